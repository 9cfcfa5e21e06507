//! Installing Debian's packages with apt-get.

use std::path::Path;
use std::process::Command;
use std::thread;
use std::time::{Duration, Instant};

use crate::diagnosis;
use crate::error::Error;
use crate::files;
use crate::step::Step;

/// How long to wait for another program that holds apt's lock.
const PATIENCE: Duration = Duration::from_secs(60);
/// Time between two attempts.
const PAUSE: Duration = Duration::from_secs(1);
/// The start of the line by which apt-get reports that it waits.
const WAITING: &str = "Waiting for cache lock";

/// The words of an apt-get command that asks nothing; without root's rights through sudo, which then asks for no
/// password.
fn words<'a>(root: bool, arguments: &[&'a str]) -> Vec<&'a str> {
    let sudo: &[&str] = if root { &[] } else { &["sudo", "-n"] };
    // `env` because sudo passes no variables on.
    [sudo, &["env", "DEBIAN_FRONTEND=noninteractive", "apt-get"], arguments].concat()
}

/// Installs packages; updates the package lists first where they are absent or out of date.
pub fn install(packages: &[&str], root: bool, step: &mut Step) -> Result<(), Error> {
    let timeout = format!("DPkg::Lock::Timeout={}", PATIENCE.as_secs());
    let options = ["install", "-y", "--no-install-recommends", "-o", &timeout];
    let install = words(root, &[&options, packages].concat());
    if have_package_lists() {
        match run(&install, step) {
            Err(error) if !is_final(&error) => {}
            result => return result,
        }
    }
    step.note("updating the package lists, which are absent or out of date");
    // Without the option a failed download of the lists is a warning.
    let update = words(root, &["update", "-o", "APT::Update::Error-Mode=any"]);
    patiently(PATIENCE, PAUSE, step, |step| run(&update, step))?;
    run(&install, step)
}

/// Whether the failure does not come from old package lists.
fn is_final(error: &Error) -> bool {
    let text = error.to_string();
    diagnosis::is_locked(&text) || diagnosis::is_offline(&text)
}

fn run(words: &[&str], step: &mut Step) -> Result<(), Error> {
    let mut command = Command::new(words[0]);
    command.args(&words[1..]);
    let mut noted = false;
    step.quiet_noting(command, |line| {
        let first = line.contains(WAITING) && !std::mem::replace(&mut noted, true);
        first.then(|| waiting(PATIENCE))
    })
}

/// Repeats `work` while another program holds apt's lock: `apt-get update` does not wait for it.
fn patiently(
    patience: Duration,
    pause: Duration,
    step: &mut Step,
    mut work: impl FnMut(&mut Step) -> Result<(), Error>,
) -> Result<(), Error> {
    let started = Instant::now();
    let mut noted = false;
    loop {
        match work(step) {
            Err(error) if diagnosis::is_locked(&error.to_string()) && started.elapsed() < patience => {
                if !noted {
                    step.note(&waiting(patience));
                    noted = true;
                }
                thread::sleep(pause);
            }
            result => return result,
        }
    }
}

fn waiting(patience: Duration) -> String {
    format!("another program uses apt: waiting up to {} s for it to end", patience.as_secs())
}

/// Whether there are package lists; images of Debian come without them.
fn have_package_lists() -> bool {
    !files::fitting(Path::new("/var/lib/apt/lists"), "*_Packages*").is_empty()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::step::Steps;

    const LOCKED: &str = "E: Could not get lock /var/lib/apt/lists/lock. It is held by process 1 (apt)";

    fn failing(text: &str) -> Result<(), Error> {
        Err(Error::Detailed { sentence: diagnosis::diagnose(text).unwrap_or("failed").into(), details: text.into() })
    }

    #[test]
    fn apt_get_goes_through_sudo_where_not_root_and_never_asks() {
        let expected = "env DEBIAN_FRONTEND=noninteractive apt-get update";
        assert_eq!(words(true, &["update"]).join(" "), expected);
        assert_eq!(words(false, &["update"]).join(" "), format!("sudo -n {expected}"));
    }

    #[test]
    fn a_lock_is_waited_for_and_not_for_ever() {
        let (long, none, pause) = (Duration::from_secs(3600), Duration::ZERO, Duration::from_millis(1));
        Steps::new(1)
            .run("waiting", |step| {
                let mut attempts = 0;
                let released = patiently(long, pause, step, |_| {
                    attempts += 1;
                    if attempts < 2 { failing(LOCKED) } else { Ok(()) }
                });
                assert_eq!((released, attempts), (Ok(()), 2));
                let error = patiently(none, pause, step, |_| failing(LOCKED)).unwrap_err();
                assert!(error.brief().starts_with("another program uses apt: wait until it has ended"), "{error}");
                // Another failure ends it at once.
                let mut attempts = 0;
                let other = patiently(long, pause, step, |_| {
                    attempts += 1;
                    failing("E: Unable to locate package x")
                });
                assert_eq!((other.is_err(), attempts), (true, 1));
                Ok(())
            })
            .unwrap();
    }

    #[test]
    fn no_network_is_final_and_an_old_list_is_not() {
        assert!(is_final(&failing("Temporary failure resolving 'deb.debian.org'").unwrap_err()));
        assert!(is_final(&failing(LOCKED).unwrap_err()));
        assert!(!is_final(&failing("E: Failed to fetch http://deb.debian.org/x  404  Not Found").unwrap_err()));
    }
}

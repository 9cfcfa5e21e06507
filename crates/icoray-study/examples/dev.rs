use clap::Parser;
#[derive(Parser)]
struct A {
    #[command(subcommand)]
    s: icoray_study::Study,
}
fn main() {
    if let Err(e) = A::parse().s.run() {
        eprintln!("{e}");
        std::process::exit(1)
    }
}

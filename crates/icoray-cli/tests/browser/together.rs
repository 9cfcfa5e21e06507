//! Two viewers of one program.

use crate::browser::Browser;
use crate::page::{SCREEN, Shown};
use fantoccini::wd::WindowHandle;

/// Two windows of different sizes that show the same page.
struct Two<'b> {
    browser: &'b Browser,
    windows: [WindowHandle; 2],
}

impl Two<'_> {
    fn to(&self, window: usize) {
        self.browser.wait(self.browser.client().switch_to_window(self.windows[window].clone()));
    }

    /// Waits until both show the same picture of the same scene at rest, and returns the scene's text.
    #[track_caller]
    fn agree(&self) -> String {
        loop {
            let [first, second, again] = [0, 1, 0].map(|window| {
                self.to(window);
                let revision = self.browser.rests();
                (revision, self.browser.number("store.frame.number"), self.browser.text())
            });
            // Without changes, revisions come to rest too.
            if first == second && first == again {
                return first.2;
            }
            assert!(again.0 < 500, "the pages answer each other for ever");
        }
    }
}

#[test]
fn two_viewers_steer_against_each_other() {
    let Some(Shown { browser, viewer, .. }) = &Shown::start() else { return };
    let first = browser.wait(browser.client().window());
    let second = browser.wait(browser.client().new_window(false)).handle;
    let two = Two { browser, windows: [first, second] };
    two.to(1);
    browser.resize([900, 700], false);
    browser.open(viewer);
    two.agree();
    // Whichever window is the larger has its picture's size.
    let width = |window: usize| {
        two.to(window);
        browser.ask("const { size } = await import('/view.js'); return [size(false)[0], store.frame.width];")
    };
    let [own, shown] = [0, 1].map(|at: usize| width(1)[at].as_u64());
    assert!(shown == own && width(0)[1] == width(1)[1] && width(0)[0].as_u64() < own, "{own:?} {shown:?}");
    two.to(1);
    browser.changed_by(|| browser.resize([640, 480], false));
    two.agree();
    let [own, shown] = [0, 1].map(|at: usize| width(0)[at].as_u64());
    assert!(shown == own && width(1)[1] == width(0)[1], "{own:?} {shown:?}");
    two.to(0);
    let start = browser.camera();

    // One turns, the other sees it.
    let [from, goal] = [[0.5, 0.5], [0.6, 0.5]].map(|place| browser.place(place));
    browser.changed_by(|| browser.drag(from, goal));
    let turned = browser.camera();
    assert_ne!(turned, start);
    two.agree();
    two.to(1);
    assert_eq!(browser.camera(), turned);

    // Both at once: one turns, one goes nearer, one opens the panel's other tab and steps in time.
    for k in 0..6 {
        two.to(0);
        browser.press(&["Shift Right", if k % 2 == 0 { "Left" } else { "Right" }]);
        two.to(1);
        browser.press(&["+"]);
    }
    two.agree();
    let both = browser.camera();
    assert!(both[0] < turned[0] - 0.2 && both[1] > turned[1] + 1.0, "{turned:?} {both:?}");

    // The same thing at once, in opposite directions.
    for _ in 0..4 {
        two.to(0);
        browser.press(&["Shift Up", "Shift Up"]);
        two.to(1);
        browser.press(&["Shift Down", "Shift Down"]);
    }
    let text = two.agree();

    // One plays while the other turns, and what one did the other undoes.
    two.to(0);
    browser.click("#play");
    two.to(1);
    browser.press(&["Shift Left", "Shift Left"]);
    two.to(0);
    browser.click("#play");
    let after = two.agree();
    assert_ne!(after, text);
    two.to(1);
    browser.changed_by(|| browser.press(&["Ctrl z"]));
    two.agree();

    // One that goes while it plays leaves a picture at rest to the other.
    two.to(1);
    browser.click("#play");
    browser.until_page("playing", "return store.frame.is_moving;");
    browser.wait(browser.client().close_window());
    two.to(0);
    browser.rests();
    let own = "const { size } = await import('/view.js'); return store.frame.width === size(false)[0];";
    browser.until_page("a picture of the size of the window that is left", own);
    browser.resize(SCREEN, false);
    browser.changed_by(|| browser.press(&["Shift Right"]));
    browser.is_quiet();
}

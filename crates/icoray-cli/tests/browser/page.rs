//! The page's state, read from its own modules, and files for it to show.

use crate::browser::Browser;
use crate::made::Made;
use crate::run::Folder;
use crate::viewer::Viewer;
use serde_json::Value;

/// A window in which pictures take little time, a screen with a mouse, and a phone.
pub const SMALL: [u32; 2] = [800, 560];
pub const SCREEN: [u32; 2] = [1280, 800];
pub const PHONE: [u32; 2] = [390, 844];

/// For bodies of functions: the page's store, and its canvas.
const KNOWN: &str = "const { store } = await import('/store.js'); const canvas = document.getElementById('picture');";

/// True where the picture is that of the scene, at rest.
const RESTS: &str = "const { frame, scene } = store;
     if (!frame || !scene || store.isMoving || frame.pending || frame.is_moving) return false;
     const isThere = frame.revision === scene.revision && frame.time === scene.time;";

/// A page that shows `made.nc`.
pub struct Shown {
    pub browser: Browser,
    pub viewer: Viewer,
    pub folder: Folder,
}

impl Shown {
    /// `None`, and a skip, where there is no browser.
    pub fn start() -> Option<Self> {
        Shown::start_with(SMALL, false)
    }

    pub fn start_with(size: [u32; 2], is_phone: bool) -> Option<Self> {
        let shown = Self::begin(size, is_phone, "")?;
        shown.browser.open(&shown.viewer);
        Some(shown)
    }

    /// A window of a size before it has the page's address; `scene` is the text of a scene file, if there is one.
    pub fn begin(size: [u32; 2], is_phone: bool, scene: &str) -> Option<Self> {
        let browser = Browser::start()?;
        let folder = Folder::of(&Made::history());
        folder.write("s.toml", scene);
        let viewer = folder.view(if scene.is_empty() { &[] } else { &["--scene", "s.toml"] });
        browser.resize(size, is_phone);
        Some(Shown { browser, viewer, folder })
    }
}

impl Viewer {
    /// The whole address of the page.
    pub fn address(&self) -> String {
        format!("http://{}/#{}", self.page.host, self.page.token)
    }
}

impl Browser {
    /// Opens the page and waits for its picture, of the canvas's size.
    pub fn open(&self, viewer: &Viewer) {
        self.go(&viewer.address());
        let view = "const { size } = await import('/view.js');";
        let body = format!("{KNOWN} {view} {RESTS} return isThere && frame.width === size(false)[0];");
        self.until("the first picture", &body);
    }

    /// What the body of an async function returns, which knows `store` and `canvas`.
    #[track_caller]
    pub fn ask(&self, body: &str) -> Value {
        self.js(&format!("{KNOWN} {body}"))
    }

    /// Waits for what [`Self::ask`] finds.
    #[track_caller]
    pub fn until_page(&self, what: &str, body: &str) -> Value {
        self.until(what, &format!("{KNOWN} {body}"))
    }

    /// A number of the scene: the value of a script's expression.
    #[track_caller]
    pub fn number(&self, expression: &str) -> f64 {
        let found = self.ask(&format!("return {expression};"));
        found.as_f64().unwrap_or_else(|| panic!("{expression}: {found}"))
    }

    /// The text of the scene.
    pub fn text(&self) -> String {
        self.ask("return store.scene.text;").as_str().unwrap().to_owned()
    }

    /// Distance, longitude and latitude of the camera.
    pub fn camera(&self) -> [f64; 3] {
        let eye = self.ask("return store.scene.camera.eye;");
        let [x, y, z] = [0, 1, 2].map(|k: usize| eye[k].as_f64().unwrap());
        let distance = x.hypot(y).hypot(z);
        [distance, y.atan2(x).to_degrees(), (z / distance).asin().to_degrees()]
    }

    /// Waits until the picture at rest is that of the scene, and returns the scene's revision.
    #[track_caller]
    pub fn rests(&self) -> u64 {
        let body = format!("{RESTS} return isThere && scene.revision;");
        self.until_page("the picture at rest", &body).as_u64().unwrap()
    }

    /// Does something that changes the scene and waits for the picture at rest.
    #[track_caller]
    pub fn changed_by(&self, act: impl FnOnce()) {
        let before = self.rests();
        act();
        let body = format!("{RESTS} return isThere && scene.revision > {before};");
        self.until_page("a new picture at rest", &body);
    }

    /// A hash of the canvas's pixels: [`hash`] of red, green and blue.
    pub fn canvas_hash(&self) -> u32 {
        let body = "const { width, height } = canvas;
             const copy = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
             copy.drawImage(canvas, 0, 0);
             const { data } = copy.getImageData(0, 0, width, height);
             let hash = 2166136261;
             for (let i = 0; i < data.length; i += 1) if (i % 4 < 3) hash = Math.imul(hash ^ data[i], 16777619);
             return hash >>> 0;";
        self.ask(body).as_u64().unwrap().try_into().unwrap()
    }

    /// The place in the window of a place of the picture, in parts of its width and height.
    pub fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let body = "const { pictureBox } = await import('/view.js'); const rect = canvas.getBoundingClientRect();
             const box = pictureBox(); return [rect.left + box.left, rect.top + box.top, box.width, box.height];";
        let found = self.ask(body);
        let [left, top, width, height] = [0, 1, 2, 3].map(|k: usize| found[k].as_f64().unwrap());
        [(left + x * width).floor(), (top + y * height).floor()]
    }

    /// Nothing went wrong in the page: no exception, no refused request, nothing that the content policy refused.
    #[track_caller]
    pub fn is_quiet(&self) {
        assert_eq!(self.log(), [""; 0]);
        assert_eq!(self.ask("return document.getElementById('alert').textContent;"), "");
    }
}

/// FNV-1a.
pub fn hash(bytes: impl Iterator<Item = u8>) -> u32 {
    bytes.fold(2_166_136_261, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(16_777_619))
}

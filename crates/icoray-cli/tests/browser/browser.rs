//! A Chromium without a window, and the ChromeDriver that steers it.

use fantoccini::error::CmdError;
use fantoccini::wd::WebDriverCompatibleCommand;
use fantoccini::{Client, ClientBuilder, Locator};
use http::Method;
use hyper_util::client::legacy::connect::HttpConnector;
use icoray_test_support::{Need, PATIENCE, has_tool};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};
use std::{fs, thread};
use tempfile::TempDir;
use tokio::runtime::{Builder, Runtime};
use url::{ParseError, Url};

/// Time between two looks at a condition.
const PAUSE: Duration = Duration::from_millis(20);

/// ChromeDriver on a port of its own, ended when it is dropped.
struct Driver {
    child: Child,
    port: u16,
    /// Kept open, so that the program can write to it.
    stdout: BufReader<ChildStdout>,
}

impl Driver {
    fn start() -> Self {
        let mut command = Command::new("chromedriver");
        let mut child = command.arg("--port=0").stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let stdout = BufReader::new(child.stdout.take().unwrap());
        let mut driver = Driver { child, port: 0, stdout };
        while driver.port == 0 {
            let mut line = String::new();
            assert!(driver.stdout.read_line(&mut line).unwrap() > 0, "chromedriver says no port");
            if let Some((_, port)) = line.split_once("successfully on port ") {
                driver.port = port.trim().trim_end_matches('.').parse().unwrap();
            }
        }
        driver
    }
}

impl Drop for Driver {
    fn drop(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }
}

/// A command of ChromeDriver beyond those of WebDriver.
#[derive(Debug)]
struct Vendor {
    path: &'static str,
    body: Value,
}

impl WebDriverCompatibleCommand for Vendor {
    fn endpoint(&self, base: &Url, session: Option<&str>) -> Result<Url, ParseError> {
        base.join(&format!("session/{}/{}", session.unwrap_or_default(), self.path))
    }

    fn method_and_body(&self, _: &Url) -> (Method, Option<String>) {
        (Method::POST, Some(self.body.to_string()))
    }
}

/// A running browser, closed when it is dropped. Calls act on its current window.
pub struct Browser {
    runtime: Runtime,
    client: Option<Client>,
    /// What the browser saves is in here.
    pub downloads: TempDir,
    // Dropped after the session has ended, which ends the browser.
    _driver: Driver,
}

impl Browser {
    /// Starts a browser; `None`, and a skip, where there is none.
    pub fn start() -> Option<Self> {
        if !has_tool(Need::Chromium, "chromium") || !has_tool(Need::Chromium, "chromedriver") {
            return None;
        }
        let downloads = tempfile::tempdir().unwrap();
        let options = json!({
            // Root has no sandbox; windows behind others are as quick; colours are those of the PNG.
            "args": [
                "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                "--disable-backgrounding-occluded-windows", "--disable-renderer-backgrounding",
                "--disable-background-timer-throttling", "--force-color-profile=srgb",
            ],
            "prefs": { "download.default_directory": downloads.path(), "download.prompt_for_download": false },
        });
        let capabilities = json!({ "goog:chromeOptions": options, "goog:loggingPrefs": { "browser": "ALL" } });
        let Value::Object(capabilities) = capabilities else { unreachable!() };
        let runtime = Builder::new_current_thread().enable_all().build().unwrap();
        let driver = Driver::start();
        let mut builder = ClientBuilder::new(HttpConnector::new());
        let address = format!("http://127.0.0.1:{}", driver.port);
        let client = runtime.block_on(builder.capabilities(capabilities).connect(&address)).unwrap();
        Some(Browser { runtime, client: Some(client), downloads, _driver: driver })
    }

    pub fn client(&self) -> &Client {
        self.client.as_ref().unwrap()
    }

    /// The result of a command, which must succeed.
    #[track_caller]
    pub fn wait<T, E: std::fmt::Debug>(&self, command: impl Future<Output = Result<T, E>>) -> T {
        self.runtime.block_on(command).unwrap()
    }

    pub fn go(&self, address: &str) {
        self.wait(self.client().goto(address));
    }

    /// What the body of an async function returns.
    #[track_caller]
    pub fn js(&self, body: &str) -> Value {
        self.js_of(body, Value::Null)
    }

    /// The same with an argument, which the body knows as `given`.
    #[track_caller]
    pub fn js_of(&self, body: &str, given: Value) -> Value {
        self.wait(self.executed(body, given))
    }

    async fn executed(&self, body: &str, given: Value) -> Result<Value, CmdError> {
        let script = format!("const [given] = arguments; return (async () => {{ {body} }})();");
        self.client().execute(&script, vec![given]).await
    }

    /// Waits until a body of an async function returns something true, and returns that.
    #[track_caller]
    pub fn until(&self, what: &str, body: &str) -> Value {
        let end = Instant::now() + PATIENCE;
        loop {
            // A page that is being replaced runs no script.
            let found = self.runtime.block_on(self.executed(body, Value::Null));
            match &found {
                Ok(Value::Null | Value::Bool(false)) | Err(_) => (),
                Ok(found) => return found.clone(),
            }
            if Instant::now() > end {
                let shot = self.failed();
                panic!("waited in vain for {what}: {found:?}; see {shot}; log: {:?}", self.log());
            }
            thread::sleep(PAUSE);
        }
    }

    /// Waits until the element shows a text with a part, and returns the text.
    #[track_caller]
    pub fn until_text(&self, selector: &str, part: &str) -> String {
        let text = format!("document.querySelector({selector:?})?.textContent ?? ''");
        let found = self.until(
            &format!("{part:?} in {selector}"),
            &format!("const text = {text}; return text.includes({part:?}) && {{ text }};"),
        );
        found["text"].as_str().unwrap().to_owned()
    }

    /// Clicks the middle of an element, which must be in sight.
    #[track_caller]
    pub fn click(&self, selector: &str) {
        let found = self.wait(self.client().find(Locator::Css(selector)));
        self.wait(found.click());
    }

    /// Calls a command of Chromium's own protocol.
    pub fn cdp(&self, command: &str, parameters: Value) {
        let body = json!({ "cmd": command, "params": parameters });
        self.wait(self.client().issue_cmd(Vendor { path: "goog/cdp/execute", body }));
    }

    /// Gives the window's page a size in CSS pixels: of a screen with a mouse, or of a phone.
    pub fn resize(&self, [width, height]: [u32; 2], is_phone: bool) {
        let scale = if is_phone { 2 } else { 1 };
        let metrics = json!({ "width": width, "height": height, "deviceScaleFactor": scale, "mobile": is_phone });
        self.cdp("Emulation.setDeviceMetricsOverride", metrics);
        self.cdp("Emulation.setTouchEmulationEnabled", json!({ "enabled": is_phone }));
    }

    /// Errors and warnings of the pages since the last call: exceptions, refusals of the content policy, failed
    /// requests.
    pub fn log(&self) -> Vec<String> {
        let body = json!({ "type": "browser" });
        let entries = self.wait(self.client().issue_cmd(Vendor { path: "se/log", body }));
        let is_bad = |entry: &&Value| ["WARNING", "SEVERE"].iter().any(|level| entry["level"] == *level);
        let text = |entry: &Value| format!("{} {}", entry["source"], entry["message"]);
        entries.as_array().unwrap().iter().filter(is_bad).map(text).collect()
    }

    /// Leaves a picture of the window, named after the test, and returns the name.
    fn failed(&self) -> String {
        let test = thread::current().name().unwrap_or_default().replace("::", "-");
        self.shot(&format!("failed-{test}"));
        format!("failed-{test}.png")
    }

    /// Leaves a picture of the window in `target/browser`.
    pub fn shot(&self, name: &str) {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap().join("browser");
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join(format!("{name}.png")), self.wait(self.client().screenshot())).unwrap();
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let Some(client) = self.client.take() else { return };
        if let Err(error) = self.runtime.block_on(client.close()) {
            eprintln!("the browser may be left running: {error}");
        }
    }
}

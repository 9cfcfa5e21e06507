//! The live page of a dataset.

use super::Opened;
use super::request::Request;
use crate::error::{argument, raised};
use crate::renderer::{Renderer, made};
use icoray::{Error, ErrorKind};
use icoray_dataset::view::{self, Viewer};
use icoray_live::{LiveView, Options, PictureSize};
use pyo3::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};

/// The live page of a dataset, served to browsers on this machine until it is closed.
#[pyclass(frozen, module = "icoray")]
pub(crate) struct View {
    /// The address of the page, with the token without which nothing is answered.
    #[pyo3(get)]
    address: String,
    /// `None` once it is closed.
    served: Mutex<Option<Served>>,
}

/// The page and the thread that answers it.
struct Served {
    live: Arc<LiveView>,
    thread: JoinHandle<()>,
}

impl View {
    pub fn open(
        py: Python,
        opened: &Arc<Opened>,
        threads: i64,
        request: &Request,
        port: Option<i64>,
    ) -> PyResult<Self> {
        let port = port
            .map(|port| u16::try_from(port).map_err(|_| argument(format!("port: {port}, expected 0 to {}", u16::MAX))));
        let port = port.transpose()?;
        let renderer = Renderer::new(threads)?;
        let time = request.time(&opened.dataset)?;
        let scene = request.scene(py, opened, &renderer, time)?;
        let text = if request.is_suggested()? { view::without_head(scene.to_toml()) } else { scene.to_toml() };
        let text = text.to_owned();
        let command = "image = icoray.render(data, scene=\"scene.toml\", time={time})".to_owned();
        let description = view::describe(&opened.dataset, command);
        let reader = view::reader(&opened.dataset);
        let size = if request.has_size()? { PictureSize::SceneOrViewer } else { PictureSize::Viewer };
        let options = Options { port, size, is_framed: true };
        let live = LiveView::open(&options, description, text, time, reader).map_err(raised)?;
        let live = Arc::new(live);
        let renderer = made(threads, live.stop())?.with_levels();
        let (opened, layers, served) = (opened.clone(), request.layers, live.clone());
        let serve = move || Viewer::new(&opened.dataset, opened.grid(), &renderer, &layers, &served).run();
        let thread = thread::Builder::new().name("icoray view".into()).spawn(serve);
        let thread = thread.map_err(|e| argument(format!("cannot start the thread of the page: {e}")))?;
        Ok(View { address: live.address(), served: Mutex::new(Some(Served { live, thread })) })
    }
}

#[pymethods]
impl View {
    /// The text of the scene as it is shown now: for `icoray.Scene` and `icoray.render`.
    #[getter]
    fn scene(&self) -> PyResult<String> {
        let served = self.served.lock().unwrap_or_else(PoisonError::into_inner);
        let Served { live, .. } =
            served.as_ref().ok_or_else(|| raised(Error::new(ErrorKind::Order, "the page is closed")))?;
        Ok(live.scene_text())
    }

    /// Ends the page. A second call does nothing.
    fn close(&self, py: Python) {
        let served = self.served.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(Served { live, thread }) = served {
            live.end();
            // A thread that has panicked has served its last picture.
            let _ = py.detach(|| thread.join());
        }
    }

    fn __repr__(&self) -> String {
        format!("<icoray.View {}>", self.address)
    }
}

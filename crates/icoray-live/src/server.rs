//! The server: one thread, independent of the renderer's.

use crate::api::Api;
use crate::guard::has_token;
use hyper::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use icoray::{Error, ErrorKind, Result};
use std::convert::Infallible;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::thread::JoinHandle;
use std::time::Duration;
use tokio::sync::oneshot;
use tokio::task::AbortHandle;
use tokio::time::timeout;

/// Maximum number of connections: some viewers, each with a few requests.
const MAX_CONNECTIONS: usize = 64;
/// Time limit for the head of a request to arrive.
const HEAD_ARRIVES: Duration = Duration::from_secs(10);
/// Lifetime of a connection: one that stalls ends, and a page opens another.
const CONNECTION_LIVES: Duration = Duration::from_secs(900);
/// Ports that are tried before the system chooses one.
const PORTS: std::ops::Range<u16> = 8750..8770;

/// A running server. It ends when it is dropped.
pub(crate) struct Server {
    pub port: u16,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Listens on this machine's loopback address, on `port`, or a free one if that is taken or `None`.
    pub fn start(port: Option<u16>, api: Api) -> Result<Self> {
        let failed =
            |e: std::io::Error| Error::new(ErrorKind::Io, format!("cannot open a port for the live view: {e}"));
        let listener = listen(port).map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let port = listener.local_addr().map_err(failed)?.port();
        let (stop, stopped) = oneshot::channel();
        let run = move || {
            let runtime = tokio::runtime::Builder::new_current_thread().enable_io().enable_time().build();
            if let Ok(runtime) = runtime {
                runtime.spawn(accept(listener, Arc::new(api)));
                // An error is the sender's end.
                let _ = runtime.block_on(stopped);
                // Does not wait for requests that wait for pictures.
                runtime.shutdown_background();
            }
        };
        let thread = std::thread::Builder::new().name("icoray-live".to_owned()).spawn(run).map_err(failed)?;
        Ok(Server { port, stop: Some(stop), thread: Some(thread) })
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            // A panic there has ended it already.
            let _ = thread.join();
        }
    }
}

fn listen(port: Option<u16>) -> std::io::Result<TcpListener> {
    let at = |port| TcpListener::bind(SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), port));
    port.into_iter().chain(PORTS).find_map(|port| at(port).ok()).map_or_else(|| at(0), Ok)
}

/// Serves connections until it is dropped.
async fn accept(listener: TcpListener, api: Arc<Api>) {
    let Ok(listener) = tokio::net::TcpListener::from_std(listener) else { return };
    let mut connections = Connections::default();
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            // For example, out of file descriptors: other connections may close.
            tokio::time::sleep(Duration::from_millis(100)).await;
            continue;
        };
        let api = api.clone();
        connections.add(|is_known| async move {
            let service = service_fn(|request: Request<Incoming>| async {
                if has_token(request.headers(), &api.token) {
                    is_known.store(true, Relaxed);
                }
                Ok::<_, Infallible>(api.answer(request).await)
            });
            let mut connection = http1::Builder::new();
            connection.timer(TokioTimer::new()).header_read_timeout(HEAD_ARRIVES).max_buf_size(32 << 10);
            let served = connection.serve_connection(TokioIo::new(stream), service);
            // A client's error ends its connection only.
            let _ = timeout(CONNECTION_LIVES, served).await;
        });
    }
}

/// The open connections, the oldest first, and whether each has had a request with the token.
#[derive(Default)]
struct Connections(Vec<(AbortHandle, Arc<AtomicBool>)>);

impl Connections {
    /// Serves another one. If there are too many, the oldest of those without a token ends, or else the oldest: its
    /// page opens another.
    fn add<F: Future<Output = ()> + Send + 'static>(&mut self, serve: impl FnOnce(Arc<AtomicBool>) -> F) {
        self.0.retain(|(task, _)| !task.is_finished());
        if self.0.len() >= MAX_CONNECTIONS {
            let unknown = self.0.iter().position(|(_, is_known)| !is_known.load(Relaxed));
            self.0.remove(unknown.unwrap_or(0)).0.abort();
        }
        let is_known = Arc::new(AtomicBool::new(false));
        let task = tokio::spawn(serve(is_known.clone())).abort_handle();
        self.0.push((task, is_known));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::future::pending;
    use tokio::sync::mpsc;

    /// A connection that reports its end.
    struct Open(usize, mpsc::UnboundedSender<usize>);

    impl Drop for Open {
        fn drop(&mut self) {
            self.1.send(self.0).unwrap();
        }
    }

    #[test]
    fn connections_without_a_token_make_room() {
        let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
        runtime.block_on(async {
            let (sender, mut ended) = mpsc::unbounded_channel();
            let mut connections = Connections::default();
            let mut add = |number: usize, has_token: bool| {
                let open = Open(number, sender.clone());
                connections.add(|is_known| {
                    is_known.store(has_token, Relaxed);
                    async move {
                        let _open = open;
                        pending::<()>().await;
                    }
                });
            };
            for number in 0..MAX_CONNECTIONS {
                add(number, number != 7 && number != 9);
            }
            for (number, expected) in [(100, 7), (101, 9), (102, 0)] {
                add(number, true);
                assert_eq!(ended.recv().await, Some(expected));
            }
        });
    }
}

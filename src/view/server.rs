//! The loopback address, the token that opens it, and a thread for each connection.

use super::connection::{BadRequest, Connection};
use super::guard::Guard;
use super::routes::{refusal, respond};
use super::served_scene::ServedScene;
use super::tracer::PageTracer;
use super::viewed_scene::{FILE_BYTES, ViewedScene};
use serde_json::json;
use std::io;
use std::net::{IpAddr, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::Ordering::SeqCst;
use std::time::Duration;

/// Most connections at a time: six for each of a few pages, and room for those without the token.
const MAX_CONNECTIONS: usize = 192;

/// Connections beyond which a new one has little time to show the token, so that a flood of others
/// keeps no page out.
const CROWD: usize = 48;

/// Time for which a failed scene is shown to pages that wait for it.
const FAILURE: Duration = Duration::from_secs(1);

/// The reason why nothing is served.
#[derive(Debug, thiserror::Error)]
pub enum ServerError {
    /// The address is not one that only this machine reaches.
    #[error("{0} is not a loopback address: anyone on the network could see the scene")]
    Address(IpAddr),
    /// The system has no such address, or another program uses it.
    #[error("cannot listen on {address}: {source}")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// The system's reason.
        source: io::Error,
    },
    /// The system has no random numbers, or no thread.
    #[error("cannot serve: {0}")]
    System(#[from] io::Error),
}

/// A server of one scene.
pub struct Server {
    address: SocketAddr,
    served: Arc<ServedScene>,
}

impl Server {
    /// Serves the page at this address, whose port may be 0 for any that is free.
    ///
    /// # Errors
    /// [`ServerError`].
    pub fn start(address: SocketAddr) -> Result<Server, ServerError> {
        if !address.ip().is_loopback() {
            return Err(ServerError::Address(address.ip()));
        }
        let refused = |source| ServerError::Listen { address, source };
        let listener = TcpListener::bind(address).map_err(refused)?;
        let address = listener.local_addr()?;
        let served = Arc::new(ServedScene::new(Guard::new()?));
        let shared = Arc::clone(&served);
        let accept = move || accept(&listener, &shared);
        std::thread::Builder::new().spawn(accept)?;
        Ok(Server { address, served })
    }

    /// The address of the page.
    pub fn url(&self) -> String {
        format!("http://{}{}", self.address, self.served.guard.path())
    }

    /// Tells the pages that the tree of a scene with this many primitives is being built.
    pub fn set_building(&self, primitives: u64) {
        let state = json!({ "stage": "building", "primitives": primitives });
        self.served.set(state);
    }

    /// Tells the pages that there will be no picture, and gives them the time to ask.
    pub fn fail(&self, reason: &str) {
        let state = json!({ "stage": "failed", "error": reason });
        self.served.set(state);
        std::thread::sleep(FAILURE);
    }

    /// Shows a scene until the process ends.
    pub fn show(&self, scene: ViewedScene) -> ! {
        let state = json!({
            "stage": "ready",
            "primitives": scene.scene.id_count(),
            "scene": scene.describe(),
        });
        let bytes = scene.most_pixels * FILE_BYTES;
        self.served.answer_bytes.store(bytes, SeqCst);
        let mut tracer = PageTracer::new(scene, &self.served.queue);
        self.served.set(state);
        tracer.run()
    }
}

fn accept(listener: &TcpListener, served: &Arc<ServedScene>) {
    for stream in listener.incoming() {
        let Ok(stream) = stream else {
            // No more descriptors: others have to be closed first.
            std::thread::sleep(Duration::from_millis(50));
            continue;
        };
        if Arc::strong_count(served) > MAX_CONNECTIONS {
            continue;
        }
        let shared = Arc::clone(served);
        // Without a thread, or after an error, there is nobody to tell.
        let talk = move || drop(talk(stream, &shared));
        let _ = std::thread::Builder::new().spawn(talk);
    }
}

/// Answers the requests of a connection, one after the other.
fn talk(stream: TcpStream, served: &Arc<ServedScene>) -> io::Result<()> {
    // Each connection shares the scene.
    let mut connection = Connection::new(stream, Arc::strong_count(served) > CROWD)?;
    loop {
        let request = match connection.receive() {
            Ok(Some(request)) => request,
            Ok(None) | Err(BadRequest(None)) => return Ok(()),
            Err(BadRequest(Some(status))) => {
                let reason = match status {
                    431 => "the head of the request is too long: remove the cookies of this host",
                    _ => "malformed request",
                };
                return connection.send_last(&refusal(status, reason));
            }
        };
        let Some(name) = served.guard.admitted(&request) else {
            return connection.send_last(&refusal(404, "there is nothing here"));
        };
        let Some(response) = respond(&request, name, &connection, served) else {
            return Ok(());
        };
        connection.send(&response, request.keep_alive)?;
        if !request.keep_alive {
            return Ok(());
        }
    }
}

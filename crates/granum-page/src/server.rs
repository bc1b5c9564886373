//! The server: a port of this computer, connections with limits, and the answers.

use std::net::{SocketAddr, TcpListener};
use std::path::Path;
use std::pin::pin;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::TcpStream;
use tokio::runtime::{Builder, Runtime};
use tokio::sync::Semaphore;
use tokio::time::{sleep, timeout};

use crate::folder::Folder;
use crate::guard::Guard;
use crate::limits::Limits;
use crate::program::Program;
use crate::routes;
use crate::serve_error::ServeError;
use crate::site::Site;
use crate::token::Token;

/// Time between two looks at whether the server is to end.
const LOOK_EVERY: Duration = Duration::from_millis(100);
/// Bytes of a request that are kept at a time, and the most lines of its head.
const HEAD: (usize, usize) = (32 << 10, 64);

/// A folder that is served at an address.
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
    token: Token,
    folder: Folder,
    program: Arc<dyn Program>,
    limits: Limits,
}

impl Server {
    /// Takes an address; with the port 0 a free one is chosen.
    ///
    /// ```no_run
    /// # fn serve(program: std::sync::Arc<dyn granum_page::Program>) -> Result<(), granum_page::ServeError> {
    /// let server = granum_page::Server::bind("127.0.0.1:0".parse().unwrap(), "runs".as_ref(), program)?;
    /// println!("open {}", server.url());
    /// server.run(|| false)
    /// # }
    /// ```
    ///
    /// # Errors
    /// If the folder cannot be read or the address cannot be taken.
    pub fn bind(address: SocketAddr, folder: &Path, program: Arc<dyn Program>) -> Result<Server, ServeError> {
        let folder = Folder::open(folder)?;
        let taken = TcpListener::bind(address).and_then(|listener| {
            listener.set_nonblocking(true)?;
            Ok((listener.local_addr()?, listener))
        });
        let (address, listener) = taken.map_err(|source| ServeError::Address { address, source })?;
        Ok(Server { listener, address, token: Token::new()?, folder, program, limits: Limits::default() })
    }

    /// The same server with other limits.
    pub fn with_limits(self, limits: Limits) -> Server {
        Server { limits, ..self }
    }

    /// The address that it listens at.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// The token of its addresses.
    pub fn token(&self) -> &str {
        self.token.text()
    }

    /// What a user opens: the address with its token.
    pub fn url(&self) -> String {
        let mut shown = self.address;
        // Nobody can ask for the address that stands for all.
        if shown.ip().is_unspecified() {
            shown.set_ip(std::net::Ipv4Addr::LOCALHOST.into());
        }
        format!("http://{shown}/?token={}", self.token.text())
    }

    /// Answers until `stopped` says so, which is asked ten times a second.
    ///
    /// # Errors
    /// If the system takes the port away.
    pub fn run(self, stopped: impl Fn() -> bool) -> Result<(), ServeError> {
        let runtime = Builder::new_current_thread()
            .enable_io()
            .enable_time()
            .max_blocking_threads(self.limits.working + 1)
            .build()?;
        let ended = self.answer(&runtime, stopped);
        // What is still being computed writes nothing, and nobody waits for it any more.
        runtime.shutdown_background();
        ended
    }

    fn answer(self, runtime: &Runtime, stopped: impl Fn() -> bool) -> Result<(), ServeError> {
        let guard = Guard::new(self.address, self.token);
        let site = Site::new(self.folder, self.program, self.limits.working);
        let (router, limits) = (routes::router(guard, Arc::new(site)), self.limits);
        runtime.block_on(async move {
            let listener = tokio::net::TcpListener::from_std(self.listener)?;
            let places = Arc::new(Semaphore::new(limits.connections));
            while !stopped() {
                // Without a place further connections wait in the queue of the system.
                let Ok(Ok(place)) = timeout(LOOK_EVERY, places.clone().acquire_owned()).await else {
                    continue;
                };
                let Ok(accepted) = timeout(LOOK_EVERY, listener.accept()).await else { continue };
                match accepted {
                    Ok((stream, _)) => {
                        let router = router.clone();
                        tokio::spawn(async move {
                            connection(stream, router, limits).await;
                            drop(place);
                        });
                    }
                    // One connection was lost, or there are too many open files for a moment.
                    Err(_) => sleep(LOOK_EVERY).await,
                }
            }
            Ok(())
        })
    }
}

/// One connection, which ends after its time whatever its client does.
async fn connection(stream: TcpStream, router: Router, limits: Limits) {
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(limits.head)
        .max_buf_size(HEAD.0)
        .max_headers(HEAD.1)
        .serve_connection(TokioIo::new(stream), TowerToHyperService::new(router));
    let mut connection = pin!(connection);
    if timeout(limits.connection, connection.as_mut()).await.is_err() {
        connection.as_mut().graceful_shutdown();
        // Whatever comes of it, the connection is closed.
        drop(timeout(limits.rest, connection).await);
    }
}

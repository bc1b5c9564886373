//! The server as strangers, other pages and slow clients meet it: by raw connections, since browsers and libraries tidy what they send.

mod guarded;
mod many;
mod paths;
mod program;
mod reading;
mod slow;

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use granum_page::{Limits, Server};

use self::program::TestProgram;

/// A folder that is served until this is dropped.
pub struct Served {
    /// Where it is served.
    pub address: SocketAddr,
    /// The token of its addresses.
    pub token: String,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Served {
    /// With the usual limits.
    pub fn new(folder: &Path) -> Served {
        Served::with_limits(folder, Limits::default())
    }

    /// With other limits.
    pub fn with_limits(folder: &Path, limits: Limits) -> Served {
        let server = Server::bind("127.0.0.1:0".parse().unwrap(), folder, Arc::new(TestProgram::default()));
        let server = server.unwrap().with_limits(limits);
        let (address, token) = (server.address(), server.token().to_string());
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = stop.clone();
        let thread = std::thread::spawn(move || server.run(|| stopped.load(Ordering::Relaxed)).unwrap());
        Served { address, token, stop, thread: Some(thread) }
    }

    /// A connection that says nothing yet.
    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(120))).unwrap();
        stream
    }

    /// What is answered to these bytes before the connection is closed.
    pub fn raw(&self, request: &str) -> String {
        let mut stream = self.connect();
        // A server that refuses early may close before it has read everything.
        let _ = stream.write_all(request.as_bytes());
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        String::from_utf8_lossy(&answer).into_owned()
    }

    /// The answer to a request of the page itself.
    pub fn ask(&self, method: &str, target: &str, more: &str) -> String {
        let (port, token) = (self.address.port(), &self.token);
        self.raw(&format!(
            "{method} {target} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nAuthorization: Bearer {token}\r\nConnection: close\r\n{more}\r\n"
        ))
    }

    /// The status and the content of an answer to GET.
    pub fn get(&self, target: &str) -> (u16, String) {
        let answer = self.ask("GET", target, "");
        let status = status(&answer);
        (status, answer.split_once("\r\n\r\n").map_or(String::new(), |(_, content)| content.to_string()))
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap();
        }
    }
}

/// The status of an answer; 0 of none.
pub fn status(answer: &str) -> u16 {
    answer.split(' ').nth(1).and_then(|code| code.parse().ok()).unwrap_or(0)
}

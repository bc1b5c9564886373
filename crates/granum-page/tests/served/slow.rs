//! Clients that take their time.

use std::io::{Read, Write};
use std::time::{Duration, Instant};

use granum_page::Limits;

use crate::{Served, status};

fn limits() -> Limits {
    Limits::default().with(|limits| {
        limits.head = Duration::from_millis(600);
        limits.connection = Duration::from_millis(1500);
        limits.rest = Duration::from_millis(500);
        limits.connections = 4;
    })
}

/// The time until a connection is closed.
fn closed_after(mut stream: std::net::TcpStream) -> Duration {
    let begun = Instant::now();
    let mut answer = Vec::new();
    let _ = stream.read_to_end(&mut answer);
    begun.elapsed()
}

#[test]
fn clients_that_say_nothing_or_little_are_closed_and_others_are_answered() {
    let folder = tempfile::tempdir().unwrap();
    let served = Served::with_limits(folder.path(), limits());
    // More connections than there are places, none of which says anything.
    let silent: Vec<_> = (0..8).map(|_| served.connect()).collect();
    let begun = Instant::now();
    assert_eq!(served.get("/api/folder").0, 200);
    assert!(begun.elapsed() < Duration::from_secs(30), "{:?}", begun.elapsed());
    for stream in silent {
        assert!(closed_after(stream) < Duration::from_secs(30));
    }
    // A head that comes letter by letter is not waited for.
    let mut slow = served.connect();
    let begun = Instant::now();
    let mut closed = false;
    for letter in
        "GET /api/folder HTTP/1.1\r\nHost: 127.0.0.1\r\nX: ".bytes().chain(std::iter::repeat_n(b'x', 2000))
    {
        if slow.write_all(&[letter]).is_err() {
            closed = true;
            break;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    assert!(closed && begun.elapsed() < Duration::from_secs(60), "{:?}", begun.elapsed());
}

/// A connection that is kept busy, or whose answers are not read, ends all the same.
#[test]
fn no_connection_is_kept_for_ever() {
    let folder = tempfile::tempdir().unwrap();
    let served = Served::with_limits(folder.path(), limits());
    let mut busy = served.connect();
    let request = format!("GET / HTTP/1.1\r\nHost: 127.0.0.1:{}\r\n\r\n", served.address.port());
    let begun = Instant::now();
    let (mut answers, mut part) = (0, [0u8; 65536]);
    loop {
        if busy.write_all(request.as_bytes()).is_err() {
            break;
        }
        match busy.read(&mut part) {
            Ok(0) | Err(_) => break,
            Ok(_) => answers += 1,
        }
        std::thread::sleep(Duration::from_millis(20));
        assert!(begun.elapsed() < Duration::from_secs(60));
    }
    assert!(answers > 3, "{answers}");
    // Requests without end, and nobody reads what is answered.
    let mut deaf = served.connect();
    deaf.set_write_timeout(Some(Duration::from_millis(200))).unwrap();
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(3) {
        if let Err(error) = deaf.write_all(request.as_bytes())
            && !matches!(error.kind(), std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut)
        {
            break;
        }
    }
    assert_eq!(served.get("/api/folder").0, 200);
    assert_eq!(status(&served.ask("GET", "/", "")), 200);
}

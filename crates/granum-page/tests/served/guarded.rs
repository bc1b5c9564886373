//! Strangers and other pages.

use crate::{Served, status};

fn served() -> (tempfile::TempDir, Served) {
    let folder = tempfile::tempdir().unwrap();
    let served = Served::new(folder.path());
    (folder, served)
}

/// A page whose name points to this computer (DNS rebinding) is refused by its name, and one of another site by what the browser says.
#[test]
fn other_hosts_and_other_pages_are_refused() {
    let (_folder, served) = served();
    let (port, token) = (served.address.port(), served.token.clone());
    let ask = |host: &str, more: &str| {
        let host = host.replace('P', &port.to_string());
        let answer = served.raw(&format!(
            "GET /api/folder HTTP/1.1\r\n{host}Authorization: Bearer {token}\r\nConnection: close\r\n{more}\r\n"
        ));
        assert!(!answer.to_lowercase().contains("access-control-"), "{answer}");
        status(&answer)
    };
    for host in ["127.0.0.1:P", "[::1]:P", "LOCALHOST:P"] {
        assert_eq!(ask(&format!("Host: {host}\r\n"), ""), 200, "{host}");
    }
    for host in ["evil.example", "localhost.evil.example", "evil.example:P", "127.0.0.1", "10.0.0.1:P"] {
        assert_eq!(ask(&format!("Host: {host}\r\n"), ""), 403, "{host}");
    }
    assert_eq!(ask("", ""), 400);
    assert_eq!(ask("Host: 127.0.0.1:P\r\nHost: evil.example\r\n", ""), 400);
    let own = "Host: 127.0.0.1:P\r\n";
    assert_eq!(ask(own, "Origin: http://evil.example\r\n"), 403);
    assert_eq!(ask(own, "Origin: null\r\n"), 403);
    assert_eq!(ask(own, "Sec-Fetch-Site: cross-site\r\n"), 403);
    assert_eq!(ask(own, "Sec-Fetch-Site: same-site\r\n"), 403);
    assert_eq!(ask(own, &format!("Origin: http://127.0.0.1:{port}\r\nSec-Fetch-Site: same-origin\r\n")), 200);
    let absolute =
        format!("GET http://evil.example/ HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: close\r\n\r\n");
    assert_eq!(status(&served.raw(&absolute)), 403);
}

#[test]
fn data_need_the_token_and_the_page_is_the_same_for_all() {
    let (_folder, served) = served();
    let port = served.address.port();
    let ask = |target: &str, more: &str| {
        let head =
            format!("GET {target} HTTP/1.1\r\nHost: localhost:{port}\r\nConnection: close\r\n{more}\r\n");
        served.raw(&head)
    };
    assert_eq!(served.token.len(), 32);
    for more in ["", "Authorization: Bearer 0\r\n", &format!("Cookie: token={}\r\n", served.token)] {
        for target in ["/api/folder", "/api/run?path=a", "/api/figure?path=a&name=b", "/api/families"] {
            let answer = ask(target, more);
            assert_eq!(status(&answer), 401, "{target}: {answer}");
        }
    }
    assert_eq!(status(&ask(&format!("/api/folder?token={}", served.token), "")), 401);
    let page = ask("/", "");
    assert_eq!(status(&page), 200);
    for part in
        ["<script type=\"module\" src=\"/modules/main.js\">", "script-src 'self'", "frame-ancestors 'none'"]
    {
        assert!(page.contains(part), "{part}: {page}");
    }
    for head in ["x-content-type-options: nosniff", "cache-control: no-store", "referrer-policy: no-referrer"]
    {
        assert!(page.contains(head), "{head}: {page}");
    }
    assert!(!page.contains(&served.token) && !page.contains("unsafe-inline"));
    assert!(ask("/modules/viewer.js", "").contains("text/javascript"));
}

/// Nothing is taken in: what would write is refused before its content is read, however much there is.
#[test]
fn only_reading_is_answered_and_uploads_are_not_read() {
    let (_folder, served) = served();
    for method in ["POST", "PUT", "DELETE", "PATCH", "OPTIONS"] {
        let answer = served.ask(method, "/api/folder", "Content-Type: text/plain\r\nContent-Length: 0\r\n");
        assert_eq!(status(&answer), 405, "{method}: {answer}");
    }
    let begun = std::time::Instant::now();
    let huge = "Content-Length: 1099511627776\r\n";
    assert_eq!(status(&served.ask("POST", "/api/folder", huge)), 405);
    assert_eq!(status(&served.ask("GET", "/api/folder", huge)), 413);
    assert_eq!(status(&served.ask("GET", "/api/folder", "Transfer-Encoding: chunked\r\n")), 413);
    // A large content that does come is not waited for.
    let content = format!("Content-Length: 50000000\r\n\r\n{}", "x".repeat(2_000_000));
    let answer = served.ask("POST", "/api/folder", &content);
    assert!([0, 405].contains(&status(&answer)), "{answer}");
    let long = format!("/api/folder?filter={}", "x".repeat(40_000));
    assert!([0, 414, 431].contains(&status(&served.ask("GET", &long, ""))));
    let heads = "X-Head: 1\r\n".repeat(200);
    assert!([0, 400, 431].contains(&status(&served.ask("GET", "/api/folder", &heads))));
    assert!(begun.elapsed().as_secs() < 20);
    assert_eq!(served.get("/api/folder").0, 200);
    let head = served.ask("HEAD", "/api/folder", "");
    assert!(status(&head) == 200 && head.ends_with("\r\n\r\n"), "{head}");
}

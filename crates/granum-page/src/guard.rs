//! Who may ask: a browser on this computer that was sent here by the printed address, and no other page that it shows.
//!
//! A foreign page can make a browser ask a server of the same computer: by a name of its own that it lets point here (DNS rebinding), or by
//! requests across sites. Both are refused by what the browser itself says of the request: `Host`, `Origin` and `Sec-Fetch-Site`. The token
//! is sent in a header, which no other page can do without being allowed to, and nothing here allows it.

use std::net::{IpAddr, SocketAddr};

use axum::http::header::{
    AUTHORIZATION, CONTENT_LENGTH, HOST, HeaderMap, HeaderValue, ORIGIN, TRANSFER_ENCODING,
};
use axum::http::request::Parts;
use axum::http::{Method, StatusCode};

use crate::refused::Refused;
use crate::token::Token;

/// The part of the addresses for which the token is needed.
pub const PROTECTED: &str = "/api/";
/// Longest path and query of a request, bytes.
const LONGEST_ADDRESS: usize = 16 << 10;

/// Who may ask a server at an address.
#[derive(Clone)]
pub struct Guard {
    address: SocketAddr,
    token: Token,
}

impl Guard {
    pub(crate) fn new(address: SocketAddr, token: Token) -> Guard {
        Guard { address, token }
    }

    /// Looks at the head of a request.
    ///
    /// # Errors
    /// If it is refused.
    pub fn check(&self, head: &Parts) -> Result<(), Refused> {
        self.check_host(head)?;
        self.check_origin(&head.headers)?;
        check_method(head)?;
        if head.uri.path_and_query().map_or(0, |text| text.as_str().len()) > LONGEST_ADDRESS {
            return Err(Refused::new(StatusCode::URI_TOO_LONG, "the address is too long"));
        }
        if head.uri.path().starts_with(PROTECTED) && !self.has_token(&head.headers) {
            let reason = "the address has no token, or that of an earlier start; open the address that granum serve printed";
            return Err(Refused::new(StatusCode::UNAUTHORIZED, reason));
        }
        Ok(())
    }

    fn check_host(&self, head: &Parts) -> Result<(), Refused> {
        let mut hosts = head.headers.get_all(HOST).iter();
        let (Some(host), None) = (hosts.next(), hosts.next()) else {
            return Err(Refused::bad("a request names its host once"));
        };
        let named = head.uri.authority().map(|authority| authority.as_str());
        let host = host.to_str().unwrap_or("");
        if ![Some(host), named].into_iter().flatten().all(|host| self.is_host(host)) {
            let reason = "this is no name of the server; open the address that granum serve printed";
            return Err(Refused::new(StatusCode::FORBIDDEN, reason));
        }
        Ok(())
    }

    /// True for a name of this server with its port: an address in numbers, which no name service can redirect, or `localhost`.
    fn is_host(&self, text: &str) -> bool {
        let (host, port) = match text.rsplit_once(':') {
            Some((host, port)) if !port.ends_with(']') => (host, port),
            _ => (text, "80"),
        };
        if port != self.address.port().to_string() {
            return false;
        }
        if host.eq_ignore_ascii_case("localhost") {
            return true;
        }
        let plain = host.strip_prefix('[').and_then(|host| host.strip_suffix(']')).unwrap_or(host);
        plain.parse::<IpAddr>().is_ok_and(|address| {
            let own = self.address.ip();
            address == own || address.is_loopback() || (own.is_unspecified() && !address.is_unspecified())
        })
    }

    fn check_origin(&self, headers: &HeaderMap) -> Result<(), Refused> {
        let is_own = |origin: &HeaderValue| {
            let host = origin.to_str().ok().and_then(|text| text.strip_prefix("http://"));
            host.is_some_and(|host| self.is_host(host))
        };
        let is_same = |site: &HeaderValue| site == "same-origin" || site == "none";
        let foreign = headers.get_all(ORIGIN).iter().any(|origin| !is_own(origin))
            || headers.get_all("sec-fetch-site").iter().any(|site| !is_same(site));
        if foreign {
            let reason =
                "the request comes from another page; type or paste the address that granum serve printed";
            return Err(Refused::new(StatusCode::FORBIDDEN, reason));
        }
        Ok(())
    }

    fn has_token(&self, headers: &HeaderMap) -> bool {
        let given = headers.get(AUTHORIZATION).and_then(|value| value.to_str().ok());
        given.and_then(|text| text.strip_prefix("Bearer ")).is_some_and(|text| self.token.is(text))
    }
}

/// Only what reads is answered, and it has no content.
fn check_method(head: &Parts) -> Result<(), Refused> {
    if ![Method::GET, Method::HEAD].contains(&head.method) {
        let reason = "the server reads and never writes: GET and HEAD are answered";
        return Err(Refused::new(StatusCode::METHOD_NOT_ALLOWED, reason));
    }
    let empty = |length: &HeaderValue| length == "0";
    if head.headers.contains_key(TRANSFER_ENCODING) || !head.headers.get_all(CONTENT_LENGTH).iter().all(empty)
    {
        return Err(Refused::new(StatusCode::PAYLOAD_TOO_LARGE, "a request has no content here"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::Request;

    fn guard(address: &str) -> (Guard, String) {
        let token = Token::new().unwrap();
        let text = token.text().to_string();
        (Guard::new(address.parse().unwrap(), token), text)
    }

    fn status(guard: &Guard, uri: &str, headers: &[(&str, &str)]) -> u16 {
        let mut request = Request::builder().uri(uri);
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        let (head, ()) = request.body(()).unwrap().into_parts();
        guard.check(&head).map_or_else(|refused| refused.status.as_u16(), |()| 200)
    }

    #[test]
    fn only_names_of_this_computer_are_hosts() {
        let (guard, _) = guard("127.0.0.1:8347");
        for host in ["127.0.0.1:8347", "[::1]:8347", "LOCALHOST:8347", "localhost:8347"] {
            assert_eq!(status(&guard, "/", &[("host", host)]), 200, "{host}");
        }
        let others = [
            "evil.example",
            "evil.example:8347",
            "localhost.evil.example:8347",
            "127.0.0.1.evil.example:8347",
            "127.0.0.1",
            "127.0.0.1:80",
            "192.168.0.1:8347",
            "",
            ":8347",
            "[::1",
        ];
        for host in others {
            assert_eq!(status(&guard, "/", &[("host", host)]), 403, "{host}");
        }
        assert_eq!(status(&guard, "/", &[]), 400);
        assert_eq!(status(&guard, "/", &[("host", "localhost:8347"), ("host", "evil.example")]), 400);
        assert_eq!(status(&guard, "http://evil.example/", &[("host", "localhost:8347")]), 403);
    }

    #[test]
    fn a_server_of_the_network_is_asked_by_numbers() {
        let (guard, _) = guard("0.0.0.0:8347");
        assert_eq!(status(&guard, "/", &[("host", "192.168.0.1:8347")]), 200);
        assert_eq!(status(&guard, "/", &[("host", "evil.example:8347")]), 403);
    }

    #[test]
    fn other_pages_are_refused() {
        let (guard, _) = guard("127.0.0.1:8347");
        let with =
            |name: &str, value: &str| status(&guard, "/", &[("host", "localhost:8347"), (name, value)]);
        assert_eq!(with("origin", "http://localhost:8347"), 200);
        for origin in ["http://evil.example", "null", "https://localhost:8347", "http://localhost:9000", ""] {
            assert_eq!(with("origin", origin), 403, "{origin}");
        }
        for (site, expected) in [("none", 200), ("same-origin", 200), ("same-site", 403), ("cross-site", 403)]
        {
            assert_eq!(with("sec-fetch-site", site), expected, "{site}");
        }
    }

    #[test]
    fn data_need_the_token() {
        let (guard, token) = guard("127.0.0.1:8347");
        let ask = |value: &str| {
            status(&guard, "/api/folder", &[("host", "localhost:8347"), ("authorization", value)])
        };
        assert_eq!(ask(&format!("Bearer {token}")), 200);
        for wrong in ["", "Bearer ", &token, "Bearer 00000000000000000000000000000000"] {
            assert_eq!(ask(wrong), 401, "{wrong}");
        }
        assert_eq!(status(&guard, "/modules/main.js", &[("host", "localhost:8347")]), 200);
        let long = format!("/{}", "x".repeat(LONGEST_ADDRESS));
        assert_eq!(status(&guard, &long, &[("host", "localhost:8347")]), 414);
    }
}

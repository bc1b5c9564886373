//! Answers: their types, and the heads that all of them have.

use axum::body::Body;
use axum::http::header::{self, HeaderName, HeaderValue};
use axum::http::{Response, StatusCode};
use serde_json::{Value, json};

use crate::refused::Refused;

/// Nothing but what the server itself holds is loaded or executed. The engine of the page is WebAssembly, which needs a word of its own.
const POLICY: &str = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; img-src 'self' blob: data:; \
                      connect-src 'self'; worker-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

/// The heads of all answers.
const HEADS: [(&str, &str); 8] = [
    ("content-security-policy", POLICY),
    ("x-content-type-options", "nosniff"),
    ("x-frame-options", "DENY"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-resource-policy", "same-origin"),
    ("cross-origin-opener-policy", "same-origin"),
    ("cache-control", "no-store"),
    ("permissions-policy", "camera=(), microphone=(), geolocation=(), usb=(), serial=()"),
];

/// The content of an answer.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer {
    /// Data.
    Json(Value),
    /// A figure.
    Svg(String),
    /// A part of the page.
    Asset(&'static str, &'static str),
}

/// An answer, or why there is none.
pub type Answered = Result<Answer, Refused>;

impl Answer {
    pub fn response(self) -> Response<Body> {
        match self {
            Answer::Json(value) => with_type(StatusCode::OK, "application/json", value.to_string()),
            Answer::Svg(text) => with_type(StatusCode::OK, "image/svg+xml", text),
            Answer::Asset(kind, text) => with_type(StatusCode::OK, kind, text),
        }
    }
}

impl Refused {
    /// The answer to a request that is refused. The connection ends with it, so that nothing more of the request is read.
    pub fn response(self) -> Response<Body> {
        let text = json!({ "error": self.reason }).to_string();
        let mut response = with_type(self.status, "application/json", text);
        if self.status == StatusCode::METHOD_NOT_ALLOWED {
            response.headers_mut().insert(header::ALLOW, HeaderValue::from_static("GET, HEAD"));
        }
        if [StatusCode::METHOD_NOT_ALLOWED, StatusCode::PAYLOAD_TOO_LARGE].contains(&self.status) {
            response.headers_mut().insert(header::CONNECTION, HeaderValue::from_static("close"));
        }
        response
    }
}

fn with_type(status: StatusCode, kind: &'static str, text: impl Into<Body>) -> Response<Body> {
    let mut response = Response::new(text.into());
    *response.status_mut() = status;
    response.headers_mut().insert(header::CONTENT_TYPE, HeaderValue::from_static(kind));
    for (name, value) in HEADS {
        response.headers_mut().insert(HeaderName::from_static(name), HeaderValue::from_static(value));
    }
    response
}

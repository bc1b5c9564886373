//! A request that is not answered, with its status and the reason in words.

use axum::http::StatusCode;

/// A request that is not answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused {
    /// The status of HTTP.
    pub status: StatusCode,
    /// Why, in a sentence that the page shows.
    pub reason: String,
}

impl Refused {
    /// A refusal.
    pub fn new(status: StatusCode, reason: impl Into<String>) -> Refused {
        Refused { status, reason: reason.into() }
    }

    /// There is nothing of that name.
    pub fn not_found(reason: impl Into<String>) -> Refused {
        Refused::new(StatusCode::NOT_FOUND, reason)
    }

    /// The request is wrong.
    pub fn bad(reason: impl Into<String>) -> Refused {
        Refused::new(StatusCode::BAD_REQUEST, reason)
    }

    /// What was asked for cannot be read or drawn.
    pub fn unreadable(reason: impl ToString) -> Refused {
        Refused::new(StatusCode::UNPROCESSABLE_ENTITY, reason.to_string())
    }
}

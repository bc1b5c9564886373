//! The calls of a page, one file for each subject. A new call is a function and a line in [`ALL`].

mod about;
mod case;
mod results;
mod run;
mod surrogates;

use serde_json::Value;

use crate::answer::CallError;
use crate::page::{Arguments, Page};

/// A call.
pub(crate) struct Call {
    pub(crate) name: &'static str,
    pub(crate) carry_out: fn(&mut Page, &Arguments) -> Result<Value, CallError>,
}

/// All calls.
pub(crate) const ALL: &[Call] = &[
    Call { name: "about", carry_out: about::about },
    Call { name: "check", carry_out: case::check },
    Call { name: "begin", carry_out: run::begin },
    Call { name: "go_on", carry_out: run::go_on },
    Call { name: "states", carry_out: run::states },
    Call { name: "view", carry_out: results::view },
    Call { name: "digest", carry_out: results::digest },
    Call { name: "series", carry_out: results::series },
    Call { name: "report", carry_out: results::report },
    Call { name: "load_family", carry_out: surrogates::load },
    Call { name: "predict", carry_out: surrogates::predict },
    Call { name: "digest_of_predictions", carry_out: surrogates::digest_of_predictions },
    Call { name: "digest_of_training", carry_out: surrogates::digest_of_training },
];

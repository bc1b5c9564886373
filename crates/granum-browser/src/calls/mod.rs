//! The calls of a page, one file for each subject. A new call is a function and a line in [`ENGINE`] or [`SURROGATES`].

mod about;
mod case;
mod figures;
mod files;
mod paper;
mod reports;
mod results;
mod run;
mod surrogates;

use serde_json::Value;

use crate::answer::CallError;
use crate::page::{Arguments, Call, Page};

const fn call(name: &'static str, carry_out: fn(&mut Page, &Arguments) -> Result<Value, CallError>) -> Call {
    Call { name, carry_out }
}

/// The calls of the laboratory: cases and their tests.
pub const ENGINE: &[Call] = &[
    call("about", about::about),
    call("check", case::check),
    call("with", case::with),
    call("begin", run::begin),
    call("go_on", run::go_on),
    call("states", run::states),
    call("view", results::view),
    call("digest", results::digest),
    call("series", results::series),
    call("result", results::result),
    call("saved", results::saved),
];

/// The calls of the surrogates, those that make reports of results, and those that read a case with the files that it names.
pub const SURROGATES: &[Call] = &[
    call("about", about::about),
    call("files", files::replace),
    call("check", case::check),
    call("with", case::with),
    call("load_family", surrogates::load),
    call("case_of", surrogates::case_of),
    call("predict", surrogates::predict),
    call("curves", figures::curves),
    call("report", reports::report),
    call("presented", reports::presented),
    call("mappings", paper::mappings),
    call("train_mapping", paper::train),
    call("ask_mapping", paper::answer),
    call("digest_of_predictions", surrogates::digest_of_predictions),
    call("digest_of_training", surrogates::digest_of_training),
];

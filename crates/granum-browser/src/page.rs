//! What a page has: the run that is under way, and the surrogates that it has loaded.

use std::any::Any;
use std::collections::BTreeMap;

use granum_dem::simulation::Hardware;
use granum_io::run::OWN_ENGINE;
use granum_learn::family::{FamilyModel, FamilyPrediction};
use granum_run::laboratory::RunInPieces;
use granum_run::{Laboratory, Resources, RunRegistry};
use serde_json::Value;

use crate::answer::CallError;

/// A call: its name, and what it does with its arguments.
#[derive(Clone, Copy)]
pub struct Call {
    pub(crate) name: &'static str,
    pub(crate) carry_out: fn(&mut Page, &Arguments) -> Result<Value, CallError>,
}

/// What a page has: at most one run, and the surrogates that it has loaded, by name and path.
pub struct Page {
    pub(crate) laboratory: Laboratory,
    pub(crate) run: Option<RunInPieces>,
    pub(crate) families: BTreeMap<String, FamilyModel>,
    /// The last prediction, with the name of its family and what was asked: a page that draws a test over it asks again and again.
    pub(crate) last: Option<(String, Vec<Option<f64>>, FamilyPrediction)>,
    /// What the call that trained it knows how to ask; without its type, so that the module without that call has nothing of it.
    pub(crate) trained: Option<Box<dyn Any>>,
    calls: &'static [Call],
}

impl Page {
    /// A page that can make these calls.
    pub fn new(calls: &'static [Call]) -> Page {
        let hardware = Hardware { threads: 1, ..Hardware::default() };
        Page {
            laboratory: Laboratory {
                resources: Resources::new(hardware),
                version: env!("CARGO_PKG_VERSION").into(),
                engine: OWN_ENGINE.into(),
                registry: RunRegistry::without_files(),
            },
            run: None,
            families: BTreeMap::new(),
            last: None,
            trained: None,
            calls,
        }
    }

    /// Carries out a message and returns the answer, both of which are JSON.
    ///
    /// ```
    /// let mut page = granum_browser::Page::new(granum_browser::ENGINE);
    /// assert!(page.answer(r#"{"call": "about"}"#).contains("version"));
    /// assert!(page.answer("no message").contains("error"));
    /// ```
    pub fn answer(&mut self, message: &str) -> String {
        let answer = self.carried_out(message);
        answer.unwrap_or_else(|error| error.answer()).to_string()
    }

    fn carried_out(&mut self, message: &str) -> Result<Value, CallError> {
        let arguments: Value = serde_json::from_str(message)
            .map_err(|error| CallError::Message(format!("this is no message in JSON: {error}")))?;
        let name = arguments["call"].as_str().unwrap_or_default();
        match self.calls.iter().find(|call| call.name == name) {
            Some(call) => (call.carry_out)(self, &Arguments(&arguments)),
            None => {
                let known: Vec<&str> = self.calls.iter().map(|call| call.name).collect();
                Err(CallError::Message(format!("there is no call {name:?}; known are {}", known.join(", "))))
            }
        }
    }

    /// The run under way.
    pub(crate) fn run(&self) -> Result<&RunInPieces, CallError> {
        self.run.as_ref().ok_or_else(|| CallError::Message("there is no run; begin one first".into()))
    }
}

/// The arguments of a call.
pub(crate) struct Arguments<'a>(&'a Value);

impl Arguments<'_> {
    /// A text.
    pub(crate) fn text(&self, name: &str) -> Result<&str, CallError> {
        self.0[name].as_str().ok_or_else(|| CallError::Message(format!("the call needs a text {name:?}")))
    }

    /// A value.
    pub(crate) fn value(&self, name: &str) -> &Value {
        &self.0[name]
    }

    /// A number, or what stands in its place where there is none.
    pub(crate) fn number_or(&self, name: &str, otherwise: f64) -> f64 {
        self.0[name].as_f64().unwrap_or(otherwise)
    }

    /// Numbers by their names; those that are null are not known.
    pub(crate) fn numbers(&self, name: &str) -> BTreeMap<String, f64> {
        let values = self.0[name].as_object().into_iter().flatten();
        values.filter_map(|(name, value)| Some((name.clone(), value.as_f64()?))).collect()
    }
}

//! Progress of a work in steps, such as fitting surrogates one after another.

use granum_core::observer::{Event, Flow, Observer, Progress as Step};
use granum_run::laboratory::ProgressField;

use crate::context::Context;
use crate::progress::Progress;

/// Shows how far a work is and its warnings, and stops it when the user asks for it.
pub struct ShowSteps<'a> {
    context: &'a Context,
    progress: Progress,
}

impl<'a> ShowSteps<'a> {
    pub fn new(context: &'a Context, phase: &str) -> ShowSteps<'a> {
        let mut progress = context.progress();
        progress.phase(phase);
        ShowSteps { context, progress }
    }

    /// Ends the work with a permanent line.
    pub fn end(&mut self, text: impl FnOnce() -> String) {
        self.progress.end(text);
    }
}

impl Observer for ShowSteps<'_> {
    fn progress(&mut self, step: &Step) -> Flow {
        let part = step.part.clone().into_iter().map(|part| ProgressField::new(0, part));
        self.progress.update(step.completed(), |_| part.collect());
        self.context.flow()
    }

    fn event(&mut self, event: &Event) {
        if let Event::Warning { text } = event {
            let context = self.context;
            self.progress.aside(|| context.warn(text));
        }
    }
}

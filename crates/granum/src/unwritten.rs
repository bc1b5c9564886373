//! Work of which nothing is written until its end: reading and searching, measuring, drawing. It has no state worth saving, so that
//! an interruption ends the program within a fraction of a second, wherever it is: not every loop has to listen.
//!
//! A thread beside the work looks for the interruption, and shows how long the work has taken.

use std::process;
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread;
use std::time::{Duration, Instant};

use granum_io::atomic::abandon_writing;

use crate::context::Context;
use crate::failure::{Failure, Interrupted};
use crate::interrupt::INTERRUPTED;
use crate::progress::{Progress, Room, readable};
use granum_run::laboratory::ProgressField;

/// Time between two looks at the flag of an interruption.
const LOOK_EVERY: Duration = Duration::from_millis(50);
/// Time in which work that listens by itself can end with a message of its own.
const GRACE: Duration = Duration::from_millis(400);
/// Time after which work is shown.
const SHOWN_AFTER: Duration = Duration::from_secs(3);

/// Work of which nothing has been written, for as long as this lives.
pub struct Unwritten {
    end: Option<Sender<()>>,
    watch: Option<thread::JoinHandle<()>>,
}

impl Context {
    /// Until the returned value is dropped, an interruption ends the program soon, whatever it is doing, since nothing has been
    /// written. With a name the work is shown once it has taken a while; without, it has a display of its own.
    pub fn nothing_written(&self, work: Option<&'static str>) -> Unwritten {
        Unwritten::new(self.clone(), work)
    }
}

impl Unwritten {
    pub fn new(context: Context, work: Option<&'static str>) -> Unwritten {
        let (end, ended) = mpsc::channel::<()>();
        let watch = move || {
            let started = Instant::now();
            let mut stopped: Option<Instant> = None;
            let mut shown: Option<Progress> = None;
            while ended.recv_timeout(LOOK_EVERY) == Err(RecvTimeoutError::Timeout) {
                if context.stopped() && stopped.get_or_insert_with(Instant::now).elapsed() >= GRACE {
                    drop(shown);
                    end_program(&context);
                }
                if let Some(work) = work.filter(|_| started.elapsed() >= SHOWN_AFTER) {
                    let progress = shown.get_or_insert_with(|| {
                        let mut progress = context.progress();
                        progress.phase(work);
                        progress
                    });
                    progress.update(None, |_: Room| vec![ProgressField::new(0, readable(started.elapsed()))]);
                }
            }
        };
        // Without the thread the work goes on, and a second signal ends it.
        let watch = thread::Builder::new().name("interruption".into()).spawn(watch).ok();
        Unwritten { end: Some(end), watch }
    }
}

impl Drop for Unwritten {
    fn drop(&mut self) {
        drop(self.end.take());
        // What follows may write, and must not be cut off.
        if let Some(watch) = self.watch.take() {
            let _ = watch.join();
        }
    }
}

/// Ends the program in the midst of its work. Files are written beside their place and renamed when they are complete, so that those
/// that are complete stay, and others are as if they had never been begun.
fn end_program(context: &Context) -> ! {
    abandon_writing();
    let left = "what was being computed is lost; files are complete or were not written".to_string();
    Failure::from(Interrupted { left }).print(context.json, &context.warnings());
    process::exit(INTERRUPTED.into())
}

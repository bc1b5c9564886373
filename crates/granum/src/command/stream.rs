//! `granum stream`: predictions for states that come one after the other, line by line.

use std::io::{self, BufRead, Write};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use clap::Args;
use granum_learn::family::FamilyStates;
use granum_learn::surrogate::PredictionStream;

use super::chosen_model::ChosenModel;
use super::family_flags::chosen_family;
use super::prediction_input::LEVEL;
use super::stream_line::{Answer, StreamInputs};
use crate::context::Context;
use crate::failure::{Failure, Unread};
use crate::latency::Latency;
use crate::messages;
use crate::output;

/// Longest line that is read, bytes: a state of ten thousand inputs.
const LONGEST_LINE: usize = 1 << 20;

/// Predict states that come one after the other, as from the sensors of a test that is running: a line of JSON on standard input is answered by a
/// line of JSON on standard output, at once.
///
/// A line has a value for every input of the surrogate by its name: a number in SI units, or a text with its unit ("100 kPa"); other names are
/// passed over. `sequence` is given back as it came. The answer has the names of the table of `granum predict`: predicted_NAME, and with intervals
/// standard_deviation_NAME, lower_NAME and upper_NAME (90 % of the states of new runs), and the list `outside` of the inputs outside the trained range.
///
/// A surrogate with memory (recurrent, path-*) carries it from line to line. {"reset": true} begins a new test. {"units": {"pressure": "kPa"}} gives
/// the units of numbers from there on. A line that cannot be answered gets an answer with `error`, and leaves no trace.
#[derive(Args)]
#[command(
    after_help = "Example:\n  sensors | granum stream surrogate.json | controller\n  echo '{\"sequence\": 1, \"deviator_strain\": 0.12, \
                  \"deviator_fabric\": 0.1}' | granum stream study --model F2\n  sensors | granum stream sand --path undrained-triaxial"
)]
pub struct Stream {
    /// The file of a surrogate, the folder of a study with --model, or the name of a family: all of its inputs must then be in a line, and the coordinate.
    #[arg(value_name = "MODEL")]
    path: PathBuf,
    /// The surrogate of a study (stress_ratio-ridge), or the mapping (F2).
    #[arg(short, long, visible_alias = "mapping", value_name = "NAME")]
    model: Option<String>,
    /// The path of the tests of a family.
    #[arg(long = "path", value_name = "NAME")]
    family_path: Option<String>,
    /// End with an error at the first line that cannot be answered.
    #[arg(long)]
    strict: bool,
    /// At the end, print on standard error how long answers took, from a line read to its answer written.
    #[arg(long)]
    latency: bool,
}

impl Stream {
    fn chosen(&self, context: &Context) -> Result<ChosenModel, Failure> {
        match chosen_family(&self.path, self.family_path.as_deref(), self.model.as_deref())? {
            Some(family) => Ok(ChosenModel::File(Box::new(FamilyStates::new(Arc::new(family))))),
            None => ChosenModel::read(context, &self.path, self.model.as_deref()),
        }
    }

    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let _alone = context.nothing_written(None);
        let model = self.chosen(context)?;
        let surrogate = model.surrogate()?;
        let mut stream = PredictionStream::new(surrogate, LEVEL)?;
        let mut inputs = StreamInputs::new(context, surrogate)?;
        let mut latency = Latency::default();
        let (mut lines, mut out) = (io::stdin().lock(), io::stdout().lock());
        let (mut line, mut number) = (Vec::new(), 0u64);
        let ended = loop {
            let read = next_line(&mut lines, &mut line)
                .map_err(|error| Failure::new(format!("standard input cannot be read: {error}")))?;
            let began = Instant::now();
            number += 1;
            let answer = match read {
                Line::End => break Ok(()),
                Line::TooLong => Answer::refused(
                    None,
                    format!(
                        "the line is longer than {LONGEST_LINE} bytes, which no state of this surrogate is"
                    ),
                ),
                Line::Whole => inputs.answer(&mut stream, &line),
            };
            write_line(&mut out, &answer.json(number))?;
            latency.add(began.elapsed());
            if let (true, Some(error)) = (self.strict, answer.error()) {
                break Err(Failure::new(format!("line {number}: {error}")));
            }
        };
        if self.latency {
            messages::line(latency.text());
        }
        ended
    }
}

/// Writes a line at once. If nobody reads the answers any more, the command ends without a message.
fn write_line(out: &mut impl Write, text: &str) -> Result<(), Failure> {
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Err(Unread.into()),
        result => output::written(result),
    }
}

/// What was read.
#[derive(Debug, PartialEq)]
enum Line {
    Whole,
    /// It was passed over to its end.
    TooLong,
    End,
}

/// Reads the next line without its end. No more than the longest line is kept of one.
fn next_line(input: &mut impl BufRead, line: &mut Vec<u8>) -> io::Result<Line> {
    line.clear();
    let (mut begun, mut too_long) = (false, false);
    loop {
        let available = match input.fill_buf() {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            result => result?,
        };
        if available.is_empty() && !begun {
            return Ok(Line::End);
        }
        begun = true;
        let end = available.iter().position(|byte| *byte == b'\n');
        let part = &available[..end.unwrap_or(available.len())];
        too_long |= line.len() + part.len() > LONGEST_LINE;
        if !too_long {
            line.extend_from_slice(part);
        }
        let (ended, used) = (end.is_some() || available.is_empty(), part.len() + usize::from(end.is_some()));
        input.consume(used);
        if ended {
            return Ok(if too_long { Line::TooLong } else { Line::Whole });
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::BufReader;

    use super::*;

    #[test]
    fn lines_are_read_whatever_their_ends_and_lengths_are() {
        let long = "x".repeat(LONGEST_LINE + 1);
        let text = format!("one\n\n{long}\n{}\nlast", &long[1..]);
        let mut input = BufReader::with_capacity(7, text.as_bytes());
        let mut line = Vec::new();
        let mut next = || {
            let read = next_line(&mut input, &mut line).unwrap();
            (read, line.len())
        };
        assert_eq!(next(), (Line::Whole, 3));
        assert_eq!(next(), (Line::Whole, 0));
        assert_eq!(next().0, Line::TooLong);
        assert_eq!(next(), (Line::Whole, LONGEST_LINE));
        assert_eq!(next(), (Line::Whole, 4));
        assert_eq!(next(), (Line::End, 0));
    }
}

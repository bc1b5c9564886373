//! What the process of a run tells the coordinator: a line of JSON on its standard output for each message.

use serde::{Deserialize, Serialize};

/// A message of the process of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "message", rename_all = "kebab-case")]
pub enum Message {
    /// How far the run is.
    Progress {
        /// The completed share of the run, from 0 to 1.
        share: f64,
        /// True while the run is in its test, and no longer in its preparation.
        in_test: bool,
    },
    /// Something that the user should know.
    Warning {
        /// The text.
        text: String,
    },
    /// The run ended; the last message.
    Ended {
        /// How.
        end: End,
        /// Largest memory of the process, bytes, if the system tells.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        memory: Option<u64>,
    },
}

/// How a run ended, as its process tells it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "end", rename_all = "kebab-case")]
pub enum End {
    /// It is finished; its record is in its folder.
    Finished,
    /// It was stopped in good order.
    Interrupted,
    /// It failed.
    Failed {
        /// Why.
        reason: String,
        /// True if the reason lies in its case.
        lasting: bool,
    },
}

impl Message {
    /// The message as a line of JSON.
    pub fn line(&self) -> String {
        // Numbers, texts and words can always be written.
        serde_json::to_string(self).unwrap_or_default()
    }

    /// Reads a line; `None` if it is no message.
    pub fn read(line: &str) -> Option<Message> {
        serde_json::from_str(line).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_read_back() {
        let failed = End::Failed { reason: "a\n\"b\"".into(), lasting: true };
        for message in [
            Message::Progress { share: 0.25, in_test: false },
            Message::Warning { text: "x".into() },
            Message::Ended { end: End::Interrupted, memory: None },
            Message::Ended { end: failed, memory: Some(5) },
        ] {
            assert_eq!(Message::read(&message.line()), Some(message));
        }
        assert_eq!(Message::read("thread panicked"), None);
    }
}

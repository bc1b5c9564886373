//! What a reader of results should know beside the numbers.

/// What was set right in data of another program, or what is doubtful in them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Remark {
    /// A whole sentence without its full stop.
    pub text: String,
    /// True if numbers may be wrong because of it; false for what was certain and has been set right.
    pub doubtful: bool,
}

impl Remark {
    /// What was certain and has been set right, or is only to be known.
    pub fn set_right(text: impl Into<String>) -> Remark {
        Remark { text: text.into(), doubtful: false }
    }

    /// What may make numbers wrong.
    pub fn doubtful(text: impl Into<String>) -> Remark {
        Remark { text: text.into(), doubtful: true }
    }
}

//! What a reader looks for in a table.

/// By what the header of a table is known among its lines.
pub(crate) struct Sought<'a> {
    /// True for the name of a column that is needed, given as it stands in the header.
    pub(crate) is_name: &'a dyn Fn(&str) -> bool,
    /// A line with this many of them is the header, without looking further.
    pub(crate) count: usize,
    /// True if a row of units may follow the header.
    pub(crate) may_have_units: bool,
}

impl Sought<'_> {
    /// Nothing: the first line is the header.
    pub(crate) const NOTHING: Sought<'static> =
        Sought { is_name: &|_| false, count: 0, may_have_units: false };
}

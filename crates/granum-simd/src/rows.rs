//! Aligned rows of doubles, which lane-wise gathers read and scatters write.

/// Eight doubles on one cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Row8(pub [f64; 8]);

/// Four doubles on half a cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct Row4(pub [f64; 4]);

impl Row8 {
    /// The numbers of consecutive rows, one after another.
    #[inline(always)]
    pub fn numbers(rows: &[Row8]) -> &[f64] {
        // SAFETY: a row is eight doubles and nothing else (64 bytes, no padding), so that consecutive rows are consecutive
        // doubles, and the alignment of a row exceeds that of a double.
        unsafe { std::slice::from_raw_parts(rows.as_ptr().cast(), rows.len() * 8) }
    }
}

const _: () = assert!(size_of::<Row8>() == 8 * size_of::<f64>());

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_consecutive_numbers() {
        let rows = [Row8([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]), Row8([9.0; 8])];
        assert_eq!(Row8::numbers(&rows)[7..9], [8.0, 9.0]);
        assert!(Row8::numbers(&rows[..0]).is_empty());
    }
}

//! The checksum of HDF5: `lookup3` of Bob Jenkins (2006, public domain), little-endian, from the initial value 0.

/// The checksum of some bytes.
pub(super) fn lookup3(bytes: &[u8]) -> u32 {
    let start = 0xdead_beef_u32.wrapping_add(bytes.len() as u32);
    let (mut a, mut b, mut c) = (start, start, start);
    let word = |piece: &[u8], k: usize| -> u32 {
        (0..4).map(|byte| u32::from(piece.get(4 * k + byte).copied().unwrap_or(0)) << (8 * byte)).sum()
    };
    let mut rest = bytes;
    while rest.len() > 12 {
        let (piece, later) = rest.split_at(12);
        a = a.wrapping_add(word(piece, 0));
        b = b.wrapping_add(word(piece, 1));
        c = c.wrapping_add(word(piece, 2));
        for [shift_c, shift_a, shift_b] in [[4, 6, 8], [16, 19, 4]] {
            a = a.wrapping_sub(c) ^ c.rotate_left(shift_c);
            c = c.wrapping_add(b);
            b = b.wrapping_sub(a) ^ a.rotate_left(shift_a);
            a = a.wrapping_add(c);
            c = c.wrapping_sub(b) ^ b.rotate_left(shift_b);
            b = b.wrapping_add(a);
        }
        rest = later;
    }
    if rest.is_empty() {
        return c;
    }
    a = a.wrapping_add(word(rest, 0));
    b = b.wrapping_add(word(rest, 1));
    c = c.wrapping_add(word(rest, 2));
    c = (c ^ b).wrapping_sub(b.rotate_left(14));
    a = (a ^ c).wrapping_sub(c.rotate_left(11));
    b = (b ^ a).wrapping_sub(a.rotate_left(25));
    c = (c ^ b).wrapping_sub(b.rotate_left(16));
    a = (a ^ c).wrapping_sub(c.rotate_left(4));
    b = (b ^ a).wrapping_sub(a.rotate_left(14));
    (c ^ b).wrapping_sub(b.rotate_left(24))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The values that the author of the function gives in its source.
    #[test]
    fn published_values() {
        assert_eq!(lookup3(b""), 0xdead_beef);
        assert_eq!(lookup3(b"Four score and seven years ago"), 0x1777_0551);
    }
}

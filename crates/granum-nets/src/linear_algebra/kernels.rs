//! Products of small dense matrices with eight lanes.
//!
//! A matrix with the rows of a table across its lanes is stored as an array of `Row8`: element (k, lane block b) is at
//! `k * stride + b`, and the stride is odd, so that rows do not compete for the same cache sets. Every element of a product
//! is summed in a fixed order for any size of the tiles. The instruction set, which only determines the size of the tiles
//! that fit into the registers, therefore does not change any bit of the result.

use granum_simd::{LANES, Lanes, Row8};

/// An odd distance of at least `blocks` between the rows of a lane matrix.
pub(crate) fn odd(blocks: usize) -> usize {
    blocks | 1
}

/// Number of lane blocks that hold `rows` rows.
pub(crate) fn blocks(rows: usize) -> usize {
    rows.div_ceil(LANES)
}

/// Largest width of a panel of [`scalar_times_lanes`] with tiles of height five, in lane blocks.
#[inline(always)]
pub(crate) fn panel<L: Lanes>() -> usize {
    if const { L::REGISTERS >= 32 } { 5 } else { 1 }
}

/// Splits blocks `from..to` into panels of nearly equal width, at most `widest`, and visits each with its first block and
/// its width.
#[inline(always)]
pub(crate) fn panels(from: usize, to: usize, widest: usize, mut visit: impl FnMut(usize, usize)) {
    let count = to - from;
    let number = count.div_ceil(widest);
    let mut first = from;
    for p in 0..number {
        let end = from + count * (p + 1) / number;
        visit(first, end - first);
        first = end;
    }
}

/// The layout of the scalars of a product: element (k, j) is at `k * by_k + j * by_j`.
#[derive(Clone, Copy)]
pub(crate) struct Scalars<'a> {
    pub values: &'a [f64],
    pub by_k: usize,
    pub by_j: usize,
}

/// Calls `finish(j, b, start(j, b) + sum over k of scalar(k, j) * lanes(k, b))` for every `j < outputs` and the blocks `b` of
/// `first..first + width`.
///
/// `lanes` is the lane matrix with the given stride, of which rows `0..depth` are used. Tiles have a height of `J` outputs
/// and a width of `width <= W` blocks, where `J * W` values should fit into the registers.
#[inline(always)]
pub(crate) fn scalar_times_lanes<L: Lanes, const J: usize, const W: usize>(
    scalars: Scalars,
    outputs: usize,
    depth: usize,
    lanes: &[Row8],
    stride: usize,
    first: usize,
    width: usize,
    start: impl Fn(usize, usize) -> L,
    mut finish: impl FnMut(usize, usize, L),
) {
    let (start, finish) = (&start, &mut finish);
    // Where few values fit into the registers, callers ask for one block at a time, and wider tiles need not be compiled.
    if const { L::REGISTERS >= 32 } {
        match width {
            5 if W >= 5 => {
                return columns::<L, J, 5>(scalars, outputs, depth, lanes, stride, first, start, finish);
            }
            4 if W >= 4 => {
                return columns::<L, J, 4>(scalars, outputs, depth, lanes, stride, first, start, finish);
            }
            3 if W >= 3 => {
                return columns::<L, J, 3>(scalars, outputs, depth, lanes, stride, first, start, finish);
            }
            2 if W >= 2 => {
                return columns::<L, J, 2>(scalars, outputs, depth, lanes, stride, first, start, finish);
            }
            _ => {}
        }
    }
    for block in first..first + width {
        columns::<L, J, 1>(scalars, outputs, depth, lanes, stride, block, start, finish);
    }
}

/// All outputs for `R` lane blocks, in tiles of `J` outputs and the remaining outputs one by one.
#[inline(always)]
fn columns<L: Lanes, const J: usize, const R: usize>(
    scalars: Scalars,
    outputs: usize,
    depth: usize,
    lanes: &[Row8],
    stride: usize,
    first: usize,
    start: &impl Fn(usize, usize) -> L,
    finish: &mut impl FnMut(usize, usize, L),
) {
    let mut j = 0;
    while j + J <= outputs {
        tile::<L, J, R>(scalars, j, depth, lanes, stride, first, start, finish);
        j += J;
    }
    while j < outputs {
        tile::<L, 1, R>(scalars, j, depth, lanes, stride, first, start, finish);
        j += 1;
    }
}

#[inline(always)]
fn tile<L: Lanes, const J: usize, const R: usize>(
    scalars: Scalars,
    j: usize,
    depth: usize,
    lanes: &[Row8],
    stride: usize,
    first: usize,
    start: &impl Fn(usize, usize) -> L,
    finish: &mut impl FnMut(usize, usize, L),
) {
    let mut sums = [[L::zero(); R]; J];
    for jj in 0..J {
        for r in 0..R {
            sums[jj][r] = start(j + jj, first + r);
        }
    }
    let mut at = j * scalars.by_j;
    let mut from = first;
    for _ in 0..depth {
        let row = &lanes[from..from + R];
        let factors = &scalars.values[at..at + (J - 1) * scalars.by_j + 1];
        let mut values = [L::zero(); R];
        for r in 0..R {
            values[r] = L::load(&row[r].0);
        }
        for jj in 0..J {
            let factor = L::splat(factors[jj * scalars.by_j]);
            for r in 0..R {
                sums[jj][r] = factor.mul_add(values[r], sums[jj][r]);
            }
        }
        at += scalars.by_k;
        from += stride;
    }
    for jj in 0..J {
        for r in 0..R {
            finish(j + jj, first + r, sums[jj][r]);
        }
    }
}

/// Calls `finish(j, i, sum over all lanes of a(j) * b(i))` for `j < rows_a` and `i < rows_b`. The blocks are summed in order
/// in each lane, and then the lanes are added as in [`granum_simd::Real::reduce_add`].
#[inline(always)]
pub(crate) fn lane_dots<L: Lanes>(
    a: &[Row8],
    rows_a: usize,
    b: &[Row8],
    rows_b: usize,
    stride: usize,
    count: usize,
    mut finish: impl FnMut(usize, usize, f64),
) {
    // Tiles have nearly equal widths, at most six with a height of four, or three with a height of two if there are few
    // registers.
    let (high, wide) = if const { L::REGISTERS >= 32 } { (4, 6) } else { (2, 3) };
    let tiles = rows_b.div_ceil(wide);
    let mut j = 0;
    while j < rows_a {
        let height = if j + high <= rows_a { high } else { 1 };
        let mut i = 0;
        for t in 0..tiles {
            let width = (rows_b * (t + 1)) / tiles - i;
            if height == 1 {
                dots_of_width::<L, 1>(a, j, b, i, width, stride, count, &mut finish);
            } else if const { L::REGISTERS >= 32 } {
                dots_of_width::<L, 4>(a, j, b, i, width, stride, count, &mut finish);
            } else {
                dots_of_width::<L, 2>(a, j, b, i, width, stride, count, &mut finish);
            }
            i += width;
        }
        j += height;
    }
}

#[inline(always)]
fn dots_of_width<L: Lanes, const J: usize>(
    a: &[Row8],
    j: usize,
    b: &[Row8],
    i: usize,
    width: usize,
    stride: usize,
    count: usize,
    finish: &mut impl FnMut(usize, usize, f64),
) {
    if const { L::REGISTERS >= 32 } {
        match width {
            4 => return dots::<L, J, 4>(a, j, b, i, stride, count, finish),
            5 => return dots::<L, J, 5>(a, j, b, i, stride, count, finish),
            6 => return dots::<L, J, 6>(a, j, b, i, stride, count, finish),
            _ => {}
        }
    }
    match width {
        1 => dots::<L, J, 1>(a, j, b, i, stride, count, finish),
        2 => dots::<L, J, 2>(a, j, b, i, stride, count, finish),
        _ => dots::<L, J, 3>(a, j, b, i, stride, count, finish),
    }
}

#[inline(always)]
fn dots<L: Lanes, const J: usize, const I: usize>(
    a: &[Row8],
    j: usize,
    b: &[Row8],
    i: usize,
    stride: usize,
    count: usize,
    finish: &mut impl FnMut(usize, usize, f64),
) {
    let mut rows_a = [&a[..0]; J];
    for jj in 0..J {
        rows_a[jj] = &a[(j + jj) * stride..(j + jj) * stride + count];
    }
    let mut rows_b = [&b[..0]; I];
    for ii in 0..I {
        rows_b[ii] = &b[(i + ii) * stride..(i + ii) * stride + count];
    }
    let mut sums = [[L::zero(); I]; J];
    for k in 0..count {
        let mut values = [L::zero(); I];
        for ii in 0..I {
            values[ii] = L::load(&rows_b[ii][k].0);
        }
        for jj in 0..J {
            let factor = L::load(&rows_a[jj][k].0);
            for ii in 0..I {
                sums[jj][ii] = factor.mul_add(values[ii], sums[jj][ii]);
            }
        }
    }
    // The sums over lanes are computed for eight sums at a time.
    let mut at = 0;
    while at < J * I {
        let mut group = [L::zero(); LANES];
        for l in 0..LANES {
            if at + l < J * I {
                group[l] = sums[(at + l) / I][(at + l) % I];
            }
        }
        let mut totals = [0.0; LANES];
        L::reduce_add8(group).store(&mut totals);
        for l in 0..LANES {
            if at + l < J * I {
                finish(j + (at + l) / I, i + (at + l) % I, totals[l]);
            }
        }
        at += LANES;
    }
}

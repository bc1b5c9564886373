//! Transfer of the numbers of contacts to a law that is called through a function pointer, and back.

use granum_simd::{Lanes, Real, Row8, Twice};

use super::law::Normal;
use super::{LAW_CONSTANTS, MAX_ADHESION_HISTORY, MAX_HISTORY, MAX_MOMENT_HISTORY};

/// One number of a contact, for up to two batches of eight contacts.
pub type Column = [Row8; 2];

/// Number of contacts that a call evaluates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Count {
    /// One contact, in the first element of every column.
    One,
    /// One batch of eight.
    Batch,
    /// Two batches.
    TwoBatches,
}

/// Numbers that a call evaluates together, and their position in a column.
pub trait Width {
    /// The numbers.
    type Value: Real;
    /// Their number.
    const COUNT: Count;
    /// Reads them from a column.
    fn read(column: &Column) -> Self::Value;
    /// Writes them to a column.
    fn write(value: Self::Value, column: &mut Column);
    /// Writes a mask as ones and zeros.
    #[inline(always)]
    fn write_mask(mask: <Self::Value as Real>::Mask, column: &mut Column) {
        Self::write(Self::Value::splat(1.0).keep(mask), column);
    }
    /// Reads a mask written as ones and zeros.
    #[inline(always)]
    fn read_mask(column: &Column) -> <Self::Value as Real>::Mask {
        Self::read(column).gt(Self::Value::zero())
    }
}

/// One contact.
#[derive(Clone, Copy)]
pub struct One;
/// A batch.
#[derive(Clone, Copy)]
pub struct Batch<L>(std::marker::PhantomData<L>);
/// Two batches.
#[derive(Clone, Copy)]
pub struct TwoBatches<L>(std::marker::PhantomData<L>);

impl Width for One {
    type Value = f64;
    const COUNT: Count = Count::One;
    #[inline(always)]
    fn read(column: &Column) -> f64 {
        column[0].0[0]
    }
    #[inline(always)]
    fn write(value: f64, column: &mut Column) {
        column[0].0[0] = value;
    }
}
impl<L: Lanes> Width for Batch<L> {
    type Value = L;
    const COUNT: Count = Count::Batch;
    #[inline(always)]
    fn read(column: &Column) -> L {
        L::load(&column[0].0)
    }
    #[inline(always)]
    fn write(value: L, column: &mut Column) {
        value.store(&mut column[0].0);
    }
}
impl<L: Lanes> Width for TwoBatches<L> {
    type Value = Twice<L>;
    const COUNT: Count = Count::TwoBatches;
    #[inline(always)]
    fn read(column: &Column) -> Twice<L> {
        Twice(L::load(&column[0].0), L::load(&column[1].0))
    }
    #[inline(always)]
    fn write(value: Twice<L>, column: &mut Column) {
        value.0.store(&mut column[0].0);
        value.1.store(&mut column[1].0);
    }
}

/// Reads consecutive columns.
#[inline(always)]
pub(super) fn read<W: Width, const N: usize>(columns: &[Column], from: usize) -> [W::Value; N] {
    std::array::from_fn(
        #[inline(always)]
        |c| W::read(&columns[from + c]),
    )
}

/// Writes consecutive columns.
#[inline(always)]
pub(super) fn write<W: Width, const N: usize>(values: [W::Value; N], columns: &mut [Column], from: usize) {
    for (c, value) in values.into_iter().enumerate() {
        W::write(value, &mut columns[from + c]);
    }
}

/// Columns of the normal part of a contact, as it is passed between slots: the numbers of [`Normal`] and the mask of
/// touching pairs.
pub(super) const NORMAL_COLUMNS: usize = 8;

#[inline(always)]
pub(super) fn write_normal<W: Width>(normal: &Normal<W::Value>, columns: &mut [Column], from: usize) {
    let numbers = [
        normal.force,
        normal.radius,
        normal.stiffness,
        normal.root_stiffness,
        normal.tangential_measure,
        normal.root_tangential_measure,
        normal.friction_load,
    ];
    write::<W, 7>(numbers, columns, from);
    W::write_mask(normal.touching, &mut columns[from + 7]);
}

#[inline(always)]
pub(super) fn read_normal<W: Width>(columns: &[Column], from: usize) -> Normal<W::Value> {
    let [
        force,
        radius,
        stiffness,
        root_stiffness,
        tangential_measure,
        root_tangential_measure,
        friction_load,
    ] = read::<W, 7>(columns, from);
    Normal {
        force,
        radius,
        stiffness,
        root_stiffness,
        tangential_measure,
        root_tangential_measure,
        friction_load,
        touching: W::read_mask(&columns[from + 7]),
    }
}

/// Columns of a call to a normal law: constants, overlap, whether the pair touched; then the contact and the losses.
pub(super) mod normal_call {
    use super::{LAW_CONSTANTS, NORMAL_COLUMNS};
    pub const OVERLAP: usize = LAW_CONSTANTS;
    pub const TOUCHED: usize = OVERLAP + 1;
    pub const CONTACT: usize = TOUCHED + 1;
    pub const LOSSES: usize = CONTACT + NORMAL_COLUMNS;
    pub const ALL: usize = LOSSES + 2;
}

/// Columns of a call to a tangential law: constants, contact, increment, history; then force, stiffnesses, masks, losses.
pub(super) mod tangential_call {
    use super::{LAW_CONSTANTS, MAX_HISTORY, NORMAL_COLUMNS};
    pub const CONTACT: usize = LAW_CONSTANTS;
    pub const INCREMENT: usize = CONTACT + NORMAL_COLUMNS;
    pub const HISTORY: usize = INCREMENT + 2;
    pub const RESULT: usize = HISTORY + MAX_HISTORY;
    pub const SLIDING: usize = RESULT + 7;
    pub const DISCARDS: usize = SLIDING + 1;
    pub const ALL: usize = DISCARDS + 1;
}

/// Columns of a call to a law of moments: constants, contact, spins, time step, history; then couple, dashpots, losses.
pub(super) mod moment_call {
    use super::{LAW_CONSTANTS, MAX_MOMENT_HISTORY, NORMAL_COLUMNS};
    pub const CONTACT: usize = LAW_CONSTANTS;
    pub const SPIN: usize = CONTACT + NORMAL_COLUMNS;
    pub const TIME_STEP: usize = SPIN + 3;
    pub const HISTORY: usize = TIME_STEP + 1;
    pub const RESULT: usize = HISTORY + MAX_MOMENT_HISTORY;
    pub const AT_LIMIT: usize = RESULT + 8;
    pub const ALL: usize = AT_LIMIT + 1;
}

/// Columns of a call to a law of adhesion: constants, overlap, whether it touches, history; then force, stiffness, loss.
pub(super) mod adhesion_call {
    use super::{LAW_CONSTANTS, MAX_ADHESION_HISTORY};
    pub const OVERLAP: usize = LAW_CONSTANTS;
    pub const TOUCHING: usize = OVERLAP + 1;
    pub const HISTORY: usize = TOUCHING + 1;
    pub const RESULT: usize = HISTORY + MAX_ADHESION_HISTORY;
    pub const ACTING: usize = RESULT + 3;
    pub const ALL: usize = ACTING + 1;
}

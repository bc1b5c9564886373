//! Constants of a law for a pair, by name: a struct that a law declares with [`law_constants!`](crate::law_constants).

use crate::contact::law::limits::LAW_CONSTANTS;

pub use granum_simd::Real;

/// Constants that a law prepares for a pair and uses in every step, for one pair (`R` is `f64`) or for eight side by side.
///
/// Numbers and structs of numbers are constants. A struct implements this by [`law_constants!`](crate::law_constants).
pub trait LawConstants<R: Real>: Copy {
    /// Number of constants, at most [`LAW_CONSTANTS`].
    const COUNT: usize;
    /// Takes them from the columns that begin with `first`, in the order of their declaration.
    fn take(first: usize, column: impl Fn(usize) -> R + Copy) -> Self;
    /// Puts them into the columns that begin with `first`, in the same order.
    fn put(&self, first: usize, columns: &mut [R]);
}

impl<R: Real> LawConstants<R> for R {
    const COUNT: usize = 1;
    #[inline(always)]
    fn take(first: usize, column: impl Fn(usize) -> R + Copy) -> R {
        column(first)
    }
    fn put(&self, first: usize, columns: &mut [R]) {
        columns[first] = *self;
    }
}

/// Constants of a law that has none.
#[derive(Clone, Copy, Debug)]
pub struct NoConstants;

impl<R: Real> LawConstants<R> for NoConstants {
    const COUNT: usize = 0;
    #[inline(always)]
    fn take(_first: usize, _column: impl Fn(usize) -> R + Copy) -> NoConstants {
        NoConstants
    }
    fn put(&self, _first: usize, _columns: &mut [R]) {}
}

/// The constants of a law out of the columns of a pair.
#[inline(always)]
pub(crate) fn named<R: Real, C: LawConstants<R>>(columns: &[R; LAW_CONSTANTS]) -> C {
    C::take(
        0,
        #[inline(always)]
        |c| columns[c],
    )
}

/// The constants of a law as columns of a pair; unused columns are zero.
pub(crate) fn columns<C: LawConstants<f64>>(constants: C) -> [f64; LAW_CONSTANTS] {
    const { assert!(C::COUNT <= LAW_CONSTANTS, "a law has more constants than LAW_CONSTANTS") };
    let mut columns = [0.0; LAW_CONSTANTS];
    constants.put(0, &mut columns);
    columns
}

/// Declares the constants of a law for a pair as a struct over the numbers of one pair or of eight, with the implementation of
/// [`LawConstants`](crate::contact::law::constants::LawConstants).
///
/// Fields are numbers, or other structs that were declared in this way. The declaration is that of an ordinary struct with one
/// parameter; the macro adds to it that the fields are read from and written to columns of numbers in their order.
///
/// ```
/// use granum_dem::contact::law::constants::LawConstants;
/// use granum_dem::law_constants;
///
/// law_constants! {
///     /// Constants of a spring.
///     pub struct SpringConstants<R> {
///         /// Stiffness k, N/m.
///         pub stiffness: R,
///         /// Its square root.
///         pub root_stiffness: R,
///     }
/// }
/// law_constants! {
///     /// Constants of a spring that holds grains together.
///     pub struct StickyConstants<R> {
///         pub spring: SpringConstants<R>,
///         /// Pull-off force, N.
///         pub pull_off: R,
///     }
/// }
///
/// let spring = SpringConstants { stiffness: 4.0, root_stiffness: 2.0 };
/// let mut columns = [0.0; 3];
/// StickyConstants { spring, pull_off: 1.0 }.put(0, &mut columns);
/// assert_eq!(columns, [4.0, 2.0, 1.0]);
/// let again = StickyConstants::<f64>::take(0, |c| columns[c]);
/// assert_eq!(again.spring.root_stiffness, 2.0);
/// ```
#[macro_export]
macro_rules! law_constants {
    (
        $(#[$about:meta])*
        $visible:vis struct $name:ident<$number:ident> {
            $($(#[$meaning:meta])* $shown:vis $field:ident: $type:ty,)+
        }
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug)]
        $visible struct $name<$number> {
            $($(#[$meaning])* $shown $field: $type,)+
        }

        impl<$number: $crate::contact::law::constants::Real> $crate::contact::law::constants::LawConstants<$number>
            for $name<$number>
        {
            const COUNT: usize =
                0 $(+ <$type as $crate::contact::law::constants::LawConstants<$number>>::COUNT)+;
            #[inline(always)]
            fn take(first: usize, column: impl Fn(usize) -> $number + Copy) -> Self {
                // Every field begins where the one before it ends.
                let end = first;
                $(
                    let count = <$type as $crate::contact::law::constants::LawConstants<$number>>::COUNT;
                    let (first, end) = (end, end + count);
                    let $field = $crate::contact::law::constants::LawConstants::<$number>::take(first, column);
                )+
                let _ = end;
                $name { $($field),+ }
            }
            fn put(&self, first: usize, columns: &mut [$number]) {
                let end = first;
                $(
                    let count = <$type as $crate::contact::law::constants::LawConstants<$number>>::COUNT;
                    let (first, end) = (end, end + count);
                    $crate::contact::law::constants::LawConstants::<$number>::put(&self.$field, first, columns);
                )+
                let _ = end;
            }
        }
    };
}

//! The laws as used by the contact stage: compiled into its loop, or called through their slots.

use granum_simd::{Lanes, Twice};

use super::views::Views;
use crate::contact::columns::{Batch, TwoBatches};
use crate::contact::interaction::{Interaction, Kinematics, Memory, interact};
use crate::contact::set::{Compiled, Laws, Open, Slots};
use crate::contact::{LAW_CONSTANTS, MAX_HISTORY, NormalLaw, PairConstants, TangentialLaw};

/// Couples on the grains of a batch, or an empty type for sets that never have any, so that nothing needs to be carried
/// along.
pub(crate) trait Couples<L: Lanes>: Copy {
    /// No couples.
    fn none() -> Self;
    /// From couples on the grains i, N m, whose opposites act on j, with the reciprocals of the radii of i and j, 1/m.
    fn of(couple: [L; 3], inverse_radii: impl FnOnce() -> [L; 2]) -> Self;
    /// Torque over radius of i and of j, N, if any.
    fn moments(&self) -> Option<[[L; 3]; 2]>;
}

impl<L: Lanes> Couples<L> for () {
    #[inline(always)]
    fn none() {}
    #[inline(always)]
    fn of(_couple: [L; 3], _inverse_radii: impl FnOnce() -> [L; 2]) {}
    #[inline(always)]
    fn moments(&self) -> Option<[[L; 3]; 2]> {
        None
    }
}

impl<L: Lanes> Couples<L> for [[L; 3]; 2] {
    #[inline(always)]
    fn none() -> Self {
        [[L::zero(); 3]; 2]
    }
    #[inline(always)]
    fn of(couple: [L; 3], inverse_radii: impl FnOnce() -> [L; 2]) -> Self {
        let [x, y, z] = couple;
        let [i, j] = inverse_radii();
        [[x * i, y * i, z * i], [-(x * j), -(y * j), -(z * j)]]
    }
    #[inline(always)]
    fn moments(&self) -> Option<[[L; 3]; 2]> {
        Some(*self)
    }
}

/// The laws of a contact stage.
pub(crate) trait StageLaws {
    /// True if the set may have moments.
    const MAY_HAVE_MOMENTS: bool;
    /// True if the set may have a law of adhesion.
    const MAY_HAVE_ADHESION: bool;
    /// Type of the couples on grains.
    type Couples<L: Lanes>: Couples<L>;
    /// The laws of the simulation behind the views.
    fn of(views: &Views) -> Self;
    /// Number of history columns of the tangential law.
    fn tangential_columns(&self) -> usize;
    /// Number of history columns of the moment law.
    fn moment_columns(&self) -> usize;
    /// Columns of history of the law of adhesion.
    fn adhesion_columns(&self) -> usize;
    /// True if the set has moments.
    fn has_moments(&self) -> bool;
    /// True if the set has a law of adhesion.
    fn has_adhesion(&self) -> bool;
    /// True if the tangential law discards parts of its history that store energy.
    fn discards(&self) -> bool;
    /// One step of a batch.
    fn interact<L: Lanes>(
        &self,
        constants: &PairConstants<L>,
        kinematics: &Kinematics<L>,
        dt: L,
        memory: &mut Memory<L>,
    ) -> Interaction<L>;
    /// One step of two batches.
    fn interact_two<L: Lanes>(
        &self,
        constants: &PairConstants<Twice<L>>,
        kinematics: &Kinematics<Twice<L>>,
        dt: Twice<L>,
        memory: &mut Memory<Twice<L>>,
    ) -> Interaction<Twice<L>>;
    /// Energy lost with discarded parts of the histories, J.
    fn discarded<L: Lanes>(
        &self,
        constants: &[L; LAW_CONSTANTS],
        stiffness: L,
        history: &[L; MAX_HISTORY],
    ) -> L;
}

impl<N: NormalLaw, T: TangentialLaw> StageLaws for Compiled<N, T> {
    const MAY_HAVE_MOMENTS: bool = false;
    const MAY_HAVE_ADHESION: bool = false;
    type Couples<L: Lanes> = ();
    #[inline(always)]
    fn of(_views: &Views) -> Self {
        Compiled::new()
    }
    #[inline(always)]
    fn tangential_columns(&self) -> usize {
        T::HISTORY
    }
    #[inline(always)]
    fn moment_columns(&self) -> usize {
        0
    }
    #[inline(always)]
    fn adhesion_columns(&self) -> usize {
        0
    }
    #[inline(always)]
    fn has_moments(&self) -> bool {
        false
    }
    #[inline(always)]
    fn has_adhesion(&self) -> bool {
        false
    }
    #[inline(always)]
    fn discards(&self) -> bool {
        T::DISCARDS
    }
    #[inline(always)]
    fn interact<L: Lanes>(
        &self,
        constants: &PairConstants<L>,
        kinematics: &Kinematics<L>,
        dt: L,
        memory: &mut Memory<L>,
    ) -> Interaction<L> {
        interact(self, constants, kinematics, dt, memory)
    }
    #[inline(always)]
    fn interact_two<L: Lanes>(
        &self,
        constants: &PairConstants<Twice<L>>,
        kinematics: &Kinematics<Twice<L>>,
        dt: Twice<L>,
        memory: &mut Memory<Twice<L>>,
    ) -> Interaction<Twice<L>> {
        interact(self, constants, kinematics, dt, memory)
    }
    #[inline(always)]
    fn discarded<L: Lanes>(
        &self,
        constants: &[L; LAW_CONSTANTS],
        stiffness: L,
        history: &[L; MAX_HISTORY],
    ) -> L {
        T::discarded(constants, stiffness, history)
    }
}

/// Any laws, called through their slots.
pub(crate) struct AnyLaws(Slots);

impl StageLaws for AnyLaws {
    const MAY_HAVE_MOMENTS: bool = true;
    const MAY_HAVE_ADHESION: bool = true;
    type Couples<L: Lanes> = [[L; 3]; 2];
    #[inline(always)]
    fn of(views: &Views) -> Self {
        AnyLaws(Slots::new(&views.laws, views.isa))
    }
    #[inline(always)]
    fn tangential_columns(&self) -> usize {
        self.0.tangential_columns()
    }
    #[inline(always)]
    fn moment_columns(&self) -> usize {
        self.0.moment_columns()
    }
    #[inline(always)]
    fn adhesion_columns(&self) -> usize {
        self.0.adhesion_columns()
    }
    #[inline(always)]
    fn has_moments(&self) -> bool {
        self.0.has_moments()
    }
    #[inline(always)]
    fn has_adhesion(&self) -> bool {
        self.0.has_adhesion()
    }
    #[inline(always)]
    fn discards(&self) -> bool {
        self.0.discards()
    }
    #[inline(always)]
    fn interact<L: Lanes>(
        &self,
        constants: &PairConstants<L>,
        kinematics: &Kinematics<L>,
        dt: L,
        memory: &mut Memory<L>,
    ) -> Interaction<L> {
        interact(&Open::<Batch<L>>::new(&self.0), constants, kinematics, dt, memory)
    }
    #[inline(always)]
    fn interact_two<L: Lanes>(
        &self,
        constants: &PairConstants<Twice<L>>,
        kinematics: &Kinematics<Twice<L>>,
        dt: Twice<L>,
        memory: &mut Memory<Twice<L>>,
    ) -> Interaction<Twice<L>> {
        interact(&Open::<TwoBatches<L>>::new(&self.0), constants, kinematics, dt, memory)
    }
    #[inline(always)]
    fn discarded<L: Lanes>(
        &self,
        constants: &[L; LAW_CONSTANTS],
        stiffness: L,
        history: &[L; MAX_HISTORY],
    ) -> L {
        Open::<Batch<L>>::new(&self.0).discarded(constants, stiffness, history)
    }
}

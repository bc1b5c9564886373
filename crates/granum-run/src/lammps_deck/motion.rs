//! How the cell moves in a stage: strain rates per unit of speed, ramps, and the stresses that are controlled.

use granum_core::assembly::Matrix;
use granum_dem::loading::{Control, ControlError, Drive, Ramp, Target};
use granum_dem::servo::{Row, STIFFNESS};

/// The motion of the cell in a stage. The strain rates of ramps are apart from the others, since the script alone knows how long they
/// take.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    /// Base strain rates per unit of speed, those of ramps left out.
    pub(super) rate: Matrix,
    /// The ramps of strains.
    pub(super) ramps: Vec<StrainRamp>,
    /// The controlled stresses, each with its target.
    pub(super) rows: Vec<(Row, Target)>,
}

/// A strain that follows a ramp.
#[derive(Clone, Copy, Debug)]
pub(super) struct StrainRamp {
    /// Index of the component.
    pub(super) component: usize,
    /// Its end.
    pub(super) ramp: Ramp,
    /// Strain rates of the cell for a unit rate of the component.
    pub(super) rate: Matrix,
}

impl Motion {
    /// The motion of a control; `modulus`, Pa, weighs constraints on strains and stresses.
    pub(super) fn new(control: &Control, modulus: f64) -> Result<Motion, ControlError> {
        let (plain, targets) = marked(control);
        let cell = plain.per_speed(modulus)?;
        let target_of = |row: &Row| targets.get(row.target_rate as usize).copied().unwrap_or_default();
        let rows = cell.rows().map(|row| (*row, target_of(row))).collect();
        let mut ramps = Vec::new();
        for (component, drive) in control.components.iter().enumerate() {
            if let Drive::Ramp(ramp) = drive {
                let rate = alone(&plain, component).per_speed(modulus)?.rate;
                ramps.push(StrainRamp { component, ramp: *ramp, rate });
            }
        }
        Ok(Motion { rate: cell.rate, ramps, rows })
    }

    /// True if an entry of the velocity gradient can be other than zero.
    pub(super) fn moves(&self, r: usize, c: usize) -> bool {
        self.is_strained(r, c) || self.rows.iter().any(|(row, _)| row.moves[r][c] != 0.0)
    }

    /// True if an entry of the velocity gradient is prescribed and other than zero.
    fn is_strained(&self, r: usize, c: usize) -> bool {
        self.rate[r][c] != 0.0 || self.ramps.iter().any(|ramp| ramp.rate[r][c] != 0.0)
    }

    /// True if a strain or a stress follows a ramp.
    pub(super) fn has_ramp(&self) -> bool {
        !self.ramps.is_empty() || self.rows.iter().any(|(_, target)| target.ramp.is_some())
    }

    /// The prescribed part of an entry of the velocity gradient of the homogeneous strain, as weights of variables.
    pub(super) fn prescribed(&self, r: usize, c: usize) -> Vec<(f64, String)> {
        let ramps = self.ramps.iter().enumerate();
        let of_ramps = ramps.map(|(k, ramp)| (-ramp.rate[r][c], format!("v_pace{}", k + 1)));
        std::iter::once((-self.rate[r][c], "v_speed".to_string())).chain(of_ramps).collect()
    }
}

/// Stiffness of a controlled combination by which the duration of its ramp is chosen, as multiples of the bulk modulus and a part
/// without it.
pub(super) fn stiffest(row: &Row) -> [f64; 2] {
    let weights = (0..6).map(|k| [row.stress[k] * STIFFNESS[k] / row.divisor, row.strain[k]]);
    weights.fold([0.0f64, 0.0f64], |[a, b], [x, y]| [a.max(x.abs()), b.max(y.abs())])
}

/// The control without ramps, in which the rate of every controlled stress is its number in the list of targets.
fn marked(control: &Control) -> (Control, Vec<Target>) {
    let (mut plain, mut targets) = (*control, Vec::new());
    let mut mark = |target: &mut Target| {
        let number = targets.len() as f64;
        targets.push(*target);
        (target.rate, target.ramp) = (number, None);
    };
    for drive in &mut plain.components {
        match drive {
            Drive::Stress(target) => mark(target),
            Drive::Ramp(_) => *drive = Drive::Rate(0.0),
            _ => {}
        }
    }
    for constraint in plain.constraints.iter_mut().flatten().filter(|c| c.stress != [0.0; 6]) {
        mark(&mut constraint.target);
    }
    (plain, targets)
}

/// A control in which one component has a unit rate and nothing else is strained.
fn alone(plain: &Control, component: usize) -> Control {
    let mut control = *plain;
    for (k, drive) in control.components.iter_mut().enumerate() {
        if let Drive::Rate(rate) = drive {
            *rate = f64::from(u8::from(k == component));
        }
    }
    for constraint in control.constraints.iter_mut().flatten().filter(|c| c.stress == [0.0; 6]) {
        constraint.target.rate = 0.0;
    }
    control
}

#[cfg(test)]
mod tests {
    use granum_dem::loading::{Constraint, Speed};

    use super::*;

    #[test]
    fn ramps_are_apart_and_targets_belong_to_their_rows() {
        let held = Drive::Stress(Target::held(2e4));
        let components =
            [Drive::Ramp(Ramp::To(0.01)), held, Drive::Free, Drive::Rate(0.5), Drive::Fixed, Drive::Fixed];
        let ratio = Constraint::stresses([-0.5, 0.0, 1.0, 0.0, 0.0, 0.0], Target::ramp(Ramp::By(3e3)));
        let control = Control::new(Speed::StrainRate(1.0), components).with(ratio);
        let motion = Motion::new(&control, 1e8).unwrap();
        assert_eq!((motion.ramps.len(), motion.rows.len()), (1, 2));
        assert_eq!(motion.ramps[0].rate[0][0], 1.0);
        assert!(motion.rate[0][0] == 0.0 && motion.rate[1][2] != 0.0);
        // A unit strain along x changes the combination, so that z follows.
        assert!(motion.ramps[0].rate[2][2] != 0.0);
        let of_z = motion.rows.iter().find(|(row, _)| row.stress[2] != 0.0).unwrap();
        assert_eq!(of_z.1.ramp, Some(Ramp::By(3e3)));
        let of_y = motion.rows.iter().find(|(row, _)| row.stress[1] != 0.0).unwrap();
        assert_eq!((of_y.1.value, of_y.1.ramp), (Some(2e4), None));
        assert!(motion.has_ramp() && motion.moves(0, 0) && !motion.moves(0, 1));
    }
}

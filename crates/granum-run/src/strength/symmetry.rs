//! The axis about which a test is axisymmetric, and which stages keep the volume, as their controls say.

use granum_core::geometry::Matrix;
use granum_dem::loading::{Constraint, Control, Drive, Measure, Ramp, Stage, Target};

/// The axis (0 for x) about which all stages of a test deform the sample alike; of several the first, which is x for an isotropic
/// test. `None` for a general test, such as simple shear, plane strain or a true triaxial test.
///
/// A control is axisymmetric if it stays the same when the other two axes change places, or if it forces their strains to be
/// equal, and strains no component of shear.
///
/// ```
/// use granum_io::Case;
/// use granum_run::strength::symmetry::axis;
///
/// let of = |path: &str| axis(&Case::parse(&format!("[[stage]]\npath = '{path}'\n"), "case").unwrap().test_stages());
/// assert_eq!((of("drained-triaxial"), of("isotropic")), (Some(0), Some(0)));
/// assert_eq!((of("plane-strain"), of("simple-shear")), (None, None));
/// ```
pub fn axis(stages: &[Stage]) -> Option<usize> {
    (0..3).find(|axis| {
        stages.iter().filter(|stage| !stage.is_mark()).all(|stage| is_axisymmetric(&stage.control, *axis))
    })
}

/// The target of the mean stress of a test like that of Antony, Zhou and Wang (2006), which is what the section `[shear]` of a case
/// stands for: one stage that strains axis x at constant mean stress while the other two axes move alike, and that spaces its states
/// by the deviator strain `eps_1 - eps_3`. `None` for any other test.
///
/// ```
/// use granum_io::Case;
/// use granum_run::strength::symmetry::shear_at_constant_p;
///
/// let of = |text: &str| shear_at_constant_p(&Case::parse(text, "case").unwrap().test_stages()).map(|target| target.value);
/// assert_eq!(of("shear.mean_stress = '50 kPa'"), Some(Some(5e4)));
/// assert_eq!(of("[[stage]]\npath = 'drained-triaxial'\n"), None);
/// ```
pub fn shear_at_constant_p(stages: &[Stage]) -> Option<Target> {
    let [stage] = stages else { return None };
    let control = &stage.control;
    let is_like = stage.record.measure == Measure::AxialDeviatorStrain
        && matches!(control.components[0], Drive::Rate(rate) if rate != 0.0)
        && is_axisymmetric(control, 0);
    let of_p = |constraint: &&Constraint| {
        let [x, y, z, shear @ ..] = constraint.stress;
        x != 0.0 && x == y && y == z && shear == [0.0; 3] && constraint.strain == [0.0; 6]
    };
    let target = control.constraints.iter().flatten().find(of_p)?.target;
    (is_like && target.rate == 0.0 && target.ramp.is_none()).then_some(target)
}

/// Deviator stress of a triaxial test, Pa: the stress along its axis less the mean of the two lateral ones, compression positive.
pub fn axial_deviator(stress: &Matrix, axis: usize) -> f64 {
    let [b, c] = others(axis);
    stress[axis.min(2)][axis.min(2)] - 0.5 * (stress[b][b] + stress[c][c])
}

/// True if a stage treats all three axes alike, as an isotropic compression does.
pub fn is_isotropic(stage: &Stage) -> bool {
    (0..3).all(|axis| is_axisymmetric(&stage.control, axis))
}

/// True if axis x alone is strained.
pub fn is_oedometric(stage: &Stage) -> bool {
    let [x, others @ ..] = &stage.control.components;
    !matches!(x, Drive::Fixed | Drive::Free) && others.iter().all(|drive| *drive == Drive::Fixed)
}

/// The axis along which a stage compresses a sample without lateral stress: the two other stresses are held at zero.
pub fn unconfined_axis(stage: &Stage) -> Option<usize> {
    let drives = &stage.control.components;
    let is_zero = |k: &usize| matches!(drives[*k], Drive::Stress(target) if target == Target::held(0.0));
    let compresses = |k: usize| matches!(drives[k], Drive::Rate(rate) if rate > 0.0);
    (0..3).find(|axis| compresses(*axis) && others(*axis).iter().all(is_zero))
}

/// True if every normal stress of a stage is brought to zero and held there.
pub(super) fn takes_stress_off(stage: &Stage) -> bool {
    let to_zero = |drive: &Drive| match drive {
        Drive::Stress(target) => *target == Target::held(0.0) || target.ramp == Some(Ramp::To(0.0)),
        _ => false,
    };
    stage.control.components[..3].iter().all(to_zero)
}

/// True if a drive strains its component or changes its stress.
pub fn moves(drive: Drive) -> bool {
    match drive {
        Drive::Rate(rate) => rate != 0.0,
        Drive::Ramp(ramp) => ramp != Ramp::By(0.0),
        Drive::Stress(target) => target.rate != 0.0 || target.ramp.is_some(),
        Drive::Fixed | Drive::Free => false,
    }
}

/// True if a stage strains the sample or changes a stress.
pub fn is_driven(stage: &Stage) -> bool {
    let changes = |of: &Constraint| of.target.rate != 0.0 || of.target.ramp.is_some();
    let control = &stage.control;
    stage.turns.is_some()
        || control.components.iter().any(|drive| moves(*drive))
        || control.constraints.iter().flatten().any(changes)
}

/// True if a control keeps the volume of a sample, or lets it change only as much as the pore fluid is compressed.
pub fn keeps_volume(control: &Control) -> bool {
    let by_rates = control.components[..3].iter().try_fold(0.0, |sum, drive| match drive {
        Drive::Fixed => Some(sum),
        Drive::Rate(rate) => Some(sum + rate),
        _ => None,
    });
    let kept = |c: &Constraint| c.strain[..3] == [1.0; 3] && c.stress == [0.0; 6] && c.target.rate == 0.0;
    let with_fluid =
        |c: &Constraint| c.strain[0] > 0.0 && c.strain[..3] == [c.strain[0]; 3] && c.stress != [0.0; 6];
    let free = control.constraints.iter().flatten().all(|constraint| constraint.stress == [0.0; 6]);
    by_rates.is_some_and(|sum| free && f64::abs(sum) < 1e-12)
        || control.constraints.iter().flatten().any(|c| kept(c) || with_fluid(c))
}

fn is_axisymmetric(control: &Control, axis: usize) -> bool {
    let [b, c] = others(axis);
    let drives = &control.components;
    let sheared = drives[3..].iter().any(|drive| moves(*drive) || *drive == Drive::Free);
    if sheared || drives[b] != drives[c] {
        return false;
    }
    let all: Vec<Constraint> = control.constraints.iter().flatten().copied().collect();
    let normal = |of: &Constraint| of.strain[3..] == [0.0; 3] && of.stress[3..] == [0.0; 3];
    let equal_strains = |of: &Constraint| {
        of.stress == [0.0; 6]
            && of.strain[b] != 0.0
            && is_difference(&of.strain, b, c)
            && of.target.rate == 0.0
    };
    all.iter().all(normal)
        && (all.iter().any(equal_strains)
            || all.iter().all(|of| all.contains(&swapped(of, b, c)) || is_zero_difference(of, b, c)))
}

/// The other two axes.
pub(super) fn others(axis: usize) -> [usize; 2] {
    [[1, 2], [0, 2], [0, 1]][axis.min(2)]
}

/// A constraint after two axes have changed places.
fn swapped(of: &Constraint, b: usize, c: usize) -> Constraint {
    let mut other = *of;
    other.strain.swap(b, c);
    other.stress.swap(b, c);
    if let Some(moves) = &mut other.moves {
        moves.swap(b, c);
    }
    other
}

/// True for weights of the difference of two axes alone.
fn is_difference(weights: &[f64; 6], b: usize, c: usize) -> bool {
    weights
        .iter()
        .enumerate()
        .all(|(k, weight)| if k == b { *weight == -weights[c] } else { k == c || *weight == 0.0 })
}

/// True for a constraint that holds the difference of two axes at zero.
fn is_zero_difference(of: &Constraint, b: usize, c: usize) -> bool {
    let target = of.target;
    let held = target.rate == 0.0 && target.ramp.is_none() && target.value.is_none_or(|value| value == 0.0);
    held && is_difference(&of.strain, b, c) && is_difference(&of.stress, b, c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_io::Case;

    fn stages(path: &str, more: &str) -> Vec<Stage> {
        Case::parse(&format!("[[stage]]\npath = \"{path}\"\n{more}"), "case.toml").unwrap().test_stages()
    }

    #[test]
    fn triaxial_paths_have_the_axis_x_and_general_ones_none() {
        for (path, more) in [
            ("drained-triaxial", ""),
            ("drained-triaxial", "axial_strain = -0.1\nlateral_stress = 1e5\n"),
            ("undrained-triaxial", "mean_stress = 1e5\n"),
            ("undrained-triaxial", "fluid_modulus = 1e8\n"),
            ("constant-p", ""),
            ("isotropic", "unloading_stress = 1e4\n"),
            ("oedometer", ""),
            ("cyclic", ""),
            ("cyclic", "stress_amplitude = 1e4\n"),
            ("cyclic", "drainage = \"drained\"\nstress_amplitude = 1e4\n"),
            ("unload-reload", ""),
            ("probes", ""),
            ("proportional", ""),
            ("proportional", "ratios_of = \"stress\"\n"),
            ("constant-p-and-b", "b = 0.0\n"),
        ] {
            assert_eq!(axis(&stages(path, more)), Some(0), "{path} {more}");
        }
        for (path, more) in [
            ("plane-strain", ""),
            ("simple-shear", ""),
            ("simple-shear-constant-volume", ""),
            ("constant-p-and-b", ""),
            ("proportional", "ratio_z = 0.3\n"),
            ("probes", "around = \"components\"\n"),
        ] {
            assert_eq!(axis(&stages(path, more)), None, "{path} {more}");
        }
        // At b = 1 the stresses along x and y are equal, but the strain along x alone is given.
        assert_eq!(axis(&stages("constant-p-and-b", "b = 1.0\n")), None);
        assert_eq!(axis(&Case::default().test_stages()), Some(0));
        let both = [stages("drained-triaxial", ""), stages("simple-shear", "")].concat();
        assert_eq!(axis(&both), None);
    }

    #[test]
    fn stages_are_isotropic_oedometric_or_of_constant_volume() {
        assert!(is_isotropic(&stages("isotropic", "")[0]));
        assert!(!is_isotropic(&stages("drained-triaxial", "")[0]));
        assert!(is_oedometric(&stages("oedometer", "")[0]) && !is_oedometric(&stages("isotropic", "")[0]));
        let volume = |path: &str, more: &str| keeps_volume(&stages(path, more).last().unwrap().control);
        assert!(volume("undrained-triaxial", "") && volume("undrained-triaxial", "fluid_modulus = 1e8\n"));
        assert!(volume("cyclic", "") && volume("simple-shear-constant-volume", ""));
        assert!(!volume("drained-triaxial", "") && !volume("constant-p", "") && !volume("simple-shear", ""));
    }
}

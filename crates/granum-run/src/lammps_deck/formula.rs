//! Numbers and formulas in the language of LAMMPS's variables.

use granum_dem::loading::Measure;

/// A number as LAMMPS reads it. There is no minus zero.
pub(super) fn number(value: f64) -> String {
    format!("{:?}", value + 0.0)
}

/// A number as a factor or term: in brackets where it is negative.
pub(super) fn term(value: f64) -> String {
    let text = number(value);
    if value < 0.0 { format!("({text})") } else { text }
}

/// A weighted sum; terms of weight zero are left out, and a factor of one is not written.
pub(super) fn sum<'a>(terms: impl IntoIterator<Item = (f64, &'a str)>) -> String {
    let mut out = String::new();
    for (weight, of) in terms.into_iter().filter(|(weight, _)| *weight != 0.0) {
        let sign = if weight < 0.0 {
            "-"
        } else if out.is_empty() {
            ""
        } else {
            "+"
        };
        out += sign;
        if weight.abs() != 1.0 {
            out += &format!("{}*", number(weight.abs()));
        }
        out += of;
    }
    if out.is_empty() { "0".into() } else { out }
}

/// Variables of the six components of stress, in granum's order.
pub(super) const STRESSES: [&str; 6] = ["v_s11", "v_s22", "v_s33", "v_s23", "v_s13", "v_s12"];
/// Variables of the six components of strain, shear strains as angles.
pub(super) const STRAINS: [&str; 6] = ["v_e11", "v_e22", "v_e33", "v_g23", "0", "v_g12"];

/// The variable of a measure; none for one that the deck does not follow.
pub(super) fn of_measure(measure: Measure) -> Option<&'static str> {
    Some(match measure {
        Measure::Time => "v_lasted",
        Measure::ArcLength => "v_walked_here",
        Measure::Strain(4) => return None,
        Measure::Strain(k) => STRAINS.get(usize::from(k)).copied()?,
        Measure::AxialDeviatorStrain => "v_deviator_strain",
        Measure::VolumetricStrain => "v_volumetric_strain",
        Measure::DeviatoricStrain => "v_deviatoric_strain",
        Measure::Stress(k) => STRESSES.get(usize::from(k)).copied()?,
        Measure::MeanStress => "v_p",
        Measure::DeviatorStress => "v_von_mises",
        Measure::AxialDeviatorStress => "v_q",
        Measure::StressRatio => "v_von_mises_ratio",
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas_have_no_minus_zero_and_no_double_sign() {
        assert_eq!([number(-0.0), number(1e-8), number(-2.5)], ["0.0", "1e-8", "-2.5"]);
        assert_eq!([term(-2.5), term(2.5)], ["(-2.5)", "2.5"]);
        assert_eq!(sum([(1.0, "a"), (-0.5, "b"), (0.0, "c"), (-0.0, "d")]), "a-0.5*b");
        assert_eq!(sum([(-1.0, "a"), (3.0, "b")]), "-a+3.0*b");
        assert_eq!(sum([(0.0, "a")]), "0");
    }

    #[test]
    fn what_a_box_of_lammps_cannot_show_is_no_measure() {
        let unknown: Vec<&str> = Measure::ALL
            .iter()
            .filter(|(_, _, m)| of_measure(*m).is_none())
            .map(|(name, ..)| *name)
            .collect();
        assert_eq!(unknown, ["zx_strain"]);
    }
}

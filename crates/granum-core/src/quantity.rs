//! Quantities: a number with a unit ("70 GPa", "0.1 mm", "2650 kg/m3"), checked by dimension.
//!
//! A plain number is in SI units. A unit is a product of symbols with whole exponents: `kg/m3`, `kg m^-3`,
//! `J/m2`, `/s`. Decimal prefixes shift the decimal exponent before the number is rounded, so "0.1 mm" is the
//! same double as `1e-4`.

use std::f64::consts::PI;
use std::fmt;

/// Physical dimension: exponents of mass, length, time and plane angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Dimension {
    mass: i8,
    length: i8,
    time: i8,
    angle: i8,
}

const fn dimension(mass: i8, length: i8, time: i8, angle: i8) -> Dimension {
    Dimension { mass, length, time, angle }
}

impl Dimension {
    /// A pure number.
    pub const NUMBER: Dimension = dimension(0, 0, 0, 0);
    /// Plane angle, rad.
    pub const ANGLE: Dimension = dimension(0, 0, 0, 1);
    /// Length, m.
    pub const LENGTH: Dimension = dimension(0, 1, 0, 0);
    /// Mass, kg.
    pub const MASS: Dimension = dimension(1, 0, 0, 0);
    /// Time, s.
    pub const TIME: Dimension = dimension(0, 0, 1, 0);
    /// Rate, 1/s.
    pub const RATE: Dimension = dimension(0, 0, -1, 0);
    /// Velocity, m/s.
    pub const VELOCITY: Dimension = dimension(0, 1, -1, 0);
    /// Force, N.
    pub const FORCE: Dimension = dimension(1, 1, -2, 0);
    /// Stress, pressure or modulus, Pa.
    pub const STRESS: Dimension = dimension(1, -1, -2, 0);
    /// Rate of a stress, Pa/s.
    pub const STRESS_RATE: Dimension = dimension(1, -1, -3, 0);
    /// Density, kg/m3.
    pub const DENSITY: Dimension = dimension(1, -3, 0, 0);
    /// Energy, J.
    pub const ENERGY: Dimension = dimension(1, 2, -2, 0);
    /// Energy per area (interface energy), J/m2.
    pub const SURFACE_ENERGY: Dimension = dimension(1, 0, -2, 0);

    /// The dimension with given powers of mass, length and time.
    pub const fn of_powers([mass, length, time]: [i8; 3]) -> Dimension {
        dimension(mass, length, time, 0)
    }

    /// Name and example units of the dimensions that granum uses.
    const KNOWN: [(Dimension, &'static str, &'static str); 13] = [
        (Self::NUMBER, "a pure number", ""),
        (Self::ANGLE, "an angle", "rad or deg"),
        (Self::LENGTH, "a length", "m, mm or um"),
        (Self::MASS, "a mass", "kg, g or mg"),
        (Self::TIME, "a time", "s, ms or us"),
        (Self::RATE, "a rate", "1/s"),
        (Self::VELOCITY, "a velocity", "m/s or mm/s"),
        (Self::FORCE, "a force", "N, mN or uN"),
        (Self::STRESS_RATE, "a rate of stress", "Pa/s or kPa/s"),
        (Self::STRESS, "a stress", "Pa, kPa, MPa or GPa"),
        (Self::DENSITY, "a density", "kg/m3 or g/cm3"),
        (Self::ENERGY, "an energy", "J or uJ"),
        (Self::SURFACE_ENERGY, "an energy per area", "J/m2 or mJ/m2"),
    ];

    /// Its description with an article: "a stress".
    pub fn name(self) -> String {
        match Self::KNOWN.iter().find(|known| known.0 == self) {
            Some(known) => known.1.to_string(),
            None => format!("a quantity in {self}"),
        }
    }

    /// Suitable units, e.g. "Pa, kPa, MPa or GPa"; empty for a pure number.
    pub fn units(self) -> String {
        match Self::KNOWN.iter().find(|known| known.0 == self) {
            Some(known) => known.2.to_string(),
            None => self.to_string(),
        }
    }

    /// The SI unit, e.g. "Pa"; empty for a pure number.
    pub fn si_unit(self) -> String {
        let units = self.units();
        units.split([',', ' ']).next().unwrap_or_default().to_string()
    }

    fn times(self, other: Dimension, power: i8) -> Option<Dimension> {
        let combine = |a: i8, b: i8| a.checked_add(b.checked_mul(power)?);
        Some(dimension(
            combine(self.mass, other.mass)?,
            combine(self.length, other.length)?,
            combine(self.time, other.time)?,
            combine(self.angle, other.angle)?,
        ))
    }
}

impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut first = true;
        for (symbol, power) in [("kg", self.mass), ("m", self.length), ("s", self.time), ("rad", self.angle)]
        {
            if power == 0 {
                continue;
            }
            write!(f, "{}{symbol}", if first { "" } else { " " })?;
            if power != 1 {
                write!(f, "{power}")?;
            }
            first = false;
        }
        Ok(())
    }
}

/// A unit: dimension, decimal exponent and a factor that is not a power of ten.
#[derive(Clone, Copy)]
struct Unit {
    dimension: Dimension,
    exponent: i32,
    factor: f64,
}

/// Symbol, dimension, decimal exponent, factor, and whether prefixes are permitted.
const SYMBOLS: [(&str, Dimension, i32, f64, bool); 16] = [
    ("1", Dimension::NUMBER, 0, 1.0, false),
    ("%", Dimension::NUMBER, -2, 1.0, false),
    ("m", Dimension::LENGTH, 0, 1.0, true),
    ("g", Dimension::MASS, -3, 1.0, true),
    ("t", Dimension::MASS, 3, 1.0, false),
    ("s", Dimension::TIME, 0, 1.0, true),
    ("min", Dimension::TIME, 0, 60.0, false),
    ("h", Dimension::TIME, 0, 3600.0, false),
    ("rad", Dimension::ANGLE, 0, 1.0, true),
    ("deg", Dimension::ANGLE, 0, PI / 180.0, false),
    ("°", Dimension::ANGLE, 0, PI / 180.0, false),
    ("N", Dimension::FORCE, 0, 1.0, true),
    ("Pa", Dimension::STRESS, 0, 1.0, true),
    ("bar", Dimension::STRESS, 5, 1.0, true),
    ("J", Dimension::ENERGY, 0, 1.0, true),
    ("Hz", Dimension::RATE, 0, 1.0, true),
];

const PREFIXES: [(&str, i32); 12] = [
    ("n", -9),
    ("u", -6),
    ("µ", -6),
    ("μ", -6),
    ("m", -3),
    ("c", -2),
    ("d", -1),
    ("h", 2),
    ("k", 3),
    ("M", 6),
    ("G", 9),
    ("T", 12),
];

fn symbol(text: &str) -> Option<Unit> {
    let exact = |name: &str, shift: i32| {
        SYMBOLS.iter().find(|s| s.0 == name && (shift == 0 || s.4)).map(|s| Unit {
            dimension: s.1,
            exponent: s.2 + shift,
            factor: s.3,
        })
    };
    exact(text, 0)
        .or_else(|| PREFIXES.iter().find_map(|(prefix, shift)| exact(text.strip_prefix(prefix)?, *shift)))
}

/// Reads a unit such as `kg/m3`, `J/m^2`, `m s-1` or `/s`.
fn unit(text: &str) -> Result<Unit, String> {
    let mut total = Unit { dimension: Dimension::NUMBER, exponent: 0, factor: 1.0 };
    let text = text.replace('²', "2").replace('³', "3");
    let mut rest = text.trim();
    let mut divided = false;
    while !rest.is_empty() {
        let divides = rest.starts_with('/');
        if divided && !divides {
            return Err(format!(
                "has the ambiguous unit {:?} (write exponents, as \"kg m-1 s-2\")",
                text.trim()
            ));
        }
        divided = divides;
        rest = rest.trim_start_matches('/').trim_start();
        let length = rest.find(['/', ' ', '*', '·']).unwrap_or(rest.len());
        let (factor, after) = rest.split_at(length);
        rest = after.trim_start_matches([' ', '*', '·']);
        let (name, power) = split_power(factor);
        let known = symbol(name).ok_or_else(|| match factor {
            "" => format!("has the incomplete unit {:?}", text.trim()),
            _ => format!("has the unknown unit {factor:?}"),
        })?;
        let power = power.filter(|p| (-4..=4).contains(p)).ok_or_else(|| {
            format!("has the unit {factor:?}, whose exponent must be a whole number from -4 to 4")
        })? * if divides { -1 } else { 1 };
        total.dimension = total
            .dimension
            .times(known.dimension, power)
            .ok_or_else(|| format!("has the unit {:?}, whose exponents are too large", text.trim()))?;
        total.exponent += known.exponent * i32::from(power);
        total.factor *= granum_simd::integer_power(known.factor, i32::from(power));
    }
    Ok(total)
}

/// True if a unit can be read, whatever its dimension: `kN/m2`, but not `psi`. An empty text is the unit of a pure number.
pub fn is_unit(text: &str) -> bool {
    unit(text).is_ok()
}

/// Splits `m3` and `m^3` into `m` and 3.
fn split_power(factor: &str) -> (&str, Option<i8>) {
    if factor == "1" {
        return (factor, Some(1));
    }
    match factor.find(|c: char| c.is_ascii_digit() || matches!(c, '^' | '-' | '+')) {
        None => (factor, Some(1)),
        Some(at) => (&factor[..at], factor[at..].trim_start_matches('^').parse().ok()),
    }
}

/// Splits "70 GPa" into number and unit.
fn split_number(text: &str) -> (&str, &str) {
    let digits = |from: usize| from + text[from..].bytes().take_while(u8::is_ascii_digit).count();
    let sign = |from: usize| from + usize::from(text[from..].starts_with(['+', '-']));
    let mut end = digits(sign(0));
    if text[end..].starts_with('.') {
        end = digits(end + 1);
    }
    if text[end..].starts_with(['e', 'E']) && digits(sign(end + 1)) > sign(end + 1) {
        end = digits(sign(end + 1));
    }
    text.split_at(if text[..end].parse::<f64>().is_ok() { end } else { 0 })
}

/// Shifts the decimal exponent before rounding, so that "0.1 mm" gives exactly `1e-4`.
fn shift_decimal(number: &str, shift: i32) -> Option<f64> {
    let (mantissa, exponent) = match number.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, exponent.parse::<i32>().ok()?),
        None => (number, 0),
    };
    format!("{mantissa}e{}", exponent.checked_add(shift)?).parse().ok()
}

/// Reads a quantity of a given dimension in SI units. A number without a unit is in SI units.
///
/// # Errors
/// A sentence that states what the text is and which units are possible.
pub fn parse_quantity(text: &str, wanted: Dimension) -> Result<f64, String> {
    let text = text.trim();
    let (number, rest) = split_number(text);
    if number.is_empty() {
        let what = if text.parse::<f64>().is_ok() { "is not finite" } else { "does not start with a number" };
        return Err(format!("{what}; {}", expected(wanted)));
    }
    let number_error = || format!("is not a number in the range of a double; {}", expected(wanted));
    let value = if rest.trim().is_empty() {
        number.parse().map_err(|_| number_error())?
    } else {
        let unit = unit(rest).map_err(|why| format!("{why}; {}", expected(wanted)))?;
        if unit.dimension != wanted {
            return Err(format!("is {}; {}", unit.dimension.name(), expected(wanted)));
        }
        shift_decimal(number, unit.exponent).ok_or_else(number_error)? * unit.factor
    };
    if value.is_finite() { Ok(value) } else { Err(number_error()) }
}

/// "it must be a stress (Pa, kPa, MPa or GPa) or a number in Pa".
fn expected(wanted: Dimension) -> String {
    if wanted == Dimension::NUMBER {
        return "it must be a pure number without unit".into();
    }
    format!("it must be {} ({}) or a number in {}", wanted.name(), wanted.units(), wanted.si_unit())
}

/// Shortest text that is read back as the same double; in plain notation where that is short, otherwise in scientific
/// notation.
pub fn format_number(value: f64) -> String {
    let size = value.abs();
    if value.is_nan() {
        "nan".into()
    } else if size == 0.0 || value.is_infinite() || (1e-3..1e7).contains(&size) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn reads_the_units_of_the_paper_exactly() {
        for (text, wanted, value) in [
            ("70 GPa", Dimension::STRESS, 70e9),
            ("0.1 mm", Dimension::LENGTH, 1e-4),
            ("0.3 um", Dimension::LENGTH, 0.3e-6),
            ("50µm", Dimension::LENGTH, 50e-6),
            ("20 kPa", Dimension::STRESS, 20e3),
            ("2650 kg/m3", Dimension::DENSITY, 2650.0),
            ("2.65 g/cm^3", Dimension::DENSITY, 2650.0),
            ("2650 kg m-3", Dimension::DENSITY, 2650.0),
            ("0.6 J/m2", Dimension::SURFACE_ENERGY, 0.6),
            ("600 mJ/m²", Dimension::SURFACE_ENERGY, 0.6),
            ("0.6 N/m", Dimension::SURFACE_ENERGY, 0.6),
            ("1e-5 /s", Dimension::RATE, 1e-5),
            ("10 1/s", Dimension::RATE, 10.0),
            ("10 s^-1", Dimension::RATE, 10.0),
            ("30 deg", Dimension::ANGLE, PI / 6.0),
            ("61 %", Dimension::NUMBER, 0.61),
            ("1 min", Dimension::TIME, 60.0),
            ("2 bar", Dimension::STRESS, 2e5),
            ("5 N/mm2", Dimension::STRESS, 5e6),
            ("-1.5e3 Pa", Dimension::STRESS, -1500.0),
            ("7e10", Dimension::STRESS, 7e10),
            ("3 kg m/s2", Dimension::FORCE, 3.0),
        ] {
            assert_eq!(parse_quantity(text, wanted), Ok(value), "{text}");
        }
    }

    #[test]
    fn a_wrong_dimension_says_what_units_would_do() {
        let error = parse_quantity("70 kg", Dimension::STRESS).unwrap_err();
        assert_eq!(error, "is a mass; it must be a stress (Pa, kPa, MPa or GPa) or a number in Pa");
        let error = parse_quantity("30 deg", Dimension::NUMBER).unwrap_err();
        assert_eq!(error, "is an angle; it must be a pure number without unit");
        let error = parse_quantity("3 Pa s", Dimension::STRESS).unwrap_err();
        assert!(error.starts_with("is a quantity in kg m-1 s-1"), "{error}");
    }

    #[test]
    fn units_are_known_by_themselves() {
        for text in ["", "%", "kPa", "kN/m^2", "kg m^-1 s^-2", "1/s"] {
            assert!(is_unit(text), "{text}");
        }
        for text in ["psi", "kPaa", "m99", "m/", "kg/m s"] {
            assert!(!is_unit(text), "{text}");
        }
    }

    #[test]
    fn nonsense_is_refused() {
        for text in
            ["", "GPa", "70 GPaa", "70 G", "1 2", "70 GPa/", "nan", "inf", "1e999", "--3", "3 m99", "3 m/s/s"]
        {
            assert!(parse_quantity(text, Dimension::STRESS).is_err(), "{text}");
        }
    }

    proptest! {
        #[test]
        fn any_text_gives_a_value_or_a_message(text in "\\PC{0,30}") {
            for wanted in [Dimension::STRESS, Dimension::NUMBER, Dimension::ANGLE] {
                if let Ok(value) = parse_quantity(&text, wanted) {
                    prop_assert!(value.is_finite());
                }
            }
        }

        #[test]
        fn numbers_read_back_as_the_same_bits(bits in any::<u64>()) {
            let value = f64::from_bits(bits);
            prop_assume!(value.is_finite());
            let text = format_number(value);
            prop_assert_eq!(text.parse::<f64>().unwrap().to_bits(), bits);
            prop_assert_eq!(parse_quantity(&text, Dimension::LENGTH).unwrap().to_bits(), bits);
        }
    }
}

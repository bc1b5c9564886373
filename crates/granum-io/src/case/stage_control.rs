//! Reading a stage with an explicit control: drives of the components, constraints, speed, ends.

use granum_dem::loading::{Control, Drive, Kinematics, SERVO_LIMIT, Speed, Stage, Start, Until};
use granum_dem::servo::COMPONENTS;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::case_stage::CaseStage;
use super::stage_read::TableReader;
use super::stage_values::{
    Mistake, Node, Parsed, boolean, constraint, drive, end, number, record, text, turns,
};
use super::suggestion::paths_with;
use granum_core::quantity::Dimension;

/// Keys of a stage with an explicit control, with their meaning.
pub(super) const STAGE_KEYS: &[[&str; 2]] = &[
    ["name", "A name, for the reader."],
    [
        "inertial_number",
        "Speed: the strain rate that counts as 1, as an inertial number at the mean stress at the start of the stage.",
    ],
    ["strain_rate", "Speed, instead of inertial_number: the strain rate that counts as 1."],
    [
        "xx",
        "Control of this component: \"fixed\", \"free\", { rate = ... }, { stress = ... }, { stress_rate = ... }, or a \
         ramp { strain_to = ... }, { strain_by = ... }, { stress_to = ... }, { stress_by = ... }.",
    ],
    ["yy", "As xx."],
    ["zz", "As xx."],
    ["yz", "As xx; shear strains are angles."],
    ["zx", "As xx."],
    ["xy", "As xx."],
    ["constraint", "Combinations of stresses or of strain rates that are controlled, as a list of tables."],
    ["kinematics", "How shear rates move the cell: \"pure-shear\" or \"simple-shear\"."],
    [
        "servo_limit",
        "Bound on the strain rate that the servo adds for one controlled stress, as a multiple of the rate that counts \
         as 1.",
    ],
    ["servo_response", "Time constant of the servo, in time steps."],
    ["turns", "Turning points of a cyclic stage: { measure = ..., high = ..., low = ... }."],
    [
        "until",
        "End conditions, the first of which to be met ends the stage: measures with values, reversals, ramp_over, \
         pore_pressure_ratio, double_amplitude, unbalanced_force, critical_state.",
    ],
    ["most_arc_length", "Arc length of strain after which the stage ends in any case."],
    [
        "record",
        "The states that are recorded: { measure = ..., every = ... }, { ..., states = ..., end = ... } or { ..., at = \
         [...] }.",
    ],
    ["settling", "True if velocities are damped globally, so that the sample comes to rest."],
    ["resets", "True if strain, time and energy count from the start of this stage."],
    [
        "density_scaling",
        "Factor on the density of every grain in this stage; only together with strain_rate.",
    ],
    [
        "start",
        "Initial state. \"here\": where the stage before ended; \"kept\": the same, and later stages can go back to \
         it; \"back\": the state that was kept last.",
    ],
];

impl TableReader<'_, '_> {
    /// A stage with an explicit control.
    pub(super) fn written_out(mut self, table: &DeTable<'_>) -> Option<CaseStage> {
        for (key, _) in table {
            if !STAGE_KEYS.iter().any(|[known, _]| *known == key.get_ref()) {
                let names = STAGE_KEYS.iter().map(|[known, _]| *known).chain(["path"]);
                self.unknown(key.get_ref(), key.span(), names);
                let paths = paths_with(self.reader.reading.vocabulary.paths(), key.get_ref());
                if let (Some(paths), Some(error)) = (paths, self.reader.errors.last_mut()) {
                    error.help = Some(format!("{} belongs to a stage with path = {paths}", key.get_ref()));
                }
            }
        }
        self.records_nothing(table, &["record"]);
        let mut control = self.control(table);
        let mut until = self.ends(table);
        match table.get("until") {
            Some(_) => {}
            None if control.has_ramp() => until.push(Until::RampOver),
            None => {
                let span = table.values().next().map_or(0..0, Spanned::span);
                let message = format!("{} has no until, so that it would not end", self.name);
                self.reader.error(span, message).help =
                    Some("add one, e.g. until = { xx_strain = 0.1, arc_length = 0.5 }".into());
            }
        }
        let moving = control.is_strained() || control.moves_a_stress();
        control.servo_limit = self
            .key(table, "servo_limit", |value| number(value, Dimension::NUMBER, [1e-3, 1e6]))
            .unwrap_or(if moving { SERVO_LIMIT } else { 1.0 });
        let response =
            self.key(table, "servo_response", |value| number(value, Dimension::NUMBER, [2.0, 1e4]));
        control.response = response.unwrap_or(control.response);
        let name = self.key(table, "name", text).unwrap_or_else(|| "stage".into());
        let mut stage = Stage::new(name, control, until);
        let most = self.key(table, "most_arc_length", |value| number(value, Dimension::NUMBER, [1e-9, 1e6]));
        stage.most_arc_length = most.or(stage.most_arc_length);
        stage.turns = self.key(table, "turns", turns);
        stage.record = self.key(table, "record", record).unwrap_or(stage.record);
        stage.settling = self.key(table, "settling", boolean).unwrap_or(false);
        stage.resets = self.key(table, "resets", boolean).unwrap_or(false);
        let scaling =
            self.key(table, "density_scaling", |value| number(value, Dimension::NUMBER, [1e-6, 1e24]));
        if let (Some(_), Speed::InertialNumber { .. }, Some(value)) =
            (scaling, stage.control.speed, table.get("density_scaling"))
        {
            let why = "has no effect without strain_rate".to_string();
            let help = Some("add strain_rate, or give inertial_number alone".to_string());
            self.take::<()>("density_scaling", Err(Mistake(value.span(), why, help)));
        }
        stage.density_scaling = scaling.unwrap_or(1.0);
        stage.start = self.key(table, "start", start).unwrap_or_default();
        Some(CaseStage::Control(Box::new(stage)))
    }

    /// The end conditions of a stage, in the order of the file.
    pub(super) fn ends(&mut self, table: &DeTable<'_>) -> Vec<Until> {
        let mut until = Vec::new();
        match table.get("until").map(|value| (value, value.get_ref())) {
            Some((_, DeValue::Table(ends))) => {
                let mut ends: Vec<_> = ends.iter().collect();
                ends.sort_by_key(|(key, _)| key.span().start);
                for (key, value) in ends {
                    let end = end(key.get_ref(), value);
                    until.extend(self.take(&format!("until.{}", key.get_ref()), end));
                }
            }
            Some((value, _)) => {
                let example = "e.g. until = { xx_strain = 0.1 }".to_string();
                self.take::<()>("until", Err(Mistake(value.span(), "is not a table".into(), Some(example))));
            }
            None => {}
        }
        until
    }

    fn control(&mut self, table: &DeTable<'_>) -> Control {
        let mut control = Control::default();
        let inertial = self.key(table, "inertial_number", |v| number(v, Dimension::NUMBER, [1e-8, 0.1]));
        let rate = self.key(table, "strain_rate", |v| number(v, Dimension::RATE, [1e-12, 1e9]));
        if let (Some(_), Some(_), Some(value)) = (inertial, rate, table.get("strain_rate")) {
            let help = Some("keep one of them".to_string());
            let why = "sets the speed, and so does inertial_number".to_string();
            self.take::<()>("strain_rate", Err(Mistake(value.span(), why, help)));
        }
        if let Some(number) = inertial {
            control.speed = Speed::InertialNumber { number, at: None };
        }
        if let Some(rate) = rate {
            control.speed = Speed::StrainRate(rate);
        }
        let mut absolute = false;
        for (k, name) in COMPONENTS.iter().enumerate() {
            let Some((drive, in_rates)) = self.key(table, name, drive) else { continue };
            if in_rates && (inertial.is_some() || rate.is_some() || control.is_strained() && !absolute) {
                let help = Some("give it as a multiple of that, a number without unit".to_string());
                let why =
                    "is an absolute strain rate, but the speed of the stage is already given".to_string();
                let span = table.get(*name).map_or(0..0, Spanned::span);
                self.take::<()>(name, Err(Mistake(span, why, help)));
                continue;
            }
            absolute |= in_rates;
            control.components[k] = drive;
        }
        if absolute {
            in_multiples(&mut control);
        }
        if let Some(DeValue::Array(items)) = table.get("constraint").map(Spanned::get_ref) {
            for (k, item) in items.iter().enumerate() {
                let found = if k < 6 {
                    constraint(item)
                } else {
                    Err(Mistake(item.span(), "is one too many; there are six strain rates".into(), None))
                };
                control.constraints[k.min(5)] = self.take(&format!("constraint.{}", k + 1), found);
            }
        } else if let Some(value) = table.get("constraint") {
            let help = Some("e.g. constraint = [{ stress = [1, 1, 1, 0, 0, 0] }]".to_string());
            self.take::<()>("constraint", Err(Mistake(value.span(), "is not a list of tables".into(), help)));
        }
        let kinematics = self.key(table, "kinematics", |value| match text(value)?.as_str() {
            "pure-shear" => Ok(Kinematics::PureShear),
            "simple-shear" => Ok(Kinematics::SimpleShear),
            _ => {
                let why = "is not known; it must be \"pure-shear\" or \"simple-shear\"";
                Err(Mistake(value.span(), why.into(), None))
            }
        });
        Control { kinematics: kinematics.unwrap_or_default(), ..control }
    }
}

/// Converts strain rates with a unit to multiples of the largest of them.
fn in_multiples(control: &mut Control) {
    let rates = control.components.iter().filter_map(|drive| match drive {
        Drive::Rate(rate) => Some(rate.abs()),
        _ => None,
    });
    let largest = rates.fold(0.0, f64::max);
    if largest > 0.0 {
        control.speed = Speed::StrainRate(largest);
        for drive in &mut control.components {
            if let Drive::Rate(rate) = drive {
                *rate /= largest;
            }
        }
    }
}

fn start(value: &Node<'_>) -> Parsed<Start> {
    match text(value)?.as_str() {
        "here" => Ok(Start::Here),
        "kept" => Ok(Start::Kept),
        "back" => Ok(Start::Back),
        _ => {
            let why = "is not known; it must be \"here\", \"kept\" or \"back\"";
            Err(Mistake(value.span(), why.into(), None))
        }
    }
}

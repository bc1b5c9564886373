//! The drive of the cell in a stage as variables of the script: its speed, its ramps, the servo of each controlled stress, the
//! velocity gradient, and the box that follows it.

use granum_dem::loading::{Control, EASE, RESPONSE, Ramp, SHORTEST_RAMP, Speed, Target, YIELDING};
use granum_dem::servo::Row;

use super::formula::{STRAINS, STRESSES, number, sum};
use super::motion::{Motion, stiffest};

/// Row and column of the entries of the velocity gradient that a box of LAMMPS can follow, with their names.
pub(super) const ENTRIES: [(usize, usize, &str); 5] =
    [(0, 0, "11"), (1, 1, "22"), (2, 2, "33"), (0, 1, "12"), (1, 2, "23")];
pub(super) const AXES: [&str; 3] = ["x", "y", "z"];

/// A tilt of the box that simple shear changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Tilt {
    /// The second edge along x.
    Xy,
    /// The third edge along y.
    Yz,
}

impl Tilt {
    fn name(self) -> &'static str {
        match self {
            Tilt::Xy => "xy",
            Tilt::Yz => "yz",
        }
    }

    /// Its rate of change in a velocity gradient.
    fn rate(self) -> &'static str {
        match self {
            Tilt::Xy => "v_l11*xy+v_l12*ly",
            Tilt::Yz => "v_l22*yz+v_l23*lz",
        }
    }
}

/// The tilts that a stage changes.
pub(super) fn tilts(motion: &Motion) -> impl Iterator<Item = Tilt> {
    let entries = [(0, 1, Tilt::Xy), (1, 2, Tilt::Yz)];
    entries.into_iter().filter(|(r, c, _)| motion.moves(*r, *c)).map(|(_, _, tilt)| tilt)
}

pub(super) fn is_sheared(motion: &Motion) -> bool {
    tilts(motion).next().is_some()
}

/// The clock of a stage, and the value of each controlled stress: formulas on which the numbers that a stage begins with depend.
pub(super) fn values(motion: &Motion) -> String {
    let mut text = String::from(
        "variable elapsed equal v_now-v_leg_at\nvariable lasted equal v_now-v_began_at\n\
         variable walked_here equal v_arc-v_began_arc\n",
    );
    for (k, (row, _)) in motion.rows.iter().enumerate() {
        let stresses = row.stress.iter().map(|weight| weight / row.divisor).zip(STRESSES);
        let strains = row.strain.iter().copied().zip(STRAINS);
        text += &format!("variable value{} equal {}\n", k + 1, sum(stresses.chain(strains)));
    }
    text
}

/// The numbers of a stage, taken where it begins: speed, time in which rates grow, targets, and how long its ramps take.
pub(super) fn constants(control: &Control, motion: &Motion, unit_rate: f64) -> String {
    let speed = match control.speed {
        Speed::StrainRate(rate) => number(rate),
        Speed::InertialNumber { number: inertial, at } => {
            let p = at.map_or_else(|| "v_p".to_string(), number);
            format!("{}*sqrt({p})", number(inertial * unit_rate))
        }
    };
    let ease =
        if control.eases { format!("$({}/sqrt(v_p))", number(EASE / unit_rate)) } else { "0".to_string() };
    let mut text = format!("variable speed equal $({speed})\nvariable ease equal {ease}\n");
    for (k, (row, _)) in motion.rows.iter().enumerate() {
        let n = k + 1;
        let target = if row.target.is_nan() { format!("$(v_value{n})") } else { number(row.target) };
        text += &format!("variable target{n} equal {target}\n");
    }
    if motion.has_ramp() {
        text += &duration(motion, unit_rate);
    }
    for (k, (_, target)) in motion.rows.iter().enumerate() {
        let n = k + 1;
        match target.ramp {
            Some(ramp) => {
                text += &format!(
                    "variable rate{n} equal $(({})/v_ramp)\n",
                    change(ramp, &format!("v_target{n}"))
                );
            }
            None if target.rate != 0.0 => {
                text += &format!("variable rate{n} equal {}\n", number(target.rate));
            }
            None => {}
        }
    }
    for (k, ramp) in motion.ramps.iter().enumerate() {
        let change = change(ramp.ramp, STRAINS[ramp.component]);
        text += &format!("variable pace{} equal $(({change})/v_ramp)\n", k + 1);
    }
    text
}

fn change(ramp: Ramp, from: &str) -> String {
    match ramp {
        Ramp::To(value) => format!("{}-{from}", number(value)),
        Ramp::By(change) => number(change),
    }
}

/// How long the ramps take, as in granum: the longest of the fastest strain at the speed of the stage, of the strain that a change of
/// stress is estimated to need, and of the shortest quasi-static change; and when they are over, since rates grow at the beginning.
fn duration(motion: &Motion, unit_rate: f64) -> String {
    let least = format!("{}/sqrt(v_p)", number(SHORTEST_RAMP / unit_rate));
    let mut times = Vec::new();
    for (k, (row, target)) in motion.rows.iter().enumerate() {
        let Some(ramp) = target.ramp else { continue };
        let [share, own] = stiffest(row);
        let stiffness = if own > 0.0 {
            // Of a combination with strains the stiffer of the two parts counts.
            let [share, own] = [number(share), number(own)];
            format!("(({share}*v_modulus>{own})*{share}*v_modulus+({share}*v_modulus<={own})*{own})")
        } else {
            format!("({}*v_modulus)", number(share))
        };
        let change = change(ramp, &format!("v_target{}", k + 1));
        times.push(format!("abs({change})/({}*{stiffness}*v_speed)", number(YIELDING)));
    }
    for ramp in &motion.ramps {
        times.push(format!("abs({})/v_speed", change(ramp.ramp, STRAINS[ramp.component])));
    }
    let mut text = format!("variable ramp equal $({least})\n");
    for time in times {
        text += &format!(
            "variable other equal $({time})\nvariable ramp equal $((v_other>v_ramp)*v_other+(v_other<=v_ramp)*v_ramp)\n"
        );
    }
    text + "variable ramp_end equal $(v_ramp+0.5*v_ease)\n"
}

/// Variables `share` of the full rates at which the cell is strained, and `progress`, the time at full rates.
pub(super) fn shares(eases: bool) -> &'static str {
    if eases {
        "variable share equal (v_elapsed<v_ease)*v_elapsed/v_ease+(v_elapsed>=v_ease)\n\
         variable progress equal (v_elapsed<v_ease)*0.5*v_elapsed^2/v_ease+(v_elapsed>=v_ease)*(v_elapsed-0.5*v_ease)\n"
    } else {
        "variable share equal 1\nvariable progress equal v_elapsed\n"
    }
}

/// True if a target changes.
fn is_moving(target: &Target) -> bool {
    target.rate != 0.0 || target.ramp.is_some()
}

/// For each controlled stress the strain rate that the servo adds, as variable `out`, and with `judged` the sum of the squares of its error.
pub(super) fn servo(motion: &Motion, limit: f64, turns: bool, judged: bool) -> String {
    let (mut text, mut growing, mut squares) = (String::new(), String::new(), String::new());
    let all = motion.rows.len();
    for (k, (row, target)) in motion.rows.iter().enumerate() {
        let n = k + 1;
        let stiffness = format!("({}*v_modulus)", number(row.stiffness));
        let direction = if turns { "v_direction*" } else { "" };
        let (aim, forward) = match is_moving(target) {
            true => (
                format!("v_target{n}+{direction}v_rate{n}*v_progress"),
                format!("+v_share*{direction}v_rate{n}/{stiffness}"),
            ),
            false => (format!("v_target{n}"), String::new()),
        };
        let limit = format!("{}*v_speed", number(limit));
        text += &format!(
            "\n# Controlled stress {n}.\n\
             variable aim{n} equal {aim}\n\
             variable error{n} equal v_aim{n}-v_value{n}\n\
             variable integral{n} equal v_before{n}+{integral}*(step-v_counted+1)\n\
             variable wanted{n} equal (v_error{n}+v_integral{n})/({stiffness}*{response}*dt){forward}\n\
             variable within{n} equal (abs(v_wanted{n})<=({limit}))*(abs(v_error{n})<=0.2*(abs(v_p)+abs(v_target{n})))\n\
             variable grow{n} equal v_within{n}*v_error{n}/{six}\n\
             variable out{n} equal (abs(v_wanted{n})<=({limit}))*v_wanted{n}+(v_wanted{n}>({limit}))*{limit}-(v_wanted{n}<(-{limit}))*{limit}\n",
            integral = entry("integrals", n, all),
            response = RESPONSE,
            six = number(6.0 * RESPONSE),
        );
        if judged {
            text += &format!(
                "variable square{n} equal v_held{n}*(v_error{n}/v_p)^2\n\
                 variable sum{n} equal v_sum_before{n}+{}*(step-v_counted+1)\n",
                entry("errors", n, all)
            );
        }
        growing += &format!(" v_grow{n}");
        squares += &format!(" v_square{n}");
    }
    if all > 0 {
        text += &format!("fix integrals all ave/time 1 1 1{growing} ave running\n");
    }
    if all > 0 && judged {
        text += &format!("fix errors all ave/time 1 1 1{squares} ave running\n");
    }
    text
}

/// The value of a fix with one number for each controlled stress.
fn entry(fix: &str, n: usize, all: usize) -> String {
    if all == 1 { format!("f_{fix}") } else { format!("f_{fix}[{n}]") }
}

/// From its first row on which it is within half a per cent of p of its target, a controlled stress counts as held.
pub(super) fn holds(motion: &Motion) -> String {
    (1..=motion.rows.len())
        .map(|n| {
            format!(
                "if \"$((v_held{n}<0.5)*(abs(v_error{n})<=0.005*v_p)) > 0.5\" then \"variable held{n} equal 1\" \"variable held_since{n} equal $(step)\"\n"
            )
        })
        .collect()
}

/// The velocity gradient, and the box that follows it.
pub(super) fn deformation(motion: &Motion, tilt: Option<Tilt>, turns: bool) -> String {
    let mut text = String::from("\n# Velocity gradient, 1/s, and the lengths that it gives the box.\n");
    let mut all = String::new();
    let share = if turns { "v_share*v_direction*" } else { "v_share*" };
    for (r, c, name) in ENTRIES {
        let base: Vec<(f64, String)> = motion
            .prescribed(r, c)
            .into_iter()
            .map(|(weight, of)| (weight, format!("{share}{of}")))
            .collect();
        let outs: Vec<(f64, String)> = (motion.rows.iter().enumerate())
            .map(|(k, (row, _))| (-row.moves[r][c], format!("v_out{}", k + 1)))
            .collect();
        let terms = base.iter().chain(&outs).map(|(weight, of)| (*weight, of.as_str()));
        text += &format!("variable l{name} equal {}\n", sum(terms));
    }
    for (k, axis) in AXES.into_iter().enumerate().filter(|(k, _)| motion.moves(*k, *k)) {
        let name = ENTRIES[k].2;
        text += &format!(
            "variable rate_{axis} equal v_l{name}*l{axis}\n\
             variable change_{axis} equal l{axis}+v_rate_{axis}*dt-v_from_{axis}\n"
        );
        all += &format!(" {axis} variable v_change_{axis} v_rate_{axis}");
    }
    if let Some(tilt) = tilt {
        let (tilt, rate) = (tilt.name(), tilt.rate());
        text += &format!(
            "variable rate_{tilt} equal {rate}\nvariable change_{tilt} equal {tilt}+v_rate_{tilt}*dt-v_from_{tilt}\n"
        );
        all += &format!(" {tilt} variable v_change_{tilt} v_rate_{tilt}");
    }
    if is_sheared(motion) {
        text += "variable slip12 equal -v_l12*dt\nvariable slip23 equal -v_l23*dt\n\
                 fix angles all ave/time 1 1 1 v_slip12 v_slip23 ave running\n\
                 variable g12 equal v_g12_before+f_angles[1]*(step-v_counted+1)\n\
                 variable g23 equal v_g23_before+f_angles[2]*(step-v_counted+1)\n";
    }
    text += &from_here(motion, tilt);
    if !all.is_empty() {
        text += &format!("fix cell all deform 1{all} remap v units box\n");
    }
    text
}

/// The lengths from which `fix deform` counts: those at the start of each `run`.
pub(super) fn from_here(motion: &Motion, tilt: Option<Tilt>) -> String {
    let lengths = (0..3).filter(|k| motion.moves(*k, *k)).map(|k| (AXES[k], format!("l{}", AXES[k])));
    let tilt = tilt.map(|tilt| (tilt.name(), tilt.name().to_string()));
    lengths.chain(tilt).map(|(name, length)| format!("variable from_{name} equal $({length})\n")).collect()
}

/// The velocity of the homogeneous strain at the full base rates at a place, with numbers of the present, for each axis; "0" where there
/// is none.
pub(super) fn homogeneous(motion: &Motion, turns: bool, place: [&str; 3]) -> [String; 3] {
    let direction = if turns { "v_direction*" } else { "" };
    std::array::from_fn(|r| {
        let parts = (0..3).filter_map(|c| {
            let weights = motion.prescribed(r, c);
            let rate = sum(weights.iter().map(|(weight, of)| (*weight, of.as_str())));
            (rate != "0").then(|| format!("$({direction}({rate}))*{}", place[c]))
        });
        let parts: Vec<String> = parts.map(|part| format!("({part})")).collect();
        if parts.is_empty() { "0".into() } else { parts.join("+") }
    })
}

/// The formula of the target of the mean stress, if the stage has one: of that itself, or of its three parts.
pub(super) fn target_mean_stress(rows: &[(Row, Target)]) -> Option<String> {
    const MEAN: [f64; 6] = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0];
    let plain = |row: &Row| row.strain == [0.0; 6];
    if let Some(k) = rows.iter().position(|(row, _)| plain(row) && row.stress == MEAN && row.divisor == 3.0) {
        return Some(format!("v_aim{}", k + 1));
    }
    let single = |axis: usize| {
        let of_axis = |row: &Row| {
            (0..6).all(|k| (row.stress[k] != 0.0) == (k == axis)) && row.stress[axis] == row.divisor
        };
        rows.iter().position(|(row, _)| plain(row) && of_axis(row)).map(|k| format!("v_aim{}", k + 1))
    };
    let [a, b, c] = [single(0)?, single(1)?, single(2)?];
    Some(format!("({a}+{b}+{c})/3"))
}

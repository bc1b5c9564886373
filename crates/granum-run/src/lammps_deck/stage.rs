//! A stage of a test as a part of the script.

use granum_dem::loading::{Control, Kinematics, Measure, Speed, Stage, Start, Until};
use granum_dem::servo::{CellControl, Row};

use super::deck_error::DeckError;
use super::formula::{STRAINS, STRESSES, number, of_measure, sum, term};
use super::head::{AT_ENDS, COLUMNS, LOOK};

/// Time constant of the servo, in time steps, as in granum's stages.
const RESPONSE: f64 = 6.0;
/// Share of the inertial time of the grains in which rates grow, as in granum.
const EASE: f64 = 0.25;
/// Rows of the curve of a stage that ends at a strain.
const ROWS: f64 = 100.0;
/// Fewest and most steps of a row.
const STEPS_OF_ROW: [u32; 2] = [10, 2000];
/// Steps between two checks whether the sample is at rest.
const REST_EVERY: u32 = 500;

/// What all stages share.
pub(super) struct Setting {
    /// Strain rate of an inertial number of one at a mean stress of one pascal, 1/s.
    pub(super) unit_rate: f64,
    /// Bulk modulus that constraints of strains and stresses are weighed with, Pa.
    pub(super) modulus: f64,
    /// Coefficient of the drag while a sample comes to rest, kg/s.
    pub(super) drag: f64,
    /// The tilt of the box that changes in some stage.
    pub(super) tilt: Option<Tilt>,
    /// Laws that change with the mean stress; empty if none do.
    pub(super) laws: String,
}

/// Row and column of the entries of the velocity gradient that a box of LAMMPS can follow, with their names.
const ENTRIES: [(usize, usize, &str); 5] =
    [(0, 0, "11"), (1, 1, "22"), (2, 2, "33"), (0, 1, "12"), (1, 2, "23")];
const AXES: [&str; 3] = ["x", "y", "z"];

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
pub(super) fn tilts(control: &CellControl) -> impl Iterator<Item = Tilt> {
    let entries = [(0, 1, Tilt::Xy), (1, 2, Tilt::Yz)];
    entries.into_iter().filter(|(r, c, _)| moves(control, *r, *c)).map(|(_, _, tilt)| tilt)
}

fn is_sheared(control: &CellControl) -> bool {
    tilts(control).next().is_some()
}

fn moves(control: &CellControl, r: usize, c: usize) -> bool {
    control.rate[r][c] != 0.0 || control.rows().any(|row| row.moves[r][c] != 0.0)
}

/// The control of a stage per unit of its speed, if the deck can express the stage.
pub(super) fn checked(stage: &Stage, modulus: f64) -> Result<CellControl, DeckError> {
    let refuse = |why: &str| DeckError::Stage { stage: stage.name.clone(), why: why.into() };
    let Stage { control, .. } = stage;
    if stage.turns.is_some() {
        return Err(refuse("it turns round at values of a measure; only stages in one direction can be"));
    }
    if stage.start != Start::Here {
        return Err(refuse("its start is a state to which stages go back"));
    }
    if control.has_ramp() {
        return Err(refuse("it has ramps, whose duration granum estimates; give rates"));
    }
    if control.constraints.iter().flatten().any(|constraint| constraint.target.ramp.is_some()) {
        return Err(refuse("a constraint has a ramp; give a rate"));
    }
    let cell = control.per_speed(modulus)?;
    let lower = [(1, 0), (2, 0), (2, 1)].into_iter().any(|(r, c)| moves(&cell, r, c));
    if lower {
        let why = match control.kinematics {
            Kinematics::PureShear => {
                "it shears the cell without rotation, but a box of LAMMPS can be sheared only as in simple shear, in xy and yz \
                 (shear_kinematics = \"simple\")"
            }
            Kinematics::SimpleShear => {
                "it shears the cell in zx, but a box of LAMMPS can be sheared only in xy and yz"
            }
        };
        return Err(refuse(why));
    }
    if stage.until.is_empty() {
        return Err(refuse("it has no end condition"));
    }
    for until in &stage.until {
        let known = match until {
            Until::Reaches { measure, .. } => of_measure(*measure).is_some(),
            Until::AtRest { .. } | Until::PorePressureRatio(_) => true,
            _ => false,
        };
        if !known {
            let why = format!(
                "its end condition ({until}) is not one of a strain, a stress, a time, rest or a pore pressure ratio"
            );
            return Err(refuse(&why));
        }
    }
    Ok(cell)
}

/// How the rows of a stage follow each other.
///
/// Found with the spring-dashpot-slider in two tests of the same sample: with an initialisation at each of 190 rows q/p was 0.08 % and p
/// 0.13 % too low at constant volume, in proportion to the time step and to the number of rows.
const RENEWAL: &str = "\
# LAMMPS is initialised again only where the time step has to change by a tenth: with each initialisation the box is a step ahead of
# the grains, which disturbs the contacts across its faces. The single step before it makes LAMMPS count the contacts with a new list of
# neighbours afterwards; at the end of a stage it counts them, since a run that is halted does not.
";

/// The text of a stage, of a number from 0.
pub(super) fn text(at: usize, stage: &Stage, setting: &Setting) -> Result<String, DeckError> {
    let cell = checked(stage, setting.modulus)?;
    let name: String = stage.name.chars().filter(|c| !c.is_control() && !"\"$&".contains(*c)).collect();
    let mut text = format!(
        "\n# ---- Stage {at}: {name} ----\n\nprint \"stage {at}: {name}\"\nvariable stage equal {at}\n"
    );
    if stage.resets {
        text += "variable x0 equal $(lx)\nvariable y0 equal $(ly)\nvariable z0 equal $(lz)\nvariable time0 equal $(time)\n\
                 variable g12 equal 0\nvariable g23 equal 0\n";
    }
    text += "variable began equal $(step)\nvariable began_at equal $(time)\nvariable began_p equal $(v_p)\n";
    text += &speed(&stage.control, setting);
    let rows: Vec<Row> = cell.rows().copied().collect();
    text += &servo(&rows, stage.control.servo_limit);
    text += &deformation(&cell, &rows, setting.tilt);
    text += &ends(stage, &rows);
    if stage.settling {
        text += &format!("fix drag all viscous {}\n", number(setting.drag));
    }
    text += &curve(stage);
    let from_here = from_here(&cell, setting.tilt);
    text += &start(at, &cell, stage.control.eases, &from_here);
    // Laws of several types take effect with an initialisation only.
    let renew = if setting.laws.lines().count() > 1 { "1" } else { "abs(v_step_now/dt-1)>0.1" };
    let quoted: String = from_here.lines().map(|line| format!(" \"{line}\"")).collect();
    text += &format!(
        "{RENEWAL}variable renew equal {renew}\ntimestep $(v_step_now)\n{from_here}variable pre string yes\n\
         label stage_{at}\n{laws}run ${{every}} pre ${{pre}} post no\nvariable pre string no\n\
         variable ended equal $(v_over)\nvariable renewed equal $(v_renew)\n\
         if \"$(v_ended+v_renewed) > 0.5\" then \"run 1 pre no post no\"\n{LOOK}{}\
         if \"$(v_renewed) > 0.5\" then \"timestep $(v_step_now)\"{quoted} \"variable pre string yes\"\n\
         if \"$(v_ended) <= 0.5\" then \"jump SELF stage_{at}\"\n",
        row(false),
        laws = setting.laws,
    );
    text += &format!(
        "print \"stage {at} ended at step $(step:%.0f), axial strain $(v_e11:%.6g), p = $(v_p:%.6g) Pa\"\n"
    );
    text += &end(&cell, &rows, stage);
    Ok(text)
}

/// Variables `speed`, `share` of the full rates at which the cell is strained, and `progress`, the time at full rates.
fn speed(control: &Control, setting: &Setting) -> String {
    let speed = match control.speed {
        Speed::StrainRate(rate) => number(rate),
        Speed::InertialNumber { number: inertial, at } => {
            let p = at.map_or_else(|| "v_p".to_string(), number);
            format!("{}*sqrt({p})", number(inertial * setting.unit_rate))
        }
    };
    let ease = if control.eases {
        format!(
            "variable ease equal $({}/sqrt(v_p))\n\
             variable share equal (v_elapsed<v_ease)*v_elapsed/v_ease+(v_elapsed>=v_ease)\n\
             variable progress equal (v_elapsed<v_ease)*0.5*v_elapsed^2/v_ease+(v_elapsed>=v_ease)*(v_elapsed-0.5*v_ease)\n",
            number(EASE / setting.unit_rate)
        )
    } else {
        "variable share equal 1\nvariable progress equal v_elapsed\n".into()
    };
    format!("variable speed equal $({speed})\nvariable elapsed equal time-v_began_at\n{ease}")
}

/// For each controlled stress the strain rate that the servo adds, as variable `out`.
fn servo(rows: &[Row], limit: f64) -> String {
    let mut text = String::new();
    let mut growing = String::new();
    for (k, row) in rows.iter().enumerate() {
        let n = k + 1;
        let stresses = row.stress.iter().map(|weight| weight / row.divisor).zip(STRESSES);
        let strains = row.strain.iter().copied().zip(STRAINS);
        text += &format!(
            "\n# Controlled stress {n}.\nvariable value{n} equal {}\n",
            sum(stresses.chain(strains))
        );
        let target = if row.target.is_nan() { format!("$(v_value{n})") } else { number(row.target) };
        let stiffness = format!("({}*v_modulus)", number(row.stiffness));
        let aim = sum([(1.0, format!("v_target{n}").as_str()), (row.target_rate, "v_progress")]);
        let forward = match row.target_rate {
            0.0 => String::new(),
            rate => format!("+v_share*{}/{stiffness}", term(rate)),
        };
        let integral = if rows.len() == 1 { "f_integrals".to_string() } else { format!("f_integrals[{n}]") };
        let limit = format!("{}*v_speed", number(limit));
        text += &format!(
            "variable target{n} equal {target}\n\
             variable error{n} equal {aim}-v_value{n}\n\
             variable wanted{n} equal (v_error{n}+{integral}*(step-v_began+1))/({stiffness}*{RESPONSE}*dt){forward}\n\
             variable within{n} equal (abs(v_wanted{n})<=({limit}))*(abs(v_error{n})<=0.2*(abs(v_p)+abs(v_target{n})))\n\
             variable grow{n} equal v_within{n}*v_error{n}/{six}\n\
             variable out{n} equal (abs(v_wanted{n})<=({limit}))*v_wanted{n}+(v_wanted{n}>({limit}))*{limit}-(v_wanted{n}<(-{limit}))*{limit}\n",
            six = number(6.0 * RESPONSE),
        );
        growing += &format!(" v_grow{n}");
    }
    if !rows.is_empty() {
        text += &format!("fix integrals all ave/time 1 1 1{growing} ave running\n");
    }
    text
}

/// The velocity gradient, and the box that follows it.
fn deformation(cell: &CellControl, rows: &[Row], tilt: Option<Tilt>) -> String {
    let mut text = String::from("\n# Velocity gradient, 1/s, and the lengths that it gives the box.\n");
    let mut all = String::new();
    for (r, c, name) in ENTRIES {
        let outs: Vec<String> = (1..=rows.len()).map(|n| format!("v_out{n}")).collect();
        let added = rows.iter().zip(&outs).map(|(row, out)| (-row.moves[r][c], out.as_str()));
        let rate = sum([(-cell.rate[r][c], "v_share*v_speed")].into_iter().chain(added));
        text += &format!("variable l{name} equal {rate}\n");
    }
    for (k, axis) in AXES.into_iter().enumerate().filter(|(k, _)| moves(cell, *k, *k)) {
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
    if is_sheared(cell) {
        text += "variable g12_before equal $(v_g12)\nvariable g23_before equal $(v_g23)\n\
                 variable slip12 equal -v_l12*dt\nvariable slip23 equal -v_l23*dt\n\
                 fix angles all ave/time 1 1 1 v_slip12 v_slip23 ave running\n\
                 variable g12 equal v_g12_before+f_angles[1]*(step-v_began+1)\n\
                 variable g23 equal v_g23_before+f_angles[2]*(step-v_began+1)\n";
    }
    text += &from_here(cell, tilt);
    if !all.is_empty() {
        text += &format!("fix cell all deform 1{all} remap v units box\n");
    }
    text
}

/// The lengths from which `fix deform` counts: those at the start of each `run`.
fn from_here(cell: &CellControl, tilt: Option<Tilt>) -> String {
    let lengths = (0..3).filter(|k| moves(cell, *k, *k)).map(|k| (AXES[k], format!("l{}", AXES[k])));
    let tilt = tilt.map(|tilt| (tilt.name(), tilt.name().to_string()));
    lengths.chain(tilt).map(|(name, length)| format!("variable from_{name} equal $({length})\n")).collect()
}

/// The end of the stage: variable `over`.
fn ends(stage: &Stage, rows: &[Row]) -> String {
    let mut text = String::from("\n# The end of the stage.\n");
    let mut any = vec![];
    let mut rest = None;
    for (k, until) in stage.until.iter().enumerate() {
        match *until {
            Until::Reaches { measure, value } => {
                let measured = of_measure(measure).unwrap_or("0");
                let value = term(value);
                text += &format!("variable sense{k} equal $(1-2*({value}<{measured}))\n");
                any.push(format!("(v_sense{k}*({measured}-{value})>=0)"));
            }
            Until::PorePressureRatio(ratio) => any.push(format!("(v_p<={}*v_began_p)", number(1.0 - ratio))),
            Until::AtRest { unbalanced_force } => rest = Some(unbalanced_force),
            _ => {}
        }
    }
    if !rows.is_empty() {
        any.push("(v_p<0.001*v_began_p)".into());
    }
    // As in granum four times the way, and without a bound as far as the stage is to go.
    let most = stage.most_arc_length.unwrap_or_else(|| 4.0 * goal(stage).unwrap_or(1.0));
    any.push(format!("(v_elapsed>{}/v_speed)", number(4.0 * most)));
    text += &format!("variable done equal {}\n", any.join("||"));
    text += "fix stop all halt 1 v_done > 0.5 error continue message no\n";
    let Some(unbalanced) = rest else { return text + "variable over equal v_done\n" };
    let arrived: String = (1..=rows.len()).map(|n| format!("*(abs(v_error{n})<0.005*v_p)")).collect();
    let earliest = 3 * REST_EVERY;
    text + &format!(
        "variable calm equal (v_unbalanced<{}){arrived}\n\
         fix calm all ave/time {REST_EVERY} 1 {REST_EVERY} v_calm ave window 3\n\
         variable rested equal (f_calm>0.99)*(step-v_began>={earliest})\n\
         fix rest all halt {REST_EVERY} v_rested > 0.5 error continue message no\n\
         variable over equal v_done||v_rested\n",
        number(unbalanced)
    )
}

/// The strain at which a stage ends, if it ends at one.
fn goal(stage: &Stage) -> Option<f64> {
    stage.until.iter().find_map(|until| match until {
        Until::Reaches {
            measure:
                Measure::Strain(_)
                | Measure::AxialDeviatorStrain
                | Measure::VolumetricStrain
                | Measure::DeviatoricStrain,
            value,
        } => Some(value.abs()),
        _ => None,
    })
}

/// The rows of the curve: their length in steps, their means, and the row at the start of the stage.
fn curve(stage: &Stage) -> String {
    let strain = goal(stage).map(|strain| strain / ROWS).or(match stage.record.spacing {
        granum_dem::config::Spacing::Every(interval) => Some(interval),
        _ => None,
    });
    let strain = strain.filter(|_| !stage.settling).unwrap_or(1.0);
    let [least, most] = STEPS_OF_ROW;
    let most = if stage.settling { REST_EVERY } else { most };
    let means: Vec<&str> = COLUMNS.iter().map(|(_, what)| *what).collect();
    format!(
        "\n# Rows of the curve: means over so many steps.\n{}\
         variable steps equal $(ceil({}/(v_speed*v_step_now)))\n\
         variable every equal $((v_steps<{least})*{least}+(v_steps>={least})*(v_steps<={most})*v_steps+(v_steps>{most})*{most}:%.0f)\n\
         fix mean all ave/time 1 1 1 {} ave window ${{every}}\n",
        row(true),
        number(strain),
        means.join(" ")
    )
}

/// Prints a row, of present values or of means; of what is counted only now and then, the mean of the two ends.
fn row(now: bool) -> String {
    let mut words = vec!["$(v_stage:%.0f)".to_string(), "$(step:%.0f)".to_string()];
    for (k, (_, what)) in COLUMNS.iter().enumerate() {
        words.push(if now { format!("$({what}:%.9g)") } else { format!("$(f_mean[{}]:%.9g)", k + 1) });
    }
    words.extend(AT_ENDS.iter().map(|(_, [before, at_end])| {
        let what = if now { (*at_end).to_string() } else { format!("0.5*({before}+{at_end})") };
        format!("$({what}:%.6g)")
    }));
    format!("print \"{}\" append ${{out}} screen no\n", words.join(","))
}

/// The velocity of the homogeneous strain at the full base rates, per unit of speed: `-B x`, for each axis.
fn homogeneous(cell: &CellControl) -> [String; 3] {
    std::array::from_fn(|r| sum(AXES.into_iter().enumerate().map(|(c, axis)| (-cell.rate[r][c], axis))))
}

/// Gives the grains the velocities of the homogeneous strain, at once or as the rates grow; by the contacts alone they would get
/// them with a shock.
fn start(at: usize, cell: &CellControl, eases: bool, from_here: &str) -> String {
    let flow = homogeneous(cell);
    if flow.iter().all(|part| part == "0") {
        return String::new();
    }
    let mut text = String::from("\n# The grains get the velocities of the homogeneous strain.\n");
    for (axis, flow) in AXES.into_iter().zip(&flow) {
        text += &if eases {
            format!("variable push_{axis} atom mass*$(v_speed/v_ease)*({flow})\n")
        } else {
            format!("variable push_{axis} atom v{axis}+$(v_speed)*({flow})\n")
        };
    }
    text + &if eases {
        format!(
            "fix push all addforce v_push_x v_push_y v_push_z\ntimestep $(v_step_now)\n{from_here}\
             variable left equal ceil((v_ease-v_elapsed)/dt-1e-6)\nvariable pre string yes\n\
             label start_{at}\nvariable part equal $((v_left<v_every)*v_left+(v_left>=v_every)*v_every:%.0f)\n\
             run ${{part}} pre ${{pre}} post no\nvariable pre string no\nvariable ended equal $(v_over||(v_left<1))\n\
             if \"$(v_ended) > 0.5\" then \"run 1 pre no post no\"\n{LOOK}{}\
             if \"$(v_ended) <= 0.5\" then \"jump SELF start_{at}\"\nunfix push\n",
            row(false)
        )
    } else {
        "velocity all set v_push_x v_push_y v_push_z\n".into()
    }
}

/// Takes these velocities away again, and with them what belongs to the stage.
fn end(cell: &CellControl, rows: &[Row], stage: &Stage) -> String {
    let mut text = String::new();
    let flow = homogeneous(cell);
    if flow.iter().any(|part| part != "0") {
        for (axis, flow) in AXES.into_iter().zip(&flow) {
            text += &format!("variable push_{axis} atom v{axis}-$(v_share*v_speed)*({flow})\n");
        }
        text += "velocity all set v_push_x v_push_y v_push_z\n";
    }
    if is_sheared(cell) {
        text += "variable g12 equal $(v_g12)\nvariable g23 equal $(v_g23)\nunfix angles\n";
    }
    let any = |there: bool, fix: &'static str| there.then_some(fix);
    let moved = ENTRIES.iter().any(|(r, c, _)| moves(cell, *r, *c));
    let rests = stage.until.iter().any(|until| matches!(until, Until::AtRest { .. }));
    let fixes = [
        any(true, "stop"),
        any(rests, "rest"),
        any(rests, "calm"),
        any(true, "mean"),
        any(moved, "cell"),
        any(!rows.is_empty(), "integrals"),
        any(stage.settling, "drag"),
    ];
    fixes.into_iter().flatten().fold(text, |text, fix| text + &format!("unfix {fix}\n"))
}

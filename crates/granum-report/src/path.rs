//! Figures of a test along any path, chosen by what its stages control.

use granum_dem::loading::{Constraint, Drive, Stage, Start};
use granum_run::strength::Curves;
use granum_run::strength::symmetry::{is_oedometric, keeps_volume, moves};
use maud::{Markup, html};

use super::data::RunReport;
use super::deviatoric_plane;
use super::figure::palette::{GREY, INK, color};
use super::figure::{Axis, Figure, Layer, Panel, Plot, SHAPES, Stroke};
use super::material::strain_axis;
use super::page::Page;

/// What a test is about, as its stages say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traits {
    /// Some stage compresses all axes alike or one alone: void ratio counts.
    pub compression: bool,
    /// Some stage strains one axis alone: the lateral stress is to be found.
    pub oedometer: bool,
    /// The volume is kept while the sample is sheared: a saturated sample would show pore pressure.
    pub undrained: bool,
    /// Grains are moved along x by their y.
    pub simple_shear: bool,
    /// It goes to and fro.
    pub cyclic: bool,
    /// The three principal stresses differ by what is controlled.
    pub triaxial: bool,
    /// Small increments from one state.
    pub probes: bool,
}

impl Traits {
    /// Those of the stages of a test.
    pub fn from_stages(stages: &[Stage]) -> Traits {
        let mut found = Traits::default();
        let mut senses = Vec::new();
        for stage in stages.iter().filter(|stage| !stage.is_mark()) {
            let control = &stage.control;
            let [x, y, z] = [0, 1, 2].map(|k| control.components[k]);
            let sheared = control.components[3..].iter().any(|drive| moves(*drive));
            found.oedometer |= is_oedometric(stage);
            found.compression |= is_isotropic(stage);
            // A combination of stresses that turns round drives the axes without a rate of their own.
            let driven = sheared || moves(x) || stage.turns.is_some();
            found.undrained |= keeps_volume(control) && driven;
            found.simple_shear |=
                moves(control.components[5]) && stage.start == Start::Here && !is_history(stage);
            found.cyclic |= stage.turns.is_some();
            found.triaxial |= control.constraints.iter().flatten().any(is_uneven)
                || (y == Drive::Fixed && matches!(z, Drive::Stress(_)) && moves(x));
            found.probes |= stage.start != Start::Here;
            senses.extend(sense(x));
        }
        found.cyclic |= senses.windows(2).any(|pair| pair[0] != pair[1]) && !found.probes && !found.oedometer;
        found.compression |= found.oedometer;
        found
    }
}

impl Traits {
    /// True if a mean over the end of the test says nothing.
    pub fn goes_to_and_fro(&self) -> bool {
        self.cyclic || self.probes || self.compression
    }
}

/// The direction in which axis x is strained, if it is given.
fn sense(x: Drive) -> Option<bool> {
    match x {
        Drive::Rate(rate) if rate != 0.0 => Some(rate > 0.0),
        _ => None,
    }
}

fn is_history(stage: &Stage) -> bool {
    stage.name.starts_with("row ")
}

/// All axes are brought to a stress, and states are recorded on the way.
fn is_isotropic(stage: &Stage) -> bool {
    let [x, y, z] = [0, 1, 2].map(|k| stage.control.components[k]);
    let stress = |drive| matches!(drive, Drive::Stress(target) if target.value.is_some());
    stress(x) && x == y && y == z && stage.record != granum_dem::loading::RecordedStates::default()
}

/// A combination of stresses that distinguishes y and z.
fn is_uneven(constraint: &Constraint) -> bool {
    constraint.stress[1] != constraint.stress[2] && constraint.stress[0] != 0.0
}

/// The void ratio at every state, from the solid fraction.
pub fn void_ratio(run: &RunReport) -> Vec<f64> {
    run.column("solid_fraction").iter().map(|solid| (1.0 - solid) / solid).collect()
}

/// A line for each segment of states over which the strain counts from one start; others are gaps.
pub fn lines(run: &RunReport, x: &[f64], y: &[f64]) -> Vec<[f64; 2]> {
    let stages = run.case.test_stages();
    let curves = Curves::new(&run.record, &stages);
    let mut points = Vec::with_capacity(x.len());
    for (row, (&x, &y)) in x.iter().zip(y).enumerate() {
        if row > 0 && curves.counted_from(row) == row {
            points.push([f64::NAN, f64::NAN]);
        }
        points.push([x, y]);
    }
    points
}

/// Ratios of stresses, with gaps where the sample has lost its stress: there they are noise.
pub fn where_stress(curves: &Curves, ratios: impl Iterator<Item = f64>) -> Vec<f64> {
    let carries = curves.carry_stress(&(0..curves.rows()));
    ratios.zip(carries).map(|(ratio, carries)| if carries { ratio } else { f64::NAN }).collect()
}

/// The deviator stress that the figures of a test draw.
struct Deviator {
    /// Its symbol.
    symbol: &'static str,
    /// What it is, as the end of a sentence.
    what: &'static str,
    /// Its values, Pa.
    stress: Vec<f64>,
    /// Its ratios to the mean stress.
    ratio: Vec<f64>,
}

impl Deviator {
    fn for_run(run: &RunReport) -> Deviator {
        let stages = run.case.test_stages();
        let curves = Curves::new(&run.record, &stages);
        let (symbol, what) = match curves.axis() {
            Some(_) => ("*q*", "*q* is the axial less the mean lateral stress, negative in extension"),
            None => ("*q*_{vM}", "*q*_{vM} = √(3 *J*_{2}) is the von Mises stress, which has no sign"),
        };
        let stress = curves.deviator_stress().into_owned();
        let ratio = where_stress(&curves, curves.stress_ratio().iter().copied());
        Deviator { symbol, what, stress, ratio }
    }
}

fn curve(run: &RunReport, x: &str, y: &str, k: usize) -> Layer {
    Layer::line(lines(run, run.column(x), run.column(y)), color(k))
}

/// The figures of a run along any path.
pub fn behaviour(page: &mut Page, run: &RunReport) -> Markup {
    let traits = Traits::from_stages(&run.case.test_stages());
    let mut figures = Vec::new();
    if traits.probes {
        figures.extend(probes(run).map(|figure| ("probes", figure)));
    }
    let compression_alone = traits.compression && is_compression_alone(run);
    if traits.cyclic {
        figures.push(("loops", loops(run, &traits)));
    }
    if traits.simple_shear {
        figures.push(("shear", simple_shear(run, &traits)));
    } else if !(traits.probes || traits.cyclic || compression_alone) {
        figures.push(("stress", stress_and_volume(run, &traits)));
    }
    if traits.compression {
        figures.push(("compression", compression(run, &traits)));
    }
    if !(traits.probes || compression_alone && !traits.oedometer) {
        figures.push(("stress-path", stress_path(run, &traits)));
    }
    if traits.undrained {
        figures.push(("pore-pressure", pore_pressure(run)));
    }
    if traits.triaxial {
        figures.push(("deviatoric-plane", deviatoric_plane::figure(run)));
    }
    let figures: Vec<Markup> =
        figures.iter().map(|(file, (figure, caption))| page.own_figure(file, caption, figure)).collect();
    html! { @for figure in figures { (figure) } }
}

/// True if no stage shears the sample by what it controls.
fn is_compression_alone(run: &RunReport) -> bool {
    run.case.test_stages().iter().filter(|stage| !stage.is_mark()).all(|stage| {
        let one = std::slice::from_ref(stage);
        Traits::from_stages(one).compression || matches!(stage.control.components[0], Drive::Stress(_))
    })
}

type Drawn = (Figure, String);

/// q/p and volumetric strain against the strain; at constant volume q/p alone.
fn stress_and_volume(run: &RunReport, traits: &Traits) -> Drawn {
    let one = std::slice::from_ref(run);
    let strain = run.strain();
    let deviator = Deviator::for_run(run);
    let Deviator { symbol, what, ratio, .. } = &deviator;
    let line = |values: &[f64]| Layer::line(lines(run, &strain, values), color(0));
    let plot = Plot::new(strain_axis(one), Axis::new(&format!("Stress ratio {symbol}/*p*")).including(0.0))
        .with(line(ratio));
    let caption = format!("Ratio of the deviator stress to the mean stress; {what}");
    if traits.undrained {
        return (
            Figure::new("Stress ratio against strain", 1, vec![Panel::plot(plot)]),
            format!("{caption}. States that have lost 95 % of the mean stress are not drawn."),
        );
    }
    let volume = Plot::new(strain_axis(one), Axis::new("Volumetric strain *ε*_{v}"))
        .with(Layer::horizontal(0.0, GREY))
        .with(line(run.column("volumetric_strain")));
    let caption = format!(
        "(a) {caption}; (b) volumetric strain, compression positive, so that a falling curve is dilation."
    );
    let panels = vec![Panel::plot(plot), Panel::plot(volume)];
    (Figure::new("Stress ratio and volumetric strain against strain", 2, panels), caption)
}

/// The path of the stress, and the void ratio over the logarithm of p where no other figure has it.
fn stress_path(run: &RunReport, traits: &Traits) -> Drawn {
    let Deviator { symbol, what, stress: deviator, .. } = Deviator::for_run(run);
    let p = run.column("mean_stress");
    let path = Plot::new(
        Axis::new("Mean stress *p*").unit("Pa").including(0.0),
        Axis::new(&format!("Deviator stress {symbol}")).unit("Pa").including(0.0),
    )
    .with(Layer::line(lines(run, p, &deviator), color(0)))
    .with_all(ends(run, p, &deviator));
    let marks = "Open circle: start; square: end.";
    if traits.compression {
        let caption = format!("Stress path in the plane of mean and deviator stress; {what}. {marks}");
        return (Figure::new("Stress path", 1, vec![Panel::plot(path)]), caption);
    }
    let caption = format!(
        "(a) Stress path in the plane of mean and deviator stress; {what}; (b) void ratio against mean stress. {marks}"
    );
    let void_ratio = void_ratio_plot(run, "Mean stress *p*", run.column("mean_stress"));
    let panels = vec![Panel::plot(path), Panel::plot(void_ratio)];
    (Figure::new("Stress path and void ratio", 2, panels), caption)
}

fn void_ratio_plot(run: &RunReport, label: &str, stress: &[f64]) -> Plot {
    let void = void_ratio(run);
    let range = granum_learn::curve::range(void.iter().copied());
    let axis = Axis::new("Void ratio *e*");
    // At constant volume rounding alone would make a scale.
    let axis = if range[1] - range[0] < 1e-5 { axis.between(range[0] - 0.01, range[1] + 0.01) } else { axis };
    Plot::new(Axis::new(label).unit("Pa").logarithmic(), axis)
        .with(Layer::line(lines(run, stress, &void), color(0)))
        .with_all(ends(run, stress, &void))
}

/// Marks at the first and the last state.
fn ends(run: &RunReport, x: &[f64], y: &[f64]) -> [Layer; 2] {
    let at = |row: Option<usize>| -> Vec<[f64; 2]> {
        row.and_then(|row| Some([*x.get(row)?, *y.get(row)?])).into_iter().collect()
    };
    let rows = run.record.series.rows();
    [Layer::points(at(Some(0)), SHAPES[0], INK), Layer::dots(at(rows.checked_sub(1)), SHAPES[1], 2.7, INK)]
}

/// Void ratio over the logarithm of the stress, and the lateral stress where one axis is compressed alone.
fn compression(run: &RunReport, traits: &Traits) -> Drawn {
    let stresses = ["stress_11", "stress_22", "stress_33"].map(|name| run.column(name));
    let second = if traits.oedometer {
        let rows = stresses.iter().map(|stress| stress.len()).min().unwrap_or(0);
        let ratio: Vec<f64> =
            (0..rows).map(|k| 0.5 * (stresses[1][k] + stresses[2][k]) / stresses[0][k]).collect();
        Plot::new(
            Axis::new("Axial stress *σ*_{1}").unit("Pa").logarithmic(),
            Axis::new("Stress ratio *K* = *σ*_{3}/*σ*_{1}").including(0.0),
        )
        .with(Layer::line(lines(run, stresses[0], &ratio), color(0)))
        .with_all(ends(run, stresses[0], &ratio))
    } else {
        Plot::new(
            Axis::new("Mean stress *p*").unit("Pa").including(0.0),
            Axis::new("Volumetric strain *ε*_{v}"),
        )
        .with(curve(run, "mean_stress", "volumetric_strain", 0))
    };
    let what = match traits.oedometer {
        true => "ratio of lateral to axial stress, *K*_{0} on first loading",
        false => "volumetric strain",
    };
    // In an oedometer the axial stress is what is known.
    let (void_ratio, against) = match traits.oedometer {
        true => (void_ratio_plot(run, "Axial stress *σ*_{1}", stresses[0]), "axial stress"),
        false => (void_ratio_plot(run, "Mean stress *p*", run.column("mean_stress")), "mean stress"),
    };
    let caption = format!("(a) Void ratio against {against}; (b) {what}. Open circle: start; square: end.");
    (Figure::new("Compression", 2, vec![Panel::plot(void_ratio), Panel::plot(second)]), caption)
}

/// Shear stress and normal stress or volume in simple shear.
fn simple_shear(run: &RunReport, traits: &Traits) -> Drawn {
    let strain = || Axis::new("Shear strain *γ*_{xy}");
    let shear = run.column("stress_12").iter().zip(run.column("stress_21")).map(|(a, b)| 0.5 * (a + b));
    let shear: Vec<f64> = shear.collect();
    let stages = run.case.test_stages();
    let ratio = shear.iter().zip(run.column("stress_22")).map(|(shear, normal)| shear / normal);
    let ratio = where_stress(&Curves::new(&run.record, &stages), ratio);
    let gamma = run.column("shear_strain_xy");
    let stress = Plot::new(strain(), Axis::new("*σ*_{xy}/*σ*_{yy}").including(0.0))
        .with(Layer::line(lines(run, gamma, &ratio), color(0)));
    let (second, what) =
        match traits.undrained {
            true => (
                Plot::new(strain(), Axis::new("Normal stress *σ*_{yy}").unit("Pa").including(0.0))
                    .with(curve(run, "shear_strain_xy", "stress_22", 0)),
                "normal stress",
            ),
            false => (
                Plot::new(strain(), Axis::new("Volumetric strain *ε*_{v}"))
                    .with(Layer::horizontal(0.0, GREY))
                    .with(curve(run, "shear_strain_xy", "volumetric_strain", 0)),
                "volumetric strain, compression positive",
            ),
        };
    let path = Plot::new(
        Axis::new("Normal stress *σ*_{yy}").unit("Pa").including(0.0),
        Axis::new("Shear stress *σ*_{xy}").unit("Pa").including(0.0),
    )
    .with(Layer::line(lines(run, run.column("stress_22"), &shear), color(0)));
    // The axis of the larger principal stress turns from wherever it is towards 45 degrees.
    let angle: Vec<f64> = (run.column("stress_11").iter().zip(run.column("stress_22")).zip(&shear))
        .map(|((x, y), shear)| (0.5 * libm::atan2(2.0 * shear, x - y)).to_degrees())
        .collect();
    let axis = Plot::new(strain(), Axis::new("Angle of *σ*_{1} to *x* (degrees)"))
        .with(Layer::line(lines(run, gamma, &angle), color(0)));
    let caption = format!(
        "Simple shear: (a) ratio of shear to normal stress; (b) {what}; (c) stress path on the shear plane; (d) \
         direction of the major principal stress in the *xy* plane."
    );
    let panels = [stress, second, path, axis].map(Panel::plot).to_vec();
    (Figure::new("Simple shear", 2, panels), caption)
}

/// q against axial strain, and volume or pore pressure along the way.
fn loops(run: &RunReport, traits: &Traits) -> Drawn {
    let strain = run.strain_and_label().0;
    let Deviator { symbol, what: which, stress, .. } = Deviator::for_run(run);
    let deviator = Plot::new(
        Axis::new("Axial strain *ε*_{1}"),
        Axis::new(&format!("Deviator stress {symbol}")).unit("Pa"),
    )
    .with(Layer::horizontal(0.0, GREY))
    .with(Layer::line(lines(run, run.column("axial_strain"), &stress), color(0)));
    let along = |axis: Axis, values: &[f64]| {
        Plot::new(strain_axis(std::slice::from_ref(run)), axis)
            .with(Layer::line(lines(run, &strain, values), color(0)))
    };
    let second = match traits.undrained {
        true => {
            let ratio = Curves::new(&run.record, &run.case.test_stages()).pore_pressure_ratio();
            along(Axis::new("Pore pressure ratio *r*_{u} = 1 − *p*/*p*_{0}").including(0.0), &ratio)
        }
        false => along(Axis::new("Volumetric strain *ε*_{v}"), run.column("volumetric_strain")),
    };
    let what = match traits.undrained {
        true => {
            "ratio of the excess pore pressure of a saturated sample under constant total mean stress, since the start of the \
             undrained stage"
        }
        false => "volumetric strain, compression positive",
    };
    let caption = format!("(a) Loops of the deviator stress; {which}; (b) {what}, along the strain path.");
    (Figure::new("Loops of stress and strain", 2, vec![Panel::plot(deviator), Panel::plot(second)]), caption)
}

/// What a fluid-saturated sample would show.
fn pore_pressure(run: &RunReport) -> Drawn {
    let strain = run.strain();
    let stages = run.case.test_stages();
    let curves = Curves::new(&run.record, &stages);
    let against = |values: Vec<f64>| lines(run, &strain, &values);
    let lost = |name: &str| curves.lost_while_undrained(name);
    let lateral = match curves.axis() {
        Some(0) => lost("stress_22").iter().zip(lost("stress_33")).map(|(y, z)| 0.5 * (y + z)).collect(),
        _ => lost("stress_33"),
    };
    let axis = || strain_axis(std::slice::from_ref(run));
    let pressure = Plot::new(axis(), Axis::new("Excess pore pressure *u*").unit("Pa").including(0.0))
        .with(Layer::line(against(lateral), color(0)).named("constant cell pressure"))
        .with(
            Layer::stroked(against(lost("mean_stress")), Stroke::new(color(1), 1.6).dashed(&[5.0, 3.0]))
                .named("constant mean stress"),
        );
    let effective = Plot::new(axis(), Axis::new("Effective mean stress *p*").unit("Pa").including(0.0))
        .with(Layer::line(against(run.column("mean_stress").to_vec()), color(0)));
    let caption = "The stresses of the grains are effective stresses. (a) Excess pore pressure that a saturated sample \
                   would show if the total lateral stress is constant (the decrease of *σ*_{3}), and if the total mean \
                   stress is (the decrease of *p*), both since the start of the undrained stage; (b) effective mean stress.";
    (Figure::new("Pore pressure", 2, vec![Panel::plot(pressure), Panel::plot(effective)]), caption.into())
}

/// Increments of strain and the increments of stress that answer them, in the triaxial plane.
fn probes(run: &RunReport) -> Option<Drawn> {
    let stages = run.case.test_stages();
    let numbers = run.column("stage");
    let row = |stage: usize| numbers.iter().position(|number| *number == (stage + 1) as f64);
    let plane = |names: [&str; 3], row: usize| -> Option<[f64; 2]> {
        let [x, y, z] = names.map(|name| run.column(name).get(row).copied());
        Some([(y? + z?) * std::f64::consts::FRAC_1_SQRT_2, x?])
    };
    let (mut strains, mut stresses) = (Vec::new(), Vec::new());
    let state = stages.iter().position(|stage| stage.start == Start::Kept).and_then(row)?;
    for (k, _) in stages.iter().enumerate().filter(|(_, stage)| stage.is_mark()) {
        let Some(row) = row(k) else { continue };
        let strain = ["axial_strain", "lateral_strain_2", "lateral_strain_3"];
        let stress = ["stress_11", "stress_22", "stress_33"];
        strains.push(plane(strain, row)?);
        let (here, before) = (plane(stress, row)?, plane(stress, state)?);
        stresses.push([here[0] - before[0], here[1] - before[1]]);
    }
    let plot = |points: Vec<[f64; 2]>, of: [&str; 2], unit: &str| {
        let spokes = points.iter().flat_map(|point| [[0.0, 0.0], *point, [f64::NAN; 2]]).collect();
        let largest = points.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs())) * 1.1;
        let axis = |label: &str| Axis::new(label).unit(unit).between(-largest, largest);
        let mut ring = points.clone();
        ring.extend(points.first().copied());
        Plot::new(axis(of[0]), axis(of[1]))
            .with(Layer::stroked(spokes, Stroke::new(GREY, 0.8)))
            .with(Layer::line(ring, color(0)))
            .with(Layer::dots(points, SHAPES[0], 2.4, color(0)))
    };
    let panels = vec![
        Panel::plot(plot(strains, ["√2 Δ*ε*_{3}", "Δ*ε*_{1}"], "")),
        Panel::plot(plot(stresses, ["√2 Δ*σ*_{3}", "Δ*σ*_{1}"], "Pa")),
    ];
    let caption = "Probes from one state: (a) strain increments, (b) the corresponding stress increments (response \
                   envelope, Gudehus 1979), in the plane of the axial and the two lateral components.";
    Some((Figure::new("Response envelope", 2, panels).sized(720.0, 360.0), caption.into()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_io::Case;

    fn traits(path: &str, more: &str) -> Traits {
        let text = format!("[[stage]]\npath = \"{path}\"\n{more}");
        Traits::from_stages(&Case::parse(&text, "case.toml").unwrap().test_stages())
    }

    /// What a report shows follows from what the stages control.
    #[test]
    fn figures_follow_from_what_is_controlled() {
        let none = Traits::default();
        assert_eq!(traits("drained-triaxial", ""), none);
        assert_eq!(traits("constant-p", ""), none);
        assert_eq!(traits("isotropic", ""), Traits { compression: true, ..none });
        let unloaded = traits("oedometer", "unloading_stress = 1e5\n");
        assert_eq!(unloaded, Traits { compression: true, oedometer: true, ..none });
        assert_eq!(traits("undrained-triaxial", ""), Traits { undrained: true, ..none });
        assert!(traits("undrained-triaxial", "fluid_modulus = 1e8\n").undrained);
        assert_eq!(traits("simple-shear", ""), Traits { simple_shear: true, ..none });
        let constant = traits("simple-shear-constant-volume", "");
        assert_eq!(constant, Traits { simple_shear: true, undrained: true, ..none });
        assert_eq!(traits("constant-p-and-b", ""), Traits { triaxial: true, ..none });
        assert_eq!(traits("plane-strain", ""), Traits { triaxial: true, ..none });
        assert_eq!(traits("cyclic", ""), Traits { cyclic: true, undrained: true, ..none });
        let stress = traits("cyclic", "stress_amplitude = 1e4\n");
        assert!(stress.cyclic && stress.undrained && !stress.triaxial);
        assert_eq!(traits("cyclic", "drainage = \"drained\"\n"), Traits { cyclic: true, ..none });
        assert_eq!(traits("unload-reload", ""), Traits { cyclic: true, ..none });
        assert!(traits("probes", "").probes && !traits("probes", "").cyclic);
    }
}

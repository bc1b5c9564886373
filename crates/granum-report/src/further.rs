//! Figures of sensors that a case asked for, where their columns are in the series.

use granum_sensors::radial_distribution::radial_distribution;

use super::data::RunReport;
use super::figure::palette::{INK, color};
use super::figure::{Axis, Figure, Layer, Panel, Plot, Stroke};
use super::material::strain_axis;

/// A figure with the name of its file and its caption.
pub type Named = (&'static str, Figure, String);

/// The figures that the columns of a run allow.
pub fn figures(run: &RunReport) -> Vec<Named> {
    [angles(run), anisotropies(run), chains(run), distances(run), bonds(run), fragments(run)]
        .into_iter()
        .flatten()
        .collect()
}

/// A panel with a line for each of these columns that the run has; `None` if it has none.
fn panel(run: &RunReport, label: &str, columns: &[(&str, &str)]) -> Option<Panel> {
    let mut plot = Plot::new(strain_axis(std::slice::from_ref(run)), Axis::new(label).including(0.0));
    let mut lines = 0;
    for (k, (column, name)) in columns.iter().enumerate() {
        if !run.column(column).is_empty() {
            plot = plot.with(Layer::line(run.against_strain(column), color(k)).named(name));
            lines += 1;
        }
    }
    (lines > 0).then(|| Panel::plot(plot))
}

fn bonds(run: &RunReport) -> Option<Named> {
    let broken =
        [("bonds_broken_by_tension", "ruptured by tension"), ("bonds_broken_by_shear", "ruptured by shear")];
    let first = panel(run, "Bonds", &broken)?;
    let share = [("broken_bond_fraction", "ruptured"), ("mean_bond_utilisation", "mean utilisation")];
    let directions = [("bond_deviator_fabric", "bonds"), ("crack_deviator_fabric", "cracks")];
    let panels = [
        Some(first),
        panel(run, "Share of the bonds", &share),
        panel(run, "Deviator fabric *φ*_{d}", &directions),
    ];
    let caption = "Bonds: (a) number of those that ruptured, by tension with bending and by shear with twist; (b) share of all bonds that \
                   ruptured, and mean ratio of load to strength of those that hold; (c) deviator fabric of the bonds that hold and of the \
                   cracks, whose normals are those of the bonds that ruptured.";
    let panels: Vec<Panel> = panels.into_iter().flatten().collect();
    Some(("bonds", Figure::new("Bonds against strain", panels.len(), panels), caption.into()))
}

/// Where bonded grains do not span the cell: agglomerates that crush.
fn fragments(run: &RunReport) -> Option<Named> {
    let breakage = run.column("einav_breakage");
    if !breakage.iter().any(|value| *value > 0.0) {
        return None;
    }
    let indices = [("einav_breakage", "Einav's *B*"), ("hardin_breakage", "Hardin's *B*_{r}")];
    let shares = [
        ("single_grain_fraction", "single spheres, by mass"),
        ("largest_fragment_fraction", "largest fragment, by mass"),
    ];
    let panels = [panel(run, "Breakage", &indices), panel(run, "Share of the mass", &shares)];
    let caption = "Fragments: (a) breakage by the gradings of fragments; (b) mass of spheres without bonds and of the largest fragment over \
                   that of all grains.";
    let panels: Vec<Panel> = panels.into_iter().flatten().collect();
    Some(("fragments", Figure::new("Fragments against strain", panels.len(), panels), caption.into()))
}

fn angles(run: &RunReport) -> Option<Named> {
    let columns = [("mobilised_friction_angle", "friction *φ*"), ("dilatancy_angle", "dilatancy *ψ*")];
    let panel = panel(run, "Angle, degrees", &columns)?;
    let caption = "Mobilised friction angle of the largest and smallest principal stress, and dilatancy angle of the strain between \
                   observations, positive in dilation.";
    Some((
        "angles",
        Figure::new("Friction and dilatancy angles against strain", 1, vec![panel]),
        caption.into(),
    ))
}

fn anisotropies(run: &RunReport) -> Option<Named> {
    let columns = [
        ("contact_anisotropy", "contacts *a*_{c}"),
        ("normal_force_anisotropy", "normal forces *a*_{n}"),
        ("tangential_force_anisotropy", "tangential forces *a*_{t}"),
    ];
    let first = panel(run, "Anisotropy", &columns)?;
    let strains = run.strain();
    // The relation is one of invariants. The series of the paper's test has the axial deviator alone, which is the same there.
    let von_mises = run.column("von_mises_ratio");
    let (ratio, label): (Vec<f64>, _) = match von_mises.is_empty() {
        true => (run.column("stress_ratio").to_vec(), "Stress ratio *q*/*p*"),
        false => (von_mises.iter().map(|ratio| ratio.abs()).collect(), "Stress ratio *q*_{vM}/*p*"),
    };
    let measured: Vec<[f64; 2]> = strains.iter().zip(&ratio).map(|(&x, &y)| [x, y]).collect();
    let relation = Plot::new(strain_axis(std::slice::from_ref(run)), Axis::new(label).including(0.0))
        .with(Layer::stroked(measured, Stroke::new(INK, 1.2)).named("measured"))
        .with(
            Layer::line(run.against_strain("stress_force_fabric_ratio"), color(1))
                .named("2/5 (*a*_{c} + *a*_{n} + 3/2 *a*_{t})"),
        );
    let caption = "(a) Anisotropies of contact normals, normal forces and tangential forces; (b) the ratio of the deviator stress (the von Mises stress *q*_{vM} where the invariants were recorded) to the \
                   mean stress that follows from them to first order (Rothenburg and Bathurst 1989), and the measured one.";
    let figure = Figure::new("Anisotropies against strain", 2, vec![first, Panel::plot(relation)]);
    Some(("anisotropies", figure, caption.into()))
}

fn chains(run: &RunReport) -> Option<Named> {
    let columns =
        [("chain_grain_fraction", "grains in chains"), ("buckling_fraction", "segments that buckle")];
    let panel = panel(run, "Fraction", &columns)?;
    let caption = "Grains in force chains (Peters et al. 2005) over all grains; segments of three grains that bend by more than 2 degrees \
                   within 1 % of strain.";
    Some(("chains", Figure::new("Force chains against strain", 1, vec![panel]), caption.into()))
}

/// The radial distribution function of the first and the last state.
fn distances(run: &RunReport) -> Option<Named> {
    let states = run.record.histograms("distances");
    let number = |column: &str, k: usize| run.column(column).get(k).copied();
    let line = |k: usize| {
        let (observations, grains) = (number("observations", k)?, number("grains", k)?);
        let g =
            radial_distribution(states.get(k)?, observations, grains, number("cell_volume_in_diameters", k)?);
        Some(g.into_iter().map(|(r, g)| [r, g]).collect::<Vec<_>>())
    };
    let last = states.len().checked_sub(1)?;
    let plot = Plot::new(Axis::new("Distance *r*/*d*"), Axis::new("Radial distribution *g*").including(0.0))
        .with(Layer::line(line(0)?, color(0)).named("first state"))
        .with(Layer::line(line(last)?, color(1)).named("last state"));
    let caption =
        "Density of centres at a distance from a centre, over the mean density; distances in mean diameters.";
    Some((
        "distances",
        Figure::new("Radial distribution function", 1, vec![Panel::plot(plot)]),
        caption.into(),
    ))
}

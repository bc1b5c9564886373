//! The energy balance by mechanism.

use granum_core::energy::MechanismGroup;
use granum_dem::bond::BOND_CHANNELS;
use granum_dem::contact::EnergyFate;

use super::data::{RunReport, column};
use super::figure::palette::{GREY, INK, color};
use super::figure::{Axis, Figure, Layer, Panel, Plot, Stroke};
use super::material::strain_axis;

/// What becomes of the energy of a mechanism, which determines its line.
#[derive(Clone, Copy, PartialEq)]
enum Fate {
    /// It can be recovered: dashed, in the color of this number.
    Elastic(usize),
    /// It is kinetic: grey, since it is small in a quasi-static test.
    Kinetic,
    /// It is lost.
    Lost,
}

/// The energy that went into a mechanism since the first recorded state, J.
struct Mechanism {
    name: &'static str,
    fate: Fate,
    values: Vec<f64>,
}

/// Energies that every set of laws stores, with the column of each, in the order of the figure.
const STORED: [(&str, Fate, &str); 3] = [
    ("normal elastic", Fate::Elastic(0), "elastic_normal_energy"),
    ("tangential elastic", Fate::Elastic(1), "elastic_tangential_energy"),
    ("kinetic", Fate::Kinetic, "kinetic_energy"),
];
/// The energy that only contacts which resist rolling store, and that of grains that attract each other at a distance.
const ROLLING: (&str, Fate, &str) = ("rolling elastic", Fate::Elastic(2), "elastic_rolling_energy");
const ATTRACTION: (&str, Fate, &str) = ("attraction", Fate::Elastic(3), "attraction_energy");
/// What bonds store.
const BONDS: (&str, Fate, &str) = ("bonds elastic", Fate::Elastic(4), "bond_energy");

/// What is lost in the mechanisms of a group, with the column of each.
fn losses(group: MechanismGroup) -> impl Iterator<Item = (&'static str, Fate, &'static str)> {
    group.mechanisms().filter_map(|mechanism| Some((mechanism.loss?, Fate::Lost, mechanism.column)))
}

/// Range of the shares of the final work that is shown.
const SHOWN: [f64; 2] = [1e-6, 2.0];

/// The boundary work by mechanism, each since the first recorded state, J.
struct Balance {
    work: Vec<f64>,
    parts: Vec<Mechanism>,
}

impl Balance {
    fn from_run(run: &RunReport) -> Option<Balance> {
        let record = &run.record;
        let rows = record.series.rows();
        let since_start = |name: &str| -> Option<Vec<f64>> {
            let values = column(record, name);
            let first = *values.first()?;
            (values.len() == rows).then(|| values.iter().map(|value| value - first).collect())
        };
        let mut parts = Vec::new();
        for (name, fate, column) in losses(MechanismGroup::Forces).chain(STORED) {
            parts.push(Mechanism { name, fate, values: since_start(column)? });
        }
        // The columns of the channels that contact laws declare exist if there is energy in them.
        let mut elastic = 3;
        let channels = run.case.contact.channels().into_iter().flatten().map(|channel| {
            let fate = match channel.fate {
                EnergyFate::Dissipated => Fate::Lost,
                EnergyFate::Stored => {
                    elastic += 1;
                    Fate::Elastic(elastic)
                }
            };
            (channel.label, fate, channel.key)
        });
        // The columns of rolling and of attraction exist only where a law has them.
        let rolling = losses(MechanismGroup::Couples).chain([ROLLING]);
        let attraction = losses(MechanismGroup::Attraction).chain([ATTRACTION]);
        let bonds =
            BOND_CHANNELS.iter().map(|channel| (channel.label, Fate::Lost, channel.key)).chain([BONDS]);
        for (name, fate, column) in rolling.chain(attraction).chain(channels).chain(bonds) {
            parts.extend(since_start(column).map(|values| Mechanism { name, fate, values }));
        }
        Some(Balance { work: since_start("boundary_work")?, parts })
    }

    /// Boundary work minus the sum of all mechanisms.
    fn residual(&self) -> Vec<f64> {
        (0..self.work.len())
            .map(|k| self.work[k] - self.parts.iter().map(|part| part.values[k]).sum::<f64>())
            .collect()
    }
}

/// Largest error of the energy balance over the total boundary work; `None` if the balance was not recorded.
pub fn closure(run: &RunReport) -> Option<f64> {
    let balance = Balance::from_run(run)?;
    let work = balance.work.last().copied().filter(|work| work.abs() > 0.0)?;
    let residual = balance.residual();
    let all_finite = residual.iter().all(|r| r.is_finite());
    all_finite.then(|| residual.iter().fold(0.0f64, |largest, r| largest.max(r.abs())) / work.abs())
}

/// Shares of the boundary work at the end by mechanism, in decreasing order.
pub fn shares(run: &RunReport) -> Vec<(&'static str, f64)> {
    let Some(balance) = Balance::from_run(run) else { return Vec::new() };
    let Some(work) = balance.work.last().copied().filter(|work| *work > 0.0) else { return Vec::new() };
    let mut shares: Vec<(&str, f64)> = (balance.parts.iter())
        .filter_map(|part| Some((part.name, part.values.last()? / work)))
        .filter(|(_, share)| share.is_finite())
        .collect();
    shares.sort_by(|a, b| b.1.total_cmp(&a.1));
    shares
}

/// Figure of the energy by mechanism and of the error of the energy balance.
pub fn figure(run: &RunReport) -> Option<(Figure, String)> {
    let balance = Balance::from_run(run)?;
    let axis = || strain_axis(std::slice::from_ref(run));
    let strain = run.strain();
    let points =
        |values: &[f64]| -> Vec<[f64; 2]> { strain.iter().zip(values).map(|(&x, &y)| [x, y]).collect() };
    let work = balance.work.last().copied().filter(|work| *work != 0.0).unwrap_or(f64::NAN);
    let shares = |values: &[f64]| points(&values.iter().map(|value| value / work).collect::<Vec<_>>());
    // On a linear scale only friction would be distinguishable from the axis.
    let scale = Axis::new("Energy over final work").logarithmic().between(SHOWN[0], SHOWN[1]);
    let mut energies = Plot::new(axis(), scale)
        .with(Layer::stroked(shares(&balance.work), Stroke::new(INK, 1.6)).named("boundary work"));
    // Mechanisms that the laws of the run do not have would take names and colours from the others.
    let present = balance.parts.iter().filter(|part| part.values.iter().any(|value| *value != 0.0));
    let mut losses = 0;
    for Mechanism { name, fate, values } in present {
        let stroke = match fate {
            Fate::Elastic(n) => Stroke::new(color(*n), 1.3).dashed(&[5.0, 3.0]),
            Fate::Kinetic => Stroke::new(GREY, 1.3),
            Fate::Lost => {
                losses += 1;
                Stroke::new(color(losses - 1), 1.3)
            }
        };
        energies = energies.with(Layer::stroked(shares(values), stroke).named(name));
    }
    let error: Vec<f64> = balance.residual().iter().map(|r| r / work).collect();
    let ends = strain.iter().fold([0.0f64; 2], |[low, high], &x| [low.min(x), high.max(x)]);
    let closing = Plot::new(axis(), Axis::new("Residual over final work").including(0.0))
        .with(Layer::stroked(ends.map(|x| [x, 0.0]).to_vec(), Stroke::new(GREY, 0.8)))
        .with(Layer::line(points(&error), color(0)));
    let panels = vec![Panel::plot(energies), Panel::plot(closing)];
    let caption = "(a) Boundary work since the first recorded state, and the energies into which it went, as shares of \
                   that work; elastic energies (dashed) are recoverable. (b) Boundary work that no mechanism accounts \
                   for, as a share of it.";
    Some((Figure::new("Energy by mechanism against strain", 2, panels), caption.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_core::{Column, Table};
    use granum_sensors::Record;

    #[test]
    fn what_no_mechanism_accounts_for_is_the_error() {
        let columns: [(&str, [f64; 2]); 10] = [
            ("deviator_strain", [0.0, 0.1]),
            ("boundary_work", [1.0, 11.0]),
            ("friction_loss", [0.0, 4.0]),
            ("micro_slip_loss", [0.0, 1.0]),
            ("damping_loss", [0.0, 1.0]),
            ("adhesion_made_loss", [0.0, 0.3]),
            ("adhesion_broken_loss", [0.0, 0.2]),
            ("kinetic_energy", [0.0, 0.1]),
            ("elastic_normal_energy", [5.0, 7.0]),
            ("elastic_tangential_energy", [1.0, 2.0]),
        ];
        let columns = columns.map(|(name, values)| Column::new(name, "J", values.to_vec())).to_vec();
        let record = Record { series: Table::new(columns).unwrap(), histograms: Vec::new() };
        // The work of 10 is split into 4 friction, 1 micro-slip, 1 tangential, 1 damping, 0.5 adhesion, 0.1 kinetic and 2
        // normal, so that 0.4 is missing.
        let run = RunReport { record, ..RunReport::default() };
        assert!((closure(&run).unwrap() - 0.04).abs() < 1e-12);
        let shares = shares(&run);
        assert_eq!(shares[0].0, "sliding friction");
        let slip = shares.iter().find(|(name, _)| *name == "micro-slip").unwrap().1;
        assert!((slip - 0.1).abs() < 1e-12);
        assert!(closure(&RunReport::default()).is_none() && figure(&RunReport::default()).is_none());
    }
}

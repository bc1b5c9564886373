//! What a calibration writes in the end: curves, report and results for programs.

use std::io::Write;
use std::path::Path;

use granum_calibration::posterior::band::{BAND_DRAWS, Band};
use granum_calibration::posterior::confirmation::Confirmed;
use granum_calibration::posterior::prediction::Prediction;
use granum_calibration::questions::next_run::NextRun;
use granum_calibration::questions::next_test::NextTest;
use granum_calibration::questions::telling::WhatTestsTell;
use granum_calibration::simulations::emulator::Emulator;
use granum_calibration::simulations::simulation::Simulated;
use granum_calibration::simulations::target::{TargetTest, understood};
use granum_io::shell::{ShowPath, quoted_path};
use granum_io::{Table, atomic::write_atomically};
use granum_report::calibration::{CalibratedCurve, CalibrationReport, curves_figure, report};
use serde_json::{Value, json};

use super::calibration::Calibration;
use super::infer::Found;
use crate::command::text_table;
use crate::failure::Failure;
use crate::output;

/// Points of a band.
const BAND_POINTS: usize = 40;

/// What stands above a posterior against which something speaks.
const BEFORE_USE: &str = "BEFORE THE POSTERIOR IS USED:";

/// What a surrogate tells beside the posterior.
pub struct Told<'a> {
    pub emulator: Emulator<'a>,
    pub telling: WhatTestsTell,
    pub next_test: NextTest,
    pub next_run: Option<NextRun>,
}

/// Writes a text file.
pub fn write(path: &Path, text: &str) -> Result<(), Failure> {
    Ok(write_atomically(path, |file| file.write_all(text.as_bytes()))?)
}

/// Writes a text file.
pub fn put(text: String, path: &Path) -> Result<(), Failure> {
    write(path, &text)
}

impl Calibration<'_> {
    /// Writes the results that [`Calibration::save_posterior`] has not written, and prints the posterior.
    pub fn finish(
        &self,
        found: &Found,
        surrogate: Option<&Told>,
        confirmed: &[Confirmed],
        simulated: &[Simulated],
        further: Vec<String>,
    ) -> Result<(), Failure> {
        // What speaks against the posterior comes before everything else that is said of it.
        let fit = self.fit(self.targets, surrogate.map(|told| &told.emulator), &found.outcome, confirmed)?;
        let against = fit.lines();
        let remarks: Vec<String> = against.iter().cloned().chain(further).collect();
        remarks.iter().for_each(|remark| self.context.warn(remark));
        let at = |name: &str| self.out.join(name);
        let table = self.posterior_table(found)?;
        let curves = self.curves(found, surrogate.map(|told| &told.emulator), simulated)?;
        put(curves_figure(&curves).to_svg(), &at("curves.svg"))?;
        let predictions =
            surrogate.map(|told| self.predictions(found, &told.emulator)).transpose()?.unwrap_or_default();
        let names: Vec<&str> = self.targets.iter().map(|target| target.name.as_str()).collect();
        let document = report(&CalibrationReport {
            subtitle: format!("tests {}; {}", names.join(", "), found.how),
            understood: understood(self.file, self.targets),
            telling: surrogate.map(|told| &told.telling),
            next_test: surrogate.map(|told| &told.next_test),
            next_run: surrogate.and_then(|told| told.next_run.as_ref()),
            outcome: &found.outcome,
            table: &table,
            curves,
            confirmed,
            remarks: remarks.clone(),
        });
        document.write(&self.out)?;
        let mut result = self.as_json(found, surrogate, confirmed, &table, &remarks, &predictions);
        result["explains_the_tests"] = json!(fit.explains());
        result["fit"] = json!(fit);
        result["against_the_posterior"] = json!(against);
        put(format!("{result:#}\n"), &at("calibration.json"))?;
        output::say_complete(self.context, &self.out, &result, || {
            let mut lines = Vec::new();
            if !against.is_empty() {
                lines.push(BEFORE_USE.to_string());
                lines.extend(against.iter().map(|line| format!("  {line}")));
                lines.push(String::new());
            }
            lines.push(self.text(&table, confirmed, &predictions));
            lines.join("\n")
        })
    }

    /// The measured curves with what the posterior predicts of them.
    fn curves(
        &self,
        found: &Found,
        emulator: Option<&Emulator>,
        simulated: &[Simulated],
    ) -> Result<Vec<CalibratedCurve>, Failure> {
        let draws = found.outcome.spread(BAND_DRAWS);
        let emulator = emulator.map(|emulator| emulator.for_targets(self.all));
        let mut all = Vec::new();
        for (test, target) in self.all.iter().enumerate() {
            for (place, curve) in &target.curves {
                let quantity = self.file.calibration.quantities[*place].quantity;
                let last = curve.strain.last().copied().unwrap_or(0.0);
                let strain: Vec<f64> =
                    (0..=BAND_POINTS).map(|k| last * k as f64 / BAND_POINTS as f64).collect();
                // Neither inadequacy nor measurement: what simulations at the draws would give.
                let none = |_: &[f64], mean: &[f64]| vec![0.0; mean.len()];
                let band = |emulator: &Emulator| Band::new(emulator, &draws, (test, *place), &strain, none);
                let band = emulator.as_ref().map(band).transpose()?.unwrap_or_default();
                let ends =
                    band.mean.iter().zip(&band.half_width).map(|(mean, half)| [mean - half, mean + half]);
                let band = strain.iter().zip(ends).map(|(strain, [low, high])| [*strain, low, high]);
                let pairs = |xs: &[f64], ys: &[f64]| -> Vec<[f64; 2]> {
                    xs.iter().zip(ys).map(|(x, y)| [*x, *y]).collect()
                };
                let own = simulated.iter().filter(|one| one.simulation.test == test);
                all.push(CalibratedCurve {
                    test: if test < self.targets.len() {
                        target.name.clone()
                    } else {
                        format!("{} (predicted)", target.name)
                    },
                    quantity: curve.quantity.clone(),
                    unit: quantity.unit().into(),
                    measured: pairs(&target.laboratory.axial_strain, &quantity.readings(&target.laboratory)),
                    band: band.collect(),
                    simulated: own
                        .map(|one| pairs(&one.curves.axial_strain, &quantity.readings(&one.curves)))
                        .collect(),
                });
            }
        }
        Ok(all)
    }

    fn as_json(
        &self,
        found: &Found,
        surrogate: Option<&Told>,
        confirmed: &[Confirmed],
        table: &Table,
        remarks: &[String],
        predictions: &[Prediction],
    ) -> Value {
        let column = |name: &str, row: usize| {
            table.values(name).and_then(|values| values.get(row)).filter(|value| value.is_finite()).copied()
        };
        let keys =
            ["mean", "standard_deviation", "quantile_5", "median", "quantile_95", "r_hat", "effective_bulk"];
        let units = self.units();
        let names =
            |targets: &[TargetTest]| targets.iter().map(|target| target.name.clone()).collect::<Vec<_>>();
        let parameter = |(row, name): (usize, &String)| {
            let mut object = json!({ "name": name, "unit": units.get(row) });
            for key in keys {
                object[key] = json!(column(key, row));
            }
            object
        };
        json!({
            "folder": output::path(&self.out),
            "granum_version": env!("CARGO_PKG_VERSION"),
            "method": self.file.calibration.method.word(),
            "found_by": found.how,
            "tests": names(self.targets),
            "predicted_tests": names(&self.all[self.targets.len()..]),
            "parameters": found.outcome.names.iter().enumerate().map(parameter).collect::<Vec<_>>(),
            "what_tests_tell": surrogate.map(|told| &told.telling),
            "not_told": surrogate.map(|told| told.telling.warnings()),
            "next_test": surrogate.map(|told| &told.next_test),
            "next_run": surrogate.and_then(|told| told.next_run.as_ref()),
            "confirmation": confirmed,
            "share_outside_intervals": granum_calibration::posterior::confirmation::share_outside(confirmed),
            "predictions": predictions,
            "remarks": remarks,
        })
    }

    fn text(&self, table: &Table, confirmed: &[Confirmed], predictions: &[Prediction]) -> String {
        let shown = ["parameter", "unit", "mean", "standard_deviation", "quantile_5", "quantile_95"];
        let columns = table.columns_where(|column| shown.contains(&column.name.as_str()));
        let mut lines = text_table::lines(&columns);
        lines.push(String::new());
        lines.push(
            "simulations at draws from the posterior (root mean square over the largest reading):".into(),
        );
        if confirmed.is_empty() {
            lines.pop();
        }
        for (_, curve) in self.all.iter().flat_map(|target| &target.curves) {
            let own = confirmed.iter().filter(|one| one.test == curve.test && one.quantity == curve.quantity);
            let misfits: Vec<f64> = own.clone().map(|one| one.misfit).collect();
            let of_surrogate: Vec<f64> = own.filter_map(|one| one.misfit_of_surrogate).collect();
            let mean = |values: &[f64]| 100.0 * values.iter().sum::<f64>() / values.len() as f64;
            let surrogate = match of_surrogate.is_empty() {
                true => String::new(),
                false => format!(" (the surrogate said {:.1} %)", mean(&of_surrogate)),
            };
            if !misfits.is_empty() {
                let quantity = curve.quantity.replace('_', " ");
                lines.push(format!("  {} {quantity}: {:.1} %{surrogate}", curve.test, mean(&misfits)));
            }
        }
        let is_predicted = |one: &&Prediction| !self.targets.iter().any(|target| target.name == one.test);
        let predicted: Vec<Prediction> = predictions.iter().filter(is_predicted).cloned().collect();
        if !predicted.is_empty() {
            lines.push("tests that were not calibrated on, predicted by the surrogate:".into());
            lines.extend(super::prediction::summary(&predicted));
        }
        lines.push(format!(
            "wrote {}: posterior.csv, report.html, inference_data.json (for ArviZ), posterior-mean.toml, draws.toml",
            self.out.shown()
        ));
        lines.push(format!(
            "predict with it: granum campaign {} --dry-run",
            quoted_path(&self.out.join("draws.toml"))
        ));
        lines.join("\n")
    }
}

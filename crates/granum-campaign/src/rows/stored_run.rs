//! A run as a piece of bytes: its record, the digest of its results, its series and its histograms, with all bits of its numbers.

use std::collections::BTreeMap;

use granum_core::{Column, Table};
use granum_io::{Machine, RunRecord};
use granum_sensors::{Histogram, Histograms, Record};
use serde::{Deserialize, Serialize};

/// What is kept of a run whose folder may go.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredRun {
    /// The record of its folder, times included.
    pub record: RunRecord,
    /// Digest of its results, as `granum digest` prints it.
    pub digest: String,
    /// The measurements.
    pub measured: Record,
}

/// Everything but the numbers of the columns and the counts of the histograms.
#[derive(Serialize, Deserialize)]
struct Head {
    record: RunRecord,
    // These are left out of the record where it is written.
    machine: Machine,
    wall_seconds: BTreeMap<String, f64>,
    digest: String,
    rows: usize,
    /// The columns without their values.
    columns: Vec<Column>,
    histograms: Vec<HistogramHead>,
}

#[derive(Serialize, Deserialize)]
struct HistogramHead {
    name: String,
    quantity: String,
    unit: String,
    /// Width, number of the first bin and number of bins of each state; one entry if all states are alike.
    bins: Vec<(f64, i64, usize)>,
}

impl StoredRun {
    /// The run as bytes: length of the head, head (JSON), the columns of the series one after another (little-endian doubles), then for
    /// each histogram and state the counts below, above and in the bins (LEB128).
    pub fn encode(&self) -> Vec<u8> {
        let series = &self.measured.series;
        let head = Head {
            record: self.record.clone(),
            machine: self.record.machine.clone(),
            wall_seconds: self.record.wall_seconds.clone(),
            digest: self.digest.clone(),
            rows: series.rows(),
            columns: series.columns().iter().map(without_values).collect(),
            histograms: self.measured.histograms.iter().map(histogram_head).collect(),
        };
        // Numbers, texts and names can always be written.
        let head = serde_json::to_vec(&head).unwrap_or_default();
        let mut bytes = (head.len() as u32).to_le_bytes().to_vec();
        bytes.extend(head);
        for column in series.columns() {
            column.values.iter().for_each(|value| bytes.extend(value.to_le_bytes()));
        }
        for histogram in self.measured.histograms.iter().flat_map(|histograms| &histograms.states) {
            let all = [histogram.below, histogram.above].into_iter().chain(histogram.counts.iter().copied());
            all.for_each(|count| put_count(&mut bytes, count));
        }
        bytes
    }

    /// Reads what [`StoredRun::encode`] wrote; `None` if it is anything else.
    pub fn decode(bytes: &[u8]) -> Option<StoredRun> {
        let mut rest = bytes;
        let length = u32::from_le_bytes(take(&mut rest, 4)?.try_into().ok()?) as usize;
        let head: Head = serde_json::from_slice(take(&mut rest, length)?).ok()?;
        let mut columns = Vec::with_capacity(head.columns.len());
        for column in head.columns {
            let numbers = take(&mut rest, head.rows.checked_mul(8)?)?.chunks_exact(8);
            let values = numbers.map(|bytes| bytes.try_into().map(f64::from_le_bytes));
            columns.push(Column { values: values.collect::<Result<_, _>>().ok()?, ..column });
        }
        let mut histograms = Vec::new();
        for known in head.histograms {
            let mut states = Vec::with_capacity(head.rows.min(rest.len()));
            for row in 0..head.rows {
                let (bin_width, first_bin, bins) = *known.bins.get(row).or(known.bins.first())?;
                let (below, above) = (get_count(&mut rest)?, get_count(&mut rest)?);
                // Each takes a byte at least.
                let mut counts = Vec::with_capacity(bins.min(rest.len()));
                for _ in 0..bins {
                    counts.push(get_count(&mut rest)?);
                }
                states.push(Histogram { bin_width, first_bin, counts, below, above });
            }
            let HistogramHead { name, quantity, unit, .. } = known;
            histograms.push(Histograms { name, quantity, unit, states });
        }
        let record = RunRecord { machine: head.machine, wall_seconds: head.wall_seconds, ..head.record };
        let series = Table::new(columns).ok()?;
        rest.is_empty().then_some(StoredRun {
            record,
            digest: head.digest,
            measured: Record { series, histograms },
        })
    }
}

fn without_values(column: &Column) -> Column {
    let Column { name, unit, kind, words, .. } = column;
    Column { name: name.clone(), unit: unit.clone(), values: Vec::new(), kind: *kind, words: words.clone() }
}

fn histogram_head(histograms: &Histograms) -> HistogramHead {
    let each = histograms.states.iter();
    let mut bins: Vec<(f64, i64, usize)> =
        each.map(|histogram| (histogram.bin_width, histogram.first_bin, histogram.bins())).collect();
    if bins.windows(2).all(|pair| pair[0] == pair[1]) {
        bins.truncate(1);
    }
    let Histograms { name, quantity, unit, .. } = histograms;
    HistogramHead { name: name.clone(), quantity: quantity.clone(), unit: unit.clone(), bins }
}

/// Seven bits a byte, the lowest first; the highest bit says that more follow.
fn put_count(bytes: &mut Vec<u8>, mut count: u64) {
    while count >= 0x80 {
        bytes.push(count as u8 | 0x80);
        count >>= 7;
    }
    bytes.push(count as u8);
}

fn get_count(rest: &mut &[u8]) -> Option<u64> {
    let mut count = 0u64;
    for shift in (0..64).step_by(7) {
        let byte = take(rest, 1)?[0];
        count |= u64::from(byte & 0x7f).checked_shl(shift)?;
        if byte < 0x80 {
            return Some(count);
        }
    }
    None
}

fn take<'a>(rest: &mut &'a [u8], count: usize) -> Option<&'a [u8]> {
    let (taken, left) = rest.split_at_checked(count)?;
    *rest = left;
    Some(taken)
}

#[cfg(test)]
pub(crate) mod tests {
    use granum_io::{Case, RunKind};

    use super::*;

    /// A run with two states.
    pub(crate) fn some_run(friction: f64) -> StoredRun {
        let mut case = Case::default();
        case.set("grains.material.friction", &friction.to_string()).unwrap();
        let mut record = RunRecord::new(RunKind::Test, "0.1.0", &case, Machine::default());
        record.wall_seconds.insert("test".into(), 1.5);
        record.measures.insert("peak_stress_ratio".into(), f64::NAN);
        let series = Table::new(vec![
            Column::new("state", "", vec![0.0, 1.0]),
            Column::new("axial_strain", "", vec![0.0, -0.0]),
            Column::new("stress_ratio", "", vec![friction, 1.0 / 3.0]),
            Column::new("mean_stress", "Pa", vec![1e5, f64::INFINITY]),
        ]);
        let states = [3, 300].map(|count| {
            let mut histogram = Histogram::new(0.5, -1.0, 2.0);
            histogram.counts[2] = count;
            histogram.above = u64::MAX / 3;
            histogram
        });
        let measured = Record::with_forces(series.unwrap(), states.to_vec());
        StoredRun { record, digest: "ab".into(), measured }
    }

    #[test]
    fn every_bit_comes_back_and_a_piece_does_not() {
        let run = some_run(0.3);
        let bytes = run.encode();
        let back = StoredRun::decode(&bytes).unwrap();
        assert_eq!(back.measured, run.measured);
        assert!(back.record.measures["peak_stress_ratio"].is_nan());
        assert_eq!((&back.record.wall_seconds, &back.digest), (&run.record.wall_seconds, &run.digest));
        assert_eq!(back.encode(), bytes);
        for length in 0..bytes.len() {
            assert!(StoredRun::decode(&bytes[..length]).is_none(), "{length}");
        }
    }

    #[test]
    fn bins_may_differ_between_states() {
        let mut run = some_run(0.3);
        run.measured.histograms[0].states[1] = Histogram::new(0.25, 0.0, 1.0);
        assert_eq!(StoredRun::decode(&run.encode()).unwrap().measured, run.measured);
    }

    #[test]
    fn damage_is_no_panic() {
        let bytes = some_run(0.3).encode();
        for at in 0..bytes.len() {
            for bit in [0x01, 0x80, 0xff] {
                let mut damaged = bytes.clone();
                damaged[at] ^= bit;
                let _ = StoredRun::decode(&damaged);
            }
        }
    }
}

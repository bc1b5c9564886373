//! `states.jsonl`: the states of a test that is under way, a line each, written as soon as they are recorded.
//!
//! The tables of a test are written at its checkpoints. In between, this file lets a program, a page or `tail -f` follow the test.
//! It has no part in the result: it is removed when the tables are complete, and a resumed run writes it again from its checkpoint.
//! A line that is not whole, on which the process was killed, is passed over.

use std::collections::BTreeSet;
use std::fs::{self, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::Path;

use granum_core::{Column, Table};
use granum_sensors::{RecordedState, Sensors};

use crate::atomic::write_atomically;
use crate::error::{Error, Result};

/// The file.
pub(super) const STATES: &str = "states.jsonl";

/// Writes the file anew with these states.
pub(super) fn write(path: &Path, states: &[RecordedState]) -> Result<()> {
    write_atomically(path, |file| {
        states.iter().try_for_each(|state| file.write_all(format!("{}\n", state.to_line()).as_bytes()))
    })
}

/// Appends a state.
pub(super) fn append(path: &Path, state: &RecordedState) -> Result<()> {
    let mut file = OpenOptions::new().append(true).open(path).map_err(Error::file("append to", path))?;
    // One call: whoever reads the file sees the whole line or a part of it, never lines that are mixed.
    file.write_all(format!("{}\n", state.to_line()).as_bytes()).map_err(Error::file("append to", path))
}

/// Removes the file, if it is there.
pub(super) fn remove(path: &Path) -> Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(Error::file("remove", path)(error)),
        _ => Ok(()),
    }
}

/// Largest size of the file that is read, bytes.
const LARGEST: u64 = 1 << 32;

/// The states of the file; none if there is no such file.
pub(super) fn read(path: &Path, sensors: &Sensors) -> Result<Vec<RecordedState>> {
    if !path.is_file() {
        return Ok(Vec::new());
    }
    let bytes = match granum_core::input::read(path, LARGEST) {
        Ok(bytes) => bytes,
        // The run ended in this moment.
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(Error::file("read", path)(error)),
    };
    let text = String::from_utf8_lossy(&bytes);
    let mut seen = BTreeSet::new();
    let states = text.lines().filter_map(|line| RecordedState::from_line(line, sensors));
    Ok(states.filter(|state| key_of(state).is_some_and(|key| seen.insert(key))).collect())
}

/// Stage and state; the stage is 1 in a test that is not given as stages.
type Key = (u64, u64);

fn key(stage: Option<f64>, state: f64) -> Option<Key> {
    let whole = |x: f64| (x >= 0.0 && x.fract() == 0.0 && x < 1e15).then_some(x as u64);
    Some((whole(stage.unwrap_or(1.0))?, whole(state)?))
}

fn key_of(state: &RecordedState) -> Option<Key> {
    key(state.value("stage"), state.value("state")?)
}

/// The rows of a saved table together with those of states that were recorded since. A state that is in both was under way when the
/// table was saved, and is taken from the later rows. What cannot be told apart is left as it was saved.
pub(super) fn joined(saved: Option<Table>, later: Table) -> Table {
    let Some(saved) = saved else { return later };
    let (Some(before), Some(after)) = (keys(&saved), keys(&later)) else { return saved };
    let replaced: BTreeSet<Key> = after.iter().copied().collect();
    // Rows by key, those of one key in the order of their table.
    let kept =
        before.iter().enumerate().filter(|(_, key)| !replaced.contains(key)).map(|(row, key)| (*key, 0, row));
    let new = after.iter().enumerate().map(|(row, key)| (*key, 1, row));
    let mut rows: Vec<(Key, usize, usize)> = kept.chain(new).collect();
    rows.sort_unstable();
    let mut table = Table::default();
    let only_later = later.columns().iter().filter(|column| saved.values(&column.name).is_none());
    for column in saved.columns().iter().chain(only_later) {
        // A column that one of the tables lacks has been zero in it.
        let sources = [saved.values(&column.name), later.values(&column.name)];
        let value = |(_, table, row): &(Key, usize, usize)| {
            sources[*table].and_then(|values| values.get(*row)).copied().unwrap_or(0.0)
        };
        let values = rows.iter().map(value).collect();
        // This cannot fail: every column has one value for each row.
        let _ = table.set(Column::new(column.name.clone(), column.unit.clone(), values));
    }
    table
}

fn keys(table: &Table) -> Option<Vec<Key>> {
    let states = table.values("state")?;
    let stages = table.values("stage");
    let stage = |row: usize| stages.and_then(|stages| stages.get(row)).copied();
    states.iter().enumerate().map(|(row, state)| key(stage(row), *state)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_core::observer::NamedValue;

    fn state(stage: f64, state: f64, q: f64) -> RecordedState {
        let named = |name: &'static str, value| NamedValue { name: name.into(), value, unit: "".into() };
        RecordedState {
            values: vec![named("stage", stage), named("state", state), named("q", q)],
            histograms: Vec::new(),
        }
    }

    #[test]
    fn a_torn_line_is_passed_over_and_the_states_are_written_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(STATES);
        let sensors = Sensors::standard();
        assert_eq!(read(&path, &sensors).unwrap(), []);
        write(&path, &[state(1.0, 0.0, 0.5)]).unwrap();
        append(&path, &state(1.0, 1.0, f64::NAN)).unwrap();
        let whole = fs::read(&path).unwrap();
        append(&path, &state(2.0, 0.0, 0.7)).unwrap();
        let all = fs::read(&path).unwrap();
        for cut in 0..=all.len() {
            fs::write(&path, &all[..cut]).unwrap();
            let found = read(&path, &sensors).unwrap();
            let lines = all[..cut].iter().filter(|byte| **byte == b'\n').count();
            // The last line counts without its end too.
            assert!(found.len() == lines || found.len() == lines + 1, "{cut}");
        }
        fs::write(&path, &whole[..whole.len() - 3]).unwrap();
        let kept = read(&path, &sensors).unwrap();
        write(&path, &kept).unwrap();
        append(&path, &state(1.0, 1.0, 0.25)).unwrap();
        let found = read(&path, &sensors).unwrap();
        assert_eq!(found, [state(1.0, 0.0, 0.5), state(1.0, 1.0, 0.25)]);
        remove(&path).unwrap();
        remove(&path).unwrap();
    }

    #[test]
    fn later_states_follow_those_of_the_table_and_replace_the_one_under_way() {
        let table = |states: &[RecordedState]| RecordedState::record(states).series;
        let saved = table(&[state(1.0, 0.0, 0.5), state(1.0, 1.0, 0.6)]);
        let later = table(&[state(1.0, 1.0, 0.65), state(2.0, 0.0, 0.7)]);
        let joined_table = joined(Some(saved.clone()), later.clone());
        assert_eq!(joined_table.values("q"), Some(&[0.5, 0.65, 0.7][..]));
        assert_eq!(joined_table.values("stage"), Some(&[1.0, 1.0, 2.0][..]));
        assert_eq!(joined(Some(saved.clone()), table(&[])), saved, "without later states nothing changes");
        assert_eq!(joined(None, later.clone()), later);
    }
}

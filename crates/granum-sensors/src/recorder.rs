//! Averages looks into recorded states as a test goes on.

use granum_core::assembly::Assembly;
use granum_dem::config::{Recording, Spacing};
use granum_dem::loading::{self, MacroState, Measure};
use serde::{Deserialize, Serialize};

use crate::force_distribution::ForceHistogram;
use crate::{Averaging, Look, Record, all, columns, invariants, stage_columns};

/// Takes looks at a test and averages them into states.
///
/// Of a stage of a test the states may stand at values of another measure than the deviator strain, which the following
/// speaks of, and be asked for at equal intervals without an end ([`Recorder::of_stage`]).
///
/// State k of `0..=states` stands at the deviator strain `k / states` of the end, and its window is one interval
/// wide around it (half a window at the end). Looks are spread evenly over a window, half a spacing off its edges, so
/// that the test is looked at in equal strides. A column of strain is averaged like every other, so each row pairs
/// mean values of the same looks.
///
/// With another [`Spacing`] the window of a state is centred on it too, and as wide as the nearer of its two neighbours
/// is far (the first state's neighbour below is the start, the last one's above is the end), so that windows never
/// overlap.
///
/// State 0 is the sample before it is strained: one look at strain zero. Its window would hold the elastic rise of the
/// stress, which stiff grains have behind them after some 1e-3 of strain; a mean over that is neither the sample nor
/// the sheared state.
///
/// The whole of it can be serialised: a run that is resumed goes on with the same bits.
///
/// ```
/// use granum_dem::{assembly::Assembly, config::Recording};
/// use granum_sensors::Recorder;
///
/// let recording = Recording { states: 2, looks: 4, ..Default::default() };
/// let mut recorder = Recorder::new(&recording, 0.3);
/// let mut assembly = Assembly::default();
/// while assembly.strain[0][0] < 0.3 {
///     if assembly.strain[0][0] >= recorder.next_look() {
///         recorder.look(&assembly);
///     }
///     assembly.strain[0][0] += 0.001;
/// }
/// assert_eq!(recorder.record().series.rows(), 3);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Recorder {
    recording: Recording,
    /// What the places of states are counted in, and what is subtracted from it.
    measure: Measure,
    origin: f64,
    /// Where the last state stands; `None` where there is no last one.
    end: Option<f64>,
    /// True if the general invariants are recorded too.
    general: bool,
    /// State and look within its window that come next.
    next: (usize, usize),
    states: Vec<StateSums>,
}

/// Looks that were asked for and could not be taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Shortfall {
    /// Looks asked for.
    pub wanted: usize,
    /// Looks that were not taken.
    pub missing: usize,
    /// States with fewer looks than asked for.
    pub states: usize,
    /// Those of them with none, which are not in the record.
    pub empty_states: usize,
}

impl Shortfall {
    /// Both together.
    pub fn plus(self, other: Shortfall) -> Shortfall {
        Shortfall {
            wanted: self.wanted + other.wanted,
            missing: self.missing + other.missing,
            states: self.states + other.states,
            empty_states: self.empty_states + other.empty_states,
        }
    }
}

/// What the looks at one state add up to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct StateSums {
    state: usize,
    looks: u64,
    sums: Vec<f64>,
    forces: ForceHistogram,
}

impl Recorder {
    /// A recorder for a test that ends at a deviator strain `end`. Numbers of states or looks of zero count as one.
    pub fn new(recording: &Recording, end: f64) -> Self {
        let recording =
            Recording { states: recording.states.max(1), looks: recording.looks.max(1), ..recording.clone() };
        // Snapshots are not its concern.
        let recording = Recording { snapshots: Vec::new(), ..recording };
        Recorder {
            recording,
            measure: Measure::AxialDeviatorStrain,
            origin: 0.0,
            end: Some(end),
            general: false,
            next: (0, 0),
            states: Vec::new(),
        }
    }

    /// A recorder for a stage whose measure counts from `origin`. Of the recording only the numbers of looks and the bins are
    /// used.
    pub fn of_stage(recording: &Recording, record: &loading::Record, origin: f64) -> Self {
        let recording =
            Recording { states: record.states, spacing: record.spacing.clone(), ..recording.clone() };
        Recorder {
            measure: record.measure,
            origin,
            end: record.end.is_finite().then_some(record.end),
            general: true,
            ..Recorder::new(&recording, 0.0)
        }
    }

    /// What the sensors saw in the stages of a test, one recorder a stage, with their numbers from 1.
    pub fn record_of_stages<'a>(recorders: impl IntoIterator<Item = &'a Recorder>) -> Record {
        let (mut rows, mut forces, mut stages) = (Vec::new(), Vec::new(), Vec::new());
        for (number, recorder) in recorders.into_iter().enumerate() {
            for sums in &recorder.states {
                rows.push((sums.state, sums.looks, sums.averages()));
                forces.push(sums.forces.clone());
                stages.push(number + 1);
            }
        }
        Record::from_states(&rows, forces, Some(&stages))
    }

    /// True if it is one of such a recording to such an end: one that was read back may be damaged or of another test.
    pub fn is_of(&self, recording: &Recording, end: f64) -> bool {
        self.is_like(&Recorder::new(recording, end))
    }

    /// True if it can be what a fresh recorder has come to.
    pub fn is_like(&self, own: &Recorder) -> bool {
        let recording = &own.recording;
        let empty = ForceHistogram::new(recording.bin_width, recording.largest_force);
        let whole = |sums: &StateSums| {
            let forces = &sums.forces;
            sums.sums.len() == own.width()
                && (forces.counts.len(), forces.first_bin) == (empty.counts.len(), empty.first_bin)
                && forces.bin_width == empty.bin_width
                && sums.looks > 0
                && sums.looks <= own.recording.looks as u64
        };
        let (state, look) = self.next;
        self.recording == own.recording
            && (self.measure, self.origin, self.end, self.general)
                == (own.measure, own.origin, own.end, own.general)
            && state <= own.last_state().saturating_add(1)
            && look < own.recording.looks
            && self.states.iter().all(whole)
            && self.states.windows(2).all(|pair| pair[0].state < pair[1].state)
            && self.states.last().is_none_or(|last| last.state <= state)
    }

    /// Number of the last state.
    fn last_state(&self) -> usize {
        match &self.recording.spacing {
            Spacing::Strains(strains) => strains.len(),
            Spacing::Every(_) => usize::MAX,
            Spacing::Equal | Spacing::Geometric(_) => self.recording.states,
        }
    }

    /// Number of columns that are averaged.
    fn width(&self) -> usize {
        if self.general { stage_columns().count() } else { columns().count() }
    }

    /// Value of the measure at the end; infinite without one.
    fn end(&self) -> f64 {
        self.end.unwrap_or(f64::INFINITY)
    }

    /// Distance by which a state may fall short by rounding and is still due.
    fn tolerance(&self) -> f64 {
        match (self.end, &self.recording.spacing) {
            (Some(end), _) => 1e-9 * end,
            (None, Spacing::Every(interval)) => 1e-9 * interval,
            (None, _) => 0.0,
        }
    }

    /// Value of the measure at a state.
    fn strain_of(&self, state: usize) -> f64 {
        let states = self.recording.states;
        let end = self.end();
        match &self.recording.spacing {
            _ if state == 0 => 0.0,
            Spacing::Every(interval) => interval * state as f64,
            Spacing::Strains(strains) => strains.get(state - 1).copied().unwrap_or(end),
            Spacing::Geometric(first) if state < states => {
                first * (end / first).powf((state - 1) as f64 / (states - 1) as f64)
            }
            Spacing::Geometric(_) => end,
            Spacing::Equal => end * (state as f64 / states as f64),
        }
    }

    /// Half the width of the window of a state, where states are not spaced equally.
    fn half_window(&self, state: usize) -> f64 {
        let here = self.strain_of(state);
        let below = 0.5 * (here - self.strain_of(state - 1));
        if state < self.last_state() {
            return below.min(0.5 * (self.strain_of(state + 1) - here));
        }
        if here < self.end() { below.min(self.end() - here) } else { below }
    }

    /// Deviator strain at which the next look is due; infinite when there is none.
    pub fn next_look(&self) -> f64 {
        let (state, look) = self.next;
        if state > self.last_state() {
            return f64::INFINITY;
        }
        if state == 0 {
            return 0.0;
        }
        let offset = (2 * look + 1) as f64 / (2 * self.recording.looks) as f64 - 0.5;
        match self.recording.spacing {
            Spacing::Equal => self.end() * ((state as f64 + offset) / self.recording.states as f64),
            _ => self.strain_of(state) + 2.0 * self.half_window(state) * offset,
        }
    }

    /// Looks that are taken at a state: half of them where the window ends with the test.
    fn looks_of(&self, state: usize) -> usize {
        let looks = self.recording.looks;
        match state {
            0 => 1,
            last if last == self.last_state() && self.strain_of(last) >= self.end() => looks.div_ceil(2),
            _ => looks,
        }
    }

    /// Of the states that are over: how many were recorded with fewer looks than asked for, or with none, and how many looks
    /// that leaves out of how many. Steps of the test that are long against a window are the cause.
    pub fn shortfall(&self) -> Shortfall {
        let mut found = Shortfall::default();
        for state in 0..self.next.0.min(self.last_state().saturating_add(1)) {
            let wanted = self.looks_of(state);
            let at = self.states.binary_search_by_key(&state, |sums| sums.state);
            let taken = at.map_or(0, |at| self.states[at].looks as usize);
            found.wanted += wanted;
            if taken < wanted {
                found.missing += wanted - taken;
                found.states += 1;
                found.empty_states += usize::from(taken == 0);
            }
        }
        found
    }

    /// True when the last look has been taken.
    pub fn is_complete(&self) -> bool {
        self.next.0 > self.last_state()
    }

    /// Looks once, for the last look that is due, and goes on to the first that is not. Before anything is due it does
    /// nothing, so it may be called at any time. A strain that falls short by rounding only is due: the caller may
    /// have added it up in another order.
    pub fn look(&mut self, assembly: &Assembly) {
        let reading = match self.measure.needs_stress() {
            true => MacroState::of(assembly),
            false => MacroState::without_stress(assembly),
        };
        let strain = self.measure.of(&reading) - self.origin + self.tolerance();
        if strain.is_nan() || strain < self.next_look() {
            return;
        }
        // Of several looks that are due it is the last: the nearest to the strain.
        let mut state = 0;
        while self.next_look() <= strain {
            state = self.next.0;
            self.advance();
        }
        if self.states.last().is_none_or(|sums| sums.state != state) {
            self.states.push(StateSums {
                state,
                looks: 0,
                sums: vec![0.0; self.width()],
                forces: ForceHistogram::new(self.recording.bin_width, self.recording.largest_force),
            });
        }
        if let Some(sums) = self.states.last_mut() {
            sums.add(&Look::new(assembly), self.general);
        }
    }

    fn advance(&mut self) {
        let (state, look) = self.next;
        self.next = if look + 1 < self.looks_of(state) { (state, look + 1) } else { (state + 1, 0) };
    }

    /// The record so far: one row a state that has been looked at.
    pub fn record(&self) -> Record {
        let rows: Vec<(usize, u64, Vec<f64>)> =
            self.states.iter().map(|sums| (sums.state, sums.looks, sums.averages())).collect();
        Record::from_states(&rows, self.states.iter().map(|sums| sums.forces.clone()).collect(), None)
    }
}

impl StateSums {
    fn add(&mut self, look: &Look, general: bool) {
        let mut row = Vec::with_capacity(self.sums.len());
        for sensor in all() {
            (sensor.measure)(look, &mut row);
        }
        if general {
            (invariants::SENSOR.measure)(look, &mut row);
        }
        for ((sum, value), column) in self.sums.iter_mut().zip(row).zip(stage_columns()) {
            match column.averaging {
                Averaging::Mean => *sum += value,
                Averaging::RootMeanSquare => *sum += value * value,
                Averaging::Largest => *sum = sum.max(value),
            }
        }
        self.looks += 1;
        self.forces.add(look);
    }

    fn averages(&self) -> Vec<f64> {
        let looks = self.looks as f64;
        self.sums
            .iter()
            .zip(stage_columns())
            .map(|(sum, column)| match column.averaging {
                Averaging::Mean => sum / looks,
                Averaging::RootMeanSquare => (sum / looks).sqrt(),
                Averaging::Largest => *sum,
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;

    fn at(strain: f64) -> Assembly {
        let mut assembly = lattice::simple_cubic(3, 1e-4, 1e-4, 2e-4 * (1.0 + strain));
        assembly.strain = [[strain, 0.0, 0.0], [0.0; 3], [0.0; 3]];
        assembly.target_mean_stress = Some(2e4);
        assembly
    }

    fn run(recorder: &mut Recorder, steps: usize, end: f64) -> usize {
        let mut looks = 0;
        for k in 0..=steps {
            let strain = end * (k as f64 / steps as f64);
            if strain >= recorder.next_look() {
                recorder.look(&at(strain));
                looks += 1;
            }
        }
        looks
    }

    #[test]
    fn windows_are_centred_with_half_a_window_at_the_end() {
        let recording = Recording { states: 4, looks: 6, ..Default::default() };
        let mut recorder = Recorder::new(&recording, 0.4);
        assert_eq!(run(&mut recorder, 2400, 0.4), 1 + 3 * 6 + 3);
        assert!(recorder.is_complete() && recorder.next_look().is_infinite());
        assert!(recorder.is_of(&recording, 0.4) && !recorder.is_of(&recording, 0.3));
        assert!(!recorder.is_of(&Recording { looks: 5, ..recording.clone() }, 0.4));
        let record = recorder.record();
        let strain = record.series.values("deviator_strain").unwrap();
        let step = 0.4 / 2400.0;
        for (k, value) in strain.iter().enumerate() {
            let centre = [0.0, 0.1, 0.2, 0.3, 0.375][k];
            assert!((value - centre).abs() <= step, "state {k}: {value}");
        }
        assert_eq!(record.series.values("looks").unwrap(), [1.0, 6.0, 6.0, 6.0, 3.0]);
        assert_eq!(record.forces[1].contacts(), 6 * 81);
        assert_eq!(record.forces[0].contacts(), 81);
    }

    #[test]
    fn a_single_look_a_state_stands_on_the_state() {
        let recording = Recording { states: 3, looks: 1, ..Default::default() };
        let mut recorder = Recorder::new(&recording, 0.3);
        assert_eq!(recorder.next_look(), 0.0);
        assert_eq!(run(&mut recorder, 300, 0.3), 4);
        let record = recorder.record();
        let strain = record.series.values("deviator_strain").unwrap();
        assert!(strain.iter().enumerate().all(|(k, s)| (s - 0.1 * k as f64).abs() < 1.1e-3), "{strain:?}");
    }

    #[test]
    fn averages_follow_what_the_column_asks_for() {
        let recording = Recording { states: 1, looks: 2, ..Default::default() };
        let mut recorder = Recorder::new(&recording, 0.2);
        recorder.look(&at(0.0));
        recorder.look(&at(0.16));
        let p = Look::new(&at(0.16)).stress.mean();
        let record = recorder.record();
        let value = |name: &str| record.series.values(name).unwrap()[1];
        assert!((value("mean_stress") / p - 1.0).abs() < 1e-12);
        assert!((value("servo_error_rms") - (p / 2e4 - 1.0).abs()).abs() < 1e-12);
        assert!((value("servo_error_largest") - (p / 2e4 - 1.0).abs()).abs() < 1e-12);
        assert!((value("largest_overlap") - 1e-4).abs() < 1e-12);
    }

    #[test]
    fn strides_longer_than_a_window_leave_states_out_and_early_looks_do_nothing() {
        let recording = Recording { states: 10, looks: 4, ..Default::default() };
        let mut recorder = Recorder::new(&recording, 1.0);
        for strain in [0.0, 0.01, 0.02, 0.5, 0.5, 1.0] {
            recorder.look(&at(strain));
        }
        assert_eq!(recorder.record().series.values("state").unwrap(), [0.0, 5.0, 10.0]);
        assert!(recorder.is_complete());
    }

    /// Strains of the looks that are due, one by one.
    fn due(mut recorder: Recorder) -> Vec<f64> {
        let mut due = Vec::new();
        while !recorder.is_complete() {
            due.push(recorder.next_look());
            recorder.advance();
        }
        due
    }

    #[test]
    fn states_stand_where_a_geometric_spacing_or_a_list_says() {
        let near = |found: &[f64], wanted: &[f64]| {
            assert_eq!(found.len(), wanted.len(), "{found:?}");
            for (a, b) in found.iter().zip(wanted) {
                assert!((a - b).abs() <= 1e-12 * b.abs(), "{found:?}");
            }
        };
        let one = Recording { states: 4, looks: 1, ..Default::default() };
        let geometric = Recording { spacing: Spacing::Geometric(1e-4), ..one.clone() };
        near(&due(Recorder::new(&geometric, 0.1)), &[0.0, 1e-4, 1e-3, 1e-2, 0.1]);
        let list = Recording { spacing: Spacing::Strains(vec![0.01, 0.02, 0.05]), ..one };
        near(&due(Recorder::new(&list, 0.1)), &[0.0, 0.01, 0.02, 0.05]);
        // A window is as wide as the nearer neighbour is far, and never reaches into the next.
        let two = Recording { looks: 2, ..list.clone() };
        near(&due(Recorder::new(&two, 0.1)), &[0.0, 0.0075, 0.0125, 0.0175, 0.0225, 0.0425, 0.0575]);
        // At the end of the test half a window is left, with half of the looks.
        near(&due(Recorder::new(&two, 0.05)), &[0.0, 0.0075, 0.0125, 0.0175, 0.0225, 0.0425]);
        let mut recorder = Recorder::new(&list, 0.1);
        run(&mut recorder, 1000, 0.1);
        assert!(recorder.is_complete() && recorder.is_of(&list, 0.1) && !recorder.is_of(&geometric, 0.1));
        assert_eq!(recorder.record().series.values("state").unwrap(), [0.0, 1.0, 2.0, 3.0]);
        assert_eq!(recorder.shortfall(), Shortfall { wanted: 4, ..Shortfall::default() });
    }

    #[test]
    fn looks_that_could_not_be_taken_are_counted() {
        let recording = Recording { states: 10, looks: 4, ..Default::default() };
        let mut recorder = Recorder::new(&recording, 1.0);
        assert_eq!(recorder.shortfall(), Shortfall::default());
        for strain in [0.0, 0.5, 1.0] {
            recorder.look(&at(strain));
        }
        // State 0 wants one look, the last one two, the others four; one was taken at 0, 5 and 10.
        let found = recorder.shortfall();
        assert_eq!((found.wanted, found.missing), (1 + 9 * 4 + 2, 9 * 4 - 1 + 1));
        assert_eq!((found.states, found.empty_states), (10, 8));
    }

    #[test]
    fn a_strain_short_by_rounding_is_due() {
        let mut recorder = Recorder::new(&Recording { states: 3, looks: 2, ..Default::default() }, 0.3);
        recorder.look(&at(0.0));
        let before = recorder.next_look();
        assert!(before > 0.0);
        recorder.look(&at(before * (1.0 - 1e-15)));
        assert!(recorder.next_look() > before);
    }

    #[test]
    fn nothing_looked_at_is_an_empty_record() {
        let recorder = Recorder::new(&Recording { states: 0, looks: 0, ..Default::default() }, 0.3);
        assert_eq!(recorder.record().series.rows(), 0);
        assert!(recorder.record().forces.is_empty());
    }

    /// A recorder that is written down and read back in the middle goes on with the same bits.
    #[test]
    fn a_resumed_recorder_goes_on_with_the_same_bits() {
        let recording = Recording { states: 5, looks: 4, ..Default::default() };
        let mut whole = Recorder::new(&recording, 0.3);
        let mut first = Recorder::new(&recording, 0.3);
        let strains: Vec<f64> = (0..=600).map(|k| 0.3 * k as f64 / 600.0).collect();
        for &strain in &strains {
            whole.look(&at(strain));
        }
        for &strain in &strains[..250] {
            first.look(&at(strain));
        }
        let text = serde_json::to_string(&first).unwrap();
        let mut second: Recorder = serde_json::from_str(&text).unwrap();
        assert_eq!(second, first);
        for &strain in &strains[250..] {
            second.look(&at(strain));
        }
        assert_eq!(whole, second);
        assert_eq!(whole.record(), second.record());
    }
}

//! What the channels of a path are in the graph of an ONNX file: linear functions of columns, of which those of a stress whose mean part varies by much are divided by it.

use super::channels::{Channels, ScalarChannel, Source};
use super::rotation::{COMPONENTS, parts, whole};
use super::tensor_channel::{TensorChannel, least_sum};
use crate::onnx::{OnnxGraph, Value};

/// A value of a network and columns: the sum of some of these with factors, or a contribution to each of them, with the middle and the scale of the value.
struct LinearTerm {
    /// Places of columns with their factors.
    factors: Vec<(usize, f64)>,
    middle: f64,
    scale: f64,
    of_mean: OfMean,
}

/// What a value has to do with a mean part that varies by much.
enum OfMean {
    Nothing,
    /// It is a component of the deviator, a multiple of the mean part.
    Multiple(Mean),
    /// It is the logarithm of the mean part.
    Logarithm(Mean),
}

/// A mean part with its offset.
struct Mean {
    /// The columns of which it is the sum with these factors; for outputs the place of its logarithm among the values of the network.
    factors: Vec<(usize, f64)>,
    offset: f64,
}

impl LinearTerm {
    fn mean(&self) -> Option<&Mean> {
        match &self.of_mean {
            OfMean::Nothing => None,
            OfMean::Multiple(mean) | OfMean::Logarithm(mean) => Some(mean),
        }
    }

    fn is_logarithm(&self) -> bool {
        matches!(self.of_mean, OfMean::Logarithm(_))
    }
}

/// The mean part of a tensor with these places, if it varies by much.
fn mean_of(channel: &TensorChannel, places: &[usize; 6]) -> Option<Mean> {
    let factors = || places[..3].iter().map(|place| (*place, 1.0 / 3.0)).collect();
    channel.offset.map(|offset| Mean { factors: factors(), offset })
}

/// For each term one number.
fn numbers(terms: &[LinearTerm], of: impl Fn(&LinearTerm) -> f64) -> Vec<f64> {
    terms.iter().map(of).collect()
}

/// A row of booleans, one for each term.
fn mask(graph: &mut OnnxGraph, terms: &[LinearTerm]) -> Value {
    let row = graph.row(&numbers(terms, |term| f64::from(u8::from(term.is_logarithm()))));
    let zero = graph.number(0.0);
    graph.apply("Greater", &[&row, &zero])
}

/// The start values of the sequences of which these are the first rows.
pub(super) fn starts(graph: &mut OnnxGraph, channels: &Channels, row: &Value, inputs: usize) -> Value {
    let terms = channels.start_terms();
    let table = |of: &dyn Fn(&LinearTerm) -> Vec<(usize, f64)>| {
        let mut factors = vec![0.0; inputs * terms.len()];
        for (k, term) in terms.iter().enumerate() {
            of(term).iter().for_each(|(place, factor)| factors[place * terms.len() + k] = *factor);
        }
        factors
    };
    let mut sums = graph.linear(row, inputs, &table(&|term| term.factors.clone()), None);
    if terms.iter().any(|term| term.mean().is_some()) {
        let factors = table(&|term| term.mean().map_or(Vec::new(), |mean| mean.factors.clone()));
        let constant = numbers(&terms, |term| term.mean().map_or(1.0, |mean| mean.offset));
        let means = graph.linear(row, inputs, &factors, Some(&constant));
        let least =
            graph.row(&numbers(&terms, |term| term.mean().map_or(1.0, |mean| least_sum(mean.offset))));
        let means = graph.apply("Max", &[&means, &least]);
        let (logarithms, multiples) = (graph.apply("Log", &[&means]), graph.apply("Div", &[&sums, &means]));
        let mask = mask(graph, &terms);
        sums = graph.apply("Where", &[&mask, &logarithms, &multiples]);
    }
    let scales = numbers(&terms, |term| 1.0 / term.scale);
    graph.scaled(&sums, &numbers(&terms, |term| term.middle), &scales, &vec![0.0; terms.len()])
}

/// The outputs in their units from those of a network.
pub(super) fn outputs(graph: &mut OnnxGraph, channels: &Channels, values: &Value, outputs: usize) -> Value {
    let (terms, constant) = channels.output_terms(outputs);
    let (middles, scales) = (numbers(&terms, |term| term.middle), numbers(&terms, |term| term.scale));
    let mut scaled = graph.scaled(values, &vec![0.0; terms.len()], &scales, &middles);
    if terms.iter().any(|term| term.mean().is_some()) {
        scaled = with_means(graph, &terms, &scaled);
    }
    let mut factors = vec![0.0; terms.len() * outputs];
    for (k, term) in terms.iter().enumerate() {
        term.factors.iter().for_each(|(place, factor)| factors[k * outputs + place] = *factor);
    }
    graph.linear(&scaled, terms.len(), &factors, Some(&constant))
}

/// The scaled values with mean parts in place of their logarithms, and deviators in place of their multiples.
fn with_means(graph: &mut OnnxGraph, terms: &[LinearTerm], scaled: &Value) -> Value {
    let is_logarithm = graph.row(&numbers(terms, |term| f64::from(u8::from(term.is_logarithm()))));
    let logarithms = graph.apply("Mul", &[scaled, &is_logarithm]);
    let means = graph.apply("Exp", &[&logarithms]);
    let mut factors = vec![0.0; terms.len() * terms.len()];
    for (k, term) in terms.iter().enumerate() {
        if let OfMean::Multiple(mean) = &term.of_mean {
            mean.factors.iter().for_each(|(place, factor)| factors[place * terms.len() + k] = *factor);
        }
    }
    let constant = numbers(terms, |term| f64::from(u8::from(!matches!(term.of_mean, OfMean::Multiple(_)))));
    let units = graph.linear(&means, terms.len(), &factors, Some(&constant));
    let offsets = graph.row(&numbers(terms, |term| {
        term.mean().filter(|_| term.is_logarithm()).map_or(0.0, |mean| mean.offset)
    }));
    let means = graph.apply("Sub", &[&means, &offsets]);
    let mask = mask(graph, terms);
    let values = graph.apply("Where", &[&mask, &means, scaled]);
    graph.apply("Mul", &[&values, &units])
}

/// By what the errors of outputs are divided ([`Channels::units`]), from the answers of all networks; none if it is one for all of them.
pub(super) fn units(
    graph: &mut OnnxGraph,
    channels: &Channels,
    answers: &[Value],
    outputs: usize,
) -> Option<Value> {
    let mut factors = vec![0.0; outputs * outputs];
    let (mut constant, mut least) = (vec![1.0; outputs], vec![1.0; outputs]);
    for channel in &channels.tensors {
        let Some(Mean { factors: of_mean, offset }) = mean_of(channel, &channel.outputs) else { continue };
        for place in channel.outputs {
            of_mean.iter().for_each(|(from, factor)| factors[from * outputs + place] = *factor);
            (constant[place], least[place]) = (offset, least_sum(offset));
        }
    }
    if factors.iter().all(|factor| *factor == 0.0) {
        return None;
    }
    let mut sum = answers[0].clone();
    for answer in &answers[1..] {
        sum = graph.apply("Add", &[&sum, answer]);
    }
    let share = graph.number(1.0 / answers.len() as f64);
    let mean = graph.apply("Mul", &[&sum, &share]);
    let sums = graph.linear(&mean, outputs, &factors, Some(&constant));
    let least = graph.row(&least);
    Some(graph.apply("Max", &[&sums, &least]))
}

impl Channels {
    /// For each input true if its first increment counts from zero: that of a strain, which is one of the sample.
    pub fn begin_at_zero(&self, inputs: usize) -> Vec<bool> {
        let is_strain = |place: usize| self.strain.iter().flatten().any(|strain| *strain == place);
        (0..inputs).map(is_strain).collect()
    }

    /// The start values in their order as linear functions of the first row.
    fn start_terms(&self) -> Vec<LinearTerm> {
        let component = |channel: &TensorChannel, c: usize| {
            let unit = |k: usize| parts(std::array::from_fn(|j| f64::from(u8::from(j == k)))).0[c];
            let places = channel.start.iter().flat_map(|places| places.iter().enumerate());
            let factors = places.map(|(k, place)| (*place, unit(k))).collect();
            let mean = channel.start.and_then(|places| mean_of(channel, &places));
            let of_mean = mean.map_or(OfMean::Nothing, OfMean::Multiple);
            LinearTerm { factors, middle: 0.0, scale: channel.scale, of_mean }
        };
        let components = (0..COMPONENTS).flat_map(|c| self.tensors.iter().map(move |own| component(own, c)));
        let scalars = self.scalars.iter().map(|channel| {
            let [middle, scale] = channel.scale;
            let sample = self.sample_of_mean(channel).and_then(|(tensor, places)| mean_of(tensor, &places));
            let (factors, middle, of_mean) = match (channel.start, sample) {
                (Some(place), _) => (vec![(place, 1.0)], middle, OfMean::Nothing),
                (None, Some(mean)) => (Vec::new(), middle, OfMean::Logarithm(mean)),
                (None, None) => (Vec::new(), middle - channel.first, OfMean::Nothing),
            };
            LinearTerm { factors, middle, scale, of_mean }
        });
        let others = self.start.iter().map(|(place, [middle, scale])| LinearTerm {
            factors: vec![(*place, 1.0)],
            middle: *middle,
            scale: *scale,
            of_mean: OfMean::Nothing,
        });
        components.chain(scalars).chain(others).collect()
    }

    /// The place of the mean part of a tensor among the values of a network, if it varies.
    fn place_of_mean(&self, number: usize) -> Option<usize> {
        let is_own = |channel: &ScalarChannel| matches!(channel.source, Source::MeanOf(of) if of == number);
        self.scalars.iter().position(is_own).map(|place| COMPONENTS * self.tensors.len() + place)
    }

    /// The outputs of a network with their scales, `scale y + middle`, the places of the outputs to which each of them contributes and by what factor, and what the outputs
    /// are where these are zero.
    fn output_terms(&self, outputs: usize) -> (Vec<LinearTerm>, Vec<f64>) {
        let component = |(number, channel): (usize, &TensorChannel), c: usize| {
            let unit = std::array::from_fn(|k| f64::from(u8::from(k == c)));
            let factors = channel.outputs.iter().copied().zip(whole(unit, 0.0)).collect();
            let mean = channel.offset.zip(self.place_of_mean(number));
            let of_mean = mean.map_or(OfMean::Nothing, |(offset, place)| {
                OfMean::Multiple(Mean { factors: vec![(place, 1.0)], offset })
            });
            LinearTerm { factors, middle: 0.0, scale: channel.scale, of_mean }
        };
        let tensors = || self.tensors.iter().enumerate();
        let components = (0..COMPONENTS).flat_map(|c| tensors().map(move |own| component(own, c)));
        let scalars = self.scalars.iter().map(|channel| {
            let offset = match channel.source {
                Source::Output(_) => None,
                Source::MeanOf(number) => self.tensors[number].offset,
            };
            let of_mean = offset
                .map_or(OfMean::Nothing, |offset| OfMean::Logarithm(Mean { factors: Vec::new(), offset }));
            let factors = match channel.source {
                Source::Output(place) => vec![(place, 1.0)],
                Source::MeanOf(number) => {
                    self.tensors[number].outputs[..3].iter().map(|place| (*place, 1.0)).collect()
                }
            };
            LinearTerm { factors, middle: channel.scale[0], scale: channel.scale[1], of_mean }
        });
        let mut constant = vec![0.0; outputs];
        for channel in &self.tensors {
            channel.outputs[..3].iter().for_each(|place| constant[*place] = channel.mean.unwrap_or(0.0));
        }
        (components.chain(scalars).collect(), constant)
    }
}

//! The ranges of the inputs in which the networks of a mapping were trained.

use granum_learn::networks::SubModelNetworks;

/// The inputs with the ranges in which one sub-model, or each of them, was trained, one input per line; bins with the same
/// range share a line.
pub fn inputs(surrogate: &SubModelNetworks, sub_model: Option<usize>) -> String {
    let chosen: Vec<(usize, Vec<[f64; 2]>)> = (0..surrogate.networks().len())
        .filter(|k| sub_model.is_none_or(|wanted| wanted == *k))
        .map(|k| (k + 1, surrogate.trained_ranges(k)))
        .collect();
    let ranges = |input: usize| -> Vec<(usize, [f64; 2])> {
        chosen.iter().map(|(number, ranges)| (*number, ranges[input])).collect()
    };
    // The first input is the strain, which selects the sub-model; the other inputs then have the range of that sub-model.
    let names = surrogate.input_names().into_iter().enumerate();
    let lines: Vec<(String, String)> =
        names.map(|(input, name)| (name, text(&ranges(input), input == 0))).collect();
    let together = |a: &(String, String), b: &(String, String)| {
        a.1 == b.1 && [a, b].iter().all(|line| line.0.starts_with("probability_density_"))
    };
    let shown = lines.chunk_by(together).map(|group| match group {
        [(first, range), .., (last, _)] => format!("  {first} to {last} ({} bins): {range}", group.len()),
        _ => group.iter().map(|(name, range)| format!("  {name}: {range}")).collect(),
    });
    shown.collect::<Vec<_>>().join("\n")
}

/// The ranges of numbered sub-models: a single range if they are all equal, or if they may be joined and have no gaps,
/// otherwise the range of each.
fn text(ranges: &[(usize, [f64; 2])], may_join: bool) -> String {
    let shown = |[low, high]: [f64; 2]| format!("{} to {}", short(low), short(high));
    let alike = ranges.windows(2).all(|pair| pair[0].1 == pair[1].1);
    let joined = may_join && ranges.windows(2).all(|pair| pair[1].1[0] <= pair[0].1[1]);
    match ranges {
        [] => String::new(),
        [(_, [low, high]), ..] if alike || joined => {
            let whole =
                ranges.iter().fold([*low, *high], |[a, b], (_, [low, high])| [a.min(*low), b.max(*high)]);
            shown(whole)
        }
        _ => {
            let each = ranges.iter().map(|(number, range)| format!("{} (sub-model {number})", shown(*range)));
            each.collect::<Vec<_>>().join(", ")
        }
    }
}

/// A number with at most five decimals.
pub fn short(value: f64) -> f64 {
    (1e5 * value).round() / 1e5
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_between_sub_models_are_shown() {
        let ranges = |second: f64| [(1, [0.0075, 0.0925]), (2, [second, 0.1975])];
        assert_eq!(
            text(&ranges(0.1025), true),
            "0.0075 to 0.0925 (sub-model 1), 0.1025 to 0.1975 (sub-model 2)"
        );
        assert_eq!(text(&ranges(0.0925), true), "0.0075 to 0.1975");
        assert_eq!(text(&ranges(0.08), true), "0.0075 to 0.1975");
        // The ranges of an input other than the strain are not joined, since it does not select the sub-model.
        assert!(text(&ranges(0.08), false).contains("(sub-model 2)"));
        assert_eq!(text(&[(1, [0.125, 3.375]), (2, [0.125, 3.375])], false), "0.125 to 3.375");
        assert_eq!(text(&[(3, [0.1, 0.2])], false), "0.1 to 0.2");
    }
}

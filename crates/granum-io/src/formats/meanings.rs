//! Columns that change what a grain is: bodies of several spheres, which are [put together](super::bodies) when the file is read, and types. Granum
//! takes each grain as of one material, and says so where a file says more.

use std::collections::{BTreeSet, HashMap};

use super::remark::Remark;
use super::result::Frame;

/// So many types are named.
const MOST_NAMED: usize = 8;

/// What columns say of a grain beside its place and size.
#[derive(Clone, Debug, Default)]
pub(super) struct Meanings {
    /// The body (clump, molecule) of which it is a part.
    pub(super) body: Option<f64>,
    /// Its type or material.
    pub(super) kind: Option<String>,
}

/// Notes in a frame what these columns, named `body_column` and `kind_column`, say of its grains, one by one in their order. A number of a body
/// that is not above `no_body` says that a grain is alone.
pub(super) fn note(
    frame: &mut Frame,
    meanings: &[Meanings],
    (body_column, no_body): (&str, f64),
    kind_column: &str,
) {
    note_bodies(frame, meanings, body_column, no_body);
    let kinds: BTreeSet<&str> = meanings.iter().filter_map(|of| of.kind.as_deref()).collect();
    if kinds.len() < 2 {
        return;
    }
    let mut named: Vec<&str> = kinds.iter().copied().take(MOST_NAMED).collect();
    if kinds.len() > MOST_NAMED {
        named.push("...");
    }
    frame.remarks.push(Remark::doubtful(format!(
        "the column {kind_column} has {} values ({}), which may be materials: all grains are taken as of one material; a packing of granum has \
         its materials by name in a column material",
        kinds.len(),
        named.join(", ")
    )));
}

fn note_bodies(frame: &mut Frame, meanings: &[Meanings], column: &str, no_body: f64) {
    let mut count: HashMap<u64, usize> = HashMap::new();
    let mut of: Vec<(u64, u64)> = Vec::new();
    for (grain, meaning) in frame.grains.iter().zip(meanings) {
        if let Some(body) = meaning.body.filter(|body| *body > no_body) {
            *count.entry(body as u64).or_default() += 1;
            of.push((grain.id, body as u64));
        }
    }
    let several = |body: &u64| count.get(body).is_some_and(|count| *count > 1);
    if !count.keys().any(several) {
        return;
    }
    // Where every sphere names its body, bodies of one sphere have their names as well.
    let all = of.len() == frame.grains.len();
    frame.clump_of = of.into_iter().filter(|(_, body)| all || several(body)).collect();
    frame.clump_column = column.to_string();
}

#[cfg(test)]
mod tests {
    use granum_core::assembly::Sphere;

    use super::*;

    fn noted(bodies: &[f64], kinds: &[f64]) -> Frame {
        let grains = (1..=bodies.len() as u64).map(|id| Sphere { id, ..Sphere::default() }).collect();
        let mut frame = Frame { grains, ..Frame::default() };
        let meaning =
            |(body, kind): (&f64, &f64)| Meanings { body: Some(*body), kind: Some(kind.to_string()) };
        let meanings: Vec<Meanings> = bodies.iter().zip(kinds).map(meaning).collect();
        note(&mut frame, &meanings, ("mol", 0.0), "type");
        frame
    }

    #[test]
    fn bodies_of_several_spheres_and_several_types_are_said() {
        let frame = noted(&[0.0, 2.0, 2.0, 3.0, 0.0], &[1.0, 1.0, 2.0, 1.0, 1.0]);
        assert_eq!(frame.clump_of, HashMap::from([(2, 2), (3, 2)]));
        assert_eq!(frame.clump_column, "mol");
        let [types] = &frame.remarks[..] else { panic!("{:?}", frame.remarks) };
        assert!(types.text.starts_with("the column type has 2 values (1, 2)"), "{}", types.text);
    }

    /// A body of one sphere keeps its number where all have one.
    #[test]
    fn bodies_of_all_spheres_are_noted() {
        let frame = noted(&[7.0, 2.0, 2.0], &[1.0; 3]);
        assert_eq!(frame.clump_of, HashMap::from([(1, 7), (2, 2), (3, 2)]));
    }

    #[test]
    fn spheres_alone_of_one_type_need_no_word() {
        let frame = noted(&[0.0, 1.0, 2.0], &[3.0, 3.0, 3.0]);
        assert!(frame.remarks.is_empty() && frame.clump_of.is_empty());
    }
}

//! Columns that change what a grain is: bodies of several spheres, and types. Granum takes each sphere as a grain of one material, and says
//! so where a file says more.

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
    let mut members: HashMap<u64, Vec<u64>> = HashMap::new();
    for (grain, of) in frame.grains.iter().zip(meanings) {
        if let Some(body) = of.body.filter(|body| *body > no_body) {
            members.entry(body as u64).or_default().push(grain.id);
        }
    }
    members.retain(|_, grains| grains.len() > 1);
    let spheres: usize = members.values().map(Vec::len).sum();
    if spheres == 0 {
        return;
    }
    let bodies = members.len();
    frame.clump_of = (members.into_iter())
        .flat_map(|(body, grains)| grains.into_iter().map(move |grain| (grain, body)))
        .collect();
    let noun = if bodies == 1 { "body" } else { "bodies" };
    frame.remarks.push(Remark::doubtful(format!(
        "{spheres} spheres are parts of {bodies} {noun} (column {column}): each is taken as a grain of its own, so that volumes in which they \
         overlap count twice, and numbers of contacts are those of spheres"
    )));
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
        let [bodies, types] = &frame.remarks[..] else { panic!("{:?}", frame.remarks) };
        assert!(bodies.text.starts_with("2 spheres are parts of 1 body (column mol)"), "{}", bodies.text);
        assert!(types.text.starts_with("the column type has 2 values (1, 2)"), "{}", types.text);
    }

    #[test]
    fn spheres_alone_of_one_type_need_no_word() {
        let frame = noted(&[0.0, 1.0, 2.0], &[3.0, 3.0, 3.0]);
        assert!(frame.remarks.is_empty() && frame.clump_of.is_empty());
    }
}

//! The names of columns by which a table of grains or of contacts is read.

/// The names of a number, the usual one first.
pub(super) type Scalar = &'static [&'static str];
/// The names of a vector, in which the axis replaces `?`, or its number, from 0, replaces `#`.
pub(super) type Triple = &'static [&'static str];

pub(super) const STEP: Scalar = &["step", "timestep"];
pub(super) const TIME: Scalar = &["time"];
pub(super) const ID: Scalar = &["id"];
/// The last two are those of ParaView, with numbers for the axes.
pub(super) const POSITION: Triple = &["position_?", "pos_?", "?", "points:#", "points_#"];
pub(super) const RADIUS: Scalar = &["radius", "r", "rad"];
pub(super) const DIAMETER: Scalar = &["diameter", "d"];
pub(super) const MASS: Scalar = &["mass"];
/// The body that a sphere is a part of; the number of a clump counts from 0, and that of a molecule from 1.
pub(super) const CLUMP: Scalar = &["clump", "clump_id", "clumpid"];
pub(super) const MOLECULE: Scalar = &["mol", "molecule", "body", "body_id", "id_multisphere"];
/// Types and materials, which may be words.
pub(super) const KIND: Scalar = &["type", "matid", "material"];
pub(super) const VELOCITY: Triple = &["velocity_?", "v?", "v_?"];
pub(super) const SPIN: Triple = &["spin_?", "omega?", "omega_?", "w?"];
pub(super) const FORCE: Triple = &["force_?", "f?", "f_?"];
pub(super) const TORQUE: Triple = &["torque_?"];
/// Ids of the two grains of a contact; each pair of names goes together.
pub(super) const PAIRS: [[&str; 2]; 3] = [["first", "second"], ["id1", "id2"], ["i", "j"]];
pub(super) const BRANCH: Triple = &["branch_?"];
pub(super) const NORMAL: Triple = &["normal_?", "n?"];
pub(super) const NORMAL_FORCE: Scalar = &["normal_force", "fn"];
pub(super) const TANGENTIAL_FORCE: Triple = &["tangential_force_?", "ft?", "ft_?"];
pub(super) const APPROACH: Scalar = &["approach", "overlap"];
pub(super) const NORMAL_ENERGY: Scalar = &["normal_energy"];
pub(super) const TANGENTIAL_ENERGY: Scalar = &["tangential_energy"];
pub(super) const SLIDING: Scalar = &["sliding"];
pub(super) const TOUCHING: Scalar = &["touching"];

/// The names of columns that say of which body a sphere is a part.
pub(crate) fn names_of_bodies() -> impl Iterator<Item = &'static str> {
    CLUMP.iter().chain(MOLECULE).copied()
}

/// All of the scalars and vectors above.
pub(super) const SCALARS: [Scalar; 14] = [
    STEP,
    TIME,
    ID,
    RADIUS,
    DIAMETER,
    MASS,
    CLUMP,
    MOLECULE,
    NORMAL_FORCE,
    APPROACH,
    NORMAL_ENERGY,
    TANGENTIAL_ENERGY,
    SLIDING,
    TOUCHING,
];
pub(super) const TRIPLES: [Triple; 8] =
    [POSITION, VELOCITY, SPIN, FORCE, TORQUE, BRANCH, NORMAL, TANGENTIAL_FORCE];

/// All names, and those of vectors.
pub(super) fn known_names() -> (Vec<String>, Vec<[String; 3]>) {
    let vector = |name: &&str| components(name);
    let vectors: Vec<[String; 3]> = TRIPLES.iter().flat_map(|names| names.iter().map(vector)).collect();
    let mut known: Vec<String> =
        SCALARS.iter().flat_map(|names| names.iter().map(|name| name.to_string())).collect();
    known.extend(KIND.iter().map(|name| name.to_string()));
    known.extend(PAIRS.iter().flatten().map(|name| name.to_string()));
    known.extend(vectors.iter().flatten().cloned());
    (known, vectors)
}

/// The names of the components of a vector.
fn components(name: &str) -> [String; 3] {
    ["x", "y", "z"].map(|axis| {
        let number = ["x", "y", "z"].iter().position(|known| *known == axis).unwrap_or_default();
        name.replace('?', axis).replace('#', &number.to_string())
    })
}

/// The names of the columns of a table, without capitals.
pub(super) struct Names(pub(super) Vec<String>);

impl Names {
    pub(super) fn new<'a>(names: impl Iterator<Item = &'a str>) -> Names {
        Names(names.map(str::to_ascii_lowercase).collect())
    }

    pub(super) fn place(&self, name: &str) -> Option<usize> {
        self.0.iter().position(|known| known == name)
    }

    pub(super) fn scalar(&self, names: Scalar) -> Option<usize> {
        names.iter().find_map(|name| self.place(name))
    }

    /// The three columns of a vector, if all are there.
    pub(super) fn triple(&self, names: Triple) -> Option<[usize; 3]> {
        names.iter().find_map(|name| {
            let [x, y, z] = components(name).map(|component| self.place(&component));
            Some([x?, y?, z?])
        })
    }

    pub(super) fn pair(&self) -> Option<[usize; 2]> {
        PAIRS.iter().find_map(|[first, second]| Some([self.place(first)?, self.place(second)?]))
    }

    pub(super) fn are_of_grains(&self) -> bool {
        self.triple(POSITION).is_some()
    }

    pub(super) fn are_of_contacts(&self) -> bool {
        self.pair().is_some()
    }

    /// True for more than a packing holds.
    pub(super) fn say_more(&self) -> bool {
        [VELOCITY, SPIN, FORCE].iter().any(|names| self.triple(names).is_some())
            || [STEP, TIME, MASS].iter().any(|names| self.scalar(names).is_some())
    }
}

/// Places of all columns that are read.
pub(super) fn needed(names: &Names) -> Vec<usize> {
    let mut places: Vec<usize> = SCALARS.iter().filter_map(|known| names.scalar(known)).collect();
    places.extend(TRIPLES.iter().filter_map(|known| names.triple(known)).flatten());
    places.extend(names.pair().into_iter().flatten());
    places.sort_unstable();
    places.dedup();
    places
}

//! What a design is that makes its points by itself.

/// Makes points from their number, a seed and the axes, one after the other.
type MakePoints = for<'a> fn(usize, u32, &'a [Axis]) -> Box<dyn Iterator<Item = Point> + 'a>;

/// A design that makes its points by itself.
#[derive(Debug)]
pub struct PointDesign {
    /// Its name in plans.
    pub name: &'static str,
    /// What it is.
    pub help: &'static str,
    /// Its points in words.
    pub points_in_words: &'static str,
    /// What decides how many points it has.
    pub size: DesignSize,
    /// Its points, from their number, a seed and the axes.
    pub(in crate::plan) points: MakePoints,
}

impl PartialEq for PointDesign {
    fn eq(&self, other: &PointDesign) -> bool {
        self.name == other.name
    }
}

/// What decides how many points a design has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DesignSize {
    /// `points` of the plan, less those that the constraints leave out.
    Points,
    /// `points` of the plan: further points replace those that the constraints leave out.
    PointsThatFulfil,
    /// The numbers of values of the variables.
    Levels,
}

/// A variable as a design sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::plan) enum Axis {
    /// A range without levels.
    Continuous,
    /// A number of values.
    Levels(usize),
}

/// The place of a point on an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::plan) enum Coordinate {
    /// From 0 to 1.
    Share(f64),
    /// The number of a value, from 0.
    Level(usize),
}

impl Coordinate {
    /// A drawn number from 0 to 1 on an axis.
    pub(super) fn drawn(share: f64, axis: Axis) -> Coordinate {
        match axis {
            Axis::Continuous => Coordinate::Share(share),
            Axis::Levels(count) => {
                Coordinate::Level(((share * count as f64) as usize).min(count.saturating_sub(1)))
            }
        }
    }
}

/// A point: its place on each axis.
pub(in crate::plan) type Point = Vec<Coordinate>;

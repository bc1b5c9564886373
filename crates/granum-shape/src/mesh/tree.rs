//! A tree of boxes around triangles: which triangles may meet, and how far a point is from the nearest.

use granum_core::assembly::Vector;
use granum_core::geometry::dot;

use super::bounds::bounds;
use super::triangles::TriangleMesh;

/// Triangles in a leaf.
const LEAF: usize = 4;

/// A tree of boxes around the triangles of a mesh.
pub(crate) struct Tree<'a> {
    mesh: &'a TriangleMesh,
    /// Triangles in the order of the leaves.
    order: Vec<usize>,
    nodes: Vec<Node>,
}

struct Node {
    bounds: [Vector; 2],
    /// Its triangles in the order of the leaves.
    range: [usize; 2],
    /// Its two parts; none for a leaf.
    parts: Option<[usize; 2]>,
}

impl<'a> Tree<'a> {
    pub(crate) fn new(mesh: &'a TriangleMesh) -> Tree<'a> {
        let middles: Vec<Vector> = (0..mesh.triangles.len())
            .map(|k| mesh.corners(k))
            .map(|[p, q, r]| std::array::from_fn(|a| p[a] + q[a] + r[a]))
            .collect();
        let mut tree = Tree { mesh, order: (0..middles.len()).collect(), nodes: Vec::new() };
        tree.grow(&middles, [0, middles.len()]);
        tree
    }

    fn grow(&mut self, middles: &[Vector], range: [usize; 2]) -> usize {
        let here = &mut self.order[range[0]..range[1]];
        let corners: Vec<Vector> = here.iter().flat_map(|k| self.mesh.corners(*k)).collect();
        let place = self.nodes.len();
        self.nodes.push(Node { bounds: bounds(&corners), range, parts: None });
        if here.len() > LEAF {
            let of_middles: Vec<Vector> = here.iter().map(|k| middles[*k]).collect();
            let [low, high] = bounds(&of_middles);
            let wide = |a: usize| high[a] - low[a];
            let axis = (1..3).fold(0, |best, a| if wide(a) > wide(best) { a } else { best });
            let half = here.len() / 2;
            here.select_nth_unstable_by(half, |a, b| {
                middles[*a][axis].total_cmp(&middles[*b][axis]).then(a.cmp(b))
            });
            let middle = range[0] + half;
            let parts = [self.grow(middles, [range[0], middle]), self.grow(middles, [middle, range[1]])];
            self.nodes[place].parts = Some(parts);
        }
        place
    }

    /// The first pair of triangles whose boxes overlap and of which a test says yes.
    pub(crate) fn find_pair(&self, test: &dyn Fn(usize, usize) -> bool) -> Option<[usize; 2]> {
        if self.order.is_empty() { None } else { self.pair(0, 0, test) }
    }

    fn pair(&self, a: usize, b: usize, test: &dyn Fn(usize, usize) -> bool) -> Option<[usize; 2]> {
        let (first, second) = (&self.nodes[a], &self.nodes[b]);
        if !overlap(&first.bounds, &second.bounds) {
            return None;
        }
        let size = |node: &Node| node.range[1] - node.range[0];
        match (first.parts, second.parts) {
            (Some([l, r]), _) if a == b => {
                self.pair(l, l, test).or_else(|| self.pair(r, r, test)).or_else(|| self.pair(l, r, test))
            }
            (Some([l, r]), other) if other.is_none() || size(first) >= size(second) => {
                self.pair(l, b, test).or_else(|| self.pair(r, b, test))
            }
            (_, Some([l, r])) => self.pair(a, l, test).or_else(|| self.pair(a, r, test)),
            _ => {
                let all = |node: &Node| self.order[node.range[0]..node.range[1]].to_vec();
                let seconds = all(second);
                for i in all(first) {
                    for &j in &seconds {
                        if (a != b || i < j) && test(i, j) {
                            return Some([i.min(j), i.max(j)]);
                        }
                    }
                }
                None
            }
        }
    }

    /// Distance of a point from the nearest triangle.
    pub(crate) fn distance(&self, x: &Vector) -> f64 {
        let mut least = f64::INFINITY;
        if !self.nodes.is_empty() {
            self.nearer(0, x, &mut least);
        }
        least.sqrt()
    }

    fn nearer(&self, place: usize, x: &Vector, least: &mut f64) {
        let node = &self.nodes[place];
        if square_from_box(&node.bounds, x) >= *least {
            return;
        }
        match node.parts {
            Some([l, r]) => {
                let from = |k: usize| square_from_box(&self.nodes[k].bounds, x);
                let [near, far] = if from(r) < from(l) { [r, l] } else { [l, r] };
                self.nearer(near, x, least);
                self.nearer(far, x, least);
            }
            None => {
                for k in &self.order[node.range[0]..node.range[1]] {
                    *least = least.min(square_from_triangle(&self.mesh.corners(*k), x));
                }
            }
        }
    }
}

fn overlap([low, high]: &[Vector; 2], [other_low, other_high]: &[Vector; 2]) -> bool {
    (0..3).all(|a| low[a] <= other_high[a] && other_low[a] <= high[a])
}

fn square_from_box([low, high]: &[Vector; 2], x: &Vector) -> f64 {
    (0..3).map(|a| (low[a] - x[a]).max(x[a] - high[a]).max(0.0)).map(|d| d * d).sum()
}

/// Square of the distance of a point from a triangle (Ericson 2004, chapter 5).
fn square_from_triangle([a, b, c]: &[Vector; 3], x: &Vector) -> f64 {
    let minus = |p: &Vector, q: &Vector| -> Vector { std::array::from_fn(|k| p[k] - q[k]) };
    let (ab, ac, ax, bx, cx) = (minus(b, a), minus(c, a), minus(x, a), minus(x, b), minus(x, c));
    let (d1, d2, d3, d4) = (dot(&ab, &ax), dot(&ac, &ax), dot(&ab, &bx), dot(&ac, &bx));
    let (d5, d6) = (dot(&ab, &cx), dot(&ac, &cx));
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    let from = |u: f64, v: f64| {
        let apart: Vector = std::array::from_fn(|k| ax[k] - u * ab[k] - v * ac[k]);
        dot(&apart, &apart)
    };
    let share = |of: f64, rest: f64| if of + rest > 0.0 { of / (of + rest) } else { 0.0 };
    if d1 <= 0.0 && d2 <= 0.0 {
        return from(0.0, 0.0);
    }
    if d3 >= 0.0 && d4 <= d3 {
        return from(1.0, 0.0);
    }
    if d6 >= 0.0 && d5 <= d6 {
        return from(0.0, 1.0);
    }
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return from(share(d1, -d3), 0.0);
    }
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return from(0.0, share(d2, -d6));
    }
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let w = share(d4 - d3, d5 - d6);
        return from(1.0 - w, w);
    }
    let sum = va + vb + vc;
    from(vb / sum, vc / sum)
}

//! Which pieces of a shape can be nearest to a point: a tree of boxes over them.
//!
//! Each piece stands for what it really is by the eight triangles between its nine points, and by how far it may be from these:
//! half of what the middles are from the bilinear piece between its corners, which is twice what halving leaves of it where the piece
//! has a second derivative. So a piece whose triangles are farther than a known distance by more than that holds no nearer point.
//! Those bounds are measured, not proved.

use loftsman_kernel::Vector;

use super::patches::{Patches, Piece};

/// Pieces in a leaf.
const LEAF: usize = 4;

#[derive(Debug, Clone, Copy)]
struct Bounds {
    low: Vector,
    high: Vector,
}

#[derive(Debug)]
struct Node {
    bounds: Bounds,
    /// Pieces in the order of the tree; of a leaf all that it has.
    range: (u32, u32),
    /// The second child: the first is the node that follows. 0 of a leaf.
    second: u32,
}

/// A tree over the pieces of a shape as it is.
pub(super) struct Tree<'a> {
    pieces: &'a [Piece],
    points: Vec<Vector>,
    order: Vec<u32>,
    /// How far a piece may be from its triangles.
    off: Vec<f64>,
    nodes: Vec<Node>,
}

/// A piece, and the place on it that is nearest to a point by its triangles.
#[derive(Debug, Clone, Copy)]
pub(super) struct Near {
    pub(super) piece: usize,
    pub(super) shares: [f64; 2],
    pub(super) distance: f64,
}

impl<'a> Tree<'a> {
    /// Cost: `n log n` in the pieces.
    pub(super) fn new(patches: &'a Patches, points: Vec<Vector>) -> Self {
        let pieces = patches.pieces();
        let off: Vec<f64> = pieces.iter().map(|piece| deviation(piece, &points)).collect();
        let bounds: Vec<Bounds> =
            pieces.iter().zip(&off).map(|(p, off)| bounds_of(p, &points, *off)).collect();
        let mut tree =
            Self { pieces, points, order: (0..pieces.len() as u32).collect(), off, nodes: Vec::new() };
        tree.build(&bounds, 0, pieces.len());
        tree
    }

    fn build(&mut self, bounds: &[Bounds], from: usize, to: usize) {
        let mut all = Bounds { low: Vector::repeat(f64::INFINITY), high: Vector::repeat(f64::NEG_INFINITY) };
        let mut middles = all;
        let middle = |piece: u32| 0.5 * bounds[piece as usize].low + 0.5 * bounds[piece as usize].high;
        for &piece in &self.order[from..to] {
            let own = &bounds[piece as usize];
            all = Bounds { low: all.low.inf(&own.low), high: all.high.sup(&own.high) };
            let at = middle(piece);
            middles = Bounds { low: middles.low.inf(&at), high: middles.high.sup(&at) };
        }
        let index = self.nodes.len();
        self.nodes.push(Node { bounds: all, range: (from as u32, to as u32), second: 0 });
        if to - from <= LEAF {
            return;
        }
        let axis = (middles.high - middles.low).imax();
        self.order[from..to].sort_by(|&a, &b| middle(a)[axis].total_cmp(&middle(b)[axis]).then(a.cmp(&b)));
        let half = from + (to - from) / 2;
        self.build(bounds, from, half);
        self.nodes[index].second = self.nodes.len() as u32;
        self.build(bounds, half, to);
    }

    /// The nearest place by the triangles.
    pub(super) fn nearest(&self, point: &Vector) -> Option<Near> {
        let mut best: Option<Near> = None;
        self.visit(point, f64::INFINITY, false, &mut |near| {
            if best.is_none_or(|b| near.distance < b.distance) {
                best = Some(near);
            }
            best.map_or(f64::INFINITY, |b| b.distance)
        });
        best
    }

    /// Shows all pieces that may hold something nearer than a distance; what is shown answers with the distance that is known then.
    pub(super) fn nearer(&self, point: &Vector, distance: f64, show: &mut dyn FnMut(Near) -> f64) {
        self.visit(point, distance, true, show);
    }

    fn visit(&self, point: &Vector, mut known: f64, allow: bool, show: &mut dyn FnMut(Near) -> f64) {
        let mut stack: Vec<(f64, u32)> = Vec::with_capacity(64);
        if let Some(root) = self.nodes.first() {
            stack.push((root.bounds.distance(point), 0));
        }
        while let Some((bound, index)) = stack.pop() {
            if bound >= known {
                continue;
            }
            let node = &self.nodes[index as usize];
            if node.second == 0 {
                for &piece in &self.order[node.range.0 as usize..node.range.1 as usize] {
                    let piece = piece as usize;
                    let near = self.on(piece, point);
                    let off = if allow { self.off[piece] } else { 0.0 };
                    if near.distance - off < known {
                        known = known.min(show(near));
                    }
                }
                continue;
            }
            let mut children =
                [index + 1, node.second].map(|c| (self.nodes[c as usize].bounds.distance(point), c));
            if children[0].0 < children[1].0 {
                children.swap(0, 1);
            }
            stack.extend(children);
        }
    }

    /// The nearest place of a piece by its triangles.
    fn on(&self, piece: usize, point: &Vector) -> Near {
        let samples = self.pieces[piece].samples();
        let at = |a: usize, b: usize| self.points[samples[a][b] as usize];
        let mut best = Near { piece, shares: [0.5, 0.5], distance: f64::INFINITY };
        for i in 0..2 {
            for j in 0..2 {
                let corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
                    let (distance, w) = from_triangle(point, &[corners[a], corners[b], corners[c]]);
                    if distance < best.distance {
                        let (s, t) = if b == 1 { (w[1] + w[2], w[2]) } else { (w[1], w[1] + w[2]) };
                        let shares = [0.5 * (i as f64 + s), 0.5 * (j as f64 + t)];
                        best = Near { piece, shares, distance };
                    }
                }
            }
        }
        best
    }
}

impl Bounds {
    fn distance(&self, point: &Vector) -> f64 {
        let outside = (self.low - point).sup(&(point - self.high)).sup(&Vector::zeros());
        outside.norm()
    }
}

fn bounds_of(piece: &Piece, points: &[Vector], off: f64) -> Bounds {
    let all = piece.samples().as_flattened();
    let start = Bounds { low: Vector::repeat(f64::INFINITY), high: Vector::repeat(f64::NEG_INFINITY) };
    let Bounds { low, high } = all.iter().fold(start, |b, &k| Bounds {
        low: b.low.inf(&points[k as usize]),
        high: b.high.sup(&points[k as usize]),
    });
    Bounds { low: low.add_scalar(-off), high: high.add_scalar(off) }
}

fn deviation(piece: &Piece, points: &[Vector]) -> f64 {
    let samples = piece.samples();
    let at = |a: usize, b: usize| points[samples[a][b] as usize];
    let mut most = 0.0_f64;
    for a in 0..3 {
        for b in 0..3 {
            let (s, t) = (0.5 * a as f64, 0.5 * b as f64);
            let bilinear = at(0, 0) * ((1.0 - s) * (1.0 - t))
                + at(2, 0) * (s * (1.0 - t))
                + at(0, 2) * ((1.0 - s) * t)
                + at(2, 2) * (s * t);
            most = most.max((at(a, b) - bilinear).norm());
        }
    }
    0.5 * most
}

/// The distance from a triangle, and the shares of its corners in the nearest place. A triangle may be a segment, or a point.
fn from_triangle(p: &Vector, [a, b, c]: &[Vector; 3]) -> (f64, [f64; 3]) {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d, e, f) = (ab.dot(&ab), ab.dot(&ac), ac.dot(&ac));
    let determinant = d * f - e * e;
    if determinant > 1e-12 * d * f {
        let (x, y) = (ab.dot(&ap), ac.dot(&ap));
        let (s, t) = ((f * x - e * y) / determinant, (d * y - e * x) / determinant);
        if s >= 0.0 && t >= 0.0 && s + t <= 1.0 {
            return ((ap - ab * s - ac * t).norm(), [1.0 - s - t, s, t]);
        }
    }
    let mut best = (f64::INFINITY, [1.0, 0.0, 0.0]);
    for (i, j, from, to) in [(0, 1, a, b), (1, 2, b, c), (2, 0, c, a)] {
        let along = to - from;
        let size = along.norm_squared();
        let share = if size > 0.0 { ((p - from).dot(&along) / size).clamp(0.0, 1.0) } else { 0.0 };
        let distance = (p - from - along * share).norm();
        if distance < best.0 {
            let mut weights = [0.0; 3];
            (weights[i], weights[j]) = (1.0 - share, share);
            best = (distance, weights);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_from_triangles() {
        let triangle = [Vector::zeros(), Vector::new(2.0, 0.0, 0.0), Vector::new(0.0, 2.0, 0.0)];
        for (point, distance, weights) in [
            (Vector::new(0.5, 0.5, 3.0), 3.0, [0.5, 0.25, 0.25]),
            (Vector::new(1.0, -4.0, 3.0), 5.0, [0.5, 0.5, 0.0]),
            (Vector::new(2.0, 2.0, 0.0), 2.0_f64.sqrt(), [0.0, 0.5, 0.5]),
            (Vector::new(-3.0, -4.0, 0.0), 5.0, [1.0, 0.0, 0.0]),
        ] {
            let (found, shares) = from_triangle(&point, &triangle);
            assert!((found - distance).abs() < 1e-14, "{point}: {found}");
            assert!(shares.iter().zip(weights).all(|(a, b)| (a - b).abs() < 1e-14), "{point}: {shares:?}");
        }
        let segment = [Vector::zeros(), Vector::zeros(), Vector::new(4.0, 0.0, 0.0)];
        let (distance, w) = from_triangle(&Vector::new(1.0, 2.0, 0.0), &segment);
        assert!((distance - 2.0).abs() < 1e-15 && (w[2] - 0.25).abs() < 1e-15);
    }
}

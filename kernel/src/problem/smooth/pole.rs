//! Poles: edges of surfaces that are points, where a sphere's meridians meet.
//!
//! At a pole all control vertices of an end row are one point `P`; what leaves it does so towards the vertices `Q_j` of the row
//! beside it. Nothing in the space of functions keeps the row together, nor the `Q_j` in one plane with `P`, which is what
//! makes the surface smooth there: `S_u(u₀, v) = Σ c_j(v) (Q_j - P)`, whatever the weights. Where they *are* so when an edit
//! is prepared, both are linear rows: `P_j = P_0`, and `Q_j - P = a_j (Q_a - P) + b_j (Q_b - P)` with the `a_j` and `b_j` that
//! are measured then. So the row beside the pole stays an affine image of what it was, which also keeps it smooth across the
//! knot lines that end in the pole: those are not asked again there.

use smallvec::SmallVec;

use super::columns::Columns;
use super::relation::ULPS;
use crate::Vector;
use crate::shape::{SMOOTH, Stencil};

/// Vertices that are no farther apart than this part of the size of the row beside them are one.
const ONE: f64 = 1e-9;

/// A pole of a surface.
#[derive(Debug, Clone)]
pub(super) struct Pole {
    /// The direction that ends in it: 0 for `u`.
    direction: usize,
    /// Its row of vertices in that direction, and the one beside it.
    row: usize,
    beside: usize,
    /// The parameter, for people.
    at: f64,
    /// Whether what leaves it does so in one plane.
    flat: bool,
    /// What keeps it, over the surface's vertices.
    pub(super) rows: Vec<Stencil>,
}

impl Pole {
    /// The poles at both ends of a net's direction.
    pub(super) fn of(net: &Columns<'_>) -> SmallVec<[Self; 2]> {
        let (count, (a, b)) = (net.across.len(), net.across.domain());
        if net.along.is_none() || !net.across.is_clamped() || count < 2 || net.columns() < 2 {
            return SmallVec::new();
        }
        let ends = [(0, 1, a), (count - 1, count - 2, b)];
        ends.into_iter().filter_map(|(row, beside, at)| Self::at(net, row, beside, at)).collect()
    }

    fn at(net: &Columns<'_>, row: usize, beside: usize, at: f64) -> Option<Self> {
        let place = net.point(row, 0);
        let way = |i: usize, j: usize| net.point(i, j) - place;
        // Most rows end here, at their second vertex.
        let noise = ULPS * f64::EPSILON * place.coords.amax();
        let size = |j: usize| way(beside, j).norm().max(way(beside, 0).norm());
        let near = |j: usize| way(row, j).norm() <= ONE * size(j) + noise;
        if !(1..net.columns()).all(near) {
            return None;
        }
        let one = |terms: &[(usize, usize, f64)]| -> Stencil {
            let largest = terms.iter().fold(0.0_f64, |m, (.., c)| m.max(c.abs()));
            terms.iter().map(|&(i, j, c)| (net.index(i, j), c / largest)).collect()
        };
        let mut rows: Vec<Stencil> =
            (1..net.columns()).map(|j| one(&[(row, j, 1.0), (row, 0, -1.0)])).collect();
        let ways: Vec<Vector> = (0..net.columns()).map(|j| way(beside, j)).collect();
        let plane = in_plane(&ways);
        for (j, combination) in plane.iter().flatten().enumerate() {
            let Some([(a, x), (b, y)]) = *combination else { continue };
            rows.push(one(&[(beside, j, 1.0), (beside, a, -x), (beside, b, -y), (row, 0, x + y - 1.0)]));
        }
        Some(Self { direction: net.direction, row, beside, at, flat: plane.is_some(), rows })
    }

    /// Whether a vertex has a part in it.
    pub(super) fn has(&self, net: &Columns<'_>, vertex: usize) -> bool {
        let (i, _) = net.place(vertex);
        i == self.row || self.flat && i == self.beside
    }

    /// Whether it keeps what crosses a column of the net of this direction.
    pub(super) fn keeps(&self, direction: usize, column: usize) -> bool {
        direction != self.direction && (column == self.row || self.flat && column == self.beside)
    }

    /// What it is, for people: `smooth pole u = 0`.
    pub(super) fn describe(&self) -> String {
        let how = if self.flat { "smooth" } else { "closed" };
        format!("{how} pole {} = {}", ["u", "v"][self.direction], self.at)
    }
}

/// A vector in terms of two others: their numbers and factors. `None` for one of these two.
type Combination = Option<[(usize, f64); 2]>;

/// Of vectors in one plane, each in terms of two of them. `None` where there is no such plane.
fn in_plane(ways: &[Vector]) -> Option<Vec<Combination>> {
    let largest = |of: &dyn Fn(&Vector) -> f64| {
        let all = ways.iter().map(of).enumerate();
        all.fold((0, 0.0), |best, (j, x)| if x > best.1 { (j, x) } else { best })
    };
    let (a, size) = largest(&Vector::norm);
    if !(size > 0.0 && size.is_finite()) {
        return None;
    }
    let first = ways[a] / size;
    let aside = |w: &Vector| w - first * first.dot(w);
    let (b, wide) = largest(&|w| aside(w).norm());
    // All along one line: a second direction would be rounding.
    let second = if wide > SMOOTH * size { aside(&ways[b]) / wide } else { Vector::zeros() };
    let slope = if wide > SMOOTH * size { first.dot(&ways[b]) / size } else { 0.0 };
    let mut all = Vec::with_capacity(ways.len());
    for (j, way) in ways.iter().enumerate() {
        let (x, y) = (first.dot(way), second.dot(way));
        if (way - first * x - second * y).norm() > SMOOTH * way.norm() + ONE * size {
            return None;
        }
        let (along, across) = (x / size, if wide > SMOOTH * size { y / wide } else { 0.0 });
        let own = j == a || j == b && wide > SMOOTH * size;
        all.push((!own).then_some([(a, along - across * slope), (b, across)]));
    }
    Some(all)
}

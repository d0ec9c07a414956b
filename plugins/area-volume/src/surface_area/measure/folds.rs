//! Lines of a net along which a surface folds over.

use loftsman_kernel::Vector;

use super::Measure;
use super::part::{Judged, Part};
use super::sums::{Net, Room};

/// Where a surface folds over along a line of its net is found to this part of a cell.
const FOUND: f64 = 1e-15;
/// On both sides of such a line, so far from it by a cell's length, the normals are opposite.
const BESIDE: f64 = 1e-7;

impl Measure<'_> {
    /// A cell cut along the lines of the net along which it folds over, as what is turned does where the speed of its profile vanishes: beside them it is
    /// smooth, and no number of halvings gets as near. None where there are no such lines.
    pub(super) fn unfolded(&self, part: &Part, net: Option<Net<'_>>, room: &mut Room) -> Option<Vec<Judged>> {
        let [p, q] = net.map_or(self.degrees, |net| net.sides.map(|side| side.degree));
        let by_stencils = |u: f64, v: f64| -> Option<Vector> {
            let row = |by: [usize; 2]| self.shape.stencil(part.at(u, v), by.into()).ok();
            Some(row([1, 0])?.apply(self.points).cross(&row([0, 1])?.apply(self.points)))
        };
        let normal = |u: f64, v: f64| match net {
            Some(net) => Some(net.normal_at(u, v)),
            None => by_stencils(u, v),
        };
        let us = folds(p, part.u, part.v, &normal);
        let vs = folds(q, part.v, part.u, &|x, y| normal(y, x));
        if us.is_empty() && vs.is_empty() {
            return None;
        }
        let ends = |(a, b): (f64, f64), inner: &[f64]| -> Vec<(f64, f64)> {
            let all: Vec<f64> = [a].into_iter().chain(inner.iter().copied()).chain([b]).collect();
            all.windows(2).map(|w| (w[0], w[1])).collect()
        };
        let mut parts = Vec::new();
        for u in ends(part.u, &us) {
            for v in ends(part.v, &vs) {
                parts.push(self.judged(Part { u, v, ..*part }, net, room));
            }
        }
        Some(parts)
    }
}

/// The parameters of one direction, of this degree, at which the normal turns round all along the other one.
fn folds(
    degree: usize,
    (a, b): (f64, f64),
    across: (f64, f64),
    normal: &dyn Fn(f64, f64) -> Option<Vector>,
) -> Vec<f64> {
    let other = |share: f64| across.0 + (across.1 - across.0) * share;
    let places = 2 * degree + 2;
    let place = |k: usize| a + (b - a) * (k as f64 + 0.5) / places as f64;
    let middle = other(0.5);
    let mut found = Vec::new();
    let mut before = normal(place(0), middle);
    for k in 1..places {
        let here = normal(place(k), middle);
        if let (Some(from), Some(to)) = (before, here)
            && from.dot(&to) < 0.0
        {
            let (mut low, mut high) = (place(k - 1), place(k));
            while high - low > FOUND * (b - a) {
                let between = 0.5 * low + 0.5 * high;
                if !(low < between && between < high) {
                    break;
                }
                match normal(between, middle) {
                    Some(n) if n.dot(&from) > 0.0 => low = between,
                    _ => high = between,
                }
            }
            let line = 0.5 * low + 0.5 * high;
            let beside = BESIDE * (b - a);
            let turns = |share: f64| {
                let sides = [line - beside, line + beside].map(|x| normal(x, other(share)));
                matches!(sides, [Some(n), Some(m)] if n.dot(&m) < 0.0)
            };
            if line - beside > a && line + beside < b && [0.1, 0.37, 0.9].into_iter().all(turns) {
                found.push(line);
            }
        }
        before = here;
    }
    found
}

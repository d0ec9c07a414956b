//! What lies beside a surface: points that other meshes have on its border, found on the pieces of that.

use std::collections::HashMap;

use loftsman_kernel::plugin::Beside;
use loftsman_kernel::{Point, Vector};

use crate::edge::Border;

/// An edge of the surface: that side of that patch.
pub(crate) struct BorderSide {
    pub(crate) edge: usize,
    pub(crate) patch: usize,
    pub(crate) side: usize,
    /// The edge in each state.
    pub(crate) states: Vec<Border>,
    /// What it takes from beside.
    pub(crate) taken: Taken,
}

/// What a piece of the border takes from beside.
#[derive(Debug, Clone, Default)]
pub(crate) struct Taken {
    /// Which of its vertices, counted from its start, another one has been already, and where.
    pub(crate) snaps: Vec<(usize, Point)>,
    /// Points between its vertices, by their place: after which vertex, and the fraction of the piece.
    pub(crate) extras: Vec<(usize, f64, Point)>,
}

/// Lets every piece of the border, cut at the fractions of its edge, take the points that lie on it. `O(log n)` for a piece, and for a point near
/// it as [`Border::foot`](crate::edge::Border::foot).
pub(crate) fn take(beside: Beside<'_>, borders: &mut [BorderSide], edges: &[Vec<f64>]) {
    let Beside { points, near } = beside;
    let Some(&first) = points.first() else { return };
    let (low, high) = points.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    let axis = (high - low).imax();
    let mut sorted: Vec<&Point> = points.iter().collect();
    sorted.sort_by(|a, b| a[axis].total_cmp(&b[axis]));
    for side in borders {
        let Some(border) = side.states.first() else { continue };
        let (low, high) = border.extent();
        let start = sorted.partition_point(|p| p[axis] < low[axis] - near);
        let end = sorted.partition_point(|p| p[axis] <= high[axis] + near);
        let fractions = &edges[side.edge];
        let at = |k: usize| match k.checked_sub(1) {
            None => 0.0,
            Some(k) => fractions.get(k).copied().unwrap_or(1.0),
        };
        let mut taken = Taken::default();
        for &point in sorted.get(start..end).unwrap_or_default() {
            let Some(t) = border.foot(*point, near) else { continue };
            // The vertices before and after it.
            let before = fractions.partition_point(|f| *f <= t);
            let is_one = |k: &usize| (border.point(at(*k)) - point).norm() <= near;
            match [before, before + 1].iter().find(|k| is_one(k)) {
                Some(&k) => taken.snaps.push((k, *point)),
                None => taken.extras.push((before, t, *point)),
            }
        }
        taken.extras.sort_by(|a, b| a.1.total_cmp(&b.1));
        // Those of others are theirs, not twice.
        taken.extras.dedup_by(|a, b| (a.2 - b.2).norm() <= near);
        side.taken = taken;
    }
}

/// A vertex between two that neighbour on the border.
pub(crate) struct Between {
    pub(crate) number: u32,
    /// Its place in the patch.
    pub(crate) at: [f64; 2],
    pub(crate) normal: Vector,
}

/// The vertices between two neighbours on the border, by these.
#[derive(Default)]
pub(crate) struct Splits(HashMap<[u32; 2], (u32, Vec<Between>)>);

impl Splits {
    /// Puts vertices between two, in their order.
    pub(crate) fn put(&mut self, from: u32, to: u32, between: Vec<Between>) {
        self.0.entry([from.min(to), from.max(to)]).or_insert((from, between));
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Those between two vertices of which the first is `from`: and whether they are to be taken from the last on.
    fn between(&self, from: u32, to: u32) -> Option<(&[Between], bool)> {
        let (first, between) = self.0.get(&[from.min(to), from.max(to)])?;
        Some((between, *first != from))
    }

    /// The triangles that one becomes whose sides are divided, and each of their corners; none where nothing is.
    pub(crate) fn of(&self, triangle: [u32; 3]) -> Vec<[Corner<'_>; 3]> {
        let mut out = Vec::new();
        let mut open = vec![[0, 1, 2].map(Corner::Own)];
        let mut divided = false;
        while let Some(one) = open.pop() {
            let side = (0..3).find_map(|k| match [one[k], one[(k + 1) % 3]] {
                [Corner::Own(a), Corner::Own(b)] => Some((k, self.between(triangle[a], triangle[b])?)),
                _ => None,
            });
            let Some((k, (between, backward))) = side else {
                out.push(one);
                continue;
            };
            divided = true;
            let (from, to, opposite) = (one[k], one[(k + 1) % 3], one[(k + 2) % 3]);
            let mut chain = vec![from];
            if backward {
                chain.extend(between.iter().rev().map(Corner::Between));
            } else {
                chain.extend(between.iter().map(Corner::Between));
            }
            chain.push(to);
            open.extend(chain.windows(2).rev().map(|ends| [ends[0], ends[1], opposite]));
        }
        if divided { out } else { Vec::new() }
    }
}

/// A corner of a part of a triangle.
#[derive(Clone, Copy)]
pub(crate) enum Corner<'a> {
    /// That corner of the triangle.
    Own(usize),
    /// A vertex on a side.
    Between(&'a Between),
}

/// The distance of a point from a segment.
pub(crate) fn off(point: &Point, from: &Point, to: &Point) -> f64 {
    let (along, out) = (to - from, point - from);
    let size = along.amax().max(out.amax());
    if !(size > 0.0 && size.is_finite()) {
        return size;
    }
    let (along, out) = (along / size, out / size);
    let square = along.norm_squared();
    let share = if square > 0.0 { (out.dot(&along) / square).clamp(0.0, 1.0) } else { 0.0 };
    (out - along * share).norm() * size
}

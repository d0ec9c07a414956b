//! What neither the energy nor the constraints say anything about.

use loftsman_kernel::Vector;
use loftsman_kernel::edit::SmoothKnot;
use loftsman_kernel::shape::{Shape, Splines};
use loftsman_kernel::solve::System;
use loftsman_kernel::spline::Space;

use crate::damped::{Damped, costless};
use crate::orthogonal::{add, complement, span};
use crate::squares::Squares;

/// A motion of which no constraint (scaled to unit length) sees more than this is free.
const PINNED: f64 = 1e-11;

/// Motions that cost no energy, and that no constraint forbids: orthonormal.
///
/// Rounding would send the search anywhere along them, so they are taken out beforehand.
#[derive(Debug, Clone, Default)]
pub(crate) struct NullSpace {
    /// Motions that every axis may make alike.
    alike: Vec<Vec<f64>>,
    /// Motions of all axes together, where constraints couple them.
    apart: Vec<Vec<Vector>>,
}

impl NullSpace {
    /// Those that a system of constraints does not see, of motions (orthonormal, each for any axis) that cost no energy.
    pub(crate) fn new(motions: &[Vec<f64>], system: &System) -> Self {
        if motions.is_empty() {
            return Self::default();
        }
        let sides = system.sides();
        let axes = if sides == 3 { 1 } else { 3 };
        let columns = axes * motions.len();
        let (n, rows) = (motions[0].len(), system.rows());
        let mut seen = Vec::with_capacity(rows.len());
        for row in 0..rows.len() {
            let norm = rows.norm(row);
            // A row that vanishes sees nothing.
            if !(norm > 0.0 && norm.is_finite()) {
                continue;
            }
            let mut line = vec![0.0; columns];
            for (column, value) in rows.iter_row(row) {
                let global = system.touched()[column];
                let (vertex, axis) = if sides == 3 { (global, 0) } else { (global / 3, global % 3) };
                for (k, motion) in motions.iter().enumerate() {
                    line[axes * k + axis] += value / norm * motion.get(vertex).copied().unwrap_or(0.0);
                }
            }
            seen.push(line);
        }
        let mut found = Self::default();
        for unseen in complement(&span(seen, PINNED), columns) {
            if axes == 1 {
                let mut motion = vec![0.0; n];
                motions.iter().zip(&unseen).for_each(|(m, u)| add(&mut motion, *u, m));
                found.alike.push(motion);
            } else {
                let mut motion = vec![Vector::zeros(); n];
                for (m, u) in motions.iter().zip(unseen.chunks_exact(3)) {
                    let u = Vector::from_column_slice(u);
                    motion.iter_mut().zip(m).for_each(|(v, m)| *v += u * *m);
                }
                found.apart.push(motion);
            }
        }
        found
    }

    /// How many there are, of all axes.
    pub(crate) fn ways(&self) -> usize {
        3 * self.alike.len() + self.apart.len()
    }

    /// One after another, over all axes.
    pub(crate) fn all(&self) -> impl Iterator<Item = Vec<Vector>> + '_ {
        let alike = self.alike.iter().flat_map(|m| {
            (0..3).map(move |axis| m.iter().map(|&z| Vector::ith(axis, z)).collect::<Vec<_>>())
        });
        alike.chain(self.apart.iter().cloned())
    }

    /// Takes out of `v` what it has of them.
    pub(crate) fn take_out(&self, v: &mut [Vector]) {
        remove(&self.alike, v);
        for motion in &self.apart {
            let along: f64 = v.iter().zip(motion).map(|(a, b)| a.dot(b)).sum();
            v.iter_mut().zip(motion).for_each(|(v, m)| *v -= m * along);
        }
    }
}

/// Takes out of every axis of `v` what it has of orthonormal motions.
pub(crate) fn remove(motions: &[Vec<f64>], v: &mut [Vector]) {
    for motion in motions {
        let along = v.iter().zip(motion).fold(Vector::zeros(), |sum, (v, m)| sum + v * *m);
        v.iter_mut().zip(motion).for_each(|(v, m)| *v -= along * *m);
    }
}

/// The motions of the vertices that may move which cost no energy.
pub(crate) struct Motions {
    /// Orthonormal, each for any axis.
    pub(crate) all: Vec<Vec<f64>>,
    /// Whether there are more, too many to be found.
    pub(crate) more: bool,
}

/// All motions of the vertices that may move which cost no energy. `damped` factors the energy where that is needed to find
/// them: where the knots tie a polynomial shape together, its polynomials are all.
pub(crate) fn motions<'a>(
    shape: &dyn Shape,
    squares: &Squares,
    free: &[bool],
    damped: impl FnOnce() -> Option<&'a Damped>,
) -> Motions {
    let known = splines(shape).is_some_and(|splines| splines.weights.is_none());
    let tied = known && squares.order() > 0 && breaks(shape, squares.order(), &[]).is_none();
    let found = if tied { None } else { damped().and_then(|damped| damped.null_space(squares)) };
    if let Some(all) = found {
        return Motions { all, more: false };
    }
    // Of the whole shape's motions those that cost nothing; of them, those that leave locked vertices where they are.
    let locked: Vec<usize> = (0..free.len()).filter(|&v| !free[v]).collect();
    let whole = costless(squares, &span(candidates(shape), PINNED), &mut |_| {});
    let seen = locked.iter().map(|&v| whole.iter().map(|m| m[v]).collect()).collect();
    let still = complement(&span(seen, PINNED), whole.len());
    let each = still.iter().map(|weights| {
        let mut motion = vec![0.0; free.len()];
        whole.iter().zip(weights).for_each(|(m, w)| add(&mut motion, *w, m));
        locked.iter().for_each(|&v| motion[v] = 0.0);
        motion
    });
    Motions { all: each.collect(), more: !tied }
}

fn splines(shape: &dyn Shape) -> Option<Splines<'_>> {
    shape.cells()?.splines()
}

/// Things worth saying about an energy: how many ways to move the whole shape it leaves free, and where the shape may break
/// without costing any.
pub(crate) fn notes(shape: &dyn Shape, squares: &Squares, ways: usize, kept: &[SmoothKnot]) -> Vec<String> {
    let mut notes = Vec::new();
    let breaks = breaks(shape, squares.order(), kept);
    if ways > 0 {
        let what = if breaks.is_some() { "the shape or its parts" } else { "the whole shape" };
        let only_shifts = ways <= 3 && breaks.is_none();
        let ways = if ways == 1 { "1 number".to_owned() } else { format!("{ways} numbers") };
        notes.push(format!(
            "{what} could be moved{} and be as fair ({ways} free): it stays as near to where it was as the constraints \
             let it",
            if only_shifts { "" } else { " or stretched evenly" }
        ));
    }
    notes.extend(breaks);
    notes
}

/// Control vertices of `1, u, u²` (on surfaces of their products), each scaled to the unit interval; of `1` alone where there are
/// weights, or the shape is no spline.
fn candidates(shape: &dyn Shape) -> Vec<Vec<f64>> {
    let Some(splines) = splines(shape).filter(|splines| splines.weights.is_none()) else {
        return vec![vec![1.0; shape.control_vertices().len()]];
    };
    let Some(v) = splines.v else { return powers(splines.u) };
    let (us, vs) = (powers(splines.u), powers(v));
    let mut all = Vec::new();
    for (i, u) in us.iter().enumerate() {
        for v in vs.iter().take(3 - i) {
            all.push(u.iter().flat_map(|a| v.iter().map(move |b| a * b)).collect());
        }
    }
    all
}

/// `1, u, u²` by their blossoms: the means of the knots in a support, and of their products two by two.
fn powers(space: &Space) -> Vec<Vec<f64>> {
    let (n, p) = (space.len(), space.degree());
    let mut all = vec![vec![1.0; n]];
    if space.is_periodic() || p == 0 {
        return all;
    }
    let (start, length) = (space.domain().0, space.length());
    let unit = |i: usize| (space.flat()[i] - start) / length;
    all.push((0..n).map(|i| (1..=p).map(|j| unit(i + j)).sum::<f64>() / p as f64).collect());
    if p > 1 {
        let pairs = (p * (p - 1)) as f64;
        let square = |i: usize| {
            let (sum, squares) =
                (1..=p).map(|j| unit(i + j)).fold((0.0, 0.0), |(s, q), t: f64| (s + t, q + t * t));
            (sum * sum - squares) / pairs
        };
        all.push((0..n).map(square).collect());
    }
    all
}

/// Knots where the shape may break (or bend sharply) at no cost, because the energy looks within spans only, and no smoothness is
/// kept that would forbid it.
fn breaks(shape: &dyn Shape, order: usize, kept: &[SmoothKnot]) -> Option<String> {
    let splines = splines(shape)?;
    let whole = |direction: usize, u: f64| {
        let here = kept.iter().find(|k| k.shape == 0 && k.direction == direction && k.at == u);
        here.and_then(|k| k.order).is_some_and(|kept| kept + 1 >= order)
    };
    let found = match splines.v {
        None => broken(splines.u, order, &|u| whole(0, u)).map(|u| format!("at {u}")),
        Some(v) => {
            let along = |direction: usize, space| {
                let name = ["u", "v"][direction];
                broken(space, order, &|u| whole(direction, u)).map(|u| format!("along {name} = {u}"))
            };
            along(0, splines.u).or_else(|| along(1, v))
        }
    }?;
    let what = ["", "gap", "corner", "jump of curvature"][order.min(3)];
    Some(format!(
        "{found} the knots are so many that a {what} costs no energy: remove some, or ask for what should hold there"
    ))
}

/// The first interior knot of multiplicity above `p + 1 - order` that is not `whole` all the same.
fn broken(space: &Space, order: usize, whole: &dyn Fn(f64) -> bool) -> Option<f64> {
    let (a, b) = space.domain();
    let allowed = (space.degree() + 1).saturating_sub(order);
    let inside = |u: &f64| (*u > a || space.is_periodic()) && *u < b;
    let mut points = space.breakpoints().into_iter().filter(inside);
    if order == 0 { None } else { points.find(|&u| space.multiplicity(u) > allowed && !whole(u)) }
}

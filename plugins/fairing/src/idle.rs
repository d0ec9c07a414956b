//! What neither the energy nor the constraints say anything about.

use std::any::Any;

use loftsman_kernel::Vector;
use loftsman_kernel::shape::Shape;
use loftsman_kernel::solve::System;
use loftsman_kernel::spline::{Curve, Space, Surface};
use nalgebra::DMatrix;

use crate::squares::Squares;

/// Ways to move the whole shape that cost no energy and that no constraint forbids, as orthonormal motions.
///
/// Rounding would send the search anywhere along them, so they are taken out beforehand.
pub(crate) fn idle_motions(
    shape: &dyn Shape,
    squares: &Squares,
    free: &[bool],
    system: &System,
) -> Vec<Vec<Vector>> {
    let moves: Vec<Vec<f64>> = candidates(shape)
        .into_iter()
        .filter(|z| {
            let x: Vec<Vector> = z.iter().map(|&z| Vector::new(z, 0.0, 0.0)).collect();
            let (energy, size) = squares.quadratic(&x);
            energy <= 1e-20 * size
        })
        .collect();
    if moves.is_empty() {
        return Vec::new();
    }
    let sides = system.sides();
    let columns = moves.len() * if sides == 3 { 1 } else { 3 };
    // What the constraints and the locks see of the motions.
    let mut seen: Vec<f64> = Vec::new();
    let mut line = vec![0.0; columns];
    for row in 0..system.rows().len() {
        let norm = system.rows().norm(row);
        line.fill(0.0);
        for (column, value) in system.rows().iter_row(row) {
            let global = system.touched()[column];
            let (vertex, axis) = if sides == 3 { (global, 0) } else { (global / 3, global % 3) };
            for (k, z) in moves.iter().enumerate() {
                let at = if sides == 3 { k } else { 3 * k + axis };
                line[at] += value / norm * z.get(vertex).copied().unwrap_or(0.0);
            }
        }
        seen.extend_from_slice(&line);
    }
    for vertex in (0..free.len()).filter(|&v| !free[v]) {
        for axis in 0..columns / moves.len() {
            line.fill(0.0);
            for (k, z) in moves.iter().enumerate() {
                line[if sides == 3 { k } else { 3 * k + axis }] = z[vertex];
            }
            seen.extend_from_slice(&line);
        }
    }
    let rows = (seen.len() / columns).max(columns);
    seen.resize(rows * columns, 0.0);
    let svd = DMatrix::from_row_slice(rows, columns, &seen).svd(false, true);
    let Some(right) = svd.v_t else { return Vec::new() };
    let largest = svd.singular_values.amax();
    let mut motions: Vec<Vec<Vector>> = Vec::new();
    for (k, _) in svd.singular_values.iter().enumerate().filter(|(_, s)| **s <= PINNED * largest) {
        let combine = |axis: usize, vertex: usize| -> f64 {
            let at = |m: usize| if sides == 3 { m } else { 3 * m + axis };
            moves.iter().enumerate().map(|(m, z)| right[(k, at(m))] * z[vertex]).sum()
        };
        if sides == 3 {
            let motion: Vec<f64> = (0..free.len()).map(|vertex| combine(0, vertex)).collect();
            motions.extend((0..3).map(|axis| motion.iter().map(|&z| Vector::ith(axis, z)).collect()));
        } else {
            let at = |vertex| Vector::new(combine(0, vertex), combine(1, vertex), combine(2, vertex));
            motions.push((0..free.len()).map(at).collect());
        }
    }
    orthonormal(motions)
}

/// A motion of which constraints see less than this part is free.
const PINNED: f64 = 1e-11;

/// Gram and Schmidt's process, twice; motions of nothing are left out.
fn orthonormal(motions: Vec<Vec<Vector>>) -> Vec<Vec<Vector>> {
    let mut done: Vec<Vec<Vector>> = Vec::new();
    for mut motion in motions {
        for _ in 0..2 {
            done.iter().for_each(|other| take_out(&mut motion, other));
            let norm = motion.iter().map(Vector::norm_squared).sum::<f64>().sqrt();
            motion.iter_mut().for_each(|v| *v /= norm);
        }
        if motion.iter().all(|v| v.iter().all(|c| c.is_finite())) {
            done.push(motion);
        }
    }
    done
}

/// Takes out of `v` what it has of a motion of length 1.
pub(crate) fn take_out(v: &mut [Vector], motion: &[Vector]) {
    let along: f64 = v.iter().zip(motion).map(|(a, b)| a.dot(b)).sum();
    v.iter_mut().zip(motion).for_each(|(v, m)| *v -= m * along);
}

/// Things worth saying about an energy: how many ways to move the whole shape it leaves free, and where the shape may break
/// without costing any.
pub(crate) fn notes(shape: &dyn Shape, squares: &Squares, ways: usize) -> Vec<String> {
    let mut notes = Vec::new();
    if ways > 0 {
        let what = if ways == 1 {
            "1 way to move the whole shape costs"
        } else {
            &format!("{ways} ways to move the whole shape cost")
        };
        notes.push(format!(
            "{what} no energy, and no constraint forbids it: there the shape stays where the constraints alone bring it"
        ));
    }
    notes.extend(breaks(shape, squares.order()));
    notes
}

/// Control vertices of `1, u, u²` (on surfaces of their products), each scaled to the unit interval.
fn candidates(shape: &dyn Shape) -> Vec<Vec<f64>> {
    let any: &dyn Any = shape;
    if let Some(curve) = any.downcast_ref::<Curve>() {
        let one = vec![vec![1.0; curve.points().len()]];
        return if curve.weights().is_some() { one } else { powers(curve.space()) };
    }
    let Some(surface) = any.downcast_ref::<Surface>() else { return Vec::new() };
    if surface.weights().is_some() {
        return vec![vec![1.0; surface.points().len()]];
    }
    let (us, vs) = (powers(surface.u()), powers(surface.v()));
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

/// Knots where the shape may break (or bend sharply) at no cost, because the energy looks within spans only.
fn breaks(shape: &dyn Shape, order: usize) -> Option<String> {
    let any: &dyn Any = shape;
    let found = if let Some(curve) = any.downcast_ref::<Curve>() {
        broken(curve.space(), order).map(|u| format!("at {u}"))
    } else {
        let surface = any.downcast_ref::<Surface>()?;
        let along = |name, space| broken(space, order).map(|u| format!("along {name} = {u}"));
        along("u", surface.u()).or_else(|| along("v", surface.v()))
    }?;
    let what = ["", "gap", "corner", "jump of curvature"][order.min(3)];
    Some(format!(
        "{found} the knots are so many that a {what} costs no energy: remove some, or ask for what should hold there"
    ))
}

/// The first interior knot of multiplicity above `p + 1 - order`.
fn broken(space: &Space, order: usize) -> Option<f64> {
    let (a, b) = space.domain();
    let allowed = (space.degree() + 1).saturating_sub(order);
    let inside = |u: &f64| (*u > a || space.is_periodic()) && *u < b;
    let mut points = space.breakpoints().into_iter().filter(inside);
    if order == 0 { None } else { points.find(|&u| space.multiplicity(u) > allowed) }
}

//! Edges that follow their faces.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::DMatrix;

use super::super::{Brep, Parts, UsePlace};
use super::Follower;
use super::sheet::Sheet;
use super::strand::{Strand, own_places, row};
use super::trace::{Line, Trace};
use crate::error::{Error, Result};
use crate::shape::Stencil;

/// The degree with which an edge follows that is no line of parameters, at least.
const DEGREE: usize = 5;
/// The highest with which it may be exact.
const EXACT: usize = 12;
/// Its spans, at least; and the most control vertices that it is given.
const SPANS: usize = 8;
const MOST: usize = 400;

/// How an edge follows.
#[derive(Debug, Clone, Copy)]
pub(super) enum Plan {
    /// As the line of parameters that it is on this use's face.
    Line(UsePlace, Line),
    /// By interpolation of the curve on this use's face.
    Fitted(UsePlace),
}

fn curve_of<'a>(
    sheets: &'a BTreeMap<usize, Sheet>,
    one: &UsePlace,
) -> Option<(&'a Sheet, &'a crate::spline::trimmed::ParameterCurve)> {
    let sheet = sheets.get(&one.face)?;
    Some((sheet, sheet.curves.get(one.chain)?.get(one.number)?))
}

/// Gives an edge the curve by which it can follow: the same, to its tolerance.
pub(super) fn replace(
    brep: &Brep,
    edge: usize,
    sheets: &BTreeMap<usize, Sheet>,
    parts: &mut Parts,
) -> Result<Plan> {
    let lost = || Error::Invalid(format!("edge {edge} is on no face that moves"));
    let uses = brep.uses(edge);
    let lines = uses.iter().filter_map(|one| {
        let (sheet, curve) = curve_of(sheets, one)?;
        Some((one, sheet, Line::of(curve)?))
    });
    let target = parts.edges.get_mut(edge).ok_or_else(lost)?;
    if let Some((one, sheet, line)) = lines.into_iter().next() {
        target.curve = Trace::of(&sheet.product(0), &line)?.curve(sheet.surface.points())?;
        target.range = target.curve.domain();
        return Ok(Plan::Line(*one, line));
    }
    let one = uses.first().ok_or_else(lost)?;
    let (sheet, curve) = curve_of(sheets, one).ok_or_else(lost)?;
    let strand = Strand::new(&sheet.surface, curve)?;
    let (from, to) = target.range;
    let mut part = target.curve.between(from, to)?;
    // Where the surface along the curve is a polynomial, the edge can be the same.
    let exact = strand.degree().filter(|d| *d <= EXACT && part.weights().is_none());
    let degree = exact.unwrap_or(0).max(DEGREE);
    if part.degree() < degree {
        part = part.elevate(degree - part.degree())?;
    }
    // Where the surface has knots, the curve on it is as smooth as these are.
    let rough = part.degree() - 2;
    let (start, end) = part.domain();
    let breaks = strand.breaks()?;
    let mut knots = Vec::new();
    let near = |knot: f64| {
        part.space()
            .breakpoints()
            .into_iter()
            .any(|t| (t - knot).abs() <= 1e-3 * (end - start) / SPANS as f64)
    };
    for &t in &breaks[1..breaks.len() - 1] {
        let knot = part.closest(strand.point(t)?)?.at;
        if knot > start && knot < end && !near(knot) {
            knots.extend(std::iter::repeat_n(knot, rough));
        }
    }
    if part.space().len() + knots.len() <= MOST && !knots.is_empty() {
        part = insert(&part, knots)?;
    }
    let spans = part.space().breakpoints();
    let each = if exact.is_some() { 1 } else { SPANS.div_ceil(spans.len() - 1).max(2) };
    let inner: Vec<f64> = spans
        .windows(2)
        .filter(|pair| pair[1] - pair[0] > 1e-6 * (end - start))
        .flat_map(|pair| (1..each).map(move |k| pair[0] + (pair[1] - pair[0]) * (k as f64 / each as f64)))
        .collect();
    if part.space().len() + inner.len() <= MOST {
        part = part.insert_knots(&inner)?;
    }
    target.range = part.domain();
    target.curve = part;
    Ok(Plan::Fitted(*one))
}

/// Knots inserted, those left out that would be repeated too often.
fn insert(curve: &crate::spline::Curve, mut knots: Vec<f64>) -> Result<crate::spline::Curve> {
    knots.sort_by(f64::total_cmp);
    let mut kept: Vec<f64> = Vec::new();
    for knot in knots {
        let times = kept.iter().filter(|k| **k == knot).count() + curve.space().multiplicity(knot);
        if times < curve.degree() {
            kept.push(knot);
        }
    }
    curve.insert_knots(&kept)
}

/// The rows of an edge's control vertices, and of its ends where it has them for itself.
pub(super) fn followers(
    brep: &Brep,
    edge: usize,
    plan: &Plan,
    sheets: &BTreeMap<usize, Sheet>,
    all: &mut Vec<Follower>,
) -> Result<()> {
    let range = brep.range_of_edge(edge);
    match plan {
        Plan::Line(one, line) => {
            let Some(product) = brep.product(one.face) else { return Ok(()) };
            let trace = Trace::of(&product, line)?;
            all.extend(range.enumerate().map(|(k, vertex)| Follower { vertex, row: trace.row(k) }));
        }
        Plan::Fitted(one) => {
            let (Some((sheet, curve)), Some(own)) = (curve_of(sheets, one), brep.curve(edge)) else {
                return Ok(());
            };
            let strand = Strand::new(&sheet.surface, curve)?;
            let (from, to) = own.domain();
            let places = own_places(own.space());
            let count = places.len();
            let mut matrix = DMatrix::zeros(count, count);
            let mut rows = Vec::with_capacity(count);
            for (k, &t) in places.iter().enumerate() {
                for (vertex, c) in row(&own, t)?.iter() {
                    matrix[(k, vertex)] = c;
                }
                let on = strand.nearest(own.point(t)?, (t - from) / (to - from))?;
                rows.push(brep.row_at(&sheet.surface, one.face, strand.parameters(on)?)?);
            }
            let columns: Vec<usize> = rows
                .iter()
                .flat_map(|row| row.vertices())
                .copied()
                .collect::<BTreeSet<_>>()
                .into_iter()
                .collect();
            let mut right = DMatrix::zeros(count, columns.len());
            for (k, row) in rows.iter().enumerate() {
                for (vertex, c) in row.iter() {
                    if let Ok(column) = columns.binary_search(&vertex) {
                        right[(k, column)] = c;
                    }
                }
            }
            let solved = matrix.lu().solve(&right).ok_or_else(|| {
                Error::Invalid(format!("edge {edge} cannot be interpolated in its own space"))
            })?;
            for (k, vertex) in range.enumerate() {
                let entries = columns.iter().enumerate().map(|(column, v)| (*v, solved[(k, column)]));
                let row: Stencil = entries.filter(|(_, c)| c.abs() > 1e-15).collect();
                all.push(Follower { vertex, row });
            }
        }
    }
    Ok(())
}

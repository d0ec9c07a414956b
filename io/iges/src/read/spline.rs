//! B-splines (126, 128) and the older parametric splines (112, 114), whose pieces are given by their powers.

use loftsman_kernel::Point;
use loftsman_kernel::brep::CurveForm;
use loftsman_kernel::spline::{Curve, Direction, Space, Surface};

use super::curve::Run;
use super::entity::{At, Entity, Got, Problem};

/// A degree: what the file calls one, if it can be one.
fn degree(entity: &Entity<'_, '_>, index: usize) -> Got<usize> {
    let degree = entity.whole(index)?;
    usize::try_from(degree)
        .ok()
        .filter(|d| *d <= entity.len())
        .ok_or_else(|| Problem::new(entity.place, format!("a spline of the degree {degree}")))
}

/// The number of the last control point, so one less than there are.
fn upper(entity: &Entity<'_, '_>, index: usize) -> Got<usize> {
    let upper = entity.whole(index)?;
    usize::try_from(upper).ok().filter(|u| *u <= entity.len()).ok_or_else(|| {
        let found = entity.len();
        Problem::new(entity.place, format!("a spline of {upper} + 1 control points in {found} parameters"))
    })
}

/// Weights; none where all are alike, as those of polynomial splines are.
fn weights(entity: &Entity<'_, '_>, weights: Vec<f64>) -> Got<Option<Vec<f64>>> {
    if let Some(bad) = weights.iter().find(|w| **w <= 0.0) {
        let text = format!("the weight {bad} of a control point: it must be positive");
        return Err(Problem::new(entity.place, text));
    }
    let alike = weights.windows(2).all(|pair| pair[0] == pair[1]);
    Ok((!alike).then_some(weights))
}

fn points(numbers: &[f64]) -> Vec<Point> {
    numbers.chunks_exact(3).map(|c| Point::new(c[0], c[1], c[2])).collect()
}

/// Where a spline starts and ends, if that is inside of where it may.
fn part(domain: (f64, f64), from: f64, to: f64) -> Option<(f64, f64)> {
    let slack = 1e-9 * (domain.1 - domain.0);
    let inside = from < to && from >= domain.0 - slack && to <= domain.1 + slack;
    let whole = (from - domain.0).abs() <= slack && (to - domain.1).abs() <= slack;
    (inside && !whole).then(|| (from.max(domain.0), to.min(domain.1)))
}

/// A rational B-spline curve (126).
pub(crate) fn curve(entity: &Entity<'_, '_>) -> Got<Run> {
    let place = entity.place;
    let (upper, degree) = (upper(entity, 1)?, degree(entity, 2)?);
    let (count, knots) = (upper + 1, upper + degree + 2);
    let knots_at = 7;
    let weights_at = knots_at + knots;
    let points_at = weights_at + count;
    let ends_at = points_at + 3 * count;
    let space = Space::open(degree, entity.reals(knots_at, knots)?).at(place)?;
    let weights = weights(entity, entity.reals(weights_at, count)?)?;
    let points = points(&entity.reals(points_at, 3 * count)?);
    let mut curve = Curve::build(space, points, weights).at(place)?;
    if let (Some(from), Some(to)) = (entity.optional(ends_at)?, entity.optional(ends_at + 1)?)
        && let Some((from, to)) = part(curve.domain(), from, to)
    {
        curve = curve.between(from, to).at(place)?;
    }
    Ok(Run::spline(curve, CurveForm::Spline))
}

/// Where the parameters of a type that counts itself end.
pub(crate) fn curve_end(entity: &Entity<'_, '_>) -> Option<usize> {
    let (upper, degree) = (upper(entity, 1).ok()?, degree(entity, 2).ok()?);
    Some(6 + (upper + degree + 2) + 4 * (upper + 1) + 5)
}

/// The same of a surface.
pub(crate) fn surface_end(entity: &Entity<'_, '_>) -> Option<usize> {
    let [ku, kv] = [upper(entity, 1).ok()?, upper(entity, 2).ok()?];
    let [mu, mv] = [degree(entity, 3).ok()?, degree(entity, 4).ok()?];
    let count = (ku + 1).checked_mul(kv + 1)?.checked_mul(4)?;
    (9 + ku + mu + 2 + kv + mv + 2 + 4).checked_add(count)
}

/// A rational B-spline surface (128).
pub(crate) fn surface(entity: &Entity<'_, '_>) -> Got<Surface> {
    let place = entity.place;
    let (ku, kv) = (upper(entity, 1)?, upper(entity, 2)?);
    let (mu, mv) = (degree(entity, 3)?, degree(entity, 4)?);
    let (columns, rows) = (kv + 1, ku + 1);
    let count = rows.saturating_mul(columns);
    if count > entity.len() {
        let found = entity.len();
        let text = format!("a surface of {rows} × {columns} control points in {found} parameters");
        return Err(Problem::new(place, text));
    }
    let mut at = 10;
    let mut take = |many: usize| {
        at += many;
        entity.reals(at - many, many)
    };
    let u = Space::open(mu, take(ku + mu + 2)?).at(place)?;
    let v = Space::open(mv, take(kv + mv + 2)?).at(place)?;
    // In the file the first direction runs fastest.
    let weights = weights(entity, take(count)?)?;
    let weights = weights.map(|w| transposed(&w, rows, columns));
    let points = transposed(&points(&take(3 * count)?), rows, columns);
    let mut surface = Surface::build(u, v, points, weights).at(place)?;
    for (direction, first) in [(Direction::U, at), (Direction::V, at + 2)] {
        if let (Some(from), Some(to)) = (entity.optional(first)?, entity.optional(first + 1)?)
            && let Some((from, to)) = part(surface.space(direction).domain(), from, to)
        {
            surface = surface.between(direction, from, to).at(place)?;
        }
    }
    Ok(surface)
}

/// A list in which rows run fastest as one in which columns do.
fn transposed<T: Copy>(list: &[T], rows: usize, columns: usize) -> Vec<T> {
    (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j))).map(|(i, j)| list[j * rows + i]).collect()
}

/// The Bézier ordinates of `c₀ + c₁ s + c₂ s² + c₃ s³` over `[0, h]`.
fn bezier(c: &[f64], h: f64) -> [f64; 4] {
    let [c0, c1, c2, c3] = [c[0], c[1] * h, c[2] * h * h, c[3] * h * h * h];
    [c0, c0 + c1 / 3.0, c0 + (2.0 * c1 + c2) / 3.0, c0 + c1 + c2 + c3]
}

/// Knots of pieces of degree 3, each inner one three times.
fn piecewise(breaks: &[f64]) -> loftsman_kernel::Result<Space> {
    let last = breaks.len() - 1;
    let knots = breaks
        .iter()
        .enumerate()
        .flat_map(|(k, &t)| std::iter::repeat_n(t, if k == 0 || k == last { 4 } else { 3 }));
    Space::open(3, knots.collect())
}

/// A parametric spline curve (112).
pub(crate) fn parametric_curve(entity: &Entity<'_, '_>) -> Got<Run> {
    let place = entity.place;
    let pieces = entity.count(4, 13)?;
    if pieces == 0 {
        return Err(Problem::new(place, "a parametric spline without pieces"));
    }
    let breaks = entity.reals(5, pieces + 1)?;
    let all = entity.reals(6 + pieces, 12 * pieces)?;
    let mut net: Vec<Point> = Vec::with_capacity(3 * pieces + 1);
    for (piece, ends) in all.chunks_exact(12).zip(breaks.windows(2)) {
        let axes: Vec<[f64; 4]> = piece.chunks_exact(4).map(|c| bezier(c, ends[1] - ends[0])).collect();
        // Of two ends that are one the later one counts.
        net.pop();
        net.extend((0..4).map(|k| Point::new(axes[0][k], axes[1][k], axes[2][k])));
    }
    let curve = piecewise(&breaks).and_then(|space| Curve::new(space, net)).at(place)?;
    Ok(Run::spline(curve, CurveForm::Spline))
}

/// A parametric spline surface (114), patch after patch; behind each row, and behind all, stand patches that say nothing.
pub(crate) fn parametric_surface(entity: &Entity<'_, '_>) -> Got<Surface> {
    let place = entity.place;
    let (m, n) = (entity.count(3, 48)?, entity.count(4, 48)?);
    if m == 0 || n == 0 || (m.saturating_mul(n)).saturating_mul(48) > entity.len() {
        return Err(Problem::new(place, format!("a parametric spline surface of {m} × {n} patches")));
    }
    let (us, vs) = (entity.reals(5, m + 1)?, entity.reals(6 + m, n + 1)?);
    let first = 7 + m + n;
    let columns = 3 * n + 1;
    let mut net = vec![Point::origin(); (3 * m + 1) * columns];
    for i in 0..m {
        for j in 0..n {
            let patch = entity.reals(first + 48 * (i * (n + 1) + j), 48)?;
            let (h, k) = (us[i + 1] - us[i], vs[j + 1] - vs[j]);
            for axis in 0..3 {
                // Four rows of powers of `u`, one for each power of `v`.
                let rows: Vec<[f64; 4]> =
                    (0..4).map(|q| bezier(&patch[16 * axis + 4 * q..16 * axis + 4 * q + 4], h)).collect();
                for a in 0..4 {
                    let along = bezier(&[rows[0][a], rows[1][a], rows[2][a], rows[3][a]], k);
                    for b in 0..4 {
                        net[(3 * i + a) * columns + 3 * j + b][axis] = along[b];
                    }
                }
            }
        }
    }
    piecewise(&us).and_then(|u| Surface::new(u, piecewise(&vs)?, net)).at(place)
}

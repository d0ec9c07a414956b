//! How far an edit reaches (paper 4, §2 and §5).

use crate::error::{Error, Result};
use crate::functional::Shapes;
use crate::shape::{Derivative, Location};
use crate::spline::{Curve, Space};

/// How far an edit reaches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Locality {
    /// Only this many vertices may move: those with the largest influence on the dragged location.
    Vertices(usize),
    /// Only the curve between these two parameters may change; knots are inserted until it can.
    Within(f64, f64),
}

/// The `count` vertices with the largest stencil values at a location: ascending global numbers.
///
/// # Errors
/// When `count` is zero or more than the location's stencil has, or the location is outside the domain.
pub(super) fn most_influential(
    shapes: &Shapes<'_>,
    shape: usize,
    at: Location,
    count: usize,
) -> Result<Vec<usize>> {
    let stencil = shapes.stencil(shape, at, Derivative::POSITION)?;
    let mut all: Vec<(usize, f64)> = stencil.iter().filter(|(_, c)| *c != 0.0).collect();
    if count == 0 || count > stencil.vertices().len() {
        return Err(Error::Invalid(format!(
            "a locality of {count} is not possible: {} control vertices have influence at {at}",
            all.len()
        )));
    }
    // Equal influence: the earlier vertex first, so that the choice does not depend on the sort.
    all.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()).then(a.0.cmp(&b.0)));
    let mut chosen: Vec<usize> = all.iter().take(count).map(|(v, _)| shapes.offset(shape) + v).collect();
    chosen.sort_unstable();
    Ok(chosen)
}

/// The pick convention of paper 4: a pick closer to an end of a clamped curve than `tolerance` (a length) picks the
/// end itself.
///
/// # Errors
/// When `u` is outside the domain.
pub fn pick(curve: &Curve, u: f64, tolerance: f64) -> Result<f64> {
    let point = curve.point(u)?;
    if !curve.space().is_clamped() {
        return Ok(u);
    }
    let (a, b) = curve.domain();
    let near = |end: f64| -> Result<f64> { Ok((curve.point(end)? - point).norm()) };
    let (to_start, to_end) = (near(a)?, near(b)?);
    // The nearer end along the curve, where both are near in space (a closed outline).
    let end = if u - a <= b - u { (a, to_start) } else { (b, to_end) };
    Ok(if end.1 <= tolerance { end.0 } else { u })
}

/// The localities that one can cycle through at a parameter, from the narrowest to the widest: a single vertex up
/// to all that have influence there, then ever narrower intervals for which knots would be inserted, from half the
/// domain down to a sixteenth.
///
/// # Errors
/// When `u` is outside the domain.
pub fn localities(curve: &Curve, u: f64) -> Result<Vec<Locality>> {
    let u = curve.space().locate(u)?;
    let (a, b) = curve.domain();
    let mut all: Vec<Locality> = (1..=curve.degree() + 1).map(Locality::Vertices).collect();
    for halvings in 1..=4 {
        let width = (b - a) / f64::from(1 << halvings);
        let start = (u - width / 2.0).max(a).min(b - width);
        all.push(Locality::Within(start, start + width));
    }
    Ok(all)
}

/// The curve with knots inserted so that an edit can stay within `[start, end]`, and the vertices that may move:
/// those whose basis functions vanish outside it (paper 4, §5; hierarchical refinement after Forsey and Bartels).
///
/// There are at least `vertices` of them with influence at `u` (`1 ..= p + 1`). The interval's ends become knots, and
/// the interval is divided evenly around `u` until that holds. The curve does not change its shape.
///
/// # Errors
/// When the interval is empty or outside the domain, does not contain `u`, or `vertices` is out of range. A periodic
/// curve's interval may not pass the seam; reparametrise it first.
pub fn localise(curve: &Curve, start: f64, end: f64, u: f64, vertices: usize) -> Result<(Curve, Vec<usize>)> {
    let space = curve.space();
    let (a, b) = space.domain();
    let p = curve.degree();
    if !(start >= a && end <= b && start < u && u < end) {
        return Err(Error::Invalid(format!(
            "the interval [{start}, {end}] must lie in the domain [{a}, {b}] and have {u} inside"
        )));
    }
    if vertices == 0 || vertices > p + 1 {
        return Err(Error::Invalid(format!(
            "{vertices} vertices cannot have influence at one place: 1 to {}",
            p + 1
        )));
    }
    let mut refined = curve.clone();
    let missing: Vec<f64> = [start, end].into_iter().filter(|&k| space.multiplicity(k) == 0).collect();
    refined = refined.insert_knots(&missing)?;
    // Halve the longest span inside the interval that lies nearest to u, until enough functions live inside. A
    // function needs p + 1 spans: 2p + 2 pieces are always enough.
    for _ in 0..64 {
        let inside = supported_inside(refined.space(), start, end);
        let influential = refined.space().clone();
        let here = influential.span(influential.locate(u)?);
        let count =
            (here - p..=here).filter(|&k| inside.binary_search(&influential.vertex(k)).is_ok()).count();
        if count >= vertices {
            return Ok((refined, inside));
        }
        let breaks = refined.space().breakpoints();
        let span = breaks
            .windows(2)
            .filter(|s| s[0] >= start && s[1] <= end)
            .max_by(|x, y| {
                let (lx, ly) = (x[1] - x[0], y[1] - y[0]);
                let away = |s: &[f64]| (0.5 * (s[0] + s[1]) - u).abs();
                // Equal to rounding counts as equal: then the nearer one.
                if (lx - ly).abs() > 1e-9 * (end - start) {
                    lx.total_cmp(&ly)
                } else {
                    away(y).total_cmp(&away(x))
                }
            })
            .map(|s| 0.5 * (s[0] + s[1]));
        match span {
            Some(knot) if refined.space().multiplicity(knot) == 0 => {
                refined = refined.insert_knots(&[knot])?;
            }
            _ => break,
        }
    }
    Err(Error::Invalid(format!("the interval [{start}, {end}] is too short to hold an edit: widen it")))
}

/// The vertices whose basis functions vanish outside `[start, end]`, ascending.
fn supported_inside(space: &Space, start: f64, end: f64) -> Vec<usize> {
    let flat = space.flat();
    let p = space.degree();
    let mut inside: Vec<usize> = (0..space.unrolled_len())
        .filter(|&k| {
            let (low, high) = (flat[k], flat[k + p + 1]);
            // Clamped ends: the support reaches no further than the domain.
            low >= start && high <= end
        })
        .map(|k| space.vertex(k))
        .collect();
    inside.sort_unstable();
    inside.dedup();
    inside
}

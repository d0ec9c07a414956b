//! How far an edit reaches (paper 4, §2 and §5).

use std::collections::BTreeSet;

use smallvec::SmallVec;

use crate::error::{Error, Result};
use crate::functional::Shapes;
use crate::shape::{Derivative, Interval, Location, Shape, cells_of, refine_of};
use crate::spline::Curve;

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
            "a locality of {count} is not possible: {} control vertices have influence at {at}; ask for 1 to so many, or leave locality out",
            all.len()
        )));
    }
    // Equal influence: the earlier vertex first, so that the choice does not depend on the sort.
    all.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()).then(a.0.cmp(&b.0)));
    let mut chosen: Vec<usize> = all.iter().take(count).map(|(v, _)| shapes.offset(shape) + v).collect();
    chosen.sort_unstable();
    Ok(chosen)
}

/// The pick convention of paper 4: a pick closer to an end of a curve than `tolerance` (a length) picks the end itself. Of a
/// B-spline only where it is clamped, so that the end is a control vertex.
///
/// # Errors
/// When the shape is no curve, or `u` is outside the domain.
pub fn pick(curve: &dyn Shape, u: f64, tolerance: f64) -> Result<f64> {
    let value = |u: f64| curve.value(Location::Curve(u), Derivative::POSITION);
    let point = value(u)?;
    let domain = curve.domain();
    let floats =
        curve.cells().and_then(|cells| cells.splines()).is_some_and(|splines| !splines.u.is_clamped());
    let Some(&Interval { start: a, end: b, periodic: false }) = domain.first().filter(|_| !floats) else {
        return Ok(u);
    };
    let near = |end: f64| -> Result<f64> { Ok((value(end)? - point).norm()) };
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
/// Any curve will do that consists of cells and can be refined.
///
/// # Errors
/// When the shape is no such curve, the interval is empty or outside the domain, does not contain `u`, or `vertices` is out of
/// range. A periodic curve's interval may not pass the seam; reparametrise it first.
pub fn localise(
    curve: &dyn Shape,
    start: f64,
    end: f64,
    u: f64,
    vertices: usize,
) -> Result<(Box<dyn Shape>, Vec<usize>)> {
    localise_beside(curve, start, end, u, vertices, &|_, _| Vec::new())
}

/// Which of some vertices of a refined curve something else keeps where they are.
type Kept<'a> = dyn Fn(&dyn Shape, &[usize]) -> Vec<usize> + 'a;

/// The same where some of the vertices inside the interval are `kept` by something else and do not count.
pub(super) fn localise_beside(
    curve: &dyn Shape,
    start: f64,
    end: f64,
    u: f64,
    vertices: usize,
    kept: &Kept<'_>,
) -> Result<(Box<dyn Shape>, Vec<usize>)> {
    let [Interval { start: a, end: b, .. }] = curve.domain()[..] else { return Err(no_curve()) };
    let at = |u: f64| curve.value(Location::Curve(u), Derivative::POSITION);
    let size = || curve.control_vertices().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
    let closes = || at(a).ok().zip(at(b).ok()).is_some_and(|(p, q)| (p - q).norm() <= 1e-9 * size());
    let over_seam = "the curve closes: over its seam, have it begin elsewhere first (operation simplify with periodic = true, then split where it is to begin)";
    if end < start {
        let what = if closes() { over_seam } else { "its ends are the wrong way round, exchange them" };
        return Err(Error::Invalid(format!("the interval [{start}, {end}] runs backwards: {what}")));
    }
    if !(start >= a && end <= b && start < u && u < end) {
        return Err(Error::Invalid(format!(
            "the interval [{start}, {end}] must lie in the domain [{a}, {b}] and have {u} inside{}",
            if (start < a || end > b) && closes() { format!("; {over_seam}") } else { String::new() }
        )));
    }
    let most = influence(curve)?;
    if vertices == 0 || vertices > most {
        return Err(Error::Invalid(format!(
            "{vertices} vertices cannot have influence at one place: 1 to {most}"
        )));
    }
    let refine = refine_of(curve, WITHIN)?;
    let mut refined = curve.boxed();
    let cells = Intervals::of(curve)?;
    let missing: Vec<f64> = [start, end].into_iter().filter(|k| !cells.ends_at(*k)).collect();
    if !missing.is_empty() {
        refined = refine.refined(0, &missing)?;
    }
    // Halve the longest cell inside the interval that lies nearest to u, until enough functions live inside. A spline's
    // function needs p + 1 spans: 2p + 2 pieces are always enough.
    for _ in 0..64 {
        let cells = Intervals::of(refined.as_ref())?;
        let inside = cells.supported_inside(start, end);
        let kept = kept(refined.as_ref(), &inside);
        let counts = |v: &&usize| inside.binary_search(v).is_ok() && !kept.contains(v);
        if cells.at(u).iter().filter(counts).count() >= vertices {
            return Ok((refined, inside));
        }
        let longest = cells
            .0
            .iter()
            .filter(|(low, high, _)| *low >= start && *high <= end)
            .max_by(|x, y| {
                let (lx, ly) = (x.1 - x.0, y.1 - y.0);
                let away = |s: &(f64, f64, _)| (0.5 * (s.0 + s.1) - u).abs();
                // Equal to rounding counts as equal: then the nearer one.
                if (lx - ly).abs() > 1e-9 * (end - start) {
                    lx.total_cmp(&ly)
                } else {
                    away(y).total_cmp(&away(x))
                }
            })
            .map(|(low, high, _)| 0.5 * (low + high));
        match longest {
            Some(knot) if !cells.ends_at(knot) => {
                refined = refine_of(refined.as_ref(), WITHIN)?.refined(0, &[knot])?;
            }
            _ => break,
        }
    }
    Err(Error::Invalid(format!("the interval [{start}, {end}] is too short to hold an edit: widen it")))
}

/// What refines a curve here, in messages.
const WITHIN: &str = "an edit within an interval";

/// That something else than a curve should be edited within an interval.
fn no_curve() -> Error {
    Error::Invalid("only an edit of a curve can be kept within an interval".into())
}

/// How many control vertices have influence at one place of a curve: the most of any cell.
///
/// # Errors
/// When it is no curve, or does not say of which cells it consists.
pub(super) fn influence(curve: &dyn Shape) -> Result<usize> {
    if curve.domain().len() != 1 {
        return Err(no_curve());
    }
    let cells = cells_of(curve, WITHIN)?;
    Ok(match cells.splines() {
        Some(splines) => splines.u.degree() + 1,
        None => cells.iter().map(|cell| cell.vertices.len()).max().unwrap_or(0),
    })
}

/// The cells of a curve, one after another: where each starts and ends, and its vertices.
pub(super) struct Intervals(Vec<(f64, f64, SmallVec<[usize; 16]>)>);

impl Intervals {
    /// # Errors
    /// When it is no curve, or does not say of which cells it consists.
    pub(super) fn of(curve: &dyn Shape) -> Result<Self> {
        if curve.domain().len() != 1 {
            return Err(no_curve());
        }
        let cells = cells_of(curve, WITHIN)?.checked(curve)?.into_iter();
        let mut all: Vec<_> =
            cells.filter_map(|cell| Some((cell.sides.first().copied()?, cell.vertices))).collect();
        all.sort_by(|a, b| a.0.start.total_cmp(&b.0.start));
        Ok(Self(all.into_iter().map(|(side, vertices)| (side.start, side.end, vertices)).collect()))
    }

    fn ends_at(&self, u: f64) -> bool {
        self.0.iter().any(|(start, end, _)| *start == u || *end == u)
    }

    /// The vertices of the cell that a parameter is in.
    fn at(&self, u: f64) -> &[usize] {
        let after = self.0.partition_point(|(start, ..)| *start <= u);
        self.0.get(after.saturating_sub(1)).map_or(&[], |(.., vertices)| vertices)
    }

    /// The vertices that have no influence outside `[start, end]`, ascending.
    pub(super) fn supported_inside(&self, start: f64, end: f64) -> Vec<usize> {
        let within = |(low, high, _): &&(f64, f64, _)| *low >= start && *high <= end;
        let outside: BTreeSet<usize> =
            self.0.iter().filter(|cell| !within(cell)).flat_map(|(.., vertices)| vertices).copied().collect();
        let inside: BTreeSet<usize> =
            self.0.iter().filter(within).flat_map(|(.., vertices)| vertices).copied().collect();
        inside.difference(&outside).copied().collect()
    }
}

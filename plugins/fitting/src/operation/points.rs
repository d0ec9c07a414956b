//! What the points are, and how they turn: chains, clouds that are no line, corners that are rounded.

use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::plugin::{ParameterError, Parameters};
use loftsman_kernel::scene::Unit;
use loftsman_kernel::{Error, Point};

use super::asked::degree_of;
use crate::fit::FittedCurve;

/// A turn between neighbouring points beyond this angle is a corner: 60°.
pub(super) const CORNER: f64 = std::f64::consts::FRAC_PI_3;

/// A smooth curve that leaves the straight sides of a turn by more than so many tolerances is told of,
pub(super) const ROUNDED: f64 = 4.0;

/// where the points turn by 20° or more, and beside by less than this part of it;
pub(super) const STRAIGHT_SIDES: f64 = std::f64::consts::PI / 9.0;

pub(super) const STRAIGHT: f64 = 0.1;

/// it is looked at in so many places on a side.
pub(super) const PLACES: u32 = 9;

/// Whether a mesh of nothing but lines is one chain, else what it is.
pub(super) fn one_chain(mesh: &Mesh) -> Result<(), String> {
    if mesh.face_count() > 0 || mesh.lines().next().is_none() {
        return Ok(());
    }
    let same = mesh.welded();
    // Each point's lines, and which point stands for all that hang together with it.
    let mut ends = vec![0_usize; same.len()];
    let mut above: Vec<u32> = (0..same.len() as u32).collect();
    let top = |above: &mut Vec<u32>, mut k: u32| {
        while above[k as usize] != k {
            let next = above[above[k as usize] as usize];
            above[k as usize] = next;
            k = next;
        }
        k
    };
    for pair in mesh.lines().flat_map(|line| line.windows(2)) {
        let [p, q] = [pair[0], pair[1]].map(|k| same[k as usize]);
        if p == q {
            continue;
        }
        ends[p as usize] += 1;
        ends[q as usize] += 1;
        let (p, q) = (top(&mut above, p), top(&mut above, q));
        above[p.max(q) as usize] = p.min(q);
    }
    let chains = (0..above.len()).filter(|&k| ends[k] > 0 && above[k] as usize == k).count();
    if chains > 1 {
        return Err(format!("{chains} separate lines"));
    }
    if ends.iter().any(|&count| count > 2) {
        return Err("lines that branch".into());
    }
    Ok(())
}

/// Points of which more than this part turn back are no line.
pub(super) const BACK: f64 = 0.25;

/// Fewer points than this may do what they like.
pub(super) const FEW: usize = 24;

/// Whether points in their order go to and fro: at more than a quarter of them by more than a right angle.
pub(super) fn is_scattered(points: &[Point]) -> bool {
    let turns = points.windows(3).filter(|p| (p[1] - p[0]).dot(&(p[2] - p[1])) < 0.0).count();
    points.len() >= FEW && turns as f64 > BACK * points.len() as f64
}

/// What to say where the points turn too sharply for the curve: the sharpest corner, and what to do. One of degree 1 through all points
/// has all corners that they have.
pub(super) fn corner(
    points: &[Point],
    closed: bool,
    parameters: &Parameters,
) -> Result<Option<String>, ParameterError> {
    let (interpolates, straight) = (parameters.flag("interpolate")?, degree_of(parameters)? == 1);
    if interpolates && straight {
        return Ok(None);
    }
    let n = points.len();
    let turn = |k: usize| turn(points, k);
    let range = if closed { 0..n } else { 1..n.saturating_sub(1) };
    let (angle, k) = range.map(|k| (turn(k), k)).fold((0.0, 0), |m, t| if t.0 > m.0 { t } else { m });
    if angle < CORNER {
        return Ok(None);
    }
    let advice = match (closed, k) {
        _ if interpolates => {
            "a `fit` without `interpolate` keeps such corners (corners = \"auto\", or an angle in degrees)"
        }
        (true, 0) => {
            "closed = false keeps the corner there, corners = \"auto\" (or an angle in degrees) all such"
        }
        _ => "corners = \"auto\", or an angle in degrees, keeps such corners",
    };
    let keeps = if straight {
        "a curve of degree 1 keeps only where it has a vertex there"
    } else {
        "a smooth curve can only round or overshoot"
    };
    let angle = angle.to_degrees();
    Ok(Some(format!("the points turn by {angle:.0}° at point {k}, which {keeps}: {advice}")))
}

/// The turn of a chain, which may be closed, at a point.
pub(super) fn turn(points: &[Point], k: usize) -> f64 {
    let n = points.len();
    let before = points[k] - points[(k + n - 1) % n];
    let after = points[(k + 1) % n] - points[k];
    // Of unit vectors, so that no square overflows; a repeated point turns nowhere.
    let (a, b) = (before / before.amax(), after / after.amax());
    Some(a.angle(&b)).filter(|angle| angle.is_finite()).unwrap_or(0.0)
}

/// What to say where corners were asked for and the points turn, by less than that, between straight sides: where a smooth curve leaves such
/// sides farthest, and by more than [`ROUNDED`] tolerances. Beside a vertex of a round chain the points turn, too.
pub(super) fn rounded(
    fitted: &FittedCurve,
    points: &[Point],
    closed: bool,
    unit: Unit,
) -> Result<Option<String>, Error> {
    let m = fitted.parameters.len().min(points.len());
    let points = &points[..m];
    let Some(tolerance) = fitted.tolerance.filter(|_| m > 4) else { return Ok(None) };
    let (start, end) = fitted.curve.domain();
    let mut worst = None::<(f64, usize)>;
    for k in if closed { 0..m } else { 2..m - 2 } {
        let own = turn(points, k);
        let flanks = turn(points, (k + m - 1) % m).max(turn(points, (k + 1) % m));
        if own < STRAIGHT_SIDES || flanks > STRAIGHT * own || fitted.corners.contains(&k) {
            continue;
        }
        for [a, b] in [[(k + m - 1) % m, k], [k, (k + 1) % m]] {
            let (from, mut to) = (fitted.parameters[a], fitted.parameters[b]);
            if to < from {
                to += end - start;
            }
            let side = points[b] - points[a];
            let along = side / side.norm();
            for i in 1..PLACES {
                let u = from + (to - from) * f64::from(i) / f64::from(PLACES);
                let off = fitted.curve.point(if u > end { u - (end - start) } else { u })? - points[a];
                let off = (off - along * off.dot(&along).clamp(0.0, side.norm())).norm();
                if off > worst.map_or(ROUNDED * tolerance, |(most, _)| most) {
                    worst = Some((off, k));
                }
            }
        }
    }
    Ok(worst.map(|(off, k)| {
        let angle = turn(points, k).to_degrees();
        format!(
            "the points turn by {angle:.0}° at point {k}, between straight sides that the smooth curve there leaves by {}: corners = {:.0} keeps the corner",
            unit.quantity(off, 1),
            (angle - 0.5).floor()
        )
    }))
}

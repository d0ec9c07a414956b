//! Offsets of free-form surfaces, which are no splines: cubic pieces near to them.
//!
//! Each piece has the offset's points, first derivatives and twist at its corners (`O = S + d n`, `O_u = S_u + d n_u`), so that pieces
//! side by side meet in a curve and, where the offset is smooth, smoothly. Rows and columns of pieces are halved until all are near enough at
//! the places between where they are measured. Parameters are those of the basis: curves in its plane stay what they are.

use super::{Space, Surface};
use crate::error::{Error, Result};
use crate::{Point, Vector};

/// Pieces in each direction at most.
const PIECES: usize = 256;
/// Places inside a piece, in each direction, at which it is measured.
const MEASURED: usize = 5;
/// How far inside a piece, in parts of it, derivatives at its corners are taken: at knots they jump.
const INSIDE: f64 = 1e-9;
/// The step for the twist, in parts of a piece.
const STEP: f64 = 1e-4;

/// The offset at a place.
struct Place {
    point: Point,
    along: [Vector; 2],
    normal: Vector,
}

impl Surface {
    /// The offset by a distance along `S_u × S_v`, `S + d n`, as bicubic pieces over the same parameters, and by how much it was found to be off at 25 places of
    /// each: at most `share` of the size of the surface. `O(pieces)`, at most 256² of them.
    ///
    /// ```
    /// use loftsman_kernel::{Point, Vector, spline::{Curve, Surface}};
    /// let profile = Curve::elliptic_arc(Point::origin(), Vector::x(), Vector::z(), -0.7, 1.4)?;
    /// let ball = Surface::revolution(&profile, Point::origin(), Vector::z(), 1.5)?;
    /// let (wider, off) = ball.offset(0.25, 1e-6)?;
    /// let p = wider.point(ball.u().domain().1 / 2.0, ball.v().domain().1 / 3.0)?;
    /// assert!(off <= 2e-6 && (p.coords.norm() - 1.25).abs() < 2e-6);
    /// # Ok::<(), loftsman_kernel::Error>(())
    /// ```
    ///
    /// # Errors
    /// When the surface has no normal somewhere, may have a crease, bends more sharply than the distance, or needs too many pieces.
    pub fn offset(&self, distance: f64, share: f64) -> Result<(Self, f64)> {
        offset(self, distance, share)
    }
}

fn offset(surface: &Surface, distance: f64, share: f64) -> Result<(Surface, f64)> {
    let spaces = [surface.u(), surface.v()];
    for (d, name) in ["u", "v"].into_iter().enumerate() {
        let (start, end) = spaces[d].domain();
        let may_be = |t: &f64| *t > start && *t < end && spaces[d].multiplicity(*t) >= spaces[d].degree();
        for at in spaces[d].breakpoints().into_iter().filter(may_be) {
            if spaces[d].multiplicity(at) > spaces[d].degree() || is_creased(surface, d, at)? {
                return Err(Error::Invalid(format!(
                    "an offset of a surface that has a crease at {name} = {at}: it is torn there"
                )));
            }
        }
    }
    let mut breaks = spaces.map(Space::breakpoints);
    let net = surface.points();
    let size = net.iter().map(|p| (p - net[0]).norm()).fold(0.0, f64::max);
    loop {
        let (found, errors) = pieces(surface, distance, &breaks)?;
        let worst = errors.iter().flatten().fold(0.0, |most: f64, e| most.max(*e));
        if !worst.is_finite() {
            return Err(Error::Invalid("an offset whose points overflow".into()));
        }
        if worst <= share * size {
            return Ok((found, worst));
        }
        let bad = |i: usize, j: usize| errors[i][j] > share * size;
        let (rows, columns) = (breaks[0].len() - 1, breaks[1].len() - 1);
        let rows_bad: Vec<bool> = (0..rows).map(|i| (0..columns).any(|j| bad(i, j))).collect();
        let columns_bad: Vec<bool> = (0..columns).map(|j| (0..rows).any(|i| bad(i, j))).collect();
        breaks = [halved(&breaks[0], &rows_bad), halved(&breaks[1], &columns_bad)];
        if breaks.iter().any(|breaks| breaks.len() > PIECES) {
            return Err(Error::Invalid(format!(
                "an offset of a free-form surface that {PIECES} pieces in a direction are not near to: {worst:e} off"
            )));
        }
    }
}

/// Normals on both sides of a knot that differ by more than this, in radians, make a crease.
const CREASED: f64 = 1e-6;

/// Whether normals differ on both sides of a knot of a direction, at places of each span of the other.
fn is_creased(surface: &Surface, direction: usize, knot: f64) -> Result<bool> {
    let spaces = [surface.u(), surface.v()];
    let (start, end) = spaces[direction].domain();
    let beside = INSIDE * (end - start);
    for span in spaces[1 - direction].breakpoints().windows(2) {
        for share in [0.0, 0.3, 0.7, 1.0] {
            let along = if share == 1.0 { span[1] } else { span[0] + share * (span[1] - span[0]) };
            let mut at = [along; 2];
            let mut normal = |t: f64| {
                at[direction] = t;
                place(surface, 0.0, at).map(|place| place.normal)
            };
            if (normal(knot + beside)? - normal(knot - beside)?).norm() > CREASED {
                return Ok(true);
            }
        }
    }
    Ok(false)
}

fn halved(breaks: &[f64], bad: &[bool]) -> Vec<f64> {
    let mut all = vec![breaks[0]];
    for (pair, bad) in breaks.windows(2).zip(bad) {
        if *bad {
            all.push(0.5 * (pair[0] + pair[1]));
        }
        all.push(pair[1]);
    }
    all
}

/// The pieces between breaks, and how far each is off where it is measured.
fn pieces(surface: &Surface, distance: f64, breaks: &[Vec<f64>; 2]) -> Result<(Surface, Vec<Vec<f64>>)> {
    let counts = [0, 1].map(|d: usize| breaks[d].len() - 1);
    let columns = 3 * counts[1] + 1;
    let mut net = vec![Point::origin(); (3 * counts[0] + 1) * columns];
    let mut errors = vec![vec![0.0; counts[1]]; counts[0]];
    for i in 0..counts[0] {
        for j in 0..counts[1] {
            let (a, b) = ([breaks[0][i], breaks[1][j]], [breaks[0][i + 1], breaks[1][j + 1]]);
            let piece = piece(surface, distance, a, b)?;
            for (k, p) in piece.iter().enumerate() {
                net[(3 * i + k / 4) * columns + 3 * j + k % 4] = *p;
            }
            errors[i][j] = off(surface, distance, (a, b), &piece)?;
        }
    }
    let space = |d: usize| {
        let ends = [breaks[d][0], breaks[d][counts[d]]];
        let inner = breaks[d][1..counts[d]].iter().flat_map(|t| [*t; 3]);
        let knots = [ends[0]; 4].into_iter().chain(inner).chain([ends[1]; 4]);
        Space::open(3, knots.collect())
    };
    Ok((Surface::new(space(0)?, space(1)?, net)?, errors))
}

/// The 16 points of a piece, along v first.
fn piece(surface: &Surface, distance: f64, a: [f64; 2], b: [f64; 2]) -> Result<[Point; 16]> {
    let sides = [b[0] - a[0], b[1] - a[1]];
    let mut net = [Point::origin(); 16];
    for corner in 0..4 {
        let end = [corner / 2, corner % 2];
        let exact = [0, 1].map(|d: usize| if end[d] == 0 { a[d] } else { b[d] });
        // Derivatives from within the piece.
        let way = end.map(|end| if end == 0 { 1.0 } else { -1.0 });
        let near = [0, 1].map(|d: usize| exact[d] + way[d] * INSIDE * sides[d]);
        let (at, inside) = (place(surface, distance, exact)?, place(surface, distance, near)?);
        let beside = place(surface, distance, [near[0], near[1] + way[1] * STEP * sides[1]])?;
        let [u, v] = [0, 1].map(|d: usize| inside.along[d] * (way[d] * sides[d] / 3.0));
        let twist = (beside.along[0] - inside.along[0]) / (way[1] * STEP * sides[1]);
        let twist = twist * (way[0] * way[1] * sides[0] * sides[1] / 9.0);
        let index = |i: usize, j: usize| {
            let [i, j] = [(end[0], i), (end[1], j)].map(|(end, k)| if end == 0 { k } else { 3 - k });
            4 * i + j
        };
        net[index(0, 0)] = at.point;
        net[index(1, 0)] = at.point + u;
        net[index(0, 1)] = at.point + v;
        net[index(1, 1)] = at.point + u + v + twist;
    }
    Ok(net)
}

/// How far a piece is from the offset at equal parameters.
fn off(surface: &Surface, distance: f64, (a, b): ([f64; 2], [f64; 2]), piece: &[Point; 16]) -> Result<f64> {
    let bernstein = |t: f64| {
        let s = 1.0 - t;
        [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t]
    };
    let mut worst = 0.0_f64;
    for k in 0..MEASURED * MEASURED {
        let share = [k / MEASURED, k % MEASURED].map(|k| (k as f64 + 0.5) / MEASURED as f64);
        let at = [0, 1].map(|d: usize| a[d] + (b[d] - a[d]) * share[d]);
        let truth = place(surface, distance, at)?;
        if truth.along[0].cross(&truth.along[1]).dot(&truth.normal) <= 0.0 {
            return Err(Error::Invalid(format!(
                "an offset that folds: near u = {}, v = {} its basis bends more sharply than the distance",
                at[0], at[1]
            )));
        }
        let (u, v) = (bernstein(share[0]), bernstein(share[1]));
        let mut on = Vector::zeros();
        for (k, p) in piece.iter().enumerate() {
            on += p.coords * (u[k / 4] * v[k % 4]);
        }
        let away = (on - truth.point.coords).norm();
        worst = if away <= worst { worst } else { away };
    }
    Ok(worst)
}

/// `S + d n` and its derivatives, with `n_u = (N_u - n (n·N_u)) / |N|` of `N = S_u × S_v`.
fn place(surface: &Surface, distance: f64, at: [f64; 2]) -> Result<Place> {
    let mut jet = [Vector::zeros(); 9];
    surface.derivatives_into(at[0], at[1], [2, 2], &mut jet)?;
    let [s, sv, svv, su, suv, _, suu, ..] = jet;
    let cross = su.cross(&sv);
    let length = cross.norm();
    if length.is_nan() || length <= 1e-9 * su.norm() * sv.norm() {
        let [u, v] = at;
        return Err(Error::Invalid(format!("an offset of a surface without a normal at u = {u}, v = {v}")));
    }
    let normal = cross / length;
    let turned = |d: Vector| (d - normal * normal.dot(&d)) / length;
    let (nu, nv) = (turned(suu.cross(&sv) + su.cross(&suv)), turned(suv.cross(&sv) + su.cross(&svv)));
    Ok(Place {
        point: Point::from(s + normal * distance),
        along: [su + nu * distance, sv + nv * distance],
        normal,
    })
}

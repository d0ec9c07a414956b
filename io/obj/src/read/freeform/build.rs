//! Elements that are complete become curves and surfaces.

use loftsman_kernel::Point;
use loftsman_kernel::spline::{Curve, Direction as Along, Space, Surface};

use super::basis::{Direction, Form, Kind, Problem};
use super::{At, Body, Freeform, Mended, Outcome, PlaneCurve, Used, What, at};
use crate::read::raw::Raw;
use crate::read::section::Shape;

/// How many times the control points of the file the B-spline's may be, so that a small file cannot become a large
/// surface by a basis matrix of high degree.
const GROWTH: usize = 32;

/// Ranges are often printed with fewer digits than knots.
const SLACK: f64 = 1e-9;

impl Freeform {
    pub(super) fn finish(&mut self, body: Body, raw: &Raw, used: &mut Used) -> Result<Outcome, At> {
        let what = match &body.what {
            What::Curve { .. } => "the curve",
            What::Curve2 { .. } => "the curve",
            What::Surface { .. } => "the surface",
        };
        let missing = match (self.kind, self.degrees) {
            (None, _) => Some("cstype"),
            (_, None) => Some("deg"),
            _ => None,
        };
        if let Some(missing) = missing {
            self.give_up(&body.what);
            self.given_up = false;
            return Err(at(body.line, format!("{what} has no {missing} before it that is right")));
        }
        match &body.what {
            What::Curve { range, vertices } => {
                used.special_left_out += body.special.len();
                let made = self.curve(&body, *range, vertices, raw);
                outcome(made, |Made { curve, wrapped, mended }| {
                    used.vertices.extend(vertices);
                    Outcome::Shape { shape: Box::new(Shape::Curve(curve)), surface: None, wrapped, mended }
                })
            }
            What::Curve2 { vertices } => {
                used.special_left_out += body.special.len();
                let made = self.plane_curve(&body, vertices, raw);
                let (curve, outcome) = match made {
                    Ok(curve) => (Some(curve), Ok(Outcome::ParameterCurve)),
                    Err(Stop::LeftOut(reason)) => (None, Ok(Outcome::LeftOut(reason))),
                    Err(Stop::At(error)) => (None, Err(error)),
                };
                self.plane_curves.push(PlaneCurve { curve, vertices: vertices.clone(), used: false });
                outcome
            }
            What::Surface { ranges, vertices } => {
                let number = self.surfaces.len();
                let mut mended = Mended::default();
                let made = self.surface(&body, *ranges, vertices, raw, &mut mended).and_then(
                    |(surface, wrapped)| Ok((self.trimmed(surface, &body, raw, used, &mut mended)?, wrapped)),
                );
                self.surfaces.push(made.is_ok());
                outcome(made, |(shape, wrapped)| {
                    used.vertices.extend(vertices);
                    Outcome::Shape { shape: Box::new(shape), surface: Some(number), wrapped, mended }
                })
            }
        }
    }

    /// One direction of an element.
    fn direction<'a>(
        &'a self,
        body: &'a Body,
        side: usize,
        count: Option<usize>,
        range: (f64, f64),
    ) -> Direction<'a> {
        Direction {
            kind: self.kind.map_or(Kind::Bspline, |(_, kind)| kind),
            degree: self.degrees.map_or(1, |degrees| degrees[side]),
            matrix: self.matrices[side].as_deref(),
            step: self.steps[side],
            parameters: body.parameters[side].as_ref().map(|(values, _)| values.as_slice()),
            count,
            range,
        }
    }

    fn rational(&self) -> bool {
        self.kind.is_some_and(|(rational, _)| rational)
    }

    fn curve(&self, body: &Body, range: (f64, f64), vertices: &[u32], raw: &Raw) -> Result<Made, Stop> {
        let stop = |problem: Problem| Stop::new(problem, body, 0);
        let mut mended = Mended::default();
        let mut direction = self.direction(body, 0, Some(vertices.len()), range);
        let needed = vertices.len() + direction.degree + 1;
        if let (Kind::Bspline, Some(knots)) = (direction.kind, direction.parameters)
            && matches!(knots.len().checked_sub(needed), Some(1 | 2))
        {
            direction.parameters = Some(&knots[..needed]);
            mended.dropped = true;
        }
        let form = direction.form().map_err(stop)?;
        let points = vertices.iter().map(|&v| raw.points[v as usize]).collect();
        let weights = self.rational().then(|| vertices.iter().map(|&v| raw.weight(v)).collect());
        let (points, weights) = converted(&form, points, weights).map_err(stop)?;
        let Part { range: (from, to), whole, clipped } =
            part(&form.space, range).map_err(|e| Stop::At(at(body.line, format!("it {e}"))))?;
        mended.clipped = clipped;
        if whole && let Some(space) = around(&form.space) {
            let same =
                |a: usize, b: usize| points[a] == points[b] && weights.as_ref().is_none_or(|w| w[a] == w[b]);
            if let Some(turn) = turn(&space, form.space.unrolled_len(), same) {
                let points = turn.iter().map(|&i| points[i]).collect();
                let weights = weights.map(|w| turn.iter().map(|&i| w[i]).collect());
                let curve = Curve::build(space, points, weights).map_err(|e| Stop::kernel(&e, body))?;
                return Ok(Made { curve, wrapped: true, mended });
            }
        }
        let curve = Curve::build(form.space, points, weights).map_err(|e| Stop::kernel(&e, body))?;
        if whole {
            return Ok(Made { curve, wrapped: false, mended });
        }
        let curve = curve.between(from, to).map_err(|e| Stop::kernel(&e, body))?;
        Ok(Made { curve, wrapped: false, mended })
    }

    fn plane_curve(&self, body: &Body, vertices: &[u32], raw: &Raw) -> Result<Curve, Stop> {
        let stop = |problem: Problem| Stop::new(problem, body, 0);
        let direction = self.direction(body, 0, Some(vertices.len()), (0.0, 1.0));
        let form = direction.form().map_err(stop)?;
        let at = |&v: &u32| raw.parameters[v as usize];
        let points = vertices.iter().map(at).map(|[u, v, _]| Point::new(u, v, 0.0)).collect();
        let weights = self.rational().then(|| vertices.iter().map(at).map(|[_, _, w]| w).collect());
        let (points, weights) = converted(&form, points, weights).map_err(stop)?;
        Curve::build(form.space, points, weights).map_err(|e| Stop::kernel(&e, body))
    }

    fn surface(
        &self,
        body: &Body,
        ranges: [(f64, f64); 2],
        vertices: &[u32],
        raw: &Raw,
        mended: &mut Mended,
    ) -> Result<(Surface, bool), Stop> {
        let stop = |side: usize| move |problem: Problem| Stop::new(problem, body, side);
        let total = vertices.len();
        let [u, v] = [0, 1].map(|side| self.direction(body, side, None, ranges[side]));
        // A single patch needs no parm to be told apart.
        let (wu, wv) = (u.window().map_err(stop(0))?.0, v.window().map_err(stop(1))?.0);
        let single = wu * wv == total;
        let form = |direction: Direction<'_>, window: usize, side: usize| {
            let count = (direction.parameters.is_none() && single).then_some(window);
            Direction { count, ..direction }.form().map_err(stop(side))
        };
        let (u, v) = (form(u, wu, 0)?, form(v, wv, 1)?);
        if u.count.checked_mul(v.count) != Some(total) {
            let problem = format!(
                "the surface has {total} vertices, but its parm and deg make {} × {}",
                u.count, v.count
            );
            return Err(Stop::At(at(body.line, problem)));
        }
        if u.len().saturating_mul(v.len()) > GROWTH * total + 65_536 {
            let reason = "the B-spline form would be more than 32 times as large".to_owned();
            return Err(Stop::LeftOut(reason));
        }
        let mut net = Net {
            columns: v.count,
            points: Vec::with_capacity(total),
            weights: self.rational().then(|| Vec::with_capacity(total)),
        };
        // In the file u runs fastest, here v does.
        for i in 0..u.count {
            for j in 0..v.count {
                let vertex = vertices[j * u.count + i];
                net.points.push(raw.points[vertex as usize]);
                net.weights.iter_mut().for_each(|w| w.push(raw.weight(vertex)));
            }
        }
        let mut net = net.converted(&u, &v).map_err(stop(0))?;
        let mut wrapped = false;
        let mut spaces = [u.space, v.space];
        let mut cuts = [None; 2];
        for side in 0..2 {
            let Part { range, whole, clipped } = part(&spaces[side], ranges[side])
                .map_err(|e| Stop::At(at(body.line, format!("in {} it {e}", ["u", "v"][side]))))?;
            mended.clipped_surface |= clipped;
            cuts[side] = Some(range).filter(|_| !whole);
            if let Some(space) = around(&spaces[side]).filter(|_| whole)
                && let Some(turn) = turn(&space, spaces[side].unrolled_len(), |a, b| net.same(side, a, b))
            {
                net = net.turned(side, &turn);
                spaces[side] = space;
                wrapped = true;
            }
        }
        let [u, v] = spaces;
        let mut surface =
            Surface::build(u, v, net.points, net.weights).map_err(|e| Stop::kernel(&e, body))?;
        for (along, cut) in [Along::U, Along::V].into_iter().zip(cuts) {
            if let Some((from, to)) = cut {
                surface = surface.between(along, from, to).map_err(|e| Stop::kernel(&e, body))?;
            }
        }
        Ok((surface, wrapped))
    }
}

/// A curve, whether it became periodic, and what was mended.
struct Made {
    curve: Curve,
    wrapped: bool,
    mended: Mended,
}

/// An error with its line, or a reason to leave an element out.
#[derive(Debug)]
pub(super) enum Stop {
    At(At),
    LeftOut(String),
}

impl Stop {
    /// A problem of one direction: that of its `parm`, where there is one.
    fn new(problem: Problem, body: &Body, side: usize) -> Self {
        match problem {
            Problem::LeftOut(reason) => Self::LeftOut(reason),
            Problem::Wrong(text) => {
                let line = body.parameters[side].as_ref().map_or(body.line, |(_, line)| *line);
                let side = if matches!(body.what, What::Surface { .. }) { ["u: ", "v: "][side] } else { "" };
                let of = format!("{side}{text} (the element starts in line {})", body.line);
                Self::At(at(line, of))
            }
        }
    }

    pub(super) fn kernel(error: &loftsman_kernel::Error, body: &Body) -> Self {
        Self::At(at(body.line, error.to_string()))
    }
}

fn outcome<T>(made: Result<T, Stop>, kept: impl FnOnce(T) -> Outcome) -> Result<Outcome, At> {
    match made {
        Ok(made) => Ok(kept(made)),
        Err(Stop::LeftOut(reason)) => Ok(Outcome::LeftOut(reason)),
        Err(Stop::At(error)) => Err(error),
    }
}

/// Where an element runs.
struct Part {
    range: (f64, f64),
    /// Whether that is all of what its knots define.
    whole: bool,
    /// Whether the file has it run beyond.
    clipped: bool,
}

/// The part of a range in which an element is defined: some exporters write the range of all the knots of the file, others round it
/// otherwise than the knots, and what overlaps is meant either way. An error where it runs backwards, or does not overlap by more than
/// rounding.
fn part(space: &Space, (from, to): (f64, f64)) -> Result<Part, String> {
    let (a, b) = space.domain();
    let slack = SLACK * (b - a);
    if from > to {
        return Err(format!("runs backwards, from {from} to {to}: the smaller parameter comes first"));
    }
    let range = (from.max(a), to.min(b));
    let clipped = from < a - slack || to > b + slack;
    if from == to || range.1 - range.0 <= if clipped { slack } else { 0.0 } {
        return Err(format!("runs from {from} to {to}, but its knots define it from {a} to {b}"));
    }
    Ok(Part { range, whole: from <= a + slack && to >= b - slack, clipped })
}

type Weighted = (Vec<Point>, Option<Vec<f64>>);

/// The B-spline's control points and weights.
fn converted(form: &Form, points: Vec<Point>, weights: Option<Vec<f64>>) -> Result<Weighted, Problem> {
    if form.is_identity() {
        return Ok((points, weights));
    }
    euclidean(form.apply(&homogeneous(&points, weights.as_deref()), 1)?, weights.is_some())
}

/// Homogeneous coordinates; the last is 0 where there are no weights.
fn homogeneous(points: &[Point], weights: Option<&[f64]>) -> Vec<[f64; 4]> {
    let at = |(i, p): (usize, &Point)| match weights {
        Some(w) => [p.x * w[i], p.y * w[i], p.z * w[i], w[i]],
        None => [p.x, p.y, p.z, 0.0],
    };
    points.iter().enumerate().map(at).collect()
}

fn euclidean(points: Vec<[f64; 4]>, rational: bool) -> Result<Weighted, Problem> {
    if !rational {
        return Ok((points.into_iter().map(|[x, y, z, _]| Point::new(x, y, z)).collect(), None));
    }
    if points.iter().any(|p| p[3].is_nan() || p[3] <= 0.0) {
        let reason = "its weights are not positive in B-spline form".to_owned();
        return Err(Problem::LeftOut(reason));
    }
    let weights = points.iter().map(|p| p[3]).collect();
    Ok((points.into_iter().map(|[x, y, z, w]| Point::new(x, y, z) / w).collect(), Some(weights)))
}

/// A control net, `columns` vertices a row.
struct Net {
    columns: usize,
    points: Vec<Point>,
    weights: Option<Vec<f64>>,
}

impl Net {
    fn converted(self, u: &Form, v: &Form) -> Result<Self, Problem> {
        if u.is_identity() && v.is_identity() {
            return Ok(self);
        }
        let transposed = |points: &[[f64; 4]], columns: usize| -> Vec<[f64; 4]> {
            (0..columns).flat_map(|j| points.iter().skip(j).step_by(columns).copied()).collect()
        };
        let net = homogeneous(&self.points, self.weights.as_deref());
        let along_u = u.apply(&net, self.columns)?;
        let along_v = v.apply(&transposed(&along_u, self.columns), u.len())?;
        let (points, weights) = euclidean(transposed(&along_v, u.len()), self.weights.is_some())?;
        Ok(Self { columns: v.len(), points, weights })
    }

    /// Where entry `k` across is in row (side 0) or column (side 1) `i`.
    fn place(&self, side: usize, i: usize, k: usize) -> usize {
        if side == 0 { i * self.columns + k } else { k * self.columns + i }
    }

    fn across(&self, side: usize) -> usize {
        if side == 0 { self.columns } else { self.points.len() / self.columns }
    }

    fn same(&self, side: usize, a: usize, b: usize) -> bool {
        (0..self.across(side)).all(|k| {
            let (a, b) = (self.place(side, a, k), self.place(side, b, k));
            self.points[a] == self.points[b] && self.weights.as_ref().is_none_or(|w| w[a] == w[b])
        })
    }

    fn turned(&self, side: usize, turn: &[usize]) -> Self {
        let across = self.across(side);
        let (rows, columns) = if side == 0 { (turn.len(), across) } else { (across, turn.len()) };
        let from = |i: usize, j: usize| {
            if side == 0 { self.place(0, turn[i], j) } else { self.place(1, turn[j], i) }
        };
        let order: Vec<usize> =
            (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j))).map(|(i, j)| from(i, j)).collect();
        Self {
            columns,
            points: order.iter().map(|&k| self.points[k]).collect(),
            weights: self.weights.as_ref().map(|w| order.iter().map(|&k| w[k]).collect()),
        }
    }
}

/// How far knots of few digits may be from one another after a period, by the range of all of them: twice what four knots are off that are
/// rounded to six digits, as Blender prints them.
const FEW_DIGITS: f64 = 4e-6;

/// By how much knots may have been rounded where they were printed: half a unit of the last decimal that any of them has. None have
/// more than twelve: others count as exact.
fn printed(knots: &[f64]) -> f64 {
    let is_whole = |scale: f64| {
        knots.iter().map(|t| t * scale).all(|x| (x - x.round()).abs() <= 4.0 * f64::EPSILON * x.abs())
    };
    let decimals = (0..=12).map(|k| 10_f64.powi(k)).find(|&scale| is_whole(scale));
    decimals.map_or(0.0, |scale| 0.5 / scale)
}

/// The periodic space whose unrolled form this is: where the knots repeat after one period, to rounding and as far as the digits tell that
/// the file has.
fn around(space: &Space) -> Option<Space> {
    let (p, n, t) = (space.degree(), space.unrolled_len(), space.flat());
    let distinct = n.checked_sub(p).filter(|&d| d >= 2)?;
    let period = t[n] - t[p];
    let rounding = 64.0 * f64::EPSILON * t[0].abs().max(t[n + p].abs());
    // Each of the four knots that are compared may be off by that.
    let slack = rounding + (4.0 * printed(t)).min(FEW_DIGITS * (t[n + p] - t[0]));
    if (0..=2 * p).any(|i| (t[i + distinct] - t[i] - period).abs() > slack) {
        return None;
    }
    Space::periodic(p, t[p..=n].to_vec()).ok()
}

/// Which of `n` control points each vertex of a periodic space is, where the last `p` are the first `p`. Vertex `i`
/// of a periodic space belongs to the B-spline whose support starts at knot `i`: entry `i + p` here.
fn turn(space: &Space, n: usize, same: impl Fn(usize, usize) -> bool) -> Option<Vec<usize>> {
    let (p, distinct) = (space.degree(), space.len());
    if distinct + p != n || !(0..p).all(|i| same(i, i + distinct)) {
        return None;
    }
    Some((0..distinct).map(|i| (i + p) % distinct).collect())
}

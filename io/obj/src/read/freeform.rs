//! Free-form curves: the state of `cstype` and `deg`, and the element between `curv` and `end`.

use loftsman_kernel::Point;
use loftsman_kernel::error::MAX_DEGREE;
use loftsman_kernel::spline::{Curve, Space};

use super::raw::Raw;
use crate::text::{number, show, words};

/// What the control vertices of an element mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Bspline,
    Bezier,
    /// Not read yet.
    Other(&'static str),
}

/// An element that has started.
#[derive(Debug)]
pub(crate) enum Element {
    Curve { range: (f64, f64), vertices: Vec<u32> },
    Other { what: String },
}

/// What an element became.
#[derive(Debug)]
pub(crate) enum Outcome {
    Curve { curve: Curve, vertices: Vec<u32>, wrapped: bool },
    LeftOut(String),
}

/// The state between statements.
#[derive(Debug, Default)]
pub(crate) struct Freeform {
    kind: Option<(bool, Kind)>,
    degree: Option<usize>,
    element: Option<(Element, usize)>,
    /// `parm u` of the element, and its line.
    parameters: Option<(Vec<f64>, usize)>,
}

impl Freeform {
    /// `cstype [rat] type`.
    pub(crate) fn cstype(&mut self, rest: &[u8]) -> Result<(), String> {
        let mut parts = words(rest).peekable();
        let rational = parts.next_if_eq(&b"rat".as_slice()).is_some();
        let kind = match parts.next() {
            Some(b"bspline") => Kind::Bspline,
            Some(b"bezier") => Kind::Bezier,
            Some(b"bmatrix") => Kind::Other("bmatrix"),
            Some(b"cardinal") => Kind::Other("cardinal"),
            Some(b"taylor") => Kind::Other("taylor"),
            other => {
                let found = show(other.unwrap_or_default());
                let known = "bspline, bezier, bmatrix, cardinal and taylor";
                return Err(format!("unknown type of curve \"{found}\": {known} are known"));
            }
        };
        self.kind = Some((rational, kind));
        Ok(())
    }

    /// `deg degu [degv]`.
    pub(crate) fn deg(&mut self, rest: &[u8]) -> Result<(), String> {
        let mut degrees = words(rest).map(|word| {
            let text = std::str::from_utf8(word).unwrap_or_default();
            match text.parse::<usize>() {
                Ok(degree) if (1..=MAX_DEGREE).contains(&degree) => Ok(degree),
                _ => Err(format!("a degree of \"{}\" is not supported: 1 to {MAX_DEGREE} are", show(word))),
            }
        });
        let first = degrees.next().unwrap_or_else(|| Err("deg needs a degree".to_owned()))?;
        degrees.try_for_each(|degree| degree.map(drop))?;
        self.degree = Some(first);
        Ok(())
    }

    /// `parm u|v p …`.
    pub(crate) fn parm(&mut self, rest: &[u8], line: usize) -> Result<(), String> {
        if self.element.is_none() {
            return Err("parm without a curv, curv2 or surf before it".to_owned());
        }
        let mut parts = words(rest);
        match parts.next() {
            Some(b"u") => self.parameters = Some((parts.map(number).collect::<Result<_, _>>()?, line)),
            Some(b"v") => parts.map(number).try_for_each(|n| n.map(drop))?,
            other => {
                let found = show(other.unwrap_or_default());
                return Err(format!("parm \"{found}\": only u and v are parameters"));
            }
        }
        Ok(())
    }

    pub(crate) fn start(&mut self, element: Element, line: usize) -> Result<(), String> {
        self.unfinished()?;
        (self.element, self.parameters) = (Some((element, line)), None);
        Ok(())
    }

    /// An error where an element has started and not ended.
    pub(crate) fn unfinished(&self) -> Result<(), String> {
        match &self.element {
            Some((_, line)) => Err(format!("the curve or surface of line {line} has no end statement")),
            None => Ok(()),
        }
    }

    /// `end`: the element is complete.
    pub(crate) fn finish(&mut self, raw: &Raw, _line: usize) -> Result<Outcome, String> {
        let Some((element, line)) = self.element.take() else {
            return Err("end without a curv, curv2 or surf before it".to_owned());
        };
        let parameters = self.parameters.take();
        let (range, vertices) = match element {
            Element::Curve { range, vertices } => (range, vertices),
            Element::Other { what } => {
                return Ok(Outcome::LeftOut(format!("the free-form statement {what} is not read yet")));
            }
        };
        let Some((rational, kind)) = self.kind else {
            return Err(format!("the curve of line {line} has no cstype before it"));
        };
        if let Kind::Other(name) = kind {
            return Ok(Outcome::LeftOut(format!("curves of type {name} are not read yet")));
        }
        let Some(degree) = self.degree else {
            return Err(format!("the curve of line {line} has no deg before it"));
        };
        let points: Vec<Point> = vertices.iter().map(|&v| raw.points[v as usize]).collect();
        let weights = rational.then(|| vertices.iter().map(|&v| raw.weight(v)).collect::<Vec<_>>());
        let knots = match kind {
            Kind::Bspline => bspline_knots(parameters, points.len(), degree, line)?,
            _ => bezier_knots(parameters, points.len(), degree, range, line)?,
        };
        let said = |e: loftsman_kernel::Error| format!("the curve of line {line}: {e}");
        let space = Space::open(degree, knots).map_err(said)?;
        let (a, b) = space.domain();
        // Ranges are often printed with fewer digits than knots.
        let slack = 1e-9 * (b - a);
        let (from, to) = range;
        if !(from < to && from >= a - slack && to <= b + slack) {
            return Err(format!(
                "the curve of line {line} runs from {from} to {to}, but its knots define it from {a} to {b}"
            ));
        }
        let whole = from <= a + slack && to >= b - slack;
        if whole && let Some(curve) = wrapped(&space, &points, weights.as_deref()) {
            return Ok(Outcome::Curve { curve, vertices, wrapped: true });
        }
        let curve = Curve::build(space, points, weights).map_err(said)?;
        let curve = if whole { curve } else { part(&curve, from.max(a), to.min(b)).map_err(said)? };
        Ok(Outcome::Curve { curve, vertices, wrapped: false })
    }
}

fn bspline_knots(
    parameters: Option<(Vec<f64>, usize)>,
    vertices: usize,
    degree: usize,
    line: usize,
) -> Result<Vec<f64>, String> {
    let needed = vertices + degree + 1;
    match parameters {
        Some((knots, _)) if knots.len() == needed => Ok(knots),
        Some((knots, at)) => Err(format!(
            "parm u in line {at} has {} values: a B-spline curve of {vertices} vertices and degree {degree} needs {needed}",
            knots.len()
        )),
        None => Err(format!("the curve of line {line} has no parm u: it needs {needed} values")),
    }
}

/// `parm u` of a Bézier curve holds the parameters where its pieces meet; each inner one becomes a knot of
/// multiplicity `degree`. Without `parm` the pieces divide the range evenly.
fn bezier_knots(
    parameters: Option<(Vec<f64>, usize)>,
    vertices: usize,
    degree: usize,
    range: (f64, f64),
    line: usize,
) -> Result<Vec<f64>, String> {
    let pieces = vertices.saturating_sub(1) / degree;
    if pieces == 0 || pieces * degree + 1 != vertices {
        return Err(format!(
            "the curve of line {line} has {vertices} vertices: Bézier pieces of degree {degree} need {degree} times their number and one more"
        ));
    }
    let ends = match parameters {
        Some((ends, _)) if ends.len() == pieces + 1 => ends,
        Some((ends, at)) => {
            return Err(format!(
                "parm u in line {at} has {} values: {pieces} Bézier piece(s) need {}",
                ends.len(),
                pieces + 1
            ));
        }
        None => {
            let (a, b) = range;
            (0..=pieces)
                .map(|k| if k == pieces { b } else { a + (b - a) * (k as f64 / pieces as f64) })
                .collect()
        }
    };
    if let Some(k) = ends.windows(2).position(|pair| pair[0] >= pair[1]) {
        return Err(format!(
            "parm u of the curve of line {line}: {} is followed by {}, but Bézier parameters must increase",
            ends[k],
            ends[k + 1]
        ));
    }
    let mut knots = Vec::with_capacity(vertices + degree + 1);
    knots.extend(ends.first());
    knots.extend(ends.iter().flat_map(|&t| std::iter::repeat_n(t, degree)));
    knots.extend(ends.last());
    Ok(knots)
}

/// The periodic curve, where control vertices, weights and knots wrap around: the last `p` vertices are the first
/// `p`, and the knots repeat after one period to rounding.
fn wrapped(space: &Space, points: &[Point], weights: Option<&[f64]>) -> Option<Curve> {
    let (p, n, t) = (space.degree(), points.len(), space.flat());
    let distinct = n.checked_sub(p).filter(|&d| d >= 2)?;
    let same = |a: usize, b: usize| points[a] == points[b] && weights.is_none_or(|w| w[a] == w[b]);
    if !(0..p).all(|i| same(i, i + distinct)) {
        return None;
    }
    let period = t[n] - t[p];
    let rounding = 64.0 * f64::EPSILON * t[0].abs().max(t[n + p].abs());
    if (0..=2 * p).any(|i| (t[i + distinct] - t[i] - period).abs() > rounding) {
        return None;
    }
    let around = Space::periodic(p, t[p..=n].to_vec()).ok()?;
    // Vertex i of a periodic curve belongs to the B-spline whose support starts at knot i: entry i + p here.
    let turn = |i: usize| (i + p) % distinct;
    let vertices = (0..distinct).map(|i| points[turn(i)]).collect();
    let weights = weights.map(|w| (0..distinct).map(|i| w[turn(i)]).collect());
    Curve::build(around, vertices, weights).ok()
}

/// The part of a curve between two parameters: knots are inserted there up to multiplicity `p`, and what is
/// between them is the part.
fn part(curve: &Curve, from: f64, to: f64) -> loftsman_kernel::Result<Curve> {
    let p = curve.degree();
    let mut inserted = Vec::new();
    for u in [from, to] {
        let present = curve.space().knots().iter().filter(|&&k| k == u).count();
        inserted.extend(std::iter::repeat_n(u, p.saturating_sub(present)));
    }
    let fine = curve.insert_knots(&inserted)?;
    let t = fine.space().knots();
    // The vertex before the last p knots at `from` is the start, the one before the first p at `to` the end.
    let start = t.partition_point(|&k| k <= from) - p;
    let end = t.partition_point(|&k| k < to);
    let mut knots = vec![from];
    knots.extend_from_slice(&t[start..end + p]);
    knots.push(to);
    let weights = fine.weights().map(|w| w[start - 1..end].to_vec());
    Curve::build(Space::open(p, knots)?, fine.points()[start - 1..end].to_vec(), weights)
}

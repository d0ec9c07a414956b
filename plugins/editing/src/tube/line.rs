//! The middle line of a tube in each of its states: its points, and the directions in which it arrives at them and leaves.

use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::plugin::{Chord, CustomShape, Drawn, Fineness, Splines, Tessellator};
use loftsman_kernel::scene::{Geometry, Object};
use loftsman_kernel::shape::{Derivative, Shape, Side};
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Vector, direction};

/// A part of a line in one state.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct State {
    pub(super) points: Vec<Point>,
    /// Directions of length 1.
    pub(super) arrive: Vec<Vector>,
    pub(super) leave: Vec<Vector>,
    /// The way along the chords to each point, and to the end: of a closed line, to the first again.
    pub(super) lengths: Vec<f64>,
}

impl State {
    pub(super) fn new(points: Vec<Point>, arrive: Vec<Vector>, leave: Vec<Vector>, closed: bool) -> Self {
        let mut lengths = vec![0.0];
        let mut way = 0.0;
        let chord = |a: &Point, b: &Point| (b - a).norm();
        for pair in points.windows(2) {
            way += chord(&pair[0], &pair[1]);
            lengths.push(way);
        }
        if let (true, Some(first), Some(last)) = (closed, points.first(), points.last()) {
            way += chord(last, first);
        }
        lengths.push(way);
        Self { points, arrive, leave, lengths }
    }

    /// The cosine of the angle by which the line turns at a point.
    pub(super) fn turn(&self, i: usize) -> f64 {
        self.arrive[i].dot(&self.leave[i]).clamp(-1.0, 1.0)
    }
}

/// A part of a line, from end to end or closed, in all states: the object as it is first, then the frames of its animation.
#[derive(Debug, Clone)]
pub(super) struct Part {
    pub(super) states: Vec<State>,
    pub(super) closed: bool,
}

/// Where a line bends most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bend {
    /// The least radius of curvature; of a corner, the way along its shorter side over the tangent of half its angle, half.
    pub(super) radius: f64,
    /// The state where that is.
    pub(super) state: usize,
    /// The parameter there, of a curve.
    pub(super) at: Option<f64>,
}

/// A line, its states cut alike.
#[derive(Debug, Clone)]
pub(super) struct Line {
    pub(super) parts: Vec<Part>,
    /// The chord that it was cut by, as a length.
    pub(super) tolerance: f64,
    pub(super) bend: Option<Bend>,
}

impl Line {
    /// The line of a curve, a polyline or a plug-in's curve-like shape, with the frames of its animation.
    pub(super) fn of(
        object: &Object,
        tessellator: Option<&dyn Tessellator>,
        fineness: &Fineness,
    ) -> Result<Self> {
        let frames: &[Vec<Point>] = object.animation.as_ref().map_or(&[], |animation| &animation.frames);
        let all = || std::iter::once(object.geometry().points().to_vec()).chain(frames.iter().cloned());
        match object.geometry() {
            Geometry::Curve(curve) => Self::of_curve(curve, all(), tessellator, fineness),
            Geometry::Polyline(line) => Self::of_points(&all().collect::<Vec<_>>(), line.closed, fineness),
            Geometry::Custom(custom) => Self::of_shape(custom, all().collect(), tessellator, fineness),
            other => Err(Error::Invalid(format!(
                "a tube is swept round a curve or a polyline, and \"{}\" is {}",
                object.name(),
                loftsman_kernel::text::a(&other.noun())
            ))),
        }
    }

    fn of_curve(
        curve: &Curve,
        states: impl Iterator<Item = Vec<Point>>,
        tessellator: Option<&dyn Tessellator>,
        fineness: &Fineness,
    ) -> Result<Self> {
        let missing = || Error::Invalid("no tessellator is registered".into());
        let weights = || curve.weights().map(<[f64]>::to_vec);
        let states: Vec<Curve> = states
            .map(|points| Curve::build(curve.space().clone(), points, weights()))
            .collect::<Result<_>>()?;
        let line = tessellator.ok_or_else(missing)?.moving_curve(&states, fineness)?;
        let count = line.parameters.len();
        if line.states.len() != states.len() || line.states.iter().any(|points| points.len() != count) {
            return Err(Error::Invalid(
                "the tessellator does not say where its points are on the curve".into(),
            ));
        }
        let (_, end) = curve.domain();
        let mut parts = Vec::with_capacity(line.starts.len());
        for (k, &start) in line.starts.iter().enumerate() {
            let stop = line.starts.get(k + 1).copied().unwrap_or(count);
            let parameters = &line.parameters[start..stop];
            let mut part = Vec::with_capacity(states.len());
            for (curve, points) in states.iter().zip(&line.states) {
                let along = |i: usize, side: Side| {
                    // A closed line arrives at its start from the end of the domain.
                    let at = if i == 0 && side == Side::Left && line.closed { end } else { parameters[i] };
                    let stencil = curve.stencil_on(at.into(), Derivative::from(1), side.into()).ok()?;
                    Some(stencil.apply(curve.points()))
                };
                part.push(Directions::of(&points[start..stop], line.closed).refined(along));
            }
            parts.push((part, &line.states, start..stop));
        }
        let parts = parts.into_iter().map(|(directions, states, range)| {
            let points = states.iter().map(|points| points[range.clone()].to_vec()).collect();
            Part::new(points, directions, line.closed)
        });
        let parts = parts.collect::<Result<Vec<_>>>()?;
        let bend = least(bend_of_curves(&states, &line.parameters).into_iter().chain(corners(&parts)));
        Ok(Self { parts, tolerance: line.tolerance, bend })
    }

    /// The line through points; those that coincide with the one before in all states are one.
    fn of_points(states: &[Vec<Point>], closed: bool, fineness: &Fineness) -> Result<Self> {
        let count = states.first().map_or(0, Vec::len);
        let mut kept: Vec<usize> = (0..count)
            .filter(|&i| i == 0 || states.iter().any(|points| points[i] != points[i - 1]))
            .collect();
        if closed && states.iter().all(|points| kept.last().is_some_and(|&last| points[last] == points[0])) {
            kept.pop();
        }
        let closed = closed && kept.len() > 2;
        if kept.len() < 2 {
            return Err(Error::NoExtent("all of its points coincide: a tube needs a way to go".into()));
        }
        let points: Vec<Vec<Point>> =
            states.iter().map(|points| kept.iter().map(|&i| points[i]).collect()).collect();
        let directions = points.iter().map(|points| Directions::of(points, closed)).collect();
        let tolerance = match fineness.chord {
            Chord::Absolute(length) => length,
            Chord::Relative(share) => {
                share * points.iter().map(|points| diagonal(points)).fold(0.0, f64::max)
            }
        };
        let parts = vec![Part::new(points, directions, closed)?];
        let bend = least(corners(&parts));
        Ok(Self { parts, tolerance, bend })
    }

    fn of_shape(
        custom: &CustomShape,
        states: Vec<Vec<Point>>,
        tessellator: Option<&dyn Tessellator>,
        fineness: &Fineness,
    ) -> Result<Self> {
        let curve = |points: &Vec<Point>| match custom.with_points(points).ok()?.splines()? {
            Splines::Curves(mut curves) if curves.len() == 1 => curves.pop(),
            _ => None,
        };
        let curves: Option<Vec<Curve>> = states.iter().map(curve).collect();
        if let Some(curves) = curves
            && let Some(first) = curves.first()
            && curves.iter().all(|c| c.space() == first.space() && c.weights() == first.weights())
        {
            let points = curves.iter().map(|curve| curve.points().to_vec()).collect::<Vec<_>>();
            return Self::of_curve(first, points.into_iter(), tessellator, fineness);
        }
        let found = custom.tessellate_frames(&states, fineness)?;
        match found.drawn {
            Drawn::Line(line) => Self::of_points(&found.states, line.closed, fineness),
            Drawn::Mesh(_) => Err(Error::Invalid(format!(
                "a tube is swept round a curve or a polyline, and {} is a surface",
                loftsman_kernel::text::a(custom.kind())
            ))),
        }
    }
}

/// The directions of a line at its points, by its chords; `None` where all of it is one point.
struct Directions(Option<[Vec<Vector>; 2]>);

impl Directions {
    /// A chord without length has the direction of the one before, or of the first that has one.
    fn of(points: &[Point], closed: bool) -> Self {
        let count = points.len();
        let chords = if closed { count } else { count.saturating_sub(1) };
        let mut ways: Vec<Option<Vector>> =
            (0..chords).map(|i| direction(&(points[(i + 1) % count] - points[i]))).collect();
        let Some(first) = ways.iter().flatten().next().copied() else { return Self(None) };
        let last = ways.iter().flatten().next_back().copied().unwrap_or(first);
        let mut along = if closed { last } else { first };
        for way in &mut ways {
            along = way.unwrap_or(along);
            *way = Some(along);
        }
        let way = |i: usize| ways[i].unwrap_or(first);
        let leave = (0..count).map(|i| way(i.min(chords - 1))).collect();
        let arrive = (0..count)
            .map(|i| match i {
                0 if closed => way(chords - 1),
                0 => way(0),
                _ => way(i - 1),
            })
            .collect();
        Self(Some([arrive, leave]))
    }

    /// With the directions of a curve where it has them: where its derivative does not vanish, and is no mere rounding beside
    /// that of its largest.
    fn refined(mut self, along: impl Fn(usize, Side) -> Option<Vector>) -> Self {
        let Some(sides) = &mut self.0 else { return self };
        let count = sides[0].len();
        let exact: Vec<[Option<Vector>; 2]> =
            (0..count).map(|i| [Side::Left, Side::Right].map(|side| along(i, side))).collect();
        let largest = exact.iter().flatten().flatten().map(|d| d.amax()).fold(0.0, f64::max);
        for (i, exact) in exact.iter().enumerate() {
            for (side, exact) in sides.iter_mut().zip(exact) {
                let is_there = |d: &&Vector| d.amax() > 1e-9 * largest;
                if let Some(direction) = exact.as_ref().filter(is_there).and_then(direction) {
                    side[i] = direction;
                }
            }
        }
        self
    }
}

impl Part {
    /// A state that is one point has the directions of the state before, or of the first that has any.
    fn new(points: Vec<Vec<Point>>, directions: Vec<Directions>, closed: bool) -> Result<Self> {
        let first = directions.iter().find_map(|d| d.0.clone());
        let Some(mut last) = first else {
            return Err(Error::NoExtent(
                "all of it is one point in every state: a tube needs a way to go".into(),
            ));
        };
        let states = points.into_iter().zip(directions).map(|(points, directions)| {
            if let Some(found) = directions.0 {
                last = found;
            }
            let [arrive, leave] = last.clone();
            State::new(points, arrive, leave, closed)
        });
        let mut part = Self { states: states.collect(), closed };
        if !closed {
            for state in &mut part.states {
                let end = state.points.len() - 1;
                state.arrive[0] = state.leave[0];
                state.leave[end] = state.arrive[end];
            }
        }
        Ok(part)
    }
}

pub(super) fn diagonal(points: &[Point]) -> f64 {
    let Some(first) = points.first() else { return 0.0 };
    let (low, high) = points.iter().fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
    (high - low).norm()
}

/// The least radius of curvature `|C'|³ / |C' × C''|` at the points and half way between them.
fn bend_of_curves(states: &[Curve], parameters: &[f64]) -> Option<Bend> {
    let between = parameters.windows(2).map(|pair| pair[0] + (pair[1] - pair[0]) / 2.0);
    let places: Vec<f64> = parameters.iter().copied().chain(between).collect();
    let mut found: Option<Bend> = None;
    for (state, curve) in states.iter().enumerate() {
        let jets: Vec<[Vector; 2]> = places
            .iter()
            .map(|&u| {
                let mut jet = [Vector::zeros(); 3];
                let known = curve.derivatives_into(u, &mut jet).is_ok();
                if known { [jet[1], jet[2]] } else { [Vector::zeros(); 2] }
            })
            .collect();
        let largest = jets.iter().map(|[first, _]| first.amax()).fold(0.0, f64::max);
        for (&u, [first, second]) in places.iter().zip(&jets) {
            let speed = first.norm();
            // Where the curve stands still it may have a corner, which is looked at apart.
            if speed <= 1e-6 * largest {
                continue;
            }
            let along = first / speed;
            let bend = along.cross(&(second / speed)).norm();
            let radius = speed / bend;
            if radius.is_finite() && found.is_none_or(|least| radius < least.radius) {
                found = Some(Bend { radius, state, at: Some(u) });
            }
        }
    }
    found
}

/// Corners of polylines and curves: how wide a tube may be before the ends of its straight parts overlap.
fn corners(parts: &[Part]) -> impl Iterator<Item = Bend> + '_ {
    parts.iter().flat_map(|part| {
        part.states.iter().enumerate().filter_map(|(k, state)| {
            let count = state.points.len();
            let inner = if part.closed { 0..count } else { 1..count.saturating_sub(1) };
            let radius = |i: usize| {
                let before = if i == 0 {
                    state.lengths[count] - state.lengths[count - 1]
                } else {
                    state.lengths[i] - state.lengths[i - 1]
                };
                let after = state.lengths[i + 1] - state.lengths[i];
                let cosine = state.turn(i);
                // tan²(α/2) = (1 - cos α) / (1 + cos α)
                let half = ((1.0 - cosine) / (1.0 + cosine)).sqrt();
                let turns = cosine < 1.0 - 1e-9 && before > 0.0 && after > 0.0;
                turns.then(|| 0.5 * before.min(after) / half)
            };
            let least = inner.filter_map(radius).fold(f64::INFINITY, f64::min);
            least.is_finite().then_some(Bend { radius: least, state: k, at: None })
        })
    })
}

fn least(bends: impl IntoIterator<Item = Bend>) -> Option<Bend> {
    bends.into_iter().min_by(|a, b| a.radius.total_cmp(&b.radius))
}

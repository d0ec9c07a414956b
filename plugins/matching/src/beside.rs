//! A curve that runs beside an edge: which way, from where, and in which space the edge can lie on it.

use std::any::Any;

use loftsman_kernel::Point;
use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::functional::{Edge, On, Shapes};
use loftsman_kernel::shape::{Derivative, Location, Shape, Stencil};
use loftsman_kernel::spline::{Conversion, Curve, Space};
use loftsman_kernel::topology::{EdgeCurve, TOGETHER};

/// Places at which edge and curve are compared to find the way round.
const COMPARED: usize = 17;
/// The most places of a closed curve that are tried as its start.
const STARTS: usize = 64;
/// Where edge and curve are not to be equal, so many times as many places show how far they are apart.
const FINER: usize = 16;
/// So near to a knot, as a part of the domain, a place is that shows what is on one side of it.
const WITHIN: f64 = 1e-9;

/// An edge of a surface of the problem, and the curve that runs beside it, both over the edge's parameters.
#[derive(Debug)]
pub(crate) struct Beside {
    /// The edge.
    pub(crate) edge: EdgeCurve,
    /// The curve, reversed and begun elsewhere where the edge is, over the edge's domain.
    pub(crate) curve: Curve,
    /// Its own parameters, where the edge's run from `a` to `b`.
    track: Track,
}

/// How a curve's own parameters go along with the edge's.
#[derive(Debug, Clone, Copy)]
struct Track {
    edge: (f64, f64),
    curve: (f64, f64),
    /// Where the curve starts.
    start: f64,
    reversed: bool,
}

impl Track {
    fn there(&self, t: f64) -> f64 {
        let ((a, b), (c, d)) = (self.edge, self.curve);
        let by = (t - a) / (b - a) * (d - c);
        let u = if self.reversed { self.start - by } else { self.start + by };
        let whole = self.start == if self.reversed { d } else { c };
        let wrapped = match u {
            _ if whole => u,
            u if u > d => u - (d - c),
            u if u < c => u + (d - c),
            u => u,
        };
        wrapped.clamp(c, d)
    }

    /// Whether the breakpoints of edge and curve lie beside one another.
    fn agrees(&self, edge: &Space, curve: &Space) -> bool {
        let breaks = curve.breakpoints();
        let near = TOGETHER * curve.length();
        let known = |u: f64| {
            let at = breaks.partition_point(|&k| k < u - near);
            breaks.get(at).is_some_and(|&k| k <= u + near)
        };
        edge.spans().count() == curve.spans().count()
            && edge.breakpoints().iter().all(|&t| known(self.there(t)))
    }
}

impl Beside {
    /// How a curve lies beside an edge now: it is run through the way, and where both are closed from the place (a breakpoint, or
    /// the one nearest to the edge's start), that brings the two nearest to one another.
    ///
    /// # Errors
    /// When the edge is a point, or numbers overflow.
    pub(crate) fn new(edge: EdgeCurve, curve: &Curve) -> Result<Self> {
        let spread = edge.spread();
        if spread == 0.0 {
            let name = edge.edge.called();
            return Err(Error::Invalid(format!(
                "{name} is a point (a pole), which runs along nothing: name another edge"
            )));
        }
        let domains = (edge.curve.domain(), curve.domain());
        let track = |start, reversed| Track { edge: domains.0, curve: domains.1, start, reversed };
        let (c, d) = domains.1;
        let mut tracks = vec![track(c, false), track(d, true)];
        if closed(&edge.curve)? && closed(curve)? {
            let breaks = curve.space().breakpoints();
            let inner = breaks.iter().copied().filter(|&k| k > c && k < d).take(STARTS);
            for start in inner {
                tracks.extend([track(start, false), track(start, true)]);
            }
            // Where the breakpoints of both agree, they are to: the edge may then be the curve exactly.
            let alike = |track: &Track| track.agrees(edge.curve.space(), curve.space());
            if tracks.iter().any(alike) {
                tracks.retain(alike);
            } else {
                let nearest = curve.closest(edge.curve.point(domains.0.0)?)?.at;
                tracks.extend([track(nearest, false), track(nearest, true)]);
            }
        }
        let (a, b) = domains.0;
        let places: Vec<(f64, Point)> = (0..COMPARED)
            .map(|i| a + (b - a) * i as f64 / (COMPARED - 1) as f64)
            .map(|t| Ok((t, edge.curve.point(t.min(b))?)))
            .collect::<Result<_>>()?;
        let mut best: Option<(f64, Track)> = None;
        for track in tracks {
            let mut far = 0.0;
            for (t, point) in &places {
                far += (curve.point(track.there(*t))? - point).norm();
            }
            // Where two ways are as near, the first: straight on, from the start.
            if best.is_none_or(|(least, _)| far < least * (1.0 - TOGETHER)) {
                best = Some((far, track));
            }
        }
        let track = best.map_or(track(c, false), |(_, track)| track);
        let mut turned = curve.clone();
        let mut start = track.start;
        if track.reversed {
            turned = turned.reverse()?;
            start = c + (d - start);
        }
        let turned = if start > c && start < d { turned.started_at(start)? } else { turned };
        Ok(Self { edge, curve: turned.reparametrise(a, b)?, track })
    }

    /// The curve's own parameter beside the edge's `t`.
    pub(crate) fn there(&self, t: f64) -> f64 {
        self.track.there(t)
    }

    /// The equations under which the edge is the curve, everywhere, to rounding: coefficients of both in one space. None where the
    /// edge's space, with its weights, does not hold the curve; then why.
    ///
    /// # Errors
    /// When numbers overflow.
    pub(crate) fn exactly(&self) -> Result<std::result::Result<Vec<(Stencil, Point)>, String>> {
        let own = self.edge.curve.space();
        let same = own == self.curve.space();
        let (mut edge, mut curve) = (self.edge.clone(), self.curve.clone());
        if !same {
            let Ok(common) = own.common(curve.space()) else {
                return Ok(Err("the knots of edge and curve cannot be told apart".into()));
            };
            let to = |steps: &[Conversion], space: &Space| steps.last().map_or(space.len(), |s| s.to().len());
            if to(&common.first, own) > own.len() {
                return Ok(Err(self.unlike()));
            }
            for step in &common.first {
                edge = edge.convert(step)?;
            }
            for step in &common.second {
                curve = curve.convert(step)?;
            }
        }
        let weight = |curve: &Curve, i: usize| curve.weights().map_or(1.0, |w| w[i]);
        let factor = weight(&edge.curve, 0) / weight(&curve, 0);
        let count = curve.points().len();
        let proportional = (0..count).all(|i| {
            let (x, y) = (weight(&edge.curve, i), factor * weight(&curve, i));
            (x - y).abs() <= 1e-12 * x
        });
        if !proportional {
            return Ok(Err("the weights along the edge are not those of the curve".into()));
        }
        Ok(Ok(edge.stencils.into_iter().zip(curve.points().iter().copied()).collect()))
    }

    /// Why the edge's space does not hold the curve.
    fn unlike(&self) -> String {
        let (p, q) = (self.edge.curve.degree(), self.curve.degree());
        if q > p {
            format!("the edge is of degree {p}, the curve of degree {q}")
        } else {
            "the curve has knots that the edge has not".into()
        }
    }

    /// As many equations as the edge has coefficients: it meets the curve at its Greville abscissae.
    ///
    /// # Errors
    /// As for [`Shape::stencil`].
    pub(crate) fn at_places(&self, shape: &dyn Shape) -> Result<Vec<(Stencil, Point)>> {
        let each = self.greville().into_iter().map(|t| {
            let stencil = shape.stencil(self.edge.edge.at(t), Derivative::POSITION)?;
            Ok((stencil, self.curve.point(t)?))
        });
        each.collect()
    }

    /// The Greville abscissae of the edge: one for each of its coefficients, inside its domain.
    pub(crate) fn greville(&self) -> Vec<f64> {
        let space = self.edge.curve.space();
        let (a, b) = space.domain();
        let inside = |t: f64| match t {
            t if space.is_periodic() && t >= b => t - (b - a),
            t if space.is_periodic() && t < a => t + (b - a),
            t => t.clamp(a, b),
        };
        (0..space.len()).map(|i| inside(space.greville(i))).collect()
    }

    /// Places all along the edge between those where anything is imposed: as many of each piece as determine a polynomial of both
    /// degrees, and where the two are not to be equal as many more as show how far they are apart, and both ends, where that may be most.
    pub(crate) fn between(&self, exact: bool) -> Vec<f64> {
        let mut breaks = self.edge.curve.space().breakpoints();
        breaks.extend(self.curve.space().breakpoints());
        breaks.sort_by(f64::total_cmp);
        let (a, b) = self.edge.curve.domain();
        breaks.dedup_by(|x, y| *x - *y <= TOGETHER * (b - a));
        let degrees = self.edge.curve.degree() + self.curve.degree();
        let each = if exact { degrees + 1 } else { FINER * degrees };
        let nodes = |piece: &[f64]| {
            let (middle, half) = (0.5 * piece[0] + 0.5 * piece[1], 0.5 * (piece[1] - piece[0]));
            let angle = move |i: usize| std::f64::consts::PI * (i as f64 + 0.5) / each as f64;
            (0..each).map(move |i| middle - half * angle(i).cos()).collect::<Vec<f64>>()
        };
        let inner = breaks.windows(2).flat_map(nodes).map(|t| t.clamp(a, b));
        let ends = [a, b].map(|end| (!exact).then_some(end));
        ends[0].into_iter().chain(inner).chain(ends[1]).collect()
    }

    /// Places at which it is told how the two surfaces meet: many of each piece, its ends from within (where tangent planes may differ from those of the
    /// next), and the ends of all.
    pub(crate) fn told(&self) -> Vec<f64> {
        let mut all = self.between(false);
        let (a, b) = self.edge.curve.domain();
        let mut breaks = self.edge.curve.space().breakpoints();
        breaks.extend(self.curve.space().breakpoints());
        let inside = |at: f64| [at - WITHIN * (b - a), at + WITHIN * (b - a)];
        all.extend(breaks.into_iter().flat_map(inside).filter(|t| *t > a && *t < b));
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    }

    /// The place of the edge at `t`.
    pub(crate) fn at(&self, t: f64) -> Location {
        self.edge.edge.at(t)
    }
}

/// Whether a curve ends where it starts, and is not a point.
fn closed(curve: &Curve) -> Result<bool> {
    if curve.is_periodic() {
        return Ok(true);
    }
    let (a, b) = curve.domain();
    let start = curve.point(a)?;
    let spread = curve.points().iter().map(|p| (p - start).norm()).fold(0.0, f64::max);
    Ok(spread > 0.0 && (curve.point(b)? - start).norm() <= TOGETHER * spread)
}

/// The edge of a shape of the problem; `what` needs it.
///
/// # Errors
/// When there is no such edge.
pub(crate) fn edge_of(shapes: &Shapes<'_>, on: &On, edge: Edge, what: &str) -> Result<EdgeCurve> {
    let shape = shapes.get(on.shape)?;
    let index = edge.number_on(shape).map_err(|e| Error::Invalid(format!("{what}: {e}{on}")))?;
    EdgeCurve::of(shape, index, what)
}

/// A shape of the problem that is a curve.
///
/// # Errors
/// When it is something else.
pub(crate) fn curve_of<'a>(shapes: &Shapes<'a>, on: &On, what: &str) -> Result<&'a Curve> {
    let any: &dyn Any = shapes.get(on.shape)?;
    any.downcast_ref()
        .ok_or_else(|| Error::Invalid(format!("{what}: what the edge is to lie on{on} is no curve")))
}

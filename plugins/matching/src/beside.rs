//! A curve that runs beside an edge: which way, from where, and in which space the edge can lie on it.

mod found;

use std::any::Any;

use loftsman_kernel::Point;
use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::functional::{Edge, On, Shapes};
use loftsman_kernel::shape::{Derivative, Location, Shape, Stencil, edges_of};
use loftsman_kernel::spline::{Conversion, Curve, Space};
use loftsman_kernel::topology::{EdgeCurve, TOGETHER};

use self::found::{round, size_of, straight};

/// Where edge and curve are not to be equal, so many times as many places show how far they are apart …
const FINER: usize = 16;
/// … and where that were more than these altogether, fewer of each piece, but twice as many as its degrees.
const PLACES: usize = 2048;
/// Rounding of the coordinates at a seam, as a part of these.
const SEAM: f64 = 64.0 * f64::EPSILON;
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
    /// Where closed ones are nearest to one another, if that is not where they were begun.
    askew: Option<Askew>,
}

/// A closed curve that is begun elsewhere than where it is nearest to the edge: what runs across is askew.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Askew {
    /// By how much: the part of a turn, as parameters go round.
    pub(crate) turn: f64,
    /// The parameter of the curve at which it would have been begun.
    pub(crate) nearest: f64,
    /// Whether the edge has a seam.
    pub(crate) seam: bool,
}

/// The way and the start that were found of a curve beside an edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Begun {
    track: Track,
    askew: Option<Askew>,
}

/// How a curve's own parameters go along with the edge's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Track {
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
    /// How a curve lies beside an edge now: it is run through the way, and where both are closed from the place, that brings the two nearest to one another
    /// (least squares over even parameters, seen from their middles). That place may be anywhere; where breakpoints lie beside one another at a place that is
    /// about as good, it is that one, since there the edge may be the curve exactly; of what is to be that (`exact`), whether it is as good or not.
    ///
    /// # Errors
    /// When the edge is a point, or numbers overflow.
    pub(crate) fn new(edge: EdgeCurve, curve: &Curve, exact: bool) -> Result<Self> {
        if edge.spread() == 0.0 {
            let name = edge.edge.called();
            return Err(Error::Invalid(format!(
                "{name} is a point (a pole), which runs along nothing: name another edge"
            )));
        }
        let (track, askew) = if closed(&edge.curve)? && closed(curve)? {
            round(&edge, curve, exact)?
        } else {
            (straight(&edge.curve, curve)?, None)
        };
        Ok(Self { askew, ..Self::along(edge, curve, track)? })
    }

    /// The same as it was found of this edge or of one that has more knots: to the last bit, where ways or starts that are equally near would be told apart by
    /// rounding, and knots that were put where the curve has some go on lying there.
    ///
    /// # Errors
    /// When numbers overflow.
    pub(crate) fn begun(edge: EdgeCurve, curve: &Curve, begun: Begun) -> Result<Self> {
        Ok(Self { askew: begun.askew, ..Self::along(edge, curve, begun.track)? })
    }

    /// How it was found to run and to begin.
    pub(crate) fn begins(&self) -> Begun {
        Begun { track: self.track, askew: self.askew }
    }

    /// The same, the way and the start being known.
    ///
    /// # Errors
    /// When numbers overflow.
    pub(crate) fn along(edge: EdgeCurve, curve: &Curve, track: Track) -> Result<Self> {
        let ((a, b), (c, d)) = (edge.curve.domain(), curve.domain());
        let mut turned = curve.clone();
        let mut start = track.start;
        if track.reversed {
            turned = turned.reverse()?;
            start = c + (d - start);
        }
        let rounding = SEAM * edge.spread().max(size_of(&turned));
        // Beside an edge without a seam it needs none where it is smooth: neither does the edge then, when it takes its knots.
        let unseamed = |curve: Curve| match curve.to_periodic(rounding) {
            Ok(ring) if edge.curve.is_periodic() => ring.shape,
            _ => curve,
        };
        let turned = match start > c && start < d {
            false if turned.is_periodic() => turned,
            false => unseamed(turned),
            true if turned.is_periodic() => turned.started_at(start)?,
            // Where it had its seam it is as smooth as it was there: no knot is left of that but what the curve needs.
            true => match turned.to_periodic(rounding) {
                Ok(ring) => unseamed(ring.shape.started_at(start)?.to_clamped()?),
                Err(_) => unseamed(turned.started_at(start)?),
            },
        };
        Ok(Self { edge, curve: turned.reparametrise(a, b)?, track, askew: None })
    }

    /// How the curve's own parameters go along with the edge's.
    pub(crate) fn track(&self) -> Track {
        self.track
    }

    /// Where closed ones are nearest to one another, if that is not where they were begun.
    pub(crate) fn askew(&self) -> Option<Askew> {
        self.askew
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

    /// Which of the Greville abscissae lie at knots of the curve that are no ends: how many are before, and a place on either side.
    pub(crate) fn knots_met(&self) -> Vec<(usize, [f64; 2])> {
        let (a, b) = self.edge.curve.domain();
        let (breaks, near) = (self.curve.space().breakpoints(), TOGETHER * (b - a));
        let met = |(k, t): (usize, f64)| {
            let at = breaks.partition_point(|knot| *knot < t - near);
            let knot =
                breaks.get(at).copied().filter(|knot| *knot <= t + near && *knot - a > WITHIN * (b - a))?;
            (b - knot > WITHIN * (b - a))
                .then_some((k, [-1.0, 1.0].map(|side| knot + side * WITHIN * (b - a))))
        };
        self.greville().into_iter().enumerate().filter_map(met).collect()
    }

    /// A place on either side of each knot of the curve that is no end.
    pub(crate) fn sides(&self) -> impl Iterator<Item = [f64; 2]> {
        let (a, b) = self.edge.curve.domain();
        let inside = move |knot: &f64| *knot - a > WITHIN * (b - a) && b - *knot > WITHIN * (b - a);
        let breaks = self.curve.space().breakpoints().into_iter().filter(inside);
        breaks.map(move |knot| [-1.0, 1.0].map(|side| knot + side * WITHIN * (b - a)))
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
        let pieces = breaks.len().saturating_sub(1).max(1);
        let each =
            if exact { degrees + 1 } else { (FINER * degrees).min((PLACES / pieces).max(2 * degrees)) };
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
pub(crate) fn closed(curve: &Curve) -> Result<bool> {
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
    let index = edge.number_on(shape).map_err(|e| {
        let none = edges_of(shape, what).is_ok_and(|edges| edges.iter().next().is_none());
        Error::Invalid(match &on.name {
            Some(name) if none => format!("{what}: \"{name}\" is closed all round and has no edge"),
            None if none => format!("{what}: the surface is closed all round and has no edge"),
            _ => format!("{what}: {e}{on}"),
        })
    })?;
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

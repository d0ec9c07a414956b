//! A curve that runs beside an edge: which way, from where, and in which space the edge can lie on it.

use std::any::Any;

use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::functional::{Edge, On, Shapes};
use loftsman_kernel::shape::{Derivative, Location, Shape, Stencil, edges_of};
use loftsman_kernel::spline::{Conversion, Curve, Space};
use loftsman_kernel::topology::{EdgeCurve, TOGETHER};
use loftsman_kernel::{Point, Vector};

/// Places at which edge and curve are compared to find the way round.
const COMPARED: usize = 17;
/// The most places of a closed curve that are tried as its start.
const STARTS: usize = 64;
/// Places at which two closed ones are compared, and as many starts that are tried evenly.
const ROUND: usize = 64;
/// Golden sections of the way between two of these starts: the start is known to 1e-8 of a turn.
const SECTIONS: usize = 40;
/// A start at which breakpoints lie beside one another is as good as the best one where its squared distances are no more than this part larger …
const AS_NEAR: f64 = 0.02;
/// … or differ by no more than the squares of this part of the edge's size, and where lines across run askew by no more than this part of a turn.
const TURNED: f64 = 1e-6;
const ASKEW: f64 = 1.0 / 720.0;
/// Where the edge may have to be the curve, corners of both, or what may be one, that lie no further than this part of a turn from one another (6°) meet.
const CORNERS: f64 = 1.0 / 60.0;
/// A start no further than this part of a turn from a knot of the curve is at it.
const AT_KNOT: f64 = 1e-6;
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

/// Straight on or backwards, whichever is nearer; of equals straight on.
fn straight(edge: &Curve, curve: &Curve) -> Result<Track> {
    let ((a, b), (c, d)) = (edge.domain(), curve.domain());
    let tracks = [(c, false), (d, true)].map(|(start, reversed)| Track {
        edge: (a, b),
        curve: (c, d),
        start,
        reversed,
    });
    let mut far = [0.0; 2];
    for i in 0..COMPARED {
        let t = (a + (b - a) * i as f64 / (COMPARED - 1) as f64).min(b);
        let point = edge.point(t)?;
        for (far, track) in far.iter_mut().zip(&tracks) {
            *far += (curve.point(track.there(t))? - point).norm();
        }
    }
    Ok(tracks[usize::from(far[1] < far[0] * (1.0 - TOGETHER))])
}

/// The way and the start at which a closed curve is nearest to a closed edge. A grid of starts, then golden sections. `O(1)` places of both, and the
/// breakpoints of the curve up to some number of them.
fn round(edge: &EdgeCurve, curve: &Curve, exact: bool) -> Result<(Track, Option<Askew>)> {
    let size = edge.spread();
    let edge = &edge.curve;
    let ((a, b), (c, d)) = (edge.domain(), curve.domain());
    let breaks = curve.space().breakpoints();
    let track = |start: f64, reversed: bool| {
        // Where it is a knot but for rounding it is that.
        let start = if start < c { start + (d - c) } else { start };
        let start = if start > d { start - (d - c) } else { start };
        let knot = breaks.iter().find(|k| (*k - start).abs() <= TOGETHER * (d - c));
        let start = knot.copied().unwrap_or(start);
        // The start of a curve run backwards is its end.
        let start = if reversed && start <= c {
            d
        } else if !reversed && start >= d {
            c
        } else {
            start
        };
        Track { edge: (a, b), curve: (c, d), start, reversed }
    };
    let share = |k: usize| k as f64 / ROUND as f64;
    let places: Vec<f64> = (0..ROUND).map(|k| a + (b - a) * share(k)).collect();
    let own = places.iter().map(|t| edge.point(*t)).collect::<Result<Vec<_>>>()?;
    let grid = (0..ROUND).map(|k| curve.point(c + (d - c) * share(k))).collect::<Result<Vec<_>>>()?;
    // How far they are apart, but for where their middles are, which no start changes: there would be nothing to see of it beside a wide gap.
    let apart = |there: &dyn Fn(usize) -> Result<Point>| -> Result<f64> {
        let ways = own.iter().enumerate().map(|(k, p)| Ok(there(k)? - p)).collect::<Result<Vec<_>>>()?;
        let middle = ways.iter().sum::<Vector>() / ROUND as f64;
        Ok(ways.iter().map(|way| ((way - middle) / size).norm_squared()).sum())
    };
    let of = |track: &Track| apart(&|k| curve.point(track.there(places[k])));
    let mut least: Option<(f64, usize, bool)> = None;
    for reversed in [false, true] {
        for start in 0..ROUND {
            let there = |k: usize| if reversed { (start + ROUND - k) % ROUND } else { (start + k) % ROUND };
            let far = apart(&|k| Ok(grid[there(k)]))?;
            // Of equals the first: straight on, from the start.
            if least.is_none_or(|(least, ..)| far < least * (1.0 - TOGETHER)) {
                least = Some((far, start, reversed));
            }
        }
    }
    let (_, start, reversed) = least.unwrap_or((0.0, 0, false));
    let turn = |share: f64| track(c + (d - c) * share.rem_euclid(1.0), reversed);
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (share(start) - share(1), share(start) + share(1));
    let inner = |low: f64, high: f64| [high - golden * (high - low), low + golden * (high - low)];
    let mut values = [0.0; 2];
    for (value, at) in values.iter_mut().zip(inner(low, high)) {
        *value = of(&turn(at))?;
    }
    for _ in 0..SECTIONS {
        let [x, y] = inner(low, high);
        if values[0] <= values[1] {
            high = y;
            values = [of(&turn(inner(low, high)[0]))?, values[0]];
        } else {
            low = x;
            values = [values[1], of(&turn(inner(low, high)[1]))?];
        }
    }
    let mut best = turn(0.5 * low + 0.5 * high);
    let mut far = of(&best)?;
    let inside = breaks.iter().copied().filter(|&k| k > c && k < d).take(STARTS);
    let starts: Vec<Track> = std::iter::once(c)
        .chain(inside)
        .flat_map(|start| [false, true].map(|way| track(start, way)))
        .collect();
    // Those are better as well where the grid was too coarse.
    let mut alike: Option<(f64, Track)> = None;
    for track in starts {
        let found = of(&track)?;
        if found < far * (1.0 - TOGETHER) {
            (far, best) = (found, track);
        }
        let nearer = alike.is_none_or(|(least, _)| found < least * (1.0 - TOGETHER));
        if nearer && track.agrees(edge.space(), curve.space()) {
            alike = Some((found, track));
        }
    }
    // Golden sections find a knot but for rounding.
    let length = d - c;
    let away = |u: f64, v: f64| {
        let turn = ((u - v) / length).rem_euclid(1.0);
        turn.min(1.0 - turn)
    };
    if let Some(&knot) = breaks.iter().find(|&&knot| away(knot, best.start) <= AT_KNOT) {
        best = track(knot, best.reversed);
    }
    let enough = far * (1.0 + AS_NEAR) + ROUND as f64 * TURNED * TURNED;
    let turned = |track: &Track| {
        if track.reversed == best.reversed { away(track.start, best.start) } else { 1.0 }
    };
    let as_good = |(found, track): &(f64, Track)| *found <= enough && turned(track) <= ASKEW;
    let begun = match alike.filter(|one| exact || as_good(one)) {
        Some((_, track)) => track,
        None => track(best.start + together(edge.space(), curve.space(), &best, exact), best.reversed),
    };
    let turn = turned(&begun);
    let seam = !edge.space().is_periodic();
    // Run the other way it is as far off as can be; nothing is askew of what looks the same from everywhere.
    let askew = (turn > ASKEW && far * (1.0 + AS_NEAR) < of(&begun)?).then_some(Askew {
        turn: turn.min(0.5),
        nearest: best.start,
        seam,
    });
    Ok((begun, askew))
}

/// How much farther along a closed curve it is begun so that knots of edge and curve that lie all but beside one another do: two knots with next to nothing
/// between them would be a piece that nothing holds. Where both have their corners, or what may be one, first; else as many as can be; and by no more than
/// [`ASKEW`], which turns what runs across by next to nothing, or for corners of what is to be `exact` by no more than [`CORNERS`].
fn together(edge: &Space, curve: &Space, track: &Track, exact: bool) -> f64 {
    let length = curve.length();
    let around = |space: &Space| {
        let mut breaks = space.breakpoints();
        // The end of what is closed is its start.
        breaks.pop();
        breaks.truncate(STARTS);
        breaks
    };
    let off = |t: f64, knot: f64| {
        let off = ((knot - track.there(t)) / length).rem_euclid(1.0);
        if off > 0.5 { off - 1.0 } else { off }
    };
    let near = |edges: &[f64], knots: &[f64], within: f64| -> Vec<f64> {
        let each = edges.iter().flat_map(|t| knots.iter().map(move |knot| off(*t, *knot)));
        let mut all: Vec<f64> = each.filter(|off| off.abs() <= within).collect();
        all.sort_by(f64::total_cmp);
        all
    };
    let sharp = |space: &Space| {
        let start = space.domain().0;
        let may_turn = |knot: &f64| {
            !space.is_periodic() && *knot == start || space.multiplicity(*knot) >= space.degree()
        };
        around(space).into_iter().filter(may_turn).collect::<Vec<f64>>()
    };
    let mut all = near(&sharp(edge), &sharp(curve), if exact { CORNERS } else { ASKEW });
    if all.is_empty() {
        all = near(&around(edge), &around(curve), ASKEW);
    }
    // Of those that can be met at once the most, and of equals the nearest.
    let mut best = None::<(usize, f64)>;
    for (k, low) in all.iter().enumerate() {
        let met = all[k..].partition_point(|off| off - low <= AT_KNOT);
        let at = all[k + met / 2];
        if best.is_none_or(|(most, by)| met > most || met == most && at.abs() < by.abs()) {
            best = Some((met, at));
        }
    }
    best.map_or(0.0, |(_, by)| by * length)
}

/// The largest coordinate of a curve's control vertices.
fn size_of(curve: &Curve) -> f64 {
    curve.points().iter().fold(0.0, |most: f64, p| most.max(p.coords.amax()))
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

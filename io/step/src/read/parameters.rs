//! Parameter curves: what the file says that an edge is in the parameters of a face's surface.
//!
//! Only those of B-spline surfaces can be taken, whose parameters are kept: planes, cylinders and their like become splines with parameters of
//! their own. What runs along a line of parameters is computed in any case: it is exact then, which files are not. Whether one is as near to its edge as that says it is, the Brep decides where it uses it.

use std::f64::consts::TAU;

use loftsman_kernel::Point;
use loftsman_kernel::spline::trimmed::{ParameterCurve, Region};
use loftsman_kernel::spline::{Curve, Space as Knots, Surface, Trimmed};

use super::curve::{Basis, OnCurve};
use super::entity::{At, Got, Problem};
use super::place::Space;
use super::spline::{CURVES, SURFACES, is_one};
use crate::part21::Entity;

/// How far beyond the domain of a surface, or of its own curve, a parameter may be by rounding, as a part of it.
const SLACK: f64 = 1e-9;
/// A curve whose parameter changes by less, as a part of the domain, is meant to be a line of it.
const STRAIGHT: f64 = 1e-6;
/// Angles that are less than this short of a turn are none.
const ROUNDING: f64 = 1e-9;

/// Where the curve of an edge comes from: the entity, and its parameters there where the edge starts and ends.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Origin {
    pub(crate) curve: u64,
    pub(crate) range: [f64; 2],
}

impl Basis {
    /// The parameters of this curve, as the schema has them, at the ends of an edge on it; `None` where the edge is on a curve that was put
    /// together.
    pub(crate) fn range_of(&self, found: &OnCurve, along: bool) -> Option<[f64; 2]> {
        let (from, to) = found.range;
        match self {
            Self::Spline(curve) => (curve.domain() == found.curve.domain()).then_some([from, to]),
            Self::Line { .. } => {
                let at = |t: f64| self.parameter(found.curve.point(t).ok()?).ok();
                Some([at(from)?, at(to)?])
            }
            Self::Ellipse { .. } => {
                let at = |t: f64| self.parameter(found.curve.point(t).ok()?).ok();
                let (a, b) = (at(from)?, at(to)?);
                // Angles go on in the sense of the edge, all around where it closes.
                let turn = |angle: f64| {
                    let rest = angle.rem_euclid(TAU);
                    if rest > ROUNDING { rest } else { TAU }
                };
                Some(if along { [a, a + turn(b - a)] } else { [a, a - turn(a - b)] })
            }
            Self::Parabola { .. } | Self::Hyperbola { .. } => Some([from, to]),
        }
    }
}

impl Space<'_, '_> {
    /// The PCURVEs of a curve on a surface, in the order in which they stand.
    fn on_surface(&self, curve: u64, surface: u64) -> Got<Vec<u64>> {
        let entity = self.entity(curve)?;
        if !matches!(entity.only(), b"SURFACE_CURVE" | b"SEAM_CURVE" | b"INTERSECTION_CURVE") {
            return Ok(Vec::new());
        }
        let mut found = Vec::new();
        for number in entity.args().references(2)? {
            let one = self.entity(number)?;
            if one.only() == b"PCURVE" && one.args().reference(1)? == surface {
                found.push(number);
            }
        }
        Ok(found)
    }

    /// The parameter curve of an edge on a B-spline surface, from the edge's start to its end, and its PCURVE; `reversed` says which of the
    /// two of a seam. `None` where the file has none that can be taken.
    pub(crate) fn parameter_curve(
        &self,
        origin: Origin,
        (number, surface): (u64, &Surface),
        reversed: bool,
    ) -> Got<Option<(ParameterCurve, u64)>> {
        let all = self.on_surface(origin.curve, number)?;
        let Some(&one) = (if reversed { all.last() } else { all.first() }) else { return Ok(None) };
        let representation = self.entity(self.entity(one)?.args().reference(2)?)?;
        let Some(&item) = representation.of("DEFINITIONAL_REPRESENTATION")?.references(1)?.first() else {
            return Ok(None);
        };
        let Some(curve) = self.planar(item, origin.range)? else { return Ok(None) };
        let inside = |t: f64, space: &Knots| {
            let ((a, b), slack) = (space.domain(), SLACK * space.length());
            t >= a - slack && t <= b + slack
        };
        // Along a line of parameters the computed one is that line, exactly; files have curves of many pieces there that waver about it.
        let stays = |k: usize, space: &Knots| {
            let first = curve.points()[0][k];
            curve.points().iter().all(|p| (p[k] - first).abs() <= STRAIGHT * space.length())
        };
        if stays(0, surface.u()) || stays(1, surface.v()) {
            return Ok(None);
        }
        let holds = curve.points().iter().all(|p| inside(p.x, surface.u()) && inside(p.y, surface.v()));
        Ok(if holds { ParameterCurve::whole(curve).ok().map(|curve| (curve, one)) } else { None })
    }

    /// What an edge is in the parameters of a surface, from its start to its end: two curves where it is a seam. None that cannot be read.
    pub(crate) fn planar_curves(&self, origin: Origin, surface: u64) -> Got<Vec<Curve>> {
        let mut range = origin.range;
        if let (Basis::Ellipse { .. }, _) = self.basis(origin.curve, 0)? {
            // As others have angles: the lesser one from 0 to a turn.
            let low = range[0].min(range[1]);
            let start = low.rem_euclid(TAU);
            let start = if start > TAU - ROUNDING { start - TAU } else { start };
            range = range.map(|angle| angle - low + start);
        }
        let mut found = Vec::new();
        for one in self.on_surface(origin.curve, surface)? {
            let representation = self.entity(self.entity(one)?.args().reference(2)?)?;
            let items = representation.of("DEFINITIONAL_REPRESENTATION")?.references(1)?;
            if let Some(&item) = items.first() {
                found.extend(self.planar(item, range)?);
            }
        }
        Ok(found)
    }

    /// What curves bound on a B-spline surface, and the PCURVEs of these: a CURVE_BOUNDED_SURFACE.
    pub(crate) fn curve_bounded(&self, number: u64) -> Got<(Trimmed, Vec<u64>)> {
        let entity = self.entity(number)?;
        let args = entity.of("CURVE_BOUNDED_SURFACE")?;
        let basis = args.reference(1)?;
        let surface = self.entity(basis)?;
        if !is_one(&surface, &SURFACES) {
            let text = format!("{} that curves bound: only B-spline surfaces are read so", surface.kinds());
            return Err(Problem::new(number, text));
        }
        let surface = self.spline_surface(&surface)?;
        let (mut region, mut used) = (Region::default(), Vec::new());
        let bounds = args.references(2)?;
        let count = bounds.len();
        for bound in bounds {
            let bound = self.entity(bound)?;
            let outer = match bound.only() {
                b"OUTER_BOUNDARY_CURVE" => true,
                // The only one there is.
                b"BOUNDARY_CURVE" => count == 1 && !args.flag(3)?,
                _ => return Err(Problem::new(bound.number, format!("{} is no boundary", bound.kinds()))),
            };
            let chain = self.boundary(&bound, basis, &mut used)?;
            if outer && region.outer.is_empty() {
                region.outer = chain;
            } else {
                region.holes.push(chain);
            }
        }
        let trimmed = Trimmed::new(surface, vec![region], Vec::new(), Vec::new()).at(number)?;
        Ok((trimmed, used))
    }

    /// A loop of parameter curves on a surface.
    fn boundary(&self, bound: &Entity<'_>, surface: u64, used: &mut Vec<u64>) -> Got<Vec<ParameterCurve>> {
        let mut chain = Vec::new();
        for segment in bound.args().references(1)? {
            let segment = self.entity(segment)?;
            let args = segment.of("COMPOSITE_CURVE_SEGMENT")?;
            let parent = args.reference(2)?;
            let one = match self.entity(parent)?.only() {
                b"PCURVE" => Some(parent),
                _ => self.on_surface(parent, surface)?.first().copied(),
            };
            let one = one.ok_or_else(|| {
                Problem::new(parent, "a boundary without a curve in the surface's parameters")
            })?;
            let entity = self.entity(one)?;
            if entity.of("PCURVE")?.reference(1)? != surface {
                return Err(Problem::new(one, "a boundary in the parameters of another surface"));
            }
            let representation = self.entity(entity.args().reference(2)?)?;
            let items = representation.of("DEFINITIONAL_REPRESENTATION")?.references(1)?;
            let item = items.first().copied().ok_or_else(|| Problem::new(one, "no curve is in it"))?;
            let item = self.entity(item)?;
            if !is_one(&item, &CURVES) {
                let text =
                    format!("{} as a boundary in parameters: only B-splines are read so", item.kinds());
                return Err(Problem::new(item.number, text));
            }
            let curve = self.planar_spline(&item)?;
            let curve = if args.flag(1)? { curve } else { curve.reverse().at(one)? };
            chain.push(ParameterCurve::whole(curve).at(one)?);
            used.push(one);
        }
        Ok(chain)
    }

    /// A curve of two coordinates between two of its parameters, the first perhaps more; `None` where it is neither a line nor a B-spline that
    /// has them.
    fn planar(&self, number: u64, [from, to]: [f64; 2]) -> Got<Option<Curve>> {
        let entity = self.entity(number)?;
        if is_one(&entity, &CURVES) {
            let curve = self.planar_spline(&entity)?;
            let ((start, end), (low, high)) = (curve.domain(), (from.min(to), from.max(to)));
            let slack = SLACK * (end - start);
            if low < start - slack || high > end + slack {
                return Ok(None);
            }
            // Parameters on lines and circles are computed: an end that is meant is one.
            let low = if low <= start + slack { start } else { low };
            let high = if high >= end - slack { end } else { high };
            let part =
                if (low, high) == (start, end) { curve.to_clamped() } else { curve.between(low, high) };
            return Ok(part.and_then(|part| if from < to { Ok(part) } else { part.reverse() }).ok());
        }
        if entity.only() != b"LINE" {
            return Ok(None);
        }
        let args = entity.args();
        let [x, y] = self.coordinates::<2>(args.reference(1)?, "CARTESIAN_POINT")?;
        let vector = self.entity(args.reference(2)?)?;
        let args = vector.of("VECTOR")?;
        let [dx, dy] = self.coordinates::<2>(args.reference(1)?, "DIRECTION")?;
        let step = args.real(2)? / dx.hypot(dy);
        let at = |t: f64| Point::new(x + dx * step * t, y + dy * step * t, 0.0);
        let ends = [at(from), at(to)];
        if ends[0] == ends[1] || !ends.iter().all(|p| p.iter().all(|c| c.is_finite())) {
            return Ok(None);
        }
        Ok(Curve::line(ends[0], ends[1]).ok())
    }
}

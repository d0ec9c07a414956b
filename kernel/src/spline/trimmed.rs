//! Trimmed surfaces: the part of a surface that closed loops in its parameter plane bound.

use super::curve::Curve;
use super::part::{Part, follow};
use super::surface::Surface;
use super::{ParameterRegion, ParameterSide};
use crate::error::{Error, Result};
use crate::quadrature::gauss_legendre;
use crate::shape::{
    Cells, Derivative, Domain, Edges, Grid, Interval, Location, Refine, Shape, Sides, Stencil,
};
use crate::solve::Symmetric;
use crate::{Point, Vector};

/// How far the ends of neighbouring curves of a loop may be apart, and a curve outside the domain, as a fraction of
/// the domain's longer side: files print parameters with six digits or fewer.
pub const LOOP_GAP: f64 = 1e-4;

/// A curve in the parameter plane of a surface, between two of its own parameters.
///
/// The curve's points are `(u, v, 0)`.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterCurve {
    curve: Curve,
    from: f64,
    to: f64,
}

impl ParameterCurve {
    /// The part of a plane curve between two parameters.
    ///
    /// # Errors
    /// When a control vertex has `z ≠ 0`, or `from < to` does not hold, or one is outside the curve's domain.
    pub fn new(curve: Curve, from: f64, to: f64) -> Result<Self> {
        if let Some((index, p)) = curve.points().iter().enumerate().find(|(_, p)| p.z != 0.0) {
            return Err(Error::Invalid(format!(
                "control vertex {index} of a curve in the parameter plane has z = {}: it must be 0",
                p.z
            )));
        }
        let (start, end) = curve.domain();
        if let Some(value) = [from, to].into_iter().find(|t| !(start..=end).contains(t)) {
            return Err(Error::Outside { value, start, end });
        }
        if from >= to {
            return Err(Error::Invalid(format!(
                "a curve in the parameter plane runs from {from} to {to}: the first must be less; reverse the curve"
            )));
        }
        // What lies in a parameter plane is its spline and no more.
        Ok(Self { curve: curve.without_form(), from, to })
    }

    /// The whole of a plane curve.
    ///
    /// # Errors
    /// As for [`new`](Self::new).
    pub fn whole(curve: Curve) -> Result<Self> {
        let (from, to) = curve.domain();
        Self::new(curve, from, to)
    }

    /// The curve that it is a part of.
    pub fn curve(&self) -> &Curve {
        &self.curve
    }

    /// Where it starts and ends on the curve.
    pub fn range(&self) -> (f64, f64) {
        (self.from, self.to)
    }

    /// The surface parameters at its start and at its end.
    ///
    /// # Errors
    /// When evaluation overflows.
    pub fn ends(&self) -> Result<[[f64; 2]; 2]> {
        let (a, b) = (self.curve.point(self.from)?, self.curve.point(self.to)?);
        Ok([[a.x, a.y], [b.x, b.y]])
    }

    fn check_inside(&self, surface: &Surface) -> Result<()> {
        let (start, end) = self.curve.domain();
        let (low, high) = if (self.from, self.to) == (start, end) {
            self.curve.bounds()
        } else {
            self.curve.between(self.from, self.to)?.bounds()
        };
        inside(surface, [low.x, low.y])?;
        inside(surface, [high.x, high.y])
    }
}

/// One region of a trimmed surface.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Region {
    /// The closed loop around it, curve after curve; without curves it is the edge of the whole domain.
    pub outer: Vec<ParameterCurve>,
    /// The closed loops that bound what is cut out of it.
    pub holes: Vec<Vec<ParameterCurve>>,
}

/// A surface of which only some regions count.
///
/// Loops are lists of curves in the parameter plane, each starting where the one before ends and the first where the
/// last ends. Special curves and special points are kept with it: a tessellation or a mesher should follow them.
#[derive(Debug, Clone, PartialEq)]
pub struct Trimmed {
    surface: Surface,
    regions: Vec<Region>,
    curves: Vec<Vec<ParameterCurve>>,
    points: Vec<[f64; 2]>,
}

impl Trimmed {
    /// A surface with regions (none: the whole of it), special curves (chains of parameter curves) and special
    /// points. `O(curves)`; whether loops cross one another is not looked at.
    ///
    /// # Errors
    /// When a loop or chain is empty or torn, a loop does not close, or something lies outside the domain: each by more
    /// than [`LOOP_GAP`]. The message names the loop.
    pub fn new(
        surface: Surface,
        regions: Vec<Region>,
        curves: Vec<Vec<ParameterCurve>>,
        points: Vec<[f64; 2]>,
    ) -> Result<Self> {
        for (r, region) in regions.iter().enumerate() {
            if !region.outer.is_empty() {
                check_chain(&surface, &region.outer, true)
                    .map_err(|e| named(&format!("the outer loop of region {r}"), &e))?;
            }
            for (h, hole) in region.holes.iter().enumerate() {
                check_chain(&surface, hole, true)
                    .map_err(|e| named(&format!("hole {h} of region {r}"), &e))?;
            }
        }
        for (c, chain) in curves.iter().enumerate() {
            check_chain(&surface, chain, false).map_err(|e| named(&format!("special curve {c}"), &e))?;
        }
        for (p, &point) in points.iter().enumerate() {
            inside(&surface, point).map_err(|e| named(&format!("special point {p}"), &e))?;
        }
        // Loops lie in the parameters of the spline, which the form of it has others than.
        Ok(Self { surface: surface.without_form(), regions, curves, points })
    }

    /// The surface that carries it.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// Its regions; none where the whole surface counts.
    pub fn regions(&self) -> &[Region] {
        &self.regions
    }

    /// The special curves.
    pub fn curves(&self) -> &[Vec<ParameterCurve>] {
        &self.curves
    }

    /// The special points, as parameters.
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    /// The same regions of another surface.
    ///
    /// # Errors
    /// When a loop does not lie in that surface's domain.
    pub fn on(&self, surface: Surface) -> Result<Self> {
        let same = surface.u() == self.surface.u() && surface.v() == self.surface.v();
        if same {
            return Ok(Self { surface: surface.without_form(), ..self.clone() });
        }
        Self::new(surface, self.regions.clone(), self.curves.clone(), self.points.clone())
    }

    /// What its loops leave of the parameter plane: what is inside outer loops and outside of holes, whichever way they run. `O(curves)`, and the cells
    /// that they cross.
    ///
    /// # Errors
    /// When loops cross, so that they do not say what is inside.
    pub fn region(&self) -> Result<ParameterRegion> {
        let (sides, whole) = self.border()?;
        let loops = self.oriented(&whole)?;
        ParameterRegion::new(&self.surface, &sides, &loops)
    }

    /// What its loops leave, prepared for many questions: whether a place is in it, which place of it is nearest to a point. `O(curves)`.
    ///
    /// # Errors
    /// When an evaluation overflows.
    pub fn part(&self) -> Result<Part> {
        let (sides, whole) = self.border()?;
        let loops = self.oriented(&whole)?;
        let mut lines = Vec::with_capacity(loops.len());
        for chain in &loops {
            let mut line = Vec::new();
            for (curve, backwards) in chain {
                follow(&mut line, curve, *backwards)?;
            }
            lines.push(line);
        }
        let border = loops.iter().flatten().map(|(curve, _)| (*curve).clone()).collect();
        Ok(Part::new(self.surface.clone(), &lines, sides, border))
    }

    /// The corners of the axis-parallel box around what its loops leave, the lower first: [`Part::bounds`].
    ///
    /// # Errors
    /// When an evaluation overflows.
    pub fn bounds(&self) -> Result<(Point, Point)> {
        self.part()?.bounds()
    }

    /// The sides of the parameter plane, and the loop around all of it.
    fn border(&self) -> Result<([ParameterSide; 2], Vec<ParameterCurve>)> {
        let (sides, _) = plane(&self.surface);
        let of = |side: &Interval| ParameterSide {
            low: side.start,
            high: side.end,
            closed: side.periodic,
            poles: [false; 2],
        };
        Ok(([of(&sides[0]), of(&sides[1])], whole_of(sides)?))
    }

    /// All loops, that around everything where a region has no outer one, outer ones counterclockwise and holes clockwise; and which curves are run
    /// backwards.
    fn oriented<'a>(&'a self, whole: &'a [ParameterCurve]) -> Result<Vec<Vec<(&'a ParameterCurve, bool)>>> {
        let mut loops = Vec::new();
        for region in &self.regions {
            let outer = if region.outer.is_empty() { whole } else { &region.outer };
            loops.push(turned(outer, true)?);
            for hole in &region.holes {
                loops.push(turned(hole, false)?);
            }
        }
        Ok(loops)
    }

    /// All loops: the outer one of each region (where it has one) and its holes.
    pub fn loops(&self) -> impl Iterator<Item = &[ParameterCurve]> + '_ {
        self.regions.iter().flat_map(|r| {
            std::iter::once(r.outer.as_slice())
                .filter(|outer| !outer.is_empty())
                .chain(r.holes.iter().map(Vec::as_slice))
        })
    }
}

/// The surface that carries it, edited as that would be: its loops, which lie in the parameter plane, stay as they are.
impl Shape for Trimmed {
    fn control_vertices(&self) -> &[Point] {
        self.surface.points()
    }

    fn control_vertices_mut(&mut self) -> &mut [Point] {
        self.surface.control_vertices_mut()
    }

    fn stencil(&self, at: Location, derivative: Derivative) -> Result<Stencil> {
        self.surface.stencil(at, derivative)
    }

    fn stencil_on(&self, at: Location, derivative: Derivative, sides: Sides) -> Result<Stencil> {
        self.surface.stencil_on(at, derivative, sides)
    }

    fn domain(&self) -> Domain {
        Shape::domain(&self.surface)
    }

    fn boxed(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }

    fn smoothness(&self, order: usize) -> Option<Symmetric> {
        self.surface.smoothness(order)
    }

    fn grid(&self) -> Option<Grid> {
        self.surface.grid()
    }

    fn cells(&self) -> Option<&dyn Cells> {
        Some(self)
    }

    /// None where there are loops: these are its boundary then.
    fn edges(&self) -> Option<&dyn Edges> {
        if self.regions.is_empty() { Some(self) } else { None }
    }

    fn refine(&self) -> Option<&dyn Refine> {
        Some(self)
    }
}

/// The edge of a domain.
fn whole_of([u, v]: [Interval; 2]) -> Result<Vec<ParameterCurve>> {
    let corners = [[u.start, v.start], [u.end, v.start], [u.end, v.end], [u.start, v.end]];
    let at = |k: usize| Point::new(corners[k % 4][0], corners[k % 4][1], 0.0);
    (0..4).map(|k| ParameterCurve::whole(Curve::line(at(k), at(k + 1))?)).collect()
}

/// A loop run counterclockwise, or clockwise: its curves, and whether each is run backwards. Its area is found by Gauss's rule, `∮ u dv`.
fn turned(chain: &[ParameterCurve], counterclockwise: bool) -> Result<Vec<(&ParameterCurve, bool)>> {
    let mut area = 0.0;
    let first = chain.first().map_or(Ok([[0.0; 2]; 2]), ParameterCurve::ends)?[0];
    for one in chain {
        let part = one.curve.between(one.from, one.to)?;
        let (nodes, weights) = gauss_legendre(2 * part.degree() + 2);
        for pair in part.space().breakpoints().windows(2) {
            let length = pair[1] - pair[0];
            for (x, w) in nodes.iter().zip(&weights) {
                let mut d = [Vector::zeros(); 2];
                part.derivatives_into(pair[0] + length * x, &mut d)?;
                area += 0.5 * w * length * ((d[0].x - first[0]) * d[1].y - (d[0].y - first[1]) * d[1].x);
            }
        }
    }
    let backwards = (area > 0.0) != counterclockwise;
    let all = chain.iter().map(|one| (one, backwards));
    Ok(if backwards { all.rev().collect() } else { all.collect() })
}

fn named(what: &str, error: &Error) -> Error {
    Error::Invalid(format!("{what}: {error}"))
}

/// The domains of a surface, and what counts as nothing there.
fn plane(surface: &Surface) -> ([Interval; 2], f64) {
    let interval = |s: &super::Space| {
        let (start, end) = s.domain();
        Interval { start, end, periodic: s.is_periodic() }
    };
    let sides = [interval(surface.u()), interval(surface.v())];
    let longest = sides.iter().map(|s| s.end - s.start).fold(0.0, f64::max);
    (sides, LOOP_GAP * longest)
}

fn inside(surface: &Surface, at: [f64; 2]) -> Result<()> {
    let (sides, slack) = plane(surface);
    for (side, value) in sides.iter().zip(at) {
        let outside = value < side.start - slack || value > side.end + slack;
        if !value.is_finite() || (outside && !side.periodic) {
            return Err(Error::Outside { value, start: side.start, end: side.end });
        }
    }
    Ok(())
}

fn check_chain(surface: &Surface, chain: &[ParameterCurve], closed: bool) -> Result<()> {
    let (Some(first), Some(last)) = (chain.first(), chain.last()) else {
        return Err(Error::Invalid("it has no curves".into()));
    };
    let (_, slack) = plane(surface);
    for curve in chain {
        curve.check_inside(surface)?;
    }
    let back = closed.then_some((last, first));
    for (k, (one, next)) in chain.iter().zip(chain.iter().skip(1)).chain(back).enumerate() {
        let ([_, end], [start, _]) = (one.ends()?, next.ends()?);
        let gap = (end[0] - start[0]).abs().max((end[1] - start[1]).abs());
        if gap > slack {
            let torn = if k + 1 == chain.len() { "it does not close" } else { "it is torn" };
            return Err(Error::Invalid(format!(
                "{torn}: curve {k} ends at ({}, {}), but the next one starts at ({}, {})",
                end[0], end[1], start[0], start[1]
            )));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spline::Space;

    fn square() -> Surface {
        let s = Space::clamped(1, &[0.0, 2.0]).unwrap();
        let points = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]].map(|[x, y]| Point::new(x, y, 0.0));
        Surface::new(s.clone(), s, points.to_vec()).unwrap()
    }

    fn line(a: [f64; 2], b: [f64; 2]) -> ParameterCurve {
        let curve = Curve::line(Point::new(a[0], a[1], 0.0), Point::new(b[0], b[1], 0.0)).unwrap();
        ParameterCurve::whole(curve).unwrap()
    }

    fn triangle(corners: [[f64; 2]; 3]) -> Vec<ParameterCurve> {
        (0..3).map(|k| line(corners[k], corners[(k + 1) % 3])).collect()
    }

    /// Files have other parameters for a plane or a line than its spline has, in which loops lie.
    #[test]
    fn what_is_trimmed_is_a_spline_only() {
        use crate::spline::form::{CurvePiece, Frame, SurfaceForm, SurfacePiece};
        let frame = Frame { origin: Point::origin(), x: Vector::x(), z: Vector::z() };
        let piece = SurfacePiece { form: SurfaceForm::Plane { frame }, ranges: [[0.0, 2.0]; 2] };
        let formed = || piece.form.patch(piece.ranges).unwrap().with_form(piece).unwrap();
        let trimmed = Trimmed::new(formed(), vec![], vec![], vec![]).unwrap();
        assert!(
            trimmed.surface().form().is_none() && trimmed.on(formed()).unwrap().surface().form().is_none()
        );
        let side = Curve::line(Point::origin(), Point::new(1.0, 0.0, 0.0)).unwrap();
        let side = ParameterCurve::whole(side.with_form(CurvePiece::LINE).unwrap()).unwrap();
        assert!(side.curve().form().is_none());
    }

    #[test]
    fn loops_must_close_and_stay_inside() {
        let outer = triangle([[0.1, 0.1], [1.9, 0.1], [0.1, 1.9]]);
        let hole = triangle([[0.2, 0.2], [0.5, 0.2], [0.2, 0.5]]);
        let region = Region { outer: outer.clone(), holes: vec![hole.clone()] };
        let trimmed =
            Trimmed::new(square(), vec![region], vec![outer[..2].to_vec()], vec![[1.0, 0.5]]).unwrap();
        assert_eq!(trimmed.loops().count(), 2);
        let check = |outer: Vec<ParameterCurve>, says: &str| {
            let region = Region { outer, holes: vec![] };
            let error = Trimmed::new(square(), vec![region], vec![], vec![]).unwrap_err().to_string();
            assert!(error.contains(says), "{error}");
        };
        check(outer[..2].to_vec(), "does not close");
        check(vec![outer[0].clone(), outer[2].clone(), outer[1].clone()], "torn");
        check(triangle([[0.1, 0.1], [2.1, 0.1], [0.1, 1.9]]), "outside the domain");
        assert!(Trimmed::new(square(), vec![], vec![vec![]], vec![]).is_err());
        assert!(Trimmed::new(square(), vec![], vec![], vec![[0.0, f64::NAN]]).is_err());
        // A gap that printing with six digits leaves is none.
        let mut printed = outer;
        printed[2] = line([0.100_001, 1.9], [0.1, 0.1]);
        Trimmed::new(square(), vec![Region { outer: printed, holes: vec![] }], vec![], vec![]).unwrap();
    }

    #[test]
    fn parameter_curves_are_plane_and_run_forwards() {
        let lifted = Curve::line(Point::new(0.0, 0.0, 0.0), Point::new(1.0, 0.0, 1.0)).unwrap();
        assert!(ParameterCurve::whole(lifted).is_err());
        let flat = Curve::line(Point::origin(), Point::new(1.0, 0.0, 0.0)).unwrap();
        let (a, b) = flat.domain();
        for (from, to) in [(b, a), (a, a), (a - 1.0, b), (a, f64::NAN)] {
            assert!(ParameterCurve::new(flat.clone(), from, to).is_err(), "{from} {to}");
        }
        let middle = a + 0.5 * (b - a);
        assert_eq!(ParameterCurve::new(flat, a, middle).unwrap().ends().unwrap(), [[0.0, 0.0], [0.5, 0.0]]);
    }
}

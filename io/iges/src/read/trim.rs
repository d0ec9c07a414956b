//! Trimmed (144) and bounded (143) surfaces: by their parameter curves where these say the same as the model curves, else by the
//! model curves, as they are.

use loftsman_kernel::Point;
use loftsman_kernel::brep::{Brep, SurfaceForm};
use loftsman_kernel::scene::Geometry;
use loftsman_kernel::spline::trimmed::{ParameterCurve, Region};
use loftsman_kernel::spline::{Curve, Surface, Trimmed};

use super::curve::Run;
use super::entity::{At, Got, Problem, Reader};
use super::face::OneFace;
use super::pace::Pace;
use super::surface::{Sheet, Whole};

/// A closed boundary as the file has it.
pub(crate) struct Boundary {
    /// Its curves in the parameters of the surface; none where there are no such.
    pub(super) parameters: Vec<Run>,
    /// Its curves in space, each from where the one before ends.
    pub(super) model: Vec<Run>,
    pub(super) place: usize,
}

/// How far curves of both kinds may be apart, as a part of the size of the boundary.
const AGREE: f64 = 1e-4;
/// At so many places of each parameter curve both are compared.
const PLACES: usize = 8;

impl Reader<'_, '_> {
    /// A trimmed surface (144) or a bounded one (143).
    pub(crate) fn trimmed(&self, place: usize) -> Got<Geometry> {
        let entity = self.of(place, &[143, 144], "a trimmed surface (144, 143)")?;
        let (surface, outer, inner) = if entity.entry.kind == 144 {
            let has_outer = entity.whole(2)? != 0;
            let count = entity.count(3, 1)?;
            (
                entity.pointer(1)?,
                if has_outer { vec![entity.pointer(4)?] } else { Vec::new() },
                entity.pointers(5, count)?,
            )
        } else {
            let mut all = entity.pointers(4, entity.count(3, 1)?)?;
            let inner = all.split_off(all.len().min(1));
            (entity.pointer(2)?, all, inner)
        };
        let sheet = self.sheet(surface, 0)?;
        let outer: Vec<Boundary> = outer.into_iter().map(|at| self.boundary(at)).collect::<Got<_>>()?;
        let inner: Vec<Boundary> = inner.into_iter().map(|at| self.boundary(at)).collect::<Got<_>>()?;
        let geometry = match sheet {
            Sheet::Whole(whole) => match self.by_parameters(&whole, &outer, &inner)? {
                Ok(trimmed) => Geometry::from(trimmed),
                Err(why) => {
                    if let Some(trimmed) = self.without_model(&whole, (&outer, &inner), place)? {
                        return self.put(trimmed.into(), place);
                    }
                    let open =
                        outer.iter().find_map(|boundary| self.gap(boundary).transpose()).transpose()?;
                    match open {
                        // What does not close bounds nothing: surfaces by themselves are told apart from parts of them.
                        Some(gap) if inner.is_empty() => {
                            let gap = self.told(gap);
                            self.change(
                                place,
                                &format!("its boundary does not close, by {gap}: the whole surface is kept"),
                            );
                            whole.surface.into()
                        }
                        _ => self.by_model(&Sheet::Whole(whole), &outer, &inner, place, &why)?.into(),
                    }
                }
            },
            Sheet::Elementary(SurfaceForm::Plane { frame }) => {
                self.in_plane(&frame, (&outer, &inner), place)?.into()
            }
            sheet => self.by_model(&sheet, &outer, &inner, place, "the surface has none")?.into(),
        };
        self.put(geometry, place)
    }

    /// What is there where the file places it.
    fn put(&self, geometry: Geometry, place: usize) -> Got<Geometry> {
        let Some(map) = self.placed(place)? else { return Ok(geometry) };
        geometry.transformed(&map).at(place)
    }

    /// By how much a boundary does not close, where that is far from nothing.
    fn gap(&self, boundary: &Boundary) -> Got<Option<f64>> {
        let (Some(first), Some(last)) = (boundary.model.first(), boundary.model.last()) else {
            return Ok(None);
        };
        let start = first.curve.point(first.curve.domain().0).at(boundary.place)?;
        let end = last.curve.point(last.curve.domain().1).at(boundary.place)?;
        let points = boundary.model.iter().flat_map(|run| run.curve.points());
        let size = points.map(|p| (p - start).amax()).fold(0.0, f64::max);
        let gap = nalgebra::distance(&start, &end);
        Ok((gap > self.near(1e4 * size)).then_some(gap))
    }

    /// A plane (108) that a closed curve bounds.
    pub(crate) fn bounded_plane(&self, place: usize) -> Got<Geometry> {
        let entity = self.entity(place)?;
        let Some(boundary) = entity.pointed(5)? else {
            return Err(Problem::new(place, "a bounded plane without its boundary"));
        };
        let mut model = self.parts(boundary, 0)?;
        let sheet = self.sheet(place, 0)?;
        // The curve is in the coordinates of the plane, which its matrix places.
        if let Some(map) = self.placed(place)? {
            for run in &mut model {
                run.curve = super::place::moved_curve(run.curve.clone(), &map, boundary)?;
            }
        }
        let outer = [Boundary { parameters: Vec::new(), model, place: boundary }];
        match sheet {
            Sheet::Elementary(SurfaceForm::Plane { frame }) => {
                Ok(self.in_plane(&frame, (&outer, &[]), place)?.into())
            }
            _ => Err(Problem::new(place, "a plane that is none")),
        }
    }

    /// A curve on a surface (142) or a boundary (141).
    pub(crate) fn boundary(&self, place: usize) -> Got<Boundary> {
        let entity = self.of(place, &[141, 142], "a boundary (142, 141)")?;
        let (mut parameters, mut model) = (Vec::new(), Vec::new());
        if entity.entry.kind == 142 {
            if let Some(of) = entity.pointed(3)? {
                parameters = self.parts(of, 0)?;
            }
            if let Some(of) = entity.pointed(4)? {
                model = self.parts(of, 0)?;
            }
        } else {
            let mut at = 5;
            let mut all_have = true;
            for _ in 0..entity.count(4, 3)? {
                let curve = entity.pointer(at)?;
                let (backwards, count) = (entity.whole(at + 1)? == 2, entity.count(at + 2, 1)?);
                let mut parts = self.parts(curve, 0)?;
                if backwards {
                    parts.reverse();
                    parts = parts.into_iter().map(|run| turned_round(run, curve)).collect::<Got<_>>()?;
                }
                model.extend(parts);
                for of in entity.pointers(at + 3, count)? {
                    parameters.extend(self.parts(of, 0)?);
                }
                all_have &= count > 0;
                at += 3 + count;
            }
            if !all_have {
                parameters.clear();
            }
        }
        if parameters.is_empty() && model.is_empty() {
            return Err(Problem::new(place, "a boundary without curves"));
        }
        Ok(Boundary { parameters, model, place })
    }

    /// The surface with its parameter curves, or why they do not serve.
    fn by_parameters(
        &self,
        whole: &Whole,
        outer: &[Boundary],
        inner: &[Boundary],
    ) -> Got<Result<Trimmed, String>> {
        let mut laid = Vec::new();
        for boundary in outer.iter().chain(inner) {
            if boundary.parameters.is_empty() {
                return Ok(Err("a boundary has no parameter curves".to_owned()));
            }
            let Some(curves) = self.laid_out(whole, boundary)? else {
                return Ok(Err("a parameter curve runs askew over angles".to_owned()));
            };
            let (off, near) = self.off_model(&whole.surface, &curves, boundary)?;
            if off > near {
                let off = self.told(off);
                return Ok(Err(format!("a parameter curve is {off} off its model curve")));
            }
            laid.push(curves);
        }
        let holes = laid.split_off(outer.len());
        let region = Region { outer: laid.pop().unwrap_or_default(), holes };
        let regions = if region.outer.is_empty() && region.holes.is_empty() { vec![] } else { vec![region] };
        Ok(Trimmed::new(whole.surface.clone(), regions, vec![], vec![]).map_err(|error| error.to_string()))
    }

    /// The parameter curves of a boundary in the parameters of the spline, where they are of the same kind there.
    fn laid_out(&self, whole: &Whole, boundary: &Boundary) -> Got<Option<Vec<ParameterCurve>>> {
        let mut all = Vec::new();
        for run in &boundary.parameters {
            let Some(curve) = laid(&run.curve, whole).at(boundary.place)? else { return Ok(None) };
            all.push(ParameterCurve::whole(curve).at(boundary.place)?);
        }
        Ok(Some(all))
    }

    /// How far parameter curves are off the model curves, if there are any, and how far they may be.
    pub(super) fn off_model(
        &self,
        surface: &Surface,
        curves: &[ParameterCurve],
        boundary: &Boundary,
    ) -> Got<(f64, f64)> {
        if boundary.model.is_empty() {
            return Ok((0.0, 0.0));
        }
        let first = boundary.model[0].curve.points()[0];
        let points = boundary.model.iter().flat_map(|run| run.curve.points());
        let size = points.map(|p| (p - first).amax()).fold(0.0, f64::max);
        let near = self.file.global.resolution.max(AGREE * size);
        let inside =
            |space: &loftsman_kernel::spline::Space, t: f64| t.clamp(space.domain().0, space.domain().1);
        let mut worst = 0.0_f64;
        // Of long boundaries a part is enough.
        let step = curves.len().div_ceil(64).max(1);
        for one in curves.iter().step_by(step) {
            let (from, to) = one.range();
            for k in 0..=PLACES {
                let p =
                    one.curve().point(from + (to - from) * (k as f64 / PLACES as f64)).at(boundary.place)?;
                let (u, v) = (inside(surface.u(), p.x), inside(surface.v(), p.y));
                let at = surface.point(u, v).at(boundary.place)?;
                let mut off = f64::INFINITY;
                for run in &boundary.model {
                    off = off.min(run.curve.closest(at).at(boundary.place)?.distance);
                    if off <= near {
                        break;
                    }
                }
                worst = worst.max(off);
            }
        }
        Ok((worst, near))
    }

    /// The part of a plane within model curves, which are parameter curves there.
    fn in_plane(
        &self,
        frame: &loftsman_kernel::brep::Frame,
        (outer, inner): (&[Boundary], &[Boundary]),
        place: usize,
    ) -> Got<Trimmed> {
        let plane = |p: &Point| {
            let d = p - frame.origin;
            Point::new(d.dot(&frame.x), d.dot(&frame.y()), d.dot(&frame.z))
        };
        let mut points = Vec::new();
        let mut laid = Vec::new();
        for boundary in outer.iter().chain(inner) {
            if boundary.model.is_empty() {
                return Err(Problem::new(
                    boundary.place,
                    "a boundary on a plane without parameters has no model curve",
                ));
            }
            let mut curves = Vec::new();
            for run in &boundary.model {
                let (space, net, weights) = run.curve.clone().into_parts();
                let size = net.iter().map(|p| (p - net[0]).amax()).fold(0.0, f64::max);
                let off = net.iter().map(|p| plane(p).z.abs()).fold(0.0, f64::max);
                let reach = net.iter().map(|p| p.coords.amax()).fold(size, f64::max);
                if off > self.near(10.0 * reach) {
                    let text = format!("a boundary is up to {} off its plane", self.told(off));
                    return Err(Problem::new(boundary.place, text));
                }
                let flat = net.iter().map(plane).map(|p| Point::new(p.x, p.y, 0.0)).collect();
                points.extend(net);
                let curve = Curve::build(space, flat, weights).and_then(ParameterCurve::whole);
                curves.push(curve.at(boundary.place)?);
            }
            laid.push(curves);
        }
        let holes = laid.split_off(outer.len());
        let region = Region { outer: laid.pop().unwrap_or_default(), holes };
        if region.outer.is_empty() {
            return Err(Problem::new(place, "a plane without ends that has no outer boundary"));
        }
        let surface = SurfaceForm::Plane { frame: *frame }.covering(&points).at(place)?;
        Trimmed::new(surface, vec![region], vec![], vec![]).at(place)
    }

    /// A Brep of one face, whose edges are the model curves.
    fn by_model(
        &self,
        sheet: &Sheet,
        outer: &[Boundary],
        inner: &[Boundary],
        place: usize,
        why: &str,
    ) -> Got<Brep> {
        if outer.is_empty() {
            let text =
                format!("it has no outer boundary, and inner ones cannot be cut out by parameters: {why}");
            return Err(Problem::new(place, text));
        }
        let mut face = OneFace::new(self, place);
        for (k, boundary) in outer.iter().chain(inner).enumerate() {
            if boundary.model.is_empty() {
                let text = format!("{why}, and there are no model curves");
                return Err(Problem::new(boundary.place, text));
            }
            face.add(&boundary.model, k == 0, boundary.place)?;
        }
        face.finish(sheet)
    }
}

/// A curve run through from its end.
fn turned_round(run: Run, place: usize) -> Got<Run> {
    use loftsman_kernel::brep::{CurveForm, Frame};
    let round = |frame: Frame| Frame { z: -frame.z, ..frame };
    let form = match run.form {
        CurveForm::Circle { frame, radius } => CurveForm::Circle { frame: round(frame), radius },
        CurveForm::Ellipse { frame, radii } => CurveForm::Ellipse { frame: round(frame), radii },
        form => form,
    };
    let curve = run.curve.reverse().at(place)?;
    Ok(Run::spline(curve, form))
}

/// A parameter curve of the file in the parameters of the spline: where both run alike, or it runs along one of the parameters.
pub(super) fn laid(curve: &Curve, whole: &Whole) -> loftsman_kernel::Result<Option<Curve>> {
    let [u, v] = &whole.paces;
    let own = |p: &Point| if whole.swapped { [p.y, p.x] } else { [p.x, p.y] };
    let (space, points, weights) = curve.clone().into_parts();
    let points: Vec<[f64; 2]> = points.iter().map(own).collect();
    let steady = |k: usize, pace: &Pace| {
        let [from, to] = pace.range();
        points.iter().all(|p| (p[k] - points[0][k]).abs() <= 1e-9 * (to - from))
    };
    // A parameter by its pace: evenly for all points, or of the ends alone.
    let turns = |k: usize, pace: &Pace| {
        let ends = [points[0][k], points[points.len() - 1][k]];
        [0.0, 1.0, -1.0].into_iter().find_map(|turns| {
            let shift = turns * std::f64::consts::TAU;
            Some([pace.at(ends[0] + shift)?, pace.at(ends[1] + shift)?])
        })
    };
    let pick = |k: usize, pace: &Pace| -> Option<Along> {
        if let Some([factor, shift]) = pace.affine() {
            return Some(Along::Even(factor, shift));
        }
        let ends = turns(k, pace)?;
        if steady(k, pace) {
            return Some(Along::Ends([ends[0]; 2]));
        }
        // What comes back to where it starts is no line along an angle.
        (ends[0] != ends[1]).then_some(Along::Ends(ends))
    };
    let (Some(along_u), Some(along_v)) = (pick(0, u), pick(1, v)) else { return Ok(None) };
    let value = |along: &Along, k: usize, p: &[f64; 2]| match along {
        Along::Even(factor, shift) => factor * p[k] + shift,
        Along::Ends([from, _]) => *from,
    };
    if along_u.is_steady() && along_v.is_steady() {
        let net = points.iter().map(|p| Point::new(value(&along_u, 0, p), value(&along_v, 1, p), 0.0));
        return Curve::build(space, net.collect(), weights).map(Some);
    }
    // Along an angle: straight in the plane, so straight in that of the spline too, at another speed.
    let other_steady = |k: usize| if k == 0 { steady(1, v) } else { steady(0, u) };
    let moving = usize::from(along_u.is_steady());
    if !other_steady(moving) {
        return Ok(None);
    }
    let end = |last: bool| {
        let p = if last { &points[points.len() - 1] } else { &points[0] };
        let at = |along: &Along, k: usize| match along {
            Along::Ends(ends) => ends[usize::from(last)],
            Along::Even(..) => value(along, k, p),
        };
        Point::new(at(&along_u, 0), at(&along_v, 1), 0.0)
    };
    Curve::line(end(false), end(true)).map(Some)
}

/// How a parameter of a curve becomes that of the spline.
enum Along {
    /// Factor and shift.
    Even(f64, f64),
    /// At the start and at the end.
    Ends([f64; 2]),
}

impl Along {
    /// Whether it maps all control points alike.
    fn is_steady(&self) -> bool {
        match self {
            Self::Even(..) => true,
            Self::Ends([from, to]) => from == to,
        }
    }
}

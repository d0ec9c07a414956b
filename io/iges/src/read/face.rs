//! A face by itself: its edges are the curves around it.

use loftsman_kernel::brep::{Brep, CurveForm, Edge, Face, Parts, SurfaceForm, Use, Vertex};
use loftsman_kernel::spline::{Curve, Surface};
use loftsman_kernel::{Point, Vector};

use super::curve::Run;
use super::entity::{At, Got, Problem, Reader};
use super::surface::Sheet;
use super::turned::turned;

/// In loops of so many curves at most, seams are looked for: curves that are run through twice.
const SEAMS: usize = 64;
/// At so many places of a boundary at most its distance from the surface is measured.
const MEASURED: usize = 256;
/// Placements of what is one differ by less in files, as directions.
const ROUNDING: f64 = 1e-6;
/// So many places of each curve say which way a loop turns.
const PLACES: usize = 8;

/// A Brep of one face, in the making.
pub(crate) struct OneFace<'a, 'r, 'f> {
    reader: &'a Reader<'r, 'f>,
    place: usize,
    parts: Parts,
    /// Each loop, and whether it is the outer one.
    loops: Vec<(Vec<Use>, bool)>,
}

impl<'a, 'r, 'f> OneFace<'a, 'r, 'f> {
    pub(crate) fn new(reader: &'a Reader<'r, 'f>, place: usize) -> Self {
        Self { reader, place, parts: Parts::default(), loops: Vec::new() }
    }

    /// A loop of curves, each of which starts where the one before ends.
    pub(crate) fn add(&mut self, runs: &[Run], outer: bool, place: usize) -> Got<()> {
        let ends = |run: &Run| -> loftsman_kernel::Result<[Point; 2]> {
            let (a, b) = run.curve.domain();
            Ok([run.curve.point(a)?, run.curve.point(b)?])
        };
        let all: Vec<[Point; 2]> = runs.iter().map(ends).collect::<Result<_, _>>().at(place)?;
        let Some(first) = all.first().map(|ends| ends[0]) else {
            return Err(Problem::new(place, "a boundary without curves"));
        };
        let points = runs.iter().flat_map(|run| run.curve.points());
        let size = points.map(|p| (p - first).amax()).fold(0.0, f64::max);
        // Neighbours that meet within this are one boundary; by how much they do not is kept as the vertex's tolerance.
        let near = self.reader.near(100.0 * size);
        let mut corners: Vec<usize> = Vec::with_capacity(all.len());
        for (k, [start, _]) in all.iter().enumerate() {
            let before = all[(k + all.len() - 1) % all.len()][1];
            let gap = nalgebra::distance(&before, start);
            if gap > near {
                let text = format!(
                    "the boundary is torn before curve {} of {}: the one before ends {} away",
                    k + 1,
                    all.len(),
                    self.reader.told(gap)
                );
                return Err(Problem::new(place, text));
            }
            let known = (all.len() <= SEAMS).then(|| {
                corners
                    .iter()
                    .copied()
                    .find(|&c| nalgebra::distance(&self.parts.vertices[c].point, start) <= near)
            });
            let corner = known.flatten().unwrap_or_else(|| {
                self.parts.vertices.push(Vertex { point: *start, tolerance: 0.0 });
                self.parts.vertices.len() - 1
            });
            let vertex = &mut self.parts.vertices[corner];
            let off =
                nalgebra::distance(&vertex.point, start).max(nalgebra::distance(&vertex.point, &before));
            vertex.tolerance = vertex.tolerance.max(off);
            corners.push(corner);
        }
        let mut chain: Vec<Use> = Vec::with_capacity(runs.len());
        let from = self.parts.edges.len();
        for (k, run) in runs.iter().enumerate() {
            let ends = [corners[k], corners[(k + 1) % corners.len()]];
            let places = quarters(&run.curve, run.curve.domain()).at(place)?;
            let known = (runs.len() <= SEAMS).then(|| {
                (from..self.parts.edges.len()).find(|&edge| {
                    let edge = &self.parts.edges[edge];
                    // Of those that close only places between tell which way they run.
                    let run_back = |found: [Point; 3]| {
                        let pairs = found.iter().rev().zip(&places);
                        let mut apart = pairs.map(|(a, b)| nalgebra::distance(a, b));
                        if ends[0] == ends[1] {
                            apart.all(|d| d <= near)
                        } else {
                            apart.nth(1).is_some_and(|d| d <= near)
                        }
                    };
                    edge.ends == [ends[1], ends[0]] && quarters(&edge.curve, edge.range).is_ok_and(run_back)
                })
            });
            if let Some(edge) = known.flatten() {
                chain.push(Use { edge, reversed: true, parameters: None });
                continue;
            }
            self.parts.edges.push(Edge {
                curve: run.curve.clone(),
                range: run.curve.domain(),
                ends,
                tolerance: self.reader.file.global.resolution,
                form: run.form,
            });
            chain.push(Use { edge: self.parts.edges.len() - 1, reversed: false, parameters: None });
        }
        self.loops.push((chain, outer));
        Ok(())
    }

    /// The face on a surface.
    pub(crate) fn finish(mut self, sheet: &Sheet) -> Got<Brep> {
        let (mut points, mut reach) = (Vec::new(), Vec::new());
        for edge in &self.parts.edges {
            reach.extend(edge.reach().at(self.place)?);
            let (from, to) = edge.range;
            let steps = 8 * edge.curve.space().spans().count();
            for k in 0..=steps {
                let t = from + (to - from) * (k as f64 / steps as f64);
                points.push(edge.curve.point(t).at(self.place)?);
            }
        }
        let mut covering = sheet.covering(&reach, self.place)?;
        self.to_seams(&mut covering.form).at(self.place)?;
        self.tell_distance(&points, &covering.surface).at(self.place)?;
        let closed = closes(&covering.surface).at(self.place)?;
        let (mut loops, mut outers) = (Vec::new(), Vec::new());
        for (mut chain, outer) in std::mem::take(&mut self.loops) {
            self.along_seams(&mut chain, &covering.surface, covering.reversed).at(self.place)?;
            // Loops run counterclockwise around the face as seen against its normal: files have them either way.
            if !closed
                && (self.area(&chain, &covering.surface).at(self.place)? > 0.0)
                    != (outer != covering.reversed)
            {
                chain.reverse();
                chain.iter_mut().for_each(|one| one.reversed = !one.reversed);
            }
            loops.push(chain);
            outers.push(outer);
        }
        self.parts.faces.push(Face {
            name: None,
            color: None,
            surface: covering.surface,
            form: covering.form,
            reversed: covering.reversed,
            loops,
            points: Vec::new(),
        });
        let mut brep = Brep::new(self.parts).at(self.place)?;
        if closed {
            brep = turned(brep, &outers).at(self.place)?;
        }
        if let Some(told) = brep.loops_told(0, false).at(self.place)? {
            self.reader.change(self.place, &told);
        }
        Ok(brep)
    }

    /// Says where edges are far from the surface: files that were deformed have such.
    fn tell_distance(&self, points: &[Point], surface: &Surface) -> loftsman_kernel::Result<()> {
        let Some(first) = points.first() else { return Ok(()) };
        let size = points.iter().map(|p| (p - first).amax()).fold(0.0, f64::max);
        let step = points.len().div_ceil(MEASURED).max(1);
        let mut worst = 0.0_f64;
        for point in points.iter().step_by(step) {
            worst = worst.max(surface.closest(*point)?.distance);
        }
        if worst > self.reader.near(100.0 * size) {
            let off = self.reader.told(worst);
            self.reader
                .change(self.place, &format!("its boundary is up to {off} off its surface: kept as it is"));
        }
        Ok(())
    }

    /// Turns what a surface is by rounding, so that it closes just where an edge runs there and back: a file has the placement of the one and of the other to
    /// ten digits, and what is beside the seam by the last of them, programs take for a turn away.
    fn to_seams(&self, form: &mut SurfaceForm) -> loftsman_kernel::Result<()> {
        let is_sphere = matches!(form, SurfaceForm::Sphere { .. });
        let (SurfaceForm::Cylinder { frame, .. }
        | SurfaceForm::Cone { frame, .. }
        | SurfaceForm::Sphere { frame, .. }
        | SurfaceForm::Torus { frame, .. }) = form
        else {
            return Ok(());
        };
        let mut uses = vec![0; self.parts.edges.len()];
        self.loops.iter().flat_map(|(chain, _)| chain).for_each(|one| uses[one.edge] += 1);
        for (edge, _) in self.parts.edges.iter().zip(&uses).filter(|(_, uses)| **uses == 2) {
            let mut axis = frame.z;
            // A sphere is one about any axis: that in the plane of the circle, too.
            if let (true, CurveForm::Circle { frame: circle, .. }) = (is_sphere, edge.form) {
                axis = (axis - circle.z * circle.z.dot(&axis)).try_normalize(0.5).unwrap_or(axis);
            }
            let away = |point: &Point| {
                let way = point - frame.origin;
                way - axis * axis.dot(&way)
            };
            let [a, b, c] = quarters(&edge.curve, edge.range)?.map(|point| away(&point));
            let Some(x) = b.try_normalize(0.0) else { continue };
            let along = |way: &Vector| (way - x * x.dot(way)).norm() <= ROUNDING * way.norm();
            if along(&a)
                && along(&c)
                && (x - frame.x).norm() <= ROUNDING
                && (axis - frame.z).norm() <= ROUNDING
            {
                (frame.x, frame.z) = (x, axis);
                return Ok(());
            }
        }
        Ok(())
    }

    /// Puts both seams of a surface that closes both ways in the order in which its border runs along them counterclockwise: as all four end in one point, any
    /// order is a chain, and files have them in any. There and back at once they bound nothing.
    fn along_seams(
        &self,
        chain: &mut [Use],
        surface: &Surface,
        reversed: bool,
    ) -> loftsman_kernel::Result<()> {
        let [a, b, c, d] = &chain[..] else { return Ok(()) };
        let back = |one: &Use, other: &Use| one.edge == other.edge && one.reversed != other.reversed;
        let [one, other] = if back(a, b) && back(c, d) {
            [a.clone(), c.clone()]
        } else if back(b, c) && back(d, a) {
            [b.clone(), d.clone()]
        } else if back(a, c) && back(b, d) {
            [a.clone(), b.clone()]
        } else {
            return Ok(());
        };
        if one.edge == other.edge {
            return Ok(());
        }
        let way = |one: &Use| -> loftsman_kernel::Result<[Vector; 2]> {
            let edge = &self.parts.edges[one.edge];
            let (at, sign) = if one.reversed { (edge.range.1, -1.0) } else { (edge.range.0, 1.0) };
            Ok([edge.curve.point(at)?.coords, edge.curve.derivative(at, 1)? * sign])
        };
        let ([place, along], [_, across]) = (way(&one)?, way(&other)?);
        let (u, v) = surface.closest(Point::from(place))?.at;
        let normal = surface.derivative(u, v, 1, 0)?.cross(&surface.derivative(u, v, 0, 1)?);
        // Counterclockwise: along one side, up the other, and back along both.
        let (first, second) =
            if (along.cross(&across).dot(&normal) > 0.0) == reversed { (other, one) } else { (one, other) };
        let turned = |one: &Use| Use { reversed: !one.reversed, ..one.clone() };
        chain.clone_from_slice(&[first.clone(), second.clone(), turned(&first), turned(&second)]);
        Ok(())
    }

    /// The signed area of a loop in the parameter plane of a surface that does not close.
    fn area(&self, chain: &[Use], surface: &Surface) -> loftsman_kernel::Result<f64> {
        let mut all: Vec<Vector> = Vec::new();
        for one in chain {
            let edge = &self.parts.edges[one.edge];
            let (from, to) = edge.range;
            for k in 0..PLACES {
                let share = k as f64 / PLACES as f64;
                let share = if one.reversed { 1.0 - share } else { share };
                let at = surface.closest(edge.curve.point(from + (to - from) * share)?)?.at;
                all.push(Vector::new(at.0, at.1, 0.0));
            }
        }
        let next = all.iter().skip(1).chain(all.first());
        let twice: f64 = all.iter().zip(next).map(|(a, b)| a.x * b.y - a.y * b.x).sum();
        Ok(0.5 * twice)
    }
}

/// The points at a quarter, the half and three quarters of a part of a curve.
fn quarters(curve: &Curve, (a, b): (f64, f64)) -> loftsman_kernel::Result<[Point; 3]> {
    Ok([curve.point(a + 0.25 * (b - a))?, curve.point(0.5 * (a + b))?, curve.point(a + 0.75 * (b - a))?])
}

/// Whether two opposite borders of a surface are one.
fn closes(surface: &Surface) -> loftsman_kernel::Result<bool> {
    if surface.u().is_periodic() || surface.v().is_periodic() {
        return Ok(true);
    }
    let ((a, b), (c, d)) = (surface.u().domain(), surface.v().domain());
    let first = surface.points()[0];
    let size = surface.points().iter().map(|p| (p - first).amax()).fold(0.0, f64::max);
    let (mut along_u, mut along_v) = (true, true);
    for share in [0.21, 0.5, 0.83] {
        let (u, v) = (a + share * (b - a), c + share * (d - c));
        along_u &= nalgebra::distance(&surface.point(a, v)?, &surface.point(b, v)?) <= 1e-6 * size;
        along_v &= nalgebra::distance(&surface.point(u, c)?, &surface.point(u, d)?) <= 1e-6 * size;
    }
    Ok(along_u || along_v)
}

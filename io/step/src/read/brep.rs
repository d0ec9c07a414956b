//! Solids and shells: from faces, loops and edges of the file to the parts of a Brep.

use std::collections::HashMap;

use loftsman_kernel::brep::{Brep, Edge, Face, Flaw, Parts, Shell, Solid, SurfaceForm, Use, Vertex};
use loftsman_kernel::spline::{Curve, Surface};
use loftsman_kernel::{Point, Vector};

use super::entity::{At, Got, Problem, deeper};
use super::parameters::Origin;
use super::place::Space;
use super::spline::{SURFACES, is_one};
use super::style::Styles;
use super::surface::Sheet;

/// What is said of what names something that is left out.
const LEFT_OUT: &str = " in it is left out";

/// What is made of one solid or surface model.
pub(crate) struct Model {
    pub(crate) brep: Brep,
    /// The entities that are in it with all that they name, and those that are in it themselves.
    pub(crate) whole: Vec<u64>,
    pub(crate) alone: Vec<u64>,
    /// The parameter curves that are in it.
    pub(crate) parameters: Vec<u64>,
    /// What of it is left out, and why.
    pub(crate) problems: Vec<Problem>,
    /// What is to be said of it.
    pub(crate) notes: Vec<String>,
}

/// The parts of one Brep, as they are found.
pub(crate) struct Builder<'r, 'f> {
    pub(super) space: Space<'r, 'f>,
    styles: &'r Styles,
    pub(super) parts: Parts,
    vertices: HashMap<u64, usize>,
    /// Of each EDGE_CURVE the edge, and whether that runs the other way.
    edges: HashMap<u64, (usize, bool)>,
    /// Where the curves of edges come from.
    pub(super) origins: HashMap<usize, Origin>,
    /// Edges between points of polygons.
    segments: HashMap<[usize; 2], usize>,
    whole: Vec<u64>,
    alone: Vec<u64>,
    parameters: Vec<u64>,
    problems: Vec<Problem>,
    pub(super) notes: Vec<String>,
}

/// Whether an entity of this type is a solid, a surface model, a shell or a face: what becomes one Brep.
pub(crate) fn is_model(kind: &[u8]) -> bool {
    matches!(
        kind,
        b"MANIFOLD_SOLID_BREP"
            | b"FACETED_BREP"
            | b"BREP_WITH_VOIDS"
            | b"SHELL_BASED_SURFACE_MODEL"
            | b"FACE_BASED_SURFACE_MODEL"
            | b"CLOSED_SHELL"
            | b"OPEN_SHELL"
            | b"CONNECTED_FACE_SET"
            | b"ADVANCED_FACE"
            | b"FACE_SURFACE"
    )
}

impl<'r, 'f> Builder<'r, 'f> {
    /// The Brep of an entity that [is one](is_model).
    pub(crate) fn build(space: Space<'r, 'f>, styles: &'r Styles, number: u64) -> Got<Model> {
        let mut builder = Self {
            space,
            styles,
            parts: Parts::default(),
            vertices: HashMap::new(),
            edges: HashMap::new(),
            origins: HashMap::new(),
            segments: HashMap::new(),
            whole: Vec::new(),
            alone: vec![number],
            parameters: Vec::new(),
            problems: Vec::new(),
            notes: Vec::new(),
        };
        builder.model(number)?;
        builder.finish(number)
    }

    fn model(&mut self, number: u64) -> Got<()> {
        let entity = self.space.entity(number)?;
        let args = entity.args();
        match entity.only() {
            b"MANIFOLD_SOLID_BREP" | b"FACETED_BREP" | b"BREP_WITH_VOIDS" => {
                let mut shells = vec![args.reference(1)?];
                // Files that were written here have a solid's own name in its shell, as the item has that of the object.
                let called = if self.space.file.header.system == crate::SYSTEM {
                    self.space.entity(shells[0])?.args().name(0)
                } else {
                    args.name(0)
                };
                if entity.only() == b"BREP_WITH_VOIDS" {
                    shells.extend(args.references(2)?);
                }
                let first = self.parts.shells.len();
                let before = self.problems.len();
                for shell in shells {
                    self.shell(shell, false, 0)?;
                }
                let found = first..self.parts.shells.len();
                let whole = before == self.problems.len() && !found.is_empty();
                let closed = whole && self.parts.shells[found.clone()].iter().all(|s| self.closes(s));
                if closed {
                    let name = Some(called).filter(|name| !name.is_empty());
                    let voids = (first + 1..found.end).collect();
                    self.parts.solids.push(Solid { name, outer: first, voids });
                } else {
                    let why = if whole { "its shell does not close" } else { "a face of it is left out" };
                    self.notes.push(format!("#{number}: the solid is kept as a shell: {why}"));
                }
                Ok(())
            }
            b"SHELL_BASED_SURFACE_MODEL" | b"FACE_BASED_SURFACE_MODEL" => {
                for shell in args.references(1)? {
                    if let Err(problem) = self.shell(shell, false, 0) {
                        self.problems.push(problem);
                    }
                }
                Ok(())
            }
            b"ADVANCED_FACE" | b"FACE_SURFACE" => {
                let face = self.face(number, false, 0)?;
                self.parts.faces.push(face);
                self.whole.push(number);
                Ok(())
            }
            _ => self.shell(number, false, 0),
        }
    }

    fn shell(&mut self, number: u64, turned: bool, depth: usize) -> Got<()> {
        let depth = deeper(number, depth)?;
        let entity = self.space.entity(number)?;
        let args = entity.args();
        self.alone.push(number);
        match entity.only() {
            b"ORIENTED_CLOSED_SHELL" | b"ORIENTED_OPEN_SHELL" => {
                let along = args.flag(3)?;
                self.shell(args.reference(2)?, turned == along, depth)
            }
            b"CLOSED_SHELL" | b"OPEN_SHELL" | b"CONNECTED_FACE_SET" => {
                let mut shell = Shell::default();
                let mut numbers = Vec::new();
                for number in args.references(1)? {
                    match self.face(number, turned, 0) {
                        Ok(face) => {
                            shell.faces.push(self.parts.faces.len());
                            numbers.push(number);
                            self.parts.faces.push(face);
                            self.whole.push(number);
                        }
                        Err(problem) => {
                            if problem.number != number {
                                let text = format!("#{}{LEFT_OUT}", problem.number);
                                self.problems.push(Problem::new(number, text));
                            }
                            self.problems.push(problem);
                        }
                    }
                }
                if !shell.faces.is_empty() {
                    self.turn_loops(&shell, &numbers, turned);
                    self.parts.shells.push(shell);
                }
                Ok(())
            }
            _ => Err(Problem::new(
                number,
                format!(
                    "a shell is needed where it is named, and it is {}: name an OPEN_SHELL or a CLOSED_SHELL",
                    entity.kinds()
                ),
            )),
        }
    }

    fn face(&mut self, number: u64, turned: bool, depth: usize) -> Got<Face> {
        let depth = deeper(number, depth)?;
        let entity = self.space.entity(number)?;
        let args = entity.args();
        let kind = entity.only();
        match kind {
            b"ORIENTED_FACE" => {
                let along = args.flag(3)?;
                return self.face(args.reference(2)?, turned == along, depth);
            }
            b"ADVANCED_FACE" | b"FACE_SURFACE" | b"FACE" => {}
            _ => {
                return Err(Problem::new(
                    number,
                    format!(
                        "a face is needed where it is named, and it is {}: name an ADVANCED_FACE or a FACE_SURFACE",
                        entity.kinds()
                    ),
                ));
            }
        }
        let (mut loops, mut lone) = (Vec::new(), Vec::new());
        for bound in args.references(1)? {
            let bound = self.space.entity(bound)?;
            if !matches!(bound.only(), b"FACE_BOUND" | b"FACE_OUTER_BOUND") {
                let text = format!("{} is no bound of a face", bound.kinds());
                return Err(Problem::new(bound.number, text));
            }
            let (one, along) = (bound.args().reference(1)?, bound.args().flag(2)?);
            let mut chain = self.chain(one, &mut lone)?;
            if along == turned {
                chain.reverse();
                chain.iter_mut().for_each(|one| one.reversed = !one.reversed);
            }
            if !chain.is_empty() {
                self.check_chain(&chain, one)?;
                loops.push(chain);
            }
        }
        let (sheet, at, same) = if kind == b"FACE" {
            (self.plane_of(number, loops.first())?, number, true)
        } else {
            let at = args.reference(2)?;
            (self.space.sheet(at, 0)?, at, args.flag(3)?)
        };
        self.notes.extend(sheet.told(at));
        let ends = matches!(sheet, Sheet::Spline(_) | Sheet::Near(..) | Sheet::Turned(..));
        let points = if ends { Vec::new() } else { self.points_of(&loops, &lone).at(number)? };
        // Parameters are those of the file.
        let of = self.space.entity(at).ok();
        let own = of.is_some_and(|of| is_one(&of, &SURFACES) || of.only() == b"OFFSET_SURFACE");
        if let Sheet::Spline(surface) | Sheet::Near(surface, _) = &sheet
            && own
        {
            self.with_parameters((at, surface), turned, &mut loops);
        }
        let covering = sheet.covering(&points, at)?;
        let name = Some(args.name(0)).filter(|name| !name.is_empty());
        Ok(Face {
            name,
            color: self.styles.color(number),
            surface: covering.surface,
            form: covering.form,
            reversed: (same == turned) != covering.reversed,
            loops,
            points: lone,
        })
    }

    /// Gives the uses of a face on a B-spline surface the parameter curves that the file has. Where one cannot be read it is as if there were none.
    fn with_parameters(&mut self, surface: (u64, &Surface), turned: bool, loops: &mut [Vec<Use>]) {
        for one in loops.iter_mut().flatten() {
            let Some(&origin) = self.origins.get(&one.edge) else { continue };
            let reversed = one.reversed != turned;
            if let Ok(Some((curve, number))) = self.space.parameter_curve(origin, surface, reversed) {
                one.parameters = Some(curve);
                self.parameters.push(number);
            }
        }
    }

    /// The edges of a loop; a vertex alone goes to `lone`.
    fn chain(&mut self, number: u64, lone: &mut Vec<usize>) -> Got<Vec<Use>> {
        let entity = self.space.entity(number)?;
        let args = entity.args();
        match entity.only() {
            b"VERTEX_LOOP" => {
                lone.push(self.vertex(args.reference(1)?)?);
                Ok(Vec::new())
            }
            b"EDGE_LOOP" => {
                let edges = args.references(1)?;
                if edges.is_empty() {
                    return Err(Problem::new(
                        number,
                        "a loop without edges bounds nothing: name its edges, or leave the bound out",
                    ));
                }
                edges.into_iter().map(|one| self.oriented(one)).collect()
            }
            b"POLY_LOOP" => {
                let points = args.references(1)?;
                let corners: Vec<usize> =
                    points.into_iter().map(|point| self.corner(point)).collect::<Got<_>>()?;
                let next = corners.iter().skip(1).chain(corners.first());
                corners.iter().zip(next).map(|(&a, &b)| self.segment(a, b, number)).collect()
            }
            _ => Err(Problem::new(number, format!("{} is no loop that is read", entity.kinds()))),
        }
    }

    fn oriented(&mut self, number: u64) -> Got<Use> {
        let entity = self.space.entity(number)?;
        let args = entity.of("ORIENTED_EDGE")?;
        let along = args.flag(4)?;
        let (edge, reversed) = self.edge(args.reference(3)?)?;
        Ok(Use { edge, reversed: reversed == along, parameters: None })
    }

    fn edge(&mut self, number: u64) -> Got<(usize, bool)> {
        if let Some(&known) = self.edges.get(&number) {
            return Ok(known);
        }
        let entity = self.space.entity(number)?;
        let args = entity.of("EDGE_CURVE")?;
        let ends = [self.vertex(args.reference(1)?)?, self.vertex(args.reference(2)?)?];
        let points = ends.map(|end| self.parts.vertices[end].point);
        let geometry = args.reference(3)?;
        let (basis, along) = self.space.basis(geometry, 0)?;
        let along = along == args.flag(4)?;
        let size = points.iter().map(|p| (p - points[0]).amax()).fold(0.0, f64::max);
        let near = self.space.units.tolerance.max(1e-6 * size);
        let found = basis.edge(points, ends[0] == ends[1], along, near, number)?;
        if let Some(range) = basis.range_of(&found, along) {
            self.origins.insert(self.parts.edges.len(), Origin { curve: geometry, range });
        }
        let ends = if found.reversed { [ends[1], ends[0]] } else { ends };
        let tolerance = self.space.units.tolerance;
        let (curve, range, form) = (found.curve, found.range, found.form);
        self.parts.edges.push(Edge { curve, range, ends, tolerance, form });
        let known = (self.parts.edges.len() - 1, found.reversed);
        self.edges.insert(number, known);
        Ok(known)
    }

    fn vertex(&mut self, number: u64) -> Got<usize> {
        if let Some(&known) = self.vertices.get(&number) {
            return Ok(known);
        }
        let entity = self.space.entity(number)?;
        let point = entity.of("VERTEX_POINT")?.reference(1)?;
        let point = self.space.point(point)?;
        Ok(self.put(number, point))
    }

    /// A point of a polygon.
    fn corner(&mut self, number: u64) -> Got<usize> {
        if let Some(&known) = self.vertices.get(&number) {
            return Ok(known);
        }
        let point = self.space.point(number)?;
        Ok(self.put(number, point))
    }

    fn put(&mut self, number: u64, point: Point) -> usize {
        self.parts.vertices.push(Vertex { point, tolerance: self.space.units.tolerance });
        let place = self.parts.vertices.len() - 1;
        self.vertices.insert(number, place);
        place
    }

    /// The edge between two points of polygons.
    fn segment(&mut self, a: usize, b: usize, number: u64) -> Got<Use> {
        let ends = [a.min(b), a.max(b)];
        let reversed = a > b;
        let parameters = None;
        if let Some(&edge) = self.segments.get(&ends) {
            return Ok(Use { edge, reversed, parameters });
        }
        let [from, to] = ends.map(|end| self.parts.vertices[end].point);
        let curve = Curve::line(from, to).at(number)?;
        let (range, tolerance) = (curve.domain(), self.space.units.tolerance);
        let form = loftsman_kernel::brep::CurveForm::Line;
        self.parts.edges.push(Edge { curve, range, ends, tolerance, form });
        let edge = self.parts.edges.len() - 1;
        self.segments.insert(ends, edge);
        Ok(Use { edge, reversed, parameters })
    }

    /// That each edge starts where the one before ends.
    fn check_chain(&self, chain: &[Use], number: u64) -> Got<()> {
        let ends = |one: &Use| {
            let [a, b] = self.parts.edges[one.edge].ends;
            if one.reversed { [b, a] } else { [a, b] }
        };
        let next = chain.iter().skip(1).chain(chain.first());
        for (place, (one, next)) in chain.iter().zip(next).enumerate() {
            let ([_, end], [start, _]) = (ends(one), ends(next));
            if end != start {
                let gap =
                    nalgebra::distance(&self.parts.vertices[end].point, &self.parts.vertices[start].point);
                let text = format!(
                    "the loop is torn behind edge {} of {}: the next one starts at another vertex, {} away",
                    place + 1,
                    chain.len(),
                    loftsman_kernel::text::short(gap)
                );
                return Err(Problem::new(number, text));
            }
        }
        Ok(())
    }

    /// What the edges of a face, and its lone vertices, reach.
    fn points_of(&self, loops: &[Vec<Use>], lone: &[usize]) -> loftsman_kernel::Result<Vec<Point>> {
        let mut points: Vec<Point> = lone.iter().map(|&vertex| self.parts.vertices[vertex].point).collect();
        for one in loops.iter().flatten() {
            points.extend(self.parts.edges[one.edge].reach()?);
        }
        Ok(points)
    }

    /// The plane of a face that has none: that of its first polygon, by the sum of its triangles' normals.
    fn plane_of(&self, number: u64, chain: Option<&Vec<Use>>) -> Got<Sheet> {
        let corners: Vec<Point> = chain
            .into_iter()
            .flatten()
            .map(|one| {
                let [a, b] = self.parts.edges[one.edge].ends;
                self.parts.vertices[if one.reversed { b } else { a }].point
            })
            .collect();
        let first = corners.first().copied().unwrap_or_else(Point::origin);
        let normal: Vector = corners.windows(2).map(|pair| (pair[0] - first).cross(&(pair[1] - first))).sum();
        let toward = corners.get(1).map_or_else(Vector::x, |second| second - first);
        match loftsman_kernel::brep::Frame::new(first, normal, toward) {
            Some(frame) => Ok(Sheet::Elementary(SurfaceForm::Plane { frame }, false)),
            None => Err(Problem::new(number, "a face without a surface whose corners span no plane")),
        }
    }

    /// Puts vertices and edges in the order of their numbers; those between points of polygons come last.
    fn order(&mut self) {
        fn keys(known: impl Iterator<Item = (u64, usize)>, count: usize) -> Vec<u64> {
            let mut numbers = vec![u64::MAX; count];
            known.for_each(|(number, place)| numbers[place] = number);
            numbers
        }
        let vertices = keys(self.vertices.iter().map(|(n, place)| (*n, *place)), self.parts.vertices.len());
        let edges = keys(self.edges.iter().map(|(n, (place, _))| (*n, *place)), self.parts.edges.len());
        self.parts.sort_by_keys(&vertices, &edges);
    }

    fn finish(mut self, number: u64) -> Got<Model> {
        if self.parts.faces.is_empty() {
            // The cause, not that what names it goes with it.
            let cause = self.problems.iter().find(|p| !p.text.ends_with(LEFT_OUT));
            let first = cause.map(|p| format!(": #{}: {}", p.number, p.text));
            let text =
                format!("nothing of it is left{}", first.unwrap_or_else(|| ": it lists no face".to_owned()));
            return Err(Problem::new(number, text));
        }
        self.order();
        if !self.problems.is_empty() {
            self.parts.drop_unused();
        }
        let tolerance = self.space.units.tolerance;
        let Self { parts, whole, alone, parameters, problems, mut notes, .. } = self;
        let brep = Brep::new(parts).at(number)?;
        for (face, number) in whole.iter().enumerate() {
            notes.extend(brep.loops_told(face, true).at(*number)?.map(|told| format!("#{number}: {told}")));
        }
        if let Some(told) = Flaw::told(&brep.misplaced().at(number)?) {
            let states = loftsman_kernel::text::short(tolerance);
            notes.push(format!("#{number}: {told}; the file states {states}"));
        }
        Ok(Model { brep, whole, alone, parameters, problems, notes })
    }
}

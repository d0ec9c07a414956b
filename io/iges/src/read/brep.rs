//! Solids (186), shells (514) and faces (510): from loops (508), edges (504) and vertices (502) to the parts of a Brep.

use std::collections::HashMap;
use std::rc::Rc;

use loftsman_kernel::brep::{Brep, CurveForm, Edge, Face, Flaw, Parts, Shell, Solid, Use, Vertex};
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Result};

use super::curve::{Run, moved_points};
use super::entity::{At, Entity, Got, Problem, Reader};
use super::report::LEFT_OUT;
use super::style::Styles;
use super::whole::turned_back;

/// What is made of one solid, shell or face.
pub(crate) struct Model {
    pub(crate) brep: Brep,
    /// What of it is left out, and why.
    pub(crate) problems: Vec<Problem>,
    /// What is to be said of it.
    pub(crate) notes: Vec<String>,
}

/// The parts of one Brep, as they are found.
pub(crate) struct Builder<'a, 'r, 'f> {
    reader: &'a Reader<'r, 'f>,
    styles: &'a Styles,
    parts: Parts,
    /// Lists of vertices and of edges, by their places.
    vertex_lists: HashMap<usize, Rc<Vec<Point>>>,
    edge_lists: HashMap<usize, Rc<Entity<'r, 'f>>>,
    /// Of each vertex of a list the number.
    vertices: HashMap<(usize, usize), usize>,
    /// Of each edge of a list the number, and whether it runs the other way.
    edges: HashMap<(usize, usize), (usize, bool)>,
    /// Of each face its place in the file.
    face_places: Vec<usize>,
    problems: Vec<Problem>,
    notes: Vec<String>,
}

impl<'a, 'r, 'f> Builder<'a, 'r, 'f> {
    /// The Brep of a solid, a shell or a face.
    pub(crate) fn build(reader: &'a Reader<'r, 'f>, styles: &'a Styles, place: usize) -> Got<Model> {
        let mut builder = Self {
            reader,
            styles,
            parts: Parts::default(),
            vertex_lists: HashMap::new(),
            edge_lists: HashMap::new(),
            vertices: HashMap::new(),
            edges: HashMap::new(),
            face_places: Vec::new(),
            problems: Vec::new(),
            notes: Vec::new(),
        };
        builder.model(place)?;
        builder.finish(place)
    }

    fn model(&mut self, place: usize) -> Got<()> {
        let entity = self.reader.entity(place)?;
        match entity.entry.kind {
            186 => {
                let mut shells = vec![(entity.pointer(1)?, entity.whole(2)? != 0)];
                for k in 0..entity.count(3, 2)? {
                    shells.push((entity.pointer(4 + 2 * k)?, entity.whole(5 + 2 * k)? != 0));
                }
                let first = self.parts.shells.len();
                let count = shells.len();
                for (shell, along) in shells {
                    self.shell(shell, along)?;
                }
                let found = first..self.parts.shells.len();
                let whole = self.problems.is_empty() && found.len() == count;
                if whole && self.parts.shells[found.clone()].iter().all(|shell| self.closes(shell)) {
                    let voids = (first + 1..found.end).collect();
                    let name = self.styles.property_name(self.reader, place);
                    self.parts.solids.push(Solid { name, outer: first, voids });
                } else {
                    let why = if whole { "its shell does not close" } else { "a face of it is left out" };
                    let number = self.reader.file.number(place);
                    self.notes.push(format!("D{number}: the solid is kept as a shell: {why}"));
                }
                Ok(())
            }
            514 => self.shell(place, true),
            _ => {
                let face = self.face(place, true)?;
                self.parts.faces.push(face);
                self.face_places.push(place);
                Ok(())
            }
        }
    }

    /// Whether a shell has each edge twice, once in each direction.
    fn closes(&self, shell: &Shell) -> bool {
        let mut turns: HashMap<usize, [usize; 2]> = HashMap::new();
        for one in shell.faces.iter().flat_map(|&face| &self.parts.faces[face].loops).flatten() {
            turns.entry(one.edge).or_default()[usize::from(one.reversed)] += 1;
        }
        turns.values().all(|turns| *turns == [1, 1])
    }

    fn shell(&mut self, place: usize, along: bool) -> Got<()> {
        let entity = self.reader.of(place, &[514], "a shell (514)")?;
        let mut shell = Shell::default();
        for k in 0..entity.count(1, 2)? {
            let (face, same) = (entity.pointer(2 + 2 * k)?, entity.whole(3 + 2 * k)? != 0);
            match self.face(face, same == along) {
                Ok(found) => {
                    shell.faces.push(self.parts.faces.len());
                    self.parts.faces.push(found);
                    self.face_places.push(face);
                }
                Err(problem) => {
                    if problem.place != face {
                        let text = format!("D{}{LEFT_OUT}", self.reader.file.number(problem.place));
                        self.problems.push(Problem::new(face, text));
                    }
                    self.problems.push(problem);
                }
            }
        }
        if !shell.faces.is_empty() {
            self.parts.shells.push(shell);
        }
        Ok(())
    }

    /// A face whose normal is that of its surface, or the other one.
    fn face(&mut self, place: usize, along: bool) -> Got<Face> {
        let entity = self.reader.of(place, &[510], "a face (510)")?;
        let sheet = self.reader.sheet(entity.pointer(1)?, 0)?;
        let (mut loops, mut lone) = (Vec::new(), Vec::new());
        for at in entity.pointers(4, entity.count(2, 1)?)? {
            let mut chain = self.chain(at, &mut lone)?;
            if chain.is_empty() {
                continue;
            }
            // Loops run around the surface's normal.
            if !along {
                chain.reverse();
                chain.iter_mut().for_each(|one| one.reversed = !one.reversed);
            }
            loops.push(chain);
        }
        let points = self.points_of(&loops, &lone).at(place)?;
        let covering = sheet.covering(&points, place)?;
        Ok(Face {
            name: self.styles.name(self.reader, place),
            color: self.styles.color(self.reader, place),
            surface: covering.surface,
            form: covering.form,
            reversed: along == covering.reversed,
            loops,
            points: lone,
        })
    }

    /// The edges of a loop; a vertex alone goes to `lone`.
    fn chain(&mut self, place: usize, lone: &mut Vec<usize>) -> Got<Vec<Use>> {
        let entity = self.reader.of(place, &[508], "a loop (508)")?;
        let (mut chain, mut at, before) = (Vec::new(), 2, lone.len());
        for _ in 0..entity.count(1, 5)? {
            let (list, number) = (entity.pointer(at + 1)?, entity.whole(at + 2)?);
            let number = usize::try_from(number).ok().filter(|number| *number > 0);
            let Some(number) = number else {
                return Err(Problem::new(place, "an edge in it has no number: they count from 1"));
            };
            let (along, curves) = (entity.whole(at + 3)? != 0, entity.count(at + 4, 2)?);
            if entity.whole(at)? == 1 {
                lone.push(self.vertex(list, number)?);
            } else {
                let (edge, reversed) = self.edge(list, number)?;
                chain.push(Use { edge, reversed: reversed == along, parameters: None });
            }
            (0..curves).for_each(|k| {
                if let Ok(Some(curve)) = entity.pointed(at + 6 + 2 * k) {
                    self.reader.set_aside(curve);
                }
            });
            at += 5 + 2 * curves;
        }
        self.check_chain(&chain, place)?;
        // A pole between edges is where they meet anyway.
        if !chain.is_empty() {
            lone.truncate(before);
        }
        Ok(chain)
    }

    /// That each edge starts where the one before ends.
    fn check_chain(&self, chain: &[Use], place: usize) -> Got<()> {
        let ends = |one: &Use| {
            let [a, b] = self.parts.edges[one.edge].ends;
            if one.reversed { [b, a] } else { [a, b] }
        };
        let next = chain.iter().skip(1).chain(chain.first());
        for (number, (one, next)) in chain.iter().zip(next).enumerate() {
            let ([_, end], [start, _]) = (ends(one), ends(next));
            if end != start {
                let [p, q] = [end, start].map(|vertex| self.parts.vertices[vertex].point);
                let text = format!(
                    "the loop is torn behind edge {} of {}: the next one starts at another vertex, {} away",
                    number + 1,
                    chain.len(),
                    self.reader.told(nalgebra::distance(&p, &q))
                );
                return Err(Problem::new(place, text));
            }
        }
        Ok(())
    }

    fn vertex(&mut self, list: usize, number: usize) -> Got<usize> {
        if let Some(&known) = self.vertices.get(&(list, number)) {
            return Ok(known);
        }
        let points = match self.vertex_lists.get(&list) {
            Some(known) => Rc::clone(known),
            None => {
                let entity = self.reader.of(list, &[502], "a list of vertices (502)")?;
                let count = entity.count(1, 3)?;
                let numbers = entity.reals(2, 3 * count)?;
                let mut points: Vec<Point> =
                    numbers.chunks_exact(3).map(|c| Point::new(c[0], c[1], c[2])).collect();
                moved_points(&mut points, self.reader.placed(list)?.as_ref());
                let points = Rc::new(points);
                self.vertex_lists.insert(list, Rc::clone(&points));
                points
            }
        };
        let Some(&point) = points.get(number.wrapping_sub(1)) else {
            let text = format!("vertex {number} is asked of it, but it lists {}", points.len());
            return Err(Problem::new(list, text));
        };
        let tolerance = self.reader.file.global.resolution;
        self.parts.vertices.push(Vertex { point, tolerance });
        let place = self.parts.vertices.len() - 1;
        self.vertices.insert((list, number), place);
        Ok(place)
    }

    fn edge(&mut self, list: usize, number: usize) -> Got<(usize, bool)> {
        if let Some(&known) = self.edges.get(&(list, number)) {
            return Ok(known);
        }
        let entity = match self.edge_lists.get(&list) {
            Some(known) => Rc::clone(known),
            None => {
                let entity = Rc::new(self.reader.of(list, &[504], "a list of edges (504)")?);
                self.edge_lists.insert(list, Rc::clone(&entity));
                entity
            }
        };
        let count = entity.count(1, 5)?;
        if number > count {
            return Err(Problem::new(list, format!("edge {number} is asked of it, but it lists {count}")));
        }
        let at = 2 + 5 * (number - 1);
        let vertex = |builder: &mut Self, index: usize| {
            let number = usize::try_from(entity.whole(index + 1)?).unwrap_or(0);
            builder.vertex(entity.pointer(index)?, number)
        };
        let ends = [vertex(self, at + 1)?, vertex(self, at + 3)?];
        let points = ends.map(|end| self.parts.vertices[end].point);
        let curve = entity.pointer(at)?;
        let mut run = self.reader.curve(curve, 0)?;
        let size = run.curve.points().iter().map(|p| (p - points[0]).amax()).fold(0.0, f64::max);
        let near = self.reader.near(10.0 * size);
        if ends[0] == ends[1]
            && let Some((meant, form)) = turned_back(&run.curve, points[0], near).at(curve)?
        {
            let number = self.reader.file.number(curve);
            self.notes.push(format!("D{number}: a whole ellipse is turned by the angle that it starts at, away from its vertex: it is turned back"));
            run = Run { curve: meant, form, ..run };
        }
        let OnCurve { curve, range, reversed, form } =
            on_curve(run, points, ends[0] == ends[1], near).at(curve)?;
        let ends = if reversed { [ends[1], ends[0]] } else { ends };
        let tolerance = self.reader.file.global.resolution;
        self.parts.edges.push(Edge { curve, range, ends, tolerance, form });
        let known = (self.parts.edges.len() - 1, reversed);
        self.edges.insert((list, number), known);
        Ok(known)
    }

    /// What the edges of a face, and its lone vertices, reach.
    fn points_of(&self, loops: &[Vec<Use>], lone: &[usize]) -> Result<Vec<Point>> {
        let mut points: Vec<Point> = lone.iter().map(|&vertex| self.parts.vertices[vertex].point).collect();
        for one in loops.iter().flatten() {
            points.extend(self.parts.edges[one.edge].reach()?);
        }
        Ok(points)
    }

    /// Puts vertices and edges in the order of their lists.
    fn order(&mut self) {
        fn keys<K: Copy + Ord>(known: impl Iterator<Item = (K, usize)>) -> Vec<K> {
            let mut all: Vec<(usize, K)> = known.map(|(key, place)| (place, key)).collect();
            all.sort_unstable();
            all.into_iter().map(|(_, key)| key).collect()
        }
        let vertices = keys(self.vertices.iter().map(|(key, place)| (*key, *place)));
        let edges = keys(self.edges.iter().map(|(key, (place, _))| (*key, *place)));
        self.parts.sort_by_keys(&vertices, &edges);
    }

    fn finish(mut self, place: usize) -> Got<Model> {
        if self.parts.faces.is_empty() {
            let first = self.problems.first();
            let first = first.map(|p| format!(": D{}: {}", self.reader.file.number(p.place), p.text));
            return Err(Problem::new(place, format!("nothing of it is left{}", first.unwrap_or_default())));
        }
        self.order();
        if !self.problems.is_empty() {
            self.parts.drop_unused();
        }
        let mut brep = Brep::new(self.parts).at(place)?;
        let (mut notes, number) = (self.notes, |place: usize| self.reader.file.number(place));
        for (face, &place) in self.face_places.iter().enumerate() {
            notes.extend(
                brep.loops_told(face, true).at(place)?.map(|told| format!("D{}: {told}", number(place))),
            );
        }
        if let Some(told) = Flaw::told(&brep.misplaced().at(place)?) {
            let states = loftsman_kernel::text::short(self.reader.file.global.resolution);
            notes.push(format!("D{}: {told}; the file states {states}", number(place)));
        }
        if let Some(map) = self.reader.placed(place)? {
            let points = brep.points().iter().map(|p| super::place::transform_point(&map, p)).collect();
            brep = brep.transformed(points, &map).at(place)?;
        }
        Ok(Model { brep, problems: self.problems, notes })
    }
}

/// A curve of an edge: where on it the edge is, whether that runs from the edge's end to its start, and what it is.
struct OnCurve {
    curve: Curve,
    range: (f64, f64),
    reversed: bool,
    form: CurveForm,
}

/// The part of a curve between two points, all around where they are one.
fn on_curve(run: Run, [first, last]: [Point; 2], closes: bool, near: f64) -> Result<OnCurve> {
    let Run { curve, form, .. } = run;
    let (start, end) = curve.domain();
    let (head, tail) = (curve.point(start)?, curve.point(end)?);
    let at = |p: Point, q: Point| nalgebra::distance(&p, &q) <= near;
    let whole = |curve: Curve, reversed: bool| OnCurve { range: (start, end), curve, reversed, form };
    if at(first, head) && at(last, tail) {
        return Ok(whole(curve, false));
    }
    if at(first, tail) && at(last, head) {
        return Ok(whole(curve, true));
    }
    let (from, to) = (curve.closest(first)?.at, curve.closest(last)?.at);
    if from < to && !closes {
        return Ok(OnCurve { curve, range: (from, to), reversed: false, form });
    }
    // What closes goes on through its seam.
    if at(head, tail) {
        let to = if closes { from } else { to };
        let gap = nalgebra::distance(&head, &tail) * 1.000_001;
        let curve = match (from >= end, to <= start) {
            (true, true) => curve,
            (true, false) => curve.between(start, to)?,
            (false, true) => curve.between(from, end)?,
            (false, false) => curve.between(from, end)?.join(&curve.between(start, to)?, gap)?.shape,
        };
        return Ok(OnCurve { range: curve.domain(), curve, reversed: false, form });
    }
    if to < from && !closes {
        return Ok(OnCurve { curve, range: (to, from), reversed: true, form });
    }
    Err(loftsman_kernel::Error::Invalid(format!(
        "its edge has the ends {from} and {to} on it, which leave nothing between them"
    )))
}

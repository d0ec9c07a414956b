//! From parts to a Brep, checked.

use super::parts::{Edge, Face, Parts, Use};
use super::{BareEdge, BareFace, Brep, Places, UsePlace, shape};
use crate::error::{Error, Result};
use crate::spline::Surface;

/// How many open edges a message names.
const NAMED: usize = 5;

impl Brep {
    /// A Brep of its parts. `O(parts)`, but for copies of what they hold. How near edges are to surfaces and to their vertices is not
    /// looked at: [`flaws`](Self::flaws) does that.
    ///
    /// # Errors
    /// With the part's number: when a number names nothing, a coordinate is not finite or a tolerance not a length, an edge has no range
    /// on its curve, a loop is empty, is no chain or does not close, a face is in two shells or a shell in two solids, or the
    /// shell of a solid is open; the last names the edges.
    pub fn new(parts: Parts) -> Result<Self> {
        let Parts { vertices, edges, faces, shells, solids } = parts;
        for (number, vertex) in vertices.iter().enumerate() {
            let p = vertex.point;
            if !p.iter().all(|c| c.is_finite()) {
                return Err(Error::VertexNotFinite { index: number, x: p.x, y: p.y, z: p.z });
            }
            tolerance(vertex.tolerance).map_err(|e| of("vertex", number, &e))?;
        }
        for (number, edge) in edges.iter().enumerate() {
            check_edge(edge, vertices.len()).map_err(|e| of("edge", number, &e))?;
        }
        for (number, face) in faces.iter().enumerate() {
            check_face(face, &edges, vertices.len()).map_err(|e| of("face", number, &e))?;
        }
        once(shells.iter().map(|s| s.faces.as_slice()), faces.len(), ["shell", "face"])?;
        let lists: Vec<Vec<usize>> = solids
            .iter()
            .map(|s| std::iter::once(s.outer).chain(s.voids.iter().copied()).collect())
            .collect();
        once(lists.iter().map(Vec::as_slice), shells.len(), ["solid", "shell"])?;

        let mut uses = vec![Vec::new(); edges.len()];
        for (face, chain, number, one) in places(&faces) {
            uses[one.edge].push(UsePlace { face, chain, number });
        }
        let mut net = Vec::new();
        let mut starts = Places::default();
        let mut bare_faces = Vec::with_capacity(faces.len());
        for Face { name, color, surface, form, reversed, loops, points } in faces {
            starts.faces.push(net.len());
            let (u, v, vertices, weights) = surface.into_parts();
            net.extend(vertices);
            bare_faces.push(BareFace { name, color, spaces: [u, v], weights, form, reversed, loops, points });
        }
        let mut bare_edges = Vec::with_capacity(edges.len());
        for Edge { curve, range, ends, tolerance, form } in edges {
            starts.edges.push(net.len());
            let (space, vertices, weights) = curve.into_parts();
            net.extend(vertices);
            bare_edges.push(BareEdge { space, weights, range, ends, tolerance, form });
        }
        starts.vertices = net.len();
        starts.cells = shape::cell_starts(&bare_faces);
        net.extend(vertices.iter().map(|vertex| vertex.point));
        let brep = Self {
            net,
            places: starts,
            faces: bare_faces,
            edges: bare_edges,
            tolerances: vertices.iter().map(|vertex| vertex.tolerance).collect(),
            shells,
            solids,
            uses,
            motion: super::loose::Motion::None,
            known: super::flaws::Known::default(),
        };
        brep.check_solids()?;
        Ok(brep)
    }

    fn check_solids(&self) -> Result<()> {
        for (number, solid) in self.solids.iter().enumerate() {
            for &shell in std::iter::once(&solid.outer).chain(&solid.voids) {
                let faces = &self.shells[shell].faces;
                let open = self.open_edges(faces);
                if !open.is_empty() {
                    let names: Vec<String> = open.iter().take(NAMED).map(usize::to_string).collect();
                    let more = if open.len() > NAMED { ", …" } else { "" };
                    return Err(Error::Invalid(format!(
                        "solid {number}: its shell {shell} does not close at {} of its edges (number {}{more}): each must bound two faces, once in each direction; keep the shell without the solid",
                        open.len(),
                        names.join(", "),
                    )));
                }
                if !self.is_closed(faces) {
                    return Err(Error::Invalid(format!(
                        "solid {number}: its shell {shell} has a face without loops on a surface that does not close: keep the shell without the solid"
                    )));
                }
            }
        }
        Ok(())
    }
}

/// Every use of an edge: face, loop, number in it.
fn places(faces: &[Face]) -> impl Iterator<Item = (usize, usize, usize, &Use)> {
    faces.iter().enumerate().flat_map(|(face, f)| {
        let chains = f.loops.iter().enumerate();
        chains.flat_map(move |(chain, uses)| {
            uses.iter().enumerate().map(move |(number, one)| (face, chain, number, one))
        })
    })
}

fn of(what: &str, number: usize, error: &Error) -> Error {
    Error::Invalid(format!("{what} {number}: {error}"))
}

fn tolerance(length: f64) -> Result<()> {
    if length >= 0.0 && length.is_finite() {
        return Ok(());
    }
    Err(Error::Invalid(format!("the tolerance {length} is no length: give 0 or more")))
}

fn check_edge(edge: &Edge, vertices: usize) -> Result<()> {
    tolerance(edge.tolerance)?;
    edge.form.check()?;
    for &end in &edge.ends {
        exists(end, vertices, "vertex", "vertices")?;
    }
    let (start, end) = edge.curve.domain();
    let (from, to) = edge.range;
    let last = if edge.curve.is_periodic() { from + (end - start) } else { end };
    if !(start..=end).contains(&from) {
        return Err(Error::Outside { value: from, start, end });
    }
    if !(from < to && to <= last) {
        return Err(Error::Invalid(format!(
            "it runs from {from} to {to} on a curve over [{start}, {end}]: the second must be more, and at most {last}"
        )));
    }
    Ok(())
}

fn check_face(face: &Face, edges: &[Edge], vertices: usize) -> Result<()> {
    face.form.check()?;
    for &vertex in &face.points {
        exists(vertex, vertices, "vertex", "vertices")?;
    }
    if let Some(color) = face.color
        && !color.iter().all(|c| c.is_finite())
    {
        return Err(Error::Invalid("a number of its colour is not finite".into()));
    }
    for (number, chain) in face.loops.iter().enumerate() {
        check_loop(chain, edges).map_err(|e| of("loop", number, &e))?;
    }
    Ok(())
}

fn check_loop(chain: &[Use], edges: &[Edge]) -> Result<()> {
    for one in chain {
        exists(one.edge, edges.len(), "edge", "edges")?;
    }
    let ends = |one: &Use| {
        let [start, end] = edges[one.edge].ends;
        if one.reversed { [end, start] } else { [start, end] }
    };
    let (Some(first), Some(last)) = (chain.first(), chain.last()) else {
        return Err(Error::Invalid("it has no edges".into()));
    };
    let next = chain.iter().skip(1).chain(std::iter::once(first));
    for (one, next) in chain.iter().zip(next) {
        let ([_, end], [start, _]) = (ends(one), ends(next));
        if end != start {
            let torn = if std::ptr::eq(one, last) { "it does not close" } else { "it is torn" };
            return Err(Error::Invalid(format!(
                "{torn}: edge {} ends at vertex {end}, but edge {} starts at vertex {start}",
                one.edge, next.edge
            )));
        }
    }
    Ok(())
}

fn exists(number: usize, count: usize, one: &str, many: &str) -> Result<()> {
    if number < count {
        return Ok(());
    }
    Err(Error::Invalid(format!("it names {one} {number}, but there are {count} {many}")))
}

/// That lists name what there is, and nothing twice.
fn once<'l>(lists: impl Iterator<Item = &'l [usize]>, count: usize, [list, item]: [&str; 2]) -> Result<()> {
    let mut taken = vec![None; count];
    for (number, members) in lists.enumerate() {
        for &member in members {
            exists(member, count, item, &format!("{item}s")).map_err(|e| of(list, number, &e))?;
            if let Some(other) = taken[member].replace(number) {
                return Err(Error::Invalid(format!(
                    "{list} {number}: {item} {member} is in {list} {other} already: give it to one of them"
                )));
            }
        }
    }
    Ok(())
}

/// Whether a whole surface has no border: each of its edges is a point, or the same as the one across.
pub(super) fn closes(surface: &Surface) -> bool {
    let (rows, columns) = (surface.u().len(), surface.v().len());
    let points = surface.points();
    let at = |i: usize, j: usize| points[i * columns + j];
    let size = points.iter().map(|p| (p - points[0]).amax()).fold(0.0, f64::max);
    let near = |a, b| nalgebra::distance(&a, &b) <= 1e-9 * size;
    let sides = |periodic: bool,
                 along: usize,
                 first: &dyn Fn(usize) -> crate::Point,
                 last: &dyn Fn(usize) -> crate::Point| {
        let point = |side: &dyn Fn(usize) -> crate::Point| (1..along).all(|k| near(side(k), side(0)));
        periodic || (0..along).all(|k| near(first(k), last(k))) || (point(first) && point(last))
    };
    sides(surface.u().is_periodic(), columns, &|j| at(0, j), &|j| at(rows - 1, j))
        && sides(surface.v().is_periodic(), rows, &|i| at(i, 0), &|i| at(i, columns - 1))
}

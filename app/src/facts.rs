//! What is said of one object: its type and the facts that people ask first, in its own coordinates.

mod faces;

use std::collections::HashSet;

use loftsman_kernel::Point;
use loftsman_kernel::brep::{Brep, Flaw};
use loftsman_kernel::plugin::{CustomShape, Fineness};
use loftsman_kernel::scene::Geometry;
use loftsman_kernel::spline::{Curve, CurvePiece, Surface, SurfacePiece};

use crate::measures::{Measures, closed, of_brep};
pub use faces::FaceFacts;
pub(crate) use faces::faces;

/// The facts about an object, as it stands: lengths, areas, volumes and places are those of the scene (of an object of a definition, the
/// definition's), with its own transform and those above it. What does not apply is left out when it is serialised.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct ObjectFacts {
    /// Its name.
    pub name: String,
    /// What it is called where it comes from, if others are called so too.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// `"curve"`, `"surface"`, `"trimmed"`, `"brep"`, `"mesh"`, `"polyline"`, `"cloud"`, `"group"` or `"instance"`; of a
    /// plug-in's shape, the name of its kind.
    #[serde(rename = "type")]
    pub kind: String,
    /// Whether the plug-in of its kind is not here, so that nothing else is known of it.
    #[serde(skip_serializing_if = "is_false")]
    pub unknown: bool,
    /// The definition that an instance shows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shows: Option<String>,
    /// The object it hangs under.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parent: Option<String>,
    /// Its layer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layer: Option<String>,
    /// Red, green, blue, alpha.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color: Option<[f64; 4]>,
    /// Whether it has a transform of its own.
    #[serde(skip_serializing_if = "is_false")]
    pub transformed: bool,
    /// What a curve or surface is beside a spline: `"line"`, `"circle"`, `"arc of a circle"`, `"cylinder"` and their like.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub form: Option<&'static str>,
    /// Degree of a curve, or degrees along `u` and `v` of a surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub degree: Option<Degree>,
    /// Control vertices, mesh points, polyline or cloud points: their number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vertices: Option<usize>,
    /// Control vertices along `u` and `v`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub net: Option<[usize; 2]>,
    /// Whether it has weights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rational: Option<bool>,
    /// Whether its parameters wrap, a direction each.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub periodic: Vec<bool>,
    /// Whether its end meets its start.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub closed: Option<bool>,
    /// The interval of its parameter, a direction each.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub domain: Vec<[f64; 2]>,
    /// Loops that bound a trimmed surface; its size is that of the part that they leave, degrees and domain are those of the surface that carries it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loops: Option<usize>,
    /// Faces of a mesh or of a brep.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub faces: Option<usize>,
    /// Edges of a brep.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edges: Option<usize>,
    /// Edges of a brep that its faces do not close at: those that do not bound two faces, once in each direction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub open_edges: Option<usize>,
    /// The first of them, and where they are.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub open_at: Vec<OpenEdge>,
    /// Edges of a brep that are off a face or a vertex of theirs by more than their tolerance and a ten-thousandth of the brep's size: how often.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub off_edges: Option<usize>,
    /// The furthest of them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub off_at: Vec<OffEdge>,
    /// How many colours the faces of a brep have, where they have colours of their own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub face_colors: Option<usize>,
    /// Each of the faces of a brep, where they are asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub face_list: Vec<FaceFacts>,
    /// Shells of a brep.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shells: Option<usize>,
    /// Solids of a brep.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solids: Option<usize>,
    /// The triangles that they make.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub triangles: Option<usize>,
    /// Frames of its animation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames: Option<usize>,
    /// Loose lines of a mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lines: Option<usize>,
    /// Length, area, volume, and whether a mesh is watertight; none where it is beyond what numbers can hold.
    #[serde(flatten)]
    pub measures: Measures,
    /// The corners of the axis-parallel box around it, the lower first: of a spline around the curve or surface
    /// itself, not its control vertices; of a plug-in's shape around its segments or triangles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bounds: Option<[[f64; 3]; 2]>,
    /// The same in its own coordinates, where it or what it hangs under is placed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub own: Option<Box<OwnFacts>>,
    /// Of an instance, whether it is placed larger, smaller or mirrored.
    #[serde(skip)]
    pub(crate) resized: bool,
}

/// How large an object is in its own coordinates.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct OwnFacts {
    /// Length, area, volume.
    #[serde(flatten)]
    pub measures: Measures,
    /// The corners of the box around it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bounds: Option<[[f64; 3]; 2]>,
}

/// An edge that the faces of a brep do not close at.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct OpenEdge {
    /// Its number.
    pub edge: usize,
    /// Its middle.
    pub at: [f64; 3],
}

/// An edge of a brep that is not where it should be. Of `face` and `vertex` one is there.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct OffEdge {
    /// Its number.
    pub edge: usize,
    /// The face whose surface it is off.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub face: Option<usize>,
    /// The vertex that its end is off.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vertex: Option<usize>,
    /// By how much at most.
    pub distance: f64,
    /// What its tolerance says.
    pub tolerance: f64,
}

/// How many open edges are named.
const OPEN: usize = 8;

/// One degree, or two.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(untagged)]
pub enum Degree {
    /// Of a curve.
    Curve(usize),
    /// Of a surface, along `u` and `v`.
    Surface([usize; 2]),
}

pub(crate) fn is_false(flag: &bool) -> bool {
    !flag
}

/// What is said of a geometry, whoever has it, in its own coordinates; and points around which boxes are those around it, wherever it is placed, where
/// its own points are not that.
pub(crate) fn shape(geometry: &Geometry) -> (ObjectFacts, Vec<Point>) {
    if let Geometry::Brep(b) = geometry {
        return brep(b, ObjectFacts { kind: geometry.kind().to_owned(), ..ObjectFacts::default() });
    }
    if let Geometry::Custom(custom) = geometry {
        let seen = custom.tessellate(&Fineness::default()).ok();
        let around = seen.map(|seen| seen.drawn.points().to_vec()).unwrap_or_default();
        return (shape_of_plugin(custom, &around, plain(geometry)), around);
    }
    (plain(geometry), Vec::new())
}

fn plain(geometry: &Geometry) -> ObjectFacts {
    let points = geometry.points();
    let has_points = !geometry.is_unknown() && !matches!(geometry, Geometry::Group | Geometry::Instance(_));
    let facts = ObjectFacts {
        kind: geometry.kind().to_owned(),
        unknown: geometry.is_unknown(),
        vertices: has_points.then_some(points.len()),
        bounds: bounds(points),
        measures: Measures::of(geometry),
        ..ObjectFacts::default()
    };
    match geometry {
        Geometry::Instance(definition) => ObjectFacts { shows: Some(definition.clone()), ..facts },
        Geometry::Curve(c) => curve(c, facts),
        Geometry::Surface(s) => surface(s, facts),
        Geometry::Trimmed(t) => ObjectFacts {
            loops: Some(t.loops().count()),
            bounds: t.bounds().ok().map(corners),
            ..surface(t.surface(), facts)
        },
        Geometry::Mesh(m) => {
            let lines = Some(m.lines().count()).filter(|&count| count > 0);
            ObjectFacts { faces: Some(m.face_count()), triangles: Some(m.triangle_count()), lines, ..facts }
        }
        Geometry::Polyline(line) => ObjectFacts { closed: Some(line.closed), ..facts },
        _ => facts,
    }
}

fn curve(curve: &Curve, facts: ObjectFacts) -> ObjectFacts {
    let (start, end) = curve.domain();
    ObjectFacts {
        form: curve.form().map(CurvePiece::noun),
        degree: Some(Degree::Curve(curve.degree())),
        rational: Some(curve.weights().is_some()),
        periodic: vec![curve.is_periodic()],
        closed: Some(closed(curve)),
        domain: vec![[start, end]],
        bounds: Some(corners(curve.bounds())),
        ..facts
    }
}

/// A plug-in's shape: its parameters, and the box around a tessellation of it.
fn shape_of_plugin(custom: &CustomShape, around: &[Point], facts: ObjectFacts) -> ObjectFacts {
    let Ok(shape) = custom.shape() else { return facts };
    let domain = shape.domain();
    ObjectFacts {
        periodic: domain.iter().map(|interval| interval.periodic).collect(),
        domain: domain.iter().map(|interval| [interval.start, interval.end]).collect(),
        bounds: bounds(around).or(facts.bounds),
        ..facts
    }
}

fn surface(surface: &Surface, facts: ObjectFacts) -> ObjectFacts {
    let (u, v) = (surface.u(), surface.v());
    ObjectFacts {
        form: surface.form().map(SurfacePiece::noun),
        degree: Some(Degree::Surface([u.degree(), v.degree()])),
        net: Some([u.len(), v.len()]),
        rational: Some(surface.weights().is_some()),
        periodic: vec![u.is_periodic(), v.is_periodic()],
        domain: [u, v].map(|s| <[f64; 2]>::from(s.domain())).to_vec(),
        bounds: Some(corners(surface.bounds())),
        ..facts
    }
}

/// A brep: what it is made of, where it is open, how large it is, and the box around its triangles.
fn brep(brep: &Brep, facts: ObjectFacts) -> (ObjectFacts, Vec<Point>) {
    let all: Vec<usize> = (0..brep.face_count()).collect();
    let open = brep.open_edges(&all);
    let middle = |edge: usize| {
        let whole = brep.edge(edge)?;
        let at = whole.curve.point(0.5 * (whole.range.0 + whole.range.1)).ok()?;
        Some(OpenEdge { edge, at: at.coords.into() })
    };
    let colors: HashSet<[u64; 4]> =
        all.iter().filter_map(|&face| brep.face_color(face)).map(|color| color.map(f64::to_bits)).collect();
    let (measures, around) = of_brep(brep);
    let around = if around.is_empty() { brep.vertices().to_vec() } else { around };
    let off = off(brep);
    let facts = ObjectFacts {
        faces: Some(brep.face_count()),
        edges: Some(brep.edge_count()),
        open_edges: Some(open.len()).filter(|&open| open > 0),
        open_at: open.iter().take(OPEN).filter_map(|&edge| middle(edge)).collect(),
        off_edges: Some(off.len()).filter(|&off| off > 0),
        off_at: off.into_iter().take(OPEN).collect(),
        face_colors: Some(colors.len()).filter(|&count| count > 0),
        measures,
        bounds: bounds(&around),
        shells: Some(brep.shells().len()),
        solids: Some(brep.solids().len()),
        vertices: Some(brep.vertices().len()),
        closed: Some(brep.is_closed(&all)),
        ..facts
    };
    (facts, around)
}

/// The edges that are not where they should be, the furthest off first. Where they cannot be evaluated none is told.
fn off(brep: &Brep) -> Vec<OffEdge> {
    let tolerance = |edge: usize| brep.edge(edge).map_or(0.0, |edge| edge.tolerance);
    let told = |flaw: Flaw| match flaw {
        Flaw::End { edge, vertex, distance } => {
            OffEdge { edge, face: None, vertex: Some(vertex), distance, tolerance: tolerance(edge) }
        }
        Flaw::Off { edge, face, distance, .. } => {
            OffEdge { edge, face: Some(face), vertex: None, distance, tolerance: tolerance(edge) }
        }
    };
    brep.misplaced().unwrap_or_default().into_iter().map(told).collect()
}

pub(crate) fn bounds(points: &[Point]) -> Option<[[f64; 3]; 2]> {
    let first = *points.first()?;
    let (low, high) = points.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    Some(corners((low, high)))
}

pub(crate) fn corners((low, high): (Point, Point)) -> [[f64; 3]; 2] {
    [low.coords.into(), high.coords.into()]
}

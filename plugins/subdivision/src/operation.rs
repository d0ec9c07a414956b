//! `subdivide`: meshes and polylines refined, in recipes.

mod cage;
mod fields;

use loftsman_kernel::error::Error;
use loftsman_kernel::mesh::{Layer, Mesh, Polyline};
use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, ParameterError, Parameters, StepReport,
    object_name,
};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::text::{a, counted as several, figure, short};
use loftsman_kernel::{Point, Vector};

use self::fields::{cage, index};
use crate::carry::{Carried, left_behind};
use crate::doo_sabin::DooSabinSurface;
use crate::own::surface;
use crate::said::Once;
use crate::together::{advised, coincident, together};
use crate::used::used;
use crate::weld::{welded, welded_by};
use crate::{
    Cage, LeftOut, LimitFrame, Polygon, Scheme, SubdivisionError, SubdivisionSurface, catmull_clark,
    doo_sabin,
};

/// The operation `subdivide`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Subdivide;

/// What areas and volumes leave out, in words.
fn told(left: crate::Result<LeftOut>, round: &str) -> String {
    match left {
        Ok(left) if left.count == 0 => "areas and volumes are exact".to_owned(),
        Ok(left) => format!(
            "areas leave out at most {} round extraordinary {round}, and volumes are within {}",
            short(left.area),
            short(left.volume)
        ),
        Err(error) => format!("what areas and volumes leave out has no bound: {error}"),
    }
}

/// More faces than these are refused beforehand: 2 GB of mesh.
const MOST: f64 = 2e7;

const FIELDS: [Field; 13] = [
    Field::optional(
        "object",
        "text",
        "the only mesh, polyline or subdivision surface",
        "the object to subdivide",
    ),
    Field::optional(
        "scheme",
        "\"catmull-clark\" | \"doo-sabin\" | \"cubic\" | \"chaikin\"",
        "catmull-clark for meshes, cubic for polylines",
        "the first two refine meshes, the others polylines",
    ),
    Field::optional(
        "levels",
        "count",
        "1",
        "how often it is refined; 0 of a subdivision surface is its cage",
    ),
    Field::optional(
        "limit",
        "true | false",
        "false",
        "put the vertices where the surface comes to, with its normals; of a polyline the spline itself",
    ),
    Field::optional(
        "surface",
        "true | false",
        "false",
        "make the mesh the control cage of its limit surface, which is then edited like any shape",
    ),
    Field::optional(
        "creases",
        "[[vertex, vertex, sharpness], …]",
        "none",
        "edges that stay sharp for so many levels, 10 and more for ever; Catmull-Clark only",
    ),
    Field::optional(
        "corners",
        "[[vertex, sharpness], …]",
        "none",
        "vertices that stay sharp for so many levels; Catmull-Clark only",
    ),
    Field::optional(
        "weld",
        "true | false",
        "false",
        "make vertices in one place one, as files split them that keep normals by vertex (glTF), as far as none joins several fans of faces; what is \
         numbered is numbered after that",
    ),
    Field::optional("holes", "[face, …]", "none", "faces that take part and are not there in the end"),
    Field::optional(
        "boundary",
        "\"edge-and-corner\" | \"edge-only\"",
        "edge-and-corner",
        "whether a boundary vertex with one face stays where it is",
    ),
    Field::optional(
        "intervals",
        "[number, …] | [[vertex, vertex, number], …]",
        "1 each",
        "knot intervals: of a polyline one a span, of a mesh those of some edges; with Doo-Sabin those that the first vertex has towards the \
         second",
    ),
    Field::optional(
        "alpha",
        "number | [{ edge = [vertex, vertex], value }, …]",
        "not tuned",
        "fine tuning: what the surface's derivative is multiplied by where it crosses each edge's knot line, 1 where nothing is said; the \
         form becomes one of Catmull-Clark by knot intervals, which is refined then; Doo-Sabin only",
    ),
    Field::optional(
        "lock",
        "[vertex, …]",
        "the first of each piece",
        "vertices whose part of a tuned form stays; with alpha only",
    ),
];

impl Operation for Subdivide {
    fn declaration(&self) -> Declaration {
        Declaration {
            name: "subdivide",
            help: "refine a mesh or a polyline by a subdivision scheme; of a subdivision surface, its cage as a mesh",
            fields: &FIELDS,
        }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        parameters: &Parameters,
        _: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        let fits =
            |g: &Geometry| matches!(g, Geometry::Mesh(_) | Geometry::Polyline(_)) || surface(g).is_some();
        let object = object_name(scene, parameters, fits, "mesh, polyline or subdivision surface")?;
        let levels = parameters.count_or("levels", 1)?;
        let (geometry, note) = match scene.object(&object)?.geometry() {
            Geometry::Mesh(mesh) => self::mesh(parameters, mesh, levels)?,
            Geometry::Polyline(line) => polyline(parameters, line, levels)?,
            other => match surface(other) {
                Some(own) => cage::meshed(parameters, &own, levels)?,
                None => {
                    let problem = format!(
                        "\"{object}\" is {}: what is subdivided is a mesh, a polyline or a subdivision surface",
                        a(&other.noun())
                    );
                    return Err(parameters.error("object", problem).into());
                }
            },
        };
        scene.replace(&object, geometry)?;
        Ok(StepReport {
            op: "subdivide".into(),
            object: Some(object),
            notes: vec![note],
            ..StepReport::default()
        })
    }
}

impl From<SubdivisionError> for OperationError {
    fn from(error: SubdivisionError) -> Self {
        Error::Invalid(error.to_string()).into()
    }
}

fn polyline(
    parameters: &Parameters,
    line: &Polyline,
    levels: usize,
) -> Result<(Geometry, String), OperationError> {
    for name in ["surface", "creases", "corners", "weld", "holes", "boundary", "alpha", "lock"] {
        if parameters.has(name) {
            return Err(parameters.error(name, "is for meshes, and this is a polyline").into());
        }
    }
    const WORDS: [(&str, Option<Scheme>); 4] = [
        ("cubic", Some(Scheme::Cubic)),
        ("chaikin", Some(Scheme::Chaikin)),
        ("catmull-clark", None),
        ("doo-sabin", None),
    ];
    let scheme =
        if parameters.has("scheme") { parameters.choice("scheme", &WORDS)? } else { Some(Scheme::Cubic) };
    let Some(scheme) = scheme else {
        let problem = "refines meshes, and this is a polyline: \"cubic\" (of Catmull-Clark) or \"chaikin\" (of Doo-Sabin)";
        return Err(parameters.error("scheme", problem).into());
    };
    let mut polygon = Polygon::new(scheme, line.points.clone(), line.closed)?;
    if parameters.has("intervals") {
        polygon = polygon.with_intervals(parameters.numbers("intervals")?)?;
    }
    if parameters.flag("limit")? {
        let curve = polygon.to_curve()?;
        let note = format!(
            "what it comes to: a spline of degree {} with {} vertices, exactly",
            curve.degree(),
            curve.points().len()
        );
        return Ok((curve.into(), note));
    }
    check_size(parameters, levels, line.points.len() as f64 * 2.0_f64.powf(levels as f64), "points")?;
    let fine = polygon.refine_times(levels);
    let note = format!("{} points → {}", line.points.len(), fine.points().len());
    Ok((Polyline { points: fine.points().to_vec(), closed: line.closed }.into(), note))
}

fn mesh(parameters: &Parameters, mesh: &Mesh, levels: usize) -> Result<(Geometry, String), OperationError> {
    const WORDS: [(&str, Option<bool>); 4] =
        [("catmull-clark", Some(true)), ("doo-sabin", Some(false)), ("cubic", None), ("chaikin", None)];
    let scheme = if parameters.has("scheme") { parameters.choice("scheme", &WORDS)? } else { Some(true) };
    let Some(smooth) = scheme else {
        let problem = "refines polylines, and this is a mesh: \"catmull-clark\" or \"doo-sabin\"";
        return Err(parameters.error("scheme", problem).into());
    };
    let of_edges = ["creases", "corners", "boundary"];
    if let Some(name) = of_edges.into_iter().find(|name| !smooth && parameters.has(name)) {
        return Err(parameters.error(name, "is for scheme = \"catmull-clark\": Doo-Sabin has none").into());
    }
    let given = mesh;
    let one = if parameters.flag("weld")? { Some(together(mesh)?) } else { None };
    let mesh = one.as_ref().map_or(given, |one| &one.mesh);
    let cage = cage(parameters, mesh, smooth).map_err(|error| advised(error, one.is_none(), given))?;
    let pairs = match &one {
        Some(one) => one.told(),
        None => coincident(&cage, given)?,
    };
    if let Some(name) = ["alpha", "lock"].into_iter().find(|name| smooth && parameters.has(name)) {
        return Err(parameters
            .error(name, "is for scheme = \"doo-sabin\", whose knot lines it scales")
            .into());
    }
    if parameters.has("lock") && !parameters.has("alpha") {
        return Err(parameters.error("lock", "is for alpha: nothing else moves a vertex").into());
    }
    if parameters.flag("surface")? {
        if let Some(name) = ["levels", "limit"].into_iter().find(|name| parameters.has(name)) {
            return Err(parameters
                .error(name, "stands beside surface = true: the cage stays as it is")
                .into());
        }
        if !smooth {
            return by_doo_sabin_surface(parameters, mesh, cage, &pairs);
        }
        let surface = SubdivisionSurface::new(cage)?;
        let left = told(surface.left_out(), "vertices");
        let (points, faces) = (mesh.points().len(), mesh.face_count());
        // What is no quad counts one for each corner, and a hole none.
        let own = surface.faces().unwrap_or(faces);
        let holes = (0..faces).filter(|&face| surface.cage().is_hole(face)).count();
        let counted = match (own + holes == faces, holes) {
            (true, 0) => String::new(),
            (true, _) => format!(" (without holes the surface has {own})"),
            (false, _) => {
                format!(" (faces that are no quads count once a corner: the surface has {own})")
            }
        };
        let behind = left_behind(mesh, "a surface");
        let note = format!(
            "{points} points and {} the cage of a surface now{counted}; {left}{behind}{pairs}",
            several(faces, "face[ is|s are]")
        );
        return Ok((surface.into(), note));
    }
    let first = mesh.corners().len() as f64;
    check_size(parameters, levels, first * 4.0_f64.powf(levels as f64 - 1.0), "faces")?;
    let limit = parameters.flag("limit")?;
    let (points, faces) = (mesh.points().len(), mesh.face_count());
    let mut strain = String::new();
    let fine = if smooth {
        by_catmull_clark(&cage, mesh, levels, limit)?
    } else if parameters.has("alpha") {
        check_size(parameters, levels, first * 4.0_f64.powf(levels as f64), "faces")?;
        let size = cage.points().iter().fold(0.0, |most: f64, p| most.max(p.coords.amax()));
        let elsewhere = doo_sabin::irregular(&cage);
        let tuned = tuned(parameters, cage)?;
        strain = format!(
            "; edges differ by {} of their lengths from what they are to be{elsewhere}",
            figure(tuned.strain)
        );
        let fine = catmull_clark::refine_times(&tuned.cage, levels)?;
        if limit { welded(&fine, &catmull_clark::limit_frames(&fine)?, size)? } else { fine.to_mesh()? }
    } else {
        by_doo_sabin(&cage, levels, limit)?
    };
    let fine = used(fine)?;
    if fine.face_count() == 0 {
        let problem = "leaves nothing: no vertex of the mesh has faces all round it, and Doo-Sabin's surface ends half a face inside the mesh; \
                       give it a row of faces more, or leave limit out";
        return Err(parameters.error("limit", problem).into());
    }
    let behind = match smooth {
        true if mesh.colors.is_empty() => String::new(),
        true => "; its colours are left out".to_owned(),
        false => left_behind(mesh, "a refinement whose faces come of edges and vertices, too,"),
    };
    let note = format!(
        "{} and {} → {} and {}{}{strain}{behind}{pairs}",
        several(points, "point[|s]"),
        several(faces, "face[|s]"),
        fine.points().len(),
        fine.face_count(),
        if limit { ", where the surface comes to" } else { "" }
    );
    Ok((fine.into(), note))
}

/// The limit of a Doo-Sabin cage as a shape.
fn by_doo_sabin_surface(
    parameters: &Parameters,
    mesh: &Mesh,
    cage: Cage,
    pairs: &str,
) -> Result<(Geometry, String), OperationError> {
    if parameters.has("alpha") {
        let problem = "makes a form whose knot intervals are 0 round faces, of which places between vertices are not known: leave surface out; \
                       with limit = true the vertices are put where it comes to";
        return Err(parameters.error("alpha", problem).into());
    }
    let surface = DooSabinSurface::new(cage)?;
    let faces = surface.faces().unwrap_or_default();
    let left = told(surface.left_out(), "points");
    let behind = left_behind(mesh, "a surface");
    let note = format!(
        "{} points and {} the cage of a surface now, of {} (one for each corner inside); {left}{behind}{pairs}",
        mesh.points().len(),
        several(mesh.face_count(), "face[ is|s are]"),
        several(faces, "face[|s]")
    );
    Ok((surface.into(), note))
}

/// The faces of a mesh refined, with what belongs to them, holes left out.
fn by_catmull_clark(cage: &Cage, from: &Mesh, levels: usize, limit: bool) -> Result<Mesh, OperationError> {
    let mut carried = Carried::new(from);
    (0..levels).for_each(|_| carried.refine());
    let fine = catmull_clark::refine_times(cage, levels)?;
    let kept: Vec<bool> = (0..fine.topology().face_count()).map(|f| !fine.is_hole(f)).collect();
    let mut mesh = fine.to_mesh()?;
    carried.give(from, &kept, &mut mesh);
    if limit {
        let frames = catmull_clark::limit_frames(&fine)?;
        put_at(&mut mesh, &frames);
        mesh.normals = catmull_clark::limit_normals(&fine, &frames)?;
    }
    Ok(mesh)
}

/// A Doo-Sabin form whose derivatives are scaled.
fn tuned(parameters: &Parameters, cage: Cage) -> Result<doo_sabin::Tuned, OperationError> {
    let mut tune = doo_sabin::FineTune::new(cage);
    match parameters.value("alpha") {
        Some(value) if value.is_array() => {
            let known = ["edge", "value"].map(|name| Field::required(name, "", ""));
            let mut once = Once::new("alpha");
            for table in parameters.tables("alpha")? {
                table.check(&known)?;
                let [a, b] = table.numbers("edge")?[..] else {
                    return Err(table.error("edge", "two vertices [i, j] are needed").into());
                };
                let edge = [index(&table, "edge", a)?, index(&table, "edge", b)?];
                let value = table.number("value")?;
                once.say(&edge, value).map_err(|e| table.error("value", e.to_string()))?;
                tune.scale(edge, value).map_err(|e| table.error("edge", e.to_string()))?;
            }
        }
        _ => tune.scale_all(parameters.number("alpha")?),
    }
    for vertex in if parameters.has("lock") { parameters.numbers("lock")? } else { Vec::new() } {
        let vertex = index(parameters, "lock", vertex)?;
        tune.pin(vertex).map_err(|e| parameters.error("lock", e.to_string()))?;
    }
    Ok(tune.solve()?)
}

/// The mesh refined; its limit is known in the middles of faces, which become the points of a mesh with a face around each inner
/// vertex.
fn by_doo_sabin(cage: &Cage, levels: usize, limit: bool) -> Result<Mesh, OperationError> {
    let fine = doo_sabin::refine_times(cage, levels)?;
    if !limit {
        return Ok(fine.to_mesh()?);
    }
    let (frames, topology) = (doo_sabin::limit_frames(&fine)?, fine.topology());
    let inner = (0..topology.vertex_count()).filter(|v| !topology.is_boundary_vertex(*v));
    let faces: Vec<Vec<usize>> = inner
        .map(|v| topology.vertex_faces(v).map(|f| f as usize).collect::<Vec<_>>())
        .filter(|face| face.len() > 2 && face.iter().all(|f| !fine.is_hole(*f)))
        .collect();
    if fine.has_end_intervals() {
        let size = cage.points().iter().fold(0.0, |most: f64, p| most.max(p.coords.amax()));
        let pairs = doo_sabin::double_knots(&fine);
        return Ok(welded_by(&frames, pairs.into_iter(), faces.into_iter(), size)?);
    }
    let points = frames.iter().map(|frame| frame.point).collect();
    let mut mesh = Mesh::new(points, &faces)?;
    put_at(&mut mesh, &frames);
    Ok(mesh)
}

/// Puts a mesh's points to limits; its normals are theirs where all have one.
fn put_at(mesh: &mut Mesh, frames: &[LimitFrame]) {
    let points: Vec<Point> = frames.iter().map(|frame| frame.point).collect();
    mesh.points_mut().copy_from_slice(&points);
    let normals: Option<Vec<Vector>> = frames.iter().map(LimitFrame::normal).collect();
    mesh.normals = normals.map_or_else(Layer::none, Layer::per_point);
}

fn check_size(parameters: &Parameters, levels: usize, count: f64, what: &str) -> Result<(), ParameterError> {
    if count > MOST {
        let problem = format!(
            "{levels} levels would make {count} {what}, and {MOST:.0e} are the most: take fewer",
            count = short(count)
        );
        return Err(parameters.error("levels", problem));
    }
    Ok(())
}

//! `section`: what planes cut from a Brep, a surface, a mesh, a curve or a polyline.

use loftsman_kernel::mesh::Cloud;
use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, Parameters, StepReport, in_own_coordinates,
    object_name,
};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::spline::Direction;
use loftsman_kernel::text::{a, counted, measured, told_apart, without_rounding};
use loftsman_kernel::{Error, Point, Vector};
use serde_json::json;

use super::{NAME, add_beside, as_curve, base_name, place, told, tolerance};
use crate::section::bounds;
use crate::{
    Contact, Options, Plane, ShellSection, brep_section, curve_plane, mesh_lines_section, mesh_section,
    mesh_section_above, mesh_section_area, section, trimmed_section,
};

/// The most planes of a step.
const MOST: usize = 10_000;

/// The operation `section`.
#[derive(Debug, Clone, Copy, Default)]
pub struct CutBy;

const PLANE: &[Field] = &[
    Field::optional("point", "[x, y, z]", "[0, 0, 0]", "a point of the plane"),
    Field::required("normal", "[x, y, z]", "the plane's normal, of any length"),
];

impl Operation for CutBy {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            Field::optional(
                "object",
                "text",
                "the only one that can be cut",
                "a brep, a surface, trimmed or not, a mesh, a curve or a polyline",
            ),
            Field::optional(
                "plane",
                "{ point, normal }",
                "this or axis is needed",
                "the plane, in the object's coordinates",
            ),
            Field::optional(
                "axis",
                "\"x\" | \"y\" | \"z\"",
                "this or plane is needed",
                "planes across this axis",
            ),
            Field::optional(
                "at",
                "number or [numbers]",
                "this or count, with axis",
                "where the planes are on the axis",
            ),
            Field::optional(
                "count",
                "1 to 10000",
                "this or at, with axis",
                "so many planes, evenly between the object's ends",
            ),
            Field::optional(
                "tolerance",
                "length",
                "1e-6 of the size",
                "largest distance of section curves from a brep or surface; parameter lines of a surface are exact",
            ),
            NAME,
        ];
        Declaration {
            name: "section",
            help: "what planes cut: of a brep or a surface curves, of a mesh polylines, of a curve, a polyline or a mesh's lines points; edges in the plane belong to it; reports the area of closed loops",
            fields: FIELDS,
        }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        parameters: &Parameters,
        context: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        parameters.check(self.declaration().fields)?;
        let usual = |g: &Geometry| {
            matches!(
                g,
                Geometry::Brep(_)
                    | Geometry::Surface(_)
                    | Geometry::Trimmed(_)
                    | Geometry::Mesh(_)
                    | Geometry::Curve(_)
            )
        };
        // Polylines, which sections of meshes are, are meant where there is nothing else, or by name.
        let none = !scene.objects().iter().any(|object| usual(object.geometry()));
        let fits = |g: &Geometry| usual(g) || none && matches!(g, Geometry::Polyline(_));
        let object = &object_name(scene, parameters, fits, "brep, surface, mesh, curve or polyline")?;
        let name = base_name(parameters, object, "section")?;
        let options = Options { tolerance: tolerance(parameters)? };
        let geometry =
            scene.object(object).map_err(|e| parameters.error("object", e.to_string()))?.geometry();
        let chords = match geometry {
            Geometry::Polyline(_) => {
                as_curve(geometry).map_err(|e| Error::Invalid(format!("\"{object}\": {e}")))?
            }
            _ => None,
        };
        let chords = chords.map(Geometry::from);
        let geometry = chords.as_ref().unwrap_or(geometry);
        let planes = planes(parameters, geometry)?;
        let mut geometries: Vec<Geometry> = Vec::new();
        let mut notes = Vec::new();
        let mut residual = None;
        // Planes that differ are named apart.
        let of_axis =
            |k: usize| told_apart(&planes.iter().map(|plane| plane.point()[k]).collect::<Vec<f64>>());
        let [xs, ys, zs] = [of_axis(0), of_axis(1), of_axis(2)];
        let (one, standing) = (scene.unit, scene.standing(object)?);
        // For each plane what is told of it in numbers.
        let mut told_planes = Vec::new();
        for (k, plane) in planes.iter().enumerate() {
            context.observer.proceed("sections", k as u64, planes.len() as u64)?;
            let at = format!("({}, {}, {})", xs[k], ys[k], zs[k]);
            let (before, known) = (geometries.len(), notes.len());
            let (mut touching, mut area): (Vec<Point>, Option<f64>) = (Vec::new(), None);
            // The parameter lines that pieces are.
            let mut lines = Vec::new();
            // Whether what is cut has loose points beside its pieces.
            let mut dots = false;
            let point_or_points = |count| counted(count, "point[|s]");
            match geometry {
                Geometry::Surface(surface) => {
                    let cut = section(surface, plane, &options)?;
                    area = cut.area;
                    for branch in cut.curves {
                        residual = Some(branch.distance.max(residual.unwrap_or(0.0)));
                        lines.extend(branch.isocurve);
                        geometries.push(branch.curve.into());
                    }
                    for q in cut.touching {
                        notes.push(format!("the plane through {at} touches it at {}", place(&q)));
                        touching.push(q);
                    }
                    for [u, v] in cut.coincident {
                        notes.push(format!(
                            "it lies in the plane through {at} for u from {} to {}, v from {} to {}",
                            told(u.0),
                            told(u.1),
                            told(v.0),
                            told(v.1)
                        ));
                    }
                    // What is left would be a section with a piece less.
                    if let Some([u, v]) = cut.undecided.first() {
                        return Err(Error::Invalid(format!(
                            "it is undecided whether the plane through {at} meets it for u from {} to {}, v from {} to {}: move the plane or turn it a little",
                            told(u.0),
                            told(u.1),
                            told(v.0),
                            told(v.1)
                        ))
                        .into());
                    }
                }
                Geometry::Mesh(mesh) => {
                    let lines = mesh_section(mesh, plane);
                    area = mesh_section_area(&lines, plane);
                    if let Some(above) = mesh_section_above(mesh, plane) {
                        let beside = if lines.is_empty() { "" } else { side(above) };
                        notes.push(format!("a face lies in the plane through {at}: not cut{beside}"));
                    }
                    geometries.extend(lines.into_iter().map(Geometry::from));
                    let met = mesh_lines_section(mesh, plane);
                    if met.lying > 0 {
                        let parts = counted(met.lying, "part[|s] of its lines [lies|lie]");
                        notes.push(format!("{parts} in the plane through {at}: not cut"));
                    }
                    if !met.points.is_empty() {
                        let points = point_or_points(met.points.len());
                        notes.push(format!("its lines meet the plane through {at} at {points}"));
                        geometries.push(Cloud { points: met.points }.into());
                        dots = true;
                    }
                }
                Geometry::Curve(curve) => {
                    let cut = curve_plane(curve, plane, &options)?;
                    residual = Some(cut.distance().max(residual.unwrap_or(0.0)));
                    if !cut.meetings.is_empty() {
                        dots = true;
                        geometries
                            .push(Cloud { points: cut.meetings.iter().map(|m| m.point).collect() }.into());
                    }
                    for (contact, how) in [(Contact::Crossing, "crosses"), (Contact::Touching, "touches")] {
                        let places = cut.meetings.iter().filter(|m| m.contact == contact).count();
                        if places > 0 {
                            let points = point_or_points(places);
                            notes.push(format!("it {how} the plane through {at} at {points}"));
                        }
                    }
                    for o in cut.overlaps {
                        notes.push(format!(
                            "it lies in the plane through {at} from {} to {}",
                            told(o.range.0),
                            told(o.range.1)
                        ));
                    }
                }
                Geometry::Brep(_) | Geometry::Trimmed(_) => {
                    let cut = match geometry {
                        Geometry::Brep(brep) => brep_section(brep, plane, &options)?,
                        Geometry::Trimmed(trimmed) => trimmed_section(trimmed, plane, &options)?,
                        _ => ShellSection::default(),
                    };
                    notes.extend(
                        cut.touching
                            .iter()
                            .map(|q| format!("the plane through {at} touches it at {}", place(q))),
                    );
                    if !cut.coincident.is_empty() {
                        let beside = match cut.shift {
                            shift if shift == 0.0 || cut.curves.is_empty() => "",
                            shift => side(shift > 0.0),
                        };
                        notes.push(format!(
                            "{} in the plane through {at}: not cut{beside}",
                            faces(&cut.coincident, "lies", "lie")
                        ));
                    }
                    // Where faces lie in it that was said above.
                    if cut.shift != 0.0 && cut.coincident.is_empty() && !cut.curves.is_empty() {
                        notes.push(format!(
                            "the plane through {at} passes a vertex or runs along an edge: what is cut was found {} along its normal, and laid into it",
                            one.quantity(cut.shift, 1)
                        ));
                    }
                    // What is left would be a section with a loop less, and a wrong area.
                    if !cut.undecided.is_empty() {
                        return Err(Error::Invalid(format!(
                            "{} undecided in the plane through {at}: which part of the surface is inside the loops cannot be told there; move the plane or turn it a little",
                            faces(&cut.undecided, "is", "are")
                        ))
                        .into());
                    }
                    touching.extend(&cut.touching);
                    area = cut.area;
                    for branch in cut.curves {
                        residual = Some(branch.distance.max(residual.unwrap_or(0.0)));
                        lines.extend(branch.isocurve);
                        geometries.push(branch.curve.into());
                    }
                }
                other => {
                    let problem = format!(
                        "\"{object}\" is {}: a section is cut from a brep, a surface, trimmed or not, a mesh, a curve or a polyline",
                        a(&other.noun())
                    );
                    return Err(Error::Invalid(problem).into());
                }
            }
            // As large as it stands.
            let area = area.map(|area| area * standing.of_areas_across(&plane.normal()));
            told_planes.push(json!({
                "point": (0..3).map(|k| plane.point()[k] + 0.0).collect::<Vec<f64>>(),
                "pieces": geometries.len() - before,
                "points": points_of(&geometries[before..]),
                "exact": lines.len(),
                "area": area,
                "touching": touching.iter().map(|q| [q.x + 0.0, q.y + 0.0, q.z + 0.0]).collect::<Vec<_>>(),
            }));
            match geometries.len() - before - usize::from(dots) {
                0 if notes.len() == known => notes.push(format!("the plane through {at} does not meet it")),
                0 => {}
                count => {
                    let area = area
                        .map(|area| format!(", an area of {}", one.quantity(area, 2)))
                        .unwrap_or_default();
                    let pieces = counted(count, "piece[|s]");
                    let exact = exactly(&lines, count);
                    notes.push(format!("the plane through {at} cuts {pieces}{area}{exact}"));
                }
            }
        }
        let longer = standing.most();
        if let (Some(wanted), Some(found)) = (options.tolerance, residual)
            && found > wanted
            && !matches!(geometry, Geometry::Curve(_))
        {
            notes.push(format!(
                "it is up to {} from the surface, farther than the tolerance: the surface turns too sharply there",
                one.quantity(longer * found, 1)
            ));
        }
        if let Some(found) = residual {
            let largest =
                scene.object(object)?.geometry().points().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
            let found = without_rounding(found, largest);
            match geometry {
                // Points are where the curve is: what is only rounding is not told.
                Geometry::Curve(_) if found == 0.0 => {}
                Geometry::Curve(_) => {
                    notes.push(format!(
                        "largest distance from the plane: {}",
                        one.quantity(longer * found, 1)
                    ));
                }
                _ => notes
                    .push(format!("largest distance from the surface: {}", one.quantity(longer * found, 1))),
            }
        }
        let cutting: &[&str] = match (parameters.has("plane"), parameters.has("count")) {
            (true, _) => &["plane"],
            (false, true) => &["axis"],
            (false, false) => &["axis", "at"],
        };
        notes.extend(in_own_coordinates(scene, object, parameters, cutting, &["tolerance"])?);
        add_beside(scene, object, &name, geometries)?;
        let mut numbers = serde_json::Map::new();
        numbers.insert("planes".into(), told_planes.into());
        if let Some(found) = residual {
            numbers.insert("distance".into(), (longer * found).into());
        }
        Ok(StepReport {
            op: "section".into(),
            object: Some(object.to_owned()),
            numbers,
            notes,
            ..StepReport::default()
        })
    }
}

/// How many pieces are exact, and which parameter lines they are: `; exact: the parameter line v = 0.5`.
fn exactly(lines: &[(Direction, f64)], pieces: usize) -> String {
    const NAMED: usize = 4;
    let name = |(direction, at): &(Direction, f64)| {
        format!("{} = {}", if *direction == Direction::U { "u" } else { "v" }, measured(*at))
    };
    let mut named: Vec<String> = lines.iter().map(name).collect();
    // A trimmed one may be in several pieces.
    named.dedup();
    let more = if named.len() > NAMED { ", …" } else { "" };
    let line = if named.len() == 1 { "the parameter line" } else { "the parameter lines" };
    named.truncate(NAMED);
    let named = named.join(", ");
    match lines.len() {
        0 => String::new(),
        all if all == pieces => format!("; exact: {line} {named}{more}"),
        some => format!("; {some} of them exact: {line} {named}{more}"),
    }
}

/// On which side of a plane what is cut is, where faces lie in it.
fn side(above: bool) -> &'static str {
    if above {
        "; what is cut is what lies just above it, where the plane's normal points"
    } else {
        "; what is cut is what lies just below it, away from the plane's normal"
    }
}

/// Faces in words: `face 3 lies`, `faces 3, 5, 7, … lie`.
fn faces(list: &[usize], one: &str, many: &str) -> String {
    const NAMED: usize = 5;
    if let [face] = list {
        return format!("face {face} {one}");
    }
    let named: Vec<String> = list.iter().take(NAMED).map(usize::to_string).collect();
    let more = if list.len() > NAMED { ", …" } else { "" };
    format!("faces {}{more} {many}", named.join(", "))
}

/// The planes of a step.
fn planes(parameters: &Parameters, geometry: &Geometry) -> Result<Vec<Plane>, OperationError> {
    // Each field is read for itself first, so that what is wrong with one is said of it.
    let plane = if parameters.has("plane") { Some(read_plane(parameters)?) } else { None };
    let axes = [("x", 0), ("y", 1), ("z", 2)];
    let axis = if parameters.has("axis") { Some(parameters.choice("axis", &axes)?) } else { None };
    let at = match parameters.value("at") {
        Some(value) if value.is_array() => Some(parameters.numbers("at")?),
        Some(_) => Some(vec![parameters.number("at")?]),
        None => None,
    };
    let count = if parameters.has("count") { Some(parameters.count("count")?) } else { None };
    let axis = match (plane, axis) {
        (Some(plane), None) if at.is_none() && count.is_none() => return Ok(vec![plane]),
        (None, Some(axis)) => axis,
        _ => {
            let problem = "give either plane = { point, normal } alone, or axis with at or count";
            return Err(parameters.error("", problem).into());
        }
    };
    let mut normal = Vector::zeros();
    normal[axis] = 1.0;
    let places = match (at, count) {
        (Some(_), Some(_)) | (None, None) => {
            return Err(parameters.error("", "axis goes with one of at and count").into());
        }
        (Some(places), None) => places,
        (None, Some(count)) => {
            if count == 0 || count > MOST {
                return Err(parameters.error("count", format!("{count} where 1 to {MOST} is needed")).into());
            }
            let (low, high) = match geometry {
                Geometry::Surface(surface) => surface.bounds(),
                Geometry::Curve(curve) => curve.bounds(),
                // The control vertices of its surfaces may be far beyond it.
                Geometry::Brep(brep) => bounds(brep).unwrap_or_default(),
                other => {
                    let points = other.points();
                    let first = points.first().copied().unwrap_or_else(Point::origin);
                    points.iter().fold((first, first), |(l, h), p| (l.inf(p), h.sup(p)))
                }
            };
            let step = (high[axis] - low[axis]) / (count + 1) as f64;
            (1..=count).map(|k| low[axis] + step * k as f64).collect()
        }
    };
    if places.is_empty() || places.len() > MOST {
        return Err(parameters
            .error(
                "at",
                match places.len() {
                    0 => format!("no place is named: 1 to {MOST} are needed"),
                    many => format!("{many} places are named: {MOST} are the most"),
                },
            )
            .into());
    }
    let plane = |at: f64| Plane::new(Point::from(normal * at), normal).map_err(OperationError::from);
    places.into_iter().map(plane).collect()
}

fn read_plane(parameters: &Parameters) -> Result<Plane, OperationError> {
    let table = parameters.table("plane")?;
    table.check(PLANE)?;
    let point = if table.has("point") { table.point("point")? } else { Point::origin() };
    Plane::new(point, table.vector("normal")?).map_err(|e| table.error("normal", e.to_string()).into())
}

/// The points at which lines and curves go through a plane, of all that was cut.
fn points_of(cut: &[Geometry]) -> Vec<[f64; 3]> {
    let clouds = cut.iter().filter(|geometry| matches!(geometry, Geometry::Cloud(_)));
    clouds.flat_map(Geometry::points).map(|p| [p.x + 0.0, p.y + 0.0, p.z + 0.0]).collect()
}

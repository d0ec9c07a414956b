//! `section`: what planes cut from a Brep, a surface, a mesh, a curve or a polyline, or from all that a group or an instance shows.

mod cut;
mod part;
mod planes;

use std::collections::HashSet;

use loftsman_kernel::Error;
use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, Parameters, StepReport, in_own_coordinates,
    object_among, object_name,
};
use loftsman_kernel::scene::{Geometry, Object, Scene, Unit};
use loftsman_kernel::spline::Direction;
use loftsman_kernel::text::{clip, counted, measured, told_apart, without_rounding};
use serde_json::{Value, json};

use self::cut::{Cut, Telling, cut};
use self::part::{Part, ends, is_cut, parts, showing};
use self::planes::planes;
use super::{Beside, NAME, add_beside, base_name, place, tolerance};
use crate::{Options, Plane};

/// The operation `section`.
#[derive(Debug, Clone, Copy, Default)]
pub struct CutBy;

impl Operation for CutBy {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            Field::optional(
                "object",
                "text",
                "the only one that can be cut",
                "a brep, a surface, trimmed or not, a mesh, a curve or a polyline; a group or an instance: all that it shows",
            ),
            Field::optional(
                "plane",
                "{ point, normal }",
                "this or axis is needed",
                "the plane, in the object's coordinates; where no point is given it goes through [0, 0, 0]",
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
            help: "what planes cut: of a brep or a surface curves, of a mesh polylines, of a curve, a polyline or a mesh's lines points; of a group or an instance all that it shows, part by part; edges in the plane belong to it; reports the area of closed loops",
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
        let object = &chosen(scene, parameters)?;
        let name = base_name(parameters, object, "section")?;
        let options = Options { tolerance: tolerance(parameters)? };
        scene.object(object).map_err(|e| parameters.error("object", e.to_string()))?;
        let parts = parts(scene, object)?;
        let planes = planes(parameters, || Ok(ends(&parts)?))?;
        let mut pieces: Vec<Beside> = Vec::new();
        let mut notes = Notes::default();
        let mut distance: Option<f64> = None;
        // Planes that differ are named apart.
        let of_axis =
            |k: usize| told_apart(&planes.iter().map(|plane| plane.point()[k]).collect::<Vec<f64>>());
        let [xs, ys, zs] = [of_axis(0), of_axis(1), of_axis(2)];
        let (unit, standing) = (scene.unit, scene.standing(object)?);
        // For each plane what is told of it in numbers.
        let mut told_planes = Vec::new();
        for (k, plane) in planes.iter().enumerate() {
            context.observer.proceed("sections", k as u64, planes.len() as u64)?;
            let at = format!("({}, {}, {})", xs[k], ys[k], zs[k]);
            let mut all = Level::default();
            for part in &parts {
                let own = part.own(plane)?;
                let found = part_cut(part, &own, &options, &at, unit, standing.most())?;
                if let Some(off) = found.distance {
                    let off = part.standing.most() * off;
                    distance = Some(off.max(distance.unwrap_or(0.0)));
                }
                let name = part.within(object).map_or_else(|| name.clone(), |part| format!("{name} {part}"));
                // As large as it stands.
                let larger =
                    part.standing.of_areas_across(&own.normal()) * standing.of_areas_across(&plane.normal());
                all.add(part, found, larger, &name, &mut pieces, &mut notes)?;
            }
            notes.close(&at, &all, parts.len(), unit);
            told_planes.push(all.numbers(plane));
        }
        let longer = standing.most();
        let only_curves = parts.iter().all(|part| matches!(part.geometry.as_ref(), Geometry::Curve(_)));
        if let (Some(wanted), Some(found)) = (options.tolerance, distance)
            && found > wanted
            && !only_curves
        {
            notes.tell(format!(
                "it is up to {} from the surface, farther than the tolerance: the surface turns too sharply there",
                unit.quantity(longer * found, 1)
            ));
        }
        if let Some(found) = distance {
            let reach = |part: &Part<'_>| {
                let own = part.geometry.points().iter().map(|p| part.seen(p).coords.amax());
                own.fold(0.0, f64::max)
            };
            let found = without_rounding(found, parts.iter().map(reach).fold(0.0, f64::max));
            let from = if only_curves { "plane" } else { "surface" };
            // Points are where the curve is: what is only rounding is not told.
            if !only_curves || found != 0.0 {
                notes.tell(format!("largest distance from the {from}: {}", unit.quantity(longer * found, 1)));
            }
        }
        let cutting: &[&str] = match (parameters.has("plane"), parameters.has("count")) {
            (true, _) => &["plane"],
            (false, true) => &["axis"],
            (false, false) => &["axis", "at"],
        };
        let mut notes = notes.list;
        if !parameters.has("object") {
            notes.extend(left(scene, object));
        }
        notes.extend(in_own_coordinates(scene, object, parameters, cutting, &["tolerance"])?);
        add_beside(scene, object, pieces)?;
        let mut numbers = serde_json::Map::new();
        numbers.insert("planes".into(), told_planes.into());
        if let Some(found) = distance {
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

/// What is cut where no object is named. Polylines, which sections of meshes are, are meant where there is no shape; groups and instances that show
/// something to cut where there is nothing else, or with the others that a step must choose from. `O(objects)`, and all that is shown where some of them are groups.
fn chosen(scene: &Scene, parameters: &Parameters) -> Result<String, OperationError> {
    const WHAT: &str = "brep, surface, mesh, curve, polyline, group or instance";
    if parameters.has("object") {
        return Ok(object_name(scene, parameters, |_| true, WHAT)?);
    }
    let is_line = |o: &&Object| matches!(o.geometry(), Geometry::Polyline(_));
    let shapes = scene.objects().iter().filter(|o| is_cut(o.geometry())).count();
    let lines = scene.objects().iter().filter(is_line).count();
    let (with_lines, with_groups) = (shapes == 0, shapes > 1 || (shapes == 0 && lines != 1));
    let is_group = |o: &Object| matches!(o.geometry(), Geometry::Group | Geometry::Instance(_));
    let full =
        if with_groups && scene.objects().iter().any(is_group) { showing(scene)? } else { HashSet::new() };
    let among = scene.objects().iter().filter(|o| match o.geometry() {
        Geometry::Polyline(_) => with_lines,
        Geometry::Group | Geometry::Instance(_) => with_groups && full.contains(o.name()),
        other => is_cut(other),
    });
    Ok(object_among(scene, parameters, among.map(Object::name), WHAT)?)
}

/// What is said of polylines beside the shape that is cut because it is the only one: those that sections of it have made are meant to stay.
fn left(scene: &Scene, object: &str) -> Option<String> {
    let is_line =
        |o: &&Object| matches!(o.geometry(), Geometry::Polyline(_)) && !o.name().starts_with(object);
    let cut = scene.object(object).ok()?;
    if matches!(cut.geometry(), Geometry::Polyline(_)) {
        return None;
    }
    let mut lines = scene.objects().iter().filter(is_line);
    let first = clip(lines.next()?.name());
    let more = lines.count();
    let others = if more > 0 { format!(" and {more} more") } else { String::new() };
    Some(format!(
        "only \"{}\" is cut; polylines where they are named by object = …: \"{first}\"{others}",
        clip(object)
    ))
}

/// What a plane, in a part's own coordinates, cuts from it, which is told in the coordinates of the whole.
fn part_cut(
    part: &Part<'_>,
    plane: &Plane,
    options: &Options,
    at: &str,
    unit: Unit,
    longer: f64,
) -> Result<Cut, OperationError> {
    let most = part.standing.most();
    let own = Options { tolerance: options.tolerance.map(|tolerance| tolerance / most) };
    let seen = |p: &loftsman_kernel::Point| place(&part.seen(p));
    let how = Telling { at, unit, longer: longer * most, seen: &seen };
    let found = cut(&part.geometry, plane, &own, &how);
    match &part.name {
        Some(name) => found.map_err(|e| Error::Invalid(format!("\"{name}\": {e}")).into()),
        None => found,
    }
}

/// What one plane cuts of all parts.
#[derive(Default)]
struct Level {
    area: Option<f64>,
    /// All pieces, and those that are clouds of points.
    pieces: usize,
    dots: usize,
    /// How many parts are cut.
    cut: usize,
    /// What has been said of the plane.
    said: usize,
    lines: Vec<(Direction, f64)>,
    points: Vec<[f64; 3]>,
    touching: Vec<[f64; 3]>,
    parts: Vec<Value>,
}

impl Level {
    /// Adds what is cut of a part to the level, and its pieces, in the coordinates of the whole, to all others.
    fn add(
        &mut self,
        part: &Part<'_>,
        found: Cut,
        larger: f64,
        name: &str,
        pieces: &mut Vec<Beside>,
        notes: &mut Notes,
    ) -> Result<(), Error> {
        let area = found.area.map(|area| area * larger);
        let count = found.pieces.len();
        self.area = area.map(|area| area + self.area.unwrap_or(0.0)).or(self.area);
        self.pieces += count;
        self.dots += usize::from(found.dots);
        self.cut += usize::from(count > usize::from(found.dots));
        self.said += found.notes.len();
        self.lines.extend(found.lines);
        let numbers = |p: &loftsman_kernel::Point| [p.x + 0.0, p.y + 0.0, p.z + 0.0];
        self.touching.extend(found.touching.iter().map(|q| numbers(&part.seen(q))));
        for piece in found.pieces {
            let piece = part.standing.seen(&piece)?.into_owned();
            // The points at which lines and curves go through the plane.
            if matches!(piece, Geometry::Cloud(_)) {
                self.points.extend(piece.points().iter().map(numbers));
            }
            pieces.push(Beside { name: name.to_owned(), geometry: piece, layer: part.layer.clone() });
        }
        if let Some(name) = &part.name
            && count > 0
        {
            self.parts.push(json!({ "object": name, "pieces": count, "area": area }));
        }
        notes.extend(part.name.as_deref(), found.notes);
        Ok(())
    }

    /// What `--json` tells of it.
    fn numbers(self, plane: &Plane) -> Value {
        let mut numbers = json!({
            "point": (0..3).map(|k| plane.point()[k] + 0.0).collect::<Vec<f64>>(),
            "pieces": self.pieces,
            "points": self.points,
            "exact": self.lines.len(),
            "area": self.area,
            "touching": self.touching,
        });
        if !self.parts.is_empty() {
            numbers["parts"] = self.parts.into();
        }
        numbers
    }
}

/// What is said of the parts of a whole: of many only some.
#[derive(Default)]
struct Notes {
    list: Vec<String>,
    of_parts: usize,
}

impl Notes {
    /// How much is said of single parts.
    const MOST: usize = 20;

    fn tell(&mut self, note: String) {
        self.list.push(note);
    }

    fn extend(&mut self, part: Option<&str>, notes: Vec<String>) {
        let Some(part) = part else {
            self.list.extend(notes);
            return;
        };
        for note in notes {
            self.of_parts += 1;
            if self.of_parts <= Self::MOST {
                self.list.push(format!("\"{part}\": {note}"));
            }
        }
    }

    /// What is said of a plane when all parts are cut.
    fn close(&mut self, at: &str, all: &Level, parts: usize, unit: Unit) {
        match all.pieces - all.dots {
            0 if all.said == 0 => self.tell(format!("the plane through {at} does not meet it")),
            0 => {}
            count => {
                let area = all
                    .area
                    .map(|area| format!(", an area of {}", unit.quantity(area, 2)))
                    .unwrap_or_default();
                let of =
                    if parts > 1 { format!(" of {}", counted(all.cut, "part[|s]")) } else { String::new() };
                let exact = exactly(&all.lines, count);
                self.tell(format!(
                    "the plane through {at} cuts {}{of}{area}{exact}",
                    counted(count, "piece[|s]")
                ));
            }
        }
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

//! Places of a recipe that are pointed at: `at = { closest = [x, y, z] }` is the location of the shape's nearest point.
//! One place for all operations, whoever wrote them: before a step runs, such a table becomes the parameters found.

use loftsman_kernel::brep::Brep;
use loftsman_kernel::error::Figure;
use loftsman_kernel::mesh::Polyline;
use loftsman_kernel::plugin::{Field, Operation, ParameterError, Parameters};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::shape::{Cell, Derivative, Location, Shape};
use loftsman_kernel::{Point, Result};
use serde_json::{Map, Value, json};

use super::deviation::distance;

/// The field of the table.
const CLOSEST: &str = "closest";
/// Fields that say where something that slides starts.
const STARTS: [&str; 2] = ["near", "other_near"];
/// The fields that hold locations or lists of them, of the object that the second field names. In a step itself those of them
/// do whose declaration says so: where `section` puts planes on an axis, `at` is a coordinate.
const FIELDS: [(&str, &str); 9] = [
    ("at", "object"),
    ("near", "object"),
    ("other_at", "other"),
    ("other_near", "other"),
    ("within", "object"),
    ("range", "object"),
    ("knots", "object"),
    ("u", "object"),
    ("v", "object"),
];
/// The most polynomial pieces that are searched where a shape has no search of its own, or for further places as near.
const CELLS: usize = 20_000;
/// A parameter that is a knot but for this part of the domain is that knot.
const AS_A_KNOT: f64 = 1e-9;
/// Two distances that differ by less than this share of the shape's size are one.
const AS_NEAR: f64 = 1e-7;

/// The fields of a step with each place that is pointed at found on the shape as it is now, and a note on each for the report;
/// the operation declares which of them hold places, and on what. `O(fields)` and a search for each place.
///
/// # Errors
/// When the table is no `{ closest = [x, y, z] }`, or its object is no shape with parameters.
pub(super) fn resolve(
    scene: &Scene,
    parameters: &Parameters,
    operation: &dyn Operation,
    notes: &mut Vec<String>,
) -> std::result::Result<Parameters, ParameterError> {
    let declared = operation.declaration().fields;
    let mut resolving = Resolving { scene, step: parameters, operation, declared, notes };
    let mut map = parameters.clone().into_map();
    resolving.table(&mut map, "", None)?;
    Parameters::new(Value::Object(map), parameters.path())
}

struct Resolving<'a> {
    scene: &'a Scene,
    step: &'a Parameters,
    operation: &'a dyn Operation,
    declared: &'static [Field],
    notes: &'a mut Vec<String>,
}

impl Resolving<'_> {
    /// A table at a path below the step, and the object that tables around it are about.
    fn table(
        &mut self,
        map: &mut Map<String, Value>,
        path: &str,
        around: Option<&str>,
    ) -> std::result::Result<(), ParameterError> {
        let named = |field: &str| map.get(field).and_then(Value::as_str).map(str::to_owned);
        let (own, other) = (named("object"), named("other"));
        let object = own.as_deref().or(around);
        // Of a surface that is asked about along one direction, one parameter is the location.
        let along = match map.get("direction").and_then(Value::as_str) {
            Some("u") => Some(0),
            Some("v") => Some(1),
            _ => None,
        };
        let in_step = path.is_empty();
        for (name, value) in map.iter_mut() {
            let path = if in_step { name.clone() } else { format!("{path}.{name}") };
            let known = FIELDS.iter().find(|(field, _)| field == name);
            match known.filter(|_| !in_step || self.is_location(name)) {
                // A parameter of its own, whatever the direction.
                Some((parameter @ ("u" | "v"), _)) => {
                    self.place(value, &path, object, Some(usize::from(*parameter == "v")))?;
                }
                // Of a surface an interval of u, and one of v.
                Some(("range", _)) if value.get(0).is_some_and(Value::is_array) => {
                    for (side, interval) in value.as_array_mut().into_iter().flatten().enumerate() {
                        self.place(interval, &format!("{path}[{side}]"), object, Some(side))?;
                    }
                }
                Some((_, "other")) => self.place(value, &path, other.as_deref(), along)?,
                Some(_) => self.place(value, &path, object, along)?,
                None => self.inside(value, &path, object)?,
            }
        }
        Ok(())
    }

    /// Whether a field of the step takes what is pointed at.
    fn is_location(&self, name: &str) -> bool {
        let takes = |field: &Field| field.takes.contains(CLOSEST) || field.takes == "location";
        self.declared.iter().any(|field| field.name == name && takes(field))
    }

    /// Tables further inside.
    fn inside(
        &mut self,
        value: &mut Value,
        path: &str,
        object: Option<&str>,
    ) -> std::result::Result<(), ParameterError> {
        match value {
            Value::Object(map) => self.table(map, path, object),
            Value::Array(list) => list
                .iter_mut()
                .enumerate()
                .try_for_each(|(index, value)| self.inside(value, &format!("{path}[{index}]"), object)),
            _ => Ok(()),
        }
    }

    /// A location, or a list of them.
    fn place(
        &mut self,
        value: &mut Value,
        path: &str,
        object: Option<&str>,
        along: Option<usize>,
    ) -> std::result::Result<(), ParameterError> {
        match value {
            Value::Object(map) if map.contains_key(CLOSEST) => {
                let table = Parameters::new(value.take(), format!("{}.{path}", self.step.path()))?;
                if let Some(beside) = table.names().find(|name| *name != CLOSEST) {
                    let problem = format!(
                        "\"{beside}\" stands beside closest: {{ closest = [x, y, z] }} is a whole location"
                    );
                    return Err(table.error("", problem));
                }
                let point = table.point(CLOSEST)?;
                *value = self.find(&table, path, point, object, along)?;
                Ok(())
            }
            Value::Object(map) if map.contains_key("face") && !map.contains_key("uv") => {
                self.whole_face(map.get("face"), path, object)
            }
            Value::Array(list) => list
                .iter_mut()
                .enumerate()
                .try_for_each(|(index, value)| self.place(value, &format!("{path}[{index}]"), object, along)),
            _ => self.inside(value, path, object),
        }
    }

    /// Of a face of a Brep the place must be given: its loops may leave out what is in the middle of its parameters.
    fn whole_face(
        &self,
        face: Option<&Value>,
        path: &str,
        object: Option<&str>,
    ) -> std::result::Result<(), ParameterError> {
        let name = match object {
            Some(name) => name.to_owned(),
            None => self.operation.object(self.scene, self.step)?,
        };
        let is_brep =
            |name: &str| self.scene.get(name).is_some_and(|o| matches!(o.geometry(), Geometry::Brep(_)));
        if !is_brep(&name) {
            return Ok(());
        }
        let face = face.map(Value::to_string).unwrap_or_default();
        let problem = format!(
            "a place on a face of \"{name}\" has parameters: give {{ face = {face}, uv = [u, v] }} (`loftsman info -v` tells those of a place inside it), or {{ closest = [x, y, z] }}"
        );
        Err(self.step.error(path, problem))
    }

    fn find(
        &mut self,
        table: &Parameters,
        path: &str,
        point: Point,
        object: Option<&str>,
        along: Option<usize>,
    ) -> std::result::Result<Value, ParameterError> {
        let name = match object {
            Some(name) => name.to_owned(),
            None => self.operation.object(self.scene, self.step)?,
        };
        let fail = |e: loftsman_kernel::Error| table.error("", e.to_string());
        let geometry = self.scene.object(&name).map_err(fail)?.geometry();
        let Found { at, distance: away, others } = nearest(geometry, point).map_err(|e| {
            let problem =
                format!("the closest place of \"{name}\" was asked for, but {e}; give its parameters");
            table.error("", problem)
        })?;
        let whole = value_of(at);
        let value = along.and_then(|k| whole.get(k).cloned()).unwrap_or(whole);
        let [x, y, z] = [point.x, point.y, point.z];
        let told = text_of(&value);
        let [x, y, z] = [x, y, z].map(|c| Figure(c + 0.0));
        let placed = self.scene.standing(&name).map_err(fail)?.to_world().is_some();
        let own = if placed { " in its own coordinates" } else { "" };
        let mut note = format!("{path} = {told} on \"{name}\": the nearest place to ({x}, {y}, {z}){own}, ");
        // The distance itself is only as good as the numbers that it is a difference of.
        let size = geometry.points().iter().fold(point.coords.amax(), |most, p| most.max(p.coords.amax()));
        note += &if away <= 16.0 * f64::EPSILON * size {
            "which it passes through".to_owned()
        } else {
            format!("{} away", self.scene.unit.quantity(away, 1))
        };
        // What slides or floats starts near: where that is farther than all of the shape is large, the point was meant for something else.
        let points = geometry.points();
        let extent = (0..3).map(|k| {
            let along = || points.iter().map(|p| p[k]);
            along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
        });
        let extent = extent.fold(0.0, f64::max);
        let field = path.rsplit('.').next().unwrap_or(path).split('[').next().unwrap_or(path);
        if STARTS.contains(&field) && away > extent {
            let problem = format!(
                "the nearest place of \"{name}\" is {} away from ({x}, {y}, {z}), farther than all of it is large ({}): give a point near to it, or a parameter",
                self.scene.unit.quantity(away, 1),
                self.scene.unit.quantity(extent, 1)
            );
            return Err(table.error(CLOSEST, problem));
        }
        if away > extent {
            note += ", farther than all of it is large";
        }
        if let Some(other) = others.first() {
            let more = if others.len() > 1 {
                format!(" and {} more places", others.len() - 1)
            } else {
                String::new()
            };
            note += &format!(
                "; {}{more} are as near: give the parameter if one of them is meant",
                text_of(&value_of(*other))
            );
        }
        self.notes.push(note);
        Ok(value)
    }
}

/// The nearest place of a shape.
struct Found {
    at: Location,
    distance: f64,
    /// Further places that are as near.
    others: Vec<Location>,
}

/// The place of a geometry that is nearest to a point: of curves and surfaces certified, of shapes of plug-ins from places of
/// each of their polynomial pieces downhill.
fn nearest(geometry: &Geometry, point: Point) -> Result<Found> {
    if let Geometry::Polyline(line) = geometry {
        return along(line, point);
    }
    let shape = geometry.shape()?;
    let short = |at| {
        let short = shortened(shape, at);
        match (geometry, at, short) {
            (Geometry::Brep(brep), Location::Face(face, u, v), Location::Face(_, x, y)) => {
                // Rounded out of the box around the loops it would be beside the face.
                let Some([low, high]) = reach(brep, face as usize) else { return short };
                let near = |k: usize, exact: f64, rounded: f64| {
                    let inside = low[k] <= exact && exact <= high[k];
                    if inside { rounded.clamp(low[k], high[k]) } else { rounded }
                };
                Location::Face(face, near(0, u, x), near(1, v, y))
            }
            _ => short,
        }
    };
    // Which places of a face or a trimmed surface are on it only its loops say.
    let bounded = matches!(geometry, Geometry::Brep(_) | Geometry::Trimmed(_));
    let near = if bounded { Vec::new() } else { candidates(shape, point)? };
    let best = match geometry {
        Geometry::Curve(curve) => curve.closest(point).map(|c| (Location::Curve(c.at), c.distance))?,
        Geometry::Surface(surface) => of_surface(surface, point)?,
        Geometry::Trimmed(trimmed) => {
            trimmed.part()?.closest(point).map(|c| (Location::Surface(c.at.0, c.at.1), c.distance))?
        }
        Geometry::Brep(brep) => {
            let found = brep.closest(point)?;
            let [u, v] = found.at;
            (Location::Face(found.face as u32, u, v), found.distance)
        }
        _ => near.first().map(|c| (c.at, c.distance)).ok_or_else(|| {
            invalid("it does not say of which polynomial pieces it consists, or has too many to be searched")
        })?,
    };
    let size = geometry.points().iter().map(|p| (p - point).amax()).fold(0.0, f64::max);
    let place = shape.value(best.0, Derivative::POSITION)?;
    let mut others: Vec<(Location, Point)> = Vec::new();
    for candidate in near.iter().take_while(|c| c.distance <= best.1 + AS_NEAR * size) {
        let apart = |at: Location, p: Point| {
            distance(&candidate.point, &p) > 1e3 * AS_NEAR * size || crossing(shape, candidate.at, at)
        };
        if apart(best.0, place.into()) && others.iter().all(|(at, p)| apart(*at, *p)) {
            others.push((candidate.at, candidate.point));
        }
    }
    let others = others.into_iter().map(|(at, _)| short(at)).collect();
    Ok(Found { at: short(best.0), distance: best.1, others })
}

/// The box around a face's loops in the parameters of its surface.
fn reach(brep: &Brep, face: usize) -> Option<[[f64; 2]; 2]> {
    let curves = brep.parameter_curves(face).ok()?;
    let boxes = curves.iter().flatten().map(|one| {
        let (from, to) = one.curve.range();
        let (low, high) = one.curve.curve().between(from, to).ok()?.bounds();
        Some([[low.x, low.y], [high.x, high.y]])
    });
    let around = |[a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]| {
        [[0, 1].map(|k| a[k].min(c[k])), [0, 1].map(|k| b[k].max(d[k]))]
    };
    boxes.reduce(|a, b| Some(around(a?, b?)))?
}

/// The place of a polyline that is nearest to a point, by the length up to there as a share of the whole: what a fit's parameters begin with.
fn along(line: &Polyline, point: Point) -> Result<Found> {
    let ends = line.points.iter().zip(line.points.iter().skip(1));
    let closing = line.points.last().zip(line.points.first()).filter(|_| line.closed);
    let (mut length, mut best) = (0.0, (f64::INFINITY, 0.0));
    for (a, b) in ends.chain(closing) {
        let (chord, size) = (b - a, distance(a, b));
        if size.is_nan() || size <= 0.0 {
            continue;
        }
        let share = ((point - a) / size).dot(&(chord / size)).clamp(0.0, 1.0);
        let off = distance(&(a + chord * share), &point);
        if off < best.0 {
            best = (off, length + share * size);
        }
        length += size;
    }
    if !(length > 0.0 && length.is_finite() && best.0.is_finite()) {
        return Err(invalid("its points have no length"));
    }
    let at = format!("{:.9}", best.1 / length).parse().unwrap_or(best.1 / length);
    Ok(Found { at: Location::Curve(at), distance: best.0, others: Vec::new() })
}

/// The location with parameters to a billionth of their domain, which people can read and copy: the place is the same to a
/// billionth of the shape's size or so. One that is a knot to that stays that knot, to the last bit: another one beside it would be a corner.
fn shortened(shape: &dyn Shape, at: Location) -> Location {
    let domain = match at {
        Location::Face(face, ..) => shape.face_domain(face),
        _ => shape.domain(),
    };
    let short = |u: f64, number: usize| {
        let side = domain.get(number);
        let (start, end) = side.map_or((0.0, 1.0), |side| (side.start, side.end));
        // Beyond its domain only what is periodic goes on.
        let (low, high) =
            if side.is_some_and(|side| side.periodic) { (start.min(u), end.max(u)) } else { (start, end) };
        let decimals = 9 - (end - start).log10().floor().clamp(-300.0, 300.0) as i32;
        let rounded =
            usize::try_from(decimals).ok().and_then(|decimals| format!("{u:.decimals$}").parse().ok());
        let face = match at {
            Location::Face(face, ..) => Some(face),
            _ => None,
        };
        let knot = knot_at(shape, face, number, u, AS_A_KNOT * (end - start));
        knot.unwrap_or_else(|| rounded.unwrap_or(u).clamp(low, high))
    };
    match at {
        Location::Curve(u) => Location::Curve(short(u, 0)),
        Location::Surface(u, v) => Location::Surface(short(u, 0), short(v, 1)),
        Location::Face(face, u, v) => Location::Face(face, short(u, 0), short(v, 1)),
        vertex @ Location::Vertex(_) => vertex,
    }
}

/// The end of a polynomial piece that is nearest to a parameter and no farther from it than this.
fn knot_at(shape: &dyn Shape, face: Option<u32>, side: usize, u: f64, within: f64) -> Option<f64> {
    let cells = shape.cells()?;
    let own = cells.iter().filter(|cell| cell.face == face);
    let ends = own.filter_map(|cell| cell.sides.get(side).map(|side| [side.start, side.end]));
    let near = ends.flatten().filter(|knot| (knot - u).abs() <= within);
    near.min_by(|a, b| (a - u).abs().total_cmp(&(b - u).abs()))
}

fn of_surface(surface: &loftsman_kernel::spline::Surface, point: Point) -> Result<(Location, f64)> {
    surface.closest(point).map(|c| (Location::Surface(c.at.0, c.at.1), c.distance))
}

fn invalid(what: &str) -> loftsman_kernel::Error {
    loftsman_kernel::Error::Invalid(what.to_owned())
}

/// Whether a curve passes one point at two parameters, which are not its two ends.
fn crossing(shape: &dyn Shape, a: Location, b: Location) -> bool {
    let (Location::Curve(a), Location::Curve(b)) = (a, b) else { return false };
    let domain = shape.domain();
    let Some(side) = domain.first() else { return false };
    let apart = (a - b).abs() / (side.end - side.start);
    (1e-3..1.0 - 1e-3).contains(&apart)
}

/// A place that is nearer than those around it.
struct Candidate {
    at: Location,
    point: Point,
    distance: f64,
}

/// Places of a shape that are nearer to a point than those around them in their polynomial piece, the nearest first; none
/// where it does not say of which pieces it consists, or has too many.
fn candidates(shape: &dyn Shape, point: Point) -> Result<Vec<Candidate>> {
    let Some(cells) = shape.cells().filter(|cells| cells.count() <= CELLS) else { return Ok(Vec::new()) };
    let mut all = Vec::new();
    for cell in cells.iter() {
        valleys(shape, &cell, point, &mut all)?;
    }
    all.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    Ok(all)
}

/// The valleys of the distance on one cell: from a grid, those of its places that are nearer than their neighbours, each
/// followed downhill by a grid that shrinks around it.
fn valleys(shape: &dyn Shape, cell: &Cell, point: Point, all: &mut Vec<Candidate>) -> Result<()> {
    let (rows, columns) = if cell.sides.len() < 2 { (13, 1) } else { (7, 7) };
    let share = |k: usize, of: usize| if of == 1 { 0.0 } else { k as f64 / (of - 1) as f64 };
    let look = |shares: [f64; 2]| -> Result<(Point, f64)> {
        let at = Point::from(shape.value(cell.at(shares), Derivative::POSITION)?);
        Ok((at, distance(&at, &point)))
    };
    let mut grid = Vec::with_capacity(rows * columns);
    for i in 0..rows {
        for j in 0..columns {
            grid.push(look([share(i, rows), share(j, columns)])?.1);
        }
    }
    let nearest = grid.iter().copied().fold(f64::INFINITY, f64::min);
    let reach = grid.iter().copied().fold(0.0, f64::max) - nearest;
    if all.iter().any(|c: &Candidate| c.distance < nearest - reach) {
        return Ok(());
    }
    for (k, &distance) in grid.iter().enumerate() {
        let (i, j) = (k / columns, k % columns);
        let around = (i.saturating_sub(1)..(i + 2).min(rows))
            .flat_map(|i| (j.saturating_sub(1)..(j + 2).min(columns)).map(move |j| (i, j)));
        if around.into_iter().any(|(i, j)| grid[i * columns + j] < distance) {
            continue;
        }
        let mut best = ([share(i, rows), share(j, columns)], look([share(i, rows), share(j, columns)])?);
        let mut step = share(1, rows);
        while step > 1e-12 {
            let (centre, before) = (best.0, best.1.1);
            for du in [-1.0, 0.0, 1.0] {
                for dv in if columns == 1 { &[0.0][..] } else { &[-1.0, 0.0, 1.0] } {
                    let next = [centre[0] + du * step, centre[1] + dv * step].map(|x| x.clamp(0.0, 1.0));
                    let found = look(next)?;
                    if found.1 < best.1.1 {
                        best = (next, found);
                    }
                }
            }
            if best.1.1 >= before {
                step *= 0.5;
            }
        }
        all.push(Candidate { at: cell.at(best.0), point: best.1.0, distance: best.1.1 });
    }
    Ok(())
}

/// A location in the words of a recipe: 0 and not 0.0.
fn text_of(value: &Value) -> String {
    let number =
        |value: &Value| value.as_f64().map_or_else(|| value.to_string(), |u| Figure(u + 0.0).to_string());
    match value {
        Value::Array(list) => format!("[{}]", list.iter().map(number).collect::<Vec<_>>().join(", ")),
        Value::Object(table) => {
            let told = |(key, value): (&String, &Value)| format!("{key} = {}", text_of(value));
            format!("{{ {} }}", table.iter().map(told).collect::<Vec<_>>().join(", "))
        }
        other => number(other),
    }
}

/// A location as a recipe's value.
fn value_of(at: Location) -> Value {
    match at {
        Location::Curve(u) => json!(u),
        Location::Surface(u, v) => json!([u, v]),
        Location::Face(face, u, v) => json!({ "face": face, "uv": [u, v] }),
        Location::Vertex(vertex) => json!({ "vertex": vertex }),
    }
}

#[cfg(test)]
mod tests;

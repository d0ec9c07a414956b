//! The operations of recipes.

mod intersect;
mod section;

use std::collections::{HashMap, HashSet};

use loftsman_kernel::plugin::{Field, OperationError, Parameters};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::text::measured as told;
use loftsman_kernel::{Error, Point};

pub use intersect::Intersect;
pub use section::CutBy;

const NAME: Field =
    Field::optional("name", "text", "after the object", "what the names of the results begin with");

/// The curve that a geometry is: a polyline is one of degree 1, whose parameter at a point is that one's number. `None` where it is none.
fn as_curve(geometry: &Geometry) -> Result<Option<Curve>, Error> {
    let line = match geometry {
        Geometry::Curve(curve) => return Ok(Some(curve.clone())),
        Geometry::Polyline(line) => line,
        _ => return Ok(None),
    };
    let (count, needed) = (line.points.len(), if line.closed { 3 } else { 2 });
    if count < needed {
        let closed = if line.closed { " closed" } else { "" };
        return Err(Error::Invalid(format!(
            "a{closed} polyline needs {needed} points at least, and has {count}"
        )));
    }
    let knots = |last: usize| (0..=last).map(|k| k as f64).collect::<Vec<f64>>();
    let mut points = line.points.clone();
    let space = if line.closed {
        // Vertex `i` of a periodic curve of degree 1 is at knot `i + 1`.
        points.rotate_left(1);
        Space::periodic(1, knots(count))?
    } else {
        Space::clamped(1, &knots(count - 1))?
    };
    Ok(Some(Curve::new(space, points)?))
}

/// A point for people; what is nothing beside its largest coordinate is 0.
fn place(point: &Point) -> String {
    let least = 1e-12 * point.coords.amax();
    let [x, y, z] = [point.x, point.y, point.z].map(|c| told(if c.abs() <= least { 0.0 } else { c }));
    format!("({x}, {y}, {z})")
}

/// What is added to a scene.
struct Beside {
    name: String,
    geometry: Geometry,
    /// Its layer, where it is not that of what it was made of.
    layer: Option<String>,
}

/// Adds objects beside the one that they were made of: placed as it is, and layered so where they say no other layer. All of them, or none.
fn add_beside(scene: &mut Scene, source: &str, pieces: Vec<Beside>) -> Result<(), OperationError> {
    let source = scene.object(source)?.clone();
    let mut added: Vec<String> = Vec::with_capacity(pieces.len());
    let mut apart = Apart::new(scene);
    for piece in pieces {
        let mut object = Object::new(apart.name(scene, &piece.name), piece.geometry);
        object.parent.clone_from(&source.parent);
        object.transform = source.transform;
        object.layer = piece.layer.or_else(|| source.layer.clone());
        let name = object.name().to_owned();
        if let Err(error) = scene.add(object) {
            for name in added.iter().rev() {
                scene.remove(name)?;
            }
            return Err(error.into());
        }
        added.push(name);
    }
    Ok(())
}

/// Names for pieces that are not those of other objects: the second piece of `rig cut box` is not `rig cut box.001` beside an object `box.001`, of which it
/// is none, but `rig cut box (2)`.
struct Apart {
    /// What objects are called that have a number behind a dot, without it.
    stems: HashSet<String>,
    /// The last number of each name that is counted so.
    counted: HashMap<String, u64>,
}

impl Apart {
    fn new(scene: &Scene) -> Self {
        let stem = |name: &str| {
            let (stem, number) = name.rsplit_once('.')?;
            (!number.is_empty() && number.bytes().all(|b| b.is_ascii_digit())).then(|| stem.to_owned())
        };
        let stems = scene.objects().iter().filter_map(|object| stem(object.name())).collect();
        Self { stems, counted: HashMap::new() }
    }

    /// A free name after `wanted`.
    fn name(&mut self, scene: &Scene, wanted: &str) -> String {
        if scene.get(wanted).is_none() {
            return wanted.to_owned();
        }
        let mut ends = wanted.match_indices([' ', '/']).map(|(at, _)| &wanted[at + 1..]);
        if !ends.any(|end| self.stems.contains(end)) {
            return scene.unique_name(wanted);
        }
        let last = self.counted.entry(wanted.to_owned()).or_insert(1);
        loop {
            *last += 1;
            let name = format!("{wanted} ({last})");
            if scene.get(&name).is_none() {
                return name;
            }
        }
    }
}

/// What the results are called: as asked for, or after the object.
fn base_name(parameters: &Parameters, object: &str, what: &str) -> Result<String, OperationError> {
    if !parameters.has("name") {
        return Ok(format!("{object} {what}"));
    }
    let name = parameters.text("name")?;
    if name.is_empty() {
        return Err(parameters.error("name", "is empty: give a name, or leave the field out").into());
    }
    Ok(name.to_owned())
}

/// The tolerance of a step, if it says one.
fn tolerance(parameters: &Parameters) -> Result<Option<f64>, OperationError> {
    if !parameters.has("tolerance") {
        return Ok(None);
    }
    let tolerance = parameters.number("tolerance")?;
    if tolerance <= 0.0 {
        return Err(parameters
            .error("tolerance", format!("{tolerance} where a positive length is needed"))
            .into());
    }
    Ok(Some(tolerance))
}

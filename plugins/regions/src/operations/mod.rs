//! The operations of recipes.

mod extrude;
mod fill;
mod loft;

use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::plugin::{
    Chord, Context, Field, Fineness, OperationError, Parameters, StepReport, Tessellator,
};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::text::without_rounding;
use loftsman_kernel::{Error, Point};

pub use extrude::Extrude;
pub use fill::Fill;
pub use loft::Loft;

use crate::error::{RegionError, Result};
use crate::fill::{Filled, Refinement, fill};
use crate::outline::Outline;

const OBJECTS: Field = Field::required(
    "objects",
    "[text, …]",
    "closed planar curves or polylines, or open ones that meet end to end; inner ones are holes; \"ring*\" is all whose names begin so",
);
const TOLERANCE: Field = Field::optional(
    "tolerance",
    "length",
    "1/1000 of the size",
    "largest distance between curves and chords",
);
const ANGLE: Field = Field::optional("angle", "degrees", "15", "largest angle between neighbouring chords");
const BRIDGE: Field =
    Field::optional("bridge", "true | false", "false", "close what is open by a straight line");
const SIZE: Field = Field::optional(
    "size",
    "length",
    "as large as they come",
    "no triangle larger than an equilateral one of this side",
);
const MIN_ANGLE: Field = Field::optional(
    "min_angle",
    "degrees, 0 to 30",
    "0",
    "smallest angle of triangles to aim for; caps keep their edges and may have smaller ones there",
);
const NAME: Field = Field::optional("name", "text", "after the first object", "the name of the result");

/// What bounds regions.
fn is_outline(geometry: &Geometry) -> bool {
    matches!(geometry, Geometry::Curve(_) | Geometry::Polyline(_))
}

fn fineness(parameters: &Parameters) -> Result<Fineness, OperationError> {
    let mut fineness = Fineness::default();
    if parameters.has("tolerance") {
        fineness.chord = Chord::Absolute(parameters.number("tolerance")?);
    }
    if parameters.has("angle") {
        fineness.angle = parameters.number("angle")?.to_radians();
    }
    Ok(fineness)
}

/// How fine the triangles are to be; walls need whole edges to fit.
fn refinement(parameters: &Parameters, whole_edges: bool) -> Result<Refinement, OperationError> {
    let size = if parameters.has("size") { Some(parameters.number("size")?) } else { None };
    Ok(Refinement { size, angle: parameters.number_or("min_angle", 0.0)?, whole_edges })
}

fn tessellator<'a>(context: &Context<'a>) -> Result<&'a dyn Tessellator, OperationError> {
    context.registry.tessellator().ok_or_else(|| Error::Invalid("no tessellator is registered".into()).into())
}

/// The name of what comes out: as asked for, where it is free, or after the first object.
fn result_name(
    scene: &Scene,
    parameters: &Parameters,
    first: &str,
    what: &str,
) -> Result<String, OperationError> {
    if !parameters.has("name") {
        return Ok(scene.unique_name(&format!("{first} {what}")));
    }
    let name = parameters.text("name")?;
    if scene.get(name).is_some() {
        return Err(parameters.error("name", format!("\"{name}\" is taken: choose another")).into());
    }
    Ok(name.to_owned())
}

/// What a result takes over from the object it was made of.
fn like(scene: &Scene, source: &str, name: &str, mesh: Mesh) -> Object {
    let mut object = Object::new(name, mesh.into());
    if let Some(source) = scene.get(source) {
        object.color = source.color;
        object.layer.clone_from(&source.layer);
        object.materials.clone_from(&source.materials);
    }
    object
}

/// An area or a volume that is a number.
fn finite(what: &'static str, value: f64) -> Result<f64> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(RegionError::Number {
        what,
        value,
        wanted: "it is beyond what numbers can hold; scale the objects down",
    })
}

/// What to say where triangles are not as fine as asked for.
fn unrefined(refined: bool) -> Option<String> {
    (!refined)
        .then(|| "some triangles are larger or sharper than asked for, next to edges that had to stay".into())
}

/// How near chords and triangles are to what they stand for.
#[derive(Debug, Clone, Copy, Default)]
struct Near {
    /// The largest distance between both, certified.
    error: f64,
    /// The largest that was asked for.
    tolerance: f64,
}

impl Near {
    fn and(self, error: f64, tolerance: f64) -> Self {
        Self { error: self.error.max(error), tolerance: self.tolerance.max(tolerance) }
    }

    /// Told in a report, of a mesh that has its `border` on what the objects are.
    fn tell(self, report: &mut StepReport, scene: &Scene, mesh: &Mesh, border: &str) {
        let size = mesh.points().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
        let error = without_rounding(self.error, size);
        report.notes.push(match error {
            0.0 => format!("nowhere off the {border}"),
            _ => format!(
                "within {} of the {border} everywhere ({} asked for)",
                scene.unit.quantity(error, 1),
                scene.unit.quantity(self.tolerance, 1)
            ),
        });
        report.numbers.insert("deviation".into(), error.into());
        report.numbers.insert("tolerance".into(), self.tolerance.into());
    }
}

/// How far from a line a point may be that is on it, relative to its length: rounding of the way to the plane and back.
const ON_LINE: f64 = 1e-9;

/// The chords of outlines, as one list of points and a ring of indices for each.
struct Chords {
    points: Vec<Point>,
    rings: Vec<(String, Vec<u32>)>,
    /// The outlines that a straight line closes.
    bridges: Vec<(String, [Point; 2])>,
    near: Near,
}

impl Chords {
    fn of(outlines: &[Outline], tessellator: &dyn Tessellator, fineness: &Fineness) -> Result<Self> {
        let mut chords =
            Self { points: Vec::new(), rings: Vec::new(), bridges: Vec::new(), near: Near::default() };
        for outline in outlines {
            let line = tessellator.moving_curve(std::slice::from_ref(&outline.curve), fineness)?;
            let (closed, mut points) = (line.closed, line.states.into_iter().next().unwrap_or_default());
            chords.near = chords.near.and(line.error, line.tolerance);
            if !closed && points.len() > 1 {
                // An outline that is not periodic ends in its first point.
                points.pop();
            }
            points.dedup();
            while points.len() > 1 && points.first() == points.last() {
                points.pop();
            }
            let first = chords.points.len() as u32;
            let ring = (first..first + points.len() as u32).collect();
            chords.points.extend(points);
            chords.rings.push((outline.name.clone(), ring));
            chords.bridges.extend(outline.bridge.map(|ends| (outline.name.clone(), ends)));
        }
        Ok(chords)
    }

    fn fill(&self, refinement: &Refinement) -> Result<Filled> {
        let rings: Vec<(&str, &[u32])> = self.rings.iter().map(|(n, r)| (n.as_str(), r.as_slice())).collect();
        fill(&self.points, &rings, refinement).map_err(|error| self.blame(error))
    }

    /// Where outlines meet on a line that only closes one of them, the line is named.
    fn blame(&self, error: RegionError) -> RegionError {
        let (names, [x, y, z]) = match &error {
            RegionError::SelfCrossing { object, x, y, z } => ([object, object], [*x, *y, *z]),
            RegionError::Crossing { first, second, x, y, z } => ([first, second], [*x, *y, *z]),
            _ => return error,
        };
        let at = Point::new(x, y, z);
        for [object, other] in [names, [names[1], names[0]]] {
            let on_line = |(_, [from, to]): &&(String, [Point; 2])| {
                let (along, arm) = (to - from, at - from);
                let t = (arm.dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
                (arm - along * t).norm() <= ON_LINE * along.norm()
            };
            if self.bridges.iter().filter(|(name, _)| name == object).any(|bridge| on_line(&bridge)) {
                let (object, other) = (object.clone(), other.clone());
                return RegionError::BridgeCrossing { object, other, x, y, z };
            }
        }
        error
    }
}

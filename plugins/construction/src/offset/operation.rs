//! The operation `offset`.

use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, Parameters, StepReport, in_own_coordinates,
    object_name,
};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::text::{a, without_rounding};

use super::{Corners, OffsetOptions, offset};
use crate::fields::{NAME, direction, free_name, length, like, made, named};
use crate::primitives::curve_through;

/// The operation `offset`: [`offset`](fn@super::offset).
#[derive(Debug, Clone, Copy, Default)]
pub struct OffsetOf;

impl Operation for OffsetOf {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            Field::optional("object", "text", "the only curve or polyline", "the planar curve"),
            Field::required(
                "distance",
                "length",
                "how far: outwards of what is closed where positive, else to the right of its way",
            ),
            Field::optional(
                "tolerance",
                "length",
                "1e-6 of its size",
                "how far the offset may be from where it should be",
            ),
            Field::optional(
                "corners",
                "\"round\" | \"sharp\" | \"open\"",
                "round",
                "joined by arcs, prolonged until they meet (up to four distances from the corner), or not joined",
            ),
            Field::optional(
                "normal",
                "[x, y, z]",
                "that of its plane",
                "from whose tip right is right; a straight line needs it",
            ),
            NAME,
        ];
        Declaration {
            name: "offset",
            help: "add the curves at a distance from a planar curve, on one side; parts nearer to it are cut away; reports the deviation",
            fields: FIELDS,
        }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        _: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        p.check(self.declaration().fields)?;
        let fits = |g: &Geometry| matches!(g, Geometry::Curve(_) | Geometry::Polyline(_));
        let source = object_name(scene, p, fits, "curve or polyline")?;
        let curve = match scene.object(&source)?.geometry() {
            Geometry::Curve(curve) => curve.clone(),
            Geometry::Polyline(line) => curve_through(line).map_err(named(&source))?,
            other => {
                let problem = format!("\"{source}\" is {}: name a curve or a polyline", a(&other.noun()));
                return Err(p.error("object", problem).into());
            }
        };
        let distance = p.number("distance")?;
        if distance == 0.0 {
            return Err(p.error("distance", "0 moves nothing: give another number").into());
        }
        let corners = [("round", Corners::Round), ("sharp", Corners::Sharp), ("open", Corners::Open)];
        let options = OffsetOptions {
            tolerance: if p.has("tolerance") { Some(length(p, "tolerance")?) } else { None },
            corners: p.choice_or("corners", &corners, Corners::Round)?,
            normal: if p.has("normal") {
                Some(direction(p, "normal", loftsman_kernel::Vector::z())?)
            } else {
                None
            },
            unit: Some(scene.unit),
        };
        let made_of = offset(&curve, distance, &options).map_err(named(&source))?;
        let mut changed = scene.clone();
        let unit = scene.unit;
        let largest = curve.points().iter().map(|p| p.coords.amax()).fold(distance.abs(), f64::max);
        // As it stands.
        let longer = scene.standing(&source)?.most();
        let (deviation, tolerance) = (longer * made_of.deviation, longer * made_of.tolerance);
        let mut notes = vec![format!(
            "{} from where it should be at most, measured both ways; {} were allowed",
            unit.quantity(without_rounding(deviation, longer * largest), 1),
            unit.quantity(tolerance, 1)
        )];
        if made_of.cut > 0 {
            let parts = if made_of.cut == 1 { "part was" } else { "parts were" };
            notes.push(format!("{} {parts} nearer to the curve and cut away", made_of.cut));
        }
        if made_of.strips {
            notes.push(format!(
                "where two sides are {} apart, twice the distance, nothing lies between: that strip of no width is left out",
                unit.quantity(2.0 * longer * distance.abs(), 1)
            ));
        }
        if made_of.blunted > 0 {
            let corners = if made_of.blunted == 1 { "corner is" } else { "corners are" };
            notes.push(format!("{} {corners} too sharp to be prolonged, and round", made_of.blunted));
        }
        let wanted = format!("{source} offset");
        let many = made_of.curves.len() > 1;
        let mut first = None;
        let (cut, blunted) = (made_of.cut, made_of.blunted);
        for curve in made_of.curves {
            let name = match p.has("name") {
                true if many => changed.unique_name(p.text("name")?),
                _ => free_name(&changed, p, &wanted)?,
            };
            let whose = if many { format!("\"{name}\": ") } else { String::new() };
            let (degree, vertices) = (curve.degree(), curve.points().len());
            notes.push(format!("{whose}degree {degree}, {vertices} control vertices"));
            changed.add(like(scene, &source, &name, curve.into()))?;
            first.get_or_insert(name);
        }
        let normal = if p.has("normal") { &["normal"][..] } else { &[] };
        notes.extend(in_own_coordinates(scene, &source, p, normal, &["distance", "tolerance"])?);
        *scene = changed;
        let mut report = made("offset", first.unwrap_or_default(), notes);
        report.numbers.insert("deviation".into(), deviation.into());
        report.numbers.insert("tolerance".into(), tolerance.into());
        report.numbers.insert("cut".into(), cut.into());
        report.numbers.insert("blunted".into(), blunted.into());
        Ok(report)
    }
}

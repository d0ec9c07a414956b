//! `match`: an edge of a surface made to meet another surface's edge, with as many knots as that needs.

mod asked;
mod attempt;
mod changed;
mod made;
mod remedy;
mod rounds;
mod rows;
mod seam;
mod turned;
mod ways;

use std::any::Any;

use loftsman_kernel::error::Error;
use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, Parameters, SceneShapes, SeenShapes, StepReport,
    object_name, other_object_name, put_back,
};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::spline::Surface;
use loftsman_kernel::text::a;

use crate::fields::{CONTINUITY, EDGE, LIMITS, WITH, other};
use asked::Asked;

/// The default tolerance, of the edge's size.
const TOLERANCE: f64 = 1e-4;
/// The most control vertices along the edge, or twice as many as it had, with continuity 0, 1 and 2.
const MOST: [usize; 3] = [256, 192, 128];

/// The operation `match`.
///
/// Its work is bounded: knots are inserted until there are 256, 192 or 128 (by continuity) control vertices along the edge (or twice as many as it had),
/// and where the whole surface bends only as long as the bordered system stays within what the solver `saddle-point` takes. Knots
/// stop where three estimates in a row, from what the last ones brought, say that twice as many as that would be needed. What is refused so is tried once more with
/// the degree and the knots of the other edge, and the remedies that a refusal names were tried, with no more than some times its own work.
#[derive(Debug, Clone, Copy, Default)]
pub struct MatchOperation;

impl Operation for MatchOperation {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            Field::optional("object", "text", "the only other surface", "the surface that moves"),
            EDGE,
            WITH,
            CONTINUITY,
            Field::optional(
                "tolerance",
                "length",
                "1/10,000 of the edge's size",
                "how far the edges may be apart",
            ),
            LIMITS[1],
            LIMITS[2],
            Field::optional(
                "keep",
                "0 | 1 | 2 | \"nothing\"",
                "as continuity",
                "what stays at the opposite edge: position, tangent planes, curvature",
            ),
            Field::optional(
                "metric",
                "\"bend\" | \"least\"",
                "bend; least where that folds, goes much farther or cannot be measured",
                "whether the whole surface follows, bending little, or only what is beside the edge",
            ),
            Field::optional(
                "refine",
                "true | false",
                "true",
                "insert knots where that brings it within the limits",
            ),
        ];
        Declaration {
            name: "match",
            help: "move an edge of a surface to another surface's, smoothly (G1, G2), with knots inserted as needed; reports what \
                   is left",
            fields: FIELDS,
        }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        context: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        p.check(self.declaration().fields)?;
        let with = other(p)?;
        let beside = with.text("object")?.to_owned();
        scene.object(&beside).map_err(|e| with.error("object", e.to_string()))?;
        let object = if p.has("object") {
            object_name(scene, p, |_| true, "surface")?
        } else {
            let fits = |g: &Geometry| matches!(g, Geometry::Surface(_));
            other_object_name(scene, p, &beside, fits, "other surface")?
        };
        if object == beside {
            return Err(with
                .error("object", "the surface that moves cannot stand still: name another")
                .into());
        }
        let still = scene.object(&beside)?;
        if still.geometry().shape().is_ok_and(|shape| shape.domain().len() == 1) {
            let problem = format!(
                "\"{beside}\" is {}, which has no edge: the edge of a surface is brought onto a curve by the constraint `edge`, in an `edit`",
                a(&still.geometry().noun())
            );
            return Err(with.error("object", problem).into());
        }
        if !matches!(scene.object(&object)?.geometry(), Geometry::Surface(_)) {
            let kind = a(&scene.object(&object)?.geometry().noun());
            let problem = match scene.object(&object)?.geometry() {
                Geometry::Curve(_) => format!(
                    "\"{object}\" is {kind}: `match` moves surfaces. Curves are brought together by the constraint `join`, with continuity = 0, 1 or 2, \
                     in an `edit`"
                ),
                Geometry::Custom(_) | Geometry::Brep(_) | Geometry::Trimmed(_) => format!(
                    "\"{object}\" is {kind}: only B-spline surfaces get knots as they need them; ask for the constraint `match` in an `edit`"
                ),
                _ => format!("\"{object}\" is {kind}: `match` moves B-spline surfaces"),
            };
            return Err(p.error("object", problem).into());
        }
        let mut names = SceneShapes::new(scene, &object)?;
        let asked = Asked::new(p, &with, &mut names, scene.unit)?;
        let SeenShapes { names, shapes, frames } = names.into_parts()?;
        let [first, second] = &shapes[..] else {
            return Err(Error::Invalid("two surfaces are needed".into()).into());
        };
        let any: &dyn Any = first.as_shape();
        let Some(surface) = any.downcast_ref::<Surface>() else {
            return Err(Error::Invalid(format!("\"{object}\" is no B-spline surface")).into());
        };
        let made = asked.run(surface, second.as_ref(), context)?;
        let mut report = made.report("match", &object, &asked);
        report.notes.extend(frames.note());
        let mut edited = scene.clone();
        put_back(&mut edited, &names[0], frames.own_shape(0, made.edited.shape()).as_ref())?;
        *scene = edited;
        Ok(report)
    }
}

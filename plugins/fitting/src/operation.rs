//! The operation `fit`: points become a curve.

mod asked;
mod interpolate;
mod points;
mod report;

use std::borrow::Cow;

use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, ParameterError, Parameters, StepReport,
    asked_in_own_coordinates, object_name,
};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::{Error, Point};

use self::asked::fit_of;
use self::interpolate::interpolate;
use self::points::{corner, is_scattered, one_chain, rounded};
pub(crate) use self::report::place;
use self::report::report_of;

/// The operation `fit`: a polyline, cloud or mesh (its points in their order) becomes a B-spline curve, by least
/// squares to a tolerance, with a given number of vertices, or by interpolation.
#[derive(Debug, Clone, Copy, Default)]
pub struct FitPoints;

const DECLARATION: Declaration = Declaration {
    name: "fit",
    help: "a polyline, a cloud or a mesh's points, in their order, become a B-spline curve",
    fields: &[
        Field::optional(
            "object",
            "text",
            "the only polyline; where there is none, the only cloud or mesh",
            "the object whose points are fitted; the curve takes its place",
        ),
        Field::optional("degree", "1 to 25", "3", "the degree of the curve"),
        Field::optional(
            "tolerance",
            "number",
            "none",
            "no point farther from the curve than this, in document units",
        ),
        Field::optional(
            "relative_tolerance",
            "number",
            "1e-4 where nothing else is asked for",
            "the same as a share of the diagonal of the points' box",
        ),
        Field::optional(
            "vertices",
            "whole number",
            "as many as the tolerance needs",
            "how many control vertices; with a tolerance, at most how many",
        ),
        Field::optional("interpolate", "true | false", "false", "pass through every point exactly"),
        Field::optional(
            "closed",
            "true | false",
            "as the polyline; false for others",
            "close the curve smoothly (periodic); false for a closed polyline keeps the corner where it starts",
        ),
        Field::optional(
            "corners",
            "degrees | \"auto\"",
            "none: a smooth curve",
            "divide the fit where the points turn by more than this; \"auto\": by more than 60°, and as sharply over six tolerances; where points scatter, two curves near the points on either side do, and what is doubtful is told. Where the turn is shared by the points before and after (a round nose) there is no corner",
        ),
        Field::optional(
            "parameters",
            "\"chord\" | \"centripetal\" | \"uniform\" | [numbers]",
            "\"chord\"; \"centripetal\" where interpolation swings",
            "the parameters to start from; a list has one number a point, and one more for a closed curve",
        ),
        Field::optional(
            "corrections",
            "whole number",
            "4",
            "the most parameter corrections between two additions of knots; 0 keeps the parameters",
        ),
        Field::optional(
            "ends",
            "\"keep\" | \"free\"; interpolating: \"averaged\" | \"not-a-knot\" | \"natural\"",
            "\"keep\"; \"averaged\"",
            "what an open curve does at its ends",
        ),
        Field::optional(
            "merge",
            "true | false",
            "false",
            "leave out points that coincide with the one before, when interpolating",
        ),
        Field::optional("weights", "[numbers]", "all 1", "a positive weight a point"),
        Field::optional(
            "constraints",
            "[{ kind, …, to }, …]",
            "none",
            "what must hold exactly, at locations from 0 to 1",
        ),
        Field::optional(
            "regularization",
            "number",
            "0",
            "how strongly to straighten vertices that the points leave open (1e-6 is little)",
        ),
        Field::optional(
            "smooth",
            "true | false",
            "true",
            "spend what the tolerance leaves over on an even curvature",
        ),
        Field::optional(
            "best_effort",
            "true | false",
            "false",
            "take the best curve found where the tolerance cannot be met",
        ),
    ],
};

impl Operation for FitPoints {
    fn declaration(&self) -> Declaration {
        DECLARATION
    }

    fn object(&self, scene: &Scene, parameters: &Parameters) -> Result<String, ParameterError> {
        let lines = scene.objects().iter().any(|o| matches!(o.geometry(), Geometry::Polyline(_)));
        let fits = |g: &Geometry| match g {
            Geometry::Polyline(_) => true,
            Geometry::Cloud(_) | Geometry::Mesh(_) => !lines,
            _ => false,
        };
        object_name(scene, parameters, fits, "polyline, cloud or mesh")
    }

    fn apply(
        &self,
        scene: &mut Scene,
        parameters: &Parameters,
        context: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        parameters.check(DECLARATION.fields)?;
        let name = self.object(scene, parameters)?;
        let name = name.as_str();
        let object = scene.object(name).map_err(|e| parameters.error("object", e.to_string()))?;
        let (points, chain) = match object.geometry() {
            Geometry::Polyline(line) => (line.points.as_slice(), line.closed),
            Geometry::Cloud(cloud) => (cloud.points.as_slice(), false),
            Geometry::Mesh(mesh) => {
                one_chain(mesh).map_err(|what| {
                    Error::Invalid(format!(
                        "\"{name}\" is a mesh of {what}, and a curve would go through the points of all, one after the other: \
                         converted to OBJ and read from there each line is a polyline, to fit by itself"
                    ))
                })?;
                (mesh.points(), false)
            }
            other => {
                let kind = loftsman_kernel::text::a(&other.noun());
                return Err(Error::Invalid(format!(
                    "\"{name}\" is {kind}: points are fitted, so give a polyline, a cloud or a mesh"
                ))
                .into());
            }
        };
        let closed = if parameters.has("closed") { parameters.flag("closed")? } else { chain };
        // A closed chain that is fitted open keeps its corner where it starts, and still comes back there.
        let back = chain && !closed && !parameters.has("parameters") && !parameters.has("weights");
        let points: Cow<'_, [Point]> = match points.first() {
            Some(&first) if back => points.iter().copied().chain([first]).collect(),
            _ => points.into(),
        };
        let points = points.as_ref();
        let (curve, mut report) = if parameters.flag("interpolate")? {
            interpolate(points, closed, parameters, scene.unit)?
        } else {
            let fit = fit_of(closed, name, parameters, context)?;
            let fitted = fit.watched(points, context.observer)?;
            let mut report = report_of(&fitted, points, scene.unit);
            if parameters.has("corners") {
                report.notes.extend(rounded(&fitted, points, closed, scene.unit)?);
            }
            (fitted.curve, report)
        };
        if is_scattered(points) {
            report.warnings.push(
                "the curve goes through the points in the order in which they are, and turns back at most of them: points that lie all over a surface, and not \
                 along a line, are fitted by `fit-shape`"
                    .into(),
            );
        } else if !parameters.has("corners") {
            report.notes.extend(corner(points, closed, parameters)?);
        }
        report.notes.extend(asked_in_own_coordinates(scene, name)?);
        let report = StepReport { op: DECLARATION.name.into(), object: Some(name.to_owned()), ..report };
        scene.replace(name, curve)?;
        Ok(report)
    }
}

//! `fit-shape`: a shape is brought near to points.

use loftsman_kernel::text::{figure, short};
use std::sync::Arc;

use loftsman_kernel::energy::Energy;
use loftsman_kernel::placement::transform_point;
use loftsman_kernel::plugin::{
    Context, Declaration, Field, Mark, Operation, OperationError, ParameterError, Parameters, SceneShapes,
    SeenShapes, StepReport, ask_once, constraint_from, editable, object_name, put_back,
};
use loftsman_kernel::scene::{Geometry, Scene, Unit};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::{Error, Point};
use nalgebra::Matrix4;

use crate::error::FitError;
use crate::operation::place;

use super::{CloudFit, CloudReport, DerivativeEnergy, ITERATIONS, TOLERANCE};

/// The operation `fit-shape`: a curve, a surface or a shape of any other kind (the limit surface of a cage) is moved as near to a
/// cloud as it can come.
#[derive(Debug, Clone, Copy, Default)]
pub struct FitShape;

const DECLARATION: Declaration = Declaration {
    name: "fit-shape",
    help: "a curve, a surface or the limit of a cage is moved as near as it can come to points",
    fields: &[
        Field::optional(
            "object",
            "text",
            "the only curve or surface",
            "the object that is moved, from where it is",
        ),
        Field::required(
            "points",
            "text",
            "the cloud, polyline or mesh whose points it comes near to; it stays",
        ),
        Field::optional("weights", "[numbers]", "all 1", "a positive weight a point"),
        Field::optional(
            "energy",
            "\"stretch\" | \"membrane\" | \"bend\" | \"thin-plate\" | \"variation\"",
            "\"bend\"; \"stretch\" of degree 1",
            "what the shape has little of beside (not where fair = 0)",
        ),
        Field::optional(
            "fair",
            "number",
            "from the noise",
            "the weight of the energy beside the mean of the squared distances (1e-6 is little, 0 none)",
        ),
        Field::optional(
            "constraints",
            "[{ kind, …, to | by | scale | keep }, …]",
            "none",
            "what holds exactly; other objects that it names stay as they are",
        ),
        Field::optional("lock", "[index, …]", "none", "control vertices that may not move; -1 is the last"),
        Field::optional(
            "relative_tolerance",
            "number",
            "1e-9",
            "the search ends when no foot moves by more than this part of the points' diagonal",
        ),
        Field::optional(
            "iterations",
            "whole number",
            "100",
            "steps, at most, beside those by which the weight is tried on points left out",
        ),
        Field::optional(
            "smooth",
            "0 | 1 | 2",
            "1",
            "at repeated knots, what was smooth stays so: 1 tangents, 2 curvatures too, 0 corners may appear",
        ),
        Field::optional(
            "solver",
            "name",
            "automatic",
            "the constraints' solver; `loftsman plugins` lists them",
        ),
    ],
};

impl Operation for FitShape {
    fn declaration(&self) -> Declaration {
        DECLARATION
    }

    fn apply(
        &self,
        scene: &mut Scene,
        parameters: &Parameters,
        context: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        parameters.check(DECLARATION.fields)?;
        let object = object_name(scene, parameters, editable(scene), "curve or surface")?;
        let mut names = SceneShapes::new(scene, &object)?;
        let tables = parameters.tables("constraints")?;
        let mut constraints = Vec::with_capacity(tables.len());
        for table in &tables {
            constraints.push(constraint_from(context.registry, table, &mut names)?);
        }
        ask_once(names.shapes(), &constraints, &tables)?;
        let solver = parameters.text_or("solver", "automatic")?;
        let solver = context.registry.find_solver(solver, &format!("{}.solver", parameters.path()))?;
        let solver = Arc::clone(solver);
        let SeenShapes { names, shapes, frames } = names.into_parts()?;
        let from = parameters.text("points")?;
        if scene.position(from).is_none() {
            return Err(parameters
                .error("points", scene.object(from).map_or_else(|e| e.to_string(), |_| String::new()))
                .into());
        }
        let points = points(scene, from, &names)?;
        let built = |orders: &[usize]| {
            let (mut fit, unfair) =
                fit_of(parameters, shapes[0].as_ref(), CloudFit::new(&shapes[0]), orders)?;
            for other in &shapes[1..] {
                fit = fit.with(other.boxed());
            }
            Ok::<_, ParameterError>((constraints.iter().cloned().fold(fit, CloudFit::ask), unfair))
        };
        let start = context.clock.seconds();
        let (fit, mut unfair) = built(&[2, 1])?;
        let mut fitted = fit.watched(&points, &solver, context.observer);
        if let Err(FitError::Undetermined { vertices, rank, .. }) = &fitted
            && !parameters.has("energy")
            && !parameters.has("fair")
        {
            // Nobody asked for this energy, and what it does not see another one does.
            let told = format!(
                "the points and \"bend\" determine {rank} of {vertices} control vertices: the energy is \"stretch\", which keeps near to the others what no point sees"
            );
            let other = built(&[1])?.0.watched(&points, &solver, context.observer);
            if other.is_ok() {
                (fitted, unfair) = (other, Some(told));
            }
        }
        let fitted = fitted.map_err(|error| advised(error, parameters, shapes[0].as_ref()))?;
        let seconds = context.clock.seconds() - start;
        let before: Vec<Box<dyn Shape>> =
            (0..shapes.len()).map(|index| frames.own_shape(index, shapes[index].as_ref())).collect();
        let after = frames.own_shape(0, fitted.shape().as_ref());
        let all: Vec<&dyn Shape> =
            std::iter::once(after.as_ref()).chain(before[1..].iter().map(AsRef::as_ref)).collect();
        let mut report = report_of(&object, fitted.report(), &points, scene.unit, shapes[0].as_ref());
        report.prepare_seconds = Some(seconds);
        report.marks = constraints.iter().filter_map(|c| Mark::of(c, &names, &before, &all)).collect();
        report.notes.extend(unfair);
        report.notes.extend(frames.note());
        put_back(scene, &object, after.as_ref())?;
        Ok(report)
    }
}

/// The points of an object, in the coordinates of the shapes: their own where all of these are placed alike, else the world's.
fn points(scene: &Scene, name: &str, shapes: &[String]) -> Result<Vec<Point>, OperationError> {
    let points = match scene.object(name)?.geometry() {
        Geometry::Polyline(line) => line.points.as_slice(),
        Geometry::Cloud(cloud) => cloud.points.as_slice(),
        Geometry::Mesh(mesh) => mesh.points(),
        other => {
            let kind = loftsman_kernel::text::a(&other.noun());
            let text = format!(
                "\"{name}\" is {kind}: a shape is fitted to points, so give a cloud, a polyline or a mesh"
            );
            return Err(Error::Invalid(text).into());
        }
    };
    let world = scene.world_transforms()?;
    let place = |name: &str| {
        let known = scene.position(name).and_then(|at| world.get(at).copied().flatten());
        known.unwrap_or_else(Matrix4::identity)
    };
    let alike = shapes.windows(2).all(|pair| place(&pair[0]) == place(&pair[1]));
    let (own, of) = (place(name), shapes.first().map_or_else(Matrix4::identity, |s| place(s)));
    if alike && own == of {
        return Ok(points.to_vec());
    }
    let back = if alike { of.try_inverse() } else { Some(Matrix4::identity()) };
    let map = back.map(|back| back * own).filter(|map| map.iter().all(|c| c.is_finite())).ok_or_else(|| {
        Error::Invalid(format!(
            "\"{}\" is placed by a transform that flattens it, so that \"{name}\" is nowhere in its coordinates: correct its transform",
            shapes.first().map_or("", String::as_str)
        ))
    })?;
    Ok(points.iter().map(|p| transform_point(&map, p)).collect())
}

/// A fit of a shape of whatever kind.
type AnyFit = CloudFit<Box<dyn Shape>>;

/// What the fields ask of a fit, with the first energy of these orders that the shape has where nobody asks for one, and what there is to say where it
/// has none.
fn fit_of(
    parameters: &Parameters,
    shape: &dyn Shape,
    mut fit: AnyFit,
    orders: &[usize],
) -> Result<(AnyFit, Option<String>), ParameterError> {
    let mut unfair = None;
    // The words that `fair` knows.
    let words = [("stretch", 1), ("membrane", 1), ("bend", 2), ("thin-plate", 2), ("variation", 3)];
    let order = parameters.choice_or("energy", &words, 2)?;
    let weight = if parameters.has("fair") { Some(parameters.number("fair")?) } else { None };
    match weight {
        Some(weight) if !(weight >= 0.0 && weight.is_finite()) => {
            return Err(parameters.error("fair", "a positive number is needed, or 0 for no energy"));
        }
        Some(0.0) if parameters.has("energy") => {
            return Err(parameters.error("energy", "has no weight: \"fair\" is 0"));
        }
        Some(0.0) => {}
        Some(weight) => fit = fit.energy(weight, DerivativeEnergy(order)).steady(),
        None if parameters.has("energy") => fit = fit.fair(DerivativeEnergy(order)),
        None => {
            let has = |order: &usize| DerivativeEnergy(*order).squares(shape, Point::origin()).is_ok();
            match orders.iter().copied().find(has) {
                Some(order) => fit = fit.fair(DerivativeEnergy(order)),
                None => {
                    let why = DerivativeEnergy(1).squares(shape, Point::origin()).err();
                    unfair = why.map(|e| format!("nothing keeps the shape fair beside its points: {e}"));
                }
            }
        }
    }
    if parameters.has("weights") {
        fit = fit.weights(parameters.numbers("weights")?);
    }
    if parameters.has("lock") {
        fit = fit.lock(parameters.integers("lock")?);
    }
    let smooth = match parameters.count_or("smooth", 1)? {
        level @ 0..=2 => level as u8,
        level => return Err(parameters.error("smooth", format!("{level} is not 0, 1 or 2"))),
    };
    let fit = fit
        .tolerance(parameters.number_or("relative_tolerance", TOLERANCE)?)
        .iterations(parameters.count_or("iterations", ITERATIONS)?)
        .smooth(smooth);
    Ok((fit, unfair))
}

/// Where vertices are left open: what would determine them, in the words of the fields.
fn advised(error: FitError, parameters: &Parameters, shape: &dyn Shape) -> FitError {
    let FitError::Undetermined { rank, vertices, first } = error else { return error };
    let stretched = parameters.text("energy").is_ok_and(|word| ["stretch", "membrane"].contains(&word));
    let without = parameters.number("fair").is_ok_and(|weight| weight == 0.0);
    let advice = if DerivativeEnergy(1).squares(shape, Point::origin()).is_err() || stretched && !without {
        "give points where it acts, or lock it"
    } else if without {
        "leave \"fair\" out, or set energy = \"stretch\" with a little \"fair\" (1e-6), which keep near to the others what no point sees"
    } else {
        "energy = \"stretch\" keeps near to the others what no point sees; or give points where it acts, or lock it"
    };
    FitError::Request(format!(
        "the points determine {rank} of {vertices} control vertices, and vertex {first} is the first that is left open: {advice}"
    ))
}

fn report_of(
    object: &str,
    report: &CloudReport,
    points: &[Point],
    unit: Unit,
    shape: &dyn Shape,
) -> StepReport {
    let dimensions = shape.domain().len();
    let length = |x: f64| unit.quantity(x, 1);
    let place = points.get(report.worst).map(|p| format!(" {}", place(p))).unwrap_or_default();
    let mut notes = vec![format!(
        "largest distance from the points {}, at point {}{place}; root mean square {} → {}; {} points",
        length(report.largest),
        report.worst,
        figure(report.before),
        length(report.rms),
        points.len()
    )];
    if let Some(weight) = report.fair {
        notes.push(format!(
            "the energy's weight follows from the noise: fair = {weight} asks for the same, fair = 0 for none", weight = figure(weight)));
    }
    if report.fair.is_some() && report.few && !report.met {
        notes.push(format!(
            "the shape may pass through any so few points with {} control vertices, so that their noise is not seen in full: if they have some, give more points, fewer control vertices or \"fair\"",
            shape.control_vertices().len()
        ));
    }
    if report.fair.is_some() && report.met {
        notes.push(format!(
            "the shape passes through all points, as it may through any so few with {} control vertices, so that their noise is not seen: if they have some, give more points, fewer control vertices or \"fair\"",
            shape.control_vertices().len()
        ));
    }
    if report.at_reach {
        notes.push("where few points are the shape was held back, no farther from where it began than ten times the size of points and shape: leave \"fair\" out or give a larger one".to_owned());
    } else if !report.converged {
        notes.push(format!(
            "after {} steps the last one still moved a foot by {}: more iterations would come nearer",
            report.iterations,
            short(report.change)
        ));
    }
    let mut warnings = Vec::new();
    if report.outweighed {
        let [was, is] = report.measure.map(|m| unit.quantity(m, dimensions));
        let what = if dimensions < 2 { "length" } else { "area" };
        warnings.push(format!(
            "the energy outweighs the points: the root mean square of their distances is {} ({} before), the {what} {is} ({was} before): give a smaller \"fair\", or leave it out, so that it follows from the noise",
            length(report.rms),
            length(report.before),
        ));
    }
    warnings.extend(astray(report, unit, dimensions));
    StepReport {
        warnings,
        op: DECLARATION.name.into(),
        object: Some(object.to_owned()),
        solver: Some(report.solver.clone()),
        equations: Some(report.equations),
        rank: Some(report.rank),
        redundant: report.redundant.clone(),
        residual: Some(report.residual),
        adjustment: Some(report.adjustment),
        iterations: Some(report.iterations),
        constraints: report.constraints.clone(),
        notes,
        leading: 1,
        ..StepReport::default()
    }
}

/// What there is to say of a shape that lies where no point is, or looks the other way than it did.
fn astray(report: &CloudReport, unit: Unit, dimensions: usize) -> Vec<String> {
    let mut warnings = Vec::new();
    let turned = report.turned;
    if let Some([x, y, z]) = turned.at {
        let [x, y, z] = [x, y, z].map(figure);
        warnings.push(format!(
            "on {} of {} faces the surface looks the other way than it did ({:.1} % of its places, one is ({x}, {y}, {z})): it is folded, or turned inside out; give a larger \"fair\", fewer control vertices, or a shape that is nearer to begin with",
            turned.faces,
            turned.of,
            100.0 * turned.share,
        ));
    }
    if report.is_beyond() {
        let [was, is] = report.measure.map(|m| unit.quantity(m, dimensions));
        let [near, far] = report.beyond.map(|x| unit.quantity(x, 1));
        let what = if dimensions < 2 { "length" } else { "area" };
        warnings.push(format!(
            "the shape goes where no point is: it lies up to {far} from the nearest one ({near} before), its {what} is {is} ({was} before): lock or constrain what no point sees, or give points there"
        ));
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::super::Turned;
    use super::*;

    #[test]
    fn what_went_astray_is_told_with_its_numbers() {
        let told = |report: &CloudReport| astray(report, Unit::Metre, 2).join("\n");
        let near = CloudReport {
            before: 0.5,
            rms: 0.1,
            beyond: [1.0, 1.7],
            measure: [2.0, 5.0],
            ..CloudReport::default()
        };
        assert_eq!(told(&near), "");
        let far = CloudReport { beyond: [1.0, 1.9], ..near.clone() };
        let text = told(&far);
        assert!(
            ["1.9 m", "1 m before", "5 m²", "2 m² before"].iter().all(|part| text.contains(part)),
            "{text}"
        );
        // It was in place, and is crumpled.
        let large = CloudReport { before: 0.2, ..near.clone() };
        assert!(told(&large).contains("5 m² (2 m² before)"), "{}", told(&large));
        let turned = Turned { share: 0.125, faces: 3, of: 24, at: Some([1.0, -2.0, 0.5]) };
        let text = told(&CloudReport { turned, ..near });
        assert!(
            ["on 3 of 24 faces", "12.5 %", "(1, -2, 0.5)"].iter().all(|part| text.contains(part)),
            "{text}"
        );
    }
}

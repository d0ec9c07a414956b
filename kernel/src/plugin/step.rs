//! What operations on shapes share: the objects that a step is about, as shapes of a problem, and the way back into the scene.

use std::any::Any;
use std::collections::HashSet;

use super::{Frames, ParameterError, Parameters};
use crate::brep::{Brep, Moving};
use crate::edit::Constraint;
use crate::error::{Error, Result};
use crate::functional::{ShapeNames, Shapes, equations_of, value_of};
use crate::scene::{CURVE_OF_POLYLINE, LINES_OF_MESH};
use crate::scene::{Geometry, Object, Scene};
use crate::shape::Shape;
use crate::spline::{Curve, Surface, Trimmed};
use crate::text::{a, clip};

/// The shapes of a step's problem: the step's own object first, then those that constraints name.
#[derive(Debug)]
pub struct SceneShapes<'a> {
    scene: &'a Scene,
    names: Vec<String>,
    shapes: Vec<Box<dyn Shape>>,
    /// Whether Breps may be among them: for operations that keep their faces together.
    solids: bool,
}

/// The shapes of a step's problem in one frame.
#[derive(Debug)]
pub struct SeenShapes {
    /// The objects' names.
    pub names: Vec<String>,
    /// Copies of their shapes.
    pub shapes: Vec<Box<dyn Shape>>,
    /// The frame that these are in, and the way back.
    pub frames: Frames,
}

impl<'a> SceneShapes<'a> {
    /// The problem of one object.
    ///
    /// # Errors
    /// As for [`shape_of`].
    pub fn new(scene: &'a Scene, object: &str) -> Result<Self> {
        let shapes = vec![shape_of(scene, object)?];
        Ok(Self { scene, names: vec![object.to_owned()], shapes, solids: false })
    }

    /// The problem of one object, which may be a Brep, and so may others: for operations that ask an [`Edit`](crate::edit::Edit) to move
    /// shapes, which keeps faces together, and let no shape go without it. Of the object itself `moving` says which faces may.
    ///
    /// # Errors
    /// As for [`shape_of`], but for Breps.
    pub fn with_solids(scene: &'a Scene, object: &str, moving: Moving) -> Result<Self> {
        let shape = match scene.object(object)?.geometry() {
            Geometry::Brep(brep) => Box::new(brep.clone().moving(moving)),
            _ => shape_of(scene, object)?,
        };
        Ok(Self { scene, names: vec![object.to_owned()], shapes: vec![shape], solids: true })
    }

    /// Copies of the shapes so far.
    pub fn shapes(&self) -> &[Box<dyn Shape>] {
        &self.shapes
    }

    /// The objects' names, copies of their shapes, and the frame in which these are: their own where all are placed alike, else
    /// that of the world.
    ///
    /// # Errors
    /// As for a placement that cannot be undone, naming the object.
    pub fn into_parts(mut self) -> Result<SeenShapes> {
        let frames = Frames::new(self.scene, &self.names, &mut self.shapes)?;
        Ok(SeenShapes { names: self.names, shapes: self.shapes, frames })
    }
}

impl ShapeNames for SceneShapes<'_> {
    fn shape(&mut self, object: &str) -> Result<usize> {
        if let Some(known) = self.names.iter().position(|n| n == object) {
            return Ok(known);
        }
        let shape: Box<dyn Shape> = match self.scene.object(object)?.geometry() {
            Geometry::Brep(brep) if self.solids => Box::new(brep.clone()),
            _ => shape_of(self.scene, object)?,
        };
        self.shapes.push(shape);
        self.names.push(object.to_owned());
        Ok(self.names.len() - 1)
    }

    fn name(&self, shape: usize) -> Option<&str> {
        self.names.get(shape).map(String::as_str)
    }
}

/// A copy of a curve, a surface, a trimmed surface or a plug-in's shape of the scene.
///
/// # Errors
/// When there is no such object, it is something else, or its plug-in is not here.
pub fn shape_of(scene: &Scene, object: &str) -> Result<Box<dyn Shape>> {
    match scene.object(object)?.geometry() {
        Geometry::Curve(curve) => Ok(Box::new(curve.clone())),
        Geometry::Surface(surface) => Ok(Box::new(surface.clone())),
        // Edited as the surface that carries it; its loops stay.
        Geometry::Trimmed(trimmed) => Ok(Box::new(trimmed.clone())),
        Geometry::Custom(custom) => custom
            .shape()
            .map(Shape::boxed)
            .map_err(|e| Error::Invalid(format!("\"{object}\" cannot be edited: {e}"))),
        Geometry::Brep(_) => Err(Error::Invalid(format!(
            "\"{object}\" is a brep, whose faces hang together, which this does not keep: \"edit\" and \"drag\" do"
        ))),
        line @ Geometry::Polyline(_) => {
            Err(Error::Invalid(format!("\"{object}\" is {}", line.other_than("a curve or surface"))))
        }
        other => Err(Error::Invalid(format!(
            "\"{object}\" is {}: fit one to it first",
            other.other_than("a curve or surface")
        ))),
    }
}

/// What a step edits where it does not say which object: curves, surfaces, shapes of plug-ins; trimmed surfaces and Breps where a scene has
/// none of them.
pub fn editable(scene: &Scene) -> impl Fn(&Geometry) -> bool + use<> {
    let whole = |g: &Geometry| matches!(g, Geometry::Curve(_) | Geometry::Surface(_) | Geometry::Custom(_));
    let none = !scene.objects().iter().any(|object| whole(object.geometry()));
    move |g| whole(g) || none && matches!(g, Geometry::Trimmed(_) | Geometry::Brep(_))
}

/// How many objects a message names.
const NAMED: usize = 8;

/// What to say where no object of a scene fits, that `beside` not asked.
fn none(scene: &Scene, beside: Option<&str>, what: &str) -> String {
    let mut there = String::new();
    let objects: Vec<&Object> = scene.objects().iter().filter(|o| Some(o.name()) != beside).collect();
    for (k, object) in objects.iter().take(NAMED).enumerate() {
        let comma = if k > 0 { ", " } else { "" };
        there += &format!("{comma}\"{}\" is {}", clip(object.name()), a(&object.geometry().noun()));
    }
    let mut told = match (objects.len(), beside.and_then(|name| scene.get(name))) {
        (0, None) => format!("the scene has no {what}: it is empty"),
        (0, Some(only)) => {
            let (name, kind) = (clip(only.name()), a(&only.geometry().noun()));
            format!("the scene has no {what}: it has only \"{name}\", {kind}")
        }
        (count, _) if count > NAMED => format!("the scene has no {what}: {there}, …"),
        _ => format!("the scene has no {what}: {there}"),
    };
    let curves = what.split([' ', ',']).any(|word| word == "curve");
    if curves && objects.iter().any(|o| matches!(o.geometry(), Geometry::Polyline(_))) {
        told += &format!("; {CURVE_OF_POLYLINE}");
    }
    let curves = what.split([' ', ',']).any(|word| word == "curve" || word == "polyline");
    if curves && objects.iter().any(|o| o.geometry().is_lines()) {
        told += &format!("; a mesh of lines is polylines otherwise: {LINES_OF_MESH}");
    }
    told
}

/// The objects that a field lists by their names, each once. A name that ends in `*`, and that no object has, stands for all objects that begin so and that
/// `fit`, in the order of the scene. `O(names + objects)` for each such name.
///
/// # Errors
/// When the field is no list of texts, or empty, names an object twice, or no object that fits begins so.
pub fn object_names(
    scene: &Scene,
    parameters: &Parameters,
    field: &str,
    fits: impl Fn(&Geometry) -> bool,
) -> Result<Vec<String>, ParameterError> {
    let mut names: Vec<String> = Vec::new();
    let mut seen: HashSet<String> = HashSet::new();
    for (i, value) in parameters.list(field)?.iter().enumerate() {
        let Some(name) = value.as_str() else {
            let problem = format!("entry {i} is {value}, where the name of an object is needed");
            return Err(parameters.error(field, problem));
        };
        let stem = name.strip_suffix('*').filter(|_| scene.get(name).is_none());
        let Some(stem) = stem else {
            if !seen.insert(name.to_owned()) {
                return Err(parameters.error(field, format!("\"{}\" is named twice", clip(name))));
            }
            names.push(name.to_owned());
            continue;
        };
        let begin = scene.objects().iter().filter(|o| o.name().starts_with(stem));
        let (fitting, others): (Vec<&Object>, Vec<&Object>) = begin.partition(|o| fits(o.geometry()));
        if fitting.is_empty() {
            let stem = clip(stem);
            let problem = match others.first() {
                None => format!("no object's name begins with \"{stem}\""),
                Some(other) => format!(
                    "of what begins with \"{stem}\" nothing fits: \"{}\" is {}",
                    clip(other.name()),
                    a(&other.geometry().noun())
                ),
            };
            return Err(parameters.error(field, problem));
        }
        // Those that are named beside it are there already.
        let new = fitting.into_iter().map(|o| o.name().to_owned()).filter(|name| seen.insert(name.clone()));
        names.extend(new);
    }
    if names.is_empty() {
        return Err(parameters.error(field, "is empty: name an object at least"));
    }
    Ok(names)
}

/// The object that a step is about: the one that its field `object` names, or the only one that `fits`; `what` says
/// in messages what fits.
///
/// # Errors
/// When there is no such object, none that fits, or more than one.
pub fn object_name(
    scene: &Scene,
    parameters: &Parameters,
    fits: impl Fn(&Geometry) -> bool,
    what: &str,
) -> Result<String, ParameterError> {
    named_or_only(scene, parameters, None, fits, what)
}

/// The same where another object is named already, which does not count: `what` is then the "other" of its kind.
///
/// # Errors
/// As for [`object_name`].
pub fn other_object_name(
    scene: &Scene,
    parameters: &Parameters,
    beside: &str,
    fits: impl Fn(&Geometry) -> bool,
    what: &str,
) -> Result<String, ParameterError> {
    named_or_only(scene, parameters, Some(beside), fits, what)
}

fn named_or_only(
    scene: &Scene,
    parameters: &Parameters,
    beside: Option<&str>,
    fits: impl Fn(&Geometry) -> bool,
    what: &str,
) -> Result<String, ParameterError> {
    if parameters.has("object") {
        let name = parameters.text("object")?;
        scene.object(name).map_err(|e| parameters.error("object", e.to_string()))?;
        return Ok(name.to_owned());
    }
    let others = scene.objects().iter().filter(|o| Some(o.name()) != beside && fits(o.geometry()));
    only_of(scene, parameters, beside, others.map(Object::name), what)
}

/// The object that a step is about: the one that its field `object` names, or the only one of those whose `names` are given; `what` says in messages
/// what fits. For operations that ask more of an object than its geometry tells.
///
/// # Errors
/// When there is no such object, none in the list, or more than one.
pub fn object_among<'a>(
    scene: &Scene,
    parameters: &Parameters,
    names: impl IntoIterator<Item = &'a str>,
    what: &str,
) -> Result<String, ParameterError> {
    if parameters.has("object") {
        return object_name(scene, parameters, |_| true, what);
    }
    only_of(scene, parameters, None, names, what)
}

fn only_of<'a>(
    scene: &Scene,
    parameters: &Parameters,
    beside: Option<&str>,
    fitting: impl IntoIterator<Item = &'a str>,
    what: &str,
) -> Result<String, ParameterError> {
    let fitting: Vec<&str> = fitting.into_iter().take(NAMED + 1).collect();
    match fitting[..] {
        [only] => Ok(only.to_owned()),
        [] => Err(parameters.error("", none(scene, beside, what))),
        _ => {
            let named: Vec<String> =
                fitting.iter().take(NAMED).map(|name| format!("\"{}\"", clip(name))).collect();
            let more = if fitting.len() > NAMED { ", …" } else { "" };
            let problem = format!("say which object it is about, by object = …: {}{more}", named.join(", "));
            Err(parameters.error("", problem))
        }
    }
}

/// Asks every functional for its value, so that what cannot be asked of these shapes (a location outside the domain, a
/// vertex that does not exist) is an error of its own table. Knots that `within` inserts would change the question.
///
/// # Errors
/// The first of these.
pub fn ask_once(
    shapes: &[Box<dyn Shape>],
    constraints: &[Constraint],
    tables: &[Parameters],
) -> Result<(), ParameterError> {
    let shapes = Shapes::new(shapes.iter().map(AsRef::as_ref));
    let mut values = Vec::new();
    for (constraint, table) in constraints.iter().zip(tables) {
        let functional = constraint.functional().as_ref();
        values.resize(equations_of(functional).map_err(|e| table.error("", e.to_string()))?, 0.0);
        value_of(functional, &shapes, &mut values).map_err(|e| table.error("", e.to_string()))?;
    }
    Ok(())
}

/// Puts a changed shape back into the scene: a plug-in's shape as the same kind.
///
/// # Errors
/// When there is no such object, or the shape is none that a scene holds.
pub fn put_back(scene: &mut Scene, name: &str, shape: &dyn Shape) -> Result<()> {
    if let Geometry::Custom(custom) = scene.object(name)?.geometry() {
        let changed = custom.with_shape(shape.boxed())?;
        return scene.replace(name, changed);
    }
    // A scene's geometries are types, so that here, and only here, shapes are told by theirs: what `shape_of` took out goes back.
    let any: &dyn Any = shape;
    if let Some(curve) = any.downcast_ref::<Curve>() {
        return scene.replace(name, curve);
    }
    if let Some(trimmed) = any.downcast_ref::<Trimmed>() {
        return scene.replace(name, trimmed);
    }
    if let Some(brep) = any.downcast_ref::<Brep>() {
        return scene.replace(name, brep);
    }
    match any.downcast_ref::<Surface>() {
        Some(surface) => scene.replace(name, surface),
        None => Err(Error::Invalid(format!("\"{name}\" became something that a scene cannot hold"))),
    }
}

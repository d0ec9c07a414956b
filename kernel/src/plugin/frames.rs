//! Objects of one problem that are placed differently, seen in one frame.

use nalgebra::Matrix4;

use super::Parameters;
use crate::Point;
use crate::error::{Error, Result};
use crate::scene::Scene;
use crate::scene::placement::transform_point;
use crate::shape::Shape;

/// What is said of one object, or of some that are placed alike.
const OWN: &str = "the object is placed by a transform: everything asked of it, and how well that is met, is in its own coordinates, as they are without that; how long \
                   or large it is, and how far it is from the old shape, is told as it stands in the scene";

/// What a report should say of an object that is placed by a transform, where a step asks things of its shape.
///
/// # Errors
/// As for [`Scene::standing`].
pub fn asked_in_own_coordinates(scene: &Scene, name: &str) -> Result<Option<String>> {
    Ok(scene.standing(name)?.to_world().map(|_| OWN.into()))
}

/// The frame in which the shapes of a problem are seen. Where all are placed alike, that is their own; where they are not, it is
/// the world's: a join, an area or a distance between them means nothing in coordinates that differ.
#[derive(Debug, Clone, Default)]
pub struct Frames {
    /// One a shape where they are placed differently; none where that is not so.
    each: Vec<Frame>,
    /// How all are placed, where they are placed alike, and not as they stand in the world.
    alike: Option<Matrix4<f64>>,
}

#[derive(Debug, Clone)]
struct Frame {
    /// From the world to the object's own coordinates.
    back: Matrix4<f64>,
    own: Vec<Point>,
    seen: Vec<Point>,
}

impl Frames {
    /// Takes shapes of a scene's objects into one frame.
    ///
    /// # Errors
    /// When the hierarchy is cyclic, an object's placement flattens it, so that nothing in the world says where its vertices go,
    /// or a coordinate overflows.
    pub(super) fn new(scene: &Scene, names: &[String], shapes: &mut [Box<dyn Shape>]) -> Result<Self> {
        let world = scene.world_transforms()?;
        let place = |name: &String| scene.position(name).and_then(|at| world.get(at).copied().flatten());
        let places: Vec<Matrix4<f64>> =
            names.iter().map(|name| place(name).unwrap_or_else(Matrix4::identity)).collect();
        if places.windows(2).all(|pair| pair[0] == pair[1]) {
            let alike = places.first().copied().filter(|place| *place != Matrix4::identity());
            return Ok(Self { each: Vec::new(), alike });
        }
        let mut frames = Vec::with_capacity(places.len());
        for ((name, to_world), shape) in names.iter().zip(places).zip(shapes) {
            let back = to_world.try_inverse().filter(|back| back.iter().all(|v| v.is_finite()));
            let back = back.ok_or_else(|| {
                Error::Invalid(format!(
                    "\"{name}\" is placed by a transform that flattens it, so that it cannot be edited together with objects that \
                     are placed otherwise: correct its transform"
                ))
            })?;
            let own = shape.control_vertices().to_vec();
            let seen: Vec<Point> = own.iter().map(|p| transform_point(&to_world, p)).collect();
            if let Some(index) = seen.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
                return Err(Error::Invalid(format!(
                    "control vertex {index} of \"{name}\" is not finite where it is placed: correct its transform"
                )));
            }
            shape.control_vertices_mut().copy_from_slice(&seen);
            frames.push(Frame { back, own, seen });
        }
        Ok(Self { each: frames, alike: None })
    }

    /// The affine map from the coordinates in which the shapes are seen to the world: how all of them are placed where they are placed alike, so that these are
    /// their own coordinates. None where they are seen in the world.
    pub fn to_world(&self) -> Option<&Matrix4<f64>> {
        self.alike.as_ref()
    }

    /// Control vertices of shape `index`, in its object's own coordinates. Those that have not moved are as they were, to the last
    /// bit.
    pub fn own(&self, index: usize, points: &[Point]) -> Vec<Point> {
        let Some(Frame { back, own, seen }) = self.each.get(index) else { return points.to_vec() };
        // With knots inserted, vertices have other numbers.
        let same = |k: usize, p: &Point| seen.len() == points.len() && seen[k] == *p;
        let each = points.iter().enumerate();
        each.map(|(k, p)| if same(k, p) { own[k] } else { transform_point(back, p) }).collect()
    }

    /// The same of a whole shape.
    pub fn own_shape(&self, index: usize, shape: &dyn Shape) -> Box<dyn Shape> {
        let mut own = shape.boxed();
        if !self.each.is_empty() {
            let points = self.own(index, shape.control_vertices());
            own.control_vertices_mut().copy_from_slice(&points);
        }
        own
    }

    /// What the report should say of it.
    pub fn note(&self) -> Option<String> {
        if self.alike.is_some() {
            return Some(OWN.into());
        }
        (!self.each.is_empty()).then(|| {
            "the objects are placed differently: everything asked of them is in the coordinates of the world".into()
        })
    }
}

/// What a report should say of an object that is placed by a transform: which of a step's fields are in its own coordinates. `places` are, where the step has them or
/// not, and `lengths` that it has, where lengths are others in the scene.
///
/// # Errors
/// As for [`Scene::standing`].
pub fn in_own_coordinates(
    scene: &Scene,
    name: &str,
    parameters: &Parameters,
    places: &[&str],
    lengths: &[&str],
) -> Result<Option<String>> {
    let standing = scene.standing(name)?;
    if standing.to_world().is_none() {
        return Ok(None);
    }
    let lengths = lengths.iter().filter(|field| parameters.has(field) && standing.changes_size());
    let fields: Vec<&str> = places.iter().chain(lengths).copied().collect();
    let (is, are) = match &fields[..] {
        [] => return Ok(None),
        [one] => ((*one).to_owned(), "is"),
        [all @ .., last] => (format!("{} and {last}", all.join(", ")), "are"),
    };
    let name = crate::text::clip(name);
    let mut told = format!(
        "\"{name}\" is placed by a transform: {is} {are} in its own coordinates, as they are without that; lengths, areas and volumes are told as they stand in the scene"
    );
    if standing.scale().is_none() {
        told += "; it stretches some directions more than others, so that lengths that are equal there are not equal in the scene";
    }
    Ok(Some(told))
}

//! How objects stand in the scene: what their own transforms, and those above them, do to lengths and areas, and one object in the coordinates of another.

use std::borrow::Cow;

use nalgebra::{Matrix3, Matrix4};

use crate::Vector;
use crate::error::{Error, Result};
use crate::scene::{Geometry, Scene};

/// How far a map may be from a similarity, as a part of its scale, for lengths to go by that.
const SIMILAR: f64 = 1e-12;

/// The linear part of an affine map.
fn linear(map: &Matrix4<f64>) -> Matrix3<f64> {
    map.fixed_view::<3, 3>(0, 0).into_owned()
}

/// By how much a map makes all lengths longer, where it does so to all of them alike; it may mirror.
pub fn similarity(map: &Matrix4<f64>) -> Option<f64> {
    let linear = linear(map);
    let scale = linear.determinant().abs().cbrt();
    let off = (linear.transpose() * linear / (scale * scale) - Matrix3::identity()).amax();
    (scale > 0.0 && scale.is_finite() && off <= SIMILAR).then_some(scale)
}

/// How an object stands in the scene: by its own transform and those above it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Standing {
    /// From its own coordinates to the scene's; `None` where these are the same.
    to_world: Option<Matrix4<f64>>,
}

impl Standing {
    /// By this map.
    pub fn by(map: Option<Matrix4<f64>>) -> Self {
        Self { to_world: map.filter(|map| *map != Matrix4::identity()) }
    }

    /// From the object's own coordinates to the scene's; `None` where these are the same.
    pub fn to_world(&self) -> Option<&Matrix4<f64>> {
        self.to_world.as_ref()
    }

    /// By how much all lengths are longer in the scene than in the object's own coordinates; `None` where some are so by more than others.
    pub fn scale(&self) -> Option<f64> {
        self.to_world.as_ref().map_or(Some(1.0), similarity)
    }

    /// By how much the length of a direction can be longer in the scene, at most.
    pub fn most(&self) -> f64 {
        let Some(map) = &self.to_world else { return 1.0 };
        similarity(map).unwrap_or_else(|| linear(map).singular_values().max())
    }

    /// By how much areas are larger in the scene that lie across a `normal` of the object's own coordinates.
    pub fn of_areas_across(&self, normal: &Vector) -> f64 {
        let Some(map) = &self.to_world else { return 1.0 };
        if let Some(scale) = similarity(map) {
            return scale * scale;
        }
        // The cofactors take the normal of an area, as long as the area is large, to that of its image.
        let linear = linear(map);
        let row = |k: usize| linear.row(k).transpose();
        let image = Vector::new(
            row(1).cross(&row(2)).dot(normal),
            row(2).cross(&row(0)).dot(normal),
            row(0).cross(&row(1)).dot(normal),
        );
        image.norm() / normal.norm()
    }

    /// Whether lengths or the hand are others in the scene.
    pub fn changes_size(&self) -> bool {
        let Some(map) = &self.to_world else { return false };
        let moved = similarity(map).is_some_and(|scale| (scale - 1.0).abs() <= SIMILAR);
        !(moved && linear(map).determinant() > 0.0)
    }

    /// A geometry as it stands in the scene: its control vertices moved, which is exact.
    ///
    /// # Errors
    /// As for [`Geometry::transformed`].
    pub fn seen<'a>(&self, geometry: &'a Geometry) -> Result<Cow<'a, Geometry>> {
        self.to_world
            .as_ref()
            .map_or(Ok(Cow::Borrowed(geometry)), |map| geometry.transformed(map).map(Cow::Owned))
    }

    /// From the scene's coordinates to the object's own, where there is a way back and they are not the same.
    ///
    /// # Errors
    /// When the object is placed by a transform that flattens it, so that there is no way back.
    pub fn back(&self, name: &str, other: &str) -> Result<Option<Matrix4<f64>>> {
        let Some(map) = &self.to_world else { return Ok(None) };
        let back = map.try_inverse().filter(|back| back.iter().all(|c| c.is_finite()));
        back.map(Some).ok_or_else(|| {
            Error::Invalid(format!(
                "\"{name}\" is placed by a transform that flattens it, so that \"{other}\" is nowhere in its coordinates: correct its transform"
            ))
        })
    }
}

impl Scene {
    /// How an object stands: by its own transform and those above it. `O(objects)`.
    ///
    /// # Errors
    /// When the hierarchy is broken ([`check_hierarchy`](Self::check_hierarchy)), or there is no such object.
    pub fn standing(&self, name: &str) -> Result<Standing> {
        self.object(name)?;
        let world = self.world_transforms()?;
        Ok(Standing::by(self.position(name).and_then(|at| world.get(at).copied().flatten())))
    }

    /// An object as it is in the coordinates of another, where both are not placed alike: its control vertices moved by the affine map from one frame to the
    /// other, which is exact. `O(objects)` and its points.
    ///
    /// # Errors
    /// When the other is placed by a transform that flattens it, or a coordinate overflows.
    pub fn in_frame_of(&self, name: &str, other: &str) -> Result<Option<Geometry>> {
        let (own, of) = (self.standing(name)?, self.standing(other)?);
        if own == of {
            return Ok(None);
        }
        let map = match (of.back(other, name)?, own.to_world) {
            (Some(back), Some(own)) => Some(back * own),
            (back, own) => back.or(own),
        };
        map.map(|map| self.object(name)?.geometry().transformed(&map)).transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Point;
    use crate::mesh::Cloud;
    use crate::scene::Object;

    #[test]
    fn areas_grow_by_the_plane_that_they_lie_in() {
        let map = Matrix4::new_nonuniform_scaling(&Vector::new(2.0, 3.0, -5.0));
        let standing = Standing::by(Some(map));
        assert_eq!((standing.scale(), standing.most()), (None, 5.0));
        assert!(standing.changes_size());
        for (normal, by) in [(Vector::z(), 6.0), (Vector::x() * 7.0, 15.0), (Vector::y(), 10.0)] {
            assert!((standing.of_areas_across(&normal) - by).abs() < 1e-14 * by);
        }
        // A parallelogram askew, stretched and sheared.
        let shear =
            Matrix4::new(1.0, 0.5, 0.0, 3.0, 0.0, 2.0, -1.0, 0.0, 0.3, 0.0, 4.0, 0.0, 0.0, 0.0, 0.0, 1.0);
        let (a, b) = (Vector::new(1.0, 2.0, 0.5), Vector::new(-0.3, 0.7, 1.1));
        let image = |v: &Vector| linear(&shear) * v;
        let by = image(&a).cross(&image(&b)).norm() / a.cross(&b).norm();
        let found = Standing::by(Some(shear)).of_areas_across(&a.cross(&b));
        assert!((found / by - 1.0).abs() < 1e-14, "{found} {by}");
        let turned = Matrix4::from_axis_angle(&Vector::y_axis(), 0.7);
        assert_eq!(Standing::by(Some(turned * 1.0)).scale().map(|s| (s * 1e12).round()), Some(1e12));
        assert!(!Standing::by(Some(turned)).changes_size() && Standing::default().scale() == Some(1.0));
    }

    #[test]
    fn one_object_in_the_coordinates_of_another_is_where_it_stands() {
        let mut scene = Scene::new();
        for (name, map) in [
            ("a", Matrix4::new_translation(&Vector::new(1.0, 2.0, 3.0)) * Matrix4::new_scaling(2.0)),
            ("b", Matrix4::from_axis_angle(&Vector::z_axis(), std::f64::consts::FRAC_PI_2)),
            ("flat", Matrix4::new_nonuniform_scaling(&Vector::new(1.0, 1.0, 0.0))),
        ] {
            let mut object = Object::new(name, Cloud { points: vec![Point::new(1.0, 0.0, 0.0)] }.into());
            object.transform = Some(map);
            scene.add(object).unwrap();
        }
        let found = scene.in_frame_of("b", "a").unwrap().unwrap();
        assert!((found.points()[0] - Point::new(-0.5, -0.5, -1.5)).norm() < 1e-15);
        assert!(scene.in_frame_of("a", "a").unwrap().is_none());
        assert!(scene.in_frame_of("a", "flat").unwrap_err().to_string().contains("flattens it"));
    }
}

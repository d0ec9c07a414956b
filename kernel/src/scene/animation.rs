//! Animations: an object's points frame by frame, and how they go along with what is done to its geometry.

use crate::Point;
use crate::error::Error;
use crate::scene::{Geometry, Object, Scene};

/// Frames of an animation: the object's points ([`Geometry::points`]) at each frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Animation {
    /// Frames a second.
    pub rate: f64,
    /// The points of each frame, as many as the object has.
    pub frames: Vec<Vec<Point>>,
}

impl Animation {
    /// Whether every frame has as many points as the geometry; of a shape whose plug-in is not here nobody knows
    /// better.
    pub fn fits(&self, geometry: &Geometry) -> bool {
        if geometry.is_unknown() {
            return true;
        }
        let count = geometry.points().len();
        self.frames.iter().all(|frame| frame.len() == count)
    }
}

impl Scene {
    /// Puts what `map` makes of an object's geometry in its place, and what it makes of each frame in the frame's: for
    /// maps that keep the shape and change how it is represented. The animation goes where the frames do not become
    /// the same kind of thing as the object (the same knots, weights and faces): there is one set of these for all frames.
    ///
    /// # Errors
    /// When there is no such object, or the map fails on its geometry; the scene is as it was then. A frame on which the
    /// map fails is no error: the animation goes.
    pub fn reshape<E: From<Error>>(
        &mut self,
        name: &str,
        map: impl Fn(&Geometry) -> Result<Geometry, E>,
    ) -> Result<(), E> {
        let object = self.object(name)?;
        let geometry = map(object.geometry())?;
        let animation = carried(object, &geometry, &map);
        self.replace(name, geometry)?;
        self.object_mut(name)?.animation = animation;
        Ok(())
    }
}

/// The frames as the map makes them, where each becomes what the object became but for its points.
fn carried<E>(
    object: &Object,
    geometry: &Geometry,
    map: &impl Fn(&Geometry) -> Result<Geometry, E>,
) -> Option<Animation> {
    let animation = object.animation.as_ref()?;
    let frame = |points: &Vec<Point>| {
        let mapped = map(&object.geometry().with_points(points.clone()).ok()?).ok()?;
        let mapped_there = mapped.with_points(geometry.points().to_vec()).ok()?;
        let alike = match (&mapped_there, geometry) {
            // A frame is no circle any more where the object is one.
            (Geometry::Curve(frame), Geometry::Curve(own)) => {
                frame.clone().without_form() == own.clone().without_form()
            }
            (Geometry::Surface(frame), Geometry::Surface(own)) => {
                frame.clone().without_form() == own.clone().without_form()
            }
            _ => mapped_there == *geometry,
        };
        alike.then(|| mapped.points().to_vec())
    };
    let frames = animation.frames.iter().map(frame).collect::<Option<_>>()?;
    Some(Animation { rate: animation.rate, frames })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spline::{Curve, Space};

    fn points(count: usize, seed: f64) -> Vec<Point> {
        (0..count).map(|k| Point::new(k as f64, (seed + k as f64).sin(), (seed * k as f64).cos())).collect()
    }

    /// Curves of every degree, clamped, periodic and as Bézier chains, with and without weights.
    fn family() -> Vec<Curve> {
        let mut all = Vec::new();
        for degree in 1..=7 {
            let chain =
                (0..=3).flat_map(|k| vec![f64::from(k); if k % 3 == 0 { degree + 1 } else { degree }]);
            let spaces = [
                Space::clamped_uniform(degree, degree + 4).unwrap(),
                Space::periodic(degree, (0..=degree + 4).map(|k| k as f64).collect()).unwrap(),
                Space::open(degree, chain.collect()).unwrap(),
            ];
            for space in spaces {
                let count = space.len();
                let weights = (0..count).map(|k| 1.0 + 0.3 * (k as f64).sin()).collect();
                all.push(Curve::build(space.clone(), points(count, 1.0), None).unwrap());
                all.push(Curve::build(space, points(count, 1.0), Some(weights)).unwrap());
            }
        }
        all
    }

    fn animated(curve: &Curve) -> Scene {
        let mut scene = Scene::new();
        let mut object = Object::new("c", curve.into());
        let count = curve.points().len();
        let frames = vec![points(count, 1.0), points(count, 2.0), points(count, 0.3)];
        object.animation = Some(Animation { rate: 12.0, frames });
        scene.add(object).unwrap();
        scene
    }

    #[test]
    fn frames_go_along_with_what_keeps_the_shape() {
        type Map = fn(&Curve) -> crate::Result<Curve>;
        let maps: [(&str, Map, Map); 3] = [
            ("refine", |c| c.insert_knots(&[0.37 * c.space().domain().1]), |c| Ok(c.clone())),
            ("elevate", |c| c.elevate(1), |c| Ok(c.clone())),
            ("reverse", Curve::reverse, Curve::reverse),
        ];
        for curve in family() {
            for (what, map, back) in &maps {
                let mut scene = animated(&curve);
                let before = scene.object("c").unwrap().animation.clone().unwrap();
                scene
                    .reshape("c", |g| match g {
                        Geometry::Curve(curve) => map(curve).map(Geometry::from),
                        _ => Err(Error::Invalid("no curve".into())),
                    })
                    .unwrap();
                let object = scene.object("c").unwrap();
                let after = object.animation.as_ref().unwrap_or_else(|| panic!("{what} of {curve:?}"));
                assert_eq!(after.rate, before.rate);
                assert_eq!(after.frames[0], object.geometry().points(), "{what}");
                for (old, new) in before.frames.iter().zip(&after.frames) {
                    let at =
                        |geometry: &Geometry, points: &[Point]| match geometry.with_points(points.to_vec()) {
                            Ok(Geometry::Curve(curve)) => curve,
                            other => panic!("{other:?}"),
                        };
                    let (old, new) = (at(&(&curve).into(), old), back(&at(object.geometry(), new)).unwrap());
                    let (a, b) = curve.space().domain();
                    for i in 0..=20 {
                        let u = a + (b - a) * f64::from(i) / 20.0;
                        let apart = (old.point(u).unwrap() - new.point(u).unwrap()).norm();
                        assert!(apart < 1e-12 * 20.0, "{what} at {u}: {apart}");
                    }
                }
            }
        }
    }

    #[test]
    fn frames_of_another_geometry_go() {
        for curve in family() {
            let mut scene = animated(&curve);
            scene.replace("c", &curve).unwrap();
            assert!(scene.object("c").unwrap().animation.is_some());
            // What only some frames allow is not done to the frames.
            let refused = |g: &Geometry| match g.points()[0].y == curve.points()[0].y {
                true => Ok::<_, Error>(g.clone()),
                false => Err(Error::Invalid("no".into())),
            };
            let mut kept = scene.clone();
            kept.reshape("c", refused).unwrap();
            assert!(kept.object("c").unwrap().animation.is_none());
            // As many points, elsewhere.
            scene
                .replace(
                    "c",
                    Curve::build(curve.space().clone(), points(curve.points().len(), 5.0), None).unwrap(),
                )
                .unwrap();
            assert!(scene.object("c").unwrap().animation.is_none());
        }
    }
}

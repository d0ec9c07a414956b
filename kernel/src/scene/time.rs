//! A scene at a moment of its animations.

use std::borrow::Cow;

use crate::Point;
use crate::error::{Error, Result};
use crate::scene::{Animation, Geometry, Object, Scene};

/// The most moments of a scene.
const MOST: f64 = 1e6;

/// A moment is that of a frame where it is nearer to it than this part of the way to the next.
const SAME: f64 = 1e-6;

impl Animation {
    /// When the last frame is shown, in seconds; the first is shown at 0.
    pub fn duration(&self) -> f64 {
        self.frames.len().saturating_sub(1) as f64 / self.rate
    }

    /// The points at a moment: those of a frame, or between two frames on the straight way from one to the other; before the
    /// first those of the first, after the last those of the last. `None` without frames.
    pub fn at(&self, seconds: f64) -> Option<Cow<'_, [Point]>> {
        let last = self.frames.len().checked_sub(1)?;
        let place = (seconds * self.rate).clamp(0.0, last as f64);
        // What is no number is the start.
        let frame = place.floor() as usize;
        let part = place - frame as f64;
        let (here, next) = (&self.frames[frame.min(last)], &self.frames[(frame + 1).min(last)]);
        if part.is_nan() || part <= SAME {
            return Some(Cow::Borrowed(here));
        }
        if part > 1.0 - SAME {
            return Some(Cow::Borrowed(next));
        }
        // Not by a difference, which may overflow.
        let between = |(a, b): (&Point, &Point)| Point::from(a.coords * (1.0 - part) + b.coords * part);
        Some(Cow::Owned(here.iter().zip(next).map(between).collect()))
    }
}

impl Geometry {
    /// What it is in a frame of its animation: as [`with_points`](Self::with_points), with the normals of a mesh turned as its
    /// faces are ([`Mesh::moved`](crate::mesh::Mesh::moved)).
    ///
    /// # Errors
    /// As for [`with_points`](Self::with_points).
    pub fn in_frame(&self, points: Vec<Point>) -> Result<Self> {
        match self {
            Self::Mesh(mesh) => mesh.moved(points).map(Self::Mesh),
            other => other.with_points(points),
        }
    }
}

impl Scene {
    /// The moments of its frames, in seconds from 0 on: as far apart as the frames of its fastest animation, until the end of
    /// its longest, those of definitions included. None where nothing is animated.
    ///
    /// # Errors
    /// When they are more than a million.
    pub fn moments(&self) -> Result<Vec<f64>> {
        let all = || self.animated().filter_map(|object| object.animation.as_ref());
        if all().next().is_none() {
            return Ok(Vec::new());
        }
        let rate = all().map(|animation| animation.rate).fold(0.0, f64::max);
        let end = all().map(Animation::duration).fold(0.0, f64::max);
        let steps = rate * end;
        if steps.is_nan() || steps >= MOST {
            return Err(Error::Invalid(format!(
                "{rate} frames a second until {end} s are more than a million: give all animations rates that are alike"
            )));
        }
        let steps = (steps - SAME).ceil().max(0.0) as usize;
        Ok((0..=steps).map(|k| (k as f64 / rate).min(end)).collect())
    }

    /// The scene at a moment: every object that is animated as it is then ([`Animation::at`]), and without its animation, in
    /// definitions, too. A shape whose plug-in is not here stays as it is.
    ///
    /// # Errors
    /// When an animation does not fit its object.
    pub fn at(&self, seconds: f64) -> Result<Self> {
        let mut still = self.clone();
        let moving: Vec<String> = names(self.objects());
        for name in moving {
            stop(still.list.object_mut(&name)?, seconds)?;
        }
        for definition in self.definitions.iter() {
            for name in names(definition.objects()) {
                stop(still.definition_mut(definition.name())?.object_mut(&name)?, seconds)?;
            }
        }
        Ok(still)
    }

    /// All objects that have frames, those of definitions included.
    fn animated(&self) -> impl Iterator<Item = &Object> {
        let all = self.objects().iter().chain(self.definitions.iter().flat_map(|d| d.objects()));
        all.filter(|object| is_animated(object))
    }
}

fn is_animated(object: &Object) -> bool {
    object.animation.as_ref().is_some_and(|animation| !animation.frames.is_empty())
}

fn names(objects: &[Object]) -> Vec<String> {
    objects.iter().filter(|object| is_animated(object)).map(|object| object.name().to_owned()).collect()
}

fn stop(object: &mut Object, seconds: f64) -> Result<()> {
    if object.geometry().is_unknown() {
        return Ok(());
    }
    let Some(animation) = object.animation.take() else { return Ok(()) };
    let Some(points) = animation.at(seconds) else { return Ok(()) };
    if *points == *object.geometry().points() {
        return Ok(());
    }
    let there = object.geometry().in_frame(points.into_owned());
    object.set_geometry(there.map_err(|e| Error::Invalid(format!("\"{}\": {e}", object.name())))?);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector;
    use crate::mesh::{Layer, Mesh, Polyline};
    use crate::scene::Definition;

    fn line(x: f64) -> Vec<Point> {
        vec![Point::origin(), Point::new(x, 0.0, 0.0)]
    }

    fn moving(name: &str, rate: f64, frames: &[f64]) -> Object {
        let mut object = Object::new(name, Polyline { points: line(-1.0), closed: false }.into());
        object.animation = Some(Animation { rate, frames: frames.iter().map(|x| line(*x)).collect() });
        object
    }

    fn reach(scene: &Scene, name: &str) -> f64 {
        scene.object(name).unwrap().geometry().points()[1].x
    }

    #[test]
    fn a_scene_is_shown_from_the_first_frame_to_the_last_of_all() {
        let mut scene = Scene::new();
        assert_eq!(scene.moments().unwrap(), [0.0; 0]);
        scene.add(moving("slow", 2.0, &[0.0, 1.0, 4.0])).unwrap();
        scene.add(moving("fast", 8.0, &[0.0, 1.0, 2.0])).unwrap();
        scene.add(Object::new("still", Polyline { points: line(7.0), closed: false }.into())).unwrap();
        let moments = scene.moments().unwrap();
        assert_eq!(moments, [0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0]);
        let found: Vec<_> = moments
            .iter()
            .map(|&t| {
                let then = scene.at(t).unwrap();
                assert!(then.objects().iter().all(|o| o.animation.is_none()) && reach(&then, "still") == 7.0);
                (reach(&then, "slow"), reach(&then, "fast"))
            })
            .collect();
        assert_eq!(found[..4], [(0.0, 0.0), (0.25, 1.0), (0.5, 2.0), (0.75, 2.0)]);
        assert_eq!(found[8], (4.0, 2.0));
        assert_eq!(reach(&scene.at(f64::NAN).unwrap(), "slow"), 0.0);
        assert_eq!(reach(&scene.at(1e300).unwrap(), "slow"), 4.0);
    }

    #[test]
    fn frames_at_odd_rates_are_the_frames_themselves() {
        for rate in [24.0, 25.0, 29.97, 1e-3, 1e6, 7.0_f64.sqrt()] {
            let places: Vec<f64> = (0..300).map(|k| f64::from(k).sin()).collect();
            let mut scene = Scene::new();
            scene.add(moving("a", rate, &places)).unwrap();
            let moments = scene.moments().unwrap();
            assert_eq!(moments.len(), 300, "{rate}");
            for (t, x) in moments.iter().zip(&places) {
                assert_eq!(reach(&scene.at(*t).unwrap(), "a"), *x, "{rate}");
            }
        }
    }

    #[test]
    fn definitions_move_and_normals_turn() {
        let points =
            [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(x, y)| Point::new(f64::from(x), f64::from(y), 0.0));
        let mut mesh = Mesh::new(points.to_vec(), &[[0, 1, 2, 3]]).unwrap();
        mesh.normals = Layer::per_point(vec![Vector::z(); 4]);
        let mut leaf = Object::new("leaf", mesh.into());
        let up = points.map(|p| Point::new(p.x, 0.0, p.y)).to_vec();
        leaf.animation = Some(Animation { rate: 1.0, frames: vec![points.to_vec(), up] });
        let mut part = Definition::new("part");
        part.add(leaf).unwrap();
        let mut scene = Scene::new();
        scene.define(part).unwrap();
        assert_eq!(scene.moments().unwrap(), [0.0, 1.0]);
        let then = scene.at(1.0).unwrap();
        let Geometry::Mesh(leaf) = then.definition("part").unwrap().object("leaf").unwrap().geometry() else {
            panic!()
        };
        assert!(leaf.normals.values().iter().all(|n| (n + Vector::y()).norm() < 1e-12));
    }

    #[test]
    fn too_many_moments_are_refused() {
        let mut scene = Scene::new();
        scene.add(moving("a", 1e6, &[0.0, 1.0])).unwrap();
        scene.add(moving("b", 1e-3, &[0.0, 1.0])).unwrap();
        assert!(scene.moments().unwrap_err().to_string().contains("million"));
    }
}

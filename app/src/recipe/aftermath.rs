//! What a step leaves of what earlier steps made: animations whose frames are of another shape, and marks whose places
//! have moved. One place for all operations, whoever wrote them.

use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

use loftsman_kernel::plugin::{Mark, StepReport};
use loftsman_kernel::scene::{Animation, Geometry, Scene};

/// An animated object as it was before a step.
struct Animated {
    geometry: Arc<Geometry>,
    animation: Animation,
}

/// What has to be known of a scene before a step, to judge what is left after it.
pub(super) struct Beforehand {
    animated: BTreeMap<String, Animated>,
    names: HashSet<String>,
}

impl Beforehand {
    /// Looks at a scene. `O(objects)`, and a copy of all frames.
    pub(super) fn of(scene: &Scene) -> Self {
        let animated = scene.objects().iter().filter_map(|object| {
            let animation = object.animation.clone()?;
            let geometry = Arc::clone(object.shared_geometry());
            Some((object.name().to_owned(), Animated { geometry, animation }))
        });
        let names = scene.objects().iter().map(|object| object.name().to_owned()).collect();
        Self { animated: animated.collect(), names }
    }

    /// Takes off the animations that no longer belong to their objects, and says of each that has gone in this step that it
    /// has.
    ///
    /// [`Scene::replace`] takes them off and [`Scene::reshape`] takes them along; an operation that changes an object's
    /// geometry in place and forgets its frames is caught here.
    pub(super) fn drop_stale(
        &self,
        scene: &mut Scene,
        report: &mut StepReport,
    ) -> loftsman_kernel::Result<()> {
        let mut stale = Vec::new();
        for object in scene.objects() {
            let Some(animation) = &object.animation else { continue };
            let forgotten = self.animated.get(object.name()).is_some_and(|a| {
                a.animation == *animation && a.geometry.points() != object.geometry().points()
            });
            if forgotten || !animation.fits(object.geometry()) {
                stale.push((object.name().to_owned(), animation.frames.len()));
            }
        }
        for (name, _) in &stale {
            scene.object_mut(name)?.animation = None;
        }
        for (name, Animated { animation, .. }) in &self.animated {
            let gone = scene.get(name).is_some_and(|object| object.animation.is_none());
            if gone && !stale.iter().any(|(known, _)| known == name) {
                stale.push((name.clone(), animation.frames.len()));
            }
        }
        for (name, frames) in stale {
            let plural = if frames == 1 { "" } else { "s" };
            report.notes.push(format!(
                "the animation of \"{name}\" ({frames} frame{plural}) was taken off: its frames are not of the shape that \
                 it is after this step; make it in a later one"
            ));
        }
        Ok(())
    }

    /// Moves the marks of earlier steps to where their places are after this one; gives how many have no place any more,
    /// which go.
    ///
    /// Where an object no longer has a place, one that the step made may have it: a piece of it, or the object itself under
    /// another name. Where the step took off an object's frames, or `made` marks with others of its own, those of earlier ones know of none.
    pub(super) fn follow(&self, scene: &Scene, marks: &mut Vec<Mark>, made: &[Mark]) -> usize {
        marks.retain_mut(|mark| {
            let was = self.animated.contains_key(&mark.object);
            let still = was && scene.find(&mark.object).is_some_and(|object| object.animation.is_none());
            let anew = made.iter().any(|other| other.object == mark.object && other.track.is_some());
            let stays = mark.stays();
            if still || anew {
                mark.track = None;
            }
            stays || mark.track.is_some()
        });
        let count = marks.len();
        let fresh = || scene.objects().iter().filter(|object| !self.names.contains(object.name()));
        marks.retain_mut(|mark| {
            let own = scene.find(&mark.object);
            if own.is_some_and(|object| mark.rests(object.geometry())) {
                return true;
            }
            if let Some(object) = fresh().find(|object| mark.rests(object.geometry())) {
                object.name().clone_into(&mut mark.object);
                return true;
            }
            own.is_some_and(|object| mark.follow(object.geometry()))
        });
        count - marks.len()
    }
}

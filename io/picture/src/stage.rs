//! Scenes in the coordinates of a view: x right, y up, z towards the viewer, centred, about one unit large.
//!
//! Moving and scaling come first, so that a scene a nanometre or a million kilometres large, or far from its
//! origin, is drawn with the same care; curvature is taken here too, since a view only turns and scales.

pub(crate) mod body;
mod crease;
pub(crate) mod feet;
pub(crate) mod finer;
pub(crate) mod laid;
pub(crate) mod piece;
mod ridge;
pub(crate) mod scenery;
pub(crate) mod shell;
pub(crate) mod solid;
pub(crate) mod trim;

use std::collections::HashSet;

use loftsman_kernel::plugin::Mark;
use loftsman_kernel::{Point, Vector};
use nalgebra::Matrix4;

use crate::view::{Frame, Lens};
use body::Body;

/// From an object's own coordinates to the scene's; `None` where they are the same.
type Place = Option<Matrix4<f64>>;

/// From the scene's coordinates to the stage's: a turn, a shift and one scale.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Projection {
    centre: Point,
    /// Half the largest extent of the scene, in its unit; 1 where the scene is a single point.
    pub(crate) size: f64,
    frame: Frame,
}

impl Projection {
    fn normal(&self, p: &Point) -> Vector {
        // Scaled before it is subtracted: a difference of the largest numbers would overflow.
        p.coords / self.size - self.centre.coords / self.size
    }

    /// A point of the scene on the stage.
    pub(crate) fn point(&self, p: &Point) -> Vector {
        self.frame.turn(&self.normal(p))
    }

    /// A displacement of the scene on the stage, turned but not scaled.
    pub(crate) fn direction(&self, v: &Vector) -> Vector {
        self.frame.turn(v)
    }

    /// How the stage is seen.
    pub(crate) fn lens(&self) -> Lens {
        self.frame.lens
    }

    /// Whether two views look the same way.
    pub(crate) fn looks_like(&self, other: &Self) -> bool {
        self.frame == other.frame
    }
}

/// A mark on the stage.
#[derive(Debug, Clone)]
pub(crate) struct Spotlight<'a> {
    pub(crate) mark: &'a Mark,
    pub(crate) position: Vector,
    pub(crate) before: Vector,
    /// The mark's vector turned into the view; its length is the scene's.
    pub(crate) vector: Option<Vector>,
}

/// How a frame of an animation is seen beside the object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Ghost {
    /// Dashed, with its number from 1.
    Dashed(usize),
    /// As pale as it is early: 0 for the first, 1 for the last of all.
    Faded(f64),
}

/// Everything that a picture shows.
#[derive(Debug)]
pub(crate) struct Stage<'a> {
    /// What there was before, by name.
    pub(crate) before: HashSet<&'a str>,
    /// The state before, where it differs: drawn lighter and first.
    pub(crate) old: Vec<Body<'a>>,
    /// Frames of animations.
    pub(crate) frames: Vec<(Body<'a>, Ghost)>,
    /// The points of all moments, where a drawing leaves room for them.
    pub(crate) moments: Vec<Vector>,
    /// The objects.
    pub(crate) new: Vec<Body<'a>>,
    /// What was asked.
    pub(crate) marks: Vec<Spotlight<'a>>,
    /// How it got here.
    pub(crate) projection: Projection,
}

impl<'a> Stage<'a> {
    /// Whether a body was there before.
    pub(crate) fn had(&self, body: &Body<'_>) -> bool {
        self.before.contains(body.object.name())
    }

    /// How many surfaces there are, before and after.
    pub(crate) fn surfaces(&self) -> usize {
        self.bodies().filter(|body| matches!(body.form, body::Form::Surface { .. })).count()
    }

    /// All bodies, the old ones first.
    pub(crate) fn bodies(&self) -> impl Iterator<Item = &Body<'a>> {
        self.old.iter().chain(self.frames.iter().map(|(body, _)| body)).chain(&self.new)
    }
}

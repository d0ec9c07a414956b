//! Scenes in the coordinates of a view: x right, y up, z towards the viewer, centred, about one unit large.
//!
//! Moving and scaling come first, so that a scene a nanometre or a million kilometres large, or far from its
//! origin, is drawn with the same care; curvature is taken here too, since a view only turns and scales.

pub(crate) mod body;
pub(crate) mod piece;

use loftsman_kernel::placement::transform_point;
use loftsman_kernel::plugin::Mark;
use loftsman_kernel::scene::{Object, Scene};
use loftsman_kernel::{Point, Vector};
use nalgebra::Matrix4;

use crate::error::PictureError;
use crate::view::{Frame, View};
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

/// Everything that a picture shows.
#[derive(Debug)]
pub(crate) struct Stage<'a> {
    /// The state before, where it differs: drawn lighter and first.
    pub(crate) old: Vec<Body<'a>>,
    /// The objects.
    pub(crate) new: Vec<Body<'a>>,
    /// What was asked.
    pub(crate) marks: Vec<Spotlight<'a>>,
    /// How it got here.
    pub(crate) projection: Projection,
}

impl<'a> Stage<'a> {
    /// Sets the stage for a scene, its state before and the marks.
    pub(crate) fn new(
        scene: &'a Scene,
        before: Option<&'a Scene>,
        marks: &'a [Mark],
        view: View,
    ) -> Result<Self, PictureError> {
        let new = placed(scene)?;
        let old: Vec<(&Object, Place, usize)> = before
            .map(placed)
            .transpose()?
            .unwrap_or_default()
            .into_iter()
            .map(|(object, place, i)| (object, place, scene.position(object.name()).unwrap_or(i)))
            .collect();
        let place = |object: &str| scene.position(object).and_then(|i| new[i].1);
        let marks: Vec<(&Mark, Place)> = marks.iter().map(|mark| (mark, place(&mark.object))).collect();

        let mut points = Vec::new();
        for (object, place, _) in new.iter().chain(&old) {
            for p in object.geometry.points() {
                points.push(at(place, p, object.name())?);
            }
        }
        for (mark, place) in &marks {
            for p in [&mark.position, &mark.before] {
                points.push(at(place, p, &mark.object)?);
            }
        }
        let (centre, size) = extent(&points);
        for p in &mut points {
            *p = Point::from(p.coords / size - centre.coords / size);
        }
        let projection = Projection { centre, size, frame: view.frame(scene.up, &points)? };
        drop(points);
        let bodies = |list: Vec<(&'a Object, Place, usize)>| {
            list.into_iter()
                .map(|(object, place, index)| Body::new(object, &place, &projection, index))
                .collect::<Result<Vec<_>, PictureError>>()
        };
        let new = bodies(new)?;
        let mut old = bodies(old)?;
        old.retain(|body| {
            let now = scene.position(body.object.name()).map(|i| &new[i]);
            !now.is_some_and(|now| now.form.alike(&body.form))
        });
        let marks = marks
            .into_iter()
            .map(|(mark, place)| spotlight(mark, &place, &projection))
            .collect::<Result<_, _>>()?;
        Ok(Self { old, new, marks, projection })
    }

    /// How many surfaces there are, before and after.
    pub(crate) fn surfaces(&self) -> usize {
        self.bodies().filter(|body| matches!(body.form, body::Form::Surface { .. })).count()
    }

    /// All bodies, the old ones first.
    pub(crate) fn bodies(&self) -> impl Iterator<Item = &Body<'a>> {
        self.old.iter().chain(&self.new)
    }
}

/// The objects of a scene, where they are and their indices.
fn placed(scene: &Scene) -> Result<Vec<(&Object, Place, usize)>, PictureError> {
    let places = scene.world_transforms()?;
    Ok(scene
        .objects()
        .iter()
        .zip(places)
        .enumerate()
        .map(|(i, (object, place))| (object, place, i))
        .collect())
}

/// A point of an object in the scene's coordinates.
///
/// # Errors
/// When it is not finite there.
fn at(place: &Place, p: &Point, object: &str) -> Result<Point, PictureError> {
    let moved = place.as_ref().map_or(*p, |map| transform_point(map, p));
    if moved.iter().all(|c| c.is_finite()) {
        Ok(moved)
    } else {
        Err(PictureError::Place { object: object.to_owned() })
    }
}

fn spotlight<'a>(
    mark: &'a Mark,
    place: &Place,
    projection: &Projection,
) -> Result<Spotlight<'a>, PictureError> {
    let staged = |p: &Point| Ok::<_, PictureError>(projection.point(&at(place, p, &mark.object)?));
    let turned = |v: Vector| place.map_or(v, |map| map.fixed_view::<3, 3>(0, 0) * v);
    let vector = mark.vector.map(|v| projection.direction(&turned(v)));
    Ok(Spotlight {
        mark,
        position: staged(&mark.position)?,
        before: staged(&mark.before)?,
        vector: vector.filter(|v| v.iter().all(|c| c.is_finite())),
    })
}

/// Centre and half the largest extent of points; the origin and 1 where there are none or they are one.
fn extent(points: &[Point]) -> (Point, f64) {
    let Some(&first) = points.first() else { return (Point::origin(), 1.0) };
    let (low, high) = points.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    let half = high.coords / 2.0 - low.coords / 2.0;
    let centre = Point::from(low.coords / 2.0 + high.coords / 2.0);
    let size = half.amax();
    // Differences below the resolution of the coordinates are rounding, not shape; a subnormal size would
    // overflow when divided by.
    let noise = 4.0 * f64::EPSILON * centre.coords.amax();
    if size > noise && size >= f64::MIN_POSITIVE { (centre, size) } else { (centre, 1.0) }
}

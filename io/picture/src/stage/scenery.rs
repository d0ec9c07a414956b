//! The objects of a picture where they are in space, before a view is chosen.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use loftsman_kernel::placement::transform_point;
use loftsman_kernel::plugin::{Mark, nearest};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::{Point, Vector};
use nalgebra::{Matrix3, Matrix4};

use super::body::Body;
use super::solid::{Solid, Solids};
use super::{Ghost, Place, Projection, Spotlight, Stage};
use crate::choices::Frames;
use crate::error::PictureError;
use crate::panel::Panel;
use crate::view::View;

/// Frames of an animation that are drawn; of more, some evenly spread.
const FRAMES: usize = 6;

/// An object, its way into the scene, and which colour of the palette it has.
#[derive(Debug, Clone, Copy)]
struct Placed<'a> {
    object: &'a Object,
    place: Place,
    index: usize,
    /// The Brep as it is drawn, or why it is not.
    solid: Option<&'a Result<Arc<Solid>, String>>,
}

impl<'a> Placed<'a> {
    fn solid(&self) -> Option<&'a Arc<Solid>> {
        self.solid?.as_ref().ok()
    }

    /// The points that it is drawn by: a Brep's control vertices may be far beyond it.
    fn points(&self) -> &'a [Point] {
        match self.solid {
            Some(Ok(solid)) => &solid.points,
            Some(Err(_)) => &[],
            None => self.object.geometry().points(),
        }
    }
}

/// Everything that a picture can show, in the scene's own coordinates, and how large all of it is: the panels of a
/// picture share one centre and size, so that they can be drawn to one scale.
#[derive(Debug)]
pub(crate) struct Scenery<'a> {
    scene: &'a Scene,
    new: Vec<Placed<'a>>,
    old: Vec<Placed<'a>>,
    /// The points of frames, and how they are seen.
    frames: Vec<(Placed<'a>, Ghost, &'a [Point])>,
    /// The objects as they move, whose frames all have room.
    moving: Vec<Placed<'a>>,
    marks: Vec<(&'a Mark, Place)>,
    centre: Point,
    size: f64,
}

impl<'a> Scenery<'a> {
    /// Places a scene, its state before, its animations' frames where they are wanted, and the marks. Colours are given
    /// out among the objects that some panel shows. Of a `moving` scene, of which this is a moment, all frames have room.
    pub(crate) fn new(
        scene: &'a Scene,
        (before, moving): (Option<&'a Scene>, Option<&'a Scene>),
        marks: &'a [Mark],
        frames: Frames,
        panels: &[Panel],
        solids: &'a Solids,
    ) -> Result<Self, PictureError> {
        let drawn = |object: &&Object| {
            !matches!(object.geometry(), Geometry::Group) && panels.iter().any(|p| p.shows(object.name()))
        };
        let palette: HashMap<&str, usize> =
            scene.objects().iter().filter(drawn).enumerate().map(|(i, object)| (object.name(), i)).collect();
        let placed = |scene| placed(scene, &palette, solids);
        let new = placed(scene)?;
        let old = before.map(placed).transpose()?.unwrap_or_default();
        let place = |object: &str| scene.position(object).and_then(|i| new[i].place);
        let marks: Vec<(&Mark, Place)> = marks.iter().map(|mark| (mark, place(&mark.object))).collect();
        let earlier: HashMap<&str, &Object> = old.iter().map(|o| (o.object.name(), o.object)).collect();
        let earlier = |object: &Object| earlier.get(object.name()).copied();
        let frames: Vec<_> =
            new.iter().flat_map(|placed| chosen(placed, earlier(placed.object), frames)).collect();
        let mut moving = moving.map(placed).transpose()?.unwrap_or_default();
        // The frames of a Brep are of its control vertices.
        moving.retain(|placed| placed.object.animation.is_some() && placed.solid.is_none());

        let mut range: Option<(Point, Point)> = None;
        let mut take = |place: &Place, points: &[Point], name: &str| {
            for p in points {
                let p = at(place, p, name)?;
                let (low, high) = range.unwrap_or((p, p));
                range = Some((low.inf(&p), high.sup(&p)));
            }
            Ok::<_, PictureError>(())
        };
        for placed in new.iter().chain(&old) {
            take(&placed.place, placed.points(), placed.object.name())?;
        }
        for (Placed { object, place, .. }, _, points) in &frames {
            take(place, points, object.name())?;
        }
        for Placed { object, place, .. } in &moving {
            states(object).try_for_each(|points| take(place, points, object.name()))?;
        }
        for (mark, place) in &marks {
            take(place, &[mark.position, mark.before], &mark.object)?;
        }
        let (centre, size) = extent(range);
        Ok(Self { scene, new, old, frames, moving, marks, centre, size })
    }

    /// The stage of a view: all objects, or those of some names.
    ///
    /// # Errors
    /// When a name is unknown, or the view cannot be.
    pub(crate) fn stage(&self, view: View, only: Option<&[String]>) -> Result<Stage<'a>, PictureError> {
        for name in only.unwrap_or_default() {
            if self.scene.get(name).is_none() {
                let near = nearest(name, self.scene.objects().iter().map(Object::name)).map(str::to_owned);
                return Err(PictureError::Object { name: name.clone(), near });
            }
        }
        let only: Option<HashSet<&str>> = only.map(|names| names.iter().map(String::as_str).collect());
        let shown = |name: &str| only.as_ref().is_none_or(|names| names.contains(name));
        let frame = view.frame(self.scene.up, &self.unit_points(view, &shown)?)?;
        let projection = Projection { centre: self.centre, size: self.size, frame };

        let body = |p: &Placed<'a>, points: &[Point]| {
            let staged = staged(&projection, &p.place, points, p.object.name())?;
            // Normals go by the cofactors: by the inverse transposed, but for a factor, and where there is no inverse.
            let cofactors = p.place.map(|map| {
                let [a, b, c] = [0, 1, 2].map(|k| map.fixed_view::<3, 1>(0, k).into_owned());
                Matrix3::from_columns(&[b.cross(&c), c.cross(&a), a.cross(&b)])
            });
            let normal = |n: &Vector| projection.direction(&cofactors.map_or(*n, |map| map * n));
            let mut body = Body::of(p.object, p.index, p.solid(), staged, normal)?;
            if let Some(Err(why)) = p.solid {
                body.missing = Some(format!("not drawn, {why}"));
            }
            Ok::<_, PictureError>(body)
        };
        let bodies = |list: &[Placed<'a>]| {
            list.iter()
                .filter(|p| shown(p.object.name()))
                .map(|p| body(p, p.points()))
                .collect::<Result<Vec<_>, _>>()
        };
        let new = bodies(&self.new)?;
        let mut old = bodies(&self.old)?;
        let now: HashMap<&str, &Body<'_>> = new.iter().map(|body| (body.object.name(), body)).collect();
        let before = old.iter().map(|body| body.object.name()).collect();
        old.retain(|body| !now.get(body.object.name()).is_some_and(|now| now.form.alike(&body.form)));
        let frames = self.frames.iter().filter(|(p, ..)| shown(p.object.name()));
        let frames = frames
            .map(|(p, ghost, points)| Ok((body(p, points)?, *ghost)))
            .collect::<Result<Vec<_>, PictureError>>()?;
        let mut moments = Vec::new();
        for p in self.moving.iter().filter(|p| shown(p.object.name())) {
            for points in states(p.object) {
                moments.extend(staged(&projection, &p.place, points, p.object.name())?);
            }
        }
        let marks = self.marks.iter().filter(|(mark, _)| shown(&mark.object));
        let marks = marks
            .map(|(mark, place)| spotlight(mark, place, &projection))
            .collect::<Result<_, PictureError>>()?;
        Ok(Stage { before, old, frames, moments, new, marks, projection })
    }

    /// The points that an automatic view looks at, near 1; none for other views.
    fn unit_points(&self, view: View, shown: &impl Fn(&str) -> bool) -> Result<Vec<Point>, PictureError> {
        let mut points = Vec::new();
        if view != View::Automatic {
            return Ok(points);
        }
        let mut take = |place: &Place, list: &[Point], name: &str| {
            if shown(name) {
                for p in list {
                    let p = at(place, p, name)?;
                    points.push(Point::from(p.coords / self.size - self.centre.coords / self.size));
                }
            }
            Ok::<_, PictureError>(())
        };
        for placed in self.new.iter().chain(&self.old) {
            take(&placed.place, placed.points(), placed.object.name())?;
        }
        for (Placed { object, place, .. }, _, list) in &self.frames {
            take(place, list, object.name())?;
        }
        for Placed { object, place, .. } in &self.moving {
            states(object).try_for_each(|points| take(place, points, object.name()))?;
        }
        for (mark, place) in &self.marks {
            take(place, &[mark.position, mark.before], &mark.object)?;
        }
        Ok(points)
    }
}

/// The objects of a scene, where they are, with the colours that their names have in a palette.
fn placed<'a>(
    scene: &'a Scene,
    palette: &HashMap<&str, usize>,
    solids: &'a Solids,
) -> Result<Vec<Placed<'a>>, PictureError> {
    let places = scene.world_transforms()?;
    let index = |object: &Object, i| palette.get(object.name()).copied().unwrap_or(i);
    let objects = scene.objects().iter().zip(places).enumerate();
    let placed = |(i, (object, place)): (usize, (&'a Object, Place))| {
        let solid = solids.get(object.geometry_id());
        Placed { object, place, index: index(object, i), solid }
    };
    Ok(objects.map(placed).collect())
}

/// All frames of an object.
fn states(object: &Object) -> impl Iterator<Item = &[Point]> {
    object.animation.iter().flat_map(|animation| &animation.frames).map(Vec::as_slice)
}

/// The frames of an object that are drawn in the drawing itself: those that differ from how it is now and was before, a few of
/// many. Dashed ones are counted from 1, the first after the start.
fn chosen<'a>(
    placed: &Placed<'a>,
    before: Option<&Object>,
    how: Frames,
) -> Vec<(Placed<'a>, Ghost, &'a [Point])> {
    let most = match how {
        Frames::Off | Frames::Film(_) => return Vec::new(),
        Frames::Dashed => FRAMES,
        Frames::Fading(count) => count,
    };
    if placed.solid.is_some() {
        // Its frames are of its control vertices.
        return Vec::new();
    }
    let now = placed.object.geometry().points();
    let Some(animation) = &placed.object.animation else { return Vec::new() };
    let start =
        animation.frames.first().zip(before).is_some_and(|(f, b)| f.as_slice() == b.geometry().points());
    let mut frames: Vec<_> = (1..).zip(&animation.frames[usize::from(start)..]).collect();
    if frames.last().is_some_and(|(_, last)| last.as_slice() == now) {
        frames.pop();
    }
    let count = frames.len().min(most);
    // The first of each of `count` even parts, from the back, so that the first frame is among few.
    (0..count)
        .map(|i| {
            let (number, frame) = frames[i * frames.len() / count];
            let ghost = match how {
                Frames::Fading(_) => Ghost::Faded(i as f64 / count as f64),
                _ => Ghost::Dashed(number),
            };
            (*placed, ghost, frame.as_slice())
        })
        .collect()
}

fn staged(
    projection: &Projection,
    place: &Place,
    points: &[Point],
    name: &str,
) -> Result<Vec<Vector>, PictureError> {
    points.iter().map(|p| Ok(projection.point(&at(place, p, name)?))).collect()
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
    let linear = |map: &Matrix4<f64>| map.fixed_view::<3, 3>(0, 0).into_owned();
    let vector = mark.vector.map(|v| projection.direction(&place.as_ref().map_or(v, |map| linear(map) * v)));
    Ok(Spotlight {
        mark,
        position: staged(&mark.position)?,
        before: staged(&mark.before)?,
        vector: vector.filter(|v| v.iter().all(|c| c.is_finite())),
    })
}

/// Centre and half the largest extent of a box; the origin and 1 where there is none or it is a point.
fn extent(range: Option<(Point, Point)>) -> (Point, f64) {
    let Some((low, high)) = range else { return (Point::origin(), 1.0) };
    let half = high.coords / 2.0 - low.coords / 2.0;
    let centre = Point::from(low.coords / 2.0 + high.coords / 2.0);
    let size = half.amax();
    // Differences below the resolution of the coordinates are rounding, not shape; a subnormal size would
    // overflow when divided by.
    let noise = 4.0 * f64::EPSILON * centre.coords.amax();
    if size > noise && size >= f64::MIN_POSITIVE { (centre, size) } else { (centre, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use loftsman_kernel::mesh::Polyline;
    use loftsman_kernel::scene::Animation;

    #[test]
    fn few_frames_stand_for_many_and_the_last_is_the_object_itself() {
        let line = |x: f64| vec![Point::origin(), Point::new(x, 0.0, 0.0)];
        let mut object = Object::new("line", Polyline { points: line(20.0), closed: false }.into());
        let before = Object::new("line", Polyline { points: line(0.0), closed: false }.into());
        let ghosts = |object: &Object, how: Frames| -> Vec<Ghost> {
            let placed = Placed { object, place: None, index: 0, solid: None };
            chosen(&placed, Some(&before), how).iter().map(|(_, ghost, _)| *ghost).collect()
        };
        let numbers = |object: &Object| -> Vec<usize> {
            let number = |ghost: &Ghost| if let Ghost::Dashed(number) = ghost { *number } else { 0 };
            ghosts(object, Frames::Dashed).iter().map(number).collect()
        };
        assert_eq!(numbers(&object), [0_usize; 0]);
        let frames = |count: u32| (1..=count).map(|i| line(f64::from(i))).collect();
        object.animation = Some(Animation { rate: 24.0, frames: frames(3) });
        assert_eq!(numbers(&object), [1, 2, 3]);
        object.animation = Some(Animation { rate: 24.0, frames: frames(20) });
        assert_eq!(numbers(&object), [1, 4, 7, 10, 13, 16]);
        assert_eq!(ghosts(&object, Frames::Fading(4)), [0.0, 0.25, 0.5, 0.75].map(Ghost::Faded));
        assert_eq!(ghosts(&object, Frames::Fading(100)).len(), 19);
        assert!(ghosts(&object, Frames::Film(4)).is_empty() && ghosts(&object, Frames::Off).is_empty());
        // One that begins with the start is counted from there.
        object.animation =
            Some(Animation { rate: 24.0, frames: (0..=3).map(|i| line(f64::from(i))).collect() });
        assert_eq!(numbers(&object), [1, 2, 3]);
    }
}

//! Marks in pictures: where something was asked of a shape, and where that is after what was done to the shape later.

use std::any::Any;

use crate::edit::{Constraint, Wanted};
use crate::functional::{Curvature, DerivativeAt, Functional, Position, Tangent};
use crate::scene::{Geometry, Object};
use crate::shape::{Derivative, Location, Shape};
use crate::{Point, Vector};

/// How far apart two points may be that count as one, relative to the largest coordinate: rounding of a few conversions.
const SAME: f64 = 1e-9;

/// A mark in a picture: where something was asked of a shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Mark {
    /// The object.
    pub object: String,
    /// What was asked there.
    pub kind: MarkKind,
    /// Where it is after the step, in the object's coordinates.
    pub position: Point,
    /// Where it was before.
    pub before: Point,
    /// The tangent, direction or curvature vector after the step, for kinds that have one.
    pub vector: Option<Vector>,
    /// A few words: `position at 0.25`.
    pub label: String,
    /// Where on the object it is, for [`follow`](Mark::follow); `None` where it is in space only.
    pub spot: Option<Spot>,
    /// Where on the object it is while things move, where that changes: of a place that slides, comes or goes.
    pub track: Option<Track>,
}

/// Where a mark is in each frame of what moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// Frames a second; the first is at 0 s.
    pub rate: f64,
    /// Its spot in each frame; `None` in those in which nothing is asked there.
    pub spots: Vec<Option<Spot>>,
    /// Whether something is still asked there at the end, so that it is marked where things end.
    pub stays: bool,
}

impl Track {
    /// The spot at a moment, in seconds: that of a frame, or between two on the straight way of its parameters, the short way round a
    /// shape that is closed; where it has no spot in one of these, that of the nearer. Before the first frame as in it, after the last as in that.
    fn at(&self, seconds: f64, shape: Option<&dyn Shape>) -> Option<Spot> {
        let last = self.spots.len().checked_sub(1)?;
        let place = (seconds * self.rate).clamp(0.0, last as f64);
        // What is no number is the start.
        let frame = (place.floor() as usize).min(last);
        let part = place - frame as f64;
        let (here, next) = (self.spots[frame], self.spots[(frame + 1).min(last)]);
        let nearer = if part > 0.5 { next } else { here };
        let between = |axis: usize, a: f64, b: f64| {
            let interval = shape.and_then(|shape| shape.domain().get(axis).copied());
            let Some(interval) = interval.filter(|interval| interval.periodic) else {
                return a + part * (b - a);
            };
            let whole = interval.end - interval.start;
            let way = (b - a + 0.5 * whole).rem_euclid(whole) - 0.5 * whole;
            interval.start + (a + part * way - interval.start).rem_euclid(whole)
        };
        match (here, next) {
            _ if part.is_nan() || part <= SAME || here == next => here,
            (Some(Spot::At(Location::Curve(a))), Some(Spot::At(Location::Curve(b)))) => {
                Some(Spot::At(Location::Curve(between(0, a, b))))
            }
            (Some(Spot::At(Location::Surface(a, c))), Some(Spot::At(Location::Surface(b, d)))) => {
                Some(Spot::At(Location::Surface(between(0, a, b), between(1, c, d))))
            }
            _ => nearer,
        }
    }
}

/// What was asked where a mark is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MarkKind {
    /// A point that was moved.
    Moved,
    /// A point that was kept.
    Kept,
    /// A place that slides along its shape.
    Slides,
    /// A derivative or direction.
    Direction,
    /// A curvature.
    Curvature,
    /// A control vertex that could not move.
    Locked,
    /// Anything else.
    Other,
}

/// Where on its object a mark is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Spot {
    /// At parameters.
    At(Location),
    /// At a control vertex.
    Vertex(usize),
}

impl MarkKind {
    /// What a functional asks at its place; `kept` says whether it is only to stay as it is.
    pub fn of(functional: &dyn Functional, kept: bool) -> Self {
        let any: &dyn Any = functional;
        if any.is::<Position>() {
            if kept { Self::Kept } else { Self::Moved }
        } else if any.is::<Curvature>() {
            Self::Curvature
        } else if any.is::<Tangent>() || any.is::<DerivativeAt>() {
            Self::Direction
        } else {
            Self::Other
        }
    }

    /// The vector that a mark of this kind has at a place of a shape; `None` where there is none.
    fn vector(self, shape: &dyn Shape, at: Location) -> Option<Vector> {
        let derivative = |order: usize| shape.value(at, Derivative { u: order, v: 0 }).ok();
        let vector = match self {
            Self::Direction => derivative(1),
            Self::Curvature => derivative(1).zip(derivative(2)).map(curvature_vector),
            _ => None,
        };
        vector.filter(|v| v.norm() > 0.0)
    }
}

/// The curvature vector `κN = (C'' − T (T·C'')) / |C'|²` of the first two derivatives; NaN where the curve stands
/// still.
fn curvature_vector((first, second): (Vector, Vector)) -> Vector {
    let tangent = first.normalize();
    (second - tangent * tangent.dot(&second)) / first.norm_squared()
}

impl Mark {
    /// The mark of what was asked at a place of a shape, which was `before` and is `after`; `None` where either has no such
    /// place.
    pub fn on(
        object: &str,
        (kind, label): (MarkKind, String),
        at: Location,
        before: &dyn Shape,
        after: &dyn Shape,
    ) -> Option<Self> {
        let point = |shape: &dyn Shape| shape.value(at, Derivative::POSITION).ok().map(Point::from);
        Some(Self {
            object: object.to_owned(),
            kind,
            position: point(after)?,
            before: point(before)?,
            vector: kind.vector(after, at),
            label,
            spot: Some(Spot::At(at)),
            track: None,
        })
    }

    /// The mark of a constraint on one of these shapes, which have these names; `None` where it has no place of its own.
    pub fn of(
        constraint: &Constraint,
        names: &[String],
        before: &[Box<dyn Shape>],
        after: &[&dyn Shape],
    ) -> Option<Self> {
        let kept = matches!(constraint.wanted(), Wanted::Keep | Wanted::Hold);
        let functional = constraint.functional().as_ref();
        let (shape, at) = functional.location()?;
        let what = (MarkKind::of(functional, kept), constraint.describe());
        Self::on(names.get(shape)?, what, at, before.get(shape)?.as_ref(), *after.get(shape)?)
    }

    /// Whether this geometry has the mark's spot where the mark is, run through this way or that; takes it there then.
    ///
    /// A shape that was turned over, refined or cut still has the marked point, perhaps at other parameters.
    pub fn rests(&mut self, geometry: &Geometry) -> bool {
        let near = |p: &Point| {
            let size = p.coords.amax().max(self.position.coords.amax());
            (p - self.position).amax() <= SAME * size
        };
        let found = match self.spot {
            None => return true,
            Some(Spot::Vertex(index)) => {
                let points = geometry.points();
                let here = points.get(index).is_some_and(near).then_some(index);
                here.or_else(|| points.iter().position(near)).map(Spot::Vertex)
            }
            Some(Spot::At(at)) => ways(geometry, at).into_iter().enumerate().find_map(|(way, at)| {
                let point = shape(geometry)?.value(at, Derivative::POSITION).ok()?;
                near(&point.into()).then(|| {
                    // Where it was in frames is turned over as it is itself.
                    let spots = self.track.iter_mut().flat_map(|track| &mut track.spots).flatten();
                    for spot in spots {
                        if let Spot::At(own) = spot
                            && let Some(turned) = ways(geometry, *own).get(way)
                        {
                            *own = *turned;
                        }
                    }
                    Spot::At(at)
                })
            }),
        };
        if found.is_some() {
            self.spot = found;
            self.turn(geometry);
        }
        found.is_some()
    }

    /// Moves the mark to where it is at a moment, in seconds: of its [track](Track), where it has one that is of the frames that its object `moves` by now, or of
    /// an object without frames. `still` is the object's geometry then. False where it is not marked then.
    pub fn go_to(&mut self, seconds: f64, moves: &Object, still: &Geometry) -> bool {
        if let Some(track) = &self.track {
            let own = moves.animation.as_ref();
            if own.is_none_or(|own| own.rate == track.rate && own.frames.len() == track.spots.len()) {
                let Some(spot) = track.at(seconds, shape(still)) else { return false };
                self.spot = Some(spot);
            } else if !track.stays {
                return false;
            }
        }
        self.follow(still)
    }

    /// Whether it is marked where things end, and not only on the way there.
    pub fn stays(&self) -> bool {
        self.track.as_ref().is_none_or(|track| track.stays)
    }

    /// Moves the mark to where this geometry, which its object has become, has its spot; false where it has none.
    pub fn follow(&mut self, geometry: &Geometry) -> bool {
        let position = match self.spot {
            None => return true,
            Some(Spot::Vertex(index)) => geometry.points().get(index).copied(),
            Some(Spot::At(at)) => {
                shape(geometry).and_then(|shape| shape.value(at, Derivative::POSITION).ok()).map(Point::from)
            }
        };
        let Some(position) = position else { return false };
        self.position = position;
        self.turn(geometry);
        true
    }

    /// Takes its vector from the geometry, where it has one.
    fn turn(&mut self, geometry: &Geometry) {
        if let (Some(Spot::At(at)), Some(shape), true) = (self.spot, shape(geometry), self.vector.is_some()) {
            self.vector = self.kind.vector(shape, at);
        }
    }
}

/// The shape that a geometry is, or is a part of.
fn shape(geometry: &Geometry) -> Option<&dyn Shape> {
    geometry.shape().ok()
}

/// The parameters themselves, and those of the same point where a direction was turned over.
fn ways(geometry: &Geometry, at: Location) -> Vec<Location> {
    let turned = |space: &crate::spline::Space, u: f64| {
        let (a, b) = space.domain();
        a + (b - u)
    };
    let surface = match geometry {
        Geometry::Surface(surface) => Some(surface),
        Geometry::Trimmed(trimmed) => Some(trimmed.surface()),
        _ => None,
    };
    match (at, geometry, surface) {
        (Location::Curve(u), Geometry::Curve(curve), _) => {
            vec![at, Location::Curve(turned(curve.space(), u))]
        }
        (Location::Surface(u, v), _, Some(surface)) => {
            let (back, over) = (turned(surface.u(), u), turned(surface.v(), v));
            [(u, v), (back, v), (u, over), (back, over)].map(Location::from).into()
        }
        (_, Geometry::Custom(_), _) => vec![at],
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Animation;
    use crate::spline::{Curve, Space};

    fn curve() -> Curve {
        let points = (0..7).map(|k| Point::new(f64::from(k), f64::from(k * k % 5), 0.0)).collect();
        Curve::new(Space::clamped_uniform(3, 7).unwrap(), points).unwrap()
    }

    #[test]
    fn marks_stay_on_what_keeps_its_shape_and_go_along_with_what_moves() {
        let old = curve();
        let kind = (MarkKind::Direction, "tangent".to_owned());
        let mark = Mark::on("c", kind, Location::Curve(1.25), &old, &old).unwrap();
        for (kept, direction) in [
            (old.insert_knots(&[1.5, 1.5]).unwrap(), 1.0),
            (old.elevate(2).unwrap(), 1.0),
            (old.reverse().unwrap(), -1.0),
        ] {
            let mut there = mark.clone();
            assert!(there.rests(&kept.into()));
            assert_eq!(there.position, mark.position);
            assert!((there.vector.unwrap() - mark.vector.unwrap() * direction).norm() < 1e-12);
        }
        // Turned over, then moved: the same point of the shape, not that of the old parameter.
        let back = old.reverse().unwrap();
        let mut there = mark.clone();
        assert!(there.rests(&(&back).into()));
        let moved = back.points().iter().map(|p| p + Vector::new(5.0, 0.0, 1.0)).collect();
        let moved: Geometry = Curve::new(back.space().clone(), moved).unwrap().into();
        assert!(!there.rests(&moved) && there.follow(&moved));
        assert!((there.position - mark.position - Vector::new(5.0, 0.0, 1.0)).norm() < 1e-12);
        // One half of it does not have the place, and is not asked beyond its end.
        let [_, far] = &old.split(2.0).unwrap()[..] else { panic!("two pieces") };
        let mut there = mark.clone();
        assert!(!there.rests(&far.into()) && !there.follow(&far.into()));
    }

    /// In frames, between them, before and after all, round the seam of what is closed, on what is turned over; not where nothing is asked.
    #[test]
    fn a_mark_that_slides_is_where_it_is_at_a_moment() {
        let shape = curve();
        let kind = (MarkKind::Kept, "ring".to_owned());
        let mut mark = Mark::on("c", kind, Location::Curve(3.0), &shape, &shape).unwrap();
        let spot = |u: f64| Some(Spot::At(Location::Curve(u)));
        let track = |spots: &[Option<Spot>]| Some(Track { rate: 2.0, spots: spots.to_vec(), stays: true });
        mark.track = track(&[None, spot(1.0), spot(2.0), spot(3.0)]);
        let mut object = Object::new("c", (&shape).into());
        let at = |mark: &Mark, seconds: f64, object: &Object| {
            let mut there = mark.clone();
            let marked = there.go_to(seconds, object, object.geometry());
            marked.then_some(there.position)
        };
        for frames in [None, Some(4)] {
            let animation = |count| Animation { rate: 2.0, frames: vec![shape.points().to_vec(); count] };
            object.animation = frames.map(animation);
            for (seconds, u) in
                [(0.5, 1.0), (0.7, 1.4), (1.0, 2.0), (1.25, 2.5), (1.5, 3.0), (9.0, 3.0), (0.4, 1.0)]
            {
                let wanted = shape.point(u).unwrap();
                assert!((at(&mark, seconds, &object).unwrap() - wanted).norm() < 1e-12, "{seconds}");
            }
            assert_eq!((at(&mark, 0.0, &object), at(&mark, 0.2, &object)), (None, None));
        }
        // Of other frames it knows nothing, but where it ends.
        object.animation = Some(Animation { rate: 2.0, frames: vec![shape.points().to_vec(); 3] });
        assert_eq!(at(&mark, 0.5, &object), Some(mark.position));
        let gone = Track { stays: false, ..mark.track.clone().unwrap() };
        assert_eq!(at(&Mark { track: Some(gone), ..mark.clone() }, 0.5, &object), None);
        // Turned over it has the same points.
        object.animation = None;
        let back: Geometry = shape.reverse().unwrap().into();
        let mut turned = mark.clone();
        assert!(turned.rests(&back));
        let (one, other) = (at(&mark, 0.7, &object), at(&turned, 0.7, &Object::new("c", back)));
        assert!((one.unwrap() - other.unwrap()).norm() < 1e-12);
        // From 6.8 to 0.2 of seven it goes by 7, not by 3.5.
        let ring = Curve::new(Space::periodic_uniform(3, 7).unwrap(), shape.points().to_vec()).unwrap();
        mark.track = track(&[spot(6.8), spot(0.2)]);
        let object = Object::new("c", (&ring).into());
        assert!((at(&mark, 0.375, &object).unwrap() - ring.point(0.1).unwrap()).norm() < 1e-12);
    }

    #[test]
    fn marks_of_vertices_find_them_again() {
        let old = curve();
        let position = old.points()[2];
        let mut mark = Mark {
            object: "c".into(),
            kind: MarkKind::Locked,
            position,
            before: position,
            vector: None,
            label: "vertex 2 locked".into(),
            spot: Some(Spot::Vertex(2)),
            track: None,
        };
        assert!(mark.rests(&old.reverse().unwrap().into()));
        assert_eq!((mark.spot, mark.position), (Some(Spot::Vertex(4)), position));
        let line = crate::mesh::Polyline { points: vec![Point::origin()], closed: false };
        assert!(!mark.rests(&line.clone().into()) && !mark.follow(&line.into()));
    }
}

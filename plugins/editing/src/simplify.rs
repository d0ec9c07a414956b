//! `simplify`: knots that a spline does not need are removed.

use loftsman_kernel::Point;
use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, Parameters, StepReport, in_own_coordinates,
};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::spline::{Curve, Direction, Space, Surface};
use loftsman_kernel::text::{figure, without_rounding};

use crate::problem::OBJECT;
use crate::representation::{direction, done, not_a_spline, spline};

/// What rounding may do to a point when knots are inserted and removed again, in units of rounding at the largest
/// coordinate: what "exactly" means.
const ROUNDING: f64 = 64.0;
/// Rounds of removal: each starts from what it measured of the one before, so that bounds that add up along a long chain
/// of knots do not keep any of them.
const ROUNDS: usize = 8;

/// The operation `simplify`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Simplify;

impl Operation for Simplify {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            OBJECT,
            Field::optional(
                "tolerance",
                "length",
                "0",
                "how far any point may move; 0 removes the knots that only rounding shows",
            ),
            Field::optional("direction", "\"u\" | \"v\"", "both", "the direction, on a surface"),
            Field::optional(
                "periodic",
                "true | false",
                "false",
                "make what ends where it starts periodic first, so that the seam's knots can go as well",
            ),
        ];
        Declaration {
            name: "simplify",
            help: "remove the knots that are not needed, exactly or within a tolerance; reports how many went",
            fields: FIELDS,
        }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        _: &Context<'_>,
    ) -> std::result::Result<StepReport, OperationError> {
        let name = spline(scene, p)?;
        let tolerance = p.number_or("tolerance", 0.0)?;
        if tolerance < 0.0 {
            let problem = format!("{tolerance} is no length: give 0 or a positive number");
            return Err(p.error("tolerance", problem).into());
        }
        let directions =
            if p.has("direction") { vec![direction(p)?] } else { vec![Direction::U, Direction::V] };
        let close = p.flag("periodic")?;
        let (simplified, before): (Simplified<Geometry>, usize) = match scene.object(&name)?.geometry() {
            Geometry::Curve(curve) => {
                (simplify(curve, &[Direction::U], tolerance, close)?.geometry(), curve.space().knots().len())
            }
            Geometry::Surface(surface) => {
                let before = directions.iter().map(|&d| surface.space(d).knots().len()).sum();
                (simplify(surface, &directions, tolerance, close)?.geometry(), before)
            }
            other => return Err(not_a_spline(&name, other).into()),
        };
        // What was removed exactly has moved nothing but by rounding.
        let size = simplified.shape.points().iter().fold(0.0, |most: f64, p| most.max(p.coords.amax()));
        let longer = scene.standing(&name)?.most();
        let moved = scene.unit.quantity(longer * without_rounding(simplified.moved, size), 1);
        let note = format!(
            "{} of {before} knots removed, {} control vertices left; places moved by {} at most, measured",
            simplified.removed,
            simplified.shape.points().len(),
            moved
        );
        let placed = in_own_coordinates(scene, &name, p, &[], &["tolerance"])?;
        if tolerance > 0.0 {
            scene.replace(&name, simplified.shape)?;
        } else {
            // Exactly so: the frames lose the same knots, where none of them needs one.
            let (object, shape) = (scene.object(&name)?.shared_geometry().clone(), simplified.shape);
            scene.reshape(&name, |geometry| match geometry {
                given if *given == *object => Ok(shape.clone()),
                Geometry::Curve(c) => simplify(c, &[Direction::U], 0.0, close).map(|s| s.geometry().shape),
                Geometry::Surface(s) => simplify(s, &directions, 0.0, close).map(|s| s.geometry().shape),
                other => Err(not_a_spline(&name, other)),
            })?;
        }
        let mut report = done("simplify", name, note);
        report.notes.extend(placed);
        Ok(report)
    }
}

/// What simplifying gave.
struct Simplified<T> {
    shape: T,
    removed: usize,
    /// The largest distance between the two shapes at the same parameters, measured.
    moved: f64,
}

impl<T: Into<Geometry>> Simplified<T> {
    fn geometry(self) -> Simplified<Geometry> {
        Simplified { shape: self.shape.into(), removed: self.removed, moved: self.moved }
    }
}

/// A curve or a surface, for what is done to both.
trait Spline: Clone {
    fn points(&self) -> &[Point];
    fn weights(&self) -> Option<&[f64]>;
    fn space_of(&self, direction: Direction) -> &Space;
    /// The shape with fewer knots, and how many went.
    fn without_knots(&self, direction: Direction, tolerance: f64) -> Result<(Self, usize)>;
    fn closed(&self, direction: Direction, tolerance: f64) -> Result<Self>;
    /// The largest distance between this and another at the same parameters.
    fn distance(&self, other: &Self) -> Result<f64>;
}

impl Spline for Curve {
    fn points(&self) -> &[Point] {
        self.points()
    }

    fn weights(&self) -> Option<&[f64]> {
        self.weights()
    }

    fn space_of(&self, _: Direction) -> &Space {
        self.space()
    }

    fn without_knots(&self, _: Direction, tolerance: f64) -> Result<(Self, usize)> {
        let removal = self.remove_knots(tolerance)?;
        Ok((removal.shape, removal.removed))
    }

    fn closed(&self, _: Direction, tolerance: f64) -> Result<Self> {
        Ok(self.to_periodic(tolerance)?.shape)
    }

    fn distance(&self, other: &Self) -> Result<f64> {
        let mut most = 0.0_f64;
        for u in places(self.space(), 2 * self.degree() + 3) {
            most = larger(most, distance(&self.point(u)?, &other.point(u)?));
        }
        Ok(most)
    }
}

impl Spline for Surface {
    fn points(&self) -> &[Point] {
        self.points()
    }

    fn weights(&self) -> Option<&[f64]> {
        self.weights()
    }

    fn space_of(&self, direction: Direction) -> &Space {
        self.space(direction)
    }

    fn without_knots(&self, direction: Direction, tolerance: f64) -> Result<(Self, usize)> {
        let removal = self.remove_knots(direction, tolerance)?;
        Ok((removal.shape, removal.removed))
    }

    fn closed(&self, direction: Direction, tolerance: f64) -> Result<Self> {
        Ok(self.to_periodic(direction, tolerance)?.shape)
    }

    fn distance(&self, other: &Self) -> Result<f64> {
        let mut most = 0.0_f64;
        let vs = places(self.v(), self.v().degree() + 2);
        for u in places(self.u(), self.u().degree() + 2) {
            for &v in &vs {
                most = larger(most, distance(&self.point(u, v)?, &other.point(u, v)?));
            }
        }
        Ok(most)
    }
}

/// So many places inside each span, the outermost near its ends: at a knot itself a torn shape has two points.
fn places(space: &Space, each: usize) -> Vec<f64> {
    let knots = space.breakpoints();
    let inside = |pair: &[f64]| {
        let (a, b) = (pair[0], pair[1]);
        (0..each).map(move |i| a + (b - a) * (i as f64 + 0.5) / each as f64).collect::<Vec<_>>()
    };
    knots.windows(2).flat_map(inside).collect()
}

/// A distance that does not overflow on the way.
fn distance(p: &Point, q: &Point) -> f64 {
    let d = q - p;
    d.x.hypot(d.y).hypot(d.z)
}

/// The larger of two, or NaN where there is one.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b <= a { a } else { b }
}

/// The shape without the knots that it does not need, in all of these directions. First within the tolerance, then what
/// rounding alone keeps; the answer is measured against what was given.
fn simplify<S: Spline>(
    given: &S,
    directions: &[Direction],
    tolerance: f64,
    close: bool,
) -> Result<Simplified<S>> {
    let size = given.points().iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
    let rounding = ROUNDING * f64::EPSILON * size;
    // What knot removal loses on the way, before it is refined, grows with the degree; and its bound counts weights at
    // their worst. The measured distance then judges.
    let degree = directions.iter().map(|&d| given.space_of(d).degree()).max().unwrap_or(0);
    let growth = 2_f64.powi(degree as i32);
    let spread = given.weights().map_or(1.0, |w| {
        let (low, high) = w.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), &w| (l.min(w), h.max(w)));
        high / low
    });
    let mut last = f64::NAN;
    for factor in [growth * spread.min(1e6), growth, growth.sqrt(), spread.min(1e6), 1.0, 1.0 / 16.0] {
        let within = tolerance.max(rounding * factor);
        let shape = reduce(given, directions, within, close)?;
        let moved = given.distance(&shape)?;
        if moved <= tolerance.max(2.0 * rounding) {
            let count = |s: &S| directions.iter().map(|&d| s.space_of(d).knots().len()).sum::<usize>();
            return Ok(Simplified { removed: count(given).saturating_sub(count(&shape)), shape, moved });
        }
        last = moved;
    }
    Err(Error::Invalid(format!(
        "removing knots would move the shape by {last}, more than {}: its weights differ too much for its knots to \
         be removed safely; give a larger tolerance",
        figure(tolerance.max(2.0 * rounding)),
        last = figure(last)
    )))
}

fn reduce<S: Spline>(given: &S, directions: &[Direction], within: f64, close: bool) -> Result<S> {
    let mut shape = given.clone();
    // Each direction, closing and each round move points: all together no further than allowed.
    let steps = directions.len() as f64;
    // Asked to close both directions of a surface, those that close are closed: one at least.
    let (mut closes, mut failure) = (!close, None);
    for &direction in directions {
        if close {
            match shape.closed(direction, within / steps / 2.0) {
                Ok(closed) => (shape, closes) = (closed, true),
                Err(e) => failure = failure.or(Some(e)),
            }
        }
        let share = within / steps / if close { 2.0 } else { 1.0 };
        let start = shape.clone();
        let mut left = share;
        for _ in 0..ROUNDS {
            let (next, removed) = shape.without_knots(direction, left)?;
            if removed == 0 {
                break;
            }
            left = share - start.distance(&next)?;
            shape = next;
            if left.is_nan() || left <= 0.0 {
                break;
            }
        }
    }
    match failure {
        Some(failure) if !closes => Err(failure),
        _ => Ok(shape),
    }
}

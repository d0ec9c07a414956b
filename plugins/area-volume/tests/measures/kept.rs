//! What is promised after every event: areas and volumes to 1e-12 of themselves, what is linear to rounding.

use std::f64::consts::{PI, TAU};

use loftsman_area_volume::{area, area_of, centroid, closed, gap, volume, volume_of};
use loftsman_kernel::edit::{Ask, Constraint, Edit, Metric, Session};
use loftsman_kernel::functional::{Functional, On, Shapes, position};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::solve::Automatic;
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use nalgebra::Rotation3;
use proptest::prelude::*;

use crate::samples::{ball, patches, torus, uneven};
use crate::sessions::Sequence;

/// Values to 1e-12 of themselves.
const KEPT: f64 = 1e-12;
/// Rounding: a point is a sum of some ten products of numbers as large as the shape, and has been added to as often.
const ROUNDING: f64 = 2e-14;

/// How a closed boundary is made.
#[derive(Debug, Clone, Copy)]
enum Family {
    Periodic,
    PeriodicRational,
    /// Clamped, its ends meeting.
    Clamped,
    ClampedRational,
    /// Two clamped curves joined end to end, the second one against the first one's direction.
    Pieces,
    /// With a rational circle as hole.
    Holed,
}

const FAMILIES: [Family; 6] = [
    Family::Periodic,
    Family::PeriodicRational,
    Family::Clamped,
    Family::ClampedRational,
    Family::Pieces,
    Family::Holed,
];

#[derive(Debug, Clone, Copy)]
enum Wanted {
    Keep,
    To,
    By,
    Scale,
}

/// The way around an ellipse from `from` to `to` (in turns), as control vertices of a space, a little uneven.
fn along(space: &Space, from: f64, to: f64, random: &mut Sequence) -> Vec<Point> {
    let n = space.len();
    let steps = if space.is_periodic() { n } else { n - 1 };
    let at = |i: usize, random: &mut Sequence| {
        let (sin, cos) = (TAU * (from + (to - from) * i as f64 / steps as f64)).sin_cos();
        let r = if i == 0 || i + 1 == n { 1.0 } else { 1.0 + 0.1 * random.next() };
        Point::new(2.0 * r * cos, r * sin, 0.0)
    };
    (0..n).map(|i| at(i, random)).collect()
}

fn clamped(degree: usize) -> Space {
    Space::clamped(degree, &uneven(5)).unwrap()
}

fn boundary(family: Family, degree: usize, random: &mut Sequence) -> Vec<Curve> {
    let weights = |n: usize, random: &mut Sequence| (0..n).map(|_| 1.2 + 0.7 * random.next()).collect();
    match family {
        Family::Periodic | Family::PeriodicRational => {
            let space = Space::periodic(degree, uneven(degree + 7)).unwrap();
            let points = along(&space, 0.0, 1.0, random);
            let weights = matches!(family, Family::PeriodicRational).then(|| weights(points.len(), random));
            vec![Curve::build(space, points, weights).unwrap()]
        }
        Family::Clamped | Family::ClampedRational => {
            let points = along(&clamped(degree), 0.0, 1.0, random);
            let weights = matches!(family, Family::ClampedRational).then(|| weights(points.len(), random));
            vec![Curve::build(clamped(degree), points, weights).unwrap()]
        }
        Family::Pieces => {
            let there = along(&clamped(degree), 0.0, 0.6, random);
            let back = along(&clamped(degree + 1), 1.0, 0.6, random);
            vec![Curve::new(clamped(degree), there).unwrap(), Curve::new(clamped(degree + 1), back).unwrap()]
        }
        Family::Holed => {
            let mut all = boundary(Family::Periodic, degree, random);
            all.push(Curve::circle(Point::new(0.2, 0.1, 0.0), Vector::z(), 0.3).unwrap());
            all
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(160))]

    #[test]
    fn after_every_event_the_area_holds_and_all_that_is_linear(
        family in proptest::sample::select(&FAMILIES[..]),
        wanted in proptest::sample::select(&[Wanted::Keep, Wanted::To, Wanted::By, Wanted::Scale][..]),
        degree in 1_usize..=5,
        alternating: bool,
        with_normal: bool,
        turn in proptest::array::uniform3(-3.0_f64..3.0),
        exponent in -9_i32..=9,
        seed: u32,
    ) {
        let size = 10.0_f64.powi(exponent);
        let mut random = Sequence(seed);
        let turn = Rotation3::from_euler_angles(turn[0], turn[1], turn[2]);
        let shift = random.vector(3.0 * size);
        let curves: Vec<Curve> = boundary(family, degree, &mut random)
            .into_iter()
            .map(|curve| {
                let (space, points, weights) = curve.into_parts();
                let points = points.iter().map(|p| turn * p * size + shift).collect();
                Curve::build(space, points, weights).unwrap()
            })
            .collect();
        let mut asked = match family {
            Family::Holed => area().holes([1]),
            Family::Pieces => area().of([0, 1]),
            _ => area(),
        };
        if with_normal {
            asked = asked.normal(turn * Vector::z());
        }
        let before: Vec<&dyn Shape> = curves.iter().map(|c| c as &dyn Shape).collect();
        let measure = asked.bind(&Shapes::new(before.iter().copied())).unwrap().unwrap();
        let value = |shapes: &[&dyn Shape]| {
            let mut out = [f64::NAN];
            measure.value(&Shapes::new(shapes.iter().copied()), &mut out).unwrap();
            out[0]
        };
        let present = value(&before);
        let (constraint, target) = match wanted {
            Wanted::Keep => (asked.keep(), present),
            Wanted::To => (asked.to(1.1 * present), 1.1 * present),
            Wanted::By => (asked.by(-0.1 * present), 0.9 * present),
            Wanted::Scale => (asked.scale(1.05), 1.05 * present),
        };
        let (a, b) = curves[0].domain();
        let (handle, held) = (a + 0.31 * (b - a), a + 0.77 * (b - a));
        let mut edit = Edit::new(&curves[0]).ask(constraint).ask(position(held).keep()).handle(position(handle));
        for curve in &curves[1..] {
            edit = edit.with(curve.boxed());
        }
        let edit = if alternating { edit.alternating() } else { edit };
        let mut session = edit.prepare(Automatic).unwrap();
        let (from, stays) = (curves[0].point(handle).unwrap(), curves[0].point(held).unwrap());
        let reach = 3.0 * size + shift.norm();
        let mut here = Vector::zeros();
        for event in 0..8 {
            let step = Vector::new(random.next(), random.next(), 0.0) * 0.08;
            here = (here + step).map(|c| c.clamp(-0.2, 0.2));
            let to = from + turn * here * size;
            session.to_point(to).unwrap();
            let shape = session.shape();
            for (found, place) in [(handle, to), (held, stays)] {
                let off = (shape.point(found).unwrap() - place).amax();
                prop_assert!(off <= ROUNDING * reach, "event {event}: {off:e} of {reach} off {place}");
            }
            let now: Vec<&dyn Shape> = (0..curves.len()).map(|i| session.shape_at(i).unwrap()).collect();
            let error = value(&now) / target - 1.0;
            prop_assert!(error.abs() <= KEPT, "event {event}: {error:e}");
            let open = gap(&Shapes::new(now), &(0..curves.len()).map(On::from).collect::<Vec<_>>()).unwrap();
            prop_assert!(open <= ROUNDING * reach, "event {event}: open by {open:e}");
        }
    }
}

/// A mouse that wanders within reach for so many events; `check` looks at the shapes after each of them.
fn wander<S: Shape>(
    session: &mut Session<S>,
    from: Point,
    events: usize,
    check: impl Fn(&Session<S>, Point, usize),
) {
    let mut random = Sequence(5);
    let mut here = Vector::zeros();
    for event in 0..events {
        here = (here + random.vector(0.05)).map(|c| c.clamp(-0.4, 0.4));
        session.to_point(from + here).unwrap();
        check(session, from + here, event);
    }
}

fn number(functional: &dyn Functional, shapes: &Shapes<'_>) -> f64 {
    let mut out = [f64::NAN];
    functional.value(shapes, &mut out).unwrap();
    out[0]
}

#[test]
fn ten_thousand_random_events_keep_volume_poles_and_all_that_is_linear() {
    for (surface, at, held) in
        [(ball(6, 5), [1.5, 1.0], [4.5, 1.2]), (torus(5, 4, 2), [1.5, 1.0], [3.5, 2.5])]
    {
        for alternating in [false, true] {
            let kept = volume_of(&surface).unwrap();
            let measure = volume().bind(&Shapes::one(&surface)).unwrap().unwrap();
            let shut = closed().bind(&Shapes::one(&surface)).unwrap().unwrap();
            let edit =
                Edit::new(&surface).ask(volume().keep()).ask(position(held).keep()).handle(position(at));
            let mut session = if alternating { edit.alternating() } else { edit }.prepare(Automatic).unwrap();
            let from = surface.point(at[0], at[1]).unwrap();
            let stays = surface.point(held[0], held[1]).unwrap();
            wander(&mut session, from, 10_000, |session, to, event| {
                let shape = session.shape();
                let error = number(measure.as_ref(), &Shapes::one(shape)) / kept - 1.0;
                assert!(error.abs() <= KEPT, "event {event}: {error:e}");
                assert!((shape.point(at[0], at[1]).unwrap() - to).amax() <= ROUNDING, "event {event}");
                assert!((shape.point(held[0], held[1]).unwrap() - stays).amax() <= ROUNDING, "event {event}");
                let mut open = vec![f64::NAN; shut.equations()];
                shut.value(&Shapes::one(shape), &mut open).unwrap();
                assert!(open.iter().all(|gap| gap.abs() <= ROUNDING), "event {event}: {open:?}");
            });
            // The same measured anew, from the middle of where the surface is now.
            assert!((volume_of(session.shape()).unwrap() / kept - 1.0).abs() <= KEPT);
            let back = session.to_point(from).unwrap();
            let pairs = back.points().iter().zip(surface.points());
            let moved = pairs.map(|(a, b)| (a - b).amax()).fold(0.0, f64::max);
            assert!(alternating || moved <= ROUNDING, "all axes together do not drift: {moved:e}");
        }
    }
}

#[test]
fn a_thousand_random_events_keep_the_centroid_beside_the_volume() {
    let surface = ball(6, 5);
    let edit = Edit::new(&surface).ask(volume().keep()).ask(centroid().keep()).handle(position([1.5, 1.0]));
    let mut session = edit.prepare(Automatic).unwrap();
    let solid = volume().bind(&Shapes::one(&surface)).unwrap().unwrap();
    let middle = centroid().bind(&Shapes::one(&surface)).unwrap().unwrap();
    let kept = number(solid.as_ref(), &Shapes::one(&surface));
    let place = |shape: &Surface| {
        let mut out = [f64::NAN; 3];
        middle.value(&Shapes::one(shape), &mut out).unwrap();
        Point::from(out)
    };
    let start = place(&surface);
    wander(&mut session, surface.point(1.5, 1.0).unwrap(), 1000, |session, _, event| {
        let error = number(solid.as_ref(), &Shapes::one(session.shape())) / kept - 1.0;
        assert!(error.abs() <= KEPT, "event {event}: {error:e}");
        // Near the origin: its own size is no measure, the surface's is.
        assert!((place(session.shape()) - start).amax() <= KEPT, "event {event}");
    });
}

#[test]
fn a_thousand_random_events_keep_what_patches_enclose() {
    let cube = patches(3, 0.2);
    let shapes: Vec<&dyn Shape> = cube.iter().map(|s| s as &dyn Shape).collect();
    let measure = volume().of(0..6).bind(&Shapes::new(shapes.iter().copied())).unwrap().unwrap();
    let kept = number(measure.as_ref(), &Shapes::new(shapes));
    let on: Vec<On> = (0..6).map(On::from).collect();
    for alternating in [false, true] {
        let mut edit = Edit::new(&cube[0]).ask(volume().of(0..6).keep()).handle(position([0.3, 0.6]));
        for patch in &cube[1..] {
            edit = edit.with(patch.boxed());
        }
        let mut session = if alternating { edit.alternating() } else { edit }.prepare(Automatic).unwrap();
        wander(&mut session, cube[0].point(0.3, 0.6).unwrap(), 1000, |session, to, event| {
            let error = number(measure.as_ref(), &session.problem().shapes()) / kept - 1.0;
            assert!(error.abs() <= KEPT, "event {event}: {error:e}");
            assert!((session.shape().point(0.3, 0.6).unwrap() - to).amax() <= ROUNDING, "event {event}");
            if event % 50 == 0 {
                assert!(gap(&session.problem().shapes(), &on).unwrap() <= ROUNDING, "event {event}");
            }
        });
    }
}

/// Knots a thousand times closer at the nose than at the tail, as where measured points are: bending's metric is then as badly
/// conditioned as metrics come.
#[test]
fn linear_constraints_hold_to_rounding_whatever_the_metric() {
    let steps = (0..24).map(|i| 1e-3_f64.powf(1.0 - (f64::from(i) - 11.5).abs() / 11.5));
    let mut knots = vec![0.0];
    for step in steps {
        knots.push(knots[knots.len() - 1] + step);
    }
    let space = Space::periodic(3, knots).unwrap();
    let points = along(&space, 0.0, 1.0, &mut Sequence(7));
    let curve = Curve::new(space, points).unwrap();
    let (a, b) = curve.domain();
    let at = |share: f64| a + share * (b - a);
    for metric in [Metric::Bend, Metric::Stretch, Metric::Least] {
        let kept = area_of(&curve).unwrap();
        let edit = Edit::new(&curve).metric(metric).ask(area().keep());
        let mut edit = edit.handle(position(at(0.2)));
        let held = [0.05, 0.35, 0.5, 0.64, 0.9];
        for share in held {
            edit = edit.ask(position(at(share)).keep());
        }
        let mut session = edit.prepare(Automatic).unwrap();
        let from = curve.point(at(0.2)).unwrap();
        for step in 1..=5 {
            let to = from + Vector::new(0.01, 0.02, 0.0) * f64::from(step);
            let shape = session.to_point(to).unwrap();
            assert!((area_of(shape).unwrap() / kept - 1.0).abs() <= KEPT);
            assert!((shape.point(at(0.2)).unwrap() - to).amax() <= ROUNDING);
            for share in held {
                let apart = (shape.point(at(share)).unwrap() - curve.point(at(share)).unwrap()).amax();
                assert!(apart <= ROUNDING, "step {step}, at {share}: {apart:e}");
            }
        }
    }
}

/// What is committed is the least way to within 1e-10, whichever way the handle went: the same as asked for at once.
#[test]
fn what_is_committed_is_least() {
    let curve = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap();
    let from = curve.point(0.4).unwrap();
    let goal = from + Vector::new(0.3, 0.1, 0.0);
    let edit = || Edit::new(&curve).ask(area().keep()).handle(position(0.4));
    let mut direct = edit().prepare(Automatic).unwrap();
    direct.to_point(goal).unwrap();
    let mut around = edit().prepare(Automatic).unwrap();
    for way in [Vector::new(-0.2, 0.3, 0.0), Vector::new(0.5, -0.1, 0.0), Vector::new(0.29, 0.11, 0.0)] {
        around.to_point(from + way).unwrap();
    }
    around.to_point(goal).unwrap();
    let (direct, around) = (direct.commit().unwrap(), around.commit().unwrap());
    let asked = Edit::new(&curve).ask(area().keep()).ask(position(0.4).to(goal)).solve().unwrap();
    for other in [around.shape(), asked.shape()] {
        let pairs = direct.shape().points().iter().zip(other.points());
        let apart = pairs.map(|(a, b)| (a - b).amax()).fold(0.0, f64::max);
        assert!(apart <= 1e-10, "{apart:e}");
    }
    // Nothing was dragged: nothing is committed.
    let still = edit().prepare(Automatic).unwrap().commit().unwrap();
    assert_eq!(still.shape(), &curve);
}

/// The whole way around by [`Constraint`]s that say the same in four ways.
#[test]
fn what_is_kept_is_given_and_scaled_alike() {
    let curve = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap();
    let asked: [Constraint; 4] = [area().keep(), area().to(PI), area().by(0.0), area().scale(1.0)];
    let solve = |constraint| {
        let edit = Edit::new(&curve).ask(constraint).ask(position(0.1).by([0.1, 0.05, 0.0]));
        edit.solve().unwrap().into_shape()
    };
    let [first, rest @ ..] = asked.map(solve);
    for other in rest {
        let apart =
            first.points().iter().zip(other.points()).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max);
        assert!(apart < 1e-10, "{apart:e}");
    }
}

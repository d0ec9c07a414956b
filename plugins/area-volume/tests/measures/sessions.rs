//! Drags and edits that keep or change areas and volumes.

use loftsman_area_volume::{area, area_of, centroid, length, surface_area, volume, volume_of};
use loftsman_kernel::edit::{Ask, Edit, Metric};
use loftsman_kernel::functional::{join, position, symmetry, tangent};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::solve::Automatic;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

use crate::samples::{ball, circle, oval, patches, pebble, ring, sphere, torus, uneven};

/// `[-1, 1)`, the same on every machine.
pub(crate) struct Sequence(pub(crate) u32);

impl Sequence {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(self.0) / 2_147_483_648.0 - 1.0
    }

    pub(crate) fn vector(&mut self, size: f64) -> Vector {
        Vector::new(self.next(), self.next(), self.next()) * size
    }
}

#[test]
fn ten_thousand_random_events_keep_area_and_all_that_is_linear() {
    for alternating in [false, true] {
        let start = oval();
        let kept = area_of(&start).unwrap();
        let edit = Edit::new(&start).ask(area().keep()).ask(position(6.0).keep()).ask(tangent(6.0).keep());
        let edit = edit.handle(position(0.0));
        let mut session = if alternating { edit.alternating() } else { edit }.prepare(Automatic).unwrap();
        let (held, along) = (start.point(6.0).unwrap(), start.derivative(6.0, 1).unwrap().normalize());
        let mut random = Sequence(5);
        let from = start.point(0.0).unwrap();
        let mut here = Vector::zeros();
        for event in 0..10_000 {
            // A mouse that wanders within reach.
            here = (here + random.vector(0.08)).map(|c| c.clamp(-0.6, 0.6));
            here.z = 0.0;
            let shape = session.to_point(from + here).unwrap();
            let now = area_of(shape).unwrap();
            assert!((now / kept - 1.0).abs() <= 1e-12, "event {event}: {:e}", now / kept - 1.0);
            assert!((shape.point(0.0).unwrap() - from - here).amax() <= 1e-14, "event {event}");
            assert!((shape.point(6.0).unwrap() - held).amax() <= 1e-14, "event {event}");
            let tangent = shape.derivative(6.0, 1).unwrap();
            assert!(tangent.cross(&along).amax() <= 1e-13, "event {event}");
        }
        let back = session.to_point(from).unwrap();
        let moved = back.points().iter().zip(start.points()).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max);
        if alternating {
            // Each event starts from the last one: the way is remembered, as in the paper. Nothing bounds the sum of ten
            // thousand least ways but what is kept; the shape wanders among those that keep it, and must not come apart:
            // its length stays of the size of the oval's, whose area it has.
            let length = back.length(1e-9).unwrap().value;
            assert!(moved > 0.0 && length < 2.0 * start.length(1e-9).unwrap().value, "{length}");
        } else {
            assert!(moved < 1e-14, "all axes together do not drift: {moved:e}");
        }
    }
}

#[test]
fn an_area_can_be_given_in_every_way() {
    for curve in [oval(), circle(1.0), pebble(), ring(Space::periodic(5, uneven(12)).unwrap())] {
        let before = area_of(&curve).unwrap();
        for (constraint, wanted) in [
            (area().to(3.0), 3.0),
            (area().by(-0.5), before - 0.5),
            (area().scale(1.7), 1.7 * before),
            (area().keep(), before),
        ] {
            let edit = Edit::new(&curve).ask(constraint).ask(position(0.1).by([0.1, 0.2, 0.0]));
            let solved = edit.solve().unwrap();
            let now = area_of(solved.shape()).unwrap();
            assert!((now / wanted - 1.0).abs() < 1e-12, "{now} is not {wanted}");
            assert!(solved.report().residual < 1e-12, "{}", solved.report());
        }
    }
}

#[test]
fn closed_ends_stay_together() {
    for curve in [circle(1.0), pebble()] {
        let (a, b) = curve.domain();
        let solved =
            Edit::new(&curve).ask(area().keep()).ask(position(a).by([0.2, 0.1, 0.0])).solve().unwrap();
        let shape = solved.shape();
        assert!((shape.point(a).unwrap() - shape.point(b).unwrap()).amax() < 1e-15);
    }
}

#[test]
fn it_does_not_depend_on_axes_or_scale() {
    let turn = nalgebra::Rotation3::from_euler_angles(0.4, -0.7, 1.1);
    let solve = |map: &dyn Fn(Point) -> Point, by: Vector| {
        let start = oval();
        let moved =
            Curve::new(start.space().clone(), start.points().iter().map(|p| map(*p)).collect()).unwrap();
        let edit = Edit::new(&moved).ask(area().keep()).ask(position(3.0).keep());
        edit.ask(position(0.0).by(by)).solve().unwrap().into_shape()
    };
    let by = Vector::new(0.5, 0.3, 0.0);
    let plain = solve(&|p| p, by);
    for scale in [1e-9, 1e-3, 1.0, 1e9] {
        let shift = Vector::new(3.0, -2.0, 5.0) * scale;
        let turned = solve(&|p| turn * p * scale + shift, turn * by * scale);
        for (a, b) in turned.points().iter().zip(plain.points()) {
            let expected = turn * b * scale + shift;
            assert!((a - expected).amax() < 1e-11 * scale, "{scale}: {a} is not {expected}");
        }
    }
}

#[test]
fn symmetry_and_locks_hold_beside_area() {
    // Paper 2, figure 2: symmetric about the y axis, its area kept.
    let start = oval();
    let kept = area_of(&start).unwrap();
    let edit = Edit::new(&start).ask(area().keep()).ask(symmetry([1.0, 0.0, 0.0], [0.0, 0.0, 0.0]).hold());
    let mut session = edit.lock([9]).handle(position(1.5)).prepare(Automatic).unwrap();
    let from = start.point(1.5).unwrap();
    for step in 1..=20 {
        let to = from + Vector::new(-0.05, 0.03, 0.0) * f64::from(step);
        let shape = session.to_point(to).unwrap();
        assert!((area_of(shape).unwrap() / kept - 1.0).abs() < 1e-12);
        let p = shape.points();
        assert!(p[9] == start.points()[9] && (shape.point(1.5).unwrap() - to).amax() < 1e-14);
        for i in 0..12 {
            let mirror = p[(18 - i) % 12];
            assert!((p[i].x + mirror.x).abs() < 1e-14 && (p[i].y - mirror.y).abs() < 1e-14, "{step}, {i}");
        }
    }
}

#[test]
fn several_areas_at_once_and_compounds() {
    let hole = circle(0.3);
    let outer = oval();
    let (outside, inside) = (area_of(&outer).unwrap(), area_of(&hole).unwrap());
    let edit =
        Edit::new(&outer).with(Box::new(hole.clone())).ask(area().scale(1.1)).ask(area().on(1).scale(0.9));
    let solved = edit.ask(position(0.2).on(1).by([0.1, 0.0, 0.0])).solve().unwrap();
    let inner: &dyn std::any::Any = solved.shape_at(1).unwrap();
    let inner = inner.downcast_ref::<Curve>().unwrap();
    assert!((area_of(solved.shape()).unwrap() / (1.1 * outside) - 1.0).abs() < 1e-12);
    assert!((area_of(inner).unwrap() / (0.9 * inside) - 1.0).abs() < 1e-12);
    // What is between them is kept while the hole grows: the outside gives way.
    let edit =
        Edit::new(&outer).with(Box::new(hole)).ask(area().holes([1]).keep()).ask(area().on(1).scale(2.0));
    let solved = edit.solve().unwrap();
    assert!(
        (area_of(solved.shape()).unwrap() / (outside + inside) - 1.0).abs() < 1e-12,
        "{}",
        solved.report()
    );
    // A half disc of two pieces that a join holds at one corner anyway.
    let arc =
        Curve::elliptic_arc(Point::origin(), Vector::x(), Vector::y(), 0.0, std::f64::consts::PI).unwrap();
    let line = Curve::line(Point::new(-1.0, 0.0, 0.0), Point::new(1.0, 0.0, 0.0)).unwrap();
    let (_, end) = arc.domain();
    let edit =
        Edit::new(&arc).with(Box::new(line)).ask(area().of([0, 1]).keep()).ask(join(end, 1, 0.0, 0).hold());
    let solved = edit.ask(position(0.5 * end).by([0.0, 0.3, 0.0])).solve().unwrap();
    let line: &dyn std::any::Any = solved.shape_at(1).unwrap();
    let line = line.downcast_ref::<Curve>().unwrap();
    assert!((solved.shape().point(0.0).unwrap() - line.point(1.0).unwrap()).amax() < 1e-15);
    assert!(solved.report().residual < 1e-12, "{}", solved.report());
}

#[test]
fn volumes_are_kept_through_drags() {
    for alternating in [false, true] {
        for (surface, at) in
            [(ball(10, 7), [2.5, 1.5]), (torus(8, 6, 3), [3.0, 2.0]), (sphere(1.0), [1.0, 0.5])]
        {
            let kept = volume_of(&surface).unwrap();
            let edit = Edit::new(&surface).ask(volume().keep()).handle(position(at));
            let mut session = if alternating { edit.alternating() } else { edit }.prepare(Automatic).unwrap();
            let from = surface.point(at[0], at[1]).unwrap();
            let mut random = Sequence(3);
            for event in 0..60 {
                let to = from + random.vector(0.3);
                let shape = session.to_point(to).unwrap();
                let now = volume_of(shape).unwrap();
                assert!((now / kept - 1.0).abs() < 1e-12, "event {event}: {:e}", now / kept - 1.0);
                assert!((shape.point(at[0], at[1]).unwrap() - to).amax() < 1e-14);
            }
        }
    }
}

#[test]
fn patches_stay_together_and_keep_their_volume() {
    let cube = patches(3, 0.2);
    let mut edit = Edit::new(&cube[0]).ask(volume().of(0..6).scale(1.2));
    for patch in &cube[1..] {
        edit = edit.with(patch.boxed());
    }
    let solved =
        edit.ask(position([0.4, 0.6]).by([0.1, 0.1, 0.3])).ask(position([0.0, 0.0]).by([0.2, 0.0, 0.0]));
    let solved = solved.metric(Metric::Least).solve().unwrap();
    assert!(solved.report().residual < 1e-12, "{}", solved.report());
    let shapes: Vec<&dyn Shape> = (0..6).map(|i| solved.shape_at(i).unwrap()).collect();
    let shapes = loftsman_kernel::functional::Shapes::new(shapes);
    let on: Vec<_> = (0..6).map(loftsman_kernel::functional::On::from).collect();
    assert!(loftsman_area_volume::gap(&shapes, &on).unwrap() < 1e-13);
}

#[test]
fn centroid_length_and_surface_area_are_kept_and_given() {
    let start = oval();
    let kept = area_of(&start).unwrap();
    // Heavier to the right: the centroid moves, the area and the length stay.
    let edit = Edit::new(&start).ask(area().keep()).ask(length().keep()).ask(centroid().by([0.1, 0.05, 0.0]));
    let solved = edit.ask(position(6.0).keep()).solve().unwrap();
    assert!((area_of(solved.shape()).unwrap() / kept - 1.0).abs() < 1e-12);
    assert!(solved.report().residual < 1e-12, "{}", solved.report());
    // Only across: along x it may go where it likes.
    let edit = Edit::new(&start).ask(centroid().by([0.0, 0.2, 0.0]).axis(loftsman_kernel::edit::Axis::Y));
    let solved = edit.ask(position(0.0).keep()).solve().unwrap();
    assert!(solved.report().equations == 4 && solved.report().residual < 1e-12, "{}", solved.report());
    let ball = ball(8, 6);
    let edit = Edit::new(&ball).ask(volume().keep()).ask(centroid().keep()).ask(surface_area().scale(1.02));
    let solved = edit.ask(position([2.0, 1.5]).by([0.1, 0.1, 0.0])).solve().unwrap();
    assert!(solved.report().residual < 1e-11, "{}", solved.report());
    assert!((volume_of(solved.shape()).unwrap() / volume_of(&ball).unwrap() - 1.0).abs() < 1e-12);
}

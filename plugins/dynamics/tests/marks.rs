//! Where pictures mark what is held: in each frame where it is then.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests may fail the test")]

use loftsman_dynamics::Dynamics;
use loftsman_kernel::Point;
use loftsman_kernel::plugin::{Context, Mark, MarkKind, Parameters, Registry};
use loftsman_kernel::scene::{Geometry, Object, Scene, Unit};
use loftsman_kernel::spline::{Curve, Space};

use serde_json::{Value, json};

fn simulated(objects: Vec<(&str, Curve)>, fields: Value) -> (Scene, Vec<Mark>) {
    let mut scene = Scene::new();
    scene.unit = Unit::Metre;
    for (name, curve) in objects {
        scene.add(Object::new(name, Geometry::Curve(curve))).unwrap();
    }
    let mut registry = Registry::new();
    registry.add(&Dynamics);
    loftsman_kernel::plugin::register_functionals(&mut registry);
    let operation = registry.find_operation("simulate", "step[0]").unwrap();
    let report = operation
        .apply(&mut scene, &Parameters::new(fields, "step[0]").unwrap(), &Context::quiet(&registry))
        .unwrap();
    (scene, report.marks)
}

/// The positions of the marks of one name in each frame; `None` where there is none.
fn positions(scene: &Scene, marks: &[Mark], name: &str, frame: usize) -> Vec<Option<Point>> {
    let seconds = frame as f64 / 24.0;
    let still = scene.at(seconds).unwrap();
    let own = marks.iter().filter(|mark| mark.label == name);
    own.map(|mark| {
        let mut there = mark.clone();
        let objects = [scene, &still].map(|scene| scene.object(&mark.object).unwrap());
        there.go_to(seconds, objects[0], objects[1].geometry()).then_some(there.position)
    })
    .collect()
}

fn rope(degree: usize, n: usize) -> Curve {
    let space = Space::clamped_uniform(degree, n).unwrap();
    let end = space.domain().1;
    let at = |i: usize| Point::new(4.0 * space.greville(i) / end, 0.0, 0.0);
    let points = (0..n).map(at).collect();
    Curve::new(space, points).unwrap()
}

/// Rings that stay in space are marked there in all frames, while the rope slides through them.
#[test]
fn a_ring_is_marked_where_it_is() {
    for degree in 1..=5 {
        let rope = rope(degree, 14);
        let end = rope.space().domain().1;
        let ring = rope.point(0.3 * end).unwrap();
        let fields = json!({ "seconds": 0.5, "scheme": "implicit", "mass": 0.1, "stiffness": 50, "constraints": [
            { "kind": "fixed", "at": 0 },
            { "kind": "fixed", "at": end, "to": [[4, 0, 0], [5, 0, 1]], "name": "hand" },
            { "kind": "sliding", "near": 0.3 * end, "name": "ring" },
        ] });
        let (scene, marks) = simulated(vec![("rope", rope)], fields);
        let mark = marks.iter().find(|mark| mark.label == "ring").unwrap();
        // The legend of pictures: what slides is no kept point.
        assert!(
            marks.iter().all(|m| m.kind == if m.label == "ring" { MarkKind::Slides } else { MarkKind::Kept })
        );
        let mut farthest = 0.0_f64;
        for frame in 0..=12 {
            let [Some(place)] = positions(&scene, &marks, "ring", frame)[..] else { panic!("one mark") };
            assert!((place - ring).norm() < 1e-4, "degree {degree}, frame {frame}: {place}");
            // Not where the place is that it has come to at the end.
            let mut last = Mark { track: None, ..mark.clone() };
            assert!(last.follow(scene.at(frame as f64 / 24.0).unwrap().object("rope").unwrap().geometry()));
            farthest = farthest.max((last.position - ring).norm());
            let [Some(hand)] = positions(&scene, &marks, "hand", frame)[..] else { panic!("one mark") };
            let still = scene.at(frame as f64 / 24.0).unwrap();
            let end = *still.object("rope").unwrap().geometry().points().last().unwrap();
            assert!((hand - end).norm() < 1e-12, "{frame}: {hand} {end}");
        }
        assert!(farthest > 0.1, "it slides: {farthest}");
    }
}

/// Both places of what is tied, one of them on a wire that stands still and has no frames, are marked where they meet.
#[test]
fn both_places_of_a_bead_are_marked_where_they_meet() {
    let wire = rope(3, 8);
    let line = |points: Vec<Point>| Curve::new(Space::clamped_uniform(1, 2).unwrap(), points).unwrap();
    let start = wire.point(1.0).unwrap();
    let bead = line(vec![start, start + loftsman_kernel::Vector::new(0.0, 0.0, -0.2)]);
    let fields = json!({ "object": "bead", "seconds": 0.5, "gravity": [3, 0, -9.81], "damping": 0, "constraints": [
        { "kind": "tied", "at": 0, "other": "wire", "other_near": 1, "name": "tie" },
    ] });
    let (scene, marks) = simulated(vec![("bead", bead), ("wire", wire)], fields);
    let mut places = Vec::new();
    for frame in 0..=12 {
        let [Some(one), Some(other)] = positions(&scene, &marks, "tie", frame)[..] else {
            panic!("two marks")
        };
        assert!((one - other).norm() < 1e-5, "{frame}: {one} {other}");
        places.push(one.x);
    }
    assert!(places[12] - places[0] > 0.1, "{places:?}");
}

/// A loop that runs round itself is marked at both of its places, which are one.
#[test]
fn a_loop_is_marked_where_it_crosses_itself() {
    let n = 16;
    let space = Space::clamped_uniform(3, n).unwrap();
    let points = [
        [0.0, 0.0],
        [0.5, 0.0],
        [1.0, 0.0],
        [1.5, 0.0],
        [2.0, 0.0],
        [2.6, 0.3],
        [2.8, 1.0],
        [2.0, 1.6],
        [1.2, 1.0],
        [1.4, 0.3],
        [2.0, 0.0],
        [2.5, 0.0],
        [3.0, 0.0],
        [3.5, 0.0],
        [4.0, 0.0],
        [4.5, 0.0],
    ];
    let curve = Curve::new(space.clone(), points.map(|[x, y]| Point::new(x, y, 0.0)).to_vec()).unwrap();
    // Where it crosses itself: the nearest pair of two parts.
    let sample = |a: f64, b: f64| (0..=400).map(move |k| a + (b - a) * f64::from(k) / 400.0);
    let (mut best, mut least) = ([0.0; 2], f64::INFINITY);
    for a in sample(1.0, 4.5) {
        for b in sample(6.5, 10.0) {
            let apart = (curve.point(a).unwrap() - curve.point(b).unwrap()).norm();
            if apart < least {
                (best, least) = ([a, b], apart);
            }
        }
    }
    let end = space.domain().1;
    let fields = json!({ "seconds": 0.5, "scheme": "implicit", "gravity": [0, 0, 0], "stiffness": 30, "mass": 0.1, "constraints": [
        { "kind": "fixed", "at": 0 },
        { "kind": "double-sliding", "near": best, "name": "loop" },
        { "kind": "fixed", "at": end, "to": [[4.5, 0, 0], [5.5, 0.5, 0]] },
    ] });
    let (scene, marks) = simulated(vec![("rope", curve)], fields);
    let loops: Vec<&Mark> = marks.iter().filter(|mark| mark.label == "loop").collect();
    let mut apart_at_the_end = 0.0_f64;
    for frame in 4..=12 {
        let [Some(one), Some(other)] = positions(&scene, &marks, "loop", frame)[..] else {
            panic!("two marks")
        };
        // What was missing at the start is drawn in by then.
        assert!(
            (one - other).norm() < 2e-2 * 0.5_f64.powi(frame as i32 - 4) + 1e-4,
            "{frame}: {one} {other}"
        );
        let still = scene.at(frame as f64 / 24.0).unwrap();
        let ends = [0, 1].map(|k| {
            let mut last = Mark { track: None, ..loops[k].clone() };
            assert!(last.follow(still.object("rope").unwrap().geometry()));
            last.position
        });
        apart_at_the_end = apart_at_the_end.max((ends[0] - one).norm());
    }
    assert!(apart_at_the_end > 1e-2, "it slides: {apart_at_the_end}");
}

/// What comes late or has let go is marked while it holds, and at the end only where it still does.
#[test]
fn what_comes_and_goes_is_marked_while_it_holds() {
    let fields = json!({ "seconds": 1, "scheme": "implicit", "mass": 0.1, "constraints": [
        { "kind": "fixed", "at": 0, "name": "nail" },
        { "kind": "fixed", "at": 7, "name": "late", "from": 0.5 },
        { "kind": "sliding", "near": 9, "name": "early", "until": 0.25 },
    ] });
    let (scene, marks) = simulated(vec![("rope", rope(3, 14))], fields);
    let held = |name: &str| {
        (0..=24).filter(|k| positions(&scene, &marks, name, *k)[0].is_some()).collect::<Vec<_>>()
    };
    assert_eq!(held("nail").len(), 25);
    assert!(held("late").last() == Some(&24) && (12..=13).contains(&held("late")[0]), "{:?}", held("late"));
    assert!(held("early")[0] <= 1 && (5..=6).contains(held("early").last().unwrap()), "{:?}", held("early"));
    let stays = |name: &str| marks.iter().find(|mark| mark.label == name).unwrap().stays();
    assert_eq!(["nail", "late", "early"].map(stays), [true, true, false]);
    assert!(marks.iter().find(|mark| mark.label == "nail").unwrap().track.is_none(), "it stays where it is");
}

//! Tubes that are matched to a closed edge with a corner, which may lie anywhere round: beside their own seam, or between their own knots.
#![allow(clippy::unwrap_used, clippy::panic, reason = "these are tests, their helpers included")]

use loftsman_kernel::Point;
use loftsman_kernel::plugin::{Context, NoClock, Operation, Parameters, Plugin, Quiet, Registry};
use loftsman_kernel::scene::{Object, Scene};
use loftsman_kernel::spline::{Space, Surface};
use loftsman_matching::{MatchOperation, MatchingPlugin};
use serde_json::json;

/// A tube along x, from `x` to `x + 1.8`, over this section.
fn tube(x: f64, around: Space, section: &[[f64; 2]], size: f64) -> Surface {
    let along = Space::clamped_uniform(3, 4).unwrap();
    let points = (0..4).flat_map(|i| {
        section.iter().map(move |[y, z]| Point::new(size * (x + 0.6 * f64::from(i)), size * y, size * z))
    });
    Surface::new(along, around, points.collect()).unwrap()
}

/// Turned about the middle.
fn turned(section: &[[f64; 2]], by: f64) -> Vec<[f64; 2]> {
    let (s, c) = by.sin_cos();
    section.iter().map(|[y, z]| [c * y - s * z, s * y + c * z]).collect()
}

/// A drop, clamped, which has its corner where it begins and ends, and is the same upside down.
fn drop(size: f64) -> Surface {
    let half = [[1.6, 0.0], [1.0, 0.7], [0.2, 1.0], [-0.8, 0.9]];
    let below = half.iter().rev().map(|[y, z]| [*y, -z]);
    let section: Vec<[f64; 2]> = half.iter().copied().chain([[-1.1, 0.0]]).chain(below).collect();
    tube(0.0, Space::clamped_uniform(3, 9).unwrap(), &section, size)
}

#[test]
fn the_corner_of_the_other_edge_is_met_wherever_it_lies() {
    let mut registry = Registry::new();
    MatchingPlugin.register(&mut registry);
    let context = Context { registry: &registry, observer: &Quiet, clock: &NoClock };
    let seam = [
        [0.9, 0.0],
        [0.9, 0.41],
        [0.36, 0.9],
        [-0.54, 0.9],
        [-0.95, 0.0],
        [-0.54, -0.9],
        [0.36, -0.9],
        [0.9, -0.41],
        [0.9, 0.0],
    ];
    let ring = [0.0_f64, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0].map(|k| {
        let (s, c) = (k * std::f64::consts::FRAC_PI_4).sin_cos();
        [0.9 * c, 0.9 * s]
    });
    let mut made = 0;
    for (turn, size) in
        [(0.0, 1.0), (0.3, 1e-9), (1.0, 1.0), (2.0, 1e9), (-2.0, 1.0), (std::f64::consts::PI, 1.0)]
    {
        for periodic in [false, true] {
            let a = if periodic {
                tube(-2.0, Space::periodic_uniform(3, 8).unwrap(), &turned(&ring, turn), size)
            } else {
                tube(-2.0, Space::clamped_uniform(3, 9).unwrap(), &turned(&seam, turn), size)
            };
            for continuity in 0..=2 {
                let case = format!("turned by {turn}, periodic {periodic}, continuity {continuity}");
                let mut scene = Scene::new();
                scene.add(Object::new("a", a.clone().into())).unwrap();
                scene.add(Object::new("b", drop(size).into())).unwrap();
                let fields = json!({ "object": "a", "edge": "u1", "with": { "object": "b", "edge": "u0" },
                    "continuity": continuity });
                let parameters = Parameters::new(fields, "step[0]").unwrap();
                let report = MatchOperation
                    .apply(&mut scene, &parameters, &context)
                    .unwrap_or_else(|e| panic!("{case}: {e}"));
                // Its knots are there, so that the edge is that curve.
                let after = &report.numbers["after"];
                assert!(after["position"].as_f64().unwrap() < 1e-9 * size, "{case}: {after}");
                assert!(
                    !report.notes.iter().any(|note| note.contains("a gap of")),
                    "{case}: {:?}",
                    report.notes
                );
                let found = scene.surface("a").unwrap();
                let ((a, b), (c, d)) = (found.u().domain(), found.v().domain());
                for k in 0..=20 {
                    let u = a + (b - a) * f64::from(k) / 20.0;
                    let [p, q] = [c, d].map(|v| found.point(u, v).unwrap());
                    assert!((p - q).norm() < 1e-9 * size, "{case}: {p} {q}");
                }
                made += 1;
            }
        }
    }
    assert_eq!(made, 36);
}

/// A drop that is the same neither upside down nor all along, so that its tangent planes on both sides of the corner meet in a line askew: both are met there.
#[test]
fn both_tangent_planes_at_a_corner_are_met() {
    let mut registry = Registry::new();
    MatchingPlugin.register(&mut registry);
    let context = Context { registry: &registry, observer: &Quiet, clock: &NoClock };
    let section = [
        [1.6, 0.0],
        [1.0, 0.9],
        [0.2, 1.1],
        [-0.8, 0.7],
        [-1.1, -0.1],
        [-0.8, -0.9],
        [0.1, -1.0],
        [1.2, -0.4],
        [1.6, 0.0],
    ];
    let (along, around, points, _) =
        tube(0.0, Space::clamped_uniform(3, 9).unwrap(), &section, 1.0).into_parts();
    let wider = |p: &Point| {
        let by = 1.0 + 0.3 * p.x;
        Point::new(p.x, by * p.y - 0.2 * p.x, by * p.z + 0.3 * p.x * p.x)
    };
    let drop = Surface::new(along, around, points.iter().map(wider).collect()).unwrap();
    let mut made = 0;
    for turn in [0.5_f64, 1.7, 2.9, 4.1] {
        let ring = [0.0_f64, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0].map(|k| {
            let (s, c) = (k * std::f64::consts::FRAC_PI_4 + turn).sin_cos();
            [0.9 * c, 0.8 * s]
        });
        for metric in ["bend", "least"] {
            let case = format!("turned by {turn}, {metric}");
            let mut scene = Scene::new();
            let a = tube(-2.0, Space::periodic_uniform(3, 8).unwrap(), &ring, 1.0);
            scene.add(Object::new("a", a.into())).unwrap();
            scene.add(Object::new("b", drop.clone().into())).unwrap();
            let fields = json!({ "object": "a", "edge": "u1", "with": { "object": "b", "edge": "u0" },
                    "continuity": 1, "metric": metric });
            let parameters = Parameters::new(fields, "step[0]").unwrap();
            let report = MatchOperation
                .apply(&mut scene, &parameters, &context)
                .unwrap_or_else(|e| panic!("{case}: {e}"));
            // The normals on either side of the corner are those of the other.
            let found = scene.surface("a").unwrap();
            let normal = |s: &Surface, u: f64, v: f64| {
                let d = |a: usize, b: usize| s.derivative(u, v, a, b).unwrap();
                d(1, 0).cross(&d(0, 1)).normalize()
            };
            let tip = Point::from(drop.derivative(0.0, 0.0, 0, 0).unwrap());
            let end = found.u().domain().1;
            let edge = found.isocurve(loftsman_kernel::spline::Direction::U, end).unwrap();
            let corner = edge.closest(tip).unwrap();
            assert!(corner.distance < 1e-9, "{case}: {}", corner.distance);
            let last = drop.v().domain().1;
            let mut other = [normal(&drop, 0.0, 1e-9), normal(&drop, 0.0, last - 1e-9)];
            let own = [corner.at + 1e-8, corner.at - 1e-8].map(|v| normal(found, end, v));
            // Whichever way it runs.
            if own[0].cross(&other[0]).norm() > own[0].cross(&other[1]).norm() {
                other.swap(0, 1);
            }
            for (own, other) in own.iter().zip(&other) {
                let sine = own.cross(other).norm();
                assert!(sine < 0.1_f64.to_radians(), "{case}: {sine} {:?}", report.notes);
            }
            made += 1;
        }
    }
    assert_eq!(made, 8);
}

/// Knots of a space over its domain from 0 to 1: how near the nearest two of them are, and the nearest one to the seam of what is not periodic.
fn nearest_knots(around: &Space) -> (f64, f64) {
    let (start, length) = (around.domain().0, around.length());
    let knots: Vec<f64> = around.breakpoints().iter().map(|knot| (knot - start) / length).collect();
    let least = knots.windows(2).map(|pair| pair[1] - pair[0]).fold(1.0, f64::min);
    let inner = &knots[1..knots.len() - 1];
    (least, inner.iter().map(|knot| knot.min(1.0 - knot)).fold(1.0, f64::min))
}

/// Round tubes of unlike counts and degrees, whose seams (sharp or smooth, or none) lie at the same angle or at all but the same: no knot comes to lie beside another
/// one, where nothing but that one is meant, and none is refused for it.
#[test]
fn seams_that_lie_beside_one_another_are_one() {
    let mut registry = Registry::new();
    MatchingPlugin.register(&mut registry);
    let context = Context { registry: &registry, observer: &Quiet, clock: &NoClock };
    let ring = |degree: usize, count: usize, kind: &str, turn: f64, size: f64| -> (Space, Vec<[f64; 2]>) {
        let space = match kind {
            "none" => Space::periodic_uniform(degree, count).unwrap(),
            _ => Space::clamped_uniform(degree, count).unwrap(),
        };
        let (start, length) = (space.domain().0, space.length());
        let shares: Vec<f64> =
            (0..count)
                .map(|i| {
                    if kind == "none" {
                        i as f64 / count as f64
                    } else {
                        (space.greville(i) - start) / length
                    }
                })
                .collect();
        let place = |share: &f64| {
            let (s, c) = (std::f64::consts::TAU * share).sin_cos();
            [size * c, 0.8 * size * s]
        };
        let mut points: Vec<[f64; 2]> = shares.iter().map(place).collect();
        if kind == "smooth" {
            // Upright where it begins and ends.
            (points[1][0], points[count - 2][0]) = (points[0][0], points[0][0]);
        }
        (space, turned(&points, turn))
    };
    let mut refused = Vec::new();
    let mut made = 0;
    for [p, n, q, m] in [[3, 8, 4, 10], [3, 10, 3, 8], [3, 9, 3, 9], [4, 8, 3, 8], [3, 12, 3, 24]] {
        for [own, there] in [
            ["sharp", "sharp"],
            ["smooth", "sharp"],
            ["sharp", "smooth"],
            ["none", "smooth"],
            ["none", "sharp"],
        ] {
            for (turn, continuity) in [(0.0, 0), (0.0, 1), (0.0, 2), (0.003, 1)] {
                let case =
                    format!("{own} {p} {n} to {there} {q} {m}, turned by {turn}, continuity {continuity}");
                let (around, section) = ring(p, n, own, turn, 0.9);
                let a = tube(-2.0, around, &section, 1.0);
                let (around, section) = ring(q, m, there, 0.0, 1.0);
                let mut scene = Scene::new();
                scene.add(Object::new("a", a.into())).unwrap();
                scene.add(Object::new("b", tube(0.0, around, &section, 1.0).into())).unwrap();
                let fields = json!({ "object": "a", "edge": "u1", "with": { "object": "b", "edge": "u0" },
                    "continuity": continuity });
                let parameters = Parameters::new(fields, "step[0]").unwrap();
                match MatchOperation.apply(&mut scene, &parameters, &context) {
                    Err(error) => refused.push(format!("{case}: {error}")),
                    Ok(report) => {
                        let around = scene.surface("a").unwrap().v().clone();
                        let (least, beside) = nearest_knots(&around);
                        assert!(least > 1e-4, "{case}: {least} {around:?}");
                        let seam = own != "none" || there == "sharp";
                        assert!(!seam || around.is_periodic() || beside > 2e-3, "{case}: {beside}");
                        let folds = report.notes.iter().any(|note| note.starts_with("it folds back"));
                        assert!(!folds, "{case}: {:?}", report.notes);
                        made += 1;
                    }
                }
            }
        }
    }
    assert!(refused.len() <= made / 20, "{made} made, {refused:#?}");
}

/// Seams with corners that lie a little beside one another meet: one corner, not two. And what has no edge says so.
#[test]
fn corners_of_both_meet_where_they_lie_near_one_another() {
    let mut registry = Registry::new();
    MatchingPlugin.register(&mut registry);
    let context = Context { registry: &registry, observer: &Quiet, clock: &NoClock };
    let ring = |space: &Space, radius: f64, turn: f64| -> Vec<[f64; 2]> {
        let ((a, b), n) = (space.domain(), space.len());
        let place = |i: usize| std::f64::consts::TAU * (space.greville(i) - a) / (b - a);
        let at = |i: usize| [radius * place(i).cos(), 0.8 * radius * place(i).sin()];
        turned(&(0..n).map(at).collect::<Vec<_>>(), turn)
    };
    let [own, other] = [(3, 8), (4, 10)].map(|(p, n)| Space::clamped_uniform(p, n).unwrap());
    for turn in [0.0, 1e-4, 0.01, 0.03, 0.08] {
        for continuity in 0..=2 {
            let mut scene = Scene::new();
            scene.add(Object::new("a", tube(-2.0, own.clone(), &ring(&own, 0.9, turn), 1.0).into())).unwrap();
            scene
                .add(Object::new("b", tube(0.0, other.clone(), &ring(&other, 1.0, 0.0), 1.0).into()))
                .unwrap();
            let fields = json!({ "object": "a", "edge": "u1", "with": { "object": "b", "edge": "u0" },
                "continuity": continuity });
            let parameters = Parameters::new(fields, "step[0]").unwrap();
            let report = MatchOperation.apply(&mut scene, &parameters, &context).unwrap();
            let corners = report.smooth.map_or(0, |smooth| smooth.corners.len());
            assert!(corners <= 1, "{turn} {continuity}: {corners}");
            let breaks = scene.surface("a").unwrap().v().breakpoints();
            let gap = breaks.windows(2).map(|w| w[1] - w[0]).fold(f64::INFINITY, f64::min);
            assert!(gap > 1e-2, "{turn} {continuity}: {breaks:?}");
        }
    }
    let torus = {
        let space = Space::periodic_uniform(3, 8).unwrap();
        let at = |i: usize| std::f64::consts::TAU * i as f64 / 8.0;
        let point = |k: usize| {
            let (u, v) = (at(k / 8), at(k % 8));
            Point::new((3.0 + v.cos()) * u.cos(), (3.0 + v.cos()) * u.sin(), v.sin())
        };
        Surface::new(space.clone(), space, (0..64).map(point).collect()).unwrap()
    };
    let mut scene = Scene::new();
    scene.add(Object::new("a", tube(-2.0, own.clone(), &ring(&own, 0.9, 0.0), 1.0).into())).unwrap();
    scene.add(Object::new("b", torus.into())).unwrap();
    let fields = json!({ "object": "a", "edge": "u1", "with": { "object": "b", "edge": "v0" } });
    let parameters = Parameters::new(fields, "step[0]").unwrap();
    let told = MatchOperation.apply(&mut scene, &parameters, &context).unwrap_err().to_string();
    assert!(told.contains("\"b\" is closed all round and has no edge"), "{told}");
}

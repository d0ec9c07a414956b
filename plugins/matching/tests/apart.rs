//! What is told of a match's position is the distance between the edges, however their parameters run: compared with closest points, both ways.
#![allow(clippy::unwrap_used, clippy::panic, reason = "these are tests, their helpers included")]

use loftsman_kernel::Point;
use loftsman_kernel::functional::{Edge, Shapes};
use loftsman_kernel::plugin::{Context, NoClock, Operation, Parameters, Plugin, Quiet, Registry};
use loftsman_kernel::scene::{Object, Scene};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::spline::{Curve, Direction, Space, Surface};
use loftsman_matching::{Limits, MatchOperation, MatchingPlugin, matching};
use serde_json::json;

/// Numbers from 0 to 1, the same each time.
fn numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(2654435761) + 1;
    move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A wavy sheet from `x` on, of this degree along its edge `u0`, with weights that make parameters run unevenly, or without.
fn sheet(seed: u64, x: f64, degree: usize, weighted: bool, size: f64) -> Surface {
    let mut next = numbers(seed);
    let (u, v) = (Space::clamped_uniform(3, 5).unwrap(), Space::clamped_uniform(degree, degree + 3).unwrap());
    let columns = v.len();
    let [f, g] = [6.0 * next(), 6.0 * next()];
    let at = |k: usize| {
        let (i, j) = ((k / columns) as f64, 2.0 * (k % columns) as f64 / (columns - 1) as f64 - 1.0);
        let wave = 0.2 * (2.0 * j + f).sin();
        Point::new(size * (x + 0.5 * i + 0.3 * wave), size * j, size * (wave + 0.1 * (i + g).cos()))
    };
    let weights = (0..5 * columns).map(|_| 0.5 + 1.5 * next()).collect();
    Surface::build(u, v, (0..5 * columns).map(at).collect(), weighted.then_some(weights)).unwrap()
}

/// The largest distance of either curve's places from the other curve.
fn hausdorff(a: &Curve, b: &Curve) -> f64 {
    const PLACES: u32 = 1000;
    let mut most = 0.0_f64;
    for [from, to] in [[a, b], [b, a]] {
        let (low, high) = from.domain();
        for k in 0..=PLACES {
            let at = from.point(low + (high - low) * f64::from(k) / f64::from(PLACES)).unwrap();
            most = most.max(to.closest(at).unwrap().distance);
        }
    }
    most
}

#[test]
fn the_position_that_is_told_is_the_distance_between_the_edges() {
    let mut registry = Registry::new();
    MatchingPlugin.register(&mut registry);
    let context = Context { registry: &registry, observer: &Quiet, clock: &NoClock };
    let (mut beside, mut vertices) = (0, 0);
    for seed in 0..12_u64 {
        let (degree, other) = ([2, 3, 5, 3][seed as usize % 4], [3, 4, 2, 7][seed as usize % 3]);
        let size = [1.0, 1e-9, 1e9][seed as usize % 3];
        let a = sheet(seed, 0.2, degree, seed % 2 == 0, size);
        let b = sheet(seed + 100, 0.0, other, true, size);
        let mut scene = Scene::new();
        scene.add(Object::new("a", a.into())).unwrap();
        scene.add(Object::new("b", b.clone().into())).unwrap();
        let continuity = seed % 2;
        let fields = json!({ "object": "a", "edge": "u0", "with": { "object": "b", "edge": "u0" },
            "continuity": continuity });
        // Sheets on the same side of their edges meet in position only.
        let fields = if continuity == 1 {
            json!({ "object": "a", "edge": "u0", "with": { "object": "b", "edge": "u1" }, "continuity": 1 })
        } else {
            fields
        };
        let parameters = Parameters::new(fields, "step[0]").unwrap();
        let report =
            MatchOperation.apply(&mut scene, &parameters, &context).unwrap_or_else(|e| panic!("{seed}: {e}"));
        let told = report.numbers["after"]["position"].as_f64().unwrap();
        let after = scene.surface("a").unwrap();
        vertices += after.v().len();
        let ends = [after.u().domain().0, if continuity == 1 { b.u().domain().1 } else { b.u().domain().0 }];
        let [own, there] =
            [(after, ends[0]), (&b, ends[1])].map(|(s, at)| s.isocurve(Direction::U, at).unwrap());
        let found = hausdorff(&own, &there);
        assert!((told - found).abs() <= 0.01 * found + 1e-12 * size, "{seed}: told {told}, found {found}");
        // By parameters it is more.
        let (c, d) = own.domain();
        let (e, f) = there.domain();
        let share = |k: usize| k as f64 / 1000.0;
        let even = (0..=1000)
            .map(|k| {
                (own.point(c + (d - c) * share(k)).unwrap() - there.point(e + (f - e) * share(k)).unwrap())
                    .norm()
            })
            .fold(0.0, f64::max);
        beside += usize::from(even > 1.5 * found);
    }
    eprintln!("{beside} of 12 run beside one another, {vertices} control vertices along edges");
    assert!(beside >= 4, "{beside}");
}

/// Along lines that lie on one another, parametrised otherwise, nothing is apart but what one is longer.
#[test]
fn edges_on_one_line_are_not_apart_but_where_one_goes_on() {
    let line = |to: f64, bend: f64| {
        let (u, v) = (Space::clamped_uniform(1, 2).unwrap(), Space::clamped_uniform(2, 3).unwrap());
        let at = |k: usize| Point::new((k / 3) as f64, [0.0, bend, to][k % 3], 0.0);
        Surface::new(u, v, (0..6).map(at).collect()).unwrap()
    };
    for (to, bend) in [(1.0, 0.2), (1.0, 0.9), (1.25, 0.5)] {
        let asked = matching(Edge::UStart, 1, Edge::UEnd, 1, Limits::default());
        let (own, other) = (line(1.0, 0.5), line(to, bend));
        let (u, v, points, _) = other.into_parts();
        let other =
            Surface::new(u, v, points.iter().map(|p| Point::new(p.x - 1.0, p.y, 0.0)).collect()).unwrap();
        let told = asked.deviation(&Shapes::new([&own as &dyn Shape, &other])).unwrap();
        assert!((told.distance - (to - 1.0)).abs() < 1e-9 && told.angle < 1e-9, "{to} {bend}: {told}");
    }
}

//! What rests and moves is stretched as its steps take it for: nothing hides between the points at which energy is summed up.

#![allow(clippy::unwrap_used, reason = "what makes the shapes of the tests cannot fail")]

use loftsman_dynamics::{Body, Dynamics, Scheme, Setup, Simulation, fixed};
use loftsman_kernel::Point;
use loftsman_kernel::plugin::{Context, Parameters, Registry, StepReport};
use loftsman_kernel::scene::{Geometry, Object, Scene, Unit};
use loftsman_kernel::spline::{Curve, Space, Surface};
use serde_json::json;

/// Bézier chains, kept smooth by their vertices or with corners, and curves of few spans; shaken.
fn ropes() -> Vec<(String, Curve)> {
    let mut all = Vec::new();
    for degree in 2..=7 {
        for spans in [1, 2, 4] {
            for chain in [false, true] {
                let knots = |at: usize| vec![at as f64; if chain { degree } else { 1 }];
                let inner = (1..spans).flat_map(knots);
                let ends = |at: f64| std::iter::repeat_n(at, degree + 1);
                let space = Space::open(degree, ends(0.0).chain(inner).chain(ends(spans as f64)).collect());
                let space = space.unwrap();
                let n = space.len();
                let shaken = |k: usize| (k as f64 * 1.7 + degree as f64).sin() * 0.05;
                let at = |i: usize| 2.0 * space.greville(i) / spans as f64;
                let point = |i: usize| Point::new(at(i), shaken(i), shaken(3 * i + 1) - 0.3 * at(i));
                let points = (0..n).map(point).collect();
                all.push((
                    format!("degree {degree}, {spans} spans, chain {chain}"),
                    Curve::new(space, points).unwrap(),
                ));
            }
        }
    }
    all
}

fn setup(rope: &Curve) -> Setup {
    let body = Body::new(rope).mass(1.0).stiffness(100.0).rest(0.7).damping(3.0);
    Setup::new(body).hold(fixed(0.0)).keep_seams()
}

fn whole(simulation: &mut Simulation) -> f64 {
    simulation.energy().total() + simulation.unseen_energy().unwrap()
}

/// Held at one end and shorter by nature, without weight: it rests where it is stretched nowhere, whatever its degree and knots.
#[test]
fn what_is_free_rests_as_long_as_it_is_by_nature() {
    for (what, rope) in ropes() {
        let mut simulation = setup(&rope).prepare().unwrap();
        let settled = simulation.settle().unwrap();
        let stretch = simulation.largest_stretch(0).unwrap();
        assert!(settled.rests && stretch.abs() < 0.01, "{what}: {stretch} {settled:?}");
        let (seen, more) = (simulation.energy().elastic, simulation.unseen_energy().unwrap());
        assert!(seen + more < 1e-4, "{what}: {seen} and {more}");
    }
}

/// The same in motion, which the air ends: what there is of energy at the end, folds within spans counted, is no thousandth of what there was at the start.
#[test]
fn what_comes_to_rest_in_motion_hides_no_folds() {
    for (what, rope) in ropes() {
        for scheme in [Scheme::Epsilon, Scheme::Implicit] {
            let mut simulation = setup(&rope).scheme(scheme).step(1.0 / 48.0).prepare().unwrap();
            let before = whole(&mut simulation);
            (0..96).for_each(|_| simulation.advance(1.0 / 24.0).unwrap());
            let after = whole(&mut simulation);
            let slow = 5e-3 * before;
            assert!(after < slow, "{what}, {scheme:?}: {before} at the start, {after} at the end");
            let (seen, more) = (simulation.energy().elastic, simulation.unseen_energy().unwrap());
            assert!(more.abs() < 0.2 * seen + 1e-4 * before, "{what}, {scheme:?}: {seen} and {more}");
        }
    }
}

/// Patches of Bézier form, and sheets of few cells, in motion.
#[test]
fn sheets_hide_no_folds() {
    for (degree, spans, chain) in
        [(2, 1, true), (3, 1, true), (3, 2, true), (2, 2, false), (3, 3, false), (5, 1, true)]
    {
        let inner = (1..spans).flat_map(|at| vec![f64::from(at); if chain { degree } else { 1 }]);
        let ends = |at: f64| std::iter::repeat_n(at, degree + 1);
        let space =
            Space::open(degree, ends(0.0).chain(inner).chain(ends(f64::from(spans))).collect()).unwrap();
        let n = space.len();
        let at = |i: usize| 2.0 * space.greville(i) / f64::from(spans);
        let shaken = |k: usize| (k as f64 * 1.7 + degree as f64).sin() * 0.1;
        let points = (0..n * n).map(|k| Point::new(at(k / n), at(k % n), shaken(k))).collect();
        let sheet = Surface::new(space.clone(), space.clone(), points).unwrap();
        let body = Body::new(&sheet).mass(1.0).stiffness(100.0).rest(0.7).damping(3.0);
        let mut simulation = Setup::new(body).hold(fixed([0.0, 0.0])).prepare().unwrap();
        let before = whole(&mut simulation);
        (0..72).for_each(|_| simulation.advance(1.0 / 24.0).unwrap());
        let after = whole(&mut simulation);
        let what = format!("degree {degree}, {spans} spans, {chain}");
        assert!(after < 0.01 * before, "{what}: {before} at the start, {after} at the end");
        let (seen, more) = (simulation.energy().elastic, simulation.unseen_energy().unwrap());
        assert!(more.abs() < 0.05 * seen + 1e-6 * before, "{what}: {seen} and {more}");
    }
}

fn told(rope: &Curve) -> StepReport {
    let mut scene = Scene::new();
    scene.unit = Unit::Metre;
    scene.add(Object::new("rope", Geometry::Curve(rope.clone()))).unwrap();
    let mut registry = Registry::new();
    registry.add(&Dynamics);
    let operation = registry.find_operation("simulate", "step[0]").unwrap();
    let fields = json!({
        "seconds": 4, "stiffness": 100, "rest": 0.7, "damping": 3, "gravity": [0, 0, 0], "settle": true,
        "constraints": [{ "kind": "fixed", "at": 0 }],
    });
    operation
        .apply(&mut scene, &Parameters::new(fields, "step[0]").unwrap(), &Context::quiet(&registry))
        .unwrap()
}

/// A rope of degree 2 and many spans crumples as it shrinks, for nothing that steps see: that is a warning, with both energies as numbers; and what the warning says helps.
#[test]
fn what_steps_do_not_see_is_warned_of() {
    for spans in [6, 12] {
        let space = Space::clamped_uniform(2, spans + 2).unwrap();
        let at = |i: usize| 2.0 * space.greville(i) / spans as f64;
        let shaken = |k: usize| (k as f64 * 2.9).sin() * 0.1;
        let points = (0..spans + 2).map(|i| Point::new(at(i), shaken(i), shaken(3 * i + 1))).collect();
        let rope = Curve::new(space.clone(), points).unwrap();
        for (rope, warned) in [(rope.clone(), true), (rope.elevate(1).unwrap(), false)] {
            let report = told(&rope);
            let [seen, all] =
                ["elastic", "elastic_in_all"].map(|name| report.numbers[name].as_f64().unwrap());
            assert_eq!(all > 1e-3, warned, "{spans}: {seen} of {all}");
            let said = report
                .warnings
                .iter()
                .any(|w| w.contains("steps take the elastic energy") && w.contains("elevate"));
            assert_eq!(said, warned, "{spans}: {:?}", report.warnings);
        }
    }
}

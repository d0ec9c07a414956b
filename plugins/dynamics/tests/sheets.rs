//! What sheets are made of: closed forms of what they pull with, and that they agree with ropes.

#![allow(clippy::unwrap_used, reason = "what makes the shapes of the tests cannot fail")]

use loftsman_dynamics::{Body, Setup, fixed};
use loftsman_kernel::Point;
use loftsman_kernel::shape::Location;
use loftsman_kernel::spline::{Curve, Space, Surface};

const STIFFNESS: f64 = 30.0;
const RESTS: [f64; 3] = [0.5, 1.0, 2.0];

/// A flat strip of some degrees, along x.
fn strip(degrees: [usize; 2], length: f64, width: f64) -> Surface {
    let [u, v] = degrees.map(|degree| Space::clamped_uniform(degree, degree + 3).unwrap());
    let share = |space: &Space, k: usize| space.greville(k) / space.domain().1;
    let points = (0..u.len() * v.len()).map(|k| {
        let (i, j) = (k / v.len(), k % v.len());
        Point::new(length * share(&u, i), width * share(&v, j), 0.0)
    });
    Surface::new(u.clone(), v.clone(), points.collect()).unwrap()
}

/// A strip that is pulled to a length, free to shrink across: `k b ε` for its width `b` at rest, as the rope of that stiffness.
#[test]
fn a_strip_pulls_as_the_rope_of_its_stiffness() {
    let (length, pulled) = (3.0, 7.0);
    for rest in RESTS {
        for width in [0.4, 0.8] {
            let wanted = STIFFNESS * (width * rest) * (pulled / (rest * length) - 1.0);
            for degrees in [[1, 1], [3, 1], [2, 3]] {
                let sheet = strip(degrees, length, width);
                let [u, v] = [sheet.u().domain().1, sheet.v().domain().1];
                let mut setup = Setup::new(Body::new(&sheet).stiffness(STIFFNESS).rest(rest))
                    .hold(fixed([0.0, 0.5 * v]).axes([false, true, true]))
                    .hold(fixed([u, 0.5 * v]).axes([false, true, true]));
                // All of both ends, at as many places as they have vertices.
                for j in 0..sheet.v().len() {
                    let at = |u: f64| Location::from([u, sheet.v().greville(j)]);
                    let axes = |z: bool| [true, false, z];
                    let middle = 2 * j + 1 == sheet.v().len();
                    setup = setup
                        .hold(fixed(at(0.0)).axes(axes(!middle)))
                        .hold(fixed(at(u)).to([pulled, 0.0, 0.0]).axes(axes(!middle)));
                }
                let mut simulation = setup.prepare().unwrap();
                let settled = simulation.settle().unwrap();
                assert!(settled.rests, "{rest} {degrees:?}: {settled:?}");
                let force: f64 = (0..simulation.constraints())
                    .filter(|k| k % 2 == 1 && *k > 1)
                    .map(|k| simulation.force_of(k).unwrap()[0])
                    .sum();
                let what = format!("{rest} {width} {degrees:?}: {force} for {wanted}");
                assert!((force - wanted).abs() < 1e-7 * STIFFNESS, "{what}");
                assert!(
                    (simulation.largest_stretch(0).unwrap() - (pulled / (rest * length) - 1.0)).abs() < 1e-7,
                    "{what}"
                );
            }
            let space = Space::clamped_uniform(3, 6).unwrap();
            let end = space.domain().1;
            let points = (0..6).map(|i| Point::new(length * space.greville(i) / end, 0.0, 0.0)).collect();
            let rope = Curve::new(space, points).unwrap();
            let mut simulation = Setup::new(Body::new(&rope).stiffness(STIFFNESS * width * rest).rest(rest))
                .hold(fixed(0.0))
                .hold(fixed(end).to([pulled, 0.0, 0.0]))
                .prepare()
                .unwrap();
            assert!(simulation.settle().unwrap().rests);
            let force = simulation.force_of(1).unwrap()[0];
            assert!((force - wanted).abs() < 1e-7 * STIFFNESS, "{rest} {width}: {force} for {wanted}");
        }
    }
}

/// Flat and stretched by `1/r - 1` in both directions, at the start: `k (1/r - 1)² r² A`, whole or cut to strips.
#[test]
fn what_rests_smaller_has_the_energy_of_its_area_at_rest() {
    for rest in RESTS {
        let energy = |width: f64| {
            let sheet = strip([3, 2], 2.0, width);
            let body = Body::new(&sheet).stiffness(STIFFNESS).rest(rest);
            Setup::new(body).prepare().unwrap().energy().elastic
        };
        let (whole, parts) = (energy(1.5), energy(0.4) + energy(1.1));
        let wanted = STIFFNESS * (1.0 / rest - 1.0).powi(2) * (rest * rest * 3.0);
        assert!((whole - wanted).abs() < 1e-12 * STIFFNESS, "{rest}: {whole} for {wanted}");
        assert!((parts - wanted).abs() < 1e-12 * STIFFNESS, "{rest}: {parts} for {wanted}");
    }
}

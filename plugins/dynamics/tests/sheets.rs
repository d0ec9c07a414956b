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

/// What hangs at its corners pulls at them with its mass times its area, however much it turns within its cells: extrusions by 0.8 of curves whose length is that of 200,000 chords.
#[test]
fn a_curved_sheet_weighs_its_area() {
    let points = |n: usize| -> Vec<Point> {
        let at = |i: usize| {
            let i = i as f64;
            Point::new((5.3 * i).sin(), 0.0, 0.4 * (3.7 * i).cos())
        };
        (0..n).map(at).collect()
    };
    let weights = |n: usize| -> Vec<f64> { (0..n).map(|i| 1.0 + 0.7 * (2.3 * i as f64).sin()).collect() };
    for (degree, n, rational) in [
        (2, 3, false),
        (2, 3, true),
        (3, 4, false),
        (3, 7, false),
        (3, 7, true),
        (4, 5, false),
        (7, 8, false),
    ] {
        for across in [1, 2, 4] {
            let (along, side) =
                (Space::clamped_uniform(degree, n).unwrap(), Space::clamped_uniform(across, across + 1));
            let side = side.unwrap();
            let wide = |p: &Point| -> Vec<Point> {
                let at = |j: usize| p + loftsman_kernel::Vector::y() * (0.8 * j as f64 / across as f64);
                (0..=across).map(at).collect()
            };
            let net: Vec<Point> = points(n).iter().flat_map(wide).collect();
            let (curve, sheet) = if rational {
                let all = weights(n).into_iter().flat_map(|w| std::iter::repeat_n(w, across + 1)).collect();
                (
                    Curve::rational(along.clone(), points(n), weights(n)).unwrap(),
                    Surface::rational(along.clone(), side, net, all).unwrap(),
                )
            } else {
                (
                    Curve::new(along.clone(), points(n)).unwrap(),
                    Surface::new(along.clone(), side, net).unwrap(),
                )
            };
            let ([_, end], parts) = ([along.domain().0, along.domain().1], 200_000);
            let at = |i: usize| curve.point(end * i as f64 / f64::from(parts)).unwrap();
            let length: f64 = (0..parts as usize).map(|i| (at(i + 1) - at(i)).norm()).sum();
            let corners = [[0.0, 0.0], [0.0, 1.0], [end, 0.0], [end, 1.0]];
            let top = sheet.v().domain().1;
            let mut setup =
                Setup::new(Body::new(&sheet).mass(0.3).stiffness(1000.0)).gravity([0.0, 0.0, -9.81]);
            for [u, v] in corners {
                setup = setup.hold(fixed([u, v * top]));
            }
            let mut simulation = setup.prepare().unwrap();
            assert!(simulation.settle().unwrap().rests, "{degree} {n} {rational} {across}");
            let weight: f64 = (0..4).map(|k| simulation.force_of(k).unwrap()[2]).sum();
            let off = weight / (0.3 * 9.81 * 0.8 * length) - 1.0;
            assert!(off.abs() < 1e-8, "{degree} {n} {rational} {across}: {weight} of {length}, {off}");
        }
    }
}

//! Curvatures that are asked while α scales: of curves in space and in planes, at any place, as wanted to 1e-9.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests may fail the test")]

use loftsman_fine_tuning::{FineTune, FineTuneError, alpha_of, alpha_space};
use loftsman_kernel::edit::{Ask, Axis, Constraint};
use loftsman_kernel::functional::{curvature, position};
use loftsman_kernel::spline::algebra::Function;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

/// Numbers in [0, 1), always the same.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// An ellipse with noise, in a plane or in space, open (with some knots repeated) or periodic.
fn some(degree: usize, plane: bool, periodic: bool, repeat: usize, random: &mut Random) -> Curve {
    let space = if periodic {
        let mut knots = vec![0.0];
        (0..16).for_each(|k| knots.push(knots[k] + 0.5 + random.next()));
        Space::periodic(degree, knots).unwrap()
    } else {
        let mut knots = vec![0.0; degree + 1];
        for k in 1..10 {
            let times = if k == 5 { repeat } else { 1 };
            knots.extend(std::iter::repeat_n(f64::from(k), times));
        }
        knots.extend(vec![10.0; degree + 1]);
        Space::open(degree, knots).unwrap()
    };
    let n = space.len();
    let points = (0..n)
        .map(|i| {
            let turn = if periodic { 1.0 } else { 0.7 };
            let (sin, cos) = (std::f64::consts::TAU * turn * i as f64 / n as f64).sin_cos();
            let (r, z) = (0.95 + 0.1 * random.next(), random.next());
            Point::new(3.0 * r * cos, 2.0 * r * sin, if plane { 0.0 } else { 0.5 * z + (1.5 * sin) * cos })
        })
        .collect();
    Curve::new(space, points).unwrap()
}

/// α over a part, with more values than ends and places ask for.
fn alpha_on((a, b): (f64, f64), random: &mut Random) -> Function<f64> {
    let at = |i: usize| if i == 18 { b } else { a + (b - a) * i as f64 / 18.0 };
    let space = Space::clamped(2, &(0..=18).map(at).collect::<Vec<_>>()).unwrap();
    let values = (0..space.len()).map(|_| 0.9 + 0.2 * random.next()).collect();
    Function::new(space, values).unwrap()
}

/// `C'` and `C''`, behind a place or before it.
fn jet(curve: &Curve, u: f64, before: bool) -> [Vector; 2] {
    let own = if before { curve.between(curve.domain().0, u).unwrap() } else { curve.clone() };
    [own.derivative(u, 1).unwrap(), own.derivative(u, 2).unwrap()]
}

fn bent(curve: &Curve, u: f64, before: bool) -> f64 {
    let [first, second] = jet(curve, u, before);
    first.cross(&second).norm() / first.norm().powi(3)
}

/// What is asked, and the curvature that it makes of another.
fn wish(kind: u64, u: f64, own: f64) -> (Constraint, f64) {
    match kind {
        0 => (curvature(u).scale(1.6), 1.6),
        1 => (curvature(u).keep(), 1.0),
        2 => (curvature(u).to([1.3 * own, 0.0]), 1.3),
        3 => (curvature(u).by(vec![-0.2 * own]), 0.8),
        _ => (curvature(u).scale(0.7), 0.7),
    }
}

/// Curves of degree 2 to 7, in planes and in space, whole, closed and in part, at any place and at knots: the curvature is as wanted,
/// the place and the ends stay, and α is the one that is asked for its value there itself.
#[test]
fn a_curvature_is_what_is_asked() {
    let (mut done, mut refused) = (0, Vec::new());
    for case in 0..180_u64 {
        let random = &mut Random(case + 77);
        (0..9).for_each(|_| {
            random.next();
        });
        let (degree, plane) = (2 + (case % 6) as usize, case % 7 < 3);
        let (periodic, is_part) = (case % 3 == 0, case % 4 == 1);
        let repeat = 1 + (case as usize / 6) % (degree - 1);
        let curve = some(degree, plane, periodic, repeat, random);
        let (a, b) = curve.domain();
        let range = if is_part { (a + 0.1 * (b - a), b - 0.15 * (b - a)) } else { (a, b) };
        let alpha = if periodic && !is_part {
            let count = alpha_space(&curve).unwrap().len();
            alpha_of(&curve, (0..count).map(|_| 0.9 + 0.2 * random.next()).collect()).unwrap()
        } else {
            alpha_on(range, random)
        };
        // At a repeated knot, where the curvature jumps, it can be scaled and kept, and not be one number on both sides.
        let at_knot = !periodic && case % 5 == 2;
        let u = if at_knot { 5.0 } else { a + (b - a) * (0.3 + 0.35 * random.next()) };
        let own = bent(&curve, u, false);
        let kind = if at_knot { [0, 1, 4][(case / 5 % 3) as usize] } else { case / 2 % 5 };
        let (asked, times) = wish(kind, u, own);
        let tune = || {
            let tune = FineTune::new(&curve, alpha.clone());
            if is_part { tune.between(range.0, range.1) } else { tune }
        };
        let context =
            format!("{case}: degree {degree}, plane {plane}, periodic {periodic}, part {is_part}, {u}");
        let tuned = match tune().ask(asked).solve() {
            Err(error @ FineTuneError::NoPositive { .. }) => {
                refused.push(format!("{context}: {error}"));
                continue;
            }
            other => other.unwrap_or_else(|e| panic!("{context}: {e}")),
        };
        done += 1;
        for before in if at_knot { vec![false, true] } else { vec![false] } {
            let (was, is) = (bent(&curve, u, before), bent(tuned.curve(), u, before));
            assert!(
                (is / (was * times) - 1.0).abs() < 1e-9,
                "{context}: {is} of {was} times {times}, before: {before}"
            );
        }
        for t in [u, a, b, range.0, range.1] {
            let off = (tuned.curve().point(t).unwrap() - curve.point(t).unwrap()).norm();
            assert!(off < 1e-11, "{context}: {off:e} at {t}");
        }
        let value = position(u).on(1).axis(Axis::X).to(1.0 / times);
        let itself = tune().ask(position(u).keep()).ask(value).solve().unwrap();
        let (ours, theirs) = (tuned.report().change, itself.report().change);
        assert!((ours - theirs).abs() <= 1e-9 * theirs.max(1e-3), "{context}: {ours} {theirs}");
    }
    println!("{done} done, refused: {refused:#?}");
    assert!(done >= 165, "{done} {refused:#?}");
}

fn arc() -> (Curve, Function<f64>) {
    let random = &mut Random(3);
    let curve = some(3, false, false, 2, random);
    (curve.clone(), alpha_on(curve.domain(), random))
}

/// What a curvature cannot become by fine tuning is said.
#[test]
fn what_no_alpha_does_is_said() {
    let (curve, alpha) = arc();
    let own = bent(&curve, 3.3, false);
    let tune = |asked: Constraint| FineTune::new(&curve, alpha.clone()).ask(asked);
    let says = |asked: Constraint, what: &str| {
        let error = tune(asked).solve().unwrap_err().to_string();
        assert!(error.contains(what) && error.contains("curvature at"), "{what}: {error}");
    };
    says(curvature(3.3).to([0.0, 0.0]), "never 0");
    says(curvature(3.3).scale(-1.0), "turn to the other side");
    says(curvature(3.3).to([-own, 0.0]), "turn to the other side");
    says(curvature(3.3).to([own, own]), "leaves the plane");
    says(curvature(3.3).to([own, 0.0, own]), "3 numbers");
    says(curvature(3.3).scale(f64::NAN), "not a factor");
    says(curvature(5.0).to([own, 0.0]), "jumps there");
    says(curvature(3.3).at_most(-1.0), "turn to the other side");
    let part = |asked: Constraint| {
        let random = &mut Random(4);
        FineTune::new(&curve, alpha_on((4.0, 9.0), random)).between(4.0, 9.0).ask(asked).solve()
    };
    let error = part(curvature(3.3).scale(2.0)).unwrap_err().to_string();
    assert!(error.contains("outside of the range"), "{error}");
    part(curvature(3.3).keep()).unwrap();
    part(curvature(4.0).keep()).unwrap();
    // With any sign the curve turns to the other side, its tangent turned round.
    let turned = tune(curvature(3.3).scale(-1.0)).any_sign().solve().unwrap();
    let [[was, w2], [is, i2]] = [jet(&curve, 3.3, false), jet(turned.curve(), 3.3, false)];
    assert!((was + is).norm() < 1e-9 * was.norm());
    let binormals = [was.cross(&w2) / was.norm().powi(3), is.cross(&i2) / is.norm().powi(3)];
    assert!((binormals[0] - binormals[1]).norm() < 1e-9 * own, "{binormals:?}");
}

/// A bound of the curvature is one of α: more is α at most.
#[test]
fn curvatures_have_bounds() {
    let (curve, alpha) = arc();
    let own = bent(&curve, 3.3, false);
    let tune = || FineTune::new(&curve, alpha.clone());
    let more = tune().ask(curvature(3.3).at_least(1.5 * own)).solve().unwrap();
    assert!((bent(more.curve(), 3.3, false) / own - 1.5).abs() < 1e-9);
    let less = tune().ask(curvature(3.3).at_most(0.5 * own)).solve().unwrap();
    assert!((bent(less.curve(), 3.3, false) / own - 0.5).abs() < 1e-9);
    let free = tune().ask(curvature(3.3).at_least(0.1 * own)).solve().unwrap();
    assert!(bent(free.curve(), 3.3, false) > 0.5 * own);
}

/// Where the curve is straight it stays so.
#[test]
fn a_straight_place_stays_straight() {
    let points =
        (0..12).map(f64::from).map(|x| Point::new(x, if x > 6.0 { (x - 6.0).powi(2) } else { 0.0 }, 0.0));
    let curve = Curve::new(Space::clamped_uniform(3, 12).unwrap(), points.collect()).unwrap();
    let alpha = alpha_on(curve.domain(), &mut Random(5));
    let tune = |asked: Constraint| FineTune::new(&curve, alpha.clone()).ask(asked).solve();
    for asked in [curvature(1.5).keep(), curvature(1.5).scale(3.0), curvature(1.5).to([0.0, 0.0])] {
        let tuned = tune(asked).unwrap();
        assert!((tuned.curve().point(1.5).unwrap() - curve.point(1.5).unwrap()).norm() < 1e-12);
    }
    let error = tune(curvature(1.5).to([1.0, 0.0])).unwrap_err().to_string();
    assert!(error.contains("straight there and stays so"), "{error}");
}

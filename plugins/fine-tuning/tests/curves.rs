//! Fine tuning of curves: against the golden samples, the identities of the paper, and what is refused.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail the test")]

use loftsman_fine_tuning::{Ends, FineTune, FineTuneError, alpha_of, alpha_space};
use loftsman_kernel::edit::Ask;
use loftsman_kernel::functional::position;
use loftsman_kernel::spline::algebra::Function;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};
use nalgebra::Rotation3;
use serde_json::Value;

/// Numbers of a fixed sequence, in [0, 1).
pub(crate) struct Lcg(pub(crate) u64);

impl Lcg {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.next() * n as f64) as usize
    }
}

/// A curve of degree 1 to 7 and 13: clamped, floating or periodic, knots graded and repeated up to corners, plane or not, of any size.
pub(crate) fn any_curve(seed: u64) -> Curve {
    let mut random = Lcg(seed);
    (0..9).for_each(|_| {
        random.next();
    });
    let degree = if seed.is_multiple_of(23) { 13 } else { 1 + random.below(7) };
    let kind = random.below(3);
    let mut knots = Vec::new();
    let mut at = 0.0;
    for _ in 0..3 + random.below(8) {
        at += if random.below(5) == 0 { 0.02 } else { 0.3 + random.next() };
        // A corner now and then.
        let times = if random.below(3) == 0 { 1 + random.below(degree) } else { 1 };
        knots.extend(std::iter::repeat_n(at, times));
    }
    let end = at + 0.7;
    let space = match kind {
        0 => {
            let mut all = vec![0.0; degree + 1];
            all.extend(knots);
            all.extend(vec![end; degree + 1]);
            Space::open(degree, all).unwrap()
        }
        1 => {
            let mut all: Vec<f64> = (0..=degree).map(|i| -0.4 * (degree - i) as f64).collect();
            all.extend(knots);
            all.extend((0..=degree).map(|i| end + 0.3 * i as f64));
            Space::open(degree, all).unwrap()
        }
        _ => {
            let mut all = vec![0.0];
            all.extend(knots);
            all.push(end);
            while all.len() < degree + 3 {
                let last = all.pop().unwrap();
                all.extend([last, last + 0.5]);
            }
            Space::periodic(degree, all).unwrap()
        }
    };
    let size = [1.0, 1e-9, 1e9][random.below(3)];
    let flat = random.below(2) == 0;
    let n = space.len();
    let point = |i: usize, random: &mut Lcg| {
        let a = i as f64 / n as f64 * std::f64::consts::TAU;
        let wobble = 0.6 + 0.8 * random.next();
        let z = if flat { 0.0 } else { random.next() };
        Point::new(size * 3.0 * wobble * a.cos(), size * 2.0 * wobble * a.sin(), size * z)
    };
    let points = (0..n).map(|i| point(i, &mut random)).collect();
    Curve::new(space, points).unwrap()
}

/// α that is positive and no pattern.
pub(crate) fn any_alpha(curve: &Curve, seed: u64) -> Function<f64> {
    let mut random = Lcg(seed.wrapping_add(77));
    let n = alpha_space(curve).unwrap().len();
    alpha_of(curve, (0..n).map(|_| 0.4 + 1.4 * random.next()).collect()).unwrap()
}

pub(crate) fn size(curve: &Curve) -> f64 {
    curve.points().iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()))
}

/// Places inside the spans of a curve.
pub(crate) fn places(curve: &Curve) -> Vec<f64> {
    let breakpoints = curve.space().breakpoints();
    breakpoints.windows(2).flat_map(|w| [0.11, 0.5, 0.87].map(|s| w[0] + s * (w[1] - w[0]))).collect()
}

fn curvature(curve: &Curve, u: f64) -> f64 {
    let (first, second) = (curve.derivative(u, 1).unwrap(), curve.derivative(u, 2).unwrap());
    first.cross(&second).norm() / first.norm().powi(3)
}

/// `D' = αC'` and `κ_D = κ/(α · scale)` everywhere, in a frame turned by nothing.
fn assert_scaled(given: &Curve, tuned: &Curve, alpha: &Function<f64>, case: u64) {
    for u in places(given) {
        let (own, a) = (given.derivative(u, 1).unwrap(), alpha.value(u).unwrap());
        let largest =
            places(given).iter().fold(0.0_f64, |m, u| m.max(given.derivative(*u, 1).unwrap().norm()));
        let found = tuned.derivative(u, 1).unwrap();
        assert!(
            (found - own * a).norm() < 1e-10 * largest * a.abs().max(1.0),
            "{case}: D' at {u}: {found} {}",
            own * a
        );
        let (before, after) = (curvature(given, u), curvature(tuned, u));
        // What rounding of the first and second derivatives, of the size of the largest, takes from `|D' × D''| / |D'|³`: much where the
        // curve nearly stops, there is no other reason for a curvature to be off.
        if given.degree() > 1 && own.norm() > 1e-2 * largest && a > 0.05 {
            let most = |curve: &Curve, order: usize| {
                places(given).iter().fold(0.0_f64, |m, u| m.max(curve.derivative(*u, order).unwrap().norm()))
            };
            let slow = found.norm();
            let rounding = (most(tuned, 2) / slow + after * most(tuned, 1)) / slow
                + (most(given, 2) / own.norm() + before * largest) / (own.norm() * a);
            assert!(
                (after - before / a).abs() < (1e-10 * rounding).min(1e-8 * (before / a + 1.0 / size(given))),
                "{case}: κ at {u}: {after} {}",
                before / a
            );
        }
    }
}

#[test]
fn golden_samples() {
    let all: Value = serde_json::from_str(include_str!("golden/fine-tune.json")).unwrap();
    let numbers = |v: &Value| v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect::<Vec<_>>();
    let cases = all["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 6);
    for case in cases {
        let given = &case["curve"];
        let points =
            given["points"].as_array().unwrap().iter().map(|p| Point::from(Vector::from_vec(numbers(p))));
        let degree = given["degree"].as_u64().unwrap() as usize;
        let curve =
            Curve::new(Space::open(degree, numbers(&given["knots"])).unwrap(), points.collect()).unwrap();
        let alpha = alpha_of(&curve, numbers(&case["alpha"])).unwrap();
        let tuned = FineTune::new(&curve, alpha).ends(Ends::Free).solve().unwrap().into_curve();
        assert_eq!(tuned.degree() as u64, case["degree"].as_u64().unwrap());
        for sample in case["samples"].as_array().unwrap() {
            let t = sample["t"].as_f64().unwrap();
            let expected = Vector::from_vec(numbers(&sample["point"]));
            assert!((tuned.point(t).unwrap().coords - expected).norm() < 1e-13 * size(&curve));
            let expected = Vector::from_vec(numbers(&sample["derivative"]));
            assert!((tuned.derivative(t, 1).unwrap() - expected).norm() < 1e-12 * expected.norm());
        }
    }
}

/// Theory §5: the control vertices of a tuned quadratic, span by span, and its knots h, 0, h, 0, ….
#[test]
fn a_quadratic_becomes_the_cubic_of_the_closed_form() {
    let h = 0.8;
    let knots = vec![0.0, 0.0, 0.0, h, 2.0 * h, 3.0 * h, 3.0 * h, 3.0 * h];
    let points =
        [[0.0, 0.0], [1.0, 2.0], [3.0, 1.5], [4.0, 0.0], [6.0, 1.0]].map(|[x, y]| Point::new(x, y, 0.0));
    let curve = Curve::new(Space::open(2, knots).unwrap(), points.to_vec()).unwrap();
    let alpha = alpha_of(&curve, vec![0.5, 1.5, 2.0, 0.8]).unwrap();
    let tuned = FineTune::new(&curve, alpha.clone()).ends(Ends::Free).solve().unwrap().into_curve();
    let expected = [0.0, 0.0, 0.0, 0.0, h, h, 2.0 * h, 2.0 * h, 3.0 * h, 3.0 * h, 3.0 * h, 3.0 * h];
    assert_eq!(tuned.space().knots(), expected);
    // In Bézier form each span is the closed form.
    let segments = tuned.bezier_segments().unwrap();
    for (i, segment) in segments.iter().enumerate() {
        let (u0, u1) = (h * i as f64, h * (i + 1) as f64);
        let slope = |u: f64, left: bool| {
            let inside = if left { u - 1e-9 } else { u };
            curve.derivative(inside, 1).unwrap()
        };
        let (a, b) = (slope(u0, false), slope(u1, i + 1 < segments.len()));
        let (p, q) = (alpha.value(u0).unwrap(), alpha.value(u1).unwrap());
        let d = segment.points();
        let steps = [a * (h / 3.0 * p), (b * p + a * q) * (h / 6.0), b * (h / 3.0 * q)];
        for (pair, step) in d.windows(2).zip(steps) {
            assert!((pair[1] - pair[0] - step).norm() < 1e-8, "{i}");
        }
    }
}

#[test]
fn derivatives_are_scaled_and_curvatures_divided() {
    for case in 0..400 {
        let curve = any_curve(case);
        let alpha = any_alpha(&curve, case);
        let tuned = FineTune::new(&curve, alpha.clone()).ends(Ends::Free).solve().unwrap();
        assert_eq!(tuned.curve().degree(), 2 * curve.degree() - 1, "{case}");
        assert_scaled(&curve, tuned.curve(), &alpha, case);
        let (a, _) = curve.domain();
        assert!((tuned.curve().point(a).unwrap() - curve.point(a).unwrap()).norm() <= 1e-14 * size(&curve));
    }
}

/// α ≡ 1 is the same curve, α ≡ c scales it about its start, and to turn and to move commutes with it.
#[test]
fn constants_and_rigid_motions() {
    for case in 0..200 {
        let curve = any_curve(case);
        let n = alpha_space(&curve).unwrap().len();
        let start = curve.point(curve.domain().0).unwrap();
        for c in [1.0, 0.3, 2.5] {
            let alpha = alpha_of(&curve, vec![c; n]).unwrap();
            let tuned = FineTune::new(&curve, alpha).ends(Ends::Free).solve().unwrap().into_curve();
            for u in places(&curve) {
                let expected = start + (curve.point(u).unwrap() - start) * c;
                let off = (tuned.point(u).unwrap() - expected).norm() / size(&curve);
                let digits = if curve.degree() > 7 { 1e-9 } else { 1e-12 };
                assert!(off < digits, "{case} {c} {u}: {off}");
            }
        }
        let turn = Rotation3::from_euler_angles(0.3, -1.1, 2.0);
        let by = Vector::new(3.0, -2.0, 1.0) * size(&curve);
        let (space, points, _) = curve.clone().into_parts();
        let moved = Curve::new(space, points.iter().map(|p| turn * p + by).collect()).unwrap();
        let alpha = any_alpha(&curve, case);
        let tuned =
            |c: &Curve| FineTune::new(c, alpha.clone()).ends(Ends::Free).solve().unwrap().into_curve();
        let (one, other) = (tuned(&curve), tuned(&moved));
        for u in places(&curve) {
            let expected = turn * one.point(u).unwrap() + by;
            let digits = if curve.degree() > 7 { 1e-9 } else { 1e-12 };
            assert!((other.point(u).unwrap() - expected).norm() < digits * size(&moved), "{case}");
        }
    }
}

/// Both ends stay, closed curves stay closed and periodic, and `κ_D = κ/α` for the α that is reported. Refusals are counted.
#[test]
fn exact_ends() {
    let (mut refused, mut bounded) = (Vec::new(), 0);
    for case in 0..400 {
        let curve = any_curve(case);
        let asked = any_alpha(&curve, case);
        match FineTune::new(&curve, asked.clone()).solve() {
            Ok(tuned) => {
                let (a, b) = curve.domain();
                for end in [a, b] {
                    let off = (tuned.curve().point(end).unwrap() - curve.point(end).unwrap()).norm();
                    assert!(
                        off <= 1e-12 * size(&curve),
                        "{case}: {:e} {:?} {:?}",
                        off / size(&curve),
                        curve.space(),
                        tuned.report()
                    );
                }
                assert_eq!(tuned.curve().is_periodic(), curve.is_periodic(), "{case}");
                assert_scaled(&curve, tuned.curve(), tuned.alpha(), case);
                bounded += usize::from(!tuned.report().solved.as_ref().unwrap().active.is_empty());
            }
            Err(error) => {
                // Only where α has too few values for as many independent equations.
                assert!(asked.space().len() <= 3, "{case}: {error}");
                refused.push((case, error.to_string()));
            }
        }
    }
    println!("{bounded} with bounds, {} refused", refused.len());
    assert!(refused.len() <= 8, "{} {refused:?}", refused.len());
}

/// The change of α is the least in `∫ (Δα)²`: no other that meets the same equations is nearer.
#[test]
fn the_change_of_alpha_is_least() {
    for case in 0..60 {
        let curve = any_curve(3 * case);
        let asked = any_alpha(&curve, case);
        let Ok(tuned) = FineTune::new(&curve, asked.clone()).any_sign().solve() else { continue };
        let change = tuned.alpha().plus(-1.0, &asked).unwrap();
        // Multiples of C' are what the equations see: the change is one of them, projected into α's space.
        let derivative = loftsman_fine_tuning::derivative(&curve).unwrap();
        let mut random = Lcg(case);
        for _ in 0..5 {
            let other = Function::new(
                asked.space().clone(),
                (0..asked.space().len()).map(|_| random.next() - 0.5).collect::<Vec<f64>>(),
            )
            .unwrap();
            // Its part that the equations do not see, by Gram-Schmidt on what they see.
            let rows: Vec<Function<f64>> = (0..3).map(|k| derivative.mapped(|v| v[k]).unwrap()).collect();
            let seen = |f: &Function<f64>| rows.iter().map(|r| f.inner(r).unwrap()).collect::<Vec<_>>();
            let gram = nalgebra::Matrix3::from_fn(|i, j| rows[i].inner(&rows[j]).unwrap());
            let rhs = nalgebra::Vector3::from_vec(seen(&other));
            let Some(c) = gram.pseudo_inverse(1e-9 * gram.amax()).ok().map(|g| g * rhs) else { continue };
            let mut free = other;
            for k in 0..3 {
                free = free.plus(-c[k], &rows[k]).unwrap();
            }
            let slope = change.inner(&free).unwrap();
            let lengths = (change.inner(&change).unwrap() * free.inner(&free).unwrap()).sqrt();
            assert!(slope.abs() <= 1e-8 * lengths + 1e-14, "{case}: {slope} of {lengths}");
        }
    }
}

#[test]
fn parts() {
    let mut refused = 0;
    for case in 0..300 {
        let curve = any_curve(case);
        if curve.degree() == 1 {
            continue;
        }
        let mut random = Lcg(case);
        let (start, end) = curve.domain();
        let (mut a, mut b) = (start + random.next() * (end - start), start + random.next() * (end - start));
        if random.below(3) == 0 {
            let breakpoints = curve.space().breakpoints();
            a = breakpoints[random.below(breakpoints.len() - 1)];
        }
        if a > b {
            std::mem::swap(&mut a, &mut b);
        }
        if b - a < 0.1 {
            continue;
        }
        // Values of its own, enough for all conditions.
        let q = curve.degree() - 1;
        let breakpoints: Vec<f64> =
            (0..=12).map(|i| if i == 12 { b } else { a + (b - a) * f64::from(i) / 12.0 }).collect();
        let space = Space::clamped(q, &breakpoints).unwrap();
        let values = (0..space.len()).map(|_| 0.6 + random.next()).collect();
        let asked = Function::new(space, values).unwrap();
        let continuity = random.below(3) as u8;
        let tuned = match FineTune::new(&curve, asked).between(a, b).continuity(continuity).solve() {
            Ok(tuned) => tuned,
            Err(_) => {
                refused += 1;
                continue;
            }
        };
        let whole = if curve.is_periodic() { curve.clone() } else { curve.to_clamped().unwrap() };
        let raised = whole.elevate(tuned.curve().degree() - curve.degree()).unwrap();
        let missing: Vec<f64> = [a, b]
            .into_iter()
            .flat_map(|t| {
                let own = if !curve.is_periodic() && (t == start || t == end) {
                    usize::MAX
                } else {
                    raised.space().multiplicity(t)
                };
                std::iter::repeat_n(t, raised.degree().saturating_sub(own))
            })
            .collect();
        let raised = raised.insert_knots(&missing).unwrap();
        let scale = size(&curve);
        for i in 0..=60 {
            let u = start + (end - start) * f64::from(i) / 60.0;
            let (before, after) = (raised.point(u).unwrap(), tuned.curve().point(u).unwrap());
            if u < a || u > b {
                assert_eq!(before, after, "{case}: outside at {u}");
            }
        }
        // Inside it is scaled, and where they meet as smooth as asked.
        for s in [0.1, 0.45, 0.9] {
            let u = a + s * (b - a);
            if curve.space().breakpoints().iter().any(|t| (t - u).abs() < 1e-9) {
                continue;
            }
            let expected = curve.derivative(u, 1).unwrap() * tuned.alpha().value(u).unwrap();
            let found = tuned.curve().derivative(u, 1).unwrap();
            let largest =
                places(&curve).iter().fold(0.0_f64, |m, u| m.max(curve.derivative(*u, 1).unwrap().norm()));
            assert!((found - expected).norm() < 1e-9 * largest, "{case} {u}: {found} {expected}");
        }
        for t in [a, b] {
            let off = (tuned.curve().point(t).unwrap() - curve.point(t).unwrap()).norm() / scale;
            let digits = if curve.degree() > 7 { 1e-9 } else { 1e-12 };
            assert!(
                off <= digits,
                "{case}: {off:e} at {t} of [{a}, {b}] {:?} {:?}",
                curve.space(),
                tuned.curve().space()
            );
            // From inside the derivatives are the given ones.
            let part = |curve: &Curve, order| curve.between(a, b).unwrap().derivative(t, order).unwrap();
            for order in 1..=usize::from(continuity).min(q + 1) {
                let unit = scale / (b - a).powi(order as i32);
                let off = (part(tuned.curve(), order) - part(&curve, order)).norm() / unit;
                let digits = if curve.degree() > 7 { 1e-6 } else { [1e-10, 1e-8][order - 1] };
                assert!(off <= digits, "{case}: order {order} at {t}: {off:e}");
            }
            if continuity > 0 {
                assert!((tuned.alpha().value(t).unwrap() - 1.0).abs() < 1e-12);
            }
            if continuity > 1 && q > 0 {
                let slope = tuned.alpha().derivative().unwrap().value(t).unwrap();
                assert!(
                    slope.abs() < 1e-9 / (b - a),
                    "{case}: {slope} {:?} {:?}",
                    tuned.alpha(),
                    tuned.report()
                );
            }
        }
    }
    assert!(refused <= 6, "{refused} refused");
}

#[test]
fn the_papers_own_ends() {
    for case in 0..200 {
        let curve = any_curve(case);
        if curve.is_periodic() || curve.degree() < 3 {
            continue;
        }
        let alpha = any_alpha(&curve, case);
        let n = alpha.space().len();
        let same =
            FineTune::new(&curve, alpha_of(&curve, vec![1.0; n]).unwrap()).ends(Ends::Free).solve().unwrap();
        for (ends, fixed) in [(Ends::Position, 1), (Ends::Tangent, 2), (Ends::Curvature, 3)] {
            let Ok(tuned) = FineTune::new(&curve, alpha.clone()).ends(ends).solve() else {
                panic!("{case}: {ends:?} of {curve:?}");
            };
            let (found, wanted) = (tuned.curve().points(), same.curve().points());
            let last = found.len() - 1;
            for k in 0..fixed {
                assert!((found[k] - wanted[k]).norm() <= 1e-13 * size(&curve), "{case} {ends:?}");
                assert!(
                    (found[last - k] - wanted[last - k]).norm() <= 1e-13 * size(&curve),
                    "{case} {ends:?}"
                );
            }
            if ends == Ends::Position {
                for u in places(&curve) {
                    let expected = curvature(&curve, u) / (alpha.value(u).unwrap() * tuned.report().scale);
                    let own = curve.derivative(u, 1).unwrap().norm();
                    if own > 0.05 * size(&curve) {
                        let found = curvature(tuned.curve(), u);
                        assert!(
                            (found - expected).abs() <= 1e-7 * (expected + 1.0 / size(&curve)),
                            "{case} {u}"
                        );
                    }
                }
            }
        }
    }
}

/// A closed curve has no scale that keeps its ends; the exact mode does, as the paper's does not.
#[test]
fn closed_curves() {
    let space = Space::periodic_uniform(3, 12).unwrap();
    let ring = (0..12).map(|i| f64::from(i) / 12.0 * std::f64::consts::TAU);
    let points = ring.map(|a| Point::new(3.0 * a.cos(), 2.0 * a.sin(), 0.0)).collect();
    let curve = Curve::new(space, points).unwrap();
    let mut values = vec![1.0; 12];
    values[2] = 0.5;
    values[3] = 0.5;
    let alpha = alpha_of(&curve, values).unwrap();
    let error = FineTune::new(&curve, alpha.clone()).ends(Ends::Position).solve().unwrap_err();
    assert!(matches!(error, FineTuneError::Closed { .. }), "{error}");
    let tuned = FineTune::new(&curve, alpha).solve().unwrap();
    assert!(tuned.curve().is_periodic());
    assert_eq!((tuned.curve().degree(), tuned.curve().space().most_repeated()), (5, 3));
    assert!(tuned.report().change < 0.3, "{}", tuned.report().change);
}

/// An α that ends with another value than it starts with makes a closed curve's curvature jump, which is told with the factor; one that is periodic does not, nor
/// one whose ends agree.
#[test]
fn a_jump_at_the_seam_is_told() {
    let space = Space::periodic_uniform(3, 12).unwrap();
    let ring = (0..12).map(|i| f64::from(i) / 12.0 * std::f64::consts::TAU);
    let points = ring.map(|a| Point::new(3.0 * a.cos(), 2.0 * a.sin(), 0.1 * (2.0 * a).sin())).collect();
    let curve = Curve::new(space, points).unwrap();
    let (a, b) = curve.domain();
    let knots: Vec<f64> = (0..=9).map(|k| a + (b - a) * f64::from(k) / 9.0).collect();
    let open = Space::clamped(2, &knots).unwrap();
    let rising = (0..open.len()).map(|k| 0.6 + 0.1 * k as f64).collect();
    let alpha = Function::new(open.clone(), rising).unwrap();
    let tuned = FineTune::new(&curve, alpha).solve().unwrap();
    assert!(tuned.curve().is_periodic());
    let bend = |at: f64| {
        let [first, second] = [1, 2].map(|order| tuned.curve().derivative(at, order).unwrap());
        first.cross(&second).norm() / first.norm().powi(3)
    };
    let own = bend(a + 1e-7) / bend(b - 1e-7);
    let [first, last] = [a, b].map(|at| tuned.alpha().value(at).unwrap());
    assert!((own - last / first).abs() < 1e-5 && (own - 1.0).abs() > 0.05, "{own} {first} {last}");
    let note = tuned.report().notes.iter().find(|note| note.contains("jumps there")).unwrap();
    let told: f64 = note.split("by the factor ").nth(1).unwrap().split(';').next().unwrap().parse().unwrap();
    assert!((told - own).abs() < 1e-3 * own, "{note}");
    let mut same: Vec<f64> = (0..open.len()).map(|k| 1.0 + 0.2 * (k as f64).sin()).collect();
    let last = same.len() - 1;
    same[last] = same[0];
    let even = Function::new(open, same).unwrap();
    let smooth = [alpha_of(&curve, (0..12).map(|k| 1.0 + 0.02 * f64::from(k)).collect()).unwrap(), even];
    for (k, alpha) in smooth.into_iter().enumerate() {
        // Ends that agree may be moved apart to close the curve: as they are with free ends, where that closes.
        let tuned = FineTune::new(&curve, alpha).solve().unwrap();
        let [first, last] = [a, b].map(|at| tuned.alpha().value(at).unwrap());
        let jumps = tuned.report().notes.iter().any(|note| note.contains("jumps there"));
        assert_eq!(jumps, k == 1 && (first - last).abs() > 1e-9 * first, "{k} {first} {last}");
    }
}

/// A point is passed, and one coordinate of another kept, while α scales: fine tuning and constraints in one step.
#[test]
fn constraints_beside() {
    let points = (0..14).map(f64::from).map(|x| Point::new(x, (0.7 * x).sin(), 0.0)).collect();
    let curve = Curve::new(Space::clamped_uniform(3, 14).unwrap(), points).unwrap();
    let alpha = any_alpha(&curve, 5);
    let to = curve.point(3.3).unwrap() + Vector::new(0.1, -0.05, 0.0);
    let tuned = FineTune::new(&curve, alpha)
        .through(3.3, to)
        .ask(position(7.0).axis(loftsman_kernel::edit::Axis::Y).keep())
        .ask(position(5.0).on(1).axis(loftsman_kernel::edit::Axis::X).to(1.25))
        .solve()
        .unwrap();
    assert!((tuned.curve().point(3.3).unwrap() - to).norm() < 1e-12);
    assert!((tuned.curve().point(7.0).unwrap().y - curve.point(7.0).unwrap().y).abs() < 1e-12);
    assert!((tuned.alpha().value(5.0).unwrap() - 1.25).abs() < 1e-12);
    assert_scaled(&curve, tuned.curve(), tuned.alpha(), 0);
}

#[test]
fn what_cannot_be_is_refused_in_words() {
    let points: Vec<Point> =
        (0..9).map(|i| Point::new(f64::from(i), f64::from(i * i % 7), f64::from(i % 3))).collect();
    let space = Space::clamped_uniform(3, 9).unwrap();
    let curve = Curve::new(space.clone(), points.clone()).unwrap();
    let text = |result: Result<loftsman_fine_tuning::Tuned, FineTuneError>| result.unwrap_err().to_string();
    let error = alpha_of(&curve, vec![1.0; 9]).unwrap_err().to_string();
    assert!(error.contains("9 values and needs 8"), "{error}");
    let mut values = vec![1.0; 8];
    values[3] = -0.5;
    let negative = alpha_of(&curve, values).unwrap();
    let error = text(FineTune::new(&curve, negative.clone()).solve());
    assert!(error.contains("α is -0.125 at 2.5 (value 3)"), "{error}");
    assert!(FineTune::new(&curve, negative).any_sign().ends(Ends::Free).solve().is_ok());
    let alpha = any_alpha(&curve, 1);
    let out = "reaches out of the domain, which is [0, 6]";
    for (a, b, what) in [
        (3.0, 2.0, "is reversed"),
        (-1.0, 2.0, out),
        (2.0, 99.0, out),
        (f64::NAN, 2.0, "two numbers"),
        (2.0, 2.0, "is empty"),
    ] {
        let error = text(FineTune::new(&curve, alpha.clone()).between(a, b).solve());
        assert!(error.contains(what), "{error}");
    }
    // Inside one span α has three values, and C² ends need seven.
    let error = text(FineTune::new(&curve, alpha.clone()).between(2.2, 2.6).solve());
    assert!(error.contains("7 equations") && error.contains("3 values"), "{error}");
    let error = text(FineTune::new(&curve, alpha.clone()).ends(Ends::Free).between(1.0, 2.0).solve());
    assert!(error.contains("torn off"), "{error}");
    let error =
        text(FineTune::new(&curve, alpha.clone()).ends(Ends::Free).through(1.0, Point::origin()).solve());
    assert!(error.contains("exact"), "{error}");
    let weights = (0..9).map(|k| 1.0 + f64::from(k % 3)).collect();
    let rational = Curve::rational(space.clone(), points.clone(), weights).unwrap();
    let error = text(FineTune::new(&rational, alpha.clone()).solve());
    assert!(error.contains("rational"), "{error}");
    // Weights that are all the same are none.
    let plain = Curve::rational(space, points, vec![2.5; 9]).unwrap();
    let tuned = FineTune::new(&plain, alpha.clone()).solve().unwrap();
    assert_eq!(tuned.curve(), FineTune::new(&curve, alpha.clone()).solve().unwrap().curve());
    let far = Function::constant(Space::clamped(2, &[0.0, 1.0]).unwrap(), 1.0).unwrap();
    let error = text(FineTune::new(&curve, far).solve());
    assert!(error.contains("[0, 1]"), "{error}");
    // A point out of reach: α would have to be negative.
    let error = text(FineTune::new(&curve, alpha).through(3.0, Point::new(500.0, 0.0, 0.0)).solve());
    assert!(error.contains("takes an α that is not positive") && error.contains("any_sign"), "{error}");
}

/// A range that is all of a period, said as one.
#[test]
fn a_whole_period() {
    let ring = (0..12).map(|i| f64::from(i) / 12.0 * std::f64::consts::TAU);
    let points = ring.map(|a| Point::new(3.0 * a.cos(), 2.0 * a.sin(), 0.0)).collect();
    let curve = Curve::new(Space::periodic_uniform(3, 12).unwrap(), points).unwrap();
    let space = Space::clamped_uniform(2, 14).unwrap();
    let alpha = Function::new(space, (0..14).map(|i| 0.7 + 0.1 * f64::from(i % 5)).collect()).unwrap();
    let tuned = FineTune::new(&curve, alpha).between(0.0, 12.0).solve().unwrap();
    assert!(tuned.curve().is_periodic());
    for order in 0..3 {
        let off = tuned.curve().derivative(0.0, order).unwrap() - curve.derivative(0.0, order).unwrap();
        assert!(off.norm() < 1e-9, "{order}: {off}");
    }
    assert!((tuned.curve().point(5.0).unwrap() - curve.point(5.0).unwrap()).norm() > 1e-3);
}

/// α of any degree that the tuned curve can have is measured.
#[test]
fn alpha_of_a_high_degree() {
    let points = (0..6).map(|i| Point::new(f64::from(i), f64::from(i * i % 5), 0.0)).collect();
    let curve = Curve::new(Space::clamped_uniform(2, 6).unwrap(), points).unwrap();
    let space = Space::clamped(20, &[0.0, 4.0]).unwrap();
    let alpha = Function::new(space, (0..21).map(|i| 1.0 + 0.02 * f64::from(i)).collect()).unwrap();
    let tuned = FineTune::new(&curve, alpha).solve().unwrap();
    assert_eq!(tuned.curve().degree(), 22);
    assert!((tuned.curve().point(4.0).unwrap() - curve.point(4.0).unwrap()).norm() < 1e-9);
}

/// Of curves that neither stop nor straighten, as those of the paper: `D' = αC'` and `κ_D = κ/α` at random parameters to 1e-10 as they stand, of all sizes, open and closed, in planes and in space.
#[test]
fn curvatures_are_divided_by_alpha_to_1e_10() {
    let mut worst = [0.0_f64; 2];
    for seed in 0..120 {
        let mut random = Lcg(seed + 1000);
        (0..9).for_each(|_| {
            random.next();
        });
        let (degree, n, closed) = (2 + random.below(4), 9 + random.below(30), seed % 3 == 0);
        let size = [1.0, 1e-9, 1e9, 40.0][random.below(4)];
        let space = if closed {
            Space::periodic_uniform(degree, n).unwrap()
        } else {
            let mut knots = vec![0.0; degree + 1];
            (1..n - degree).for_each(|k| knots.push(k as f64 + 0.3 * (random.next() - 0.5)));
            knots.extend(vec![(n - degree) as f64; degree + 1]);
            Space::open(degree, knots).unwrap()
        };
        // A closed oval, or a spiral that climbs.
        let climbs = if closed || seed % 2 == 0 { 0.0 } else { 0.4 };
        let points = (0..n).map(|i| {
            let share = if closed { i as f64 / n as f64 } else { space.greville(i) / (n - degree) as f64 };
            let a = share * std::f64::consts::TAU * if closed { 1.0 } else { 0.8 };
            let r = size * (1.0 + if closed { 0.0 } else { 0.3 * share });
            Point::new(1.4 * r * a.cos(), r * a.sin(), size * climbs * a)
        });
        let curve = Curve::new(space.clone(), points.collect()).unwrap();
        let alpha = any_alpha(&curve, seed);
        let tuned = FineTune::new(&curve, alpha.clone()).ends(Ends::Free).solve().unwrap().into_curve();
        let (start, end) = curve.space().domain();
        for _ in 0..20 {
            let u = start + (end - start) * random.next();
            let a = alpha.value(u).unwrap();
            let own = curve.derivative(u, 1).unwrap() * a;
            let derivative = (tuned.derivative(u, 1).unwrap() - own).norm() / own.norm();
            let wanted = curvature(&curve, u) / a;
            let bent = (curvature(&tuned, u) - wanted).abs() / wanted;
            worst = [worst[0].max(derivative), worst[1].max(bent)];
            assert!(derivative < 1e-10, "{seed}: D' at {u} off by {derivative:e}");
            assert!(bent < 1e-10, "{seed}: κ at {u} off by {bent:e}, degree {degree}, {n} vertices");
        }
    }
    // And far below that: what a rounding of such curves makes.
    assert!(worst[0] < 1e-11 && worst[1] < 1e-10, "{worst:?}");
}

/// A point that no α brings the curve to is said to be that, and why: off the plane or the line of the curve, at the start, outside of the range.
#[test]
fn points_out_of_reach_are_said() {
    let text = |result: Result<loftsman_fine_tuning::Tuned, FineTuneError>| result.unwrap_err().to_string();
    let turned = |x: f64, y: f64| Point::new(0.6 * x - 0.3, y, 0.8 * x + 0.1 * y);
    let points = (0..14).map(f64::from).map(|x| turned(x, (0.7 * x).sin())).collect();
    let curve = Curve::new(Space::clamped_uniform(3, 14).unwrap(), points).unwrap();
    let alpha = any_alpha(&curve, 1);
    let tune = |at: f64, by: Vector| {
        let tune = FineTune::new(&curve, alpha.clone());
        text(tune.through(at, curve.point(at).unwrap() + by).solve())
    };
    let error = tune(4.0, Vector::new(0.4, 0.05, -0.3));
    assert!(error.contains("stays in its plane") && error.contains("through[0], at 4"), "{error}");
    let error = tune(0.0, Vector::new(0.3, 0.0, 0.4));
    assert!(error.contains("the start stays"), "{error}");
    let part = FineTune::new(&curve, alpha.clone()).between(3.0, 8.0);
    let error = text(part.through(1.0, turned(2.0, 0.0)).solve());
    assert!(error.contains("inside of the range"), "{error}");
    let line = (0..9).map(f64::from).map(|x| Point::new(x, 2.0 * x, x / 3.0)).collect();
    let line = Curve::new(Space::clamped_uniform(2, 9).unwrap(), line).unwrap();
    let tune = FineTune::new(&line, any_alpha(&line, 2));
    let error = text(tune.through(3.0, Point::new(3.0, 3.0, 1.0)).solve());
    assert!(error.contains("stays on its line"), "{error}");
}

//! Fine tuning of surfaces: the identities of theory §5, edges and regions that stay, and what is refused.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail the test")]

use loftsman_fine_tuning::{
    Ends, FineTuneError, FineTuneSurface, Scaling, TunedSurface, surface_alpha_of, surface_alpha_spaces,
};
use loftsman_kernel::spline::algebra::{Field, Function};
use loftsman_kernel::spline::{Direction, Space, Surface};
use loftsman_kernel::{Point, Vector};
use nalgebra::Rotation3;

use Direction::{U, V};

/// Numbers of a fixed sequence, in [0, 1).
struct Lcg(u64);

impl Lcg {
    fn new(seed: u64) -> Self {
        let mut random = Self(seed);
        (0..9).for_each(|_| {
            random.next();
        });
        random
    }

    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() * n as f64) as usize
    }
}

/// Clamped, floating or periodic, knots repeated up to corners now and then.
fn any_space(degree: usize, random: &mut Lcg) -> Space {
    let kind = random.below(3);
    let mut knots = Vec::new();
    let mut at = 0.0;
    for _ in 0..1 + random.below(4) {
        at += if random.below(5) == 0 { 0.05 } else { 0.3 + random.next() };
        let times = if random.below(4) == 0 { 1 + random.below(degree) } else { 1 };
        knots.extend(std::iter::repeat_n(at, times));
    }
    let end = at + 0.7;
    match kind {
        0 => {
            let all = [vec![0.0; degree + 1], knots, vec![end; degree + 1]].concat();
            Space::open(degree, all).unwrap()
        }
        1 => {
            let mut all: Vec<f64> = (0..=degree).map(|i| -0.4 * (degree - i) as f64).collect();
            all.extend(knots);
            all.extend((0..=degree).map(|i| end + 0.3 * i as f64));
            Space::open(degree, all).unwrap()
        }
        _ => {
            let mut all = [vec![0.0], knots, vec![end]].concat();
            while all.len() < degree + 3 {
                let last = all.pop().unwrap();
                all.extend([last, last + 0.5]);
            }
            Space::periodic(degree, all).unwrap()
        }
    }
}

/// A surface of degrees 1 to 5, of any size, plane or not, with a pole now and then.
fn any_surface(seed: u64) -> Surface {
    let mut random = Lcg::new(seed);
    let (p, q) = (1 + random.below(5), 1 + random.below(5));
    let (u, v) = (any_space(p, &mut random), any_space(q, &mut random));
    shaped(u, v, &mut random)
}

fn shaped(u: Space, v: Space, random: &mut Lcg) -> Surface {
    let size = [1.0, 1.0, 1e-9, 1e9][random.below(4)];
    let (flat, pole) = (random.below(4) == 0, random.below(5) == 0);
    let (rows, columns) = (u.len(), v.len());
    let mut points = Vec::new();
    for i in 0..rows {
        for j in 0..columns {
            let (a, b) = (i as f64 / rows as f64 * 5.0, j as f64 / columns as f64 * 4.0);
            let mut noise = || 0.5 * random.next() - 0.25;
            let (x, y) = (a + noise(), b + noise());
            let z = if flat { 0.0 } else { (a + b).sin() + noise() };
            let at = if pole && i == 0 { Vector::new(0.0, 2.0, 0.5) } else { Vector::new(x, y, z) };
            points.push(Point::from(at * size));
        }
    }
    Surface::new(u, v, points).unwrap()
}

fn any_line(surface: &Surface, direction: Direction, random: &mut Lcg) -> Function<f64> {
    let [u, v] = surface_alpha_spaces(surface).unwrap();
    let space = if direction == U { u } else { v };
    let values = (0..space.len()).map(|_| 0.4 + 1.4 * random.next()).collect();
    Function::new(space, values).unwrap()
}

/// α(u, v) of degree `across` on even knots over the surface's domain, without jumps; periodic where the surface is.
fn any_net(surface: &Surface, knots: [usize; 2], degrees: [usize; 2], random: &mut Lcg) -> Field<f64> {
    let even = |space: &Space, count: usize, degree: usize| {
        let (a, b) = space.domain();
        let at = |i: usize| if i == count { b } else { a + (b - a) * i as f64 / count as f64 };
        let breakpoints: Vec<f64> = (0..=count).map(at).collect();
        if space.is_periodic() && count >= degree + 2 && degree > 0 {
            Space::periodic(degree, breakpoints).unwrap()
        } else {
            Space::clamped(degree, &breakpoints).unwrap()
        }
    };
    let (u, v) = (even(surface.u(), knots[0], degrees[0]), even(surface.v(), knots[1], degrees[1]));
    let values = (0..u.len() * v.len()).map(|_| 0.5 + random.next()).collect();
    Field::new(u, v, values).unwrap()
}

fn size(surface: &Surface) -> f64 {
    surface.points().iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()))
}

fn inside(space: &Space) -> Vec<f64> {
    let breakpoints = space.breakpoints();
    breakpoints.windows(2).flat_map(|w| [0.13, 0.71].map(|s| w[0] + s * (w[1] - w[0]))).collect()
}

fn places(surface: &Surface) -> Vec<(f64, f64)> {
    let all = inside(surface.v());
    inside(surface.u()).into_iter().flat_map(|u| all.iter().map(move |v| (u, *v))).collect()
}

fn slope(surface: &Surface, direction: Direction, (u, v): (f64, f64)) -> Vector {
    let (a, b) = if direction == U { (1, 0) } else { (0, 1) };
    surface.derivative(u, v, a, b).unwrap()
}

fn curvature(surface: &Surface, direction: Direction, (u, v): (f64, f64)) -> f64 {
    let second = if direction == U { (2, 0) } else { (0, 2) };
    let (first, second) =
        (slope(surface, direction, (u, v)), surface.derivative(u, v, second.0, second.1).unwrap());
    first.cross(&second).norm() / first.norm().powi(3)
}

/// `D_u = αS_u`, and of each line the curvature divided by α.
fn assert_scaled(
    given: &Surface,
    tuned: &Surface,
    direction: Direction,
    alpha: &dyn Fn(f64, f64) -> f64,
    case: u64,
) {
    let all = places(given);
    let largest = all.iter().fold(0.0_f64, |m, at| m.max(slope(given, direction, *at).norm()));
    for at in all {
        let (own, found, a) = (slope(given, direction, at), slope(tuned, direction, at), alpha(at.0, at.1));
        assert!(
            (found - own * a).norm() <= 1e-10 * largest * a.abs().max(1.0),
            "{case} {at:?}: {found} {}",
            own * a
        );
        if given.space(direction).degree() > 1 && own.norm() > 0.05 * largest && a > 0.05 {
            let (before, after) = (curvature(given, direction, at), curvature(tuned, direction, at));
            assert!((after - before / a).abs() <= 1e-7 * (before / a + 1.0 / size(given)), "{case} κ {at:?}");
        }
    }
}

fn distance(one: &Surface, other: &Surface) -> f64 {
    places(one)
        .into_iter()
        .fold(0.0_f64, |m, (u, v)| m.max((one.point(u, v).unwrap() - other.point(u, v).unwrap()).norm()))
}

fn free(surface: &Surface, scaling: Scaling) -> Surface {
    FineTuneSurface::new(surface, scaling).ends(Ends::Free).solve().unwrap().into_surface()
}

#[test]
fn a_biquadratic_becomes_a_bicubic() {
    let mut random = Lcg::new(1);
    let (u, v) = (Space::clamped_uniform(2, 6).unwrap(), Space::clamped_uniform(2, 5).unwrap());
    let surface = shaped(u, v, &mut random);
    let (alpha, beta) = (any_line(&surface, U, &mut random), any_line(&surface, V, &mut random));
    let tuned = free(&surface, Scaling::u_and_v(alpha, beta));
    assert_eq!((tuned.u().degree(), tuned.v().degree()), (3, 3));
    assert_eq!((tuned.u().most_repeated(), tuned.u().is_clamped()), (2, true));
}

#[test]
fn lines_are_scaled() {
    for case in 0..150 {
        let (surface, mut random) = (any_surface(case), Lcg::new(case + 1000));
        let (alpha, beta) = (any_line(&surface, U, &mut random), any_line(&surface, V, &mut random));
        let along_u = free(&surface, Scaling::u(alpha.clone()));
        assert_eq!(along_u.u().degree(), 2 * surface.u().degree() - 1);
        assert_eq!(along_u.v(), surface.v());
        assert_scaled(&surface, &along_u, U, &|u, _| alpha.value(u).unwrap(), case);
        let along_v = free(&surface, Scaling::v(beta.clone()));
        assert_scaled(&surface, &along_v, V, &|_, v| beta.value(v).unwrap(), case);
        // Both, in one step or in two, in either order.
        let both = free(&surface, Scaling::u_and_v(alpha.clone(), beta.clone()));
        assert_scaled(&along_v, &both, U, &|u, _| alpha.value(u).unwrap(), case);
        assert_scaled(&along_u, &both, V, &|_, v| beta.value(v).unwrap(), case);
        for other in [free(&along_u, Scaling::v(beta)), free(&along_v, Scaling::u(alpha))] {
            assert!(distance(&both, &other) <= 1e-11 * size(&both), "{case}");
        }
        // The edges that integration starts from.
        let (u0, v0) = (surface.u().domain().0, surface.v().domain().0);
        for (_, v) in places(&surface) {
            let off = along_u.point(u0, v).unwrap() - surface.point(u0, v).unwrap();
            assert!(off.norm() <= 1e-13 * size(&surface), "{case}");
        }
        assert!(
            (both.point(u0, v0).unwrap() - surface.point(u0, v0).unwrap()).norm() <= 1e-13 * size(&surface)
        );
    }
}

#[test]
fn nets_scale_each_line_by_its_own() {
    for case in 0..100 {
        let (surface, mut random) = (any_surface(case), Lcg::new(case + 2000));
        let degrees = [random.below(4), 1 + random.below(3)];
        for direction in [U, V] {
            let (knots, degrees) =
                if direction == U { ([5, 4], degrees) } else { ([4, 5], [degrees[1], degrees[0]]) };
            let alpha = any_net(&surface, knots, degrees, &mut random);
            let tuning =
                FineTuneSurface::new(&surface, Scaling::along(direction, alpha.clone())).ends(Ends::Free);
            let closed = surface.space(if direction == U { V } else { U }).is_periodic();
            let tuned = match tuning.solve() {
                Ok(tuned) => tuned.into_surface(),
                Err(error) => {
                    // α that is not closed where the surface is.
                    assert!(closed && error.to_string().contains("closed along"), "{case}: {error}");
                    continue;
                }
            };
            // Between the knots of both.
            let (u, v) = (tuned.u().breakpoints(), tuned.v().breakpoints());
            let in_spans = |all: &[f64]| all.windows(2).map(|w| 0.4 * w[0] + 0.6 * w[1]).collect::<Vec<_>>();
            let largest =
                places(&surface).iter().fold(0.0_f64, |m, at| m.max(slope(&surface, direction, *at).norm()));
            for u in in_spans(&u) {
                for v in in_spans(&v) {
                    let expected = slope(&surface, direction, (u, v)) * alpha.value(u, v).unwrap();
                    let found = slope(&tuned, direction, (u, v));
                    assert!((found - expected).norm() <= 1e-10 * largest, "{case} {direction:?} {u} {v}");
                }
            }
        }
    }
}

#[test]
fn constants_and_rigid_motions() {
    for case in 0..80 {
        let (surface, mut random) = (any_surface(case), Lcg::new(case + 3000));
        let [u, v] = surface_alpha_spaces(&surface).unwrap();
        let (u0, v0) = (surface.u().domain().0, surface.v().domain().0);
        for c in [1.0, 0.3, 2.5] {
            let alpha = Function::constant(u.clone(), c).unwrap();
            let tuned = free(&surface, Scaling::u(alpha.clone()));
            let other = free(&surface, Scaling::u_and_v(alpha, Function::constant(v.clone(), c).unwrap()));
            let start = surface.point(u0, v0).unwrap();
            for (u, v) in places(&surface) {
                let (own, from) = (surface.point(u, v).unwrap(), surface.point(u0, v).unwrap());
                assert!(
                    (tuned.point(u, v).unwrap() - (from + (own - from) * c)).norm() <= 1e-12 * size(&surface)
                );
                // Scaled both ways from one corner; what is not a sum of lines is scaled twice.
                if c == 1.0 {
                    assert!((other.point(u, v).unwrap() - own).norm() <= 1e-12 * size(&surface), "{start}");
                }
            }
        }
        let turn = Rotation3::from_euler_angles(0.3, -1.1, 2.0);
        let by = Vector::new(3.0, -2.0, 1.0) * size(&surface);
        let points = surface.points().iter().map(|p| turn * p + by).collect();
        let moved = Surface::new(surface.u().clone(), surface.v().clone(), points).unwrap();
        let scaling =
            Scaling::u_and_v(any_line(&surface, U, &mut random), any_line(&surface, V, &mut random));
        let (one, other) = (free(&surface, scaling.clone()), free(&moved, scaling));
        let points = one.points().iter().map(|p| turn * p + by).collect();
        let turned = Surface::new(one.u().clone(), one.v().clone(), points).unwrap();
        assert!(distance(&turned, &other) <= 1e-12 * size(&moved), "{case}");
    }
}

/// Both edges stay for an α(u, v) with values enough; closed surfaces stay closed.
#[test]
fn exact_edges() {
    let (mut refused, mut closed, mut bounded) = (Vec::new(), 0, 0);
    for case in 0..60 {
        let (surface, mut random) = (any_surface(case), Lcg::new(case + 4000));
        let q = surface.v().degree();
        let spans = surface.v().breakpoints().len() - 1;
        let alpha = any_net(&surface, [(3 * (q + 1) * spans).min(40) + 5, 3], [2, 1], &mut random);
        let tuned = match FineTuneSurface::new(&surface, Scaling::along(U, alpha)).solve() {
            Ok(tuned) => tuned,
            Err(error) => {
                refused.push((case, error.to_string()));
                continue;
            }
        };
        let Scaling::Along { alpha: found, .. } = tuned.scaling() else { panic!("another scaling") };
        assert!(found.coefficients().iter().all(|c| *c > 0.0));
        bounded += usize::from(tuned.report().solved[0].as_ref().is_some_and(|r| !r.active.is_empty()));
        let own = tuned.surface();
        assert_eq!(own.u().is_periodic(), surface.u().is_periodic(), "{case}");
        closed += usize::from(own.u().is_periodic());
        let (u0, u1) = surface.u().domain();
        for v in inside(own.v()) {
            for u in [u0, u1] {
                let off = (own.point(u, v).unwrap() - surface.point(u, v).unwrap()).norm();
                assert!(off <= 1e-12 * size(&surface), "{case} {u} {v}: {:e}", off / size(&surface));
            }
        }
        let largest = places(&surface).iter().fold(0.0_f64, |m, at| m.max(slope(&surface, U, *at).norm()));
        for u in inside(own.u()) {
            for v in inside(own.v()) {
                let expected = slope(&surface, U, (u, v)) * found.value(u, v).unwrap();
                assert!((slope(own, U, (u, v)) - expected).norm() <= 1e-9 * largest, "{case} {u} {v}");
            }
        }
    }
    println!("{closed} closed, {bounded} with bounds, refused: {refused:?}");
    assert!(refused.len() <= 12, "{} {refused:?}", refused.len());
    assert!(closed >= 10);
}

/// α(u) alone keeps both edges of an extrusion, whose lines are all of one kind, and of nothing with more kinds than it has values.
#[test]
fn exact_edges_by_one_function() {
    let profile: Vec<Vector> =
        (0..9).map(|i| f64::from(i)).map(|x| Vector::new(x, (0.9 * x).sin(), 0.0)).collect();
    let (u, v) = (Space::clamped_uniform(3, 9).unwrap(), Space::clamped_uniform(2, 4).unwrap());
    let points =
        profile.iter().flat_map(|p| (0..4).map(move |j| Point::from(p + Vector::z() * f64::from(j * j))));
    let extruded = Surface::new(u.clone(), v.clone(), points.collect()).unwrap();
    let mut random = Lcg::new(5);
    let (alpha, beta) = (any_line(&extruded, U, &mut random), any_line(&extruded, V, &mut random));
    let tuned = FineTuneSurface::new(&extruded, Scaling::u_and_v(alpha, beta)).solve().unwrap();
    assert_eq!(tuned.report().solved[0].as_ref().unwrap().rank, 2);
    for (u, v) in [(0.0, 0.0), (0.0, 2.0), (6.0, 0.0), (6.0, 2.0)] {
        let off = tuned.surface().point(u, v).unwrap() - extruded.point(u, v).unwrap();
        assert!(off.norm() < 1e-11, "{u} {v}");
    }
    let wild = shaped(u, v, &mut random);
    let error = FineTuneSurface::new(&wild, Scaling::u(any_line(&wild, U, &mut random))).solve().unwrap_err();
    assert!(matches!(error, FineTuneError::Edges { equations: 8, values: 8, .. }), "{error}");
    assert!(error.to_string().contains("α(u, v)"), "{error}");
    // α = 1 keeps what it keeps.
    let one = Function::constant(surface_alpha_spaces(&wild).unwrap()[0].clone(), 1.0).unwrap();
    let same = FineTuneSurface::new(&wild, Scaling::u(one)).solve().unwrap();
    assert!(distance(&wild, same.surface()) <= 1e-13 * size(&wild));
}

/// The surface in the degrees and with the knots that a tuned part of it needs, as the kernel makes it.
fn raised(surface: &Surface, tuned: &Surface) -> Surface {
    let mut all = surface.clone();
    for direction in [U, V] {
        let (own, to) = (all.space(direction).clone(), tuned.space(direction));
        if &own == to {
            continue;
        }
        if !own.is_periodic() {
            all = all.convert(direction, &own.clamping().unwrap()).unwrap();
        }
        all = all.elevate(direction, to.degree() - own.degree()).unwrap();
        let ends = own.domain();
        // Copies of a seam may be numbered with its start or with its end.
        let refined = [ends.1, ends.0].map(|left_out| {
            let lacking = |t: f64| {
                let end = t == left_out || (!own.is_periodic() && (t == ends.0 || t == ends.1));
                let times = if end { 0 } else { to.multiplicity(t) - all.space(direction).multiplicity(t) };
                std::iter::repeat_n(t, times)
            };
            let missing: Vec<f64> = to.breakpoints().into_iter().flat_map(lacking).collect();
            all.insert_knots(direction, &missing).unwrap()
        });
        let same = usize::from(refined[1].space(direction) == to);
        all = refined[same].clone();
    }
    all
}

#[test]
fn regions() {
    let (mut refused, mut done) = (Vec::new(), 0);
    for case in 0..80 {
        let (surface, mut random) = (any_surface(case), Lcg::new(case + 5000));
        let mut part = |space: &Space| {
            let (a, b) = space.domain();
            let (s, t) = (random.next() * 0.5, 0.6 + 0.4 * random.next());
            (a + s * (b - a), if random.below(5) == 0 { b } else { a + t * (b - a) })
        };
        let (in_u, in_v) = (part(surface.u()), part(surface.v()));
        let continuity = random.below(3) as u8;
        let patch = surface.between(U, in_u.0, in_u.1).unwrap().between(V, in_v.0, in_v.1).unwrap();
        let (both, direction) = (random.below(3) == 0, [U, V][random.below(2)]);
        let across = patch.space(if direction == U { V } else { U });
        let many = (3 * (across.degree() + 1) * (across.breakpoints().len() - 1)).min(36) + 8;
        let (knots, degrees) = if direction == U { ([many, 7], [2, 2]) } else { ([7, many], [2, 2]) };
        let tuning = if both {
            FineTuneSurface::new(&surface, Scaling::both(any_net(&patch, [3, 3], degrees, &mut random)))
        } else {
            FineTuneSurface::new(
                &surface,
                Scaling::along(direction, any_net(&patch, knots, degrees, &mut random)),
            )
        };
        let tuning = tuning.between(U, in_u.0, in_u.1).between(V, in_v.0, in_v.1).continuity(continuity);
        let tuned = match tuning.solve() {
            Ok(tuned) => tuned,
            Err(error) => {
                refused.push((case, error.to_string()));
                continue;
            }
        };
        done += 1;
        let own = tuned.surface();
        let whole = raised(&surface, own);
        assert!(distance(&surface, &whole) <= 1e-12 * size(&surface), "{case}");
        let mut moved = 0;
        for i in 0..=24 {
            for j in 0..=24 {
                let at = |space: &Space, i: usize| {
                    let (a, b) = space.domain();
                    a + (b - a) * (i as f64 / 24.0)
                };
                let (u, v) = (at(surface.u(), i), at(surface.v(), j));
                let (before, after) = (whole.point(u, v).unwrap(), own.point(u, v).unwrap());
                let out = |x: f64, (a, b): (f64, f64)| x < a || x > b;
                if out(u, in_u) || out(v, in_v) {
                    assert_eq!(before, after, "{case}: outside at {u} {v}");
                } else {
                    moved += usize::from((before - after).norm() > 1e-9 * size(&surface));
                }
            }
        }
        assert!(moved > 0, "{case}: nothing was tuned");
        // On the border as smooth as was asked: the derivatives across it from inside are the given ones.
        for s in [0.0, 0.07, 0.31, 0.64, 0.93, 1.0] {
            let (u, v) = (in_u.0 + s * (in_u.1 - in_u.0), in_v.0 + s * (in_v.1 - in_v.0));
            let border = [(in_u.0, v, U), (in_u.1, v, U), (u, in_v.0, V), (u, in_v.1, V)];
            let tuned = own.between(U, in_u.0, in_u.1).unwrap().between(V, in_v.0, in_v.1).unwrap();
            for (u, v, direction) in border {
                for order in 0..=usize::from(continuity) {
                    let of = |s: &Surface| match direction {
                        U => s.derivative(u, v, order, 0).unwrap(),
                        V => s.derivative(u, v, 0, order).unwrap(),
                    };
                    let unit = size(&surface) / patch.space(direction).length().powi(order as i32);
                    let off = (of(&tuned) - of(&patch)).norm() / unit;
                    let digits = [1e-12, 1e-9, 1e-6][order];
                    assert!(
                        off <= digits,
                        "{case}: order {order} across {direction:?} at {u} {v}: {off:e} {both}"
                    );
                }
            }
        }
        if let Scaling::Along { alpha, .. } = tuned.scaling() {
            let largest =
                places(&patch).iter().fold(0.0_f64, |m, at| m.max(slope(&patch, direction, *at).norm()));
            for s in [0.1234, 0.4567, 0.8901] {
                let (u, v) = (in_u.0 + s * (in_u.1 - in_u.0), in_v.0 + s * (in_v.1 - in_v.0));
                let expected = slope(&patch, direction, (u, v)) * alpha.value(u, v).unwrap();
                assert!((slope(own, direction, (u, v)) - expected).norm() <= 1e-8 * largest, "{case}");
            }
        }
    }
    println!("{done} done, refused: {refused:?}");
    assert!(done >= 55, "{} {refused:?}", refused.len());
}

/// A strip around a tube, tuned along its axis: the closed direction stays closed.
#[test]
fn a_strip_of_a_closed_surface() {
    let (u, v) = (Space::clamped_uniform(3, 12).unwrap(), Space::periodic_uniform(3, 10).unwrap());
    let at = |i: u32, j: u32| {
        let (a, r) = (f64::from(j) * 0.2 * std::f64::consts::PI, 2.0 + 0.3 * f64::from(i).sin());
        Point::new(r * a.cos(), r * a.sin(), f64::from(i))
    };
    let points = (0..12).flat_map(|i| (0..10).map(move |j| at(i, j))).collect();
    let tube = Surface::new(u, v, points).unwrap();
    let breakpoints: Vec<f64> = (0..=30).map(|i| 2.0 + f64::from(i) / 6.0).collect();
    let along = Space::clamped(2, &breakpoints).unwrap();
    let around = Space::periodic_uniform(2, 10).unwrap();
    let values = (0..along.len() * 10).map(|k| 1.0 + 0.3 * f64::from((k * 7 % 11) as u32) / 11.0).collect();
    let alpha = Field::new(along, around, values).unwrap();
    let tuned = FineTuneSurface::new(&tube, Scaling::along(U, alpha)).between(U, 2.0, 7.0).solve().unwrap();
    let own = tuned.surface();
    assert!(own.v().is_periodic() && !own.u().is_periodic());
    let whole = raised(&tube, own);
    for k in 0..50 {
        let v = f64::from(k) * 0.2;
        for u in [0.0, 0.7, 1.99, 7.01, 8.5] {
            assert_eq!(whole.point(u, v).unwrap(), own.point(u, v).unwrap());
        }
        for u in [2.0, 7.0] {
            assert!((tube.point(u, v).unwrap() - own.point(u, v).unwrap()).norm() < 1e-12 * 20.0);
        }
    }
    assert!(distance(&tube, own) > 1e-4);
}

fn net(space: [&Space; 2], value: impl Fn(f64, f64) -> f64) -> Field<f64> {
    let [u, v] = space;
    let each = (0..u.len()).flat_map(|i| (0..v.len()).map(move |j| (i, j)));
    let values = each.map(|(i, j)| value(u.greville(i), v.greville(j))).collect();
    Field::new(u.clone(), v.clone(), values).unwrap()
}

/// Both derivatives by a constant: the exact surface, scaled about its corner.
#[test]
fn least_squares_of_what_is_integrable() {
    for case in 0..60 {
        let surface = any_surface(case);
        let [u, v] = surface_alpha_spaces(&surface).unwrap();
        let (u0, v0) = (surface.u().domain().0, surface.v().domain().0);
        let start = surface.point(u0, v0).unwrap();
        for c in [1.0, 0.4, 1.7] {
            let alpha = net([&u, &v], |_, _| c);
            let tuned =
                FineTuneSurface::new(&surface, Scaling::both(alpha)).ends(Ends::Free).solve().unwrap();
            for (u, v) in places(&surface) {
                let expected = start + (surface.point(u, v).unwrap() - start) * c;
                let off = (tuned.surface().point(u, v).unwrap() - expected).norm() / size(&surface);
                assert!(off <= 1e-10, "{case} {c} at {u} {v}: {off:e}");
            }
            assert!(tuned.report().residual.unwrap() <= 1e-10, "{case} {:?}", tuned.report());
            assert_eq!(tuned.surface().u().is_periodic(), surface.u().is_periodic());
            assert_eq!(tuned.surface().v().is_periodic(), surface.v().is_periodic());
        }
    }
}

/// Gauss's rule on [0, 1]: Newton's method on the Legendre polynomial.
fn gauss(n: usize) -> Vec<(f64, f64)> {
    let at = |x: f64| {
        let (mut p, mut q) = (1.0, 0.0);
        for k in 1..=n {
            let k = k as f64;
            (p, q) = (((2.0 * k - 1.0) * x * p - (k - 1.0) * q) / k, p);
        }
        (p, n as f64 * (x * p - q) / (x * x - 1.0))
    };
    let node = |i: usize| {
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        (0..20).for_each(|_| x -= at(x).0 / at(x).1);
        (0.5 + 0.5 * x, 1.0 / ((1.0 - x * x) * at(x).1.powi(2)))
    };
    (0..n).map(node).collect()
}

/// `∫∫ |D_u - αS_u|² + |D_v - αS_v|²`, by Gauss's rule with eight points a span, which is exact to degree 15.
fn energy(given: &Surface, tuned: &Surface, alpha: &Field<f64>) -> f64 {
    let rule_of_8 = gauss(8);
    let rule = |space: &Space| {
        let each = space.breakpoints();
        let pairs = each.windows(2).flat_map(|w| {
            let (a, h) = (w[0], w[1] - w[0]);
            rule_of_8.iter().map(move |(x, w)| (a + h * x, h * w))
        });
        pairs.collect::<Vec<_>>()
    };
    let mut sum = 0.0;
    let in_v = rule(tuned.v());
    for (u, w) in rule(tuned.u()) {
        for (v, y) in &in_v {
            let a = alpha.value(u, *v).unwrap();
            for direction in [U, V] {
                let off = slope(tuned, direction, (u, *v)) - slope(given, direction, (u, *v)) * a;
                sum += w * y * off.norm_squared();
            }
        }
    }
    sum
}

/// No direction in which vertices may move makes the sum of squares smaller, and it is the one that is reported.
#[test]
fn least_squares_are_least() {
    let mut done = 0;
    for case in 0..60 {
        let (surface, mut random) = (any_surface(case), Lcg::new(case + 6000));
        if surface.u().degree() > 3 || surface.v().degree() > 3 {
            continue;
        }
        let values = |n: usize, random: &mut Lcg| (0..n).map(|_| 0.5 + random.next()).collect::<Vec<_>>();
        let [u, v] = surface_alpha_spaces(&surface).unwrap();
        let alpha = surface_alpha_of(&surface, values(u.len() * v.len(), &mut random)).unwrap();
        let ends = [Ends::Free, Ends::Position, Ends::Tangent, Ends::Curvature][random.below(4)];
        let Ok(tuned) = FineTuneSurface::new(&surface, Scaling::both(alpha.clone())).ends(ends).solve()
        else {
            continue;
        };
        done += 1;
        let own = tuned.surface();
        let whole = raised(&surface, own);
        let kept = match ends {
            Ends::Position => 1,
            Ends::Tangent => 2,
            Ends::Curvature => 3,
            _ => 0,
        };
        let (rows, columns) = (own.u().len(), own.v().len());
        let of_u = if own.u().is_periodic() { 0 } else { kept };
        let of_v = if own.v().is_periodic() { 0 } else { kept };
        let edge = |k: usize, of: usize, kept: usize| k < kept || k + kept >= of;
        let is_kept = |k: usize| edge(k / columns, rows, of_u) || edge(k % columns, columns, of_v);
        // A closed direction may be numbered from elsewhere.
        let numbered = whole.u() == own.u() && whole.v() == own.v();
        for k in (0..rows * columns).filter(|k| numbered && is_kept(*k)) {
            assert!((own.points()[k] - whole.points()[k]).norm() <= 1e-12 * size(&surface), "{case} {k}");
        }
        let least = energy(&surface, own, &alpha);
        let all = energy(
            &surface,
            &Surface::new(own.u().clone(), own.v().clone(), vec![Point::origin(); rows * columns]).unwrap(),
            &alpha,
        );
        let reported = tuned.report().residual.unwrap();
        assert!(
            ((least / all).sqrt() - reported).abs() <= 1e-9,
            "{case}: {} {reported}",
            (least / all).sqrt()
        );
        for _ in 0..3 {
            let step: Vec<Vector> = (0..rows * columns)
                .map(|k| {
                    let way = Vector::new(random.next(), random.next(), random.next()) - Vector::repeat(0.5);
                    if is_kept(k) { Vector::zeros() } else { way * size(&surface) }
                })
                .collect();
            let moved = |by: f64| {
                let points = own.points().iter().zip(&step).map(|(p, s)| p + s * by).collect();
                energy(&surface, &Surface::new(own.u().clone(), own.v().clone(), points).unwrap(), &alpha)
            };
            // A parabola: its slope at 0 against its curvature.
            let (ahead, behind) = (moved(1e-2), moved(-1e-2));
            let (slope, bend) = ((ahead - behind) / 2.0, (ahead + behind) / 2.0 - least);
            assert!(
                slope.abs() <= 1e-9 * (bend * least.max(1e-6 * all)).sqrt().max(bend),
                "{case} {ends:?}: {slope:e} {bend:e} {least:e}"
            );
        }
    }
    assert!(done >= 12, "{done}");
}

/// One similarity where all lines want the same: a cone from its tip, and a strip of straight lines; elsewhere refused.
#[test]
fn edges_kept_by_a_similarity() {
    let (u, v) = (Space::clamped_uniform(3, 7).unwrap(), Space::clamped_uniform(3, 6).unwrap());
    let at = |i: u32, j: u32| {
        let (r, a) = (f64::from(i) + 0.1 * f64::from(i * i), 0.3 * f64::from(j));
        Point::new(r * a.cos(), r * a.sin(), 2.0 * r)
    };
    let points = (0..7).flat_map(|i| (0..6).map(move |j| at(i, j))).collect();
    let cone = Surface::new(u.clone(), v.clone(), points).unwrap();
    let mut random = Lcg::new(3);
    let alpha = any_line(&cone, U, &mut random);
    let tuned = FineTuneSurface::new(&cone, Scaling::u(alpha.clone())).ends(Ends::Position).solve().unwrap();
    for k in 0..=10 {
        let v = 0.3 * f64::from(k);
        for u in [0.0, 4.0] {
            let off = tuned.surface().point(u, v).unwrap() - cone.point(u, v).unwrap();
            assert!(off.norm() <= 1e-9, "{off}");
        }
        let expected = slope(&cone, U, (1.3, v)) * alpha.value(1.3).unwrap() * tuned.report().scale[0];
        assert!((slope(tuned.surface(), U, (1.3, v)) - expected).norm() <= 1e-9);
    }
    let wild = shaped(u, v, &mut random);
    for ends in [Ends::Position, Ends::Tangent, Ends::Curvature] {
        let tuning = FineTuneSurface::new(&wild, Scaling::u(any_line(&wild, U, &mut random)));
        let error = tuning.ends(ends).solve().unwrap_err().to_string();
        assert!(error.contains("different rotations") && error.contains("exact"), "{error}");
    }
}

#[test]
fn what_cannot_be_is_refused_in_words() {
    let mut random = Lcg::new(7);
    let (u, v) = (Space::clamped_uniform(3, 7).unwrap(), Space::clamped_uniform(2, 6).unwrap());
    let surface = shaped(u.clone(), v.clone(), &mut random);
    let text = |result: Result<TunedSurface, FineTuneError>| result.unwrap_err().to_string();
    let error = surface_alpha_of(&surface, vec![1.0; 31]).unwrap_err().to_string();
    assert!(error.contains("31 values and needs 6 × 5"), "{error}");
    let line = any_line(&surface, U, &mut random);
    let mut values = vec![1.0; 30];
    values[13] = -0.5;
    let negative = surface_alpha_of(&surface, values).unwrap();
    let error = text(FineTuneSurface::new(&surface, Scaling::along(U, negative.clone())).solve());
    assert!(error.contains("α is -0.5 at value [2, 3]"), "{error}");
    let allowed = FineTuneSurface::new(&surface, Scaling::along(U, negative)).any_sign().ends(Ends::Free);
    assert!(allowed.solve().is_ok());
    let rational = Surface::rational(u.clone(), v.clone(), surface.points().to_vec(), vec![1.0; 42]).unwrap();
    let error = text(FineTuneSurface::new(&rational, Scaling::u(line.clone())).solve());
    assert!(error.contains("rational surface"), "{error}");
    let far = Function::constant(Space::clamped(2, &[0.0, 1.0]).unwrap(), 2.0).unwrap();
    let error = text(FineTuneSurface::new(&surface, Scaling::u(far)).solve());
    assert!(error.contains("over u in [0, 1]"), "{error}");
    let smooth = any_net(&surface, [4, 4], [2, 2], &mut random);
    for (a, b) in [(3.0, 2.0), (-1.0, 2.0), (2.0, 99.0), (f64::NAN, 2.0), (2.0, 2.0)] {
        let tuning = FineTuneSurface::new(&surface, Scaling::along(U, smooth.clone())).between(V, a, b);
        assert!(text(tuning.solve()).contains("is not within [0, 4]"));
    }
    let error = text(FineTuneSurface::new(&surface, Scaling::u(line.clone())).between(V, 1.0, 3.0).solve());
    assert!(error.contains("moves the sides"), "{error}");
    let tuning = FineTuneSurface::new(&surface, Scaling::along(U, smooth)).between(U, 1.0, 3.0);
    let error = text(tuning.clone().ends(Ends::Free).solve());
    assert!(error.contains("torn off"), "{error}");
    let error = text(tuning.between(V, 1.0, 3.0).ends(Ends::Position).solve());
    assert!(error.contains("similarity"), "{error}");
    let jumps = any_net(&surface, [4, 4], [2, 0], &mut random);
    let error = text(FineTuneSurface::new(&surface, Scaling::along(U, jumps)).ends(Ends::Free).solve());
    assert!(error.contains("α jumps at v = 1"), "{error}");
    let high = any_net(&surface, [1, 1], [23, 1], &mut random);
    let error = text(FineTuneSurface::new(&surface, Scaling::along(U, high)).ends(Ends::Free).solve());
    assert!(error.contains("degree 26"), "{error}");
    let high = any_net(&surface, [1, 1], [1, 24], &mut random);
    let error = text(FineTuneSurface::new(&surface, Scaling::along(U, high)).ends(Ends::Free).solve());
    assert!(error.contains("26"), "{error}");
    // Two rows of three and nothing between.
    let small = surface_alpha_of(&surface, vec![1.5; 30]).unwrap();
    let tuning = FineTuneSurface::new(&surface, Scaling::both(small)).between(U, 0.1, 0.2).continuity(2);
    let error = text(tuning.solve());
    assert!(error.contains("none would be free"), "{error}");
    let ring = shaped(Space::periodic_uniform(3, 7).unwrap(), v, &mut random);
    let error = text(
        FineTuneSurface::new(&ring, Scaling::u(any_line(&ring, U, &mut random))).ends(Ends::Position).solve(),
    );
    assert!(error.contains("are one point"), "{error}");
}

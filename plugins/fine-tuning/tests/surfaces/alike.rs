//! Surfaces whose lines want one rotation and one scale: extruded, moved along a curve, moved and made larger; their ends stay by `D_u = s R α S_u`.

use loftsman_fine_tuning::{Ends, FineTuneSurface, Scaling};
use loftsman_kernel::spline::Direction::{self, U, V};
use loftsman_kernel::spline::{Space, Surface};
use loftsman_kernel::{Point, Vector};
use nalgebra::Rotation3;

use super::family::{Lcg, any_line, any_net, any_surface, inside, places, size, slope};

/// `S(u, v) = h(v) C(u) + E(v)`, with `h = 1` where it is not grown.
fn moved(case: u64, random: &mut Lcg) -> Surface {
    let mut clamped = || {
        let degree = 1 + random.below(7);
        Space::clamped_uniform(degree, degree + 3 + random.below(5)).unwrap()
    };
    let (u, v) = (clamped(), clamped());
    let scale = [1.0, 1.0, 1e-9, 1e9][random.below(4)];
    let line = |space: &Space, random: &mut Lcg| -> Vec<Vector> {
        let mut noise = || random.next() - 0.5;
        (0..space.len()).map(|i| Vector::new(i as f64 + noise(), 2.0 * noise(), noise())).collect()
    };
    let (profile, way) = (line(&u, random), line(&v, random));
    let grown: Vec<f64> = way.iter().map(|_| if case % 3 == 2 { 0.5 + random.next() } else { 1.0 }).collect();
    let along = Vector::new(0.2, 1.0, -0.4);
    let at = |c: &Vector, j: usize| {
        let by =
            if case.is_multiple_of(3) { along * j as f64 } else { Vector::new(way[j].y, way[j].x, way[j].z) };
        Point::from((c * grown[j] + by) * scale)
    };
    let points =
        profile.iter().flat_map(|c| (0..v.len()).map(move |j| (c, j))).map(|(c, j)| at(c, j)).collect();
    Surface::new(u, v, points).unwrap()
}

fn turned(surface: &Surface) -> Surface {
    let (n, m) = (surface.u().len(), surface.v().len());
    let points = (0..m).flat_map(|j| (0..n).map(move |i| (i, j))).map(|(i, j)| surface.points()[i * m + j]);
    Surface::new(surface.v().clone(), surface.u().clone(), points.collect()).unwrap()
}

#[test]
fn ends_stay_by_one_rotation_and_one_scale() {
    let mut too_few = 0;
    for case in 0..60 {
        let mut random = Lcg::new(case + 500);
        let (own, direction) = (moved(case, &mut random), if case % 2 == 0 { U } else { V });
        let surface = if direction == U { own } else { turned(&own) };
        let alpha = any_line(&surface, direction, &mut random);
        let scaling = match direction {
            U => Scaling::u(alpha.clone()),
            V => Scaling::v(alpha.clone()),
        };
        for (fixed, ends) in [Ends::Position, Ends::Tangent, Ends::Curvature].into_iter().enumerate() {
            let tuning = FineTuneSurface::new(&surface, scaling.clone());
            let tuned = match tuning.ends_along(direction, ends).solve() {
                Ok(tuned) => tuned,
                Err(error) => {
                    assert!(error.to_string().contains("too few"), "{case} {ends:?}: {error}");
                    too_few += 1;
                    continue;
                }
            };
            let k = if direction == U { 0 } else { 1 };
            let scale = tuned.report().scale[k];
            assert!(scale > 0.1 && scale < 10.0 && (scale - 1.0).abs() > 1e-6, "{case} {ends:?}: {scale}");
            let tuned = tuned.surface();
            ends_are_kept(&surface, tuned, direction, fixed, case);
            if fixed == 0 {
                lines_are_similar(&surface, tuned, direction, &|t| scale * alpha.value(t).unwrap(), case);
            }
        }
    }
    assert!(too_few < 20, "{too_few}");
}

/// Points, with more rows first and second derivatives across the edges, are the given ones.
fn ends_are_kept(given: &Surface, tuned: &Surface, direction: Direction, orders: usize, case: u64) {
    let (space, across) =
        (given.space(direction), if direction == U { given.space(V) } else { given.space(U) });
    let (a, b) = space.domain();
    for order in 0..=orders.min(space.degree()) {
        let of = |surface: &Surface, end: f64, t: f64| {
            let at = if direction == U { (end, t) } else { (t, end) };
            let (p, q) = if direction == U { (order, 0) } else { (0, order) };
            surface.derivative(at.0, at.1, p, q).unwrap()
        };
        for t in inside(across) {
            for end in [a, b] {
                let (was, is) = (of(given, end, t), of(tuned, end, t));
                let whole = size(given) * 50_f64.powi(order as i32);
                assert!(
                    (was - is).norm() <= 1e-11 * whole,
                    "{case} {direction:?} {order} at {end}: {was} {is}"
                );
            }
        }
    }
}

/// `D_u = s α R S_u` for one rotation: lengths, and angles between any two of them.
fn lines_are_similar(
    given: &Surface,
    tuned: &Surface,
    direction: Direction,
    factor: &dyn Fn(f64) -> f64,
    case: u64,
) {
    let all: Vec<(Vector, Vector)> = places(given)
        .into_iter()
        .map(|at| {
            let by = factor(if direction == U { at.0 } else { at.1 });
            (slope(given, direction, at) * by, slope(tuned, direction, at))
        })
        .collect();
    let largest = all.iter().fold(0.0_f64, |m, (a, _)| m.max(a.norm()));
    for (k, (a, b)) in all.iter().enumerate() {
        let (c, d) = all[(7 * k + 3) % all.len()];
        assert!((a.norm() - b.norm()).abs() <= 1e-10 * largest, "{case}: {a} {b}");
        assert!((a.dot(&c) - b.dot(&d)).abs() <= 1e-10 * largest * largest, "{case}: {a} {b}");
    }
}

/// Twice as fast everywhere, an extrusion comes back as it was, to half its size made and back: no rotation, a scale of 2.
#[test]
fn a_constant_alpha_gives_the_surface_back() {
    let mut random = Lcg::new(1);
    let surface = moved(0, &mut random);
    let alpha = any_line(&surface, U, &mut random);
    let half = loftsman_kernel::spline::algebra::Function::constant(alpha.space().clone(), 0.5).unwrap();
    for ends in [Ends::Position, Ends::Tangent, Ends::Curvature] {
        let Ok(tuned) = FineTuneSurface::new(&surface, Scaling::u(half.clone())).ends_along(U, ends).solve()
        else {
            assert_ne!(ends, Ends::Position);
            continue;
        };
        if ends == Ends::Position {
            assert!((tuned.report().scale[0] - 2.0).abs() < 1e-12, "{}", tuned.report().scale[0]);
            let off = super::family::distance(&surface, tuned.surface());
            assert!(off <= 1e-12 * size(&surface), "{off:e}");
        }
    }
}

/// To turn, to move and to scale commutes with every kind of ends, of surfaces of all kinds and of those whose lines are alike; refusals are the same.
#[test]
fn similarities_commute_with_every_kind_of_ends() {
    let (mut done, mut refused) = (0, 0);
    for case in 0..60 {
        let mut random = Lcg::new(case + 1300);
        let alike = case % 2 == 1;
        let surface = if alike { moved(case, &mut random) } else { any_surface(case) };
        let turn = Rotation3::from_euler_angles(0.3 + case as f64, -1.1, 2.0);
        let by = Vector::new(3.0, -2.0, 1.0) * size(&surface);
        let factor = [1.0, 1e-6, 1e6][case as usize % 3];
        let to = |p: &Point| Point::from((turn * p.coords + by) * factor);
        let points = surface.points().iter().map(to).collect();
        let other = Surface::new(surface.u().clone(), surface.v().clone(), points).unwrap();
        let line = any_line(&surface, U, &mut random);
        let many = 3 * (surface.v().degree() + 1) * (surface.v().breakpoints().len() - 1) + 5;
        let net = any_net(&surface, [many.min(40), 3], [1, 1], &mut random);
        for (k, ends) in
            [Ends::Exact, Ends::Free, Ends::Position, Ends::Tangent, Ends::Curvature].into_iter().enumerate()
        {
            let scaling = if k == 0 { Scaling::along(U, net.clone()) } else { Scaling::u(line.clone()) };
            let tuned = |surface: &Surface| {
                FineTuneSurface::new(surface, scaling.clone()).ends_along(U, ends).any_sign().solve()
            };
            match (tuned(&surface), tuned(&other)) {
                (Ok(one), Ok(two)) => {
                    done += 1;
                    // What rounding ill-conditioned equations make larger.
                    let condition = one.report().solved[0].as_ref().map_or(1.0, |solved| solved.condition);
                    let digits = (f64::EPSILON * condition).max(1e-9);
                    for (u, v) in places(&surface) {
                        let expected = to(&one.surface().point(u, v).unwrap());
                        let off = (two.surface().point(u, v).unwrap() - expected).norm() / size(&other);
                        assert!(off < digits, "{case} {ends:?}: {off:e} at {u} {v}, condition {condition:e}");
                    }
                }
                (Err(_), Err(_)) => refused += 1,
                (one, two) => panic!("{case} {ends:?}: {:?} {:?}", one.err(), two.err()),
            }
        }
    }
    println!("{done} done, {refused} refused");
    assert!(done >= 150, "{done} done, {refused} refused");
}

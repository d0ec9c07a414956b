//! Each line scaled: derivatives, curvatures, constants, rigid motions.

use loftsman_fine_tuning::{Ends, FineTuneSurface, Scaling, surface_alpha_spaces};
use loftsman_kernel::Vector;
use loftsman_kernel::spline::Direction::{U, V};
use loftsman_kernel::spline::algebra::Function;
use loftsman_kernel::spline::{Space, Surface};
use nalgebra::Rotation3;

use super::family::*;

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

/// A surface that is closed both ways stays so with free ends where α lets it (a constant, and what is scaled the other way only), and opens where it does not.
#[test]
fn what_closes_by_itself_stays_closed() {
    let mut random = Lcg::new(77);
    let mut opened = 0;
    for (p, q) in [(2, 2), (3, 2), (3, 3), (4, 5)] {
        let ring = |degree: usize, n: usize| Space::periodic_uniform(degree, n).unwrap();
        let surface = shaped(ring(p, 9), ring(q, 8), &mut random);
        for factor in [0.5, 1.0, 3.0] {
            let [u, v] = surface_alpha_spaces(&surface).unwrap();
            let constants = [
                Scaling::u(Function::constant(u, factor).unwrap()),
                Scaling::v(Function::constant(v, factor).unwrap()),
            ];
            for scaling in constants {
                let tuned = free(&surface, scaling);
                assert!(tuned.u().is_periodic() && tuned.v().is_periodic(), "{p} {q} {factor}");
                let near = tuned.u().domain().1 - 1e-9;
                let (before, after) =
                    (tuned.point(near, 0.3).unwrap(), tuned.point(tuned.u().domain().0, 0.3).unwrap());
                assert!((before - after).norm() < 1e-6 * size(&surface), "{p} {q} {factor}");
            }
        }
        let alpha = any_line(&surface, U, &mut random);
        let tuned = free(&surface, Scaling::u(alpha.clone()));
        assert_scaled(&surface, &tuned, U, &|u, _| alpha.value(u).unwrap(), p as u64);
        assert!(tuned.v().is_periodic());
        opened += usize::from(!tuned.u().is_periodic());
    }
    assert_eq!(opened, 4);
}

/// A tube whose α along its closed direction ends with another value than it starts with: the factor by which its curvature jumps is told, and measured. Where
/// α is periodic, or the other direction is scaled, nothing is.
#[test]
fn a_jump_at_the_seam_of_a_surface_is_told() {
    let (u, v) = (Space::periodic_uniform(3, 10).unwrap(), Space::clamped_uniform(3, 5).unwrap());
    let points = (0..50).map(|k| {
        let a = f64::from(k / 5) / 10.0 * std::f64::consts::TAU;
        loftsman_kernel::Point::new(3.0 * a.cos(), 2.0 * a.sin(), f64::from(k % 5) + 0.1 * (2.0 * a).sin())
    });
    let surface = Surface::new(u, v, points.collect()).unwrap();
    let (a, b) = surface.u().domain();
    let knots: Vec<f64> = (0..=8).map(|k| a + (b - a) * f64::from(k) / 8.0).collect();
    let open = Space::clamped(2, &knots).unwrap();
    let rising = (0..open.len()).map(|k| 0.7 + 0.06 * k as f64).collect();
    let alpha = Function::new(open, rising).unwrap();
    let tuned = FineTuneSurface::new(&surface, Scaling::u(alpha)).solve().unwrap();
    assert!(tuned.surface().u().is_periodic());
    let bend = |at: f64| {
        let [first, second] = [1, 2].map(|order| tuned.surface().derivative(at, 0.3, order, 0).unwrap());
        first.cross(&second).norm() / first.norm().powi(3)
    };
    let own = bend(a + 1e-7) / bend(b - 1e-7);
    let jumps = |notes: &[String]| notes.iter().find(|note| note.contains("jumps there")).cloned();
    let note = jumps(&tuned.report().notes).unwrap();
    let told: f64 = note.split("up to ").nth(1).unwrap().split(';').next().unwrap().parse().unwrap();
    assert!((told - own).abs() < 1e-3 * own && (own - 1.0).abs() > 0.05, "{note} {own}");
    let [u, v] = surface_alpha_spaces(&surface).unwrap();
    let waves = |space: &Space| (0..space.len()).map(|k| 1.0 + 0.1 * (k as f64).sin()).collect();
    let smooth = [
        Scaling::u(Function::new(u.clone(), waves(&u)).unwrap()),
        Scaling::v(Function::new(v.clone(), waves(&v)).unwrap()),
    ];
    for scaling in smooth {
        let tuned = FineTuneSurface::new(&surface, scaling).solve().unwrap();
        assert_eq!(jumps(&tuned.report().notes), None);
    }
}

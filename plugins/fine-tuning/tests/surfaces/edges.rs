//! Edges that stay: exactly, by a change of α, or by a similarity.

use loftsman_fine_tuning::{Ends, FineTuneError, FineTuneSurface, Scaling, surface_alpha_spaces};
use loftsman_kernel::spline::Direction::{U, V};
use loftsman_kernel::spline::algebra::{Field, Function};
use loftsman_kernel::spline::{Space, Surface};
use loftsman_kernel::{Point, Vector};
use nalgebra::Rotation3;

use super::family::*;

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
    let profile: Vec<Vector> = (0..9).map(f64::from).map(|x| Vector::new(x, (0.9 * x).sin(), 0.0)).collect();
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
    // Between the corners an edge moves, and that is said; not where one direction is tuned.
    let edge = tuned.surface().point(3.0, 0.0).unwrap() - extruded.point(3.0, 0.0).unwrap();
    assert!(
        edge.norm() > 1e-3
            && tuned.report().notes.iter().any(|note| note.contains("edge is tuned along itself"))
    );
    let alpha = any_line(&extruded, U, &mut random);
    let one = FineTuneSurface::new(&extruded, Scaling::u(alpha)).solve().unwrap();
    assert!(!one.report().notes.iter().any(|note| note.contains("edge")));
    let wild = shaped(u, v, &mut random);
    let error = FineTuneSurface::new(&wild, Scaling::u(any_line(&wild, U, &mut random))).solve().unwrap_err();
    assert!(matches!(error, FineTuneError::Edges { equations: 8, values: 8, .. }), "{error}");
    assert!(error.to_string().contains("α(u, v)"), "{error}");
    // α = 1 keeps what it keeps.
    let one = Function::constant(surface_alpha_spaces(&wild).unwrap()[0].clone(), 1.0).unwrap();
    let same = FineTuneSurface::new(&wild, Scaling::u(one)).solve().unwrap();
    assert!(distance(&wild, same.surface()) <= 1e-13 * size(&wild));
}

/// One rotation and scale where all lines want the same: a cone from its tip, and a strip of straight lines; elsewhere refused.
#[test]
fn edges_kept_by_one_turn_and_scale() {
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

fn inner(one: &Field<f64>, other: &Field<f64>) -> f64 {
    one.times(other).unwrap().total().unwrap()
}

/// The change of α is the least in `∫∫ (Δα)²`: orthogonal to the way to any other α that keeps the edges.
#[test]
fn the_change_of_alpha_is_least() {
    for case in 0..40 {
        let (surface, mut random) = (any_surface(case), Lcg::new(case + 7000));
        let many = 3 * (surface.v().degree() + 1) * (surface.v().breakpoints().len() - 1) + 5;
        let mut tuned = || {
            let asked = any_net(&surface, [many.min(40), 3], [1, 1], &mut random);
            let tuning = FineTuneSurface::new(&surface, Scaling::along(U, asked.clone())).any_sign();
            let tuned = tuning.solve().unwrap();
            let Scaling::Along { alpha, .. } = tuned.scaling().clone() else { panic!("another scaling") };
            (asked, alpha, tuned.report().solved[0].as_ref().map_or(1.0, |solved| solved.condition))
        };
        let ((asked, found, condition), (_, other, _)) = (tuned(), tuned());
        let (change, way) = (found.plus(-1.0, &asked).unwrap(), other.plus(-1.0, &found).unwrap());
        let lengths = (inner(&change, &change) * inner(&way, &way)).sqrt();
        let cosine = inner(&change, &way) / lengths;
        // What equations leave of rounding their multipliers make as much larger as these are ill-conditioned.
        let rounding = f64::EPSILON * condition;
        assert!(cosine.abs() <= rounding.max(1e-9), "{case}: {cosine:e}, condition {condition:e}");
    }
}

/// α that would have to be negative is held above zero, and the edges stay all the same.
#[test]
fn alpha_stays_positive() {
    let mut bounded = 0;
    for case in 0..30 {
        let (surface, mut random) = (any_surface(case), Lcg::new(case + 8000));
        let many = 3 * (surface.v().degree() + 1) * (surface.v().breakpoints().len() - 1) + 5;
        let even = any_net(&surface, [many.min(40), 3], [1, 1], &mut random);
        // Nearly nothing at the start, much at the end.
        let (u0, u1) = surface.u().domain();
        let space = even.space(U);
        let columns = even.space(V).len();
        let value = |k: usize| {
            let s = (space.greville(k / columns) - u0) / (u1 - u0);
            if s.rem_euclid(1.0) < 0.5 { 0.02 } else { 3.0 + 2.0 * random.next() }
        };
        let values = (0..even.coefficients().len()).map(value).collect();
        let asked = Field::new(space.clone(), even.space(V).clone(), values).unwrap();
        let Ok(tuned) = FineTuneSurface::new(&surface, Scaling::along(U, asked)).solve() else { continue };
        assert!(tuned.report().alpha[0][0] > 0.0, "{case}");
        bounded += usize::from(tuned.report().solved[0].as_ref().is_some_and(|r| !r.active.is_empty()));
        for v in inside(tuned.surface().v()) {
            let off = tuned.surface().point(u1, v).unwrap() - surface.point(u1, v).unwrap();
            assert!(off.norm() <= 1e-12 * size(&surface), "{case}: {:e}", off.norm() / size(&surface));
        }
    }
    assert!(bounded >= 3, "{bounded}");
}

/// A plane surface in any position has fewer equations, found by their rank; and the same input gives the same bytes.
#[test]
fn turned_planes() {
    let turn = Rotation3::from_euler_angles(0.4, 1.3, -2.0);
    let by = Vector::new(1.0, -5.0, 2.0);
    for case in 0..20 {
        let (surface, mut random) = (any_surface(case), Lcg::new(case + 9000));
        let flat = surface.points().iter().map(|p| Vector::new(p.x, p.y, 0.0));
        let points = flat.map(|p| Point::from(turn * p + by * size(&surface))).collect();
        let plane = Surface::new(surface.u().clone(), surface.v().clone(), points).unwrap();
        let many = 3 * (surface.v().degree() + 1) * (surface.v().breakpoints().len() - 1) + 5;
        let asked = any_net(&surface, [many.min(40), 3], [1, 1], &mut random);
        let tuning = FineTuneSurface::new(&plane, Scaling::along(U, asked));
        let (tuned, again) = (tuning.solve().unwrap(), tuning.solve().unwrap());
        assert_eq!(tuned.surface(), again.surface());
        for v in inside(tuned.surface().v()) {
            for u in [plane.u().domain().0, plane.u().domain().1] {
                let off = tuned.surface().point(u, v).unwrap() - plane.point(u, v).unwrap();
                assert!(off.norm() <= 1e-12 * size(&plane), "{case}");
            }
        }
        let flat =
            tuned.surface().points().iter().map(|p| (turn.inverse() * (p.coords - by * size(&surface))).z);
        assert!(flat.fold(0.0_f64, |m, z| m.max(z.abs())) <= 1e-12 * size(&plane), "{case}");
    }
}

/// One direction exact, the other free: edges across the first stay on their lines of the surface that is scaled along the other.
#[test]
fn ends_of_each_direction() {
    let mut random = Lcg::new(17);
    let (u, v) = (Space::clamped_uniform(2, 6).unwrap(), Space::clamped_uniform(3, 6).unwrap());
    let at = |i: u32, j: u32| Point::new(f64::from(i * i), f64::from(j), f64::from(j * j % 5));
    let points = (0..6).flat_map(|i| (0..6).map(move |j| at(i, j))).collect();
    let surface = Surface::new(u, v, points).unwrap();
    let (alpha, beta) = (any_line(&surface, U, &mut random), any_line(&surface, V, &mut random));
    let both = FineTuneSurface::new(&surface, Scaling::u_and_v(alpha, beta.clone()));
    let tuned = both.ends_along(V, Ends::Free).solve().unwrap();
    assert!(tuned.report().solved[0].is_some() && tuned.report().solved[1].is_none());
    let across = free(&surface, Scaling::v(beta));
    for v in inside(surface.v()) {
        for u in [surface.u().domain().0, surface.u().domain().1] {
            let off = tuned.surface().point(u, v).unwrap() - across.point(u, v).unwrap();
            assert!(off.norm() <= 1e-12 * size(&surface));
        }
    }
}

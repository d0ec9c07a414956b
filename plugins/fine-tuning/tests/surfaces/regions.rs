//! Parts of surfaces: outside not a bit moves, and on the border it is as smooth as asked.

use loftsman_fine_tuning::{Ends, FineTuneSurface, Scaling};
use loftsman_kernel::Point;
use loftsman_kernel::spline::Direction::{U, V};
use loftsman_kernel::spline::algebra::{Field, Function};
use loftsman_kernel::spline::{Space, Surface};

use super::family::*;

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

/// Bands across one direction only: by α(u) where all lines are of one kind, by α(u, v) with free ends, and around a whole period.
#[test]
fn bands() {
    let (u, v) = (Space::clamped_uniform(3, 12).unwrap(), Space::clamped_uniform(2, 5).unwrap());
    let at = |i: u32, j: u32| Point::new(f64::from(i), f64::from(i).sin(), f64::from(j * j));
    let points = (0..12).flat_map(|i| (0..5).map(move |j| at(i, j))).collect();
    let extruded = Surface::new(u, v, points).unwrap();
    let breakpoints: Vec<f64> = (0..=20).map(|i| 1.5 + f64::from(i) / 4.0).collect();
    let space = Space::clamped(2, &breakpoints).unwrap();
    let values = (0..space.len()).map(|k| 1.0 + 0.4 * (k as f64).cos()).collect();
    let alpha = Function::new(space, values).unwrap();
    let tuned = FineTuneSurface::new(&extruded, Scaling::u(alpha)).between(U, 1.5, 6.5).solve().unwrap();
    assert_eq!(tuned.surface().v(), extruded.v());
    let whole = raised(&extruded, tuned.surface());
    for (u, v) in [(0.3, 0.1), (1.4, 2.9), (6.6, 1.0), (8.9, 3.0)] {
        assert_eq!(whole.point(u, v).unwrap(), tuned.surface().point(u, v).unwrap());
    }
    assert!(distance(&extruded, tuned.surface()) > 1e-3);

    let mut random = Lcg::new(11);
    for case in 0..30 {
        let surface = any_surface(case);
        let (v0, v1) = surface.v().domain();
        let (a, b) = (v0 + 0.2 * (v1 - v0), v0 + 0.7 * (v1 - v0));
        let part = surface.between(V, a, b).unwrap();
        let alpha = any_net(&part, [4, 8], [2, 2], &mut random);
        let tuning =
            FineTuneSurface::new(&surface, Scaling::along(U, alpha)).between(V, a, b).ends(Ends::Free);
        if surface.u().is_periodic() {
            // Free ends open it, and the rest is closed.
            assert!(tuning.solve().is_err(), "{case}");
            continue;
        }
        let tuned = tuning.solve().unwrap();
        let (own, (u0, u1)) = (tuned.surface(), surface.u().domain());
        for s in [0.0, 0.13, 0.5, 0.77, 1.0] {
            let u = u0 + s * (u1 - u0);
            for t in [0.0, 0.1, 0.2, 0.7, 0.8, 0.9] {
                let v = v0 + t * (v1 - v0);
                let off = (own.point(u, v).unwrap() - surface.point(u, v).unwrap()).norm();
                assert!(off <= 1e-12 * size(&surface), "{case} {u} {v} {off:e}");
            }
        }
        assert!(distance(own, &surface) > 1e-4 * size(&surface), "{case}");
    }
}

/// A region that is all of a period, said as one: closed, and at the seam as smooth as asked.
#[test]
fn a_whole_period() {
    let mut done = 0;
    for case in 0..60 {
        let (surface, mut random) = (any_surface(case), Lcg::new(case + 300));
        let (start, end) = surface.u().domain();
        if !surface.u().is_periodic() || surface.u().multiplicity(start) > 1 || surface.u().degree() < 3 {
            continue;
        }
        let part = surface.between(U, start, end).unwrap();
        let alpha = any_net(&part, [40, 3], [2, 1], &mut random);
        let tuned =
            FineTuneSurface::new(&surface, Scaling::along(U, alpha)).between(U, start, end).solve().unwrap();
        let own = tuned.surface();
        assert!(own.u().is_periodic());
        for v in inside(own.v()) {
            for order in 0..3 {
                let of = |s: &Surface| s.derivative(start, v, order, 0).unwrap();
                let off = (of(own) - of(&surface)).norm();
                assert!(off <= [1e-12, 1e-9, 1e-6][order] * size(&surface), "{case} {order} {off:e}");
            }
        }
        done += 1;
    }
    assert!(done >= 3, "{done}");
}

/// A part that reaches an edge of the surface joins nothing there: α is no more held there than that of the whole surface, so that it changes less; asked for,
/// derivatives stay there, too, also along all of a direction.
#[test]
fn at_the_edges_of_the_surface_nothing_joins() {
    let mut lower = 0;
    for case in 0..30 {
        let mut random = Lcg::new(case + 900);
        let (p, q) = (2 + random.below(3), 1 + random.below(3));
        let (u, v) = (Space::clamped_uniform(p, p + 4).unwrap(), Space::clamped_uniform(q, q + 3).unwrap());
        let surface = shaped(u, v, &mut random);
        let (a, b) = surface.u().domain();
        let (c, d) = surface.v().domain();
        let (to, side) = (a + 0.7 * (b - a), c + 0.6 * (d - c));
        let patch = surface.between(U, a, to).unwrap().between(V, c, side).unwrap();
        let many = (3 * (q + 1) * (patch.v().breakpoints().len() - 1)).min(36) + 8;
        let alpha = any_net(&patch, [many, 9], [3, 3], &mut random);
        let part = FineTuneSurface::new(&surface, Scaling::along(U, alpha.clone()));
        let part = part.between(U, a, to).between(V, c, side).any_sign();
        let (Ok(own), Ok(held)) = (part.clone().solve(), part.continuity(2).solve()) else { continue };
        let Scaling::Along { alpha: found, .. } = own.scaling() else { panic!("another scaling") };
        let Scaling::Along { alpha: kept, .. } = held.scaling() else { panic!("another scaling") };
        // Where it joins the rest α is 1 with slopes 0, and not where it does not; held it is there, too.
        for s in [0.1, 0.35, 0.8] {
            let (x, y) = (a + s * (to - a), c + s * (side - c));
            for (at, joins) in [((a, y), false), ((to, y), true), ((x, c), false), ((x, side), true)] {
                let is_one = |alpha: &Field<f64>| (alpha.value(at.0, at.1).unwrap() - 1.0).abs() < 1e-10;
                assert!(is_one(kept) && (!joins || is_one(found)), "{case} {at:?}");
            }
        }
        assert!((found.value(a, c + 0.5 * (side - c)).unwrap() - 1.0).abs() > 1e-6, "{case}");
        let [less, more] = [&own, &held].map(|tuned| tuned.report().change[0]);
        assert!(less < more, "{case}: {less} {more}");
        lower += 1;
        // Edges stay, and outside nothing moves.
        let whole = raised(&surface, own.surface());
        for k in 0..=20 {
            let v = c + (d - c) * f64::from(k) / 20.0;
            for u in [a, to, b] {
                let off = own.surface().point(u, v).unwrap() - surface.point(u, v).unwrap();
                assert!(off.norm() <= 1e-11 * size(&surface), "{case}: {u} {v} {:e}", off.norm());
            }
            if v > side {
                let u = a + (b - a) * f64::from(k) / 20.0;
                assert_eq!(own.surface().point(u, v).unwrap(), whole.point(u, v).unwrap(), "{case}: {u} {v}");
            }
        }
        // All of a direction by [], derivatives held at its ends when that is asked for.
        let strip = surface.between(V, c, side).unwrap();
        let alpha = any_net(&strip, [many, 9], [3, 3], &mut random);
        let tuning = FineTuneSurface::new(&surface, Scaling::along(U, alpha)).between(V, c, side).any_sign();
        if let Ok(tuned) = tuning.continuity(2).solve() {
            let Scaling::Along { alpha, .. } = tuned.scaling() else { panic!("another scaling") };
            for u in [a, b] {
                let value = alpha.value(u, c + 0.4 * (side - c)).unwrap();
                assert!((value - 1.0).abs() < 1e-10, "{case}: {value}");
            }
        }
    }
    assert!(lower >= 20, "{lower}");
}

/// α(u, v) that wants to run from a sixth to six over a region whose border stays: where 1 keeps the border (it always does) some positive α does, and one is
/// found.
#[test]
fn regions_with_a_wide_alpha() {
    let (mut asked, mut held) = (0, 0);
    for case in 0..80 {
        let (surface, mut random) = (any_surface(case), Lcg::new(case + 9000));
        let mut part = |space: &Space| {
            let (a, b) = space.domain();
            (a + (b - a) * random.next() * 0.4, a + (b - a) * (0.7 + 0.25 * random.next()))
        };
        let (in_u, in_v) = (part(surface.u()), part(surface.v()));
        let direction = [U, V][random.below(2)];
        let patch = surface.between(U, in_u.0, in_u.1).unwrap().between(V, in_v.0, in_v.1).unwrap();
        let (knots, degrees) = if direction == U { ([17, 5], [3, 3]) } else { ([5, 17], [3, 3]) };
        let net = any_net(&patch, knots, degrees, &mut random);
        let tune = |alpha: Field<f64>| {
            let tuning = FineTuneSurface::new(&surface, Scaling::along(direction, alpha));
            tuning.between(U, in_u.0, in_u.1).between(V, in_v.0, in_v.1).continuity(1).solve()
        };
        // From [0.5, 1.5] to powers of ten.
        let wide = net.mapped(|value| 10.0_f64.powf(1.6 * (value - 1.0))).unwrap();
        let ones = net.mapped(|_| 1.0).unwrap();
        // Too few values for what the border asks, or degrees too high.
        if tune(ones).is_err() {
            continue;
        }
        asked += 1;
        match tune(wide) {
            Ok(tuned) => {
                let [least, most] = tuned.report().alpha[usize::from(direction == V)];
                assert!(least > 0.0, "{case}: {least}");
                held += usize::from(least < 1e-3 * most);
                let whole = raised(&surface, tuned.surface());
                assert!(distance(&surface, &whole) <= 1e-12 * size(&surface), "{case}");
            }
            Err(error) => {
                let said = error.to_string();
                assert!(said.contains("values") || said.contains("degree"), "{case}: {said}");
                asked -= 1;
            }
        }
    }
    assert!(asked >= 20 && held >= 5, "{asked} {held}");
}

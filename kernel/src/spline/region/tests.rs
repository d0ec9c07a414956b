//! Integrals over regions that are known.

use std::f64::consts::{PI, TAU};

use proptest::prelude::*;

use super::*;
use crate::shape::Cells;
use crate::spline::{Curve, Space};
use crate::{Point, Vector};

fn polygon(corners: &[[f64; 2]]) -> Vec<ParameterCurve> {
    let at = |k: usize| Point::new(corners[k % corners.len()][0], corners[k % corners.len()][1], 0.0);
    let edge = |k: usize| ParameterCurve::whole(Curve::line(at(k), at(k + 1)).unwrap()).unwrap();
    (0..corners.len()).map(edge).collect()
}

fn circle(center: [f64; 2], radius: f64) -> Vec<ParameterCurve> {
    let center = Point::new(center[0], center[1], 0.0);
    vec![ParameterCurve::whole(Curve::circle(center, Vector::z(), radius).unwrap()).unwrap()]
}

/// A surface whose knots are these; where it lies does not matter.
fn surface(u: &[f64], v: &[f64]) -> Surface {
    let spaces = [u, v].map(|knots| Space::clamped(1, knots).unwrap());
    let [u, v] = spaces;
    let net = (0..u.len()).flat_map(|i| (0..v.len()).map(move |j| (i, j)));
    let net = net.map(|(i, j)| Point::new(u.greville(i), v.greville(j), 0.0)).collect();
    Surface::new(u, v, net).unwrap()
}

fn sides(surface: &Surface, closed: [bool; 2]) -> [ParameterSide; 2] {
    let domains = [surface.u().domain(), surface.v().domain()];
    [0, 1].map(|d: usize| ParameterSide {
        low: domains[d].0,
        high: domains[d].1,
        closed: closed[d],
        poles: [false; 2],
    })
}

/// `∬ u^a v^b` over what loops bound, by rules that are exact for it; with how many cells count whole, in part and not at all.
fn moments(
    surface: &Surface,
    sides: &[ParameterSide; 2],
    loops: &[Vec<ParameterCurve>],
    powers: [usize; 2],
    parts: usize,
) -> Result<(f64, [usize; 3])> {
    let loops: Vec<Vec<(&ParameterCurve, bool)>> =
        loops.iter().map(|chain| chain.iter().map(|c| (c, false)).collect()).collect();
    let region = ParameterRegion::new(surface, sides, &loops)?;
    let mut sum = 0.0;
    let mut counts = [0; 3];
    for index in 0..surface.count() {
        let Some(cell) = surface.cell(index) else { continue };
        let share = region.share([cell.sides[0].start, cell.sides[1].start]);
        counts[match share {
            Share::Whole => 0,
            Share::Part(_) => 1,
            Share::Nothing => 2,
        }] += 1;
        let counts = powers.map(|p| p / 2 + 1);
        for (at, weight) in share.gauss_points(&cell, counts, parts) {
            let crate::shape::Location::Surface(u, v) = at else { unreachable!() };
            assert!((cell.sides[0].start..=cell.sides[0].end).contains(&u));
            assert!((cell.sides[1].start..=cell.sides[1].end).contains(&v));
            sum += weight * u.powi(powers[0] as i32) * v.powi(powers[1] as i32);
        }
    }
    Ok((sum, counts))
}

/// The same of a polygon, triangle by triangle from the origin: `∬ u^a v^b` by a rule on the square that is mapped onto each.
fn of_polygon(corners: &[[f64; 2]], powers: [usize; 2]) -> f64 {
    let (nodes, weights) = crate::quadrature::gauss_legendre(powers[0] + powers[1] + 2);
    let mut sum = 0.0;
    for (k, a) in corners.iter().enumerate() {
        let b = corners[(k + 1) % corners.len()];
        let double = a[0] * b[1] - a[1] * b[0];
        for (r, w) in nodes.iter().zip(&weights) {
            for (s, x) in nodes.iter().zip(&weights) {
                let at = [0, 1].map(|d: usize| r * (a[d] + (b[d] - a[d]) * s));
                sum += w * x * r * double * at[0].powi(powers[0] as i32) * at[1].powi(powers[1] as i32);
            }
        }
    }
    sum
}

#[test]
fn cells_count_whole_in_part_or_not_at_all() {
    let grid = surface(&[0.0, 1.0, 2.0, 3.0], &[0.0, 1.0, 2.0, 3.0]);
    let flat = sides(&grid, [false; 2]);
    let of = |loops: &[Vec<ParameterCurve>]| moments(&grid, &flat, loops, [0, 0], 1).unwrap();
    let near = |a: (f64, [usize; 3]), b: (f64, [usize; 3])| {
        assert!((a.0 - b.0).abs() < 1e-13 && a.1 == b.1, "{a:?} {b:?}");
    };
    let square = |a: f64, b: f64| polygon(&[[a, a], [b, a], [b, b], [a, b]]);
    let mut hole = square(1.0, 2.0);
    near(of(&[square(0.0, 3.0)]), (9.0, [9, 0, 0]));
    near(of(&[hole.clone()]), (1.0, [1, 0, 8]));
    near(of(&[square(0.5, 2.5)]), (4.0, [1, 8, 0]));
    near(of(&[polygon(&[[0.0, 0.0], [3.0, 0.0], [3.0, 3.0]])]), (4.5, [3, 3, 3]));
    let back = |chain: &[[f64; 2]]| polygon(&chain.iter().rev().copied().collect::<Vec<_>>());
    hole = back(&[[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]]);
    near(of(&[square(0.0, 3.0), hole.clone()]), (8.0, [8, 0, 1]));
    // All run the other way: still what they bound.
    near(of(&[back(&[[0.5, 0.5], [2.5, 0.5], [2.5, 2.5], [0.5, 2.5]])]), (4.0, [1, 8, 0]));
    // A slit there and back changes nothing.
    let slit = polygon(&[[0.0, 0.0], [3.0, 0.0], [3.0, 1.5], [1.5, 1.5], [3.0, 1.5], [3.0, 3.0], [0.0, 3.0]]);
    let (area, _) = of(&[slit]);
    assert!((area - 9.0).abs() < 1e-13);
    // A circle, and one that touches knot lines.
    for (center, radius) in [([1.4, 1.6], 1.3), ([1.5, 1.5], 0.5), ([1.5, 1.5], 1.5)] {
        let (area, _) = moments(&grid, &flat, &[circle(center, radius)], [0, 0], 2).unwrap();
        assert!((area - PI * radius * radius).abs() < 1e-12, "{center:?} {radius}: {area}");
    }
    let refused = |loops: &[Vec<ParameterCurve>], says: &str| {
        let error = moments(&grid, &flat, loops, [0, 0], 1).unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
    };
    refused(&[square(0.0, 3.0), square(1.0, 2.0)], "more than once");
    refused(&[square(0.0, 3.0), back(&[[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]])], "bound nothing");
}

#[test]
fn what_goes_around_is_counted_once() {
    let grid = surface(&[0.0, 1.0, 2.5, TAU], &[-1.0, 0.0, 2.0]);
    let around = sides(&grid, [true, false]);
    let ring = |v: f64, from: f64| {
        let ends = [Point::new(from, v, 0.0), Point::new(from + TAU, v, 0.0)];
        ParameterCurve::whole(Curve::line(ends[0], ends[1]).unwrap()).unwrap()
    };
    let loops = |chains: &[Vec<(&ParameterCurve, bool)>]| {
        let region = ParameterRegion::new(&grid, &around, chains)?;
        let mut sum = 0.0;
        for cell in (0..grid.count()).filter_map(|k| grid.cell(k)) {
            let share = region.share([cell.sides[0].start, cell.sides[1].start]);
            sum += share.gauss_points(&cell, [1, 1], 1).iter().map(|(_, w)| w).sum::<f64>();
        }
        Ok::<f64, Error>(sum)
    };
    for from in [0.0, 0.3, 2.5, -7.0, 6.0] {
        let (low, high) = (ring(-1.0, from), ring(1.3, from + 1.0));
        let area = loops(&[vec![(&low, false)], vec![(&high, true)]]).unwrap();
        assert!((area - 2.3 * TAU).abs() < 1e-12, "{area}");
        // Joined by a seam: the same.
        let seam = polygon(&[[from + TAU, -1.0], [from + TAU, 1.3]]).remove(0);
        let high = ring(1.3, from);
        let area = loops(&[vec![(&low, false), (&seam, false), (&high, true), (&seam, true)]]).unwrap();
        assert!((area - 2.3 * TAU).abs() < 1e-12, "{from}: {area}");
        // One ring alone leaves the surface open.
        let error = loops(&[vec![(&high, true)]]).unwrap_err().to_string();
        assert!(error.contains("goes on where the surface ends"), "{error}");
        let error = loops(&[vec![(&low, false)], vec![(&high, false)]]).unwrap_err().to_string();
        assert!(error.contains("more than once") || error.contains("goes on"), "{error}");
    }
}

/// A whole torus has one loop, there and back along both seams, wherever they are.
#[test]
fn a_whole_torus_is_all_of_it() {
    let grid = surface(&[0.0, 1.0, 2.5, TAU], &[-1.0, 0.0, 2.0]);
    let around = sides(&grid, [true; 2]);
    let area = |chains: &[Vec<(&ParameterCurve, bool)>]| {
        let region = ParameterRegion::new(&grid, &around, chains)?;
        let mut sum = 0.0;
        for cell in (0..grid.count()).filter_map(|k| grid.cell(k)) {
            let share = region.share([cell.sides[0].start, cell.sides[1].start]);
            sum += share.gauss_points(&cell, [1, 1], 1).iter().map(|(_, w)| w).sum::<f64>();
        }
        Ok::<f64, Error>(sum)
    };
    for [u, v] in [[0.0, -1.0], [0.7, 0.4], [2.5, 0.0]] {
        for tilt in [0.0, 3e-16, 1e-12] {
            let corners = [[u, v], [u + TAU, v + tilt], [u + TAU + tilt, v + 3.0], [u - tilt, v + 3.0]];
            let seams = polygon(&corners);
            for way in [false, true] {
                let mut chain: Vec<(&ParameterCurve, bool)> = seams.iter().map(|c| (c, way)).collect();
                if way {
                    chain.reverse();
                }
                let found = area(&[chain]).unwrap();
                assert!((found - 3.0 * TAU).abs() < 1e-12, "{u} {v} {tilt} {way}: {found}");
            }
        }
    }
    // Along one seam only it bounds nothing.
    let one = polygon(&[[0.0, -1.0], [TAU, -1.0]]);
    assert!(area(&[one.iter().map(|c| (c, false)).collect()]).is_err());
}

/// A corner that only touches the seam peeks over it by rounding: the strip that counts there is no wider than what is taken away from it, also
/// where a moment weighs the far side of the surface a hundred times as much.
#[test]
fn a_corner_on_the_seam_leaves_nothing_beyond_it() {
    let grid = surface(&[0.0, 1.0, 1.1, 3.0, 4.0], &[0.0, 1.0, 1.1, 3.0, 4.0]);
    for touching in [0.0, 5e-14, -5e-14] {
        let corners = [[0.5, 1.5], [0.25, 2.5], [touching, 1.5], [0.25, 0.75]];
        for powers in [[0, 0], [3, 0], [3, 2], [3, 3]] {
            let found =
                moments(&grid, &sides(&grid, [true, false]), &[polygon(&corners)], powers, 1).unwrap().0;
            let expected = of_polygon(&corners, powers);
            assert!((found - expected).abs() < 1e-14, "{touching} {powers:?}: {found} {expected}");
        }
    }
}

fn star() -> impl Strategy<Value = Vec<[f64; 2]>> {
    proptest::collection::vec(0.2..1.0_f64, 3..9).prop_map(|radii| {
        let count = radii.len() as f64;
        let corner = |(k, r): (usize, &f64)| {
            let (sin, cos) = (TAU * k as f64 / count).sin_cos();
            [r * cos, r * sin]
        };
        radii.iter().enumerate().map(corner).collect()
    })
}

proptest! {
    #[test]
    fn polygons_have_their_moments(
        corners in star(),
        at in [0.0..4.0_f64, 0.0..4.0_f64],
        knots in [0.05..0.95_f64, 0.05..0.95_f64],
        closed in proptest::array::uniform2(any::<bool>()),
        powers in [0_usize..4, 0_usize..4],
        on_knots in any::<bool>(),
    ) {
        // Domains from 0 to 4; where they do not close, everything is kept inside.
        let lines = |share: f64| [0.0, 1.0, 1.0 + 2.0 * share, 3.0, 4.0];
        let grid = surface(&lines(knots[0]), &lines(knots[1]));
        let sides = sides(&grid, closed);
        let at = [0, 1].map(|d: usize| if closed[d] { at[d] } else { at[d].clamp(1.0, 3.0) });
        let mut moved: Vec<[f64; 2]> = corners.iter().map(|c| [c[0] + at[0], c[1] + at[1]]).collect();
        if on_knots {
            // Corners and edges on lines, where that is next to where they are.
            moved.iter_mut().flatten().for_each(|x| *x = (4.0 * *x).round() / 4.0);
        }
        let area = of_polygon(&moved, [0, 0]);
        prop_assume!(area > 0.05);
        // Corners that are moved may turn a star over: still polygons, but not simple ones.
        let simple = |from: &[f64; 2], to: &[f64; 2]| {
            (from[0] - at[0]) * (to[1] - at[1]) - (from[1] - at[1]) * (to[0] - at[0]) > 0.0
        };
        let turns = (0..moved.len()).all(|k| simple(&moved[k], &moved[(k + 1) % moved.len()]));
        prop_assume!(turns);
        let loops = vec![polygon(&moved)];
        let (found, _) = moments(&grid, &sides, &loops, [0, 0], 1).unwrap();
        prop_assert!((found - area).abs() < 1e-11, "{found} {area}");
        // Where nothing goes around, all moments.
        let inside = moved.iter().flatten().all(|x| (0.0..=4.0).contains(x));
        if inside {
            let (found, _) = moments(&grid, &sides, &loops, powers, 1).unwrap();
            let expected = of_polygon(&moved, powers);
            prop_assert!((found - expected).abs() < 1e-10 * (1.0 + expected.abs()), "{found} {expected}");
        }
    }
}

//! Surfaces that share an edge as a set of points only: knots, degree, direction or length of their edges differ, and what is cut is one.

#![allow(clippy::unwrap_used, reason = "a test may stop at what should not be")]

use std::collections::BTreeMap;

use crate::common::{deviation, no_sliver_of_nothing};
use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::plugin::{Beside, Chord, Fineness, Tessellated, Tessellator};
use loftsman_kernel::spline::{Direction, Space, Surface};
use loftsman_kernel::{Point, Vector};
use loftsman_tessellation::Adaptive;
use proptest::prelude::*;

/// All surfaces cut as a writer does it: every border first, then each with the points of all.
fn cut(surfaces: &[Surface], fineness: &Fineness, near: f64) -> Vec<Tessellated> {
    let mut all: Vec<Point> = Vec::new();
    for surface in surfaces {
        for point in Adaptive::default().border(surface, fineness).unwrap() {
            if all.iter().all(|p| (p - point).norm() > near) {
                all.push(point);
            }
        }
    }
    let beside = Beside { points: &all, near };
    surfaces
        .iter()
        .map(|surface| Adaptive::default().measured_surface_beside(surface, fineness, beside).unwrap())
        .collect()
}

/// How often each directed side of a triangle is there in all meshes together, its ends known by their bits.
type Sides = BTreeMap<[[u64; 3]; 2], usize>;

fn sides<'m>(meshes: impl IntoIterator<Item = &'m Mesh>) -> Sides {
    let mut sides = Sides::new();
    for mesh in meshes {
        // -0 and 0 are one.
        let bits = |k: u32| (mesh.points()[k as usize].coords + Vector::zeros()).data.0[0].map(f64::to_bits);
        for f in mesh.faces() {
            (0..3).for_each(|k| *sides.entry([bits(f[k]), bits(f[(k + 1) % 3])]).or_default() += 1);
        }
    }
    sides
}

/// The sides with nothing across, if everything along the way is there once each way.
fn open(sides: &Sides) -> Vec<[[f64; 3]; 2]> {
    let across = |[a, b]: &[[u64; 3]; 2]| sides.get(&[*b, *a]).copied().unwrap_or(0);
    let found = sides.iter().filter(|(side, count)| across(side) != **count);
    found.map(|([a, b], _)| [a.map(f64::from_bits), b.map(f64::from_bits)]).collect()
}

/// A spline with a wavy net over clamped spaces, rational where `weighty`.
fn wavy(degrees: [usize; 2], spans: [usize; 2], weighty: bool, seed: u64) -> Surface {
    let mut state = seed.wrapping_mul(2).wrapping_add(1);
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / 2_f64.powi(31)
    };
    let mut space = |d: usize| {
        let (p, mut knots, mut at) = (degrees[d], vec![0.0; degrees[d] + 1], 0.0);
        for _ in 1..spans[d] {
            at += 0.2 + next();
            let times = 1 + (next() * p as f64) as usize;
            knots.extend(vec![at; times.min(p)]);
        }
        knots.extend(vec![at + 0.2 + next(); p + 1]);
        Space::open(p, knots).unwrap()
    };
    let (u, v) = (space(0), space(1));
    let (n, m) = (u.len(), v.len());
    let mut points = Vec::new();
    for i in 0..n {
        for j in 0..m {
            let (x, y) = (i as f64 / (n - 1) as f64, j as f64 / (m - 1) as f64);
            points.push(Point::new(
                2.0 * x + 0.05 * next(),
                y + 0.05 * next(),
                0.3 * (2.5 * x).sin() * (1.7 * y + 0.4).cos() + 0.05 * next(),
            ));
        }
    }
    let weights = (0..n * m).map(|_| 0.4 + 2.0 * next()).collect();
    Surface::build(u, v, points, weighty.then_some(weights)).unwrap()
}

/// The surface in two, of which the second has another edge of the same points: knots more, a degree more, the other way round, or in two
/// pieces of its own.
fn torn(surface: &Surface, how: usize, share: f64) -> Vec<Surface> {
    let (a, b) = surface.u().domain();
    let mut parts = surface.split(Direction::U, a + 0.47 * (b - a)).unwrap();
    let second = parts.pop().unwrap();
    let (c, d) = second.v().domain();
    let at = c + share * (d - c);
    let more = match how {
        0 => vec![second.insert_knots(Direction::V, &[at]).unwrap()],
        1 => vec![second.elevate(Direction::V, 2).unwrap()],
        2 => {
            let turned = second.reverse(Direction::V).unwrap().insert_knots(Direction::V, &[at]);
            vec![turned.unwrap().reverse(Direction::U).unwrap()]
        }
        _ => second.split(Direction::V, at).unwrap(),
    };
    parts.extend(more);
    parts
}

fn common(meshes: &[Tessellated], whole: &Surface, chord: f64) -> Result<(), TestCaseError> {
    // What is open is the border of the whole, as if nothing were torn.
    let left = open(&sides(meshes.iter().map(|m| &m.mesh)));
    for [a, b] in &left {
        let middle = Point::from((Vector::from(*a) + Vector::from(*b)) * 0.5);
        let (u, v) = whole.closest(middle).unwrap().at;
        let ((u0, u1), (v0, v1)) = (whole.u().domain(), whole.v().domain());
        let share = [(u - u0) / (u1 - u0), (v - v0) / (v1 - v0)];
        let rim = share.iter().map(|s| s.min(1.0 - s)).fold(1.0, f64::min);
        prop_assert!(rim < 0.1, "open between {a:?} and {b:?}, at {share:?}");
    }
    for mesh in meshes {
        prop_assert!(mesh.error <= chord * (1.0 + 1e-9), "{} of {chord}", mesh.error);
        prop_assert!((mesh.tolerance - chord).abs() <= 1e-12 * chord);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, ..ProptestConfig::default() })]

    #[test]
    fn edges_that_are_one_as_points_are_cut_as_one(
        degrees in [1_usize..8, 1_usize..8],
        spans in [1_usize..4, 1_usize..4],
        weighty: bool,
        seed: u64,
        how in 0_usize..4,
        share in 0.05..0.95,
        chord in prop::sample::select(vec![3e-2, 3e-3, 5e-4]),
    ) {
        let whole = wavy(degrees, spans, weighty, seed);
        let parts = torn(&whole, how, share);
        let fineness = Fineness { chord: Chord::Absolute(chord), angle: 0.6 };
        let meshes = cut(&parts, &fineness, 1e-9);
        common(&meshes, &whole, chord)?;
        for (part, mesh) in parts.iter().zip(&meshes) {
            let (out, back) = deviation(part, &mesh.mesh, mesh.error);
            prop_assert!(out <= mesh.error * (1.0 + 1e-6) && back <= mesh.error * (1.0 + 1e-6), "{out} {back} of {}", mesh.error);
            no_sliver_of_nothing(&mesh.mesh);
        }
    }
}

/// A tube of radius 1 about z, exactly, from one height to another, begun at an angle.
fn tube(low: f64, high: f64, begin: f64) -> Surface {
    let line = loftsman_kernel::spline::Curve::line(
        Point::new(begin.cos(), begin.sin(), low),
        Point::new(begin.cos(), begin.sin(), high),
    );
    Surface::revolution(&line.unwrap(), Point::origin(), Vector::z(), std::f64::consts::TAU).unwrap()
}

#[test]
fn rings_of_seams_elsewhere_are_one() {
    for begin in [0.3, 1.0, 3.0, 6.0] {
        let parts = [tube(0.0, 1.0, 0.0), tube(1.0, 2.0, begin)];
        let meshes = cut(&parts, &Fineness { chord: Chord::Absolute(1e-3), angle: 1.0 }, 1e-9);
        let left = open(&sides(meshes.iter().map(|m| &m.mesh)));
        assert!(!left.is_empty());
        for [a, b] in left {
            assert!(a[2] != 1.0 && b[2] != 1.0, "begun at {begin}: open between {a:?} and {b:?}");
        }
        assert!(meshes.iter().all(|m| m.error <= 1e-3));
        // Alone they are not.
        let alone = parts.each_ref().map(|part| {
            let fineness = Fineness { chord: Chord::Absolute(1e-3), angle: 1.0 };
            Adaptive::default().measured_surface(part, &fineness).unwrap().mesh
        });
        assert!(open(&sides(&alone)).iter().any(|[a, _]| a[2] == 1.0));
    }
}

#[test]
fn what_is_not_on_the_border_does_not_matter() {
    let surface = wavy([3, 3], [3, 2], true, 5);
    let fineness = Fineness { chord: Chord::Absolute(1e-3), angle: 0.6 };
    let away: Vec<Point> = (0..50).map(|k| Point::new(0.04 * f64::from(k), 0.5, 3.0)).collect();
    let none = Beside { points: &[], near: 1e-9 };
    let adaptive = Adaptive::default();
    let alone = adaptive.measured_surface_beside(&surface, &fineness, none).unwrap();
    let same =
        adaptive.measured_surface_beside(&surface, &fineness, Beside { points: &away, ..none }).unwrap();
    assert_eq!(alone, same);
    // Nor does what it has itself.
    let own = adaptive.border(&surface, &fineness).unwrap();
    let same =
        adaptive.measured_surface_beside(&surface, &fineness, Beside { points: &own, ..none }).unwrap();
    assert_eq!(alone.mesh, same.mesh);
    // A point half as far off as points may be to be one is one.
    let mut points = own;
    let (k, moved) = (points.len() / 2, Vector::new(0.0, 0.0, 5e-10));
    points[k] += moved;
    let near =
        adaptive.measured_surface_beside(&surface, &fineness, Beside { points: &points, ..none }).unwrap();
    assert_eq!(alone.mesh.points().len(), near.mesh.points().len());
    assert!(near.mesh.points().contains(&points[k]) && near.error >= alone.error);
}

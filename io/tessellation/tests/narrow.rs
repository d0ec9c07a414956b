//! Loops that come nearer to one another than the tolerance, beside a crease, where what is near to it counts as on it.

#![allow(clippy::unwrap_used, clippy::panic, reason = "tests")]

use std::f64::consts::{FRAC_PI_2, PI};

use loftsman_kernel::brep::{Brep, Face, SurfaceForm};
use loftsman_kernel::plugin::{Chord, Fineness, TessellatedBrep, Tessellator};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use loftsman_tessellation::Adaptive;

use crate::common::{euler, no_sliver_of_nothing};
use crate::solids::{against, along, edge, face, line, p, vertex, whole};

const CHORD: f64 = 0.05;

fn cut(brep: &Brep) -> TessellatedBrep {
    let fineness = Fineness { chord: Chord::Absolute(CHORD), angle: FRAC_PI_2 };
    Adaptive::default().measured_brep(brep, &fineness).unwrap()
}

fn volume(cut: &TessellatedBrep) -> f64 {
    let of = |f: &[u32]| {
        let [a, b, c] = [f[0], f[1], f[2]].map(|k| cut.mesh.points()[k as usize].coords);
        a.dot(&b.cross(&c)) / 6.0
    };
    cut.mesh.faces().map(of).sum()
}

/// A circle around (1 + left, 1.5), which is `left` away from x = 0, and a closed spline that is, too; both start there, and run
/// counterclockwise.
fn holes(left: f64, height: f64) -> [Curve; 2] {
    let circle =
        Curve::elliptic_arc(p(0.8 + left, 1.5, height), Vector::x() * 0.8, Vector::y() * 0.8, PI, 2.0 * PI);
    let at = |x: f64, y: f64| p(left + x, 3.5 + y, height);
    let points = vec![
        at(0.0, 0.0),
        at(0.0, -0.9),
        at(1.6, -0.6),
        at(1.6, 0.0),
        at(1.6, 0.6),
        at(0.0, 0.9),
        at(0.0, 0.0),
    ];
    let space = Space::open(3, [vec![0.0; 4], vec![0.5; 3], vec![1.0; 4]].concat());
    [circle.unwrap(), Curve::new(space.unwrap(), points).unwrap()]
}

/// A plate of thickness 1 between x = `left` and 3 and y = 0 and 5, with two holes that are `gap` away from its left edge. Its top is of a
/// surface with a crease at x = 0, outside of it.
fn plate(left: f64, gap: f64) -> Brep {
    let corners = |z: f64| [p(left, 0.0, z), p(3.0, 0.0, z), p(3.0, 5.0, z), p(left, 5.0, z)];
    let [low, high] = [0.0, 1.0].map(corners);
    let mut vertices: Vec<_> = low.into_iter().chain(high).map(vertex).collect();
    let mut edges = Vec::new();
    for (ring, first) in [(low, 0), (high, 4)] {
        edges.extend((0..4).map(|k| line(ring[k], ring[(k + 1) % 4], [first + k, first + (k + 1) % 4])));
    }
    edges.extend((0..4).map(|k| line(low[k], high[k], [k, k + 4])));
    let mut faces = Vec::new();
    let plane = |points: [Point; 4], chain| {
        let [a, b, c, _] = points;
        let frame = loftsman_kernel::brep::Frame::new(a, (b - a).cross(&(c - b)), b - a).unwrap();
        face(SurfaceForm::Plane { frame }, &points, false, vec![chain])
    };
    for k in 0..4 {
        let next = (k + 1) % 4;
        let ring = [low[k], low[next], high[next], high[k]];
        faces.push(plane(ring, vec![along(k), along(8 + next), against(4 + k), against(8 + k)]));
    }
    let [a, b, c, d] = low;
    faces.push(plane([a, d, c, b], vec![against(3), against(2), against(1), against(0)]));
    let net =
        [(-1.0, 0.3), (0.0, 1.0), (4.0, 1.0)].into_iter().flat_map(|(x, z)| [p(x, -1.0, z), p(x, 6.0, z)]);
    let spaces = [vec![-1.0, 0.0, 4.0], vec![-1.0, 6.0]].map(|breaks| Space::clamped(1, &breaks).unwrap());
    let [u, v] = spaces;
    let roof = Surface::new(u, v, net.collect()).unwrap();
    let spline = |surface, loops| Face {
        name: None,
        color: None,
        surface,
        form: SurfaceForm::Spline,
        reversed: false,
        loops,
        points: vec![],
    };
    faces.push(spline(roof, vec![vec![along(4), along(5), along(6), along(7)]]));
    for (lower, upper) in holes(left + gap, 0.0).into_iter().zip(holes(left + gap, 1.0)) {
        let number = edges.len();
        let wall = Surface::extrusion(&lower, Vector::z()).unwrap();
        for curve in [lower, upper] {
            vertices.push(vertex(curve.point(0.0).unwrap()));
            edges.push(edge(curve, [vertices.len() - 1; 2]));
        }
        faces[4].loops.push(vec![along(number)]);
        faces[5].loops.push(vec![against(number + 1)]);
        let mut wall = spline(wall, vec![vec![against(number)], vec![along(number + 1)]]);
        wall.reversed = true;
        faces.push(wall);
    }
    whole(vertices, edges, faces, true)
}

/// What the plate holds.
fn expected(left: f64) -> f64 {
    // What the spline bounds, by Green's formula.
    let [_, curve] = holes(0.0, 0.0);
    let count = 20_000;
    let at = |k: i32| curve.point(f64::from(k) / f64::from(count)).unwrap();
    let spline: f64 =
        (0..count).map(|k| (at(k), at(k + 1))).map(|(a, b)| 0.5 * (a.x * b.y - a.y * b.x)).sum();
    (3.0 - left) * 5.0 - PI * 0.64 - spline
}

#[test]
fn loops_nearer_than_the_tolerance_are_parted() {
    for near in [3e-4, 3e-5] {
        let found = cut(&plate(near, near));
        assert!(found.left_out.is_empty(), "{:?}", found.left_out);
        assert_eq!(euler(&found.mesh), -2);
        no_sliver_of_nothing(&found.mesh);
        assert!(found.error <= CHORD);
        // Around the holes, above and below, are 2 π 0.8 and less.
        let off = (volume(&found) - expected(near)).abs();
        assert!(off <= found.error * 10.0, "{off}");
        // The edges of the face below are not cut finer.
        let count = |edge: usize| found.edges[edge].len();
        for [below, above] in [[12, 13], [14, 15]] {
            assert!(2 * count(below) < count(above), "{} {}", count(below), count(above));
        }
    }
    // Away from the crease chords part where they cross, and no edge is cut anew.
    let apart = cut(&plate(0.5, 1e-6));
    assert!(apart.left_out.is_empty() && euler(&apart.mesh) == -2);
    assert_eq!(apart.edges[12].len(), apart.edges[13].len());
}

/// Loops that cross are told as soon as their chords meet, and no other tolerance is advised.
#[test]
fn loops_that_cross_are_told() {
    for left in [0.5, 3e-4] {
        let found = cut(&plate(left, -0.1));
        let out: Vec<usize> = found.left_out.iter().map(|(face, _)| *face).collect();
        assert_eq!(out, [4, 5]);
        for (_, reason) in &found.left_out {
            let reason = reason.to_string();
            assert!(
                reason.contains("its loops cross or touch at edge") && !reason.contains("may part"),
                "{reason}"
            );
        }
    }
}

/// Where finer edges part nothing, all edges are as if they had not been tried.
#[test]
fn loops_that_finer_edges_do_not_part_leave_all_as_it_was() {
    let found = cut(&plate(1e-7, 1e-7));
    let [(5, reason)] = &found.left_out[..] else { panic!("{:?}", found.left_out) };
    assert!(reason.to_string().contains("a tolerance of 5e-5 may part them"), "{reason}");
    for [below, above] in [[12, 13], [14, 15]] {
        assert_eq!(found.edges[below].len(), found.edges[above].len());
    }
}

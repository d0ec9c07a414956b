//! Breps whose areas and volumes are known: closed where they should be, and as near as promised.

#![allow(clippy::unwrap_used, reason = "a test may stop at what should not be")]

use std::f64::consts::{FRAC_PI_2, PI};

use crate::solids::*;
use loftsman_kernel::Vector;
use loftsman_kernel::brep::Brep;
use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::plugin::{Chord, Fineness, TessellatedBrep, Tessellator};
use loftsman_tessellation::Adaptive;

fn fineness(chord: f64) -> Fineness {
    Fineness { chord: Chord::Absolute(chord), angle: FRAC_PI_2 }
}

fn area(mesh: &Mesh) -> f64 {
    let of = |f: &[u32]| {
        let [a, b, c] = [f[0], f[1], f[2]].map(|k| mesh.points()[k as usize]);
        0.5 * (b - a).cross(&(c - a)).norm()
    };
    mesh.faces().map(of).sum()
}

fn volume(mesh: &Mesh) -> f64 {
    let of = |f: &[u32]| {
        let [a, b, c] = [f[0], f[1], f[2]].map(|k| mesh.points()[k as usize].coords);
        a.dot(&b.cross(&c)) / 6.0
    };
    mesh.faces().map(of).sum()
}

/// Cuts a Brep and asks what holds of all: nothing left out, unit normals on the side of their triangles, edges followed.
fn cut(brep: &Brep, chord: f64) -> TessellatedBrep {
    let cut = Adaptive::default().measured_brep(brep, &fineness(chord)).unwrap();
    assert!(cut.left_out.is_empty(), "{:?}", cut.left_out);
    assert_eq!(cut.faces.len(), cut.mesh.face_count());
    assert!(cut.faces.is_sorted());
    crate::common::no_sliver_of_nothing(&cut.mesh);
    assert!(cut.error <= chord * 1.000_001, "{} of {chord}", cut.error);
    for (f, corners) in cut.mesh.faces().enumerate() {
        let [a, b, c] = [0, 1, 2].map(|k| cut.mesh.points()[corners[k] as usize]);
        let normal = (b - a).cross(&(c - a)).normalize();
        for k in 0..3 {
            let own = cut.mesh.normals.at(3 * f + k, corners[k]).unwrap();
            assert!(own.dot(&normal) > -0.2, "triangle {f} of face {}: {own} {normal}", cut.faces[f]);
        }
    }
    let mut segments = std::collections::BTreeSet::new();
    for f in cut.mesh.faces() {
        (0..3).for_each(|k| _ = segments.insert((f[k], f[(k + 1) % 3])));
    }
    for (edge, chain) in cut.edges.iter().enumerate() {
        for pair in chain.windows(2) {
            let known = segments.contains(&(pair[0], pair[1])) || segments.contains(&(pair[1], pair[0]));
            assert!(known, "edge {edge}: {pair:?} is no edge of a triangle");
        }
    }
    cut
}

/// Of a solid: closed, of this Euler characteristic, with this area and volume within what the error allows.
fn solid(brep: &Brep, chord: f64, euler: i64, size: [f64; 2]) -> TessellatedBrep {
    let cut = cut(brep, chord);
    assert_eq!(crate::common::euler(&cut.mesh), euler);
    let [expected_area, expected_volume] = size;
    let (a, v) = (area(&cut.mesh), volume(&cut.mesh));
    assert!(
        (v - expected_volume).abs() <= cut.error * expected_area + 1e-12,
        "volume {v} of {expected_volume}: {}",
        cut.error
    );
    // An area is not bounded by a distance; of smooth faces cut into fair triangles it is as near as this.
    assert!(
        (a - expected_area).abs() <= 20.0 * cut.error * expected_area.sqrt() + 1e-12,
        "area {a} of {expected_area}"
    );
    cut
}

#[test]
fn a_cube_is_twelve_triangles() {
    let cut = solid(&cube(), 1e-3, 2, [6.0, 1.0]);
    assert_eq!((cut.mesh.points().len(), cut.mesh.face_count()), (8, 12));
    assert!(cut.error < 1e-12, "{}", cut.error);
}

#[test]
fn cylinders_with_caps_close() {
    for seam in [false, true] {
        for chord in [0.1, 1e-2, 1e-3, 1e-4] {
            let cut = solid(&cylinder(1.0, 2.0, seam), chord, 2, [2.0 * PI + 4.0 * PI, 2.0 * PI]);
            if chord < 0.05 {
                // As many chords as the tolerance asks for around, and two triangles each between the circles.
                let around = PI / (0.9_f64 * chord / 2.0).sqrt() * 0.72;
                let per = cut.mesh.face_count() as f64 / around;
                assert!(per < 8.0, "{chord}: {} {around}", cut.mesh.face_count());
            }
        }
    }
}

#[test]
fn cones_end_in_their_tips() {
    for seam in [false, true] {
        for chord in [1e-2, 1e-3] {
            let (r, h) = (1.0_f64, 2.0_f64);
            let slant = (r * r + h * h).sqrt();
            solid(&cone(r, h, seam), chord, 2, [PI * r * slant + PI * r * r, PI * r * r * h / 3.0]);
        }
    }
}

#[test]
fn spheres_are_cut_by_planes() {
    for seam in [false, true] {
        for height in [-0.7, 0.0, 0.4] {
            for chord in [1e-2, 1e-3] {
                // The part above the height, and the disc.
                let h = 1.0 - height;
                let disc = PI * (1.0 - height * height);
                let size = [2.0 * PI * h + disc, PI * h * h * (3.0 - h) / 3.0];
                solid(&sphere_cap(height, seam), chord, 2, size);
            }
        }
    }
}

#[test]
fn tori_have_windows() {
    for chord in [0.03, 3e-3] {
        for [u, v] in [[1.0, 1.0], [0.0, 0.0], [PI, 0.0], [0.0, PI]] {
            let cut = cut(&torus_window([u, v], 0.5), chord);
            let whole = 4.0 * PI * PI * 3.0;
            assert!(area(&cut.mesh) < whole && area(&cut.mesh) > 0.9 * whole, "{}", area(&cut.mesh));
            // A torus with a hole: characteristic -1.
            let mut open = 0;
            let mut edges = std::collections::BTreeMap::new();
            for f in cut.mesh.faces() {
                (0..3).for_each(|k| *edges.entry((f[k], f[(k + 1) % 3])).or_insert(0) += 1);
            }
            for (&(a, b), &count) in &edges {
                assert_eq!(count, 1);
                open += usize::from(!edges.contains_key(&(b, a)));
            }
            let all = (edges.len() + open) / 2;
            assert_eq!(cut.mesh.points().len() as i64 - all as i64 + cut.mesh.face_count() as i64, -1);
            assert_eq!(open, cut.edges[0].len() - 1);
        }
    }
}

#[test]
fn a_drilled_cube_has_a_handle() {
    for chord in [0.05, 1e-3] {
        let r = 0.25;
        let size = [6.0 - 2.0 * PI * r * r + 2.0 * PI * r, 1.0 - PI * r * r];
        solid(&drilled_cube(r), chord, 0, size);
    }
}

#[test]
fn whole_surfaces_need_no_edges() {
    solid(&sphere(2.0), 1e-3, 2, [16.0 * PI, 32.0 * PI / 3.0]);
}

#[test]
fn sizes_do_not_matter() {
    for scale in [1e-9, 1e-4, 1e6, 1e9] {
        let map = nalgebra::Matrix4::new_scaling(scale).append_translation(&Vector::new(
            scale,
            -2.0 * scale,
            0.5 * scale,
        ));
        for (brep, count) in [(drilled_cube(0.25), 0), (sphere_cap(0.3, true), 2), (cone(1.0, 2.0, false), 2)]
        {
            let points = brep.points().iter().map(|p| map.transform_point(p)).collect();
            let moved = brep.transformed(points, &map).unwrap();
            let one = cut(&moved, 1e-3 * scale);
            assert_eq!(crate::common::euler(&one.mesh), count);
            let other = cut(&brep, 1e-3);
            let (a, b) = (area(&one.mesh) / (scale * scale), area(&other.mesh));
            assert!((a - b).abs() < 1e-3 * b, "{a} {b}");
        }
    }
}

#[test]
fn relative_tolerances_measure_the_whole() {
    let half = Fineness { chord: Chord::Relative(1e-3), angle: FRAC_PI_2 };
    // A sphere with a small hole: its only edge is much smaller than it.
    let cut = Adaptive::default().measured_brep(&sphere_cap(-0.99, false), &half).unwrap();
    let diagonal = 12_f64.sqrt();
    assert!((0.8..=1.0).contains(&(cut.tolerance / (1e-3 * diagonal))), "{}", cut.tolerance);
}

#[test]
fn a_face_that_fails_is_left_out() {
    // Two corners of the top change places: the loops of three faces cross, bound nothing, or are far from their surfaces.
    let mut points = cube().points().to_vec();
    let first = points.len() - 8;
    points.swap(first + 4, first + 5);
    let crossed = cube().with_points(points).unwrap();
    let found = Adaptive::default().measured_brep(&crossed, &fineness(1e-2)).unwrap();
    assert!(!found.left_out.is_empty());
    for (_, reason) in &found.left_out {
        let reason = reason.to_string();
        assert!(["cross", "area", "off its surface"].iter().any(|why| reason.contains(why)), "{reason}");
    }
    assert!(found.faces.iter().all(|face| found.left_out.iter().all(|(out, _)| out != face)));
}

#[test]
fn the_same_bytes_every_time() {
    let brep = drilled_cube(0.3);
    let one = Adaptive::default().measured_brep(&brep, &fineness(1e-3)).unwrap();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let other = pool.install(|| Adaptive::default().measured_brep(&brep, &fineness(1e-3)).unwrap());
    assert_eq!(one, other);
}

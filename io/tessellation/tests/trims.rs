//! Trimmed surfaces: areas that are known, wavy surfaces with star-shaped holes against dense samples, and what is refused.

#![allow(clippy::unwrap_used, reason = "a test may stop at what should not be")]

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::plugin::{Chord, Fineness, Tessellated, Tessellator};
use loftsman_kernel::spline::trimmed::{ParameterCurve, Region};
use loftsman_kernel::spline::{Curve, Space, Surface, Trimmed};
use loftsman_kernel::{Point, Vector};
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

fn flat(size: f64) -> Surface {
    let space = Space::clamped(1, &[0.0, 1.0]).unwrap();
    let net = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]];
    let net = net.map(|[x, y]| Point::new(x * size, y * size, 0.0)).to_vec();
    Surface::new(space.clone(), space, net).unwrap()
}

/// A loop around a place of the plane, counterclockwise or not.
fn ring(x: f64, y: f64, radius: f64, forward: bool) -> Vec<ParameterCurve> {
    let normal = if forward { Vector::z() } else { -Vector::z() };
    vec![ParameterCurve::whole(Curve::circle(Point::new(x, y, 0.0), normal, radius).unwrap()).unwrap()]
}

fn polygon(corners: &[[f64; 2]]) -> Vec<ParameterCurve> {
    let point = |k: usize| Point::new(corners[k % corners.len()][0], corners[k % corners.len()][1], 0.0);
    (0..corners.len())
        .map(|k| ParameterCurve::whole(Curve::line(point(k), point(k + 1)).unwrap()).unwrap())
        .collect()
}

fn trimmed(surface: Surface, outer: Vec<ParameterCurve>, holes: Vec<Vec<ParameterCurve>>) -> Trimmed {
    Trimmed::new(surface, vec![Region { outer, holes }], vec![], vec![]).unwrap()
}

fn cut(trimmed: &Trimmed, chord: f64) -> Tessellated {
    let cut = Adaptive::default().measured_trimmed(trimmed, &fineness(chord)).unwrap();
    crate::common::no_sliver_of_nothing(&cut.mesh);
    assert!(cut.error <= chord, "{} of {chord}", cut.error);
    cut
}

#[test]
fn plane_regions_have_their_areas() {
    for size in [1e-9, 1.0, 1e9] {
        for chord in [1e-2, 1e-4] {
            for forward in [true, false] {
                let disc = trimmed(flat(size), ring(0.5, 0.5, 0.4, forward), vec![]);
                let annulus =
                    trimmed(flat(size), ring(0.5, 0.5, 0.4, forward), vec![ring(0.5, 0.5, 0.2, !forward)]);
                let plate = trimmed(
                    flat(size),
                    vec![],
                    vec![ring(0.3, 0.3, 0.1, forward), ring(0.6, 0.7, 0.2, false)],
                );
                let expected = [PI * 0.16, PI * 0.12, 1.0 - PI * 0.05];
                for (shape, expected) in [disc, annulus, plate].into_iter().zip(expected) {
                    let found = cut(&shape, chord * size);
                    let a = area(&found.mesh) / (size * size);
                    // A chord's area is two thirds of what its distance times its length is.
                    assert!((a - expected).abs() < 4.0 * chord, "{size} {chord} {a} {expected}");
                }
            }
        }
    }
}

#[test]
fn a_hundred_holes() {
    let holes = (0..100).map(|k| {
        let (i, j) = (f64::from(k % 10), f64::from(k / 10));
        ring(0.05 + 0.1 * i, 0.05 + 0.1 * j, 0.03, k % 3 == 0)
    });
    let shape = trimmed(flat(1.0), vec![], holes.collect());
    let found = cut(&shape, 1e-4);
    assert!((area(&found.mesh) - (1.0 - 100.0 * PI * 0.0009)).abs() < 1e-3);
}

/// Every second corner of a star nearer to its middle.
fn star(x: f64, y: f64, radii: [f64; 2], count: usize) -> Vec<[f64; 2]> {
    (0..2 * count)
        .map(|k| {
            let angle = PI * k as f64 / count as f64 + 0.1;
            [x + radii[k % 2] * angle.cos(), y + radii[k % 2] * angle.sin()]
        })
        .collect()
}

fn inside(corners: &[[f64; 2]], p: [f64; 2]) -> bool {
    let mut inside = false;
    for k in 0..corners.len() {
        let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
        if (a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (b[0] - a[0]) * (p[1] - a[1]) / (b[1] - a[1]) {
            inside = !inside;
        }
    }
    inside
}

fn wavy(p: usize, q: usize, count: usize, rational: bool, phase: f64) -> Surface {
    let (n, m) = (count.max(p + 1), count.max(q + 1));
    let (u, v) = (Space::clamped_uniform(p, n).unwrap(), Space::clamped_uniform(q, m).unwrap());
    let mut net = Vec::new();
    let mut weights = Vec::new();
    for i in 0..n {
        for j in 0..m {
            let (x, y) = (i as f64 / (n - 1) as f64, j as f64 / (m - 1) as f64);
            let z = 0.3 * (5.0 * x + phase).sin() * (4.0 * y - phase).cos();
            net.push(Point::new(x + 0.02 * (9.0 * y).sin(), y + 0.02 * (7.0 * x).cos(), z));
            weights.push(1.0 + 0.5 * (3.0 * x - 2.0 * y + phase).sin());
        }
    }
    Surface::build(u, v, net, rational.then_some(weights)).unwrap()
}

fn to_triangle(p: Vector, [a, b, c]: [Vector; 3]) -> f64 {
    let segment = |a: Vector, b: Vector| {
        let d = b - a;
        let t = ((p - a).dot(&d) / d.norm_squared()).clamp(0.0, 1.0);
        (p - a - d * t).norm()
    };
    let normal = (b - a).cross(&(c - a)).normalize();
    let inside = |a: Vector, b: Vector| normal.dot(&(b - a).cross(&(p - a))) >= 0.0;
    if inside(a, b) && inside(b, c) && inside(c, a) {
        normal.dot(&(p - a)).abs()
    } else {
        segment(a, b).min(segment(b, c)).min(segment(c, a))
    }
}

#[test]
fn wavy_surfaces_are_near() {
    let degrees = [(1, 1), (1, 3), (2, 2), (3, 3), (3, 5), (7, 4), (6, 1), (25, 2)];
    for (k, (p, q)) in degrees.into_iter().enumerate() {
        for rational in [false, true] {
            let surface = wavy(p, q, 8, rational, k as f64);
            let ((u0, u1), (v0, v1)) = (surface.u().domain(), surface.v().domain());
            let place = |at: [f64; 2]| [u0 + (u1 - u0) * at[0], v0 + (v1 - v0) * at[1]];
            let outer = star(0.5, 0.5, [0.45, 0.3], 5 + k);
            let hole = star(0.55, 0.45, [0.08, 0.15], 4);
            let placed = |star: &[[f64; 2]]| star.iter().map(|at| place(*at)).collect::<Vec<_>>();
            let shape = trimmed(surface.clone(), polygon(&placed(&outer)), vec![polygon(&placed(&hole))]);
            let chord = 2e-3;
            let found = cut(&shape, chord);
            // Points of the mesh are on the surface where their texture coordinates say.
            let mesh = &found.mesh;
            for (f, corners) in mesh.faces().enumerate() {
                let uvs = [0, 1, 2].map(|c| place(*mesh.uvs.at(3 * f + c, corners[c]).unwrap()));
                let points = [0, 1, 2].map(|c| mesh.points()[corners[c] as usize].coords);
                for (uv, point) in uvs.iter().zip(points) {
                    let on = surface.point(uv[0], uv[1]).unwrap().coords;
                    assert!((on - point).norm() < 1e-9, "{on} {point}");
                }
                for mix in [[1.0, 1.0, 1.0], [2.0, 1.0, 0.0], [0.0, 1.0, 1.0], [4.0, 1.0, 1.0]] {
                    let sum: f64 = mix.iter().sum();
                    let uv = [0, 1].map(|d| (0..3).map(|c| uvs[c][d] * mix[c]).sum::<f64>() / sum);
                    let on = surface.point(uv[0], uv[1]).unwrap().coords;
                    let mut far = to_triangle(on, points);
                    if far > found.error {
                        // Beyond its own triangle's edge there is the next one.
                        let all = mesh
                            .faces()
                            .map(|f| [f[0], f[1], f[2]].map(|k| mesh.points()[k as usize].coords));
                        far = all.map(|other| to_triangle(on, other)).fold(far, f64::min);
                    }
                    assert!(far <= found.error * 1.000_001, "{p} {q} {rational}: {far} of {}", found.error);
                }
            }
            // What is inside the loops is covered.
            for i in 0..60 {
                for j in 0..60 {
                    let at = [f64::from(i) / 59.0, f64::from(j) / 59.0];
                    if !inside(&outer, at) || inside(&hole, at) || (i + j) % 7 != 0 {
                        continue;
                    }
                    let [u, v] = place(at);
                    let on = surface.point(u, v).unwrap().coords;
                    let near = mesh.faces().map(|f| {
                        to_triangle(on, [f[0], f[1], f[2]].map(|k| mesh.points()[k as usize].coords))
                    });
                    let near = near.fold(f64::INFINITY, f64::min);
                    assert!(near <= found.error * 1.000_001, "{p} {q} {rational}: {near} of {}", found.error);
                }
            }
        }
    }
}

#[test]
fn periodic_surfaces_are_trimmed_across_their_seams() {
    let circle = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap();
    let tube = Surface::extrusion(&circle, Vector::z() * 2.0).unwrap();
    let tube = tube.to_periodic(loftsman_kernel::spline::Direction::U, 1e-9).unwrap().shape;
    assert!(tube.u().is_periodic());
    let (a, b) = tube.u().domain();
    let length = b - a;
    let (c, d) = tube.v().domain();
    let middle = 0.5 * (c + d);
    // Around a window across the seam.
    let window: Vec<[f64; 2]> = [[-0.1, -0.2], [0.1, -0.2], [0.1, 0.2], [-0.1, 0.2]]
        .iter()
        .map(|[x, y]| [a + x * length, middle + y * (d - c)])
        .collect();
    let patch = cut(&trimmed(tube.clone(), polygon(&window), vec![]), 1e-4);
    let expected = 0.2 * TAU * 0.8;
    assert!((area(&patch.mesh) - expected).abs() < 0.02, "{}", area(&patch.mesh));
    let open = cut(&trimmed(tube, vec![], vec![polygon(&window)]), 1e-4);
    assert!((area(&open.mesh) - (2.0 * TAU - expected)).abs() < 0.02, "{}", area(&open.mesh));
}

#[test]
fn special_curves_and_points_are_followed() {
    let surface = wavy(3, 3, 6, false, 0.3);
    let line = polygon(&[[0.2, 0.3], [0.8, 0.6], [0.5, 0.5]])[..1].to_vec();
    let shape = Trimmed::new(surface.clone(), vec![], vec![line], vec![[0.7, 0.2]]).unwrap();
    let found = cut(&shape, 1e-3);
    let at = |u: f64, v: f64| surface.point(u, v).unwrap();
    for place in [at(0.7, 0.2), at(0.2, 0.3), at(0.8, 0.6)] {
        assert!(found.mesh.points().iter().any(|p| (p - place).norm() < 1e-12));
    }
    let ((u0, u1), (v0, v1)) = (surface.u().domain(), surface.v().domain());
    let on = found.mesh.uvs.values().iter().filter(|uv| {
        let [u, v] = [u0 + (u1 - u0) * uv[0], v0 + (v1 - v0) * uv[1]];
        let t = (u - 0.2) / 0.6;
        (-1e-9..=1.0 + 1e-9).contains(&t) && (v - (0.3 + 0.3 * t)).abs() < 1e-9
    });
    assert!(on.count() > 3);
}

#[test]
fn what_crosses_is_refused() {
    let refused = |shape: &Trimmed, says: &str| {
        let error = Adaptive::default().measured_trimmed(shape, &fineness(1e-2)).unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
    };
    let bow = polygon(&[[0.1, 0.1], [0.9, 0.9], [0.9, 0.1], [0.1, 0.9]]);
    refused(&trimmed(flat(1.0), bow, vec![]), "cross");
    refused(&trimmed(flat(1.0), ring(0.5, 0.5, 0.3, true), vec![ring(0.8, 0.5, 0.1, false)]), "cross");
    let nothing = polygon(&[[0.1, 0.1], [0.9, 0.1], [0.5, 0.1]]);
    let error = Adaptive::default().measured_trimmed(&trimmed(flat(1.0), nothing, vec![]), &fineness(1e-2));
    assert!(error.is_err());
    let fine = Adaptive { budget: 100 }.measured_trimmed(
        &trimmed(wavy(3, 3, 8, true, 0.1), vec![], vec![ring(3.0, 2.0, 0.1, true)]),
        &fineness(1e-6),
    );
    assert!(fine.unwrap_err().to_string().contains("coarser"));
}

#[test]
fn the_same_bytes_every_time() {
    let shape = trimmed(wavy(3, 3, 8, true, 0.1), vec![], vec![ring(3.0, 2.0, 0.5, true)]);
    let one = cut(&shape, 1e-3);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(one, pool.install(|| cut(&shape, 1e-3)));
}

/// Numbers in a fixed order, between 0 and 1 (Steele and Vigna's SplitMix64).
fn numbers(mut seed: u64) -> impl FnMut() -> f64 {
    move || {
        seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = seed;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A slanted border in many pieces that are one line, flat along it and with bumps right beside it, as faces have that were edited while their edges stayed:
/// triangles between corners on one line are no reason to give up, however much the surface bends beside them.
#[test]
fn slanted_borders_beside_bumps_are_cut() {
    let mut number = numbers(7);
    for case in 0..24 {
        let (cells, p) = (8 + case % 9, 2 + case % 3);
        let (left, right) = (0.2 + 0.3 * number(), 0.2 + 0.3 * number());
        let knots: Vec<f64> = (0..=cells).map(|k| k as f64 / cells as f64).collect();
        let space = Space::clamped(p, &knots).unwrap();
        let (flat, count) = (space.flat().to_vec(), space.len());
        let line = |u: f64| left + (right - left) * u;
        let greville = |i: usize| flat[i + 1..=i + p].iter().sum::<f64>() / p as f64;
        let mut net = Vec::new();
        for i in 0..count {
            for j in 0..count {
                let (a, b, low, high) = (flat[i], flat[i + p + 1], flat[j], flat[j + p + 1]);
                let apart = line(a).max(line(b)) < low || line(a).min(line(b)) > high;
                let height = if apart { 0.5 * (number() - 0.5) } else { 0.0 };
                net.push(Point::new(greville(i), greville(j), height));
            }
        }
        let surface = Surface::new(space.clone(), space, net).unwrap();
        let pieces = 1 + case % 4 * 3;
        let mut corners = vec![[1.0, 1.0], [0.0, 1.0]];
        corners.extend((0..=pieces).map(|k| k as f64 / pieces as f64).map(|u| [u, line(u)]));
        let shape = trimmed(surface.clone(), polygon(&corners), vec![]);
        for chord in [1e-2, 1e-3] {
            let found = cut(&shape, chord);
            if case % 6 == 0 {
                let (worst, _) = crate::common::deviation(&surface, &found.mesh, found.error);
                assert!(worst <= chord, "{case}: {worst}");
            }
        }
    }
}

/// Ten spans of a ten-thousandth each, in which a surface trembles by less than the tolerance, do not make its other triangles thin: it has some more, not many times as many.
#[test]
fn short_spans_that_bend_do_not_make_all_triangles_thin() {
    let around = Space::clamped(3, &[0.0, 1.0]).unwrap();
    let triangles = |trembles: bool| {
        let mut knots: Vec<f64> = (0..=20).map(|k| f64::from(k) / 20.0).collect();
        if trembles {
            knots.extend((1..=10).map(|k| 0.5 + 1e-4 * f64::from(k)));
            knots.sort_by(f64::total_cmp);
        }
        let along = Space::clamped(3, &knots).unwrap();
        let flat = along.flat();
        let greville = |j: usize| (flat[j + 1] + flat[j + 2] + flat[j + 3]) / 3.0;
        let mut net = Vec::new();
        for [y, z] in [[-1.0, 0.0], [-0.6, 1.0], [0.6, 1.0], [1.0, 0.0]] {
            for j in 0..along.len() {
                let v = greville(j);
                let tremble = if v > 0.5001 && v < 0.5009 && j % 2 == 0 { 1e-4 } else { 0.0 };
                net.push(Point::new(5.0 * v, y, z + (4.0 * v).sin() + tremble));
            }
        }
        let surface = Surface::new(around.clone(), along, net).unwrap();
        let square = polygon(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        cut(&trimmed(surface, square, vec![]), 1e-3).mesh.faces().count()
    };
    let (plain, trembling) = (triangles(false), triangles(true));
    assert!(trembling < 3 * plain, "{plain} {trembling}");
}

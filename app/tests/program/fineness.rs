//! How fine the triangles of a glTF file are, measured on the file: as near as 1e-4 of the scene's diagonal, and not much nearer.

use std::f64::consts::TAU;

use loftsman::kernel::Point;
use loftsman::kernel::scene::{Object, Scene, Unit, Up};
use loftsman::kernel::shape::Shape;
use loftsman::kernel::spline::{Space, Surface};
use serde_json::Value;

use crate::LOFTSMAN;

/// The positions and triangles of the only mesh of a `.glb`, as other programs see it.
fn triangles(bytes: &[u8]) -> (Vec<Point>, Vec<[usize; 3]>) {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    let json = word(12);
    let document: Value = serde_json::from_slice(&bytes[20..20 + json]).unwrap();
    let blob = &bytes[28 + json..];
    let primitive = &document["meshes"][0]["primitives"][0];
    assert!(
        document["meshes"].as_array().unwrap().len() == 1 && primitive["mode"].as_u64().unwrap_or(4) == 4
    );
    let part = |accessor: &Value| {
        let accessor = &document["accessors"][accessor.as_u64().unwrap() as usize];
        let view = &document["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let at = |value: &Value| value["byteOffset"].as_u64().unwrap_or(0) as usize;
        let kind = accessor["componentType"].as_u64().unwrap();
        (
            &blob[at(view) + at(accessor)..],
            accessor["count"].as_u64().unwrap() as usize,
            kind,
            view["byteStride"].as_u64(),
        )
    };
    let (data, count, kind, stride) = part(&primitive["attributes"]["POSITION"]);
    assert_eq!(kind, 5126);
    let stride = stride.map_or(12, |stride| stride as usize);
    let number = |at: usize| f64::from(f32::from_le_bytes(data[at..at + 4].try_into().unwrap()));
    let points = (0..count).map(|k| Point::from([0, 4, 8].map(|c| number(k * stride + c)))).collect();
    let (data, count, kind, _) = part(&primitive["indices"]);
    let index = |k: usize| match kind {
        5123 => usize::from(u16::from_le_bytes(data[2 * k..2 * k + 2].try_into().unwrap())),
        5125 => u32::from_le_bytes(data[4 * k..4 * k + 4].try_into().unwrap()) as usize,
        other => panic!("indices of type {other}"),
    };
    (points, (0..count / 3).map(|k| [3 * k, 3 * k + 1, 3 * k + 2].map(index)).collect())
}

/// A bent sheet, tube or cup of a degree.
fn shapes() -> Vec<(String, Surface)> {
    let mut all = Vec::new();
    for degree in [2, 3, 4, 5, 7] {
        for (kind, v) in [
            ("clamped", Space::clamped_uniform(degree, degree + 3).unwrap()),
            ("floating", Space::floating_uniform(degree, degree + 3).unwrap()),
            ("periodic", Space::periodic_uniform(degree, degree + 5).unwrap()),
        ] {
            let u = Space::clamped(2, &[0.0, 0.3, 1.0, 1.2]).unwrap();
            let (rows, columns) = (u.len(), v.len());
            let at = |k: usize| {
                let (i, j) = ((k / columns) as f64, (k % columns) as f64);
                let (s, c) = (TAU * j / columns as f64).sin_cos();
                let wide = 2.0 + (1.3 * i).sin();
                if kind == "periodic" {
                    Point::new(wide * c, wide * s, i)
                } else {
                    Point::new(2.0 * i, j, s + 0.3 * wide)
                }
            };
            for rational in [false, true] {
                let weights =
                    rational.then(|| (0..rows * columns).map(|k| 1.0 + 0.5 * (k as f64).sin()).collect());
                let points = (0..rows * columns).map(at).collect();
                let surface = Surface::build(u.clone(), v.clone(), points, weights).unwrap();
                all.push((
                    format!("{kind} {degree} {}", if rational { "rational" } else { "polynomial" }),
                    surface,
                ));
            }
        }
    }
    all
}

#[test]
fn triangles_are_as_near_as_a_ten_thousandth_of_the_diagonal_and_not_much_nearer() {
    let (mut done, mut largest) = (0, 0.0_f64);
    for (number, (name, surface)) in shapes().into_iter().enumerate() {
        let size = [1e-3, 1.0, 1e4][number % 3];
        let bench = LOFTSMAN.bench();
        let mut shape = surface.clone();
        shape.control_vertices_mut().iter_mut().for_each(|at| *at *= size);
        let mut scene = Scene::new();
        scene.unit = Unit::Metre;
        scene.up = Up::Y;
        scene.add(Object::new("shape", shape.clone().into())).unwrap();
        loftsman::write(&scene, bench.path("shape.loft.json")).unwrap();
        bench.done(&["convert", "shape.loft.json", "shape.glb"]);
        let (points, faces) = triangles(&bench.read("shape.glb"));
        let (low, high) = shape.bounds();
        let diagonal = (high - low).norm();
        let mut off = 0.0_f64;
        let stride = (faces.len() / 120).max(1);
        for [a, b, c] in faces.iter().step_by(stride).map(|face| face.map(|k| points[k].coords)) {
            for middle in [(a + b + c) / 3.0, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)] {
                off = off.max(shape.closest(Point::from(middle)).unwrap().distance);
            }
        }
        let share = off / diagonal;
        assert!(share <= 1e-4, "{name} at {size}: {share:e} of the diagonal with {} triangles", faces.len());
        // A tenth of it would be ten times as many triangles as are needed.
        assert!(share >= 1e-5, "{name} at {size}: {share:e} of the diagonal with {} triangles", faces.len());
        largest = largest.max(share);
        done += 1;
    }
    assert!(done == 30 && largest > 3e-5, "{done} {largest:e}");
}

/// Limits of a cube of either scheme need some ten thousands of triangles at most: round extraordinary points no more than elsewhere.
#[test]
fn limits_of_cages_are_cut_as_finely_as_they_need() {
    let bench = LOFTSMAN.bench();
    let cube = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    bench.write("cube.obj", cube);
    for scheme in ["catmull-clark", "doo-sabin"] {
        let recipe = format!(
            "input = 'cube.obj'\noutput = 'cube.glb'\n[[step]]\nop = 'subdivide'\nscheme = '{scheme}'\nsurface = true\n"
        );
        bench.write("r.toml", recipe);
        bench.done(&["run", "r.toml"]);
        let (points, triangles) = triangles(&bench.read("cube.glb"));
        assert!((500..150_000).contains(&triangles.len()), "{scheme}: {} triangles", triangles.len());
        let corner = |axis: usize| {
            points.iter().fold((f64::MAX, f64::MIN), |m, p| (m.0.min(p[axis]), m.1.max(p[axis])))
        };
        assert!(
            (0..3).all(|axis| corner(axis).0 > -1e-6 && corner(axis).1 < 1.000001),
            "{scheme}: within the cage"
        );
    }
}

/// A length that is asked for, and one that is told, is in the unit of the scene, whatever unit and axes the file gets.
#[test]
fn tolerances_are_in_the_scenes_unit_whatever_the_files_is() {
    let mut cut = 0;
    for (name, surface) in shapes().into_iter().step_by(3) {
        for unit in [Unit::Millimetre, Unit::Inch] {
            let bench = LOFTSMAN.bench();
            let mut scene = Scene::new();
            scene.unit = unit;
            scene.up = Up::Z;
            let (low, high) = surface.bounds();
            let tolerance = format!("{}", 2e-4 * (high - low).norm());
            scene.add(Object::new("shape", surface.clone().into())).unwrap();
            loftsman::write(&scene, bench.path("shape.loft.json")).unwrap();
            let mut all = Vec::new();
            for asked in
                [&[][..], &["--up", "z"], &["--up", "x"], &["--unit", "mm"], &["--unit", "m", "--up", "keep"]]
            {
                let mut words = vec!["convert", "shape.loft.json", "shape.glb", "--tolerance", &tolerance];
                words.extend(asked);
                let told = bench.done(&words);
                let within = told.split_once("triangles, within ").unwrap().1;
                let within = within.split_whitespace().take(2).collect::<Vec<_>>().join(" ");
                all.push((triangles(&bench.read("shape.glb")).1.len(), within));
                std::fs::remove_file(bench.path("shape.glb")).unwrap();
            }
            // The last digit of a measured length may be another one.
            let number = |text: &str| text.split(' ').next().unwrap().parse::<f64>().unwrap();
            for (count, within) in &all {
                assert_eq!(*count, all[0].0, "{name}: {all:?}");
                assert!(within.ends_with(all[0].1.split(' ').nth(1).unwrap()), "{name}: {all:?}");
                assert!((number(within) / number(&all[0].1) - 1.0).abs() < 2e-3, "{name}: {all:?}");
            }
            cut += all.len();
        }
    }
    assert!(cut >= 50);
}

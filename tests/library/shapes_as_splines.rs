//! Shapes of plug-ins that are splines exactly go out to formats of splines as these; others are left out, and what makes splines of them is
//! named.

use loftsman::kernel::Point;
use loftsman::kernel::plugin::{CustomShape, Fate, Memory, ReadOptions, Splines, WriteOptions};
use loftsman::kernel::scene::{Geometry, Object, Scene, Unit};
use loftsman::subdivision::doo_sabin::DooSabinSurface;
use loftsman::subdivision::{Cage, SubdivisionSurface, catmull_clark};

/// A torus of quads: the first `rows` of seven round the axis, all of them for a closed one, five round the tube.
fn torus(rows: usize) -> Cage {
    let point = |k: usize| {
        let angle = |at: usize, of: f64| (at as f64 * std::f64::consts::TAU / of).sin_cos();
        let ((s, c), (t, d)) = (angle(k / 5, 7.0), angle(k % 5, 5.0));
        Point::new((3.0 + d) * c, (3.0 + d) * s, t)
    };
    let at = |i: usize, j: usize| i % 7 * 5 + j % 5;
    let face = |k: usize| {
        let (i, j) = (k / 5, k % 5);
        [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]
    };
    let count = if rows < 7 { rows + 1 } else { 7 };
    Cage::new((0..5 * count).map(point).collect(), &(0..5 * rows).map(face).collect::<Vec<_>>()).unwrap()
}

fn cube() -> Cage {
    let corner = |k: usize| Point::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Cage::new((0..8).map(corner).collect(), &faces).unwrap()
}

fn scene(shape: CustomShape) -> Scene {
    let mut scene = Scene::new();
    scene.unit = Unit::Millimetre;
    scene.add(Object::new("ring", shape.into())).unwrap();
    scene
}

#[test]
fn what_is_regular_goes_out_as_its_splines() {
    let registry = loftsman::registry();
    let shapes: [CustomShape; 4] = [
        SubdivisionSurface::new(torus(7)).unwrap().into(),
        SubdivisionSurface::new(torus(4)).unwrap().into(),
        DooSabinSurface::new(torus(7)).unwrap().into(),
        DooSabinSurface::new(torus(4)).unwrap().into(),
    ];
    for shape in shapes {
        let Some(Splines::Surfaces(own)) = shape.splines() else { panic!("it is all splines") };
        let scene = scene(shape);
        for name in ["step", "iges"] {
            let format = registry.formats().iter().find(|format| format.declaration().name == name).unwrap();
            let mut file = Memory::new(format!("t.{name}"), "");
            let told = format.losses(&scene, &WriteOptions::default()).unwrap();
            assert!(told.iter().any(|line| line.contains("goes out as the splines that it is")), "{told:?}");
            let report = format.write(&scene, &mut file, &WriteOptions::default()).unwrap();
            let of = &report.objects[0];
            assert_ne!(of.fate, Fate::LeftOut, "{:?}", of.reason);
            assert_eq!(of.form, "B-spline surfaces");
            assert!(
                of.reason.as_deref().unwrap().contains("the splines that it is exactly"),
                "{:?}",
                of.reason
            );
            let (read, _) = format.read(&file, &ReadOptions::default()).unwrap();
            let found: Vec<_> = read
                .objects()
                .iter()
                .filter_map(|object| match object.geometry() {
                    Geometry::Surface(surface) => Some(surface),
                    _ => None,
                })
                .collect();
            assert_eq!(found.len(), own.len(), "{name}");
            for (found, own) in found.iter().zip(&own) {
                let clamped = own.clamped().unwrap();
                assert_eq!(found.points().len(), clamped.points().len());
                let [(a, b), (c, d)] = [clamped.u().domain(), clamped.v().domain()];
                let [(e, f), (g, h)] = [found.u().domain(), found.v().domain()];
                for k in 0..=12 {
                    let (s, t) = (f64::from(k) / 12.0, f64::from(k * 5 % 13) / 12.0);
                    let p = clamped.point(a + (b - a) * s, c + (d - c) * t).unwrap();
                    let q = found.point(e + (f - e) * s, g + (h - g) * t).unwrap();
                    assert!((p - q).norm() < 1e-13, "{name}: {p} {q}");
                }
            }
        }
    }
}

#[test]
fn what_is_none_says_who_makes_some() {
    let registry = loftsman::registry();
    let shapes: [CustomShape; 2] = [
        SubdivisionSurface::new(cube()).unwrap().into(),
        DooSabinSurface::new(catmull_clark::refine(&cube()).unwrap()).unwrap().into(),
    ];
    for shape in shapes {
        let kind = shape.kind().to_owned();
        let scene = scene(shape);
        for (name, word) in [("step", "STEP"), ("iges", "IGES")] {
            let format = registry.formats().iter().find(|format| format.declaration().name == name).unwrap();
            let report = format.write(&scene, &mut Memory::new("t", ""), &WriteOptions::default()).unwrap();
            assert_eq!(report.objects[0].fate, Fate::LeftOut);
            assert_eq!(
                report.objects[0].reason.as_deref().unwrap(),
                format!(
                    "{word} has no {kind}, and this one is no splines exactly: the operation \"patches\" makes some of it, within a tolerance"
                )
            );
        }
    }
}

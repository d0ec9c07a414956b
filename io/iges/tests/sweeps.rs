//! Curves along vectors and about axes, by themselves, stay what they are.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::f64::consts::TAU;

use loftsman_iges::Iges;
use loftsman_kernel::brep::{CurveForm, Frame, SurfaceForm};
use loftsman_kernel::plugin::{Format, Memory, ReadOptions, WriteOptions};
use loftsman_kernel::scene::{Geometry, Object, Scene, Unit};
use loftsman_kernel::spline::{Curve, CurvePiece, Space, Surface, SurfacePiece};
use loftsman_kernel::{Point, Vector};
use nalgebra::Matrix4;

use crate::common::{Entity, entity, file};

fn write(scene: &Scene, unit: Option<Unit>) -> String {
    let mut memory = Memory::new("t.igs", Vec::new());
    let report = Iges.write(scene, &mut memory, &WriteOptions { unit, ..WriteOptions::default() }).unwrap();
    assert!(report.notes.is_empty(), "{report:?}");
    String::from_utf8(memory.bytes).unwrap()
}

fn read(text: &str) -> Vec<Surface> {
    let (scene, report) = Iges.read(&Memory::new("t.igs", text), &ReadOptions::default()).unwrap();
    assert!(report.adds_up() && report.left_out.is_empty(), "{report:?}");
    let surface = |object: &Object| match object.geometry() {
        Geometry::Surface(surface) => Some(surface.clone()),
        _ => None,
    };
    scene.objects().iter().filter_map(surface).collect()
}

/// Profiles: a spline, an arc, an ellipse, a parabola and a line.
fn profiles() -> Vec<Curve> {
    let frame = Frame::new(Point::new(9.0, 1.0, 2.0), Vector::new(0.1, 1.0, 0.2), Vector::x()).unwrap();
    let knots = Space::clamped(3, &[-1.0, 1.0, 2.5]).unwrap();
    let points = (0..5).map(|k| Point::new(8.0 + f64::from(k * k), f64::from(k), 1.5)).collect();
    let spline = Curve::rational(knots, points, vec![1.0, 2.0, 1.5, 0.5, 1.0]).unwrap();
    let arc = |[a, b]: [f64; 2], [from, to]: [f64; 2]| {
        let form = if a == b {
            CurveForm::Circle { frame, radius: a }
        } else {
            CurveForm::Ellipse { frame, radii: [a, b] }
        };
        let curve = Curve::elliptic_arc(frame.origin, frame.x * a, frame.y() * b, from, to - from).unwrap();
        curve.with_form(CurvePiece { form, range: [from, to] }).unwrap()
    };
    let form = CurveForm::Parabola { frame, focal: 0.5 };
    let at = |a: f64, b: f64| frame.origin + frame.x * (0.5 * a * b) + frame.y() * (0.5 * (a + b));
    let parabola = Curve::new(
        Space::clamped(2, &[0.0, 1.0]).unwrap(),
        vec![at(-1.0, -1.0), at(-1.0, 1.5), at(1.5, 1.5)],
    );
    let line = Curve::line(Point::new(8.0, 0.0, 0.0), Point::new(9.0, 4.0, 1.0)).unwrap();
    vec![
        spline,
        arc([2.0; 2], [0.0, TAU]),
        arc([2.0; 2], [-0.5, 2.0]),
        arc([1.0, 2.5], [0.25, 3.0]),
        parabola.unwrap().with_form(CurvePiece { form, range: [-1.0, 1.5] }).unwrap(),
        line.with_form(CurvePiece::LINE).unwrap(),
    ]
}

fn family() -> Vec<Surface> {
    let axis = (Point::new(1.0, -2.0, 0.5), Vector::new(0.3, -0.5, 0.8));
    let mut all = Vec::new();
    for profile in profiles() {
        let of = profile.form().copied();
        for sweep in [TAU, 1.25, -2.0] {
            let surface = Surface::revolution(&profile, axis.0, axis.1, sweep).unwrap();
            let piece = SurfacePiece::turned(&surface, axis, sweep, of).unwrap();
            all.push(surface.with_form(piece).unwrap());
        }
        if of != Some(CurvePiece::LINE) {
            let surface = Surface::extrusion(&profile, Vector::new(1.0, 5.0, -3.0)).unwrap();
            let piece = SurfacePiece::extruded(&surface, of);
            all.push(surface.with_form(piece).unwrap());
        }
    }
    all
}

/// How far two surfaces are from one another at equal shares of their domains.
fn off(one: &Surface, other: &Surface) -> f64 {
    let share = |(a, b): (f64, f64), k: u32| a + (b - a) * f64::from(k) / 6.0;
    let at =
        |s: &Surface, k: u32| s.point(share(s.u().domain(), k / 7), share(s.v().domain(), k % 7)).unwrap();
    (0..49).map(|k| (at(one, k) - at(other, k)).amax()).fold(0.0, f64::max)
}

fn profile(surface: &Surface) -> &'static str {
    match surface.form().unwrap().form {
        SurfaceForm::Extrusion { profile, .. } | SurfaceForm::Revolution { profile, .. } => profile.name(),
        form => form.name(),
    }
}

#[test]
fn sweeps_are_written_and_read_as_what_they_are() {
    for unit in [None, Some(Unit::Inch), Some(Unit::Metre)] {
        let mut scene = Scene::new();
        for (k, surface) in family().into_iter().enumerate() {
            scene.add(Object::new(k.to_string(), surface.into())).unwrap();
        }
        let scale = unit.map_or(1.0, |unit| scene.unit.metres().unwrap() / unit.metres().unwrap());
        let found = read(&write(&scene, unit));
        assert_eq!(found.len(), family().len());
        let mut again = Scene::new();
        for (was, is) in family().iter().zip(&found) {
            let was = was.transformed(&Matrix4::new_scaling(scale)).unwrap();
            assert!(off(&was, is) <= 1e-12 * 40.0 * scale, "{:?}: {:e}", was.form(), off(&was, is));
            assert!(is.form().is_some(), "{:?}", was.form());
            assert_eq!(was.form().unwrap().noun(), is.form().unwrap().noun());
            assert_eq!(profile(&was), profile(is));
            again.add(Object::new(again.objects().len().to_string(), is.clone().into())).unwrap();
        }
        for (one, other) in found.iter().zip(read(&write(&again, None))) {
            assert!(other.form().is_some() && off(one, &other) <= 1e-12 * 40.0 * scale);
        }
    }
}

/// An ellipse in the plane of x and z, turned from an angle on, and along a vector, both under a matrix.
#[test]
fn sweeps_are_those_of_the_file() {
    let matrix = "124,0.,-1.,0.,1.,1.,0.,0.,2.,0.,0.,1.,3.;";
    let ellipse = "104,1.,0.,4.,0.,0.,-4.,0.,2.,0.,0.,1.;";
    let find = |sweep: &str| {
        let all = [
            Entity { status: "00010000", ..entity(0, "110,5.,0.,0.,5.,2.,0.;") },
            Entity { status: "00010000", form: 1, ..entity(0, ellipse) },
            Entity { matrix: 7, ..entity(0, sweep) },
            entity(0, matrix),
        ];
        read(&file(&all)).remove(0)
    };
    let moved = |p: Point| Point::new(1.0 - p.y, 2.0 + p.x, 3.0 + p.z);
    let ends = |surface: &Surface| {
        let ((a, b), (c, d)) = (surface.u().domain(), surface.v().domain());
        [(a, c), (b, c), (a, d)].map(|(u, v)| surface.point(u, v).unwrap())
    };
    let turned = find("120,1,3,0.5,2.;");
    assert_eq!((turned.form().unwrap().noun(), profile(&turned)), ("revolution", "ellipse"));
    let at = |angle: f64, p: Point| {
        let r = p.x - 5.0;
        moved(Point::new(5.0 + r * angle.cos(), p.y, -r * angle.sin()))
    };
    let [start, end] = [Point::new(2.0, 0.0, 0.0), Point::new(0.0, 1.0, 0.0)];
    for (found, expected) in ends(&turned).iter().zip([at(0.5, start), at(2.0, start), at(0.5, end)]) {
        assert!((found - expected).amax() < 1e-14, "{found} {expected}");
    }
    let extruded = find("122,3,2.,1.,4.;");
    assert_eq!((extruded.form().unwrap().noun(), profile(&extruded)), ("extrusion", "ellipse"));
    let along = Vector::new(0.0, 1.0, 4.0);
    for (found, expected) in ends(&extruded).iter().zip([start, end, start + along].map(moved)) {
        assert!((found - expected).amax() < 1e-14, "{found} {expected}");
    }
}

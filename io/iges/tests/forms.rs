//! Lines and conics by themselves stay what they are.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use std::f64::consts::{PI, TAU};

use loftsman_iges::Iges;
use loftsman_kernel::brep::CurveForm;
use loftsman_kernel::conformance::{same_forms, sample_forms};
use loftsman_kernel::plugin::{Format, Memory, ReadOptions, WriteOptions};
use loftsman_kernel::scene::{Geometry, Scene, Unit};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::spline::{Curve, CurvePiece, Direction};
use loftsman_kernel::{Point, Vector};
use nalgebra::Matrix4;

use crate::common::{Entity, entity, file};

fn write(scene: &Scene, unit: Option<Unit>) -> String {
    let mut memory = Memory::new("t.igs", Vec::new());
    let report = Iges.write(scene, &mut memory, &WriteOptions { unit, ..WriteOptions::default() }).unwrap();
    assert!(report.notes.is_empty(), "{report:?}");
    String::from_utf8(memory.bytes).unwrap()
}

/// How many B-spline curves (126) a file has.
fn splines(text: &str) -> usize {
    of_type(text, 126)
}

/// How many B-spline surfaces (128) it has.
fn sheets(text: &str) -> usize {
    of_type(text, 128)
}

fn of_type(text: &str, kind: u32) -> usize {
    let starts = format!("{kind:8}");
    text.lines().filter(|line| line.starts_with(&starts) && line.get(72..73) == Some("D")).count() / 2
}

fn read(text: &str) -> Scene {
    let (scene, report) = Iges.read(&Memory::new("t.igs", text), &ReadOptions::default()).unwrap();
    assert!(report.adds_up() && report.left_out.is_empty(), "{report:?}");
    scene
}

#[test]
fn every_form_is_written_and_read_as_what_it_is() {
    let scene = sample_forms().unwrap();
    let text = write(&scene, None);
    assert_eq!(splines(&text), 0, "{text}");
    let second = read(&text);
    let verdict = same_forms(&scene, &second);
    assert!(verdict.passed(), "{verdict}");
    // From there on nothing changes, but surfaces by rounding: what is turned has neither its axis nor its place around that as numbers.
    let third = read(&write(&second, None));
    assert!(same_forms(&second, &third).passed());
    assert_eq!(second.objects().len(), third.objects().len());
    for (before, after) in second.objects().iter().zip(third.objects()) {
        assert!(before == after || matches!(before.geometry(), Geometry::Surface(_)), "{}", before.name());
    }
}

#[test]
fn forms_go_along_to_other_units() {
    let scene = sample_forms().unwrap();
    for unit in [Unit::Inch, Unit::Metre, Unit::Micrometre] {
        let text = write(&scene, Some(unit));
        assert_eq!(splines(&text), 0, "{text}");
        let found = read(&text);
        assert_eq!(found.unit, unit);
        let verdict = same_forms(&scene.converted(unit, scene.up).unwrap(), &found);
        assert!(verdict.passed(), "{unit:?}: {verdict}");
    }
}

/// What is moved, cut or stretched is a spline, and what is stretched on the way out, too; lines are lines under any map.
#[test]
fn what_was_edited_is_written_as_a_spline() {
    let scene = sample_forms().unwrap();
    for object in scene.objects() {
        let Geometry::Curve(curve) = object.geometry() else { continue };
        let is_line = curve.form().unwrap().form == CurveForm::Line;
        let count = |geometry: Geometry, transform: Option<Matrix4<f64>>| {
            let mut scene = Scene::new();
            let mut object = loftsman_kernel::scene::Object::new("c", geometry);
            object.transform = transform;
            scene.add(object).unwrap();
            let text = write(&scene, None);
            assert!(matches!(read(&text).objects()[0].geometry(), Geometry::Curve(_)));
            splines(&text)
        };
        assert_eq!(count(curve.clone().into(), None), 0);
        let mut moved = curve.clone();
        moved.control_vertices_mut()[0].x += 1e-9;
        let (a, b) = curve.domain();
        let half = curve.between(a, 0.5 * (a + b)).unwrap();
        for other in [moved, half, curve.elevate(1).unwrap()] {
            assert_eq!(count(other.into(), None), 1);
        }
        let points = curve.points().iter().map(|p| p + Vector::x() * 0.25).collect();
        assert_eq!(count(object.geometry().with_points(points).unwrap(), None), 1);
        let stretch = Matrix4::new_nonuniform_scaling(&Vector::new(1.0, 2.0, 1.0));
        assert_eq!(count(curve.clone().into(), Some(stretch)), usize::from(!is_line));
        assert_eq!(count(curve.clone().into(), Some(Matrix4::new_scaling(3.0))), 0);
        assert_eq!(count(curve.clone().into(), Some(Matrix4::new_scaling(-3.0))), 0);
    }
}

/// The same of surfaces; a mirror image is of the same form, but of a cone.
#[test]
fn surfaces_that_were_edited_are_written_as_splines() {
    for object in sample_forms().unwrap().objects() {
        let Geometry::Surface(surface) = object.geometry() else { continue };
        let count = |geometry: Geometry, transform: Option<Matrix4<f64>>| {
            let mut scene = Scene::new();
            let mut object = loftsman_kernel::scene::Object::new("s", geometry);
            object.transform = transform;
            scene.add(object).unwrap();
            let text = write(&scene, None);
            let found = read(&text);
            let surface = |o: &loftsman_kernel::scene::Object| match o.geometry() {
                Geometry::Surface(surface) => Some(surface.form().is_none()),
                _ => None,
            };
            assert_eq!(found.objects().iter().filter_map(surface).collect::<Vec<_>>(), [sheets(&text) > 0]);
            sheets(&text)
        };
        assert_eq!(count(surface.clone().into(), None), 0, "{}", object.name());
        let mut moved = surface.clone();
        moved.control_vertices_mut()[0].x += 1e-9;
        let reversed = surface.reverse(Direction::U).unwrap();
        for other in [moved, reversed, surface.elevate(Direction::V, 1).unwrap()] {
            assert_eq!(count(other.into(), None), 1);
        }
        let stretch = Matrix4::new_nonuniform_scaling(&Vector::new(1.0, 2.0, 1.0));
        assert_eq!(count(surface.clone().into(), Some(stretch)), 1);
        assert_eq!(count(surface.clone().into(), Some(Matrix4::new_scaling(3.0))), 0);
        let mirror = Matrix4::new_nonuniform_scaling(&Vector::new(-2.0, 2.0, 2.0));
        // Where it is placed it is not written otherwise.
        assert_eq!(count(surface.clone().into(), Some(mirror)), 0);
    }
}

/// One entity, placed by a matrix where there is one.
fn one(form: i32, parameters: &str, matrix: Option<&str>) -> Curve {
    let mut entities =
        vec![Entity { matrix: if matrix.is_some() { 3 } else { 0 }, ..entity(form, parameters) }];
    entities.extend(matrix.map(|matrix| entity(0, matrix)));
    let scene = read(&file(&entities));
    let Geometry::Curve(curve) = scene.objects()[0].geometry().clone() else { panic!("{parameters}") };
    curve
}

/// What the specification says of lines, arcs and conics.
#[test]
fn forms_are_those_of_the_file() {
    let of = |curve: &Curve| *curve.form().unwrap();
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-13, "{a} {b}");
    assert_eq!(of(&one(0, "110,1.,2.,3.,4.,5.,6.;", None)), CurvePiece::LINE);

    // About (1, 2) at z = 3, from below to the left; and the same seen from behind and moved.
    let arc = one(0, "100,3.,1.,2.,1.,0.,-1.,2.;", None);
    let CurveForm::Circle { frame, radius } = of(&arc).form else { panic!() };
    assert_eq!(
        (frame.origin, frame.x, frame.z, radius),
        (Point::new(1.0, 2.0, 3.0), -Vector::y(), Vector::z(), 2.0)
    );
    near(of(&arc).range[1], 1.5 * PI);
    assert_eq!(arc.points().last(), Some(&Point::new(-1.0, 2.0, 3.0)));
    let matrix = "124,1.,0.,0.,10.,0.,-1.,0.,0.,0.,0.,-1.,0.;";
    let behind = one(0, "100,3.,1.,2.,1.,0.,-1.,2.;", Some(matrix));
    let CurveForm::Circle { frame, .. } = of(&behind).form else { panic!() };
    assert_eq!((frame.origin, frame.x, frame.z), (Point::new(11.0, -2.0, -3.0), Vector::y(), -Vector::z()));
    assert_eq!(of(&one(0, "100,3.,1.,2.,1.,0.,1.,0.;", None)).range, [0.0, TAU]);

    // x²/9 + y² = 1 about (2, 1), a quarter of it.
    let ellipse = one(1, "104,1.,0.,9.,-4.,-18.,4.,0.,5.,1.,2.,2.;", None);
    let CurveForm::Ellipse { frame, radii } = of(&ellipse).form else { panic!() };
    near((frame.origin - Point::new(2.0, 1.0, 0.0)).norm(), 0.0);
    near(radii[0], 3.0);
    near(radii[1], 1.0);
    near(of(&ellipse).range[1] - of(&ellipse).range[0], PI / 2.0);
    // y = x²/4 + 1 from (-2, 2) to (4, 5), and the other way: focal length 1.
    for (ends, noun) in [("-2.,2.,4.,5.", "forth"), ("4.,5.,-2.,2.", "back")] {
        let parabola = of(&one(3, &format!("104,1.,0.,0.,0.,-4.,4.,7.,{ends};"), None));
        let CurveForm::Parabola { frame, focal } = parabola.form else { panic!("{noun}") };
        near(focal, 1.0);
        near((frame.origin - Point::new(0.0, 1.0, 7.0)).norm(), 0.0);
        near((frame.x - Vector::y()).norm(), 0.0);
        let expected = if noun == "forth" { [-1.0, 2.0] } else { [-2.0, 1.0] };
        near(parabola.range[0], expected[0]);
        near(parabola.range[1], expected[1]);
    }
    // x²/4 - y² = 1, both branches, and x y = 1.
    for (sign, ends) in [(1.0, [-0.5, 1.25_f64]), (-1.0, [1.25, -0.5])] {
        let [a, b] = ends.map(|t| format!("{:?},{:?}", sign * 2.0 * t.cosh(), t.sinh()));
        let hyperbola = of(&one(2, &format!("104,1.,0.,-4.,0.,0.,-4.,0.,{a},{b};"), None));
        let CurveForm::Hyperbola { frame, radii } = hyperbola.form else { panic!() };
        near(radii[0], 2.0);
        near(radii[1], 1.0);
        near((frame.x - Vector::x() * sign).norm(), 0.0);
        // From below, seen from the other side.
        near(hyperbola.range[0], if sign > 0.0 { -0.5 } else { -1.25 });
        near(hyperbola.range[1], if sign > 0.0 { 1.25 } else { 0.5 });
    }
    let turned = of(&one(2, "104,0.,1.,0.,0.,0.,-1.,0.,0.25,4.,3.,0.3333333333333333;", None));
    let CurveForm::Hyperbola { radii, .. } = turned.form else { panic!() };
    near(radii[0], 2.0_f64.sqrt());
    near(radii[1], 2.0_f64.sqrt());
    // Where the ends are off the parabola by more than rounding a spline through them is left.
    let near_it = one(3, "104,1.,0.,0.,0.,-4.,4.,7.,-2.,2.,4.,5.0001;", None);
    assert!(near_it.form().is_none());
    assert_eq!(near_it.points().last(), Some(&Point::new(4.0, 5.0001, 7.0)));
}

/// Lines and arcs that are turned, whichever way they run and the axis points.
#[test]
fn surfaces_of_revolution_are_what_their_profiles_make_them() {
    let turned = |generatrix: &str, matrix: i32, axis: &str, angles: &str| {
        let turned = format!("120,1,3,{angles};");
        let mut all = vec![
            Entity { status: "00010000", ..entity(0, axis) },
            Entity { status: "00010000", matrix, ..entity(0, generatrix) },
            entity(0, &turned),
        ];
        if matrix > 0 {
            all.push(entity(0, "124,1.,0.,0.,0.,0.,0.,-1.,0.,0.,1.,0.,0.;"));
        }
        let scene = read(&file(&all));
        let Geometry::Surface(surface) = scene.objects()[0].geometry().clone() else {
            panic!("{generatrix}")
        };
        *surface.form().unwrap()
    };
    let (up, down) = ("110,0.,0.,0.,0.,0.,5.;", "110,0.,0.,5.,0.,0.,0.;");
    for axis in [up, down] {
        for (line, noun) in [
            ("110,2.,0.,1.,2.,0.,4.;", "cylinder"),
            ("110,2.,0.,4.,2.,0.,1.;", "cylinder"),
            ("110,2.,0.,1.,3.,0.,4.;", "cone"),
            ("110,3.,0.,4.,0.,0.,1.;", "cone"),
        ] {
            assert_eq!(turned(line, 0, axis, "0.5,2.").noun(), noun, "{line}");
            assert_eq!(turned(line, 0, axis, "0.,6.283185307179586").noun(), noun, "{line}");
        }
        // In the plane of x and z: half a circle about the origin, and a whole one beside the axis.
        assert_eq!(turned("100,0.,0.,0.,0.,-2.,0.,2.;", 7, axis, "0.,6.283185307179586").noun(), "sphere");
        assert_eq!(turned("100,0.,0.,0.,1.2,-1.6,1.6,1.2;", 7, axis, "0.25,3.").noun(), "sphere");
        assert_eq!(turned("100,0.,5.,0.,6.,0.,6.,0.;", 7, axis, "0.,6.283185307179586").noun(), "torus");
        assert_eq!(turned("100,0.,5.,0.,5.,1.,4.,0.;", 7, axis, "1.,2.").noun(), "torus");
    }
}

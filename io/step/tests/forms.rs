//! Lines and conics by themselves stay what they are.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use std::f64::consts::{PI, TAU};

use loftsman_kernel::brep::CurveForm;
use loftsman_kernel::conformance::{same_forms, sample_forms};
use loftsman_kernel::plugin::{Format, Memory, ReadOptions, WriteOptions};
use loftsman_kernel::scene::{Geometry, Scene, Unit};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::spline::{Curve, CurvePiece, Direction};
use loftsman_kernel::{Point, Vector};
use loftsman_step::Step;
use nalgebra::Matrix4;

use crate::common;

fn write(scene: &Scene, unit: Option<Unit>) -> String {
    let mut memory = Memory::new("t.step", Vec::new());
    let report = Step.write(scene, &mut memory, &WriteOptions { unit, ..WriteOptions::default() }).unwrap();
    assert!(report.notes.is_empty(), "{report:?}");
    String::from_utf8(memory.bytes).unwrap()
}

fn read(text: &str) -> Scene {
    let (scene, report) = Step.read(&Memory::new("t.step", text), &ReadOptions::default()).unwrap();
    assert!(report.adds_up(), "{report:?}");
    scene
}

#[test]
fn every_form_is_written_and_read_as_what_it_is() {
    let scene = sample_forms().unwrap();
    let text = write(&scene, None);
    assert!(!text.contains("SPLINE"), "{text}");
    let second = read(&text);
    let verdict = same_forms(&scene, &second);
    assert!(verdict.passed(), "{verdict}");
    // From there on nothing changes.
    let third = read(&write(&second, None));
    assert!(third == second);
}

#[test]
fn forms_go_along_to_other_units() {
    let scene = sample_forms().unwrap();
    for unit in [Unit::Inch, Unit::Metre, Unit::Kilometre] {
        let text = write(&scene, Some(unit));
        assert!(!text.contains("SPLINE"), "{text}");
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
            text.matches("SPLINE_CURVE_WITH_KNOTS").count()
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
            assert_eq!(
                found.objects().iter().filter_map(surface).collect::<Vec<_>>(),
                [text.contains("B_SPLINE_SURFACE_WITH_KNOTS")]
            );
            text.matches("B_SPLINE_SURFACE_WITH_KNOTS").count()
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
        let is_cone = surface.form().unwrap().noun() == "cone";
        assert_eq!(count(surface.clone().into(), Some(mirror)), usize::from(is_cone));
    }
}

fn one(item: &str) -> Curve {
    let text = common::file("#100", &format!("{}#100=GEOMETRIC_CURVE_SET('',(#101));\n{item}", common::AXES));
    let Geometry::Curve(curve) = read(&text).objects()[0].geometry().clone() else { panic!("{item}") };
    curve
}

/// What the schema says of conics, their senses and their ends (angles are in degrees here).
#[test]
fn forms_are_those_of_the_file() {
    let trimmed = |basis: &str, ends: [&str; 2], sense: &str, master: &str| {
        one(&format!(
            "#101=TRIMMED_CURVE('',#102,({}),({}),.{sense}.,.{master}.);\n#102={basis};\n\
             #103=CARTESIAN_POINT('',(0.,2.,0.));#104=CARTESIAN_POINT('',(-2.,0.,0.));#105=DIRECTION('',(3.,4.,0.));\
             #106=VECTOR('',#105,2.);#107=CARTESIAN_POINT('',(6.,8.,0.));",
            ends[0], ends[1]
        ))
    };
    let of = |curve: &Curve| *curve.form().unwrap();
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-14, "{a} {b}");
    let p = |t: &str| format!("PARAMETER_VALUE({t})");

    let whole = of(&one("#101=CIRCLE('',#10,2.);"));
    assert_eq!((whole.noun(), whole.range), ("circle", [0.0, TAU]));
    let CurveForm::Circle { frame, radius } = whole.form else { panic!() };
    assert_eq!((frame.origin, frame.x, frame.z, radius), (Point::origin(), Vector::x(), Vector::z(), 2.0));

    let by_numbers = trimmed("CIRCLE('',#10,2.)", [&p("90."), &p("180.")], "T", "PARAMETER");
    let by_points = trimmed("CIRCLE('',#10,2.)", ["#103", "#104"], "T", "CARTESIAN");
    for arc in [by_numbers, by_points] {
        assert_eq!(of(&arc).noun(), "arc of a circle");
        near(of(&arc).range[0], PI / 2.0);
        near(of(&arc).range[1], PI);
    }
    // Against it: from 90° back to 180°, three quarters, seen from below.
    let back = trimmed("CIRCLE('',#10,2.)", [&p("90."), &p("180.")], "F", "PARAMETER");
    let CurveForm::Circle { frame, .. } = of(&back).form else { panic!() };
    assert_eq!(frame.z, -Vector::z());
    near(of(&back).range[0], -2.5 * PI);
    near(of(&back).range[1], -PI);

    for (sense, ends) in [("T", ["#103", "#107"]), ("F", ["#107", "#103"])] {
        let line = trimmed("LINE('',#103,#106)", ends, sense, "CARTESIAN");
        assert_eq!(of(&line), CurvePiece::LINE, "{sense}");
    }
    let line = trimmed("LINE('',#104,#106)", [&p("0."), &p("2.5")], "T", "PARAMETER");
    assert!((line.points()[1] - Point::new(1.0, 4.0, 0.0)).norm() < 1e-15);
    let parabola = of(&trimmed("PARABOLA('',#10,0.5)", [&p("-1."), &p("3.")], "T", "PARAMETER"));
    assert_eq!((parabola.noun(), parabola.range), ("piece of a parabola", [-1.0, 3.0]));
    let parabola = of(&trimmed("PARABOLA('',#10,0.5)", [&p("3."), &p("-1.")], "F", "PARAMETER"));
    assert_eq!((parabola.noun(), parabola.range), ("piece of a parabola", [-3.0, 1.0]));
    let hyperbola = of(&trimmed("HYPERBOLA('',#10,2.,1.)", [&p("-1.5"), &p("2.")], "T", "PARAMETER"));
    assert_eq!((hyperbola.noun(), hyperbola.range), ("piece of a hyperbola", [-1.5, 2.0]));
    // Splines that lie on circles are splines, as the file has them.
    let spline = one(
        "#101=(BOUNDED_CURVE()B_SPLINE_CURVE(2,(#110,#111,#112),.UNSPECIFIED.,.F.,.F.)BEZIER_CURVE()\
         RATIONAL_B_SPLINE_CURVE((1.,0.7071067811865476,1.))CURVE()GEOMETRIC_REPRESENTATION_ITEM()REPRESENTATION_ITEM(''));\
         #110=CARTESIAN_POINT('',(1.,0.,0.));#111=CARTESIAN_POINT('',(1.,1.,0.));#112=CARTESIAN_POINT('',(0.,1.,0.));",
    );
    assert!(spline.form().is_none());
}

/// Rectangles by the formulas of the schema, in degrees, and by their senses.
#[test]
fn rectangles_are_those_of_the_file() {
    let form = |basis: &str, [u, v]: [&str; 2], senses: &str| {
        let item = format!("#101=RECTANGULAR_TRIMMED_SURFACE('',#102,{u},{v},{senses});#102={basis};");
        let text = common::file("#100", &format!("{}#100=GEOMETRIC_SET('',(#101));\n{item}", common::AXES));
        let Geometry::Surface(surface) = read(&text).objects()[0].geometry().clone() else {
            panic!("{item}")
        };
        *surface.form().unwrap()
    };
    let quarter = PI / 2.0;
    for (basis, ranges, senses, expected) in [
        ("CYLINDRICAL_SURFACE('',#10,2.)", ["0.,90.", "1.,3."], ".T.,.T.", [[0.0, quarter], [1.0, 3.0]]),
        ("CYLINDRICAL_SURFACE('',#10,2.)", ["0.,90.", "3.,1."], ".T.,.F.", [[0.0, quarter], [3.0, 1.0]]),
        (
            "CONICAL_SURFACE('',#10,2.,45.)",
            ["-90.,90.", "0.,1."],
            ".T.,.T.",
            [[-quarter, quarter], [0.0, 1.0]],
        ),
        ("SPHERICAL_SURFACE('',#10,2.)", ["0.,360.", "-90.,0."], ".T.,.T.", [[0.0, TAU], [-quarter, 0.0]]),
        (
            "TOROIDAL_SURFACE('',#10,3.,1.)",
            ["270.,90.", "0.,90."],
            ".T.,.T.",
            [[3.0 * quarter, 5.0 * quarter], [0.0, quarter]],
        ),
        ("PLANE('',#10)", ["0.,2.", "-1.,4."], ".T.,.T.", [[0.0, 2.0], [-1.0, 4.0]]),
    ] {
        let found = form(basis, ranges, senses);
        let off = found.ranges.iter().flatten().zip(expected.iter().flatten()).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f64::max) < 1e-14, "{basis}: {:?}", found.ranges);
    }
}

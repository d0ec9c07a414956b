//! Curves along vectors and about axes, by themselves, stay what they are.

#![allow(clippy::unwrap_used, clippy::panic, reason = "tests")]

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use loftsman_kernel::brep::{CurveForm, Frame, SurfaceForm};
use loftsman_kernel::plugin::{Format, Memory, ReadOptions, WriteOptions};
use loftsman_kernel::scene::{Geometry, Object, Scene, Unit};
use loftsman_kernel::spline::{Curve, CurvePiece, Direction, Space, Surface, SurfacePiece};
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

fn read(text: &str) -> Vec<Surface> {
    let (scene, report) = Step.read(&Memory::new("t.step", text), &ReadOptions::default()).unwrap();
    assert!(report.adds_up(), "{report:?}");
    let surface = |object: &Object| match object.geometry() {
        Geometry::Surface(surface) => surface.clone(),
        other => panic!("{other:?}"),
    };
    scene.objects().iter().map(surface).collect()
}

fn piece(form: CurveForm, [from, to]: [f64; 2]) -> Curve {
    let frame = match form {
        CurveForm::Circle { frame, radius } => (frame, [radius; 2]),
        CurveForm::Ellipse { frame, radii } | CurveForm::Hyperbola { frame, radii } => (frame, radii),
        CurveForm::Parabola { frame, focal } => (frame, [focal; 2]),
        _ => panic!(),
    };
    let (frame, [a, b]) = frame;
    let bezier = |weight: f64, middle: Point| {
        let points = vec![form.point(from).unwrap(), middle, form.point(to).unwrap()];
        let space = Space::clamped(2, &[from, to]).unwrap();
        if weight == 1.0 {
            Curve::new(space, points).unwrap()
        } else {
            Curve::rational(space, points, vec![1.0, weight, 1.0]).unwrap()
        }
    };
    let at = |x: f64, y: f64| frame.origin + frame.x * x + frame.y() * y;
    let curve = match form {
        CurveForm::Parabola { .. } => bezier(1.0, at(a * from * to, a * (from + to))),
        CurveForm::Hyperbola { .. } => {
            let (half, middle) = (0.5 * (to - from), 0.5 * (from + to));
            let by = 1.0 / half.cosh();
            bezier(half.cosh(), at(a * middle.cosh() * by, b * middle.sinh() * by))
        }
        _ => Curve::elliptic_arc(frame.origin, frame.x * a, frame.y() * b, from, to - from).unwrap(),
    };
    curve.with_form(CurvePiece { form, range: [from, to] }).unwrap()
}

fn spline() -> Curve {
    let knots = Space::clamped(3, &[-1.0, 1.0, 2.5]).unwrap();
    let points = (0..5).map(|k| Point::new(8.0 + f64::from(k * k), f64::from(k), 1.5)).collect();
    Curve::rational(knots, points, vec![1.0, 2.0, 1.5, 0.5, 1.0]).unwrap()
}

/// Profiles with their names.
fn profiles() -> Vec<(&'static str, Curve)> {
    let origin = Point::new(9.0, 1.0, 2.0);
    let frame = Frame::new(origin, Vector::new(0.1, 1.0, 0.2), Vector::x()).unwrap();
    let (radii, tall) = ([2.0, 1.5], [1.0, 2.5]);
    vec![
        ("spline", spline()),
        ("ring", piece(CurveForm::Circle { frame, radius: 2.0 }, [0.0, TAU])),
        ("arc", piece(CurveForm::Circle { frame, radius: 2.0 }, [-0.5, 2.0])),
        ("ellipse", piece(CurveForm::Ellipse { frame, radii }, [0.0, TAU])),
        ("tall", piece(CurveForm::Ellipse { frame, radii: tall }, [0.25, 3.0])),
        ("hyperbola", piece(CurveForm::Hyperbola { frame, radii }, [-0.2, 0.7])),
        ("parabola", piece(CurveForm::Parabola { frame, focal: 0.5 }, [-1.0, 1.5])),
    ]
}

fn extruded(profile: &Curve) -> Surface {
    let surface = Surface::extrusion(profile, Vector::new(1.0, 5.0, -3.0)).unwrap();
    let piece = SurfacePiece::extruded(&surface, profile.form().copied());
    surface.with_form(piece).unwrap()
}

fn turned(profile: &Curve, sweep: f64) -> Surface {
    let axis = (Point::new(1.0, -2.0, 0.5), Vector::new(0.3, -0.5, 0.8));
    let surface = Surface::revolution(profile, axis.0, axis.1, sweep).unwrap();
    let piece = SurfacePiece::turned(&surface, axis, sweep, profile.form().copied()).unwrap();
    surface.with_form(piece).unwrap()
}

/// Surfaces, and whether the file has them as what they are.
fn family() -> Vec<(String, Surface, bool)> {
    let mut all = Vec::new();
    for (name, profile) in profiles() {
        let bow = name == "parabola";
        all.push((format!("extruded {name}"), extruded(&profile), !bow));
        all.push((format!("turned {name}"), turned(&profile, TAU), !bow));
        all.push((format!("part of a turned {name}"), turned(&profile, 1.25), !bow));
        all.push((format!("{name} turned back"), turned(&profile, -2.0), !bow));
    }
    let line = Curve::line(Point::new(8.0, 0.0, 0.0), Point::new(9.0, 4.0, 1.0)).unwrap();
    let line = line.with_form(CurvePiece::LINE).unwrap();
    all.push(("hyperboloid".to_owned(), turned(&line, TAU), true));
    all
}

/// How far two surfaces are from one another at equal shares of their domains.
fn off(one: &Surface, other: &Surface) -> f64 {
    let share = |(a, b): (f64, f64), k: u32| a + (b - a) * f64::from(k) / 6.0;
    let at =
        |s: &Surface, k: u32| s.point(share(s.u().domain(), k / 7), share(s.v().domain(), k % 7)).unwrap();
    (0..49).map(|k| (at(one, k) - at(other, k)).amax()).fold(0.0, f64::max)
}

#[test]
fn sweeps_are_written_and_read_as_what_they_are() {
    for unit in [Some(Unit::Millimetre), Some(Unit::Inch), None] {
        let mut scene = Scene::new();
        for (name, surface, _) in family() {
            scene.add(Object::new(&name, surface.into())).unwrap();
        }
        let text = write(&scene, unit);
        let scale = unit.map_or(1.0, |unit| scene.unit.metres().unwrap() / unit.metres().unwrap());
        let found = read(&text);
        assert_eq!(found.len(), family().len());
        for ((name, was, kept), is) in family().iter().zip(&found) {
            let was = was.transformed(&Matrix4::new_scaling(scale)).unwrap();
            // Along vectors, and of lines about axes, in other units splines are left: OpenCASCADE takes their lengths for millimetres.
            let by_length = name.starts_with("extruded") || name == "hyperboloid";
            let kept = *kept && (unit == Some(Unit::Millimetre) || !by_length);
            assert_eq!(is.form().is_some(), kept, "{name}");
            assert!(off(&was, is) <= 1e-13 * 40.0 * scale, "{name}: {:e}", off(&was, is));
            let (Some(was), Some(is)) = (was.form(), is.form()) else { continue };
            assert_eq!(was.noun(), is.noun(), "{name}");
            let profile = |piece: &SurfacePiece| match piece.form {
                SurfaceForm::Extrusion { profile, .. } | SurfaceForm::Revolution { profile, .. } => {
                    profile.name()
                }
                _ => panic!(),
            };
            assert_eq!(profile(was), profile(is), "{name}");
        }
        // What is read goes out as that again.
        let mut scene = Scene::new();
        for (k, surface) in found.iter().enumerate() {
            scene.add(Object::new(k.to_string(), surface.clone().into())).unwrap();
        }
        if let Some(unit) = unit {
            scene.unit = unit;
        }
        for (one, other) in found.iter().zip(read(&write(&scene, unit))) {
            assert_eq!(one.form().is_some(), other.form().is_some());
            assert!(off(one, &other) <= 1e-13 * 40.0 * scale);
        }
    }
}

#[test]
fn sweeps_that_were_edited_are_written_as_splines() {
    for (name, surface, kept) in family() {
        let count = |surface: Surface| {
            let mut scene = Scene::new();
            scene.add(Object::new("s", surface.into())).unwrap();
            write(&scene, Some(Unit::Millimetre)).matches("B_SPLINE_SURFACE_WITH_KNOTS").count()
        };
        assert_eq!(count(surface.clone()), usize::from(!kept), "{name}");
        let mut moved = surface.clone();
        loftsman_kernel::shape::Shape::control_vertices_mut(&mut moved)[0].x += 1e-9;
        for other in
            [moved, surface.reverse(Direction::U).unwrap(), surface.elevate(Direction::V, 1).unwrap()]
        {
            assert_eq!(count(other), 1, "{name}");
        }
    }
}

/// By the schema, with angles in degrees, and by the senses of the rectangle.
#[test]
fn sweeps_are_those_of_the_file() {
    let one = |basis: &str, [u, v]: [&str; 2], senses: &str| {
        let item = format!(
            "#101=RECTANGULAR_TRIMMED_SURFACE('',#102,{u},{v},{senses});#102={basis};\
             #103=ELLIPSE('',#10,4.,2.);#104=VECTOR('',#105,2.);#105=DIRECTION('',(0.,3.,4.));\
             #106=AXIS1_PLACEMENT('',#107,#108);#107=CARTESIAN_POINT('',(7.,0.,0.));#108=DIRECTION('',(0.,1.,0.));"
        );
        let text = common::file("#100", &format!("{}#100=GEOMETRIC_SET('',(#101));\n{item}", common::AXES));
        read(&text).remove(0)
    };
    let at = |angle: f64| Point::new(4.0 * angle.cos(), 2.0 * angle.sin(), 0.0);
    let along = Vector::new(0.0, 0.6, 0.8) * 2.0;
    let corners = |surface: &Surface| {
        let ((a, b), (c, d)) = (surface.u().domain(), surface.v().domain());
        let point = |u: f64, v: f64| surface.point(u, v).unwrap();
        [point(a, c), point(b, c), point(a, d), point(0.5 * (a + b), c)]
    };
    let near = |found: [Point; 4], expected: [Point; 4]| {
        for (one, other) in found.iter().zip(&expected) {
            assert!((one - other).amax() < 1e-14, "{found:?} {expected:?}");
        }
    };
    let basis = "SURFACE_OF_LINEAR_EXTRUSION('',#103,#104)";
    for (senses, [s, e], [c, d]) in [
        (".T.,.T.", [30.0, 90.0], [-1.0, 3.0]),
        (".F.,.T.", [30.0, 90.0], [-1.0, 3.0]),
        (".T.,.F.", [30.0, 90.0], [-1.0, 3.0]),
    ] {
        // A sense that is false: from the second to the first.
        let [u_sense, v_sense] = [&senses[..3], &senses[4..]].map(|sense| sense == ".T.");
        let (u, v) = (if u_sense { "30.,90." } else { "90.,30." }, if v_sense { "-1.,3." } else { "3.,-1." });
        let surface = one(basis, [u, v], senses);
        let SurfaceForm::Extrusion { profile: CurveForm::Ellipse { .. }, .. } = surface.form().unwrap().form
        else {
            panic!("{senses}")
        };
        let [s, e] = if u_sense { [s, e] } else { [e, s] }.map(f64::to_radians);
        let [c, d] = if v_sense { [c, d] } else { [d, c] };
        let first = along * c;
        near(corners(&surface), [at(s) + first, at(e) + first, at(s) + along * d, at(0.5 * (s + e)) + first]);
    }
    // About the line x = 7 along y: at an angle of a quarter what was at x = 7 - r is at z = r.
    for senses in [".T.,.T.", ".F.,.T.", ".T.,.F."] {
        let [u_sense, v_sense] = [&senses[..3], &senses[4..]].map(|sense| sense == ".T.");
        let (u, v) =
            (if u_sense { "90.,270." } else { "270.,90." }, if v_sense { "60.,120." } else { "120.,60." });
        let surface = one("SURFACE_OF_REVOLUTION('',#103,#106)", [u, v], senses);
        let SurfaceForm::Revolution { profile: CurveForm::Ellipse { .. }, .. } = surface.form().unwrap().form
        else {
            panic!("{senses}")
        };
        let at = |turn: f64, angle: f64| {
            let p = at(angle);
            let r = 7.0 - p.x;
            Point::new(7.0 - r * turn.cos(), p.y, r * turn.sin())
        };
        let [a, b] = if u_sense { [FRAC_PI_2, 3.0 * FRAC_PI_2] } else { [3.0 * FRAC_PI_2, FRAC_PI_2] };
        let [c, d] = if v_sense { [PI / 3.0, 2.0 * PI / 3.0] } else { [2.0 * PI / 3.0, PI / 3.0] };
        near(corners(&surface), [at(a, c), at(b, c), at(a, d), at(PI, c)]);
    }
}

//! What curves are beside splines: there and back to the last bit, and refused where they are not that.

use super::common::{read, write};
use loftsman_kernel::brep::{CurveForm, Frame};
use loftsman_kernel::conformance::{format_conformance, sample_forms};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::spline::{Curve, CurvePiece, Surface, SurfacePiece};
use loftsman_kernel::{Point, Vector};
use loftsman_native::Native;

#[test]
fn forms_read_back_to_the_last_bit() {
    let scene = sample_forms().unwrap();
    let bytes = write(&scene);
    let (found, _) = read(bytes.clone()).unwrap();
    assert!(found == scene);
    assert_eq!(write(&found), bytes);
    let verdict = format_conformance(&Native, &scene);
    assert!(verdict.passed(), "{verdict}");
    // A circle that nobody calls one is a spline.
    let circle = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap();
    let mut plain = Scene::new();
    plain.add(Object::new("c", circle.into())).unwrap();
    let text = String::from_utf8(write(&plain)).unwrap();
    assert!(!text.contains("form"), "{text}");
}

#[test]
fn forms_that_are_not_those_of_the_curve_are_refused() {
    let mut scene = sample_forms().unwrap();
    scene.retain(|object| ["line", "arc", "parabola"].contains(&object.name()));
    let text = String::from_utf8(write(&scene)).unwrap();
    let Geometry::Curve(arc) = scene.object("arc").unwrap().geometry() else { panic!() };
    let [from, to] = arc.form().unwrap().range;
    for (was, is, said) in [
        ("\"radius\": 2,".to_owned(), "\"radius\": 2.000001,", "the curve is no circle"),
        (format!("\"from\": {from:?}"), "\"from\": -0.31", "its range ends at -0.31"),
        (format!("\"to\": {to:?}"), "\"to\": 4.8", "its range ends at 4.8"),
        ("\"focal\": 0.7".to_owned(), "\"focal\": 0.71", "the curve is no parabola"),
        ("\"focal\": 0.7".to_owned(), "\"focal\": -0.7", "must be positive"),
        ("\"kind\": \"circle\"".to_owned(), "\"kind\": \"line\"", "no line"),
        ("\"kind\": \"circle\"".to_owned(), "\"kind\": \"sphere\"", "no kind of curve"),
        ("\"kind\": \"circle\"".to_owned(), "\"kind\": \"circel\"", "circle"),
        (format!("\"from\": {from:?},"), "", "needs the field \"from\""),
    ] {
        assert!(text.contains(&was), "{was} in {text}");
        let error = read(text.replacen(&was, is, 1)).unwrap_err().to_string();
        assert!(error.contains(said), "{is}: {error}");
    }
}

/// A spline and an arc, along a vector and about an axis.
fn sweeps() -> Scene {
    let points = [[4.0, 0.0], [5.0, 1.0], [4.0, 3.0], [6.0, 4.0]].map(|[x, z]| Point::new(x, 0.0, z));
    let spline = Curve::bezier(points.to_vec()).unwrap();
    let frame = Frame::new(Point::new(4.0, 0.0, 2.0), Vector::y(), Vector::x()).unwrap();
    let arc = Curve::elliptic_arc(frame.origin, frame.x * 2.0, frame.y() * 2.0, 0.25, 2.0).unwrap();
    let form = CurveForm::Circle { frame, radius: 2.0 };
    let arc = arc.with_form(CurvePiece { form, range: [0.25, 2.25] }).unwrap();
    let mut scene = Scene::new();
    for (name, profile) in [("spline", spline), ("arc", arc)] {
        let of = profile.form().copied();
        let surface = Surface::extrusion(&profile, Vector::new(1.0, 5.0, 0.5)).unwrap();
        let piece = SurfacePiece::extruded(&surface, of);
        scene.add(Object::new(format!("extruded {name}"), surface.with_form(piece).unwrap().into())).unwrap();
        let axis = (Point::origin(), Vector::z());
        let surface = Surface::revolution(&profile, axis.0, axis.1, 1.5).unwrap();
        let piece = SurfacePiece::turned(&surface, axis, 1.5, of).unwrap();
        scene.add(Object::new(format!("turned {name}"), surface.with_form(piece).unwrap().into())).unwrap();
    }
    scene
}

#[test]
fn sweeps_read_back_to_the_last_bit_and_are_refused_where_they_are_none() {
    let bytes = write(&sweeps());
    let (found, _) = read(bytes.clone()).unwrap();
    assert!(found == sweeps());
    let text = String::from_utf8(bytes).unwrap();
    for (was, is, said) in [
        ("\"along\": [1, 5, 0.5]", "\"along\": [1, 5, 0.25]", "the surface is no extrusion"),
        ("\"radius\": 2", "\"radius\": 2.000001", "the curve is no circle"),
        ("\"u\": [0, 1.5]", "\"u\": [0, 1.25]", "the surface is no revolution"),
        ("\"v\": [0, 1]", "\"v\": [0, 2]", "the surface is no extrusion"),
        ("\"v\": [0.25, 2.25]", "\"v\": [0.25, 2]", "its range ends at 2"),
    ] {
        assert!(text.contains(was), "{was} in {text}");
        let error = read(text.replacen(was, is, 1)).unwrap_err().to_string();
        assert!(error.contains(said), "{is}: {error}");
    }
}

#[test]
fn forms_that_are_not_those_of_the_surface_are_refused() {
    let mut scene = sample_forms().unwrap();
    scene.retain(|object| ["cylinder", "torus"].contains(&object.name()));
    let text = String::from_utf8(write(&scene)).unwrap();
    for (was, is, said) in [
        ("\"radius\": 2", "\"radius\": 2.000001", "the surface is no cylinder"),
        ("\"major\": 5", "\"major\": -5", "must be positive"),
        ("\"u\": [0.3, 2.9]", "\"u\": [0.3, 2.8]", "the surface is no cylinder"),
        ("\"v\": [-1, 4]", "\"v\": [4, -1]", "the surface is no cylinder"),
        ("\"v\": [-1, 4]", "\"w\": [-1, 4]", "no field \"w\""),
        ("\"kind\": \"cylinder\"", "\"kind\": \"circle\"", "no kind of surface"),
    ] {
        assert!(text.contains(was), "{was} in {text}");
        let error = read(text.replacen(was, is, 1)).unwrap_err().to_string();
        assert!(error.contains(said), "{is}: {error}");
    }
}

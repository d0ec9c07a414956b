//! Bad input: one clear error each, naming the object and what to do.

use loftsman_area_volume::{area, length, volume};
use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::{Functional, On, Shapes, position};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::solve::Automatic;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

use crate::samples::{ball, circle, oval, patches, pebble, sphere};

fn refuses(functional: &dyn Functional, shapes: &[&dyn Shape], words: &[&str]) {
    let error =
        functional.value(&Shapes::new(shapes.iter().copied()), &mut [0.0; 3]).unwrap_err().to_string();
    for word in words {
        assert!(error.contains(word), "\"{word}\" is not in: {error}");
    }
}

fn named(name: &str) -> On {
    On { shape: 0, name: Some(name.into()) }
}

#[test]
fn what_cannot_be_asked_of_a_shape_says_so() {
    let mut open = pebble();
    open.control_vertices_mut()[0].y += 0.125;
    refuses(&area().on(named("rib")), &[&open], &["\"rib\"", "open", "0.125", "close it"]);
    let mut bent = oval();
    bent.control_vertices_mut()[3].z += 0.5;
    refuses(&area().on(named("rib")), &[&bent], &["\"rib\"", "not planar", "normal"]);
    let flat = (0..8).map(|i| Point::new(f64::from(if i < 5 { i } else { 8 - i }), 0.0, 0.0)).collect();
    let flat = Curve::new(Space::periodic_uniform(3, 8).unwrap(), flat).unwrap();
    refuses(&area().on(named("rib")), &[&flat], &["\"rib\"", "no area"]);
    refuses(&area().on(named("rib")).normal([0.0, 0.0, 1.0]), &[&flat], &["\"rib\"", "area is zero"]);
    refuses(&area().on(named("rib")).normal([1.0, 0.0, 0.0]), &[&oval()], &["\"rib\"", "area is zero"]);
    refuses(&area().on(named("rib")).normal([0.0; 3]), &[&oval()], &["normal has no direction"]);
    refuses(&area().on(named("hull")), &[&sphere(1.0)], &["\"hull\"", "surface", "volume"]);
    refuses(&volume().on(named("rib")), &[&oval()], &["\"rib\"", "a curve", "area"]);
    let sides = patches(3, 0.0);
    let lidless: Vec<&dyn Shape> = sides[1..].iter().map(|s| s as &dyn Shape).collect();
    refuses(&volume().of(0..5), &lidless, &["open", "edge", "patches"]);
    let mut torn = ball(6, 6);
    torn.control_vertices_mut()[0].x += 0.5;
    refuses(&volume().on(named("hull")), &[&torn], &["\"hull\"", "open", "v0"]);
    let mut pressed = ball(6, 6);
    pressed.control_vertices_mut().iter_mut().for_each(|p| p.z = 0.0);
    refuses(&volume().on(named("hull")), &[&pressed], &["\"hull\"", "no volume"]);
}

#[test]
fn targets_that_cannot_be_are_refused() {
    let refused = |constraint, words: &[&str]| {
        let error = Edit::new(&oval()).ask(constraint).solve().unwrap_err().to_string();
        words.iter().for_each(|word| assert!(error.contains(word), "\"{word}\" is not in: {error}"));
    };
    let up = || area().on(named("rib")).normal([0.0, 0.0, 1.0]);
    refused(up().to(-5.0), &["\"rib\"", "inside out", "same sign"]);
    refused(up().to(0.0), &["\"rib\"", "nothing is left"]);
    refused(up().by(-6.0), &["inside out"]);
    refused(up().scale(-1.0), &["inside out"]);
    refused(up().to(f64::NAN), &["not a finite number"]);
    let error = Edit::new(&ball(6, 6)).ask(volume().to(-1.0)).solve().unwrap_err().to_string();
    assert!(error.contains("inside out") && error.contains("normals"), "{error}");
}

#[test]
fn axes_do_not_alternate_where_there_are_bounds() {
    let edit = Edit::new(&oval()).ask(area().on(named("rib")).keep()).ask(position(1.0).at_most([3.0; 3]));
    let error = edit.alternating().handle(position(0.0)).prepare(Automatic).unwrap_err().to_string();
    for word in ["bounds", "area of \"rib\" may break \"position at 1 ≤ (3, 3, 3)\"", "together"] {
        assert!(error.contains(word), "\"{word}\" is not in: {error}");
    }
    // Together they can.
    let edit = Edit::new(&oval()).ask(area().keep()).ask(position(1.0).at_most([3.0; 3]));
    edit.ask(position(0.0).by([0.1, 0.0, 0.0])).solve().unwrap();
}

#[test]
fn what_is_all_held_cannot_change() {
    let error = Edit::new(&oval()).ask(area().scale(1.5)).lock(0..12).solve().unwrap_err().to_string();
    assert!(error.contains("area") && error.contains("unlock"), "{error}");
    // Two areas of one curve that contradict one another.
    let twice = Edit::new(&oval()).ask(area().scale(1.5)).ask(area().normal(Vector::z()).to(2.0));
    let error = twice.solve().unwrap_err().to_string();
    assert!(error.contains("area") && error.contains("release one of them"), "{error}");
    let agreeing = Edit::new(&oval()).ask(area().scale(1.5)).ask(area().normal(Vector::z()).scale(1.5));
    let solved = agreeing.solve().unwrap();
    assert!(solved.report().redundant.len() == 1, "{}", solved.report());
    // Far less than the rounding of the points.
    let error = Edit::new(&circle(1.0)).ask(area().scale(1e-30)).solve().unwrap_err().to_string();
    assert!(error.contains("nothing is left of it at an area of 3.14"), "{error}");
}

#[test]
fn a_length_below_the_distance_of_held_ends_says_that_distance() {
    let points = [[5.0, 0.0], [6.0, 3.0], [3.0, 6.0], [1.0, 5.5], [0.0, 5.0]];
    let arc = points.map(|[x, y]| Point::new(x, y, 0.0)).to_vec();
    let straight = (0..5).map(|k| Point::new(5.0 - 1.25 * f64::from(k), 1.25 * f64::from(k), 0.0)).collect();
    for points in [arc, straight] {
        let curve = Curve::new(Space::clamped_uniform(3, 5).unwrap(), points).unwrap();
        let (start, end) = curve.domain();
        let held = Edit::new(&curve).ask(position(start).keep()).ask(position(end).keep());
        let error = held.ask(length().to(1.0)).solve().unwrap_err().to_string();
        assert!(
            error.contains("the ends of the shape are 7.07") && error.contains("cannot be shorter"),
            "{error}"
        );
        // What can be had is had, and other failures say nothing of it.
        let held = Edit::new(&curve).ask(position(start).keep()).ask(position(end).keep());
        let longer = held.ask(length().to(12.0)).solve().map(|_| ()).map_err(|e| e.to_string());
        assert!(longer.as_ref().err().is_none_or(|error| !error.contains("shorter")), "{longer:?}");
    }
}

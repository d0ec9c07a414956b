//! Rows against finite differences, for every functional on every kind of shape that closes.

use loftsman_area_volume::{AreaVolume, area, centroid, closed, length, surface_area, volume};
use loftsman_kernel::conformance::{functional_conformance, sample_shapes};
use loftsman_kernel::functional::Functional;
use loftsman_kernel::plugin::Registry;
use loftsman_kernel::shape::Shape;
use loftsman_kernel::spline::Space;

use crate::samples::{ball, circle, oval, patches, pebble, ring, sphere, torus, uneven};

fn check(functional: &dyn Functional, shapes: &[Box<dyn Shape>]) {
    let verdict = functional_conformance(functional, shapes);
    assert!(verdict.passed() && verdict.checks >= 12, "{verdict}");
}

fn one(shape: impl Shape) -> Vec<Box<dyn Shape>> {
    vec![Box::new(shape)]
}

#[test]
fn areas() {
    for curve in [oval(), circle(2.0), pebble(), ring(Space::periodic(7, uneven(6)).unwrap())] {
        check(&area(), &one(curve.clone()));
        check(&area().normal([0.3, -0.2, 1.0]), &one(curve));
    }
    let compound: Vec<Box<dyn Shape>> = vec![Box::new(oval()), Box::new(circle(0.3))];
    check(&area().holes([1]), &compound);
    check(&area().of([1, 0]), &compound);
}

#[test]
fn volumes() {
    for surface in [torus(5, 4, 2), ball(6, 5), sphere(1.0), torus(3, 4, 4)] {
        check(&volume(), &one(surface));
    }
    let cube: Vec<Box<dyn Shape>> = patches(2, 0.3).into_iter().map(|s| s.boxed()).collect();
    check(&volume().of(0..6), &cube);
}

#[test]
fn centroids() {
    for curve in [oval(), circle(2.0), pebble(), ring(Space::periodic(7, uneven(6)).unwrap())] {
        check(&centroid(), &one(curve.clone()));
        check(&centroid().normal([0.3, -0.2, 1.0]), &one(curve));
    }
    let compound: Vec<Box<dyn Shape>> = vec![Box::new(oval()), Box::new(circle(0.3))];
    check(&centroid().holes([1]), &compound);
    for surface in [torus(5, 4, 2), ball(6, 5), sphere(1.0)] {
        check(&centroid(), &one(surface));
    }
    let cube: Vec<Box<dyn Shape>> = patches(2, 0.3).into_iter().map(|s| s.boxed()).collect();
    check(&centroid().of(0..6), &cube);
}

#[test]
fn lengths_and_surface_areas() {
    for curve in sample_shapes(false) {
        check(&length(), &[curve]);
    }
    check(&length().of([0, 1]), &[Box::new(oval()), Box::new(circle(0.3))]);
    for surface in sample_shapes(true) {
        check(&surface_area(), &[surface]);
    }
    check(&surface_area(), &one(torus(5, 4, 3)));
}

#[test]
fn boundaries() {
    check(&closed(), &one(pebble()));
    check(&closed(), &one(ball(6, 5)));
    check(&closed(), &one(sphere(1.0)));
}

#[test]
fn every_kind_is_registered() {
    let mut registry = Registry::new();
    registry.add(&AreaVolume);
    let names: Vec<_> = registry.functionals().map(|d| d.name).collect();
    assert_eq!(names, ["area", "volume", "centroid", "length", "surface-area", "closed"]);
}

//! `transform` with maps of any size and rank.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic, reason = "tests")]

use loftsman_editing::Editing;
use loftsman_kernel::plugin::{Context, OperationError, Parameters, Registry};
use loftsman_kernel::scene::{Definition, Geometry, Object, Scene};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use serde_json::{Value, json};

struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

fn curve() -> Curve {
    let points = [[0, 0, 0], [1, 2, 0], [2, -1, 1], [3, 2, 0], [4, 0, -1], [5, 2, 0], [6, 0, 0], [7, 1, 0]];
    let points = points.map(|p| Point::from(p.map(f64::from))).to_vec();
    Curve::new(Space::clamped_uniform(3, 8).unwrap(), points).unwrap()
}

fn run(fields: Value) -> Result<Vec<Point>, OperationError> {
    let mut registry = Registry::new();
    registry.add(&Editing);
    let mut scene = Scene::new();
    scene.add(Object::new("c", curve().into())).unwrap();
    let before = scene.clone();
    let operation = registry.find_operation("transform", "step[0].op")?.clone();
    let parameters = Parameters::new(fields, "step[0]")?;
    parameters.check(operation.declaration().fields)?;
    match operation.apply(&mut scene, &parameters, &Context::quiet(&registry)) {
        Ok(_) => Ok(scene.object("c").unwrap().geometry().points().to_vec()),
        Err(error) => {
            assert_eq!(scene, before, "a failed step leaves the scene alone");
            Err(error)
        }
    }
}

#[test]
fn the_length_of_an_axis_does_not_matter() {
    let mut random = Random(1);
    for member in 0..150 {
        let axis = Vector::from([(); 3].map(|()| random.within(-1.0, 1.0)));
        let angle = random.within(-400.0, 400.0);
        // Also as long and as short as numbers are.
        let length = 10_f64.powf(random.within(-307.0, 307.9));
        let stretched = axis / axis.amax() * length;
        let points = run(json!({ "rotate": { "axis": stretched.as_slice(), "degrees": angle } })).unwrap();
        // Rodrigues, by hand.
        let (k, a) = (axis.normalize(), angle.to_radians());
        for (p, q) in curve().points().iter().zip(points) {
            let v = p.coords;
            let turned = v * a.cos() + k.cross(&v) * a.sin() + k * k.dot(&v) * (1.0 - a.cos());
            assert!((turned - q.coords).norm() <= 1e-13 * 10.0, "member {member}: {length:e}");
        }
    }
    for axis in [[1e155, 0.0, 0.0], [0.0, 5e-324, 0.0], [1.7e308, 1.7e308, 1.7e308]] {
        let points = run(json!({ "rotate": { "axis": axis, "degrees": 90 } })).unwrap();
        let length = |p: &[Point]| p.windows(2).map(|w| (w[1] - w[0]).norm()).sum::<f64>();
        assert!((length(&points) - length(curve().points())).abs() < 1e-12);
    }
    let text = run(json!({ "rotate": { "axis": [0, 0, 0], "degrees": 90 } })).unwrap_err().to_string();
    assert!(text.contains("the zero vector is no axis"), "{text}");
}

#[test]
fn maps_that_flatten_are_refused_whatever_their_size() {
    let rows = |m: [[f64; 3]; 3]| {
        json!({ "matrix": [
        [m[0][0], m[0][1], m[0][2], 0.5], [m[1][0], m[1][1], m[1][2], -1], [m[2][0], m[2][1], m[2][2], 0], [0, 0, 0, 1]
    ] })
    };
    let mut random = Random(2);
    for member in 0..200 {
        let mut vector = || [(); 3].map(|()| random.within(-1.0, 1.0));
        let [a, b, c] = [vector(), vector(), vector()];
        let size = 10_f64.powi((member % 41) * 7 - 140);
        let unlike = [1.0, 10_f64.powi(member % 13), 10_f64.powi(-member % 7)];
        let scaled = |m: [[f64; 3]; 3]| {
            let mut m = m;
            m.iter_mut().zip(unlike).for_each(|(row, f)| row.iter_mut().for_each(|x| *x *= f * size));
            m
        };
        let mixed = |x: f64, y: f64| std::array::from_fn(|i| x * a[i] + y * b[i]);
        // Of rank two, one and nought.
        for flat in [
            [a, b, mixed(0.3, -1.7)],
            [a, mixed(2.0, 0.0), mixed(-0.1, 0.0)],
            [a, [0.0; 3], b],
            [[0.0; 3]; 3],
        ] {
            let text = run(rows(scaled(flat))).unwrap_err().to_string();
            assert!(text.contains("flattens the object"), "member {member}: {text}");
        }
        // Of full rank, stretched unlike.
        let mut full = [a, b, c];
        (0..3).for_each(|i| full[i][i] += 3.0);
        if size < 1e120 {
            assert!(run(rows(scaled(full))).is_ok(), "member {member}");
        }
    }
}

#[test]
fn what_leaves_the_numbers_or_nothing_is_refused() {
    for fields in [
        json!({ "scale": 1e308 }),
        json!({ "scale": 1e-324 }),
        json!({ "scale": [1e-200, 1e-200, 1e-200], "translate": [1e200, 1e200, 1e200] }),
        json!({ "translate": [1e300, 1e300, 1e300] }),
        json!({ "rotate": { "axis": [0, 0, 1], "degrees": 10, "about": [1.7e308, -1.7e308, 0] } }),
        json!({ "scale": 0 }),
        json!({ "scale": [1, 1, 0] }),
    ] {
        let text = run(fields.clone()).map(|p| format!("{p:?}")).unwrap_err().to_string();
        assert!(!text.is_empty(), "{fields}");
    }
    assert!(run(json!({ "scale": 1e-300 })).is_ok());
}

/// An instance has no points: its transform takes the map in, so that what it shows goes where its points would have gone.
#[test]
fn an_instance_moves_with_all_that_it_shows() {
    let mut registry = Registry::new();
    registry.add(&Editing);
    let mut scene = Scene::new();
    let mut definition = Definition::new("d");
    definition.add(Object::new("c", curve().into())).unwrap();
    scene.define(definition).unwrap();
    for name in ["first", "second"] {
        scene.add(Object::new(name, Geometry::Instance("d".into()))).unwrap();
    }
    let operation = registry.find_operation("transform", "step[0].op").unwrap().clone();
    for (fields, expected) in [
        (json!({ "object": "first", "translate": [1, 2, 3] }), [1.0, 2.0, 3.0]),
        (json!({ "object": "first", "scale": 2, "translate": [0, 0, 1] }), [1.0, 2.0, 4.0]),
    ] {
        let parameters = Parameters::new(fields, "step[0]").unwrap();
        operation.apply(&mut scene, &parameters, &Context::quiet(&registry)).unwrap();
        let map = scene.object("first").unwrap().transform.unwrap();
        assert_eq!(map.column(3).as_slice(), [expected[0], expected[1], expected[2], 1.0]);
    }
    assert_eq!(scene.object("first").unwrap().transform.unwrap()[(1, 1)], 2.0);
    assert!(scene.object("second").unwrap().transform.is_none());
    assert_eq!(*scene.definition("d").unwrap().objects()[0].geometry(), Geometry::from(curve()));
}

/// A mirrored surface looks the other way, as nothing else of it says; `reverse` is the way back.
#[test]
fn a_mirrored_surface_tells_the_way_back() {
    let mut registry = Registry::new();
    registry.add(&Editing);
    let ball = Surface::extrusion(&curve(), Vector::new(0.0, 1.0, 3.0)).unwrap();
    let notes = |fields: Value| {
        let mut scene = Scene::new();
        scene.add(Object::new("s", ball.clone().into())).unwrap();
        let operation = registry.find_operation("transform", "step[0].op").unwrap().clone();
        let parameters = Parameters::new(fields, "step[0]").unwrap();
        operation.apply(&mut scene, &parameters, &Context::quiet(&registry)).unwrap().notes.join("; ")
    };
    for factors in [[-1.0, 1.0, 1.0], [1.0, -1e-120, 1e-120], [-2.0, -3.0, -1e90]] {
        let told = notes(json!({ "scale": factors }));
        assert!(told.contains("mirror image") && told.contains("`reverse`"), "{factors:?}: {told}");
    }
    for factors in [[1.0, 1.0, 2.0], [-1.0, -1.0, 1.0]] {
        assert_eq!(notes(json!({ "scale": factors })), "", "{factors:?}");
    }
}

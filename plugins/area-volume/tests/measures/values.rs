//! What the functionals say, against closed forms and numbers of other programs.

use std::f64::consts::PI;

use loftsman_area_volume::{AreaForm, area, area_of, centroid, gap, length, surface_area, volume, volume_of};
use loftsman_kernel::functional::{Functional, On, Shapes};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use serde_json::Value;

use crate::samples::{ball, circle, oval, patches, pebble, ring, sphere, torus, uneven};

fn numbers(value: &Value) -> Vec<f64> {
    serde_json::from_value(value.clone()).unwrap()
}

fn points(value: &Value) -> Vec<Point> {
    match value[0][0].is_array() {
        true => value.as_array().unwrap().iter().flat_map(points).collect(),
        false => value.as_array().unwrap().iter().map(|p| Point::from_slice(&numbers(p))).collect(),
    }
}

fn space(value: &Value) -> Space {
    let (degree, knots) = (value["degree"].as_u64().unwrap() as usize, numbers(&value["knots"]));
    if value["periodic"] == true { Space::periodic(degree, knots) } else { Space::open(degree, knots) }
        .unwrap()
}

fn signed(functional: &dyn Functional, shapes: &[&dyn Shape]) -> f64 {
    let mut out = [f64::NAN];
    functional.value(&Shapes::new(shapes.iter().copied()), &mut out).unwrap();
    out[0]
}

#[test]
fn golden_areas() {
    let golden: Value = serde_json::from_str(include_str!("../golden/area.json")).unwrap();
    let cases = golden["cases"].as_array().unwrap();
    assert!(cases.len() >= 10);
    for case in cases {
        let curve = Curve::new(space(&case["curve"]), points(&case["curve"]["points"])).unwrap();
        let form = AreaForm::new(curve.space());
        for (i, row) in case["form"].as_array().unwrap().iter().enumerate() {
            for (j, expected) in numbers(row).into_iter().enumerate() {
                assert!((form.entry(i, j) - expected).abs() < 1e-12, "{i}, {j}: {}", form.entry(i, j));
            }
        }
        let (found, expected) =
            (signed(&area().normal([0.0, 0.0, 1.0]), &[&curve]), case["area"].as_f64().unwrap());
        assert!((found / expected - 1.0).abs() < 1e-12, "{found} is not {expected}");
    }
}

#[test]
fn golden_volumes() {
    let golden: Value = serde_json::from_str(include_str!("../golden/volume.json")).unwrap();
    for case in golden["cases"].as_array().unwrap() {
        let surface = &case["surface"];
        let surface =
            Surface::new(space(&surface["u"]), space(&surface["v"]), points(&surface["points"])).unwrap();
        let (found, expected) = (volume_of(&surface).unwrap(), case["volume"].as_f64().unwrap());
        assert!((found / expected - 1.0).abs() < 1e-12, "{found} is not {expected}");
    }
}

#[test]
fn an_oval_of_the_theory_and_its_mirror_image() {
    assert!((area_of(&oval()).unwrap() - 5.733_247_420_397_618_5).abs() < 1e-14);
    let mirrored = oval().reverse().unwrap();
    let up = area().normal([0.0, 0.0, 3.0]);
    assert!((signed(&up, &[&mirrored]) + 5.733_247_420_397_618_5).abs() < 1e-14);
    assert!((area_of(&mirrored).unwrap() - 5.733_247_420_397_618_5).abs() < 1e-14, "its own normal");
}

#[test]
fn polygons_by_the_shoelace_formula() {
    for n in [3, 4, 7, 1000] {
        let polygon = ring(Space::periodic(1, uneven(n + 1)).unwrap());
        let p = polygon.points();
        let cross = |i: usize| p[i].x * p[(i + 1) % n].y - p[(i + 1) % n].x * p[i].y;
        let expected = 0.5 * (0..n).map(cross).sum::<f64>();
        assert!((area_of(&polygon).unwrap() / expected - 1.0).abs() < 1e-13);
    }
}

#[test]
fn circles_and_ellipses_are_rational_splines() {
    for radius in [1e-9, 1.0, 1e9] {
        let found = area_of(&circle(radius)).unwrap();
        assert!((found / (PI * radius * radius) - 1.0).abs() < 1e-13, "{radius}: {found}");
        let center = Point::new(1.0, 2.0, 3.0) * radius;
        let ellipse =
            Curve::ellipse(center, Vector::new(1.0, 1.0, 0.0) * radius, Vector::z() * (3.0 * radius));
        let expected = PI * radius * radius * 3.0 * 2.0_f64.sqrt();
        assert!((area_of(&ellipse.unwrap()).unwrap() / expected - 1.0).abs() < 1e-13);
        let periodic = circle(radius).to_periodic(1e-9 * radius).unwrap().shape;
        assert!((area_of(&periodic).unwrap() / (PI * radius * radius) - 1.0).abs() < 1e-12);
    }
    // Weights of very different size: the same circle after a projective change of parameter.
    let (space, points, weights) = circle(1.0).into_parts();
    let spread = weights.unwrap().iter().enumerate().map(|(i, w)| w * 3.0_f64.powi(i as i32)).collect();
    let skewed = Curve::rational(space, points, spread).unwrap();
    assert!((area_of(&skewed).unwrap() / PI - 1.0).abs() < 1e-12, "{}", area_of(&skewed).unwrap());
}

#[test]
fn dense_quadrature_agrees() {
    for curve in [
        pebble(),
        ring(Space::periodic(5, uneven(10)).unwrap()),
        ring(Space::periodic(2, uneven(5)).unwrap()),
    ] {
        let (a, b) = curve.domain();
        let count = 200_000;
        let mut total = 0.0;
        for i in 0..count {
            let u = a + (b - a) * (f64::from(i) + 0.5) / f64::from(count);
            let (p, d) = (curve.point(u).unwrap(), curve.derivative(u, 1).unwrap());
            total += 0.5 * (p.x * d.y - p.y * d.x) * (b - a) / f64::from(count);
        }
        let found = signed(&area().normal([0.0, 0.0, 1.0]), &[&curve]);
        assert!((found / total - 1.0).abs() < 1e-9, "{found} is not {total}");
    }
}

#[test]
fn areas_in_space_are_those_of_projections() {
    let tilt = rotation();
    let turned: Vec<Point> =
        oval().points().iter().map(|p| tilt * p + Vector::new(50.0, -20.0, 7.0)).collect();
    let turned = Curve::new(oval().space().clone(), turned).unwrap();
    assert!((area_of(&turned).unwrap() / 5.733_247_420_397_618_5 - 1.0).abs() < 1e-13);
    let normal = tilt * Vector::z();
    for (axis, share) in [(Vector::x(), normal.x), (Vector::y(), normal.y), (Vector::z(), normal.z)] {
        let found = signed(&area().normal(axis), &[&turned]);
        assert!((found - 5.733_247_420_397_618_5 * share).abs() < 1e-12);
    }
}

fn rotation() -> nalgebra::Rotation3<f64> {
    nalgebra::Rotation3::from_euler_angles(0.4, -0.7, 1.1)
}

#[test]
fn holes_and_pieces_end_to_end() {
    let hole = Curve::circle(Point::new(0.2, 0.1, 0.0), Vector::z(), 0.3).unwrap();
    let expected = 5.733_247_420_397_618_5 - PI * 0.09;
    for hole in [hole.clone(), hole.reverse().unwrap()] {
        let found = signed(&area().holes([1]), &[&oval(), &hole]);
        assert!((found / expected - 1.0).abs() < 1e-13, "{found}");
    }
    let both = signed(&area().of([0, 1]), &[&oval(), &hole.reverse().unwrap()]);
    assert!((both / expected - 1.0).abs() < 1e-13, "by its own direction: {both}");
    // A half disc of an arc and a line, which may run either way; and a hole of the same kind.
    let arc =
        |r: f64| Curve::elliptic_arc(Point::origin(), Vector::x() * r, Vector::y() * r, 0.0, PI).unwrap();
    let line = |r: f64| Curve::line(Point::new(-r, 0.0, 0.0), Point::new(r, 0.0, 0.0)).unwrap();
    for (line, inner) in
        [(line(1.0), line(0.5).reverse().unwrap()), (line(1.0).reverse().unwrap(), line(0.5))]
    {
        let half = signed(&area().of([1, 0]), &[&arc(1.0), &line]);
        assert!((half / (PI / 2.0) - 1.0).abs() < 1e-13);
        let shell = area().of([0, 1]).holes([2, 3]).normal([0.0, 0.0, 1.0]);
        let shell = signed(&shell, &[&arc(1.0), &line, &arc(0.5), &inner]);
        assert!((shell / (PI * 0.375) - 1.0).abs() < 1e-13, "{shell}");
    }
}

#[test]
fn spheres_boxes_and_tori() {
    for radius in [1e-9, 1.0, 1e9] {
        let found = volume_of(&sphere(radius)).unwrap();
        assert!((found / (4.0 / 3.0 * PI * radius.powi(3)) - 1.0).abs() < 1e-12, "{radius}: {found}");
    }
    // An ellipsoid: any affine image of a sphere.
    let (u, v, points, weights) = sphere(1.0).into_parts();
    let stretched = points.iter().map(|p| Point::new(2.0 * p.x + 5.0, 0.5 * p.y + p.x, 3.0 * p.z)).collect();
    let ellipsoid = Surface::build(u, v, stretched, weights).unwrap();
    assert!((volume_of(&ellipsoid).unwrap() / (4.0 * PI) - 1.0).abs() < 1e-12);
    // Patches: a cube; then each face z = 1 + b(1-s²)(1-t²) adds b (4/3)².
    for (degree, bulge, expected) in [(1, 0.0, 8.0), (3, 0.0, 8.0)] {
        let cube = patches(degree, bulge);
        let shapes: Vec<&dyn Shape> = cube.iter().map(|s| s as &dyn Shape).collect();
        let found = signed(&volume().of(0..6), &shapes);
        assert!((found.abs() / expected - 1.0).abs() < 1e-13, "{found}");
    }
    // A rational torus by Pappus.
    let circle = Curve::circle(Point::new(3.0, 0.0, 0.0), Vector::y(), 1.0).unwrap();
    let torus = Surface::revolution(&circle, Point::origin(), Vector::z(), 2.0 * PI).unwrap();
    assert!((volume_of(&torus).unwrap().abs() / (6.0 * PI * PI) - 1.0).abs() < 1e-12);
}

/// Nine evenly spaced points on every span and their weights (closed Newton–Cotes, exact up to degree 9: enough for the
/// `3p - 1` of a cubic surface's volume), so that nothing is shared with the rules that are tested.
fn newton_cotes(space: &Space) -> Vec<(f64, f64)> {
    const WEIGHTS: [f64; 9] = [989.0, 5888.0, -928.0, 10496.0, -4540.0, 10496.0, -928.0, 5888.0, 989.0];
    let breaks = space.breakpoints();
    let on = |span: &[f64]| {
        let (a, h) = (span[0], span[1] - span[0]);
        // Ends a little inside, where one-sided derivatives are this span's.
        let at = move |i: usize| a + h * (i as f64 / 8.0).clamp(1e-15, 1.0 - 1e-15);
        (0..9).map(move |i| (at(i), h * WEIGHTS[i] / 28350.0)).collect::<Vec<_>>()
    };
    breaks.windows(2).flat_map(on).collect()
}

#[test]
fn volumes_by_dense_quadrature_in_all_three_orders() {
    for surface in [torus(7, 5, 3), torus(6, 9, 2), ball(8, 6)] {
        let found = volume_of(&surface).unwrap();
        let mut totals = [0.0; 3];
        for (u, wu) in newton_cotes(surface.u()) {
            for (v, wv) in newton_cotes(surface.v()) {
                let normal =
                    surface.derivative(u, v, 1, 0).unwrap().cross(&surface.derivative(u, v, 0, 1).unwrap());
                let point = surface.point(u, v).unwrap();
                for axis in 0..3 {
                    totals[axis] += wu * wv * point[axis] * normal[axis];
                }
            }
        }
        for total in totals {
            assert!((found / total - 1.0).abs() < 1e-12, "{found} is not {total}");
        }
    }
}

#[test]
fn what_is_open_says_by_how_much() {
    let on = |count: usize| (0..count).map(On::from).collect::<Vec<_>>();
    assert_eq!(gap(&Shapes::one(&oval()), &on(1)).unwrap(), 0.0);
    let mut open = pebble();
    open.control_vertices_mut()[0].x += 0.25;
    assert!((gap(&Shapes::one(&open), &on(1)).unwrap() - 0.25).abs() < 1e-15);
    assert!(gap(&Shapes::one(&sphere(1.0)), &on(1)).unwrap() < 1e-15);
    let cube = patches(3, 0.2);
    let shapes = Shapes::new(cube.iter().map(|s| s as &dyn Shape));
    assert!(gap(&shapes, &on(6)).unwrap() < 1e-15);
    let lid = Shapes::new(cube[1..].iter().map(|s| s as &dyn Shape));
    assert!((gap(&lid, &on(5)).unwrap() - 2.0).abs() < 1e-12, "as far as the lid is wide");
}

fn middle(functional: &dyn Functional, shapes: &[&dyn Shape]) -> Point {
    let mut out = [f64::NAN; 3];
    functional.value(&Shapes::new(shapes.iter().copied()), &mut out).unwrap();
    Point::from(out)
}

#[test]
fn centroids_of_known_shapes() {
    for scale in [1e-9, 1.0, 1e9] {
        let found = middle(&centroid(), &[&circle(scale)]);
        assert!((found - Point::new(0.3, -0.2, 0.0) * scale).amax() < 1e-12 * scale, "{found}");
    }
    // A half disc: 4r/3π above its chord, here in a plane that is tilted and far away.
    let turn = rotation();
    let shift = Vector::new(3.0, -20.0, 7.0);
    let (x, y) = (turn * Vector::x() * 2.0, turn * Vector::y() * 2.0);
    let arc = Curve::elliptic_arc(Point::from(shift), x, y, 0.0, PI).unwrap();
    let line = Curve::line(Point::from(shift - x), Point::from(shift + x)).unwrap();
    let found = middle(&centroid().of([0, 1]), &[&arc, &line]);
    let expected = Point::from(shift + turn * Vector::y() * (8.0 / (3.0 * PI)));
    assert!((found - expected).amax() < 1e-12, "{found} is not {expected}");
    // A disc with a hole beside its middle.
    let disc = Curve::circle(Point::origin(), Vector::z(), 2.0).unwrap();
    let hole = Curve::circle(Point::new(1.0, 0.0, 0.0), Vector::z(), 0.5).unwrap();
    let found = middle(&centroid().holes([1]), &[&disc, &hole]);
    assert!((found - Point::new(-0.25 / 3.75, 0.0, 0.0)).amax() < 1e-12, "{found}");
    // A half ball: 3r/8 above its lid.
    let quarter = Curve::elliptic_arc(Point::origin(), Vector::x(), Vector::z(), 0.0, PI / 2.0).unwrap();
    let dome = Surface::revolution(&quarter, Point::origin(), Vector::z(), 2.0 * PI).unwrap();
    let lid = Surface::revolution(
        &Curve::line(Point::origin(), Point::new(1.0, 0.0, 0.0)).unwrap(),
        Point::origin(),
        Vector::z(),
        2.0 * PI,
    )
    .unwrap();
    let found = middle(&centroid().of([0, 1]), &[&dome, &lid]);
    assert!((found - Point::new(0.0, 0.0, 0.375)).amax() < 1e-12, "{found}");
    let volume = signed(&volume().of([0, 1]), &[&dome, &lid]);
    assert!((volume.abs() / (2.0 / 3.0 * PI) - 1.0).abs() < 1e-12, "{volume}");
    let moved: Vec<Point> = torus(7, 5, 3).points().iter().map(|p| p + Vector::new(9.0, 8.0, 7.0)).collect();
    let far = Surface::new(torus(7, 5, 3).u().clone(), torus(7, 5, 3).v().clone(), moved).unwrap();
    let apart = middle(&centroid(), &[&far]) - middle(&centroid(), &[&torus(7, 5, 3)]);
    assert!((apart - Vector::new(9.0, 8.0, 7.0)).amax() < 1e-12);
}

#[test]
fn lengths_and_surface_areas_of_known_shapes() {
    for scale in [1e-9, 1.0, 1e9] {
        let found = signed(&length(), &[&circle(scale)]);
        assert!((found / (2.0 * PI * scale) - 1.0).abs() < 1e-13);
        let found = signed(&surface_area(), &[&sphere(scale)]);
        assert!((found / (4.0 * PI * scale * scale) - 1.0).abs() < 1e-10, "{found}");
    }
    let pebble = pebble();
    let kernel = pebble.length(1e-13).unwrap().value;
    assert!((signed(&length(), &[&pebble]) / kernel - 1.0).abs() < 1e-12);
    // (t², t³): a cusp in the middle.
    let points = [(1.0, -1.0), (-1.0 / 3.0, 1.0), (-1.0 / 3.0, -1.0), (1.0, 1.0)];
    let cusp = Curve::bezier(points.map(|(x, y)| Point::new(x, y, 0.0)).to_vec()).unwrap();
    let exact = 2.0 * (13.0_f64.powf(1.5) - 8.0) / 27.0;
    assert!((signed(&length(), &[&cusp]) / exact - 1.0).abs() < 1e-12);
    let circle = Curve::circle(Point::new(3.0, 0.0, 0.0), Vector::y(), 1.0).unwrap();
    let torus = Surface::revolution(&circle, Point::origin(), Vector::z(), 2.0 * PI).unwrap();
    assert!((signed(&surface_area(), &[&torus]) / (12.0 * PI * PI) - 1.0).abs() < 1e-10);
    let cube = patches(1, 0.0);
    let shapes: Vec<&dyn Shape> = cube.iter().map(|s| s as &dyn Shape).collect();
    assert!((signed(&surface_area().of(0..6), &shapes) / 24.0 - 1.0).abs() < 1e-14);
}

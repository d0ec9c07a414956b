//! Trimmed surfaces: what their loops leave of them.

use std::f64::consts::{PI, TAU};

use loftsman_area_volume::{surface_area, volume};
use loftsman_kernel::functional::{Equation, Functional, Shapes, Store, value_of};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::spline::trimmed::{ParameterCurve, Region};
use loftsman_kernel::spline::{Curve, Space, Surface, Trimmed};
use loftsman_kernel::{Point, Vector};

fn area(shape: &dyn Shape) -> f64 {
    let mut out = [0.0];
    value_of(&surface_area(), &Shapes::one(shape), &mut out).unwrap();
    out[0]
}

fn circle(center: [f64; 2], radius: f64) -> Vec<ParameterCurve> {
    let center = Point::new(center[0], center[1], 0.0);
    vec![ParameterCurve::whole(Curve::circle(center, Vector::z(), radius).unwrap()).unwrap()]
}

fn polygon(corners: &[[f64; 2]]) -> Vec<ParameterCurve> {
    let at = |k: usize| Point::new(corners[k % corners.len()][0], corners[k % corners.len()][1], 0.0);
    (0..corners.len())
        .map(|k| ParameterCurve::whole(Curve::line(at(k), at(k + 1)).unwrap()).unwrap())
        .collect()
}

/// A surface over `[0, 3] × [0, 3]` with its parameters as coordinates, times a factor, and a height.
fn graph(degree: usize, scale: f64, height: impl Fn(f64, f64) -> f64) -> Surface {
    let space = Space::clamped(degree, &[0.0, 0.8, 2.0, 3.0]).unwrap();
    let net = (0..space.len()).flat_map(|i| (0..space.len()).map(move |j| (i, j)));
    let net = net.map(|(i, j)| {
        let (x, y) = (space.greville(i), space.greville(j));
        Point::new(x * scale, y * scale, height(x, y))
    });
    let net: Vec<Point> = net.collect();
    Surface::new(space.clone(), space, net).unwrap()
}

#[test]
fn plates_with_holes_have_their_area() {
    for scale in [1e-6, 1.0, 1e6] {
        for degree in [1, 2, 3, 7] {
            // A slope of 3/4: areas grow by 5/4.
            let plane = graph(degree, scale, |x, _| 0.75 * scale * x);
            let cut = |regions: Vec<Region>| {
                let shape = Trimmed::new(plane.clone(), regions, vec![], vec![]).unwrap();
                area(&shape) / (1.25 * scale * scale)
            };
            let near = |found: f64, wanted: f64| {
                assert!((found - wanted).abs() < 2e-12 * wanted, "{degree} {scale}: {found} {wanted}");
            };
            let hole = circle([1.5, 1.4], 0.7);
            near(cut(vec![Region { outer: vec![], holes: vec![hole.clone()] }]), 9.0 - PI * 0.49);
            let ring = Region { outer: circle([1.5, 1.4], 1.3), holes: vec![hole] };
            near(cut(vec![ring]), PI * (1.69 - 0.49));
            // Whichever way a loop runs.
            let corners = [[0.2, 0.1], [2.9, 0.3], [1.1, 2.7]];
            let back = [corners[2], corners[1], corners[0]];
            for chain in [corners, back] {
                near(cut(vec![Region { outer: polygon(&chain), holes: vec![] }]), 3.42);
            }
        }
    }
}

#[test]
fn curved_ones_converge_to_what_is_known() {
    // Of z = u² the part with v < u: ∫ u √(1 + 4u²) du.
    let parabola = graph(2, 1.0, |x, _| x);
    let mut bent = parabola.clone();
    let space = bent.u().clone();
    let knots = space.flat().to_vec();
    // The coefficients of x² are products of two knots.
    for i in 0..space.len() {
        for j in 0..space.len() {
            bent.control_vertices_mut()[i * space.len() + j].z = knots[i + 1] * knots[i + 2];
        }
    }
    let corners = [[0.0, 0.0], [3.0, 0.0], [3.0, 3.0]];
    let shape =
        Trimmed::new(bent, vec![Region { outer: polygon(&corners), holes: vec![] }], vec![], vec![]).unwrap();
    let expected = (37.0_f64.powf(1.5) - 1.0) / 12.0;
    let found = area(&shape);
    assert!((found / expected - 1.0).abs() < 1e-11, "{found} {expected}");
    // Of a periodic cylinder what a loop over its seam bounds.
    let ring = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap().to_periodic(1e-12).unwrap().shape;
    let wall = Surface::extrusion(&ring, Vector::z() * 3.0).unwrap();
    let (start, end) = wall.u().domain();
    let length = (end - start) / TAU;
    let corners = [[-0.3, 1.0], [0.4, 1.0], [0.4, 2.0], [-0.3, 2.0]];
    let window = polygon(&corners.map(|c| [start + length * c[0], c[1] / 3.0]));
    let region = Region { outer: window, holes: vec![] };
    let on_seam = Trimmed::new(wall.clone(), vec![region], vec![], vec![]).unwrap();
    let at = |u: f64| wall.point(u, 0.0).unwrap();
    let angle = |u: f64| at(u).y.atan2(at(u).x);
    let (a, b) = (start + length * 0.4, start - length * 0.3 + (end - start));
    let turn = (angle(a) - angle(b)).rem_euclid(TAU);
    let found = area(&on_seam);
    assert!((found - turn).abs() < 1e-11, "{found} {turn}");
}

#[test]
fn areas_change_as_their_gradients_say() {
    let wave = graph(3, 1.0, |x, y| 0.4 * (1.3 * x + 0.2).sin() * (y - 0.3).cos());
    let region = Region {
        outer: circle([1.95, 1.95], 1.0),
        holes: vec![polygon(&[[1.7, 1.6], [2.4, 1.8], [1.9, 2.5]])],
    };
    let shape = Trimmed::new(wave, vec![region], vec![], vec![]).unwrap();
    assert!(shape.cells().unwrap().is_partial());
    let functional = surface_area();
    let bound = functional.bind(&Shapes::one(&shape)).unwrap().unwrap();
    let mut rows = Store::default();
    bound.rows(&Shapes::one(&shape), &mut rows.rows(&Shapes::one(&shape))).unwrap();
    let (count, step) = (shape.control_vertices().len(), 1e-6);
    let mut gradient = vec![Vector::zeros(); count];
    for equation in rows.equations() {
        let Equation::Coupled { vertices, vectors, .. } = equation else { unreachable!() };
        vertices.iter().zip(vectors).for_each(|(&vertex, c)| gradient[vertex] += c);
    }
    let mut unseen = 0;
    for vertex in 0..count {
        for axis in 0..3 {
            let at = |by: f64| {
                let mut moved = shape.clone();
                moved.control_vertices_mut()[vertex][axis] += by;
                area(&moved)
            };
            let slope = (at(step) - at(-step)) / (2.0 * step);
            assert!(
                (slope - gradient[vertex][axis]).abs() < 1e-8,
                "{vertex} {axis}: {slope} {:?}",
                gradient[vertex]
            );
        }
        unseen += usize::from(gradient[vertex] == Vector::zeros());
    }
    assert!(unseen > 0, "what lies outside of the loops has no part in it");
}

#[test]
fn loops_that_bound_nothing_are_refused() {
    let corners = [[0.5, 0.5], [2.5, 0.5], [2.5, 2.5], [0.5, 2.5]];
    let outer = polygon(&corners);
    let region = |holes| Region { outer: outer.clone(), holes };
    let twice = polygon(&[[0.2, 1.0], [1.0, 1.0], [1.0, 2.0], [0.2, 2.0]]);
    let shape = Trimmed::new(graph(2, 1.0, |_, _| 0.0), vec![region(vec![twice])], vec![], vec![]).unwrap();
    let mut out = [0.0];
    let said = value_of(&surface_area(), &Shapes::one(&shape), &mut out).unwrap_err().to_string();
    assert!(said.contains("more than once"), "{said}");
    let open = Trimmed::new(graph(2, 1.0, |_, _| 0.0), vec![region(vec![])], vec![], vec![]).unwrap();
    assert!(value_of(&volume(), &Shapes::one(&open), &mut out).is_err());
}

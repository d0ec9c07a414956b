//! Edges of limit surfaces joined: to one another, to splines, to themselves.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use loftsman_kernel::edit::{Ask, Edit, Metric};
use loftsman_kernel::functional::{Edge, derivative, join, position, symmetry};
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::spline::{Space, Surface};
use loftsman_kernel::{Point, Vector};
use loftsman_subdivision::catmull_clark::refine;
use loftsman_subdivision::{Cage, SubdivisionSurface};

fn sheet(rows: usize, columns: usize, to: Vector) -> SubdivisionSurface {
    let mut cage = crate::shapes::grid(rows, columns, [false, false], 0.15);
    cage.points_mut().iter_mut().for_each(|p| *p += to);
    SubdivisionSurface::new(cage).unwrap()
}

/// The number of the edge between two vertices of the cage, in the direction in which its face runs.
fn edge(surface: &SubdivisionSurface, a: usize, b: usize) -> usize {
    let edges = Shape::edges(surface).unwrap();
    let wanted = [format!("{a}-{b}"), format!("{b}-{a}")];
    edges.iter().position(|e| wanted.iter().any(|w| *w == e.name)).unwrap()
}

/// The largest difference of the derivatives across an edge, at places that the equations do not know.
fn gap(a: &dyn Shape, first: usize, b: &dyn Shape, second: usize, order: usize, turned: bool) -> f64 {
    let on = |shape: &dyn Shape, index: usize, t: f64| {
        let edge = shape.edges().unwrap().edge(index).unwrap();
        let by = if edge.along_u { [0, order] } else { [order, 0] };
        let out = if edge.at_end { 1.0 } else { -1.0 };
        let share = edge.start + (edge.end - edge.start) * t;
        shape.value(edge.at(share), Derivative::from(by)).unwrap() * if order == 1 { out } else { 1.0 }
    };
    let differ = |t: f64| {
        let (x, y) = (on(a, first, t), on(b, second, if turned { 1.0 - t } else { t }));
        if order == 1 { (x + y).norm() } else { (x - y).norm() }
    };
    (0..=20).map(|k| differ(f64::from(k) / 20.0)).fold(0.0, f64::max)
}

#[test]
fn two_limits_meet_along_a_whole_side() {
    // The last row of one is the first of the other, but for the noise of both.
    let (a, b) = (sheet(5, 6, Vector::zeros()), sheet(5, 6, Vector::new(4.0, 0.1, 0.2)));
    let sides: Vec<(usize, usize)> = (0..5).map(|k| (edge(&a, 24 + k, 25 + k), edge(&b, k, k + 1))).collect();
    for order in 0..=2 {
        let ask = |edit: Edit<SubdivisionSurface>, &(i, j): &(usize, usize)| {
            edit.ask(join(Edge::Number(i), 1, Edge::Number(j), order).keep())
        };
        let edit = sides.iter().fold(Edit::new(&a).with(b.boxed()), ask);
        let edited = edit.solve().unwrap();
        let (left, right) = (edited.shape(), edited.shape_at(1).unwrap());
        for &(i, j) in &sides {
            for k in 0..=order.min(1) {
                let off = [false, true].map(|turned| gap(left, i, right, j, k, turned));
                assert!(off[0].min(off[1]) < 1e-12, "order {order}, derivative {k}: {off:?}");
            }
        }
        assert!(edited.report().adjustment > 0.1, "they did not meet before");
        // Far from the side nothing moves.
        assert_eq!(left.control_vertices()[0], a.control_vertices()[0]);
    }
}

#[test]
fn a_limit_meets_a_spline() {
    let a = sheet(5, 5, Vector::zeros());
    let (i, line) = (edge(&a, 21, 22), Space::clamped_uniform(3, 4).unwrap());
    let net =
        (0..16).map(|k| Point::new(4.0 + f64::from(k / 4), 1.0 + f64::from(k % 4) / 3.0, 0.3)).collect();
    let patch = Surface::new(line.clone(), line, net).unwrap();
    for order in 0..=1 {
        let edit = Edit::new(&a).with(Box::new(patch.clone()));
        let edited = edit.ask(join(Edge::Number(i), 1, Edge::UStart, order).keep()).solve().unwrap();
        let (left, right) = (edited.shape(), edited.shape_at(1).unwrap());
        let side = right.edges().unwrap().iter().position(|e| e.name == "u0").unwrap();
        for k in 0..=order {
            let off = [false, true].map(|turned| gap(left, i, right, side, k, turned));
            assert!(off[0].min(off[1]) < 1e-12, "order {order}, derivative {k}: {off:?}");
        }
        // And the other way round: the spline first, the limit as it is.
        let edit = Edit::new(&patch).with(a.boxed()).lock_on(1, 0..25);
        let edited = edit.ask(join(Edge::UStart, 1, Edge::Number(i), order).keep()).solve().unwrap();
        let off = [false, true].map(|turned| gap(edited.shape(), side, &a, i, order, turned));
        assert!(off[0].min(off[1]) < 1e-12, "order {order}: {off:?}");
    }
}

#[test]
fn a_limit_closes_onto_itself() {
    // A strip bent to a ring that does not quite close.
    let mut cage = crate::shapes::grid(9, 4, [false, false], 0.05);
    for (k, p) in cage.points_mut().iter_mut().enumerate() {
        let turn = 0.95 * std::f64::consts::TAU * (k / 4) as f64 / 8.0;
        *p = Point::new(2.0 * turn.cos() + p.z, 2.0 * turn.sin(), p.y);
    }
    let strip = SubdivisionSurface::new(cage).unwrap();
    let pairs: Vec<(usize, usize)> =
        (0..3).map(|k| (edge(&strip, k, k + 1), edge(&strip, 32 + k, 33 + k))).collect();
    for order in 0..=1 {
        let ask = |edit: Edit<SubdivisionSurface>, &(i, j): &(usize, usize)| {
            edit.ask(join(Edge::Number(i), 0, Edge::Number(j), order).keep())
        };
        let edited = pairs.iter().fold(Edit::new(&strip), ask).solve().unwrap();
        let ring = edited.shape();
        for &(i, j) in &pairs {
            for k in 0..=order {
                let off = [false, true].map(|turned| gap(ring, i, ring, j, k, turned));
                assert!(off[0].min(off[1]) < 1e-12, "order {order}, derivative {k}: {off:?}");
            }
        }
    }
}

/// A sheet of which a boundary vertex has three faces instead of two.
fn uneven() -> (SubdivisionSurface, usize) {
    let ring = |k: usize, r: f64| {
        let t = std::f64::consts::PI * k as f64 / 6.0;
        Point::new(r * t.cos(), r * t.sin(), 0.1 * crate::shapes::noise(k as u64))
    };
    let points: Vec<Point> = [Point::origin()].into_iter().chain((0..7).map(|k| ring(k, 1.0))).collect();
    let faces = [[0, 1, 2, 3], [0, 3, 4, 5], [0, 5, 6, 7]];
    let surface = SubdivisionSurface::new(Cage::new(points, &faces).unwrap()).unwrap();
    let number = edge(&surface, 0, 1);
    (surface, number)
}

#[test]
fn edges_that_end_at_extraordinary_vertices_are_joined_by_position_and_no_more() {
    let (a, i) = uneven();
    let line = Space::clamped_uniform(3, 4).unwrap();
    let net = (0..16).map(|k| Point::new(f64::from(k / 4) / 3.0, -f64::from(k % 4), 0.2)).collect();
    let patch = Surface::new(line.clone(), line, net).unwrap();
    let ask = |order: usize| {
        let edit = Edit::new(&a).with(Box::new(patch.clone()));
        edit.ask(join(Edge::Number(i), 1, Edge::VStart, order).keep()).solve()
    };
    let edited = ask(0).unwrap();
    let right = edited.shape_at(1).unwrap();
    let side = right.edges().unwrap().iter().position(|e| e.name == "v0").unwrap();
    let off = [false, true].map(|turned| gap(edited.shape(), i, right, side, 0, turned));
    assert!(off[0].min(off[1]) < 1e-12, "{off:?}");
    let refused = ask(1).unwrap_err().to_string();
    assert!(refused.contains("0-1") && refused.contains("extraordinary"), "{refused}");
    println!("{refused}");
    // What it advises: places of it one by one, or the part of a finer cage that is away from the vertex.
    let at = |t: f64| a.edges().unwrap().edge(i).unwrap().at(t);
    let first = |on: &dyn Shape, at: Location, by: [usize; 2]| on.value(at, Derivative::from(by)).unwrap();
    let places = [0.25, 0.75].into_iter().fold(Edit::new(&a), |edit, t| {
        let slope = first(&a, at(t), [0, 1]) + Vector::new(0.0, 0.1, 0.2);
        edit.ask(position(at(t)).keep()).ask(derivative(at(t), [0, 1]).to(slope))
    });
    let places = places.solve().unwrap();
    let moved = first(places.shape(), at(0.75), [0, 1]) - first(&a, at(0.75), [0, 1]);
    assert!((moved - Vector::new(0.0, 0.1, 0.2)).norm() < 1e-12, "{moved}");
    let finer = SubdivisionSurface::new(refine(a.cage()).unwrap()).unwrap();
    let parts: Vec<usize> = finer
        .edges()
        .unwrap()
        .iter()
        .enumerate()
        .filter_map(|(k, e)| e.name.contains("-1").then_some(k).or(e.name.starts_with("1-").then_some(k)))
        .collect();
    let joined = parts.iter().filter(|&&k| {
        let edit = Edit::new(&finer).with(Box::new(patch.clone()));
        let Ok(edited) = edit.ask(join(Edge::Number(k), 1, Edge::VStart, 1).keep()).solve() else {
            return false;
        };
        let right = edited.shape_at(1).unwrap();
        let off = [false, true].map(|turned| gap(edited.shape(), k, right, side, 1, turned));
        off[0].min(off[1]) < 1e-12
    });
    assert!(joined.count() >= 1, "{parts:?}");
}

/// As on splines: a mirror image stays one, and is brought about where it is not.
#[test]
fn symmetry_holds_of_every_point_of_the_limit() {
    let cage = crate::shapes::grid(5, 5, [false, false], 0.0);
    let mut surface = SubdivisionSurface::new(cage).unwrap();
    for (k, p) in surface.control_vertices_mut().iter_mut().enumerate() {
        *p += Vector::from_fn(|axis, _| 1e-3 * crate::shapes::noise((3 * k + axis) as u64));
    }
    let plane = || symmetry(Vector::x(), Point::new(2.0, 0.0, 0.0));
    let to = Point::new(1.1, 1.2, 1.0);
    // Halfway along the first direction face `4 i + j` and face `4 (3 - i) + j` mirror one another.
    let edit = Edit::new(&surface).ask(plane().hold()).ask(position(Location::Vertex(6)).to(to));
    let edited = edit.solve().unwrap();
    let after = edited.shape();
    let value = |at: Location| after.value(at, Derivative::POSITION).unwrap();
    assert!((value(Location::Vertex(6)) - to.coords).norm() < 1e-12);
    for i in 0..4_u32 {
        for j in 0..4_u32 {
            let (u, v) = (0.3, 0.85);
            let (x, y) =
                (value(Location::Face(4 * i + j, u, v)), value(Location::Face(4 * (3 - i) + j, 1.0 - u, v)));
            assert!((Vector::new(4.0 - x.x, x.y, x.z) - y).norm() < 1e-12, "face {i}, {j}: {x} {y}");
        }
    }
}

/// On a regular grid the falloff is a spline's: both have the same net of neighbours in the middle.
#[test]
fn a_falloff_is_as_far_as_it_says() {
    let surface = SubdivisionSurface::new(crate::shapes::grid(11, 11, [false, false], 0.0)).unwrap();
    for radius in [1.0, 2.0, 3.0] {
        let edit = Edit::new(&surface).metric(Metric::Falloff(radius));
        let edited = edit.ask(position(Location::Vertex(60)).by(Vector::z())).solve().unwrap();
        let ways: Vec<Vector> = edited
            .shape()
            .control_vertices()
            .iter()
            .zip(surface.control_vertices())
            .map(|(a, b)| a - b)
            .collect();
        // The limit of vertex 60 depends on its eight neighbours; from each the falloff takes along fewer than `radius` steps.
        for (k, way) in ways.iter().enumerate() {
            let steps = (k / 11).abs_diff(5).max((k % 11).abs_diff(5));
            let free = (steps as f64) < 1.0 + radius;
            assert!(free || way.norm() == 0.0, "radius {radius}: vertex {k} moved by {way}");
        }
        // What is symmetric stays so: the eight symmetries of the square.
        for i in 0..11 {
            for j in 0..11 {
                let off = [(j, i), (10 - i, j), (i, 10 - j)]
                    .map(|(a, b)| (ways[11 * i + j] - ways[11 * a + b]).norm());
                assert!(off.iter().all(|o| *o < 1e-13), "radius {radius}: {off:?}");
            }
        }
        let there = edited.shape().value(Location::Vertex(60), Derivative::POSITION).unwrap();
        let before = surface.value(Location::Vertex(60), Derivative::POSITION).unwrap();
        assert!((there - before - Vector::z()).norm() < 1e-13);
    }
}

//! Edges of elementary surfaces, whose parameters are known.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::super::{CurveForm, Edge, Face, Frame, Parts, SurfaceForm, Use, Vertex};
use super::*;
use crate::Vector;

fn frame() -> Frame {
    Frame::new(Point::origin(), Vector::z(), Vector::x()).unwrap()
}

fn edge(curve: Curve, ends: [usize; 2]) -> Edge {
    let range = curve.domain();
    Edge { curve, range, ends, tolerance: 0.0, form: CurveForm::Spline }
}

/// One face with one loop of edges, forwards or backwards.
fn face(surface: Surface, edges: Vec<Edge>, chain: &[(usize, bool)], reversed: bool) -> Brep {
    let count = edges.iter().flat_map(|edge| edge.ends).max().unwrap() + 1;
    let mut vertices = vec![Vertex { point: Point::origin(), tolerance: 0.0 }; count];
    for edge in &edges {
        for (t, end) in [edge.range.0, edge.range.1].into_iter().zip(edge.ends) {
            vertices[end].point = edge.curve.point(t).unwrap();
        }
    }
    let uses = chain.iter().map(|&(edge, reversed)| Use { edge, reversed, parameters: None }).collect();
    let form = SurfaceForm::Spline;
    let face = Face { name: None, color: None, surface, form, reversed, loops: vec![uses], points: vec![] };
    Brep::new(Parts { vertices, edges, faces: vec![face], shells: vec![], solids: vec![] }).unwrap()
}

/// The only loop, and its ends in the direction of the loop; what is said of every curve is checked.
fn projected(brep: &Brep) -> (Vec<Projected>, Vec<[[f64; 2]; 2]>) {
    let loops = brep.parameter_curves(0).unwrap();
    let surface = brep.surface(0).unwrap();
    let sides = surface.parameter_sides(1e-9).unwrap();
    let mut ends = Vec::new();
    for (one, used) in loops[0].iter().zip(&brep.loops(0)[0]) {
        let edge = brep.edge(used.edge).unwrap();
        let part = edge.curve.between(edge.range.0, edge.range.1).unwrap();
        let (a, b) = one.curve.range();
        let (start, end) = part.domain();
        for k in 0..=200 {
            let share = f64::from(k) / 200.0;
            let p = one.curve.curve().point((a + (b - a) * share).min(b)).unwrap();
            let on = surface.point(sides[0].wrapped(p.x), sides[1].wrapped(p.y)).unwrap();
            let off = if one.curve.curve().degree() > 1 && (a, b) == (start, end) {
                (part.point((start + (end - start) * share).min(end)).unwrap() - on).norm()
            } else {
                part.closest(on).unwrap().distance
            };
            assert!(off <= one.error + 1e-13, "edge {} at {share}: {off:e} of {:e}", used.edge, one.error);
        }
        let [from, to] = one.curve.ends().unwrap();
        ends.push(if used.reversed { [to, from] } else { [from, to] });
    }
    (loops.into_iter().next().unwrap(), ends)
}

fn near(found: &[[[f64; 2]; 2]], expected: &[[[f64; 2]; 2]]) {
    let all = found.iter().flatten().flatten().zip(expected.iter().flatten().flatten());
    let off = all.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(found.len() == expected.len() && off < 1e-9, "{found:?} {expected:?}");
}

fn circle(height: f64, radius: f64) -> Curve {
    Curve::circle(Point::new(0.0, 0.0, height), Vector::z(), radius).unwrap()
}

/// The frame whose angles start where circles do.
fn with_circles() -> Frame {
    let start = circle(0.0, 1.0).point(0.0).unwrap();
    Frame::new(Point::origin(), Vector::z(), start.coords).unwrap()
}

#[test]
fn edges_of_planes_are_their_own_curves() {
    let block = Brep::block(Point::new(-1.0, 2.0, 0.5), Point::new(2.0, 3.0, 4.0)).unwrap();
    for face in 0..6 {
        let loops = block.parameter_curves(face).unwrap();
        let ends: Vec<_> = loops[0].iter().map(|one| one.curve.ends().unwrap()).collect();
        for (k, used) in block.loops(face)[0].iter().enumerate() {
            assert!(loops[0][k].error < 1e-15 && loops[0][k].curve.curve().degree() == 1);
            let next = (k + 1) % 4;
            let end = ends[k][usize::from(!used.reversed)];
            let start = ends[next][usize::from(block.loops(face)[0][next].reversed)];
            assert!((0..2).all(|d| (end[d] - start[d]).abs() < 1e-15));
        }
    }
    // A rational circle on a skew plane over another domain, refined: exact, vertex for vertex.
    let [o, a, b] = [Vector::new(1.0, 2.0, 3.0), Vector::new(2.0, 0.1, 0.0), Vector::new(0.7, 1.5, 0.0)];
    let at = |u: f64, v: f64| Point::from(o + a * u + b * v);
    let space = crate::spline::Space::clamped(2, &[-1.0, 0.25, 1.0]).unwrap();
    let net = (0..4).flat_map(|i| (0..4).map(move |j| (i, j)));
    let net = net.map(|(i, j)| at(space.greville(i), space.greville(j))).collect();
    let surface = Surface::new(space.clone(), space.clone(), net).unwrap();
    let ring = Curve::circle(at(0.1, 0.0), Vector::z(), 0.4).unwrap();
    let brep = face(surface, vec![edge(ring.clone(), [0, 0])], &[(0, false)], false);
    let (curves, _) = projected(&brep);
    assert!(curves[0].error < 1e-14 && curves[0].curve.curve().weights() == ring.weights());
}

#[test]
fn seams_are_on_both_sides_of_the_domain() {
    let ends = [circle(0.0, 2.0).point(0.0).unwrap(), circle(3.0, 2.0).point(0.0).unwrap()];
    let side = SurfaceForm::Cylinder { frame: with_circles(), radius: 2.0 }.covering(&ends).unwrap();
    let edges = vec![
        edge(circle(0.0, 2.0), [0, 0]),
        edge(circle(3.0, 2.0), [1, 1]),
        edge(Curve::line(ends[0], ends[1]).unwrap(), [0, 1]),
    ];
    let expected = [
        [[0.0, 0.0], [TAU, 0.0]],
        [[TAU, 0.0], [TAU, 3.0]],
        [[TAU, 3.0], [0.0, 3.0]],
        [[0.0, 3.0], [0.0, 0.0]],
    ];
    let uses = [(0, false), (2, false), (1, true), (2, true)];
    for first in 0..4 {
        let mut chain = uses.to_vec();
        chain.rotate_left(first);
        let mut expected = expected.to_vec();
        expected.rotate_left(first);
        for surface in [side.clone(), side.to_periodic(crate::spline::Direction::U, 1e-12).unwrap().shape] {
            let (curves, found) = projected(&face(surface, edges.clone(), &chain, false));
            near(&found, &expected);
            assert!(curves.iter().all(|one| one.curve.curve().degree() == 1 && one.error < 1e-13));
        }
    }
}

#[test]
fn loops_go_along_poles_with_the_face_to_their_left() {
    let sphere = SurfaceForm::Sphere { frame: with_circles(), radius: 1.0 }.covering(&[]).unwrap();
    let x = circle(0.0, 1.0).point(0.0).unwrap().coords;
    let arc =
        |from: f64, to: f64| Curve::elliptic_arc(Point::origin(), x, Vector::z(), from, to - from).unwrap();
    // The upper half, and the whole.
    let half = vec![edge(circle(0.0, 1.0), [0, 0]), edge(arc(0.0, FRAC_PI_2), [0, 1])];
    let brep = face(sphere.clone(), half.clone(), &[(0, false), (1, false), (1, true)], false);
    let top = FRAC_PI_2;
    near(
        &projected(&brep).1,
        &[[[0.0, 0.0], [TAU, 0.0]], [[TAU, 0.0], [TAU, top]], [[0.0, top], [0.0, 0.0]]],
    );
    let whole = vec![edge(arc(-FRAC_PI_2, FRAC_PI_2), [0, 1])];
    let brep = face(sphere.clone(), whole.clone(), &[(0, false), (0, true)], false);
    near(&projected(&brep).1, &[[[TAU, -top], [TAU, top]], [[0.0, top], [0.0, -top]]]);
    // Turned inside out, loops run the other way.
    let brep = face(sphere.clone(), whole, &[(0, true), (0, false)], true);
    near(&projected(&brep).1, &[[[TAU, top], [TAU, -top]], [[0.0, -top], [0.0, top]]]);
    // With an edge that is a point, too.
    let tip = Curve::line(Point::new(0.0, 0.0, 1.0), Point::new(0.0, 0.0, 1.0)).unwrap();
    let mut edges = half;
    edges.push(edge(tip, [1, 1]));
    let brep = face(sphere.clone(), edges, &[(0, false), (1, false), (2, false), (1, true)], false);
    near(&projected(&brep).1[2..3], &[[[TAU, top], [0.0, top]]]);
    // A quarter of it: two meridians and the equator between them.
    let meridian = |angle: f64| {
        let x = nalgebra::Rotation3::from_axis_angle(&Vector::z_axis(), angle) * x;
        Curve::elliptic_arc(Point::origin(), x, Vector::z(), 0.0, FRAC_PI_2).unwrap()
    };
    let y = Vector::z().cross(&x);
    let low = Curve::elliptic_arc(Point::origin(), x, y, 0.3, 1.0).unwrap();
    let edges = vec![edge(low, [0, 1]), edge(meridian(0.3), [0, 2]), edge(meridian(1.3), [1, 2])];
    let brep = face(sphere, edges, &[(0, false), (2, false), (1, true)], false);
    let across = [[[0.3, 0.0], [1.3, 0.0]], [[1.3, 0.0], [1.3, top]], [[0.3, top], [0.3, 0.0]]];
    // Angles and parameters are the same at eighths of turns only: rational arcs.
    let (_, found) = projected(&brep);
    let bent = brep.surface(0).unwrap().closest(brep.vertices()[0]).unwrap().at.0;
    assert!((bent - 0.3).abs() < 0.03 && (found[0][0][0] - bent).abs() < 1e-9, "{found:?} {across:?}");
    assert!((found[2][0][0] - bent).abs() < 1e-9 && (found[1][1][0] - found[0][1][0]).abs() < 1e-9);
    assert_eq!((found[1][1][1], found[2][0][1]), (top, top));
}

#[test]
fn curved_ones_are_fitted_as_near_as_promised() {
    let top = [Point::new(0.0, 0.0, -4.0), Point::new(0.0, 0.0, 4.0)];
    let cylinder = SurfaceForm::Cylinder { frame: frame(), radius: 1.0 }.covering(&top).unwrap();
    // Ellipses around the cylinder, from wherever they start.
    for (k, tilt) in [0.01, 0.5, 3.0].into_iter().enumerate() {
        let (x, y) = (Vector::new(0.8, -0.6, 0.3 * tilt), Vector::new(0.6, 0.8, -tilt));
        let ring = Curve::elliptic_arc(Point::origin(), x, y, k as f64, TAU).unwrap();
        let size = size_of(ring.points());
        let brep = face(cylinder.clone(), vec![edge(ring, [0, 0])], &[(0, false)], false);
        let (curves, ends) = projected(&brep);
        assert!(
            curves[0].error <= 1e-9 * size && curves[0].curve.curve().degree() == 7,
            "{:e}",
            curves[0].error
        );
        assert!((ends[0][1][0] - ends[0][0][0] - TAU).abs() < 1e-8, "{ends:?}");
        assert!(curves[0].curve.curve().points().len() < 300);
    }
    // A tolerance that the file gives is enough, to a tenth.
    let ring =
        Curve::elliptic_arc(Point::origin(), Vector::x(), Vector::new(0.0, 1.0, 2.0), 0.0, TAU).unwrap();
    let mut loose = edge(ring, [0, 0]);
    loose.tolerance = 1e-3;
    let (curves, _) = projected(&face(cylinder, vec![loose], &[(0, false)], false));
    assert!(curves[0].error <= 1e-4 && curves[0].curve.curve().points().len() < 60);
    // A great circle through both poles: along their sides of the domain.
    let sphere = SurfaceForm::Sphere { frame: frame(), radius: 1.0 }.covering(&[]).unwrap();
    let x = Vector::new(1.0, 0.4, 0.0).normalize();
    let ring = Curve::elliptic_arc(Point::origin(), x, Vector::z(), 0.2, TAU).unwrap();
    let (curves, ends) = projected(&face(sphere, vec![edge(ring, [0, 0])], &[(0, false)], false));
    assert!(curves[0].error < 1e-8, "{:e}", curves[0].error);
    assert!((ends[0][0][1] - ends[0][1][1]).abs() < 1e-9, "{ends:?}");
    let turns = (ends[0][0][0] - ends[0][1][0]) / TAU;
    assert!((turns - turns.round()).abs() < 1e-9, "{ends:?}");
}

#[test]
fn files_curves_are_taken_where_they_are_right() {
    let side = SurfaceForm::Cylinder { frame: with_circles(), radius: 2.0 };
    let side = side.covering(&[Point::origin(), Point::new(0.0, 0.0, 3.0)]).unwrap();
    let brep = face(side, vec![edge(circle(1.0, 2.0), [0, 0])], &[(0, false)], false);
    let given = |height: f64| {
        let line = Curve::line(Point::new(TAU, height, 0.0), Point::new(2.0 * TAU, height, 0.0)).unwrap();
        let mut parts = brep.parts();
        parts.faces[0].loops[0][0].parameters =
            Some(ParameterCurve::whole(line.elevate(3).unwrap()).unwrap());
        Brep::new(parts).unwrap().parameter_curves(0).unwrap().remove(0).remove(0)
    };
    let (right, wrong) = (given(1.0), given(1.1));
    assert!(right.error < 1e-12 && wrong.error < 1e-12);
    assert_eq!((right.curve.curve().degree(), wrong.curve.curve().degree()), (4, 1));
    let ends = right.curve.ends().unwrap();
    assert!((ends[0][0]).abs() < 1e-12 && (ends[1][0] - TAU).abs() < 1e-12, "within the domain: {ends:?}");
}

#[test]
fn edges_that_are_off_say_by_how_much() {
    let sphere = SurfaceForm::Sphere { frame: frame(), radius: 1.0 }.covering(&[]).unwrap();
    let x = Vector::new(1.0, 0.2, 0.0).normalize();
    let y = Vector::new(-0.1, 0.6, 0.8);
    let y = (y - x * x.dot(&y)).normalize();
    let arc = Curve::elliptic_arc(Point::origin(), x * 1.01, y * 1.01, 0.3, PI).unwrap();
    let back = Curve::elliptic_arc(Point::origin(), -x * 1.01, -y * 1.01, 0.3, PI).unwrap();
    let brep = face(sphere, vec![edge(arc, [0, 1]), edge(back, [1, 0])], &[(0, false), (1, false)], false);
    let (curves, _) = projected(&brep);
    for one in curves {
        assert!((one.error - 0.01).abs() < 1e-6, "{:e}", one.error);
        assert!(one.curve.curve().points().len() < 100);
    }
    assert!(brep.parameter_curves(1).is_err());
}

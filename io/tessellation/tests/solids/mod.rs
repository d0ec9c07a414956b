//! Solids built by hand.
#![allow(clippy::unwrap_used, reason = "a test may stop at what should not be")]

use std::f64::consts::{PI, TAU};

use loftsman_kernel::brep::{
    Brep, CurveForm, Edge, Face, Frame, Parts, Shell, Solid, SurfaceForm, Use, Vertex,
};
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Vector};

pub(crate) fn p(x: f64, y: f64, z: f64) -> Point {
    Point::new(x, y, z)
}

fn frame(origin: Point, z: Vector, x: Vector) -> Frame {
    Frame::new(origin, z, x).unwrap()
}

pub(crate) fn vertex(point: Point) -> Vertex {
    Vertex { point, tolerance: 1e-12 }
}

pub(crate) fn edge(curve: Curve, ends: [usize; 2]) -> Edge {
    let range = curve.domain();
    Edge { curve, range, ends, tolerance: 1e-12, form: CurveForm::Spline }
}

pub(crate) fn line(a: Point, b: Point, ends: [usize; 2]) -> Edge {
    edge(Curve::line(a, b).unwrap(), ends)
}

/// A circle around z, from x on.
pub(crate) fn circle(height: f64, radius: f64, vertex: usize) -> Edge {
    edge(Curve::circle(p(0.0, 0.0, height), Vector::z(), radius).unwrap(), [vertex; 2])
}

pub(crate) fn along(edge: usize) -> Use {
    Use { edge, reversed: false, parameters: None }
}

pub(crate) fn against(edge: usize) -> Use {
    Use { edge, reversed: true, parameters: None }
}

pub(crate) fn face(form: SurfaceForm, points: &[Point], reversed: bool, loops: Vec<Vec<Use>>) -> Face {
    Face {
        name: None,
        color: None,
        surface: form.covering(points).unwrap(),
        form,
        reversed,
        loops,
        points: vec![],
    }
}

/// One shell of all faces, and a solid where it closes.
pub(crate) fn whole(vertices: Vec<Vertex>, edges: Vec<Edge>, faces: Vec<Face>, solid: bool) -> Brep {
    let shells = vec![Shell { faces: (0..faces.len()).collect() }];
    let solids = if solid { vec![Solid::default()] } else { vec![] };
    Brep::new(Parts { vertices, edges, faces, shells, solids }).unwrap()
}

fn corner(k: usize) -> Point {
    p((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64)
}

const RINGS: [[usize; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

fn box_parts() -> (Vec<Vertex>, Vec<Edge>, Vec<Face>) {
    let vertices = (0..8).map(|k| vertex(corner(k))).collect();
    let (mut edges, mut faces): (Vec<Edge>, Vec<Face>) = (Vec::new(), Vec::new());
    for ring in RINGS {
        let mut chain = Vec::new();
        for k in 0..4 {
            let (a, b) = (ring[k], ring[(k + 1) % 4]);
            if let Some(known) = edges.iter().position(|e| e.ends == [b, a]) {
                chain.push(against(known));
            } else {
                edges.push(line(corner(a), corner(b), [a, b]));
                chain.push(along(edges.len() - 1));
            }
        }
        let [a, b, c] = [0, 1, 2].map(|k| corner(ring[k]));
        let form = SurfaceForm::Plane { frame: frame(a, (b - a).cross(&(c - b)), b - a) };
        faces.push(face(form, &ring.map(corner), false, vec![chain]));
    }
    (vertices, edges, faces)
}

/// The cube from 0 to 1.
pub(crate) fn cube() -> Brep {
    let (vertices, edges, faces) = box_parts();
    whole(vertices, edges, faces, true)
}

/// The cube from 0 to 1 with a hole along z through its middle.
pub(crate) fn drilled_cube(radius: f64) -> Brep {
    let (mut vertices, mut edges, mut faces) = box_parts();
    let ring = |height: f64, at: usize| {
        edge(Curve::circle(p(0.5, 0.5, height), Vector::z(), radius).unwrap(), [at; 2])
    };
    let start = ring(0.0, 8).curve.point(0.0).unwrap();
    vertices.push(vertex(start));
    vertices.push(vertex(p(start.x, start.y, 1.0)));
    edges.push(ring(0.0, 8));
    edges.push(ring(1.0, 9));
    // The bottom is seen from below, where the circle runs clockwise, as holes do.
    faces[0].loops.push(vec![along(12)]);
    faces[1].loops.push(vec![against(13)]);
    let form = SurfaceForm::Cylinder { frame: frame(p(0.5, 0.5, 0.0), Vector::z(), Vector::y()), radius };
    let points = [p(0.5, 0.5, 0.0), p(0.5, 0.5, 1.0)];
    faces.push(face(form, &points, true, vec![vec![against(12)], vec![along(13)]]));
    whole(vertices, edges, faces, true)
}

/// The cap at a height: the plane across z, its normal up or down, bounded by a circle edge that runs counterclockwise from above.
fn disc(height: f64, up: bool, circle: usize, radius: f64) -> Face {
    let z = if up { Vector::z() } else { -Vector::z() };
    let form = SurfaceForm::Plane { frame: frame(p(0.0, 0.0, height), z, Vector::x()) };
    let around = [p(radius, radius, height), p(-radius, -radius, height)];
    let one = if up { along(circle) } else { against(circle) };
    face(form, &around, false, vec![vec![one]])
}

/// A cylinder around z from height 0, its side with a seam edge or without.
pub(crate) fn cylinder(radius: f64, height: f64, seam: bool) -> Brep {
    let x = Curve::circle(p(0.0, 0.0, 0.0), Vector::z(), radius).unwrap().point(0.0).unwrap().coords;
    let ends = [Point::from(x), Point::from(x + Vector::z() * height)];
    let vertices = ends.iter().map(|&p| vertex(p)).collect();
    let mut edges = vec![circle(0.0, radius, 0), circle(height, radius, 1)];
    let mut loops = vec![vec![along(0)], vec![against(1)]];
    // Without a seam edge the surface's own seam is elsewhere.
    let mut toward = Vector::new(0.3, 0.8, 0.0);
    if seam {
        toward = x;
        edges.push(line(ends[0], ends[1], [0, 1]));
        loops = vec![vec![along(0), along(2), against(1), against(2)]];
    }
    let form = SurfaceForm::Cylinder { frame: frame(Point::origin(), Vector::z(), toward), radius };
    let side = face(form, &ends, false, loops);
    let faces = vec![disc(0.0, false, 0, radius), disc(height, true, 1, radius), side];
    whole(vertices, edges, faces, true)
}

/// A cone on its base at height 0.
pub(crate) fn cone(radius: f64, height: f64, seam: bool) -> Brep {
    let x = Curve::circle(p(0.0, 0.0, 0.0), Vector::z(), radius).unwrap().point(0.0).unwrap().coords;
    let tip = p(0.0, 0.0, height);
    let mut vertices = vec![vertex(Point::from(x))];
    let mut edges = vec![circle(0.0, radius, 0)];
    let mut loops = vec![vec![along(0)]];
    let mut toward = Vector::new(0.3, 0.8, 0.0);
    if seam {
        toward = x;
        vertices.push(vertex(tip));
        edges.push(line(Point::from(x), tip, [0, 1]));
        loops = vec![vec![along(0), along(1), against(1)]];
    }
    // The frame looks down, since the radius grows along it; angles run the other way round.
    let form = SurfaceForm::Cone {
        frame: frame(tip, -Vector::z(), toward),
        radius: 0.0,
        angle: (radius / height).atan(),
    };
    let side = face(form, &[Point::from(x), tip], false, loops);
    whole(vertices, edges, vec![disc(0.0, false, 0, radius), side], true)
}

/// What is above a height of the unit sphere.
pub(crate) fn sphere_cap(height: f64, seam: bool) -> Brep {
    let radius = (1.0 - height * height).sqrt();
    let start = Curve::circle(p(0.0, 0.0, height), Vector::z(), radius).unwrap().point(0.0).unwrap();
    let x = Vector::new(start.x, start.y, 0.0).normalize();
    let mut vertices = vec![vertex(start)];
    let mut edges = vec![circle(height, radius, 0)];
    let mut loops = vec![vec![along(0)]];
    let mut toward = Vector::new(0.3, 0.8, 0.0);
    if seam {
        toward = x;
        vertices.push(vertex(p(0.0, 0.0, 1.0)));
        let from = height.asin();
        let arc = Curve::elliptic_arc(Point::origin(), x, Vector::z(), from, 0.5 * PI - from).unwrap();
        edges.push(edge(arc, [0, 1]));
        loops = vec![vec![along(0), along(1), against(1)]];
    }
    let form = SurfaceForm::Sphere { frame: frame(Point::origin(), Vector::z(), toward), radius: 1.0 };
    let cap = face(form, &[], false, loops);
    whole(vertices, edges, vec![disc(height, false, 0, radius), cap], true)
}

/// A sphere without edges.
pub(crate) fn sphere(radius: f64) -> Brep {
    let form = SurfaceForm::Sphere { frame: frame(Point::origin(), Vector::z(), Vector::x()), radius };
    whole(vec![], vec![], vec![face(form, &[], false, vec![])], true)
}

/// A torus of radii 3 and 1 without what a ball around a point of it holds: its only edge is where they meet, about.
pub(crate) fn torus_window([u, v]: [f64; 2], size: f64) -> Brep {
    let form = SurfaceForm::Torus {
        frame: frame(Point::origin(), Vector::z(), Vector::x()),
        major: 3.0,
        minor: 1.0,
    };
    let surface = form.covering(&[]).unwrap();
    // A loop in the plane of parameters, run around clockwise, and fitted in space.
    let at = |t: f64| {
        let (x, y) = (u + 0.4 * size * t.cos(), v - size * t.sin());
        surface.point(x.rem_euclid(TAU), y.rem_euclid(TAU)).unwrap()
    };
    let count = 400;
    let mut points: Vec<Point> = (0..count).map(|k| at(TAU * f64::from(k) / f64::from(count))).collect();
    points.push(points[0]);
    let knots: Vec<f64> = (0..=count).map(f64::from).collect();
    let space = loftsman_kernel::spline::Space::clamped(1, &knots).unwrap();
    let first = points[0];
    let curve = Curve::new(space, points).unwrap();
    let mut one = edge(curve, [0, 0]);
    one.tolerance = 2e-4;
    let mut window = face(form, &[], false, vec![vec![along(0)]]);
    window.surface = surface;
    whole(vec![vertex(first)], vec![one], vec![window], false)
}

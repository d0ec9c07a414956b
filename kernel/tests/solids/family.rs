//! Solids that reach the rims.

use loftsman_kernel::brep::{
    Brep, CurveForm, Edge, Face, Frame, Parts, Shell, Solid, SurfaceForm, Use, Vertex,
};
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Vector};

pub(crate) fn block() -> Brep {
    Brep::block(Point::new(-1.0, 0.5, 2.0), Point::new(2.0, 2.5, 3.0)).unwrap()
}

fn used(edge: usize, reversed: bool) -> Use {
    Use { edge, reversed, parameters: None }
}

fn face(surface: loftsman_kernel::spline::Surface, form: SurfaceForm, loops: Vec<Vec<Use>>) -> Face {
    Face { name: None, color: None, surface, form, reversed: false, loops, points: Vec::new() }
}

/// A cylinder with two caps and a seam: face 0 the side, 1 the bottom, 2 the top.
pub(crate) fn cylinder(radius: f64, height: f64) -> Brep {
    let frame = Frame::new(Point::new(0.3, 0.2, -0.1), Vector::new(0.1, 0.2, 1.0), Vector::x()).unwrap();
    let at = |h: f64| frame.origin + frame.z * h + frame.x * radius;
    let circle = |h: f64| {
        let center = frame.origin + frame.z * h;
        Edge {
            curve: Curve::elliptic_arc(
                center,
                frame.x * radius,
                frame.y() * radius,
                0.0,
                std::f64::consts::TAU,
            )
            .unwrap(),
            range: (0.0, std::f64::consts::TAU),
            ends: [usize::from(h > 0.0); 2],
            tolerance: 0.0,
            form: CurveForm::Circle { frame: Frame { origin: center, ..frame }, radius },
        }
    };
    let mut circles = [circle(0.0), circle(height)];
    for circle in &mut circles {
        circle.range = circle.curve.domain();
    }
    let [low, high] = circles;
    let seam = Edge {
        curve: Curve::line(at(0.0), at(height)).unwrap(),
        range: (0.0, 1.0),
        ends: [0, 1],
        tolerance: 0.0,
        form: CurveForm::Line,
    };
    let form = SurfaceForm::Cylinder { frame, radius };
    let side = form.covering(&[at(0.0), at(height)]).unwrap();
    let cap = |h: f64, down: bool| {
        let origin = frame.origin + frame.z * h;
        let z = if down { -frame.z } else { frame.z };
        let form = SurfaceForm::Plane { frame: Frame::new(origin, z, frame.x).unwrap() };
        let rim: Vec<Point> = (0..16)
            .map(|k| {
                let (sin, cos) = (f64::from(k) * std::f64::consts::FRAC_PI_8).sin_cos();
                origin + (frame.x * cos + frame.y() * sin) * radius
            })
            .collect();
        (form.covering(&rim).unwrap(), form)
    };
    let (bottom, bottom_form) = cap(0.0, true);
    let (top, top_form) = cap(height, false);
    Brep::new(Parts {
        vertices: vec![
            Vertex { point: at(0.0), tolerance: 0.0 },
            Vertex { point: at(height), tolerance: 0.0 },
        ],
        edges: vec![low, high, seam],
        faces: vec![
            face(side, form, vec![vec![used(0, false), used(2, false), used(1, true), used(2, true)]]),
            face(bottom, bottom_form, vec![vec![used(0, true)]]),
            face(top, top_form, vec![vec![used(1, false)]]),
        ],
        shells: vec![Shell { faces: vec![0, 1, 2] }],
        solids: vec![Solid::default()],
    })
    .unwrap()
}

/// A ball of radius 2 in two faces of one surface, without an edge along its seam: beyond a plane with this normal, so far from its middle, and before it.
pub(crate) fn parted_ball(normal: Vector, height: f64) -> Brep {
    let radius = 2.0;
    let frame = Frame::new(Point::new(0.3, -1.0, 2.0), Vector::new(0.2, 0.1, 1.0), Vector::x()).unwrap();
    let along = frame.x * normal.x + frame.y() * normal.y + frame.z * normal.z;
    let wide = (radius * radius - height * height).sqrt();
    let plane =
        Frame::new(frame.origin + along.normalize() * height, along, frame.z + frame.x * 0.3).unwrap();
    let turn = std::f64::consts::TAU;
    let curve = Curve::elliptic_arc(plane.origin, plane.x * wide, plane.y() * wide, 0.0, turn).unwrap();
    let start = plane.origin + plane.x * wide;
    let form = CurveForm::Circle { frame: plane, radius: wide };
    let edge = Edge { range: curve.domain(), curve, ends: [0; 2], tolerance: 0.0, form };
    let form = SurfaceForm::Sphere { frame, radius };
    let surface = form.covering(&[]).unwrap();
    Brep::new(Parts {
        vertices: vec![Vertex { point: start, tolerance: 0.0 }],
        edges: vec![edge],
        faces: vec![
            face(surface.clone(), form, vec![vec![used(0, false)]]),
            face(surface, form, vec![vec![used(0, true)]]),
        ],
        shells: vec![Shell { faces: vec![0, 1] }],
        solids: vec![Solid::default()],
    })
    .unwrap()
}

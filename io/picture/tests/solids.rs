//! Pictures of Breps: their faces' colours, their edges, what is behind them, and what is said where there is nothing to draw.
#![allow(clippy::unwrap_used, reason = "a helper of a test may fail as the test itself")]

use loftsman_kernel::brep::{
    Brep, CurveForm, Edge, Face, Frame, Parts, Shell, Solid, SurfaceForm, Use, Vertex,
};
use loftsman_kernel::scene::{Definition, Geometry, Object, Scene};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use loftsman_picture::{Faces, Picture, View};
use loftsman_tessellation::Adaptive;
use nalgebra::Matrix4;
use roxmltree::Document;

const BY: Adaptive = Adaptive { budget: 1_000_000 };

fn block() -> Brep {
    Brep::block(Point::origin(), Point::new(3.0, 2.0, 1.0)).unwrap()
}

fn ball(radius: f64) -> Brep {
    let frame = Frame::new(Point::origin(), Vector::z(), Vector::x()).unwrap();
    let form = SurfaceForm::Sphere { frame, radius };
    let face = Face {
        name: None,
        color: None,
        surface: form.covering(&[]).unwrap(),
        form,
        reversed: false,
        loops: vec![],
        points: vec![],
    };
    let (shells, solids) = (vec![Shell { faces: vec![0] }], vec![Solid::default()]);
    Brep::new(Parts { faces: vec![face], shells, solids, ..Parts::default() }).unwrap()
}

fn one(geometry: impl Into<Geometry>) -> Scene {
    let mut scene = Scene::new();
    scene.add(Object::new("part", geometry.into())).unwrap();
    scene
}

fn svg(scene: &Scene, view: View) -> String {
    Picture::of(scene).tessellator(&BY).view(view).to_svg().unwrap()
}

/// The segments of the paths of a class.
fn segments(svg: &str, class: &str) -> Vec<[[f64; 2]; 2]> {
    let document = Document::parse(svg).unwrap();
    let mut found = Vec::new();
    for path in document.descendants().filter(|node| node.attribute("class") == Some(class)) {
        let spaced =
            path.attribute("d").unwrap().replace(['M', 'L'], " ").replace('H', " H").replace('V', " V");
        let raw = path.attribute("d").unwrap();
        assert!(!spaced.is_empty());
        let (mut pen, mut start) = ([0.0; 2], [0.0; 2]);
        let mut rest = raw;
        while let Some(command) = rest.chars().next() {
            let end = rest[1..].find(|c: char| c.is_ascii_alphabetic()).map_or(rest.len(), |at| at + 1);
            let text = rest[1..end].replace('-', " -");
            let numbers: Vec<f64> =
                text.split([' ', ',']).filter(|n| !n.is_empty()).map(|n| n.parse().unwrap()).collect();
            let mut to = |spot: [f64; 2], draws: bool| {
                if draws {
                    found.push([pen, spot]);
                }
                pen = spot;
            };
            match command {
                'M' | 'L' => {
                    for (k, pair) in numbers.chunks(2).enumerate() {
                        to([pair[0], pair[1]], command == 'L' || k > 0);
                        if command == 'M' && k == 0 {
                            start = [pair[0], pair[1]];
                        }
                    }
                }
                'Z' => to(start, true),
                other => unreachable!("{other} in {raw}"),
            }
            rest = &rest[end..];
        }
    }
    found
}

fn length(segments: &[[[f64; 2]; 2]]) -> f64 {
    segments.iter().map(|[a, b]| (a[0] - b[0]).hypot(a[1] - b[1])).sum()
}

/// From a corner nine edges of a block are seen, three are behind it.
#[test]
fn edges_behind_faces_are_not_drawn() {
    let seen = svg(&one(block()), View::From(Vector::new(1.0, -1.0, 1.0)));
    let lines = segments(&seen, "outline");
    // 3, 2 and 1 long, three of each seen, in the projection along the diagonal: each is as long as its square root of 2/3.
    let mut all = one(block());
    let wire = loftsman_kernel::mesh::Polyline {
        points: vec![Point::new(0.0, 0.0, 1.0), Point::new(3.0, 0.0, 1.0)],
        closed: false,
    };
    all.add(Object::new("wire", wire.into())).unwrap();
    let scale = length(&segments(&svg(&all, View::From(Vector::new(1.0, -1.0, 1.0))), "polyline")) / 3.0;
    let expected = 3.0 * (3.0 + 2.0 + 1.0) * scale;
    assert!((length(&lines) / expected - 1.0).abs() < 0.02, "{} {expected}", length(&lines));
    assert!(segments(&seen, "inner").is_empty() && segments(&seen, "border").is_empty());
}

/// A ball has no edges: its outline is a circle.
#[test]
fn a_smooth_face_has_an_outline() {
    for radius in [1e-6, 1.0, 1e6] {
        let lines = segments(&svg(&one(ball(radius)), View::Top), "outline");
        let points: Vec<[f64; 2]> = lines.iter().flatten().copied().collect();
        let middle = [0, 1].map(|k| {
            let all = points.iter().map(|p| p[k]);
            0.5 * (all.clone().fold(f64::INFINITY, f64::min) + all.fold(f64::NEG_INFINITY, f64::max))
        });
        let radii: Vec<f64> = points.iter().map(|p| (p[0] - middle[0]).hypot(p[1] - middle[1])).collect();
        let (low, high) = radii.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), r| (l.min(*r), h.max(*r)));
        assert!(high > 10.0 && high - low < 0.004 * high, "{low} {high}");
        assert!((length(&lines) / (std::f64::consts::TAU * high) - 1.0).abs() < 0.02);
    }
}

/// A rod of radius 1 along x from `start` to 10, with both its ends.
fn rod(start: f64) -> Brep {
    let frame = Frame::new(Point::new(start, 0.0, 0.0), Vector::x(), Vector::y()).unwrap();
    let at = |x: f64| Point::new(x, 1.0, 0.0);
    let used = |edge: usize, reversed: bool| Use { edge, reversed, parameters: None };
    let rim = |x: f64, end: usize| {
        let frame = Frame { origin: Point::new(x, 0.0, 0.0), ..frame };
        let curve =
            Curve::elliptic_arc(frame.origin, frame.x, frame.y(), 0.0, std::f64::consts::TAU).unwrap();
        let range = curve.domain();
        Edge { curve, range, ends: [end; 2], tolerance: 0.0, form: CurveForm::Circle { frame, radius: 1.0 } }
    };
    let seam = Curve::line(at(start), at(10.0)).unwrap();
    let face = |form: SurfaceForm, reach: &[Point], bound: Vec<Use>| Face {
        name: None,
        color: None,
        surface: form.covering(reach).unwrap(),
        form,
        reversed: false,
        loops: vec![bound],
        points: vec![],
    };
    let cap = |x: f64, normal: Vector, bound: Use| {
        let frame = Frame::new(Point::new(x, 0.0, 0.0), normal, Vector::y()).unwrap();
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        face(SurfaceForm::Plane { frame }, &corners.map(|[y, z]| Point::new(x, y, z)), vec![bound])
    };
    let side = vec![used(0, false), used(2, false), used(1, true), used(2, true)];
    Brep::new(Parts {
        vertices: [start, 10.0].map(|x| Vertex { point: at(x), tolerance: 0.0 }).to_vec(),
        edges: vec![
            rim(start, 0),
            rim(10.0, 1),
            Edge { curve: seam, range: (0.0, 1.0), ends: [0, 1], tolerance: 0.0, form: CurveForm::Line },
        ],
        faces: vec![
            face(SurfaceForm::Cylinder { frame, radius: 1.0 }, &[at(start), at(10.0)], side),
            cap(start, -Vector::x(), used(0, true)),
            cap(10.0, Vector::x(), used(1, false)),
        ],
        shells: vec![Shell { faces: vec![0, 1, 2] }],
        solids: vec![Solid::default()],
    })
    .unwrap()
}

/// Where a rod goes into a wall its outline ends, though its facets are as long as itself: of a long rod no more is seen than of one that ends
/// just behind the wall's face.
#[test]
fn outlines_of_long_facets_end_where_they_go_in() {
    for towards in [[1.0, -1.0, 1.0], [2.0, 1.0, 0.5], [0.3, 0.1, 1.0]] {
        let seen = |start: f64| {
            let mut scene = one(rod(start));
            let wall = Brep::block(Point::new(-12.0, -6.0, -6.0), Point::new(0.0, 6.0, 6.0)).unwrap();
            scene.add(Object::new("wall", wall.into())).unwrap();
            length(&segments(&svg(&scene, View::From(Vector::from(towards))), "outline"))
        };
        let (long, short) = (seen(-10.0), seen(-0.05));
        // Four ends, each to within what a facet rises across, a millimetre.
        assert!(short > 300.0 && (long - short).abs() < 2.0, "{towards:?}: {long} {short}");
    }
}

#[test]
fn faces_have_their_colours_and_the_same_picture_the_same_bytes() {
    let mut parts = block().parts();
    parts.faces[1].color = Some([1.0, 0.0, 0.0, 1.0]);
    let scene = one(Brep::new(parts).unwrap());
    let plain = Picture::of(&one(block())).tessellator(&BY).view(View::Top).to_png(300).unwrap();
    let painted = Picture::of(&scene).tessellator(&BY).view(View::Top).to_png(300).unwrap();
    assert_eq!(painted, Picture::of(&scene).tessellator(&BY).view(View::Top).to_png(300).unwrap());
    let middle = |png: &[u8]| {
        let image = tiny_skia::Pixmap::decode_png(png).unwrap();
        let pixel = image.pixel(image.width() / 2, image.height() / 3).unwrap();
        (pixel.red(), pixel.green(), pixel.blue())
    };
    let ((red, green, blue), (r, _, b)) = (middle(&painted), middle(&plain));
    assert!(red > green && red > blue && b > r, "{:?} {:?}", middle(&painted), middle(&plain));
    for faces in [Faces::Zebra, Faces::Deviation] {
        assert!(Picture::of(&scene).tessellator(&BY).faces(faces).to_svg().is_ok());
    }
}

#[test]
fn what_is_not_drawn_is_said() {
    let svg = Picture::of(&one(block())).to_svg().unwrap();
    assert!(
        svg.contains("part: not drawn, it needs a tessellator") && !svg.contains("class=\"outline\""),
        "{svg}"
    );
    let mut parts = block().parts();
    let line = || Space::clamped(1, &[0.0, 1.0]).unwrap();
    let speck = Face {
        name: Some("speck".into()),
        color: None,
        surface: Surface::new(line(), line(), vec![Point::new(1.0, 1.0, 1.0); 4]).unwrap(),
        form: SurfaceForm::Spline,
        reversed: false,
        loops: vec![],
        points: vec![],
    };
    parts.faces.push(speck);
    let svg = Picture::of(&one(Brep::new(parts).unwrap())).tessellator(&BY).to_svg().unwrap();
    assert!(svg.contains("1 of 7 faces could not be cut") && svg.contains("class=\"outline\""), "{svg}");
    let empty = Picture::of(&one(Brep::new(Parts::default()).unwrap())).tessellator(&BY).to_svg().unwrap();
    assert!(empty.contains("part: not drawn"), "{empty}");
}

#[test]
fn instances_and_the_state_before_are_drawn() {
    let mut bolt = Definition::new("bolt");
    bolt.add(Object::new("body", block().into())).unwrap();
    let mut scene = Scene::new();
    scene.define(bolt).unwrap();
    for k in 0..40 {
        let mut place = Object::new(format!("{k}"), Geometry::Instance("bolt".into()));
        place.transform = Some(Matrix4::new_translation(&Vector::new(4.0 * f64::from(k), 0.0, 0.0)));
        scene.add(place).unwrap();
    }
    let lines = segments(&svg(&scene, View::Top), "outline");
    let single = segments(&svg(&one(block()), View::Top), "outline");
    // Both fill the page's width: forty blocks in 159 units, one in 3.
    let expected = 40.0 * length(&single) * 3.0 / 159.0;
    assert!((length(&lines) / expected - 1.0).abs() < 0.02, "{} {expected}", length(&lines));
    let mut moved = one(block());
    moved.object_mut("part").unwrap().transform = Some(Matrix4::new_translation(&Vector::new(0.5, 0.5, 0.0)));
    let svg = Picture::of(&moved).before(&one(block())).tessellator(&BY).view(View::Top).to_svg().unwrap();
    assert!(!segments(&svg, "solid").is_empty());
    let same = Picture::of(&moved).before(&moved).tessellator(&BY).view(View::Top).to_svg().unwrap();
    assert!(segments(&same, "solid").is_empty());
}

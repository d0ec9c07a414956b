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

/// A face over a square of parameters whose surface has a corner of so many degrees along a knot line or two, of this degree along `u` and
/// this multiplicity; its loop is a smaller square.
fn bent(degree: usize, multiplicity: usize, degrees: f64, across: bool) -> Brep {
    let angle = degrees.to_radians();
    // From side to side the points lie on two lines that meet at the corner, evenly, so that but for the turn all derivatives go on.
    let knots = |p: usize| {
        let mut knots = vec![0.0; p + 1];
        knots.extend(vec![1.0; multiplicity]);
        knots.extend(vec![2.0; p + 1]);
        knots
    };
    let bends = Space::open(degree, knots(degree)).unwrap();
    let straight = Space::clamped(1, &[0.0, 2.0]).unwrap();
    let at =
        |x: f64| if x <= 1.0 { [x, 0.0] } else { [1.0 + (x - 1.0) * angle.cos(), (x - 1.0) * angle.sin()] };
    let line: Vec<[f64; 2]> = (0..bends.len()).map(|i| at(bends.greville(i))).collect();
    let row = |y: f64| line.iter().map(move |[x, z]| Point::new(*x, y, *z));
    let points: Vec<Point> = if across {
        line.iter().flat_map(|[x, z]| [0.0, 2.0].map(|y| Point::new(*x, y, *z))).collect()
    } else {
        row(0.0).chain(row(2.0)).collect()
    };
    let [u, v] = if across { [bends, straight] } else { [straight, bends] };
    let surface = Surface::new(u, v, points).unwrap();
    // A square of parameters a half to one and a half, as lines on the surface: where they meet the corner they have one, too.
    let place = |t: [f64; 2]| {
        let [u, v] = if across { t } else { [t[1], t[0]] };
        surface.point(u, v).unwrap()
    };
    let corners = [[0.5, 0.5], [1.5, 0.5], [1.5, 1.5], [0.5, 1.5]];
    let edge = |k: usize| {
        let [from, to] = [corners[k], corners[(k + 1) % 4]];
        let middle = [0, 1].map(|d| 0.5 * (from[d] + to[d]));
        let curve =
            Curve::new(Space::clamped(1, &[0.0, 0.5, 1.0]).unwrap(), [from, middle, to].map(place).to_vec());
        let ends = [k, (k + 1) % 4];
        Edge { curve: curve.unwrap(), range: (0.0, 1.0), ends, tolerance: 1e-9, form: CurveForm::Spline }
    };
    let used = |edge: usize| Use { edge, reversed: false, parameters: None };
    let face = Face {
        name: None,
        color: None,
        form: SurfaceForm::Spline,
        surface: surface.clone(),
        reversed: false,
        loops: vec![(0..4).map(used).collect()],
        points: vec![],
    };
    let vertices = corners.map(|at| Vertex { point: place(at), tolerance: 1e-9 }).to_vec();
    let shells = vec![Shell { faces: vec![0] }];
    Brep::new(Parts {
        vertices,
        edges: (0..4).map(edge).collect(),
        faces: vec![face],
        shells,
        solids: vec![],
    })
    .unwrap()
}

/// A crease inside a face is drawn as edges are, as long as the loop leaves it, and hidden where something is before it; one of a few degrees as
/// faces are that go on into one another; what only looks like one by its knots is not.
#[test]
fn creases_inside_faces_are_drawn() {
    let edge = |brep: Brep, view: View| {
        let picture = svg(&one(brep), view);
        // The loop goes round a square of side 1, seen from above: a border.
        let side = |class: &str| length(&segments(&picture, class));
        [side("outline"), side("inner"), side("border")]
    };
    for degree in [1, 2, 3, 7, 25] {
        for (across, degrees) in [(true, 40.0), (false, 40.0), (true, -90.0_f64)] {
            let [outline, inner, border] = edge(bent(degree, degree, degrees, across), View::Top);
            let wide = 1.0 + 2.0 * (0.5 + 0.5 * degrees.to_radians().cos()) / 2.0;
            let expected = border / (2.0 * wide);
            if degrees > 0.0 {
                assert!(
                    (outline / expected - 1.0).abs() < 0.02,
                    "{degree} {across} {degrees}: {outline} {expected}"
                );
            } else {
                assert!(outline > 0.0, "{degree} {across} {degrees}");
            }
            assert_eq!(inner, 0.0, "{degree} {across} {degrees}");
        }
        let [outline, inner, border] = edge(bent(degree, degree, 4.0, true), View::Top);
        assert!(outline == 0.0 && (inner / (border / 4.0) - 1.0).abs() < 0.02, "{degree}: {inner} {border}");
        for degrees in [0.0, 0.5] {
            let [outline, inner, _] = edge(bent(degree, degree, degrees, true), View::Top);
            assert_eq!([outline, inner], [0.0; 2], "{degree} {degrees}");
        }
    }
    // Under a block nothing is seen of it.
    let beside = |degrees: f64, height: f64| {
        let mut scene = one(bent(3, 3, degrees, true));
        let block = Brep::block(Point::new(0.0, 0.0, height), Point::new(3.0, 2.0, height + 1.0)).unwrap();
        scene.add(Object::new("block", block.into())).unwrap();
        length(&segments(&svg(&scene, View::Top), "outline"))
    };
    let [flat, below, above] = [beside(0.0, 2.0), beside(40.0, 2.0), beside(40.0, -3.0)];
    assert!((below / flat - 1.0).abs() < 1e-3 && above > 1.04 * flat, "{flat} {below} {above}");
}

/// A tube along z round a drop, which closes with a corner of so many degrees, or smoothly, at its seam.
fn drop(degree: usize, sharp: bool) -> Brep {
    let space = Space::clamped(degree, &[0.0, 1.0, 2.0, 3.0]).unwrap();
    let count = space.len();
    let round = |i: usize| {
        let t = space.greville(i) / 3.0 * std::f64::consts::TAU;
        let pull = if sharp { (0.5 * t).sin() } else { 1.0 };
        [1.0 - t.cos(), pull * t.sin()]
    };
    let mut line: Vec<[f64; 2]> = (0..count).map(round).collect();
    line[count - 1] = line[0];
    if !sharp {
        // One direction on both sides, at one speed.
        line[1] = [line[0][0], line[0][1] + 0.5];
        line[count - 2] = [line[0][0], line[0][1] - 0.5];
    }
    let row = |z: f64| line.iter().map(|[x, y]| Point::new(*x, *y, z)).collect::<Vec<_>>();
    let surface =
        Surface::new(Space::clamped(1, &[0.0, 1.0]).unwrap(), space.clone(), [row(0.0), row(1.0)].concat())
            .unwrap();
    let rim = |z: f64, end: usize| Edge {
        curve: Curve::new(space.clone(), row(z)).unwrap(),
        range: (0.0, 3.0),
        ends: [end; 2],
        tolerance: 1e-9,
        form: CurveForm::Spline,
    };
    let at = |z: f64| Point::new(line[0][0], line[0][1], z);
    let seam = Edge {
        curve: Curve::line(at(0.0), at(1.0)).unwrap(),
        range: (0.0, 1.0),
        ends: [0, 1],
        tolerance: 1e-9,
        form: CurveForm::Line,
    };
    let used = |edge: usize, reversed: bool| Use { edge, reversed, parameters: None };
    let face = Face {
        name: None,
        color: None,
        form: SurfaceForm::Spline,
        surface,
        reversed: true,
        loops: vec![vec![used(0, false), used(2, false), used(1, true), used(2, true)]],
        points: vec![],
    };
    Brep::new(Parts {
        vertices: [0.0, 1.0].map(|z| Vertex { point: at(z), tolerance: 1e-9 }).to_vec(),
        edges: vec![rim(0.0, 0), rim(1.0, 1), seam],
        faces: vec![face],
        shells: vec![Shell { faces: vec![0] }],
        solids: vec![],
    })
    .unwrap()
}

/// Where a face closes with a corner there is a line to see, and where it goes on smoothly there is none.
#[test]
fn seams_are_drawn_where_they_have_a_corner() {
    for degree in [2, 3, 7] {
        // From the side of the seam, where the tube is widest elsewhere.
        let lines = |sharp: bool| {
            let picture = svg(&one(drop(degree, sharp)), View::From(Vector::new(-1.0, 0.1, 0.0)));
            length(&segments(&picture, "outline"))
        };
        let [smooth, sharp] = [lines(false), lines(true)];
        // Two outlines of the same height, and the seam.
        assert!(sharp > 1.3 * smooth, "{degree}: {smooth} {sharp}");
    }
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
    // One that was shorter shows the end that it had, 2 long where all of it is 4 wide, and not its other edges over those that are there.
    let longer = one(Brep::block(Point::origin(), Point::new(4.0, 2.0, 1.0)).unwrap());
    let svg = Picture::of(&longer).before(&one(block())).tessellator(&BY).view(View::Top).to_svg().unwrap();
    let outline = segments(&svg, "outline");
    let across = outline.iter().flatten().map(|[x, _]| *x);
    let wide = across.clone().fold(f64::NEG_INFINITY, f64::max) - across.fold(f64::INFINITY, f64::min);
    let old = length(&segments(&svg, "solid"));
    assert!((old / (0.5 * wide) - 1.0).abs() < 0.03, "{old} {wide}");
}

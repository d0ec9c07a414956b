//! Whole pictures: they parse, show what they should where it should be, and have the same bytes every time.
#![allow(clippy::unwrap_used, reason = "a helper of a test may fail as the test itself")]

use crate::drawn::Drawn;
use loftsman_kernel::mesh::{Cloud, Mesh, Polyline};
use loftsman_kernel::plugin::{Mark, MarkKind};
use loftsman_kernel::scene::{Animation, Geometry, Object, Scene, Unit, Up};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use loftsman_picture::{Against, Beads, Combs, Frames, Panel, Picture, PictureError, Theme, View};
use proptest::prelude::*;
use roxmltree::Document;

fn scene(objects: impl IntoIterator<Item = (&'static str, Geometry)>) -> Scene {
    let mut scene = Scene::new();
    for (name, geometry) in objects {
        scene.add(Object::new(name, geometry)).unwrap();
    }
    scene
}

fn points(list: &[[f64; 2]], scale: f64) -> Vec<Point> {
    list.iter().map(|[x, y]| Point::new(x * scale, y * scale, 0.0)).collect()
}

/// Twelve vertices, uniform clamped cubic.
fn cubic(scale: f64) -> Curve {
    let heights = [0.0, 1.0, 0.5, -0.5, 0.8, 1.2, 0.2, -0.6, 0.0, 1.0, 0.7, 0.0];
    let net: Vec<[f64; 2]> = heights.iter().enumerate().map(|(i, h)| [i as f64, *h]).collect();
    Curve::new(Space::clamped_uniform(3, 12).unwrap(), points(&net, scale)).unwrap()
}

fn mark(kind: MarkKind, before: Point, position: Point, vector: Option<Vector>) -> Mark {
    Mark {
        object: "c".into(),
        kind,
        position,
        before,
        vector,
        label: "position at 0.25".into(),
        spot: None,
        track: None,
    }
}

/// Parses the document, and gives the elements.
fn elements(svg: &str) -> Vec<(String, Vec<(String, String)>)> {
    Document::parse(svg)
        .unwrap()
        .descendants()
        .filter(|node| node.is_element())
        .map(|node| {
            let attributes = node.attributes().map(|a| (a.name().to_owned(), a.value().to_owned()));
            (node.tag_name().name().to_owned(), attributes.collect())
        })
        .collect()
}

/// An attribute of the elements of a class.
fn of_class(svg: &str, class: &str, attribute: &str) -> Vec<String> {
    elements(svg)
        .into_iter()
        .map(|(_, attributes)| attributes)
        .filter(|list| list.iter().any(|(name, value)| name == "class" && value == class))
        .filter_map(|list| list.into_iter().find(|(name, _)| name == attribute))
        .map(|(_, value)| value)
        .collect()
}

fn numbers(data: &str) -> Vec<f64> {
    let separated: String = data.chars().map(|c| if c.is_ascii_alphabetic() { ' ' } else { c }).collect();
    separated.split_whitespace().map(|n| n.parse().unwrap()).collect()
}

#[test]
fn a_cubic_is_nine_exact_segments_with_twelve_squares_and_ten_knots() {
    let scene = scene([("c", cubic(1.0).into())]);
    let svg = Picture::of(&scene).beads(Beads::Knots).drawn();
    let [curve] = &of_class(&svg, "curve", "d")[..] else { panic!("one curve") };
    assert_eq!((curve.matches('M').count(), curve.matches('C').count()), (1, 9));
    let [squares] = &of_class(&svg, "control-vertices", "d")[..] else { panic!("one net") };
    assert_eq!(squares.matches('z').count(), 12);
    let [beads] = &of_class(&svg, "beads", "d")[..] else { panic!("beads") };
    assert_eq!(beads.matches('M').count(), 10);
    // The map from scene to page is a similarity with y turned over: ends and a knot fit one scale.
    let d = numbers(curve);
    let (start, end) = ([d[0], d[1]], [d[d.len() - 2], d[d.len() - 1]]);
    let scale = (end[0] - start[0]) / 11.0;
    assert!((start[1] - end[1]).abs() < 2e-3);
    let knot = cubic(1.0).point(1.0).unwrap();
    let page = [start[0] + scale * knot.x, start[1] - scale * knot.y];
    assert!((d[6] - page[0]).abs() < 2e-3 && (d[7] - page[1]).abs() < 2e-3, "{d:?} {page:?}");
}

#[test]
fn marks_are_where_they_should_be() {
    let mut child = Object::new("c", cubic(1.0).into());
    let shift = nalgebra::Matrix4::new_translation(&Vector::new(100.0, 0.0, 0.0));
    child.transform = Some(shift);
    let mut scene = Scene::new();
    scene.add(child).unwrap();
    let (old, new) = (cubic(1.0).point(0.0).unwrap(), cubic(1.0).point(9.0).unwrap());
    let marks = [mark(MarkKind::Moved, old, new, None)];
    let svg = Picture::of(&scene).marks(&marks).drawn();
    // From the curve's start to its end, in the page's coordinates, though the object is moved.
    let curve = numbers(&of_class(&svg, "curve", "d")[0]);
    let arrow = numbers(&of_class(&svg, "arrow", "d")[0]);
    assert!((arrow[0] - curve[0]).abs() < 2e-3 && (arrow[1] - curve[1]).abs() < 2e-3);
    let circle = elements(&svg).into_iter().find(|(name, _)| name == "circle").unwrap();
    let value = |name: &str| -> f64 { circle.1.iter().find(|a| a.0 == name).unwrap().1.parse().unwrap() };
    assert!((value("cx") - curve[curve.len() - 2]).abs() < 2e-3);
    assert!((value("cy") - curve[curve.len() - 1]).abs() < 2e-3);
}

#[test]
fn the_osculating_circle_of_a_circle_is_itself() {
    let w = 0.5_f64.sqrt();
    let net = points(&[[2.0, 0.0], [2.0, 2.0], [0.0, 2.0]], 1.0);
    let arc = Curve::rational(Space::clamped(2, &[0.0, 1.0]).unwrap(), net, vec![1.0, w, 1.0]).unwrap();
    let at = arc.point(0.5).unwrap();
    let curvature = -at.coords.normalize() / 2.0;
    let marks = [mark(MarkKind::Curvature, at, at, Some(curvature))];
    let scene = scene([("c", (&arc).into())]);
    let svg = Picture::of(&scene).marks(&marks).control_polygons(false).drawn();
    let curve = numbers(&of_class(&svg, "curve", "d")[0]);
    // (2, 0) and (0, 2) give the page's scale and the centre.
    let (start, end) = ([curve[0], curve[1]], [curve[curve.len() - 2], curve[curve.len() - 1]]);
    let (centre, radius) = ([end[0], start[1]], start[0] - end[0]);
    let circle = numbers(&of_class(&svg, "osculating", "d")[0]);
    assert!(circle.len() > 20);
    for spot in circle.chunks(2) {
        let distance = (spot[0] - centre[0]).hypot(spot[1] - centre[1]);
        assert!((distance - radius).abs() < 0.01, "{distance} {radius}");
    }
}

#[test]
fn the_size_of_a_scene_changes_its_scale_bar_and_nothing_else() {
    let drawing = |scale: f64| {
        let scene = scene([("c", cubic(scale).into())]);
        let before = self::scene([(
            "c",
            Curve::bezier(points(&[[0.0, 0.0], [5.0, 3.0], [11.0, 0.0]], scale)).unwrap().into(),
        )]);
        let marks = [mark(MarkKind::Moved, Point::origin(), Point::new(5.0 * scale, scale, 0.0), None)];
        let picture = Picture::of(&scene).before(&before).marks(&marks).combs(Combs::Automatic);
        let svg = picture.drawn();
        svg.split("id=\"legend\"").next().unwrap().to_owned()
    };
    let expected = drawing(1.0);
    for scale in [2_f64.powi(-30), 2_f64.powi(30), 2_f64.powi(-900), 2_f64.powi(900)] {
        assert_eq!(drawing(scale), expected, "{scale}");
    }
    for scale in [1e-9, 1e9, 1e-300, 1e300] {
        assert_eq!(drawing(scale).len(), expected.len(), "{scale}");
    }
}

#[test]
fn what_has_not_changed_is_not_drawn_twice() {
    let now = scene([("c", cubic(1.0).into()), ("d", cubic(2.0).into())]);
    let then = scene([("c", cubic(1.5).into()), ("d", cubic(2.0).into())]);
    let svg = Picture::of(&now).before(&then).drawn();
    assert_eq!(of_class(&svg, "curve", "d").len(), 3);
    assert!(svg.contains("c, before") && !svg.contains("d, before"));
    // The same scene in another unit is the same scene.
    let converted = now.converted(Unit::Millimetre, Up::Z).unwrap();
    let svg = Picture::of(&now).before(&converted).drawn();
    assert_eq!(of_class(&svg, "curve", "d").len(), 2);
}

#[test]
fn degenerate_scenes_have_pictures() {
    let line = Curve::bezier(points(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [3.0, 3.0]], 1.0)).unwrap();
    let spot = Curve::bezier(vec![Point::new(1e9, 1.0, 1.0); 4]).unwrap();
    let (u, v) = (Space::clamped_uniform(1, 2).unwrap(), Space::clamped_uniform(1, 2).unwrap());
    let flat = Surface::new(u, v, vec![Point::origin(); 4]).unwrap();
    let sliver = Mesh::new(points(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], 1.0), &[[0, 1, 2]]).unwrap();
    let huge = Polyline { points: points(&[[-1.0, -1.0], [1.0, 1.0]], f64::MAX), closed: true };
    let tiny = Polyline { points: points(&[[0.0, 0.0], [1.0, 1.0]], f64::from_bits(1)), closed: false };
    let scenes = [
        scene([]),
        scene([("group", Geometry::Group)]),
        scene([("line", line.into())]),
        scene([("spot", spot.into())]),
        scene([("flat", flat.into())]),
        scene([("sliver", sliver.into())]),
        scene([("huge", huge.into())]),
        scene([("tiny", tiny.into())]),
        scene([("nothing", Cloud::default().into())]),
        scene([("one", Cloud { points: vec![Point::new(3.0, 4.0, 5.0)] }.into())]),
        scene([("none", Polyline { points: vec![], closed: true }.into())]),
    ];
    for scene in &scenes {
        let oblique = [View::Isometric, View::Perspective];
        for view in [View::Automatic, View::Front, View::Top, View::Right].into_iter().chain(oblique) {
            let picture = Picture::of(scene).view(view).combs(Combs::Automatic).beads(Beads::Uniform(3));
            let svg = picture.before(&scenes[2]).drawn();
            elements(&svg);
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        }
    }
}

#[test]
fn panels_have_one_scale_and_ids_of_their_own() {
    let scene = scene([("c", cubic(1.0).into()), ("d", cubic(2.0).into())]);
    let panels = [
        Panel::view(View::Top).objects(["c"]).caption("(a) <one>"),
        Panel::view(View::Top).objects(["d"]),
        Panel::view(View::Perspective),
        Panel::profile(Against::Parameter).caption("curvature"),
    ];
    let svg = Picture::of(&scene).combs(Combs::Automatic).panels(panels).drawn();
    let all = elements(&svg);
    let mut ids: Vec<&String> =
        all.iter().flat_map(|(_, list)| list).filter(|a| a.0 == "id").map(|a| &a.1).collect();
    let count = ids.len();
    ids.sort();
    ids.dedup();
    assert!(ids.len() == count && ids.iter().any(|id| *id == "curves-4"), "{ids:?}");
    // The second curve is twice the first, on the page too.
    let curves = of_class(&svg, "curve", "d");
    assert_eq!(curves.len(), 4);
    let wide = |data: &str| {
        let d = numbers(data);
        d[d.len() - 2] - d[0]
    };
    assert!((wide(&curves[1]) / wide(&curves[0]) - 2.0).abs() < 1e-3);
    assert!(svg.contains("(a) &lt;one&gt;") && svg.contains(">parameter u<"));
    assert_eq!(of_class(&svg, "profile", "d").len(), 2);
}

/// A group that a panel names is all that hangs under it, at any depth.
#[test]
fn a_group_is_what_hangs_under_it() {
    let mut scene = scene([
        ("all", Geometry::Group),
        ("some", Geometry::Group),
        ("c", cubic(1.0).into()),
        ("d", cubic(2.0).into()),
        ("e", cubic(3.0).into()),
    ]);
    for (name, parent) in [("some", "all"), ("c", "all"), ("d", "some")] {
        scene.object_mut(name).unwrap().parent = Some(parent.into());
    }
    let drawn = |names: &[&str]| {
        let panel = Panel::view(View::Top).objects(names.iter().copied());
        of_class(&Picture::of(&scene).panels([panel]).drawn(), "curve", "d").len()
    };
    assert_eq!([drawn(&["all"]), drawn(&["some"]), drawn(&["e"]), drawn(&["some", "d"])], [2, 1, 1, 1]);
}

#[test]
fn the_profile_of_a_circle_is_flat_and_as_long_as_the_circle() {
    let w = 0.5_f64.sqrt();
    let net = points(&[[2.0, 0.0], [2.0, 2.0], [0.0, 2.0]], 1.0);
    let arc = Curve::rational(Space::clamped(2, &[0.0, 1.0]).unwrap(), net, vec![1.0, w, 1.0]).unwrap();
    let scene = scene([("arc", (&arc).into())]);
    let svg = Picture::of(&scene).panels([Panel::profile(Against::ArcLength)]).drawn();
    let [profile] = &of_class(&svg, "profile", "d")[..] else { panic!("one profile") };
    let d = numbers(profile);
    assert!(d.chunks(2).all(|p| (p[1] - d[1]).abs() < 1e-3), "{d:?}");
    // Curvature 1/2, to the left; ticks give the scale: the axis ends at the length π.
    assert!(svg.contains("signed curvature (1/m)") && svg.contains(">3<") && !svg.contains(">4<"));
    let texts = |words: &str| {
        let at = svg.find(&format!(">{words}<")).unwrap();
        let x = svg[..at].rfind(" x=\"").unwrap() + 4;
        svg[x..].split('"').next().unwrap().parse::<f64>().unwrap()
    };
    let unit = texts("3") - texts("2");
    assert!(((d[d.len() - 2] - d[0]) / unit - std::f64::consts::PI).abs() < 1e-3);
}

#[test]
fn frames_of_a_drag_are_dashed_and_the_last_is_the_curve() {
    let mut object = Object::new("c", cubic(1.0).into());
    let lifted =
        |by: f64| object.geometry().points().iter().map(|p| p + Vector::y() * by).collect::<Vec<_>>();
    let frames = vec![lifted(2.0), lifted(1.0), lifted(0.0)];
    object.animation = Some(Animation { rate: 24.0, frames });
    let mut scene = Scene::new();
    scene.add(object).unwrap();
    let svg = Picture::of(&scene).frames(true).drawn();
    assert_eq!(of_class(&svg, "frame", "stroke-dasharray").len(), 2);
    assert!(svg.contains(">frame 2<") && !svg.contains(">frame 3<"));
    assert!(of_class(&Picture::of(&scene).drawn(), "frame", "d").is_empty());
}

/// A line of a mesh below its face is seen from above but for where the face is, in the mesh's colour, and the legend shows both; a mesh of
/// lines alone is shown by a line.
#[test]
fn the_lines_of_a_mesh_are_drawn_as_far_as_no_face_hides_them() {
    let square = points(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], 1.0);
    let wire = [-1.0, 0.5, 2.0].map(|x| Point::new(x, 0.5, -1.0));
    let at: Vec<Point> = square.iter().chain(&wire).copied().collect();
    let mut both = Mesh::new(at.clone(), &[[0, 1, 2, 3]]).unwrap();
    both.set_lines(vec![4, 5, 5, 6], vec![0, 2, 4]).unwrap();
    let mut lines = Mesh::new(at, &[[0; 3]; 0]).unwrap();
    lines.set_lines(vec![4, 5, 6], vec![0, 3]).unwrap();
    let drawn = |mesh: &Mesh| {
        let scene = scene([("m", mesh.clone().into())]);
        Picture::of(&scene).view(View::Top).drawn()
    };
    // How far the parts of a path reach from left to right, together.
    let length = |svg: &str, class: &str| -> f64 {
        let data = of_class(svg, class, "d").concat();
        let pieces = chains(&data);
        pieces.iter().map(|p| p.iter().map(|q| q[0]).fold(0.0, f64::max) - p[0][0]).sum()
    };
    let svg = drawn(&both);
    let (seen, hidden) = (length(&svg, "line"), length(&svg, "hidden"));
    assert!((hidden / (seen + hidden) - 1.0 / 3.0).abs() < 0.01, "{seen} {hidden}");
    let alone = drawn(&lines);
    assert!(length(&alone, "line") > 50.0 && length(&alone, "hidden") == 0.0, "{alone}");
    let entries = |svg: &str| {
        let document = Document::parse(svg).unwrap();
        let legend = document.descendants().find(|n| n.attribute("id") == Some("legend")).unwrap();
        let faces = legend.descendants().filter(|n| n.has_tag_name("rect")).count();
        let sample = |n: &roxmltree::Node<'_, '_>| n.attribute("class") == Some("sample");
        let strokes = legend.descendants().filter(sample).filter_map(|n| n.attribute("stroke"));
        (faces, strokes.map(str::to_owned).collect::<Vec<_>>())
    };
    let color = of_class(&svg, "line", "stroke");
    let (faces, strokes) = entries(&svg);
    assert_eq!((faces, strokes.len()), (1, 2), "the face, its line and what is hidden");
    assert!(strokes.contains(&color[0]));
    assert_eq!(entries(&alone), (0, of_class(&alone, "line", "stroke")));

    // Before, and in the frames of an animation, too.
    let before = scene([("m", lines.clone().into())]);
    let mut other = lines.clone();
    other.set_lines(vec![4, 5], vec![0, 2]).unwrap();
    let after = scene([("m", other.into())]);
    let svg = Picture::of(&after).before(&before).view(View::Top).drawn();
    assert!(of_class(&svg, "mesh", "d")[0].contains('L') && length(&svg, "line") > 20.0, "{svg}");
    let mut object = Object::new("m", lines.clone().into());
    let moved = |by: f64| lines.points().iter().map(|p| p + Vector::y() * by).collect::<Vec<_>>();
    object.animation = Some(Animation { rate: 24.0, frames: vec![moved(2.0), moved(1.0), moved(0.0)] });
    let mut scene = Scene::new();
    scene.add(object).unwrap();
    let svg = Picture::of(&scene).view(View::Top).frames(Frames::Fading(2)).drawn();
    let frames = of_class(&svg, "frame", "d");
    assert!(frames.len() == 2 && frames.iter().all(|data| chains(data)[0].len() == 2), "{frames:?}");
}

/// A prism of many sides that moves: its frames are outlines, not dots, and no lines between its faces.
#[test]
fn frames_of_a_mesh_are_outlines() {
    let sides = 32_usize;
    let ring = |z: f64| {
        (0..sides).map(move |k| {
            let (sin, cos) = (k as f64 * std::f64::consts::TAU / sides as f64).sin_cos();
            Point::new(cos, sin, z)
        })
    };
    let points: Vec<Point> = ring(0.0).chain(ring(6.0)).collect();
    let faces: Vec<Vec<usize>> = (0..sides)
        .map(|k| vec![k, (k + 1) % sides, sides + (k + 1) % sides, sides + k])
        .chain([(0..sides).rev().collect(), (sides..2 * sides).collect()])
        .collect();
    let mesh = Mesh::new(points.clone(), &faces).unwrap();
    let mut object = Object::new("pipe", mesh.into());
    let moved = |by: f64| points.iter().map(|p| p + Vector::x() * by).collect::<Vec<_>>();
    object.animation = Some(Animation { rate: 24.0, frames: vec![moved(9.0), moved(4.5), moved(0.0)] });
    let mut scene = Scene::new();
    scene.add(object).unwrap();
    let svg = Picture::of(&scene).view(View::Front).frames(Frames::Fading(3)).drawn();
    let drawn = of_class(&svg, "frame", "d");
    assert_eq!(drawn.len(), 2);
    for data in drawn {
        assert!(!data.contains("h.001"), "dots: {data}");
        // Two sides, and two ends seen from their edge, each a line: none between the faces.
        let places = data.split(['M', 'L']).filter(|part| !part.is_empty()).count();
        assert!(data.contains('L') && (5..=12).contains(&places), "{places}: {data}");
    }
}

#[test]
fn segments_alternate_and_vertices_have_arrows() {
    let (now, then) = (scene([("c", cubic(1.0).into())]), scene([("c", cubic(1.1).into())]));
    let svg = Picture::of(&now).alternate(true).drawn();
    let counts: Vec<usize> = of_class(&svg, "curve", "d").iter().map(|d| d.matches('C').count()).collect();
    assert_eq!(counts, [5, 4]);
    let svg = Picture::of(&now).before(&then).movements(true).drawn();
    // All but the vertex at the origin; and the legend's sample.
    assert_eq!(of_class(&svg, "arrow", "d").len() - 2, 11 + 1);
}

/// A sphere of radius 1: a half circle turned about z.
fn sphere() -> Surface {
    let w = 0.5_f64.sqrt();
    let net = [[0.0, -1.0], [1.0, -1.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let net = net.map(|[x, z]| Point::new(x, 0.0, z)).to_vec();
    let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 2.0];
    let half = Curve::rational(Space::open(2, knots).unwrap(), net, vec![1.0, w, 1.0, w, 1.0]).unwrap();
    Surface::revolution(&half, Point::origin(), Vector::z(), std::f64::consts::TAU).unwrap()
}

/// Chains of path data without curves.
fn chains(data: &str) -> Vec<Vec<[f64; 2]>> {
    let pieces = data.split('M').filter(|piece| !piece.is_empty());
    pieces.map(|piece| numbers(piece).chunks(2).map(|p| [p[0], p[1]]).collect()).collect()
}

#[test]
fn a_sphere_shows_its_outline_and_the_half_in_front() {
    let axes =
        Polyline { points: [[-2.0, 0.0, 0.0], [2.0, 0.0, 0.0]].map(Point::from).to_vec(), closed: false };
    let scene = scene([("ball", sphere().into()), ("axis", axes.into())]);
    let svg = Picture::of(&scene).view(View::Front).control_polygons(false).drawn();
    // The axis gives middle and scale; it is hidden within the ball.
    let seen = chains(&of_class(&svg, "polyline", "d")[0]);
    let hidden = chains(&of_class(&svg, "hidden", "d")[0]);
    assert_eq!((seen.len(), hidden.len()), (2, 1));
    let (left, right) = (seen[0][0], seen[1][1]);
    let (middle, radius) = ([(left[0] + right[0]) / 2.0, left[1]], (right[0] - left[0]) / 4.0);
    for (end, exact) in [(hidden[0][0][0], middle[0] - radius), (hidden[0][1][0], middle[0] + radius)] {
        assert!((end - exact).abs() < 0.2, "{end} {exact}");
    }
    let off = |p: &[f64; 2]| (p[0] - middle[0]).hypot(p[1] - middle[1]);
    let outline = chains(&of_class(&svg, "outline", "d").concat());
    assert!(outline.iter().flatten().all(|p| (off(p) - radius).abs() < 0.1));
    assert!(outline.iter().flatten().count() > 60);
    // Meridians in front meet the equator in front; those behind are not there: 8 of 16 spans of the equator's
    // lines, so half of what a wire frame has.
    let inner = chains(&of_class(&svg, "inner", "d").concat());
    let length = |chains: &[Vec<[f64; 2]>]| -> f64 {
        let steps = chains.iter().flat_map(|c| c.windows(2));
        steps.map(|s| (s[1][0] - s[0][0]).hypot(s[1][1] - s[0][1])).sum()
    };
    let before = self::scene([("ball", sphere().into())]);
    let nothing =
        self::scene([("axis", Polyline { points: vec![Point::origin(); 2], closed: false }.into())]);
    let wires = Picture::of(&nothing).before(&before).view(View::Front).drawn();
    let wires = chains(&of_class(&wires, "surface", "d")[0]);
    let all: f64 = length(&wires);
    let scale = {
        let x = wires.iter().flatten().map(|p| p[0]);
        let (low, high) = x.fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
        2.0 * radius / (high - low)
    };
    let share = length(&inner) / (all * scale);
    assert!((0.4..0.6).contains(&share), "{share}");
    assert_eq!(of_class(&svg, "shading", "width").len(), 1);
}

#[test]
fn of_a_trimmed_surface_only_what_is_left_is_drawn() {
    use loftsman_kernel::spline::trimmed::{ParameterCurve, Region, Trimmed};
    let (u, v) = (Space::clamped(1, &[0.0, 1.0]).unwrap(), Space::clamped(1, &[0.0, 1.0]).unwrap());
    let net = [[0.0, 0.0], [0.0, 10.0], [10.0, 0.0], [10.0, 10.0]].map(|[x, y]| Point::new(x, y, 0.0));
    let plane = Surface::new(u, v, net.to_vec()).unwrap();
    let corners = [[0.1, 0.1], [0.9, 0.1], [0.1, 0.9], [0.1, 0.1]].map(|[x, y]| Point::new(x, y, 0.0));
    let triangle = Curve::new(Space::clamped_uniform(1, 4).unwrap(), corners.to_vec()).unwrap();
    let outer = vec![ParameterCurve::whole(triangle).unwrap()];
    let region = Region { outer, holes: Vec::new() };
    let trimmed = Trimmed::new(plane, vec![region], Vec::new(), Vec::new()).unwrap();
    let scene = scene([("panel", Geometry::Trimmed(trimmed))]);
    let svg = Picture::of(&scene).view(View::Top).control_polygons(false).drawn();
    let border = chains(&of_class(&svg, "border", "d")[0]);
    assert_eq!((border.len(), border[0].len()), (1, 4));
    let (low, high) = (border[0][0], [border[0][1][0], border[0][2][1]]);
    let inner = chains(&of_class(&svg, "inner", "d")[0]);
    assert!(inner.len() > 8);
    for p in inner.iter().flatten() {
        let [s, t] = [0, 1].map(|i| (p[i] - low[i]) / (high[i] - low[i]));
        assert!(s > -0.03 && t > -0.03 && s + t < 1.03, "{s} {t}");
    }
}

#[test]
fn options_that_cannot_be_are_refused_with_reasons() {
    let scene = scene([("c", cubic(1.0).into())]);
    let picture = || Picture::of(&scene);
    for wrong in [
        picture().width(f64::NAN).to_svg().map(|_| ()),
        picture().width(3.0).to_svg().map(|_| ()),
        picture().height(-1.0).to_svg().map(|_| ()),
        picture().to_png(0).map(|_| ()),
        picture().to_png(u32::MAX).map(|_| ()),
    ] {
        assert!(matches!(wrong, Err(PictureError::Size { .. })), "{wrong:?}");
    }
    for wrong in [picture().combs(Combs::Scale(-1.0)), picture().view(View::From(Vector::zeros()))] {
        assert!(matches!(wrong.to_svg(), Err(PictureError::Option { .. })));
    }
    assert!(matches!(picture().columns(0).to_svg(), Err(PictureError::Option { .. })));
    let unknown = picture().panels([Panel::view(View::Top).objects(["cc"])]).to_svg().unwrap_err();
    assert_eq!(unknown.to_string(), "the scene has no object \"cc\"; did you mean \"c\"?");
    let cloud = self::scene([("cloud", Cloud { points: vec![Point::origin()] }.into())]);
    let profile = Picture::of(&cloud).panels([Panel::profile(Against::ArcLength)]).to_svg().unwrap_err();
    assert!(profile.to_string().contains("none among cloud"), "{profile}");
    let marks = [mark(MarkKind::Kept, Point::new(f64::NAN, 0.0, 0.0), Point::origin(), None)];
    assert!(matches!(picture().marks(&marks).to_svg(), Err(PictureError::Place { .. })));
}

#[test]
fn pictures_have_their_size_and_the_same_bytes_every_time() {
    let scene = scene([("c", cubic(1.0).into())]);
    let picture = Picture::of(&scene).title("Ünïcode <&> \u{1}").combs(Combs::Automatic).theme(Theme::Dark);
    let (svg, png) = (picture.drawn(), picture.to_png(640).unwrap());
    assert_eq!(svg, picture.drawn());
    assert_eq!(png, picture.clone().to_png(640).unwrap());
    assert!(svg.contains("Ünïcode &lt;&amp;&gt; \u{fffd}"));
    let size = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().unwrap());
    let page: Vec<f64> = {
        let root = elements(&svg).swap_remove(0).1;
        root.iter().find(|a| a.0 == "viewBox").unwrap().1.split(' ').map(|n| n.parse().unwrap()).collect()
    };
    assert_eq!(size(16), 640);
    assert_eq!(f64::from(size(20)), (640.0 * page[3] / page[2]).round());
}

#[test]
fn texts_are_drawn_without_any_font_installed() {
    // A scene without lines: whatever is dark in the image is text, scale bar or axes; the title is at the top.
    let scene = scene([]);
    let picture = Picture::of(&scene).title("MMMMMMMM").legend(false);
    let without = Picture::of(&scene).legend(false);
    assert!(picture.to_png(400).unwrap().len() > without.to_png(400).unwrap().len() + 100);
}

#[test]
fn very_many_vertices_points_and_faces_stay_small() {
    let n = 100_000;
    let turn = |i: usize| i as f64 * 0.7;
    let net = (0..n).map(|i| Point::new(i as f64, 3e4 * turn(i).sin(), 0.0)).collect();
    let curve = Curve::new(Space::clamped_uniform(3, n).unwrap(), net).unwrap();
    let cloud = (0..n).map(|i| Point::new(turn(i).sin(), (turn(i) * 1.3).cos(), 0.0)).collect();
    let side = 300;
    let height = |i: usize, j: usize| (i as f64 * 0.05).sin() * (j as f64 * 0.04).cos() * 20.0;
    let grid = (0..side * side)
        .map(|k| Point::new((k % side) as f64, (k / side) as f64, height(k % side, k / side)));
    let faces: Vec<[usize; 4]> = (0..side * side)
        .filter(|k| k % side + 1 < side && k / side + 1 < side)
        .map(|k| [k, k + 1, k + side + 1, k + side])
        .collect();
    let mesh = Mesh::new(grid.collect(), &faces).unwrap();
    for (geometry, most) in [
        (Geometry::from(curve), 9_000_000),
        (Cloud { points: cloud }.into(), 600_000),
        (mesh.into(), 1_500_000),
    ] {
        let scene = scene([("many", geometry)]);
        let picture = Picture::of(&scene).combs(Combs::Automatic).beads(Beads::Knots);
        let svg = picture.drawn();
        assert!(svg.len() < most, "{}", svg.len());
        assert!(svg.contains(" are drawn, the others are too") || svg.contains("class=\"shading\""));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn names_and_labels_never_break_the_document(name in "\\PC{1,40}|.{1,40}", label in ".{0,60}") {
        let mut scene = Scene::new();
        scene.add(Object::new(name.clone(), cubic(1.0).into())).unwrap();
        let marks = [Mark { object: name, label: label.clone(), ..mark(MarkKind::Kept, Point::origin(), Point::origin(), None) }];
        elements(&Picture::of(&scene).marks(&marks).title(label).drawn());
    }

    #[test]
    fn any_curve_has_a_picture(
        net in prop::collection::vec([-1e3..1e3_f64, -1e3..1e3, -1e3..1e3], 6..20),
        weights in prop::collection::vec(1e-3..1e3_f64, 20),
        degree in 1_usize..6,
        periodic: bool,
        exponent in -12..12_i32,
    ) {
        let scale = 10_f64.powi(exponent);
        let points: Vec<Point> = net.iter().map(|c| Point::from(Vector::from(*c) * scale)).collect();
        let space = if periodic { Space::periodic_uniform(degree, points.len()) } else { Space::clamped_uniform(degree, points.len()) };
        let weights = weights[..points.len()].to_vec();
        let curve = Curve::rational(space.unwrap(), points, weights).unwrap();
        let scene = scene([("c", curve.into())]);
        let panels = [Panel::view(View::Perspective), Panel::profile(Against::ArcLength)];
        let picture = Picture::of(&scene).combs(Combs::Automatic).beads(Beads::Knots).panels(panels);
        let svg = picture.drawn();
        elements(&svg);
        prop_assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }
}

#[test]
fn what_lies_in_one_place_is_drawn_in_seconds_and_what_is_too_much_is_refused() {
    let net = || vec![Point::origin(), Point::new(3.0, 0.0, 1.0), Point::new(0.0, 2.0, 0.5)];
    let start = std::time::Instant::now();
    // The same face 3000 times in one mesh; as many instances; and as many, each a little elsewhere.
    let pile = Mesh::new(net(), &vec![[0, 1, 2]; 3000]).unwrap();
    let one = Mesh::new(net(), &[[0, 1, 2]]).unwrap();
    let shifted = |by: f64| {
        let mut scene = Scene::new();
        for k in 0..3000 {
            let mut object = Object::new(format!("o{k}"), (&one).into());
            object.transform =
                Some(nalgebra::Matrix4::new_translation(&Vector::new(0.0, 0.0, by * f64::from(k))));
            scene.add(object).unwrap();
        }
        scene
    };
    let plain = Picture::of(&scene([("pile", (&one).into())])).drawn();
    let shading = |svg: &str| of_class(svg, "shading", "href");
    let piled = Picture::of(&scene([("pile", (&pile).into())])).drawn();
    assert_eq!(shading(&piled), shading(&plain));
    assert!(!of_class(&Picture::of(&shifted(0.0)).drawn(), "border", "d").is_empty());
    let apart = Picture::of(&shifted(1e-6)).view(View::Isometric).drawn();
    assert!(apart.contains("drawn in cells of"), "and said");
    // Far more than a page can show.
    let count = 40_000_u32;
    let points =
        (0..count).flat_map(|k| net().into_iter().map(move |p| p + Vector::z() * (1e-6 * f64::from(k))));
    let faces: Vec<[usize; 3]> = (0..count as usize).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    let scene = scene([("tower", Mesh::new(points.collect(), &faces).unwrap().into())]);
    let error = Picture::of(&scene).view(View::Top).width(2000.0).to_svg().unwrap_err();
    assert!(matches!(error, PictureError::Covered(_)), "{error}");
    assert!(start.elapsed().as_secs() < 60, "{:?}", start.elapsed());
}

#[test]
fn a_hundred_thousand_curves_take_ten_times_as_long_as_ten_thousand() {
    let scene = |count: u32| {
        let mut scene = Scene::new();
        for k in 0..count {
            let at = Vector::new(f64::from(k % 300), f64::from(k / 300), 0.0);
            let points =
                [[0.0, 0.0], [0.3, 0.9], [0.6, -0.4], [0.9, 0.2]].map(|[x, y]| Point::new(x, y, 0.0) + at);
            // Long names, so that comparing them all would be felt.
            let name = format!("a curve of many, and its number is {k}");
            scene.add(Object::new(name, Curve::bezier(points.to_vec()).unwrap().into())).unwrap();
        }
        scene
    };
    let time = |count: u32| {
        let scene = scene(count);
        let start = std::time::Instant::now();
        let svg = Picture::of(&scene).combs(Combs::Automatic).beads(Beads::Knots).drawn();
        assert_eq!(svg.matches("class=\"curve\"").count(), count as usize);
        start.elapsed().as_secs_f64()
    };
    let (few, many) = (time(10_000), time(100_000));
    // What is quadratic takes a hundred times as long.
    assert!(many < 40.0 * few, "{few} s, {many} s");
}

#[test]
fn what_is_on_hidden_layers_is_not_there_at_all() {
    use loftsman_kernel::scene::Layer;
    let curve =
        |x: f64| -> Geometry { Curve::bezier(points(&[[x, 0.0], [x + 1.0, 2.0]], 1.0)).unwrap().into() };
    let shown = scene([("c", curve(0.0))]);
    // Far away, so that the extent would tell.
    let mut both = scene([("c", curve(0.0)), ("far", curve(1e6))]);
    both.layers.add(Layer::new("below").below("off")).unwrap();
    both.layers.add(Layer::new("off").hidden()).unwrap();
    both.object_mut("far").unwrap().layer = Some("below".into());
    let far = Point::new(1e6, 0.0, 0.0);
    let marks = [Mark { object: "far".into(), ..mark(MarkKind::Moved, far, far, None) }];
    let drawn = |scene: &Scene| Picture::of(scene).to_svg().unwrap();
    assert_eq!(drawn(&both), drawn(&shown));
    // Nor as it was before, whatever it was on then.
    let before = scene([("c", curve(0.0)), ("far", curve(2e6))]);
    let changed = Picture::of(&both).before(&before).marks(&marks).to_svg().unwrap();
    assert_eq!(changed, drawn(&shown));
    let mut seen = both.clone();
    seen.layers = Default::default();
    assert_ne!(drawn(&seen), drawn(&shown));
}

#[test]
fn an_object_by_layer_is_drawn_as_one_with_the_colour() {
    use loftsman_kernel::scene::Layer;
    let mut own = scene([("c", cubic(1.0).into())]);
    own.object_mut("c").unwrap().color = Some([0.8, 0.1, 0.2, 1.0]);
    let mut by_layer = scene([("c", cubic(1.0).into())]);
    by_layer.layers.add(Layer::new("red").colored([0.8, 0.1, 0.2, 1.0])).unwrap();
    by_layer.object_mut("c").unwrap().layer = Some("red".into());
    assert_eq!(Picture::of(&by_layer).to_svg().unwrap(), Picture::of(&own).to_svg().unwrap());
}

#[test]
fn lengths_of_unknown_units_are_said_to_be_units() {
    let mut unknown = scene([("c", cubic(1.0).into())]);
    unknown.unit = Unit::Unknown;
    let svg = Picture::of(&unknown).combs(Combs::Automatic).to_svg().unwrap();
    assert!(svg.contains(" unit</text>") && svg.contains("/unit"), "{svg}");
    assert!(!svg.contains("unknown"), "{svg}");
}

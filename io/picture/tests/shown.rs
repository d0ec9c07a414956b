//! What pictures show of several objects and of shapes that have changed their knots, and what they say is not shown.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a helper of a test may fail as the test itself")]

use crate::drawn::Drawn;
use loftsman_kernel::mesh::{Cloud, Layer, Mesh, Polyline};
use loftsman_kernel::plugin::{CustomShape, Mark, MarkKind};
use loftsman_kernel::scene::{Definition, Geometry, Object, Scene};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use loftsman_picture::{Beads, Combs, Curvature, Faces, Panel, Picture, View};
use loftsman_subdivision::{Cage, SubdivisionSurface};
use nalgebra::Matrix4;
use roxmltree::Document;

/// A scene of the curve "c".
fn scene(curve: Curve) -> Scene {
    let mut scene = Scene::new();
    scene.add(Object::new("c", curve.into())).unwrap();
    scene
}

/// Twelve vertices, uniform clamped cubic.
fn cubic(scale: f64) -> Curve {
    let heights = [0.0, 1.0, 0.5, -0.5, 0.8, 1.2, 0.2, -0.6, 0.0, 1.0, 0.7, 0.0];
    let points = heights.iter().enumerate().map(|(i, h)| Point::new(i as f64 * scale, h * scale, 0.0));
    Curve::new(Space::clamped_uniform(3, 12).unwrap(), points.collect()).unwrap()
}

/// An attribute of the elements of a class.
fn of_class(svg: &str, class: &str, attribute: &str) -> Vec<String> {
    let document = Document::parse(svg).unwrap();
    let nodes = document.descendants().filter(|node| node.attribute("class") == Some(class));
    nodes.filter_map(|node| node.attribute(attribute).map(str::to_owned)).collect()
}

#[test]
fn movements_are_drawn_of_a_refined_shape_and_said_to_be_missing_of_another() {
    let knots = [2.5, 2.5, 6.1];
    let now = scene(cubic(1.0).insert_knots(&knots).unwrap());
    let then = scene(cubic(1.1));
    let svg = Picture::of(&now).before(&then).movements(true).drawn();
    // All but the vertex at the origin; and the legend's sample, and two axes.
    assert_eq!(of_class(&svg, "arrow", "d").len() - 2, 14 + 1);
    let other = scene(cubic(1.1).elevate(1).unwrap());
    let svg = Picture::of(&now).before(&other).movements(true).drawn();
    assert!(of_class(&svg, "arrow", "d").len() == 2 && svg.contains("c: no arrows"), "{svg}");
}

#[test]
fn the_legend_names_what_is_shown_each_in_its_own_colour() {
    let mut all = Scene::new();
    for i in 0..30 {
        let points = vec![Point::new(0.0, f64::from(i), 0.0), Point::new(9.0, f64::from(i), 0.0)];
        let line = Polyline { points, closed: false };
        all.add(Object::new(format!("line {i:02}"), line.into())).unwrap();
    }
    // A palette's length apart, and beyond the objects that a legend of all would name.
    let chosen = ["line 02", "line 08", "line 14", "line 26"];
    let svg = Picture::of(&all).panels([Panel::view(View::Top).objects(chosen)]).drawn();
    let legend = svg.split("id=\"legend\"").nth(1).unwrap();
    assert!(chosen.iter().all(|name| legend.contains(name)) && !legend.contains(" more "), "{legend}");
    let mut colours = of_class(&svg, "polyline", "stroke");
    colours.sort();
    colours.dedup();
    assert_eq!(colours.len(), chosen.len(), "{colours:?}");
    // Of more than it names, the others are counted: once, whatever panels there are.
    let thirteen = (0..13).map(|i| format!("line {i:02}"));
    let panels = [View::Top, View::Front].map(|view| Panel::view(view).objects(thirteen.clone()));
    let svg = Picture::of(&all).panels(panels).drawn();
    assert_eq!(svg.matches("and 1 more polyline<").count(), 1, "{svg}");
    let svg = Picture::of(&all).view(View::Top).drawn();
    assert_eq!(svg.matches("and 18 more polylines<").count(), 1, "{svg}");
    // What is of several kinds is objects.
    all.add(Object::new("z", cubic(1.0).into())).unwrap();
    let svg = Picture::of(&all).view(View::Top).drawn();
    assert_eq!(svg.matches("and 19 more objects<").count(), 1, "{svg}");
}

#[test]
fn what_instances_show_is_drawn_where_it_is() {
    let mut all = Scene::new();
    let mut part = Definition::new("part");
    part.add(Object::new("c", cubic(1.0).into())).unwrap();
    all.define(part).unwrap();
    for (name, y) in [("low", 0.0), ("high", 7.0)] {
        let mut object = Object::new(name, Geometry::Instance("part".into()));
        object.transform = Some(Matrix4::new_translation(&Vector::new(0.0, y, 0.0)));
        all.add(object).unwrap();
    }
    all.add(Object::new("alone", cubic(0.5).into())).unwrap();
    let flat = all.flattened(100).unwrap().into_owned();
    let svg = Picture::of(&all).drawn();
    assert_eq!(svg, Picture::of(&flat).drawn());
    assert!(svg.contains("low/c") && svg.contains("high/c"));
    // Who asks for an instance is shown what it shows.
    let high = Picture::of(&all).panels([Panel::view(View::Top).objects(["high"])]).drawn();
    let inside = Picture::of(&flat).panels([Panel::view(View::Top).objects(["high", "high/c"])]).drawn();
    assert_eq!(high, inside);
    assert!(high.contains("high/c") && !high.contains("low/c"), "{high}");
}

/// The colours of a mesh's points are those of the picture, darkened by a tenth where its faces are turned away from the light by 45
/// degrees; without them a mesh has its object's.
#[test]
fn meshes_have_the_colours_of_their_points() {
    let points = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Point::new(x, y, 0.0));
    let plain = Mesh::new(points.to_vec(), &[[0, 1, 2, 3]]).unwrap();
    let mut colored = plain.clone();
    // Linear red on the left, linear blue on the right.
    let (red, blue) = ([1.0, 0.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]);
    colored.colors = Layer::per_point(vec![red, blue, blue, red]);
    let picture = |mesh: &Mesh| {
        let mut scene = Scene::new();
        scene.add(Object::new("m", mesh.clone().into())).unwrap();
        let bytes = Picture::of(&scene).panels([Panel::view(View::Top)]).to_png(300).unwrap();
        tiny_skia::Pixmap::decode_png(&bytes).unwrap()
    };
    let image = picture(&colored);
    let rgb = |x: u32| image.pixel(x, 60).map(|p| [p.red(), p.green(), p.blue()]).unwrap();
    let row: Vec<[u8; 3]> =
        (0..image.width()).map(rgb).filter(|p| p[1] < 20 && p[0].max(p[2]) > 80).collect();
    assert!(row.len() > 40, "{}", row.len());
    let lit = 255.0 * (1.0 - 0.35 * 0.3);
    for (k, [red, _, blue]) in row.iter().enumerate() {
        let share = k as f64 / (row.len() - 1) as f64;
        assert!((f64::from(*red) - lit * (1.0 - share)).abs() < 8.0, "{k}: {red} {blue}");
        assert!((f64::from(*blue) - lit * share).abs() < 8.0, "{k}: {red} {blue}");
    }
    let image = picture(&plain);
    let all = image.pixels().iter();
    assert!(!all.into_iter().any(|p| p.green() < 20 && p.red().max(p.blue()) > 80 && p.alpha() == 255));
}

/// The words of the labels in the drawings.
fn labels(svg: &str) -> Vec<String> {
    let document = Document::parse(svg).unwrap();
    let nodes = document.descendants().filter(|node| node.attribute("class") == Some("label"));
    nodes.filter_map(|node| node.text().map(str::to_owned)).collect()
}

/// All texts of a page.
fn texts(svg: &str) -> Vec<String> {
    let document = Document::parse(svg).unwrap();
    let nodes = document.descendants().filter(|node| node.has_tag_name("text"));
    nodes.filter_map(|node| node.text().map(str::to_owned)).collect()
}

/// A sheet of so many vertices each way, `f` above a square.
fn sheet(count: usize, f: impl Fn(f64, f64) -> f64) -> Surface {
    let space = || Space::clamped_uniform(3, count).unwrap();
    let (_, end) = space().domain();
    let at = |k: usize| {
        let [x, y] = [k / count, k % count].map(|i| 4.0 * space().greville(i) / end - 2.0);
        Point::new(x, y, f(x, y))
    };
    Surface::new(space(), space(), (0..count * count).map(at).collect()).unwrap()
}

fn scene_of(geometry: Geometry) -> Scene {
    let mut scene = Scene::new();
    scene.add(Object::new("s", geometry)).unwrap();
    scene
}

/// Every parameter of a sheet under its net has its number, in one drawing as on a page of four, on painted faces too.
#[test]
fn the_parameters_of_a_surface_are_read_beside_its_net() {
    let sheet = sheet(9, |x, y| 0.2 * (4.0 - x * x - y * y));
    let scene = scene_of(sheet.into());
    let picture = Picture::of(&scene).view(View::Isometric).parameters(true);
    let svg = picture.drawn();
    let found = labels(&svg).join(", ");
    for name in ["u", "v"] {
        for value in [0, 2, 4, 6] {
            assert!(found.contains(&format!("{name} {value}")), "{name} {value}: {found}");
        }
    }
    assert!(!texts(&svg).iter().any(|text| text.contains("no room")), "{:?}", texts(&svg));
    let panels = [Faces::Zebra, Faces::Curvature(Curvature::Mean), Faces::Shaded, Faces::Shaded]
        .map(|faces| Panel::view(View::Isometric).faces(faces));
    let svg = picture.panels(panels).drawn();
    let each: Vec<&str> = svg.split("id=\"labels-").skip(1).collect();
    assert_eq!(each.len(), 4);
    for drawing in each {
        assert!(drawing.matches("class=\"label\"").count() >= 6, "{drawing}");
        // On faces of any colour leaders have paper around.
        assert_eq!(
            drawing.matches("class=\"leader\"").count(),
            drawing.matches("class=\"halo\"").count(),
            "{drawing}"
        );
    }
}

/// Round numbers all along a polyline of many knots, at knots and squares, and no knots instead.
#[test]
fn the_parameters_of_a_polyline_of_many_knots_are_all_read() {
    let at = |k: usize| Point::new(k as f64, 20.0 * (k as f64 * 0.03).sin(), 0.0);
    let line = Curve::new(Space::clamped_uniform(1, 501).unwrap(), (0..501).map(at).collect()).unwrap();
    let svg = Picture::of(&scene(line)).beads(Beads::Knots).parameters(true).drawn();
    let mut found: Vec<u32> = labels(&svg).iter().map(|label| label.parse().unwrap()).collect();
    found.sort_unstable();
    assert_eq!(found, [0, 50, 100, 150, 200, 250, 300, 350, 400, 450, 500]);
}

/// Where there is no room for all, that is said, and in which drawing.
#[test]
fn parameters_without_a_label_are_counted() {
    let many: Vec<_> = (0..40)
        .map(|k| {
            let points = [[0.0, 0.0], [9.0, 0.0]].map(|[x, y]| Point::new(x, y + 0.05 * f64::from(k), 0.0));
            Object::new(format!("{k:02}"), Curve::bezier(points.to_vec()).unwrap().into())
        })
        .collect();
    let mut scene = Scene::new();
    many.into_iter().for_each(|object| scene.add(object).unwrap());
    let picture = Picture::of(&scene).parameters(true);
    let notes =
        |svg: &str| texts(svg).into_iter().filter(|text| text.contains("no room")).collect::<Vec<_>>();
    let one = notes(&picture.drawn());
    assert!(one.len() == 1 && one[0].starts_with("labels for which there is no room: "), "{one:?}");
    assert!(!one[0].contains("drawing"), "{one:?}");
    let panels = [Panel::view(View::Top), Panel::view(View::Top).caption("above").objects(["00"])];
    let two = notes(&picture.clone().panels(panels).drawn());
    assert!(two[0].contains("in \"drawing 1\"") && !two[0].contains("above"), "{two:?}");
    // A side that only one of them shows is its name.
    let sides = [Panel::view(View::Top), Panel::view(View::Perspective).objects(["00"])];
    let named = notes(&picture.panels(sides).drawn());
    assert!(named[0].contains("in \"from above\"") && !named[0].contains("drawing"), "{named:?}");
}

/// Vertices of meshes, polylines and cages have their numbers where they are seen; of very many it is said that they have none.
#[test]
fn vertices_are_numbered() {
    let corner = |k: usize| Point::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
    let corners: Vec<Point> = (0..8).map(corner).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mesh = Geometry::from(Mesh::new(corners.clone(), &quads).unwrap());
    let cage = Geometry::from(CustomShape::from(
        SubdivisionSurface::new(Cage::new(corners.clone(), &quads).unwrap()).unwrap(),
    ));
    let line = Geometry::from(Polyline { points: corners, closed: false });
    let of = |geometry: Geometry| {
        let svg = Picture::of(&scene_of(geometry)).view(View::Isometric).parameters(true).drawn();
        let mut found: Vec<usize> = labels(&svg).iter().filter_map(|label| label.parse().ok()).collect();
        found.sort_unstable();
        (found, texts(&svg).join("\n"))
    };
    // Of a cube seen from a corner seven are seen; a cage stands round its surface, and through lines everything is seen: in the middle of
    // the page two of them are one place.
    let (found, words) = of(mesh);
    assert!(found.len() == 7 && words.contains("out of sight: 1 of s"), "{found:?} {words}");
    let (found, words) = of(cage);
    assert!(
        found.len() >= 7 && words.contains("the numbers are those of its control vertices"),
        "{found:?} {words}"
    );
    let (found, words) = of(line);
    assert!(found.len() >= 6 && !words.contains("out of sight"), "{found:?} {words}");
    let many = (0..501).map(|k| Point::new(f64::from(k), 0.0, 0.0)).collect();
    let (found, words) = of(Polyline { points: many, closed: false }.into());
    assert!(found.is_empty() && words.contains("its 501 vertices are too many to be numbered"), "{words}");
}

/// The parameters of a trimmed surface are on what is left of it.
#[test]
fn parameters_of_a_trimmed_surface_are_where_it_is_drawn() {
    use loftsman_kernel::spline::trimmed::{ParameterCurve, Region, Trimmed};
    let (u, v) = (Space::clamped(1, &[0.0, 1.0]).unwrap(), Space::clamped(1, &[0.0, 1.0]).unwrap());
    let net = [[0.0, 0.0], [0.0, 10.0], [10.0, 0.0], [10.0, 10.0]].map(|[x, y]| Point::new(x, y, 0.0));
    let plane = Surface::new(u, v, net.to_vec()).unwrap();
    // A triangle whose long side no line of equal parameter runs along.
    let corners = [[0.1, 0.1], [0.9, 0.3], [0.3, 0.9], [0.1, 0.1]].map(|[x, y]| Point::new(x, y, 0.0));
    let triangle = Curve::new(Space::clamped_uniform(1, 4).unwrap(), corners.to_vec()).unwrap();
    let outer = vec![ParameterCurve::whole(triangle).unwrap()];
    let trimmed = Trimmed::new(plane, vec![Region { outer, holes: Vec::new() }], Vec::new(), Vec::new());
    let scene = scene_of(Geometry::Trimmed(trimmed.unwrap()));
    let svg = Picture::of(&scene).view(View::Top).control_polygons(false).parameters(true).drawn();
    let numbers = |data: &str| -> Vec<f64> {
        let split = data.split(|c: char| c.is_ascii_alphabetic() || c == ' ').filter(|part| !part.is_empty());
        split.map(|number| number.parse().unwrap()).collect()
    };
    let border = numbers(&of_class(&svg, "border", "d")[0]);
    // The corners, from which the page's scale follows.
    let scale = (border[2] - border[0]) / 0.8;
    let dots = numbers(&of_class(&svg, "parameters", "d")[0]);
    assert_eq!(dots.len() / 3, 8, "0.2, 0.4, 0.6 and 0.8 each way: {dots:?}");
    for dot in dots.chunks(3) {
        let (x, y) = (0.1 + (dot[0] - border[0]) / scale, 0.1 - (dot[1] - border[1]) / scale);
        let inside = |[a, b]: [f64; 2], [c, d]: [f64; 2]| (c - a) * (y - b) - (d - b) * (x - a) > -3e-3;
        assert!(
            inside([0.1, 0.1], [0.9, 0.3])
                && inside([0.9, 0.3], [0.3, 0.9])
                && inside([0.3, 0.9], [0.1, 0.1]),
            "{x} {y}"
        );
    }
    assert_eq!(labels(&svg).len(), 8, "{:?}", labels(&svg));
    assert!(texts(&svg).iter().any(|text| text == "labels out of sight: 4 of s"), "{:?}", texts(&svg));
}

/// An arrow on a face of its colour has paper around it; without faces there is nothing to stand out from.
#[test]
fn arrows_on_faces_have_a_halo() {
    let scene_of_sheet = scene_of(sheet(5, |_, _| 0.5).into());
    let before = scene_of(sheet(5, |_, _| 0.0).into());
    let mark = |object: &str| Mark {
        object: object.into(),
        kind: MarkKind::Moved,
        position: Point::new(0.0, 0.0, 0.5),
        before: Point::origin(),
        vector: None,
        label: "position at [0.5, 0.123456789]".into(),
        spot: None,
        track: None,
    };
    let marks = [mark("s")];
    let picture = Picture::of(&scene_of_sheet).before(&before).draw_before(false).marks(&marks);
    let svg = picture.view(View::Isometric).faces(Faces::Deviation).drawn();
    let group = svg.split("class=\"mark moved\"").nth(1).unwrap().split("</g>").next().unwrap();
    let (halo, arrow) = (group.find("\"halo\"").unwrap(), group.find("\"arrow\"").unwrap());
    assert!(halo < arrow, "{group}");
    assert_eq!(labels(&svg), ["position at [0.5, 0.123457]"]);
    let curve = scene(cubic(1.0));
    let marks = [mark("c")];
    let svg = Picture::of(&curve).marks(&marks).drawn();
    assert!(svg.contains("\"arrow\"") && !svg.contains("\"halo\""));
}

/// A few points that were found are seen on the lines that meet there: above them, larger than a line is wide, and so in the legend.
#[test]
fn a_few_points_stand_above_lines() {
    let found = |count: usize| {
        let mut all = scene(cubic(1.0));
        let points = (0..count).map(|k| Point::new(0.1 * k as f64, 0.5, 0.0)).collect();
        all.add(Object::new("found", Cloud { points }.into())).unwrap();
        Picture::of(&all).beads(Beads::Knots).drawn()
    };
    let svg = found(3);
    let at = |id: &str| svg.find(&format!("id=\"{id}\"")).unwrap();
    assert!(
        at("points") > at("curves") && at("points") > at("knots") && at("points") > at("control-polygons")
    );
    let width = |svg: &str| -> f64 { of_class(svg, "cloud", "stroke-width")[0].parse().unwrap() };
    assert!(width(&svg) > 1.0 && width(&found(400)) < 1.0 && !found(400).contains("id=\"points\""));
}

/// What is thinned out is said once for all objects, of as many as there are.
#[test]
fn vertices_that_are_left_out_are_told_in_one_sentence() {
    let mut all = Scene::new();
    let dense = |y: f64| {
        // A quarter of the vertices, 100 in all, lie in the last hundredth.
        let at = |k: usize| Point::new(if k < 25 { k as f64 } else { 24.0 + 1e-3 * k as f64 }, y, 0.0);
        Curve::new(Space::clamped_uniform(2, 100).unwrap(), (0..100).map(at).collect()).unwrap()
    };
    for k in 0..7 {
        all.add(Object::new(format!("c{k}"), dense(f64::from(k)).into())).unwrap();
    }
    let said = |picture: &Picture<'_>| {
        let words = texts(&picture.drawn()).join(" ");
        words[words.find("control polygon").unwrap() + 16..].to_owned()
    };
    let words = said(&Picture::of(&all));
    assert!(
        words.starts_with("control vertices too close to be told apart are left out: drawn are 2"),
        "{words}"
    );
    assert!(words.contains(" of 100 of c0, ") && words.contains(" and 3 more"), "{words}");
    assert_eq!(words.matches("too close").count(), 1, "{words}");
    let panels =
        ["c0", "c1"].map(|name| Panel::view(View::Top).caption(format!("the {name}")).objects([name]));
    let words = said(&Picture::of(&all).panels(panels));
    assert!(words.contains(" of 100 of c0 in \"the c0\", "), "{words}");
    let words = said(&Picture::of(&scene(dense(0.0))));
    assert!(words.starts_with("c: ") && words.contains(" of 100 control vertices are drawn"), "{words}");
}

/// The teeth of a comb are read by the scale bar: of a circle of radius `r` all are of the curvature `1/r`, so that a tooth as long on the page as `k` bars is of `k` times what the legend says of one.
#[test]
fn teeth_of_a_comb_are_read_by_the_scale_bar() {
    let corner = std::f64::consts::FRAC_1_SQRT_2;
    let around =
        [[1., 0.], [1., 1.], [0., 1.], [-1., 1.], [-1., 0.], [-1., -1.], [0., -1.], [1., -1.], [1., 0.]];
    let knots = vec![0., 0., 0., 1., 1., 2., 2., 3., 3., 4., 4., 4.];
    let weights = (0..9).map(|i| if i % 2 == 0 { 1.0 } else { corner }).collect();
    for (radius, combs) in
        [(2.0, Combs::Automatic), (2e-9, Combs::Automatic), (3e9, Combs::Automatic), (5.0, Combs::Scale(7.0))]
    {
        let points = around.map(|[x, y]| Point::new(radius * x, radius * y, 0.0)).to_vec();
        let space = Space::open(2, knots.clone()).unwrap();
        let circle = Curve::rational(space, points, Vec::clone(&weights)).unwrap();
        let svg = Picture::of(&scene(circle)).combs(combs).drawn();
        let numbers = |data: &str| -> Vec<f64> {
            data.split(|c: char| !(c.is_ascii_digit() || "-.e".contains(c)))
                .filter_map(|n| n.parse().ok())
                .collect()
        };
        let [ref bar] = of_class(&svg, "scale-bar", "d")[..] else { panic!("one bar") };
        let bar = numbers(bar.split_once('h').unwrap().1)[0];
        let [ref teeth] = of_class(&svg, "comb", "d")[..] else { panic!("one comb") };
        let teeth = numbers(teeth);
        let said = svg.split("a tooth of ").nth(1).unwrap();
        let (long, rest) = said.split_once(" is ").unwrap();
        let (per, rest) = rest.split_once('/').unwrap();
        let largest = rest.split("drawn up to ").nth(1).unwrap().split('/').next().unwrap();
        assert!(svg.matches(&format!(">{long}<")).count() == 1, "the bar says {long}: {svg}");
        // `5·10⁸` and `10⁻⁹`, too.
        let plain = |words: &str| -> String {
            words
                .chars()
                .map(|c| "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().position(|d| d == c).map_or(c, |d| (b'0' + d as u8) as char))
                .collect()
        };
        let number = |words: &str| -> f64 {
            let raised = |(before, after): &(&str, &str)| {
                (before.is_empty() || before.ends_with('·'))
                    && after.starts_with(|c: char| "⁻⁰¹²³⁴⁵⁶⁷⁸⁹".contains(c))
            };
            let Some((times, power)) = words.split_once("10").filter(raised) else {
                return words.parse().unwrap();
            };
            let times = if times.is_empty() { 1.0 } else { times.trim_end_matches('·').parse().unwrap() };
            times * 10_f64.powi(plain(power).replace('⁻', "-").parse().unwrap())
        };
        assert!(teeth.len() >= 40, "{teeth:?}");
        for tooth in teeth.chunks_exact(4) {
            let length = (tooth[2] - tooth[0]).hypot(tooth[3] - tooth[1]);
            // Numbers are told to three figures, and the page has thousandths of a millimetre.
            assert!(
                (length / bar * number(per) * radius - 1.0).abs() < 1e-2,
                "{radius}: {length} {bar} {per}"
            );
        }
        assert!((number(largest) * radius - 1.0).abs() < 6e-3, "{radius}: {largest}");
    }
}

/// A mark behind a face is pale, and that is said; one on the face that is seen, and one beside it, are not.
#[test]
fn marks_behind_faces_are_pale() {
    let scene = scene_of(sheet(5, |_, _| 0.0).into());
    let mark = |z: f64| Mark {
        object: "s".into(),
        kind: MarkKind::Kept,
        position: Point::new(0.1, 0.1, z),
        before: Point::new(0.1, 0.1, z),
        vector: None,
        label: "kept".into(),
        spot: None,
        track: None,
    };
    let drawn = |z: f64| {
        let marks = [mark(z)];
        Picture::of(&scene).marks(&marks).view(View::Top).faces(Faces::Shaded).drawn()
    };
    let fill = |svg: &str| {
        let group = svg.split("class=\"mark kept\"").nth(1).unwrap().split("</g>").next().unwrap().to_owned();
        group.split("fill=\"").nth(1).unwrap()[..7].to_owned()
    };
    let (on, before, behind) = (drawn(0.0), drawn(0.4), drawn(-0.4));
    assert_eq!(fill(&on), fill(&before));
    let light =
        |hex: &str| (1..7).step_by(2).map(|i| u32::from_str_radix(&hex[i..i + 2], 16).unwrap()).sum::<u32>();
    assert!(light(&fill(&behind)) > light(&fill(&on)) + 200, "{} {}", fill(&behind), fill(&on));
    let said = "pale marks are behind faces";
    assert!(behind.contains(said) && !on.contains(said) && !before.contains(said));
}

/// Lines of a surface that turns fast between two of them look round: with cells of one size chords turned by thirty degrees here.
#[test]
fn lines_that_turn_fast_look_round() {
    // A step up between two flats.
    let profile = |k: usize| match k {
        0..=3 => [0.25 * k as f64, 0.0],
        4 => [1.0, 0.0],
        5 => [1.0, 0.1],
        k => [1.0 + 0.25 * (k - 5) as f64, 0.1],
    };
    let space = Space::clamped_uniform(2, 10).unwrap();
    let row = |k: usize| [0.0, 0.5].map(|y| Point::new(profile(k)[0], y, profile(k)[1]));
    let points = (0..10).flat_map(row).collect();
    let across = Space::clamped(1, &[0.0, 1.0]).unwrap();
    let bent = scene_of(Surface::new(space, across, points).unwrap().into());
    let svg = Picture::of(&bent).view(View::Isometric).faces(Faces::Shaded).drawn();
    let mut most = 0.0_f64;
    let path = svg.split("class=\"inner\" d=\"").nth(1).unwrap().split('"').next().unwrap();
    {
        for line in path.split('M').skip(1) {
            let numbers: Vec<f64> =
                line.split(|c: char| "LHVZ, ".contains(c)).filter_map(|n| n.parse().ok()).collect();
            let spots: Vec<[f64; 2]> = numbers.chunks_exact(2).map(|p| [p[0], p[1]]).collect();
            for w in spots.windows(3) {
                let (a, b) = ([w[1][0] - w[0][0], w[1][1] - w[0][1]], [w[2][0] - w[1][0], w[2][1] - w[1][1]]);
                let (sin, cos) = (a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1]);
                most = most.max(sin.atan2(cos).abs().to_degrees());
            }
        }
    }
    assert!(most > 1.0 && most < 20.0, "{most}");
}

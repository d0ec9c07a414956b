//! What pictures show of several objects and of shapes that have changed their knots, and what they say is not shown.
#![allow(clippy::unwrap_used, reason = "a helper of a test may fail as the test itself")]

mod drawn;

use drawn::Drawn;
use loftsman_kernel::mesh::{Layer, Mesh, Polyline};
use loftsman_kernel::scene::{Definition, Geometry, Object, Scene};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};
use loftsman_picture::{Panel, Picture, View};
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
    assert!(chosen.iter().all(|name| legend.contains(name)) && !legend.contains("more object"), "{legend}");
    let mut colours = of_class(&svg, "polyline", "stroke");
    colours.sort();
    colours.dedup();
    assert_eq!(colours.len(), chosen.len(), "{colours:?}");
    // Of more than it names, the others are counted: once, whatever panels there are.
    let thirteen = (0..13).map(|i| format!("line {i:02}"));
    let panels = [View::Top, View::Front].map(|view| Panel::view(view).objects(thirteen.clone()));
    let svg = Picture::of(&all).panels(panels).drawn();
    assert_eq!(svg.matches("and 1 more object<").count(), 1, "{svg}");
    let svg = Picture::of(&all).view(View::Top).drawn();
    assert_eq!(svg.matches("and 18 more objects<").count(), 1, "{svg}");
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

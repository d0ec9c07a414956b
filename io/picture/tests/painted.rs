//! Faces painted with stripes, curvature and deviation, where these are known.
#![allow(clippy::unwrap_used, clippy::panic, reason = "these are tests, their helpers included")]

use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::scene::{Object, Scene, Unit};
use loftsman_kernel::spline::{Curve, Direction, Space, Surface};
use loftsman_kernel::{Point, Vector};
use loftsman_picture::{Curvature, Faces, Panel, Picture, View};

fn scene(surface: Surface) -> Scene {
    let mut scene = Scene::new();
    scene.unit = Unit::Millimetre;
    scene.add(Object::new("s", surface.into())).unwrap();
    scene
}

/// The sphere of a radius whose normal points outwards, so that its curvatures are `-1/r`.
fn sphere(radius: f64) -> Surface {
    let half = Curve::elliptic_arc(
        Point::origin(),
        -Vector::z() * radius,
        Vector::x() * radius,
        0.0,
        std::f64::consts::PI,
    );
    Surface::revolution(&half.unwrap(), Point::origin(), Vector::z(), std::f64::consts::TAU).unwrap()
}

/// The graph of a function over a square of a side.
fn graph(side: f64, f: impl Fn(f64, f64) -> f64) -> Surface {
    let space = || Space::clamped_uniform(2, 12).unwrap();
    let at = |k: usize| {
        let (x, y) = (space().greville(k / 12) / 10.0 - 0.5, space().greville(k % 12) / 10.0 - 0.5);
        Point::new(side * x, side * y, side * f(x, y))
    };
    Surface::new(space(), space(), (0..144).map(at).collect()).unwrap()
}

/// The pixels of a picture seen from above without anything but the faces, as red, green and blue.
fn pixels(picture: &Picture<'_>) -> (usize, Vec<[u8; 3]>) {
    let bytes = picture
        .clone()
        .panels([Panel::view(View::Top)])
        .control_polygons(false)
        .legend(false)
        .to_png(400)
        .unwrap();
    let image = tiny_skia::Pixmap::decode_png(&bytes).unwrap();
    let pixels = image.pixels().iter().map(|p| [p.red(), p.green(), p.blue()]).collect();
    (image.width() as usize, pixels)
}

fn middle((width, pixels): &(usize, Vec<[u8; 3]>)) -> [u8; 3] {
    // A little beside the middle, where no line of the surface runs.
    pixels[(pixels.len() / width / 2 + 7) * width + width / 2 + 9]
}

fn texts(picture: &Picture<'_>) -> Vec<String> {
    let svg = picture.to_svg().unwrap();
    let document = roxmltree::Document::parse(&svg).unwrap();
    document
        .descendants()
        .filter(|n| n.has_tag_name("text"))
        .filter_map(|n| n.text())
        .map(str::to_owned)
        .collect()
}

#[test]
fn the_curvature_of_a_sphere_is_one_colour_and_its_scale_ends_there() {
    for (radius, end) in [(2.0, "0.5"), (4e-9, "250000000"), (1e9, "10⁻⁹")] {
        let scene = scene(sphere(radius));
        for (which, words) in [
            (Curvature::Mean, "mean curvature"),
            (Curvature::Maximum, "larger principal curvature"),
            (Curvature::Minimum, "smaller principal curvature"),
        ] {
            let picture = Picture::of(&scene).faces(Faces::Curvature(which));
            let said = texts(&picture);
            // It is the same all over, and that is said.
            let whole = [format!("{words}: {end}/mm everywhere"), format!("{words}: −{end}/mm everywhere")];
            assert!(said.iter().any(|t| whole.contains(t)), "{words}: {said:?}");
            assert!(
                said.iter().any(|t| t == end) && said.iter().any(|t| *t == format!("−{end}")),
                "{said:?}"
            );
            let [r, g, b] = middle(&pixels(&picture));
            // One end of the map; which one, the sense of the normal says.
            assert!(r.abs_diff(b) > 100 && g > 50, "{radius}: {r} {g} {b}");
        }
        let gaussian = Picture::of(&scene).faces(Faces::Curvature(Curvature::Gaussian));
        let [r, _, b] = middle(&pixels(&gaussian));
        assert!(r > b, "the Gaussian curvature of a sphere is positive: vermilion");
        assert!(
            texts(&gaussian)
                .iter()
                .any(|t| t.starts_with("Gaussian curvature: ") && t.ends_with("/mm² everywhere"))
        );
    }
    let saddle = scene(graph(3.0, |x, y| x * y));
    let said = texts(&Picture::of(&saddle).faces(Faces::Curvature(Curvature::Gaussian)));
    assert!(said.iter().any(|t| t == "Gaussian curvature in 1/mm²"), "{said:?}");
    let [r, _, b] = middle(&pixels(&Picture::of(&saddle).faces(Faces::Curvature(Curvature::Gaussian))));
    assert!(b > r, "that of a saddle is negative: blue");
    // Flat all over: the middle of the map, and nothing but 0 at its scale.
    let flat = scene(graph(3.0, |_, _| 0.0));
    let picture = Picture::of(&flat).faces(Faces::Curvature(Curvature::Mean));
    let [r, g, b] = middle(&pixels(&picture));
    assert!(r > 200 && r.abs_diff(g) < 12 && r.abs_diff(b) < 12, "{r} {g} {b}");
}

#[test]
fn the_deviation_of_a_lifted_sheet_is_its_height() {
    for (side, end) in [(3.0, "0.3"), (3e-8, "3·10⁻⁹"), (3e8, "30000000")] {
        let before = scene(graph(side, |_, _| 0.0));
        for by in [0.1, -0.1] {
            let after = scene(graph(side, |_, _| by));
            let picture = Picture::of(&after).before(&before).draw_before(false).faces(Faces::Deviation);
            let said = texts(&picture);
            let end = end.to_owned();
            let sign = if by < 0.0 { "−" } else { "" };
            let even = format!("distance from before: {sign}{end} mm everywhere");
            assert!(said.contains(&even), "{even}: {said:?}");
            assert!(said.contains(&end), "{end}: {said:?}");
            let [r, _, b] = middle(&pixels(&picture));
            assert!(r.abs_diff(b) > 100, "{side} {by}: {r} {b}");
        }
        let color = |by: f64| {
            let after = scene(graph(side, |_, _| by));
            middle(&pixels(&Picture::of(&after).before(&before).draw_before(false).faces(Faces::Deviation)))
        };
        let ([r, _, b], [s, _, c]) = (color(0.1), color(-0.1));
        assert_eq!((r > b), (s < c), "above and below have different colours");
    }
    // What is as it was is white.
    let same = scene(graph(3.0, |x, _| x * x));
    let [r, _, b] = middle(&pixels(&Picture::of(&same).before(&same).faces(Faces::Deviation)));
    assert!(r.abs_diff(b) < 12);
}

#[test]
fn a_zebra_has_as_many_stripes_as_the_normal_turns() {
    // A half cylinder seen from above: along y its normal turns by 180 degrees and the mirrored ray by 360, which is 24 stripes twice.
    let arc =
        Curve::arc(Point::new(0.0, -1.0, 0.0), Point::origin(), -Vector::x(), std::f64::consts::PI).unwrap();
    let cylinder = Surface::extrusion(&arc, Vector::x() * 2.0).unwrap();
    let scene = scene(cylinder);
    let (width, pixels) = pixels(&Picture::of(&scene).faces(Faces::Zebra));
    let column: Vec<u16> = (0..pixels.len() / width)
        .map(|row| pixels[row * width + width / 2 + 9])
        .filter(|p| *p != [255, 255, 255])
        .map(|[r, g, b]| u16::from(r) + u16::from(g) + u16::from(b))
        .collect();
    let mut changes = 0;
    let mut light = column[0] > 500;
    for tone in &column {
        // Only well beyond the middle, so that soft edges and lines do not count twice.
        if light && *tone < 330 || !light && *tone > 620 {
            changes += 1;
            light = !light;
        }
    }
    // The outermost are too thin to be seen.
    assert!((40..=48).contains(&changes), "{changes} of {column:?}");
}

#[test]
fn what_cannot_be_painted_is_said_and_shaded() {
    let mesh =
        Mesh::new(vec![Point::origin(), Point::new(1.0, 0.0, 0.0), Point::new(0.0, 1.0, 0.0)], &[[0, 1, 2]])
            .unwrap();
    let mut scene = Scene::new();
    scene.add(Object::new("m", mesh.clone().into())).unwrap();
    let said = texts(&Picture::of(&scene).faces(Faces::Curvature(Curvature::Mean)));
    assert!(said.iter().any(|t| t.contains("\"m\" is a mesh, which has no curvature")), "{said:?}");
    // Of a mesh with the same points, how far each has moved.
    let mut before = Scene::new();
    let lower =
        Mesh::new(mesh.points().iter().map(|p| p - Vector::z() * 0.25).collect(), &[[0, 1, 2]]).unwrap();
    before.add(Object::new("m", lower.into())).unwrap();
    let picture = Picture::of(&scene).before(&before).draw_before(false).faces(Faces::Deviation);
    assert!(texts(&picture).iter().any(|t| t == "0.25"), "{:?}", texts(&picture));
    let _ = picture.faces(Faces::Zebra).to_png(200).unwrap();
}

#[test]
fn panels_of_one_scene_show_what_each_says_with_one_scale_a_kind() {
    let mut scene = scene(sphere(2.0));
    let small: Vec<Point> = sphere(0.5).points().iter().map(|p| p + Vector::x() * 4.0).collect();
    let small = Surface::build(
        sphere(0.5).u().clone(),
        sphere(0.5).v().clone(),
        small,
        sphere(0.5).weights().map(<[f64]>::to_vec),
    )
    .unwrap();
    scene.add(Object::new("t", small.into())).unwrap();
    let mean = Faces::Curvature(Curvature::Mean);
    let panels = [
        Panel::view(View::Top).objects(["s"]).faces(mean),
        Panel::view(View::Top).objects(["t"]).faces(mean),
        Panel::view(View::Top).faces(Faces::Zebra),
    ];
    let said = texts(&Picture::of(&scene).panels(panels));
    // That of the smaller sphere.
    assert_eq!(said.iter().filter(|t| *t == "2").count(), 1, "{said:?}");
    assert_eq!(said.iter().filter(|t| t.contains("mean curvature")).count(), 1, "{said:?}");
}

/// Of a few values beyond the ends of the scale the largest is told, so that it is the one that reports tell.
#[test]
fn a_scale_tells_the_largest_value_beyond_its_ends() {
    let bump = |x: f64, y: f64| if x.abs() < 0.06 && y.abs() < 0.06 { 0.5 } else { 0.01 };
    let bent = scene(graph(3.0, bump));
    let curvature = Faces::Curvature(Curvature::Maximum);
    let said = texts(&Picture::of(&bent).faces(curvature));
    let told = |prefix: &str| said.iter().find(|text| text.starts_with(prefix)).cloned().unwrap();
    let title = told("larger principal curvature in 1/mm, the least −");
    let [most, end] =
        [title.clone(), told("≥ ")].map(|text| text.rsplit(' ').next().unwrap().parse::<f64>().unwrap());
    assert!(title.contains(", the largest ") && most > 1.05 * end, "{said:?}");
    // On a narrow page it goes on in the next line, and nothing of it is lost.
    let said = texts(&Picture::of(&bent).faces(curvature).width(100.0)).join(" ");
    assert!(said.contains(&title), "{said}");
}

/// A map of distances ends where the furthest is, however small the part is that has moved: nothing of it is cut off, and what has not moved is white.
#[test]
fn a_map_of_distances_ends_at_the_furthest() {
    for half in [0.06, 0.3] {
        let bump = |x: f64, y: f64| if x.abs() < half && y.abs() < half { 0.5 } else { 1e-15 * x };
        let (before, after) = (scene(graph(3.0, |_, _| 0.0)), scene(graph(3.0, bump)));
        let said = texts(&Picture::of(&after).before(&before).draw_before(false).faces(Faces::Deviation));
        assert!(said.iter().all(|text| !text.starts_with(['≤', '≥'])), "{said:?}");
        let most: Vec<f64> = said.iter().filter_map(|text| text.parse().ok()).filter(|x| *x > 0.0).collect();
        assert!(most.len() == 1 && (0.5..=1.5).contains(&most[0]), "{half}: {said:?}");
        let (_, pixels) =
            pixels(&Picture::of(&after).before(&before).draw_before(false).faces(Faces::Deviation));
        let coloured = |[r, g, b]: &&[u8; 3]| r.abs_diff(*b) > 60 || g.abs_diff(*b) > 60;
        let share = pixels.iter().filter(coloured).count() as f64 / pixels.len() as f64;
        assert!(share > 1e-3 && share < 3.0 * (2.0 * half + 0.2).powi(2), "{half}: {share}");
    }
}

/// Two halves of a bump, one of them with its normal below: the sign of its curvature is the other one, and the legend says whose. The Gaussian curvature has the
/// same sign from either side, and what meets at a sharp edge goes on in nothing.
#[test]
fn a_normal_that_points_to_the_other_side_is_told() {
    let half = |turn: bool, tilt: f64| {
        let space = || Space::clamped_uniform(2, 6).unwrap();
        let at = |k: usize| {
            let (x, y) = (space().greville(k / 6) / 4.0, space().greville(k % 6) / 4.0);
            Point::new(x, y, -0.3 * x * x - tilt * x)
        };
        let points: Vec<Point> = (0..36).map(at).collect();
        let half = Surface::new(space(), space(), points.clone()).unwrap();
        if !turn {
            return half;
        }
        let mirrored = points.iter().map(|p| Point::new(-p.x, p.y, p.z)).collect();
        Surface::new(space(), space(), mirrored).unwrap()
    };
    let said = |other: Surface, which: Curvature| {
        let mut scene = scene(half(false, 0.0));
        scene.add(Object::new("far side", other.into())).unwrap();
        texts(&Picture::of(&scene).faces(Faces::Curvature(which))).join(" ")
    };
    for which in [Curvature::Mean, Curvature::Maximum, Curvature::Minimum] {
        let told = said(half(true, 0.0), which);
        assert!(told.contains("own normal: of \"far side\" that points to the other side"), "{told}");
    }
    let turned = half(true, 0.0).reverse(Direction::U).unwrap();
    assert!(!said(turned, Curvature::Mean).contains("own normal"));
    assert!(!said(half(true, 0.0), Curvature::Gaussian).contains("own normal"));
    assert!(!said(half(true, 3.0), Curvature::Mean).contains("own normal"));
}

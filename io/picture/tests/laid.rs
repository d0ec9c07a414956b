//! Surfaces of plug-ins: limit surfaces of cages are drawn and painted as surfaces, by their own derivatives.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use loftsman_kernel::error::Result;
use loftsman_kernel::plugin::{CustomShape, Declaration, DeclaredShape, ParameterError, Parameters};
use loftsman_kernel::scene::{Object, Scene, Unit};
use loftsman_kernel::shape::{Derivative, Domain, Location, Shape, Stencil};
use loftsman_kernel::spline::{Curve, Surface};
use loftsman_kernel::{Point, Vector};
use loftsman_picture::{Curvature, Faces, Panel, Picture, View};
use loftsman_subdivision::doo_sabin::DooSabinSurface;
use loftsman_subdivision::{Cage, SubdivisionSurface, catmull_clark};

use crate::drawn::Drawn;

fn scene(shape: impl Into<CustomShape>) -> Scene {
    let mut scene = Scene::new();
    scene.unit = Unit::Millimetre;
    let shape: CustomShape = shape.into();
    scene.add(Object::new("s", shape.into())).unwrap();
    scene
}

fn limit(cage: Cage) -> Scene {
    scene(SubdivisionSurface::new(cage).unwrap())
}

const CUBE: [[usize; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

fn cube() -> Cage {
    let corner =
        |k: usize| Point::new((k & 1) as f64 - 0.5, (k >> 1 & 1) as f64 - 0.5, (k >> 2) as f64 - 0.5);
    Cage::new((0..8).map(corner).collect(), &CUBE).unwrap()
}

/// A cage whose limit is nearly the sphere of a radius: vertices of a refined cube, so far out that their limits are on it.
fn ball(radius: f64) -> Cage {
    let mut cage = cube();
    for _ in 0..2 {
        cage = catmull_clark::refine(&cage).unwrap();
    }
    for p in cage.points_mut() {
        *p = Point::from(p.coords.normalize() * radius);
    }
    for _ in 0..20 {
        let limits = catmull_clark::limit_points(&cage).unwrap();
        for (p, limit) in cage.points_mut().iter_mut().zip(limits) {
            *p += limit.coords.normalize() * radius - limit.coords;
        }
    }
    cage
}

/// A prism of many sides whose rims are sharp for ever: a cylinder between two planes, its axis along z.
fn drum(sides: usize) -> Cage {
    let ring = |z: f64| {
        (0..sides).map(move |k| {
            let (s, c) = (std::f64::consts::TAU * k as f64 / sides as f64).sin_cos();
            Point::new(c, s, z)
        })
    };
    let points = ring(-0.5).chain(ring(0.0)).chain(ring(0.5)).collect();
    let mut faces: Vec<Vec<usize>> = Vec::new();
    for level in 0..2 {
        let at = |k: usize| level * sides + k % sides;
        faces.extend((0..sides).map(|k| vec![at(k), at(k + 1), at(k + 1) + sides, at(k) + sides]));
    }
    faces.push((0..sides).rev().collect());
    faces.push((2 * sides..3 * sides).collect());
    let mut cage = Cage::new(points, &faces).unwrap();
    for k in 0..sides {
        for level in [0, 2 * sides] {
            cage = cage.with_crease(level + k, level + (k + 1) % sides, f64::INFINITY).unwrap();
        }
    }
    cage
}

/// Triangles round a vertex, in the plane z = 0 but for that vertex: flat with an extraordinary point.
fn tent(height: f64) -> Cage {
    let mut points = vec![Point::new(0.0, 0.0, height)];
    let at = |k: usize, radius: f64| {
        let (s, c) = (std::f64::consts::TAU * k as f64 / 10.0).sin_cos();
        Point::new(radius * c, radius * s, 0.0)
    };
    points.extend((0..10).map(|k| at(k, if k % 2 == 0 { 1.0 } else { 1.3 })));
    points.extend((0..10).map(|k| at(k, 2.2)));
    let mut faces: Vec<[usize; 4]> =
        (0..5).map(|k| [0, 1 + 2 * k, 2 + 2 * k, 1 + (2 * k + 2) % 10]).collect();
    faces.extend((0..10).map(|k| [1 + k, 11 + k, 11 + (k + 1) % 10, 1 + (k + 1) % 10]));
    Cage::new(points, &faces).unwrap()
}

fn texts(picture: &Picture<'_>) -> Vec<String> {
    let svg = picture.to_svg().unwrap();
    let document = roxmltree::Document::parse(&svg).unwrap();
    let texts = document.descendants().filter(|n| n.has_tag_name("text"));
    texts.filter_map(|n| n.text()).map(str::to_owned).collect()
}

/// The faces of a picture alone, without a line on them: red, green and blue by rows; nothing where there is none.
fn faces(picture: &Picture<'_>, view: View) -> Vec<Vec<Option<[u8; 3]>>> {
    let svg = picture.clone().panels([Panel::view(view)]).control_polygons(false).to_svg().unwrap();
    let document = roxmltree::Document::parse(&svg).unwrap();
    let image = document.descendants().find(|n| n.attribute("class") == Some("shading")).unwrap();
    let href = image.attributes().find(|a| a.name() == "href").unwrap().value();
    let bytes = STANDARD.decode(href.strip_prefix("data:image/png;base64,").unwrap()).unwrap();
    let image = tiny_skia::Pixmap::decode_png(&bytes).unwrap();
    let color = |p: &tiny_skia::PremultipliedColorU8| (p.alpha() > 0).then(|| [p.red(), p.green(), p.blue()]);
    image.pixels().chunks(image.width() as usize).map(|row| row.iter().map(color).collect()).collect()
}

/// The data of the paths of a class.
fn paths(svg: &str, class: &str) -> Vec<String> {
    let document = roxmltree::Document::parse(svg).unwrap();
    let paths = document.descendants().filter(|n| n.attribute("class") == Some(class));
    paths.filter_map(|n| n.attribute("d")).map(str::to_owned).collect()
}

/// Where the map ends: the largest number that the legend says, whether values are beyond it or not.
fn end(said: &[String]) -> f64 {
    let number = |text: &String| text.trim_start_matches("≥ ").parse().ok();
    said.iter().filter_map(number).fold(0.0, f64::max)
}

fn painted(scene: &Scene, which: Curvature) -> Picture<'_> {
    Picture::of(scene).faces(Faces::Curvature(which))
}

#[test]
fn a_ball_is_painted_by_its_curvature() {
    for (which, power) in [(Curvature::Mean, 1), (Curvature::Maximum, 1), (Curvature::Gaussian, 2)] {
        let scene = limit(ball(0.5));
        let picture = painted(&scene, which);
        let said = texts(&picture);
        assert!(!said.iter().any(|text| text.contains("is a mesh") || text.contains("NaN")), "{said:?}");
        // 1/0.5, or its square; rounded up to two digits.
        let known = 2_f64.powi(power);
        assert!((known..1.15 * known).contains(&end(&said)), "{which:?}: {said:?}");
        // From above, the middle is regular: the colour of -2/mm, or 4/mm², whose share of the map says the legend's end.
        let rows = faces(&picture, View::Top);
        let [r, _, b] = rows[rows.len() / 2][rows[0].len() / 2].unwrap();
        assert!(if power == 2 { r > b + 100 } else { b > r + 100 }, "{which:?}: {r} {b}");
    }
    // Of any size; some 1/mm are 1e9 of them on a ball a billion times smaller.
    for size in [1e-9, 1e9] {
        let said = texts(&painted(&limit(ball(size)), Curvature::Mean));
        let words = if size < 1.0 { "1.1·10⁹" } else { "1.1·10⁻⁹" };
        let plain = if size < 1.0 { "1·10⁹" } else { "10⁻⁹" };
        let has = said.iter().any(|text| {
            let number = text.trim_start_matches('−');
            number == words
                || number == plain
                || (size < 1.0 && number.parse::<f64>().is_ok_and(|x| (1e9..1.15e9).contains(&x)))
        });
        assert!(has, "{size}: {said:?}");
    }
}

#[test]
fn a_plane_has_no_curvature_at_its_extraordinary_points_either() {
    for which in [Curvature::Mean, Curvature::Gaussian, Curvature::Minimum] {
        let said = texts(&painted(&limit(tent(0.0)), which));
        assert!(
            said.iter().any(|text| text.contains("curvature: 0/mm") && text.ends_with(" everywhere")),
            "{said:?}"
        );
    }
}

#[test]
fn colours_do_not_blend_over_a_crease_that_never_ends() {
    let scene = limit(drum(24));
    let picture = painted(&scene, Curvature::Mean);
    let said = texts(&picture);
    // Half the curvature of the ring, the uniform cubic spline round 24 vertices of a unit circle.
    assert!((0.5..0.54).contains(&end(&said)), "{said:?}");
    let share = |[r, _, b]: [u8; 3]| (f64::from(b) - f64::from(r)) / f64::from(b.max(r));
    // The flat end is white up to its rim.
    let top = faces(&picture, View::Top);
    // The outermost cells may show the side, edge on: those within a third of a millimetre, a sixth of a triangle, at the ends of rows that end
    // steeply.
    let inside = |rows: &[Vec<Option<[u8; 3]>>]| -> Vec<[u8; 3]> {
        let steep = &rows[rows.len() / 4..3 * rows.len() / 4];
        let there = steep.iter().map(|row| row.iter().flatten().copied().collect::<Vec<_>>());
        there.flat_map(|row| row[3..row.len() - 3].to_vec()).collect()
    };
    let all: Vec<f64> = inside(&top).into_iter().map(share).collect();
    let coloured = all.iter().filter(|share| share.abs() > 0.02).count();
    assert!(all.len() > 10_000 && coloured == 0, "{coloured} of {}", all.len());
    // The side has one colour up to both of its rims, seen from the front along its middle.
    let front = faces(&picture, View::Front);
    let middle = front[0].len() / 2 + 3;
    let column: Vec<f64> = front.iter().filter_map(|row| row[middle]).map(share).collect();
    assert!(column.len() > 100);
    assert!(
        column.iter().all(|share| *share > 0.6 && (share - column[column.len() / 2]).abs() < 0.03),
        "{column:?}"
    );
    // Stripes do not blend either: a flat end mirrors one place of the world.
    let zebra = faces(&Picture::of(&scene).faces(Faces::Zebra), View::Top);
    let tones: std::collections::BTreeSet<[u8; 3]> = inside(&zebra).into_iter().collect();
    assert_eq!(tones.len(), 1, "{tones:?}");
}

/// The product of both curvatures is rounding where one of them is.
#[test]
fn what_bends_one_way_only_has_no_gaussian_curvature() {
    let said = texts(&painted(&limit(drum(24)), Curvature::Gaussian));
    let none = |text: &String| text.contains("curvature: 0/mm") && text.ends_with(" everywhere");
    assert!(said.iter().any(none), "{said:?}");
}

#[test]
fn distances_are_those_of_the_limit() {
    let flat = limit(tent(0.0));
    // Half the height of a vertex with five edges in a plane: 5/(5+5).
    for height in [1.0, -1.0, 1e-3] {
        let after = limit(tent(height));
        let picture = Picture::of(&after).before(&flat).draw_before(false).faces(Faces::Deviation);
        let said = texts(&picture);
        assert!((end(&said) - 0.5 * height.abs()).abs() < 0.011 * height.abs(), "{height}: {said:?}");
        let rows = faces(&picture, View::Top);
        let strongest = |k: usize, other: usize| {
            let pixels = rows.iter().flatten().flatten();
            pixels.map(|p| i32::from(p[k]) - i32::from(p[other])).max().unwrap()
        };
        // Vermilion along the normal, blue against it, and only one of them.
        let [red, blue] = [strongest(0, 2), strongest(2, 0)];
        assert!(if height > 0.0 { red > 100 && blue < 12 } else { blue > 100 && red < 12 }, "{red} {blue}");
    }
    // A surface moved along its normal everywhere is as far everywhere, to rounding.
    for by in [0.25, -0.125] {
        let mut cage = tent(0.0);
        cage.points_mut().iter_mut().for_each(|p| *p += Vector::z() * by);
        let said = texts(&Picture::of(&limit(cage)).before(&flat).draw_before(false).faces(Faces::Deviation));
        let sign = if by < 0.0 { "−" } else { "" };
        let even = format!("distance from before: {sign}{} mm everywhere", f64::abs(by));
        assert!(said.contains(&even), "{even}: {said:?}");
    }
    // A ball blown up about its middle is as far as its radius grew: the nearest places, not the same ones.
    let (small, large) = (limit(ball(1.0)), limit(ball(1.25)));
    let said = texts(&Picture::of(&large).before(&small).draw_before(false).faces(Faces::Deviation));
    assert!((0.25..0.2601).contains(&end(&said)), "{said:?}");
    // What is as it was is white, and what was not there is said.
    let said = texts(&Picture::of(&small).before(&small).faces(Faces::Deviation));
    assert!(said.iter().any(|text| text == "distance from before: 0 mm everywhere"), "{said:?}");
    let said = texts(&Picture::of(&small).before(&Scene::new()).faces(Faces::Deviation));
    assert!(said.iter().any(|text| text.contains("has no state before")), "{said:?}");
}

/// What has its foot on a sharp edge or at a sharp corner is outside where all of what meets there has it outside.
#[test]
fn what_is_moved_outwards_at_something_sharp_is_outside() {
    let edge = |cage: Cage| cage.with_crease(6, 7, f64::INFINITY).unwrap();
    let corner = |cage: Cage| cage.with_corner(7, f64::INFINITY).unwrap();
    for sharp in [&edge as &dyn Fn(Cage) -> Cage, &corner] {
        let mut moved = cube();
        for v in [6, 7] {
            moved.points_mut()[v] += Vector::new(if v == 7 { 0.3 } else { -0.3 }, 0.5, 0.4);
        }
        let (before, after) = (limit(sharp(cube())), limit(sharp(moved)));
        let picture = Picture::of(&after).before(&before).draw_before(false).faces(Faces::Deviation);
        for view in [View::Top, View::From(Vector::new(0.5, 2.0, 1.0))] {
            let rows = faces(&picture, view);
            let blue =
                rows.iter().flatten().flatten().filter(|p| i32::from(p[2]) - i32::from(p[0]) > 20).count();
            let red =
                rows.iter().flatten().flatten().filter(|p| i32::from(p[0]) - i32::from(p[2]) > 60).count();
            assert!(red > 1000 && blue == 0, "{view:?}: {red} {blue}");
        }
    }
}

#[test]
fn lines_are_the_borders_of_faces_and_no_triangles() {
    let after = limit(cube());
    let mut taller = cube();
    taller.points_mut().iter_mut().filter(|p| p.z > 0.0).for_each(|p| p.z += 0.5);
    let before = limit(taller);
    let picture = Picture::of(&after)
        .before(&before)
        .control_polygons(false)
        .panels([Panel::view(View::From(Vector::new(1.0, -2.2, 0.9)))]);
    let svg = picture.drawn();
    assert!(paths(&svg, "mesh").is_empty() && paths(&svg, "crease").is_empty(), "a surface is no mesh");
    // Twelve borders of six faces, each of some chords; of triangles there are hundreds.
    let chords = |class: &str| {
        paths(&svg, class).iter().map(|d| d.matches(['L', 'l', 'H', 'h', 'V', 'v']).count()).sum::<usize>()
    };
    let starts =
        |class: &str| paths(&svg, class).iter().map(|d| d.matches(['M', 'm']).count()).sum::<usize>();
    assert!(starts("inner") > 0 && starts("inner") <= 12, "{}", starts("inner"));
    assert!(starts("surface") > 0 && starts("surface") <= 24, "{}", starts("surface"));
    // An outline, and no line where a closed surface would end.
    assert!(starts("outline") > 0 && paths(&svg, "border").is_empty());
    assert!((24..240).contains(&chords("inner")) && (24..480).contains(&chords("surface")));
    assert_eq!(svg, picture.drawn(), "the same bytes again");
}

#[test]
fn a_doo_sabin_surface_is_painted_too() {
    let scene = scene(DooSabinSurface::new(cube()).unwrap());
    for which in [Curvature::Mean, Curvature::Gaussian] {
        let picture = painted(&scene, which);
        let said = texts(&picture);
        assert!(!said.iter().any(|text| text.contains("is a mesh") || text.contains("NaN")), "{said:?}");
        assert!(end(&said) > 1.0, "{said:?}");
        // In the middles of the cage's faces, by symmetry, it bends alike in all directions, away from its normal.
        let rows = faces(&picture, View::Top);
        let [r, _, b] = rows[rows.len() / 2 + 2][rows[0].len() / 2 + 2].unwrap();
        assert!(if which == Curvature::Gaussian { r > b } else { b > r }, "{which:?}: {r} {b}");
    }
    assert!(paths(&Picture::of(&scene).drawn(), "mesh").is_empty());
}

/// A surface of which nobody knows that it is a spline: sampled like any shape.
#[derive(Debug, Clone)]
struct Hidden(Surface);

impl Shape for Hidden {
    fn control_vertices(&self) -> &[Point] {
        self.0.points()
    }

    fn control_vertices_mut(&mut self) -> &mut [Point] {
        self.0.control_vertices_mut()
    }

    fn stencil(&self, at: Location, derivative: Derivative) -> Result<Stencil> {
        self.0.stencil(at, derivative)
    }

    fn domain(&self) -> Domain {
        self.0.domain()
    }

    fn boxed(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }
}

impl DeclaredShape for Hidden {
    const DECLARATION: Declaration = Declaration { name: "hidden", help: "a surface", fields: &[] };

    fn fields(&self) -> Parameters {
        Parameters::empty("")
    }

    fn from_parameters(fields: &Parameters) -> std::result::Result<Self, ParameterError> {
        Err(fields.error("", "it has none"))
    }
}

#[test]
fn any_shape_is_painted_by_its_derivatives() {
    let half = Curve::elliptic_arc(
        Point::origin(),
        -Vector::z() * 2.0,
        Vector::x() * 2.0,
        0.0,
        std::f64::consts::PI,
    );
    let sphere =
        Surface::revolution(&half.unwrap(), Point::origin(), Vector::z(), std::f64::consts::TAU).unwrap();
    let scene = scene(Hidden(sphere));
    let said = texts(&painted(&scene, Curvature::Mean));
    assert!(said.iter().any(|text| text == "mean curvature: −0.5/mm everywhere"), "{said:?}");
    let said = texts(&painted(&scene, Curvature::Gaussian));
    assert!(said.iter().any(|text| text == "Gaussian curvature: 0.25/mm² everywhere"), "{said:?}");
    // Its triangles are not drawn, for it is smooth.
    let svg = Picture::of(&scene).drawn();
    assert!(paths(&svg, "inner").is_empty() && paths(&svg, "crease").is_empty());
}

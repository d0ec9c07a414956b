//! Writes pictures of what the crate draws into a folder, to be looked at:
//! `cargo run -p loftsman-picture --example gallery -- FOLDER`.

use std::error::Error;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use loftsman_kernel::mesh::{Cloud, Mesh, Polyline};
use loftsman_kernel::plugin::{Mark, MarkKind};
use loftsman_kernel::scene::{Geometry, Object, Scene, Unit};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use loftsman_picture::{Against, Beads, Combs, Panel, Picture, Theme, View};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("which folder?")?);
    std::fs::create_dir_all(&folder)?;
    section(&folder)?;
    theory(&folder)?;
    surface(&folder)?;
    mixed(&folder)
}

fn write(folder: &Path, name: &str, picture: &Picture<'_>) -> Result<(), Box<dyn Error>> {
    std::fs::write(folder.join(format!("{name}.svg")), picture.to_svg()?)?;
    std::fs::write(folder.join(format!("{name}.png")), picture.to_png(1600)?)?;
    Ok(())
}

/// A section like a blade's: before and after one control vertex was pulled, with marks and combs.
fn section(folder: &Path) -> Result<(), Box<dyn Error>> {
    let n = 24;
    let net: Vec<Point> = (0..n)
        .map(|i| f64::from(i) / f64::from(n - 1) * TAU)
        .map(|a| {
            let x = 0.5 + 0.5 * a.cos();
            let thick = 0.6
                * (0.2969 * x.sqrt() - 0.126 * x - 0.3516 * x * x + 0.2843 * x.powi(3) - 0.1015 * x.powi(4));
            Point::new(x, if a < TAU / 2.0 { 1.15 * thick } else { -0.85 * thick } / 0.2, 0.0)
        })
        .collect();
    let space = Space::clamped_uniform(3, net.len())?;
    let old = Curve::new(space.clone(), net.clone())?;
    let mut moved = net.clone();
    for (i, by) in [(6, 0.03), (7, 0.07), (8, 0.07), (9, 0.03)] {
        moved[i].y += by;
    }
    let new = Curve::new(space, moved)?;
    let points =
        (0..=60).map(|i| old.point(old.domain().1 * f64::from(i) / 60.0)).collect::<Result<_, _>>()?;
    let measured = Object::new("measured points", Cloud { points }.into());
    let scene = |curve: &Curve| -> Result<Scene, loftsman_kernel::Error> {
        let mut scene = Scene::new();
        scene.add(Object::new("section", curve.into()))?;
        scene.add(measured.clone())?;
        Ok(scene)
    };
    let (before, after) = (scene(&old)?, scene(&new)?);
    let (u, nose, tail) = (6.5, 10.5, old.domain().1);
    let jet = |u: f64| {
        Ok::<_, loftsman_kernel::Error>((new.point(u)?, new.derivative(u, 1)?, new.derivative(u, 2)?))
    };
    let mark = |kind, u: f64, vector: Option<Vector>, label: &str| {
        Ok::<_, loftsman_kernel::Error>(Mark {
            object: "section".into(),
            kind,
            position: new.point(u)?,
            before: old.point(u)?,
            vector,
            label: label.into(),
            spot: None,
            track: None,
        })
    };
    let (_, first, second) = jet(nose)?;
    let tangent = first.normalize();
    let kappa = (second - tangent * tangent.dot(&second)) / first.norm_squared();
    let mut marks = vec![
        mark(MarkKind::Moved, u, None, "position at 6.5")?,
        mark(MarkKind::Kept, nose, None, "position at 10.5")?,
        mark(MarkKind::Direction, nose, Some(first), "derivative 1 at 10.5")?,
        mark(MarkKind::Curvature, nose, Some(kappa), "curvature at 10.5")?,
        mark(MarkKind::Kept, tail, None, "position at 21")?,
    ];
    for i in [0, n as usize - 1] {
        let (position, label) = (net[i], format!("vertex {i}"));
        let object = "section".into();
        marks.push(Mark {
            object,
            kind: MarkKind::Locked,
            position,
            before: position,
            vector: None,
            label,
            spot: None,
            track: None,
        });
    }
    let picture = Picture::of(&after).before(&before).marks(&marks);
    write(folder, "section", &picture.clone().title("Blade section: the upper side pushed out"))?;
    let comb = picture.combs(Combs::Automatic).beads(Beads::Knots).control_polygons(false);
    write(folder, "section-comb", &comb.clone().title("Blade section with curvature combs"))?;
    let profile = [Panel::view(View::Automatic), Panel::profile(Against::ArcLength)];
    write(
        folder,
        "section-profile",
        &comb.clone().title("Blade section with its curvature").panels(profile),
    )?;
    write(folder, "section-dark", &comb.theme(Theme::Dark).title("Dark"))
}

/// The cubic of twelve vertices with the middle point moved by (0, 1, 0).
fn theory(folder: &Path) -> Result<(), Box<dyn Error>> {
    let heights = [0.0, 1.0, 0.5, -0.5, 0.8, 1.2, 0.2, -0.6, 0.0, 1.0, 0.7, 0.0];
    let net: Vec<Point> = heights.iter().enumerate().map(|(i, h)| Point::new(i as f64, *h, 0.0)).collect();
    let space = Space::clamped_uniform(3, 12)?;
    let old = Curve::new(space.clone(), net.clone())?;
    let mut moved = net;
    for (i, by) in
        (4..8).zip([0.0452830188679245, 1.0415094339622641, 1.0415094339622641, 0.0452830188679245])
    {
        moved[i].y += by;
    }
    let new = Curve::new(space, moved)?;
    let (mut before, mut after) = (Scene::new(), Scene::new());
    before.add(Object::new("cubic", (&old).into()))?;
    after.add(Object::new("cubic", (&new).into()))?;
    let marks = [Mark {
        object: "cubic".into(),
        kind: MarkKind::Moved,
        position: new.point(4.5)?,
        before: old.point(4.5)?,
        vector: None,
        label: "position at 4.5".into(),
        spot: None,
        track: None,
    }];
    let picture = Picture::of(&after).before(&before).marks(&marks).beads(Beads::Knots);
    write(
        folder,
        "cubic",
        &picture.clone().title("Twelve vertices, the point at u = 4.5 moved by (0, 1, 0)"),
    )?;
    write(folder, "cubic-comb", &picture.combs(Combs::Automatic))
}

/// A wavy surface and a torus, isometrically.
fn surface(folder: &Path) -> Result<(), Box<dyn Error>> {
    let wave = |i: usize, j: usize| ((i * 5 + j * 3) as f64 * 0.7).sin() * 0.6;
    let net = (0..7).flat_map(|i| (0..9).map(move |j| Point::new(i as f64, j as f64, wave(i, j)))).collect();
    let sheet = Surface::new(Space::clamped_uniform(3, 7)?, Space::clamped_uniform(3, 9)?, net)?;
    let ring = |i: usize, j: usize| {
        let (a, b) = (i as f64 / 12.0 * TAU, j as f64 / 8.0 * TAU);
        let r = 3.0 + 1.2 * b.cos();
        Point::new(10.5 + r * a.cos(), 4.0 + r * a.sin(), 1.2 * b.sin())
    };
    let net = (0..12).flat_map(|i| (0..8).map(move |j| ring(i, j))).collect();
    let torus = Surface::new(Space::periodic_uniform(3, 12)?, Space::periodic_uniform(3, 8)?, net)?;
    let mut scene = Scene::new();
    scene.unit = Unit::Millimetre;
    scene.add(Object::new("sheet", (&sheet).into()))?;
    scene.add(Object::new("torus", (&torus).into()))?;
    write(folder, "surfaces", &Picture::of(&scene).title("Surfaces").control_polygons(false))?;
    write(folder, "surfaces-nets", &Picture::of(&scene).title("Surfaces and their control nets"))?;
    write(folder, "surfaces-top", &Picture::of(&scene).view(View::Top).control_polygons(false))?;
    let views = [
        ("top", View::Top),
        ("perspective", View::Perspective),
        ("front", View::Front),
        ("right", View::Right),
    ];
    let panels = views.map(|(name, view)| Panel::view(view).caption(name));
    let sheet = Picture::of(&scene).title("Four views").control_polygons(false).panels(panels);
    write(folder, "surfaces-four", &sheet)?;
    // A line through the torus, one in the sheet, a mesh that cuts both, and points around.
    let skewer = vec![Point::new(-1.0, 9.0, -2.0), Point::new(15.0, -1.0, 2.5)];
    scene.add(Object::new("skewer", Polyline { points: skewer, closed: false }.into()))?;
    let along = (0..30).map(|i| sheet_point(&scene, f64::from(i) / 29.0)).collect::<Result<Vec<_>, _>>()?;
    let lies = Curve::new(Space::clamped_uniform(3, along.len())?, along)?;
    scene.add(Object::new("in the sheet", (&lies).into()))?;
    let wall = [[5.0, -1.0, -2.0], [5.0, 9.0, -2.0], [5.0, 9.0, 2.0], [5.0, -1.0, 2.0]].map(Point::from);
    scene.add(Object::new("wall", Mesh::new(wall.to_vec(), &[[0, 1, 2, 3]])?.into()))?;
    let scan = (0..600).map(f64::from);
    let scan = scan.map(|i| {
        Point::new(10.5 + 5.0 * (i * 0.61).sin(), 4.0 + 5.0 * (i * 1.7).cos(), 1.5 * (i * 2.9).sin())
    });
    scene.add(Object::new("scan", Cloud { points: scan.collect() }.into()))?;
    let through = Picture::of(&scene).title("Hidden lines").control_polygons(false);
    write(folder, "hidden", &through.clone())?;
    write(folder, "hidden-perspective", &through.clone().view(View::Perspective).theme(Theme::Dark))?;
    write(folder, "hidden-nets", &through.control_polygons(true).combs(Combs::Automatic))
}

fn sheet_point(scene: &Scene, t: f64) -> Result<Point, loftsman_kernel::Error> {
    let sheet = scene.surface("sheet")?;
    let ((_, u), (_, v)) = (sheet.u().domain(), sheet.v().domain());
    sheet.point(u * (0.1 + 0.8 * t), v * (0.5 + 0.4 * (9.0 * t).sin()))
}

/// One of each kind of object, with awkward names.
fn mixed(folder: &Path) -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::new();
    scene.unit = Unit::Metre;
    let corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
    let points = corners.map(|[x, y, z]| Point::new(f64::from(x), f64::from(y), f64::from(z))).to_vec();
    let faces = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
    scene.add(Object::new("box <&\"'>", Mesh::new(points, &faces)?.into()))?;
    let helix: Vec<Point> = (0..40)
        .map(|i| f64::from(i) * 0.4)
        .map(|a| Point::new(2.5 + 0.7 * a.cos(), 0.5 + 0.7 * a.sin(), a / 10.0))
        .collect();
    let degree = 5;
    let curve = Curve::new(Space::clamped_uniform(degree, helix.len())?, helix)?;
    scene.add(Object::new("Wendel – σπείρα", (&curve).into()))?;
    let w = 0.5_f64.sqrt();
    let circle = Curve::rational(
        Space::open(2, vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0])?,
        [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1], [1, 0]]
            .map(|[x, y]| Point::new(-1.2 + 0.6 * f64::from(x), 0.5, 0.6 + 0.6 * f64::from(y)))
            .to_vec(),
        [1.0, w, 1.0, w, 1.0, w, 1.0, w, 1.0].to_vec(),
    )?;
    scene.add(Object::new("circle", (&circle).into()))?;
    let star = (0..10)
        .map(|i| (f64::from(i) * TAU / 10.0, if i % 2 == 0 { 0.6 } else { 0.25 }))
        .map(|(a, r)| Point::new(0.5 + r * a.cos(), -1.2 + r * a.sin(), 0.0))
        .collect();
    scene.add(Object::new("star", Polyline { points: star, closed: true }.into()))?;
    let scan = (0..400)
        .map(f64::from)
        .map(|i| {
            Point::new(-1.2 + 0.5 * (i * 0.61).sin(), -1.2 + 0.5 * (i * 1.7).cos(), 0.4 * (i * 2.9).sin())
        })
        .collect();
    scene.add(Object::new("scan", Cloud { points: scan }.into()))?;
    scene.add(Object::new("group", Geometry::Group))?;
    let picture = Picture::of(&scene).title("One of each").combs(Combs::Automatic);
    write(folder, "mixed", &picture)
}

//! OBJ → ours → OBJ → ours is the first reading: names, counts, geometry to the last bit, unit and axis.

#![allow(clippy::unwrap_used, reason = "a test may stop at what should not be")]

use std::fmt::Write as _;

use loftsman_kernel::Point;
use loftsman_kernel::material::Material;
use loftsman_kernel::mesh::{Cloud, Mesh, Polyline};
use loftsman_kernel::plugin::{Chord, Fineness, Format, Memory, ReadOptions, UpChoice, WriteOptions};
use loftsman_kernel::scene::{Geometry, Layer, Object, Scene, Unit, Up};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_obj::Obj;
use loftsman_tessellation::Adaptive;
use proptest::prelude::*;

/// Numbers from -1 to 1, the same in every run (Knuth's MMIX generator).
struct Lcg(u64);

impl Lcg {
    fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

fn written(scene: &Scene, options: &WriteOptions<'_>) -> Memory {
    let mut file = Memory::new("s.obj", "");
    Obj.write(scene, &mut file, options).unwrap();
    file
}

fn read(file: &Memory) -> Scene {
    let (scene, report) = Obj.read(file, &ReadOptions::default()).unwrap();
    assert!(report.adds_up());
    scene
}

/// Names, geometry, materials, unit and axis; labels are left to the names that go out.
fn same(a: &Scene, b: &Scene) {
    assert_eq!((a.unit, a.up, a.objects().len()), (b.unit, b.up, b.objects().len()));
    for (a, b) in a.objects().iter().zip(b.objects()) {
        assert_eq!((a.name(), &a.materials, a.color), (b.name(), &b.materials, b.color));
        assert_eq!(a.geometry(), b.geometry(), "{}", a.name());
        let bits = |o: &Object| -> Vec<u64> {
            o.geometry().points().iter().flat_map(|p| [p.x, p.y, p.z]).map(f64::to_bits).collect()
        };
        assert_eq!(bits(a), bits(b), "{}", a.name());
    }
}

fn check(first: &Scene) {
    let tessellator = Adaptive::default();
    let fineness = Fineness { chord: Chord::Relative(0.05), angle: 0.8 };
    let options = WriteOptions {
        tessellator: Some(&tessellator),
        fineness,
        up: UpChoice::Keep,
        ..WriteOptions::default()
    };
    let file = written(first, &options);
    let second = read(&file);
    same(first, &second);
    let again = written(&second, &options);
    assert_eq!(String::from_utf8_lossy(&file.bytes), String::from_utf8_lossy(&again.bytes));
    assert_eq!(file.siblings, again.siblings);
}

fn space(random: &mut Lcg, degree: usize, kind: usize) -> Space {
    let mut at = 0.0;
    let inner = 1 + (random.next().abs() * 4.0) as usize;
    let mut rising = |count: usize| -> Vec<f64> {
        (0..count)
            .map(|_| {
                at += 0.1 + random.next().abs();
                at
            })
            .collect()
    };
    match kind % 4 {
        0 => Space::open(degree, rising(2 * degree + 2 + inner)).unwrap(),
        1 => Space::clamped(degree, &rising(2 + inner)).unwrap(),
        2 => Space::periodic(degree, rising(degree + 2 + inner)).unwrap(),
        _ => {
            // A repeated knot, as far as the degree allows it.
            let mut knots = rising(2 * degree + 2 + inner);
            for k in degree + 1..(2 * degree).min(degree + inner) {
                knots[k + 1] = knots[k];
            }
            knots.sort_by(f64::total_cmp);
            Space::open(degree, knots).unwrap()
        }
    }
}

fn spline_scene(seed: u64, degree: usize) -> Scene {
    let mut random = Lcg::new(seed);
    let mut scene = Scene::new();
    (scene.unit, scene.up) =
        if seed.is_multiple_of(2) { (Unit::Millimetre, Up::Z) } else { (Unit::Unknown, Up::Y) };
    let point = |random: &mut Lcg| Point::new(random.next(), 100.0 * random.next(), random.next() / 3.0);
    for kind in 0..4 {
        for rational in [false, true] {
            let around = space(&mut random, degree, kind);
            let n = around.len();
            let points: Vec<Point> = (0..n).map(|_| point(&mut random)).collect();
            let weights = rational.then(|| (0..n).map(|_| 0.3 + random.next().abs()).collect());
            let curve = Curve::build(around, points, weights).unwrap();
            scene.add(Object::new(format!("c{kind} {rational}"), curve.into())).unwrap();
            if degree > 7 {
                continue;
            }
            let (u, v) = (space(&mut random, degree, kind), space(&mut random, 1 + degree % 3, kind + 1));
            let n = u.len() * v.len();
            let points: Vec<Point> = (0..n).map(|_| point(&mut random)).collect();
            let weights = rational.then(|| (0..n).map(|_| 0.3 + random.next().abs()).collect());
            let surface = Surface::build(u, v, points, weights).unwrap();
            scene.add(Object::new(format!("s{kind} {rational}"), surface.into())).unwrap();
        }
    }
    scene
}

#[test]
fn splines_of_every_degree_come_back_as_one_object_each_with_unit_axis_and_knots() {
    for degree in [1, 2, 3, 4, 5, 6, 7, 25] {
        for seed in 0..2 {
            check(&spline_scene(seed, degree));
        }
    }
}

/// Colours of objects: their own, bright ones, one that others have too, none, one beside a material; and what a layer lends.
#[test]
fn colours_of_objects_come_back_to_the_bit_and_others_see_them_as_materials() {
    let mut scene = spline_scene(1, 2);
    let blue = [0.1, 1.0 / 3.0, 0.7, 1.0];
    let colors = [Some(blue), None, Some([0.2, 0.4, 0.6, 0.5]), Some(blue), Some([2.0, -1.0, 0.5, 1.0])];
    scene.materials.add(Material::new("color-1", [0.9, 0.0, 0.0, 1.0])).unwrap();
    let add =
        |scene: &mut Scene, name: &str, geometry: Geometry| scene.add(Object::new(name, geometry)).unwrap();
    let points = vec![Point::origin(), Point::new(1.0, 0.0, 0.0), Point::new(0.0, 1.0, 0.0)];
    add(&mut scene, "face", Mesh::new(points.clone(), &[[0, 1, 2]]).unwrap().into());
    add(&mut scene, "line", Polyline { points: points.clone(), closed: false }.into());
    add(&mut scene, "dots", Cloud { points }.into());
    let count = scene.objects().len();
    for index in 0..count {
        let name = scene.objects()[index].name().to_owned();
        let object = scene.object_mut(&name).unwrap();
        object.color = colors[index % colors.len()];
        if index % 7 == 3 {
            object.materials = vec!["color-1".into()];
        }
    }
    check(&scene);
    let file = written(&scene, &WriteOptions { up: UpChoice::Keep, ..WriteOptions::default() });
    let library = String::from_utf8(file.siblings["s.mtl"].clone()).unwrap();
    // The material keeps its name; a colour is one material, however many objects have it, and within what others read.
    assert_eq!(library.matches("newmtl ").count(), 5, "{library}");
    // What has none has a material that stands for none: others would go on with the one before.
    assert!(library.contains("newmtl plain\n# Loftsman none\nKd 0.8 0.8 0.8\n"), "{library}");
    assert!(!String::from_utf8_lossy(&file.bytes).lines().any(|line| line.trim() == "usemtl"));
    assert!(library.contains("newmtl color-1\nKd 0.9 0 0\n"), "{library}");
    assert!(library.contains("\n# Loftsman color\nKd 1 0 0.5\n"), "{library}");
    assert!(library.contains("d 0.5\n"), "{library}");
    // Who makes more of such a colour in the library has a material.
    let mut more = file.clone();
    more.siblings.insert("s.mtl".into(), library.replace("d 0.5\n", "d 0.5\nillum 2\n").into_bytes());
    let made = read(&more);
    assert_eq!(made.materials.iter().count(), 2);

    // A comment that somebody spoilt says nothing: the material that it stood beside does.
    let text = String::from_utf8_lossy(&file.bytes);
    let said = text.lines().find(|line| line.starts_with("# Loftsman color")).unwrap();
    for wrong in [
        "# Loftsman color nan 0 0 1",
        "# Loftsman color 1e999 0 0 1",
        "# Loftsman color 1 0 0",
        "# Loftsman color",
    ] {
        let mut spoilt = file.clone();
        spoilt.bytes = text.replace(said, wrong).into_bytes();
        let back = read(&spoilt);
        assert_eq!(back.objects().len(), scene.objects().len());
        let mut colors = back.objects().iter().filter_map(|o| o.color).flatten();
        assert!(colors.all(f64::is_finite), "{wrong}");
    }

    // What a layer lends is seen, and is the object's own from then on: the file has no layers.
    let mut lent = Scene::new();
    let line = Polyline { points: vec![Point::origin(), Point::new(1.0, 2.0, 3.0)], closed: false };
    let mut object = Object::new("line", line.into());
    object.layer = Some("frames".into());
    lent.add(object).unwrap();
    let mut layer = Layer::new("frames");
    layer.color = Some(blue);
    lent.layers.add(layer).unwrap();
    let back = read(&written(&lent, &WriteOptions::default()));
    assert_eq!((back.objects()[0].color, back.materials.iter().count()), (Some(blue), 0));
}

/// Lines of two to four points, closed or not, and vertices' colours whose sRGB is no short number: written again, the file is the same.
#[test]
fn short_closed_lines_and_vertices_colours_are_written_alike_again() {
    let mut random = Lcg::new(7);
    for case in 0..400 {
        let mut scene = Scene::new();
        let count = 2 + case % 3;
        let points: Vec<Point> =
            (0..count + 3).map(|_| Point::new(random.next(), random.next(), random.next())).collect();
        let line = Polyline { points: points[3..].to_vec(), closed: case % 2 == 0 };
        scene.add(Object::new("line", line.into())).unwrap();
        let mut mesh = Mesh::new(points[..3].to_vec(), &[[0, 1, 2]]).unwrap();
        let colors = (0..3).map(|_| [0.0; 3].map(|_| random.next().abs()));
        let colors = colors.map(|[r, g, b]| [r, g, b, 1.0]).collect();
        mesh.colors = loftsman_kernel::mesh::Layer::per_point(colors);
        scene.add(Object::new("mesh", mesh.into())).unwrap();

        let first = written(&scene, &WriteOptions::default());
        let back = read(&first);
        let Geometry::Polyline(line) = back.object("line").unwrap().geometry() else { panic!("case {case}") };
        assert_eq!((line.points.len(), line.closed), (count, case % 2 == 0), "case {case}");
        assert!(written(&back, &WriteOptions::default()).bytes == first.bytes, "case {case}");
    }
}

/// The number behind the name of a surface beside its mesh makes no name of it that another object has, whatever the order.
#[test]
fn names_with_numbers_stay_those_of_their_objects() {
    let mut random = Lcg::new(3);
    let space = || Space::clamped_uniform(2, 4).unwrap();
    let mut patch = || {
        let points = (0..16).map(|_| Point::new(random.next(), random.next(), random.next())).collect();
        Surface::new(space(), space(), points).unwrap()
    };
    let names = ["body", "body.002", "body.001", "body.001.001", "body.003"];
    for turn in 0..names.len() {
        let mut scene = Scene::new();
        for k in 0..names.len() {
            let name = names[(k + turn) % names.len()];
            scene.add(Object::new(name, patch().into())).unwrap();
        }
        check(&scene);
    }
}

#[test]
fn a_mesh_that_somebody_has_changed_beside_its_surface_is_an_object_of_its_own() {
    let scene = spline_scene(1, 2);
    let tessellator = Adaptive::default();
    let options = WriteOptions { tessellator: Some(&tessellator), ..WriteOptions::default() };
    let text = String::from_utf8(written(&scene, &options).bytes).unwrap();
    let at = text.find("# Loftsman mesh").unwrap();
    let moved = format!("{}{}", &text[..at], text[at..].replacen("\nv ", "\nv 1", 1));
    let back = read(&Memory::new("s.obj", moved));
    assert_eq!(back.objects().len(), scene.objects().len() + 1);
    // Programs that know nothing of the comments see both, as before.
    let plain: String = text.lines().filter(|l| !l.starts_with('#')).map(|l| format!("{l}\n")).collect();
    let surfaces = scene.objects().iter().filter(|o| o.geometry().kind() == "surface").count();
    assert_eq!(read(&Memory::new("s.obj", plain)).objects().len(), scene.objects().len() + surfaces);
}

/// Whatever of a surface is moved, the mesh beside it was not made of it; the others stay one object with theirs.
#[test]
fn a_surface_that_somebody_has_changed_beside_its_mesh_is_an_object_of_its_own() {
    let tessellator = Adaptive::default();
    let options = WriteOptions { tessellator: Some(&tessellator), ..WriteOptions::default() };
    let mut tried = 0;
    for seed in 0..12 {
        let scene = spline_scene(seed, 1 + seed as usize % 3);
        let text = String::from_utf8(written(&scene, &options).bytes).unwrap();
        for (at, _) in text.match_indices("# Loftsman surface") {
            let end = at + text[at..].find("end\n").unwrap();
            for change in ["\nv ", "\nparm u ", "\nparm v "] {
                // The first number of a vertex; the last knot.
                let place = at + text[at..end].find(change).unwrap() + change.len();
                let ends = |c: char| place + text[place..].find(c).unwrap();
                let changed = match change {
                    "\nv " => format!("{}77{}", &text[..place], &text[ends(' ')..]),
                    _ => {
                        let (all, last) = text[..ends('\n')].rsplit_once(' ').unwrap();
                        let last = last.parse::<f64>().unwrap() + 1.0;
                        format!("{all} {last}{}", &text[ends('\n')..])
                    }
                };
                let (back, report) =
                    Obj.read(&Memory::new("s.obj", changed), &ReadOptions::default()).unwrap();
                assert_eq!(back.objects().len(), scene.objects().len() + 1, "{seed} {change:?}");
                let said = |words: &str| report.notes.iter().any(|note| note.contains(words));
                assert!(said("changed since: each is an object of its own"), "{:?}", report.notes);
                tried += 1;
            }
        }
    }
    assert!(tried >= 30, "{tried}");
}

/// Of twins only the one that is as it was written has the mesh beside it.
#[test]
fn twins_of_which_one_was_changed_are_told_apart() {
    let (u, v) = (Space::clamped(1, &[0.0, 1.0]).unwrap(), Space::clamped(1, &[0.0, 1.0]).unwrap());
    let corners = [[0.0, 0.0], [0.0, 1.0], [2.0, 0.0], [2.0, 1.0]].map(|[x, y]| Point::new(x, y, 0.0));
    let flat = Surface::new(u, v, corners.to_vec()).unwrap();
    let mut scene = Scene::new();
    for name in ["one", "two"] {
        scene.add(Object::new(name, flat.clone().into())).unwrap();
    }
    let tessellator = Adaptive::default();
    let options = WriteOptions { tessellator: Some(&tessellator), ..WriteOptions::default() };
    let text = String::from_utf8(written(&scene, &options).bytes).unwrap();
    let marks: Vec<usize> = text.match_indices("# Loftsman surface").map(|(at, _)| at).collect();
    assert_eq!(marks.len(), 2);
    let kinds = |text: String| -> Vec<String> {
        let back = read(&Memory::new("s.obj", text));
        back.objects().iter().map(|o| format!("{} {}", o.name(), o.geometry().kind())).collect()
    };
    assert_eq!(kinds(text.clone()), ["one surface", "two surface"]);
    let moved = |at: usize| format!("{}{}", &text[..at], text[at..].replacen("\nv ", "\nv 7", 1));
    assert_eq!(kinds(moved(marks[0])), ["one mesh", "one.001 surface", "two surface"]);
    assert_eq!(kinds(moved(marks[1])), ["one surface", "two mesh", "two.001 surface"]);
}

/// The text of some object, with vertices of its own.
fn object(kind: usize, seed: u64, name: &str) -> String {
    let mut random = Lcg::new(seed);
    let mut text = format!("o {name}\n");
    if seed.is_multiple_of(3) {
        text += "usemtl m\n";
    }
    let n = 4 + seed as usize % 5;
    for _ in 0..n {
        let _ = writeln!(text, "v {} {} {}", random.next(), 1e3 * random.next(), random.next() * 1e-7);
    }
    let any = |random: &mut Lcg, n: usize| 1 + (random.next().abs() * n as f64) as usize % n;
    match kind {
        0..=2 => {
            // Normals for some meshes only, smoothing and groups for others.
            for _ in 0..if kind == 1 { 3 } else { 0 } {
                let _ =
                    writeln!(text, "vn {} {} {}", random.next(), random.next(), 0.1 + random.next().abs());
            }
            text += ["", "g left\n", "s 3\n"][seed as usize % 3];
            for face in 0..n {
                let corners = 3 + face % 3;
                text += "f";
                for k in 0..corners {
                    let vertex = n - (face + k) % n;
                    let _ = if kind == 1 {
                        write!(text, " -{vertex}//-{}", any(&mut random, 3))
                    } else {
                        write!(text, " -{vertex}")
                    };
                }
                text += "\n";
            }
            text += "g\ns off\n";
        }
        3 => {
            text += "l";
            (1..=n).rev().for_each(|k| _ = write!(text, " -{k}"));
            text += if seed.is_multiple_of(2) { "\n" } else { " -4\n" };
        }
        4 => (1..=n).for_each(|k| _ = writeln!(text, "p -{k}")),
        5 => {
            let degree = 1 + seed as usize % 3;
            let _ = write!(text, "cstype bspline\ndeg {degree}\ncurv 0 1");
            (1..=n).for_each(|k| _ = write!(text, " -{k}"));
            let knots = n + degree + 1;
            text += "\nparm u";
            (0..knots).for_each(|k| _ = write!(text, " {}", k as f64 / (knots - 1) as f64));
            text += "\nend\n";
        }
        _ => {
            text +=
                "cstype bspline\ndeg 1 1\nsurf 0 1 0 1 -1 -2 -3 -4\nparm u 0 0 1 1\nparm v 0 0 1 1\nend\n";
        }
    }
    text
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]
    #[test]
    fn random_files_are_read_as_at_first_after_they_were_written(
        kinds in prop::collection::vec((0_usize..7, 0_u64..1000), 1..8), head in 0_usize..3,
    ) {
        let mut text = ["", "# Loftsman; unit mm, z up\n", "# Loftsman; unit ft, y up\n"][head].to_owned();
        for (at, (kind, seed)) in kinds.iter().enumerate() {
            text += &object(*kind, *seed, &format!("part {at}"));
        }
        check(&read(&Memory::new("s.obj", text)));
    }
}

//! Surfaces that share an edge still do as meshes, at the tolerance that holds when none is given.

use std::collections::HashMap;

use loftsman::kernel::plugin::{Memory, Parameters, ReadOptions, Registry, WriteOptions};
use loftsman::kernel::scene::{Geometry, Object, Scene};
use loftsman::kernel::spline::{Direction, Space, Surface};
use loftsman::kernel::{Point, Vector};
use nalgebra::{Matrix4, Rotation3, Translation3};
use serde_json::json;

/// A bicubic patch over `[x, x + width] × [0, 1]`, waved along `y` as its neighbours are where they meet.
fn patch(x: f64, width: f64) -> Surface {
    let space = || Space::open(3, vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]).unwrap();
    let points = (0..16).map(|k| {
        let (i, j) = ((k / 4) as f64 / 3.0, (k % 4) as f64 / 3.0);
        let bump = if (1..3).contains(&(k / 4)) { 0.2 * width } else { 0.0 };
        Point::new(x + width * i, j, [0.0, 0.8, -0.5, 0.1][k % 4] + bump)
    });
    Surface::new(space(), space(), points.collect()).unwrap()
}

/// The points of a mesh at `x = 0`, by `y`.
fn at_the_edge(scene: &Scene, name: &str) -> Vec<[i64; 2]> {
    let object = scene.objects().iter().find(|o| o.name().starts_with(name)).unwrap();
    let Geometry::Mesh(mesh) = object.geometry() else { panic!("{} is no mesh", object.name()) };
    let of_edge = mesh.points().iter().filter(|p| p.x.abs() < 1e-6);
    // To a millionth: what single precision keeps.
    let mut points: Vec<[i64; 2]> = of_edge.map(|p| [p.y, p.z].map(|c| (c * 1e6).round() as i64)).collect();
    points.sort_unstable();
    points.dedup();
    points
}

#[test]
fn a_small_patch_and_a_large_one_meet_in_the_same_points() {
    let mut scene = Scene::new();
    scene.add(Object::new("small", Geometry::Surface(patch(0.0, 0.3)))).unwrap();
    scene.add(Object::new("large", Geometry::Surface(patch(-40.0, 40.0)))).unwrap();
    let registry = loftsman::registry();
    for (name, own) in [("out.obj", json!({ "surfaces": "mesh" })), ("out.gltf", json!({}))] {
        let format = registry.format_of(name).unwrap();
        let own = Parameters::new(own, "write").unwrap();
        let options = WriteOptions { tessellator: registry.tessellator(), own, ..WriteOptions::default() };
        let mut out = Memory::new(name, "");
        let report = format.write(&scene, &mut out, &options).unwrap();
        // Both are held to the same tolerance: a thousandth of what they are together.
        for written in &report.objects {
            let tolerance = written.tolerance.unwrap();
            assert!((0.040..0.041).contains(&tolerance), "{written:?}");
        }
        // As another program reads it: the triangles.
        if name.ends_with("gltf") {
            let text = String::from_utf8(out.bytes).unwrap();
            out.bytes = text.replace("\"loftsman\"", "\"another\"").into_bytes();
        }
        let (again, _) = format.read(&out, &ReadOptions::default()).unwrap();
        let (small, large) = (at_the_edge(&again, "small"), at_the_edge(&again, "large"));
        assert!(small.len() > 3, "{small:?}");
        assert_eq!(small, large, "{name}");
    }
}

/// A side of the unit cube with parabolas for edges, in the plane that halves the angle to its neighbour, its directions elevated and cut into
/// spans as `how` says.
fn side(how: usize) -> Surface {
    let space = || Space::open(2, vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0]).unwrap();
    let points = (0..9).map(|k| {
        let out = |k: usize| if k == 1 { 0.0 } else { k as f64 - 1.0 };
        let (x, y) = (out(k / 3), out(k % 3));
        let bulge = match (x != 0.0, y != 0.0) {
            (true, true) => 0.0,
            (false, false) => 0.6,
            _ => 0.25,
        };
        // Across an edge and up alike.
        let across = |c: f64, other: f64| 0.5 + c * (0.5 + if other == 0.0 { bulge } else { 0.0 });
        Point::new(across(x, y), across(y, x), bulge)
    });
    let mut surface = Surface::new(space(), space(), points.collect()).unwrap();
    for (direction, by) in [(Direction::U, how % 3), (Direction::V, (how + 1) % 2)] {
        surface = if by > 0 { surface.elevate(direction, by).unwrap() } else { surface };
    }
    let knots: Vec<f64> =
        (1..=how).map(|k| (k as f64 + 0.3 * (how as f64).sin()) / (how + 1) as f64).collect();
    let surface = surface.insert_knots(Direction::U, &knots).unwrap();
    surface.insert_knots(Direction::V, &knots[..how / 2]).unwrap()
}

/// Six sides of a cube with edges bent alike from both sides, whose knots and degrees differ.
fn cube(moved: bool) -> Scene {
    use std::f64::consts::{FRAC_PI_2, PI};
    let mut scene = Scene::new();
    let turns =
        [(0.0, 0.0), (FRAC_PI_2, 0.0), (PI, 0.0), (-FRAC_PI_2, 0.0), (0.0, FRAC_PI_2), (0.0, -FRAC_PI_2)];
    for (k, (about_x, about_y)) in turns.into_iter().enumerate() {
        let up = Translation3::new(-0.5, -0.5, 0.5).to_homogeneous();
        let turn = Rotation3::from_axis_angle(&Vector::x_axis(), about_x)
            * Rotation3::from_axis_angle(&Vector::y_axis(), about_y);
        let map = turn.to_homogeneous() * up;
        let geometry = Geometry::Surface(side(k));
        let mut object = Object::new(format!("side{k}"), geometry);
        if moved {
            object.transform = Some(map);
        } else {
            object = Object::new(format!("side{k}"), object.geometry().transformed(&map).unwrap());
            bend(&mut object);
        }
        scene.add(object).unwrap();
    }
    scene
}

/// Twists all control vertices by an affine map, so that nothing is along an axis.
fn bend(object: &mut Object) {
    let map = Matrix4::new(1.0, 0.3, 0.1, 2.0, -0.2, 0.9, 0.4, 1.0, 0.1, -0.3, 1.2, 0.5, 0.0, 0.0, 0.0, 1.0);
    *object = Object::new(object.name(), object.geometry().transformed(&map).unwrap());
}

#[test]
fn sides_of_other_knots_and_degrees_close() {
    let registry = loftsman::registry();
    for moved in [false, true] {
        let scene = cube(moved);
        let joined = scene.joined().unwrap();
        for found in &joined {
            let found = found.as_ref().unwrap();
            assert!(found.as_points && found.beside.len() == 4, "{found:?}");
        }
        for (name, own) in [("out.obj", json!({ "surfaces": "mesh" })), ("out.glb", json!({}))] {
            let format = registry.format_of(name).unwrap();
            let own = Parameters::new(own, "write").unwrap();
            let options =
                WriteOptions { tessellator: registry.tessellator(), own, ..WriteOptions::default() };
            let mut out = Memory::new(name, "");
            let report = format.write(&scene, &mut out, &options).unwrap();
            for written in &report.objects {
                let (error, tolerance) = (written.error.unwrap(), written.tolerance.unwrap());
                assert!(error <= tolerance * (1.0 + 1e-9), "{written:?}");
            }
            let meshes = triangles(registry, name, out);
            // Points are one to a hundred thousandth: single precision keeps a millionth.
            let mut known: Vec<Point> = Vec::new();
            let mut one = |p: Point| {
                let found = known.iter().position(|q| (q - p).norm() < 1e-5);
                found.unwrap_or_else(|| {
                    known.push(p);
                    known.len() - 1
                })
            };
            let mut sides: HashMap<[usize; 2], i64> = HashMap::new();
            let mut faces = 0;
            for (points, corners) in meshes {
                let numbers: Vec<usize> = points.into_iter().map(&mut one).collect();
                for f in corners.chunks_exact(3) {
                    faces += 1;
                    for k in 0..3 {
                        let [a, b] = [k, (k + 1) % 3].map(|k| numbers[f[k] as usize]);
                        *sides.entry([a, b]).or_default() += 1;
                        *sides.entry([b, a]).or_default() -= 1;
                    }
                }
            }
            let open = sides.values().filter(|&&n| n != 0).count();
            assert!(faces > 100 && open == 0, "{name}, moved: {moved}: {open} open sides of {faces} faces");
        }
    }
}

/// The triangles of a file as another program reads them, in the world.
fn triangles(registry: &Registry, name: &str, mut out: Memory) -> Vec<(Vec<Point>, Vec<u32>)> {
    if name.ends_with("glb") {
        // Under another key our own reader takes the triangles, too.
        let at = out.bytes.windows(10).position(|w| w == b"\"loftsman\"");
        while let Some(at) = out.bytes.windows(10).position(|w| w == b"\"loftsman\"") {
            out.bytes[at..at + 10].copy_from_slice(b"\"somebody\"");
        }
        assert!(at.is_some());
    }
    let (scene, _) = registry.format_of(name).unwrap().read(&out, &ReadOptions::default()).unwrap();
    let world = scene.world_transforms().unwrap();
    let of = |(object, map): (&Object, &Option<Matrix4<f64>>)| {
        let Geometry::Mesh(mesh) = object.geometry() else { return None };
        let placed = map.map_or(Matrix4::identity(), |m| m);
        let points = mesh.points().iter().map(|p| placed.transform_point(p)).collect();
        Some((points, mesh.faces().flat_map(|f| f.iter().copied()).collect()))
    };
    scene.objects().iter().zip(&world).filter_map(of).collect()
}

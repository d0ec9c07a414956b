//! Surfaces that share an edge still do as meshes, at the tolerance that holds when none is given.

use loftsman::kernel::Point;
use loftsman::kernel::plugin::{Memory, Parameters, ReadOptions, WriteOptions};
use loftsman::kernel::scene::{Geometry, Object, Scene};
use loftsman::kernel::spline::{Space, Surface};
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

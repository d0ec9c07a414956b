//! Materials go out as the colours that STEP has.
#![allow(clippy::unwrap_used, reason = "a test may stop at what should not be")]

use loftsman_kernel::Point;
use loftsman_kernel::material::{Alpha, Material};
use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::mesh::color::to_srgb;
use loftsman_kernel::plugin::{Format, Memory, ReadOptions, WriteOptions};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_step::Step;

/// The arguments of each entity of a type.
fn entities<'t>(text: &'t str, kind: &str) -> Vec<(&'t str, &'t str)> {
    let lines = text.lines().filter_map(|line| line.split_once('='));
    lines
        .filter_map(|(number, body)| {
            Some((number.trim(), body.trim().strip_prefix(kind)?.strip_prefix('(')?))
        })
        .collect()
}

/// The colour of a styled item, found by following references: of each styled entity.
fn colors(text: &str) -> Vec<(String, [f64; 3])> {
    let body = |number: &str| {
        let start = format!("{number}=");
        text.lines()
            .find(|line| line.replace(' ', "").starts_with(&start))
            .unwrap()
            .split_once('=')
            .unwrap()
            .1
            .trim()
    };
    let references = |body: &str| -> Vec<String> {
        body.match_indices('#')
            .map(|(at, _)| {
                body[at..]
                    .chars()
                    .enumerate()
                    .take_while(|(k, c)| *k == 0 || c.is_ascii_digit())
                    .map(|(_, c)| c)
                    .collect()
            })
            .collect()
    };
    let mut all = Vec::new();
    for (_, styled) in entities(text, "STYLED_ITEM") {
        let mut named = references(styled);
        let item = named.pop().unwrap();
        let mut open = named;
        let mut color = None;
        while let Some(next) = open.pop() {
            let body = body(&next);
            // Behind its name.
            if let Some((_, numbers)) = body.strip_prefix("COLOUR_RGB('").and_then(|all| all.split_once("',"))
            {
                let numbers: Vec<f64> =
                    numbers.trim_end_matches(");").split(',').map(|x| x.parse().unwrap()).collect();
                color = Some([numbers[0], numbers[1], numbers[2]]);
            } else {
                open.extend(references(body));
            }
        }
        all.push((item, color.unwrap()));
    }
    all
}

fn scene() -> Scene {
    let mut scene = Scene::new();
    let mut glass = Material::new("glass", [0.0, 0.25, 0.0, 0.5]);
    glass.alpha = Alpha::Blend;
    for material in
        [Material::new("red", [1.0, 0.0, 0.0, 1.0]), glass, Material::new("blue", [0.1, 0.2, 0.9, 1.0])]
    {
        scene.materials.add(material).unwrap();
    }
    let points = (0..8).map(|k| Point::new(f64::from(k % 4), f64::from(k / 4), 0.0)).collect();
    let mut mesh = Mesh::new(points, &[[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6]]).unwrap();
    mesh.materials = vec![0, 1, 2];
    let mut sheet = Object::new("sheet", mesh.into());
    sheet.materials = ["red", "glass", "red"].map(str::to_owned).to_vec();
    scene.add(sheet).unwrap();
    let triangle = |z: f64| {
        Mesh::new(
            [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)].map(|(x, y)| Point::new(x, y, z)).to_vec(),
            &[[0, 1, 2]],
        )
    };
    for (name, materials, slot, z) in [
        ("one", vec!["blue"], None, 1.0),
        ("second", vec!["red", "blue"], Some(1), 2.0),
        ("plain", vec![], None, 3.0),
    ] {
        let mut mesh = triangle(z).unwrap();
        mesh.materials = slot.into_iter().collect();
        let mut object = Object::new(name, mesh.into());
        object.materials = materials.into_iter().map(str::to_owned).collect();
        // What a material says goes before it.
        object.color = Some([0.0, 0.5, 0.5, 1.0]);
        scene.add(object).unwrap();
    }
    scene
}

/// Faces of a mesh by their materials, an object by its one, and by its own colour where it has none; as many triangles as there are.
#[test]
fn base_colours_of_materials_go_out() {
    let mut memory = Memory::new("t.step", Vec::new());
    Step.write(&scene(), &mut memory, &WriteOptions::default()).unwrap();
    let text = String::from_utf8(memory.bytes.clone()).unwrap();
    let faces = entities(&text, "TRIANGULATED_FACE");
    assert_eq!(faces.len(), 5, "{text}");
    let all = colors(&text);
    let of = |number: &str| all.iter().find(|(item, _)| item == number).map(|(_, color)| *color);
    let triangles = |body: &str| body.rsplit_once(",(),").unwrap().1.matches('(').count() - 1;
    let shells = entities(&text, "TESSELLATED_SHELL");
    let mut found: Vec<([f64; 3], usize)> = Vec::new();
    for (number, body) in &faces {
        let shell = shells
            .iter()
            .find(|(_, list)| list.contains(&format!("{number},")) || list.contains(&format!("{number})")))
            .unwrap();
        let color = of(number).or_else(|| of(shell.0)).unwrap();
        match found.iter_mut().find(|(known, _)| (0..3).all(|k| (known[k] - color[k]).abs() < 1e-9)) {
            Some((_, count)) => *count += triangles(body),
            None => found.push((color, triangles(body))),
        }
    }
    let mut expected =
        [([1.0, 0.0, 0.0], 4), ([0.0, 0.25, 0.0], 2), ([0.1, 0.2, 0.9], 2), ([0.0, 0.5, 0.5], 1)]
            .map(|(color, count): ([f64; 3], usize)| (color.map(to_srgb), count));
    for (color, count) in &mut expected {
        let at = found.iter().position(|(own, _)| (0..3).all(|k| (own[k] - color[k]).abs() < 1e-9));
        assert_eq!(at.map(|at| found[at].1), Some(*count), "{color:?} {found:?}");
    }
    assert!(text.contains("SURFACE_STYLE_TRANSPARENT(0.5)"));
    // What is read again has the same triangles.
    let (again, _) = Step.read(&memory, &ReadOptions::default()).unwrap();
    let count = |scene: &Scene| {
        let meshes = scene.objects().iter().filter_map(|object| match object.geometry() {
            Geometry::Mesh(mesh) => Some(mesh.triangle_count()),
            _ => None,
        });
        meshes.sum::<usize>()
    };
    assert_eq!((count(&again), count(&scene())), (9, 9));
}

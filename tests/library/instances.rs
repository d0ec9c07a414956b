//! What is shown a hundred thousand times is kept once: read, listed, written again, and written flat.

use std::io::{self, Write};
use std::sync::Arc;

use allocation_counter::measure;
use loftsman::describe::describe;
use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::plugin::{FormatError, Memory, ReadOptions, Sink, WriteOptions};
use loftsman_kernel::scene::{Geometry, Object, Scene, Unit, Up};
use loftsman_kernel::{Point, Vector};
use nalgebra::Matrix4;

/// A sink that counts bytes and lines and keeps nothing.
struct Drain {
    name: &'static str,
    bytes: u64,
    lines: u64,
}

impl Write for Drain {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.bytes += bytes.len() as u64;
        self.lines += bytes.iter().filter(|&&b| b == b'\n').count() as u64;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Sink for Drain {
    fn name(&self) -> &str {
        self.name
    }

    fn main(&mut self) -> &mut dyn Write {
        self
    }

    fn sibling(&mut self, _: &str) -> Result<&mut dyn Write, FormatError> {
        Ok(self)
    }
}

/// A round bolt of `2 n` points.
fn bolt(n: usize) -> Mesh {
    let ring = |z: f64| {
        (0..n).map(move |k| {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / n as f64).sin_cos();
            Point::new(cos, sin, z)
        })
    };
    let points = ring(0.0).chain(ring(4.0)).collect();
    let side = |k: usize| [[k, (k + 1) % n, n + k], [n + k, (k + 1) % n, n + (k + 1) % n]];
    Mesh::new(points, &(0..n).flat_map(side).collect::<Vec<_>>()).unwrap()
}

/// So many nodes that show a bolt, as a file.
fn file(nodes: usize, n: usize) -> Memory {
    let mut scene = Scene::new();
    (scene.unit, scene.up) = (Unit::Metre, Up::Y);
    let bolt = Arc::new(Geometry::from(bolt(n)));
    for k in 0..nodes {
        let mut object = Object::sharing(format!("bolt {k}"), Arc::clone(&bolt));
        let at = Vector::new((k % 400) as f64, (k / 400) as f64, 0.0) * 3.0;
        object.transform = Some(Matrix4::new_translation(&at));
        scene.add(object).unwrap();
    }
    let mut file = Memory::new("bolts.glb", "");
    gltf().write(&scene, &mut file, &WriteOptions::default()).unwrap();
    file
}

fn format(name: &str) -> Arc<dyn loftsman_kernel::plugin::Format> {
    let formats = loftsman::registry().formats();
    Arc::clone(formats.iter().find(|f| f.declaration().name == name).unwrap())
}

fn gltf() -> Arc<dyn loftsman_kernel::plugin::Format> {
    format("gltf")
}

fn read(file: &Memory) -> Scene {
    gltf().read(file, &ReadOptions::default()).unwrap().0
}

/// The most memory that it takes to read a file, list it and write it again.
fn peak(file: &Memory) -> u64 {
    let counted = measure(|| {
        let scene = read(file);
        let facts = describe(&scene);
        assert!(facts.objects.iter().all(|o| o.kind == "mesh" && o.faces == facts.objects[0].faces));
        drop(facts);
        let mut drain = Drain { name: "again.glb", bytes: 0, lines: 0 };
        gltf().write(&scene, &mut drain, &WriteOptions::default()).unwrap();
        // Names of meshes and the same once more.
        assert!(drain.bytes < 2 * file.bytes.len() as u64, "{} {}", drain.bytes, file.bytes.len());
    });
    counted.bytes_max
}

#[test]
fn a_hundred_thousand_nodes_cost_one_mesh_and_their_names() {
    let nodes = 100_000;
    let small = file(nodes, 3);
    // By the bytes: one mesh, and so many nodes.
    assert!(small.bytes.len() < 100 * nodes, "{}", small.bytes.len());
    let scene = read(&small);
    let first = scene.objects()[0].shared_geometry();
    assert!(scene.objects().iter().all(|o| Arc::ptr_eq(first, o.shared_geometry())));
    let few = peak(&small);
    assert!(few < 4000 * nodes as u64, "{few}: more than 4 kB a node");
    // Ten thousand times as many triangles, and a few megabytes more.
    let large = file(nodes, 5000);
    let many = peak(&large);
    let mesh = 10_000 * 24 + 10_000 * 12 + 10_000 * 8;
    assert!(many < few + 20 * mesh, "{many} after {few}: {} a node more", (many - few) / nodes as u64);

    // Flat, object after object; nothing of what goes out stays.
    let mut drain = Drain { name: "flat.obj", bytes: 0, lines: 0 };
    let counted = measure(|| {
        format("obj").write(&scene, &mut drain, &WriteOptions::default()).unwrap();
    });
    assert!(drain.lines > nodes as u64 * (1 + 6 + 6) && drain.bytes > 1 << 24, "{}", drain.bytes);
    assert!(counted.bytes_max < 2000 * nodes as u64, "{}", counted.bytes_max);
}

/// One after the other they must not cost their square.
#[test]
fn many_objects_are_named_removed_and_renamed_in_time() {
    let mut scene = read(&file(50_000, 3));
    let started = std::time::Instant::now();
    for _ in 0..50_000 {
        let name = scene.unique_name("bolt 0");
        scene.add(Object::new(name, Geometry::Group)).unwrap();
    }
    assert_eq!(scene.retain(|o| !o.name().ends_with('7')).len(), 10_000);
    scene.check().unwrap();
    assert!(started.elapsed().as_secs() < 20, "{:?}", started.elapsed());
}

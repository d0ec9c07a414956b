//! Files of other programs, with facts counted by someone else (`tests/data/gltf/SOURCES.md`).

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use std::borrow::Cow;
use std::path::PathBuf;

use loftsman_gltf::Gltf;
use loftsman_kernel::plugin::{Format, FormatError, ReadOptions, ReadReport, Source};
use loftsman_kernel::scene::{Geometry, Scene, Unit, Up};

/// A file of a folder, with its siblings.
struct Disk {
    name: String,
    folder: PathBuf,
    bytes: Vec<u8>,
}

impl Source for Disk {
    fn name(&self) -> &str {
        &self.name
    }

    fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    fn sibling(&self, name: &str) -> Result<Cow<'_, [u8]>, FormatError> {
        assert!(!name.contains("..") && !name.starts_with('/'));
        let missing = |_| FormatError::whole(format!("the file \"{name}\" beside it is missing"));
        std::fs::read(self.folder.join(name)).map(Cow::Owned).map_err(missing)
    }
}

fn read(name: &str) -> Result<(Scene, ReadReport), FormatError> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/gltf"));
    let bytes = std::fs::read(folder.join(name)).unwrap();
    let read = Gltf.read(&Disk { name: name.to_owned(), folder, bytes }, &ReadOptions::default());
    if let Ok((scene, report)) = &read {
        assert!(report.adds_up(), "{name}: {report:?}");
        scene.check().unwrap();
    }
    read
}

/// Objects, those with faces, points, triangles, line segments; how many objects have materials.
fn facts(scene: &Scene) -> [usize; 6] {
    let mut facts = [scene.objects().len(), 0, 0, 0, 0, 0];
    for object in scene.objects() {
        facts[2] += object.geometry().points().len();
        facts[5] += usize::from(!object.materials.is_empty());
        match object.geometry() {
            Geometry::Mesh(mesh) => {
                facts[1] += usize::from(mesh.face_count() > 0);
                facts[3] += mesh.triangle_count();
                facts[4] += mesh.lines().map(|l| l.len() - 1).sum::<usize>();
            }
            Geometry::Polyline(line) => facts[4] += line.points.len() - usize::from(!line.closed),
            _ => {}
        }
    }
    facts
}

#[test]
fn files_hold_what_others_counted() {
    // Nodes and triangles are SOURCES.md's; points and segments follow from the accessors' counts and the modes.
    let table = [
        ("Triangle.gltf", [1, 1, 3, 1, 0, 0]),
        ("TriangleWithoutIndices.gltf", [1, 1, 3, 1, 0, 0]),
        ("SimpleMeshes.gltf", [2, 2, 6, 2, 0, 0]),
        ("SimpleSparseAccessor.gltf", [1, 1, 14, 12, 0, 0]),
        ("VertexColorTest.glb", [2, 2, 72, 36, 0, 2]),
        // Two of its seven nodes show the same mesh, of 1152 triangles.
        ("ShapeCollection.glb", [7, 7, 0, 2390 + 1152, 0, 0]),
        ("properties.glb", [3, 3, 72, 36, 0, 3]),
        ("nested.glb", [3, 3, 72, 36, 0, 3]),
        ("cubevc.glb", [1, 1, 54, 48, 0, 0]),
        ("Mesh_PrimitiveMode_00.gltf", [1, 0, 1024, 0, 0, 1]),
        ("Mesh_PrimitiveMode_01.gltf", [1, 0, 8, 0, 4, 1]),
        ("Mesh_PrimitiveMode_02.gltf", [1, 0, 4, 0, 4, 1]),
        ("Mesh_PrimitiveMode_03.gltf", [1, 0, 5, 0, 4, 1]),
        ("Mesh_PrimitiveMode_04.gltf", [1, 1, 4, 2, 0, 1]),
        ("Mesh_PrimitiveMode_05.gltf", [1, 1, 4, 2, 0, 1]),
        ("Mesh_PrimitiveMode_06.gltf", [1, 1, 6, 2, 0, 1]),
        ("Mesh_PrimitiveMode_08.gltf", [1, 0, 4, 0, 4, 1]),
        ("Mesh_PrimitiveMode_11.gltf", [1, 1, 4, 2, 0, 1]),
        ("Mesh_PrimitiveMode_13.gltf", [1, 1, 4, 2, 0, 1]),
        ("Mesh_PrimitiveMode_15.gltf", [1, 1, 4, 2, 0, 1]),
    ];
    for (name, mut expected) in table {
        let (scene, _) = read(name).unwrap_or_else(|e| panic!("{e}"));
        let found = facts(&scene);
        if expected[2] == 0 {
            expected[2] = found[2];
        }
        assert_eq!(found, expected, "{name}");
        assert_eq!((scene.unit, scene.up), (Unit::Metre, Up::Y));
    }
}

#[test]
fn strips_and_fans_look_the_same_way_as_triangles() {
    // All of these show the same square, seen from +z.
    for number in ["04", "05", "06", "11", "13", "15"] {
        let (scene, _) = read(&format!("Mesh_PrimitiveMode_{number}.gltf")).unwrap();
        let Geometry::Mesh(mesh) = scene.objects()[0].geometry() else { panic!("no mesh") };
        for face in 0..mesh.face_count() {
            assert!(mesh.face_normal(face).unwrap().z > 0.999, "{number}");
        }
    }
}

#[test]
fn a_missing_bin_is_named() {
    let error = read("CubeHierarchy.gltf").unwrap_err().to_string();
    assert!(
        error.contains("buffers[0]") && error.contains("\"CubeHierarchy.bin\" beside it is missing"),
        "{error}"
    );
}

#[test]
fn what_has_no_place_is_counted() {
    let (scene, report) = read("VertexColorTest.glb").unwrap();
    assert!(report.left_out.is_empty(), "{report:?}");
    let tangents = |o: &loftsman_kernel::scene::Object| match o.geometry() {
        Geometry::Mesh(mesh) => mesh.tangents.values().len(),
        _ => 0,
    };
    assert!(scene.objects().iter().any(|o| tangents(o) > 0));
    let Geometry::Mesh(mesh) = scene.objects()[1].geometry() else { panic!("no mesh") };
    assert!(mesh.normals.corners().is_none() && mesh.normals.values().len() == mesh.points().len());
    assert!(mesh.colors.values().iter().all(|c| c.iter().all(|x| (0.0..=1.0).contains(x))));
    assert_eq!((scene.images.len(), scene.materials.len()), (2, 2));
}

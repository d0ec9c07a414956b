//! What a conversion loses is what is told of it beforehand, and nothing else: scenes with one thing each that some format does
//! not hold, written and read again.

use loftsman::kernel::conformance::{sample_assembly, sample_scene};
use loftsman::kernel::connection::{Connection, Side};
use loftsman::kernel::material::{Image, ImageData, Material};
use loftsman::kernel::mesh::{Cloud, FaceGroup, Layer, Mesh, Polyline};
use loftsman::kernel::plugin::{
    Fate, FormatErrorKind, Memory, Parameters, ReadOptions, UnitRule, WriteOptions,
};
use loftsman::kernel::scene::{
    Animation, Definition, Geometry, Layer as SceneLayer, Object, Scene, Unit, Up,
};
use loftsman::kernel::spline::trimmed::{ParameterCurve, Region};
use loftsman::kernel::spline::{Curve, Space, Surface, Trimmed};
use loftsman::kernel::{Point, Vector};
use nalgebra::Matrix4;

/// Points whose coordinates single precision holds, on no line.
fn points(n: usize) -> Vec<Point> {
    (0..n).map(|k| Point::new(k as f64, (k * k % 5) as f64, (k * k * k % 3) as f64)).collect()
}

fn scene() -> Scene {
    let mut scene = Scene::new();
    (scene.unit, scene.up) = (Unit::Metre, Up::Y);
    scene
}

fn of(object: Object) -> Scene {
    let mut scene = scene();
    scene.add(object).unwrap();
    scene
}

fn one(geometry: impl Into<Geometry>) -> Scene {
    of(Object::new("it", geometry.into()))
}

fn cloud() -> Object {
    Object::new("it", Cloud { points: points(3) }.into())
}

fn triangles() -> Mesh {
    Mesh::new(points(4), &[[0, 1, 2], [2, 1, 3]]).unwrap()
}

fn mesh(change: impl FnOnce(&mut Mesh)) -> Scene {
    let mut mesh = triangles();
    change(&mut mesh);
    one(mesh)
}

fn cloud_with(change: impl FnOnce(&mut Object)) -> Scene {
    let mut object = cloud();
    change(&mut object);
    of(object)
}

fn layer(change: impl FnOnce(&mut SceneLayer)) -> SceneLayer {
    let mut layer = SceneLayer::new("frames");
    change(&mut layer);
    layer
}

fn by_corner<T>(a: T, b: T) -> Layer<T> {
    Layer::per_corner(vec![a, b], vec![0, 0, 0, 1, 1, 1])
}

fn patch() -> Surface {
    let space = || Space::clamped_uniform(2, 3).unwrap();
    Surface::new(
        space(),
        space(),
        (0..9).map(|k| Point::new((k / 3) as f64, (k % 3) as f64, (k % 2) as f64)).collect(),
    )
    .unwrap()
}

fn trimmed() -> Trimmed {
    let at = |x: f64, y: f64| Point::new(x, y, 0.0);
    let corners = [at(0.0, 0.0), at(0.5, 0.0), at(0.5, 0.5)];
    let side =
        |k: usize| ParameterCurve::whole(Curve::line(corners[k], corners[(k + 1) % 3]).unwrap()).unwrap();
    let outer = (0..3).map(side).collect();
    Trimmed::new(patch(), vec![Region { outer, holes: Vec::new() }], Vec::new(), Vec::new()).unwrap()
}

/// Scenes with one thing each.
fn scenes() -> Vec<(&'static str, Scene)> {
    let z = Vector::z;
    let mut all = vec![
        ("triangles", mesh(|_| ())),
        ("a quadrilateral", one(Mesh::new(points(4), &[[0, 1, 2, 3]]).unwrap())),
        ("normals", mesh(|m| m.normals = Layer::per_point(vec![z(); 4]))),
        ("normals by face", mesh(|m| m.normals = by_corner(z(), Vector::x()))),
        ("texture coordinates", mesh(|m| m.uvs = Layer::per_point(vec![[0.5, 0.25]; 4]))),
        ("texture coordinates by face", mesh(|m| m.uvs = by_corner([0.5, 0.25], [0.0, 1.0]))),
        (
            "further texture coordinates",
            mesh(|m| {
                m.uvs = Layer::per_point(vec![[0.5, 0.25]; 4]);
                m.more_uvs = vec![Layer::per_point(vec![[0.0, 1.0]; 4])];
            }),
        ),
        ("colours of points", mesh(|m| m.colors = Layer::per_point(vec![[1.0, 0.0, 1.0, 1.0]; 4]))),
        ("colours by face", mesh(|m| m.colors = by_corner([1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0]))),
        (
            "tangents",
            mesh(|m| {
                m.normals = Layer::per_point(vec![z(); 4]);
                m.uvs = Layer::per_point(vec![[0.5, 0.25]; 4]);
                m.tangents = Layer::per_point(vec![[1.0, 0.0, 0.0, 1.0]; 4]);
            }),
        ),
        ("groups", mesh(|m| m.groups = vec![FaceGroup { name: "side".into(), faces: vec![1] }])),
        ("smoothing groups", mesh(|m| m.smoothing = vec![1, 2])),
        ("a line beside faces", mesh(|m| m.set_lines(vec![0, 3], vec![0, 2]).unwrap())),
        ("a chain beside faces", mesh(|m| m.set_lines(vec![0, 3, 1], vec![0, 3]).unwrap())),
    ];
    let lines = |corners: Vec<u32>, starts: Vec<usize>| {
        let mut mesh = Mesh::from_parts(points(4), Vec::new(), vec![0]).unwrap();
        mesh.set_lines(corners, starts).unwrap();
        one(mesh)
    };
    all.extend([
        ("loose lines", lines(vec![0, 1, 2, 3], vec![0, 2, 4])),
        ("a loose chain", lines(vec![0, 1, 2, 3], vec![0, 4])),
        ("a mesh of points", lines(Vec::new(), Vec::new())),
        ("a group", one(Geometry::Group)),
        ("a cloud", of(cloud())),
        ("a polyline", one(Polyline { points: points(4), closed: false })),
        ("a closed polyline", one(Polyline { points: points(4), closed: true })),
        ("a Bézier curve", one(Curve::new(Space::clamped_uniform(3, 4).unwrap(), points(4)).unwrap())),
        ("a curve", one(Curve::new(Space::clamped_uniform(3, 6).unwrap(), points(6)).unwrap())),
        ("a closed curve", one(Curve::new(Space::periodic_uniform(3, 6).unwrap(), points(6)).unwrap())),
        ("a surface", one(patch())),
        ("a trimmed surface", one(trimmed())),
        ("a transform", cloud_with(|o| o.transform = Some(Matrix4::new_translation(&Vector::x())))),
        ("a colour", cloud_with(|o| o.color = Some([1.0, 0.0, 0.0, 1.0]))),
        ("a layer's name", cloud_with(|o| o.layer = Some("frames".into()))),
        (
            "an animation",
            cloud_with(|o| o.animation = Some(Animation { rate: 1.0, frames: vec![points(3), points(3)] })),
        ),
        ("a statement", cloud_with(|o| o.statements = vec![("other".into(), "word".into())])),
    ]);
    let mut labelled = of(cloud());
    let second = labelled.unique_name("it");
    labelled.add(cloud().renamed(second).labelled("it")).unwrap();
    all.push(("a label", labelled));
    let mut hung = of(cloud());
    let mut below = cloud().renamed("below");
    below.parent = Some("it".into());
    hung.add(below).unwrap();
    all.push(("a hierarchy", hung));
    let mut layered = cloud_with(|o| o.layer = Some("frames".into()));
    layered.layers.add(layer(|l| l.color = Some([1.0, 0.0, 0.0, 1.0]))).unwrap();
    all.push(("a layer's colour", layered));
    let mut hidden = cloud_with(|o| o.layer = Some("frames".into()));
    hidden.layers.add(layer(|l| l.visible = false)).unwrap();
    all.push(("a hidden layer", hidden));
    let mut used = mesh(|_| ());
    used.object_mut("it").unwrap().materials = vec!["red".into()];
    used.materials.add(Material::new("red", [1.0, 0.0, 0.0, 1.0])).unwrap();
    all.push(("a material", used));
    let mut unused = of(cloud());
    unused.materials.add(Material::new("red", [1.0, 0.0, 0.0, 1.0])).unwrap();
    all.push(("a material of nobody", unused));
    let mut picture = of(cloud());
    picture.images.add(Image::new("red.png", ImageData::File("red.png".into()))).unwrap();
    all.push(("a picture of nothing", picture));
    let mut shell = scene();
    shell.add(Object::new("left", patch().into())).unwrap();
    shell.add(Object::new("right", patch().into())).unwrap();
    let along =
        || ParameterCurve::whole(Curve::line(Point::origin(), Point::new(1.0, 0.0, 0.0)).unwrap()).unwrap();
    let side = |name: &str| Side { object: name.into(), curve: along() };
    shell.connect(Connection { first: side("left"), second: side("right") }).unwrap();
    all.push(("a connection", shell));
    let mut defined = scene();
    let mut bolt = Definition::new("bolt");
    bolt.add(cloud()).unwrap();
    defined.define(bolt).unwrap();
    let mut shown = defined.clone();
    shown.add(Object::new("shown", Geometry::Instance("bolt".into()))).unwrap();
    all.push(("an instance", shown));
    defined.add(cloud()).unwrap();
    all.push(("a definition that nothing shows", defined));
    all
}

/// Lines that are said of every scene that has a shape, or of what other programs see and Loftsman does not lose.
const OF_ALL: [&str; 5] = [
    "single precision",
    "the format has no unit",
    "for Loftsman",
    "other programs",
    "becomes segments or triangles; the exact",
];

#[test]
fn what_is_lost_is_what_is_told_beforehand() {
    let tessellator = loftsman::registry().tessellator();
    let mut wrong = Vec::new();
    for format in loftsman::registry().formats() {
        let name = format.declaration().name;
        let mut lost = 0;
        for (what, scene) in scenes() {
            let mut memory = Memory::new(format!("a.{}", format.declaration().extensions[0]), "");
            let options = WriteOptions { tessellator, ..WriteOptions::default() };
            let (told, written) =
                (format.losses(&scene, &options), format.write(&scene, &mut memory, &options));
            let (told, report) = match (told, written) {
                (Ok(told), Ok(report)) => (told, report),
                (Err(told), Err(refused)) => {
                    assert_eq!((told.kind, told.problem), (refused.kind, refused.problem), "{name}, {what}");
                    continue;
                }
                (told, written) => panic!("{name}, {what}: {told:?}, but {written:?}"),
            };
            assert_eq!(told, report.losses, "{name}, {what}");
            for object in report.objects.iter().filter(|object| object.fate == Fate::LeftOut) {
                // The groups that stand for instances hold what goes out.
                let Some(kind) =
                    scene.get(&object.object).map(|o| o.geometry().kind()).filter(|k| *k != "instance")
                else {
                    continue;
                };
                let said = |line: &String| line.starts_with(kind) && line.contains("is left out");
                assert!(told.iter().any(said), "{name}, {what}: {object:?} is not among {told:?}");
            }
            let said = told.iter().any(|line| !OF_ALL.iter().any(|of_all| line.contains(of_all)));
            // Told is what others lose. In OBJ, what they lose stands in comments, by which it comes back here.
            if name == "obj" {
                let text = String::from_utf8(memory.bytes).unwrap();
                let seen: String = text
                    .lines()
                    .filter(|line| !line.starts_with('#'))
                    .flat_map(|line| [line, "\n"])
                    .collect();
                memory.bytes = seen.into_bytes();
            }
            // Units and axes have tests of their own.
            let unit = (format.declaration().holds.unit == UnitRule::None).then_some(Unit::Metre);
            let up = format.declaration().holds.up.is_none().then_some(Up::Y);
            let read = format.read(&memory, &ReadOptions { unit, up, ..ReadOptions::default() });
            let differs = match read {
                Ok((read, _)) => *read.converted(scene.unit, scene.up).unwrap() != scene,
                Err(error) => {
                    // A file of nothing may be none.
                    let nothing = report.objects.iter().all(|object| object.fate == Fate::LeftOut);
                    assert!(nothing, "{name}, {what}: {error}");
                    true
                }
            };
            if differs != said {
                wrong.push(format!("{name}, {what}: differs {differs}, and this is told: {told:?}"));
            }
            lost += usize::from(said);
        }
        assert_eq!(lost == 0, name == "loft", "{name} loses {lost}");
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn what_options_change_is_told_too() {
    let formats = loftsman::registry();
    let losses = |format: &str, scene: &Scene, option: &str, value: serde_json::Value| {
        let own = Parameters::new(serde_json::json!({ option: value }), "write").unwrap();
        let options = WriteOptions { tessellator: formats.tessellator(), own, ..WriteOptions::default() };
        let format = formats.format_of(&format!("x.{format}")).unwrap();
        let told = format.losses(scene, &options).unwrap();
        let mut memory = Memory::new("x", "");
        assert_eq!(format.write(scene, &mut memory, &options).unwrap().losses, told);
        told.join("; ")
    };
    let curve = one(Curve::new(Space::clamped_uniform(3, 6).unwrap(), points(6)).unwrap());
    assert!(losses("obj", &curve, "knots", "bezier".into()).contains("Bézier"));
    assert!(!losses("obj", &curve, "knots", "any".into()).contains("Bézier"));
    assert!(losses("glb", &curve, "meshes-only", true.into()).contains("curve is left out"));
    assert!(losses("obj", &one(patch()), "surfaces", "both".into()).contains("and as triangles"));
    assert!(!losses("obj", &one(patch()), "surfaces", "exact".into()).contains("surface"));
    assert!(losses("obj", &one(patch()), "surfaces", "mesh".into()).contains("surface becomes"));
    let own = Parameters::new(serde_json::json!({ "knots": "no" }), "write").unwrap();
    let refused =
        formats.format_of("x.obj").unwrap().losses(&curve, &WriteOptions { own, ..WriteOptions::default() });
    assert_eq!(refused.unwrap_err().kind, FormatErrorKind::Option);
}

#[test]
fn what_is_told_of_larger_scenes_is_reported_too() {
    let tessellator = loftsman::registry().tessellator();
    for (mut scene, unit) in [sample_scene(), sample_assembly()].into_iter().zip([Unit::Unknown, Unit::Inch])
    {
        scene.unit = unit;
        for format in loftsman::registry().formats() {
            for asked in [None, Some(Unit::Foot)] {
                let options = WriteOptions { tessellator, unit: asked, ..WriteOptions::default() };
                let told = format.losses(&scene, &options).unwrap();
                let report = format.write(&scene, &mut Memory::new("x", ""), &options).unwrap();
                assert_eq!(told, report.losses);
            }
        }
    }
}

//! What the tests of the format share.

use std::sync::Arc;

use loftsman_kernel::Point;
use loftsman_kernel::Vector;
use loftsman_kernel::connection::{Connection, Side};
use loftsman_kernel::material::{Alpha, Channel, Filter, Image, ImageData, Material, Texture, Wrap};
use loftsman_kernel::mesh::{Cloud, FaceGroup, Layer, Mesh, NONE, Polyline};
use loftsman_kernel::plugin::{Format, FormatError, Memory, ReadOptions, ReadReport, WriteOptions};
use loftsman_kernel::scene::{self, Animation, Geometry, Object, Scene, Unit, Up};
use loftsman_kernel::spline::trimmed::{ParameterCurve, Region};
use loftsman_kernel::spline::{Curve, Space, Surface, Trimmed};
use loftsman_native::Native;
use nalgebra::Matrix4;

pub(crate) fn read(bytes: impl Into<Vec<u8>>) -> Result<(Scene, ReadReport), FormatError> {
    Native.read(&Memory::new("test.loft.json", bytes), &ReadOptions::default())
}

pub(crate) fn write(scene: &Scene) -> Vec<u8> {
    let mut sink = Memory::new("test.loft.json", "");
    Native.write(scene, &mut sink, &WriteOptions::default()).unwrap();
    sink.bytes
}

/// One object of every kind, with everything that an object may have.
pub(crate) fn everything() -> Scene {
    let mut scene = Scene::new();
    (scene.unit, scene.up) = (Unit::Millimetre, Up::Y);
    let mut frames = scene::Layer::new("frames");
    (frames.color, frames.parent) = (Some([0.1, 1.0 / 3.0, -0.0, 1.0]), Some("all".into()));
    scene.layers.add(frames).unwrap();
    scene.layers.add(scene::Layer::new("all").hidden()).unwrap();
    let points =
        |n: usize| (0..n).map(|i| Point::new(0.1 * i as f64, -0.0, 1.0 / (1 + i) as f64)).collect::<Vec<_>>();
    let mut group = Object::new("assembly \"1\"\n", Geometry::Group);
    group.transform = Some(Matrix4::from_axis_angle(&Vector::z_axis(), 0.3));
    scene.add(group).unwrap();
    let space = Space::periodic(3, vec![0.1, 0.7, 1.3, 2.9, 3.3]).unwrap();
    let mut section =
        Object::new("section", Curve::rational(space, points(4), vec![1.0, 0.7, 2.5, 1e-3]).unwrap().into());
    section.color = Some([0.8, 0.2, 0.1, 1.0]);
    section.layer = Some("frames".into());
    section.label = Some("section \"1\"".into());
    section.parent = Some("assembly \"1\"\n".into());
    section.animation = Some(Animation { rate: 29.97, frames: vec![points(4), points(4)] });
    scene.add(section).unwrap();
    let u = Space::clamped_uniform(2, 14).unwrap();
    let v = Space::periodic_uniform(1, 3).unwrap();
    let weights = (0..42).map(|i| 1.0 + f64::from(i) / 7.0).collect();
    scene.add(Object::new("hull", Surface::rational(u, v, points(42), weights).unwrap().into())).unwrap();
    let mut mesh = Mesh::new(points(5), &[vec![0, 1, 2, 3], vec![2, 3, 4]]).unwrap();
    mesh.normals = Layer::per_point(vec![Vector::new(0.6, 0.0, 0.8); 5]);
    mesh.tangents = Layer::per_point(vec![[0.8, 1.0 / 3.0, -0.6, -1.0]; 5]);
    mesh.uvs = Layer::per_point(vec![[0.25, 1.0 / 3.0]; 5]);
    mesh.colors = Layer::per_point(vec![[0.1, 0.2, 0.3, 0.5]; 5]);
    scene.add(Object::new("panel", mesh.into())).unwrap();
    let mut painted = Mesh::new(points(5), &[vec![0, 1, 2, 3], vec![2, 3, 4], vec![0, 4, 1]]).unwrap();
    let corners = |n: u32| (0..10).map(|c| if c % 4 == 3 { NONE } else { c % n }).collect::<Vec<_>>();
    painted.normals = Layer::per_corner(vec![Vector::z(), -Vector::z()], corners(2));
    painted.tangents = Layer::per_corner(vec![[1.0, -0.0, 5e-324, 1.0]], corners(1));
    painted.uvs = Layer::per_corner(vec![[0.1, -0.0], [1.0 / 3.0, 2.0], [5e-324, 1e300]], corners(3));
    painted.more_uvs =
        vec![Layer::none(), Layer::per_point(vec![[0.5; 2]; 5]), Layer::per_corner(vec![], vec![NONE; 10])];
    painted.colors = Layer::per_corner(vec![[0.1, 0.2, 0.3, 1.0]], vec![0; 10]);
    painted.materials = vec![1, 0, 1];
    painted.smoothing = vec![0, 7, u32::MAX];
    painted.groups = vec![
        FaceGroup { name: "all \"of\" it".into(), faces: vec![0, 1, 2] },
        FaceGroup { name: String::new(), faces: vec![] },
    ];
    painted.set_lines(vec![0, 4, 1, 3, 2], vec![0, 3, 5]).unwrap();
    let mut painted = Object::new("painted", painted.into());
    painted.materials = vec!["glass".into(), "wood".into()];
    painted.statements =
        vec![("gltf extras".into(), "{\"a\": [1, \"ü\"]}".into()), ("x".into(), String::new())];
    scene.add(painted).unwrap();
    materials(&mut scene);
    scene.statements = vec![("gltf asset extras".into(), "12".into())];
    scene.add(Object::new("path", Polyline { points: points(3), closed: true }.into())).unwrap();
    scene.add(Object::new("scan", Cloud { points: points(2) }.into())).unwrap();
    scene.add(Object::new("empty", Cloud::default().into())).unwrap();
    scene.add(Object::new("window", trimmed().into())).unwrap();
    scene.add(Object::new("part", super::breps::everything().into())).unwrap();
    let side = |object: &str| Side { object: object.into(), curve: ring(0.3).swap_remove(0) };
    scene.connect(Connection { first: side("window"), second: side("hull") }).unwrap();
    scene
}

/// A loop of two curves about the middle of the unit square.
fn ring(size: f64) -> Vec<ParameterCurve> {
    let corner = |x: f64, y: f64| Point::new(0.5 + size * x, 0.5 + size * y, 0.0);
    let half = |s: f64| Curve::bezier(vec![corner(-s, 0.0), corner(0.0, -s), corner(s, 0.0)]).unwrap();
    [1.0, -1.0].map(|s| ParameterCurve::whole(half(s)).unwrap()).into()
}

fn trimmed() -> Trimmed {
    let space = || Space::clamped(1, &[0.0, 1.0]).unwrap();
    let points =
        [[0.0, 0.0], [0.0, 1.0], [1.0, 0.1], [1.0, 1.0 / 3.0]].map(|[x, y]| Point::new(x, y, -0.0)).to_vec();
    let surface = Surface::new(space(), space(), points).unwrap();
    let part = ParameterCurve::new(ring(0.2)[0].curve().clone(), 0.125, 0.7).unwrap();
    let regions = vec![Region { outer: ring(0.4), holes: vec![ring(0.1)] }, Region::default()];
    Trimmed::new(surface, regions, vec![vec![part]], vec![[0.3, 1.0 / 3.0]]).unwrap()
}

/// Materials and images with everything that they may have.
fn materials(scene: &mut Scene) {
    scene.images.add(Image::new("grain", ImageData::File("wood/grain é.png".into()))).unwrap();
    let bytes: Arc<[u8]> = (0..40_000_u32).map(|i| (i * i % 251) as u8).collect();
    let embedded = ImageData::Embedded { media_type: "image/png".into(), bytes };
    scene.images.add(Image::new("packed", embedded)).unwrap();
    let mut wood = Material::new("wood", [0.3, 0.2, 0.1, 1.0]);
    (wood.metallic, wood.roughness, wood.double_sided) = (0.1, 1.0 / 3.0, true);
    (wood.emissive, wood.alpha) = ([0.0, -0.0, 12.5], Alpha::Mask(0.45));
    let everything = Texture {
        set: 2,
        strength: 0.7,
        offset: [0.1, -0.0],
        tiling: [2.0, -3.0],
        rotation: 0.3,
        wrap: [Wrap::Mirror, Wrap::Clamp],
        magnify: Some(Filter::Nearest),
        minify: Some(Filter::LinearOfMixed),
        ..Texture::new("grain")
    };
    for channel in [
        Channel::BaseColor,
        Channel::MetallicRoughness,
        Channel::Normal,
        Channel::Occlusion,
        Channel::Emissive,
        Channel::Other("map_Ks".into()),
        Channel::Other("normal".into()),
    ] {
        wood.textures.insert(channel, everything.clone());
    }
    wood.textures.insert(Channel::Other("plain".into()), Texture::new("packed"));
    wood.statements = vec![("mtl Ks".into(), "0.5 0.5 0.5".into()), ("mtl Ks".into(), String::new())];
    scene.materials.add(wood).unwrap();
    scene.materials.add(Material::new("glass", [1.0, 1.0, 1.0, 0.25])).unwrap();
}

/// A text in which every number shows its bits, the sign of zero too.
pub(crate) fn bits(scene: &Scene) -> String {
    let (images, materials) = (scene.images.as_slice(), scene.materials.as_slice());
    let (objects, connections) = (scene.objects(), (scene.connections(), &scene.statements));
    let layers = scene.layers.as_slice();
    format!("{:?} {:?} {layers:?} {images:?} {materials:?} {objects:?} {connections:?}", scene.unit, scene.up)
}

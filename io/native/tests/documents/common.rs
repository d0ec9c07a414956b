//! What the tests of the format share.

use loftsman_kernel::Point;
use loftsman_kernel::Vector;
use loftsman_kernel::connection::{Connection, Side};
use loftsman_kernel::mesh::{Cloud, Layer, Mesh, Polyline};
use loftsman_kernel::plugin::{Format, FormatError, Memory, ReadOptions, ReadReport, WriteOptions};
use loftsman_kernel::scene::{Animation, Geometry, Object, Scene, Unit, Up};
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
    section.parent = Some("assembly \"1\"\n".into());
    section.animation = Some(Animation { rate: 29.97, frames: vec![points(4), points(4)] });
    scene.add(section).unwrap();
    let u = Space::clamped_uniform(2, 14).unwrap();
    let v = Space::periodic_uniform(1, 3).unwrap();
    let weights = (0..42).map(|i| 1.0 + f64::from(i) / 7.0).collect();
    scene.add(Object::new("hull", Surface::rational(u, v, points(42), weights).unwrap().into())).unwrap();
    let mut mesh = Mesh::new(points(5), &[vec![0, 1, 2, 3], vec![2, 3, 4]]).unwrap();
    mesh.normals = Layer::per_point(vec![Vector::new(0.6, 0.0, 0.8); 5]);
    mesh.uvs = Layer::per_point(vec![[0.25, 1.0 / 3.0]; 5]);
    mesh.colors = Layer::per_point(vec![[0.1, 0.2, 0.3, 0.5]; 5]);
    scene.add(Object::new("panel", mesh.into())).unwrap();
    scene.add(Object::new("path", Polyline { points: points(3), closed: true }.into())).unwrap();
    scene.add(Object::new("scan", Cloud { points: points(2) }.into())).unwrap();
    scene.add(Object::new("empty", Cloud::default().into())).unwrap();
    scene.add(Object::new("window", trimmed().into())).unwrap();
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

/// A text in which every number shows its bits, the sign of zero too.
pub(crate) fn bits(scene: &Scene) -> String {
    format!("{:?} {:?} {:?}", scene.unit, scene.up, scene.objects()) + &format!("{:?}", scene.connections())
}

//! Random scenes, placed by anything that has an inverse: what is written first is what is written ever after.

#![allow(clippy::unwrap_used, reason = "a test may stop at what should not be")]

use loftsman_kernel::connection::{Connection, Side};
use loftsman_kernel::material::Material;
use loftsman_kernel::mesh::{Cloud, Mesh, Polyline};
use loftsman_kernel::plugin::{Chord, Fineness, Format, Memory, ReadOptions, UpChoice, WriteOptions};
use loftsman_kernel::scene::{Geometry, Object, Scene, Unit, Up};
use loftsman_kernel::spline::trimmed::{ParameterCurve, Region};
use loftsman_kernel::spline::{Curve, Space, Surface, Trimmed};
use loftsman_kernel::{Point, Vector};
use loftsman_obj::Obj;
use loftsman_tessellation::Adaptive;
use nalgebra::{Matrix3, Matrix4};
use proptest::prelude::*;

/// Numbers from 0 to 1, the same in every run (Knuth's MMIX generator).
struct Lcg(u64);

impl Lcg {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn below(&mut self, n: usize) -> usize {
        ((self.next() * n as f64) as usize).min(n - 1)
    }

    fn point(&mut self) -> Point {
        Point::new(self.next(), 3.0 * self.next(), self.next() / 3.0)
    }

    fn points(&mut self, n: usize) -> Vec<Point> {
        (0..n).map(|_| self.point()).collect()
    }

    fn space(&mut self) -> Space {
        let degree = 1 + self.below(3);
        let knots: Vec<f64> = (0..2 + degree + self.below(3)).map(|k| k as f64 + 0.4 * self.next()).collect();
        match self.below(3) {
            0 => Space::periodic(degree, knots).unwrap(),
            _ => Space::clamped(degree, &knots).unwrap(),
        }
    }

    fn weights(&mut self, n: usize) -> Option<Vec<f64>> {
        (self.next() < 0.4).then(|| (0..n).map(|_| 0.5 + self.next()).collect())
    }

    fn surface(&mut self) -> Surface {
        let (u, v) = (self.space(), self.space());
        let n = u.len() * v.len();
        let points = self.points(n);
        Surface::build(u, v, points, self.weights(n)).unwrap()
    }

    /// A patch with a triangle as outer loop, a hole in it, a special curve and a special point.
    fn trimmed(&mut self) -> Trimmed {
        let space = |degree| Space::clamped(degree, &[0.0, 1.0]).unwrap();
        let points = self.points(12);
        let patch = Surface::new(space(3), space(2), points).unwrap();
        let chain = |corners: &[[f64; 2]]| -> Vec<ParameterCurve> {
            let ends = corners.iter().zip(corners.iter().cycle().skip(1));
            ends.map(|(a, b)| {
                let line = [Point::new(a[0], a[1], 0.0), Point::new(b[0], b[1], 0.0)];
                ParameterCurve::whole(Curve::new(space(1), line.to_vec()).unwrap()).unwrap()
            })
            .collect()
        };
        let region = Region {
            outer: chain(&[[0.0, 0.0], [1.0, 0.1 * self.next()], [0.2, 1.0]]),
            holes: vec![chain(&[[0.2, 0.2], [0.3, 0.5], [0.5, 0.2]])],
        };
        let special = chain(&[[0.1, 0.1], [0.3, 0.3]])[..1].to_vec();
        Trimmed::new(patch, vec![region], vec![special], vec![[0.25, 0.5]]).unwrap()
    }

    fn geometry(&mut self) -> Geometry {
        match self.below(8) {
            0 => Geometry::Group,
            1 => {
                let space = self.space();
                let n = space.len();
                let points = self.points(n);
                Curve::build(space, points, self.weights(n)).unwrap().into()
            }
            2 | 3 => self.surface().into(),
            4 => self.trimmed().into(),
            5 => {
                let points = self.points(5);
                Mesh::new(points, &[vec![0, 1, 2, 3], vec![0, 4, 1]]).unwrap().into()
            }
            6 => {
                let (n, closed) = (self.below(4), self.next() < 0.4);
                Polyline { points: self.points(3 * usize::from(n > 0) + n), closed }.into()
            }
            _ => {
                let n = 1 + self.below(4);
                Cloud { points: self.points(n) }.into()
            }
        }
    }

    /// A turn, a mirror, both, larger along one axis.
    fn placement(&mut self) -> Matrix4<f64> {
        let any = Matrix3::from_fn(|_, _| self.next() - 0.5) + Matrix3::identity();
        let linear = match self.below(4) {
            0 => Matrix3::from_diagonal(&Vector::new(-1.0, 1.0, 1.0)),
            1 => Matrix3::new(0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0),
            2 => any.qr().q() * (0.3 + self.next()),
            _ => any,
        };
        linear.to_homogeneous().append_translation(&(self.point() - Point::origin()))
    }

    fn scene(&mut self) -> Scene {
        let mut scene = Scene::new();
        scene.unit = [Unit::Millimetre, Unit::Metre, Unit::Inch, Unit::Unknown][self.below(4)];
        scene.up = [Up::Y, Up::Z][self.below(2)];
        let names = ["part", "a b", "color-1", "plain", "p #1", "o\\", "Ünal", "part.001", "#x"];
        if self.next() < 0.3 {
            let red = Material::new(names[self.below(9)], [1.0, 0.25, 0.0, 1.0]);
            scene.materials.add(red).unwrap();
        }
        let mut made: Vec<String> = Vec::new();
        for _ in 0..2 + self.below(6) {
            let name = scene.unique_name(names[self.below(9)]);
            let mut object = Object::new(name.clone(), self.geometry());
            if self.next() < 0.5 {
                // Few colours, so that objects share some.
                object.color = Some([[0.1, 1.0 / 3.0, 0.7, 1.0], [1.0, 0.0, 0.5, 0.5]][self.below(2)]);
            } else if self.next() < 0.4 {
                object.materials = scene
                    .materials
                    .iter()
                    .map(|m| loftsman_kernel::named::Named::name(m).to_owned())
                    .collect();
            }
            if self.next() < 0.6 {
                object.transform = Some(self.placement());
            }
            if !made.is_empty() && self.next() < 0.4 {
                object.parent = Some(made[self.below(made.len())].clone());
            }
            scene.add(object).unwrap();
            made.push(name);
        }
        self.connect(&mut scene);
        scene
    }

    /// Two surfaces that meet, as a file may say of any.
    fn connect(&mut self, scene: &mut Scene) {
        let surfaces: Vec<String> = scene
            .objects()
            .iter()
            .filter(|o| matches!(o.geometry(), Geometry::Surface(_) | Geometry::Trimmed(_)))
            .map(|o| o.name().to_owned())
            .collect();
        if let [one, other, ..] = surfaces.as_slice() {
            let mut side = |object: &String| {
                let points = (0..2).map(|_| Point::new(self.next(), self.next(), 0.0)).collect();
                let line = Curve::new(Space::clamped(1, &[0.0, 1.0]).unwrap(), points).unwrap();
                Side { object: object.clone(), curve: ParameterCurve::whole(line).unwrap() }
            };
            let connection = Connection { first: side(one), second: side(other) };
            scene.connect(connection).unwrap();
        }
    }
}

fn options<'a>(by: &'a Adaptive, kind: u64) -> WriteOptions<'a> {
    WriteOptions {
        tessellator: (!kind.is_multiple_of(7)).then_some(by as _),
        fineness: Fineness { chord: Chord::Relative(0.05), angle: 0.8 },
        unit: [None, Some(Unit::Millimetre), Some(Unit::Inch)][kind as usize % 3],
        up: [UpChoice::Keep, UpChoice::To(Up::Y), UpChoice::To(Up::Z)][kind as usize / 3 % 3],
        ..WriteOptions::default()
    }
}

fn written(scene: &Scene, options: &WriteOptions<'_>) -> Memory {
    let mut file = Memory::new("s.obj", "");
    Obj.write(scene, &mut file, options).unwrap();
    file
}

fn read(file: &Memory) -> Scene {
    Obj.read(file, &ReadOptions::default()).unwrap().0
}

/// The first line that two files do not share, with what stands above it.
fn difference(one: &str, other: &str) -> Option<String> {
    let (one, other): (Vec<&str>, Vec<&str>) = (one.lines().collect(), other.lines().collect());
    let at = (0..one.len().max(other.len())).find(|&at| one.get(at) != other.get(at))?;
    let above: Vec<&&str> = one[..at].iter().rev().filter(|line| !line.starts_with("v ")).take(6).collect();
    Some(format!("line {at}: {:?}, then {:?}; above {above:#?}", one.get(at), other.get(at)))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]
    #[test]
    fn a_scene_is_written_once_as_it_is_ever_after(seed in any::<u64>()) {
        let scene = Lcg(seed).scene();
        let tessellator = Adaptive::default();
        let options = options(&tessellator, seed >> 32);
        let first = written(&scene, &options);
        let text = String::from_utf8_lossy(&first.bytes);
        // A library where there is something in it, its colours counted from one.
        let names: Vec<&str> = text.lines().filter_map(|l| l.strip_prefix("usemtl ")).collect();
        let own = scene.materials.iter().count();
        prop_assert_eq!(first.siblings.contains_key("s.mtl"), own + names.len() > 0, "{}", text);
        prop_assert_eq!(text.contains("mtllib "), own + names.len() > 0, "{}", text);
        if own == 0 && names.contains(&"color-2") {
            prop_assert!(names.contains(&"color-1"), "{}", text);
        }
        let again = written(&read(&first), &options);
        prop_assert_eq!(difference(&text, &String::from_utf8_lossy(&again.bytes)), None);
        prop_assert_eq!(&first.siblings, &again.siblings);
    }
}

/// Triangles of the first mesh of a file, as vectors of area.
fn sides(mesh: &Mesh) -> Vec<Vector> {
    let p = mesh.points();
    mesh.faces()
        .map(|f| [f[0], f[1], f[2]].map(|k| p[k as usize]))
        .map(|[a, b, c]| (b - a).cross(&(c - a)))
        .collect()
}

/// A flat patch whose outside is +z stays one under mirrors, in the mesh and in the exact surface; what loops leave of it, too.
#[test]
fn a_mirrored_surface_and_the_mesh_beside_it_look_the_same_way() {
    let space = || Space::clamped(1, &[0.0, 1.0]).unwrap();
    let corners = [[0.0, 0.0], [0.0, 1.0], [2.0, 0.0], [2.0, 1.0]].map(|[x, y]| Point::new(x, y, 0.0));
    let flat = Surface::new(space(), space(), corners.to_vec()).unwrap();
    let corner = |[u, v]: [f64; 2]| Point::new(u, v, 0.0);
    let outer = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 0.0]];
    let outer = outer.windows(2).map(|w| {
        ParameterCurve::whole(Curve::new(space(), vec![corner(w[0]), corner(w[1])]).unwrap()).unwrap()
    });
    let region = Region { outer: outer.collect(), holes: Vec::new() };
    let half = Trimmed::new(flat.clone(), vec![region], Vec::new(), Vec::new()).unwrap();
    let mirror = Matrix4::from_diagonal(&nalgebra::Vector4::new(-1.0, 1.0, 1.0, 1.0));
    let tessellator = Adaptive::default();
    for (geometry, area) in [(Geometry::from(flat), 2.0), (half.into(), 1.0)] {
        let mut scene = Scene::new();
        let mut object = Object::new("s", geometry);
        object.transform = Some(mirror);
        scene.add(object).unwrap();
        let options =
            WriteOptions { tessellator: Some(&tessellator), up: UpChoice::Keep, ..WriteOptions::default() };
        let mut file = Memory::new("s.obj", "");
        let report = Obj.write(&scene, &mut file, &options).unwrap();
        assert!(report.notes.iter().any(|note| note.contains("u and v exchanged")), "{:?}", report.notes);
        let text = String::from_utf8(file.bytes.clone()).unwrap();
        // Without our comments the mesh is an object of its own.
        let plain: String = text.lines().filter(|l| !l.starts_with('#')).map(|l| format!("{l}\n")).collect();
        let both = read(&Memory::new("s.obj", plain));
        let meshes = both.objects().iter().filter_map(|o| match o.geometry() {
            Geometry::Mesh(mesh) => Some(mesh),
            _ => None,
        });
        let triangles: Vec<Vector> = meshes.flat_map(sides).collect();
        assert!(triangles.iter().all(|n| n.z > 0.0), "{text}");
        assert!((triangles.iter().map(|n| n.z).sum::<f64>() / 2.0 - area).abs() < 1e-12);
        let back = read(&file);
        assert_eq!(back.objects().len(), 1);
        let (surface, outer) = match back.objects()[0].geometry() {
            Geometry::Surface(surface) => (surface, None),
            Geometry::Trimmed(trimmed) => (trimmed.surface(), trimmed.regions().first().map(|r| &r.outer)),
            other => panic!("{}", other.kind()),
        };
        let normal =
            surface.derivative(0.3, 0.6, 1, 0).unwrap().cross(&surface.derivative(0.3, 0.6, 0, 1).unwrap());
        assert!((normal - Vector::new(0.0, 0.0, 2.0)).norm() < 1e-12, "{normal}");
        // The outer loop runs counterclockwise, as OBJ has it.
        if let Some(outer) = outer {
            let ends = outer.iter().map(|curve| curve.ends().unwrap());
            let doubled: f64 = ends.map(|[[a, b], [c, d]]| a * d - b * c).sum();
            assert!((doubled - 1.0).abs() < 1e-12, "{doubled}");
        }
        assert_eq!(text.as_bytes(), written(&back, &options).bytes);
    }
}

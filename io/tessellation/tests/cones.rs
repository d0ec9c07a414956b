//! Cones with a tip, turned and cut open at random: closed, near, and of no more triangles than their curvature asks for.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::solids::*;
use loftsman_kernel::brep::{Brep, Edge, Frame, SurfaceForm};
use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::plugin::{Chord, Fineness, Tessellator};
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Vector};
use loftsman_tessellation::Adaptive;

/// Cones of each kind.
const COUNT: usize = 100;
/// A cone needs its circle's chords, and some triangles for each of them.
const TIMES: f64 = 12.0;

/// Numbers of [0, 1) that look random and are the same every time (SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    fn vector(&mut self) -> Vector {
        loop {
            let v = Vector::new(self.within(-1.0, 1.0), self.within(-1.0, 1.0), self.within(-1.0, 1.0));
            if (0.1..1.0).contains(&v.norm()) {
                return v;
            }
        }
    }
}

/// A cone on its base, or a sector of it.
struct Cone {
    /// That of the base, `z` from the tip to it, `x` where the surface's seam is.
    frame: Frame,
    radius: f64,
    /// Half of the angle in the tip.
    angle: f64,
    /// How far it goes around, and where that starts.
    sweep: f64,
    start: f64,
}

impl Cone {
    fn of(random: &mut Random, whole: bool) -> Self {
        let radius = 10_f64.powf(random.within(-2.0, 2.0));
        let origin = Point::from(random.vector() * radius);
        let z = random.vector();
        let frame = Frame::new(origin, z, z.cross(&random.vector())).unwrap();
        let angle = random.within(0.05, 1.5);
        if whole {
            return Self { frame, radius, angle, sweep: TAU, start: 0.0 };
        }
        let (sweep, start) = (random.within(0.2, 0.9 * TAU), random.within(0.0, TAU));
        Self { frame, radius, angle, sweep, start }
    }

    fn height(&self) -> f64 {
        self.radius / self.angle.tan()
    }

    /// As files have it: the numbers of points end after a dozen digits.
    fn rounded(&self, p: Point) -> Point {
        let unit = 1e-12 * 10_f64.powf(self.radius.log10().ceil());
        p.map(|x| (x / unit).round() * unit)
    }

    fn tip(&self) -> Point {
        self.rounded(self.frame.origin - self.frame.z * self.height())
    }

    fn on_base(&self, turn: f64) -> Point {
        let Frame { origin, x, .. } = self.frame;
        origin + (x * turn.cos() + self.frame.y() * turn.sin()) * self.radius
    }

    /// An edge with the tolerance that files say.
    fn edge(&self, curve: Curve, ends: [usize; 2]) -> Edge {
        Edge { tolerance: 1e-7 * self.radius, ..edge(curve, ends) }
    }

    fn around(&self, ends: [usize; 2]) -> Edge {
        let Frame { origin, z, .. } = self.frame;
        let from = self.rounded(self.on_base(self.start));
        self.edge(Curve::arc(from, origin, z, self.sweep).unwrap(), ends)
    }

    fn line(&self, a: Point, b: Point, ends: [usize; 2]) -> Edge {
        self.edge(Curve::line(a, b).unwrap(), ends)
    }

    fn side(&self) -> SurfaceForm {
        SurfaceForm::Cone { frame: self.frame, radius: self.radius, angle: self.angle }
    }

    /// All around, with the line from the base to the tip that CAD programs put on the seam, or without.
    fn whole(&self, seam: bool) -> Brep {
        let Frame { origin, z, x } = self.frame;
        let (from, tip) = (self.rounded(self.on_base(0.0)), self.tip());
        let mut vertices = vec![vertex(from)];
        let mut edges = vec![self.around([0, 0])];
        let mut loops = vec![vec![against(0)]];
        if seam {
            vertices.push(vertex(tip));
            edges.push(self.line(from, tip, [0, 1]));
            loops = vec![vec![along(1), against(1), against(0)]];
        }
        let mut points = vec![from, tip];
        let side = face(self.side(), &points, false, loops);
        points = (0..8).map(|k| self.on_base(TAU * f64::from(k) / 8.0)).collect();
        let plane = SurfaceForm::Plane { frame: Frame::new(origin, z, x).unwrap() };
        whole(vertices, edges, vec![side, face(plane, &points, false, vec![vec![along(0)]])], true)
    }

    /// A sector, with the two triangles that close it.
    fn part(&self) -> Brep {
        let Frame { origin, z, x } = self.frame;
        let (axis, tip) = (origin, self.tip());
        let [a, b] = [self.start, self.start + self.sweep].map(|turn| self.rounded(self.on_base(turn)));
        let corners = [axis, tip, a, b];
        let vertices = corners.iter().map(|&p| vertex(p)).collect();
        let edges = vec![
            self.around([2, 3]),
            self.line(a, tip, [2, 1]),
            self.line(b, tip, [3, 1]),
            self.line(axis, a, [0, 2]),
            self.line(axis, b, [0, 3]),
            self.line(axis, tip, [0, 1]),
        ];
        let points: Vec<Point> = (0..8).map(|k| self.on_base(TAU * f64::from(k) / 8.0)).collect();
        let plane = |normal: Vector, toward: Vector, loops, points: &[Point]| {
            let form = SurfaceForm::Plane { frame: Frame::new(origin, normal, toward).unwrap() };
            face(form, points, false, vec![loops])
        };
        let faces = vec![
            face(self.side(), &[a, b, tip], false, vec![vec![against(0), along(1), against(2)]]),
            plane(z, x, vec![along(3), along(0), against(4)], &points),
            plane((a - axis).cross(&z), a - axis, vec![along(5), against(1), against(3)], &[axis, a, tip]),
            plane(z.cross(&(b - axis)), b - axis, vec![along(4), along(2), against(5)], &[axis, b, tip]),
        ];
        whole(vertices, edges, faces, true)
    }
}

fn sizes(mesh: &Mesh, about: Point) -> [f64; 2] {
    let mut sizes = [0.0; 2];
    for f in mesh.faces() {
        let [a, b, c] = [f[0], f[1], f[2]].map(|k| mesh.points()[k as usize] - about);
        sizes[0] += 0.5 * (b - a).cross(&(c - a)).norm();
        sizes[1] += a.dot(&b.cross(&c)) / 6.0;
    }
    sizes
}

/// What is asked of the mesh of a cone.
fn check(cone: &Cone, brep: &Brep, number: usize, name: &str) {
    let &Cone { radius, angle, sweep, .. } = cone;
    let (height, slant) = (cone.height(), radius / angle.sin());
    let size = radius.max(height);
    let share = sweep / TAU;
    let cuts = if share < 1.0 { radius * height } else { 0.0 };
    let area = share * std::f64::consts::PI * radius * (radius + slant) + cuts;
    let volume = share * std::f64::consts::PI * radius * radius * height / 3.0;
    // The finest for every twentieth: they take as long as all others.
    let parts = &[1e-2, 1e-3, 1e-4, 1e-5][..if number.is_multiple_of(20) { 4 } else { 3 }];
    for chord in parts.iter().map(|part| part * size) {
        let turn = [FRAC_PI_2, 0.35][number % 2];
        let around = sweep / (0.8 * chord / radius).min(0.5).sqrt().min(turn) + 12.0;
        let most = ((TIMES * around) as usize).max(400);
        let fineness = Fineness { chord: Chord::Absolute(chord), angle: turn };
        let cut = Adaptive { budget: most }.measured_brep(brep, &fineness).unwrap();
        let of = format!("{name}: radius {radius}, angle {angle}, chord {chord}, turn {turn}");
        assert!(cut.left_out.is_empty(), "{of}: {:?}", cut.left_out);
        assert!(cut.error <= 1.000_001 * chord, "{of}: {}", cut.error);
        assert!(cut.mesh.face_count() <= most, "{of}: {} triangles", cut.mesh.face_count());
        crate::common::no_sliver_of_nothing(&cut.mesh);
        assert_eq!(crate::common::euler(&cut.mesh), 2, "{of}");
        let [a, v] = sizes(&cut.mesh, cone.frame.origin);
        // The mesh is inscribed: what it lacks is a layer as thick as the chord at most.
        assert!(
            (v - volume).abs() <= 1.000_001 * chord * area + 1e-6 * volume,
            "{of}: volume {v} of {volume}"
        );
        assert!((a - area).abs() <= 2.0 * chord * (radius + slant) * TAU, "{of}: area {a} of {area}");
    }
}

#[test]
fn whole_cones_end() {
    let mut random = Random(1);
    for k in 0..COUNT {
        let cone = Cone::of(&mut random, true);
        for seam in [true, false] {
            check(&cone, &cone.whole(seam), k, &format!("cone {k}, seam {seam}"));
        }
    }
}

#[test]
fn sectors_of_cones_end() {
    let mut random = Random(2);
    for k in 0..COUNT {
        let cone = Cone::of(&mut random, false);
        check(&cone, &cone.part(), k, &format!("sector {k}"));
    }
}

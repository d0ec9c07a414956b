//! Animated splines: every frame of the file is as near to the frame's own spline as the report says, measured by an evaluator
//! that is written here by the book (de Boor's recurrence) and shares nothing with the kernel.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use loftsman_gltf::Gltf;
use loftsman_kernel::mesh::{Layer, Mesh, Polyline};
use loftsman_kernel::plugin::{Chord, Fate, Fineness, Format, Memory, ReadOptions, WriteOptions, Written};
use loftsman_kernel::scene::{Animation, Geometry, Object, Scene, Up};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use loftsman_tessellation::Adaptive;

type P = [f64; 3];

fn sub(a: P, b: P) -> P {
    [0, 1, 2].map(|i| a[i] - b[i])
}

fn mix(a: P, b: P, t: f64) -> P {
    [0, 1, 2].map(|i| a[i] + (b[i] - a[i]) * t)
}

fn dot(a: P, b: P) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: P, b: P) -> P {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(a: P) -> f64 {
    dot(a, a).sqrt()
}

/// The point at `u` of the B-spline over these open knots: by the triangular scheme, in homogeneous coordinates.
fn de_boor(p: usize, knots: &[f64], net: &[[f64; 4]], u: f64) -> [f64; 4] {
    let n = net.len();
    let last = (p..n).rev().find(|&k| knots[k] < knots[k + 1]).unwrap();
    let k = (p..n).rev().find(|&k| knots[k] <= u && knots[k] < knots[k + 1]).unwrap_or(last);
    let mut d = net[k - p..=k].to_vec();
    for r in 1..=p {
        for j in (r..=p).rev() {
            let i = j + k - p;
            let t = (u - knots[i]) / (knots[i + p + 1 - r] - knots[i]);
            d[j] = [0, 1, 2, 3].map(|c| (1.0 - t) * d[j - 1][c] + t * d[j][c]);
        }
    }
    d[p]
}

fn project(h: [f64; 4]) -> P {
    [h[0] / h[3], h[1] / h[3], h[2] / h[3]]
}

/// One direction as open knots, and which vertex each basis function has.
struct Line {
    p: usize,
    knots: Vec<f64>,
    vertices: Vec<usize>,
}

impl Line {
    fn open(p: usize, knots: Vec<f64>) -> Self {
        let n = knots.len() - p - 1;
        Self { p, knots, vertices: (0..n).collect() }
    }

    /// Knots of one period, continued by `p` each way; vertex `i`'s function starts at knot `i`.
    fn periodic(p: usize, knots: &[f64]) -> Self {
        let n = knots.len() - 1;
        let period = knots[n] - knots[0];
        let at = |k: isize| {
            let (turn, k) = (k.div_euclid(n as isize), k.rem_euclid(n as isize) as usize);
            knots[k] + turn as f64 * period
        };
        let all = (-(p as isize)..=(n + p) as isize).map(at).collect();
        let vertices = (0..n + p).map(|k| (k + n * p - p) % n).collect();
        Self { p, knots: all, vertices }
    }

    fn space(&self, is_periodic: bool) -> Space {
        if is_periodic {
            let n = self.vertices.len() - self.p;
            Space::periodic(self.p, self.knots[self.p..=self.p + n].to_vec()).unwrap()
        } else {
            Space::open(self.p, self.knots.clone()).unwrap()
        }
    }

    fn domain(&self) -> (f64, f64) {
        (self.knots[self.p], self.knots[self.vertices.len()])
    }

    fn count(&self) -> usize {
        self.vertices.iter().max().unwrap() + 1
    }

    /// Samples of each span, the ends of spans from their own side.
    fn samples(&self, each: usize) -> Vec<Vec<f64>> {
        let n = self.vertices.len();
        let spans = (self.p..n).filter(|&k| self.knots[k] < self.knots[k + 1]);
        let of = |k: usize| {
            let (a, b) = (self.knots[k], self.knots[k + 1]);
            let end = if k + 1 == n { b } else { b - (b - a) * 1e-12 };
            (0..=each).map(|i| (a + (b - a) * i as f64 / each as f64).min(end)).collect()
        };
        spans.map(of).collect()
    }
}

struct Dice(u64);

impl Dice {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn point(&mut self, size: f64) -> P {
        [0; 3].map(|_| size * (2.0 * self.unit() - 1.0))
    }

    /// A direction: clamped, floating or periodic, inner knots repeated up to `most` times.
    fn line(&mut self, p: usize, spans: usize, is_periodic: bool, most: usize) -> Line {
        let (mut at, mut inner) = (0.0, Vec::new());
        for _ in 1..spans {
            at += 0.2 + self.unit();
            let times = if self.below(3) == 0 { 1 + self.below(most) } else { 1 };
            inner.extend(vec![at; times]);
        }
        let end = at + 0.2 + self.unit();
        if is_periodic {
            return Line::periodic(p, &[vec![0.0], inner, vec![end]].concat());
        }
        let knots = if self.below(3) == 0 {
            let before = (0..=p).rev().map(|k| -0.3 * k as f64).collect();
            [before, inner, (0..=p).map(|k| end + 0.25 * k as f64).collect()].concat()
        } else {
            [vec![0.0; p + 1], inner, vec![end; p + 1]].concat()
        };
        Line::open(p, knots)
    }

    fn weights(&mut self, n: usize) -> Option<Vec<f64>> {
        (self.below(3) == 0).then(|| (0..n).map(|_| 10_f64.powf(self.unit() - 0.5)).collect())
    }
}

/// The kinds of motion: how frame `k` of `frames` has its vertices. The first frame of most is nothing to go by.
const KINDS: [&str; 8] = ["wave", "straighten", "fold", "grow", "collapse", "turn", "noise", "still"];

fn frames(kind: &str, count: usize, base: &[P], dice: &mut Dice) -> Vec<Vec<P>> {
    let n = base.len();
    let far: Vec<P> = (0..n).map(|_| dice.point(1.0)).collect();
    let along = |i: usize| i as f64 / (n - 1) as f64;
    let last = (count - 1).max(1) as f64;
    (0..count)
        .map(|k| {
            let s = k as f64 / last;
            let one = |i: usize| -> P {
                match kind {
                    "wave" => [8.0 * along(i), 2.0 * s * (9.0 * along(i)).sin(), 0.0],
                    "straighten" => mix(base[i], [3.0 * along(i), 0.0, 0.0], s),
                    "fold" => {
                        let a = s * 9.0 * along(i);
                        [a.cos() * (1.0 + along(i)), a.sin(), 0.3 * s * along(i)]
                    }
                    "grow" => base[i].map(|x| x * 10_f64.powf(-6.0 * (1.0 - s))),
                    "collapse" => base[i].map(|x| x * (1.0 - s)),
                    "turn" => {
                        [base[i][0] * (3.0 * s).cos() - base[i][1] * (3.0 * s).sin(), base[i][1], base[i][2]]
                    }
                    "noise" => mix(base[i], far[i], (1.7 * k as f64).sin()),
                    _ => base[i],
                }
            };
            (0..n).map(one).collect()
        })
        .collect()
}

fn points(list: &[P]) -> Vec<Point> {
    list.iter().map(|p| Point::from(*p)).collect()
}

/// A file as it was written.
struct File {
    document: gltf::Document,
    blob: Vec<u8>,
    report: Written,
    memory: Memory,
}

fn write(object: Object, fineness: Fineness) -> Result<File, String> {
    let mut scene = Scene::new();
    scene.up = Up::Y;
    scene.add(object).unwrap();
    let tessellator = Adaptive::default();
    let options = WriteOptions { tessellator: Some(&tessellator), fineness, ..WriteOptions::default() };
    let mut memory = Memory::new("a.glb", "");
    let report = Gltf.write(&scene, &mut memory, &options).map_err(|e| e.to_string())?;
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(&memory.bytes).unwrap();
    let report = report.objects.into_iter().next().unwrap();
    Ok(File { document, blob: blob.unwrap_or_default(), report, memory })
}

impl File {
    /// The points of the first primitive as they are before anything moves (by the mesh's weights), and in each frame.
    fn shown(&self) -> (Vec<P>, Vec<Vec<P>>) {
        let (base, frames) = self.base();
        match self.document.meshes().next().unwrap().weights() {
            Some(weights) => {
                let shown: Vec<usize> = (0..weights.len()).filter(|&k| weights[k] != 0.0).collect();
                assert_eq!((weights.len(), &shown[..], weights[0]), (frames.len(), &[0][..], 1.0));
                (frames[0].clone(), frames)
            }
            None => (base, frames),
        }
    }

    /// The points of the first primitive as they are without weights, and in each frame; the node's place added.
    fn base(&self) -> (Vec<P>, Vec<Vec<P>>) {
        let node = self.document.nodes().next().unwrap();
        let (shift, ..) = node.transform().decomposed();
        let primitive = node.mesh().unwrap().primitives().next().unwrap();
        let reader = primitive.reader(|_| Some(&self.blob));
        let wide = |p: [f32; 3]| p.map(f64::from);
        let base: Vec<P> = reader.read_positions().unwrap().map(wide).collect();
        let targets: Vec<Vec<P>> =
            reader.read_morph_targets().map(|(moves, ..)| moves.unwrap().map(wide).collect()).collect();
        let placed = |p: &P| [0, 1, 2].map(|i| p[i] + f64::from(shift[i]));
        let moved = |target: &Vec<P>| {
            base.iter().zip(target).map(|(p, d)| placed(&[0, 1, 2].map(|i| p[i] + d[i]))).collect()
        };
        (base.iter().map(placed).collect(), targets.iter().map(moved).collect())
    }

    /// The strips or triangles, as indices.
    fn parts(&self) -> Vec<Vec<u32>> {
        let node = self.document.nodes().next().unwrap();
        let all = node.mesh().unwrap().primitives().map(|primitive| {
            let reader = primitive.reader(|_| Some(&self.blob));
            match reader.read_indices() {
                Some(indices) => indices.into_u32().collect(),
                None => (0..reader.read_positions().unwrap().count() as u32).collect(),
            }
        });
        all.collect()
    }
}

fn to_segment(p: P, a: P, b: P) -> f64 {
    let (d, e) = (sub(b, a), sub(p, a));
    let square = dot(d, d);
    let t = if square > 0.0 { (dot(d, e) / square).clamp(0.0, 1.0) } else { 0.0 };
    length(sub(e, d.map(|x| x * t)))
}

fn diagonal(list: &[P]) -> f64 {
    let (mut low, mut high) = (list[0], list[0]);
    for p in list {
        for i in 0..3 {
            (low[i], high[i]) = (low[i].min(p[i]), high[i].max(p[i]));
        }
    }
    length(sub(high, low))
}

/// Nearest distances from points in order to chains in order: the next is looked for near the last one, and everywhere where
/// that is not near enough.
fn worst(from: impl Iterator<Item = P>, to: &[[P; 2]], enough: f64) -> f64 {
    let (mut at, mut worst) = (0_usize, 0.0_f64);
    for p in from {
        let window = at.saturating_sub(3)..(at + 4).min(to.len());
        let nearest = |range: std::ops::Range<usize>| {
            range.map(|k| (to_segment(p, to[k][0], to[k][1]), k)).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
        };
        let mut found = nearest(window);
        if found.0 > enough {
            found = nearest(0..to.len());
        }
        at = found.1;
        worst = worst.max(found.0);
    }
    worst
}

#[test]
fn a_line_that_becomes_a_sine_bends_in_the_file() {
    let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 6.0, 6.0, 6.0];
    let net =
        |k: usize| -> Vec<P> { (0..9).map(|i| [i as f64, 0.2 * k as f64 * (i as f64).sin(), 0.0]).collect() };
    let curve = Curve::new(Space::open(3, knots.clone()).unwrap(), points(&net(0))).unwrap();
    let mut object = Object::new("line", curve.into());
    object.animation = Some(Animation { rate: 10.0, frames: (0..11).map(|k| points(&net(k))).collect() });
    let file = write(object, Fineness::default()).unwrap();
    let (start, frames) = file.shown();
    assert!(start.len() > 20 && frames.len() == 11, "{}", start.len());
    assert!(start.iter().all(|p| p[1] == 0.0), "it starts as the first frame");
    let height = |points: &Vec<P>| points.iter().fold(0.0_f64, |m, p| m.max(p[1].abs()));
    assert!(height(&frames[10]) > 1.5);
    let (tolerance, error) = (file.report.tolerance.unwrap(), file.report.error.unwrap());
    assert!(error > 0.0 && error <= tolerance, "{error} {tolerance}");
    let line = Line::open(3, knots);
    let homogeneous: Vec<[f64; 4]> = net(10).iter().map(|p| [p[0], p[1], p[2], 1.0]).collect();
    let segments: Vec<[P; 2]> = frames[10].windows(2).map(|p| [p[0], p[1]]).collect();
    let at = |u: f64| project(de_boor(3, &line.knots, &homogeneous, u));
    let off = worst(line.samples(200).concat().into_iter().map(at), &segments, error);
    assert!(off <= error + 1e-6, "{off} {error}");
}

#[test]
fn every_frame_of_curves_of_all_kinds_is_within_the_reported_error() {
    let mut dice = Dice(7);
    let (mut members, mut torn, mut refused, mut bends) = (0, 0, 0, 0);
    for member in 0..160 {
        let p = [1, 2, 3, 4, 5, 6, 7, 25][dice.below(8)];
        let is_periodic = dice.below(3) == 0;
        let most = if is_periodic { p } else { p + 1 };
        let spans = 2 + dice.below(4);
        let line = dice.line(p, spans, is_periodic, most);
        let n = line.count();
        if is_periodic && n < 2 {
            continue;
        }
        let base: Vec<P> = (0..n).map(|_| dice.point(1.0)).collect();
        let kind = KINDS[member % KINDS.len()];
        let count = 1 + dice.below(7);
        let moved = frames(kind, count, &base, &mut dice);
        let weights = dice.weights(n);
        let curve = Curve::build(line.space(is_periodic), points(&base), weights.clone()).unwrap();
        let mut object = Object::new("c", curve.into());
        object.animation = Some(Animation { rate: 24.0, frames: moved.iter().map(|f| points(f)).collect() });
        let chord = [Chord::Relative(1e-3), Chord::Relative(2e-2), Chord::Absolute(1e-2)][dice.below(3)];
        let file = match write(object.clone(), Fineness { chord, angle: 1.0 }) {
            Ok(file) => file,
            Err(problem) => panic!("{member} {kind} {p}: {problem}"),
        };
        if file.document.meshes().count() == 0 {
            // Nothing to be seen in any frame.
            // Nothing, or what is within the tolerance of a point.
            let least = match chord {
                Chord::Relative(_) => 0.0,
                Chord::Absolute(length) => length,
            };
            assert!(moved.iter().all(|f| diagonal(f) <= least), "{member} {kind}");
            refused += 1;
            continue;
        }
        members += 1;
        let (start, found) = file.shown();
        assert_eq!(found.len(), count);
        for (a, b) in start.iter().zip(&found[0]) {
            assert!(length(sub(*a, *b)) <= 1e-6, "{member} {kind}: it does not start as its first frame");
        }
        let (tolerance, error) = (file.report.tolerance.unwrap(), file.report.error.unwrap());
        assert!(error <= tolerance * (1.0 + 1e-9), "{member} {kind}: {error} {tolerance}");
        let parts = file.parts();
        torn += usize::from(parts.len() > 1);
        let size = moved.iter().map(|f| diagonal(f)).fold(0.0, f64::max);
        for (k, (frame, shown)) in moved.iter().zip(&found).enumerate() {
            let weight = |i: usize| weights.as_ref().map_or(1.0, |w| w[i]);
            let net: Vec<[f64; 4]> = line
                .vertices
                .iter()
                .map(|&i| {
                    [frame[i][0] * weight(i), frame[i][1] * weight(i), frame[i][2] * weight(i), weight(i)]
                })
                .collect();
            let at = |u: f64| project(de_boor(p, &line.knots, &net, u));
            let exact: Vec<Vec<P>> =
                line.samples(150).iter().map(|span| span.iter().map(|&u| at(u)).collect()).collect();
            let segments = |chain: &[P]| -> Vec<[P; 2]> { chain.windows(2).map(|p| [p[0], p[1]]).collect() };
            let of_curve: Vec<[P; 2]> = exact.iter().flat_map(|span| segments(span)).collect();
            let of_file: Vec<[P; 2]> = parts
                .iter()
                .flat_map(|strip| segments(&strip.iter().map(|&i| shown[i as usize]).collect::<Vec<_>>()))
                .collect();
            // A state is held to its own size, of which what is a thousandth of the largest is as small as it counts.
            let own = match chord {
                Chord::Relative(part) => part * diagonal(&exact.concat()).max(1e-3 * size) * 1.01,
                Chord::Absolute(length) => length,
            };
            let promised = error.min(own);
            // Single precision, and the samples that stand for the curve.
            let slack = 1e-6 * size + 1e-3 * promised;
            let forth = worst(exact.concat().into_iter(), &of_file, promised);
            assert!(
                forth <= promised + slack,
                "{member} {kind} frame {k} of degree {p}: {forth} {error} {own}"
            );
            let steps = |s: &[P; 2]| [0.0, 0.25, 0.5, 0.75, 1.0].map(|t| mix(s[0], s[1], t));
            let back = worst(of_file.iter().flat_map(steps), &of_curve, promised);
            // The curve between samples is off their chord by an eighth of the second difference.
            let second = |w: &[P]| length([0, 1, 2].map(|c| w[0][c] - 2.0 * w[1][c] + w[2][c])) / 8.0;
            let coarse = exact.iter().flat_map(|span| span.windows(3).map(second)).fold(0.0, f64::max);
            assert!(
                back <= promised + slack + 1.5 * coarse,
                "back: {member} {kind} frame {k} of degree {p}: {back} {error} {own}"
            );
            bends += usize::from(forth > 0.05 * tolerance);
        }
        // The exact curve and its exact frames come back from extras.
        let (scene, _) = Gltf.read(&file.memory, &ReadOptions::default()).unwrap();
        assert_eq!(scene.objects()[0].animation, object.animation, "{member} {kind}");
        assert_eq!(scene.objects()[0].geometry(), object.geometry(), "{member} {kind}");
    }
    assert!(
        members >= 120 && torn >= 10 && refused <= 10 && bends > 100,
        "{members} {torn} {refused} {bends}"
    );
}

#[test]
fn every_frame_of_surfaces_is_within_the_reported_error() {
    let mut dice = Dice(11);
    let (mut members, mut unseen) = (0, 0);
    for member in 0..40 {
        let degrees = [1, 2, 3, 4];
        let (p, q) = (degrees[dice.below(4)], degrees[dice.below(4)]);
        let periodic = [dice.below(4) == 0, dice.below(4) == 0];
        let (su, sv) = (2 + dice.below(2), 2 + dice.below(2));
        let u = dice.line(p, if periodic[0] { su + 2 } else { su }, periodic[0], p);
        let v = dice.line(q, if periodic[1] { sv + 2 } else { sv }, periodic[1], q);
        let (nu, nv) = (u.count(), v.count());
        let base: Vec<P> = (0..nu * nv)
            .map(|k| {
                let noise = dice.point(0.2);
                [(k / nv) as f64 + noise[0], (k % nv) as f64 + noise[1], noise[2]]
            })
            .collect();
        let count = 2 + dice.below(3);
        let kind = member % 5;
        let moved: Vec<Vec<P>> = (0..count)
            .map(|f| {
                let s = f as f64 / (count - 1) as f64;
                let one = |k: usize| -> P {
                    let [x, y, z] = base[k];
                    match kind {
                        // Flat becomes wavy; a point grows; rolled up; one side closes to a pole; a fold.
                        0 => [x, y, s * (1.5 * x).sin() * y.cos()],
                        1 => [x, y, z].map(|c| c * s),
                        2 => [x, (1.0 + y) * (2.0 * s * y).cos(), (1.0 + y) * (2.0 * s * y).sin()],
                        3 => [x, y * (1.0 - s * (1.0 - x / nu as f64).powi(2)), z],
                        _ => [x * (1.0 - 1.6 * s) + s * z, y, z + s * x * x * 0.3],
                    }
                };
                (0..nu * nv).map(one).collect()
            })
            .collect();
        let weights = dice.weights(nu * nv);
        let build = |list: &[P]| {
            Surface::build(u.space(periodic[0]), v.space(periodic[1]), points(list), weights.clone()).unwrap()
        };
        let mut object = Object::new("s", build(&base).into());
        object.animation = Some(Animation { rate: 24.0, frames: moved.iter().map(|f| points(f)).collect() });
        let chord = Chord::Relative([1e-2, 3e-3][dice.below(2)]);
        let file = match write(object.clone(), Fineness { chord, angle: 1.5 }) {
            Ok(file) => file,
            Err(problem) => panic!("{member} of kind {kind}: {problem}"),
        };
        if file.document.meshes().count() == 0 {
            unseen += 1;
            continue;
        }
        members += 1;
        let (start, found) = file.shown();
        for (a, b) in start.iter().zip(&found[0]) {
            assert!(length(sub(*a, *b)) <= 1e-5, "{member}: it does not start as its first frame");
        }
        let (tolerance, error) = (file.report.tolerance.unwrap(), file.report.error.unwrap());
        assert!(error > 0.0 && error <= tolerance * (1.0 + 1e-9), "{member}: {error} {tolerance}");
        let triangles: Vec<[u32; 3]> = file.parts().concat().chunks(3).map(|t| [t[0], t[1], t[2]]).collect();
        let primitive = file.document.meshes().next().unwrap().primitives().next().unwrap();
        let uvs: Vec<[f64; 2]> = primitive
            .reader(|_| Some(&file.blob))
            .read_tex_coords(0)
            .unwrap()
            .into_f32()
            .map(|[s, t]| [f64::from(s), 1.0 - f64::from(t)])
            .collect();
        let ((u0, u1), (v0, v1)) = (u.domain(), v.domain());
        for (frame, shown) in moved.iter().zip(&found) {
            let weight = |k: usize| weights.as_ref().map_or(1.0, |w| w[k]);
            let net: Vec<Vec<[f64; 4]>> = (u.vertices.iter())
                .map(|&i| {
                    let at = |&j: &usize| {
                        let (k, w) = (i * nv + j, weight(i * nv + j));
                        [frame[k][0] * w, frame[k][1] * w, frame[k][2] * w, w]
                    };
                    v.vertices.iter().map(at).collect()
                })
                .collect();
            let at = |s: f64, t: f64| -> P {
                let (a, b) = (u0 + (u1 - u0) * s.clamp(0.0, 1.0), v0 + (v1 - v0) * t.clamp(0.0, 1.0));
                let column: Vec<[f64; 4]> = net.iter().map(|row| de_boor(q, &v.knots, row, b)).collect();
                project(de_boor(p, &u.knots, &column, a))
            };
            let size = diagonal(frame);
            for triangle in &triangles {
                let corners = triangle.map(|i| shown[i as usize]);
                let places = triangle.map(|i| uvs[i as usize]);
                for share in
                    [[1.0 / 3.0; 3], [0.6, 0.2, 0.2], [0.2, 0.6, 0.2], [0.5, 0.5, 0.0], [0.0, 0.5, 0.5]]
                {
                    let sum = |c: usize| (0..3).map(|k| share[k] * corners[k][c]).sum::<f64>();
                    let on = [0, 1, 2].map(sum);
                    let place = [0, 1].map(|c| (0..3).map(|k| share[k] * places[k][c]).sum::<f64>());
                    let off = nearest(&at, place, on, error);
                    assert!(
                        off <= error * 1.001 + 1e-6 * (1.0 + size),
                        "{member} of kind {kind}: {off} {error} at {place:?}"
                    );
                }
            }
        }
        let (scene, _) = Gltf.read(&file.memory, &ReadOptions::default()).unwrap();
        assert_eq!(scene.objects()[0].animation, object.animation, "{member}");
    }
    assert!(members >= 36 && unseen <= 4, "{members} {unseen}");
}

/// The distance to the surface, looked for from parameters near it by a pattern search; where that is not near enough, from
/// the best of parameters everywhere.
fn nearest(at: &impl Fn(f64, f64) -> P, place: [f64; 2], to: P, enough: f64) -> f64 {
    let off = |[s, t]: [f64; 2]| length(sub(at(s, t), to));
    let search = |from: [f64; 2], wide: f64| {
        let (mut best, mut from, mut step) = (off(from), from, wide);
        while best > enough && step > 1e-7 {
            let around = [
                [step, 0.0],
                [-step, 0.0],
                [0.0, step],
                [0.0, -step],
                [step, step],
                [-step, -step],
                [step, -step],
                [-step, step],
            ];
            let moved = around.map(|d| [(from[0] + d[0]).clamp(0.0, 1.0), (from[1] + d[1]).clamp(0.0, 1.0)]);
            let found = moved.map(|at| (off(at), at)).into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
            if found.0 < best { (best, from) = found } else { step *= 0.5 }
        }
        best
    };
    // Small steps first: large ones may leap to another layer of the surface.
    let near =
        [4e-4, 2e-3, 1e-2, 0.05].map(|wide| search(place, wide)).into_iter().fold(f64::INFINITY, f64::min);
    if near <= enough {
        return near;
    }
    let mut starts: Vec<(f64, [f64; 2])> = (0..=60)
        .flat_map(|i| (0..=60).map(move |j| [f64::from(i) / 60.0, f64::from(j) / 60.0]))
        .map(|at| (off(at), at))
        .collect();
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    starts[..24].iter().map(|(_, at)| search(*at, 4e-3)).fold(near, f64::min)
}

#[test]
fn what_is_no_spline_starts_as_its_first_frame_too_and_comes_back_as_it_was() {
    let line = |y: f64| -> Vec<Point> {
        (0..5).map(|i| Point::new(f64::from(i), y * f64::from(i * i), 0.0)).collect()
    };
    let mut object = Object::new("chain", Polyline { points: line(1.0), closed: false }.into());
    object.animation = Some(Animation { rate: 24.0, frames: vec![line(0.0), line(0.5), line(1.0)] });
    let file = write(object.clone(), Fineness::default()).unwrap();
    let mesh = file.document.meshes().next().unwrap();
    assert_eq!(mesh.weights(), Some([1.0, 0.0, 0.0].as_slice()));
    let (base, frames) = file.base();
    assert!(base[4][1] == 16.0 && frames[0][4][1] == 0.0 && frames[1][4][1] == 8.0);
    let (scene, report) = Gltf.read(&file.memory, &ReadOptions::default()).unwrap();
    assert_eq!(scene.objects()[0].geometry(), object.geometry());
    assert_eq!(scene.objects()[0].animation, object.animation);
    assert!(report.left_out.is_empty());
}

/// A rope, a sheet and a mesh alike: without their animation they are what the object is, which is a frame of it or none; the weights show the
/// first frame.
#[test]
fn the_base_of_all_that_moves_is_the_shape_itself() {
    let space = || Space::clamped_uniform(2, 4).unwrap();
    let net = |bend: f64| -> Vec<Point> {
        let at = |k: usize| Point::new((k / 4) as f64, (k % 4) as f64, bend * ((k / 4) * (k / 4)) as f64);
        (0..16).map(at).collect()
    };
    let faces: Vec<[usize; 4]> = (0..9)
        .map(|k| {
            let a = k / 3 * 4 + k % 3;
            [a, a + 4, a + 5, a + 1]
        })
        .collect();
    let line = |bend: f64| -> Vec<Point> { net(bend).into_iter().step_by(4).collect() };
    let curve = |bend: f64| Geometry::from(Curve::new(space(), line(bend)).unwrap());
    let sheet = |bend: f64| Geometry::from(Surface::new(space(), space(), net(bend)).unwrap());
    let mesh = |bend: f64| {
        let mut mesh = Mesh::new(net(bend), &faces).unwrap();
        mesh.normals = Layer::per_point(vec![Vector::z(); 16]);
        Geometry::from(mesh.moved(net(bend)).unwrap())
    };
    type Made<'a> = &'a dyn Fn(f64) -> Geometry;
    type Points<'a> = &'a dyn Fn(f64) -> Vec<Point>;
    let kinds: [(Made<'_>, Points<'_>); 3] = [(&curve, &line), (&sheet, &net), (&mesh, &net)];
    for (number, (made, points)) in kinds.into_iter().enumerate() {
        // It is its last frame; none of them; the first.
        for own in [1.0, 2.0, 0.0] {
            let mut object = Object::new("it", made(own));
            let frames = vec![points(0.0), points(0.5), points(1.0)];
            object.animation = Some(Animation { rate: 24.0, frames });
            let fine = Fineness { chord: Chord::Absolute(1e-3), ..Fineness::default() };
            let file = write(object.clone(), fine).unwrap();
            let (base, shown) = file.base();
            assert_eq!(shown.len(), 3);
            // The far edge lies 9 times the bend up.
            let high = |of: &[P]| of.iter().map(|p| p[2]).fold(f64::NEG_INFINITY, f64::max);
            assert!((high(&base) - 9.0 * own).abs() < 1e-5, "{number} {own}: {}", high(&base));
            for (frame, bend) in shown.iter().zip([0.0, 0.5, 1.0]) {
                assert!((high(frame) - 9.0 * bend).abs() < 1e-5, "{number} {own}: {}", high(frame));
            }
            let weights = file.document.meshes().next().unwrap().weights().map(<[f32]>::to_vec);
            assert_eq!(weights, (own != 0.0).then(|| vec![1.0, 0.0, 0.0]), "{number} {own}");
            let (scene, report) = Gltf.read(&file.memory, &ReadOptions::default()).unwrap();
            let back = &scene.objects()[0];
            assert_eq!(back.geometry().points(), object.geometry().points(), "{number} {own}");
            assert_eq!(back.animation, object.animation, "{number} {own}");
            assert!(
                report.left_out.keys().all(|reason| reason.starts_with("normals")),
                "{:?}",
                report.left_out
            );
        }
    }
}

/// Where faces are flat that bend later, normals are a millionth shorter: Blender would take such faces for flat ones, and leave them so in all
/// frames. What is to look flat (a face with points of its own) keeps its normals.
#[test]
fn what_is_flat_at_first_looks_smooth_when_it_bends() {
    let product = |file: &File| -> f64 {
        let primitive = file.document.meshes().next().unwrap().primitives().next().unwrap();
        let reader = primitive.reader(|_| Some(&file.blob));
        let points: Vec<P> = reader.read_positions().unwrap().map(|p| p.map(f64::from)).collect();
        let normals: Vec<[f32; 3]> = reader.read_normals().unwrap().collect();
        // Of each triangle the least product of its normal with those of its corners; of these the largest, as Blender looks at them.
        let triangles = file.parts().concat();
        let of = |t: &[u32]| {
            let [a, b, c] = [0, 1, 2].map(|k| points[t[k] as usize]);
            let across = cross(sub(b, a), sub(c, a));
            let own = |&p: &u32| dot(normals[p as usize].map(f64::from), across) / length(across);
            t.iter().map(own).fold(f64::INFINITY, f64::min)
        };
        triangles.chunks_exact(3).map(of).fold(0.0, f64::max)
    };
    let net = |bend: f64| -> Vec<Point> {
        let at = |k: usize| Point::new((k / 4) as f64, (k % 4) as f64, bend * ((k / 4) * (k / 4)) as f64);
        (0..16).map(at).collect()
    };
    let space = || Space::clamped_uniform(2, 4).unwrap();
    let mut sheet = Object::new("sheet", Surface::new(space(), space(), net(0.0)).unwrap().into());
    let still = write(sheet.clone(), Fineness::default()).unwrap();
    assert!(product(&still) > 0.999_999_9, "{}", product(&still));
    sheet.animation = Some(Animation { rate: 24.0, frames: vec![net(0.0), net(0.3)] });
    let moving = write(sheet, Fineness::default()).unwrap();
    assert!((0.999_998..0.999_999_8).contains(&product(&moving)), "{}", product(&moving));
    // In each frame the sum is as long again.
    let primitive = moving.document.meshes().next().unwrap().primitives().next().unwrap();
    let reader = primitive.reader(|_| Some(&moving.blob));
    let base: Vec<[f32; 3]> = reader.read_normals().unwrap().collect();
    for (_, normals, _) in reader.read_morph_targets() {
        for (base, delta) in base.iter().zip(normals.unwrap()) {
            let long = length([0, 1, 2].map(|k| f64::from(base[k] + delta[k])));
            assert!((long - 1.0).abs() < 2e-6, "{long}");
        }
    }
    // Two triangles that share no point.
    let corners = |bend: f64| {
        [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
            .map(|[x, y]| Point::new(x, y, bend * x * y))
            .to_vec()
    };
    let mut mesh = Mesh::new(corners(0.0), &[[0, 1, 2], [3, 4, 5]]).unwrap();
    mesh.normals = Layer::per_point(vec![Vector::z(); 6]);
    let mut roof = Object::new("roof", mesh.into());
    roof.animation = Some(Animation { rate: 24.0, frames: vec![corners(0.0), corners(0.5)] });
    assert_eq!(product(&write(roof, Fineness::default()).unwrap()), 1.0);
}

#[test]
fn what_cannot_be_cut_finely_enough_is_refused_at_once_with_its_name() {
    // Weights of which the larger is the other's square of all numbers; and less wild ones, curves and surfaces.
    let start = std::time::Instant::now();
    let net =
        |n: usize| -> Vec<Point> { (0..n).map(|k| Point::new(k as f64, (k % 2) as f64, 0.0)).collect() };
    let (mut refused, mut shown) = (0, 0);
    for heavy in [1e308, 1e200, 1e40, 1e17] {
        for light in [1e-308, 1e-100, 1e-17] {
            let clamped = |weights: [f64; 6]| {
                Curve::rational(Space::clamped_uniform(3, 6).unwrap(), net(6), weights.to_vec()).ok()
            };
            for weights in [
                [1.0, 1.0, heavy, light, 1.0, 1.0],
                [light, heavy, 1.0, 1.0, 1.0, 1.0],
                [heavy, heavy, heavy, light, light, light],
            ] {
                let Some(curve) = clamped(weights) else {
                    refused += 1;
                    continue;
                };
                let space = Space::clamped_uniform(3, 6).unwrap();
                let across = Space::clamped_uniform(1, 2).unwrap();
                let points: Vec<Point> =
                    net(6).iter().flat_map(|p| [*p, Point::new(p.x, p.y, 1.0)]).collect();
                let weights = weights.iter().flat_map(|w| [*w, *w]).collect();
                let surface = Surface::rational(space, across, points, weights).unwrap();
                for geometry in [Geometry::from(curve), surface.into()] {
                    match write(Object::new("wild", geometry), Fineness::default()) {
                        Ok(file) => {
                            assert_eq!(
                                file.document.meshes().count(),
                                1,
                                "an empty node: {heavy:e} {light:e}"
                            );
                            shown += 1;
                        }
                        Err(problem) => {
                            assert!(problem.contains("wild") && problem.contains("weights"), "{problem}");
                            refused += 1;
                        }
                    }
                }
            }
        }
    }
    assert!(
        refused >= 36 && shown <= 24 && start.elapsed().as_secs() < 20,
        "{refused} {shown} {:?}",
        start.elapsed()
    );
    // What is only unlike is shown.
    let weights = vec![1.0, 1.0, 1e6, 1e-6, 1.0, 1.0];
    let curve = Curve::rational(Space::clamped_uniform(3, 6).unwrap(), net(6), weights).unwrap();
    let file = write(Object::new("unlike", curve.into()), Fineness::default()).unwrap();
    assert_eq!((file.report.fate, file.document.meshes().count()), (Fate::Approximated, 1));
}

/// A sheet of five by five points with a seam in its texture coordinates, normals by corner; turned about x by so many degrees.
fn turned_sheet(degrees: f64) -> (Vec<Point>, [f64; 3]) {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let at = |k: usize| {
        let (x, y) = ((k % 5) as f64, (k / 5) as f64);
        Point::new(x, y * cosine, y * sine)
    };
    ((0..25).map(at).collect(), [0.0, -sine, cosine])
}

#[test]
fn normals_turn_with_the_faces_of_each_frame() {
    let mut faces = Vec::new();
    for row in 0..4 {
        for column in 0..4 {
            let a = 5 * row + column;
            faces.push([a, a + 1, a + 6, a + 5]);
        }
    }
    let mut mesh = Mesh::new(turned_sheet(0.0).0, &faces).unwrap();
    mesh.normals = Layer::per_corner(vec![Vector::z()], vec![0; 64]);
    // Every face has a corner of the texture of its own: most points are doubled.
    mesh.uvs = Layer::per_corner(
        (0..64).map(|k| [f64::from(k) / 64.0, 0.25 * f64::from(k % 4)]).collect(),
        (0..64).collect(),
    );
    let turns = [0.0, 10.0, 45.0, 90.0, 170.0, -60.0];
    let mut object = Object::new("sheet", mesh.into());
    let frames = turns.iter().map(|turn| turned_sheet(*turn).0).collect();
    object.animation = Some(Animation { rate: 10.0, frames });
    let file = write(object, Fineness::default()).unwrap();
    let primitive = file.document.meshes().next().unwrap().primitives().next().unwrap();
    let reader = primitive.reader(|_| Some(&file.blob));
    let base: Vec<[f32; 3]> = reader.read_normals().unwrap().collect();
    assert_eq!(base.len(), 64, "points are doubled");
    let mut seen = 0;
    for ((_, normals, _), turn) in reader.read_morph_targets().zip(turns) {
        let expected = turned_sheet(turn).1;
        for (base, delta) in base.iter().zip(normals.unwrap()) {
            let found = [0, 1, 2].map(|i| f64::from(base[i] + delta[i]));
            assert!(length(sub(found, expected)) < 1e-6, "{turn} degrees: {found:?} for {expected:?}");
            seen += 1;
        }
    }
    assert_eq!(seen, 64 * turns.len());
    // What has no normals has none in its frames, and lines neither.
    let mut bare = Mesh::new(turned_sheet(0.0).0, &faces).unwrap();
    bare.set_lines(vec![0, 24], vec![0, 2]).unwrap();
    let mut object = Object::new("sheet", bare.into());
    object.animation = Some(Animation { rate: 10.0, frames: vec![turned_sheet(30.0).0; 2] });
    let file = write(object, Fineness::default()).unwrap();
    for primitive in file.document.meshes().flat_map(|mesh| mesh.primitives().collect::<Vec<_>>()) {
        assert!(primitive.morph_targets().all(|target| target.normals().is_none()));
    }
}

#[test]
fn surfaces_have_the_normals_of_their_frames() {
    // A plane that becomes a cylinder: normals of the last frame are those of the cylinder to a few degrees.
    let (count, spans) = (9, 6);
    let knots: Vec<f64> =
        [vec![0.0; 3], (0..=spans).map(f64::from).collect(), vec![f64::from(spans); 3]].concat();
    let space = Space::open(3, knots).unwrap();
    let net = |bend: f64| -> Vec<Point> {
        (0..count * count)
            .map(|k| {
                let (x, y) = ((k / count) as f64 * 0.25, (k % count) as f64 * 0.25);
                if bend == 0.0 {
                    return Point::new(x, y, 0.0);
                }
                Point::new((bend * x).sin() / bend, y, (1.0 - (bend * x).cos()) / bend)
            })
            .collect()
    };
    let surface = Surface::new(space.clone(), space, net(0.0)).unwrap();
    let mut object = Object::new("sheet", surface.into());
    object.animation = Some(Animation { rate: 10.0, frames: vec![net(0.0), net(0.5), net(1.0)] });
    let fine = Fineness { chord: Chord::Absolute(1e-3), ..Fineness::default() };
    let file = write(object, fine).unwrap();
    assert!(file.report.reason.iter().all(|reason| !reason.contains("normals")), "{:?}", file.report);
    let primitive = file.document.meshes().next().unwrap().primitives().next().unwrap();
    let reader = primitive.reader(|_| Some(&file.blob));
    let base: Vec<[f32; 3]> = reader.read_normals().unwrap().collect();
    let (_, frames) = file.shown();
    let (_, normals, _) = reader.read_morph_targets().nth(2).unwrap();
    let mut worst = 0.0_f64;
    for ((p, base), delta) in frames[2].iter().zip(&base).zip(normals.unwrap()) {
        let found = [0, 1, 2].map(|i| f64::from(base[i] + delta[i]));
        // The axis of the cylinder is at height 1; the spline is a little inside of its vertices.
        let out = [-p[0], 0.0, 1.0 - p[2]];
        let cosine = dot(found, out) / length(out) / length(found);
        worst = worst.max(cosine.abs().clamp(-1.0, 1.0).acos().to_degrees());
    }
    // At its edges faces are on one side only: half of the angle that neighbouring normals may differ by.
    assert!(worst < 8.5, "{worst} degrees");
}

#[test]
fn what_stands_still_takes_no_room() {
    // One point of a thousand moves in each frame.
    let base: Vec<Point> = (0..1000).map(|k| Point::new(f64::from(k), 0.0, 0.0)).collect();
    let moved = |k: usize| {
        let mut frame = base.clone();
        frame[7 * k].y = 1.0 + k as f64;
        frame
    };
    let mut object = Object::new("line", Polyline { points: base.clone(), closed: false }.into());
    let frames: Vec<_> = std::iter::once(base.clone()).chain((1..100).map(moved)).collect();
    object.animation = Some(Animation { rate: 24.0, frames: frames.clone() });
    let file = write(object, Fineness::default()).unwrap();
    let size = file.memory.bytes.len();
    assert!(size < 80_000, "{size} bytes for what takes 1.2 million in full");
    let (_, shown) = file.shown();
    for (frame, shown) in frames.iter().zip(&shown) {
        assert!(frame.iter().zip(shown).all(|(p, q)| length(sub([p.x, p.y, p.z], *q)) < 1e-4));
    }
    let (scene, _) = Gltf.read(&file.memory, &ReadOptions::default()).unwrap();
    let back = scene.objects()[0].animation.as_ref().unwrap();
    assert_eq!((back.rate, back.frames.len()), (24.0, 100));
    assert_eq!(back.frames[99][7 * 99].y, 100.0);
    // Weights grow with the number of frames, not with its square.
    let frames = |count: usize| {
        let mut object = Object::new("line", Polyline { points: base[..2].to_vec(), closed: false }.into());
        let frame = |k: usize| vec![Point::origin(), Point::new(1.0, k as f64, 0.0)];
        object.animation = Some(Animation { rate: 24.0, frames: (0..count).map(frame).collect() });
        write(object, Fineness::default()).unwrap().memory.bytes.len()
    };
    let (few, many) = (frames(100), frames(2000));
    assert!(many < 25 * few, "{few} bytes for 100 frames, {many} for 2000");
}

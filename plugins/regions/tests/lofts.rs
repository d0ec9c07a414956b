//! Lofts of families of sections: any start, any sense, any knots, measured by an evaluator that shares nothing with the
//! kernel but the numbers.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests may fail the test")]

use std::f64::consts::{PI, TAU};

use loftsman_kernel::plugin::{Context, OperationError, Parameters, Registry, StepReport};
use loftsman_kernel::scene::{Object, Scene};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use loftsman_regions::{Lofted, Regions, loft};
use loftsman_tessellation::Tessellation;
use serde_json::{Value, json};

/// Numbers that look random and are the same every time (splitmix64).
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

    fn below(&mut self, count: usize) -> usize {
        ((self.next() * count as f64) as usize).min(count - 1)
    }
}

/// De Boor's algorithm by the book, in homogeneous coordinates, on a flat knot vector; `net(k)` is coefficient `k`.
fn de_boor(degree: usize, flat: &[f64], net: &dyn Fn(usize) -> [f64; 4], u: f64) -> [f64; 4] {
    let count = flat.len() - degree - 1;
    let mut span = degree;
    while span + 1 < count && flat[span + 1] <= u {
        span += 1;
    }
    let mut d: Vec<[f64; 4]> = (0..=degree).map(|j| net(span - degree + j)).collect();
    for r in 1..=degree {
        for j in (r..=degree).rev() {
            let (low, high) = (flat[span + j - degree], flat[span + 1 + j - r]);
            let a = (u - low) / (high - low);
            for c in 0..4 {
                d[j][c] = (1.0 - a) * d[j - 1][c] + a * d[j][c];
            }
        }
    }
    d[degree]
}

fn homogeneous(p: &Point, w: f64) -> [f64; 4] {
    [p.x * w, p.y * w, p.z * w, w]
}

fn projected(h: [f64; 4]) -> Point {
    Point::new(h[0] / h[3], h[1] / h[3], h[2] / h[3])
}

/// The vertex of coefficient `k`: a period starts `degree` coefficients in.
fn vertex(space: &Space, k: usize) -> usize {
    if space.is_periodic() { (k + space.len() * 30 - space.degree()) % space.len() } else { k }
}

fn on_curve(curve: &Curve, share: f64) -> Point {
    let (a, b) = curve.domain();
    let net = |k: usize| {
        let i = vertex(curve.space(), k);
        homogeneous(&curve.points()[i], curve.weights().map_or(1.0, |w| w[i]))
    };
    projected(de_boor(curve.degree(), curve.space().flat(), &net, a + share * (b - a)))
}

/// The ring of points of a surface at `v`, at so many shares of `u`.
fn ring(surface: &Surface, v: f64, shares: &[f64]) -> Vec<Point> {
    let (su, sv) = (surface.u(), surface.v());
    let line: Vec<[f64; 4]> = (0..su.len())
        .map(|i| {
            let net = |k: usize| {
                let at = i * sv.len() + vertex(sv, k);
                homogeneous(&surface.points()[at], surface.weights().map_or(1.0, |w| w[at]))
            };
            de_boor(sv.degree(), sv.flat(), &net, v)
        })
        .collect();
    let (a, b) = su.domain();
    let at = |&s: &f64| projected(de_boor(su.degree(), su.flat(), &|k| line[vertex(su, k)], a + s * (b - a)));
    shares.iter().map(at).collect()
}

/// The volume between rings, capped by fans: the divergence theorem on triangles.
fn volume_of(rings: &[Vec<Point>]) -> f64 {
    let origin = rings[0][0];
    let six = |a: &Point, b: &Point, c: &Point| (a - origin).dot(&(b - origin).cross(&(c - origin)));
    let mut sum = 0.0;
    for pair in rings.windows(2) {
        for i in 0..pair[0].len() {
            let j = (i + 1) % pair[0].len();
            let (a, b, c, d) = (&pair[0][i], &pair[0][j], &pair[1][j], &pair[1][i]);
            sum += six(a, b, c) + six(a, c, d);
        }
    }
    for (ring, sign) in [(&rings[0], -1.0), (&rings[rings.len() - 1], 1.0)] {
        for i in 1..ring.len() - 1 {
            sum += sign * six(&ring[0], &ring[i], &ring[i + 1]);
        }
    }
    (sum / 6.0).abs()
}

const AROUND: usize = 160;

fn shares() -> Vec<f64> {
    (0..AROUND).map(|i| (i as f64 + 0.5) / AROUND as f64).collect()
}

/// The volume of a loft, from its numbers alone.
fn volume_of_loft(lofted: &Lofted) -> f64 {
    let mut vs = Vec::new();
    for pair in lofted.parameters.windows(2) {
        vs.extend((0..10).map(|i| pair[0] + (pair[1] - pair[0]) * f64::from(i) / 10.0));
    }
    vs.push(1.0);
    volume_of(&vs.iter().map(|&v| ring(&lofted.surface, v, &shares())).collect::<Vec<_>>())
}

/// The volume between sections as they stand, joined by straight lines at equal shares of their parameters.
fn volume_between(sections: &[Curve]) -> f64 {
    let rings: Vec<Vec<Point>> =
        sections.iter().map(|s| shares().iter().map(|&t| on_curve(s, t)).collect()).collect();
    // A hyperbolic paraboloid is no two triangles: many strips.
    let mut fine = Vec::new();
    for pair in rings.windows(2) {
        for k in 0..10 {
            let t = f64::from(k) / 10.0;
            fine.push(pair[0].iter().zip(&pair[1]).map(|(p, q)| p + (q - p) * t).collect());
        }
    }
    fine.push(rings[rings.len() - 1].clone());
    volume_of(&fine)
}

/// How far a loft is from a section as it was given, by the aligner's own account of what it did to it.
fn missed(lofted: &Lofted, section: &Curve, k: usize) -> f64 {
    let change = lofted.sections[k];
    let on = ring(&lofted.surface, lofted.parameters[k], &shares());
    let mut worst = 0.0_f64;
    for (share, on) in shares().into_iter().zip(on) {
        let forward = (share + change.turned).rem_euclid(1.0);
        let own = if change.reversed { 1.0 - forward } else { forward };
        worst = worst.max((on_curve(section, own) - on).norm());
    }
    worst
}

/// A closed section that starts on its own x axis, runs from x to y, and mirrors itself in that axis.
fn section(random: &mut Random, place: &dyn Fn(f64, f64) -> Point) -> Curve {
    let (a, b) = (random.within(0.7, 1.5), random.within(0.7, 1.5));
    let kind = random.below(5);
    if kind == 0 {
        let centre = place(0.0, 0.0);
        let (x, y) = (place(a, 0.0) - centre, place(0.0, b) - centre);
        return Curve::elliptic_arc(centre, x, y, 0.0, TAU).unwrap();
    }
    let (degree, count) = match kind {
        1 => (1, 3 + random.below(6)),
        _ => (2 + random.below(4), 5 + random.below(26)),
    };
    let space = Space::periodic_uniform(degree, count).unwrap();
    let at = |k: usize| {
        let (sin, cos) = (TAU * (k as f64 + 0.5 * (degree + 1) as f64) / count as f64).sin_cos();
        place(a * cos, b * sin)
    };
    let ring = Curve::new(space, (0..count).map(at).collect()).unwrap();
    if kind == 2 { ring.to_clamped().unwrap() } else { ring }
}

/// The same curve, differently written: another start, sense, degree, knots, domain, weights.
fn scrambled(random: &mut Random, section: &Curve) -> Curve {
    let (a, b) = section.domain();
    let mut curve = section.clone();
    if random.below(4) > 0 {
        let u = random.within(a, b);
        let u = if random.below(3) == 0 { curve.space().breakpoints()[0] + (b - a) / 8.0 } else { u };
        curve = curve.started_at(u).unwrap();
    }
    if random.below(2) == 0 {
        curve = curve.reverse().unwrap();
    }
    if random.below(4) == 0 && curve.degree() < 5 {
        curve = curve.elevate(1 + random.below(2)).unwrap();
    }
    if random.below(3) == 0 {
        let (a, b) = curve.domain();
        let new: Vec<f64> = (0..3).map(|_| random.within(a, b)).collect();
        curve = curve.insert_knots(&new).unwrap();
    }
    let (start, length) = (random.within(-5.0, 5.0), 10_f64.powf(random.within(-3.0, 3.0)));
    let mut curve = curve.reparametrise(start, start + length).unwrap();
    if let (space, points, Some(weights)) = curve.clone().into_parts() {
        let factor = 10_f64.powf(random.within(-3.0, 3.0));
        curve = Curve::rational(space, points, weights.iter().map(|w| w * factor).collect()).unwrap();
    }
    curve
}

/// Sections that face one another along a straight or bent spine, tilted about one axis, of any size, anywhere.
fn family(random: &mut Random) -> (Vec<Curve>, f64) {
    let count = 2 + random.below(11);
    let size = 10_f64.powi(random.below(19) as i32 - 9);
    let bend = if random.below(3) == 0 { random.within(0.2, 1.9) / (count - 1) as f64 } else { 0.0 };
    let tilts = if random.below(3) == 0 { 0.4 } else { 0.0 };
    let shear = random.within(-1.0, 1.0);
    let mut height = 0.0;
    let sections = (0..count)
        .map(|k| {
            let angle = if bend > 0.0 { bend * k as f64 } else { tilts * random.within(-1.0, 1.0) };
            height += random.within(0.8, 2.0);
            let (sin, cos) = angle.sin_cos();
            let centre = if bend > 0.0 {
                // The spine is an arc wide enough that sections do not meet.
                let radius = 2.0 * count as f64 / bend.max(0.2);
                Vector::new(radius * (1.0 - cos), 0.0, radius * sin)
            } else {
                Vector::new(shear * height, 0.3 * height, height)
            };
            let place = |x: f64, y: f64| Point::from((centre + Vector::new(x * cos, y, -x * sin)) * size);
            section(random, &place)
        })
        .collect();
    (sections, size)
}

fn run(scene: &mut Scene, fields: Value) -> Result<StepReport, OperationError> {
    let mut registry = Registry::new();
    registry.add(&Regions);
    registry.add(&Tessellation);
    let operation = registry.find_operation("loft", "step[0]").unwrap();
    let parameters = Parameters::new(fields, "step[0]").unwrap();
    operation.apply(scene, &parameters, &Context::quiet(&registry))
}

fn scene_of(sections: &[Curve]) -> (Scene, Vec<String>) {
    let mut scene = Scene::new();
    let names: Vec<String> = (0..sections.len()).map(|k| format!("s{k}")).collect();
    for (name, section) in names.iter().zip(sections) {
        scene.add(Object::new(name.clone(), section.clone().into())).unwrap();
    }
    (scene, names)
}

/// Shown where the volume of a member is off: what it was made of.
fn near(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((found - expected).abs() <= tolerance * expected, "{what}: {found:e} instead of {expected:e}");
}

#[test]
fn lofts_do_not_depend_on_how_their_sections_are_written() {
    let (mut refused, mut meshes) = (0, 0);
    for member in 0..160 {
        let mut random = Random(member);
        let (straight, size) = family(&mut random);
        let degree = [1, 1, 2, 3, 3, 4, 7, 25][random.below(8)];
        let given: Vec<Curve> = straight.iter().map(|s| scrambled(&mut random, s)).collect();
        let what = format!("member {member}, {} sections, degree {degree}", given.len());
        let lofted = match loft(&given, degree) {
            Ok(lofted) => lofted,
            Err(error) => {
                let text = error.to_string();
                let wild = text.contains("swings out") || text.contains("do not stay positive");
                assert!(degree > 3 && wild, "{what}: {text}");
                refused += 1;
                continue;
            }
        };
        let reach = given.iter().flat_map(Curve::points).fold(0.0_f64, |m, p| m.max(p.coords.amax()));
        for (k, section) in given.iter().enumerate() {
            let missed = missed(&lofted, section, k);
            assert!(missed <= 1e-11 * reach, "{what}: section {k} is missed by {missed:e}");
        }
        assert!(lofted.deviation <= 1e-12 * reach, "{what}: {:e}", lofted.deviation);
        let volume = volume_of_loft(&lofted);
        let expected = if degree == 1 {
            volume_between(&straight)
        } else {
            // Sections that face one another already stay as they are.
            let straight = loft(&straight, degree).unwrap();
            assert!(straight.sections.iter().all(|s| !s.reversed && s.turned == 0.0), "{what}");
            volume_of_loft(&straight)
        };
        near(volume / size.powi(3), expected / size.powi(3), 2e-3, &what);
        if member % 8 == 0 {
            let (mut scene, names) = scene_of(&given);
            let report = run(&mut scene, json!({ "sections": names, "degree": degree })).unwrap();
            near(report.volume.unwrap() / size.powi(3), volume / size.powi(3), 2e-2, &what);
            meshes += 1;
        }
    }
    // All of them of degree 7 and more, most with rational sections among others.
    assert!(refused <= 24 && meshes >= 15, "{refused} refused, {meshes} meshes");
}

#[test]
fn flat_sections_are_refused() {
    for member in 0..100 {
        let mut random = Random(1000 + member);
        let size = 10_f64.powi(random.below(19) as i32 - 9);
        let [tilt, turn] = [random.within(0.0, PI), random.within(0.0, TAU)];
        let x = Vector::new(turn.cos() * tilt.cos(), turn.sin() * tilt.cos(), -tilt.sin());
        let y = Vector::new(-turn.sin(), turn.cos(), 0.0);
        let sections: Vec<Curve> = (0..2 + random.below(3))
            .map(|k| {
                let shift = random.within(-3.0, 3.0);
                let scale = 1.0 + k as f64;
                let place = |a: f64, b: f64| Point::from((x * (scale * a + shift) + y * (scale * b)) * size);
                let flat = section(&mut random, &place);
                scrambled(&mut random, &flat)
            })
            .collect();
        let (mut scene, names) = scene_of(&sections);
        let before = scene.clone();
        let text = run(&mut scene, json!({ "sections": names })).unwrap_err().to_string();
        assert!(text.contains("lie in one plane: the solid would have no volume"), "member {member}: {text}");
        assert_eq!(scene, before);
        // Without caps it is a flat ring, as asked for.
        run(&mut scene, json!({ "sections": names, "caps": false, "degree": 1 })).unwrap();
    }
}

/// A uniform periodic cubic through so many vertices of a circle, with its first vertex on the x axis.
fn circle_of(count: usize, z: f64, sense: f64, radius: f64) -> Curve {
    let at = |k: usize| {
        let (sin, cos) = (TAU * k as f64 / count as f64).sin_cos();
        Point::new(radius * cos, sense * radius * sin, z)
    };
    Curve::new(Space::periodic_uniform(3, count).unwrap(), (0..count).map(at).collect()).unwrap()
}

#[test]
fn starts_far_apart_and_opposite_senses() {
    let expected = |count: usize, other: usize| {
        // A cubic ring of n vertices is nearly a circle of this radius.
        let radius = |n: usize| (2.0 + (TAU / n as f64).cos()) / 3.0;
        let (a, b) = (PI * radius(count).powi(2), PI * radius(other).powi(2));
        (a + b + (a * b).sqrt()) / 3.0
    };
    for (sections, counts, turned, reversed) in [
        ([circle_of(5, 0.0, 1.0, 1.0), circle_of(50, 1.0, 1.0, 1.0)], (5, 50), true, false),
        ([circle_of(8, 0.0, 1.0, 1.0), circle_of(8, 1.0, -1.0, 1.0)], (8, 8), true, true),
    ] {
        let (mut scene, names) = scene_of(&sections);
        let report = run(&mut scene, json!({ "sections": names, "tolerance": 1e-4 })).unwrap();
        near(report.volume.unwrap(), expected(counts.0, counts.1), 5e-3, "repro 8");
        let text = report.notes.join("\n");
        assert_eq!(text.contains("further round"), turned, "{text}");
        assert_eq!(text.contains("\"s1\" runs the other way now"), reversed, "{text}");
        assert!(!text.contains("narrows"), "{text}");
    }
}

#[test]
fn a_bend_of_more_than_a_quarter_turn_is_no_reversal() {
    for degrees in [30.0, 89.0, 91.0, 120.0, 140.0_f64] {
        let angle = degrees.to_radians();
        let place = |angle: f64| {
            let (sin, cos) = angle.sin_cos();
            move |t: f64| {
                let (s, c) = t.sin_cos();
                Point::new(4.0 - (4.0 - c) * cos, s, (4.0 - c) * sin)
            }
        };
        let ring = |place: &dyn Fn(f64) -> Point| {
            let points = (0..12).map(|k| place(TAU * k as f64 / 12.0)).collect();
            Curve::new(Space::periodic_uniform(3, 12).unwrap(), points).unwrap()
        };
        let lofted = loft(&[ring(&place(0.0)), ring(&place(angle))], 1).unwrap();
        assert!(!lofted.sections[1].reversed && lofted.sections[1].turned == 0.0, "{degrees}");
        let turned = ring(&place(angle)).reverse().unwrap().started_at(3.3).unwrap();
        let lofted = loft(&[ring(&place(0.0)), turned], 1).unwrap();
        assert!(lofted.sections[1].reversed && lofted.sections[1].turned > 0.0, "{degrees}");
    }
}

#[test]
fn degrees_that_do_not_fit_are_refused_or_told() {
    let sections = [circle_of(8, 0.0, 1.0, 1.0), circle_of(8, 1.0, 1.0, 1.0)];
    for degree in [0, 26, 99, usize::MAX] {
        let text = loft(&sections, degree).unwrap_err().to_string();
        assert!(text.contains("choose a degree from 1 to 25"), "{text}");
    }
    let (mut scene, names) = scene_of(&sections);
    let text = run(&mut scene, json!({ "sections": names, "degree": 99 })).unwrap_err().to_string();
    assert!(text.contains("choose a degree from 1 to 25"), "{text}");
    let report = run(&mut scene, json!({ "sections": names, "degree": 5 })).unwrap();
    assert!(report.notes.iter().any(|n| n == "degree 1: 2 sections give no more"), "{:?}", report.notes);
}

#[test]
fn sixty_sections_at_any_degree() {
    let radius = |k: usize| 1.0 + 0.1 * (k as f64).sin();
    let sections: Vec<Curve> = (0..60).map(|k| circle_of(8, k as f64, 1.0, radius(k))).collect();
    let shrink = (2.0 + (TAU / 8.0).cos()) / 3.0;
    let exact: f64 = (0..59 * 64)
        .map(|i| (i as f64 + 0.5) / 64.0)
        .map(|z| PI * (shrink * (1.0 + 0.1 * z.sin())).powi(2) / 64.0)
        .sum();
    for degree in [1, 2, 3, 5, 7, 12] {
        let lofted = loft(&sections, degree).unwrap();
        near(volume_of_loft(&lofted), exact, 1e-2, &format!("degree {degree}"));
    }
    let (mut scene, names) = scene_of(&sections);
    let report = run(&mut scene, json!({ "sections": names, "degree": 7, "tolerance": 0.005 })).unwrap();
    near(report.volume.unwrap(), exact, 1e-2, "degree 7, as a mesh");
    // What passes through all of them at degree 25 swings out near the ends by three times their size: no loft.
    let text =
        run(&mut scene, json!({ "sections": names, "degree": 25, "name": "wild" })).unwrap_err().to_string();
    assert!(text.contains("a loft of degree 25 swings out between its sections"), "{text}");
}

#[test]
fn what_swings_out_is_refused() {
    // A polynomial of degree 25 through sections that jump: nothing like them in between.
    let sections: Vec<Curve> =
        (0..26).map(|k| circle_of(8, k as f64, 1.0, if k % 5 == 0 { 3.0 } else { 1.0 })).collect();
    let text = loft(&sections, 25).unwrap_err().to_string();
    assert!(text.contains("a loft of degree 25 swings out between its sections"), "{text}");
    assert!(loft(&sections, 3).is_ok());
}

#[test]
fn open_sections_are_reversed_where_that_is_nearer() {
    let line = |z: f64| {
        let points = (0..6).map(|i| Point::new(f64::from(i), f64::from(i * i % 5), z)).collect();
        Curve::new(Space::clamped_uniform(3, 6).unwrap(), points).unwrap()
    };
    let sections = [line(0.0), line(1.0).reverse().unwrap(), line(2.0)];
    let lofted = loft(&sections, 3).unwrap();
    assert_eq!(lofted.sections.iter().map(|s| s.reversed).collect::<Vec<_>>(), [false, true, false]);
    for (k, section) in sections.iter().enumerate() {
        assert!(missed(&lofted, section, k) < 1e-13);
    }
}

#[test]
fn sections_that_coincide_are_refused() {
    for size in [1e-9, 1.0, 1e9] {
        for gap in [0.0, 1e-17] {
            let sections = [circle_of(8, 0.0, 1.0, size), circle_of(8, gap * size, 1.0, size)];
            let text = loft(&sections, 1).unwrap_err().to_string();
            assert!(text.contains("coincide"), "{text}");
        }
    }
}

/// A root circle and an aerofoil with a blunt trailing edge that a line closes: the line takes a share of the parameter like its
/// length, so that no half of the circle is led into it.
#[test]
fn a_short_bridge_takes_a_short_part_of_the_circle() {
    let blunt = |k: usize| {
        let angle = 0.02 + (TAU - 0.04) * k as f64 / 40.0;
        Point::new(2.0 * angle.cos(), 0.5 * angle.sin(), 3.0)
    };
    let open = Curve::new(Space::clamped_uniform(3, 41).unwrap(), (0..41).map(blunt).collect()).unwrap();
    let gap = (open.points()[40] - open.points()[0]).norm();
    let share = gap / (gap + open.length(1e-9).unwrap().value);
    let root = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap();
    let (mut scene, names) = scene_of(&[root, open]);
    let fields = json!({ "sections": names, "tolerance": 1e-3, "bridge": true, "degree": 1, "surface": true, "name": "blade" });
    run(&mut scene, fields).unwrap();
    let surface = scene.surface("blade surface").unwrap();
    let ((a, b), (_, end)) = (surface.u().domain(), surface.v().domain());
    // The line of the trailing edge is where the second section has the x of its ends.
    let flat = 2.0 * 0.02_f64.cos() - 1e-9;
    let count = 20_000;
    let on_line = (0..count)
        .filter(|k| surface.point(a + (b - a) * f64::from(*k) / f64::from(count), end).unwrap().x >= flat)
        .count();
    let found = on_line as f64 / f64::from(count);
    assert!((found - share).abs() < 0.2 * share + 2e-4, "{found} of the parameter for {share} of the length");
}

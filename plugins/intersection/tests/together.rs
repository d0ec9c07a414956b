//! What runs together, where that is known: shapes and copies of them that are refined, elevated, reversed, turned or cut into parts.
#![allow(clippy::unwrap_used, reason = "a test that fails should panic")]

use std::f64::consts::TAU;

use loftsman_intersection::{Intersections, Options, curve_surface, curves};
use loftsman_kernel::shape::{Derivative, Location};
use loftsman_kernel::spline::{Curve, Direction, Space, Surface};
use loftsman_kernel::{Point, Vector};

/// Numbers from 0 to 1, the same every time (Knuth's MMIX generator).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() * count as f64) as usize
    }

    fn size(&mut self) -> f64 {
        [1.0, 7.3, 1e-6, 1e6][self.below(4)]
    }
}

/// A curve that goes on along x or round the origin, so that it meets itself nowhere.
fn simple(random: &mut Numbers, degree: usize, periodic: bool, rational: bool) -> Curve {
    let size = random.size();
    let count = degree + 1 + random.below(5) + if periodic { 3 } else { 0 };
    let points: Vec<Point> = (0..count)
        .map(|i| {
            let share = i as f64 / if periodic { count as f64 } else { count as f64 - 1.0 };
            if periodic {
                let (radius, angle) = (random.within(0.7, 1.3) * size, TAU * share);
                Point::new(radius * angle.cos(), radius * angle.sin(), 0.2 * radius)
            } else {
                Point::new(
                    10.0 * share * size,
                    random.within(-4.0, 4.0) * size,
                    random.within(-1.0, 1.0) * size,
                )
            }
        })
        .collect();
    let space = if periodic {
        Space::periodic_uniform(degree, count).unwrap()
    } else {
        Space::clamped_uniform(degree, count).unwrap()
    };
    if rational {
        let weights = (0..count).map(|_| 10_f64.powf(random.within(-0.7, 0.7))).collect();
        Curve::rational(space, points, weights).unwrap()
    } else {
        Curve::new(space, points).unwrap()
    }
}

/// A copy with some more knots, maybe of a higher degree, reversed, by another parameter.
fn copy(random: &mut Numbers, curve: &Curve) -> Curve {
    let (a, b) = curve.domain();
    let knots: Vec<f64> = (0..=random.below(5)).map(|_| random.within(a, b)).collect();
    let mut copy = curve.insert_knots(&knots).unwrap();
    if random.below(3) == 0 {
        copy = copy.elevate(1 + random.below(2)).unwrap();
    }
    if random.below(3) == 0 {
        copy = copy.reverse().unwrap();
    }
    if random.below(3) == 0 {
        copy = copy.reparametrise(-3.0, random.within(0.0, 90.0)).unwrap();
    }
    copy
}

/// What is wrong where the only thing in common are runs over these ranges of the first, which are one but at its seam.
fn wrong(found: &Intersections, first: &Curve, ranges: &[(f64, f64)]) -> Option<String> {
    let length = first.space().length();
    // Where an end is known to the tolerance along the curve.
    let near = |x: f64, y: f64| (x - y).abs() <= 1e-7 * length;
    let ends = found.overlaps.len() == ranges.len()
        && found.overlaps.iter().zip(ranges).all(|(o, r)| near(o.range.0, r.0) && near(o.range.1, r.1));
    let right = ends && found.meetings.is_empty() && found.distance() <= found.tolerance;
    (!right || !found.is_complete()).then(|| {
        let told: Vec<_> = found.overlaps.iter().map(|o| o.range).collect();
        format!(
            "{told:?} not {ranges:?}, {} points, {} undecided",
            found.meetings.len(),
            found.undecided.len()
        )
    })
}

/// Tells all that is wrong at once.
#[derive(Default)]
struct Told {
    cases: usize,
    wrong: Vec<String>,
}

impl Told {
    fn add(&mut self, what: impl Fn() -> String, wrong: Option<String>) {
        self.cases += 1;
        self.wrong.extend(wrong.map(|wrong| format!("{}: {wrong}", what())));
    }

    fn all(&self, cases: usize) {
        let (wrong, some) =
            (self.wrong.len(), self.wrong.iter().take(12).cloned().collect::<Vec<_>>().join("\n"));
        assert!(self.cases >= cases && wrong == 0, "{wrong} of {} wrong:\n{some}", self.cases);
    }
}

#[test]
fn a_curve_and_a_copy_of_it_are_one_run() {
    let mut random = Numbers(1);
    let mut told = Told::default();
    for case in 0..400 {
        let degree = 1 + case % 5;
        let (periodic, rational) = (case % 3 == 2, case % 2 == 1);
        let a = simple(&mut random, degree, periodic, rational);
        let b = copy(&mut random, &a);
        let found = curves(&a, &b, &Options::default()).unwrap();
        told.add(
            || format!("{case}: degree {degree}, periodic {periodic}, rational {rational}"),
            wrong(&found, &a, &[a.domain()]),
        );
    }
    told.all(400);
}

#[test]
fn a_rough_curve_and_a_copy_of_it_are_one_run() {
    let mut random = Numbers(7);
    let mut told = Told::default();
    for case in 0..70 {
        let degree = if case % 10 == 9 { 25 } else { 1 + case % 7 };
        let count = degree + 1 + random.below(6);
        let size = random.size();
        let points =
            (0..count).map(|_| Point::from(Vector::from_fn(|_, _| random.within(-size, size)))).collect();
        let a = Curve::new(Space::clamped_uniform(degree, count).unwrap(), points).unwrap();
        let (low, high) = a.domain();
        let knots: Vec<f64> = (0..3).map(|_| random.within(low, high)).collect();
        let b = a.insert_knots(&knots).unwrap();
        let b = if case % 2 == 1 { b.reverse().unwrap() } else { b };
        let found = curves(&a, &b, &Options::default()).unwrap();
        told.add(|| format!("{case}: degree {degree}"), wrong(&found, &a, &[a.domain()]));
    }
    told.all(70);
}

#[test]
fn a_copy_within_a_coarse_tolerance_is_one_run() {
    let mut random = Numbers(3);
    for case in 0..60 {
        let degree = 1 + case % 4;
        let count = degree + 1 + random.below(5);
        let tolerance = [1e-3, 1e-6][case % 2];
        let points: Vec<Point> =
            (0..count).map(|i| Point::new(i as f64, random.within(-2.0, 2.0), 0.0)).collect();
        let a = Curve::new(Space::clamped_uniform(degree, count).unwrap(), points.clone()).unwrap();
        let moved =
            points.iter().map(|p| p + Vector::from_fn(|_, _| random.within(-0.3, 0.3) * tolerance)).collect();
        let (low, high) = a.domain();
        let knots = [0, 1, 2].map(|_| random.within(low, high));
        let b = Curve::new(a.space().clone(), moved).unwrap().insert_knots(&knots).unwrap();
        let found = curves(&a, &b, &Options::within(tolerance)).unwrap();
        let ends = found.overlaps.first().unwrap();
        // The ends are where one of them ends, and so within the tolerance.
        for (at, end) in [(ends.range.0, low), (ends.range.1, high)] {
            assert!((a.point(at).unwrap() - a.point(end).unwrap()).norm() <= tolerance, "{found:#?}");
        }
        assert!(found.overlaps.len() == 1 && found.meetings.is_empty() && found.is_complete(), "{found:#?}");
        assert!(found.distance() <= tolerance);
    }
}

#[test]
fn a_curve_and_a_part_of_it_are_one_run() {
    let mut random = Numbers(2);
    let mut told = Told::default();
    for case in 0..200 {
        let degree = 1 + case % 5;
        let a = simple(&mut random, degree, false, case % 2 == 1);
        let (low, high) = (random.within(0.0, 0.5), random.within(0.55, 1.0));
        let b = copy(&mut random, &a.between(low, high).unwrap());
        let found = curves(&a, &b, &Options::default()).unwrap();
        told.add(|| format!("{case}: degree {degree}"), wrong(&found, &a, &[(low, high)]));
        let found = curves(&b, &a, &Options::default()).unwrap();
        told.add(|| format!("{case}, the part first: degree {degree}"), wrong(&found, &b, &[b.domain()]));
        // Two parts have in common what both have.
        let c = copy(&mut random, &a.between(0.5 * (low + high), 1.0).unwrap());
        let (from, _) = c.domain();
        let at = b.closest(a.point(0.5 * (low + high)).unwrap()).unwrap().at;
        let ends = if b.closest(a.point(high).unwrap()).unwrap().at > at {
            (at, b.domain().1)
        } else {
            (b.domain().0, at)
        };
        let found = curves(&b, &c, &Options::default()).unwrap();
        told.add(|| format!("{case}, two parts: degree {degree}, from {from}"), wrong(&found, &b, &[ends]));
    }
    told.all(600);
}

/// A circle, or the arc of some degrees that starts at an angle.
fn arc(radius: f64, center: Point, start: f64, degrees: f64) -> Curve {
    let start = start.to_radians();
    let from = center + Vector::new(radius * start.cos(), radius * start.sin(), 0.0);
    Curve::arc(from, center, Vector::z(), degrees.to_radians()).unwrap()
}

#[test]
fn circles_and_arcs_turned_by_every_degree() {
    let mut told = Told::default();
    for degrees in (0..360).filter(|d| d % 2 == 0 || *d < 90 || *d > 300) {
        let turn = f64::from(degrees);
        let radius = [1.0, 10.0, 1e-6, 1e6][degrees as usize % 4];
        let center = Point::new(0.3 * radius, -1.7 * radius, 0.9 * radius);
        let whole = arc(radius, center, 0.0, 360.0);
        let at = |angle: f64| {
            whole
                .closest(
                    center + Vector::new(angle.to_radians().cos(), angle.to_radians().sin(), 0.0) * radius,
                )
                .unwrap()
                .at
        };
        let ring = Curve::circle(center, Vector::z(), radius).unwrap();
        for (other, of) in [(arc(radius, center, turn, 360.0), "closed"), (ring, "periodic")] {
            let found = curves(&whole, &other, &Options::default()).unwrap();
            told.add(|| format!("{degrees}, {of}"), wrong(&found, &whole, &[whole.domain()]));
            let found = curves(&other, &whole, &Options::default()).unwrap();
            told.add(|| format!("{degrees}, {of} first"), wrong(&found, &other, &[other.domain()]));
        }
        let part = arc(radius, center, turn, 170.0);
        let found = curves(&whole, &part, &Options::default()).unwrap();
        // What passes over the seam of the first is told from there, and to there.
        let (start, end) = whole.domain();
        let ranges = match degrees {
            0 => vec![(start, at(170.0))],
            190 => vec![(at(190.0), end)],
            191.. => vec![(start, at(turn + 170.0)), (at(turn), end)],
            _ => vec![(at(turn), at(turn + 170.0))],
        };
        told.add(|| format!("{degrees}, an arc"), wrong(&found, &whole, &ranges));
        let found = curves(&part, &whole, &Options::default()).unwrap();
        told.add(|| format!("{degrees}, an arc first"), wrong(&found, &part, &[part.domain()]));
        // Two arcs of half a turn: what both have.
        if (1..180).contains(&degrees) {
            let (a, b) = (arc(radius, center, 0.0, 180.0), arc(radius, center, turn, 179.0));
            let from = a.closest(b.point(b.domain().0).unwrap()).unwrap().at;
            let found = curves(&a, &b, &Options::default()).unwrap();
            told.add(|| format!("{degrees}, two arcs"), wrong(&found, &a, &[(from, a.domain().1)]));
        }
    }
    told.all(1500);
}

/// A surface over a square, uneven.
fn sheet(random: &mut Numbers, degrees: [usize; 2], rational: bool) -> Surface {
    let counts = degrees.map(|degree| degree + 1 + random.below(4));
    let size = random.size();
    let mut points = Vec::new();
    for i in 0..counts[0] {
        for j in 0..counts[1] {
            let (u, v) = (i as f64 / (counts[0] as f64 - 1.0), j as f64 / (counts[1] as f64 - 1.0));
            points.push(Point::new(u * size, v * size, random.within(-0.15, 0.15) * size));
        }
    }
    let [u, v] = [0, 1].map(|k| Space::clamped_uniform(degrees[k], counts[k]).unwrap());
    if rational {
        let weights = (0..points.len()).map(|_| random.within(0.5, 2.0)).collect();
        Surface::rational(u, v, points, weights).unwrap()
    } else {
        Surface::new(u, v, points).unwrap()
    }
}

#[test]
fn an_isocurve_and_its_refined_surface_are_one_run() {
    let mut random = Numbers(3);
    let mut told = Told::default();
    for case in 0..80 {
        let degrees = [1 + case % 3, 1 + case / 3 % 3];
        let surface = sheet(&mut random, degrees, case % 2 == 1);
        let at = random.within(0.1, 0.9);
        let direction = if case % 4 < 2 { Direction::U } else { Direction::V };
        let curve = surface.isocurve(direction, at).unwrap();
        let knots = [random.within(0.05, 0.95), random.within(0.05, 0.95)];
        let refined = surface.insert_knots(Direction::U, &knots[..1]).unwrap();
        let refined = refined.insert_knots(Direction::V, &knots[1..]).unwrap();
        let found = curve_surface(&curve, &refined, &Options::default()).unwrap();
        told.add(|| format!("{case}: degrees {degrees:?}"), wrong(&found, &curve, &[curve.domain()]));
        for o in &found.overlaps {
            let ends = o.with.unwrap().map(|with| match with {
                Location::Surface(..) => Point::from(refined_value(&refined, with)),
                _ => Point::origin(),
            });
            assert!((0..2).all(|k| (ends[k] - o.points[k]).norm() <= 4.0 * found.tolerance));
        }
    }
    told.all(80);
}

fn refined_value(surface: &Surface, at: Location) -> Vector {
    use loftsman_kernel::shape::Shape;
    surface.value(at, Derivative::POSITION).unwrap()
}

#[test]
fn circles_on_surfaces_of_revolution_are_one_run() {
    let mut told = Told::default();
    for degrees in (1..360).step_by(4) {
        let radius = [1.0, 1e-6, 1e6][degrees as usize % 3];
        let profile = Curve::new(
            Space::clamped_uniform(3, 6).unwrap(),
            [[1.0, 0.0], [1.4, 0.3], [0.8, 0.7], [1.2, 1.1], [0.9, 1.5], [1.1, 2.0]]
                .map(|[x, z]| Point::new(x * radius, 0.0, z * radius))
                .to_vec(),
        )
        .unwrap();
        let surface = Surface::revolution(&profile, Point::origin(), Vector::z(), TAU).unwrap();
        let place = profile.point(0.05 + 0.9 * f64::from(degrees) / 360.0).unwrap();
        let circle = arc(place.x, Point::new(0.0, 0.0, place.z), f64::from(degrees), 360.0);
        let found = curve_surface(&circle, &surface, &Options::default()).unwrap();
        told.add(|| format!("{degrees}"), wrong(&found, &circle, &[circle.domain()]));
    }
    told.all(90);
}

#[test]
fn what_only_comes_near_does_not_run_together() {
    let o = Options::default();
    for degrees in (0..90).step_by(9) {
        let turn = f64::from(degrees);
        let whole = arc(1.0, Point::origin(), 0.0, 360.0);
        // Of a slightly other radius, by 5 tolerances and more.
        for apart in [1e-8, 1e-7, 1e-5] {
            let found = curves(&whole, &arc(1.0 + apart, Point::origin(), turn, 300.0), &o).unwrap();
            assert!(found.overlaps.is_empty() && found.meetings.is_empty(), "{turn}, {apart}: {found:#?}");
        }
        // One that touches from within, and one beside it that crosses at a small angle.
        let (x, y) = (turn.to_radians().cos(), turn.to_radians().sin());
        let inner = Point::new(0.4 * x, 0.4 * y, 0.0);
        let found = curves(&whole, &arc(0.6, inner, 3.0 * turn, 360.0), &o).unwrap();
        assert!(found.overlaps.is_empty() && found.meetings.len() == 1, "{turn}: {found:#?}");
        // A tangent that starts where it touches.
        let place = Point::new(x, y, 0.0);
        let tangent = Curve::line(place, place + Vector::new(-y, x, 0.0)).unwrap();
        let found = curves(&whole, &tangent, &o).unwrap();
        assert!(found.overlaps.is_empty() && found.meetings.len() == 1, "{turn}: {found:#?}");
    }
    // Osculation at a knot of both: cubics that share a place, its tangent and its curvature.
    let mut random = Numbers(5);
    for _ in 0..60 {
        let a = simple(&mut random, 3, false, false);
        let space = a.space().clone();
        let mut points = a.points().to_vec();
        let last = points.len() - 1;
        if last < 4 {
            continue;
        }
        let size = (points[last] - points[0]).norm();
        for p in &mut points[3..] {
            p.y += 0.3 * size;
        }
        let b = Curve::new(space, points).unwrap();
        let b = copy(&mut random, &b);
        let found = curves(&a, &b, &o).unwrap();
        assert!(found.overlaps.is_empty(), "{found:#?}");
    }
}

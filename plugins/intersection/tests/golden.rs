//! Against OpenCASCADE, and against a search of our own that samples.
#![allow(clippy::unwrap_used, reason = "a test that fails should panic")]

use loftsman_intersection::{
    Options, Plane, curve_plane, curve_surface, curves, section, self_intersections,
};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use serde_json::Value;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn points(value: &Value) -> Vec<Point> {
    let point = |v: &Value| Point::from_slice(&numbers(v));
    value.as_array().unwrap().iter().map(point).collect()
}

fn golden() -> Value {
    serde_json::from_str(include_str!("golden/meetings.json")).unwrap()
}

fn curve(case: &Value, name: &str) -> Curve {
    let p = points(&case[name]);
    let space = Space::clamped_uniform(case["degree"].as_u64().unwrap() as usize, p.len()).unwrap();
    Curve::rational(space, p, numbers(&case[format!("w{name}")])).unwrap()
}

fn surface(case: &Value) -> Surface {
    let rows: Vec<Vec<Point>> = case["b"].as_array().unwrap().iter().map(points).collect();
    let weights = case["wb"].as_array().unwrap().iter().flat_map(numbers).collect();
    let degree = case["degree"].as_u64().unwrap() as usize;
    let space = |n| Space::clamped_uniform(degree, n).unwrap();
    let (u, v) = (space(rows.len()), space(rows[0].len()));
    Surface::rational(u, v, rows.into_iter().flatten().collect(), weights).unwrap()
}

/// Theirs are all among ours; ours that they lack lie on both, which is measured.
fn compare(theirs: &[Point], ours: &[loftsman_intersection::Meeting], more: &mut usize) {
    for p in theirs {
        let near = ours.iter().map(|m| (m.point - p).norm()).fold(f64::INFINITY, f64::min);
        assert!(near < 1e-6, "{p} is missing: nearest {near:e}");
    }
    assert!(ours.iter().all(|m| m.distance <= 1e-12 * 20.0), "{ours:?}");
    *more += ours.len() - theirs.len();
}

#[test]
fn curves_meet_where_opencascade_finds_it() {
    let (mut count, mut more) = (0, 0);
    for case in golden()["curves"].as_array().unwrap() {
        let (a, b) = (curve(case, "a"), curve(case, "b"));
        let found = curves(&a, &b, &Options::default()).unwrap();
        // Theirs lacks some: all of ours are there, by dense chords.
        assert_eq!(found.meetings.len(), chord_crossings(&a, &b).len());
        // And lie on both, by another search than the one that found them.
        for m in &found.meetings {
            let off = [&a, &b].map(|c| c.closest(m.point).unwrap().distance);
            assert!(off.iter().all(|off| *off <= 1e-9), "{m:?}: {off:?}");
        }
        assert!(found.is_complete() && found.overlaps.is_empty());
        let theirs = points(&case["points"]);
        compare(&theirs, &found.meetings, &mut more);
        count += theirs.len();
    }
    assert!(count >= 60, "{count}");
    println!("{count} meetings of curves, {more} more of ours");
}

#[test]
fn curves_meet_themselves_where_opencascade_finds_it() {
    let (mut count, mut more) = (0, 0);
    for case in golden()["itself"].as_array().unwrap() {
        let own = curve(case, "a");
        let found = self_intersections(&own, &Options::default()).unwrap();
        assert!(found.is_complete() && found.overlaps.is_empty());
        let off = found.meetings.iter().map(|m| own.closest(m.point).unwrap().distance).fold(0.0, f64::max);
        assert!(off <= 1e-9, "{off:e}");
        // Each once: as many as its dense chords cross, which lists both chords of a crossing.
        let twice = chord_crossings(&own, &own).len();
        assert_eq!(2 * found.meetings.len(), twice, "{:?}", found.meetings);
        let theirs = points(&case["points"]);
        compare(&theirs, &found.meetings, &mut more);
        count += theirs.len();
    }
    assert!(count >= 150, "{count}");
    println!("{count} meetings of curves with themselves, {more} more of ours");
}

#[test]
fn curves_meet_surfaces_where_opencascade_finds_it() {
    let (mut count, mut more) = (0, 0);
    for case in golden()["curve_surface"].as_array().unwrap() {
        let (a, b) = (curve(case, "a"), surface(case));
        let found = curve_surface(&a, &b, &Options::default()).unwrap();
        assert!(found.is_complete() && found.overlaps.is_empty());
        for m in &found.meetings {
            let off = [a.closest(m.point).unwrap().distance, b.closest(m.point).unwrap().distance];
            assert!(off.iter().all(|off| *off <= 1e-9), "{m:?}: {off:?}");
        }
        let theirs = points(&case["points"]);
        compare(&theirs, &found.meetings, &mut more);
        count += theirs.len();
    }
    assert!(count >= 20, "{count}");
    println!("{count} meetings with surfaces, {more} more of ours");
    assert!(more <= count / 20, "{more}");
}

#[test]
fn sections_are_those_of_opencascade() {
    let mut count = 0;
    for case in golden()["sections"].as_array().unwrap() {
        let plane = Plane::new(
            Point::from_slice(&numbers(&case["point"])),
            Vector::from_row_slice(&numbers(&case["normal"])),
        )
        .unwrap();
        let cut = section(&surface(case), &plane, &Options::within(1e-7)).unwrap();
        assert!(cut.undecided.is_empty());
        let length: f64 = cut.curves.iter().map(|c| c.curve.length(1e-9).unwrap().value).sum();
        let theirs = case["length"].as_f64().unwrap();
        assert!((length - theirs).abs() <= 1e-4 * theirs, "{length} is not {theirs}");
        // Ours lie in the plane and on the surface, by another search.
        for one in &cut.curves {
            let (a, b) = one.curve.domain();
            for k in 0..=20 {
                let p = one.curve.point((a + (b - a) * f64::from(k) / 20.0).min(b)).unwrap();
                let off = plane.distance(&p).abs().max(surface(case).closest(p).unwrap().distance);
                assert!(off <= 2e-7, "{p} is {off:e} off");
            }
        }
        for p in points(&case["samples"]) {
            let near = cut.curves.iter().map(|c| c.curve.closest(p).unwrap().distance);
            let near = near.fold(f64::INFINITY, f64::min);
            assert!(near <= 1e-5, "{p} is {near:e} away");
            count += 1;
        }
    }
    assert!(count >= 50, "{count}");
}

/// Numbers that look like chance and are not.
struct Sequence(u64);

impl Sequence {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() * n as f64) as usize
    }

    /// A planar curve of any family.
    fn curve(&mut self) -> Curve {
        let degree = [1, 2, 3, 4, 5, 6, 7, 25][self.below(8)];
        let n = degree + 1 + self.below(8);
        let space = match self.below(4) {
            0 => Space::clamped_uniform(degree, n).unwrap(),
            1 => Space::floating_uniform(degree, n).unwrap(),
            2 => Space::periodic_uniform(degree, n.max(3)).unwrap(),
            // Each knot twice.
            _ => {
                let breaks: Vec<f64> = (1..=(n - degree - 1) / 2).map(|k| k as f64).collect();
                let inner = breaks.iter().flat_map(|b| vec![*b; 2.min(degree)]);
                let last = breaks.len() as f64 + 1.0;
                let ends = |x: f64| vec![x; degree + 1];
                let knots = ends(0.0).into_iter().chain(inner).chain(ends(last)).collect();
                Space::open(degree, knots).unwrap()
            }
        };
        let n = space.len();
        let points =
            (0..n).map(|_| Point::new(4.0 * self.next() - 2.0, 4.0 * self.next() - 2.0, 0.0)).collect();
        if self.next() < 0.5 {
            return Curve::new(space, points).unwrap();
        }
        Curve::rational(space, points, (0..n).map(|_| 0.3 + 2.0 * self.next()).collect()).unwrap()
    }
}

const CHORDS: usize = 3000;

fn chords(curve: &Curve) -> Vec<Point> {
    let (a, b) = curve.domain();
    (0..=CHORDS).map(|k| curve.point(a + (b - a) * (k as f64 / CHORDS as f64)).unwrap()).collect()
}

/// Where chords of two planar curves cross, and how long they are.
fn chord_crossings(a: &Curve, b: &Curve) -> Vec<(Point, f64)> {
    let (p, q) = (chords(a), chords(b));
    let mut found = Vec::new();
    for x in p.windows(2) {
        for y in q.windows(2) {
            if x[0].x.max(x[1].x) < y[0].x.min(y[1].x)
                || y[0].x.max(y[1].x) < x[0].x.min(x[1].x)
                || x[0].y.max(x[1].y) < y[0].y.min(y[1].y)
                || y[0].y.max(y[1].y) < x[0].y.min(x[1].y)
            {
                continue;
            }
            let side = |o: &Point, e: &Point, p: &Point| (e - o).cross(&(p - o)).z;
            if side(&x[0], &x[1], &y[0]) * side(&x[0], &x[1], &y[1]) < 0.0
                && side(&y[0], &y[1], &x[0]) * side(&y[0], &y[1], &x[1]) < 0.0
            {
                found.push((x[0], (x[1] - x[0]).norm()));
            }
        }
    }
    found
}

#[test]
fn no_crossing_of_dense_chords_is_missed() {
    let mut random = Sequence(7);
    let (mut crossings, mut meetings) = (0, 0);
    for case in 0..60 {
        let (a, b) = (random.curve(), random.curve());
        let found = curves(&a, &b, &Options::default()).unwrap();
        assert!(found.is_complete(), "{case}");
        assert!(found.meetings.iter().all(|m| m.distance <= found.tolerance));
        meetings += found.meetings.len();
        for (at, chord) in chord_crossings(&a, &b) {
            crossings += 1;
            // Chords of crossing curves at a small angle cross a little beside.
            let near = found.meetings.iter().map(|m| (m.point - at).norm()).fold(f64::INFINITY, f64::min);
            assert!(near < 0.05 + 2.0 * chord, "case {case}: the nearest to {at} is {near:e} away");
        }
        // Each meeting is listed once.
        for (k, m) in found.meetings.iter().enumerate() {
            for n in &found.meetings[k + 1..] {
                assert!(m.at != n.at || m.with != n.with, "case {case}: {m:?} twice");
            }
        }
    }
    println!("{crossings} crossings of chords, {meetings} meetings");
    assert!(crossings >= 100 && meetings.abs_diff(crossings) <= crossings / 50, "{crossings} {meetings}");
}

#[test]
fn every_change_of_side_is_a_meeting_with_the_plane() {
    let mut random = Sequence(11);
    let mut changes = 0;
    for case in 0..400 {
        let curve = random.curve();
        let normal = Vector::new(random.next() - 0.5, random.next() - 0.5, 0.0);
        let plane = Plane::new(Point::new(random.next() - 0.5, random.next() - 0.5, 0.0), normal).unwrap();
        let found = curve_plane(&curve, &plane, &Options::default()).unwrap();
        let sides: Vec<bool> = chords(&curve).iter().map(|p| plane.distance(p) > 0.0).collect();
        let count = sides.windows(2).filter(|w| w[0] != w[1]).count();
        assert!(
            found.meetings.len() >= count && (found.meetings.len() - count).is_multiple_of(2),
            "case {case}: {count}, {found:?}"
        );
        assert!(found.meetings.iter().all(|m| m.distance <= found.tolerance));
        changes += count;
    }
    assert!(changes > 200, "{changes}");
}

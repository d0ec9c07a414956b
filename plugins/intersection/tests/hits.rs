//! Meetings of every degree from 1 to 5, of conics and elementary surfaces, and tangencies, against OpenCASCADE: `golden/hits.py` made the numbers.
#![allow(clippy::unwrap_used, reason = "a test that fails should panic")]

use loftsman_intersection::{
    Contact, Intersections, Options, Plane, curve_plane, curve_surface, curves, section,
};
use loftsman_kernel::Point;
use loftsman_kernel::shape::Location;
use loftsman_kernel::spline::{Curve, Space, Surface};
use serde_json::Value;

fn golden(kind: &str) -> Vec<Value> {
    let all: Value = serde_json::from_str(include_str!("golden/hits.json")).unwrap();
    all[kind].as_array().unwrap().clone()
}

fn list(value: &Value) -> &[Value] {
    value.as_array().unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    list(value).iter().map(|v| v.as_f64().unwrap()).collect()
}

/// Those in a plane have two numbers.
fn point(value: &Value) -> Point {
    let all = numbers(value);
    Point::new(all[0], all[1], all.get(2).copied().unwrap_or(0.0))
}

fn points(value: &Value) -> Vec<Point> {
    list(value).iter().map(point).collect()
}

fn curve(told: &Value) -> Curve {
    let space = Space::open(told["degree"].as_u64().unwrap() as usize, numbers(&told["knots"])).unwrap();
    Curve::rational(space, points(&told["points"]), numbers(&told["weights"])).unwrap()
}

fn surface(told: &Value) -> Surface {
    let space = |k: usize| {
        Space::open(told["degrees"][k].as_u64().unwrap() as usize, numbers(&told["knots"][k])).unwrap()
    };
    let net = list(&told["net"]).iter().flat_map(points).collect();
    let weights = list(&told["weights"]).iter().flat_map(numbers).collect();
    Surface::rational(space(0), space(1), net, weights).unwrap()
}

#[derive(Debug, Default)]
struct Told {
    cases: usize,
    points: usize,
    touching: usize,
    wrong: Vec<String>,
}

impl Told {
    /// Holds the parameters of meetings against their places: `at` on the first, `with` on the second, which gives a point for it.
    fn at_and_with(
        &mut self,
        first: &Curve,
        found: &Intersections,
        second: impl Fn(Location) -> Option<Point>,
    ) {
        for m in &found.meetings {
            let at = (first.point(m.at).unwrap() - m.point).norm();
            let with = m.with.and_then(&second).map_or(f64::INFINITY, |p| (p - m.point).norm());
            if at > 1e-12 || with > found.tolerance {
                self.wrong
                    .push(format!("{m:?}: its parameters are those of places {at:.1e}, {with:.1e} away"));
            }
        }
    }

    fn compare(&mut self, case: &Value, found: &Intersections) {
        self.cases += 1;
        let name = &case["name"];
        let mut wrong = |problem: String| self.wrong.push(format!("{name}: {problem}"));
        if !found.is_complete() || !found.overlaps.is_empty() {
            wrong(format!("{found:?}"));
        }
        let far = found.distance();
        if far > found.tolerance {
            wrong(format!("{far:.1e} apart"));
        }
        let nearest = |p: &Point| {
            let all = found.meetings.iter().map(|m| ((m.point - p).norm(), m.contact));
            all.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, Contact::Crossing))
        };
        for (key, within, kind) in
            [("points", 1e-7, Contact::Crossing), ("touching", 2e-6, Contact::Touching)]
        {
            for p in points(&case[key]) {
                let (near, contact) = nearest(&p);
                if near > within || contact != kind {
                    wrong(format!("{key} {p}: {near:.1e} away, {contact:?}"));
                }
                if kind == Contact::Touching { self.touching += 1 } else { self.points += 1 }
            }
        }
        let more = found.meetings.len() as i64
            - list(&case["points"]).len() as i64
            - list(&case["touching"]).len() as i64;
        let lacks = case.get("lacks").map_or(0, |n| n.as_i64().unwrap());
        if more != lacks {
            wrong(format!("{more} more than OpenCASCADE found, which lacks {lacks}: {:?}", found.meetings));
        }
    }

    fn done(&self, least: [usize; 3]) {
        let counts = [self.cases, self.points, self.touching];
        assert!(counts.iter().zip(least).all(|(found, least)| *found >= least), "{counts:?}");
        assert!(self.wrong.is_empty(), "{}", self.wrong.join("\n"));
    }
}

fn on_curve(curve: &Curve) -> impl Fn(Location) -> Option<Point> {
    move |with| match with {
        Location::Curve(t) => curve.point(t).ok(),
        _ => None,
    }
}

#[test]
fn planar_curves_and_conics_meet_where_opencascade_finds_it() {
    let mut told = Told::default();
    for case in golden("planar") {
        let (a, b) = (curve(&case["a"]), curve(&case["b"]));
        for (a, b) in [(&a, &b), (&b, &a)] {
            let found = curves(a, b, &Options::default()).unwrap();
            told.compare(&case, &found);
            told.at_and_with(a, &found, on_curve(b));
        }
    }
    told.done([88, 250, 20]);
}

#[test]
fn curves_in_space_meet_where_opencascade_finds_it() {
    let mut told = Told::default();
    for case in golden("space") {
        let (a, b) = (curve(&case["a"]), curve(&case["b"]));
        let options = Options::within(1e-7);
        let found = curves(&a, &b, &options).unwrap();
        told.compare(&case, &found);
        told.at_and_with(&a, &found, on_curve(&b));
        let near = found.meetings.iter().map(|m| (m.point - point(&case["known"])).norm());
        assert!(near.fold(f64::INFINITY, f64::min) <= 1e-7, "{}", case["name"]);
    }
    told.done([15, 15, 0]);
}

#[test]
fn curves_meet_surfaces_of_all_kinds_where_opencascade_finds_it() {
    let mut told = Told::default();
    for case in golden("surfaces") {
        let (a, b) = (curve(&case["a"]), surface(&case["b"]));
        let found = curve_surface(&a, &b, &Options::default()).unwrap();
        told.compare(&case, &found);
        told.at_and_with(&a, &found, |with| match with {
            Location::Surface(u, v) => b.point(u, v).ok(),
            _ => None,
        });
    }
    told.done([54, 150, 3]);
}

#[test]
fn curves_meet_planes_where_opencascade_finds_it() {
    let mut told = Told::default();
    for case in golden("planes") {
        let own = curve(&case["a"]);
        let plane = Plane::new(point(&case["b"]["point"]), point(&case["b"]["normal"]).coords).unwrap();
        let found = curve_plane(&own, &plane, &Options::default()).unwrap();
        // The parameter told is that of the place told.
        for m in &found.meetings {
            let off = (own.point(m.at).unwrap() - m.point).norm();
            assert!(off <= 1e-12, "{} at {}: {off:.1e}", case["name"], m.at);
        }
        told.compare(&case, &found);
    }
    told.done([42, 100, 6]);
}

#[test]
fn sections_of_all_degrees_are_those_of_opencascade() {
    let (mut cases, mut wrong) = (0, Vec::new());
    for case in golden("sections") {
        let normal = point(&case["normal"]).coords;
        let plane = Plane::new(point(&case["point"]), normal).unwrap();
        let found = section(&surface(&case["b"]), &plane, &Options::within(1e-7)).unwrap();
        assert!(found.undecided.is_empty(), "{}", case["name"]);
        let length: f64 = found.curves.iter().map(|c| c.curve.length(1e-10).unwrap().value).sum();
        let theirs = case["length"].as_f64().unwrap();
        if (length - theirs).abs() > 1e-6 * theirs {
            wrong.push(format!(
                "{} length {length}, not {theirs}: {:.1e}",
                case["name"],
                length / theirs - 1.0
            ));
        }
        for p in points(&case["points"]) {
            let near = found.curves.iter().map(|c| c.curve.closest(p).unwrap().distance);
            let near = near.fold(f64::INFINITY, f64::min);
            if near > 1e-6 {
                wrong.push(format!("{} {p} is {near:.1e} away", case["name"]));
            }
        }
        cases += 1;
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(cases >= 15, "{cases}");
}

//! Contacts along edges against OpenCASCADE's: `golden/contacts.py`.
#![allow(clippy::unwrap_used, reason = "these are tests, their helpers included")]

use loftsman_kernel::Point;
use loftsman_kernel::functional::{Edge, Shapes};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::spline::{Space, Surface};
use loftsman_matching::{Limits, matching};
use serde_json::Value;

fn surface(case: &Value, name: &str) -> Surface {
    let rows = |name: &str| case[name].as_array().unwrap().clone();
    let numbers =
        |row: &Value| row.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect::<Vec<_>>();
    let points: Vec<Point> = rows(name)
        .iter()
        .flat_map(|row| row.as_array().unwrap().clone())
        .map(|at| Point::from_slice(&numbers(&at)))
        .collect();
    let weights: Vec<f64> = rows(&format!("{name}_weights")).iter().flat_map(numbers).collect();
    let degree = |k: usize| case["degrees"][k].as_u64().unwrap() as usize;
    let count = rows(name).len();
    let space = |degree, n| Space::clamped_uniform(degree, n).unwrap();
    let rational = case["rational"].as_bool().unwrap();
    Surface::build(
        space(degree(0), count),
        space(degree(1), points.len() / count),
        points,
        rational.then_some(weights),
    )
    .unwrap()
}

#[test]
fn angle_and_curvature_are_those_of_opencascade() {
    let cases: Value = serde_json::from_str(include_str!("golden/contacts.json")).unwrap();
    let mut done = 0;
    for case in cases.as_array().unwrap() {
        let (first, second) = (surface(case, "first"), surface(case, "second"));
        let shapes = Shapes::new([&second as &dyn Shape, &first]);
        let asked = matching(Edge::UStart, 1, Edge::UEnd, 2, Limits::default());
        let found = asked.deviation(&shapes).unwrap();
        let wanted = |name: &str| case[name].as_f64().unwrap();
        assert!(found.distance < 1e-13);
        // Each looks at places of its own: the largest of all is a little more.
        for (name, found) in [
            ("angle", found.angle),
            ("curvature", found.curvature),
            ("largest", found.curvature / found.part),
        ] {
            assert!(
                (found / wanted(name) - 1.0).abs() < 2e-3,
                "{}: {name} {found}, {}",
                case["skew"],
                wanted(name)
            );
        }
        done += 1;
    }
    assert!(done >= 7);
}

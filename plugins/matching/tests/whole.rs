//! What a match does to the whole of a surface, away from the edge: measured on a grid of the tests' own.
#![allow(clippy::unwrap_used, reason = "these are tests, their helpers included")]

use loftsman_kernel::plugin::{Context, NoClock, Operation, Parameters, Plugin, Quiet, Registry};
use loftsman_kernel::scene::{Object, Scene};
use loftsman_kernel::spline::{Space, Surface};
use loftsman_kernel::{Point, Vector};
use loftsman_matching::{MatchOperation, MatchingPlugin};
use serde_json::{Value, json};

/// `u1` of the first matched to `u0` of the second: the surface, and what is told.
fn matched(
    pair: &[Surface; 2],
    continuity: usize,
    metric: Option<&str>,
) -> Result<(Surface, String), String> {
    let mut registry = Registry::new();
    MatchingPlugin.register(&mut registry);
    let context = Context { registry: &registry, observer: &Quiet, clock: &NoClock };
    let mut fields = json!({ "object": "a", "edge": "u1", "with": { "object": "b", "edge": "u0" },
        "continuity": continuity });
    if let Some(metric) = metric {
        fields["metric"] = json!(metric);
    }
    let mut scene = Scene::new();
    scene.add(Object::new("a", pair[0].clone().into())).unwrap();
    scene.add(Object::new("b", pair[1].clone().into())).unwrap();
    let parameters = Parameters::new(fields, "step[0]").unwrap();
    let report = MatchOperation.apply(&mut scene, &parameters, &context).map_err(|e| e.to_string())?;
    Ok((scene.surface("a").unwrap().clone(), report.notes.join("; ")))
}

/// How far the surface went at most, how far its edge `u1` did, and the least cosine between the normals before and after.
#[derive(Debug)]
struct Went {
    moved: f64,
    edge: f64,
    cosine: f64,
}

fn went(before: &Surface, after: &Surface) -> Went {
    const PLACES: usize = 60;
    let look = |s: &Surface, i: usize, j: usize| -> (Vector, Vector) {
        let at = |(a, b): (f64, f64), k: usize| a + (b - a) * k as f64 / PLACES as f64;
        let mut all = [Vector::zeros(); 4];
        s.derivatives_into(at(s.u().domain(), i), at(s.v().domain(), j), [1, 1], &mut all).unwrap();
        (all[0], all[2].normalize().cross(&all[1].normalize()).normalize())
    };
    let mut found = Went { moved: 0.0, edge: 0.0, cosine: 1.0 };
    for i in 0..=PLACES {
        for j in 0..=PLACES {
            let ((p, m), (q, n)) = (look(before, i, j), look(after, i, j));
            found.moved = found.moved.max((p - q).norm());
            found.edge = found.edge.max(if i == PLACES { (p - q).norm() } else { 0.0 });
            found.cosine = found.cosine.min(m.dot(&n));
        }
    }
    found
}

/// The largest distance between the edges, at shares of their domains, and the largest angle between the ways across in the planes square to the
/// edge, in degrees.
fn left(after: &Surface, beside: &Surface) -> [f64; 2] {
    let look = |s: &Surface, u: f64, v: f64| {
        let mut all = [Vector::zeros(); 4];
        s.derivatives_into(u, v, [1, 1], &mut all).unwrap();
        let along = all[1].normalize();
        (all[0], (all[2] - along * along.dot(&all[2])).normalize())
    };
    let ((a, b), (c, d)) = (after.v().domain(), beside.v().domain());
    let mut worst = [0.0_f64; 2];
    for k in 0..=300 {
        let share = f64::from(k) / 300.0;
        let (p, x) = look(after, after.u().domain().1, a + (b - a) * share);
        let (q, y) = look(beside, beside.u().domain().0, c + (d - c) * share);
        worst[0] = worst[0].max((p - q).norm());
        worst[1] = worst[1].max(x.cross(&y).norm().atan2(x.dot(&y)).to_degrees());
    }
    worst
}

/// Two pairs of smooth surfaces, half a unit of two apart, with knots close together.
fn towers() -> Vec<[Surface; 2]> {
    let cases: Value = serde_json::from_str(include_str!("golden/towers.json")).unwrap();
    let numbers =
        |row: &Value| row.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect::<Vec<_>>();
    let surface = |one: &Value| {
        let space = |k: usize| {
            Space::open(one["degrees"][k].as_u64().unwrap() as usize, numbers(&one["knots"][k])).unwrap()
        };
        let rows = |name: &str| one[name].as_array().map(|rows| rows.to_vec());
        let points = rows("points").unwrap();
        let points =
            points.iter().flat_map(|row| row.as_array().unwrap()).map(|at| Point::from_slice(&numbers(at)));
        let weights = rows("weights").map(|rows| rows.iter().flat_map(numbers).collect());
        Surface::build(space(0), space(1), points.collect(), weights).unwrap()
    };
    cases.as_array().unwrap().iter().map(|case| [surface(&case["a"]), surface(&case["b"])]).collect()
}

/// What bends least may rise far beyond what its edge asks for, or fold over: then it is moved least, which is told. Who asks for a metric gets it, and hears of
/// folds.
#[test]
fn what_would_tower_or_fold_over_is_moved_least() {
    let pairs = towers();
    let (after, told) = matched(&pairs[0], 1, None).unwrap();
    let found = went(&pairs[0][0], &after);
    assert!(found.moved < 1.1 * found.edge && found.cosine > 0.0, "{found:?} {told}");
    assert!(
        told.contains("bent as little as can be it would fold back over itself near u = 0.9")
            && told.contains("metric = \"least\""),
        "{told}"
    );
    let (after, told) = matched(&pairs[0], 1, Some("bend")).unwrap();
    assert!(went(&pairs[0][0], &after).moved > 1.0 && !told.contains("bent as little"), "{told}");

    let (after, told) = matched(&pairs[1], 1, None).unwrap();
    let found = went(&pairs[1][0], &after);
    assert!(found.cosine > 0.5, "{found:?} {told}");
    assert!(told.contains("bent as little as can be it would fold back over itself near u = 0.7"), "{told}");
    let (after, told) = matched(&pairs[1], 1, Some("bend")).unwrap();
    assert!(went(&pairs[1][0], &after).cosine < -0.9, "{told}");
    assert!(
        told.contains("it folds back over itself near u = 0.7") && told.contains("without `metric`"),
        "{told}"
    );
}

/// A pair of smooth sheets, some way apart, of degrees 2 to 5, clamped or not, one of four of them rational.
fn smooth(seed: u64) -> [Surface; 2] {
    let mut state = seed.wrapping_mul(2654435761) + 1;
    let mut next = move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut sheet = |shift: f64| {
        let mut space = || {
            let degree = 2 + (4.0 * next()) as usize;
            let count = degree + 1 + (5.0 * next()) as usize;
            let gaps: Vec<f64> = (0..count + degree).map(|_| 0.2 + next()).collect();
            let mut knots = vec![0.0; 1];
            gaps.iter().for_each(|gap| knots.push(knots[knots.len() - 1] + gap));
            if next() < 0.7 {
                let (first, last) = (knots[degree], knots[count]);
                knots[..degree].fill(first);
                knots[count + 1..].fill(last);
            }
            Space::open(degree, knots).unwrap()
        };
        let (u, v) = (space(), space());
        let wide = 0.7 + 0.5 * next();
        let part = |k: usize, n: usize| 2.0 * k as f64 / (n - 1) as f64 - 1.0;
        let mut points = Vec::new();
        for i in 0..u.len() {
            for j in 0..v.len() {
                let [a, b, c] = [0; 3].map(|_| 0.15 * (next() - 0.5));
                points.push(Point::new(shift + part(i, u.len()) + a, wide * part(j, v.len()) + b, 2.0 * c));
            }
        }
        let weights = (next() < 0.25).then(|| points.iter().map(|_| 0.6 + next()).collect());
        Surface::build(u, v, points, weights).unwrap()
    };
    [sheet(0.0), sheet(2.1)]
}

/// No fold is untold, nothing goes much farther than it has to, what is left along the edge is within the limits; few are refused, and what is advised helps.
#[test]
fn smooth_surfaces_meet_without_folds_or_towers() {
    let (mut refused, mut told, mut folded, mut other) = (Vec::new(), 0, 0, 0);
    const COUNT: u64 = 40;
    for seed in 0..COUNT {
        let pair = smooth(seed);
        let (after, notes) = match matched(&pair, 1, None) {
            Ok(found) => found,
            Err(problem) => {
                refused.push(format!("{seed}: {problem}"));
                continue;
            }
        };
        let (found, [_, angle]) = (went(&pair[0], &after), left(&after, &pair[1]));
        let is_told = notes.contains("it folds back over itself");
        told += usize::from(is_told);
        folded += usize::from(found.cosine < -0.5);
        other +=
            usize::from(notes.contains("bent as little as can be it would") || notes.contains("left free"));
        assert!(found.cosine > -0.5 || is_told, "{seed}: {found:?} {notes}");
        assert!(found.moved < 2.5 * found.edge, "{seed}: {found:?} {notes}");
        // Compared at shares of the domains, beside one another but for what the positions allow.
        assert!(angle < 5.0, "{seed}: {angle} {notes}");
    }
    eprintln!("{COUNT}: {folded} folded, {told} told, {other} another way, refused {refused:#?}");
    assert!(refused.is_empty() && told <= 1 && other >= 4, "{told} {other} {refused:#?}");
}

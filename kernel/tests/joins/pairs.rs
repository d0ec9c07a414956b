//! The three pairs that were found apart, and others that can or cannot be had.

use std::sync::Arc;

use loftsman_kernel::Point;
use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::{Edge, Functional, join};
use loftsman_kernel::solve::Automatic;
use loftsman_kernel::spline::{Curve, Direction, Space, Surface};
use serde_json::Value;

use super::{Pair, solvers};

fn surface(value: &Value) -> Surface {
    let numbers =
        |v: &Value| -> Vec<f64> { v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect() };
    let space =
        |v: &Value| Space::open(v["degree"].as_u64().unwrap() as usize, numbers(&v["knots"])).unwrap();
    let rows = |v: &Value| -> Vec<Value> {
        v.as_array().unwrap().iter().flat_map(|r| r.as_array().unwrap().clone()).collect()
    };
    let points = rows(&value["points"]).iter().map(|p| Point::from_slice(&numbers(p))).collect();
    let weights = value.get("weights").map(|w| rows(w).iter().map(|x| x.as_f64().unwrap()).collect());
    Surface::build(space(&value["u"]), space(&value["v"]), points, weights).unwrap()
}

fn pairs() -> Vec<(String, Pair)> {
    let all: Value = serde_json::from_str(include_str!("pairs.json")).unwrap();
    let mut pairs = Vec::new();
    for (name, pair) in all.as_object().unwrap() {
        for order in 0..=2 {
            let (a, b) = (surface(&pair["a"]), surface(&pair["b"]));
            pairs.push((name.clone(), Pair { a, b, edges: ("u1", "u0"), order }));
        }
    }
    assert_eq!(pairs.len(), 9);
    pairs
}

#[test]
fn the_pairs_that_were_left_apart() {
    let mut held = 0;
    for (name, pair) in pairs() {
        for solver in solvers() {
            match pair.solve(pair.join(), Arc::clone(&solver)) {
                Ok(done) => {
                    assert!(name == "equal-edge-weights" && pair.order == 0, "{name} C{}", pair.order);
                    assert!(done.apart(|x| x).iter().all(|a| *a <= 1e-14));
                    held += 1;
                }
                Err(error) => {
                    let text = error.to_string();
                    assert!(name != "equal-edge-weights" || pair.order > 0, "{text}");
                    let why = match (name.as_str(), pair.order) {
                        ("equal-edge-weights", _) => "the weights beside the edges are unlike",
                        _ => "the weights of the edges are unlike",
                    };
                    assert!(
                        text.contains(why) && text.contains("raise the degree of both along the edge by 3"),
                        "{text}"
                    );
                }
            }
        }
    }
    // With the adjoint, too: six equations a coordinate.
    assert_eq!(held, 6);
}

/// What the refusal says to do helps: with the degree raised the edges are one, in a cubic.
#[test]
fn raising_the_degree_of_both_helps() {
    for (name, pair) in pairs() {
        let raise = |s: &Surface| s.elevate(Direction::V, 3).unwrap();
        let pair = Pair { a: raise(&pair.a), b: raise(&pair.b), ..pair };
        for solver in solvers().into_iter().take(4) {
            let by = solver.name().to_owned();
            let done = pair
                .solve(pair.join(), solver)
                .unwrap_or_else(|e| panic!("{name} C{} {by}: {e}", pair.order));
            let apart = done.apart(|x| x);
            assert!(apart.iter().all(|a| *a <= 1e-11), "{name} C{} {by}: {apart:?}", pair.order);
            // The edge is not a point.
            let ends = |s: &Surface| s.point(4.0, 3.0).unwrap() - s.point(4.0, 0.0).unwrap();
            assert!(ends(&done.a).norm() > 2.0, "{name} C{}: {}", pair.order, ends(&done.a));
        }
    }
}

/// Equal weights, up to a factor, help: the second's beside and along the edge are the first's.
#[test]
fn weights_that_are_made_alike_help() {
    for (name, pair) in pairs() {
        let weights = pair.a.weights().map(<[f64]>::to_vec);
        // Mirrored in the edge: then the weights' derivatives there are the first's, but for their sign.
        let (u, v, points, _) = pair.b.clone().into_parts();
        let (n, m) = (u.len(), v.len());
        let mirrored: Option<Vec<f64>> =
            weights.map(|w| (0..n * m).map(|k| 2.5 * w[(n - 1 - k / m) * m + k % m]).collect());
        let b = Surface::build(u, v, points, mirrored).unwrap();
        let pair = Pair { b, ..pair };
        let result = pair.solve(pair.join(), Arc::new(Automatic));
        if pair.order == 0 || pair.a.weights().is_none() {
            let apart = result.unwrap_or_else(|e| panic!("{name}: {e}")).apart(|x| x);
            assert!(apart.iter().all(|a| *a <= 1e-11), "{name} C{}: {apart:?}", pair.order);
        } else {
            assert!(result.unwrap_err().to_string().contains("the weights beside the edges are unlike"));
        }
    }
}

#[test]
fn a_cubic_edge_against_a_linear_one_becomes_linear() {
    let patch = |x: f64, v: Space| {
        let u = Space::clamped_uniform(3, 5).unwrap();
        let (n, m) = (u.len(), v.len());
        let points = (0..n * m)
            .map(|k| {
                let y = (k % m) as f64 * 3.0 / (m - 1) as f64;
                Point::new(x + (k / m) as f64, y, (1.7 * k as f64).sin())
            })
            .collect();
        Surface::new(u, v, points).unwrap()
    };
    for order in 0..=2 {
        let pair = Pair {
            a: patch(0.0, Space::clamped_uniform(3, 7).unwrap()),
            b: patch(4.2, Space::clamped_uniform(1, 2).unwrap()),
            edges: ("u1", "u0"),
            order,
        };
        for solver in solvers().into_iter().take(4) {
            let edited = pair.edit().ask(pair.join().hold()).solve_with(Arc::clone(&solver)).unwrap();
            let notes = &edited.report().notes;
            assert!(
                notes.len() == 1 && notes[0].contains("only 2 of 7 and 2 degrees of freedom"),
                "{notes:?}"
            );
            assert_eq!(edited.report().rank, 3 * 7 * (order + 1));
            let done = pair.solve(pair.join(), solver).unwrap();
            assert!(done.apart(|x| x).iter().all(|a| *a <= 1e-12));
            let edge: Curve = Curve::new(done.a.v().clone(), done.a.points()[28..].to_vec()).unwrap();
            let middle = edge.point(2.0).unwrap();
            let straight =
                edge.point(0.0).unwrap() + (edge.point(4.0).unwrap() - edge.point(0.0).unwrap()) * 0.5;
            assert!((middle - straight).norm() < 1e-12);
        }
    }
}

#[test]
fn what_cannot_be_asked_says_why() {
    let patch = |u: Space, v: Space| {
        let (n, m) = (u.len(), v.len());
        let points =
            (0..n * m).map(|k| Point::new((k / m) as f64, (k % m) as f64, 0.3 * (k % 3) as f64)).collect();
        Surface::new(u, v, points).unwrap()
    };
    let cubic = |knots: &[f64]| Space::clamped(3, knots).unwrap();
    let a = patch(cubic(&[0.0, 1.0]), cubic(&[0.0, 1.0, 2.0]));
    let near = patch(cubic(&[0.0, 1.0]), cubic(&[0.0, 1.0 + 1e-8, 2.0]));
    let equal = patch(cubic(&[0.0, 1.0]), cubic(&[0.0, 1.0 + 1e-15, 2.0]));
    let pair = |b: &Surface, order| Pair { a: a.clone(), b: b.clone(), edges: ("u1", "u0"), order };
    let why = |pair: &Pair| pair.solve(pair.join(), Arc::new(Automatic)).unwrap_err().to_string();
    assert!(why(&pair(&near, 0)).contains("knots that nearly agree, 1 and 1.00000001: make them equal"));
    let done = pair(&near, 0).solve(pair(&near, 0).join().within(1e-6), Arc::new(Automatic)).unwrap();
    assert!(done.apart(|x| x)[0] < 1e-7);
    assert!(pair(&equal, 0).solve(pair(&equal, 0).join(), Arc::new(Automatic)).is_ok());
    assert!(why(&pair(&a, 3)).contains("continuity 3 is not 0, 1 or 2"));

    let alone = pair(&a, 0);
    let bind = |join: loftsman_kernel::functional::Join| join.bind(&alone.shapes()).unwrap_err().to_string();
    assert!(bind(join(Edge::UEnd, 0, Edge::UEnd, 1)).contains("cannot be joined with itself"));
    assert!(bind(join(Edge::UEnd, 1, [0.0, 0.0], 0)).contains("an edge can only be joined with an edge"));
    assert!(bind(join(Edge::UEnd, 1, Edge::UStart, 0).within(-1.0)).contains("tolerance -1 is not a length"));
    assert!(bind(join(Edge::UEnd, 1, Edge::UStart, 0).within(f64::NAN)).contains("not a length"));
    assert!(bind(join([0.0, 0.0], 1, [1.0, 0.0], 0).within(1.0)).contains("whole edges only"));
    assert!(bind(join(Edge::UEnd, 7, Edge::UStart, 0)).contains("no shape 7"));
    let curve = Curve::new(cubic(&[0.0, 1.0]), a.points()[..4].to_vec()).unwrap();
    let edit = Pair::edit(&alone).with(Box::new(curve)).ask(join(Edge::UEnd, 2, Edge::UStart, 0).hold());
    assert!(edit.solve().unwrap_err().to_string().contains("a curve has ends, no edges"));
    // A surface's own edges are joined: it closes.
    let bound = join(Edge::UEnd, 0, Edge::UStart, 1).bind(&alone.shapes()).unwrap().unwrap();
    assert_eq!(bound.equations(), 3 * 2 * a.v().len());
    let closed = Pair::edit(&alone).ask(join(Edge::UEnd, 0, Edge::UStart, 1).hold()).solve().unwrap();
    let gaps =
        join(Edge::UEnd, 0, Edge::UStart, 1).gaps(&loftsman_kernel::functional::Shapes::one(closed.shape()));
    assert!(gaps.unwrap().iter().all(|g| *g < 1e-13));
}

/// Sizes from 1e-9 to 1e9, and domains far from zero.
#[test]
fn sizes_do_not_matter() {
    for size in [1e-9, 1.0, 1e9] {
        for start in [0.0, 1e3] {
            let at = |k: f64| start + k * 1e-2;
            let space = |p: usize| Space::clamped(p, &[at(0.0), at(1.0), at(2.5), at(3.0)]).unwrap();
            let patch = |x: f64, v: Space| {
                let u = Space::clamped(2, &[0.0, size, 2.0 * size]).unwrap();
                let (n, m) = (u.len(), v.len());
                let point = |k: usize| {
                    Point::new(x + (k / m) as f64, (k % m) as f64 * 5.0 / (m - 1) as f64, (k as f64).sin())
                        * size
                };
                Surface::new(u, v, (0..n * m).map(point).collect()).unwrap()
            };
            for order in 0..=2 {
                let pair =
                    Pair { a: patch(0.0, space(3)), b: patch(4.0, space(4)), edges: ("u1", "u0"), order };
                let done = pair.solve(pair.join(), Arc::new(Automatic)).unwrap();
                // A parameter is known to an ulp of where the domain lies.
                let slack = 1e-11 + start * 1e-16 / 3e-2 * 10.0;
                assert!(done.apart(|x| x).iter().all(|a| *a <= slack), "{:?}", done.apart(|x| x));
            }
        }
    }
}

/// A wavy patch, its edge across `u`.
fn wavy(u: &Space, v: &Space, x: f64, weights: Option<Vec<f64>>) -> Surface {
    let (n, m) = (u.len(), v.len());
    let point = |k: usize| {
        let (i, j) = ((k / m) as f64 / (n - 1) as f64, (k % m) as f64 / (m - 1) as f64);
        Point::new(x + i, 3.0 * j, (1.3 * k as f64).sin() * 0.2)
    };
    Surface::build(u.clone(), v.clone(), (0..n * m).map(point).collect(), weights).unwrap()
}

/// Up to degree 25 along and across.
#[test]
fn high_degrees() {
    let space = |p: usize, knots: &[f64]| Space::clamped(p, knots).unwrap();
    let whole: &[f64] = &[0.0, 1.0, 2.0, 3.0];
    for (p, q) in [(7, 7), (6, 7), (25, 25), (25, 3), (5, 12), (25, 24)] {
        for knots in [whole, &[0.0, 1.7, 3.0]] {
            for order in 0..=2 {
                let a = wavy(&space(q.min(7), &[0.0, 1.0]), &space(p, whole), 0.0, None);
                let b = wavy(&space(25, &[0.0, 1.0]), &space(q, knots), 1.2, None);
                let pair = Pair { a, b, edges: ("u1", "u0"), order };
                let done = pair.solve(pair.join(), Arc::new(Automatic)).unwrap();
                let (seen, apart) = (done.witnessed(&pair, &pair.join()), done.apart(|x| x));
                assert!(seen <= 1e-11, "{p} {q} C{order}: {seen:e}");
                assert!(apart.iter().all(|a| *a <= 1e-11), "{p} {q} C{order}: {apart:?}");
            }
        }
    }
}

/// Knots of multiplicity p + 1, which tear a surface, in both edges or in one.
#[test]
fn torn_edges() {
    let torn =
        |at: f64| Space::open(2, [vec![0.0; 3], vec![at; 3], vec![1.6], vec![2.0; 3]].concat()).unwrap();
    let u = Space::clamped(2, &[0.0, 1.0]).unwrap();
    for (other, left) in [
        (torn(1.0), None),
        (torn(0.5), Some(4)),
        (Space::clamped(2, &[0.0, 1.0, 1.6, 2.0]).unwrap(), Some(5)),
    ] {
        for order in 0..=2 {
            let pair = Pair {
                a: wavy(&u, &torn(1.0), 0.0, None),
                b: wavy(&u, &other, 1.1, None),
                edges: ("u1", "u0"),
                order,
            };
            for solver in solvers().into_iter().take(4) {
                let edited = pair.edit().ask(pair.join().hold()).solve_with(Arc::clone(&solver)).unwrap();
                let notes = edited.report().notes.join("");
                let told = left.map(|left| format!("only {left} of 7 and"));
                assert!(told.map_or(notes.is_empty(), |told| notes.contains(&told)), "{left:?}: {notes}");
                let done = pair.solve(pair.join(), solver).unwrap();
                assert!(done.witnessed(&pair, &pair.join()) <= 1e-13);
                assert!(done.apart(|x| x).iter().all(|a| *a <= 1e-12), "{left:?}: {:?}", done.apart(|x| x));
            }
        }
    }
}

/// Weights from 1e-3 to 1e3, and all of them times 1e300 or 1e-300 in one surface.
#[test]
fn weights_far_apart() {
    let (u, v) = (Space::clamped_uniform(2, 4).unwrap(), Space::clamped_uniform(3, 6).unwrap());
    for factor in [1.0, 1e300, 1e-300] {
        let weights = |by: f64, mirrored: bool| -> Vec<f64> {
            let across = [1.0, 0.4, 2.0, 0.7];
            (0..24)
                .map(|k| {
                    by * across[if mirrored { 3 - k / 6 } else { k / 6 }]
                        * 10_f64.powf((k % 6) as f64 * 1.2 - 3.0)
                })
                .collect()
        };
        for order in 0..=2 {
            let pair = Pair {
                a: wavy(&u, &v, 0.0, Some(weights(1.0, false))),
                b: wavy(&u, &v, 1.1, Some(weights(factor, true))),
                edges: ("u1", "u0"),
                order,
            };
            for solver in solvers().into_iter().take(4) {
                let done = pair.solve(pair.join(), solver).unwrap();
                let apart = done.apart(|x| x);
                assert!(apart.iter().all(|a| *a <= 1e-11), "{factor:e} C{order}: {apart:?}");
            }
        }
    }
}

/// A tolerance is about positions: surfaces that meet at an angle meet, and the report says at which.
#[test]
fn a_join_within_a_tolerance_tells_the_angle() {
    let space = |knots: &[f64]| Space::clamped(3, knots).unwrap();
    // Flat, from an edge along y, rising by an angle; even in both parameters.
    let patch = |way: f64, degrees: f64, v: Space| {
        let u = space(&[0.0, 1.0]);
        let (sin, cos) = degrees.to_radians().sin_cos();
        let places: Vec<f64> =
            (0..v.len()).map(|j| v.flat()[j + 1..j + 4].iter().sum::<f64>() / 3.0).collect();
        let rows = (0..4).flat_map(|i| places.iter().map(move |y| (f64::from(i), *y)));
        let net = rows.map(|(x, y)| Point::new(way * x * cos, y, x * sin)).collect();
        Surface::new(u, v, net).unwrap()
    };
    for (degrees, order, told) in
        [(0.0, 0, "0°"), (0.02, 0, "0.02°"), (30.0, 0, "30.0°"), (110.0, 0, "110.0°"), (0.0, 1, "0°")]
    {
        let pair = Pair {
            a: patch(-1.0, 0.0, space(&[0.0, 1.0, 2.0])),
            b: patch(1.0, degrees, space(&[0.0, 0.7, 1.0, 2.0])),
            edges: ("u0", "u0"),
            order,
        };
        let join = pair.join().within(0.1);
        let crease = join.crease(&pair.shapes()).unwrap().unwrap().to_degrees();
        assert!((crease - degrees).abs() < 1e-9, "{crease} for {degrees}");
        let edited = pair.edit().ask(join.hold()).solve().unwrap();
        let note = edited.report().notes.iter().find(|note| note.contains("apart at most")).unwrap();
        assert!(note.ends_with(&format!("which nothing bounds, is {told} at most")), "{note}");
        assert_eq!(edited.shape_at(1).unwrap().control_vertices().len(), pair.b.points().len());
    }
}

/// Curves that both start (or both end) at the joint run on as one path: odd derivatives are opposite there.
#[test]
fn curves_that_start_at_one_joint_run_through_it() {
    let curve = |x: f64| {
        let points =
            (0..7).map(|i| Point::new(x + f64::from(i), (0.8 * f64::from(i) + x).sin(), 0.1 * x)).collect();
        Curve::new(Space::clamped_uniform(3, 7).unwrap(), points).unwrap()
    };
    let (first, second) = (curve(0.0), curve(3.0));
    let (start, end) = first.domain();
    for (at, with) in [(start, start), (end, end), (start, end), (end, start), (1.3, 2.2), (start, 2.2)] {
        let edited = Edit::new(&first)
            .with(Box::new(second.clone()))
            .ask(join(at, 1, with, 2).hold())
            .solve()
            .unwrap();
        let any: &dyn std::any::Any = edited.shape_at(1).unwrap();
        let other: &Curve = any.downcast_ref().unwrap();
        let turn = if at == with && (at == start || at == end) { -1.0 } else { 1.0 };
        let apart = |k: usize, sign: f64| {
            let value = |c: &Curve, u: f64| {
                if k == 0 { c.point(u).unwrap().coords } else { c.derivative(u, k).unwrap() }
            };
            (value(edited.shape(), at) - value(other, with) * sign).norm()
        };
        assert!(apart(0, 1.0) < 1e-12 && apart(1, turn) < 1e-12 && apart(2, 1.0) < 1e-11, "{at} {with}");
        assert!(apart(1, -turn) > 0.1, "{at} {with}");
    }
}

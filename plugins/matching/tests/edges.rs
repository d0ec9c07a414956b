//! Edges on curves and on other surfaces' edges, against closed forms and evaluated all along.
#![allow(clippy::unwrap_used, clippy::panic, reason = "these are tests, their helpers included")]

use loftsman_kernel::conformance::functional_conformance;
use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::{Edge, Functional, Shapes};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::spline::{Curve, Direction, Space, Surface};
use loftsman_kernel::{Point, Vector};
use loftsman_matching::{Limits, edge_on, matching};

/// Numbers without a pattern, between -1 and 1.
fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

fn spaces(p: usize, n: usize) -> Vec<Space> {
    let breaks: Vec<f64> = (0..=n).map(|i| -1.0 + i as f64 + 0.3 * (i as f64 * 1.7).sin()).collect();
    vec![
        Space::clamped_uniform(p, p + n).unwrap(),
        Space::clamped(p, &breaks).unwrap(),
        Space::floating_uniform(p, p + n).unwrap(),
        Space::periodic_uniform(p, p + n + 1).unwrap(),
    ]
}

/// A surface over two spaces, rough, perhaps rational; its edges along `v` are what is moved.
fn rough(u: Space, v: Space, seed: u64, rational: bool) -> Surface {
    let mut noise = noise(seed);
    let (rows, columns) = (u.len(), v.len());
    let closed = v.is_periodic();
    let points = (0..rows * columns)
        .map(|k| {
            let (i, j) = ((k / columns) as f64, (k % columns) as f64);
            let (x, y) = if closed {
                let turn = std::f64::consts::TAU * j / columns as f64;
                ((4.0 + i) * turn.cos(), (4.0 + i) * turn.sin())
            } else {
                (2.0 * i, 1.5 * j)
            };
            Point::new(x + 0.2 * noise(), y + 0.2 * noise(), noise())
        })
        .collect();
    let weights = rational.then(|| (0..rows * columns).map(|_| 1.5 + 0.9 * noise()).collect());
    Surface::build(u, v, points, weights).unwrap()
}

/// A curve in the space of an edge (with its weights), near to the edge.
fn beside(edge: &Curve, seed: u64) -> Curve {
    let mut noise = noise(seed);
    let moved =
        edge.points().iter().map(|p| p + Vector::new(0.4 * noise(), 0.4 * noise(), 1.0 + 0.4 * noise()));
    Curve::build(edge.space().clone(), moved.collect(), edge.weights().map(<[f64]>::to_vec)).unwrap()
}

fn edge_of(surface: &Surface, name: &str) -> Curve {
    let edges = loftsman_kernel::shape::edges_of(surface, "test").unwrap();
    let index = edges.iter().position(|edge| edge.name == name).unwrap();
    loftsman_kernel::topology::EdgeCurve::of(surface, index, "test").unwrap().curve
}

/// The largest distance of the edge `u1` from a curve, each point of one looked for on the other.
fn apart(surface: &Surface, curve: &Curve) -> f64 {
    let edge = edge_of(surface, "u1");
    let (a, b) = edge.domain();
    let at = |i: usize| a + (b - a) * i as f64 / 64.0;
    let point = |i: usize| surface.point(surface.u().domain().1, at(i)).unwrap();
    (0..=64).map(|i| (curve.closest(point(i)).unwrap().point - point(i)).norm()).fold(0.0, f64::max)
}

#[test]
fn an_edge_becomes_the_curve_to_rounding_where_its_space_holds_it() {
    let mut done = 0;
    for p in [1, 2, 3, 4, 5, 6, 7, 25] {
        for (kind, v) in spaces(p, 4).into_iter().enumerate() {
            for rational in [false, true] {
                let seed = (10 * p + kind) as u64;
                let surface = rough(Space::clamped_uniform(2, 4).unwrap(), v.clone(), seed, rational);
                let edge = edge_of(&surface, "u1");
                let own = beside(&edge, seed + 1000);
                let mut curves =
                    vec![own.clone(), own.reverse().unwrap(), own.reparametrise(10.0, 11.0).unwrap()];
                if own.is_periodic() {
                    let (a, b) = own.domain();
                    curves.push(own.started_at(a + (b - a) / v.len() as f64 * 2.0).unwrap());
                }
                for curve in curves {
                    let asked = edge_on(Edge::UEnd, 1);
                    let edit = Edit::new(&surface).with(Box::new(curve.clone())).smooth(0).ask(asked.hold());
                    let edited = match edit.solve() {
                        Ok(edited) => edited,
                        Err(e) => panic!("degree {p}, space {kind}, rational {rational}: {e}"),
                    };
                    let far = apart(edited.shape(), &curve);
                    assert!(far < 1e-9, "degree {p}, space {kind}, rational {rational}: {far:e}");
                    // The curve stands still, and so does what is beyond the edge's own row.
                    let stood = edited.shape_at(1).unwrap().control_vertices();
                    assert_eq!(stood, curve.points());
                    let columns = v.len();
                    assert_eq!(edited.shape().points()[..2 * columns], surface.points()[..2 * columns]);
                    done += 1;
                }
            }
        }
    }
    assert!(done >= 190, "{done}");
}

#[test]
fn a_curve_of_lower_degree_and_fewer_knots_is_held_exactly() {
    for p in 2..=7 {
        let space = Space::clamped(p, &[0.0, 0.2, 0.5, 0.9, 1.0]).unwrap();
        let surface = rough(Space::clamped_uniform(3, 5).unwrap(), space, p as u64, false);
        let edge = edge_of(&surface, "u1");
        let (a, b) = edge.domain();
        let mut noise = noise(p as u64);
        let coarse = Space::clamped(p - 1, &[0.0, 0.5, 1.0]).unwrap();
        // Smoothness of degree p - 1 at 0.5 needs a double knot in degree p.
        let refined = surface.insert_knots(Direction::V, &[0.5]).unwrap();
        let points = (0..coarse.len()).map(|i| {
            let t = a + (b - a) * i as f64 / (coarse.len() - 1) as f64;
            edge.point(t).unwrap() + Vector::new(noise(), noise(), noise())
        });
        let curve = Curve::new(coarse.clone(), points.collect()).unwrap();
        let edited =
            Edit::new(&refined).with(Box::new(curve.clone())).smooth(0).ask(edge_on(Edge::UEnd, 1).hold());
        assert!(apart(edited.solve().unwrap().shape(), &curve) < 1e-10);
        // Without the knot it is refused, by what is missing; with a tolerance it is near.
        let ask = |tolerance: Option<f64>| {
            let asked = edge_on(Edge::UEnd, 1);
            let asked = tolerance.map_or(asked.clone(), |t| asked.within(t));
            Edit::new(&surface).with(Box::new(curve.clone())).smooth(0).ask(asked.hold()).solve()
        };
        let refused = ask(None).unwrap_err().to_string();
        assert!(
            refused.contains("knots that the edge has not") && refused.contains("tolerance"),
            "{refused}"
        );
        assert!(ask(Some(1e-9)).is_err(), "degree {p}: nothing is within that");
        let near = ask(Some(1.0)).unwrap();
        let far = apart(near.shape(), &curve);
        assert!(far > 1e-6 && far <= 1.0, "{far}");
    }
}

#[test]
fn a_tube_ends_on_a_circle() {
    // Exact: the weights of a revolution's edge are those of the circle.
    let line = Curve::new(
        Space::clamped_uniform(1, 3).unwrap(),
        vec![Point::new(1.0, 0.0, 0.0), Point::new(1.2, 0.0, 1.0), Point::new(1.0, 0.0, 2.0)],
    )
    .unwrap();
    let tube = Surface::revolution(&line, Point::origin(), Vector::z(), std::f64::consts::TAU).unwrap();
    let circle = Curve::circle(Point::new(0.3, 0.2, 2.5), Vector::new(0.2, 0.0, 1.0), 0.7).unwrap();
    let mut done = 0;
    for edge in [Edge::UStart, Edge::UEnd, Edge::VStart, Edge::VEnd] {
        if edge.number_on(&tube).is_err() {
            continue;
        }
        let edit = Edit::new(&tube).with(Box::new(circle.clone())).ask(edge_on(edge, 1).hold());
        let edited = match edit.solve() {
            Ok(edited) => edited,
            Err(error) => {
                // The seam is straight, of degree 1.
                assert!(matches!(edge, Edge::UStart | Edge::UEnd), "{edge}: {error}");
                assert!(error.to_string().contains("degree"), "{edge}: {error}");
                continue;
            }
        };
        let name = edge.to_string();
        let (a, b) = edge_of(edited.shape(), &name).domain();
        for i in 0..=50 {
            let point = edge_of(edited.shape(), &name).point(a + (b - a) * f64::from(i) / 50.0).unwrap();
            let from = point - Point::new(0.3, 0.2, 2.5);
            assert!((from.norm() - 0.7).abs() < 1e-12 && from.dot(&Vector::new(0.2, 0.0, 1.0)).abs() < 1e-12);
        }
        done += 1;
    }
    assert_eq!(done, 2);
}

/// A quarter of a cylinder of radius 2 about y, from x = 2 (z = 0) up to z = 2; `u` runs round it, its edges lie along y.
fn cylinder() -> Surface {
    let quarter = std::f64::consts::FRAC_PI_2;
    let arc = Curve::arc(Point::new(2.0, 0.0, 0.0), Point::origin(), -Vector::y(), quarter).unwrap();
    Surface::extrusion(&arc, Vector::y() * 3.0).unwrap()
}

/// The edge of the cylinder at x = 2, whichever it is.
fn low_edge(cylinder: &Surface) -> Edge {
    [Edge::UStart, Edge::UEnd, Edge::VStart, Edge::VEnd]
        .into_iter()
        .find(|edge| {
            let curve = edge_of(cylinder, &edge.to_string());
            let (a, b) = curve.domain();
            [a, b].iter().all(|&t| (curve.point(t).unwrap().x - 2.0).abs() < 1e-9)
        })
        .unwrap()
}

/// A bent sheet below, whose edge `u1` comes near to the cylinder's.
fn sheet(u: Space, v: Space) -> Surface {
    let (rows, columns) = (u.len(), v.len());
    let at = |k: usize| {
        let (i, j) = ((k / columns) as f64 / (rows - 1) as f64, (k % columns) as f64 / (columns - 1) as f64);
        Point::new(2.3 + 0.4 * (1.0 - i), 3.2 * j - 0.1, -0.2 - 3.0 * (1.0 - i) + 0.2 * (3.0 * j).sin())
    };
    Surface::new(u, v, (0..rows * columns).map(at).collect()).unwrap()
}

#[test]
fn what_is_matched_to_a_cylinder_has_its_tangents_and_its_curvature() {
    let cylinder = cylinder();
    let low = low_edge(&cylinder);
    for p in 2..=7 {
        for q in [1, 2, 3, 5, 7] {
            let sheet =
                sheet(Space::clamped_uniform(p, p + 4).unwrap(), Space::clamped_uniform(q, q + 3).unwrap());
            for continuity in 0..=2 {
                let asked = matching(Edge::UEnd, 1, low, continuity, Limits::default());
                let edit = Edit::new(&sheet).with(Box::new(cylinder.clone())).ask(asked.clone().hold());
                let edited = edit.solve().unwrap_or_else(|e| panic!("{p} {q} {continuity}: {e}"));
                let end = sheet.u().domain().1;
                let shapes = Shapes::new([edited.shape() as &dyn Shape, &cylinder]);
                let left = asked.deviation(&shapes).unwrap();
                assert!(left.distance < 1e-11, "{left}");
                assert!(continuity < 1 || left.angle < 1e-7, "{left}");
                assert!(continuity < 2 || left.part < 0.05, "{left}");
                let places: Vec<f64> = (0..sheet.v().len()).map(|i| sheet.v().greville(i)).collect();
                for (k, v) in places.iter().copied().chain((0..=40).map(|j| f64::from(j) / 40.0)).enumerate()
                {
                    let s = |a: usize, b: usize| edited.shape().derivative(end, v, a, b).unwrap();
                    let point = s(0, 0);
                    assert!((point.x - 2.0).abs() < 1e-12 && point.z.abs() < 1e-12, "{point}");
                    let normal = s(1, 0).cross(&s(0, 1)).normalize();
                    if continuity > 0 {
                        assert!(normal.x.abs() > 1.0 - 1e-14, "{p} {q} {continuity}: {normal}");
                    }
                    if continuity > 1 {
                        // Square to the edge the normal curvature is 1/2.
                        let (along, d) = (s(0, 1), s(1, 0));
                        let a = d.dot(&along) / along.norm_squared();
                        let bend = s(2, 0) - s(1, 1) * (2.0 * a) + s(0, 2) * (a * a);
                        let kappa = -bend.x / (d - along * a).norm_squared();
                        let wanted = 0.5;
                        // Where it was imposed it holds; between it is off by no more than is told, which is looked for at so many places
                        // that nowhere it is half a percent more.
                        let allowed = if k < places.len() { 1e-9 } else { left.curvature / 0.995 + 1e-9 };
                        assert!(
                            (kappa - wanted).abs() < allowed,
                            "{p} {q}, {k} at {v}: {kappa} and not {wanted}, {left}; {}",
                            edited.report()
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn the_rows_are_the_derivatives_and_refusals_say_why() {
    let cylinder = cylinder();
    let low = low_edge(&cylinder);
    let sheet = sheet(Space::clamped_uniform(3, 6).unwrap(), Space::clamped_uniform(3, 5).unwrap());
    let shapes = || -> Vec<Box<dyn Shape>> { vec![Box::new(sheet.clone()), Box::new(cylinder.clone())] };
    for continuity in 0..=2 {
        let verdict =
            functional_conformance(&matching(Edge::UEnd, 1, low, continuity, Limits::default()), &shapes());
        assert!(verdict.passed() && verdict.checks >= 12, "{verdict}");
    }
    let rail = edge_of(&sheet, "u0");
    let on_rail: Vec<Box<dyn Shape>> = vec![Box::new(sheet.clone()), Box::new(rail)];
    let verdict = functional_conformance(&edge_on(Edge::UEnd, 1), &on_rail);
    assert!(verdict.passed() && verdict.checks >= 12, "{verdict}");

    let boxes = shapes();
    let shapes = Shapes::new(boxes.iter().map(AsRef::as_ref));
    let refused = |f: &dyn Functional| f.bind(&shapes).unwrap_err().to_string();
    let limits = Limits::default();
    for (problem, words) in [
        (refused(&matching(Edge::UEnd, 0, low, 1, limits)), "cannot be matched to itself"),
        (refused(&matching(Edge::Number(9), 1, low, 1, limits)), "there is no edge 9"),
        (refused(&matching(Edge::UEnd, 7, low, 1, limits)), "there is no shape 7"),
        (refused(&matching(Edge::UEnd, 1, low, 3, limits)), "is not 0, 1 or 2"),
        (refused(&matching(Edge::UEnd, 1, low, 1, Limits { angle: f64::NAN, ..limits })), "above 0"),
        (refused(&edge_on(Edge::UEnd, 1)), "is no curve"),
        (refused(&edge_on(Edge::UEnd, 1).within(-1.0)), "is no length"),
    ] {
        assert!(problem.contains(words), "{problem}");
    }
    // A pole is no edge.
    let top = Point::new(0.0, 0.0, 1.0);
    let half = Curve::arc(top, Point::origin(), Vector::y(), std::f64::consts::PI).unwrap();
    let ball = Surface::revolution(&half, Point::origin(), Vector::z(), std::f64::consts::TAU).unwrap();
    let poles: Vec<String> = [Edge::UStart, Edge::UEnd, Edge::VStart, Edge::VEnd]
        .into_iter()
        .filter(|edge| edge.number_on(&ball).is_ok())
        .filter_map(|edge| {
            let shapes = Shapes::new([&sheet as &dyn Shape, &ball]);
            matching(Edge::UEnd, 1, edge, 1, limits).bind(&shapes).err().map(|e| e.to_string())
        })
        .collect();
    assert!(poles.iter().any(|problem| problem.contains("is a point (a pole)")), "{poles:?}");
}

/// What the constraint left is in the report, in its own quantities; what is outside its limits is said with them, and what to do.
#[test]
fn a_match_tells_what_is_left_and_what_is_too_much() {
    let cylinder = cylinder();
    let low = low_edge(&cylinder);
    let sheet = sheet(Space::clamped_uniform(3, 6).unwrap(), Space::clamped_uniform(3, 5).unwrap());
    let solve = |limits: Limits| {
        let asked = matching(Edge::UEnd, 1, low, 2, limits);
        Edit::new(&sheet).with(Box::new(cylinder.clone())).ask(asked.hold()).solve()
    };
    let report = solve(Limits::default()).unwrap().report().clone();
    let told = |note: &String| {
        note.contains("the surfaces are apart by position")
            && note.contains("angle")
            && note.contains("% of the other surface's largest)")
    };
    assert!(report.notes.iter().any(told), "{:?}", report.notes);
    let refused = solve(Limits { curvature: 1e-9, ..Limits::default() }).unwrap_err().to_string();
    assert!(
        refused.contains("apart by position") && refused.contains("insert knots along the edge"),
        "{refused}"
    );
    assert!(!refused.contains("rounding explains"), "{refused}");
}

/// The same points in another parametrisation, of the same degree or another one: nothing moves.
#[test]
fn an_edge_that_is_on_the_curve_already_stays() {
    let line = |degree: usize, places: &[f64]| {
        let space = Space::clamped_uniform(degree, places.len()).unwrap();
        Curve::new(space, places.iter().map(|&y| Point::new(2.0, y, 1.0)).collect()).unwrap()
    };
    let flat = |q: usize| {
        let (u, v) = (Space::clamped_uniform(2, 4).unwrap(), Space::clamped_uniform(q, q + 1).unwrap());
        let at =
            |k: usize| Point::new((k / (q + 1)) as f64 * 2.0 / 3.0, (k % (q + 1)) as f64 / q as f64, 1.0);
        Surface::new(u, v, (0..4 * (q + 1)).map(at).collect()).unwrap()
    };
    for (q, curve) in [
        (1, line(3, &[0.0, 0.1, 0.2, 0.3, 1.0])),
        (1, line(2, &[1.0, 0.2, 0.0])),
        (3, line(3, &[0.0, 0.1, 0.4, 1.0])),
        (2, line(5, &[-1.0, 0.0, 0.4, 0.5, 0.6, 0.7, 1.5])),
    ] {
        let sheet = flat(q);
        let asked = edge_on(Edge::UEnd, 1);
        let edited =
            Edit::new(&sheet).with(Box::new(curve.clone())).ask(asked.clone().hold()).solve().unwrap();
        assert_eq!(edited.shape().points(), sheet.points(), "degree {q}");
        assert!(
            edited.report().notes.iter().any(|note| note.contains("already")),
            "{:?}",
            edited.report().notes
        );
        let shapes = Shapes::new([&sheet as &dyn Shape, &curve]);
        assert!(asked.distance(&shapes).unwrap() < 1e-12);
        // A little off it, it is on it no more.
        let mut off = sheet.clone();
        off.control_vertices_mut().iter_mut().for_each(|at| at.z += 1e-6);
        let shapes = Shapes::new([&off as &dyn Shape, &curve]);
        assert!((asked.clone().within(1.0).distance(&shapes).unwrap() - 1e-6).abs() < 1e-12);
    }
}

/// A curve that is run through unevenly: the edge comes as near to its points as it can, and what is measured is the distance.
#[test]
fn within_a_tolerance_the_parameters_run_as_they_have_to() {
    let sheet = sheet(Space::clamped_uniform(2, 4).unwrap(), Space::clamped_uniform(3, 7).unwrap());
    let at = |y: f64| Point::new(2.5, y, 0.2 * (1.5 * y).sin());
    // Bunched towards one end: evenly by parameter the edge would be far off.
    let places: Vec<f64> = (0..40).map(|k| 3.0 * (f64::from(k) / 39.0).powi(4)).collect();
    let curve =
        Curve::new(Space::clamped_uniform(3, 40).unwrap(), places.iter().map(|&y| at(y)).collect()).unwrap();
    let solve = |tolerance: f64| {
        let asked = edge_on(Edge::UEnd, 1).within(tolerance);
        Edit::new(&sheet).with(Box::new(curve.clone())).smooth(0).ask(asked.hold()).solve()
    };
    let edited = solve(0.01).unwrap();
    let far = apart(edited.shape(), &curve);
    assert!(far < 0.01, "{far}");
    let told = edited.report().constraints[0].between.unwrap();
    assert!(told < 0.01 && told > 0.9 * far, "{told} {far}");
    let refused = solve(1e-9).unwrap_err().to_string();
    assert!(
        refused.contains("as near as it comes it is")
            && refused.contains(" at (")
            && refused.contains("is allowed"),
        "{refused}"
    );
}

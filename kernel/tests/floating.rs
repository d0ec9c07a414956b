//! Locations that float, against brute force over their parameters: edits at rest on a fine grid, walked downhill from where
//! the location starts.
#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::smooth::dice::Dice;
use crate::smooth::solvers;
use loftsman_kernel::conformance::{functional_conformance, sample_shapes};
use loftsman_kernel::edit::{Ask, Axis, Constraint, Edit, EditError, Metric, Session};
use loftsman_kernel::error::Result;
use loftsman_kernel::functional::{
    Functional, Linearity, Rows, Shapes, curvature, near, orthogonal, position, tangent,
};
use loftsman_kernel::shape::{Derivative, Location};
use loftsman_kernel::solve::{SolveError, Solver};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};

/// A wavy curve: clamped, floating or periodic, polynomial or with unlike weights.
fn curve(dice: &mut Dice, round: usize) -> Curve {
    let p = 1 + round % 5;
    let n = p + 4 + dice.below(8);
    let space = match round / 5 % 3 {
        0 => Space::clamped_uniform(p, n).unwrap(),
        1 => Space::open(p, (0..n + p + 1).map(|k| k as f64 * 0.7).collect::<Vec<_>>()).unwrap(),
        _ => Space::periodic(p, (0..=n).map(|k| k as f64).collect::<Vec<_>>()).unwrap(),
    };
    let n = space.len();
    let round_trip = space.is_periodic();
    let point = |k: usize, dice: &mut Dice| {
        let t = k as f64;
        let jitter = dice.vector(0.2);
        if round_trip {
            let angle = std::f64::consts::TAU * t / n as f64;
            Point::new(5.0 * angle.cos(), 4.0 * angle.sin(), (2.0 * angle).sin()) + jitter
        } else {
            Point::new(t, 1.5 * (0.9 * t).sin(), 0.6 * (0.5 * t).cos()) + jitter
        }
    };
    let points: Vec<Point> = (0..n).map(|k| point(k, dice)).collect();
    let weights = (round % 2 == 1).then(|| (0..n).map(|_| dice.between(0.4, 2.5)).collect());
    Curve::build(space, points, weights).unwrap()
}

fn ends(edit: Edit<Curve>, curve: &Curve) -> Edit<Curve> {
    let (a, b) = curve.space().domain();
    if curve.space().is_periodic() { edit } else { edit.ask(position(a).keep()).ask(position(b).keep()) }
}

/// The length of the least adjustment with the location at rest; infinite where it cannot be.
fn at_rest(curve: &Curve, u: f64, to: Point, metric: &Metric) -> f64 {
    let edit = ends(Edit::new(curve), curve).metric(metric.clone()).ask(position(u).to(to));
    // The least is measured by the metric, as the forces tell it: ½ dᵀWd = ½ bᵀλ.
    edit.solve().map_or(f64::INFINITY, |edited| measured(curve, edited.shape(), metric))
}

/// The length of a displacement in a metric.
fn measured(before: &Curve, after: &Curve, metric: &Metric) -> f64 {
    let d: Vec<Vector> = after.points().iter().zip(before.points()).map(|(a, b)| a - b).collect();
    match metric {
        Metric::Weights(weights) => {
            d.iter().zip(weights).map(|(d, w)| w * d.norm_squared()).sum::<f64>().sqrt()
        }
        _ => d.iter().map(Vector::norm_squared).sum::<f64>().sqrt(),
    }
}

/// From `start` downhill on a grid, then by golden sections.
fn downhill(domain: (f64, f64), periodic: bool, start: f64, cost: &dyn Fn(f64) -> f64) -> f64 {
    let step = (domain.1 - domain.0) / 4000.0;
    let inside = |u: f64| if periodic { u } else { u.clamp(domain.0, domain.1) };
    let mut at = start;
    let mut here = cost(at);
    for _ in 0..8000 {
        let sides = [inside(at - step), inside(at + step)].map(|u| (cost(u), u));
        let best = if sides[0].0 < sides[1].0 { sides[0] } else { sides[1] };
        if best.0 >= here {
            break;
        }
        (here, at) = best;
    }
    let (mut a, mut b) = (inside(at - step), inside(at + step));
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    for _ in 0..60 {
        let (x, y) = (b - golden * (b - a), a + golden * (b - a));
        if cost(x) < cost(y) { b = y } else { a = x }
    }
    0.5 * (a + b)
}

#[test]
fn the_curve_passes_where_it_costs_least_near_where_it_starts() {
    let mut dice = Dice(0x10f7);
    let (mut checked, mut elsewhere) = (0, 0);
    for round in 0..60 {
        let curve = curve(&mut dice, round);
        let (a, b) = curve.space().domain();
        let periodic = curve.space().is_periodic();
        let start = dice.between(a + 0.1 * (b - a), b - 0.1 * (b - a));
        let target = (start + dice.between(-0.06, 0.06) * (b - a)).clamp(a, b);
        let to = curve.point(target).unwrap() + dice.vector(0.4);
        let metric = match round % 3 {
            0 => Metric::Weights((0..curve.points().len()).map(|_| dice.between(0.5, 3.0)).collect()),
            _ => Metric::Least,
        };
        let domain = if periodic { (a - (b - a), b + (b - a)) } else { (a, b) };
        let wrap = |u: f64| if periodic { a + (u - a).rem_euclid(b - a) } else { u };
        let cost = |u: f64| at_rest(&curve, wrap(u), to, &metric);
        let expected = downhill(domain, periodic, start, &cost);
        let least = cost(expected);
        for solver in solvers() {
            let name = solver.name().to_owned();
            let edit = ends(Edit::new(&curve), &curve).metric(metric.clone());
            let edited = match edit.ask(position(near(start)).to(to)).solve_with(solver) {
                Ok(edited) => edited,
                Err(EditError::Solve(SolveError::TooLarge { .. })) if name == "adjoint" => continue,
                Err(error) => panic!("{round} {name}: {error}"),
            };
            let told = edited.report().constraints.iter().find(|c| c.location.is_some()).unwrap();
            let u = told.location.clone().unwrap()[0];
            assert!((edited.shape().point(u).unwrap() - to).norm() < 1e-11, "{round} {name}");
            let found = measured(&curve, edited.shape(), &metric);
            // Polylines have a local minimum at every vertex or so: one of them as good will do.
            let same = (found - least).abs() <= 1e-7 * least + 1e-9;
            if !same {
                assert!(
                    found < least,
                    "{round} {name}: {found} at {u} beside {least} at {expected} from {start}"
                );
                elsewhere += 1;
            }
            checked += 1;
        }
    }
    assert!(checked > 250, "{checked}");
    assert!(elsewhere * 50 < checked, "{elsewhere} of {checked} went to a better place farther away");
}

#[test]
fn a_point_on_the_curve_changes_nothing() {
    let mut dice = Dice(7);
    for round in 0..60 {
        let curve = curve(&mut dice, round);
        let (a, b) = curve.space().domain();
        let u = dice.between(a + 0.2 * (b - a), b - 0.2 * (b - a));
        let from = u + dice.between(-0.2, 0.2) * (b - a) / curve.points().len() as f64;
        let to = curve.point(u).unwrap();
        let edited = Edit::new(&curve).ask(position(near(from)).to(to)).solve().unwrap();
        assert!(edited.report().adjustment < 1e-9, "{round}: {}", edited.report().adjustment);
        // Even where nothing may move.
        let all = 0..curve.points().len() as i64;
        let locked = Edit::new(&curve).lock(all).ask(position(near(from)).to(to)).solve();
        let locked = locked.unwrap_or_else(|error| panic!("{round}: {error}"));
        assert_eq!(locked.shape(), &curve);
    }
}

#[test]
fn drags_follow_the_curve_and_equal_edits_from_where_they_are() {
    let mut dice = Dice(99);
    for round in 0..30 {
        let curve = curve(&mut dice, round);
        let (a, b) = curve.space().domain();
        let start = 0.5 * (a + b);
        let from = curve.point(start).unwrap();
        let way = dice.vector(1.0);
        for solver in solvers() {
            let edit = ends(Edit::new(&curve), &curve).handle(position(near(start)));
            let mut session = match edit.prepare(Arc::clone(&solver)) {
                Ok(session) => session,
                Err(EditError::Solve(SolveError::TooLarge { .. })) if solver.name() == "adjoint" => continue,
                Err(error) => panic!("{error}"),
            };
            let mut u = start;
            for step in 1..=10 {
                let to = from + way * (0.1 * f64::from(step));
                session.to_point(to).unwrap();
                let report = session.report();
                let rests = report.constraints.iter().find_map(|c| c.location.clone()).unwrap()[0];
                assert!((session.shape().point(rests).unwrap() - to).norm() < 1e-11);
                let once = ends(Edit::new(&curve), &curve).ask(position(near(u)).to(to)).solve().unwrap();
                let (dragged, alone) = (report.adjustment, once.report().adjustment);
                assert!((dragged - alone).abs() < 1e-7 * alone, "{round}: {dragged} {alone}");
                u = rests;
            }
            assert!(session.commit().unwrap().report().residual < 1e-11);
        }
    }
}

#[test]
fn beside_what_is_not_linear_bounds_and_one_axis() {
    let curve = curve(&mut Dice(5), 3);
    let (a, b) = curve.space().domain();
    let at = |share: f64| a + share * (b - a);
    let to = curve.point(at(0.45)).unwrap() + Vector::new(0.0, 0.3, 0.2);
    let cost = |u: f64| {
        let edit = Edit::new(&curve).ask(curvature(at(0.8)).scale(1.2)).ask(position(u).to(to));
        edit.solve().map_or(f64::INFINITY, |edited| edited.report().adjustment)
    };
    let expected = downhill((a, b), false, at(0.4), &cost);
    let ask = || Edit::new(&curve).ask(curvature(at(0.8)).scale(1.2)).ask(position(near(at(0.4))).to(to));
    let edited = ask().solve().unwrap();
    let found = edited.report().adjustment;
    assert!((found - cost(expected)).abs() < 1e-7 * found, "{found} {}", cost(expected));
    // A bound that carries something.
    let low = edited.shape().point(at(0.6)).unwrap().y + 0.1;
    let bounded = Edit::new(&curve)
        .ask(position(at(0.6)).axis(Axis::Y).at_least(low))
        .ask(position(near(at(0.4))).to(to))
        .solve()
        .unwrap();
    assert!(bounded.shape().point(at(0.6)).unwrap().y >= low - 1e-12);
    let cost = |u: f64| {
        let edit =
            Edit::new(&curve).ask(position(at(0.6)).axis(Axis::Y).at_least(low)).ask(position(u).to(to));
        edit.solve().map_or(f64::INFINITY, |edited| edited.report().adjustment)
    };
    let expected = cost(downhill((a, b), false, at(0.4), &cost));
    assert!((bounded.report().adjustment - expected).abs() < 1e-7 * expected);
    // One axis alone can be met without a change, where the curve has that height.
    let height = curve.point(at(0.43)).unwrap().y;
    let level = Edit::new(&curve).ask(position(near(at(0.4))).axis(Axis::Y).to(height)).solve().unwrap();
    assert!(level.report().adjustment < 1e-9);
}

#[test]
fn surfaces_float_in_both_parameters() {
    let mut dice = Dice(21);
    for round in 0..12 {
        let (u, v) =
            (Space::clamped_uniform(2 + round % 2, 7).unwrap(), Space::clamped_uniform(3, 6).unwrap());
        let net = (0..42).map(|k| {
            let (i, j) = ((k / 6) as f64, (k % 6) as f64);
            Point::new(i, j, (0.7 * i).sin() + (0.5 * j).cos()) + dice.vector(0.1)
        });
        let surface = Surface::build(u, v, net.collect(), None).unwrap();
        let ([a, b], [c, d]) =
            (<[f64; 2]>::from(surface.u().domain()), <[f64; 2]>::from(surface.v().domain()));
        let start = [
            dice.between(a + 0.3 * (b - a), b - 0.3 * (b - a)),
            dice.between(c + 0.3 * (d - c), d - 0.3 * (d - c)),
        ];
        let to = surface.point(start[0], start[1]).unwrap() + dice.vector(0.5);
        for solver in solvers() {
            let edited = Edit::new(&surface).ask(position(near(start)).to(to)).solve_with(solver).unwrap();
            let at = edited.report().constraints[0].location.clone().unwrap();
            assert!((edited.shape().point(at[0], at[1]).unwrap() - to).norm() < 1e-11);
            let found = edited.report().adjustment;
            let cost = |u: f64, v: f64| {
                let edit = Edit::new(&surface).ask(position(Location::Surface(u, v)).to(to));
                edit.solve().map_or(f64::INFINITY, |edited| edited.report().adjustment)
            };
            let began = cost(start[0], start[1]);
            assert!(found <= began * (1.0 + 1e-12));
            // No place around is better.
            for k in 0..16 {
                let angle = f64::from(k) * std::f64::consts::TAU / 16.0;
                for reach in [1e-1, 1e-2, 1e-3] {
                    let (u, v) = (
                        (at[0] + reach * angle.cos()).clamp(a, b),
                        (at[1] + reach * angle.sin()).clamp(c, d),
                    );
                    assert!(cost(u, v) >= found * (1.0 - 1e-9), "{round}");
                }
            }
        }
    }
}

#[test]
fn two_that_start_at_one_place_part_and_what_cannot_be_is_said() {
    let curve = Curve::new(
        Space::clamped_uniform(3, 12).unwrap(),
        (0..12).map(|k| Point::new(f64::from(k), 0.1 * f64::from(k * k % 5), 0.0)).collect(),
    )
    .unwrap();
    let (one, other) = (curve.point(4.2).unwrap(), curve.point(5.1).unwrap());
    let up = Vector::new(0.0, 0.2, 0.0);
    let both = Edit::new(&curve)
        .ask(position(near(4.6)).to(one + up))
        .ask(position(near(4.6)).to(other + up))
        .solve()
        .unwrap();
    let at: Vec<f64> = both.report().constraints.iter().map(|c| c.location.clone().unwrap()[0]).collect();
    assert!(at[0] < at[1], "{at:?}");
    // The same twice is redundant wherever it comes to rest.
    let twice = Edit::new(&curve)
        .ask(position(near(4.3)).to(one + up))
        .ask(position(near(4.3)).to(one + up))
        .solve()
        .unwrap();
    assert_eq!(twice.report().rank, 3);
    let nowhere = Edit::new(&curve).lock(0..12).ask(position(near(4.0)).to([4.0, 9.0, 0.0])).solve();
    assert!(nowhere.unwrap_err().to_string().contains("position near 4"));
    let outside = Edit::new(&curve).ask(position(near(40.0)).to([4.0, 9.0, 0.0])).solve();
    assert!(outside.unwrap_err().to_string().contains("40"));
    // An end that is pulled along its tangent stays an end.
    let end = curve.point(9.0).unwrap() + curve.derivative(9.0, 1).unwrap();
    let pulled = Edit::new(&curve).ask(position(near(8.8)).to(end)).solve().unwrap();
    assert_eq!(pulled.report().constraints[0].location, Some(vec![9.0]));
}

/// A position that floats, and moves in another way than it says.
#[derive(Debug, Clone)]
struct Astray {
    inner: Arc<dyn Functional>,
    faster: f64,
    stays: bool,
    floats: bool,
}

impl Functional for Astray {
    fn equations(&self) -> usize {
        3
    }

    fn linearity(&self) -> Linearity {
        Linearity::Nonlinear
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        self.inner.rows(shapes, rows)
    }

    fn describe(&self) -> String {
        "astray".into()
    }

    fn location(&self) -> Option<(usize, Location)> {
        self.inner.location()
    }

    fn floats(&self) -> bool {
        self.floats
    }

    fn moved(&self, to: Location) -> Option<Arc<dyn Functional>> {
        if self.stays {
            return None;
        }
        Some(Arc::new(Self { inner: self.inner.moved(to)?, floats: false, ..self.clone() }))
    }

    fn along(&self, shapes: &Shapes<'_>, order: Derivative, out: &mut [f64]) -> Result<()> {
        self.inner.along(shapes, order, out)?;
        out.iter_mut().for_each(|v| *v *= self.faster);
        Ok(())
    }
}

#[test]
fn who_moves_otherwise_than_said_is_seen_and_harms_nobody() {
    let inner: Arc<dyn Functional> = Arc::new(position(near(0.9)));
    let honest = Astray { inner, faster: 1.0, stays: false, floats: true };
    let passes = |astray: &Astray| {
        sample_shapes(false).into_iter().all(|shape| functional_conformance(astray, &[shape]).passed())
    };
    assert!(passes(&honest));
    assert!(!passes(&Astray { faster: 1.1, ..honest.clone() }));
    assert!(!passes(&Astray { faster: f64::NAN, ..honest.clone() }));
    // What is handed out is measured whatever the functional says of its way.
    let curve = curve(&mut Dice(1), 2);
    let (a, b) = curve.space().domain();
    let u = 0.5 * (a + b);
    let to = curve.point(u).unwrap() + Vector::new(0.1, 0.2, 0.3);
    for (faster, stays) in [(1.1, false), (-1.0, false), (0.0, false), (f64::NAN, false), (1.0, true)] {
        let inner: Arc<dyn Functional> = Arc::new(position(near(u)));
        let done = Edit::new(&curve).ask((Astray { inner, faster, stays, floats: true }).to(to)).solve();
        match done {
            Ok(done) => {
                let at = done.report().constraints[0].location.clone().unwrap()[0];
                assert!((done.shape().point(at).unwrap() - to).norm() < 1e-11);
            }
            Err(error) => assert!(stays && error.to_string().contains("cannot be moved"), "{error}"),
        }
    }
}

/// A linear functional that moves, but whose rows change otherwise than it says, or in another number.
#[derive(Debug)]
struct Askew(loftsman_kernel::functional::Position, f64, usize);

impl Functional for Askew {
    fn equations(&self) -> usize {
        3
    }

    fn linearity(&self) -> Linearity {
        Linearity::Linear
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        self.0.rows(shapes, rows)
    }

    fn describe(&self) -> String {
        "askew".into()
    }

    fn location(&self) -> Option<(usize, Location)> {
        self.0.location()
    }

    fn moved(&self, to: Location) -> Option<Arc<dyn Functional>> {
        self.0.moved(to)
    }

    fn along(&self, shapes: &Shapes<'_>, order: Derivative, out: &mut [f64]) -> Result<()> {
        self.0.along(shapes, order, out)
    }

    fn along_rows(&self, shapes: &Shapes<'_>, order: Derivative, rows: &mut Rows<'_>) -> Result<()> {
        let (_, at) = self.0.location().unwrap();
        let stencil: loftsman_kernel::shape::Stencil =
            shapes.stencil(0, at, order)?.iter().map(|(v, c)| (v, c * self.1)).collect();
        (0..self.2).for_each(|_| rows.alike(0, &stencil));
        Ok(())
    }
}

#[test]
fn whose_rows_change_otherwise_than_said_is_seen() {
    let passes = |factor: f64, times: usize| {
        let askew = Askew(position(0.9), factor, times);
        sample_shapes(false).into_iter().all(|shape| functional_conformance(&askew, &[shape]).passed())
    };
    assert!(passes(1.0, 1));
    assert!(!passes(1.001, 1) && !passes(1.0, 2) && !passes(1.0, 0) && !passes(f64::NAN, 1));
}

/// A direction that a curve is to have somewhere: where it has it already nothing moves, and where it has it nowhere the place is that of the
/// least change of all near it.
#[test]
fn directions_float_to_where_they_cost_least() {
    let points = (0..12).map(|i| Point::new(f64::from(i), (0.7 * f64::from(i)).sin(), 0.0)).collect();
    let curve = Curve::new(Space::clamped_uniform(3, 12).unwrap(), points).unwrap();
    let size = |edited: &Curve| measured(&curve, edited, &Metric::Least);
    // Level somewhere: at its crest.
    for ask in
        [orthogonal(near(2.0), [0.0, 1.0, 0.0]).hold(), tangent(near(2.0)).direction([1.0, 0.0, 0.0]).hold()]
    {
        let level = Edit::new(&curve).ask(ask).solve().unwrap();
        let at = level.report().constraints[0].location.clone().unwrap()[0];
        let slope = level.shape().derivative(at, 1).unwrap();
        assert!(slope.y.abs() < 1e-12 && size(level.shape()) < 1e-7, "{at}: {slope}");
    }
    // Out of its plane it leans nowhere.
    let lean = Vector::new(1.0, 0.0, 1.0);
    let cost =
        |u: f64| size(Edit::new(&curve).ask(tangent(u).direction(lean).hold()).solve().unwrap().shape());
    let floats = Edit::new(&curve).ask(tangent(near(4.4)).direction(lean).hold()).solve().unwrap();
    let at = floats.report().constraints[0].location.clone().unwrap()[0];
    let slope = floats.shape().derivative(at, 1).unwrap();
    assert!(slope.cross(&lean).norm() < 1e-11 * slope.norm(), "{slope}");
    let here = size(floats.shape());
    assert!((here - cost(at)).abs() < 1e-9 * here && here < cost(4.4), "{here} {}", cost(4.4));
    for beside in [-0.01, 0.01] {
        assert!(cost(at + beside) > here, "{at}: {here}, {beside} beside {}", cost(at + beside));
    }
    assert!(
        floats.report().notes[0].starts_with("tangent near 4.4: it holds at "),
        "{:?}",
        floats.report().notes
    );
}

/// Two locations that look for one target and find one place would make the curve stand still between them; where they find two
/// places the curve passes twice.
#[test]
fn two_that_meet_in_one_place_are_refused_and_two_that_stay_apart_are_not() {
    let points = (0..12).map(|i| Point::new(f64::from(i), (0.7 * f64::from(i)).sin(), 0.0)).collect();
    let curve = Curve::new(Space::clamped_uniform(3, 12).unwrap(), points).unwrap();
    let target = curve.point(4.9).unwrap() + Vector::new(0.1, 1.2, 0.4);
    for solver in solvers().into_iter().filter(|s| s.name() != "adjoint") {
        let both = |a: f64, b: f64, second: Point| {
            Edit::new(&curve)
                .ask(position(near(a)).to(target))
                .ask(position(near(b)).to(second))
                .solve_with(Arc::clone(&solver))
        };
        let error = both(4.8, 5.0, target).unwrap_err().to_string();
        assert!(error.contains("at one place") && error.contains("turn back"), "{}: {error}", solver.name());
        // Another target is another wish, and far away the same one makes a loop.
        both(4.8, 5.6, target + Vector::new(0.8, 0.0, 0.0)).unwrap();
        // A lemniscate passes twice through its middle, and does so elsewhere when it is asked to.
        let turn = |k: i32| 0.5 + 0.3 * f64::from(k);
        let net = (0..24).map(|k| Point::new((2.0 * turn(k)).sin(), turn(k).sin(), 0.0)).collect();
        let eight = Curve::new(Space::clamped_uniform(3, 24).unwrap(), net).unwrap();
        let foot = |from: i32| {
            let places = (0..300).map(|k| f64::from(from) + 0.02 * f64::from(k));
            let distance = |u: &f64| eight.point(*u).unwrap().coords.norm();
            places.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap()
        };
        let middle = Point::new(0.03, 0.05, 0.1);
        let twice = Edit::new(&eight)
            .ask(position(near(foot(5))).to(middle))
            .ask(position(near(foot(14))).to(middle))
            .solve_with(Arc::clone(&solver))
            .unwrap();
        let at: Vec<f64> =
            twice.report().constraints.iter().filter_map(|c| c.location.as_ref().map(|at| at[0])).collect();
        assert!((at[0] - at[1]).abs() > 1.0, "{at:?}");
        for u in at {
            assert!((twice.shape().point(u).unwrap() - middle).norm() < 1e-12);
        }
    }
}

/// Where the locations of a session rest, the handle's last.
fn rests(session: &Session<Curve>) -> Vec<f64> {
    session.report().constraints.iter().filter_map(|c| c.location.as_ref().map(|at| at[0])).collect()
}

/// However far locations have gone when an event fails, they are where they were: what comes next is what would have come
/// without it.
#[test]
fn an_event_that_fails_leaves_locations_and_shape_as_they_were() {
    let points = (0..12).map(|i| Point::new(f64::from(i), (0.7 * f64::from(i)).sin(), 0.0)).collect();
    let curve = Curve::new(Space::clamped_uniform(3, 12).unwrap(), points).unwrap();
    let aside = Vector::new(0.1, 1.2, 0.4);
    for solver in solvers() {
        // Nothing may move: a target on the curve is met by the location alone. One beside it is not met, and its foot is tried.
        let edit = Edit::new(&curve).lock(0..12).handle(position(near(4.0)));
        let mut locked = edit.prepare(Arc::clone(&solver)).unwrap();
        locked.to_point(curve.point(4.3).unwrap()).unwrap();
        let before = rests(&locked);
        assert!((before[0] - 4.3).abs() < 1e-9, "{before:?}");
        locked.to_point(curve.point(4.9).unwrap() + aside).unwrap_err();
        assert_eq!(rests(&locked), before, "{}", solver.name());
        assert_eq!(locked.shape(), &curve);
        locked.to_point(curve.point(4.4).unwrap()).unwrap();
        assert_eq!(locked.shape(), &curve);
        // Two that come to hold at one place are refused once they have got there.
        let target = curve.point(4.9).unwrap() + aside;
        let session = || {
            let edit = Edit::new(&curve).ask(position(near(4.8)).to(target)).handle(position(near(5.6)));
            let mut session = edit.prepare(Arc::clone(&solver)).unwrap();
            session.to_point(target + Vector::new(0.8, 0.0, 0.0)).unwrap();
            session
        };
        let (mut one, mut other) = (session(), session());
        let (before, shape) = (rests(&one), one.shape().clone());
        one.to_point(target).unwrap_err();
        assert_eq!(rests(&one), before, "{}", solver.name());
        assert_eq!(one.shape(), &shape, "{}", solver.name());
        let next = target + Vector::new(0.9, 0.1, 0.0);
        let apart = |a: &Curve, b: &Curve| {
            a.points().iter().zip(b.points()).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max)
        };
        let (a, b) = (one.to_point(next).unwrap().clone(), other.to_point(next).unwrap().clone());
        assert!(apart(&a, &b) < 1e-12, "{}: {:e}", solver.name(), apart(&a, &b));
        one.commit().unwrap();
    }
}

#[test]
fn where_a_location_came_to_rest_is_told() {
    let points = (0..12).map(|i| Point::new(f64::from(i), (0.7 * f64::from(i)).sin(), 0.0)).collect();
    let curve = Curve::new(Space::clamped_uniform(3, 12).unwrap(), points).unwrap();
    let to = curve.point(4.3).unwrap();
    let notes = |at: Constraint| Edit::new(&curve).ask(at).solve().unwrap().report().notes.clone();
    let told = notes(position(near(4.0)).to(to));
    assert!(told.len() == 1 && told[0].starts_with("position near 4: it holds at 4.3"), "{told:?}");
    assert!(notes(position(4.3).to(to)).is_empty());
}

/// Pulled beyond an edge, a location comes to rest on it, and there where the change is least.
#[test]
fn beyond_an_edge_the_place_along_it_is_the_best() {
    let mut dice = Dice(33);
    let mut at_edges = 0;
    for round in 0..24 {
        let (u, v) = (Space::clamped_uniform(2, 6).unwrap(), Space::clamped_uniform(3, 7).unwrap());
        let skew = dice.between(-0.8, 0.8);
        let net = (0..42).map(|k| {
            let (i, j) = ((k / 7) as f64, (k % 7) as f64);
            Point::new(i + skew * j, j - skew * i, (0.7 * i).sin() + (0.5 * j).cos()) + dice.vector(0.1)
        });
        let surface = Surface::build(u, v, net.collect(), None).unwrap();
        let ([a, b], [c, d]) =
            (<[f64; 2]>::from(surface.u().domain()), <[f64; 2]>::from(surface.v().domain()));
        let end = if round % 2 == 0 { b } else { a };
        let there = c + (d - c) * dice.between(0.3, 0.7);
        let inner = end + 0.1 * (0.5 * (a + b) - end);
        let outwards = surface.point(end, there).unwrap() - surface.point(inner, there).unwrap();
        let to = surface.point(end, there).unwrap() + outwards * dice.between(4.0, 9.0) + dice.vector(0.5);
        let start = (there + dice.between(-0.15, 0.15) * (d - c)).clamp(c, d);
        let edited = Edit::new(&surface).ask(position(near([inner, start])).to(to)).solve().unwrap();
        let at = edited.report().constraints[0].location.clone().unwrap();
        let found = edited.report().adjustment;
        let cost = |u: f64, v: f64| {
            let edit = Edit::new(&surface).ask(position(Location::Surface(u, v)).to(to));
            edit.solve().map_or(f64::INFINITY, |edited| edited.report().adjustment)
        };
        at_edges += usize::from(at[0] == end);
        for reach in [1e-1, 1e-2, 1e-3] {
            for (du, dv) in [(0.0, 1.0), (0.0, -1.0), (1.0, 0.0), (-1.0, 0.0), (0.7, 0.7), (-0.7, -0.7)] {
                let (u, v) = ((at[0] + reach * du).clamp(a, b), (at[1] + reach * dv).clamp(c, d));
                assert!(cost(u, v) >= found * (1.0 - 1e-9), "{round}: better at {u}, {v} than at {at:?}");
            }
        }
    }
    assert!(at_edges >= 15, "{at_edges}");
}

/// `x² + 1`, which never comes to the zero that it is asked for, and counts how often it is looked at.
#[derive(Debug, Clone)]
struct Endless {
    effort: usize,
    looks: Arc<AtomicUsize>,
}

impl Functional for Endless {
    fn equations(&self) -> usize {
        1
    }

    fn linearity(&self) -> Linearity {
        Linearity::Nonlinear
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        rows.equation().term(0, 0, Vector::x() * (2.0 * shapes.vertex(0).x));
        Ok(())
    }

    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        self.looks.fetch_add(1, Ordering::Relaxed);
        out[0] = 1.0 + shapes.vertex(0).x.powi(2);
        Ok(())
    }

    fn describe(&self) -> String {
        "endless".into()
    }

    fn effort(&self) -> usize {
        self.effort
    }
}

/// What takes much work is given up the sooner, by counted work.
#[test]
fn what_takes_much_work_and_does_not_arrive_is_given_up() {
    let curve = curve(&mut Dice(5), 2);
    let looks = |effort: usize| {
        let looks = Arc::new(AtomicUsize::new(0));
        let endless = Endless { effort, looks: Arc::clone(&looks) };
        Edit::new(&curve).ask(endless.to(0.0)).solve().unwrap_err();
        looks.load(Ordering::Relaxed)
    };
    let (cheap, dear) = (looks(0), looks(1_000_000));
    println!("{cheap} looks where they are cheap, {dear} where they are dear");
    assert!(dear <= 150 && cheap > 2 * dear, "{cheap} {dear}");
}

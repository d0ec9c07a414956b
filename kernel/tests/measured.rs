//! Nobody believes a solver: what does not hold is not handed out, whoever said so; what is out of proportion is refused; and
//! every edit has a way back.
#![allow(clippy::unwrap_used, clippy::panic, reason = "these are tests, their helpers included")]

use std::sync::Arc;

use loftsman_kernel::edit::{Ask, Axis, Constraint, Edit, EditError, Metric, Session};
use loftsman_kernel::functional::{
    Accuracy, Functional, Linearity, Rows, Shapes, curvature, derivative, magnitude, near, position, tangent,
    vertex,
};
use loftsman_kernel::shape::Location;
use loftsman_kernel::solve::{
    Adjoint, Automatic, DenseLu, Diagnosis, Factored, HouseholderQr, SaddlePoint, SolveError, Solver, Sparse,
    System, SystemMetric,
};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Result, Vector};

/// A small generator of numbers in 0..1 (Knuth's constants), the same everywhere.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn up_to(&mut self, n: usize) -> usize {
        ((self.next() * n as f64) as usize).min(n - 1)
    }
}

/// A curve of any family: degree 1 to 7, clamped, floating or periodic, knots repeated up to the degree, weights unlike.
fn any_curve(random: &mut Random, size: f64) -> Curve {
    let p = 1 + random.up_to(7);
    let n = p + 2 + random.up_to(12);
    let space = match random.up_to(3) {
        0 => {
            let mut inner: Vec<f64> = Vec::new();
            while inner.len() < n - p - 1 {
                let knot = (random.next() * 20.0).floor() + 1.0;
                if inner.iter().filter(|k| **k == knot).count() < p {
                    inner.push(knot);
                }
            }
            inner.sort_by(f64::total_cmp);
            let last = inner.last().copied().unwrap_or(0.0) + 1.0;
            let knots = std::iter::repeat_n(0.0, p + 1).chain(inner).chain(std::iter::repeat_n(last, p + 1));
            Space::open(p, knots.collect()).unwrap()
        }
        1 => Space::floating_uniform(p, n).unwrap(),
        _ => Space::periodic_uniform(p, n).unwrap(),
    };
    let count = space.len();
    let points = (0..count)
        .map(|_| Point::new(size * random.next(), size * random.next(), size * random.next()))
        .collect();
    let weights = (random.up_to(2) == 1).then(|| (0..count).map(|_| 0.2 + 3.0 * random.next()).collect());
    Curve::build(space, points, weights).unwrap()
}

/// De Boor by the book: every basis function by its recurrence, on the unrolled knots.
fn by_the_book(curve: &Curve, u: f64) -> Vector {
    let space = curve.space();
    let (flat, p) = (space.flat(), space.degree());
    let mut n: Vec<f64> = {
        let last = flat[space.unrolled_len()];
        (0..flat.len() - 1)
            .map(|i| {
                let end = u >= last && flat[i] < last && flat[i + 1] >= last;
                f64::from(u8::from(flat[i] <= u && u < flat[i + 1] || end))
            })
            .collect()
    };
    for k in 1..=p {
        for i in 0..n.len() - k {
            let part = |top: f64, bottom: f64, n: f64| if bottom > 0.0 { top / bottom * n } else { 0.0 };
            n[i] = part(u - flat[i], flat[i + k] - flat[i], n[i])
                + part(flat[i + k + 1] - u, flat[i + k + 1] - flat[i + 1], n[i + 1]);
        }
    }
    let (mut sum, mut weight) = (Vector::zeros(), 0.0);
    for (i, n) in n.iter().enumerate().take(space.unrolled_len()) {
        let v = space.vertex(i);
        let w = curve.weights().map_or(1.0, |w| w[v]) * n;
        sum += curve.points()[v].coords * w;
        weight += w;
    }
    sum / weight
}

fn solvers() -> Vec<Arc<dyn Solver>> {
    vec![
        Arc::new(Automatic),
        Arc::new(Adjoint),
        Arc::new(Sparse),
        Arc::new(HouseholderQr),
        Arc::new(SaddlePoint),
        Arc::new(DenseLu),
    ]
}

/// Two positions so near to each other that only one of them moving asks for the impossible, or nearly: the answer holds by
/// an evaluator that shares nothing with the kernel and is in proportion, or it is refused.
#[test]
fn places_that_are_ever_nearer_are_met_in_proportion_or_refused() {
    let mut random = Random(11);
    let (mut met, mut refused) = (0, 0);
    for case in 0..400 {
        let size = [1e-9, 1.0, 1e9][case % 3];
        let curve = any_curve(&mut random, size);
        let (a, b) = curve.domain();
        let gap = 10_f64.powf(-1.0 - 13.0 * random.next()) * (b - a);
        let u = a + (b - a) * (0.1 + 0.7 * random.next());
        let by = [0.3 * size, -0.2 * size, 0.1 * size];
        let metric = [Metric::Least, Metric::Stretch, Metric::Bend][random.up_to(3)].clone();
        for solver in solvers() {
            let edit = Edit::new(&curve)
                .metric(metric.clone())
                .ask(position(u).by(by))
                .ask(position(u + gap).keep());
            match edit.solve_with(Arc::clone(&solver)) {
                Ok(done) => {
                    met += 1;
                    let wanted = by_the_book(&curve, u) + Vector::from(by);
                    let kept = by_the_book(&curve, u + gap);
                    let error = (by_the_book(done.shape(), u) - wanted)
                        .amax()
                        .max((by_the_book(done.shape(), u + gap) - kept).amax());
                    assert!(error <= 1e-8 * size, "{} case {case}: {error:.1e} of {size:.0e}", solver.name());
                    assert!(done.report().residual <= 1e-8 * size, "{}", done.report());
                    // Each alone costs at most |b| / ‖f‖, and ‖f‖² ≥ 1/(p+1).
                    let alone = 0.4 * size * 3.0_f64.sqrt() * ((curve.degree() + 1) as f64).sqrt();
                    if metric == Metric::Least && curve.weights().is_none() {
                        assert!(done.report().adjustment <= 1e6 * alone, "{}", done.report());
                    }
                }
                Err(EditError::Solve(
                    SolveError::NearConflict { .. }
                    | SolveError::Conflict { .. }
                    | SolveError::Missed { .. }
                    | SolveError::IllConditioned { .. },
                )) => refused += 1,
                Err(other) => panic!("{} case {case}: {other}", solver.name()),
            }
        }
    }
    println!("{met} met, {refused} refused");
    assert!(met >= 600 && refused >= 300, "{met} met, {refused} refused");
}

#[test]
fn a_near_conflict_names_the_constraints_and_force_takes_the_way_but_not_the_error() {
    let points = (0..12).map(|i| Point::new(f64::from(i), f64::from(i % 3), 0.0)).collect();
    let curve = Curve::new(Space::clamped_uniform(3, 12).unwrap(), points).unwrap();
    let edit = || {
        Edit::new(&curve)
            .ask(position(8.5).keep())
            .ask(position(3.0).by([0.0, 1.0, 0.0]))
            .ask(position(3.0 + 1e-8).keep())
    };
    for solver in solvers() {
        let error = edit().solve_with(Arc::clone(&solver)).unwrap_err();
        let EditError::Solve(SolveError::NearConflict { constraints, times, .. }) = &error else {
            // These square the condition, and say so.
            let squares = ["adjoint", "sparse", "saddle-point"].contains(&solver.name());
            assert!(squares && error.to_string().contains("householder-qr"), "{}: {error}", solver.name());
            continue;
        };
        assert_eq!(constraints.len(), 2, "{error}");
        assert!(
            constraints[0].contains("position at 3") && constraints[1].contains("position at 3.00000001")
        );
        assert!(*times > 1e7 && *times < 1e9 && error.to_string().contains("force = true"), "{error}");
        match edit().force().solve_with(solver) {
            Ok(done) => assert!(done.report().residual < 1e-6 && done.report().adjustment > 1e7),
            Err(EditError::Solve(SolveError::Missed { error, allowed, .. })) => assert!(error > allowed),
            Err(other) => panic!("{other}"),
        }
    }
}

/// A solver that is wrong by a little, now and then.
struct Liar {
    by: f64,
}

struct Lie {
    inner: Box<dyn Factored>,
    by: f64,
}

impl Solver for Liar {
    fn name(&self) -> &'static str {
        "liar"
    }

    fn takes(&self, _: &SystemMetric) -> bool {
        true
    }

    fn factor_minimum_norm(&self, system: &System) -> Result<Box<dyn Factored>, SolveError> {
        Ok(Box::new(Lie { inner: HouseholderQr.factor(system)?, by: self.by }))
    }
}

impl Factored for Lie {
    fn solver(&self) -> &'static str {
        "liar"
    }

    fn rank(&self) -> usize {
        self.inner.rank()
    }

    fn diagnosis(&self) -> Diagnosis {
        self.inner.diagnosis()
    }

    fn solve_into(&mut self, rhs: &[f64], d: &mut [f64]) {
        self.inner.solve_into(rhs, d);
        d.iter_mut().for_each(|d| *d *= 1.0 + self.by);
    }

    fn multipliers_into(&mut self, rhs: &[f64], multipliers: &mut [f64]) {
        self.inner.multipliers_into(rhs, multipliers);
    }
}

#[test]
fn no_lie_of_a_solver_gets_out_of_an_event() {
    let mut random = Random(3);
    for case in 0..200 {
        let size = [1e-9, 1.0, 1e9][case % 3];
        let curve = any_curve(&mut random, size);
        let (a, b) = curve.domain();
        let u = a + (b - a) * random.next() * 0.99;
        let by = [0.5 * size, 0.2 * size, -size];
        let edit = |lie: f64| Edit::new(&curve).ask(position(u).by(by)).solve_with(Liar { by: lie });
        edit(0.0).unwrap();
        for lie in [1e-11, 1e-6, 1.0, f64::NAN, f64::INFINITY] {
            let error = edit(lie).unwrap_err().to_string();
            assert!(error.contains("\"liar\"") || error.contains("overflows"), "{error}");
        }
        // A drag's event refuses it, too, and the shape is as it was.
        let mut drag = Edit::new(&curve).handle(position(u)).prepare(Liar { by: 1e-6 }).unwrap();
        assert!(drag.to_point(Point::new(2.0 * size, size, -size)).is_err());
        assert_eq!(drag.shape(), &curve);
        // Bounds and equations that are not linear have their own ways; the lie gets out of neither.
        let far = [3.0 * size; 3];
        let bounded = Edit::new(&curve).ask(position(u).at_least(far)).solve_with(Liar { by: -1e-6 });
        assert!(bounded.is_err());
    }
}

/// Events judge as finely as a commit does, each in its own way (equations, bounds, what is not linear), and so does a problem
/// that is solved once; an adjustment may be forced, an error never.
#[test]
fn events_judge_to_rounding_whatever_is_forced() {
    let mut random = Random(29);
    for case in 0..120 {
        let size = [1e-9, 1.0, 1e9][case % 3];
        let curve = any_curve(&mut random, size);
        let (a, b) = curve.domain();
        let u = a + (b - a) * random.next() * 0.99;
        let (by, far) = ([0.5 * size, 0.2 * size, -size], [3.0 * size; 3]);
        for forced in [false, true] {
            let edit = || if forced { Edit::new(&curve).force() } else { Edit::new(&curve) };
            for by_share in [0.0, 1e-11, -1e-11, 1e-6, f64::NAN] {
                let liar = || Liar { by: by_share };
                let honest = by_share == 0.0;
                let mut drag = edit().handle(position(u)).prepare(liar()).unwrap();
                let to = Point::new(2.0 * size, size, -size);
                assert_eq!(drag.to_point(to).is_ok(), honest, "case {case}: a drag, {by_share:e}");
                assert!(honest || drag.shape() == &curve);
                let mut applied = edit().ask(position(u).by(by)).prepare(liar()).unwrap();
                assert_eq!(applied.apply().is_ok(), honest, "case {case}: an event, {by_share:e}");
                assert!(honest || applied.shape() == &curve);
                let mut bounded = edit().ask(position(u).at_least(far)).prepare(liar()).unwrap();
                // Too much of what is bounded from below is no error.
                let fine = by_share >= 0.0;
                assert_eq!(bounded.apply().is_ok(), fine, "case {case}: a bound, {by_share:e}");
                assert!(fine || bounded.shape() == &curve);
                let once = edit().ask(position(u).by(by)).problem().unwrap().solve(&liar());
                assert_eq!(once.is_ok(), honest, "case {case}: once, {by_share:e}");
                let once = edit().ask(position(u).at_least(far)).problem().unwrap().solve(&liar());
                assert_eq!(once.is_ok(), fine, "case {case}: a bound once, {by_share:e}");
            }
        }
    }
    // Beside what is not linear, on its border and in one system with it.
    let points = (0..12).map(|i| Point::new(f64::from(i), f64::from(i % 3), 0.0)).collect();
    let curve = Curve::new(Space::clamped_uniform(3, 12).unwrap(), points).unwrap();
    for (forced, bounded) in [(false, false), (false, true), (true, false), (true, true)] {
        let edit = || {
            let edit =
                Edit::new(&curve).ask(magnitude(6.5).scale(1.2)).ask(position(2.0).by([0.1, 0.4, 0.2]));
            let edit = if forced { edit.force() } else { edit };
            if bounded { edit.ask(position(4.5).axis(Axis::Y).at_most(0.5)) } else { edit }
        };
        edit().prepare(Liar { by: 0.0 }).unwrap().apply().unwrap();
        for by in [1e-11, 1e-6] {
            assert!(edit().prepare(Liar { by }).unwrap().apply().is_err(), "{forced} {bounded} {by:e}");
        }
    }
}

/// Near conflicts beside what is not linear: solved in one system with bounds, or with the linear ones factored once.
#[test]
fn near_conflicts_beside_what_is_not_linear_are_refused_too() {
    let points = (0..12).map(|i| Point::new(f64::from(i), f64::from(i % 3), 0.0)).collect();
    let curve = Curve::new(Space::clamped_uniform(3, 12).unwrap(), points).unwrap();
    let edit = |bounded: bool| {
        let edit = Edit::new(&curve)
            .ask(magnitude(8.0).scale(1.1))
            .ask(position(3.0).by([0.0, 1.0, 0.0]))
            .ask(position(3.0 + 1e-7).keep());
        if bounded { edit.ask(position(6.5).axis(Axis::Y).at_most(0.5)) } else { edit }
    };
    for bounded in [false, true] {
        let mut session = edit(bounded).prepare(HouseholderQr).unwrap();
        let error = session.apply().unwrap_err();
        let EditError::Solve(SolveError::NearConflict { constraints, times, .. }) = &error else {
            panic!("{bounded}: {error}");
        };
        assert!(*times > 1e6 && *times < 1e9, "{error}");
        assert!(constraints.iter().all(|name| name.contains("position at 3")), "{error}");
        assert_eq!(session.shape(), &curve);
    }
    let forced = edit(false).force().solve_with(HouseholderQr).unwrap();
    assert!(forced.report().adjustment > 1e6 && forced.report().residual < 1e-6, "{}", forced.report());
}

/// Says that it is met where its rows are, and is not: a value that goes its own way.
#[derive(Debug, Clone)]
struct Fickle {
    on: usize,
    own_way: f64,
    between: f64,
    accuracy: Accuracy,
}

impl Functional for Fickle {
    fn equations(&self) -> usize {
        3
    }

    fn linearity(&self) -> Linearity {
        Linearity::Linear
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        vertex(self.on as i64).rows(shapes, rows)
    }

    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        vertex(self.on as i64).value(shapes, out)?;
        // Where the vertex has moved, the value has not gone along all the way.
        let moved = shapes.vertex(self.on).y;
        out[1] += self.own_way * moved;
        Ok(())
    }

    fn describe(&self) -> String {
        "fickle".into()
    }

    fn accuracy(&self) -> Accuracy {
        self.accuracy
    }

    fn witness(&self, _: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        let between = self.between;
        Ok((between != 0.0).then(|| Arc::new(Between(between, self.accuracy)) as Arc<dyn Functional>))
    }

    fn location(&self) -> Option<(usize, Location)> {
        None
    }
}

#[derive(Debug)]
struct Between(f64, Accuracy);

impl Functional for Between {
    fn equations(&self) -> usize {
        1
    }

    fn linearity(&self) -> Linearity {
        Linearity::Linear
    }

    fn rows(&self, _: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        rows.equation().term(0, 0, Vector::x());
        Ok(())
    }

    fn value(&self, _: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        out[0] = self.0;
        Ok(())
    }

    fn describe(&self) -> String {
        "between".into()
    }

    fn accuracy(&self) -> Accuracy {
        self.1
    }
}

#[test]
fn commit_asks_the_functionals_themselves_and_between_their_places() {
    let points = (0..6).map(|i| Point::new(f64::from(i), 0.0, 0.0)).collect();
    let curve = Curve::new(Space::clamped_uniform(3, 6).unwrap(), points).unwrap();
    let fickle = |own_way, between, accuracy| {
        let functional = Fickle { on: 2, own_way, between, accuracy };
        Edit::new(&curve).ask(functional.to([2.0, 1.0, 0.0])).solve()
    };
    let exact = Accuracy::Rounding;
    assert_eq!(fickle(0.0, 0.0, exact).unwrap().report().constraints[0].between, None);
    let error = fickle(1e-9, 0.0, exact).unwrap_err().to_string();
    assert!(error.contains("\"fickle\" would be missed by 1e-9"), "{error}");
    assert!(fickle(f64::NAN, 0.0, exact).is_err());
    // Between its places it does not hold, or no better than it promises.
    let error = fickle(0.0, 0.03, exact).unwrap_err().to_string();
    assert!(error.contains("missed by 0.03"), "{error}");
    assert!(fickle(0.0, 0.03, Accuracy::Within(0.02)).is_err());
    let done = fickle(0.0, 0.03, Accuracy::Within(0.04)).unwrap();
    assert_eq!(done.report().constraints[0].between, Some(0.03));
}

#[test]
fn undo_takes_inserted_knots_out_again() {
    let mut random = Random(5);
    let mut tried = 0;
    for _ in 0..200 {
        let curve = any_curve(&mut random, 1.0);
        let (a, b) = curve.domain();
        let u = a + (b - a) * (0.3 + 0.4 * random.next());
        let within = (u - 0.15 * (b - a), u + 0.15 * (b - a));
        let edit = || Edit::new(&curve).ask(position(u).by([0.0, 0.1, 0.0])).within(within.0, within.1);
        let Ok(done) = edit().solve() else { continue };
        tried += 1;
        assert!(done.shape().points().len() > curve.points().len());
        assert_eq!(done.undo(), curve);
        let mut session =
            Edit::new(&curve).handle(position(u)).within(within.0, within.1).prepare(Automatic).unwrap();
        assert_eq!(session.shape(), &curve, "nothing has moved yet");
        let first = session.to_point(Point::new(0.5, 0.5, 0.5)).unwrap().clone();
        assert_ne!(first, curve);
        session.checkpoint();
        let second = session.to_point(Point::new(0.6, 0.5, 0.5)).unwrap().clone();
        assert!(session.undo().unwrap());
        assert_eq!(session.shape(), &first);
        assert!(session.undo().unwrap());
        assert_eq!(session.shape(), &curve);
        // It can be gone on with.
        assert_eq!(
            session.to_point(Point::new(0.6, 0.5, 0.5)).unwrap().points().len(),
            second.points().len()
        );
        assert!(session.undo().unwrap());
        assert_eq!(session.commit().unwrap().shape(), &curve);
    }
    assert!(tried >= 150, "{tried} of 200");
}

#[test]
fn a_length_that_overflows_is_refused() {
    let points = (0..12).map(|i| Point::new(f64::from(i), 0.0, 0.0)).collect();
    let curve = Curve::new(Space::clamped_uniform(3, 12).unwrap(), points).unwrap();
    let ask = |size: f64| {
        Edit::new(&curve)
            .ask(vertex(2).axis(Axis::X).to(size))
            .ask(vertex(2).axis(Axis::Y).to(size))
            .ask(vertex(3).axis(Axis::Z).to(-size))
            .solve()
    };
    assert!(ask(1e154).unwrap().report().adjustment.is_finite());
    match ask(1.7e308) {
        Ok(done) => assert!(done.report().adjustment.is_finite(), "{}", done.report()),
        Err(error) => assert!(error.to_string().contains("overflows"), "{error}"),
    }
}

#[test]
fn what_was_not_solved_for_is_said() {
    let points = (0..8).map(|i| Point::new(f64::from(i), 0.0, 0.0)).collect();
    let curve = Curve::new(Space::clamped_uniform(3, 8).unwrap(), points).unwrap();
    let mut session = Edit::new(&curve).handle(position(2.0)).prepare(Automatic).unwrap();
    session.to_point(Point::new(2.0, 1.0, 0.0)).unwrap();
    session.add(tangent(4.0).direction([1.0, 1.0, 0.0]).hold()).unwrap();
    let report = session.commit().unwrap().report().clone();
    assert!(report.residual > 0.1 && report.to_string().contains("nothing has been solved for"), "{report}");
    let mut session =
        Edit::new(&curve).ask(derivative(2.0, 1).keep()).handle(position(2.0)).prepare(Automatic).unwrap();
    session.to_point(Point::new(2.0, 1.0, 0.0)).unwrap();
    assert!(session.commit().unwrap().report().notes.is_empty());
}

/// Whether two sessions show the same and are asked the same.
fn assert_as(session: &Session<Curve>, other: &Session<Curve>) {
    assert_eq!(session.shape(), other.shape());
    let asked =
        |s: &Session<Curve>| -> Vec<String> { s.problem().constraints().map(Constraint::label).collect() };
    assert_eq!(asked(session), asked(other));
    assert_eq!(session.report().constraints, other.report().constraints);
}

/// What cannot be added (or let go of) leaves nothing behind: no constraint, no companion, no location that floats, no other idea
/// of where the handle was.
#[test]
fn what_fails_to_join_a_session_is_taken_back_whole() {
    let points = (0..12).map(|i| Point::new(f64::from(i), (0.7 * f64::from(i)).sin(), 0.0)).collect();
    let curve = Curve::new(Space::clamped_uniform(3, 12).unwrap(), points).unwrap();
    let full = || {
        let edit = Edit::new(&curve).ask(position(7.5).keep()).ask(position(0.5).keep());
        let mut session = edit.handle(position(3.0)).prepare(Adjoint).unwrap();
        session.to_point(Point::new(3.2, 1.0, 0.3)).unwrap();
        session
    };
    // More equations than the solver is for, or what cannot be asked at all.
    let six = |functional: &dyn Fn(f64) -> Constraint| {
        (0..6).map(|k| functional(1.1 + 1.3 * f64::from(k))).collect()
    };
    let many: Vec<Constraint> = six(&|u| position(u).keep());
    let bent: Vec<Constraint> = six(&|u| curvature(u + 0.3).keep());
    let afloat: Vec<Constraint> = six(&|u| position(near(u)).keep());
    let hopeless = vec![vertex(40).keep()];
    for fresh in [many, bent, afloat, hopeless] {
        let (mut session, mut other) = (full(), full());
        let mut failed = 0;
        for constraint in fresh {
            let label = constraint.label();
            if session.add(constraint.clone()).is_ok() {
                other.add(constraint).unwrap();
            } else {
                failed += 1;
                assert_as(&session, &other);
            }
            // What comes next is what would have come without it.
            let to = Point::new(3.1, 1.0 + 0.1 * f64::from(failed), 0.2);
            let next = session.to_point(to).unwrap_or_else(|error| panic!("{label}: {error}")).clone();
            assert!(
                (next.point(3.0).unwrap() - to).amax() < 1e-12,
                "after {label}: {}",
                next.point(3.0).unwrap()
            );
            other.to_point(to).unwrap();
            assert_as(&session, &other);
        }
        assert!(failed > 0);
        session.commit().unwrap();
    }
}

/// A shape as it was of which something cannot be asked that was asked since: there is no way back to it before that is let go,
/// and the session goes on as it was.
#[test]
fn an_undo_that_fails_leaves_the_session_as_it_was() {
    let mut points: Vec<Point> = (0..8).map(|i| Point::new(f64::from(i), 0.0, 0.0)).collect();
    points[1] = points[0];
    let curve = Curve::new(Space::clamped_uniform(3, 8).unwrap(), points).unwrap();
    for checkpoint in [false, true] {
        let mut session = Edit::new(&curve).handle(vertex(1)).prepare(Automatic).unwrap();
        if checkpoint {
            session.checkpoint();
        }
        session.to_point(Point::new(1.0, 1.0, 0.0)).unwrap();
        // Where the curve stood still it had no tangent.
        let id = session.add(magnitude(0.0).keep()).unwrap();
        session.to_point(Point::new(2.0, 2.0, 0.0)).unwrap();
        let shape = session.shape().clone();
        let error = session.undo().unwrap_err().to_string();
        assert!(error.contains("C' vanishes there"), "{error}");
        assert_eq!(session.shape(), &shape);
        assert_eq!(
            session.to_point(Point::new(0.5, 0.5, 0.0)).unwrap().points()[1],
            Point::new(0.5, 0.5, 0.0)
        );
        session.remove(id).unwrap();
        assert!(session.undo().unwrap());
        assert_eq!(session.shape(), &curve);
    }
}

/// Short of a near conflict, an adjustment that is long for what is asked is told, with the constraints that make it so; where
/// it is forced as well.
#[test]
fn an_adjustment_that_is_long_for_what_is_asked_is_told() {
    let points = (0..12).map(|i| Point::new(f64::from(i), f64::from(i % 3), 0.0)).collect();
    let curve = Curve::new(Space::clamped_uniform(3, 12).unwrap(), points).unwrap();
    let edit = |gap: f64, beside: usize| {
        let edit = Edit::new(&curve)
            .ask(position(8.5).keep())
            .ask(position(3.0).by([0.0, 1.0, 0.0]))
            .ask(position(3.0 + gap).keep());
        match beside {
            0 => edit,
            1 => edit.metric(Metric::Bend),
            2 => edit.ask(magnitude(8.0).scale(1.1)),
            _ => edit.ask(position(6.5).axis(Axis::Y).at_most(0.5)),
        }
    };
    let told = |edit: Edit<Curve>| {
        let done = edit.solve_with(HouseholderQr).unwrap();
        let notes = done.report().notes.iter().filter(|note| note.contains("nearly contradictory"));
        notes.cloned().collect::<Vec<_>>()
    };
    for beside in 0..4 {
        assert_eq!(told(edit(0.1, beside)), [""; 0], "{beside}");
        // A change of one, and a distance of 1e-5: as steep as a hundred thousand. Bending takes more.
        let (gap, name) = if beside == 1 { (1e-4, "3.0001") } else { (1e-5, "3.00001") };
        let notes = told(edit(gap, beside));
        assert!(notes.len() == 1, "{beside}: {notes:?}");
        assert!(notes[0].contains("times what its equations ask one by one"), "{}", notes[0]);
        let names = format!("\"position at 3\", \"position at {name}\"");
        assert!(notes[0].ends_with(&names), "{}", notes[0]);
        let forced = told(edit(1e-7, beside).force());
        assert!(forced.len() == 1 && forced[0].contains("position at 3.0000001"), "{beside}: {forced:?}");
        // Nothing has been solved for, and nothing is long.
        let session = edit(1e-5, beside).prepare(HouseholderQr).unwrap();
        assert!(!session.report().to_string().contains("nearly contradictory"));
    }
    // After a drag, too.
    let edit = Edit::new(&curve).ask(position(3.0 + 1e-5).keep()).handle(position(3.0));
    let mut drag = edit.prepare(Automatic).unwrap();
    let start = curve.point(3.0).unwrap();
    drag.to_point(start).unwrap();
    assert!(!drag.report().to_string().contains("nearly contradictory"));
    drag.to_point(start + Vector::new(0.0, 0.5, 0.0)).unwrap();
    assert!(drag.report().to_string().contains("nearly contradictory"), "{}", drag.report());
}

/// A checkpoint is the whole shape, whatever is asked of other vertices after it.
#[test]
fn an_undo_takes_back_what_was_first_touched_after_the_checkpoint() {
    let points = (0..12).map(|i| Point::new(f64::from(i), (0.7 * f64::from(i)).sin(), 0.0)).collect();
    let curve = Curve::new(Space::clamped_uniform(3, 12).unwrap(), points).unwrap();
    for handle in [position(3.2), position(near(3.2))] {
        let mut session = Edit::new(&curve).handle(handle).prepare(Automatic).unwrap();
        session.to_point(Point::new(3.0, 1.0, 0.2)).unwrap();
        let mut shapes = vec![curve.clone(), session.shape().clone()];
        session.checkpoint();
        for (place, height) in [(6.0, 0.5), (1.1, 0.8), (8.4, -1.0)] {
            session.add(position(place).axis(Axis::Z).to(height)).unwrap();
            session.to_point(Point::new(4.0 + height, 1.2, 0.1)).unwrap();
            shapes.push(session.shape().clone());
            session.checkpoint();
        }
        session.apply().unwrap();
        shapes.pop();
        assert!(session.undo().unwrap());
        while let Some(before) = shapes.pop() {
            assert!(session.undo().unwrap());
            let apart = session.shape().points().iter().zip(before.points()).map(|(a, b)| (a - b).amax());
            assert!(apart.fold(0.0, f64::max) == 0.0, "{} left", shapes.len());
        }
    }
}

//! Curves, edited: what was smooth is smooth.

use loftsman_kernel::edit::{Ask, Axis, Edit, EditError, Metric};
use loftsman_kernel::functional::{derivative, magnitude, orthogonal, position, vertex};
use loftsman_kernel::solve::SolveError;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

use super::evaluator::{angle, joints, on_curve};
use super::families::{chain, chain_of, conic, cornered, inserted};
use super::{Dice, solvers};

/// Both sides of every knot where something may be lost, with whether they meet and whether they are smooth.
struct Seen {
    sides: [[Vector; 3]; 2],
    meets: bool,
    smooth: bool,
}

fn look(curve: &Curve) -> Vec<Seen> {
    joints(curve.space(), curve.degree(), true)
        .into_iter()
        .map(|places| {
            let sides = places.map(|place| on_curve(curve, place));
            let meets = (sides[1][0] - sides[0][0]).norm() < 1e-12;
            let smooth = meets && angle(sides[0][1], sides[1][1]) < 1e-9;
            Seen { sides, meets, smooth }
        })
        .collect()
}

/// How many knots were smooth, all of which are now; `after` has the knots of `before`.
fn check(before: &Curve, after: &Curve, what: &str) -> usize {
    let size = after.points().iter().map(|p| p.coords.amax()).fold(1.0, f64::max);
    let mut count = 0;
    for (old, new) in look(before).iter().zip(look(after)) {
        let gap = (new.sides[1][0] - new.sides[0][0]).norm();
        assert!(!old.meets || gap <= 1e-9 * size, "{what}: a gap of {gap:e}");
        if !old.smooth {
            continue;
        }
        count += 1;
        let r = old.sides[1][1].norm() / old.sides[0][1].norm();
        let [left, right] = [new.sides[0][1], new.sides[1][1]];
        // The relation holds wherever the edit took the derivative, to zero as well.
        let scale = right.norm() + r * left.norm() + old.sides[1][1].norm();
        assert!((right - left * r).norm() <= 1e-9 * scale, "{what}: {right} is not {r} times {left}");
        if right.norm() > 0.1 * old.sides[1][1].norm() {
            let (turn, ratio) = (angle(left, right), right.norm() / left.norm());
            assert!(turn <= 1e-9, "{what}: an angle of {turn:e}");
            assert!((ratio - r).abs() <= 1e-9 * r, "{what}: the ratio was {r} and is {ratio}");
        }
    }
    count
}

/// A place on the curve, every other time a knot.
fn place(curve: &Curve, dice: &mut Dice) -> f64 {
    let (a, b) = curve.domain();
    let breaks = curve.space().breakpoints();
    if dice.below(2) == 0 { breaks[dice.below(breaks.len() - 1)] } else { dice.between(a, b) }
}

fn metric(curve: &Curve, dice: &mut Dice) -> Metric {
    match dice.below(8) {
        0 => Metric::Bend,
        1 => Metric::Stretch,
        2 => Metric::Falloff(dice.between(1.0, 2.5)),
        3 => Metric::Weights(curve.points().iter().map(|_| dice.between(0.5, 5.0)).collect()),
        _ => Metric::Least,
    }
}

/// What a solver may say of a system it is not made for.
fn beyond(error: &EditError) -> bool {
    matches!(error, EditError::Solve(SolveError::TooLarge { .. } | SolveError::IllConditioned { .. }))
}

#[test]
fn what_a_translation_meets_is_never_refused() {
    // Positions, vertices all moved by one vector and derivatives kept: the translated curve is as smooth as it was.
    let (mut kept, mut beyond_it, mut trials) = (0, 0, 0);
    for seed in 0..240 {
        for solver in solvers() {
            let mut dice = Dice(1000 + seed);
            let curve = [chain, conic, inserted, cornered][seed as usize % 4](&mut dice);
            let by = dice.vector(0.5);
            let mut edit = Edit::new(&curve).metric(metric(&curve, &mut dice));
            for _ in 0..1 + dice.below(4) {
                let at = place(&curve, &mut dice);
                edit = match dice.below(4) {
                    0 => edit.ask(vertex(dice.below(curve.points().len()) as i64).by(by)),
                    1 => edit.ask(derivative(at, 1).keep()),
                    _ => edit.ask(position(at).by(by)),
                };
            }
            trials += 1;
            match edit.solve_with(solver.clone()) {
                Ok(edited) => kept += check(&curve, edited.shape(), &format!("{seed}, {}", edited.report())),
                Err(error) if beyond(&error) => beyond_it += 1,
                Err(error) => panic!("{seed}, {}: {error}", solver.name()),
            }
        }
    }
    assert!(kept > 2000, "{kept} knots were kept smooth");
    // The adjoint takes six equations at most.
    assert!(beyond_it * 3 < trials, "{beyond_it} of {trials} were beyond their solver");
}

#[test]
fn edits_of_every_kind_keep_what_was_smooth() {
    let (mut kept, mut refused, mut solved, mut reported) = (0, 0, 0, 0);
    for seed in 0..240 {
        let mut dice = Dice(5000 + seed);
        let curve = [chain, conic, inserted, cornered][seed as usize % 4](&mut dice);
        let n = curve.points().len();
        let mut edit = Edit::new(&curve).metric(metric(&curve, &mut dice));
        let at = place(&curve, &mut dice);
        edit = edit.ask(position(at).by(dice.vector(0.4)));
        for _ in 0..dice.below(3) {
            let there = place(&curve, &mut dice);
            edit = match dice.below(6) {
                0 => edit.ask(derivative(there, 1).by(dice.vector(0.3))),
                1 => edit.ask(orthogonal(there, dice.vector(1.0)).keep()),
                2 => edit.ask(vertex(dice.below(n) as i64).by(dice.vector(0.3))),
                3 => edit.ask(magnitude(there).keep()),
                _ => edit.ask(position(there).by(dice.vector(0.3))),
            };
        }
        if dice.below(4) == 0 {
            edit = edit.lock([dice.below(n) as i64]);
        }
        if dice.below(6) == 0 {
            edit = edit.locality(curve.degree().min(1 + dice.below(3)));
        }
        let solver = solvers()[dice.below(4)].clone();
        match edit.solve_with(solver) {
            Ok(edited) => {
                solved += 1;
                kept += check(&curve, edited.shape(), &format!("{seed}, {}", edited.report()));
                reported += usize::from(edited.report().smooth.knots > 0);
            }
            Err(_) => refused += 1,
        }
    }
    assert!(kept > 400 && reported > 100, "{kept} knots kept, in {reported} reports");
    // What they ask at random contradicts itself, or a lock, or one vertex that alone may move.
    assert!(refused <= 55, "{refused} of {} were refused", refused + solved);
}

#[test]
fn a_contradiction_names_the_knot_and_the_way_out() {
    let mut found = 0;
    for seed in 0..120 {
        for solver in solvers() {
            let mut dice = Dice(9000 + seed);
            let curve = chain(&mut dice);
            let (p, space) = (curve.degree(), curve.space());
            // The vertices around an inner knot: that before it is moved, the others stay.
            let breaks = space.breakpoints();
            let knot = breaks[1 + dice.below(breaks.len() - 2)];
            let k = space.flat().iter().position(|&t| t == knot).unwrap() as i64 - 1;
            let torn = space.multiplicity(knot) > p;
            let ask = |level: u8| {
                let edit = Edit::new(&curve).smooth(level).ask(vertex(k - 1).by([0.3, -0.4, 0.5]));
                let edit = edit.ask(vertex(k).keep()).ask(vertex(k + 1).keep());
                if torn { edit.ask(vertex(k + 2).keep()) } else { edit }
            };
            match ask(1).solve_with(solver.clone()) {
                Ok(_) => panic!("{seed}, {}: solved", solver.name()),
                Err(error) if beyond(&error) => {}
                Err(error) => {
                    let text = error.to_string();
                    assert!(text.contains(&format!("smooth knot at {knot}\"")), "{seed}: {text}");
                    assert!(text.contains("smooth = 0"), "{seed}: {text}");
                    found += 1;
                }
            }
            let let_go = ask(0).solve_with(solver).unwrap();
            let corners = &let_go.report().smooth.corners;
            let at = corners.iter().find(|c| c.place == format!("at {knot}")).unwrap();
            let now = look(let_go.shape());
            let places = joints(space, p, true);
            let seen = places.iter().position(|[_, right]| right.1 == knot).unwrap();
            let measured = angle(now[seen].sides[0][1], now[seen].sides[1][1]).to_degrees();
            assert!((at.degrees.unwrap() - measured).abs() < 1e-6, "{seed}: {at} {measured}");
        }
    }
    assert!(found >= 480, "{found}");
}

#[test]
fn level_2_keeps_the_curvature() {
    let mut counted = 0;
    for seed in 0..100 {
        let mut dice = Dice(12_000 + seed);
        let curve = if seed % 3 == 0 { conic(&mut dice) } else { inserted(&mut dice) };
        let (at, by) = (place(&curve, &mut dice), dice.vector(0.4));
        let edited = Edit::new(&curve).smooth(2).ask(position(at).by(by)).solve().unwrap();
        check(&curve, edited.shape(), &format!("{seed}"));
        let bend = |side: [Vector; 3]| side[1].cross(&side[2]) / side[1].norm().powi(3);
        for (old, new) in look(&curve).iter().zip(look(edited.shape())) {
            let curvature = |seen: &Seen| {
                let [a, b] = seen.sides.map(bend);
                ((a - b).norm(), a.norm().max(b.norm()))
            };
            let ((was, _), (is, size)) = (curvature(old), curvature(&new));
            if old.smooth && was < 1e-9 {
                counted += 1;
                assert!(is <= 1e-7 * size.max(1.0), "{seed}: the curvature jumps by {is:e} of {size}");
            }
        }
    }
    assert!(counted > 300, "{counted}");
}

#[test]
fn an_edit_within_an_interval_has_room_beside_what_stays_smooth() {
    for seed in 0..100 {
        let mut dice = Dice(15_000 + seed);
        let curve = chain(&mut dice);
        let breaks = curve.space().breakpoints();
        let piece = dice.below(breaks.len() - 1);
        let (a, b) = (breaks[piece], breaks[piece + 1]);
        let at = a + (b - a) * dice.between(0.3, 0.7);
        let edited = Edit::new(&curve).within(a, b).ask(position(at).by([0.1, 0.2, 0.3])).solve();
        if curve.degree() == 1 {
            // A straight line cannot be bent at one place and stay straight, however many knots it has.
            assert!(edited.unwrap_err().to_string().contains("smooth = 0"));
            continue;
        }
        let edited = edited.unwrap();
        let after = edited.shape();
        for [left, right] in joints(curve.space(), curve.degree(), true) {
            let [old, new] = [&curve, after].map(|c| {
                let place = |u: f64, end: bool| {
                    let t = c.space().flat();
                    let spans = (c.degree()..t.len() - c.degree() - 1).filter(|&s| t[s] < t[s + 1]);
                    let mut fits = spans.filter(|&s| if end { t[s + 1] == u } else { t[s] == u });
                    (fits.next().unwrap(), u)
                };
                [on_curve(c, place(left.1, true)), on_curve(c, place(right.1, false))]
            });
            let meets = (old[1][0] - old[0][0]).norm() < 1e-12;
            if meets && angle(old[0][1], old[1][1]) < 1e-9 {
                let turn = angle(new[0][1], new[1][1]);
                assert!(turn < 1e-9, "{seed}: a corner of {turn:e} at {}", right.1);
            }
        }
    }
}

/// The same curve in another unit, over another domain.
fn scaled(curve: &Curve, size: f64, domain: f64) -> Curve {
    let (space, points, weights) = curve.clone().into_parts();
    let knots = space.knots().iter().map(|k| k * domain).collect();
    let other = if space.is_periodic() { Space::periodic } else { Space::open };
    let points = points.into_iter().map(|p| Point::from(p.coords * size)).collect();
    Curve::build(other(space.degree(), knots).unwrap(), points, weights).unwrap()
}

#[test]
fn no_unit_and_no_domain_is_special() {
    for seed in 0..100 {
        let mut dice = Dice(30_000 + seed);
        let curve = [chain, conic, inserted, cornered][seed as usize % 4](&mut dice);
        let (at, by) = (place(&curve, &mut dice), dice.vector(0.5));
        let plain = Edit::new(&curve).ask(position(at).by(by)).solve().unwrap();
        // Powers of two: every number is the same but for its exponent.
        for (size, domain) in [(1e-9, 1.0), (1e9, 1e6), (1.0, 1e-6), (1e-9, 1e9)] {
            let power = |x: f64| x.log2().round().exp2();
            let (size, domain) = (power(size), power(domain));
            let other = scaled(&curve, size, domain);
            let edited = Edit::new(&other).ask(position(at * domain).by(by * size)).solve().unwrap();
            assert_eq!(edited.report().smooth.knots, plain.report().smooth.knots, "{seed}");
            for (p, q) in plain.shape().points().iter().zip(edited.shape().points()) {
                assert!((p.coords * size - q.coords).norm() <= 1e-12 * size * 10.0, "{seed}: {p} {q}");
            }
        }
    }
}

#[test]
fn the_highest_degree_and_long_chains() {
    let mut kept = 0;
    for seed in 0..20 {
        let mut dice = Dice(31_000 + seed);
        let curve = chain_of(25, &mut dice);
        let edited =
            Edit::new(&curve).ask(position(place(&curve, &mut dice)).by(dice.vector(0.5))).solve().unwrap();
        kept += check(&curve, edited.shape(), &format!("{seed}"));
    }
    assert!(kept > 40, "{kept}");
    // Two thousand quadratic pieces: all hang together; two thousand cubic ones: only those at the place.
    for (p, most) in [(2, 1999), (3, 2)] {
        let pieces = 2000;
        let n = pieces * p + 1;
        let inner = (1..pieces).flat_map(|k| std::iter::repeat_n(k as f64, p));
        let ends = |u: f64| std::iter::repeat_n(u, p + 1);
        let space = Space::open(p, ends(0.0).chain(inner).chain(ends(pieces as f64)).collect()).unwrap();
        // A parabola, cut at every knot.
        let smooth = Curve::new(Space::clamped_uniform(p, pieces + p).unwrap(), {
            let space = Space::clamped_uniform(p, pieces + p).unwrap();
            (0..pieces + p)
                .map(|i| Point::new(space.greville(i), (space.greville(i) * 0.01).sin(), 0.0))
                .collect()
        });
        let knots: Vec<f64> = (1..pieces).flat_map(|k| std::iter::repeat_n(k as f64, p - 1)).collect();
        let curve = smooth.unwrap().insert_knots(&knots).unwrap();
        assert_eq!((curve.points().len(), curve.space()), (n, &space));
        let edited = Edit::new(&curve).ask(position(1000.3).by([0.0, 0.5, 0.0])).solve().unwrap();
        check(&curve, edited.shape(), "long");
        assert_eq!(edited.report().smooth.knots, most);
    }
}

#[test]
fn bounds_leave_what_is_smooth() {
    let (mut kept, mut refused) = (0, 0);
    for seed in 0..100 {
        let mut dice = Dice(32_000 + seed);
        let curve = [chain, conic, inserted, cornered][seed as usize % 4](&mut dice);
        let mut edit = Edit::new(&curve);
        for _ in 0..1 + dice.below(3) {
            let at = place(&curve, &mut dice);
            let low = curve.point(at).unwrap().y + dice.between(-0.3, 0.5);
            edit = edit.ask(position(at).axis(Axis::Y).at_least(low));
        }
        let edited = match edit.solve() {
            Ok(edited) => edited,
            Err(_) => {
                refused += 1;
                continue;
            }
        };
        kept += check(&curve, edited.shape(), &format!("{seed}, {}", edited.report()));
    }
    // Far enough up, all of them hold.
    assert!(kept > 200 && refused == 0, "{kept} kept, {refused} refused");
    // Vertices around a joint against a bound: the knot is named.
    let line: Vec<Point> = (0..7).map(|i| Point::new(f64::from(i), 0.0, 0.0)).collect();
    let space = Space::open(3, vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0]).unwrap();
    let line = Curve::new(space, line).unwrap();
    let bounded = Edit::new(&line).ask(vertex(2).keep()).ask(vertex(3).keep());
    let text = bounded.ask(vertex(4).axis(Axis::Y).at_least(1.0)).solve().unwrap_err().to_string();
    assert!(text.contains("smooth knot at 1") && text.contains("smooth = 0"), "{text}");
}

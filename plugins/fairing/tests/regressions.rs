//! What once went wrong: rows that vanish, energies that can be nothing, motions that cost nothing.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail the test")]

use crate::dice::Dice;
use loftsman_fairing::{EnergySum, Fair, FairReport, bend, near, stretch, variation};
use loftsman_kernel::Point;
use loftsman_kernel::edit::{Ask, Axis, Constraint};
use loftsman_kernel::functional::{derivative, position};
use loftsman_kernel::spline::{Curve, Space, Surface};

/// Eight vertices, clamped, degree 3, over `[0, 5]`.
fn eight() -> Curve {
    let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 5.0, 5.0, 5.0];
    let points = [
        [0.0, 0.0, 0.0],
        [1.0, 2.0, 0.0],
        [2.0, -1.0, 1.0],
        [3.0, 2.0, 0.0],
        [4.0, 0.0, -1.0],
        [5.0, 2.0, 0.0],
        [6.0, 0.0, 0.0],
        [7.0, 1.0, 0.0],
    ];
    Curve::new(Space::open(3, knots).unwrap(), points.map(Point::from).to_vec()).unwrap()
}

fn y_at(u: f64) -> loftsman_kernel::edit::AxisOf<loftsman_kernel::functional::Position> {
    position(u).axis(Axis::Y)
}

/// A locked end that is kept as well, and a derivative that no cubic has.
#[test]
fn rows_that_vanish_are_dropped() {
    let curve = eight();
    let fair = Fair::new(&curve)
        .energy(bend())
        .lock([0, 7])
        .ask(position(0.0).keep())
        .ask(position(5.0).keep())
        .solve()
        .unwrap();
    let straight = Fair::new(&curve).energy(bend()).lock([0, 7]).solve().unwrap();
    assert!(fair.shape().points().iter().zip(straight.shape().points()).all(|(a, b)| (a - b).norm() < 1e-13));
    assert_eq!(fair.report().redundant.len(), 2, "{:?}", fair.report().redundant);
    assert!(fair.report().energy_after < 1e-24, "{}", fair.report());

    // What is 0 whatever the curve is nothing to ask for, not even that it stays.
    for fourth in [derivative(2.5, 4).keep(), derivative(2.5, 4).to([0.0, 1.0, 0.0])] {
        let never = Fair::new(&curve).energy(bend()).ask(fourth).solve().unwrap_err().to_string();
        assert!(never.contains("derivative 4 of degree 3 is always 0; elevate first"), "{never}");
    }
}

fn surface(dice: &mut Dice, degrees: [usize; 2], counts: [usize; 2]) -> Surface {
    let [u, v] = [0, 1].map(|k| Space::clamped_uniform(degrees[k], counts[k]).unwrap());
    let at = |i: usize, dice: &mut Dice| {
        Point::new((i / counts[1]) as f64, (i % counts[1]) as f64, dice.between(-0.5, 0.5))
    };
    let points = (0..counts[0] * counts[1]).map(|i| at(i, dice)).collect();
    Surface::new(u, v, points).unwrap()
}

/// Corners of surfaces locked, kept, both, and again; twice the same, and what vanishes.
#[test]
fn corners_locked_and_kept_come_to_an_end() {
    let mut dice = Dice(0x00c0_ffee_1234_5678);
    for number in 0..120 {
        let degrees = [2 + dice.below(3), 2 + dice.below(3)];
        let counts = [0, 1].map(|k| degrees[k] + 1 + dice.below(4));
        let surface = surface(&mut dice, degrees, counts);
        let ((u0, u1), (v0, v1)) = (surface.u().domain(), surface.v().domain());
        let corners = [[u0, v0], [u0, v1], [u1, v0], [u1, v1]];
        let last = counts[0] * counts[1] - 1;
        let vertices = [0, counts[1] - 1, last + 1 - counts[1], last];
        let mut locks = Vec::new();
        let energy = [stretch(), bend(), bend() + near()][dice.below(3)].clone();
        let mut fair = Fair::new(&surface).energy(energy);
        for k in 0..4 {
            if k == 0 || dice.chance(0.5) {
                locks.push(vertices[k] as i64);
            }
            for _ in 0..usize::from(k == 0) + dice.below(3) {
                fair = fair.ask(position(corners[k]).keep());
            }
            if dice.chance(0.3) {
                fair = fair.ask(position(corners[k]).by([0.0; 3]));
            }
        }
        let middle = [0.5 * (u0 + u1), 0.5 * (v0 + v1)];
        let pushed = dice.chance(0.5);
        if pushed {
            fair = fair.ask(position(middle).axis(Axis::Z).at_least(0.4));
            fair = fair.ask(position(middle).axis(Axis::Z).at_least(0.3));
        }
        let fair = fair.lock(locks.iter().copied()).solve().unwrap();
        let report = fair.report();
        for &lock in &locks {
            assert_eq!(fair.shape().points()[lock as usize], surface.points()[lock as usize], "{number}");
        }
        assert!(report.residual < 1e-11, "{number}: {report}");
        assert!(pushed || report.energy_after <= report.energy_before, "{number}: {report}");
        assert!(
            !pushed || fair.shape().point(middle[0], middle[1]).unwrap().z >= 0.4 - 1e-11,
            "{number}: {report}"
        );
        assert!(report.farthest < 20.0, "{number}: {report}");
    }
}

fn solved(
    constraints: Vec<Constraint>,
    energy: EnergySum,
    within: Option<f64>,
) -> Result<(Curve, FairReport), String> {
    let curve = eight();
    let fair = constraints.into_iter().fold(Fair::new(&curve).energy(energy), Fair::ask);
    let fair = if let Some(distance) = within { fair.within(distance) } else { fair };
    fair.solve().map(|f| (f.shape().clone(), f.report().clone())).map_err(|e| e.to_string())
}

#[test]
fn an_energy_may_be_nothing() {
    let size: f64 = eight().points().iter().map(|p| p.coords.norm()).fold(0.0, f64::max);
    // A straight line through the start, or anywhere, over the peg; of all of them the nearest.
    for kept in [true, false] {
        let mut asked = vec![y_at(2.5).at_least(3.0)];
        if kept {
            asked.insert(0, position(0.0).keep());
        }
        let (curve, report) = solved(asked, bend(), None).unwrap();
        assert!((curve.point(2.5).unwrap().y - 3.0).abs() < 1e-12, "{report}");
        assert!(report.energy_after < 1e-20 * size * size, "{report}");
        assert!(report.farthest < 10.0 && report.active.len() == 1, "{report}");
        // The same with the bound as an equation.
        let mut same = vec![y_at(2.5).to(3.0)];
        if kept {
            same.insert(0, position(0.0).keep());
        }
        let (same, _) = solved(same, bend(), None).unwrap();
        assert!(curve.points().iter().zip(same.points()).all(|(a, b)| (a - b).norm() < 1e-10));
    }
    // Everything at one point; and as near to that as a distance allows.
    let kept = || vec![position(0.0).keep()];
    let mut slack = kept();
    slack.push(y_at(2.5).at_least(-10.0));
    let (curve, report) = solved(slack, stretch(), None).unwrap();
    assert!(curve.points().iter().all(|p| p.coords.norm() < 1e-12) && report.active.is_empty(), "{report}");
    for distance in [0.3, 1.0, 3.0, 20.0] {
        let (curve, report) = solved(kept(), stretch(), Some(distance)).unwrap();
        let far =
            eight().points().iter().zip(curve.points()).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(far <= distance && report.energy_after < report.energy_before, "{distance}: {report}");
        assert!(curve.point(0.0).unwrap().coords.norm() < 1e-12, "{distance}: {report}");
    }
}

#[test]
fn bounds_that_contradict_each_other_or_a_distance_are_named() {
    let low = || y_at(2.5).at_least(3.0);
    let text = solved(vec![position(0.0).keep(), low(), y_at(2.5).at_most(-3.0)], bend(), None).unwrap_err();
    assert!(
        text.contains("y of position at 2.5 ≥ 3") && text.contains("y of position at 2.5 ≤ -3"),
        "{text}"
    );
    assert!(!text.contains("position at 0\"") && text.contains("cannot all hold"), "{text}");
    let text = solved(vec![position(0.0).keep(), low()], bend(), Some(0.1)).unwrap_err();
    assert!(
        text.contains("\"y of position at 2.5 ≥ 3\" alone moves") && text.contains("further than 0.1"),
        "{text}"
    );
    assert!(!text.contains("position at 0\""), "{text}");
    // What moves one vertex far where the adjustment is least may be shared by its neighbours.
    let need = 3.0 - eight().point(2.5).unwrap().y;
    let (curve, report) = solved(vec![low()], bend() + near(), Some(1.001 * need)).unwrap();
    assert!(report.farthest <= 1.001 * need && curve.point(2.5).unwrap().y >= 3.0 - 1e-12, "{report}");
    assert!(solved(vec![low()], bend(), Some(0.999 * need)).unwrap_err().contains("none may move further"));
    let (curve, report) = solved(vec![y_at(2.5).to(3.0)], bend() + near(), Some(1.001 * need)).unwrap();
    assert!(report.farthest <= 1.001 * need && (curve.point(2.5).unwrap().y - 3.0).abs() < 1e-12, "{report}");
}

/// A triple knot inside a cubic: pieces that bend for themselves. Where they meet costs nothing, so it stays near.
#[test]
fn pieces_that_no_energy_ties_together_stay_near() {
    let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0];
    let points = [[0.0, 0.0], [1.0, 1.0], [2.0, 1.0], [3.0, 0.0], [4.0, 3.0], [5.0, 3.0], [6.0, 0.0]];
    let points: Vec<Point> = points.map(|[x, y]| Point::new(x, y, 0.0)).to_vec();
    let curve = Curve::new(Space::open(3, knots).unwrap(), points.clone()).unwrap();
    let ends = || Fair::new(&curve).energy(bend()).ask(position(0.0).keep()).ask(position(2.0).keep());
    let fair = ends().solve().unwrap();
    // Two straight lines from the ends to a point X: vertices at thirds. The X nearest to the old ones, by hand.
    let share = |i: usize| if i < 3 { i as f64 / 3.0 } else { (6 - i) as f64 / 3.0 };
    let base = |i: usize| {
        if i < 3 { points[0].coords * (1.0 - share(i)) } else { points[6].coords * (1.0 - share(i)) }
    };
    let whole: f64 = (1..6).map(|i| share(i) * share(i)).sum();
    let x = (1..6).map(|i| (points[i].coords - base(i)) * share(i)).sum::<loftsman_kernel::Vector>() / whole;
    for (i, p) in fair.shape().points().iter().enumerate() {
        assert!((p.coords - base(i) - x * share(i)).norm() < 1e-12, "{i}: {p}, {}", fair.report());
    }
    assert!(fair.report().energy_after < 1e-24, "{}", fair.report());
    assert!(fair.report().notes.iter().any(|n| n.contains("corner")), "{:?}", fair.report().notes);
    // A peg above where they meet lifts that point and nothing else.
    let peg = ends().ask(y_at(1.0).at_least(x.y + 1.0)).solve().unwrap();
    assert!(
        (peg.shape().points()[3].y - x.y - 1.0).abs() < 1e-12 && peg.report().energy_after < 1e-20,
        "{}",
        peg.report()
    );
}

/// Chains of Bézier curves, corners of every multiplicity: nothing is flung, and what costs nothing is the nearest.
#[test]
fn chains_are_never_flung() {
    let mut dice = Dice(0xfeed_beef_0000_0001);
    for number in 0..130 {
        let degree = 1 + number % 7;
        let spans = 2 + dice.below(12);
        let mut knots = vec![0.0; degree + 1];
        for i in 1..spans {
            let times = if number % 3 == 0 { degree } else { 1 + dice.below(degree + 1) };
            knots.extend(vec![i as f64; times]);
        }
        knots.extend(vec![spans as f64; degree + 1]);
        let space = Space::open(degree, knots).unwrap();
        let count = space.len();
        let points: Vec<Point> = (0..count)
            .map(|i| Point::new(i as f64, dice.between(-1.0, 1.0), dice.between(-1.0, 1.0)))
            .collect();
        let weights = dice.chance(0.3).then(|| (0..count).map(|_| dice.between(0.5, 2.0)).collect());
        let curve = Curve::build(space, points, weights).unwrap();
        let energies = [stretch(), bend(), variation()];
        let order = 1 + dice.below(degree.min(3));
        let energy = energies[order - 1].clone();
        let fair = Fair::new(&curve).energy(energy.clone());
        let fair = fair.ask(position(0.0).keep()).ask(position(spans as f64).keep()).solve().unwrap();
        let report = fair.report();
        assert!(report.energy_after <= report.energy_before * (1.0 + 1e-12), "{number}: {report}");
        // The old shape with only its ends kept is one that meets everything: the nearest of the fairest is not far beyond what
        // a straight line through the ends would take.
        let (a, b) = (curve.points()[0], curve.points()[count - 1]);
        let straight: f64 = curve
            .points()
            .iter()
            .enumerate()
            .map(|(i, p)| (p - a - (b - a) * (curve.space().greville(i) / spans as f64)).norm_squared())
            .sum::<f64>()
            .sqrt();
        // (Pieces that are not even joined may shrink to points, which is fairer than a line where it is stretched.)
        assert!(
            order == 1 || curve.weights().is_some() || report.adjustment <= straight * (1.0 + 1e-9),
            "{number}: {report}, {straight}"
        );
        assert!(report.farthest < 4.0 * count as f64, "{number}: {report}");
        // Fair already: once more changes nothing.
        let again = Fair::new(fair.shape()).energy(energy);
        let again = again.ask(position(0.0).keep()).ask(position(spans as f64).keep()).solve().unwrap();
        assert!(again.report().farthest < 1e-6 * count as f64, "{number}: {} after {report}", again.report());
    }
}

/// A plate over a bed of nails, a wire through a long band, a long chain: as large as people have them.
#[test]
fn large_problems_come_to_an_end() {
    let mut dice = Dice(0x1a26_e000_0000_0007);
    let plate = surface(&mut dice, [3, 3], [30, 30]);
    let ((u0, u1), (v0, v1)) = (plate.u().domain(), plate.v().domain());
    let mut fair = Fair::new(&plate).energy(bend());
    for corner in [[u0, v0], [u0, v1], [u1, v0], [u1, v1]] {
        fair = fair.ask(position(corner).keep());
    }
    let mut nails = Vec::new();
    for i in 1..12 {
        for j in 1..12 {
            let at = [u0 + (u1 - u0) * f64::from(i) / 12.0, v0 + (v1 - v0) * f64::from(j) / 12.0];
            let height = 1.0 + (0.9 * f64::from(i)).sin() * (0.7 * f64::from(j)).cos();
            nails.push((at, height));
            fair = fair.ask(position(at).axis(Axis::Z).at_least(height));
        }
    }
    let fair = fair.solve().unwrap();
    for &(at, height) in &nails {
        assert!(fair.shape().point(at[0], at[1]).unwrap().z >= height - 1e-12, "{}", fair.report());
    }
    assert!(fair.report().active.len() >= 5, "{}", fair.report());
    for told in &fair.report().constraints[4..] {
        assert!(told.multipliers[0] >= 0.0, "{told:?}");
    }

    let count = 300;
    let space = Space::clamped_uniform(3, count).unwrap();
    let points = (0..count).map(|i| Point::new(space.greville(i), dice.between(-0.3, 0.3), 0.0)).collect();
    let wire = Curve::new(space, points).unwrap();
    let end = wire.domain().1;
    let mut fair = Fair::new(&wire).energy(bend()).ask(position(0.0).keep()).ask(position(end).keep());
    let mut band = Vec::new();
    for k in 1..300 {
        let u = end * f64::from(k) / 300.0;
        let (middle, half) = (wire.point(u).unwrap().y, 0.2);
        band.push((u, middle, half));
        fair = fair.ask(y_at(u).at_least(middle - half)).ask(y_at(u).at_most(middle + half));
    }
    let fair = fair.solve().unwrap();
    for &(u, middle, half) in &band {
        assert!((fair.shape().point(u).unwrap().y - middle).abs() <= half + 1e-12, "{u}: {}", fair.report());
    }
    assert!(fair.report().energy_after < 0.5 * fair.report().energy_before, "{}", fair.report());

    // The longer one has more corners than their motions can be told one by one.
    for spans in [100, 1200] {
        let end = f64::from(spans);
        let mut knots = vec![0.0; 4];
        (1..spans).for_each(|i| knots.extend([f64::from(i); 3]));
        knots.extend([end; 4]);
        let space = Space::open(3, knots).unwrap();
        let points = (0..space.len()).map(|i| Point::new(i as f64, dice.between(-1.0, 1.0), 0.0)).collect();
        let chain = Curve::new(space, points).unwrap();
        let fair = Fair::new(&chain).energy(bend()).ask(position(0.0).keep());
        let fair = fair.ask(position(0.5 * end).by([0.0, 1.0, 0.0])).solve().unwrap();
        let report = fair.report();
        assert!(report.farthest < 3.0 && report.energy_after < 1e-12 * report.energy_before, "{report}");
    }
}

/// Weights that leave too much to integrate: the message says in which span, and what it advises helps.
#[test]
fn weights_that_are_too_unlike_name_their_span() {
    let mut dice = Dice(0x0dd5_9a25_0dd5_9a25);
    let (mut refused, mut helped) = (0, 0);
    for number in 0..120 {
        // Several spans of degree 5, the vertices that only one of them has weigh 64 times as much, or as little.
        let spans = 1 + dice.below(4);
        let bad = dice.below(spans);
        let (mut knots, mut breaks) = (vec![0.0; 6], vec![0.0]);
        for k in 0..spans {
            let next = breaks[k] + dice.between(0.5, 2.0);
            breaks.push(next);
            knots.extend(vec![next; if k + 1 < spans { 5 } else { 6 }]);
        }
        let count = knots.len() - 6;
        let mut weights = vec![1.0; count];
        let heavy = if dice.chance(0.5) { 64.0 } else { 1.0 / 64.0 };
        weights[5 * bad + 2..5 * bad + 2 + 1 + dice.below(2)].fill(heavy);
        let points: Vec<Point> = (0..count)
            .map(|i| Point::new(i as f64, dice.between(-1.0, 1.0), dice.between(-1.0, 1.0)))
            .collect();
        let curve = Curve::build(Space::open(5, knots).unwrap(), points, Some(weights)).unwrap();
        let kept = |curve: &Curve| {
            let fair = Fair::new(curve).energy(bend()).ask(position(0.0).keep());
            fair.ask(position(breaks[spans]).keep()).solve().map(|_| ()).map_err(|e| e.to_string())
        };
        let Err(text) = kept(&curve) else { continue };
        refused += 1;
        let place = format!("between {} and {}", breaks[bad], breaks[bad + 1]);
        assert!(text.contains(&place) && text.contains("refine"), "{number}: not {place}: {text}");
        let inner: Vec<f64> =
            (1..16).map(|k| breaks[bad] + (breaks[bad + 1] - breaks[bad]) * f64::from(k) / 16.0).collect();
        match kept(&curve.insert_knots(&inner).unwrap()) {
            Ok(()) => helped += 1,
            Err(text) => assert!(!text.contains("integrated"), "{number}: refined, and still {text}"),
        }
    }
    println!("{refused} of 120 refused, {helped} solved once refined");
    assert!(refused >= 20 && helped >= refused * 9 / 10, "{refused} refused, {helped} helped");
}

//! At a knot where the curvature may jump it is asked of both sides.

use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::{curvature, derivative, magnitude, position};
use loftsman_kernel::solve::{Adjoint, Automatic, DenseLu, HouseholderQr, Sparse};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

use super::book::{Random, Spline, Turn};

/// How a curve turns before and behind a place: before it, the curve run backwards.
fn both(curve: &Curve, u: f64) -> [Turn; 2] {
    let spline = Spline::of(curve);
    let mut back = spline.clone();
    back.knots.iter_mut().for_each(|k| *k = -*k);
    back.knots.reverse();
    back.points.reverse();
    if let Some(weights) = &mut back.weights {
        weights.reverse();
    }
    [back.turn(-u), spline.turn(u)]
}

struct Member {
    curve: Curve,
    u: f64,
    /// Whether the first derivative may jump, too.
    chain: bool,
}

/// A spline of degree 2 to 6 with a knot repeated `p - 1` or `p` times, smooth there, the curvature equal on both sides or not.
fn member(random: &mut Random) -> Member {
    let p = random.of(&[2, 3, 3, 4, 5, 6]);
    let pieces = 3 + random.below(4);
    let mut knots = vec![0.0; p + 1];
    knots.extend((1..pieces).map(|k| k as f64 + random.between(-0.2, 0.2)));
    knots.extend(vec![pieces as f64; p + 1]);
    let n = knots.len() - p - 1;
    let size = random.of(&[1.0, 1.0, 1e-6, 1e6]);
    let points: Vec<Point> = (0..n)
        .map(|i| {
            let t = i as f64 / n as f64 * 4.5;
            Point::from((Vector::new(3.0 * t.cos(), 2.0 * t.sin(), t.sin()) + random.vector() * 0.1) * size)
        })
        .collect();
    let weights = (random.below(3) == 0).then(|| (0..n).map(|_| random.between(0.5, 2.0)).collect());
    let u = knots[p + 1 + random.below(pieces - 1)];
    let curve = Curve::build(Space::open(p, knots).unwrap(), points, weights).unwrap();
    let chain = random.below(2) == 0 || p == 2;
    let curve = curve.insert_knots(&vec![u; if chain { p - 1 } else { p - 2 }]).unwrap();
    if random.below(2) == 0 || p == 2 {
        return Member { curve, u, chain };
    }
    // The third vertex behind the place has a say in the curvature there, and in nothing of lower order.
    let space = curve.space().clone();
    let behind = space.knots().iter().rposition(|&k| k == u).unwrap() - p + usize::from(chain) + 1;
    let mut points = curve.points().to_vec();
    points[behind] += random.vector() * (0.3 * size);
    let weights = curve.weights().map(<[f64]>::to_vec);
    Member { curve: Curve::build(space, points, weights).unwrap(), u, chain }
}

#[test]
fn both_sides_of_a_knot_have_the_curvature_that_was_asked() {
    let (mut refused, mut jumps, mut both_nonlinear) = (Vec::new(), 0, 0);
    for seed in 0..300 {
        let mut random = Random::new(seed);
        let Member { curve, u, chain } = member(&mut random);
        let size = curve.points().iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
        let before = both(&curve, u);
        let jump = (before[0].vector - before[1].vector).norm() > 1e-6 * before[0].kappa;
        jumps += usize::from(jump);
        let mut edit = Edit::new(&curve);
        // At level 0 nothing but what is asked holds a chain together.
        let smooth = random.of(&[1, 1, 2, 0]);
        edit = edit.smooth(smooth);
        match random.below(4) {
            0 => edit = edit.ask(derivative(u, 1).scale(random.between(0.5, 2.0))),
            1 => edit = edit.ask(magnitude(u).scale(random.between(0.5, 2.0))),
            2 => edit = edit.ask(derivative(u, 1).keep()),
            _ => {}
        }
        if random.below(2) == 0 {
            edit = edit.ask(position(u).by(random.vector() * (0.1 * size)));
        }
        let wanted: [f64; 2];
        (edit, wanted) = match random.below(4) {
            0 | 1 => (edit.ask(curvature(u).keep()), before.map(|b| b.kappa)),
            2 => (edit.ask(curvature(u).scale(1.4)), before.map(|b| 1.4 * b.kappa)),
            _ => (edit.ask(curvature(u).to(before[1].kappa * 0.7)), [0.7 * before[1].kappa; 2]),
        };
        both_nonlinear += usize::from(chain);
        let solved = match seed % 5 {
            0 => edit.solve_with(Automatic),
            1 => edit.solve_with(Sparse),
            2 => edit.solve_with(Adjoint),
            3 => edit.solve_with(HouseholderQr),
            _ => edit.solve_with(DenseLu),
        };
        match solved {
            Ok(edited) => {
                let after = both(edited.shape(), u);
                for side in 0..2 {
                    let missed = (after[side].kappa / wanted[side] - 1.0).abs();
                    let what =
                        format!("seed {seed}, smooth {smooth}, chain {chain}, jump {jump}, side {side}");
                    assert!(missed < 1e-8, "{what}: {missed:e}; {}", edited.report());
                }
            }
            Err(error) if error.to_string().contains("too many for the solver \"adjoint\"") => {}
            Err(error) => refused.push(format!("seed {seed}, {smooth}, {chain}, {jump}: {error}")),
        }
    }
    assert!(jumps > 60 && both_nonlinear > 100, "{jumps} jumps, {both_nonlinear} chains");
    assert!(refused.len() <= 9, "{} refused\n{}", refused.len(), refused.join("\n"));
}

#[test]
fn at_a_corner_the_side_behind_it_is_asked_and_that_is_told() {
    let space = Space::open(2, vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 2.0]).unwrap();
    let points = [(0.0, 0.0), (1.0, 1.0), (2.0, 0.0), (3.0, 1.0), (4.0, -1.0)];
    let points = points.map(|(x, y)| Point::new(x, y, 0.0)).to_vec();
    let curve = Curve::new(space, points).unwrap();
    let edited = Edit::new(&curve).ask(curvature(1.0).scale(1.5)).solve().unwrap();
    let (before, after) = (both(&curve, 1.0), both(edited.shape(), 1.0));
    assert!((after[1].kappa / before[1].kappa - 1.5).abs() < 1e-12);
    let told = edited.report().notes.iter().any(|note| note.contains("has a corner there"));
    assert!(told, "{}", edited.report());
}

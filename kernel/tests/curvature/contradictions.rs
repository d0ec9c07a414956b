//! What contradicts a curvature: refused by every solver, naming what is in it, and nothing moves.

use loftsman_kernel::edit::{Ask, Constraint, Edit};
use loftsman_kernel::functional::{curvature, derivative, magnitude, position, tangent, vertex};
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::solve::{Adjoint, Automatic, DenseLu, HouseholderQr, Sparse};
use loftsman_kernel::spline::Curve;

use super::book::{Random, Spline, any_place, any_spline};

/// What cannot be, in how many ways.
const WAYS: usize = 6;

struct Member {
    curve: Curve,
    ask: Vec<Constraint>,
    lock: Vec<i64>,
    /// Constraints of which the message must name one at least, each: those that contradict.
    names: Vec<String>,
    /// Fit, and no part of it.
    innocent: Option<Constraint>,
}

/// A bent place, of some curve.
fn bent(random: &mut Random) -> (Spline, f64) {
    loop {
        let spline = any_spline(random);
        let u = any_place(&spline, random);
        let [_, first, _] = spline.jet(u);
        // Not bent to speak of: whatever is asked of its κ, a factor of nothing is nothing.
        if spline.turn(u).kappa * first.norm() > 1e-3 && spline.noise(u) < 1e-7 * spline.turn(u).kappa {
            return (spline, u);
        }
    }
}

fn member(seed: u64) -> Member {
    let mut random = Random::new(40_000 + seed);
    let (before, u) = bent(&mut random);
    let curve = before.curve();
    let count = before.points.len() as i64;
    let kappa = before.turn(u).kappa;
    let (mut ask, mut lock, mut names) = (Vec::new(), Vec::new(), Vec::new());
    let other = |random: &mut Random| match random.below(4) {
        0 => curvature(u).scale(random.of(&[0.3, 0.5, 2.0, 5.0])),
        1 => curvature(u).to(random.of(&[0.0, 0.25, 3.0]) * kappa),
        2 => curvature(u).by(random.of(&[-0.5, 0.7, 2.0]) * kappa),
        _ => curvature(u).to([0.0, random.of(&[-0.6, 1.3]) * kappa]),
    };
    let way = seed as usize % WAYS;
    match way {
        // Twice, with unlike values, the first derivative standing still or not.
        0 | 1 => {
            let beside = if way == 0 { 0 } else { 1 + random.below(3) };
            match beside {
                1 => ask.push(magnitude(u).scale(random.between(0.6, 1.8))),
                2 => ask.push(derivative(u, 1).scale(random.between(0.6, 1.8))),
                3 => ask.push(tangent(u).keep()),
                _ => {}
            }
            ask.push(curvature(u).keep());
            ask.push(other(&mut random));
            names.push("curvature at".to_owned());
        }
        // Beside three derivatives that fix another.
        2 => {
            ask.push(derivative(u, 1).keep());
            ask.push(derivative(u, 2).keep());
            if random.below(2) == 0 {
                ask.push(position(u).keep());
            }
            ask.push(other(&mut random));
            names.push("curvature at".to_owned());
        }
        // Nothing may move.
        3 => {
            lock.extend(0..count);
            ask.push(other(&mut random));
            names.push("curvature at".to_owned());
        }
        // Only what does not reach it may move.
        _ => {
            let touched = |i: i64| {
                [0, 1, 2].iter().any(|&d| {
                    let stencil = curve.stencil(Location::Curve(u), Derivative { u: d, v: 0 }).unwrap();
                    stencil.iter().any(|(v, c)| v as i64 == i && c != 0.0)
                })
            };
            let reaching: Vec<i64> = (0..count).filter(|&i| touched(i)).collect();
            if way == 4 {
                lock.extend(reaching);
            } else {
                ask.extend(reaching.iter().map(|&i| vertex(i).keep()));
            }
            ask.push(other(&mut random));
            names.push("curvature at".to_owned());
        }
    }
    let elsewhere = {
        let (a, b) = before.domain();
        // As far away as there is.
        if (u - a).abs() > (b - u).abs() { a } else { b }
    };
    let innocent =
        (seed.is_multiple_of(2) && way != 3 && !before.periodic).then(|| position(elsewhere).keep());
    Member { curve, ask, lock, names, innocent }
}

#[test]
fn what_contradicts_a_curvature_is_refused_and_named_by_every_solver() {
    const MEMBERS: u64 = 180;
    let mut refused = [0; WAYS];
    let (mut too_many, mut wrong) = (0, Vec::new());
    for seed in 0..MEMBERS {
        let member = member(seed);
        for solver in 0..5 {
            let mut edit = Edit::new(&member.curve).lock(member.lock.iter().copied());
            for constraint in member.ask.iter().chain(&member.innocent) {
                edit = edit.ask(constraint.clone());
            }
            let done = match solver {
                0 => edit.solve_with(Automatic),
                1 => edit.solve_with(Sparse),
                2 => edit.solve_with(Adjoint),
                3 => edit.solve_with(HouseholderQr),
                _ => edit.solve_with(DenseLu),
            };
            let name = format!(
                "seed {seed}, way {}, solver {solver}, degree {}",
                seed as usize % WAYS,
                member.curve.degree()
            );
            match done {
                Ok(edited) => wrong.push(format!("{name}: accepted: {}", edited.report())),
                Err(error) => {
                    let text = error.to_string();
                    if text.contains("too many for the solver \"adjoint\"") {
                        too_many += 1;
                        continue;
                    }
                    refused[seed as usize % WAYS] += 1;
                    if !member.names.iter().all(|part| text.contains(&format!("\"{part}"))) {
                        wrong.push(format!("{name}: unnamed: {text}"));
                    }
                    let blamed = member.innocent.as_ref().map(Constraint::label);
                    if blamed.is_some_and(|label| text.contains(&format!("\"{label}\""))) {
                        wrong.push(format!("{name}: blames what fits: {text}"));
                    }
                }
            }
        }
    }
    println!("refused {refused:?} of {MEMBERS} members by five solvers; {too_many} too many for adjoint");
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
    assert!(refused.iter().all(|&n| n >= 60), "{refused:?}");
}

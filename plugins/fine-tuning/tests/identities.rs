//! What holds whatever α is: tangents keep their directions. To ask for it changes nothing, and to ask for something else is refused.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail the test")]

use loftsman_fine_tuning::FineTune;
use loftsman_kernel::edit::Ask;
use loftsman_kernel::functional::{orthogonal, tangent};
use loftsman_kernel::spline::Curve;
use loftsman_kernel::spline::algebra::Function;
use loftsman_kernel::{Point, Vector};

use crate::curves::{Lcg, any_alpha, any_curve, size};

/// The same curve in a plane that lies askew.
fn flattened(curve: &Curve) -> Curve {
    let [x, y] = [Vector::new(0.48, 0.6, 0.64), Vector::new(0.8, 0.0, -0.6)];
    let flat = |p: &Point| Point::new(3.0, -1.0, 7.0) + x * p.x + y * p.y;
    Curve::new(curve.space().clone(), curve.points().iter().map(flat).collect()).unwrap()
}

fn furthest(one: &Curve, other: &Curve) -> f64 {
    let (a, b) = one.domain();
    let at = (0..=60).map(|k| a + (b - a) * f64::from(k) / 60.0);
    at.map(|t| (one.point(t).unwrap() - other.point(t).unwrap()).norm()).fold(0.0, f64::max)
}

/// Curves of all kinds, in space and in planes, with α = 1 and with another: a tangent that is kept, or given as it is, and a direction that is square to it.
/// The tuned curve is that without these; nothing is refused that is not without them.
#[test]
fn tangents_that_are_as_they_are_change_nothing() {
    let (mut met, mut refused) = (0, 0);
    for seed in 0..120_u64 {
        let mut random = Lcg(seed * 13 + 1);
        let given = if seed % 2 == 0 { any_curve(seed) } else { flattened(&any_curve(seed)) };
        let alpha = if seed % 3 == 0 {
            Function::constant(given.space().clone(), 1.0).unwrap()
        } else {
            any_alpha(&given, seed)
        };
        let Ok(plain) = FineTune::new(&given, alpha.clone()).solve() else { continue };
        let breaks = given.space().breakpoints();
        let k = random.below(breaks.len() - 1);
        let at = breaks[k] + (breaks[k + 1] - breaks[k]) * (0.1 + 0.8 * random.next());
        let direction = given.derivative(at, 1).unwrap();
        if direction.norm() < 1e-3 * size(&given) {
            continue;
        }
        let across = direction.cross(&Vector::new(0.3, -0.7, 0.2));
        let asked = [
            tangent(at).keep(),
            tangent(at).direction(direction * 2.5).hold(),
            orthogonal(at, across).hold(),
        ];
        for (which, constraint) in asked.into_iter().enumerate() {
            let tuned = FineTune::new(&given, alpha.clone()).ask(constraint).solve();
            let Ok(tuned) = tuned else {
                println!("{seed} {which}: {}", tuned.unwrap_err());
                refused += 1;
                continue;
            };
            let off = furthest(plain.curve(), tuned.curve());
            assert!(off < 1e-9 * size(&given), "{seed} {which}: {off:e} of {}", size(&given));
            let is_said = |note: &String| note.contains("holds whatever alpha is");
            let solved = tuned.report().solved.as_ref().unwrap();
            assert!(solved.notes.iter().any(is_said), "{seed} {which}: {:?}", solved.notes);
            met += 1;
        }
        // Anything else is out of reach, but of a straight curve that has it.
        let other = tangent(at).direction(direction + across * 0.5).hold();
        let found = FineTune::new(&given, alpha).ask(other).solve();
        let error = found.err().map(|error| error.to_string());
        let is_said =
            |said: &String| said.contains("asks for another one") || said.contains("no alpha changes this");
        assert!(error.as_ref().is_some_and(is_said), "{seed}: degree {}, {error:?}", given.degree());
    }
    assert!(met >= 240 && refused == 0, "{met} met, {refused} refused");
}

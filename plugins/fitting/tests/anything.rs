//! Whatever comes in: an answer that holds, or an error. Never a panic, never nonsense.

use loftsman_fitting::{Duplicates, Ends, Fit, GridFit, Interpolation, Parametrization, Target};
use loftsman_kernel::Point;
use proptest::prelude::*;

/// Coordinates that coincide often, jump, vanish, and now and then are huge or no numbers at all.
fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => (-3_i32..4).prop_map(f64::from),
        8 => -1.0_f64..1.0,
        1 => Just(1e-300),
        1 => Just(1e300),
        1 => Just(-1.7e308),
        1 => Just(f64::MIN_POSITIVE / 1024.0),
    ]
}

fn points() -> impl Strategy<Value = Vec<Point>> {
    let point = (coordinate(), coordinate(), Just(0.0)).prop_map(|(x, y, z)| Point::new(x, y, z));
    let tame = ((-3_i32..4), (-3_i32..4)).prop_map(|(x, y)| Point::new(f64::from(x), f64::from(y), 0.0));
    prop_oneof![proptest::collection::vec(point, 0..40), proptest::collection::vec(tame, 0..40)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    #[test]
    fn fits_hold_what_they_say(
        points in points(),
        degree in 0_usize..28,
        closed in any::<bool>(),
        way in 0_u8..4,
        smooth in any::<bool>(),
        corrections in 0_usize..3,
        best_effort in any::<bool>(),
    ) {
        let target = match way {
            0 => Target::Relative(1e-2),
            1 => Target::Tolerance(1e-3),
            2 => Target::Vertices(points.len() / 2 + 1),
            _ => Target::AtMost { tolerance: 0.1, vertices: degree + 4 },
        };
        let fit = Fit { closed, smooth, corrections, best_effort, ..Fit::new(degree, target) };
        if let Ok(fitted) = fit.curve(&points) {
            prop_assert!(fitted.curve.points().iter().all(|p| p.iter().all(|c| c.is_finite())));
            prop_assert!(fitted.met || best_effort);
            if let (true, Some(tolerance)) = (fitted.met, fitted.tolerance) {
                prop_assert!(fitted.max_error <= tolerance * (1.0 + 1e-9));
            }
            if let Target::Vertices(n) = target {
                prop_assert_eq!(fitted.curve.points().len(), n);
            }
            prop_assert!(fitted.parameters.windows(2).all(|w| w[0] <= w[1]));
        }
    }

    #[test]
    fn interpolations_interpolate(
        points in points(),
        degree in 0_usize..28,
        closed in any::<bool>(),
        ends in 0_u8..3,
        centripetal in any::<bool>(),
    ) {
        let through = Interpolation {
            degree,
            closed,
            parameters: if centripetal { Parametrization::Centripetal } else { Parametrization::ChordLength },
            ends: match ends { 0 => Ends::Averaged, 1 => Ends::NotAKnot, _ => Ends::Natural },
            duplicates: Duplicates::Merge,
        };
        if let Ok(through) = through.curve(&points) {
            let size = points.iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
            let kept = points.iter().enumerate().filter(|(i, _)| !through.merged.contains(i));
            for (u, (_, point)) in through.parameters.iter().zip(kept) {
                let off = through.curve.point(*u).map(|p| (p / size - point / size).amax());
                prop_assert!(off.is_ok_and(|d| d < 1e-8));
            }
        }
    }

    #[test]
    fn grids_answer(points in points(), columns in 0_usize..7, degree in 0_usize..5, closed in any::<bool>()) {
        let fit = GridFit { closed: [closed, false], ..GridFit::new([degree, 2]) };
        if let Ok(through) = fit.surface(columns, &points) {
            prop_assert!(through.max_error.is_finite());
        }
    }
}

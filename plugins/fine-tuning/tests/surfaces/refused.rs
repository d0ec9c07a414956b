//! What cannot be is refused in words.

use loftsman_fine_tuning::{Ends, FineTuneError, FineTuneSurface, Scaling, TunedSurface, surface_alpha_of};
use loftsman_kernel::spline::Direction::{U, V};
use loftsman_kernel::spline::algebra::Function;
use loftsman_kernel::spline::{Space, Surface};

use super::family::*;

#[test]
fn what_cannot_be_is_refused_in_words() {
    let mut random = Lcg::new(7);
    let (u, v) = (Space::clamped_uniform(3, 7).unwrap(), Space::clamped_uniform(2, 6).unwrap());
    let surface = shaped(u.clone(), v.clone(), &mut random);
    let text = |result: Result<TunedSurface, FineTuneError>| result.unwrap_err().to_string();
    let error = surface_alpha_of(&surface, vec![1.0; 31]).unwrap_err().to_string();
    assert!(error.contains("31 values and needs 6 × 5"), "{error}");
    let line = any_line(&surface, U, &mut random);
    let mut values = vec![1.0; 30];
    values[13] = -0.5;
    let negative = surface_alpha_of(&surface, values).unwrap();
    let error = text(FineTuneSurface::new(&surface, Scaling::along(U, negative.clone())).solve());
    assert!(error.contains("α is -0.125 at (1.5, 3) (value [2, 3])"), "{error}");
    let allowed = FineTuneSurface::new(&surface, Scaling::along(U, negative)).any_sign().ends(Ends::Free);
    assert!(allowed.solve().is_ok());
    let rational = Surface::rational(
        u.clone(),
        v.clone(),
        surface.points().to_vec(),
        (0..42).map(|k| 1.0 + f64::from(k % 3)).collect(),
    )
    .unwrap();
    let error = text(FineTuneSurface::new(&rational, Scaling::u(line.clone())).solve());
    assert!(error.contains("rational surface"), "{error}");
    let far = Function::constant(Space::clamped(2, &[0.0, 1.0]).unwrap(), 2.0).unwrap();
    let error = text(FineTuneSurface::new(&surface, Scaling::u(far)).solve());
    assert!(error.contains("over u in [0, 1]"), "{error}");
    let smooth = any_net(&surface, [4, 4], [2, 2], &mut random);
    let out = "reaches out of the domain, which is [0, 4]";
    for (a, b, what) in [
        (3.0, 2.0, "is reversed"),
        (-1.0, 2.0, out),
        (2.0, 99.0, out),
        (f64::NAN, 2.0, "two numbers"),
        (2.0, 2.0, "is empty"),
    ] {
        let tuning = FineTuneSurface::new(&surface, Scaling::along(U, smooth.clone())).between(V, a, b);
        let error = text(tuning.solve());
        assert!(error.contains(what), "{error}");
    }
    let error = text(FineTuneSurface::new(&surface, Scaling::u(line.clone())).between(V, 1.0, 3.0).solve());
    assert!(error.contains("moves the sides"), "{error}");
    let tuning = FineTuneSurface::new(&surface, Scaling::along(U, smooth)).between(U, 1.0, 3.0);
    let error = text(tuning.clone().ends(Ends::Free).solve());
    assert!(error.contains("torn off"), "{error}");
    let error = text(tuning.between(V, 1.0, 3.0).ends(Ends::Position).solve());
    assert!(error.contains("similarity"), "{error}");
    let jumps = any_net(&surface, [4, 4], [2, 0], &mut random);
    let error = text(FineTuneSurface::new(&surface, Scaling::along(U, jumps)).ends(Ends::Free).solve());
    assert!(error.contains("α jumps at v = 1"), "{error}");
    let high = any_net(&surface, [1, 1], [23, 1], &mut random);
    let error = text(FineTuneSurface::new(&surface, Scaling::along(U, high)).ends(Ends::Free).solve());
    assert!(error.contains("degree 26"), "{error}");
    let high = any_net(&surface, [1, 1], [1, 24], &mut random);
    let error = text(FineTuneSurface::new(&surface, Scaling::along(U, high)).ends(Ends::Free).solve());
    assert!(error.contains("26"), "{error}");
    // Two rows of three and nothing between.
    let small = surface_alpha_of(&surface, vec![1.5; 30]).unwrap();
    let tuning = FineTuneSurface::new(&surface, Scaling::both(small)).between(U, 0.1, 0.2).continuity(2);
    let error = text(tuning.solve());
    assert!(error.contains("none would be free"), "{error}");
    let ring = shaped(Space::periodic_uniform(3, 7).unwrap(), v, &mut random);
    let error = text(
        FineTuneSurface::new(&ring, Scaling::u(any_line(&ring, U, &mut random))).ends(Ends::Position).solve(),
    );
    assert!(error.contains("are one point"), "{error}");
}

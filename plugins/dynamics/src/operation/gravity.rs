//! Which way things fall, and how fast: in the coordinates in which they move.

use loftsman_kernel::Vector;
use loftsman_kernel::plugin::{Frames, OperationError, Parameters};
use loftsman_kernel::scene::{Scene, Up};
use loftsman_kernel::text::figure;
use nalgebra::Matrix3;

use crate::error::direction;

/// What falls, falls faster by so much every second: in metres.
const FALL: f64 = 9.81;

/// Gravity, and what a unit of mass weighs: what is given, in the coordinates in which the objects `names` are `seen` to move; else the scene's, 9.81 m/s² down, brought
/// there. Where all of them are placed alike by the linear map `L` and a shift they move in their own coordinates: by `L⁻¹ g`, so that `x ↦ L x + t` of what falls is
/// what falls in the scene.
pub(super) fn gravity(
    scene: &Scene,
    parameters: &Parameters,
    (names, seen): (&[String], &Frames),
    notes: &mut Vec<String>,
) -> Result<(Vector, f64), OperationError> {
    let metres = scene.unit.metres();
    let fall = FALL / metres.unwrap_or(1.0);
    let down = -fall
        * match scene.up {
            Up::X => Vector::x(),
            Up::Y => Vector::y(),
            Up::Z => Vector::z(),
        };
    let linear = seen.to_world().map(|place| place.fixed_view::<3, 3>(0, 0).into_owned());
    let linear = linear.filter(|linear| *linear != Matrix3::identity());
    let own = match linear {
        None => Some(down),
        // One factor after another would lose a map that is far from length 1, as of kilometres in millimetres.
        Some(linear) => {
            linear.lu().solve(&down).filter(|own| own.iter().all(|v| v.is_finite()) && own.norm() > 0.0)
        }
    };
    if let (Some(_), Some(name)) = (linear, names.first())
        && scene.standing(name)?.scale().is_none()
    {
        notes.push(
            "the placement stretches some directions more than others: what moves is the shape that the object is in its own coordinates, with the lengths and angles that it has there".into(),
        );
    }
    if parameters.has("gravity") {
        let given = parameters.vector("gravity")?;
        let fall = own.map_or(fall, |own| own.norm());
        return Ok((given, if given.norm() > 0.0 { given.norm() } else { fall }));
    }
    let Some(own) = own else {
        let problem = "the object is placed by a transform that flattens it, so that nothing in its own coordinates is down in the scene: give `gravity` in its own coordinates, \
                       or correct its transform";
        return Err(parameters.error("gravity", problem).into());
    };
    if metres.is_none() {
        notes.push(
            "the unit of lengths is unknown: gravity is 9.81 of them per s², as if they were metres".into(),
        );
    }
    if linear.is_some() {
        notes.push(format!(
            "gravity is the scene's, 9.81 {} down as the object is placed there: {} per s² along {} in its own coordinates",
            if metres.is_some() { "m/s²" } else { "lengths per s²" },
            figure(own.norm()),
            direction(&own.normalize())
        ));
    }
    Ok((own, own.norm()))
}

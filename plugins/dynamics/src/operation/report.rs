//! What a simulation tells of itself.

use loftsman_kernel::Point;
use loftsman_kernel::plugin::{
    ConstraintReport, Frames, Mark, MarkKind, OperationError, Spot as MarkSpot, StepReport,
};
use loftsman_kernel::shape::{Derivative, Location, Shape};

use crate::simulation::{Settled, Simulation};

pub(super) fn report(
    object: &str,
    simulation: &mut Simulation,
    settled: Option<Settled>,
    (before, stretch): (f64, f64),
    scheme: &str,
) -> Result<StepReport, OperationError> {
    let errors = simulation.errors()?;
    let (equations, rank) = simulation.equations();
    let after = simulation.energy();
    let mut notes = Vec::new();
    if simulation.sub_steps() > 0 {
        let stable = simulation.stable_step();
        let length = simulation.time() / simulation.sub_steps() as f64;
        notes.push(match scheme {
            "implicit" => format!(
                "{} steps of {length:.3e} s (halved where they had to be), scheme implicit (explicit ones would be stable to {stable:.3e} s)",
                simulation.sub_steps()
            ),
            _ => format!(
                "{} steps of {length:.3e} s on average, scheme {scheme} (stable to {stable:.3e} s)",
                simulation.sub_steps()
            ),
        });
        notes.push(format!(
            "energy at the end: motion {:.4e}, elastic {:.4e}, gravity {:.4e}, pulls {:.4e}",
            after.kinetic, after.elastic, after.gravity, after.pulls
        ));
        notes.push(format!("constraints drifted by {:.2e} at most", simulation.worst_error()));
    }
    let way = |stretch: f64| if stretch < 0.0 { "compressed" } else { "stretched" };
    let end = simulation.stretch(0)?;
    let told = format!("at the end it is {} by {:.2} %", way(end), 100.0 * end.abs());
    let most = if stretch.abs() > end.abs() { stretch } else { end };
    notes.push(match simulation.sub_steps() {
        0 => told,
        _ => format!("{told}, in any frame {} by {:.2} % at most", way(most), 100.0 * most.abs()),
    });
    if let Some(Settled { residual, steps, rests, .. }) = settled {
        notes.push(if rests {
            format!("it rests: {residual:.1e} of the forces is left, after {steps} steps")
        } else {
            format!(
                "it does not rest yet: {residual:.1e} of the forces is left, after {steps} steps; let it move before (`seconds`, with some \
                 `damping`), or hold it at more places"
            )
        });
    }
    notes.extend(
        simulation.events().iter().map(|e| format!("{} s: \"{}\": {}", round(e.time), e.name, e.what)),
    );
    let mut constraints = Vec::with_capacity(errors.len());
    for (index, residual) in errors.iter().enumerate() {
        // Of two places both, one behind the other.
        let places = simulation.locations(index)?.into_iter().flat_map(|at| match at {
            Location::Curve(u) => vec![u],
            Location::Surface(u, v) | Location::Face(_, u, v) => vec![u, v],
            Location::Vertex(_) => Vec::new(),
        });
        let location = Some(places.collect::<Vec<_>>()).filter(|all| !all.is_empty());
        constraints.push(ConstraintReport {
            name: simulation.name_of(index)?.into(),
            residual: *residual,
            location: location.filter(|_| simulation.holds(index).unwrap_or(false)),
            multipliers: simulation.force_of(index)?.to_vec(),
            ..ConstraintReport::default()
        });
    }
    Ok(StepReport {
        op: "simulate".into(),
        object: Some(object.into()),
        equations: Some(equations),
        rank: Some(rank),
        residual: Some(errors.iter().copied().fold(0.0, f64::max)),
        energy: Some([before, after.total()]),
        iterations: Some(simulation.sub_steps() + settled.map_or(0, |s| s.steps)),
        constraints,
        notes,
        ..StepReport::default()
    })
}

fn round(time: f64) -> f64 {
    (time * 1000.0).round() / 1000.0
}

/// Where things are held, for pictures.
pub(super) fn marks(
    simulation: &Simulation,
    names: &[String],
    seen: &Frames,
    first: &[Box<dyn Shape>],
) -> Result<Vec<Mark>, OperationError> {
    let mut all = Vec::new();
    for index in 0..simulation.constraints() {
        if !simulation.holds(index)? {
            continue;
        }
        for (body, at) in simulation.places(index)? {
            let shape = seen.own_shape(body, simulation.shape(body)?);
            let before = seen.own_shape(body, first[body].as_ref());
            let point = |shape: &dyn Shape| shape.value(at, Derivative::POSITION).map(Point::from);
            all.push(Mark {
                object: names[body].clone(),
                kind: MarkKind::Kept,
                position: point(shape.as_ref())?,
                before: point(before.as_ref())?,
                vector: None,
                label: simulation.name_of(index)?.to_owned(),
                spot: Some(MarkSpot::At(at)),
            });
        }
    }
    Ok(all)
}

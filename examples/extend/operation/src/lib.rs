//! An operation of one's own: the control vertices are moved onto a grid.

use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, Parameters, Plugin, Registry, StepReport,
};
use loftsman_kernel::scene::Scene;
use loftsman_kernel::shape::Shape;

/// Rounds a curve's control vertices to multiples of `step`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Snap;

impl Operation for Snap {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            Field::required("object", "text", "the curve"),
            Field::optional("step", "length", "1", "the spacing of the grid"),
        ];
        Declaration { name: "snap", help: "move control vertices onto a grid", fields: FIELDS }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        _: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        let (name, step) = (p.text("object")?, p.number_or("step", 1.0)?);
        if step <= 0.0 {
            return Err(p.error("step", format!("{step} is not a spacing: give more than 0")).into());
        }
        let mut curve = scene.curve(name).map_err(|e| p.error("object", e.to_string()))?.clone();
        let mut moved = 0.0_f64;
        for vertex in curve.control_vertices_mut() {
            let snapped = vertex.map(|c| (c / step).round() * step);
            if snapped.iter().all(|c| c.is_finite()) {
                moved = moved.hypot((snapped - *vertex).norm());
                *vertex = snapped;
            }
        }
        scene.replace(name, curve)?;
        Ok(StepReport {
            op: "snap".into(),
            object: Some(name.into()),
            adjustment: Some(moved),
            ..StepReport::default()
        })
    }
}

impl Plugin for Snap {
    fn register(&self, registry: &mut Registry) {
        registry.operation(*self);
    }
}

//! Operations on objects as such: `delete`, `rename`.

use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, Parameters, StepReport,
};
use loftsman_kernel::scene::Scene;

const OBJECT: Field = Field::required("object", "text", "the object");

/// The operation `delete`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Delete;

impl Operation for Delete {
    fn declaration(&self) -> Declaration {
        Declaration { name: "delete", help: "take an object out of the scene", fields: &[OBJECT] }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        _: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        let name = p.text("object")?;
        scene.remove(name).map_err(|e| p.error("object", e.to_string()))?;
        Ok(StepReport { op: "delete".into(), object: Some(name.into()), ..StepReport::default() })
    }
}

/// The operation `rename`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Rename;

impl Operation for Rename {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[OBJECT, Field::required("to", "text", "its new name")];
        Declaration { name: "rename", help: "give an object another name", fields: FIELDS }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        _: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        let (name, to) = (p.text("object")?, p.text("to")?);
        scene.object(name).map_err(|e| p.error("object", e.to_string()))?;
        scene.rename(name, to).map_err(|e| p.error("to", e.to_string()))?;
        Ok(StepReport { op: "rename".into(), object: Some(to.into()), ..StepReport::default() })
    }
}

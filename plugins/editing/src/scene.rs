//! Operations on objects as such: `copy`, `delete`, `rename`.

use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, ParameterError, Parameters, StepReport,
};
use loftsman_kernel::scene::Scene;

const OBJECT: Field = Field::required("object", "text", "the object");

/// The operation `copy`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Duplicate;

impl Operation for Duplicate {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            OBJECT,
            Field::required(
                "to",
                "name or [name, …]",
                "the names of the copies; what hangs under it stays with it",
            ),
        ];
        Declaration { name: "copy", help: "the same object again, under other names", fields: FIELDS }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        _: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        let name = p.text("object")?;
        let original = scene.object(name).map_err(|e| p.error("object", e.to_string()))?.clone();
        let copies: Vec<(String, String)> = match p.value("to") {
            Some(serde_json::Value::Array(list)) => list
                .iter()
                .enumerate()
                .map(|(i, to)| {
                    let place = format!("to[{i}]");
                    let to = to.as_str().ok_or_else(|| p.error(&place, "a name is needed here"))?;
                    Ok((place, to.to_owned()))
                })
                .collect::<Result<_, ParameterError>>()?,
            _ => vec![("to".to_owned(), p.text("to")?.to_owned())],
        };
        let mut with_copies = scene.clone();
        for (place, to) in copies {
            with_copies.add(original.renamed(to)).map_err(|e| p.error(&place, e.to_string()))?;
        }
        *scene = with_copies;
        Ok(StepReport { op: "copy".into(), object: Some(name.into()), ..StepReport::default() })
    }
}

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

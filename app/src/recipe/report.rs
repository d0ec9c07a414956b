//! What a run did, as a value.

use loftsman_kernel::plugin::{ReadReport, StepReport, Written};
use loftsman_kernel::scene::Unit;

/// What a recipe's run read, did and wrote.
#[derive(Debug, Clone, Default, serde::Serialize)]
pub struct RunReport {
    /// The unit of all lengths in the report.
    pub unit: Unit,
    /// What was read; `None` where the recipe has no input.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub input: Option<InputReport>,
    /// The inputs after the first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub more_inputs: Vec<InputReport>,
    /// Each step.
    pub steps: Vec<StepReport>,
    /// Each output.
    pub outputs: Vec<OutputReport>,
}

/// A file that was read.
#[derive(Debug, Clone, serde::Serialize)]
pub struct InputReport {
    /// The file.
    pub path: String,
    /// Its format.
    pub format: &'static str,
    /// What was kept and what was left out.
    pub report: ReadReport,
    /// What had to change where it joined the inputs before it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
}

/// A file that was written.
#[derive(Debug, Clone, Default, serde::Serialize)]
pub struct OutputReport {
    /// The file.
    pub path: String,
    /// Its size, without its siblings'.
    pub bytes: u64,
    /// Files that came along (`.mtl`, `.bin`).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub siblings: Vec<crate::file::Produced>,
    /// Of a sequence, the file of each frame; its path is the pattern then, and its size that of all.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub frames: Vec<crate::file::Produced>,
    /// How each object went out; empty for a picture.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub objects: Vec<Written>,
    /// Anything else worth saying.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
}

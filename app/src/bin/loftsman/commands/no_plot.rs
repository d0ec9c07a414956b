//! `plot`, in a program without pictures.

use std::process::ExitCode;

use crate::Usage;
use crate::args::PlotArgs;

pub(crate) fn run(_: &PlotArgs) -> anyhow::Result<ExitCode> {
    Err(Usage(format!("plot: {}", loftsman::picture::ABSENT)).into())
}

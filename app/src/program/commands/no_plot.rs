//! `plot`, in a program without pictures.

use std::process::ExitCode;

use loftsman_kernel::plugin::Registry;

use crate::program::Usage;
use crate::program::args::PlotArgs;

pub(crate) fn run(_: &PlotArgs, _: &Registry) -> anyhow::Result<ExitCode> {
    Err(Usage(format!("plot: {}", crate::picture::ABSENT)).into())
}

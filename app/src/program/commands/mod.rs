//! What each command does. Every one returns the exit status, or why it could not.

pub(crate) mod compare;
pub(crate) mod completions;
pub(crate) mod convert;
mod convert_many;
pub(crate) mod fit;
pub(crate) mod info;
mod measures;
#[cfg_attr(not(feature = "picture"), path = "no_plot.rs")]
pub(crate) mod plot;
pub(crate) mod plugins;
mod report;
pub(crate) mod run;

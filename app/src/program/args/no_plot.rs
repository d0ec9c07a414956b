//! What `plot` takes in a program without pictures: anything, to say that there are none.

use std::ffi::OsString;

#[derive(Debug, clap::Args)]
pub(crate) struct PlotArgs {
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    _anything: Vec<OsString>,
}

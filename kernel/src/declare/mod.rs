//! What is declared by name, and the fields that recipes and documents give it.

mod declaration;
mod parameters;

pub use declaration::{Declaration, Field, Table, hint, nearest};
pub use parameters::{ParameterError, Parameters};

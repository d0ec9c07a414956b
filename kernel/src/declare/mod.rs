//! What can be named in a recipe says what it is called and which fields it takes; and the fields of a recipe, read with their
//! places.

mod declaration;
mod parameters;

pub use declaration::{Declaration, Field, nearest};
pub use parameters::{ParameterError, Parameters};

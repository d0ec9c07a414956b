//! Steps that cannot be done, in words.

use loftsman_kernel::plugin::{OperationError, Parameters};
use loftsman_kernel::scene::{Geometry, Object, Scene};

use super::Recipe;
use crate::error::Error;
use crate::recipe_error::RecipeError;

/// What is wrong with a step, with its place in the recipe.
pub(super) fn step_error(
    recipe: &Recipe,
    number: usize,
    op: &str,
    parameters: &Parameters,
    error: OperationError,
) -> Error {
    let mut located = match &error {
        OperationError::Parameter(e) => RecipeError::at(&recipe.name, &e.path, &e.problem),
        other => {
            let problem = other.to_string();
            // What begins with the object's name needs no second one.
            let named = |object: &&str| problem.starts_with(&format!("\"{object}\": "));
            let object = parameters.text("object").ok().filter(|object| !named(object));
            let object = object.map(|object| format!(" of \"{object}\"")).unwrap_or_default();
            RecipeError::at(&recipe.name, format!("step[{number}]"), format!("{op}{object}: {problem}"))
        }
    };
    located.cause = Some(error);
    recipe.text.locate(located).into()
}

/// The same error with a way out where an operation does not take a plug-in's shape of which another one makes splines.
pub(super) fn advised(error: Error, scene: &Scene, parameters: &Parameters) -> Error {
    let Ok(name) = parameters.text("object") else { return error };
    let made = match scene.get(name).map(Object::geometry) {
        Some(Geometry::Custom(custom)) => custom.made_splines_by(),
        _ => None,
    };
    match (made, error) {
        (Some(operation), Error::Recipe(mut located))
            if located.problem.contains(&format!("\"{name}\" is a")) =>
        {
            located.problem.push_str(&format!("; {operation} makes splines of it, tessellate a mesh"));
            Error::Recipe(located)
        }
        (_, error) => error,
    }
}

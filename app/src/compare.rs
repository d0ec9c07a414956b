//! The same recipe with every solver: do they agree, and how long do they take?

use loftsman_kernel::plugin::{Clock, Observer, Registry, StepReport};
use loftsman_kernel::scene::Scene;

use crate::error::Result;
use crate::recipe::{Applied, Recipe, Runner};

/// What every solver made of a recipe.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Comparison {
    /// Each solver.
    pub solvers: Vec<Trial>,
    /// The largest distance between a control vertex of one solver's scene and the same of another's, divided by
    /// the scene's size; `None` where fewer than two succeeded.
    pub agreement: Option<f64>,
}

/// What one solver made of a recipe.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Trial {
    /// The solver.
    pub solver: String,
    /// Why it could not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// Each step; those that take no solver are the same for all.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub steps: Vec<StepReport>,
    /// The largest distance of a control vertex from the first successful solver's, divided by the scene's size.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub difference: Option<f64>,
    /// All steps together, in seconds.
    pub seconds: f64,
}

/// Runs a recipe with every registered solver and compares the scenes. Writes nothing.
///
/// # Errors
/// When the recipe fails with every solver: the first error.
pub fn compare(
    recipe: &Recipe,
    registry: &Registry,
    observer: &dyn Observer,
    clock: &dyn Clock,
) -> Result<Comparison> {
    let mut solvers: Vec<Trial> = Vec::new();
    let mut first: Option<Scene> = None;
    let mut failure = None;
    let runner = Runner::new(registry).watched(observer, clock);
    for solver in registry.solvers() {
        let start = clock.seconds();
        let outcome = runner.clone().with_solver(solver.name()).apply(recipe);
        let mut trial = Trial {
            solver: solver.name().to_owned(),
            error: None,
            steps: Vec::new(),
            difference: None,
            seconds: clock.seconds() - start,
        };
        match outcome {
            Ok(Applied { scene, steps, .. }) => {
                trial.steps = steps;
                trial.difference = Some(difference(first.get_or_insert_with(|| scene.clone()), &scene));
            }
            Err(error) => {
                trial.error = Some(error.to_string());
                failure.get_or_insert(error);
            }
        }
        solvers.push(trial);
    }
    let done: Vec<f64> = solvers.iter().filter_map(|t| t.difference).collect();
    match failure {
        Some(error) if done.is_empty() => Err(error),
        _ => {
            let largest = done.iter().copied().fold(0.0, f64::max);
            Ok(Comparison { agreement: (done.len() > 1).then_some(largest), solvers })
        }
    }
}

/// The largest distance between corresponding points of two scenes, relative to the size of the first; infinite
/// where they do not correspond.
fn difference(a: &Scene, b: &Scene) -> f64 {
    let size = a.bounds().map_or(0.0, |(low, high)| (high - low).amax());
    let points = |scene: &Scene| -> usize { scene.objects().iter().map(|o| o.geometry.points().len()).sum() };
    if points(a) != points(b) {
        return f64::INFINITY;
    }
    let all = |scene: &Scene| -> Vec<_> {
        scene.objects().iter().flat_map(|o| o.geometry.points()).copied().collect()
    };
    let largest = all(a).iter().zip(all(b)).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max);
    if size > 0.0 { largest / size } else { largest }
}

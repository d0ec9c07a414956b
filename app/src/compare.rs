//! The same recipe with every solver: do they agree, and how long do they take?

use std::collections::BTreeSet;

use loftsman_kernel::plugin::{Clock, Observer, OperationError, Registry, StepReport};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::solve::SolveError;
use loftsman_kernel::spline::Space;

use crate::error::{Error, Result};
use crate::recipe::{Applied, Recipe, Runner};
use loftsman_kernel::text::counted;

/// What every solver made of a recipe.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Comparison {
    /// Each solver.
    pub solvers: Vec<Trial>,
    /// The largest distance between a point of one solver's scene and the same of another's, divided by the scene's size
    /// (weights by their own size); `None` where fewer than two solvers have an answer, or nothing in their scenes
    /// corresponds.
    pub agreement: Option<f64>,
    /// The objects that have no such distance, because they are not made alike: meshes of other triangles, curves of other
    /// knots, … Each is a sentence.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unlike: Vec<String>,
    /// The solvers that refuse what others do (a conflict, iterations that do not arrive): they contradict one another.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub refused: Vec<String>,
    /// The solvers that are not for such a problem, as their errors say: too large, too nearly dependent, not supported.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unsuited: Vec<String>,
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
    /// The largest distance from the first successful solver's answer, as in [`Comparison::agreement`]; `None` where nothing
    /// corresponds.
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
    let mut scenes: Vec<(&str, Scene)> = Vec::new();
    let mut failure = None;
    let (mut refused, mut unsuited) = (Vec::new(), Vec::new());
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
                scenes.push((solver.name(), scene));
                let (first, last) = (&scenes[0], &scenes[scenes.len() - 1]);
                trial.difference = difference([first, last]).largest;
            }
            Err(error) => {
                trial.error = Some(error.to_string());
                let list = if is_unsuited(&error) { &mut unsuited } else { &mut refused };
                list.push(solver.name().to_owned());
                failure.get_or_insert(error);
            }
        }
        solvers.push(trial);
    }
    if let (Some(error), true) = (failure, scenes.is_empty()) {
        return Err(error);
    }
    let (mut agreement, mut unlike) = (None, Vec::new());
    for (k, first) in scenes.iter().enumerate() {
        for second in &scenes[k + 1..] {
            let found = difference([first, second]);
            agreement = found.largest.into_iter().chain(agreement).reduce(f64::max);
            // Said once of each object, with the first two that it differs for.
            let said: BTreeSet<String> = found.unlike.into_iter().filter(|u| !named_in(&unlike, u)).collect();
            unlike.extend(said);
        }
    }
    Ok(Comparison { solvers, agreement, unlike, refused, unsuited })
}

/// Whether a solver leaves the problem to others, rather than saying that it cannot be solved.
fn is_unsuited(error: &Error) -> bool {
    let Error::Recipe(error) = error else { return false };
    matches!(
        error.cause,
        Some(OperationError::Solve(
            SolveError::TooLarge { .. } | SolveError::IllConditioned { .. } | SolveError::Unsupported(_)
        ))
    )
}

/// Whether one of the sentences begins with the same object as this.
fn named_in(sentences: &[String], sentence: &str) -> bool {
    let object = |s: &str| s.split("\": ").next().map(str::to_owned);
    sentences.iter().any(|s| object(s) == object(sentence))
}

/// How far two scenes are apart.
struct Difference {
    largest: Option<f64>,
    unlike: Vec<String>,
}

/// The largest distance between corresponding points of two scenes, relative to their size, and the objects that do not
/// correspond.
fn difference(of: [&(&str, Scene); 2]) -> Difference {
    let [(first, a), (second, b)] = of;
    let mut found = Difference { largest: None, unlike: Vec::new() };
    let mut alike: Vec<[&Object; 2]> = Vec::new();
    for object in a.objects() {
        match b.get(object.name()) {
            None => found.unlike.push(format!("\"{}\": {first} has it, {second} has not", object.name())),
            Some(other) => match unlike(object.geometry(), other.geometry()) {
                Some((x, y)) => {
                    found.unlike.push(format!("\"{}\": {first} makes it {x}, {second} {y}", object.name()));
                }
                None => alike.push([object, other]),
            },
        }
    }
    for object in b.objects().iter().filter(|o| a.get(o.name()).is_none()) {
        found.unlike.push(format!("\"{}\": {second} has it, {first} has not", object.name()));
    }
    // Coordinates are scaled before they are subtracted, so that neither a difference nor the size overflows.
    let points = || alike.iter().flat_map(|pair| pair.iter().flat_map(|o| o.geometry().points()));
    let largest = points().map(|p| p.coords.amax()).fold(0.0, f64::max);
    let scale = if largest > 0.0 { largest } else { 1.0 };
    let ends = points().map(|p| (p.coords / scale, p.coords / scale));
    let size =
        ends.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1))).map_or(0.0, |(low, high)| (high - low).amax());
    let size = if size > 0.0 { size } else { 1.0 };
    for [x, y] in alike {
        let (p, q) = (x.geometry().points(), y.geometry().points());
        let apart = p.iter().zip(q).map(|(p, q)| (p.coords / scale - q.coords / scale).norm() / size);
        let heavier = weights(x.geometry()).iter().zip(weights(y.geometry()));
        let heavier = heavier.map(|(v, w)| (v - w).abs() / v.abs().max(w.abs()).max(f64::MIN_POSITIVE));
        let most = apart.chain(heavier).fold(0.0, f64::max);
        found.largest = Some(found.largest.map_or(most, |before: f64| before.max(most)));
    }
    found
}

fn weights(geometry: &Geometry) -> &[f64] {
    match geometry {
        Geometry::Curve(curve) => curve.weights(),
        Geometry::Surface(surface) => surface.weights(),
        Geometry::Trimmed(trimmed) => trimmed.surface().weights(),
        _ => None,
    }
    .unwrap_or_default()
}

/// What two geometries are, where their points do not correspond one by one.
fn unlike(a: &Geometry, b: &Geometry) -> Option<(String, String)> {
    let spaces = |g: &Geometry| -> Vec<Space> {
        match g {
            Geometry::Curve(c) => vec![c.space().clone()],
            Geometry::Surface(s) => vec![s.u().clone(), s.v().clone()],
            Geometry::Trimmed(t) => vec![t.surface().u().clone(), t.surface().v().clone()],
            _ => Vec::new(),
        }
    };
    let count = |g: &Geometry| match g {
        Geometry::Mesh(mesh) => {
            format!(
                "a mesh of {} and {}",
                counted(mesh.points().len(), "point[|s]"),
                counted(mesh.face_count(), "face[|s]")
            )
        }
        Geometry::Group => "a group".to_owned(),
        Geometry::Instance(definition) => format!("an instance of \"{definition}\""),
        unknown if unknown.is_unknown() => format!("a {} whose plug-in is not here", unknown.kind()),
        other => format!("a {} of {}", other.kind(), counted(other.points().len(), "point[|s]")),
    };
    let (before, after) = (count(a), count(b));
    if before != after {
        return Some((before, after));
    }
    let same = match (a, b) {
        (Geometry::Mesh(a), Geometry::Mesh(b)) => (a.corners(), a.starts()) == (b.corners(), b.starts()),
        // With the same points; what its kind writes beside them.
        (Geometry::Custom(one), Geometry::Custom(two)) => {
            let like = one.with_points(two.points());
            let same = like.map_or(one == two, |like| like == *two);
            return (!same).then(|| (before, "one of other fields".to_owned()));
        }
        _ => return (spaces(a) != spaces(b)).then(|| (before, "one of other knots".to_owned())),
    };
    (!same).then(|| (before, "as many, but other faces".to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use loftsman_kernel::Point;
    use loftsman_kernel::mesh::{Mesh, Polyline};
    use loftsman_kernel::spline::Curve;

    fn scene(name: &str, geometry: impl Into<Geometry>) -> Scene {
        let mut scene = Scene::new();
        scene.add(Object::new(name, geometry.into())).unwrap();
        scene
    }

    fn points(list: &[[f64; 2]], scale: f64) -> Vec<Point> {
        list.iter().map(|[x, y]| Point::new(x * scale, y * scale, 0.0)).collect()
    }

    const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

    #[test]
    fn distances_are_relative_to_the_size_at_every_size() {
        for scale in [1e-320, 1e-9, 1.0, 1e9, 1e308] {
            let line = |list| Polyline { points: points(list, scale), closed: false };
            let moved = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.5]];
            let (a, b) = (("one", scene("c", line(&SQUARE))), ("two", scene("c", line(&moved))));
            let found = difference([&a, &b]);
            let slack = if scale < 1e-300 { 1e-3 } else { 1e-15 };
            assert!((found.largest.unwrap() - 0.5).abs() <= slack && found.unlike.is_empty(), "{scale}");
            assert_eq!(difference([&a, &a]).largest, Some(0.0));
        }
    }

    #[test]
    fn what_does_not_correspond_is_said_and_never_a_number() {
        let net = points(&SQUARE, 1.0);
        let mesh = |faces: &[[usize; 3]]| Mesh::new(net.clone(), faces).unwrap();
        let (one, two) = (mesh(&[[0, 1, 2], [0, 2, 3]]), mesh(&[[0, 1, 3], [1, 2, 3]]));
        let line = Polyline { points: net.clone(), closed: false };
        let bezier = Curve::bezier(net.clone()).unwrap();
        let other = Curve::new(Space::clamped_uniform(2, 4).unwrap(), net.clone()).unwrap();
        let cases: [(Scene, Scene, &str); 5] = [
            (scene("m", one.clone()), scene("m", two), "other faces"),
            (scene("m", one.clone()), scene("m", mesh(&[[0, 1, 2]])), "4 points and 1 face"),
            (scene("m", one), scene("m", line.clone()), "polyline"),
            (scene("c", bezier), scene("c", other), "other knots"),
            (scene("c", line.clone()), scene("d", line), "two has not"),
        ];
        for (a, b, words) in cases {
            let found = difference([&("one", a), &("two", b)]);
            assert_eq!(found.largest, None, "{words}");
            assert!(found.unlike.iter().any(|u| u.contains(words)), "{:?}: {words}", found.unlike);
        }
    }
}

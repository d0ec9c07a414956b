//! Whether an operation is one: declared fields, determinism, a scene left alone where it fails.

use super::Verdict;
use crate::plugin::{Context, Operation, Parameters, Registry};
use crate::scene::Scene;

/// Checks an operation on a scene with parameters that it should take: it does what it does twice alike, reports under
/// its name, keeps the hierarchy whole; every field has help; and where it fails (parameters of the wrong kind, an
/// object that is not there, an empty scene) the scene stays as it was.
pub fn operation_conformance(
    operation: &dyn Operation,
    scene: &Scene,
    parameters: &Parameters,
    registry: &Registry,
) -> Verdict {
    let mut verdict = Verdict::default();
    let declaration = operation.declaration();
    let name = declaration.name;
    verdict.check(!name.is_empty() && !declaration.help.is_empty(), || "no name or no help".into());
    for field in declaration.fields {
        let told = !field.name.is_empty() && !field.takes.is_empty() && !field.help.is_empty();
        verdict.check(told, || format!("{name}: the field \"{}\" has no help", field.name));
        verdict.check(field.name != "op", || format!("{name}: \"op\" is not a field of its own"));
    }
    let context = Context::quiet(registry);
    if let Err(error) = parameters.check(declaration.fields) {
        verdict.check(false, || format!("{name}: the parameters are not its own: {error}"));
        return verdict;
    }
    let run = |parameters: &Parameters, scene: &Scene| {
        let mut copy = scene.clone();
        let result = operation.apply(&mut copy, parameters, &context);
        (copy, result)
    };
    let ((first, report), (second, again)) = (run(parameters, scene), run(parameters, scene));
    match report {
        Ok(report) => {
            verdict.check(first == second && again.as_ref() == Ok(&report), || {
                format!("{name}: two runs differ")
            });
            verdict.check(report.op == name, || format!("{name} reports as \"{}\"", report.op));
            verdict.check(first.check().is_ok(), || format!("{name} breaks the hierarchy"));
        }
        Err(error) => verdict.check(false, || format!("{name}: {error}")),
    }
    let mut wrong: Vec<(serde_json::Map<String, serde_json::Value>, &Scene)> = Vec::new();
    let empty = Scene::new();
    let own = || -> serde_json::Map<String, serde_json::Value> {
        parameters.names().filter_map(|n| Some((n.to_owned(), parameters.value(n)?.clone()))).collect()
    };
    for field in declaration.fields {
        for value in
            [serde_json::Value::Bool(true), serde_json::Value::Null, "nonsense".into(), (-1e300).into()]
        {
            let mut fields = own();
            fields.insert(field.name.to_owned(), value);
            wrong.push((fields, scene));
        }
    }
    wrong.push((own(), &empty));
    for (fields, scene) in wrong {
        let text = serde_json::Value::Object(fields.clone()).to_string();
        let Ok(parameters) = Parameters::new(fields.into(), "step[0]") else { continue };
        let (after, result) = run(&parameters, scene);
        if let Err(error) = result {
            verdict
                .check(after == *scene, || format!("{name} fails on {text} and changes the scene: {error}"));
            verdict.check(!error.to_string().is_empty(), || {
                format!("{name} fails on {text} and does not say why")
            });
        }
    }
    verdict
}

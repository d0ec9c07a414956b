//! Whether a kind of functional can be asked for in recipes: what it declares, and what it makes of parameters.

use super::{Verdict, functional_conformance, guarded};
use crate::functional::{DeclaredFunctional, ShapeNames};
use crate::plugin::{Declaration, EVERYWHERE, Parameters, WISHES};
use crate::shape::Shape;

/// Checks what a kind of functional declares: a name and fields in lower-case words, each once and with help; none that
/// every constraint has (`kind`, `axis`); and none that says what is wanted (`to`, `by`, `scale`, `keep`, `at_least`,
/// `at_most`), for then nobody could want that of it, unless it `is_condition`, of which nothing else is wanted.
pub fn declaration_conformance(declaration: &Declaration, is_condition: bool) -> Verdict {
    guarded(|verdict| {
        declared(declaration, is_condition, verdict);
        Some(())
    })
}

fn declared(declaration: &Declaration, is_condition: bool, verdict: &mut Verdict) {
    named(declaration, verdict);
    let name = declaration.name;
    for own in declaration.fields.iter().map(|field| field.name) {
        verdict.check(!EVERYWHERE.contains(&own), || {
            format!("{name}: the field \"{own}\" is reserved, every constraint has it")
        });
        verdict.check(is_condition || !WISHES.contains(&own), || {
            format!("{name}: the field \"{own}\" is reserved, it says what is wanted of the functional")
        });
    }
}

/// A name and fields in lower-case words, each once and with help.
pub(super) fn named(declaration: &Declaration, verdict: &mut Verdict) {
    let name = declaration.name;
    verdict.check(is_word(name, '-'), || format!("\"{name}\" is no name: use lower-case words with hyphens"));
    verdict.check(!declaration.help.is_empty(), || format!("{name} has no help"));
    for (k, field) in declaration.fields.iter().enumerate() {
        let own = field.name;
        verdict.check(is_word(own, '_'), || {
            format!("{name}: \"{own}\" is no field's name: use lower-case words")
        });
        verdict.check(!field.takes.is_empty() && !field.help.is_empty(), || {
            format!("{name}: the field \"{own}\" has no help")
        });
        verdict.check(declaration.fields[..k].iter().all(|f| f.name != own), || {
            format!("{name}: the field \"{own}\" is declared twice")
        });
    }
}

fn is_word(name: &str, between: char) -> bool {
    let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == between;
    name.starts_with(|c: char| c.is_ascii_lowercase()) && name.chars().all(plain)
}

/// Checks a kind of functional that recipes can ask for: what it declares, that it is made of the parameters (twice alike),
/// that wrong ones are errors and no panics, and the functional itself on shapes, by
/// [`functional_conformance`].
pub fn declared_functional_conformance<F: DeclaredFunctional>(
    parameters: &Parameters,
    names: &mut dyn ShapeNames,
    shapes: &[Box<dyn Shape>],
) -> Verdict {
    let mut found = None;
    let mut verdict = guarded(|verdict| {
        let name = F::DECLARATION.name;
        verdict.take(parameters.check(F::DECLARATION.fields), |e| {
            format!("{name}: the parameters are not its own: {e}")
        })?;
        let functional =
            verdict.take(F::from_parameters(parameters, names), |e| format!("{name} cannot be made: {e}"))?;
        declared(&F::DECLARATION, functional.is_condition(), verdict);
        let again = F::from_parameters(parameters, names).map(|f| f.describe());
        verdict.check(again.as_ref() == Ok(&functional.describe()), || {
            format!("{name} becomes something else of the same parameters: {again:?}")
        });
        for field in F::DECLARATION.fields {
            for value in
                [serde_json::Value::Bool(true), serde_json::Value::Null, "nonsense".into(), (-1e300).into()]
            {
                let mut fields = serde_json::Map::new();
                for own in parameters.names() {
                    fields.extend(parameters.value(own).map(|v| (own.to_owned(), v.clone())));
                }
                fields.insert(field.name.to_owned(), value);
                let Ok(wrong) = Parameters::new(fields.into(), parameters.path()) else { continue };
                // Whether it takes the value is its own business; that it says something is not.
                if let Err(error) = F::from_parameters(&wrong, names) {
                    verdict.check(!error.to_string().is_empty(), || {
                        format!("{name} refuses a {} and does not say why", field.name)
                    });
                }
            }
        }
        found = Some(functional);
        Some(())
    });
    if let Some(functional) = found {
        let own = functional_conformance(&functional, shapes);
        verdict.checks += own.checks;
        verdict.failures.extend(own.failures);
    }
    verdict
}

//! `plugins [NAME] [--json]`: everything that is known by name, with all fields.

use std::fmt::Write;
use std::process::ExitCode;

use loftsman::kernel::plugin::{Declaration, Field, FormatDeclaration, Registry, nearest};
use loftsman::recipe;

use crate::Usage;
use crate::args::PluginsArgs;
use crate::console::{self, BOLD, DIM, styled};

#[derive(serde::Serialize)]
struct Known {
    formats: Vec<FormatDeclaration>,
    operations: Vec<Declaration>,
    constraints: Vec<Declaration>,
    solvers: Vec<String>,
    shapes: Vec<Declaration>,
    recipe: Vec<Field>,
    picture: Vec<Field>,
}

pub(crate) fn run(args: &PluginsArgs) -> anyhow::Result<ExitCode> {
    let registry = loftsman::registry();
    let mut known = Known {
        formats: registry.formats().iter().map(|f| f.declaration()).collect(),
        operations: registry.operations().iter().map(|o| o.declaration()).collect(),
        constraints: registry.functionals().collect(),
        solvers: registry.solvers().iter().map(|s| s.name().to_owned()).collect(),
        shapes: registry.shape_kinds().iter().map(|k| k.declaration()).collect(),
        recipe: recipe::FIELDS.to_vec(),
        picture: loftsman::picture::FIELDS.to_vec(),
    };
    if let Some(name) = &args.name {
        let near = {
            let names = known.formats.iter().map(|f| f.name).chain(known.operations.iter().map(|o| o.name));
            let names = names.chain(known.constraints.iter().map(|c| c.name));
            let names = names.chain(known.shapes.iter().map(|k| k.name));
            nearest(name, names.chain(known.solvers.iter().map(String::as_str))).map(str::to_owned)
        };
        known.formats.retain(|f| f.name == name);
        known.operations.retain(|o| o.name == name);
        known.constraints.retain(|c| c.name == name);
        known.solvers.retain(|s| s == name);
        known.shapes.retain(|k| k.name == name);
        known.recipe.clear();
        known.picture.clear();
        let declared = known.operations.len() + known.constraints.len() + known.shapes.len();
        if known.formats.len() + declared + known.solvers.len() == 0 {
            let hint = near.map(|n| format!("; did you mean {n}?")).unwrap_or_default();
            return Err(Usage(format!("nothing is called {name}{hint}")).into());
        }
    }
    if args.json.wanted {
        console::print_json(&known)?;
    } else {
        console::print(&text(&known, registry))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn text(known: &Known, registry: &Registry) -> String {
    let mut text = String::new();
    let heading = |text: &mut String, title: &str, some: bool| {
        if some {
            let gap = if text.is_empty() { "" } else { "\n" };
            let _ = writeln!(text, "{gap}{}", styled(BOLD, title));
        }
    };
    heading(&mut text, "Formats", !known.formats.is_empty());
    for format in &known.formats {
        let way = match (format.reads, format.writes) {
            (true, true) => "reads, writes",
            (true, false) => "reads",
            (false, true) => "writes",
            (false, false) => "",
        };
        let extensions: Vec<String> = format.extensions.iter().map(|e| format!(".{e}")).collect();
        let _ = writeln!(
            text,
            "  {}  {} ({way}): {}",
            styled(BOLD, format.name),
            format.help,
            extensions.join(" ")
        );
        let _ = writeln!(text, "    {}", styled(DIM, &format!("holds {}", format.holds)));
        fields(&mut text, format.options);
    }
    let declared =
        [("Operations", &known.operations), ("Constraints", &known.constraints), ("Shapes", &known.shapes)];
    for (title, entries) in declared {
        heading(&mut text, title, !entries.is_empty());
        for entry in entries {
            let _ = writeln!(text, "  {}  {}", styled(BOLD, entry.name), entry.help);
            fields(&mut text, entry.fields);
        }
    }
    heading(&mut text, "Solvers", !known.solvers.is_empty());
    for solver in registry.solvers().iter().filter(|s| known.solvers.iter().any(|name| name == s.name())) {
        let _ = writeln!(text, "  {}  {}", styled(BOLD, solver.name()), solver.help());
    }
    heading(&mut text, "A recipe's own fields", !known.recipe.is_empty());
    fields(&mut text, &known.recipe);
    heading(&mut text, "The fields of its picture", !known.picture.is_empty());
    fields(&mut text, &known.picture);
    text
}

fn fields(text: &mut String, fields: &[Field]) {
    for field in fields {
        let default = match field.default {
            Some(default) => format!(" [default: {default}]"),
            None => " [needed]".to_owned(),
        };
        let _ =
            writeln!(text, "    {} = {}: {}{}", field.name, field.takes, field.help, styled(DIM, &default));
    }
}

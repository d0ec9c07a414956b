//! `plugins [NAME] [--json]`: everything that is known by name, with all fields.

use std::fmt::Write;
use std::path::Path;
use std::process::ExitCode;

use crate::picture_name::is_picture;
use crate::recipe;
use crate::words::{self, Word};
use loftsman_kernel::plugin::{Declaration, Field, FormatDeclaration, Registry, Table, nearest};

use crate::program::Usage;
use crate::program::args::PluginsArgs;
use crate::program::console::{self, BOLD, DIM, styled};

/// What a step runs, with what the tables take that its fields list.
#[derive(Clone, serde::Serialize)]
struct Operation {
    #[serde(flatten)]
    declaration: Declaration,
    #[serde(skip_serializing_if = "<[Table]>::is_empty")]
    tables: &'static [Table],
}

#[derive(Clone, Default, serde::Serialize)]
struct Known {
    formats: Vec<FormatDeclaration>,
    operations: Vec<Operation>,
    constraints: Vec<Declaration>,
    solvers: Vec<String>,
    shapes: Vec<Declaration>,
    wishes: Vec<Field>,
    recipe: Vec<Field>,
    picture: Vec<Field>,
    document: Vec<Field>,
    /// What the words mean that these use, and those that documents use.
    words: Vec<Word>,
    document_words: Vec<Word>,
}

impl Known {
    /// Everything.
    fn all(registry: &Registry) -> Self {
        Self {
            formats: registry.formats().iter().map(|f| f.declaration()).collect(),
            operations: registry
                .operations()
                .iter()
                .map(|o| Operation { declaration: o.declaration(), tables: o.tables() })
                .collect(),
            constraints: registry.functionals().collect(),
            solvers: registry.solvers().iter().map(|s| s.name().to_owned()).collect(),
            shapes: registry.shape_kinds().iter().map(|k| k.declaration()).collect(),
            wishes: recipe::WISHES.to_vec(),
            recipe: recipe::FIELDS.to_vec(),
            picture: crate::picture::FIELDS.to_vec(),
            document: crate::document::FIELDS.to_vec(),
            words: Vec::new(),
            document_words: Vec::new(),
        }
    }

    /// The same with what the words mean that it uses, in documents often something else.
    fn explained(self) -> Self {
        let declared =
            self.operations.iter().map(|o| &o.declaration).chain(&self.constraints).chain(&self.shapes);
        let tables = self.operations.iter().flat_map(|o| o.tables);
        let of_tables =
            tables.flat_map(|t| t.fields.iter().chain(t.kinds.iter().flat_map(|kind| kind.fields)));
        let own = self.wishes.iter().chain(&self.recipe).chain(&self.picture);
        let fields = declared.flat_map(|d| d.fields).chain(of_tables).chain(own);
        let fields = fields.chain(self.formats.iter().flat_map(|f| f.options));
        let words = words::used(words::WORDS, fields.map(|field| field.takes));
        let document_words =
            words::used(words::DOCUMENT_WORDS, self.document.iter().map(|field| field.takes));
        Self { words, document_words, ..self }
    }

    /// All of one sort; `None` where the word is none of a sort.
    fn sort(self, word: &str) -> Option<Self> {
        let none = Self::default();
        Some(match word {
            "format" | "formats" => Self { formats: self.formats, ..none },
            "operation" | "operations" => Self { operations: self.operations, ..none },
            "constraint" | "constraints" => {
                Self { constraints: self.constraints, wishes: self.wishes, ..none }
            }
            "solver" | "solvers" => Self { solvers: self.solvers, ..none },
            "shape" | "shapes" => Self { shapes: self.shapes, ..none },
            "wish" | "wishes" => Self { wishes: self.wishes, ..none },
            "recipe" => Self { recipe: self.recipe, ..none },
            "picture" => Self { picture: self.picture, ..none },
            // What files that are pictures are written by.
            _ if !self.picture.is_empty() && is_picture(Path::new(&format!("x.{}", bare(word)))) => {
                Self { picture: self.picture, ..none }
            }
            "document" => Self { document: self.document, ..none },
            "word" | "words" => Self { words: words::WORDS.to_vec(), ..none },
            _ => return None,
        })
    }

    /// The operation and its field whose tables have a kind of this name.
    fn kind_of(&self, name: &str) -> Option<(&'static str, &'static str)> {
        let tables = self.operations.iter().flat_map(|o| o.tables.iter().map(|t| (o.declaration.name, t)));
        let mut found = tables.filter(|(_, table)| table.kinds.iter().any(|kind| kind.name == name));
        found.next().map(|(operation, table)| (operation, table.field))
    }

    /// What to say of a name that is none of these: the field that takes it or is called so, the nearest name, or where to look.
    fn unknown(&self, name: &str) -> String {
        let fields = |whose: String, list: &[Field]| -> Option<String> {
            let field = list.iter().find(|field| {
                field.name == name || field.takes.split('|').any(|word| word.trim().trim_matches('"') == name)
            })?;
            Some(if field.name == name {
                format!("nothing is called {name}, but a field of {whose} is: see loftsman plugins {whose}")
            } else {
                format!(
                    "nothing is called {name}, but {} = \"{name}\" is for {whose}: see loftsman plugins {whose}",
                    field.name
                )
            })
        };
        let own = [("picture", &self.picture), ("recipe", &self.recipe), ("document", &self.document)];
        let operations =
            self.operations.iter().map(|o| (o.declaration.name.to_owned(), o.declaration.fields.to_vec()));
        let constraints = self.constraints.iter().map(|c| (c.name.to_owned(), c.fields.to_vec()));
        let mut all = own
            .into_iter()
            .map(|(whose, list)| (whose.to_owned(), list.clone()))
            .chain(operations)
            .chain(constraints);
        let names =
            self.formats.iter().map(|f| f.name).chain(self.operations.iter().map(|o| o.declaration.name));
        let names = names.chain(self.constraints.iter().map(|c| c.name));
        let names = names.chain(self.shapes.iter().map(|k| k.name)).chain(SORTS);
        let near = nearest(name, names.chain(self.solvers.iter().map(String::as_str)));
        if let Some(field) = all.find_map(|(whose, list)| fields(whose, &list)) {
            return field;
        }
        let operations = self.operations.iter().map(|o| o.declaration.name);
        if let Some(ours) = recipe::elsewhere::called_among(name, operations) {
            return format!(
                "nothing is called {name}; what comes nearest to it is {ours}: see loftsman plugins {ours}"
            );
        }
        if let Some(why) = recipe::elsewhere::absent(name) {
            return format!("nothing is called {name}: {why}");
        }
        let speak = self.speaking_of(name);
        if let [first, ..] = &speak[..] {
            return format!(
                "nothing is called {name}; {} {} of it: see loftsman plugins {first}",
                speak.join(", "),
                if speak.len() > 1 { "speak" } else { "speaks" }
            );
        }
        match near {
            Some(near) => format!("nothing is called {name}; did you mean {near}?"),
            None => format!(
                "nothing is called {name}; give the name of a format, an operation, a constraint or a solver, or one of {}",
                SORTS.join(", ")
            ),
        }
    }

    /// The operations and constraints, and the tables of fields, in whose help a word stands, in the singular or the plural.
    fn speaking_of(&self, name: &str) -> Vec<&str> {
        const MOST: usize = 6;
        let name = name.to_lowercase();
        let one = name.strip_suffix('s').unwrap_or(&name);
        let says = |text: &str| {
            let mut words = text.split(|c: char| !c.is_alphanumeric());
            words.any(|word| {
                let word = word.to_lowercase();
                one.len() > 2 && word.strip_suffix('s').unwrap_or(&word) == one
            })
        };
        let tells = |help: &str, fields: &[Field]| says(help) || fields.iter().any(|f| says(f.help));
        let declared = self.operations.iter().map(|o| &o.declaration).chain(&self.constraints);
        let declared = declared.filter(|d| tells(d.help, d.fields)).map(|d| d.name);
        let own = [("picture", &self.picture), ("recipe", &self.recipe), ("document", &self.document)];
        let own = own.into_iter().filter(|(_, fields)| tells("", fields)).map(|(whose, _)| whose);
        declared.chain(own).take(MOST).collect()
    }

    /// The entries of one name, a constraint with what every constraint takes, a format by the ending of its files as well.
    fn entry(mut self, name: &str) -> Option<Self> {
        let ending = bare(name);
        let ends_so = |f: &FormatDeclaration| f.extensions.iter().any(|e| e.eq_ignore_ascii_case(ending));
        let named = self.formats.iter().any(|f| f.name == name);
        self.formats.retain(|f| f.name == name || !named && ends_so(f));
        self.operations.retain(|o| o.declaration.name == name);
        self.constraints.retain(|c| c.name == name);
        self.solvers.retain(|s| s == name);
        self.shapes.retain(|k| k.name == name);
        let declared = self.operations.len() + self.constraints.len() + self.shapes.len();
        if self.formats.len() + declared + self.solvers.len() == 0 {
            return None;
        }
        if self.constraints.is_empty() {
            self.wishes.clear();
        }
        Some(Self { recipe: Vec::new(), picture: Vec::new(), document: Vec::new(), ..self })
    }
}

/// An ending of files without its dot.
fn bare(ending: &str) -> &str {
    ending.strip_prefix('.').unwrap_or(ending)
}

/// What all of a sort are called.
const SORTS: [&str; 10] = [
    "formats",
    "operations",
    "constraints",
    "solvers",
    "shapes",
    "wishes",
    "recipe",
    "picture",
    "document",
    "words",
];

pub(crate) fn run(args: &PluginsArgs, registry: &Registry) -> anyhow::Result<ExitCode> {
    let all = Known::all(registry);
    let known = match &args.name {
        None => all.explained(),
        Some(name) => match all.clone().entry(name).or_else(|| all.clone().sort(name)) {
            Some(known) if known.words.is_empty() => known.explained(),
            Some(known) => known,
            None => {
                if let Some(found) = words::WORDS.iter().find(|word| word.word == name.as_str()) {
                    Known { words: vec![*found], ..Known::default() }
                } else if let Some((operation, field)) = all.kind_of(name) {
                    let told = format!(
                        "{name} is a kind of {field} of {operation}: see loftsman plugins {operation}"
                    );
                    return Err(Usage(told).into());
                } else {
                    return Err(Usage(all.unknown(name)).into());
                }
            }
        },
    };
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
    heading(&mut text, "Operations", !known.operations.is_empty());
    for Operation { declaration, tables } in &known.operations {
        let _ = writeln!(text, "  {}  {}", styled(BOLD, declaration.name), declaration.help);
        fields(&mut text, declaration.fields);
        tables.iter().for_each(|table| listed(&mut text, table));
    }
    let declared = [("Constraints", &known.constraints), ("Shapes", &known.shapes)];
    for (title, entries) in declared {
        heading(&mut text, title, !entries.is_empty());
        for entry in entries {
            let _ = writeln!(text, "  {}  {}", styled(BOLD, entry.name), entry.help);
            fields(&mut text, entry.fields);
        }
    }
    heading(&mut text, "What every constraint takes", !known.wishes.is_empty());
    fields(&mut text, &known.wishes);
    heading(&mut text, "Solvers", !known.solvers.is_empty());
    for solver in registry.solvers().iter().filter(|s| known.solvers.iter().any(|name| name == s.name())) {
        let _ = writeln!(text, "  {}  {}", styled(BOLD, solver.name()), solver.help());
    }
    heading(&mut text, "A recipe's own fields", !known.recipe.is_empty());
    fields(&mut text, &known.recipe);
    heading(&mut text, "The fields of its picture", !known.picture.is_empty());
    fields(&mut text, &known.picture);
    heading(&mut text, "What a document (*.loft.json) holds", !known.document.is_empty());
    fields(&mut text, &known.document);
    for (title, words) in [
        ("What the words stand for", &known.words),
        ("What the words of documents stand for", &known.document_words),
    ] {
        heading(&mut text, title, !words.is_empty());
        for Word { word, means } in words {
            let _ = writeln!(text, "    {}  {means}", styled(BOLD, word));
        }
    }
    text
}

/// The tables that a field lists.
fn listed(text: &mut String, table: &Table) {
    let _ = writeln!(text, "    each of {}: {}", styled(BOLD, table.field), table.help);
    indented(text, "      ", table.fields);
    for kind in table.kinds {
        let _ = writeln!(text, "      kind = {}  {}", styled(BOLD, &format!("\"{}\"", kind.name)), kind.help);
        indented(text, "        ", kind.fields);
    }
}

fn fields(text: &mut String, fields: &[Field]) {
    indented(text, "    ", fields);
}

fn indented(text: &mut String, indent: &str, fields: &[Field]) {
    for field in fields {
        let default = match field.default {
            Some(default) => format!(" [default: {default}]"),
            None => " [needed]".to_owned(),
        };
        let _ = writeln!(
            text,
            "{indent}{} = {}: {}{}",
            field.name,
            field.takes,
            field.help,
            styled(DIM, &default)
        );
    }
}

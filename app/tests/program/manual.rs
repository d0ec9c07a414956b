//! The manual: its examples run and print what it says, and its reference is what is declared.
//!
//! `LOFTSMAN_WRITE_REFERENCE=1 cargo test --test program manual` writes the reference anew.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use loftsman::kernel::plugin::{Declaration, Field, Table};

use crate::LOFTSMAN;

fn manual() -> PathBuf {
    loftsman_tests::repository().join("docs/manual")
}

fn pages(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let path = entry.path();
        if path.is_dir() {
            found.extend(pages(&path));
        } else if path.extension().is_some_and(|e| e == "md") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The fenced blocks of a page: what kind each is said to be, and its lines.
fn blocks(page: &str) -> Vec<(String, String)> {
    let mut found: Vec<(String, String)> = Vec::new();
    let mut open = false;
    for line in page.lines() {
        match line.strip_prefix("```") {
            Some(kind) if !open => {
                found.push((kind.to_owned(), String::new()));
                open = true;
            }
            Some(_) => open = false,
            None if open => {
                let (_, text) = found.last_mut().unwrap();
                text.push_str(line);
                text.push('\n');
            }
            None => {}
        }
    }
    assert!(!open, "a block is not closed");
    found
}

/// Whether a line is as the manual has it, in which `…` stands for anything.
fn is_like(line: &str, pattern: &str) -> bool {
    let mut rest = line.trim_end();
    let parts: Vec<&str> = pattern.trim_end().split('…').collect();
    let [first, middle @ .., last] = &parts[..] else { return rest == pattern.trim_end() };
    let Some(after) = rest.strip_prefix(first) else { return false };
    rest = after;
    for part in middle {
        let Some(at) = rest.find(part) else { return false };
        rest = &rest[at + part.len()..];
    }
    rest.ends_with(last)
}

/// Whether output is as the manual has it; a line of `…` alone stands for any lines.
fn differs(output: &str, told: &str) -> Option<String> {
    let printed: Vec<&str> = output.lines().collect();
    let (mut at, mut gap) = (0, false);
    for pattern in told.lines() {
        if pattern.trim() == "…" {
            gap = true;
            continue;
        }
        let most = if gap { printed.len() } else { printed.len().min(at + 1) };
        let Some(found) = (at..most).find(|&k| is_like(printed[k], pattern)) else {
            return Some(format!("there is no line `{pattern}` where it is told"));
        };
        (at, gap) = (found + 1, false);
    }
    (!gap && at < printed.len()).then(|| format!("it goes on with `{}`", printed[at]))
}

#[test]
fn a_line_of_the_manual_stands_for_what_is_printed() {
    assert!(is_like("edit \"arch\"  rank 9 of 9 · 3 µs", "edit \"arch\"  rank 9 of 9 · …"));
    assert!(!is_like("edit \"arch\"  rank 8 of 9 · 3 µs", "edit \"arch\"  rank 9 of 9 · …"));
    assert!(is_like("wrote a.obj", "wrote a.obj") && !is_like("wrote a.obj, 3", "wrote a.obj"));
    assert_eq!(differs("a\nb\nc", "a\n…\nc"), None);
    assert!(differs("a\nb\nc", "a\nc").is_some() && differs("a\nb", "a").is_some());
    assert!(differs("a", "a\nb").is_some());
}

/// Every operation is in the table of examples with one that uses it and has a picture, and nothing else is; those made for operations are
/// in the gallery.
#[test]
fn every_operation_has_an_example() {
    let page = std::fs::read_to_string(manual().join("src/examples.md")).unwrap();
    let gallery = std::fs::read_to_string(loftsman_tests::repository().join("docs/gallery.md")).unwrap();
    let (_, table) = page.split_once("| operation | example |").unwrap();
    let table = table.split_once("\n\n").unwrap().0;
    let registry = loftsman::registry();
    let operations = registry.operations().iter().map(|operation| operation.declaration().name);
    for operation in operations.clone() {
        let Some(row) = table.lines().find(|line| line.starts_with(&format!("| `{operation}` |"))) else {
            panic!("{operation} has no example");
        };
        let example = row.split('`').nth(3).unwrap();
        let folder = loftsman_tests::repository().join("examples").join(example);
        let recipe = std::fs::read_to_string(folder.join("recipe.toml")).unwrap();
        assert!(recipe.contains(&format!("op = \"{operation}\"\n")), "{example} does without {operation}");
        let readme = std::fs::read_to_string(folder.join("README.md")).unwrap();
        let mut links = readme.split("](").skip(1).filter_map(|rest| rest.split(')').next());
        let picture = links.find(|link| link.ends_with(".png")).unwrap();
        assert!(folder.join(picture).is_file(), "{example}: {picture}");
    }
    let rows = table.lines().filter(|line| line.starts_with("| `")).count();
    assert_eq!(rows, operations.count(), "a row an operation");
    for example in [
        "vase",
        "canoe",
        "bottle-sections",
        "pocket",
        "trefoil",
        "matched-deck",
        "jug",
        "pebble",
        "ship-plate",
    ] {
        assert!(gallery.contains(&format!("(../examples/{example}/recipe.toml)")), "{example}");
    }
}

#[test]
fn its_examples_run_and_print_what_it_says() {
    let mut ran = 0;
    let mut wrong = Vec::new();
    for page in pages(&manual().join("src")) {
        let name = page.strip_prefix(manual()).unwrap().display().to_string();
        let text = std::fs::read_to_string(&page).unwrap();
        let folder = tempfile::tempdir().unwrap();
        super::examples::copy(
            &loftsman_tests::repository().join("examples"),
            &folder.path().join("examples"),
        );
        super::examples::copy(&manual().join("files"), folder.path());
        if text.contains("tests/data/step/") {
            let data = "tests/data/step";
            super::examples::copy(&loftsman_tests::repository().join(data), &folder.path().join(data));
        }
        for (kind, block) in blocks(&text) {
            let file = block.lines().next().and_then(|line| line.strip_prefix("# "));
            match (kind.as_str(), file) {
                ("toml", Some(file)) => std::fs::write(folder.path().join(file), &block).unwrap(),
                ("console", _) => {
                    for command in block.split("$ ").skip(1) {
                        let (line, told) = command.split_once('\n').unwrap_or((command, ""));
                        let arguments: Vec<&str> = line.split_whitespace().collect();
                        assert_eq!(arguments.first(), Some(&"loftsman"), "{name}: {line}");
                        let run = LOFTSMAN.run(folder.path(), &arguments[1..]);
                        let printed = run.out + &run.err;
                        let fails = told.starts_with("error:");
                        if (run.code == Some(0)) == fails {
                            wrong.push(format!("{name}: `{line}` ends with {:?}:\n{printed}", run.code));
                        } else if let Some(what) = differs(&printed, told) {
                            wrong.push(format!("{name}: `{line}`: {what}:\n{printed}"));
                        }
                        ran += 1;
                    }
                }
                _ => {}
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(ran >= 15, "{ran} commands were run");
}

/// What a cell of a table may hold.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

fn fields(page: &mut String, fields: &[Field]) {
    if fields.is_empty() {
        page.push_str("No fields of its own.\n\n");
        return;
    }
    page.push_str("| field | takes | default | what |\n|---|---|---|---|\n");
    for field in fields {
        let default = field.default.map_or_else(|| "*needed*".to_owned(), cell);
        let _ =
            writeln!(page, "| `{}` | {} | {default} | {} |", field.name, cell(field.takes), cell(field.help));
    }
    page.push('\n');
}

fn entries(title: &str, preface: &str, declared: impl IntoIterator<Item = Declaration>) -> String {
    let mut page = format!("# {title}\n\n{preface}\n\n");
    declared.into_iter().for_each(|one| entry(&mut page, &one));
    page.trim_end().to_owned() + "\n"
}

fn entry(page: &mut String, one: &Declaration) {
    let _ = writeln!(page, "## {}\n\n{}\n", one.name, sentence(one.help));
    fields(page, one.fields);
}

/// What the tables take that a field lists.
fn tables(page: &mut String, table: &Table) {
    let _ = writeln!(page, "Each of `{}`: {}.\n", table.field, cell(table.help));
    fields(page, table.fields);
    for kind in table.kinds {
        let _ = writeln!(page, "`kind = \"{}\"`: {}.\n", kind.name, cell(kind.help));
        fields(page, kind.fields);
    }
}

fn sentence(help: &str) -> String {
    let mut letters = help.trim_end_matches('.').chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    format!("{first}{}.", letters.as_str())
}

fn reference() -> Vec<(&'static str, String)> {
    let registry = loftsman::registry();
    let mut operations = entries(
        "Operations",
        "Each is a step of a recipe, named by `op`. Made from what the operations declare; `loftsman plugins` prints the same.",
        [],
    );
    operations.push('\n');
    for operation in registry.operations() {
        entry(&mut operations, &operation.declaration());
        operation.tables().iter().for_each(|table| tables(&mut operations, table));
    }
    operations.truncate(operations.trim_end().len());
    operations.push('\n');
    operations.push_str("\n## Recipes\n\nThe fields of a recipe itself.\n\n");
    fields(&mut operations, loftsman::recipe::FIELDS);
    operations.push_str(
        "## Pictures\n\nThe fields of `picture` in a recipe, for outputs that are `.svg` or `.png`.\n\n",
    );
    fields(&mut operations, loftsman::picture::FIELDS);
    let constraints = entries(
        "Constraints",
        "Each is an entry of `constraints`, named by `kind`, with one wish beside its own fields: `to`, `by`, `scale`, `keep`, \
         `at_least` or `at_most`; `axis` narrows a vector to one axis. Made from what the kinds declare.",
        registry.functionals(),
    );
    let mut solvers = "# Solvers\n\nNamed by `solver` in a step, or `--solver` for all steps.\n\n".to_owned();
    solvers.push_str("| solver | for |\n|---|---|\n");
    for solver in registry.solvers() {
        let _ = writeln!(solvers, "| `{}` | {} |", solver.name(), cell(solver.help()));
    }
    let mut formats = "# Formats\n\nMade from what the formats declare.\n\n".to_owned();
    for format in registry.formats() {
        let format = format.declaration();
        let ways = [(format.reads, "read"), (format.writes, "written")];
        let ways: Vec<&str> = ways.iter().filter(|(does, _)| *does).map(|(_, what)| *what).collect();
        let extensions: Vec<String> = format.extensions.iter().map(|e| format!("`.{e}`")).collect();
        let (ways, extensions) = (ways.join(" and "), extensions.join(", "));
        let _ = writeln!(formats, "## {}\n\n{} {extensions}: {ways}.\n", format.name, sentence(format.help));
        let _ = writeln!(formats, "It holds {}.\n", format.holds);
        fields(&mut formats, format.options);
    }
    let formats = formats.trim_end().to_owned() + "\n";
    vec![
        ("operations.md", operations.trim_end().to_owned() + "\n"),
        ("constraints.md", constraints),
        ("solvers.md", solvers),
        ("formats.md", formats),
    ]
}

#[test]
fn its_reference_is_what_is_declared() {
    let folder = manual().join("src/reference");
    let write = std::env::var_os("LOFTSMAN_WRITE_REFERENCE").is_some();
    for (name, page) in reference() {
        let path = folder.join(name);
        if write {
            std::fs::create_dir_all(&folder).unwrap();
            std::fs::write(&path, &page).unwrap();
        }
        let found = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            found == page,
            "docs/manual/src/reference/{name} is not what is declared: \
             LOFTSMAN_WRITE_REFERENCE=1 cargo test --test program manual"
        );
    }
    for solver in loftsman::registry().solvers() {
        assert!(!solver.help().is_empty(), "{} does not say what it is for", solver.name());
    }
}

/// Links and included files are there, and every page is in the table of contents.
#[test]
fn its_pages_hang_together() {
    let src = manual().join("src");
    let summary = std::fs::read_to_string(src.join("SUMMARY.md")).unwrap();
    let mut listed = BTreeSet::new();
    for page in pages(&src) {
        let text = std::fs::read_to_string(&page).unwrap();
        let from = page.parent().unwrap();
        for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let file = link.split('#').next().unwrap_or_default();
            if !file.is_empty() && !link.contains("://") {
                assert!(from.join(file).exists(), "{}: there is no {file}", page.display());
            }
        }
        for include in text.split("{{#include ").skip(1).filter_map(|rest| rest.split("}}").next()) {
            assert!(from.join(include).exists(), "{}: there is no {include}", page.display());
        }
    }
    for link in summary.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
        listed.insert(src.join(link));
    }
    for page in pages(&src).into_iter().filter(|page| !page.ends_with("SUMMARY.md")) {
        assert!(listed.contains(&page), "{} is not in SUMMARY.md", page.display());
    }
}

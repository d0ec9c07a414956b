//! One word for each notion: the table of the manual, held against what constraints declare.

use std::collections::BTreeSet;

/// The words in backticks of a column of the manual's table.
fn column(number: usize) -> BTreeSet<String> {
    let page = loftsman_tests::repository().join("docs/manual/src/library.md");
    let page = std::fs::read_to_string(page).unwrap();
    let table = page.split("## One word for each notion").nth(1).unwrap().split("```").next().unwrap();
    let rows = table.lines().filter(|line| line.starts_with('|')).skip(2);
    let cells = rows.filter_map(|row| row.split('|').nth(number));
    let words = cells.flat_map(|cell| cell.split('`').skip(1).step_by(2));
    words.map(|word| word.split([' ', '(']).next().unwrap().to_owned()).collect()
}

/// Every field of every constraint is a word of the table, so that a new one for an old notion is seen; and what is a direction is
/// called so.
#[test]
fn constraints_have_one_name_for_each_notion() {
    let words = column(3);
    let mut names = BTreeSet::new();
    for constraint in loftsman::registry().functionals() {
        for field in constraint.fields {
            assert!(
                words.contains(field.name),
                "{}: {} is not in the manual's table",
                constraint.name,
                field.name
            );
            names.insert(field.name);
            let is_direction = field.takes == "[x, y, z]" && field.help.starts_with("the direction");
            assert!(!is_direction || field.name == "direction", "{}: {}", constraint.name, field.name);
        }
        let has = |name: &str| constraint.fields.iter().any(|field| field.name == name);
        assert!(!has("to") || has("direction"), "{}", constraint.name);
    }
    // And no word of the table is nobody's: the rest are those of steps.
    let wishes = ["to", "by", "scale", "keep", "at_least", "at_most", "axis"];
    let steps = ["constraints", "keep", "lock", "smooth", "solver"];
    for word in &words {
        let known = names.contains(word.as_str()) || wishes.contains(&word.as_str());
        assert!(known || steps.contains(&word.as_str()), "{word}");
    }
}

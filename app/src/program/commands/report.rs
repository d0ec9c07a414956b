//! Reports in words: what was read, what a step did, how each object went out.

use std::fmt::Write;

use crate::file::input::left_out;
use crate::recipe::{InputReport, OutputReport, RunReport};
use loftsman_kernel::plugin::{
    AskedQuantity, ChangeKind, Fate, ObjectChange, ReadReport, StepReport, Written,
};
use loftsman_kernel::scene::Unit;

use super::measures;
use crate::program::console::{self, BOLD, DIM, bytes, count, figure, seconds, styled};

/// A whole run; `timed` with the times that its steps took.
pub(crate) fn run(report: &RunReport, timed: bool) -> String {
    let mut text = String::new();
    for input in report.input.iter().chain(&report.more_inputs) {
        text += &self::input(input);
    }
    for step in &report.steps {
        text += &self::step(step, report.unit, timed);
    }
    for output in &report.outputs {
        text += &self::output(output, report.unit);
    }
    if report.outputs.is_empty() {
        text += "nothing was written: the recipe has no output, and no -o was given\n";
    }
    text
}

fn input(input: &InputReport) -> String {
    let mut text =
        format!("read {} {}\n{}", styled(BOLD, &input.path), styled(DIM, input.format), read(&input.report));
    for note in &input.notes {
        let _ = writeln!(text, "  {}", styled(DIM, note));
    }
    text
}

/// Says on the standard error what a reader left out.
pub(crate) fn warn(path: &str, report: &ReadReport) {
    if let Some(text) = left_out(path, report) {
        console::warning(&text);
    }
}

/// What was not kept as it was, indented.
pub(crate) fn read(report: &ReadReport) -> String {
    let mut text = String::new();
    for (what, reasons) in [("read otherwise", &report.approximated), ("left out", &report.left_out)] {
        // What is only counted comes behind what is named.
        let (further, named): (Vec<_>, Vec<_>) =
            reasons.iter().partition(|(reason, _)| reason.starts_with("further "));
        for (reason, number) in named.into_iter().chain(further) {
            let _ = writeln!(text, "  {number} of {} {what}: {reason}", report.entities);
        }
    }
    for note in &report.notes {
        let _ = writeln!(text, "  {}", styled(DIM, note));
    }
    text
}

/// So many redundant constraints are named.
const REDUNDANT: usize = 5;

/// A distance that is less than this part of the one allowed is rounding.
const ROUNDING: f64 = 1e-9;

/// So many objects of a step have a line each.
const OBJECTS: usize = 8;

/// One step: what it changed, in the user's quantities, then how it was solved.
fn step(step: &StepReport, unit: Unit, timed: bool) -> String {
    let object = step.object.as_ref().map(|o| format!(" \"{o}\"")).unwrap_or_default();
    let mut text = styled(BOLD, &format!("{}{object}", step.op));
    // The object that the step names needs no second name.
    let (own, others): (Vec<_>, Vec<_>) =
        step.objects.iter().partition(|change| step.object.as_ref() == Some(&change.name));
    let told = own.first().map(|change| changed(change, unit)).unwrap_or_default();
    text += &if told.is_empty() { "\n".to_owned() } else { format!("  {told}\n") };
    for change in others.iter().take(OBJECTS) {
        let name = styled(BOLD, &format!("\"{}\"", change.name));
        let _ = writeln!(text, "  {name}  {}", changed(change, unit));
    }
    if others.len() > OBJECTS {
        let _ = writeln!(text, "  … and {} more", others.len() - OBJECTS);
    }
    for asked in step.asked.iter().filter(|asked| !is_told(asked, step)) {
        let told = measures::pair(&asked.name, asked.value, unit, usize::from(asked.dimension));
        let _ = told.map(|told| writeln!(text, "  {told}"));
    }
    if let Some(count) = step.unchanged.filter(|&count| count > 0) {
        let _ = writeln!(text, "  {}", styled(DIM, &format!("{} as before", self::count(count, "object"))));
    }
    if !step.active.is_empty() {
        let _ = writeln!(text, "  bounds touched: {}", step.active.join(", "));
    }
    let (first, rest) = step.notes.split_at(step.leading.min(step.notes.len()));
    for note in first {
        let _ = writeln!(text, "  {note}");
    }
    let facts = facts(step, timed).join(" · ");
    if !facts.is_empty() {
        let _ = writeln!(text, "  {}", styled(DIM, &facts));
    }
    for name in step.redundant.iter().take(REDUNDANT) {
        let _ = writeln!(text, "  the other constraints say this already: {name}");
    }
    if step.redundant.len() > REDUNDANT {
        let _ = writeln!(text, "  … and {} more", step.redundant.len() - REDUNDANT);
    }
    if let Some(smooth) = step.smooth.as_ref().filter(|smooth| smooth.knots + smooth.bonds > 0) {
        let _ = writeln!(text, "  {}", styled(DIM, &smooth.to_string()));
    }
    for note in rest {
        let _ = writeln!(text, "  {}", styled(DIM, note));
    }
    text
}

/// Whether what was asked is an object's own area, length or volume, which its line tells.
fn is_told(asked: &AskedQuantity, step: &StepReport) -> bool {
    let own = |change: &ObjectChange| match asked.dimension {
        1 => change.length,
        2 => change.area,
        _ => change.volume,
    };
    let alike = |a: Option<f64>, b: Option<f64>| {
        a.zip(b).is_some_and(|(a, b)| (a.abs() - b.abs()).abs() <= AS_TOLD * a.abs())
    };
    step.objects
        .iter()
        .map(own)
        .any(|told| alike(asked.value.after, told.after) && alike(asked.value.before, told.before))
}

/// Two figures that differ by less than this part of them are one, by whatever rule each was summed up.
const AS_TOLD: f64 = 1e-6;

/// What became of an object, in the user's quantities.
fn changed(change: &ObjectChange, unit: Unit) -> String {
    let told = measures::change(change, unit);
    let what = match change.change {
        ChangeKind::Changed => "",
        ChangeKind::New => "new",
        ChangeKind::Gone => "gone",
    };
    [what, &told].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" · ")
}

/// The figures of a step that was solved; `timed` with the times that it took.
pub(crate) fn facts(step: &StepReport, timed: bool) -> Vec<String> {
    // What moves takes steps, each of which solves its equations; how many there are is in its notes.
    let moves = step.steps.is_some();
    let rank = match (step.rank, step.equations) {
        (Some(rank), Some(equations)) if moves => {
            Some(format!("{}{}", count(equations, "equation"), repeated(rank, equations, step.best_effort)))
                .filter(|_| equations > 0)
        }
        (Some(rank), Some(equations)) => {
            Some(format!("rank {rank} of {equations}{}", repeated(rank, equations, step.best_effort)))
        }
        (None, Some(equations)) => Some(count(equations, "equation")),
        (Some(rank), None) => Some(format!("rank {rank}")),
        (None, None) => None,
    };
    let all = [
        step.solver.clone(),
        rank,
        // What nothing was asked of met nothing.
        step.residual.filter(|_| !moves || step.equations != Some(0)).map(|r| match (moves, r == 0.0) {
            (false, _) => format!("residual {}", figure(r)),
            (true, true) => "met to rounding".to_owned(),
            (true, false) => format!("missed by {}", figure(r)),
        }),
        step.condition.map(|c| format!("condition {}", figure(c))),
        step.adjustment.map(|d| format!("adjustment {}", figure(d))),
        step.iterations.filter(|&n| n > 1 && !moves).map(|n| count(n, "iteration")),
        step.prepare_seconds.filter(|&t| timed && t > 0.0).map(|t| format!("prepared in {}", seconds(t))),
        step.event_seconds
            .filter(|&t| timed && t > 0.0)
            .map(|t| format!("{} {}", seconds(t), if moves { "a step" } else { "an event" })),
    ];
    all.into_iter().flatten().collect()
}

/// What the equations are that do not count for the rank.
fn repeated(rank: usize, equations: usize, contradict: bool) -> String {
    let more = equations.saturating_sub(rank);
    let (one, many) = if contradict {
        (
            "1 equation contradicts the others, or says what they say",
            "equations contradict the others, or say what they say",
        )
    } else {
        ("1 equation follows from the others", "equations follow from the others")
    };
    match more {
        0 => String::new(),
        1 => format!(" ({one})"),
        more => format!(" ({more} {many})"),
    }
}

fn output(output: &OutputReport, unit: Unit) -> String {
    let mut text = format!("wrote {}, {}\n", styled(BOLD, &output.path), bytes(output.bytes));
    for sibling in &output.siblings {
        let _ = writeln!(text, "  with {}, {}", sibling.path, bytes(sibling.bytes));
    }
    text + &written(&output.objects, unit, &output.notes)
}

/// How each object went out, indented; a long list is cut.
pub(crate) fn written(objects: &[Written], unit: Unit, notes: &[String]) -> String {
    const SHOWN: usize = 12;
    let mut text = String::new();
    for object in objects.iter().take(SHOWN) {
        // How far off it is at most, where that is known, else what was asked.
        let within = match (object.error, object.tolerance) {
            (Some(error), Some(asked)) if error <= ROUNDING * asked => Some("nowhere off".to_owned()),
            (error, asked) => error.or(asked).map(|most| format!("within {}", unit.quantity(most, 1))),
        };
        let how = match object.fate {
            Fate::Kept => {
                within.map_or_else(|| "exact".to_owned(), |within| format!("exact, triangles {within}"))
            }
            // Without a distance it is the same shape, said otherwise.
            Fate::Approximated => within.unwrap_or_else(|| "in another form".to_owned()),
            Fate::LeftOut => "left out".to_owned(),
        };
        let reason = object.reason.as_ref().map(|r| format!(": {r}")).unwrap_or_default();
        let form = if object.form.is_empty() { String::new() } else { format!("{}, ", object.form) };
        let _ = writeln!(text, "  {}  {form}{how}{reason}", object.object);
    }
    if objects.len() > SHOWN {
        let _ = writeln!(text, "  … and {} more", objects.len() - SHOWN);
    }
    for note in notes {
        let _ = writeln!(text, "  {}", styled(DIM, note));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_ends_where_its_words_end_and_names_a_few_of_many() {
        let plain =
            StepReport { op: "simplify".into(), object: Some("arch".into()), ..StepReport::default() };
        let text = step(&plain, Unit::Metre, false);
        assert!(text.lines().all(|line| line == line.trim_end()), "{text:?}");
        let redundant =
            |count: usize| StepReport { redundant: vec!["C0 join".into(); count], ..plain.clone() };
        let lines = |count: usize| {
            step(&redundant(count), Unit::Metre, false)
                .lines()
                .filter(|line| line.contains("say this already"))
                .count()
        };
        assert_eq!([lines(0), lines(1), lines(5), lines(400)], [0, 1, 5, 5]);
        assert!(
            step(&redundant(400), Unit::Metre, false).ends_with("\n  … and 395 more\n"),
            "{}",
            step(&redundant(400), Unit::Metre, false)
        );
        assert!(!step(&redundant(5), Unit::Metre, false).contains("more"));
    }

    /// Distances have the scene's unit, and one that is rounding is told as such.
    #[test]
    fn how_near_triangles_are_has_a_unit() {
        let near = |error: f64| {
            let object = loftsman_kernel::scene::Object::new("o", loftsman_kernel::scene::Geometry::Group);
            let mut one = Written::kept(&object, "4 triangles");
            one.cut(0.01, Some(error));
            written(&[one], Unit::Millimetre, &[])
        };
        assert_eq!(near(0.0082), "  o  4 triangles, exact, triangles within 0.0082 mm\n");
        assert_eq!(near(9.9e-19), "  o  4 triangles, exact, triangles nowhere off\n");
    }

    /// What a step was run for stands before how it was solved, whatever number of notes it says these are.
    #[test]
    fn results_are_told_before_how_they_were_found() {
        let notes = vec!["near to 0.1 m".to_owned(), "of an even curvature".to_owned()];
        let report = |leading| StepReport {
            op: "fit".into(),
            residual: Some(1e-16),
            notes: notes.clone(),
            leading,
            ..StepReport::default()
        };
        let lines = |leading| {
            let text = step(&report(leading), Unit::Metre, false);
            ["near to", "residual", "of an even"]
                .map(|part| text.lines().position(|l| l.contains(part)).unwrap())
        };
        assert_eq!([0, 1, 2, 9].map(lines), [[2, 1, 3], [1, 2, 3], [1, 3, 2], [1, 3, 2]]);
    }

    /// How long a step took is nothing that it did: it is told where it is asked for. What a step makes has its name once.
    #[test]
    fn times_are_told_where_they_are_asked_for_and_names_once() {
        let made = ObjectChange { name: "rim".into(), change: ChangeKind::New, ..ObjectChange::default() };
        let report = StepReport {
            op: "offset".into(),
            object: Some("rim".into()),
            objects: vec![made],
            residual: Some(0.0),
            prepare_seconds: Some(72e-6),
            event_seconds: Some(9e-6),
            ..StepReport::default()
        };
        let [plain, timed] = [false, true].map(|timed| step(&report, Unit::Metre, timed));
        assert!(!plain.contains("prepared") && !plain.contains("event"), "{plain}");
        assert!(timed.contains("prepared in 72 µs · 9.0 µs an event"), "{timed}");
        assert_eq!(plain.matches("rim").count(), 1, "{plain}");
        assert!(plain.contains("new"), "{plain}");
    }
}

//! What people see: the standard output, messages, and figures short enough to read.

use std::io::Write;

use anstyle::{AnsiColor, Style};
use loftsman_kernel::text;

/// Names of objects and files.
pub(crate) const BOLD: Style = Style::new().bold();
/// What matters less.
pub(crate) const DIM: Style = Style::new().dimmed();
const RED: Style = AnsiColor::Red.on_default().bold();

/// The text in a style; the standard streams drop it where they are no terminal.
pub(crate) fn styled(style: Style, text: &str) -> String {
    format!("{style}{text}{style:#}")
}

/// Prints text on the standard output.
pub(crate) fn print(text: &str) -> anyhow::Result<()> {
    let mut stream = anstream::stdout().lock();
    stream.write_all(text.as_bytes())?;
    Ok(stream.flush()?)
}

/// Prints bytes on the standard output, unchanged.
pub(crate) fn print_bytes(bytes: &[u8]) -> anyhow::Result<()> {
    let mut stream = std::io::stdout().lock();
    stream.write_all(bytes)?;
    Ok(stream.flush()?)
}

/// Prints one JSON value on the standard output. Numbers read back exactly.
pub(crate) fn print_json(value: &impl serde::Serialize) -> anyhow::Result<()> {
    let mut text = serde_json::to_string_pretty(value)?;
    text.push('\n');
    print_bytes(text.as_bytes())
}

/// An error, on the standard error.
pub(crate) fn error(text: &str) {
    // Nobody is left to be told when this fails.
    let _ = writeln!(anstream::stderr().lock(), "{}: {}", styled(RED, "error"), printable(text));
}

/// Something that was done, but not wholly, on the standard error.
pub(crate) fn warning(text: &str) {
    // Nobody is left to be told when this fails.
    let _ = writeln!(anstream::stderr().lock(), "{}: {}", styled(BOLD, "warning"), printable(text));
}

/// Text from files may hold control characters, which a terminal would obey.
fn printable(text: &str) -> String {
    text.chars()
        .map(|c| if c.is_control() && c != '\n' && c != '\t' { char::REPLACEMENT_CHARACTER } else { c })
        .collect()
}

/// A number in about four figures.
pub(crate) fn figure(number: f64) -> String {
    // What is below that is told for its size only.
    if number.abs() < 1e-4 { text::short(number) } else { text::figure(number) }
}

/// A number of bytes.
pub(crate) fn bytes(count: u64) -> String {
    const STEPS: [(f64, &str); 3] = [(1e9, "GB"), (1e6, "MB"), (1e3, "kB")];
    let count = count as f64;
    match STEPS.iter().find(|(size, _)| count >= *size) {
        Some((size, unit)) => format!("{:.1} {unit}", count / size),
        None => format!("{count} bytes"),
    }
}

/// A time.
pub(crate) fn seconds(time: f64) -> String {
    const STEPS: [(f64, &str); 3] = [(1.0, "s"), (1e-3, "ms"), (1e-6, "µs")];
    match STEPS.iter().find(|(size, _)| time >= *size) {
        Some((size, unit)) => {
            let number = time / size;
            let decimals = if number < 9.95 { 1 } else { 0 };
            format!("{number:.decimals$} {unit}")
        }
        None => format!("{:.0} ns", time * 1e9),
    }
}

/// `1 curve`, `2 curves`.
pub(crate) fn count(number: usize, what: &str) -> String {
    let plural = match (number, what) {
        (1, _) => what.to_owned(),
        (_, "vertex") => "vertices".to_owned(),
        _ => format!("{what}s"),
    };
    format!("{number} {plural}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_short() {
        let cases = [(0.0, "0"), (3.2e-16, "3.2e-16"), (3e-16, "3e-16"), (0.21234, "0.2123"), (-12.0, "-12")];
        for (number, text) in cases {
            assert_eq!(figure(number), text);
        }
        assert_eq!((bytes(12), bytes(1_234_567)), ("12 bytes".into(), "1.2 MB".into()));
        assert_eq!(
            (seconds(0.00154), seconds(43.4e-6), seconds(3e-8)),
            ("1.5 ms".into(), "43 µs".into(), "30 ns".into())
        );
        assert_eq!((count(1, "vertex"), count(2, "vertex")), ("1 vertex".into(), "2 vertices".into()));
        assert_eq!(printable("a\x1b[31m"), "a\u{fffd}[31m");
    }
}

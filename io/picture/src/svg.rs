//! Writing SVG: elements, attributes, escaped text, numbers of the page.

use std::fmt::Write;

/// A length on the page with three decimals (a micrometre), without trailing zeros and without "-0".
pub(crate) fn length(value: f64) -> String {
    let mut text = format!("{value:.3}");
    let kept = text.trim_end_matches('0').trim_end_matches('.').len();
    text.truncate(kept);
    if text == "-0" { "0".to_owned() } else { text }
}

/// A text as XML may hold it: markup escaped, line breaks as spaces, characters that XML forbids as U+FFFD.
pub(crate) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\t' | '\n' | '\r' => out.push(' '),
            '\u{0}'..='\u{1f}' | '\u{7f}'..='\u{9f}' | '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            other => out.push(other),
        }
    }
    out
}

/// One element under construction: `Element::new("path").attribute("d", …)`.
#[derive(Debug, Clone)]
pub(crate) struct Element {
    name: &'static str,
    text: String,
}

impl Element {
    /// An element without attributes.
    pub(crate) fn new(name: &'static str) -> Self {
        Self { name, text: format!("<{name}") }
    }

    /// Adds an attribute; its value is escaped.
    #[must_use]
    pub(crate) fn attribute(mut self, name: &str, value: &str) -> Self {
        // Writing to a string cannot fail.
        let _ = write!(self.text, " {name}=\"{}\"", escaped(value));
        self
    }

    /// Adds a length of the page.
    #[must_use]
    pub(crate) fn length(self, name: &str, value: f64) -> Self {
        self.attribute(name, &length(value))
    }

    /// The element without content.
    pub(crate) fn empty(mut self) -> String {
        self.text.push_str("/>\n");
        self.text
    }

    /// The element around a text, which is escaped.
    pub(crate) fn text(mut self, content: &str) -> String {
        let _ = writeln!(self.text, ">{}</{}>", escaped(content), self.name);
        self.text
    }

    /// The element around other elements.
    pub(crate) fn around(mut self, content: &str) -> String {
        let _ = write!(self.text, ">\n{content}</{}>\n", self.name);
        self.text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_short_and_have_no_negative_zero() {
        assert_eq!([0.0, -0.0001, 1.5, 2.00049, -8.1236].map(length), ["0", "0", "1.5", "2", "-8.124"]);
        assert_eq!(length(100.0), "100");
    }

    #[test]
    fn hostile_names_stay_text() {
        let text = Element::new("title").text("a<b>&\"'\u{0}\u{1b}\n]]>");
        assert_eq!(text, "<title>a&lt;b&gt;&amp;&quot;&#39;\u{fffd}\u{fffd} ]]&gt;</title>\n");
    }
}

//! Reading back what `svg` writes: tags with quoted attributes, texts, five escapes.

use std::borrow::Cow;

/// What comes next in a document.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Token<'a> {
    Open(Tag<'a>),
    Text(Cow<'a, str>),
    Close,
}

/// An element's name and attributes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tag<'a> {
    pub(super) name: &'a str,
    pub(super) attributes: Vec<(&'a str, Cow<'a, str>)>,
    /// Whether it ends where it starts.
    pub(super) empty: bool,
}

/// The tokens of a document, in order; an error is the last.
#[derive(Debug)]
pub(super) struct Reader<'a> {
    rest: &'a str,
}

impl<'a> Reader<'a> {
    pub(super) fn new(document: &'a str) -> Self {
        // The declaration says version and encoding, which are always the same.
        let rest = match document.strip_prefix("<?xml") {
            Some(rest) => rest.split_once("?>").map_or("", |(_, rest)| rest),
            None => document,
        };
        Self { rest: rest.trim_start() }
    }

    fn token(&mut self) -> Result<Token<'a>, String> {
        let Some(rest) = self.rest.strip_prefix('<') else {
            let end = self.rest.find('<').unwrap_or(self.rest.len());
            let (text, rest) = self.rest.split_at(end);
            self.rest = rest;
            return Ok(Token::Text(unescaped(text)?));
        };
        // No attribute holds a ">" that is not escaped.
        let (inside, rest) =
            rest.split_once('>').ok_or_else(|| format!("a tag has no end: {}", start_of(rest)))?;
        self.rest = rest;
        if inside.starts_with('/') {
            return Ok(Token::Close);
        }
        let (inside, empty) = inside.strip_suffix('/').map_or((inside, false), |inside| (inside, true));
        let (name, mut list) = inside.split_once(' ').unwrap_or((inside, ""));
        let mut attributes = Vec::new();
        while !list.is_empty() {
            let parts = list.split_once("=\"").and_then(|(name, rest)| Some((name, rest.split_once('"')?)));
            let (name, (value, rest)) = parts.ok_or_else(|| format!("no attributes: {}", start_of(list)))?;
            attributes.push((name.trim_start(), unescaped(value)?));
            list = rest;
        }
        Ok(Token::Open(Tag { name, attributes, empty }))
    }
}

impl<'a> Iterator for Reader<'a> {
    type Item = Result<Token<'a>, String>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        let token = self.token();
        if token.is_err() {
            self.rest = "";
        }
        Some(token)
    }
}

impl Tag<'_> {
    /// The text of an attribute, where there is one.
    pub(super) fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(n, _)| *n == name).map(|(_, value)| value.as_ref())
    }

    /// The text of an attribute that has to be there.
    pub(super) fn text(&self, name: &str) -> Result<&str, String> {
        self.attribute(name).ok_or_else(|| format!("<{}> has no {name}", self.name))
    }

    /// A number that has to be there.
    pub(super) fn number(&self, name: &str) -> Result<f32, String> {
        number(self.text(name)?)
    }

    /// A number, or what it is where it is not there.
    pub(super) fn number_or(&self, name: &str, other: f32) -> Result<f32, String> {
        self.attribute(name).map_or(Ok(other), number)
    }

    /// Numbers with spaces in between.
    pub(super) fn numbers<const N: usize>(&self, name: &str) -> Result<[f32; N], String> {
        let text = self.text(name)?;
        let list = text.split(' ').map(number).collect::<Result<Vec<_>, _>>()?;
        list.try_into().map_err(|_| format!("{name}=\"{text}\" has not {N} numbers"))
    }
}

pub(super) fn number(text: &str) -> Result<f32, String> {
    // By way of `f64`, as SVG's own numbers go.
    text.parse::<f64>().map(|value| value as f32).map_err(|_| format!("{:?} is no number", start_of(text)))
}

fn start_of(text: &str) -> String {
    text.chars().take(40).collect()
}

/// A text without the escapes that `svg::escaped` writes.
fn unescaped(text: &str) -> Result<Cow<'_, str>, String> {
    if !text.contains('&') {
        return Ok(Cow::Borrowed(text));
    }
    let mut parts = text.split('&');
    let mut out = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (name, rest) = part.split_once(';').unwrap_or((part, ""));
        out.push(match name {
            "amp" => '&',
            "lt" => '<',
            "gt" => '>',
            "quot" => '"',
            "#39" => '\'',
            _ => return Err(format!("the escape &{} is unknown", start_of(name))),
        });
        out.push_str(rest);
    }
    Ok(Cow::Owned(out))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::svg::Element;

    #[test]
    fn what_was_written_is_read() {
        let hostile = "a<b>&\"'/> =\" é";
        let child = Element::new("text").attribute("class", hostile).length("x", -1.5).text(hostile);
        let written = Element::new("g").around(&(child + &Element::new("path").attribute("d", "").empty()));
        let tokens: Vec<Token<'_>> = Reader::new(&written).collect::<Result<_, _>>().unwrap();
        let Token::Open(text) = &tokens[2] else { panic!("{tokens:?}") };
        assert_eq!((text.name, text.attribute("class")), ("text", Some(hostile)));
        assert_eq!((text.number("x"), text.empty), (Ok(-1.5), false));
        assert_eq!(tokens[3], Token::Text(hostile.into()));
        let Token::Open(path) = &tokens[6] else { panic!("{tokens:?}") };
        assert_eq!((path.name, path.attribute("d"), path.empty), ("path", Some(""), true));
        assert_eq!(tokens.iter().filter(|token| **token == Token::Close).count(), 2);
    }

    #[test]
    fn what_nobody_wrote_is_refused() {
        for text in ["<g", "<g x>", "<g x=\"1>", "a&nbsp;b", "a&"] {
            assert!(Reader::new(text).any(|token| token.is_err()), "{text}");
        }
    }
}

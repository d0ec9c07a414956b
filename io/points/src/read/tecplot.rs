//! Tecplot's header statements: `TITLE = …`, `VARIABLES = …`, `ZONE T="…", I=129, F=POINT`.

use super::line::text;

/// What the headers have said so far.
#[derive(Debug, Default)]
pub(super) struct Tecplot {
    /// Whether there has been a header.
    seen: bool,
    /// Whether variables are being listed, a name a line.
    listing: bool,
    variables: Vec<String>,
    /// A zone that has just been opened, with its name.
    zone: Option<Option<String>>,
}

impl Tecplot {
    /// Whether a line is a header statement, or goes on with one.
    ///
    /// # Errors
    /// Where it says that the numbers are not in rows.
    pub(super) fn takes(&mut self, line: &[u8]) -> Result<bool, String> {
        // Rows start with a digit or a sign; most lines are rows.
        if line.first().is_none_or(|b| !(b.is_ascii_alphabetic() || *b == b'"')) {
            return Ok(false);
        }
        let equals = line.contains(&b'=');
        if self.listing && line.starts_with(b"\"") && !equals {
            self.variables.extend(names(line));
            return Ok(true);
        }
        let word = line.iter().position(|b| !b.is_ascii_alphabetic()).unwrap_or(line.len());
        let keyword = line[..word].to_ascii_uppercase();
        let starts = matches!(keyword.as_slice(), b"TITLE" | b"VARIABLES" | b"ZONE" | b"FILETYPE") && equals;
        // ZONE may go on over several lines: `I=129, J=1`, `DATAPACKING=POINT`.
        if !(starts || self.seen && equals || self.seen && keyword == b"ZONE") {
            return Ok(false);
        }
        self.seen = true;
        self.listing = keyword == b"VARIABLES";
        if self.listing {
            self.variables = names(line);
        }
        let upper: Vec<u8> =
            line.iter().filter(|b| !b.is_ascii_whitespace()).map(u8::to_ascii_uppercase).collect();
        if [&b"F=BLOCK"[..], b"PACKING=BLOCK"]
            .iter()
            .any(|packing| upper.windows(packing.len()).any(|w| w == *packing))
        {
            let problem =
                "the zone has its numbers in blocks, a variable after the other: write it with F=POINT";
            return Err(problem.to_owned());
        }
        if keyword == b"ZONE" {
            self.zone = Some(names(line).into_iter().next().filter(|name| !name.is_empty()));
        }
        Ok(true)
    }

    /// The zone that the last line opened: its name, if it has one.
    pub(super) fn zone(&mut self) -> Option<Option<String>> {
        self.zone.take()
    }

    /// The names of the variables, if there are as many as columns.
    pub(super) fn variables(&self, count: usize) -> Option<Vec<String>> {
        (self.variables.len() == count).then(|| self.variables.clone())
    }
}

/// What stands in double quotes in a line.
fn names(line: &[u8]) -> Vec<String> {
    let mut parts = line.split(|&b| b == b'"');
    let mut names = Vec::new();
    while let (Some(_), Some(inside)) = (parts.next(), parts.next()) {
        names.push(text(inside.trim_ascii()));
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_and_what_only_looks_like_them() {
        let mut tecplot = Tecplot::default();
        assert_eq!(tecplot.takes(b"Zone 5 airfoil"), Ok(false));
        assert_eq!(tecplot.takes(b"a = 5"), Ok(false));
        assert_eq!(tecplot.takes(b"VARIABLES = \"x\""), Ok(true));
        assert_eq!(tecplot.takes(b"\"y\" \"cp\""), Ok(true));
        assert_eq!(tecplot.variables(3).unwrap(), ["x", "y", "cp"]);
        assert_eq!(tecplot.takes(b"zone T=\"upper side\""), Ok(true));
        assert_eq!(tecplot.zone(), Some(Some("upper side".to_owned())));
        assert_eq!(tecplot.takes(b"I=129, J=1, F=POINT"), Ok(true));
        assert_eq!(tecplot.zone(), None);
        assert!(tecplot.takes(b"DATAPACKING = BLOCK").is_err());
    }
}

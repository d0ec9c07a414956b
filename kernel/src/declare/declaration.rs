//! What an entry of the registry is called and which fields it takes.

/// A field that an operation, a functional or a format takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Field {
    /// Its name in recipes.
    pub name: &'static str,
    /// What it takes, for people: `"number"`, `"[x, y, z]"`, `"\"least\" | \"bend\""`.
    pub takes: &'static str,
    /// Its default, for people; `None` where it must be given.
    pub default: Option<&'static str>,
    /// One line of help.
    pub help: &'static str,
}

impl Field {
    /// A field that must be given.
    pub const fn required(name: &'static str, takes: &'static str, help: &'static str) -> Self {
        Self { name, takes, default: None, help }
    }

    /// A field that may be left out; `default` says what holds then.
    pub const fn optional(
        name: &'static str,
        takes: &'static str,
        default: &'static str,
        help: &'static str,
    ) -> Self {
        Self { name, takes, default: Some(default), help }
    }
}

/// A name, one line of help and the fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Declaration {
    /// The name in recipes: `"edit"`, `"position"`, …
    pub name: &'static str,
    /// One line of help.
    pub help: &'static str,
    /// The fields it takes.
    pub fields: &'static [Field],
}

/// What the tables take that a field lists: `forces = [{ at = 1.5, force = [0, 0, 2] }, …]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Table {
    /// The field whose list they are in.
    pub field: &'static str,
    /// One line of help.
    pub help: &'static str,
    /// What each of them takes.
    pub fields: &'static [Field],
    /// What a table of one `kind` takes beside that; none where there are no kinds.
    pub kinds: &'static [Declaration],
}

/// The name that was probably meant: the most similar of `names`, if one is similar at all.
pub fn nearest<'a>(wanted: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // A long garbage string is similar to nothing, and measuring it would cost its length squared.
    if wanted.len() > 64 {
        return None;
    }
    let mut best: Option<(f64, &str)> = None;
    for name in names {
        if name.len() > 64 {
            continue;
        }
        let similarity = strsim::jaro_winkler(&wanted.to_lowercase(), &name.to_lowercase());
        if similarity > 0.75 && best.is_none_or(|(b, _)| similarity > b) {
            best = Some((similarity, name));
        }
    }
    best.map(|(_, name)| name)
}

/// What to say of a name that nobody knows: the nearest of `names`, or else `otherwise`.
pub fn hint<'a>(
    wanted: &str,
    names: impl IntoIterator<Item = &'a str>,
    otherwise: impl FnOnce() -> String,
) -> String {
    nearest(wanted, names).map_or_else(otherwise, |near| format!("did you mean \"{near}\"?"))
}

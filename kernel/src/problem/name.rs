//! What a constraint is called in reports.

use std::fmt;
use std::ops::Deref;
use std::sync::{Arc, OnceLock};

use crate::functional::Functional;

/// What something is called, for people: a text that is made when it is first read, since most reports are made and never read.
#[derive(Clone, Default)]
pub struct Name {
    /// What describes itself, and which axis of it is meant, where the text is yet to be made.
    of: Option<(Arc<dyn Functional>, Option<&'static str>)>,
    text: OnceLock<String>,
}

impl Name {
    /// That of a functional, or of one axis of it: `x of position at 0.25`.
    pub(crate) fn of(functional: &Arc<dyn Functional>, axis: Option<&'static str>) -> Self {
        Self { of: Some((Arc::clone(functional), axis)), text: OnceLock::new() }
    }
}

impl Deref for Name {
    type Target = String;

    fn deref(&self) -> &String {
        self.text.get_or_init(|| match &self.of {
            None => String::new(),
            Some((functional, None)) => functional.describe(),
            Some((functional, Some(axis))) => format!("{axis} of {}", functional.describe()),
        })
    }
}

impl From<String> for Name {
    fn from(text: String) -> Self {
        Self { of: None, text: OnceLock::from(text) }
    }
}

impl From<&str> for Name {
    fn from(text: &str) -> Self {
        text.to_owned().into()
    }
}

impl From<Name> for String {
    fn from(name: Name) -> Self {
        String::clone(&name)
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&**self, f)
    }
}

impl fmt::Debug for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&**self, f)
    }
}

impl PartialEq for Name {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl PartialEq<str> for Name {
    fn eq(&self, other: &str) -> bool {
        **self == *other
    }
}

impl PartialEq<String> for Name {
    fn eq(&self, other: &String) -> bool {
        **self == *other
    }
}

impl PartialEq<&str> for Name {
    fn eq(&self, other: &&str) -> bool {
        **self == **other
    }
}

impl serde::Serialize for Name {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::functional::position;

    #[test]
    fn a_name_is_that_of_its_functional_whenever_it_is_read() {
        let functional: Arc<dyn Functional> = Arc::new(position(0.25));
        let (whole, part) = (Name::of(&functional, None), Name::of(&functional, Some("x")));
        assert_eq!(whole, "position at 0.25");
        assert_eq!((part.to_string(), part.clone()), ("x of position at 0.25".to_owned(), part));
        assert_eq!(Name::from("here"), Name::from("here".to_owned()));
        assert!(Name::default().is_empty() && whole != Name::default());
    }
}

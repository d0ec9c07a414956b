//! Colours, layers, and what is hidden.

use std::collections::{HashMap, HashSet};

use loftsman_kernel::mesh::color::from_srgb;

use super::entity::{Args, Got, entity, kind};
use crate::light;
use crate::part21::{File, Value};

/// What is said of how entities look.
#[derive(Debug, Default)]
pub(crate) struct Styles {
    colors: HashMap<u64, [f64; 4]>,
    layers: HashMap<u64, String>,
    /// The layers, with what stands beside their names.
    pub(crate) named: Vec<(String, String)>,
    /// The colours that things have in some context only.
    pub(crate) within: Vec<Within>,
    /// Names of layers that are hidden.
    pub(crate) hidden: HashSet<String>,
    /// The entities that say it.
    pub(crate) read: Vec<u64>,
}

/// A colour that something has in a context: where one occurrence shows it.
#[derive(Debug)]
pub(crate) struct Within {
    /// The entity that says so.
    pub(crate) number: u64,
    pub(crate) item: u64,
    pub(crate) context: u64,
    pub(crate) color: [f64; 4],
}

impl Styles {
    /// The colour of an entity, linear.
    pub(crate) fn color(&self, number: u64) -> Option<[f64; 4]> {
        self.colors.get(&number).copied()
    }

    /// The layer of an entity.
    pub(crate) fn layer(&self, number: u64) -> Option<&String> {
        self.layers.get(&number)
    }

    /// Takes in one STYLED_ITEM or OVER_RIDING_STYLED_ITEM.
    pub(crate) fn style(&mut self, file: &File<'_>, number: u64) -> Got<()> {
        let styled = entity(file, number)?;
        let args = styled.args();
        let item = args.reference(2)?;
        let (mut context, mut search) =
            (None, Search { file, color: None, said: None, alpha: 1.0, left: 256 });
        for style in args.references(1)? {
            if kind(file, style) == b"PRESENTATION_STYLE_BY_CONTEXT" {
                let by_context = entity(file, style)?;
                context = context.or(by_context.args().reference(1).ok());
                by_context.args().references(0)?.into_iter().for_each(|style| search.visit(style, 0));
            } else {
                search.visit(style, 0);
            }
        }
        if let Some([r, g, b]) = search.color {
            let color = light::exact([from_srgb(r), from_srgb(g), from_srgb(b), search.alpha], search.said);
            if color.iter().all(|c| c.is_finite()) {
                match context {
                    Some(context) => self.within.push(Within { number, item, context, color }),
                    None => {
                        self.colors.insert(item, color);
                        self.read.push(number);
                    }
                }
            }
        }
        Ok(())
    }

    /// Takes in colours in contexts that are no occurrences: those of what has no other.
    pub(crate) fn everywhere(&mut self, left: Vec<Within>) {
        for Within { number, item, color, .. } in left {
            self.colors.entry(item).or_insert(color);
            self.read.push(number);
        }
    }

    /// Takes in one PRESENTATION_LAYER_ASSIGNMENT.
    pub(crate) fn assign(&mut self, file: &File<'_>, number: u64) -> Got<()> {
        let assignment = entity(file, number)?;
        let args = assignment.args();
        let (name, about) = (args.name(0), args.name(1));
        if name.is_empty() {
            return Ok(());
        }
        for item in args.references(2)? {
            self.layers.insert(item, name.clone());
        }
        if self.named.iter().all(|(known, _)| *known != name) {
            self.named.push((name, about));
        }
        self.read.push(number);
        Ok(())
    }

    /// Takes in one INVISIBILITY: of layers.
    pub(crate) fn hide(&mut self, file: &File<'_>, number: u64) -> Got<()> {
        let invisible = entity(file, number)?;
        for item in invisible.args().references(0)? {
            if kind(file, item) == b"PRESENTATION_LAYER_ASSIGNMENT" {
                self.hidden.insert(entity(file, item)?.args().name(0));
                self.read.push(number);
            }
        }
        Ok(())
    }
}

/// A search for the first colour of a style, down the entities that it names.
struct Search<'r, 'f> {
    file: &'r File<'f>,
    color: Option<[f64; 3]>,
    /// What its name says of it.
    said: Option<[f64; 4]>,
    alpha: f64,
    /// How many entities may still be looked at: styles that name themselves end.
    left: usize,
}

impl Search<'_, '_> {
    fn visit(&mut self, number: u64, depth: usize) {
        if depth > 12 || self.left == 0 {
            return;
        }
        self.left -= 1;
        // What is malformed in a style leaves the colour out, which is seen in the report.
        let Ok(entity) = entity(self.file, number) else { return };
        let args = entity.args();
        match entity.only() {
            b"COLOUR_RGB" if self.color.is_none() => {
                if let (Ok(r), Ok(g), Ok(b)) = (args.real(1), args.real(2), args.real(3)) {
                    self.color = Some([r, g, b]);
                    self.said = light::parse(&args.name(0));
                }
            }
            b"DRAUGHTING_PRE_DEFINED_COLOUR" | b"PRE_DEFINED_COLOUR" if self.color.is_none() => {
                self.color = named(&args.name(0));
            }
            b"SURFACE_STYLE_TRANSPARENT" => {
                if let Ok(transparency) = args.real(0) {
                    self.alpha = (1.0 - transparency).clamp(0.0, 1.0);
                }
            }
            // The colour of text and hatching is not that of the thing.
            b"TEXT_STYLE_FOR_DEFINED_FONT" | b"FILL_AREA_STYLE_HATCHING" => {}
            _ => self.below(&args, depth),
        }
    }

    fn below(&mut self, args: &Args<'_, '_>, depth: usize) {
        for value in args.values {
            match value {
                Value::Reference(number) => self.visit(*number, depth + 1),
                Value::List(values) => self.below(&Args { values, ..*args }, depth),
                _ => {}
            }
        }
    }
}

/// The colours that have names (ISO 10303-46).
fn named(name: &str) -> Option<[f64; 3]> {
    Some(match name.to_ascii_lowercase().as_str() {
        "red" => [1.0, 0.0, 0.0],
        "green" => [0.0, 1.0, 0.0],
        "blue" => [0.0, 0.0, 1.0],
        "yellow" => [1.0, 1.0, 0.0],
        "magenta" => [1.0, 0.0, 1.0],
        "cyan" => [0.0, 1.0, 1.0],
        "black" => [0.0, 0.0, 0.0],
        "white" => [1.0, 1.0, 1.0],
        _ => return None,
    })
}

//! The reader: finds the entities, then builds what the products are made of.

mod brep;
mod curve;
mod emit;
mod entity;
mod facets;
mod items;
mod occurrence;
mod parameters;
mod place;
mod product;
mod report;
mod spline;
mod style;
mod surface;
mod swept;
mod turned;
mod twice;
mod units;
mod wound;

use loftsman_kernel::plugin::{Confidence, FormatError, Place, ReadOptions, ReadReport, Source};
use loftsman_kernel::scene::Scene;

use crate::part21::{File, Kind};
use emit::Emitter;
use product::{Products, Sources};
use report::Account;
use style::Styles;
use units::Contexts;

/// How sure the first bytes of a file are those of a STEP file.
pub(crate) fn confidence(head: &[u8]) -> Confidence {
    let text = loftsman_kernel::text::unmarked(head).trim_ascii_start();
    if text.starts_with(b"ISO-10303-21") { Confidence::Sure } else { Confidence::No }
}

/// Reads a file.
pub(crate) fn read(
    source: &dyn Source,
    options: &ReadOptions<'_>,
) -> Result<(Scene, ReadReport), FormatError> {
    let bytes = source.bytes();
    loftsman_kernel::plugin::refuse_utf16(bytes, 0)?;
    let file = File::scan(bytes).map_err(|fault| {
        FormatError::new(Place::Line(crate::part21::line(bytes, fault.at)), fault.problem)
    })?;
    options.limits.check_entities(file.len() + file.doubled.len())?;
    let mut account = Account::new(&file);
    let (sources, mut styles) = survey(&file, &mut account);
    let mut contexts = Contexts::default();
    let mut products = Products::read(&file, &sources, &mut contexts);
    account.problems(std::mem::take(&mut products.problems));
    occurrence::color(&file, &mut products, &mut styles, &mut account);
    let name = source.name().rsplit(['/', '\\']).next().unwrap_or_default();
    let stem = name.split('.').next().filter(|stem| !stem.is_empty()).unwrap_or("object");
    let scene = Emitter::new(&file, &products, &styles, &mut contexts, &mut account, stem).scene(options)?;
    account.keep_alone(&styles.read);
    account.keep_alone(&products.read);
    if contexts.silent {
        account.note(contexts.told_silent(&file));
    }
    account.finish(scene)
}

/// Sorts the entities that others are found from.
fn survey(file: &File<'_>, account: &mut Account<'_, '_>) -> (Sources, Styles) {
    let (mut sources, mut styles) = (Sources::default(), Styles::default());
    let mut overriding = Vec::new();
    for place in 0..file.len() {
        let number = file.number(place);
        let Kind::One(kind) = file.kind(place) else { continue };
        let said = match kind {
            b"SHAPE_DEFINITION_REPRESENTATION" => {
                sources.shapes.push(number);
                Ok(())
            }
            b"SHAPE_REPRESENTATION_RELATIONSHIP" | b"REPRESENTATION_RELATIONSHIP" => {
                sources.relations.push(number);
                Ok(())
            }
            b"CONTEXT_DEPENDENT_SHAPE_REPRESENTATION" => {
                sources.placements.push(number);
                Ok(())
            }
            b"NEXT_ASSEMBLY_USAGE_OCCURRENCE" => {
                sources.usages.push(number);
                Ok(())
            }
            b"PROPERTY_DEFINITION_REPRESENTATION" => {
                sources.properties.push(number);
                Ok(())
            }
            b"STYLED_ITEM" => styles.style(file, number),
            b"OVER_RIDING_STYLED_ITEM" => {
                overriding.push(number);
                Ok(())
            }
            b"PRESENTATION_LAYER_ASSIGNMENT" => styles.assign(file, number),
            b"INVISIBILITY" => styles.hide(file, number),
            _ if kind.ends_with(b"SHAPE_REPRESENTATION") || kind == b"TESSELLATED_SHAPE_REPRESENTATION" => {
                sources.representations.push(number);
                Ok(())
            }
            _ => Ok(()),
        };
        if let Err(problem) = said {
            account.problems(vec![problem]);
        }
    }
    for number in overriding {
        if let Err(problem) = styles.style(file, number) {
            account.problems(vec![problem]);
        }
    }
    (sources, styles)
}

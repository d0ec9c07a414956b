//! Why nothing of a file is in the scene, with a place in it: the first cause, or what stands where geometry should.

use loftsman_kernel::text::clip;

use super::super::entity::{entity, kind};
use super::super::product::representation;
use super::{Account, unknown_schema};
use crate::part21::Kind;

/// What is said of entities that name what is left out: no cause, but a consequence.
const CONSEQUENCE: &str = " in it is left out";

impl Account<'_, '_> {
    /// What an error says where nothing was read.
    pub(super) fn nothing(&self) -> String {
        let schemas = &self.file.header.schemas;
        let strange = unknown_schema(schemas).map(|told| format!(" ({told})")).unwrap_or_default();
        let cause = self.at_fault.iter().find(|(_, text)| !text.ends_with(CONSEQUENCE));
        match cause.or_else(|| self.at_fault.iter().next()) {
            Some((&number, text)) => {
                let told = match self.file.place(number) {
                    Some(_) => self.told(number, text),
                    None => self.told_missing(number, self.who_names(&[number])[0].1),
                };
                format!("nothing in it can be read: {told}{strange}")
            }
            None => {
                let why = self.instead();
                format!(
                    "there is no geometry in it that is read: no solid, surface, curve or mesh of a product; {why}{strange}"
                )
            }
        }
    }

    /// What stands where geometry should, where nothing is wrong with any entity.
    fn instead(&self) -> String {
        let file = self.file;
        let is_representation = |place: &usize| match file.kind(*place) {
            Kind::One(kind) => kind.ends_with(b"SHAPE_REPRESENTATION"),
            Kind::Several => false,
        };
        let listed = |number: u64| -> Vec<u64> {
            let found = entity(file, number);
            found.and_then(|found| representation(&found)?.references(1)).unwrap_or_default()
        };
        let all: Vec<u64> =
            (0..file.len()).filter(is_representation).map(|place| file.number(place)).collect();
        let strange = |&number: &u64| {
            let item = listed(number).into_iter().find(|&item| kind(file, item) != b"AXIS2_PLACEMENT_3D")?;
            Some((number, item))
        };
        if let Some((number, item)) = all.iter().find_map(strange) {
            let what = if item == number { "itself".to_owned() } else { self.named(item) };
            return self.told(number, &format!("it lists {what}, which is none of these"));
        }
        if let Some(&number) = all.first() {
            let what = if listed(number).is_empty() { "nothing" } else { "nothing but placements" };
            return self.told(number, &format!("it lists {what}"));
        }
        match file.len() {
            0 => format!("not one entity stands in its {} lines: get the file again", file.lines()),
            count => {
                let first = self.named(file.number(0));
                format!(
                    "none of its entities ({count}, the first is {first}) is a representation that lists what a product consists of"
                )
            }
        }
    }

    /// An entity as messages name it: `#345 (CARTESIAN_POINT), line 812`.
    pub(super) fn named(&self, number: u64) -> String {
        match self.file.place(number) {
            Some(place) => {
                let kind = match self.file.kind(place) {
                    Kind::One(name) => clip(&String::from_utf8_lossy(name)),
                    Kind::Several => "of several types".to_owned(),
                };
                format!("#{number} ({kind}), line {}", self.file.line_of(place))
            }
            None => format!("#{number}"),
        }
    }
}

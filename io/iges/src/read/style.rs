//! Names, colours and layers.

use std::collections::BTreeMap;

use loftsman_kernel::mesh::color::from_srgb;

use super::entity::Reader;
use super::tree::end;

/// What is said of how entities look, beside what stands with each.
#[derive(Debug, Default)]
pub(crate) struct Styles {
    /// Names of levels.
    levels: BTreeMap<i32, String>,
}

/// The colours that have numbers, from 1 on.
const COLORS: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 1.0, 0.0],
    [1.0, 0.0, 1.0],
    [0.0, 1.0, 1.0],
    [1.0, 1.0, 1.0],
];

impl Styles {
    /// The names of levels (406, form 3), which stand on their level.
    pub(crate) fn new(reader: &Reader<'_, '_>) -> Self {
        let mut styles = Self::default();
        for (place, entry) in reader.file.entries().iter().enumerate() {
            if (entry.kind, entry.form) == (406, 3)
                && entry.level > 0
                && let Ok(entity) = reader.entity(place)
            {
                let name = entity.text(3);
                if !name.is_empty() {
                    styles.levels.entry(entry.level).or_insert(name);
                }
            }
        }
        styles
    }

    /// The layer of an entity.
    pub(crate) fn layer(&self, reader: &Reader<'_, '_>, place: usize) -> Option<String> {
        let mut level = reader.file.entry(place).level;
        if level < 0 {
            // A list of levels (406, form 1): the first counts.
            let list = reader.file.place(i64::from(level).abs())?;
            level = i32::try_from(reader.entity(list).ok()?.whole(2).ok()?).ok()?;
        }
        (level > 0).then(|| self.levels.get(&level).cloned().unwrap_or_else(|| level.to_string()))
    }

    /// The colour of an entity, linear.
    pub(crate) fn color(&self, reader: &Reader<'_, '_>, place: usize) -> Option<[f64; 4]> {
        let color = reader.file.entry(place).color;
        let rgb = if color < 0 {
            let at = reader.file.place(i64::from(color).abs())?;
            let entity = reader.of(at, &[314], "a colour").ok()?;
            entity.triple(1).ok()?.map(|percent| percent / 100.0)
        } else {
            *COLORS.get(usize::try_from(color).ok()?.checked_sub(1)?)?
        };
        let [r, g, b] = rgb.map(from_srgb);
        let linear = [r, g, b, 1.0];
        linear.iter().all(|c| c.is_finite()).then_some(linear)
    }

    /// What an entity is called: by a property (406, form 15), else by its label.
    pub(crate) fn name(&self, reader: &Reader<'_, '_>, place: usize) -> Option<String> {
        if let Some(name) = self.property_name(reader, place) {
            return Some(name);
        }
        let entry = reader.file.entry(place);
        let label = &entry.label;
        if label.is_empty() {
            return None;
        }
        Some(if entry.subscript > 0 { format!("{label}{}", entry.subscript) } else { label.clone() })
    }

    /// The name of a property, of which the number stands behind the parameters of the entity and what it is associated with.
    pub(crate) fn property_name(&self, reader: &Reader<'_, '_>, place: usize) -> Option<String> {
        let entity = reader.glance(place).ok()?;
        let end = end(&entity)?;
        let associated = entity.count(end + 1, 1).ok()?;
        let properties = end + 2 + associated;
        for k in 0..entity.count(properties, 1).ok()? {
            let Ok(Some(at)) = entity.pointed(properties + 1 + k) else { continue };
            let entry = reader.file.entry(at);
            if (entry.kind, entry.form) == (406, 15)
                && let Ok(property) = reader.entity(at)
            {
                return Some(property.text(2)).filter(|name| !name.is_empty());
            }
        }
        None
    }
}

//! The layers of objects, some of which are hidden.

use super::Emitter;

/// What is on no layer but hidden is on this one.
const HIDDEN: &str = "hidden";

impl Emitter<'_, '_, '_> {
    /// The layer of an entity, which for hidden ones among others that are seen is one of its own.
    pub(super) fn layer(&self, place: usize) -> Option<String> {
        let layer = self.styles.layer(self.reader, place);
        if !self.reader.file.entry(place).blank {
            return layer;
        }
        let mixed = self.shown.get(&layer).is_some_and(|[seen, _]| *seen > 0);
        match layer {
            None => Some(HIDDEN.to_owned()),
            Some(layer) if mixed => Some(format!("{layer}, {HIDDEN}")),
            layer => layer,
        }
    }

    /// The layers of which everything is hidden.
    pub(super) fn hidden_layers(&self) -> Vec<String> {
        let hidden = self.shown.iter().filter(|(_, [_, hidden])| *hidden > 0);
        hidden
            .map(|(layer, [seen, _])| match layer {
                None => HIDDEN.to_owned(),
                Some(layer) if *seen > 0 => format!("{layer}, {HIDDEN}"),
                Some(layer) => layer.clone(),
            })
            .collect()
    }
}

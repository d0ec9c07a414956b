//! Layers.

use loftsman_kernel::named::Named;
use loftsman_kernel::plugin::hint;
use loftsman_kernel::scene::{Layer, Scene, check_layers};
use loftsman_kernel::text::clip;
use serde::de::{Error, MapAccess};

use super::lists::Fixed;
use super::table::{Table, need};
use super::trail::Trail;

/// A layer.
#[derive(Default)]
pub(super) struct LayerTable {
    name: Option<String>,
    color: Option<[f64; 4]>,
    visible: Option<bool>,
    parent: Option<String>,
}

impl<'de> Table<'de> for LayerTable {
    type Out = Layer;
    const WHAT: &'static str = "a layer";
    const FIELDS: &'static [&'static str] = &["name", "color", "visible", "parent"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        match name {
            "name" => self.name = Some(map.next_value()?),
            "color" => {
                self.color = Some(map.next_value_seed(Fixed { trail, what: "[red, green, blue, alpha]" })?);
            }
            "visible" => self.visible = Some(map.next_value()?),
            _ => self.parent = Some(map.next_value()?),
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Layer, E> {
        let name = need::<Self, _, _>(self.name, "name", trail)?;
        let mut layer = Layer::new(name);
        (layer.color, layer.parent) = (self.color, self.parent);
        layer.visible = self.visible.unwrap_or(true);
        Ok(layer)
    }
}

/// Every layer lies below one that exists, and none below itself.
pub(super) fn check<E: Error>(scene: &Scene, trail: &Trail) -> Result<(), E> {
    for (i, layer) in scene.layers.iter().enumerate() {
        if let Some(parent) = layer.parent.as_deref().filter(|parent| scene.layers.get(parent).is_none()) {
            let known = scene.layers.iter().map(Named::name);
            let hint = hint(parent, known, || "add it, or take the field away".to_owned());
            let problem = format!("there is no layer \"{}\" to lie below; {hint}", clip(parent));
            return Err(trail.refuse_table(format!("layers[{i}].parent"), problem));
        }
    }
    check_layers(&scene.layers).map_err(|defect| trail.refuse_table("layers", defect.to_string()))
}

//! What a layer's description says of it beyond its name, which the schema has no place for: `colour r g b a; seen; below name`.

use std::collections::BTreeSet;

use loftsman_kernel::Result;
use loftsman_kernel::scene::{Layer, Object, Scene};
use loftsman_kernel::text;

/// The words before a colour, of a layer that is hidden by those above alone, and before the name of the layer above.
const COLOR: &str = "colour ";
const SEEN: &str = "seen";
const BELOW: &str = "below ";

/// What is said of a layer.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct About {
    pub(crate) color: Option<[f64; 4]>,
    /// It is seen itself, though it is hidden with those above.
    pub(crate) seen: bool,
    pub(crate) parent: Option<String>,
}

/// What a description says; nothing where it is of another's making.
pub(crate) fn parse(about: &str) -> Option<About> {
    let (mut rest, mut color) = (about, None);
    if let Some(tail) = rest.strip_prefix(COLOR) {
        let (numbers, tail) = tail.split_once("; ").unwrap_or((tail, ""));
        let numbers: Vec<f64> = numbers.split(' ').map(|n| n.parse().ok()).collect::<Option<_>>()?;
        let four: [f64; 4] = numbers.try_into().ok()?;
        color = Some(four).filter(|four| four.iter().all(|c| c.is_finite()));
        color?;
        rest = tail;
    }
    let seen = rest.strip_prefix(SEEN).and_then(|tail| tail.strip_prefix("; "));
    let parent = seen.unwrap_or(rest).strip_prefix(BELOW).map(str::to_owned);
    let said = color.is_some() || parent.is_some();
    let whole = said && (rest.is_empty() || parent.is_some());
    whole.then_some(About { color, seen: seen.is_some(), parent })
}

/// The description of a layer, which is hidden, by those above perhaps, or not.
pub(crate) fn describe(layer: &Layer, hidden: bool) -> String {
    let mut parts = Vec::new();
    if let Some(color) = layer.color {
        let numbers = color.map(|c| {
            let mut digits = Vec::new();
            // Writing to a list cannot fail, and digits are ASCII.
            let _ = text::number(&mut digits, c);
            String::from_utf8_lossy(&digits).into_owned()
        });
        parts.push(format!("{COLOR}{}", numbers.join(" ")));
    }
    if let Some(parent) = &layer.parent {
        if hidden && layer.visible {
            parts.push(SEEN.to_owned());
        }
        parts.push(format!("{BELOW}{parent}"));
    }
    parts.join("; ")
}

/// Numbers of colours are as good as equal.
const SAME: f64 = 1e-9;

/// Takes the colour from an object that is the one of its layer: items say the colour that they are seen in, whosever it is.
pub(crate) fn take_color(scene: &Scene, object: &mut Object) {
    let Some(own) = object.color.take() else { return };
    let layer = scene.color_of(object);
    let same = |layer: [f64; 4]| own.iter().zip(layer).all(|(a, b)| (a - b).abs() <= SAME);
    if !layer.is_some_and(same) {
        object.color = Some(own);
    }
}

/// Lets layers lie below none whose own way up does not end, and lists those that others lie below; those of `hiding` are hidden.
pub(crate) fn untie(scene: &mut Scene, hiding: &BTreeSet<String>) -> Result<()> {
    let missing: Vec<String> = scene
        .layers
        .iter()
        .filter_map(|layer| layer.parent.clone())
        .filter(|parent| scene.layers.get(parent).is_none())
        .collect();
    for name in missing {
        if scene.layers.get(&name).is_none() {
            let mut layer = Layer::new(name);
            layer.visible = !hiding.contains(layer.name());
            scene.layers.add(layer)?;
        }
    }
    if loftsman_kernel::scene::check_layers(&scene.layers).is_err() {
        let mut flat: Vec<Layer> = scene.layers.iter().cloned().collect();
        scene.layers = Default::default();
        for mut layer in flat.drain(..) {
            layer.parent = None;
            scene.layers.add(layer)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn descriptions_read_back() {
        for layer in [
            Layer::new("a").colored([0.1, 1.0 / 3.0, 1e-9, 1.0]),
            Layer::new("a").below("b; colour 1"),
            Layer::new("a").colored([0.0; 4]).below("c d"),
        ] {
            for hidden in [false, true] {
                let said = parse(&describe(&layer, hidden)).unwrap();
                assert_eq!((said.color, &said.parent), (layer.color, &layer.parent), "{}", layer.name());
                assert_eq!(said.seen, hidden && layer.parent.is_some());
            }
        }
        for about in ["", "visible", "colour red", "colour 1 2 3", "colour 1 2 3 NaN", "colour 1 2 3 4; x"] {
            assert_eq!(parse(about), None, "{about}");
        }
    }
}

//! Names, colours and layers.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use loftsman_kernel::mesh::color::to_srgb;
use loftsman_kernel::scene::{Object, Scene};

use super::brep::Looks;
use super::print::{Look, Printer, Purpose, Record, plain};

/// Colours that were written, and the numbers of layers.
#[derive(Debug, Default)]
pub(crate) struct Styles {
    colors: HashMap<[u64; 3], u32>,
    levels: BTreeMap<String, i32>,
    hidden: BTreeSet<String>,
    /// Whether a colour was not opaque.
    pub(crate) transparent: usize,
}

impl Styles {
    /// The layers that objects are on: those whose names are numbers keep them.
    pub(crate) fn new(scene: &Scene) -> Self {
        let defined = scene.definitions().iter().flat_map(|d| d.objects());
        let used: BTreeSet<String> =
            scene.objects().iter().chain(defined).filter_map(|o| o.layer.clone()).collect();
        let number = |name: &str| {
            let number: i32 = name.parse().ok()?;
            (number > 0 && number < 1_000_000 && number.to_string() == name).then_some(number)
        };
        let mut levels: BTreeMap<String, i32> =
            used.iter().filter_map(|name| Some((name.clone(), number(name)?))).collect();
        let taken: BTreeSet<i32> = levels.values().copied().collect();
        let mut free = (1..).filter(|number| !taken.contains(number));
        for name in &used {
            if !levels.contains_key(name)
                && let Some(number) = free.next()
            {
                levels.insert(name.clone(), number);
            }
        }
        let hidden = scene.hidden_layers();
        let hidden = used.iter().filter(|name| hidden.contains(name)).cloned().collect();
        Self { levels, hidden, ..Self::default() }
    }

    /// Writes the names of layers.
    pub(crate) fn layers(&self, printer: &mut Printer) {
        for (name, &level) in self.levels.iter().filter(|(name, level)| **name != level.to_string()) {
            let look = Look { level, ..Look::default().form(3).purpose(Purpose::Other) };
            printer.put(Record::new(406).whole(2).whole(i64::from(level)).text(name), look);
        }
    }

    /// How an object looks.
    pub(crate) fn look(&mut self, printer: &mut Printer, object: &Object, color: Option<[f64; 4]>) -> Look {
        let layer = object.layer.as_ref();
        Look {
            level: layer.and_then(|name| self.levels.get(name)).copied().unwrap_or(0),
            blank: layer.is_some_and(|name| self.hidden.contains(name)),
            color: color.map(|color| self.color(printer, color)),
            ..Look::default()
        }
    }
}

impl Looks for Styles {
    fn color(&mut self, printer: &mut Printer, [r, g, b, alpha]: [f64; 4]) -> u32 {
        self.transparent += usize::from(alpha < 1.0);
        // So many digits as come back the same from light and sRGB.
        let digits = |light: f64| {
            let percent = 100.0 * to_srgb(light);
            format!("{percent:.12e}").parse().unwrap_or(percent)
        };
        let rgb = [r, g, b].map(digits);
        let key = rgb.map(f64::to_bits);
        if let Some(&known) = self.colors.get(&key) {
            return known;
        }
        let look = Look::default().purpose(Purpose::Definition);
        let number = printer.put(Record::new(314).reals(&rgb).text("color"), look);
        self.colors.insert(key, number);
        number
    }

    fn name(&mut self, printer: &mut Printer, name: &str) -> u32 {
        let look = Look { owned: true, ..Look::default().form(15).purpose(Purpose::Other) };
        // Without a name it would be taken for another thing.
        let name = Some(plain(name)).filter(|name| !name.is_empty()).unwrap_or_else(|| "object".to_owned());
        printer.put(Record::new(406).whole(1).text(&name), look)
    }
}

//! Colours and layers.

use std::collections::{BTreeMap, HashMap};

use loftsman_kernel::mesh::color::{from_srgb, to_srgb};
use loftsman_kernel::scene::Scene;

use super::print::{Printer, real, references};
use crate::part21::encode;
use crate::{layers, light};

/// What carries a colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Carrier {
    /// Solids, faces, surfaces, groups.
    Surface,
    /// Curves.
    Curve,
    /// Points.
    Point,
}

/// What is said of how things look, until all is written.
#[derive(Debug, Default)]
pub(crate) struct Looks {
    /// Styles that were written, by carrier and the bits of the colour.
    known: HashMap<(Carrier, [u64; 4]), u64>,
    /// The assignments of styles that were written.
    assignments: HashMap<u64, u64>,
    styled: Vec<u64>,
    layers: BTreeMap<String, Vec<u64>>,
}

impl Looks {
    /// Colours an item.
    pub(crate) fn color(&mut self, p: &mut Printer, item: u64, color: [f64; 4], carrier: Carrier) {
        let style = self.style(p, color, carrier);
        let assignment = *self
            .assignments
            .entry(style)
            .or_insert_with(|| p.put(&format!("PRESENTATION_STYLE_ASSIGNMENT((#{style}))")));
        self.styled.push(p.put(&format!("STYLED_ITEM('color',(#{assignment}),#{item})")));
    }

    /// Colours an item where it is shown by one occurrence, whose representation is `within`.
    pub(crate) fn color_within(
        &mut self,
        p: &mut Printer,
        within: u64,
        item: u64,
        color: [f64; 4],
        carrier: Carrier,
    ) {
        let style = self.style(p, color, carrier);
        let by_context = p.put(&format!("PRESENTATION_STYLE_BY_CONTEXT((#{style}),#{within})"));
        self.styled.push(p.put(&format!("STYLED_ITEM('color',(#{by_context}),#{item})")));
    }

    fn style(&mut self, p: &mut Printer, color: [f64; 4], carrier: Carrier) -> u64 {
        *self.known.entry((carrier, color.map(f64::to_bits))).or_insert_with(|| style(p, color, carrier))
    }

    /// Puts an item on a layer.
    pub(crate) fn layer(&mut self, item: u64, layer: &str) {
        self.layers.entry(layer.to_owned()).or_default().push(item);
    }

    /// Writes what belongs to all. How many listed layers hold nothing that was written, so that they are lost.
    pub(crate) fn finish(self, p: &mut Printer, scene: &Scene, context: u64) -> usize {
        if !self.styled.is_empty() {
            let items = references(&self.styled);
            p.put(&format!("MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',{items},#{context})"));
        }
        let hidden = scene.hidden_layers();
        let mut unseen = Vec::new();
        for (name, items) in &self.layers {
            let about = scene.layers.get(name).map(|l| layers::describe(l, hidden.contains(name)));
            let (name_text, about) = (encode(name), encode(&about.unwrap_or_default()));
            let number =
                p.put(&format!("PRESENTATION_LAYER_ASSIGNMENT({name_text},{about},{})", references(items)));
            if hidden.contains(name) {
                unseen.push(number);
            }
        }
        if !unseen.is_empty() {
            p.put(&format!("INVISIBILITY({})", references(&unseen)));
        }
        scene.layers.iter().filter(|layer| !self.layers.contains_key(layer.name())).count()
    }
}

/// What is left of one, in few digits where these say as much.
fn rest(value: f64) -> f64 {
    let rest = 1.0 - value;
    let rounded: f64 = format!("{rest:.12e}").parse().unwrap_or(rest);
    if 1.0 - rounded == value { rounded } else { rest }
}

fn style(p: &mut Printer, [r, g, b, alpha]: [f64; 4], carrier: Carrier) -> u64 {
    let shown = [r, g, b].map(to_srgb);
    let through = rest(alpha);
    let says_all = shown.map(from_srgb) == [r, g, b] && 1.0 - through == alpha;
    let name = if says_all { String::new() } else { light::name([r, g, b, alpha]) };
    let [r, g, b] = shown.map(real);
    let color = p.put(&format!("COLOUR_RGB({},{r},{g},{b})", encode(&name)));
    match carrier {
        Carrier::Surface => {
            let fill = p.put(&format!("FILL_AREA_STYLE_COLOUR('',#{color})"));
            let fill = p.put(&format!("FILL_AREA_STYLE('',(#{fill}))"));
            let mut sides = vec![p.put(&format!("SURFACE_STYLE_FILL_AREA(#{fill})"))];
            if alpha < 1.0 {
                let through = p.put(&format!("SURFACE_STYLE_TRANSPARENT({})", real(through)));
                sides.push(p.put(&format!(
                    "SURFACE_STYLE_RENDERING_WITH_PROPERTIES(.NORMAL_SHADING.,#{color},(#{through}))"
                )));
            }
            let side = p.put(&format!("SURFACE_SIDE_STYLE('',{})", references(&sides)));
            p.put(&format!("SURFACE_STYLE_USAGE(.BOTH.,#{side})"))
        }
        Carrier::Curve => {
            let font = p.put("DRAUGHTING_PRE_DEFINED_CURVE_FONT('continuous')");
            p.put(&format!("CURVE_STYLE('',#{font},POSITIVE_LENGTH_MEASURE(0.1),#{color})"))
        }
        Carrier::Point => {
            p.put(&format!("POINT_STYLE('',MARKER_TYPE(.DOT.),POSITIVE_LENGTH_MEASURE(0.1),#{color})"))
        }
    }
}

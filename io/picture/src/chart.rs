//! A chart of curvature along curves: axes with round ticks, one line a curve, the state before lighter and below.

use loftsman_kernel::Vector;
use loftsman_kernel::plugin::{MarkKind, Splines};
use loftsman_kernel::scene::{Geometry, Unit};

use crate::draw::{color, mark};
use crate::error::PictureError;
use crate::layout::Rect;
use crate::panel::Against;
use crate::path::Spot;
use crate::sheet::{Layer, Sheet, Stroke};
use crate::stage::Stage;
use crate::stage::body::{Body, Form};
use crate::stage::piece::Piece;
use crate::svg::{Element, length};
use crate::text;

/// Room for numbers and titles of the axes at the left and below, in millimetres.
const LEFT: f64 = 14.0;
const BELOW: f64 = 10.0;

/// The size of texts, in millimetres.
const SIZE: f64 = 2.6;

/// The most samples of a curve.
const SAMPLES: usize = 6000;

/// The most marks that are shown on curves of a chart.
const MARKS: usize = 40;

/// Ticks of an axis, about.
const TICKS: f64 = 6.0;

/// Curvature of which all but this part of the length has less decides the height of the chart: where the rest is
/// more than this many times larger (a nose, a cusp) it is cut off, and said.
const RARE: f64 = 0.02;
const TALL: f64 = 4.0;

/// A line of a chart.
#[derive(Debug)]
struct Series {
    /// Index of its body among the new ones, or the old ones.
    body: usize,
    old: bool,
    /// Arc length or parameter, and curvature, in the scene's units.
    points: Vec<Spot>,
    /// The places on the stage that they belong to.
    places: Vec<Vector>,
}

/// A chart, in the units of the scene.
#[derive(Debug)]
pub(crate) struct Chart {
    series: Vec<Series>,
    range: Rect,
    against: Against,
    /// Whether curvature has a sign.
    signed: bool,
    /// The largest curvature of all, where it is cut off.
    cut: Option<f64>,
}

impl Chart {
    /// The curvature profiles of all curves on a stage that an automatic view has set.
    pub(crate) fn of(stage: &Stage<'_>, against: Against) -> Result<Self, PictureError> {
        let curves = || stage.old.iter().chain(&stage.new).filter(|b| matches!(b.form, Form::Curve { .. }));
        if curves().next().is_none() {
            let names: Vec<&str> = stage.new.iter().map(|b| b.object.name()).take(5).collect();
            let names = if names.is_empty() { "no objects at all".to_owned() } else { names.join(", ") };
            return Err(PictureError::NoCurve(text::clipped(&names, 80)));
        }
        let flat = |net: &[Vector]| net.iter().all(|p| (p.z - net[0].z).abs() <= 1e-9);
        let signed = curves().all(|b| matches!(&b.form, Form::Curve { net, .. } if flat(net)));
        let size = stage.projection.size;
        let mut series = Vec::new();
        for (old, bodies) in [(true, &stage.old), (false, &stage.new)] {
            for (index, body) in bodies.iter().enumerate() {
                if let Form::Curve { pieces, .. } = &body.form {
                    let (points, places) = sample(body, pieces, against, signed, size);
                    series.push(Series { body: index, old, points, places });
                }
            }
        }
        let mut range = Rect::NONE;
        let mut values = Vec::new();
        for [x, y] in series.iter().flat_map(|s| &s.points).filter(|p| p.iter().all(|c| c.is_finite())) {
            range.take([*x, 0.0]);
            values.push(*y);
        }
        let most = |values: &[f64]| values.iter().fold(0.0_f64, |most, y| most.max(y.abs()));
        let all = most(&values);
        let mut sizes: Vec<f64> = values.iter().map(|y| y.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let usual = sizes.get(((1.0 - RARE) * sizes.len() as f64) as usize).copied().unwrap_or(all);
        let cut = (usual > 0.0 && all > TALL * usual).then_some(all);
        let limit = if cut.is_some() { 1.5 * usual } else { all };
        for y in values {
            let y = y.clamp(-limit, limit);
            range.low[1] = range.low[1].min(y);
            range.high[1] = range.high[1].max(y);
        }
        // Straight lines have no curvature, and points no length: any range shows that.
        for (i, spare) in [(0, 1.0), (1, 1.0 / size)] {
            if range.high[i] <= range.low[i] {
                range.low[i] = if range.low[i].is_finite() { range.low[i] } else { 0.0 };
                range.high[i] = range.low[i] + if spare.is_finite() { spare } else { 1.0 };
            }
        }
        Ok(Self { series, range, against, signed, cut })
    }

    /// Draws the chart into an area of the page.
    pub(crate) fn draw(&self, sheet: &mut Sheet, stage: &Stage<'_>, area: &Rect, unit: Unit) {
        let inner = Rect {
            low: [area.low[0] + LEFT, area.low[1] + 2.0],
            high: [area.high[0] - 2.0, area.high[1] - BELOW],
        };
        let mut bounds = self.range;
        // A little air above and below, but zero stays on its axis.
        let air = 0.05 * (bounds.high[1] - bounds.low[1]);
        bounds.low[1] -= if bounds.low[1] < 0.0 { air } else { 0.0 };
        bounds.high[1] += if bounds.high[1] > 0.0 { air } else { 0.0 };
        let horizontal = ticks(bounds.low[0], bounds.high[0], TICKS);
        let vertical = ticks(bounds.low[1], bounds.high[1], 0.7 * TICKS);
        let [w, h] = bounds.size();
        let [wide, high] = inner.size();
        // Differences first: ranges may be tiny beside their place.
        let spot = |[x, y]: Spot| {
            let (s, t) = ((x - bounds.low[0]) / w, (y - bounds.low[1]) / h);
            [inner.low[0] + s * wide, inner.high[1] - t.clamp(-0.02, 1.02) * high]
        };
        let (units, unit) = (unit.symbol(), unit.one());
        self.axes(sheet, &inner, [&horizontal, &vertical], &spot, [&units, &unit]);
        for series in &self.series {
            let body = if series.old { &stage.old[series.body] } else { &stage.new[series.body] };
            let color = color(sheet, body, series.old);
            let mut path = crate::path::Path::default();
            let mut last = None;
            for point in &series.points {
                if !point[1].is_finite() {
                    last = None;
                    continue;
                }
                let to = spot(*point);
                match last {
                    None => path.move_to(to),
                    Some(from) => {
                        sheet.ink.segment(from, to, 4);
                        path.line_to(to);
                    }
                }
                last = Some(to);
            }
            let stroke = Stroke::plain(color, if series.old { 0.35 } else { 0.45 });
            let title = Element::new("title").text(body.object.name());
            let layer = if series.old { Layer::Old } else { Layer::Curves };
            sheet.put(layer, &stroke.path("profile", path.finish()).around(&title));
            crate::draw::named(
                sheet,
                body,
                series.old,
                crate::sheet::Sample::Line(Stroke::plain(color, 0.45)),
            );
        }
        self.marks(sheet, stage, &spot);
        if let Some(most) = self.cut {
            sheet
                .caption
                .note(format!("the profile is cut; the largest curvature is {}/{unit}", text::number(most)));
        }
    }

    /// What was asked, on the curves of the chart: each mark at the sample nearest to it.
    fn marks(&self, sheet: &mut Sheet, stage: &Stage<'_>, spot: &impl Fn(Spot) -> Spot) {
        for light in stage.marks.iter().filter(|light| light.mark.kind != MarkKind::Locked).take(MARKS) {
            let own = |s: &&Series| !s.old && stage.new[s.body].object.name() == light.mark.object;
            let Some(series) = self.series.iter().find(own) else { continue };
            let off = |i: &usize| (series.places[*i] - light.position).norm_squared();
            let nearest = (0..series.points.len()).min_by(|a, b| off(a).total_cmp(&off(b)));
            if let Some(point) = nearest.map(|i| series.points[i]).filter(|p| p[1].is_finite()) {
                sheet.put(Layer::Marks, &mark::point(sheet.theme, light.mark.kind, spot(point)));
            }
        }
    }

    fn axes(
        &self,
        sheet: &mut Sheet,
        inner: &Rect,
        [horizontal, vertical]: [&[f64]; 2],
        spot: &impl Fn(Spot) -> Spot,
        [units, unit]: [&str; 2],
    ) {
        let (faint, ink) = (sheet.theme.faint(), sheet.theme.ink());
        let grid = Stroke::plain(faint.mixed(sheet.theme.paper(), 0.6), 0.1);
        let mut lines = String::new();
        let mut out = String::new();
        let words = |x: f64, y: f64, anchor: &str, words: &str| {
            Element::new("text")
                .length("x", x)
                .length("y", y)
                .length("font-size", SIZE)
                .attribute("text-anchor", anchor)
                .attribute("fill", &ink.hex())
                .text(words)
        };
        let at = |points: [Spot; 2]| {
            let [a, b] = points.map(|[x, y]| format!("{} {}", length(x), length(y)));
            format!("M{a}L{b}")
        };
        for &x in horizontal {
            let [x_page, _] = spot([x, 0.0]);
            lines.push_str(&at([[x_page, inner.low[1]], [x_page, inner.high[1]]]));
            out.push_str(&words(x_page, inner.high[1] + 3.6, "middle", &text::tick(x, horizontal)));
        }
        for &y in vertical {
            let [_, y_page] = spot([0.0, y]);
            lines.push_str(&at([[inner.low[0], y_page], [inner.high[0], y_page]]));
            let label = text::tick(y, vertical);
            out.push_str(&words(inner.low[0] - 1.2, y_page + 0.35 * SIZE, "end", &label));
        }
        let [_, zero] = spot([0.0, 0.0]);
        let axis = at([[inner.low[0], inner.low[1]], [inner.low[0], inner.high[1]]])
            + &at([[inner.low[0], zero], [inner.high[0], zero]]);
        sheet.put(Layer::Axes, &grid.path("grid", lines).empty());
        sheet.put(Layer::Axes, &Stroke::plain(faint, 0.25).path("axis", axis).empty());
        let middle = (inner.low[0] + inner.high[0]) / 2.0;
        let below = match self.against {
            Against::ArcLength => format!("arc length ({units})"),
            Against::Parameter => "parameter u".to_owned(),
        };
        out.push_str(&words(middle, inner.high[1] + 7.6, "middle", &below));
        let signed = if self.signed { "signed curvature" } else { "curvature" };
        let title = format!("{signed} (1/{unit})");
        // A low chart has no room for more than the essential.
        let fits = text::width(&title) * SIZE <= inner.size()[1];
        let title = if fits { title } else { format!("κ (1/{unit})") };
        let (x, y) = (inner.low[0] - LEFT + SIZE, (inner.low[1] + inner.high[1]) / 2.0);
        let turned = Element::new("text")
            .length("font-size", SIZE)
            .attribute("transform", &format!("translate({} {}) rotate(-90)", length(x), length(y)))
            .attribute("text-anchor", "middle")
            .attribute("fill", &ink.hex());
        out.push_str(&turned.text(&title));
        sheet.put(Layer::Axes, &out);
    }
}

/// Arc length or parameter, and curvature, along a curve; NaN where the curve stands still, and where it is torn.
fn sample(
    body: &Body<'_>,
    pieces: &[Piece],
    against: Against,
    signed: bool,
    size: f64,
) -> (Vec<Spot>, Vec<Vector>) {
    let breaks = match body.object.geometry() {
        Geometry::Curve(curve) => curve.space().breakpoints(),
        Geometry::Custom(custom) => match custom.splines() {
            Some(Splines::Curves(curves)) => {
                curves.first().map(|c| c.space().breakpoints()).unwrap_or_default()
            }
            _ => Vec::new(),
        },
        _ => Vec::new(),
    };
    let steps = (SAMPLES / pieces.len().max(1)).clamp(1, 64);
    let mut points = Vec::with_capacity(pieces.len() * (steps + 1));
    let mut places = Vec::with_capacity(points.capacity());
    let mut travelled = 0.0;
    for (index, (piece, span)) in pieces.iter().zip(breaks.windows(2)).enumerate() {
        if index > 0 && !pieces[index - 1].meets(piece) {
            // Nothing is between the ends of a torn curve.
            points.push([f64::NAN; 2]);
            places.push(Vector::repeat(f64::NAN));
        }
        for i in 0..=steps {
            let t = i as f64 / steps as f64;
            if i > 0 {
                travelled += piece_length(piece, (i - 1) as f64 / steps as f64, t);
            }
            let jet = piece.jet(t);
            let bent = jet.curvature().map_or(f64::NAN, |k| {
                let left = jet.first.x * k.y - jet.first.y * k.x;
                if signed && left < 0.0 { -k.norm() } else { k.norm() }
            });
            let x = match against {
                Against::ArcLength => travelled * size,
                Against::Parameter => span[0] + (span[1] - span[0]) * t,
            };
            points.push([x, bent / size]);
            places.push(jet.point);
        }
    }
    (points, places)
}

/// The length of a part of a piece, by Gauss's rule of five points.
fn piece_length(piece: &Piece, a: f64, b: f64) -> f64 {
    const NODES: [(f64, f64); 5] = [
        (0.0, 0.568_888_888_888_888_9),
        (-0.538_469_310_105_683, 0.478_628_670_499_366_5),
        (0.538_469_310_105_683, 0.478_628_670_499_366_5),
        (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
        (0.906_179_845_938_664, 0.236_926_885_056_189_1),
    ];
    let (middle, half) = ((a + b) / 2.0, (b - a) / 2.0);
    NODES.iter().map(|(x, w)| w * half * piece.jet(middle + half * x).first.norm()).sum()
}

/// The ticks of a range: multiples of 1, 2 or 5 · 10ᵏ within it, about `about` of them.
fn ticks(low: f64, high: f64, about: f64) -> Vec<f64> {
    let rough = (high - low) / about;
    let power = 10_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|d| d * power).into_iter().find(|s| *s >= rough * (1.0 - 1e-9));
    let step = step.filter(|step| *step > 0.0 && step.is_finite());
    let Some(step) = step else { return vec![low] };
    let (first, last) = ((low / step - 1e-9).ceil(), (high / step + 1e-9).floor());
    let count = (last - first).clamp(0.0, 4.0 * about) as usize;
    (0..=count).map(|i| (first + i as f64) * step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within_the_range() {
        assert_eq!(ticks(0.0, 9.0, 6.0), [0.0, 2.0, 4.0, 6.0, 8.0]);
        assert_eq!(ticks(-1.0, 1.0, 4.0), [-1.0, -0.5, 0.0, 0.5, 1.0]);
        for scale in [1e-300, 1e-9, 1e9, 1e300] {
            let list = ticks(0.13 * scale, 2.9 * scale, 6.0);
            assert!((3..=9).contains(&list.len()), "{list:?}");
            assert!(list.iter().all(|t| (0.13 * scale..=2.9 * scale).contains(t)), "{list:?}");
        }
        assert_eq!(ticks(5.0, 5.0, 6.0), [5.0]);
    }

    #[test]
    fn lengths_of_pieces_are_exact_to_rounding_for_short_ones() {
        use nalgebra::Vector4;
        // A parabola y = x² over [0, 1]: √5/2 + asinh(2)/4.
        let control = [[0.0, 0.0], [0.5, 0.0], [1.0, 1.0]].map(|[x, y]| Vector4::new(x, y, 0.0, 1.0));
        let piece = Piece { control: control.to_vec(), rational: false };
        let sum: f64 =
            (0..64).map(|i| piece_length(&piece, f64::from(i) / 64.0, f64::from(i + 1) / 64.0)).sum();
        assert!((sum - (5.0_f64.sqrt() / 2.0 + 2.0_f64.asinh() / 4.0)).abs() < 1e-14, "{sum}");
    }
}

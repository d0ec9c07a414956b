//! Curvature combs: teeth `−s κN` on the outer side of a curve, and the envelope of their tips; of a surface on some of its
//! isoparametric lines.

use loftsman_kernel::Vector;
use loftsman_kernel::scene::Unit;
use loftsman_kernel::spline::{Direction, Surface};

use crate::choices::{Choices, Combs};
use crate::draw::{color, legend, surface};
use crate::path::Path;
use crate::sheet::{Layer, Sample, Sheet, Stroke};
use crate::stage::Stage;
use crate::stage::body::{Form, pieces};
use crate::stage::piece::Piece;
use crate::stage::trim::{Mask, Trim};
use crate::text;

/// Teeth are about this far apart along the curve, in units of the stage (which is two of them large).
const GAP: f64 = 0.016;

/// Steps of the envelope from tooth to tooth.
const FINE: usize = 4;

/// Pieces with teeth; of more, every k-th has some.
const PIECES: usize = 2000;

/// Isoparametric lines of a surface with combs, each way.
const LINES: usize = 5;

/// A line within this, in units of the stage, is a point.
const POINT: f64 = 1e-3;

/// How long the usual tooth of an automatic comb is, and where it cuts long ones.
const USUAL: f64 = 0.16;
const LONGEST: f64 = 0.5;

/// A comb's samples along one curve, in order.
#[derive(Debug)]
struct Comb {
    /// Index of its body among the new ones, or the old ones.
    body: usize,
    old: bool,
    samples: Vec<Sampled>,
}

#[derive(Debug, Clone, Copy)]
struct Sampled {
    foot: Vector,
    /// The curvature vector, in stage units; zero where the curve stands still.
    curvature: Vector,
    /// Whether there is a tooth here, or only a point of the envelope.
    tooth: bool,
    /// Whether the curve is torn before it: no envelope leads here.
    torn: bool,
}

/// How long teeth are, the same in all panels of a picture.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Measure {
    /// Length of a tooth over curvature, in stage units.
    scale: f64,
    /// Teeth are no longer than this.
    longest: f64,
    /// The largest curvature, in stage units.
    most: f64,
}

impl Measure {
    /// The measure for the combs of all panels; `size` is what a unit of the stage is in the scene. `None` where
    /// nothing bends.
    pub(crate) fn of<'a>(
        combings: impl Iterator<Item = &'a Combing> + Clone,
        combs: Combs,
        size: f64,
    ) -> Option<Self> {
        let samples = combings.flat_map(|combing| &combing.combs).flat_map(|c| &c.samples);
        let mut values: Vec<f64> = samples.map(|s| s.curvature.norm()).collect();
        values.sort_by(f64::total_cmp);
        let most = values.last().copied().unwrap_or(0.0);
        // Radii of a billion times the scene are rounding on a straight line.
        if most < 1e-9 {
            return None;
        }
        let (scale, longest) = match combs {
            Combs::Scale(scale) => (scale / size / size, 4.0),
            _ => {
                // Samples are about even along the curve: four fifths of its length have less than this.
                let usual = values[values.len() * 4 / 5];
                let by_usual = USUAL / usual.max(most * 1e-3);
                (
                    if most * by_usual <= 1.5 * LONGEST { by_usual.min(LONGEST / most) } else { by_usual },
                    LONGEST,
                )
            }
        };
        Some(Self { scale, longest, most })
    }
}

/// The combs of the curves of a panel.
#[derive(Debug, Default)]
pub(crate) struct Combing {
    combs: Vec<Comb>,
    measure: Measure,
}

impl Combing {
    /// Samples the curvature of all curves; none where no combs are wanted.
    pub(crate) fn of(stage: &Stage<'_>, choices: &Choices) -> Self {
        if choices.combs == Combs::Off {
            return Self::default();
        }
        let mut combs = Vec::new();
        for (old, bodies) in [(true, &stage.old), (false, &stage.new)] {
            for (body, form) in bodies.iter().map(|b| &b.form).enumerate() {
                let mut add = |samples| combs.push(Comb { body, old, samples });
                match form {
                    Form::Curve { pieces, .. } => add(sample(pieces, &|_, _| true)),
                    Form::Surface { surface, trim, .. } => {
                        isolines(surface, trim.as_ref()).into_iter().for_each(add);
                    }
                    _ => {}
                }
            }
        }
        Self { combs, measure: Measure::default() }
    }

    /// The same combs with a measure; without one there are none.
    pub(crate) fn measured(self, measure: Option<Measure>) -> Self {
        measure.map(|measure| Self { measure, ..self }).unwrap_or_default()
    }

    fn tip(&self, sample: &Sampled) -> (Vector, bool) {
        let tooth = sample.curvature * -self.measure.scale;
        let length = tooth.norm();
        if length <= self.measure.longest * (1.0 + 1e-9) {
            (sample.foot + tooth, false)
        } else {
            // A direction first: a scale of 1e300 overflows the length.
            let direction = sample.curvature.normalize();
            (sample.foot - direction * self.measure.longest, true)
        }
    }

    /// The tips of all teeth, which the page must hold.
    pub(crate) fn tips(&self) -> impl Iterator<Item = Vector> {
        self.combs.iter().flat_map(|comb| comb.samples.iter().map(|s| self.tip(s).0))
    }

    /// Draws teeth and envelopes; of the state before only the envelopes.
    pub(crate) fn draw(&self, sheet: &mut Sheet, stage: &Stage<'_>, unit: Unit) {
        let mut any_cut = false;
        for comb in &self.combs {
            let body = if comb.old { &stage.old[comb.body] } else { &stage.new[comb.body] };
            let base = color(sheet, body, comb.old);
            let paper = sheet.theme.paper();
            let mut teeth = Path::default();
            let (mut envelope, mut dashed) = (Path::default(), Path::default());
            let mut last: Option<(_, bool)> = None;
            for sample in &comb.samples {
                let (tip, cut) = self.tip(sample);
                let (foot, tip) = (sheet.spot(&sample.foot), sheet.spot(&tip));
                any_cut |= cut;
                if sample.torn {
                    last = None;
                }
                if sheet.hides(&sample.foot) {
                    last = None;
                    continue;
                }
                if sample.tooth && !comb.old {
                    teeth.move_to(foot);
                    teeth.line_to(tip);
                    sheet.ink.segment(foot, tip, 1);
                }
                // What joins cut teeth is no envelope and therefore dashed.
                if let Some((from, was_cut)) = last {
                    let path = if was_cut || cut { &mut dashed } else { &mut envelope };
                    if path.pen() != Some(from) {
                        path.move_to(from);
                    }
                    path.line_to(tip);
                    sheet.ink.segment(from, tip, 2);
                }
                last = Some((tip, cut));
            }
            let tone = base.mixed(paper, 0.5);
            if !comb.old {
                sheet.put(Layer::Combs, &Stroke::plain(tone, 0.1).path("comb", teeth.finish()).empty());
            }
            let stroke = Stroke::plain(if comb.old { base } else { base.mixed(paper, 0.25) }, 0.2);
            let layer = if comb.old { Layer::Old } else { Layer::Combs };
            let dashed = dashed.finish();
            if !dashed.is_empty() {
                sheet.put(layer, &stroke.dashed().path("envelope-cut", dashed).empty());
            }
            sheet.put(layer, &stroke.path("envelope", envelope.finish()).empty());
        }
        if let Some(comb) = self.combs.iter().find(|comb| !comb.old).or(self.combs.first()) {
            let body = if comb.old { &stage.old[comb.body] } else { &stage.new[comb.body] };
            let color = color(sheet, body, comb.old);
            let size = stage.projection.size;
            let most = text::number(self.measure.most / size);
            let one = unit.one();
            if sheet.layout.is_parallel() {
                let (value, bar) = legend::bar(sheet.layout.scale / size);
                let per = text::number(bar / (self.measure.scale * sheet.layout.scale * size));
                let long = legend::long(value, unit);
                let words = format!("curvature: a tooth of {long} is {per}/{one}, drawn up to {most}/{one}");
                sheet.caption.explain_once(Sample::Comb(color), words);
            } else if !sheet.caption.legend.iter().any(|(sample, _)| matches!(sample, Sample::Comb(_))) {
                sheet
                    .caption
                    .explain_once(Sample::Comb(color), format!("curvature, drawn up to {most}/{one}"));
            }
            if any_cut {
                sheet
                    .caption
                    .note("the longest teeth of the curvature comb are cut (dashed envelope)".to_owned());
            }
        }
    }
}

/// The samples of some isoparametric lines of a surface, as far as they count of it.
fn isolines(surface: &Surface, trim: Option<&Trim>) -> Vec<Vec<Sampled>> {
    let mask = trim.map(|trim| Mask::new(trim, surface));
    let mut all = Vec::new();
    for direction in [Direction::U, Direction::V] {
        let lines = surface::lines(surface.space(direction));
        let few = LINES.min(lines.len());
        // Evenly among the lines that are drawn, the first and the last of them.
        for k in 0..few {
            let at = lines[k * (lines.len() - 1) / (few - 1).max(1)];
            let Ok(line) = surface.isocurve(direction, at) else { continue };
            let net: Vec<Vector> = line.points().iter().map(|p| p.coords).collect();
            // A pole is a line without extent, which bends without end.
            let extent = net.iter().map(|p| (p - net[0]).amax()).fold(0.0, f64::max);
            let Ok(pieces) = pieces(&line, &net) else { continue };
            if extent < POINT {
                continue;
            }
            let breaks = line.space().breakpoints();
            let counts = |piece: usize, t: f64| {
                let along = breaks[piece] + (breaks[piece + 1] - breaks[piece]) * t;
                let place = if direction == Direction::U { [at, along] } else { [along, at] };
                mask.as_ref().is_none_or(|mask| mask.has(place))
            };
            all.push(sample(&pieces, &counts));
        }
    }
    all
}

/// Samples every piece at even steps, ends included, so that jumps of curvature at knots show; what does not count, by the number of
/// the piece and the place in it, is left out.
fn sample(pieces: &[Piece], counts: &dyn Fn(usize, f64) -> bool) -> Vec<Sampled> {
    let step = pieces.len().div_ceil(PIECES).max(1);
    let mut samples = Vec::new();
    for (index, piece) in pieces.iter().enumerate().step_by(step) {
        // Of the pieces since the last one with teeth, whether any is torn off the one before.
        let mut torn = (index.saturating_sub(step)..index).any(|k| !pieces[k].meets(&pieces[k + 1]));
        let length: f64 = (0..8)
            .map(|i| (piece.point(f64::from(i + 1) / 8.0) - piece.point(f64::from(i) / 8.0)).norm())
            .sum();
        let teeth = if step > 1 { 1 } else { (length / GAP).ceil().clamp(1.0, 64.0) as usize };
        for i in 0..=teeth * FINE {
            let t = i as f64 / (teeth * FINE) as f64;
            if !counts(index, t) {
                torn = true;
                continue;
            }
            let jet = piece.jet(t);
            let curvature = jet.curvature().unwrap_or_else(Vector::zeros);
            samples.push(Sampled { foot: jet.point, curvature, tooth: i % FINE == 0, torn });
            torn = false;
        }
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector4;

    #[test]
    fn the_comb_of_a_circle_is_a_larger_circle() {
        let w = 0.5_f64.sqrt();
        let control = vec![
            Vector4::new(1.0, 0.0, 0.0, 1.0),
            Vector4::new(w, w, 0.0, w),
            Vector4::new(0.0, 1.0, 0.0, 1.0),
        ];
        let samples = sample(&[Piece { control, rational: true }], &|_, _| true);
        let combs = vec![Comb { body: 0, old: false, samples }];
        let combing = Combing { combs, measure: Measure { scale: 0.25, longest: LONGEST, most: 1.0 } };
        assert!(combing.tips().count() > 100);
        assert!(combing.tips().all(|tip| (tip.norm() - 1.25).abs() < 1e-12));
    }

    /// A torus: on every parallel and meridian a circle, whose teeth are all alike.
    #[test]
    fn the_lines_of_a_torus_are_circles_and_what_is_cut_out_has_no_teeth() {
        use loftsman_kernel::Point;
        use loftsman_kernel::spline::trimmed::{ParameterCurve, Region, Trimmed};
        use loftsman_kernel::spline::{Curve, Space};
        let meridian = Curve::circle(Point::new(3.0, 0.0, 0.0), Vector::y(), 1.0).unwrap();
        let torus =
            Surface::revolution(&meridian, Point::origin(), Vector::z(), std::f64::consts::TAU).unwrap();
        let all = isolines(&torus, None);
        assert_eq!(all.len(), 2 * LINES);
        for line in &all {
            let bent: Vec<f64> = line.iter().map(|s| s.curvature.norm()).collect();
            // The radius of the circle: of a meridian 1, of a parallel its distance from the axis.
            assert!(bent.iter().all(|b| (b - bent[0]).abs() < 1e-9 && *b >= 0.25 - 1e-9 && *b <= 1.0 + 1e-9));
        }
        // Of a ball the two poles have no teeth, and all others those of a circle within it.
        let half = Curve::elliptic_arc(Point::origin(), -Vector::z(), Vector::x(), 0.0, std::f64::consts::PI);
        let ball =
            Surface::revolution(&half.unwrap(), Point::origin(), Vector::z(), std::f64::consts::TAU).unwrap();
        let all = isolines(&ball, None);
        assert_eq!(all.len(), 2 * LINES - 2);
        let bent = all.iter().flatten().map(|s| s.curvature.norm());
        assert!(bent.clone().fold(0.0, f64::max) < 3.0 && bent.fold(9.0, f64::min) > 1.0 - 1e-9);
        let square = Space::clamped(1, &[0.0, 4.0]).unwrap();
        let flat = (0..4).map(|k| Point::new(f64::from(4 * (k / 2)), f64::from(4 * (k % 2)), 0.0)).collect();
        let surface = Surface::new(square.clone(), square, flat).unwrap();
        let hole = Curve::circle(Point::new(2.0, 2.0, 0.0), Vector::z(), 1.2).unwrap();
        let region = Region { outer: Vec::new(), holes: vec![vec![ParameterCurve::whole(hole).unwrap()]] };
        let trimmed = Trimmed::new(surface.clone(), vec![region], Vec::new(), Vec::new()).unwrap();
        let trim = Trim::of(&trimmed).unwrap();
        let cut: Vec<Sampled> = isolines(&surface, trim.as_ref()).into_iter().flatten().collect();
        assert!(cut.iter().all(|s| (s.foot - Vector::new(2.0, 2.0, 0.0)).norm() > 1.19));
        // The line through the middle goes on behind the hole, without an envelope across it.
        assert_eq!(cut.iter().filter(|s| s.torn).count(), 2 * 3, "three lines each way are cut");
    }
}

//! Labels that keep away from lines and from one another.

use crate::layout::Rect;
use crate::path::Spot;
use crate::svg::Element;
use crate::text;
use crate::theme::{Color, Theme};

/// The size of labels, in millimetres.
pub(crate) const SIZE: f64 = 2.9;

/// From line to line, in millimetres.
const LEADING: f64 = 3.6;

/// How far from its spot a label stands at most that is not worth a leader, in millimetres.
const BESIDE: f64 = 3.0;

/// The side of the cells that ink is counted in, in millimetres.
const CELL: f64 = 0.8;

/// How much is drawn where on the page, by cells.
#[derive(Debug)]
pub(crate) struct Ink {
    area: Rect,
    columns: usize,
    rows: usize,
    cells: Vec<u16>,
}

impl Ink {
    /// A clean area.
    pub(crate) fn new(area: Rect) -> Self {
        let [width, height] = area.size();
        let (columns, rows) = ((width / CELL).ceil() as usize + 1, (height / CELL).ceil() as usize + 1);
        Self { area, columns, rows, cells: vec![0; columns * rows] }
    }

    /// Where there is room for it.
    pub(crate) fn area(&self) -> Rect {
        self.area
    }

    /// Inks a segment; `weight` says how bad it is to cover it. Cells keep the heaviest.
    pub(crate) fn segment(&mut self, from: Spot, to: Spot, weight: u16) {
        let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
        let steps = (dx.hypot(dy) / (0.7 * CELL)).ceil().clamp(1.0, 4096.0) as usize;
        for i in 0..=steps {
            let t = i as f64 / steps as f64;
            if let Some(cell) = self.cell([from[0] + dx * t, from[1] + dy * t]) {
                self.cells[cell] = self.cells[cell].max(weight);
            }
        }
    }

    fn cell(&self, [x, y]: Spot) -> Option<usize> {
        let (column, row) = ((x - self.area.low[0]) / CELL, (y - self.area.low[1]) / CELL);
        let inside = column >= 0.0 && row >= 0.0 && column < self.columns as f64 && row < self.rows as f64;
        inside.then(|| row as usize * self.columns + column as usize)
    }

    /// The weight of all ink on a line, cell by cell.
    fn crossed(&self, from: Spot, to: Spot) -> f64 {
        let steps = ((to[0] - from[0]).hypot(to[1] - from[1]) / CELL).ceil().clamp(1.0, 4096.0) as usize;
        let at = |i: usize| [0, 1].map(|k| from[k] + (to[k] - from[k]) * i as f64 / steps as f64);
        (0..=steps).filter_map(|i| self.cell(at(i))).map(|cell| f64::from(self.cells[cell])).sum()
    }
}

/// Lines of text that belong to a spot.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Label {
    pub(crate) anchor: Spot,
    pub(crate) lines: Vec<String>,
    pub(crate) color: Color,
    /// Whether it is one of a row that tells as much without it: it is left out where it would not stand free beside its spot.
    pub(crate) dispensable: bool,
}

impl Label {
    fn size(&self) -> [f64; 2] {
        let width = self.lines.iter().map(|line| text::width(line)).fold(0.0, f64::max);
        [width * SIZE, self.lines.len() as f64 * LEADING]
    }
}

/// Places labels one after another and draws them, and gives the words of those that have no room: these have a number in the drawing, from
/// `first` on, and their words go into the legend.
///
/// A label stands where nothing is drawn, no other label is and no leader runs: near its anchor, else further off with a leader, beside
/// the drawing if need be; only its leader may cross lines. What is dispensable is left out where it would not stand free beside its spot.
/// `O(cells of the page)` for each label that is moved away.
pub(crate) fn place(labels: &[Label], ink: &Ink, theme: Theme, first: usize) -> (String, Vec<String>) {
    let mut page = Page { ink, free: Free::of(ink), placed: Vec::new(), leaders: Vec::new() };
    let (mut out, mut apart) = (String::new(), Vec::new());
    for label in labels {
        let found = page.beside(label).or_else(|| if label.dispensable { None } else { page.away(label) });
        if let Some(spot) = found {
            out.push_str(&page.take(label, spot, theme));
            continue;
        }
        if label.dispensable {
            continue;
        }
        let number = Label { lines: vec![(first + apart.len()).to_string()], ..label.clone() };
        apart.push(label.lines.join("; "));
        if let Some(spot) = page.beside(&number).or_else(|| page.away(&number)) {
            out.push_str(&page.take(&number, spot, theme));
        }
    }
    (out, apart)
}

/// How far a label's box is from lines at least: glyphs at their ends have a size. In millimetres.
const CLEAR: f64 = 0.5;

/// Labels further away than this have a number instead, in millimetres.
const FAR: f64 = 45.0;

/// The page while labels are placed.
struct Page<'a> {
    ink: &'a Ink,
    free: Free,
    placed: Vec<Rect>,
    leaders: Vec<[Spot; 2]>,
}

impl Page<'_> {
    /// Whether a label may stand here.
    fn is_free(&self, rect: &Rect) -> bool {
        let area = &self.ink.area;
        let inside = (0..2).all(|i| rect.low[i] >= area.low[i] && rect.high[i] <= area.high[i]);
        inside
            && self.free.is_free(self.ink, &rect.grown(CLEAR))
            && !self.placed.iter().any(|other| other.overlaps(rect))
            && !self.leaders.iter().any(|leader| meets(*leader, rect))
    }

    /// What a leader would run across.
    fn crossed(&self, label: &Label, rect: &Rect, radius: f64) -> f64 {
        let Some([start, end]) = leader(label, rect, radius) else { return 0.0 };
        let through = self.placed.iter().filter(|other| meets([start, end], other)).count();
        self.ink.crossed(start, end) + 1000.0 * through as f64
    }

    /// The best of the places around its anchor.
    fn beside(&self, label: &Label) -> Option<(Rect, f64)> {
        let near = candidates(label).into_iter();
        near.filter(|(rect, radius)| (!label.dispensable || *radius <= BESIDE) && self.is_free(rect))
            .map(|(rect, radius)| (self.crossed(label, &rect, radius) + 1.5 * radius, (rect, radius)))
            .filter(|(cost, _)| *cost < 1000.0)
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, place)| place)
    }

    /// The nearest of all free places of the page whose leader runs across no other label.
    fn away(&self, label: &Label) -> Option<(Rect, f64)> {
        let [w, h] = label.size();
        let area = &self.ink.area;
        let steps = |i: usize, size: f64| {
            let room = area.high[i] - area.low[i] - size;
            let count = if room >= 0.0 { (room / (2.0 * CELL)).floor() as usize + 1 } else { 0 };
            (0..count).map(move |k| 2.0 * CELL * k as f64)
        };
        let mut best: Option<(f64, (Rect, f64))> = None;
        for y in steps(1, h) {
            for x in steps(0, w) {
                let low = [area.low[0] + x, area.low[1] + y];
                let rect = Rect { low, high: [low[0] + w, low[1] + h] };
                let near = [0, 1].map(|i| label.anchor[i].clamp(rect.low[i], rect.high[i]) - label.anchor[i]);
                let distance = near[0].hypot(near[1]);
                let close = best.as_ref().is_none_or(|(cost, _)| 1.5 * distance < *cost);
                if distance > FAR || !close || !self.is_free(&rect) {
                    continue;
                }
                let cost = 1.5 * distance + 0.25 * self.crossed(label, &rect, distance);
                if cost < 250.0 && best.as_ref().is_none_or(|(known, _)| cost < *known) {
                    best = Some((cost, (rect, distance)));
                }
            }
        }
        best.map(|(_, place)| place)
    }

    /// Puts a label there.
    fn take(&mut self, label: &Label, (rect, radius): (Rect, f64), theme: Theme) -> String {
        self.leaders.extend(leader(label, &rect, radius));
        self.placed.push(rect.grown(0.4));
        draw(label, &rect, radius, theme)
    }
}

/// How many cells with ink there are above and left of each cell: so that it costs nothing to look whether a box is clean.
struct Free {
    sums: Vec<u32>,
}

impl Free {
    fn of(ink: &Ink) -> Self {
        let width = ink.columns + 1;
        let mut sums = vec![0; width * (ink.rows + 1)];
        for row in 0..ink.rows {
            let mut line = 0;
            for column in 0..ink.columns {
                line += u32::from(ink.cells[row * ink.columns + column] > 0);
                sums[(row + 1) * width + column + 1] = sums[row * width + column + 1] + line;
            }
        }
        Self { sums }
    }

    fn is_free(&self, ink: &Ink, rect: &Rect) -> bool {
        let index = |c: f64, low: f64, count: usize| (((c - low) / CELL) as usize).min(count - 1);
        let [left, right] = [rect.low[0], rect.high[0]].map(|c| index(c, ink.area.low[0], ink.columns));
        let [top, bottom] = [rect.low[1], rect.high[1]].map(|c| index(c, ink.area.low[1], ink.rows));
        let at = |row: usize, column: usize| self.sums[row * (ink.columns + 1) + column];
        at(bottom + 1, right + 1) + at(top, left) == at(top, right + 1) + at(bottom + 1, left)
    }
}

/// Whether a segment meets a box: the part of it that is within the box in both directions.
fn meets([from, to]: [Spot; 2], rect: &Rect) -> bool {
    let (mut start, mut end) = (0.0_f64, 1.0_f64);
    for i in 0..2 {
        let d = to[i] - from[i];
        if d == 0.0 {
            if from[i] < rect.low[i] || from[i] > rect.high[i] {
                return false;
            }
            continue;
        }
        let (a, b) = ((rect.low[i] - from[i]) / d, (rect.high[i] - from[i]) / d);
        (start, end) = (start.max(a.min(b)), end.min(a.max(b)));
    }
    start <= end
}

/// Rectangles for the label in 16 directions and several distances; right and above come first, so that they
/// win among equals.
fn candidates(label: &Label) -> Vec<(Rect, f64)> {
    let [w, h] = label.size();
    let mut list = Vec::new();
    for radius in [2.0, 3.5, 6.0, 9.0, 13.0, 18.0, 24.0] {
        for turn in [0, 2, -2, 8, 6, -6, 4, -4, 1, -1, 7, -7, 3, 5, -3, -5] {
            let (s, c) = (f64::from(turn) * std::f64::consts::TAU / 16.0).sin_cos();
            let x = label.anchor[0] + c * (radius + w / 2.0);
            let y = label.anchor[1] - s * (radius + h / 2.0);
            let rect = Rect { low: [x - w / 2.0, y - h / 2.0], high: [x + w / 2.0, y + h / 2.0] };
            list.push((rect, radius));
        }
    }
    list
}

/// The ends of the line from a label's anchor to its text; none where they are close together.
fn leader(label: &Label, rect: &Rect, radius: f64) -> Option<[Spot; 2]> {
    let near = [0, 1].map(|i| label.anchor[i].clamp(rect.low[i], rect.high[i]));
    let d = [near[0] - label.anchor[0], near[1] - label.anchor[1]];
    let distance = d[0].hypot(d[1]);
    (radius > 3.0 && distance > 2.5).then(|| {
        let start = [0, 1].map(|i| label.anchor[i] + d[i] * 1.4 / distance);
        [start, [0, 1].map(|i| near[i] - d[i] * 0.4 / distance)]
    })
}

fn draw(label: &Label, rect: &Rect, radius: f64, theme: Theme) -> String {
    let mut out = String::new();
    if let Some([start, end]) = leader(label, rect, radius) {
        let leader = Element::new("line")
            .attribute("class", "leader")
            .length("x1", start[0])
            .length("y1", start[1])
            .length("x2", end[0])
            .length("y2", end[1])
            .attribute("stroke", &theme.faint().hex())
            .length("stroke-width", 0.15);
        out.push_str(&leader.empty());
    }
    // Beside its anchor a text is flush with it; above or below it is centred.
    let (anchor, x) = if rect.low[0] >= label.anchor[0] {
        ("start", rect.low[0])
    } else if rect.high[0] <= label.anchor[0] {
        ("end", rect.high[0])
    } else {
        ("middle", (rect.low[0] + rect.high[0]) / 2.0)
    };
    for (i, line) in label.lines.iter().enumerate() {
        let text = Element::new("text")
            .attribute("class", "label")
            .length("x", x)
            .length("y", rect.low[1] + LEADING * (i as f64 + 0.78))
            .length("font-size", SIZE)
            .attribute("text-anchor", anchor)
            .attribute("fill", &label.color.hex())
            .attribute("stroke", &theme.paper().hex())
            .length("stroke-width", 0.7)
            .attribute("stroke-linejoin", "round")
            .attribute("paint-order", "stroke");
        out.push_str(&text.text(line));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn label(anchor: Spot, words: &str) -> Label {
        Label { anchor, lines: vec![words.into()], color: Color([0; 3]), dispensable: false }
    }

    /// Of a crowded row of numbers those stay that stand free, the first among them; what has to be said is said all the same.
    #[test]
    fn what_is_dispensable_is_left_out_where_it_is_crowded() {
        let ink = Ink::new(Rect { low: [0.0, 0.0], high: [100.0, 60.0] });
        let row: Vec<Label> = (0..60)
            .map(|k| Label { dispensable: true, ..label([40.0 + 0.1 * f64::from(k), 30.0], "0.25") })
            .collect();
        let text = place(&row, &ink, Theme::Light, 1).0;
        let boxes: Vec<Rect> = text.split("<text").skip(1).map(around).collect();
        assert!((2..30).contains(&boxes.len()) && !text.contains("leader"), "{text}");
        for (k, rect) in boxes.iter().enumerate() {
            assert!(boxes[..k].iter().all(|other| !other.overlaps(rect)), "{boxes:?}");
        }
        let apart: Vec<Label> = (0..10)
            .map(|k| Label { dispensable: true, ..label([5.0 + 9.0 * f64::from(k), 30.0], "0.25") })
            .collect();
        assert_eq!(place(&apart, &ink, Theme::Light, 1).0.matches("<text").count(), 10);
    }

    #[test]
    fn labels_of_one_spot_do_not_overlap_and_keep_off_the_line() {
        let mut ink = Ink::new(Rect { low: [0.0, 0.0], high: [100.0, 60.0] });
        ink.segment([0.0, 30.0], [100.0, 30.0], 4);
        let labels: Vec<Label> = (0..6).map(|_| label([50.0, 30.0], "position at 0.25")).collect();
        let text = place(&labels, &ink, Theme::Light, 1).0;
        let boxes: Vec<Rect> = text.split("<text").skip(1).map(around).collect();
        assert_eq!(boxes.len(), 6, "{text}");
        for (k, rect) in boxes.iter().enumerate() {
            assert!(rect.high[1] < 30.0 || rect.low[1] > 30.0, "{rect:?} is on the line");
            assert!((0..2).all(|i| rect.low[i] >= 0.0 && rect.high[i] <= [100.0, 60.0][i]), "{rect:?}");
            for other in &boxes[..k] {
                let apart = |i: usize| rect.low[i] >= other.high[i] || other.low[i] >= rect.high[i];
                assert!(apart(0) || apart(1), "{rect:?} {other:?}");
            }
        }
        // Without the others, and without the line, all would stand in the same place.
        let clean = Ink::new(Rect { low: [0.0, 0.0], high: [100.0, 60.0] });
        let alone = around(place(&labels[..1], &clean, Theme::Light, 1).0.split("<text").nth(1).unwrap());
        assert!((alone.low[1]..alone.high[1]).contains(&30.0), "{alone:?}");
    }

    /// What a text element covers: as wide as its letters, from a little below its base line to their height.
    fn around(element: &str) -> Rect {
        let value = |name: &str| {
            let from = element.find(&format!(" {name}=\"")).unwrap() + name.len() + 3;
            element[from..].split('"').next().unwrap().to_owned()
        };
        let number = |name: &str| -> f64 { value(name).parse().unwrap() };
        let words = element.split('>').nth(1).unwrap().split('<').next().unwrap();
        let (wide, x, y) = (text::width(words) * SIZE, number("x"), number("y"));
        let left = match value("text-anchor").as_str() {
            "start" => x,
            "end" => x - wide,
            _ => x - wide / 2.0,
        };
        Rect { low: [left, y - 0.75 * SIZE], high: [left + wide, y + 0.2 * SIZE] }
    }

    #[test]
    fn a_leader_keeps_off_lines_that_lead_elsewhere() {
        let mut ink = Ink::new(Rect { low: [0.0, 0.0], high: [100.0, 60.0] });
        // No room but above and below, and above a line in between.
        (0..=20).for_each(|k| {
            let y = 25.0 + 0.5 * f64::from(k);
            ink.segment([0.0, y], [100.0, y], 9);
        });
        ink.segment([0.0, 22.0], [100.0, 22.0], 9);
        let text = place(&[label([50.0, 30.0], "position")], &ink, Theme::Light, 1).0;
        let y2: f64 = text.split("y2=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
        assert!(y2 > 30.0, "{text}");
    }

    /// Where no place around is free a label stands beside the drawing; where it would be too far off it has a number, and its words are for
    /// the legend.
    #[test]
    fn labels_never_stand_on_lines() {
        let mut ink = Ink::new(Rect { low: [0.0, 0.0], high: [200.0, 60.0] });
        (0..=60).for_each(|k| ink.segment([0.0, f64::from(k)], [160.0, f64::from(k)], 1));
        let (text, apart) = place(&[label([140.0, 30.0], "position at 0.5")], &ink, Theme::Light, 1);
        let rect = around(text.split("<text").nth(1).unwrap());
        assert!(rect.low[0] > 160.0 && apart.is_empty() && text.contains("leader"), "{rect:?}");
        // A slit of no more than a figure.
        let mut ink = Ink::new(Rect { low: [0.0, 0.0], high: [200.0, 60.0] });
        (0..=60).for_each(|k| {
            ink.segment([0.0, f64::from(k)], [95.0, f64::from(k)], 1);
            ink.segment([100.0, f64::from(k)], [200.0, f64::from(k)], 1);
        });
        let (text, apart) = place(&[label([90.0, 30.0], "position at 0.5")], &ink, Theme::Light, 7);
        let rect = around(text.split("<text").nth(1).unwrap());
        assert!(rect.low[0] > 95.0 && rect.high[0] < 100.0 && text.contains(">7<"), "{rect:?} {text}");
        assert_eq!(apart, ["position at 0.5"]);
    }

    #[test]
    fn a_label_in_the_corner_stays_inside() {
        let ink = Ink::new(Rect { low: [0.0, 0.0], high: [100.0, 60.0] });
        let text = place(&[label([99.0, 1.0], "a long label here")], &ink, Theme::Light, 1).0;
        assert!(text.contains("text-anchor=\"end\""), "{text}");
    }
}

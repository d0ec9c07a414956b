//! Labels that keep away from lines and from one another.

mod drawn;

use std::collections::HashSet;

use self::drawn::{draw, leader};
use crate::layout::Rect;
use crate::path::Spot;
use crate::text;
use crate::theme::{Color, Theme};

/// The size of labels, in millimetres.
pub(crate) const SIZE: f64 = 2.9;

/// Places nearer than this on the page are one, in millimetres.
pub(crate) const ONE: f64 = 0.6;

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
    /// Where it is one of a row of numbers that tells nearly as much without it: then it is left out where there is no room near its spot.
    pub(crate) row: Option<Row>,
}

/// What a label is to the row of numbers that it belongs to.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Row {
    /// How far down a row of its length is halved until it is met: the ends are 0, the middle is 1, quarters are 2. What is met first has
    /// the first choice of places, so that a row is thinned evenly.
    pub(crate) rank: u32,
    /// Whose numbers these are.
    pub(crate) object: String,
}

impl Row {
    /// Whether the row cannot be read without it: its ends and its middle.
    fn holds(&self) -> bool {
        self.rank <= 1
    }
}

/// The ranks of a row of so many numbers.
pub(crate) fn ranks(count: usize) -> Vec<u32> {
    let mut ranks = vec![0; count];
    let mut open = vec![(0_usize, count.saturating_sub(1), 1)];
    while let Some((first, last, rank)) = open.pop() {
        let middle = first.midpoint(last);
        if middle > first {
            ranks[middle] = rank;
            open.extend([(first, middle, rank + 1), (middle, last, rank + 1)]);
        }
    }
    ranks
}

impl Label {
    fn size(&self) -> [f64; 2] {
        let width = self.lines.iter().map(|line| text::width(line)).fold(0.0, f64::max);
        [width * SIZE, self.lines.len() as f64 * LEADING]
    }
}

/// What has become of labels.
#[derive(Debug, Default)]
pub(crate) struct Placed {
    /// The elements of those that have a place.
    pub(crate) drawn: String,
    /// Whose rows have numbers that are left out, and how many.
    pub(crate) left: Vec<(String, usize)>,
}

/// Places labels one after another and draws them. Those whose words have no room have a number in the drawing, from 1 on, and their words go into the
/// legend: into `apart`, where they are once, however many places of a page they are at. Where there are `faces`, leaders have a halo, so that they are
/// read on any colour.
///
/// A label stands where nothing is drawn, no other label is and no leader runs: near its anchor, else further off with a leader, beside
/// the drawing if need be; only its leader may cross lines. Rows of numbers come last, by rank, and stay near their spots; what has no room
/// there is left out, and counted. `O(cells of the page)` for each label that is moved away.
pub(crate) fn place(
    labels: &[Label],
    ink: &Ink,
    (theme, faces): (Theme, bool),
    apart: &mut Vec<String>,
) -> Placed {
    let rows = labels.iter().filter(|label| label.row.is_some()).map(|label| label.anchor);
    let spots = rows.take(Numbers::MOST).collect();
    let anchors = labels.iter().map(|label| label.anchor).take(Numbers::MOST).collect();
    let mut page = Page { spots, anchors, ..Page::clean(ink) };
    let mut found = Placed::default();
    let mut order: Vec<&Label> = labels.iter().collect();
    // What has to be said has the first choice. The sort is stable: else they come as they are given.
    order.sort_by_key(|label| label.row.as_ref().map(|row| row.rank));
    let mut numbers = Numbers::default();
    for label in order {
        if numbers.are_said(label) {
            continue;
        }
        let place =
            if numbers.are_many(label) { None } else { page.beside(label).or_else(|| page.away(label)) };
        if let Some(spot) = place {
            found.drawn.push_str(&page.take(label, spot, theme, faces));
            continue;
        }
        if let Some(row) = &label.row {
            match found.left.iter_mut().find(|(object, _)| *object == row.object) {
                Some((_, count)) => *count += 1,
                None => found.left.push((row.object.clone(), 1)),
            }
            continue;
        }
        let words = label.lines.join("; ");
        let at = apart.iter().position(|known| *known == words).unwrap_or_else(|| {
            apart.push(words);
            apart.len() - 1
        });
        let number = Label { lines: vec![(at + 1).to_string()], ..label.clone() };
        if let Some(spot) = page.beside(&number).or_else(|| page.away(&number)) {
            found.drawn.push_str(&page.take(&number, spot, theme, faces));
        }
    }
    found
}

/// The numbers of rows that have been placed, or not.
#[derive(Default)]
struct Numbers {
    tried: usize,
    /// By their words and the square that they are in.
    said: HashSet<(String, [i64; 2])>,
}

impl Numbers {
    /// For so many numbers of rows a place is looked for: a page of more is black.
    const MOST: usize = 1000;

    /// Whether a number is said at its spot already: objects that share their places have one label there.
    fn are_said(&mut self, label: &Label) -> bool {
        let (Some(_), [words]) = (&label.row, &label.lines[..]) else { return false };
        // The casts saturate.
        let [x, y] = label.anchor.map(|c| (c / ONE).floor() as i64);
        let around = |k: i64| [x.saturating_add(k % 3 - 1), y.saturating_add(k / 3 - 1)];
        if (0..9).any(|k| self.said.contains(&(words.clone(), around(k)))) {
            return true;
        }
        self.said.insert((words.clone(), [x, y]));
        false
    }

    /// Whether no place is looked for any more.
    fn are_many(&mut self, label: &Label) -> bool {
        self.tried += usize::from(label.row.is_some());
        label.row.is_some() && self.tried > Self::MOST
    }
}

/// Whether there is room for words of such a size near a spot, as things are on the page.
pub(crate) struct Room<'a> {
    page: Page<'a>,
}

impl<'a> Room<'a> {
    /// The room that ink leaves.
    pub(crate) fn on(ink: &'a Ink) -> Self {
        Self { page: Page::clean(ink) }
    }

    /// How far off a label has to stand; `None` where it has no place.
    pub(crate) fn near(&self, label: &Label) -> Option<f64> {
        self.page.beside(label).or_else(|| self.page.away(label)).map(|(_, radius)| radius)
    }
}

/// How far a label's box is from lines at least: glyphs at their ends have a size. In millimetres.
const CLEAR: f64 = 0.5;

/// Labels further away than this have a number instead, in millimetres.
const FAR: f64 = 45.0;

/// The numbers of a row stand no further from their spots than this, in millimetres; those that hold the row may go further.
const NEAR: f64 = 12.0;
const HOLDING: f64 = 30.0;

/// The most ink, weighed, that the leader of a number of a row runs across: it would lead through half a drawing.
const TANGLED: f64 = 60.0;

/// The page while labels are placed.
struct Page<'a> {
    ink: &'a Ink,
    free: Free,
    /// The spots of the numbers of rows.
    spots: Vec<Spot>,
    /// The spots of all labels: a leader that ran over one would seem to end there.
    anchors: Vec<Spot>,
    placed: Vec<Rect>,
    leaders: Vec<[Spot; 2]>,
    /// From the ends of leaders to the middles of their labels.
    gaps: Vec<[Spot; 2]>,
}

/// A leader keeps so far from spots that are not its own, in millimetres.
const PAST: f64 = 1.2;

impl<'a> Page<'a> {
    fn clean(ink: &'a Ink) -> Self {
        let (spots, anchors) = (Vec::new(), Vec::new());
        let (leaders, gaps) = (Vec::new(), Vec::new());
        Self { ink, free: Free::of(ink), spots, anchors, placed: Vec::new(), leaders, gaps }
    }
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

    /// Whether it is seen which spot of a row a number belongs to: a leader leads there, or none other is as near its box or its middle, nor would be
    /// if the number were as high as wide: words belong to what they are in a line with.
    fn is_told(&self, label: &Label, rect: &Rect, radius: f64) -> bool {
        let middle = [0, 1].map(|i| (rect.low[i] + rect.high[i]) / 2.0);
        let off = |spot: &Spot| {
            let [x, y] = [0, 1].map(|i| spot[i].clamp(rect.low[i], rect.high[i]) - spot[i]);
            let [dx, dy] = [0, 1].map(|i| middle[i] - spot[i]);
            [x.hypot(y), dx.hypot(dy), (dx * rect.size()[1]).hypot(dy * rect.size()[0])]
        };
        let own = off(&label.anchor);
        let rivals =
            |spot: &Spot| *spot != label.anchor && off(spot).iter().zip(own).any(|(d, own)| *d <= own);
        label.row.is_none() || leader(label, rect, radius).is_some() || !self.spots.iter().any(rivals)
    }

    /// What a leader would run across.
    fn crossed(&self, label: &Label, rect: &Rect, radius: f64) -> f64 {
        let Some([start, end]) = leader(label, rect, radius) else { return 0.0 };
        let through = self.placed.iter().filter(|other| meets([start, end], other)).count();
        // Between a leader and its words is no way through either.
        let gap = [end, middle(rect)];
        let meets_leader = |other: &&[Spot; 2]| cross([start, end], **other) || cross(gap, **other);
        let over = self.leaders.iter().filter(meets_leader).count()
            + self.gaps.iter().filter(|other| cross([start, end], **other)).count();
        let own = |spot: &Spot| (spot[0] - label.anchor[0]).hypot(spot[1] - label.anchor[1]) <= PAST;
        let past = self.anchors.iter().filter(|spot| !own(spot) && off([start, end], **spot) < PAST).count();
        self.ink.crossed(start, end) + 1000.0 * (through + over + past) as f64
    }

    /// The best of the places around its anchor.
    fn beside(&self, label: &Label) -> Option<(Rect, f64)> {
        let most = if label.row.is_some() { TANGLED } else { 1000.0 };
        let near = candidates(label).into_iter();
        near.filter(|(rect, radius)| self.is_free(rect) && self.is_told(label, rect, *radius))
            .map(|(rect, radius)| (self.crossed(label, &rect, radius), rect, radius))
            .filter(|(crossed, ..)| *crossed < most)
            .map(|(crossed, rect, radius)| (crossed + 1.5 * radius, (rect, radius)))
            .filter(|(cost, _)| *cost < 1000.0)
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, place)| place)
    }

    /// The nearest of all free places of the page whose leader runs across no other label.
    fn away(&self, label: &Label) -> Option<(Rect, f64)> {
        let far = match &label.row {
            None => FAR,
            Some(row) if row.holds() => HOLDING,
            Some(_) => NEAR,
        };
        let [w, h] = label.size();
        let area = &self.ink.area;
        // Those of the page that are not too far off.
        let steps = |i: usize, size: f64| {
            let room = area.high[i] - area.low[i] - size;
            let count = if room >= 0.0 { (room / (2.0 * CELL)).floor() as usize + 1 } else { 0 };
            let step = |at: f64| ((at - area.low[i]) / (2.0 * CELL)).max(0.0) as usize;
            let (first, end) = (step(label.anchor[i] - far - size), step(label.anchor[i] + far) + 2);
            (first..count.min(end)).map(move |k| 2.0 * CELL * k as f64)
        };
        let mut best: Option<(f64, (Rect, f64))> = None;
        for y in steps(1, h) {
            for x in steps(0, w) {
                let low = [area.low[0] + x, area.low[1] + y];
                let rect = Rect { low, high: [low[0] + w, low[1] + h] };
                let near = [0, 1].map(|i| label.anchor[i].clamp(rect.low[i], rect.high[i]) - label.anchor[i]);
                let distance = near[0].hypot(near[1]);
                let close = best.as_ref().is_none_or(|(cost, _)| 1.5 * distance < *cost);
                if distance > far || !close || !self.is_free(&rect) || !self.is_told(label, &rect, distance) {
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
    fn take(&mut self, label: &Label, (rect, radius): (Rect, f64), theme: Theme, halo: bool) -> String {
        let drawn = leader(label, &rect, radius);
        self.leaders.extend(drawn);
        self.gaps.extend(drawn.map(|[_, end]| [end, middle(&rect)]));
        // Two numbers beside one another would be read as one.
        let is_number = label.lines.iter().all(|line| line.bytes().all(|b| b.is_ascii_digit()));
        self.placed.push(rect.grown(if is_number && label.row.is_none() { SIZE / 2.0 } else { 0.4 }));
        draw(label, &rect, radius, (theme, halo))
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

/// The middle of a box.
fn middle(rect: &Rect) -> Spot {
    [0, 1].map(|i| (rect.low[i] + rect.high[i]) / 2.0)
}

/// How far a spot is from a segment.
fn off([from, to]: [Spot; 2], spot: Spot) -> f64 {
    let [d, e] = [[to[0] - from[0], to[1] - from[1]], [spot[0] - from[0], spot[1] - from[1]]];
    let square = d[0] * d[0] + d[1] * d[1];
    let share = if square > 0.0 { ((d[0] * e[0] + d[1] * e[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
    (e[0] - share * d[0]).hypot(e[1] - share * d[1])
}

/// Whether two segments cross.
fn cross([a, b]: [Spot; 2], [c, d]: [Spot; 2]) -> bool {
    let side = |p: Spot, q: Spot, r: Spot| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    (side(a, b, c) > 0.0) != (side(a, b, d) > 0.0) && (side(c, d, a) > 0.0) != (side(c, d, b) > 0.0)
}

/// Rectangles for the label in 16 directions and several distances; right and above come first, so that they
/// win among equals.
fn candidates(label: &Label) -> Vec<(Rect, f64)> {
    let [w, h] = label.size();
    let mut list = Vec::new();
    let radii: &[f64] = match label.row {
        None => &[2.0, 3.5, 6.0, 9.0, 13.0, 18.0, 24.0],
        Some(_) => &[2.0, BESIDE, 3.5, 5.0, 7.0, 9.5, NEAR],
    };
    for &radius in radii {
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

#[cfg(test)]
mod tests;

//! Stretches of seams, creases and poles.

use std::collections::{BTreeMap, BTreeSet};

use super::{Arranged, Border, Builder, Node, key};
use crate::brep::carrier::Carrier;
use crate::brep::cut::BESIDE;

/// Halvings of a stretch at most.
const DEPTH: u32 = 24;
/// How many chords go around a pole at least, for a whole turn.
const AROUND: f64 = 12.0;

/// A line of the plane along one of the parameters.
#[derive(Debug, Clone, Copy)]
struct Line {
    /// What is constant on it.
    direction: usize,
    at: f64,
    /// Whether all of it is a point.
    pole: bool,
}

impl Line {
    fn along(&self) -> usize {
        1 - self.direction
    }

    fn place(&self, x: f64, _: &Carrier) -> [f64; 2] {
        if self.direction == 0 { [self.at, x] } else { [x, self.at] }
    }
}

impl Builder<'_> {
    /// How far apart places on a pole may be, so that what reaches from there into the face, as far as the tolerance lets it, bends
    /// little enough.
    fn around(&self, line: Line) -> f64 {
        let carrier = self.carrier;
        let (along, across) = (&carrier.sides[line.along()], &carrier.sides[line.direction]);
        let (mut low, mut high) = ([0.0; 2], [0.0; 2]);
        (low[line.along()], high[line.along()]) = (along.low, along.high);
        (low[line.direction], high[line.direction]) = (across.low, across.high);
        let bends = |low, high| {
            let most = carrier.bounds.mean(low, high);
            [most[0], most[2]]
        };
        let reach = (8.0 * self.goal.chord / bends(low, high)[line.direction]).sqrt().min(across.length());
        if line.at == across.low {
            high[line.direction] = across.low + reach;
        } else {
            low[line.direction] = across.high - reach;
        }
        let step = (8.0 * BESIDE * self.goal.chord / bends(low, high)[line.along()]).sqrt();
        step.min(along.length() / AROUND)
    }

    /// Halves a stretch until what lies beside it bends little enough.
    fn halve(&mut self, line: Line, a: f64, b: f64, beside: &mut f64, out: &mut Vec<f64>) {
        let mut open = vec![(0_u32, a, b)];
        let around = if line.pole { self.around(line) } else { 0.0 };
        while let Some((depth, a, b)) = open.pop() {
            let box_at = |x: f64| line.place(x, self.carrier);
            let copies = self.copies(line.place(a, self.carrier));
            let mut most = 0.0_f64;
            let mut turns = false;
            for copy in copies.iter().filter(|copy| copy[line.along()] == a) {
                let at = copy[line.direction];
                let [low, high] = [a, b].map(|x| {
                    let mut place = box_at(x);
                    place[line.direction] = at;
                    place
                });
                // A line is on the border of cells: those before it count as those behind it.
                let thin = 1e-9 * self.carrier.sides[line.direction].length();
                let (mut l, mut h) = (low, high);
                l[line.direction] -= thin;
                h[line.direction] += thin;
                let mut step = [0.0; 2];
                step[line.along()] = b - a;
                most = most.max(self.carrier.bounds.spread(l, h).whole(step));
                let middle = box_at(0.5 * (a + b));
                let [n, o] = [self.carrier.normal(low, middle), self.carrier.normal(high, middle)];
                let apart = (self.carrier.point(low) - self.carrier.point(high)).norm();
                turns |= n.angle(&o) > self.goal.angle && apart > 2.0 * self.goal.chord;
            }
            let around = line.pole && (b - a) > around;
            if depth < DEPTH && (around || !line.pole && (most > BESIDE * self.goal.chord || turns)) {
                let middle = 0.5 * (a + b);
                open.extend([(depth + 1, middle, b), (depth + 1, a, middle)]);
            } else {
                if !line.pole {
                    *beside = beside.max(most);
                }
                out.push(b);
            }
        }
    }
}

/// Seams, creases and poles between the nodes on them.
pub(super) fn lines(
    all: &mut Builder<'_>,
    borders: &BTreeMap<[u32; 2], Border>,
    stretches: &mut BTreeSet<[u32; 2]>,
) -> Arranged {
    let carrier = all.carrier;
    // What is on one side of a seam is on the other, too.
    for node in 0..all.nodes.len() {
        let Node { at, point } = all.nodes[node];
        for copy in all.copies(at) {
            if !all.known.contains_key(&key(copy)) {
                let number = all.nodes.len() as u32;
                all.nodes.push(Node { at: copy, point });
                all.known.insert(key(copy), number);
            }
        }
    }
    let mut every: Vec<Line> = Vec::new();
    for direction in 0..2 {
        let side = &carrier.sides[direction];
        every.extend(side.lines.iter().map(|&at| Line { direction, at, pole: false }));
        for (end, at) in [side.low, side.high].into_iter().enumerate() {
            if carrier.poles[direction][end].is_some() {
                every.push(Line { direction, at, pole: true });
            }
        }
    }
    // From where to where each line reaches: between the nodes on it, and on to where the surface closes or ends in a pole.
    let mut reach: Vec<Option<[f64; 2]>> = every
        .iter()
        .map(|line| {
            let on = all.nodes.iter().filter(|node| node.at[line.direction] == line.at);
            let mut range = on.fold(None, |range: Option<[f64; 2]>, node| {
                let x = node.at[line.along()];
                let [low, high] = range.unwrap_or([x, x]);
                Some([low.min(x), high.max(x)])
            });
            let along = &carrier.sides[line.along()];
            for (end, x) in [along.low, along.high].into_iter().enumerate() {
                if along.closed || carrier.poles[line.along()][end].is_some() {
                    let [low, high] = range.unwrap_or([x, x]);
                    range = Some([low.min(x), high.max(x)]);
                }
            }
            range
        })
        .collect();
    // A line that only starts where the surface ends in a pole, and meets nothing, is none of the face's.
    for (line, range) in every.iter().zip(&mut reach) {
        let along = &carrier.sides[line.along()];
        if range.is_some_and(|[low, high]| low == high) && !along.closed {
            *range = None;
        }
    }
    let ends: Vec<[f64; 2]> = every
        .iter()
        .zip(&reach)
        .filter_map(|(line, range)| range.map(|range| range.map(|x| line.place(x, carrier))))
        .flatten()
        .collect();
    for at in ends {
        all.own(at);
    }
    for (k, line) in every.iter().enumerate() {
        for (l, other) in every.iter().enumerate().filter(|(_, other)| other.direction != line.direction) {
            if let [Some(a), Some(b)] = [reach[k], reach[l]]
                && line.direction == 0
                && (a[0]..=a[1]).contains(&other.at)
                && (b[0]..=b[1]).contains(&line.at)
            {
                all.own(line.place(other.at, carrier));
            }
        }
    }
    let mut arranged = Arranged {
        nodes: Vec::new(),
        borders: Vec::new(),
        stretches: Vec::new(),
        seams: Vec::new(),
        poles: Vec::new(),
        own: Vec::new(),
        beside: 0.0,
    };
    let mut by_line: BTreeMap<(usize, u64), Vec<f64>> = BTreeMap::new();
    for node in &all.nodes {
        for direction in 0..2 {
            let line = (direction, (node.at[direction] + 0.0).to_bits());
            by_line.entry(line).or_default().push(node.at[1 - direction]);
        }
    }
    for line in &every {
        let Some(on) = by_line.get_mut(&(line.direction, (line.at + 0.0).to_bits())) else { continue };
        on.sort_unstable_by(f64::total_cmp);
        on.dedup();
        let on = on.clone();
        for pair in on.windows(2) {
            let [a, b] = [pair[0], pair[1]];
            let [Some(&first), Some(&last)] = [a, b].map(|x| all.known.get(&key(line.place(x, carrier))))
            else {
                continue;
            };
            if borders.contains_key(&[first.min(last), first.max(last)]) {
                continue;
            }
            let side = &carrier.sides[line.direction];
            let seam = side.closed && !line.pole && (line.at == side.low || line.at == side.high);
            // Where one side of a seam is a border the other one is none of the face's.
            let twin = if line.at == side.low { side.high } else { side.low };
            let across = Line { at: twin, ..*line };
            if seam {
                let ends = [a, b].map(|x| all.known.get(&key(across.place(x, carrier))).copied());
                if let [Some(c), Some(d)] = ends
                    && borders.contains_key(&[c.min(d), c.max(d)])
                {
                    continue;
                }
            }
            let mut places = vec![a];
            let mut beside = 0.0;
            all.halve(*line, a, b, &mut beside, &mut places);
            arranged.beside = arranged.beside.max(beside);
            let mut before = first;
            for &x in &places[1..] {
                let next = all.own(line.place(x, carrier));
                let pair = [before.min(next), before.max(next)];
                if pair[0] != pair[1] {
                    stretches.insert(pair);
                    if line.pole {
                        arranged.poles.push(pair);
                    }
                }
                if seam && line.at == side.low {
                    let places = [before, next].map(|node| all.nodes[node as usize].at);
                    let others = places.map(|mut at| {
                        at[line.direction] = side.high;
                        all.own(at)
                    });
                    arranged.seams.push([[before, next], others]);
                }
                before = next;
            }
        }
    }
    arranged
}

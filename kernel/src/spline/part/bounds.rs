//! The axis-parallel box around the part of a surface that loops bound.
//!
//! A coordinate is largest on the border, at a crease, or inside, where its derivatives vanish. The border is looked at in many places, and climbed from
//! those that are higher than what is beside them. Inside, pieces are halved best first, as for whole surfaces ([`Surface::bounds`]), but for
//! those beyond the border and those in which a derivative of the coordinate keeps its sign (at a crease: the one along it).

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::Part;
use super::border::on;
use crate::Point;
use crate::error::Result;
use crate::spline::bounds::{
    Controls, HALVINGS, HALVINGS_A_SPAN, Side, Value, hull, is_straighter_in_rows, tight,
};
use crate::spline::closest::Kept;
use crate::spline::piece::{bezier_patch, halves, halves_of_rows};
use crate::spline::{Space, Surface};

/// Places of each span of a loop's curve that are looked at.
const LOOKS: usize = 64;
/// Steps of a search between two of them, each of which leaves .618 of the way: 1e-12 of it.
const STEPS: usize = 58;
/// The part of an interval that a step of the search leaves: the golden section.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

impl Part {
    /// The corners of the axis-parallel box around the part, the lower first: inside as near as [`Surface::bounds`] is. On the border each side is that of
    /// places that were climbed to, from 64 of each span of a loop's curve. About as much as the box around the surface, 64 evaluations
    /// a span, and some sixty for each of its highest places.
    ///
    /// # Errors
    /// When an evaluation overflows.
    pub fn bounds(&self) -> Result<(Point, Point)> {
        let net = Controls { points: self.surface.points(), weights: self.surface.weights() };
        let hull = self.surface.hull_bounds();
        if self.border.is_empty() || !(hull.1 - hull.0).amax().is_finite() {
            return Ok(self.surface.bounds());
        }
        let mut chains = Vec::with_capacity(self.border.len());
        for number in 0..self.border.len() {
            chains.push(self.looks(number)?);
        }
        let mut failed = None;
        let found = tight(&net, hull, |side| {
            let border = self.highest_of_border(side, &chains);
            match border {
                Ok(border) => self.highest(side, border),
                Err(error) => {
                    failed.get_or_insert(error);
                    f64::NAN
                }
            }
        });
        failed.map_or(Ok(found), Err)
    }

    /// Parameters of a curve of the border, ascending, and the points there.
    fn looks(&self, number: usize) -> Result<Vec<(f64, Point)>> {
        let (from, to) = self.border[number].range();
        let knots = self.border[number].curve().space().breakpoints();
        let mut ends = vec![from];
        ends.extend(knots.into_iter().filter(|t| *t > from && *t < to));
        ends.push(to);
        let mut all = Vec::with_capacity(LOOKS * ends.len());
        for pair in ends.windows(2) {
            for k in 0..LOOKS {
                let t = pair[0] + (pair[1] - pair[0]) * (k as f64 / LOOKS as f64);
                all.push((t, self.on_border(number, t)?));
            }
        }
        all.push((to, self.on_border(number, to)?));
        Ok(all)
    }

    fn on_border(&self, number: usize, t: f64) -> Result<Point> {
        Ok(on(&self.surface, self.outline.sides(), &self.border[number], t)?.1)
    }

    /// The largest coordinate of the border towards a side.
    fn highest_of_border(&self, side: &Side<'_>, chains: &[Vec<(f64, Point)>]) -> Result<f64> {
        let value = |p: &Point| side.sign * (p[side.axis] - side.origin);
        let mut best = chains.iter().flatten().map(|(_, p)| value(p)).fold(f64::NEG_INFINITY, f64::max);
        for (number, looks) in chains.iter().enumerate() {
            for k in 0..looks.len() {
                let (before, after) = (k.saturating_sub(1), (k + 1).min(looks.len() - 1));
                let [own, left, right] = [k, before, after].map(|k| value(&looks[k].1));
                // Between two places it rises by no more than from one to the next, or so.
                if own < left.max(right) || own + (own - left.min(right)) <= best {
                    continue;
                }
                let (mut low, mut high) = (looks[before].0, looks[after].0);
                for _ in 0..STEPS {
                    let (a, b) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
                    let [x, y] = [self.on_border(number, a)?, self.on_border(number, b)?].map(|p| value(&p));
                    best = best.max(x).max(y);
                    (low, high) = if x < y { (a, high) } else { (low, b) };
                }
            }
        }
        Ok(best)
    }

    /// The largest coordinate of the part towards a side, where that of its border is known.
    fn highest(&self, side: &Side<'_>, border: f64) -> f64 {
        let (u, v) = (self.surface.u(), self.surface.v());
        let creases = [u, v].map(creases);
        let mut heap: BinaryHeap<Piece> = pieces(&self.surface, side).into();
        let mut left = heap.len().saturating_mul(HALVINGS_A_SPAN).saturating_add(HALVINGS);
        let mut known = border;
        while let Some(piece) = heap.pop() {
            // No other piece has a larger bound.
            if piece.bound <= known + side.tolerance || left == 0 {
                return known.max(piece.bound);
            }
            let share = self.outline.share(piece.at);
            if share == Some(false) {
                continue;
            }
            let net = match piece.net {
                Ok(net) => net,
                Err(span) => {
                    let vertices = acting(u, v, span).map(|vertex| side.value(vertex)).collect();
                    let net = bezier_patch(u, v, span, vertices);
                    heap.push(Piece { bound: hull(&net).min(piece.bound), at: piece.at, net: Ok(net) });
                    continue;
                }
            };
            let at_crease = [0, 1].map(|d| {
                let (low, high) = piece.at[d];
                creases[d].iter().any(|knot| *knot >= low && *knot <= high)
            });
            let columns = v.degree() + 1;
            let [by_u, by_v] = keeps_sign(&net, columns);
            // On a crease only what happens along it counts.
            let rises = match at_crease {
                [false, false] => by_u || by_v,
                [true, false] => by_v,
                [false, true] => by_u,
                [true, true] => false,
            };
            if rises {
                continue;
            }
            if share == Some(true) {
                // Of a larger piece a corner may be beyond the border, between that and its chords.
                let last = net.len() - 1;
                let corners = [0, columns - 1, last + 1 - columns, last].map(|k| net[k][0] / net[k][1]);
                known =
                    corners.into_iter().filter(|x| piece.bound - x <= side.tolerance).fold(known, f64::max);
            }
            left -= 1;
            // What is across the border is left out in the end as it gets small both ways.
            let by_u = if share == Some(true) {
                is_straighter_in_rows(&net, columns)
            } else {
                let part = |d: usize| (piece.at[d].1 - piece.at[d].0) / [u, v][d].length();
                part(0) >= part(1)
            };
            heap.extend(cut(&net, columns, piece.at, by_u).map(|(net, at)| Piece {
                bound: hull(&net).min(piece.bound),
                at,
                net: Ok(net),
            }));
        }
        known
    }
}

/// The parameters inside a space at which its functions may have a crease.
fn creases(space: &Space) -> Vec<f64> {
    let all = space.breakpoints();
    let (degree, end) = (space.degree(), all.len() - 1);
    let seam = space.is_periodic();
    let inner = all.into_iter().enumerate().filter(|(k, _)| seam || (*k > 0 && *k < end));
    inner.map(|(_, knot)| knot).filter(|knot| space.multiplicity(*knot) >= degree).collect()
}

/// The control vertices of a pair of spans, row after row.
fn acting<'a>(u: &'a Space, v: &'a Space, (i, j): (usize, usize)) -> impl Iterator<Item = usize> + 'a {
    let (p, q) = (u.degree(), v.degree());
    (i - p..=i).flat_map(move |r| (j - q..=j).map(move |c| u.vertex(r) * v.len() + v.vertex(c)))
}

fn pieces(surface: &Surface, side: &Side<'_>) -> Vec<Piece> {
    let (u, v) = (surface.u(), surface.v());
    let spans = u.spans().flat_map(|i| v.spans().map(move |j| (i, j)));
    spans
        .map(|(i, j)| {
            let vertices = acting(u, v, (i, j)).map(|vertex| side.coordinate(vertex));
            let at = [(u.flat()[i], u.flat()[i + 1]), (v.flat()[j], v.flat()[j + 1])];
            Piece { bound: vertices.fold(f64::NEG_INFINITY, f64::max), at, net: Err((i, j)) }
        })
        .collect()
}

/// A box of parameters, and what the coordinate reaches there at most.
struct Piece {
    bound: f64,
    at: [(f64, f64); 2],
    /// Its Bézier net, or the spans that it is to be made of.
    net: std::result::Result<Vec<Value>, (usize, usize)>,
}

impl PartialEq for Piece {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Piece {}
impl PartialOrd for Piece {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Piece {
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound.total_cmp(&other.bound)
    }
}

/// Whether the derivatives of `f = x / w` along `u` and along `v` keep their signs: each is that of `x' - f w'`, which is linear in `f` and lies in the hull of what differences of
/// vertices are of it, at the least and the largest `f` of the piece.
fn keeps_sign(net: &[Value], columns: usize) -> [bool; 2] {
    let values = || net.iter().map(|[x, w]| if *w > 0.0 { x / w } else { f64::NAN });
    let (low, high) =
        values().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), f| (low.min(f), high.max(f)));
    let one_sign = |step: usize, has: &dyn Fn(usize) -> bool| {
        let differences =
            (0..net.len()).filter(|k| has(*k)).map(|k| [0, 1].map(|l| net[k + step][l] - net[k][l]));
        let all: Vec<f64> = differences.flat_map(|[x, w]| [x - low * w, x - high * w]).collect();
        !all.is_empty() && (all.iter().all(|d| *d > 0.0) || all.iter().all(|d| *d < 0.0))
    };
    [one_sign(columns, &|k| k + columns < net.len()), one_sign(1, &|k| k % columns + 1 < columns)]
}

/// A part of a net, and the parameters that it covers.
type Cut = (Vec<Value>, [(f64, f64); 2]);

/// Halves a net, and its box with it.
fn cut(net: &[Value], columns: usize, at: [(f64, f64); 2], by_u: bool) -> [Cut; 2] {
    let [first, second] =
        if by_u { halves(net, net.len() / columns, columns) } else { halves_of_rows(net, columns) };
    let d = usize::from(!by_u);
    let middle = 0.5 * at[d].0 + 0.5 * at[d].1;
    let (mut low, mut high) = (at, at);
    (low[d].1, high[d].0) = (middle, middle);
    [(first, low), (second, high)]
}

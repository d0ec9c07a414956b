//! What has to hold of the control vertices so that two edges are one, and their cross derivatives too.
//!
//! Edges are `A = N/w` and `B = M/x` with their weights fixed, each of `N, w, M, x` a power series across the edge whose
//! coefficients are splines along it. `A - B` vanishes to order `K` exactly where `N x - M w` does: linear in the control
//! vertices, whatever the weights.
//!
//! * *Weights alike*: where `x = λ w` up to order `K`, `λ` not varying along the edge (polynomial surfaces; equal weights up to
//!   a factor), that is `M = λ N`, an equality of splines: of their coefficients in a space that has both.
//! * *Otherwise* `N x - M w = 0` is a spline of the sum of the degrees, which vanishes where it does so at enough places of
//!   each span. What that leaves free is found first: mostly nothing but edges that are shrunk to a point (`w` and `x` have
//!   no common factor, so that `w` divides `N`), which is refused; more where the degrees were raised.

use super::dense::Split;
use super::places::{all_breakpoints, nodes, places};
use crate::error::{Error, MAX_DEGREE, Result};
use crate::shape::Stencil;
use crate::spline::binomial;
use crate::spline::space::{MAX_ORDER, Space};
use crate::text::short;
use crate::topology::pair::{Common, Map, Terms};
use crate::topology::{Pair, SurfaceEdge};

/// Weights that are alike to this part of themselves are: less moves an edge by no more than so much of its size.
const ALIKE: f64 = 1e-12;
/// Edges whose points move by less than this where unit vectors of control vertices do are shrunk to a point.
const SHRUNK: f64 = 1e-8;
/// The most coefficients of both edges, of all orders, for which what is left free is found.
const MOST: usize = 512;

/// What a join of whole edges asks.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Conditions {
    /// Pairs of stencils, of the first and of the second surface, that are equal where the join holds.
    pub(super) rows: Vec<(Stencil, Stencil)>,
    /// What is given up so that it can hold.
    pub(super) note: Option<String>,
    /// Where one piece of an edge ends and the next begins, in the first one's parameters.
    pub(super) breakpoints: Vec<f64>,
    /// The parameter step by which derivatives are made lengths: `d^k` times the `k`-th.
    pub(super) step: f64,
}

/// Why edges cannot be one, and what to do.
pub(super) type Refusal = String;

/// Something, or why it cannot be had; or an error on the way.
type Outcome<T> = Result<std::result::Result<T, Refusal>>;

impl Conditions {
    /// The conditions for continuity `order`. With a tolerance, where they cannot simply be made the same: those of meeting at
    /// as many places as the larger edge has control vertices.
    pub(super) fn new(pair: &Pair<'_>, order: usize, tolerant: bool) -> Outcome<Self> {
        let common = pair.common()?;
        let strips = Strips::new(pair, order)?;
        let (na, nb) = (pair.first.space().len(), pair.second.space().len());
        let weights = strips.weights(pair, &common);
        let alike = weights.factors();
        // One edge's space contains the other's: coefficients in it are as many conditions as there are.
        let nested = common.space.len() == na.max(nb);
        let own = |rows, note| {
            let breakpoints = common.space.breakpoints();
            Ok(Ok(Self { rows, note, breakpoints, step: strips.step }))
        };
        if tolerant && (alike.is_none() || !nested || common.nearly.is_some()) {
            let breakpoints = all_breakpoints(pair, &common);
            return Ok(Ok(Self {
                rows: meeting(pair, &strips)?,
                note: None,
                breakpoints,
                step: strips.step,
            }));
        }
        if let Some((s, t)) = common.nearly {
            return Ok(Err(format!(
                "the edges have knots that nearly agree, {s} and {t}: make them equal, or ask for a tolerance"
            )));
        }
        match alike {
            Some(factors) if nested => {
                let note = if na != nb { given_up(na, nb, na.min(nb)) } else { None };
                own(strips.equal(&lines(&common, &weights, factors[0]), &factors), note)
            }
            Some(factors) => match strips.unlike(pair, &common, &weights, factors[0])? {
                Err(refusal) => Ok(Err(refusal)),
                Ok((lines, note)) => own(strips.equal(&lines, &factors), note),
            },
            None => match strips.product(pair, &common, &weights)? {
                Err(refusal) => Ok(Err(refusal)),
                Ok((rows, note)) => own(strips.rows(&rows), note),
            },
        }
    }
}

/// One condition in terms of the strips' coefficients: order, coefficient and factor, of the first and of the second edge.
type Row = [Vec<(usize, usize, f64)>; 2];

/// One condition, the same for every order: coefficients and factors, of the first and of the second edge.
type Line = [Terms; 2];

/// The cross derivatives of `w S` along both edges.
struct Strips {
    order: usize,
    /// Derivatives of order `k` are multiplied by its `k`-th power, which makes them lengths like those of the net.
    step: f64,
    /// For each edge and order, every coefficient along the edge.
    of: [Vec<Vec<Stencil>>; 2],
}

impl Strips {
    fn new(pair: &Pair<'_>, order: usize) -> Result<Self> {
        let largest = [pair.first, pair.second]
            .into_iter()
            .filter_map(|side| side.strips().get(1).filter(|_| order > 0))
            .fold(0.0_f64, |m, strip| m.max(strip.largest));
        let step = if order > 0 { 1.0 / largest } else { 1.0 };
        if !(step > 0.0 && step.is_finite()) {
            return Err(Error::Invalid(
                "a surface is too short across the edge: choose a longer domain".into(),
            ));
        }
        let strips = |side: &SurfaceEdge<'_>, signed: bool| -> Vec<Vec<Stencil>> {
            let orders = side.strips().iter().take(order + 1).enumerate();
            let scaled = orders.map(|(k, strip)| {
                let factor = if signed { pair.sign(k) } else { 1.0 } * step.powi(k as i32);
                strip.coefficients.iter().map(|stencil| stencil.clone().scaled(factor)).collect()
            });
            scaled.collect()
        };
        Ok(Self { order, step, of: [strips(pair.first, false), strips(pair.second, true)] })
    }

    fn weights(&self, pair: &Pair<'_>, common: &Common) -> Weights {
        let of = |e: usize, side: &SurfaceEdge<'_>, map: &Map| {
            (0..=self.order)
                .map(|k| {
                    let sums: Vec<(f64, f64)> = self.of[e][k]
                        .iter()
                        .map(|stencil| {
                            let all = stencil.coefficients();
                            let size = all.iter().map(|c| c.abs()).sum();
                            // Without weights the sum is known; rounding must not put any there.
                            let sum = if side.is_rational() {
                                all.iter().sum()
                            } else {
                                f64::from(u8::from(k == 0))
                            };
                            (sum, size)
                        })
                        .collect();
                    map.iter()
                        .map(|row| {
                            row.iter()
                                .fold((0.0, 0.0), |s, &(i, c)| (s.0 + c * sums[i].0, s.1 + c * sums[i].1))
                        })
                        .collect()
                })
                .collect()
        };
        Weights([of(0, pair.first, &common.first), of(1, pair.second, &common.second)])
    }

    /// `M = λ N` order after order, for lines of what the coefficients of `λ N` and of `M` have to meet.
    fn equal(&self, lines: &[Line], factors: &[f64]) -> Vec<(Stencil, Stencil)> {
        let row = |k: usize, [a, b]: &Line| {
            let lower = (0..=k).filter(|l| factors[k - l] != 0.0);
            let first = lower.flat_map(|l| {
                let factor = binomial(k, l) * factors[k - l];
                a.iter().map(move |&(i, c)| (l, i, factor * c))
            });
            [first.collect(), b.iter().map(|&(i, c)| (k, i, c)).collect()]
        };
        let orders = 0..=self.order;
        let rows: Vec<Row> = orders.flat_map(|k| lines.iter().map(move |line| row(k, line))).collect();
        self.rows(&rows)
    }

    /// The lines of edges of which neither's space contains the other's: an orthonormal basis of the coefficients' equations,
    /// some of which may be dependent; and what it leaves free, which may be a point where closed edges have unlike knots.
    fn unlike(
        &self,
        pair: &Pair<'_>,
        common: &Common,
        weights: &Weights,
        factor: f64,
    ) -> Outcome<(Vec<Line>, Option<String>)> {
        let (na, nb) = (pair.first.space().len(), pair.second.space().len());
        if na + nb > MOST {
            let space = &common.space;
            let torn = space.breakpoints().iter().any(|&t| space.multiplicity(t) > space.degree());
            return Ok(if torn || pair.first.space().is_periodic() || pair.second.space().is_periodic() {
                Err(too_many(na + nb))
            } else {
                Ok((lines(common, weights, factor), None))
            });
        }
        let dense = |(a, b): (&Terms, &Terms)| {
            let mut row = vec![0.0; na + nb];
            a.iter().for_each(|&(i, c)| row[i] += c);
            b.iter().for_each(|&(i, c)| row[na + i] -= c);
            row
        };
        let rows = common.first.iter().zip(&common.second).map(dense).collect();
        let split = Split::new(rows, na + nb).ok_or_else(overflow)?;
        if shrunk(&split, common, weights) && !both_points(pair)? {
            return Ok(Err(
                "the edges are closed and have unlike knots, so they could only meet where each is shrunk to a point; \
                 refine both to the same knots, or ask for a tolerance"
                    .into(),
            ));
        }
        let heaviest = weights.0[0][0].iter().fold(0.0_f64, |m, (w, _)| m.max(*w));
        let by = 1.0 / (factor * heaviest);
        let line = |vector: &Vec<f64>| {
            let terms = |part: &[f64], by: f64| {
                part.iter().enumerate().filter(|(_, c)| **c != 0.0).map(|(i, c)| (i, by * c)).collect()
            };
            [terms(&vector[..na], by), terms(&vector[na..], -by)]
        };
        Ok(Ok((split.spanned().iter().map(line).collect(), given_up(na, nb, split.free().len()))))
    }

    /// `N x - M w = 0` up to the order, at as many places of each span as determine it; of that, an orthonormal basis.
    fn product(
        &self,
        pair: &Pair<'_>,
        common: &Common,
        weights: &Weights,
    ) -> Outcome<(Vec<Row>, Option<String>)> {
        let (na, nb) = (pair.first.space().len(), pair.second.space().len());
        let (each, orders) = (na + nb, self.order + 1);
        if each * orders > MOST {
            return Ok(Err(too_many(each * orders)));
        }
        let degree = pair.first.space().degree() + pair.second.space().degree();
        let mut rows = Vec::new();
        for t in nodes(&common.space.breakpoints(), degree + 1) {
            let here = Here::new(&common.space, t);
            let (a, b) = (here.row(&common.first, na), here.row(&common.second, nb));
            let value = |e: usize, k: usize| here.value(&weights.0[e][k]);
            for k in 0..orders {
                let mut row = vec![0.0; each * orders];
                for l in 0..=k {
                    let by = binomial(k, l);
                    let (x, w) = (by * value(1, k - l), by * value(0, k - l));
                    row[l * each..l * each + na].iter_mut().zip(&a).for_each(|(r, a)| *r += a * x);
                    row[l * each + na..(l + 1) * each].iter_mut().zip(&b).for_each(|(r, b)| *r -= b * w);
                }
                rows.push(row);
            }
        }
        let split = Split::new(rows, each * orders).ok_or_else(overflow)?;
        // Edges that are points already have nothing to lose, but for the directions in which surfaces leave them.
        if shrunk(&split, common, weights) && (orders > 1 || !both_points(pair)?) {
            return Ok(Err(self.shrinking(pair, weights)));
        }
        let term = |vector: &Vec<f64>| {
            let mut row: Row = [Vec::new(), Vec::new()];
            for (at, &c) in vector.iter().enumerate().filter(|(_, c)| **c != 0.0) {
                let (k, i) = (at / each, at % each);
                if i < na { row[0].push((k, i, c)) } else { row[1].push((k, i - na, -c)) }
            }
            row
        };
        let spanned: Vec<Row> = split.spanned().iter().map(term).collect();
        let left = split.free().len();
        Ok(Ok((spanned, given_up(na * orders, nb * orders, left))))
    }

    fn shrinking(&self, pair: &Pair<'_>, weights: &Weights) -> Refusal {
        let ratio = |j: usize| weights.0[1][0][j].0 / weights.0[0][0][j].0;
        let ratios: Vec<f64> = (0..weights.0[0][0].len()).map(ratio).collect();
        let (low, high) = ratios.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), r| (l.min(*r), h.max(*r)));
        let apart = high / low - 1.0;
        let (what, which) = if apart > ALIKE {
            (
                format!("the weights of the edges are unlike: their ratio varies by {}", percent(apart)),
                "along both edges",
            )
        } else {
            ("the weights beside the edges are unlike".to_owned(), "along and beside both edges")
        };
        let degree = pair.first.space().degree().max(pair.second.space().degree());
        let raise = if 2 * degree <= MAX_DEGREE {
            format!(", raise the degree of both along the edge by {degree}")
        } else {
            String::new()
        };
        format!(
            "{what}, so they could only meet where each is shrunk to a point; give both the same weights (up to a factor) \
             {which}{raise}, or ask for a tolerance"
        )
    }

    /// Conditions on strips as conditions on control vertices; those that touch none are left out.
    fn rows(&self, rows: &[Row]) -> Vec<(Stencil, Stencil)> {
        let sum = |e: usize, terms: &[(usize, usize, f64)]| -> Stencil {
            let all = terms.iter().flat_map(|&(k, i, c)| {
                self.of[e][k][i].iter().map(move |(vertex, value)| (vertex, c * value))
            });
            let mut all: Vec<(usize, f64)> = all.collect();
            all.sort_by_key(|(vertex, _)| *vertex);
            all.into_iter().collect()
        };
        rows.iter()
            .map(|row| (sum(0, &row[0]), sum(1, &row[1])))
            .filter(|(a, b)| a.coefficients().iter().chain(b.coefficients()).any(|c| *c != 0.0))
            .collect()
    }
}

/// The weights along both edges in the common space: for each edge, order and coefficient its value, and the size of the
/// numbers that it is a sum of.
struct Weights([Vec<Vec<(f64, f64)>>; 2]);

impl Weights {
    /// `λ` with `x = λ w` up to the order; `None` where there is no such.
    fn factors(&self) -> Option<Vec<f64>> {
        let [w, x] = &self.0;
        let first = &w[0];
        let squared: f64 = first.iter().map(|(w, _)| w * w).sum();
        let mut factors = Vec::with_capacity(w.len());
        for k in 0..w.len() {
            // x_k - Σ_(l>0) C(k, l) λ_(k-l) w_l should be λ_k w_0.
            let rest: Vec<(f64, f64)> = (0..first.len())
                .map(|j| {
                    (1..=k).fold(x[k][j], |(sum, size), l| {
                        let by: f64 = binomial(k, l) * factors[k - l];
                        (sum - by * w[l][j].0, size + by.abs() * w[l][j].1)
                    })
                })
                .collect();
            let dot: f64 = rest.iter().zip(first).map(|(r, w)| r.0 * w.0).sum();
            let size: f64 = rest.iter().zip(first).map(|(r, w)| r.1 * w.0).sum();
            // What is nothing but rounding is nothing: no row then touches vertices that it need not.
            let factor = if dot.abs() <= ALIKE * size { 0.0 } else { dot / squared };
            let agrees = |(r, w): (&(f64, f64), &(f64, f64))| {
                (r.0 - factor * w.0).abs() <= ALIKE * (r.1 + factor.abs() * w.1)
            };
            if !rest.iter().zip(first).all(agrees) {
                return None;
            }
            factors.push(factor);
        }
        Some(factors)
    }
}

/// The basis functions of a space at a place.
struct Here {
    vertices: Vec<usize>,
    values: [f64; MAX_ORDER],
}

impl Here {
    fn new(space: &Space, t: f64) -> Self {
        let (p, span) = (space.degree(), space.span(t));
        let mut values = [0.0; MAX_ORDER];
        space.basis_into(span, t, 0, &mut values);
        Self { vertices: (span - p..=span).map(|i| space.vertex(i)).collect(), values }
    }

    fn value(&self, coefficients: &[(f64, f64)]) -> f64 {
        self.vertices.iter().zip(self.values).map(|(&j, value)| value * coefficients[j].0).sum()
    }

    /// The value there in terms of an edge's own coefficients.
    fn row(&self, map: &Map, width: usize) -> Vec<f64> {
        let mut row = vec![0.0; width];
        for (&j, value) in self.vertices.iter().zip(self.values) {
            map[j].iter().for_each(|&(i, c)| row[i] += value * c);
        }
        row
    }
}

/// Whether what is left free shrinks the first edge to a point on some span.
fn shrunk(split: &Split, common: &Common, weights: &Weights) -> bool {
    let (space, width) =
        (&common.space, common.first.iter().flatten().map(|(i, _)| i + 1).max().unwrap_or(0));
    let breakpoints = space.breakpoints();
    breakpoints.windows(2).any(|span| {
        let points: Vec<Vec<f64>> = nodes(span, space.degree() + 1)
            .map(|t| {
                let here = Here::new(space, t);
                let (row, w) = (here.row(&common.first, width), here.value(&weights.0[0][0]));
                let value = |free: &Vec<f64>| row.iter().zip(free).map(|(r, f)| r * f).sum::<f64>() / w;
                split.free().iter().map(value).collect()
            })
            .collect();
        let Some((start, rest)) = points.split_first() else { return true };
        rest.iter().flatten().zip(start.iter().cycle()).all(|(p, start)| (p - start).abs() <= SHRUNK)
    })
}

/// Whether both edges are points already.
fn both_points(pair: &Pair<'_>) -> Result<bool> {
    for side in [pair.first, pair.second] {
        let (a, b) = side.space().domain();
        let start = side.point(a)?;
        let size = start.coords.amax();
        for t in nodes(&[a, b], 2 * side.space().len()) {
            if (side.point(t)? - start).amax() > 1e-12 * size {
                return Ok(false);
            }
        }
    }
    Ok(true)
}

/// Both meet, and their derivatives, at as many places as the larger edge has control vertices.
fn meeting(pair: &Pair<'_>, strips: &Strips) -> Result<Vec<(Stencil, Stencil)>> {
    let (first, second) = (pair.first.space(), pair.second.space());
    let at: Vec<(f64, f64)> = if first.len() >= second.len() {
        places(first).into_iter().map(|t| (t, pair.there(t))).collect()
    } else {
        places(second).into_iter().map(|u| (pair.here(u), u)).collect()
    };
    let mut rows = Vec::with_capacity(at.len() * (strips.order + 1));
    for k in 0..=strips.order {
        let by = strips.step.powi(k as i32);
        for &(t, u) in &at {
            let (a, b) = (pair.first.stencil(t, k)?, pair.second.stencil(u, k)?);
            rows.push((a.scaled(by), b.scaled(by * pair.sign(k))));
        }
    }
    rows.retain(|(a, b)| a.coefficients().iter().chain(b.coefficients()).any(|c| *c != 0.0));
    Ok(rows)
}

/// The equality of two edges' coefficients in one space, each divided by the weight there, so that it is a length.
fn lines(common: &Common, weights: &Weights, factor: f64) -> Vec<Line> {
    let both = common.first.iter().zip(&common.second).zip(&weights.0[0][0]);
    both.map(|((a, b), (w, _))| {
        let terms = |row: &[(usize, f64)]| row.iter().map(|&(i, c)| (i, c / (factor * w))).collect();
        [terms(a), terms(b)]
    })
    .collect()
}

fn given_up(first: usize, second: usize, left: usize) -> Option<String> {
    (left < first.max(second)).then(|| {
        format!(
            "so that the edges can be one, only {left} of {first} and {second} degrees of freedom are left along them: \
             refine both to the same knots, degrees and weights to keep all"
        )
    })
}

fn too_many(width: usize) -> Refusal {
    format!(
        "the edges have unlike knots or weights and {width} coefficients in all, too many to find out how they could be one \
         (at most {MOST}); refine both to the same knots, degrees and weights up to a factor, or ask for a tolerance"
    )
}

fn percent(part: f64) -> String {
    if part >= 1e-3 {
        format!("{:.3} %", 100.0 * part)
    } else {
        format!("{part} of itself", part = short(part))
    }
}

fn overflow() -> Error {
    Error::Invalid(
        "the weights along an edge are too far apart to compute with: choose more alike ones".into(),
    )
}

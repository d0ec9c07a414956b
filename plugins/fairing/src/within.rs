//! The least energy with no control vertex further from its place than a distance.
//!
//! `min E(x)` subject to `F x = b` and `|x_i - x⁰_i| ≤ r` is convex. Its multipliers `τ_i ≥ 0` are the weights of tethers:
//! `D(τ) = min E(x) + Σ τ_i (|x_i - x⁰_i|² - r²)` is never above the least energy, and is reached by the minimiser where the
//! tethers that pull hold their vertices at exactly `r`. Tethers grow where a vertex is too far away and shrink where it
//! is nearer; after each change the minimiser is drawn back along the line to a shape that is surely within the
//! distance, as far as it must be. So there is at every time a shape that meets everything and a bound for how much energy it has
//! too much, and the search ends where that is small.
//!
//! Every point of a shape is a convex combination of control vertices (of rational shapes, too: their weights are positive and
//! stay), so that no point moves further than the vertices do.

use loftsman_kernel::Vector;
use loftsman_kernel::edit::EditError;
use loftsman_kernel::error::Error;
use loftsman_kernel::shape::Grid;
use loftsman_kernel::solve::SolveError;

use crate::active::{Failure, Row};
use crate::convex::Convex;
use crate::damped::Damped;
use crate::minimise::Search;
use crate::squares::Squares;

/// Rounds of new tethers, and the part of the energy that may remain to be gained.
const ROUNDS: usize = 400;
/// Rounds of new planes.
const CUTS: usize = 100;
/// Proximal steps of a round, and the gain below which one is the last.
const STEPS: usize = 40;
const GAIN: f64 = 1e-7;
/// Rounds of new weights in search of a start.
const WEIGHTINGS: usize = 300;
/// A start with this part of the distance used is well inside.
const ROOMY: f64 = 0.9;
const GAP: f64 = 1e-3;
/// How fast tethers follow: `τ ← τ (|d| / r)^γ`. At 1 they creep, beyond 2 they swing.
const GAMMA: f64 = 1.5;

/// Moves a shape to the least of the energy and tethers of some weights; the steps that took.
pub(crate) type Tied<'a> = dyn FnMut(&[f64], &mut [Vector]) -> Result<Option<usize>, EditError> + 'a;

/// How a search begins.
pub(crate) enum Start {
    Inside(Vec<Vector>),
    Beyond {
        /// No shape has all vertices nearer than this.
        least: f64,
        /// This near some shape has.
        nearest: f64,
        /// What proves that: of every row, nothing where it plays no part.
        multipliers: Vec<f64>,
    },
}

/// What is to be kept within the distance, and how the search begins.
pub(crate) struct DistanceLimit<'a> {
    /// The vertices as they were.
    rest: &'a [Vector],
    /// The largest distance, positive.
    pub(crate) radius: f64,
    /// Which vertices may move.
    free: &'a [bool],
}

impl<'a> DistanceLimit<'a> {
    /// A bound on how far vertices move from where they rest.
    pub(crate) fn new(rest: &'a [Vector], radius: f64, free: &'a [bool]) -> Result<Self, Error> {
        if !(radius > 0.0 && radius.is_finite()) {
            return Err(Error::Invalid(format!(
                "a distance of {radius} is not possible: give a positive number"
            )));
        }
        Ok(DistanceLimit { rest, radius, free })
    }

    /// How far the start of a search may be.
    pub(crate) fn inside(&self) -> f64 {
        self.radius * (1.0 - 1e-6)
    }

    /// A shape that meets the rows with every vertex inside the distance, or a proof that there is none: Lawson's algorithm
    /// (1961). The weighted squares `Σ w_i |d_i|²` (with `Σ w_i = 1`) are least for some shape; whatever the weights, no shape that
    /// meets the rows has all of its vertices nearer than the root of that, and weights grow where vertices are far.
    pub(crate) fn start(&self, rows: &[Row], grid: &Grid) -> Result<Start, Failure> {
        let mut weights: Vec<f64> = self.free.iter().map(|&f| f64::from(u8::from(f))).collect();
        let mut inside: Option<(f64, Vec<Vector>)> = None;
        let mut best = Start::Beyond { least: 0.0, nearest: f64::INFINITY, multipliers: Vec::new() };
        let mut guess = Vec::new();
        for _ in 0..WEIGHTINGS {
            let mut squares = Squares::default();
            squares.tether(&weights, self.rest);
            let damped = Damped::new(&squares, self.free, grid).ok_or(Failure::Work)?;
            let convex = Convex { squares: &squares, damped: &damped, motions: &[], rows };
            let found = convex.step(self.rest, &guess)?;
            let (far, _) = self.farthest(&found.x);
            if far < self.inside() && inside.as_ref().is_none_or(|(before, _)| far < *before) {
                inside = Some((far, found.x.clone()));
            }
            let away = || found.x.iter().zip(self.rest).map(|(x, rest)| (x - rest).norm());
            let total: f64 = weights.iter().sum();
            let bound = (weights.iter().zip(away()).map(|(w, d)| w * d * d).sum::<f64>() / total).sqrt();
            if let Start::Beyond { least, nearest, multipliers } = &mut best {
                *nearest = nearest.min(far);
                if bound > *least {
                    (*least, *multipliers) = (bound, found.multipliers);
                }
                // Well inside, or nearly as far inside as can be.
                let roomy = far < ROOMY * self.radius || *nearest - *least < 0.1 * (self.radius - *nearest);
                if inside.is_some() && roomy {
                    break;
                }
                if *least >= self.radius || *nearest - *least <= 1e-9 * *nearest {
                    break;
                }
            }
            guess = found.active;
            for ((w, d), _) in weights.iter_mut().zip(away()).zip(self.free).filter(|(_, free)| **free) {
                *w *= (d / far).max(1e-3);
            }
            let most = weights.iter().fold(0.0_f64, |m, w| m.max(*w));
            let floor = |(w, free): (&mut f64, &bool)| *w = if *free { (*w / most).max(1e-9) } else { 0.0 };
            weights.iter_mut().zip(self.free).for_each(floor);
        }
        Ok(inside.map_or(best, |(_, x)| Start::Inside(x)))
    }

    /// The largest distance of a vertex from its place, and which vertex that is.
    pub(crate) fn farthest(&self, x: &[Vector]) -> (f64, usize) {
        let far = x.iter().zip(self.rest).map(|(x, rest)| (x - rest).norm());
        far.enumerate().fold((0.0, 0), |best, (i, d)| if d > best.0 { (d, i) } else { best })
    }

    /// Moves `x`, which meets the constraints and is within the distance, to (nearly) the least energy. `solve` moves it to the
    /// least of the energy and the tethers together, whatever the distance, and says in how many steps; `None` where
    /// that cannot be factored. The constraints must be convex: what lies between two shapes that meet them does, too.
    ///
    /// # Errors
    /// Those of `solve`; when the gap does not close.
    pub(crate) fn minimise(
        &self,
        squares: &Squares,
        solve: &mut Tied<'_>,
        x: &mut [Vector],
    ) -> Result<Search, EditError> {
        // A hair inside, so that rounding and the last correction cannot leave the distance.
        let radius = self.radius * (1.0 - 1e-9);
        let mut search = Search::default();
        let mut best = x.to_vec();
        let mut best_energy = squares.energy(x).0;
        // An energy this small, compared with the start's, is none.
        let nothing = 1e-13 * best_energy;
        let mut bound = 0.0_f64;
        let mut gradient = vec![Vector::zeros(); x.len()];
        squares.gradient(x, true, &mut gradient);
        let largest = gradient.iter().map(Vector::norm).fold(0.0, f64::max);
        if largest == 0.0 {
            return Ok(search);
        }
        let safe = x.to_vec();
        // What would hold each vertex at the distance if it alone moved.
        let mut tethers: Vec<f64> = gradient.iter().map(|g| g.norm().max(1e-6 * largest) / radius).collect();
        for _ in 0..ROUNDS {
            let Some(steps) = solve(&tethers, x)? else { break };
            search.steps += steps;
            let pull = |(t, (x, rest)): (&f64, (&Vector, &Vector))| {
                t * ((x - rest).norm_squared() - radius * radius)
            };
            let moving =
                tethers.iter().zip(x.iter().zip(self.rest)).zip(self.free).filter(|(_, free)| **free);
            bound = bound.max(squares.energy(x).0 + moving.map(|(one, _)| pull(one)).sum::<f64>());
            let inside = self.drawn_back(&safe, x, radius);
            let energy = squares.energy(&inside).0;
            if energy < best_energy {
                (best_energy, best) = (energy, inside);
            }
            search.gap = (best_energy - bound).max(0.0) / best_energy;
            if best_energy - bound <= (GAP * best_energy).max(nothing) {
                x.copy_from_slice(&best);
                return Ok(search);
            }
            for (tether, (x, rest)) in tethers.iter_mut().zip(x.iter().zip(self.rest)) {
                let ratio = ((x - rest).norm() / radius).clamp(0.1, 10.0);
                *tether *= ratio.powf(GAMMA);
            }
        }
        Err(SolveError::Unsupported(format!(
            "no shape within {} of the old one was found that is surely the fairest: after {} steps its energy may be {:.1} % \
             above the least; allow more, or take an energy that is less stiff",
            self.radius,
            search.steps,
            100.0 * search.gap
        ))
        .into())
    }

    /// The same by planes: a vertex that went too far is kept on this side of the plane that touches its sphere where it went.
    /// Planes keep to every shape within the distance, so that the least energy between them is never above the least within it;
    /// a few planes for each vertex do, since between two that are near a sphere bulges little (Kelley 1960). What tethers
    /// only creep towards, where hardly any shape is within the distance, this finds. `rows` are all that is asked.
    ///
    /// Returns what the search did, and the multipliers of the rows.
    ///
    /// # Errors
    /// When it cannot be decided which rows hold with equality, or the gap does not close.
    pub(crate) fn cut(
        &self,
        squares: &Squares,
        (damped, motions): (&Damped, &[Vec<f64>]),
        rows: &[Row],
        x: &mut [Vector],
    ) -> Result<(Search, Vec<f64>), Failure> {
        let radius = self.radius * (1.0 - 1e-9);
        let (safe, nothing) = (x.to_vec(), 1e-13 * squares.energy(x).0);
        let (mut best, mut best_energy) = (x.to_vec(), squares.energy(x).0);
        let (mut all, mut guess, mut search) = (rows.to_vec(), Vec::new(), Search::default());
        let mut now = self.rest.to_vec();
        for _ in 0..CUTS {
            let convex = Convex { squares, damped, motions, rows: &all };
            let (mut energy, mut multipliers) = (f64::INFINITY, Vec::new());
            for _ in 0..STEPS {
                let found = convex.step(&now, &guess)?;
                search.steps += 1;
                (now, guess, multipliers) = (found.x, found.active, found.multipliers);
                let before = std::mem::replace(&mut energy, squares.energy(&now).0);
                if before - energy <= GAIN * energy + nothing {
                    break;
                }
            }
            let inside = self.drawn_back(&safe, &now, radius);
            let drawn = squares.energy(&inside).0;
            if drawn < best_energy {
                (best_energy, best) = (drawn, inside);
            }
            search.gap = (best_energy - energy).max(0.0) / best_energy.max(f64::MIN_POSITIVE);
            if best_energy - energy <= (GAP * best_energy).max(nothing) {
                x.copy_from_slice(&best);
                multipliers.truncate(rows.len());
                return Ok((search, multipliers));
            }
            for (vertex, (x, rest)) in now.iter().zip(self.rest).enumerate() {
                let away = x - rest;
                let far = away.norm();
                if far > radius && self.free[vertex] {
                    let out = away / far;
                    let terms = (0..3).map(|axis| (3 * vertex + axis, -out[axis])).collect();
                    let value = -radius - out.dot(rest);
                    let size = rest.lp_norm(1) + self.radius;
                    all.push(Row { terms, value, equation: false, size });
                }
            }
        }
        Err(Failure::Work)
    }

    /// The point nearest to `x` on the way from `safe` to it that is within the distance.
    fn drawn_back(&self, safe: &[Vector], x: &[Vector], radius: f64) -> Vec<Vector> {
        let mut share = 1.0_f64;
        for ((s, x), rest) in safe.iter().zip(x).zip(self.rest) {
            let (from, by) = (s - rest, x - s);
            // |from + t by| = r for the larger t: the root of a quadratic, written so that nothing cancels.
            let (a, b, c) = (by.norm_squared(), from.dot(&by), radius * radius - from.norm_squared());
            if a > 0.0 && (from + by).norm() > radius {
                let root = (b * b + a * c).max(0.0).sqrt();
                let t = if b > 0.0 { c / (b + root) } else { (root - b) / a };
                share = share.min(t.clamp(0.0, 1.0));
            }
        }
        safe.iter().zip(x).map(|(s, x)| s + (x - s) * share).collect()
    }
}

//! Surfaces: fine tuning being said, and what comes of it.

use std::fmt;
use std::sync::Arc;

use loftsman_kernel::edit::Report;
use loftsman_kernel::solve::{Automatic, Solver};
use loftsman_kernel::spline::{Direction, Surface};

use crate::alpha::same;
use crate::curve::Ends;
use crate::error::{FineTuneError, Result};
use crate::lines::{across, index, name};
use crate::patch::{Region, patch, put_back};
use crate::scaling::Scaling;

/// Says how a surface should be tuned: its derivatives scaled by α, in one direction or in both, everywhere or in a region.
///
/// What the ends of a direction do is [`Ends`], as for curves, meant of each line in that direction:
/// * [`Ends::Exact`]: both edges across it stay, because α is changed for it as little as can be, in `∫∫ (Δα)²`. That is linear in
///   the values of α, with three equations for each function of `v` in the products `α S_u`: α(u, v) needs more than `3 (q + 1)`
///   values along `u` for each span across, where the surface is of degree `q`; α(u) can do it only where all lines are of one kind
///   (an extrusion, a plane), and else is refused. Where both directions are scaled, corners stay and each edge is tuned along
///   itself.
/// * [`Ends::Free`]: the edge `u = u₀` stays, the other goes where it goes.
/// * [`Ends::Position`], [`Ends::Tangent`], [`Ends::Curvature`]: one, two or three rows of control vertices at either end stay,
///   by one rotation and one scale of all lines, each about its own start: `D_u = s R α S_u`. Others for each line would be no tensor product, so
///   that where the lines want different ones it is refused; those of an extrusion want the same.
///
/// With [`Scaling::Both`] nothing is changed in α: none, one, two or three rows (and columns) of the tuned surface are kept with
/// `Free`, `Position`, `Tangent` and `Curvature`, and `Exact` keeps one more than the [continuity](Self::continuity).
///
/// ```
/// use loftsman_fine_tuning::{Ends, FineTuneSurface, Scaling, surface_alpha_spaces};
/// use loftsman_kernel::Point;
/// use loftsman_kernel::spline::{Space, Surface, algebra::Function};
///
/// let at = |i: u32, j: u32| Point::new(f64::from(i), f64::from(j), f64::from(i * j % 3));
/// let points = (0..6).flat_map(|i| (0..5).map(move |j| at(i, j))).collect();
/// let surface = Surface::new(Space::clamped_uniform(2, 6)?, Space::clamped_uniform(2, 5)?, points)?;
/// let [space, _] = surface_alpha_spaces(&surface)?;
/// let alpha = Function::new(space, vec![1.0, 1.0, 2.0, 1.0, 1.0])?;
/// let tuned = FineTuneSurface::new(&surface, Scaling::u(alpha.clone())).ends(Ends::Free).solve()?;
/// assert_eq!(tuned.surface().u().degree(), 3);
/// let scaled = surface.derivative(1.7, 0.3, 1, 0)? * alpha.value(1.7)?;
/// assert!((tuned.surface().derivative(1.7, 0.3, 1, 0)? - scaled).norm() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct FineTuneSurface {
    surface: Surface,
    pub(crate) scaling: Scaling,
    pub(crate) ends: [Ends; 2],
    pub(crate) region: Region,
    pub(crate) continuity: Option<u8>,
    pub(crate) pinned: Vec<Pin>,
    pub(crate) solver: Arc<dyn Solver>,
    pub(crate) any_sign: bool,
}

/// A value that α of a direction has at a place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pin {
    pub(crate) direction: Direction,
    pub(crate) at: (f64, f64),
    pub(crate) value: f64,
}

/// A tuned surface.
#[derive(Debug, Clone)]
pub struct TunedSurface {
    pub(crate) surface: Surface,
    pub(crate) scaling: Scaling,
    pub(crate) report: SurfaceReport,
}

/// What a tuning of a surface did; pairs are of `u` and `v`.
#[derive(Debug, Clone, Default)]
pub struct SurfaceReport {
    /// How the equations for α were solved, where there were any to solve.
    pub solved: [Option<Report>; 2],
    /// By what the tuned surface was scaled to keep its ends; 1 where it was not.
    pub scale: [f64; 2],
    /// `(mean (Δα)²)^½` over the domain: how far α had to be changed from the one asked for.
    pub change: [f64; 2],
    /// The smallest and the largest value of α in the end; `[1, 1]` in a direction that is not scaled.
    pub alpha: [[f64; 2]; 2],
    /// `(∫∫ |D_u - αS_u|² + |D_v - βS_v|² / ∫∫ |αS_u|² + |βS_v|²)^½` with [`Scaling::Both`]; else none.
    pub residual: Option<f64>,
    /// Anything else worth saying.
    pub notes: Vec<String>,
}

impl fmt::Debug for FineTuneSurface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FineTuneSurface")
            .field("surface", &self.surface)
            .field("scaling", &self.scaling)
            .finish_non_exhaustive()
    }
}

impl FineTuneSurface {
    /// The tuning of a surface by spline functions over its domain, or over the region that is tuned.
    pub fn new(surface: &Surface, scaling: Scaling) -> Self {
        // Weights that are all the same are none.
        let polynomial = match surface.weights() {
            Some(weights) if same(weights) => {
                Surface::new(surface.u().clone(), surface.v().clone(), surface.points().to_vec()).ok()
            }
            _ => None,
        };
        Self {
            surface: polynomial.unwrap_or_else(|| surface.clone()),
            scaling,
            ends: [Ends::default(); 2],
            region: [None; 2],
            continuity: None,
            pinned: Vec::new(),
            solver: Arc::new(Automatic),
            any_sign: false,
        }
    }

    /// What the ends of both directions do.
    #[must_use]
    pub fn ends(mut self, ends: Ends) -> Self {
        self.ends = [ends; 2];
        self
    }

    /// What the ends of one direction do.
    #[must_use]
    pub fn ends_along(mut self, direction: Direction, ends: Ends) -> Self {
        self.ends[index(direction)] = ends;
        self
    }

    /// Tunes the part from `a` to `b` in one direction and nothing else; said of both directions, a rectangle. Knots are inserted
    /// around it to full multiplicity; the rest is the same surface in higher degrees.
    #[must_use]
    pub fn between(mut self, direction: Direction, a: f64, b: f64) -> Self {
        self.region[index(direction)] = Some((a, b));
        self
    }

    /// How many derivatives across its border the tuned part has in common with the rest, with [`Ends::Exact`]: 0, 1 (`α = 1` on
    /// its ends) or 2 (`α_u = 0` there too); across the sides that α(u, v) has beside them, the same with one derivative of α
    /// more. By default 2 where a region joins the rest, 0 at the edges of the surface.
    #[must_use]
    pub fn continuity(mut self, derivatives: u8) -> Self {
        self.continuity = Some(derivatives.min(2));
        self
    }

    /// Holds α of a direction at a value in a place `(u, v)`, with [`Ends::Exact`]: the derivative is multiplied by just this there. Of an
    /// α of one parameter the other number does not matter.
    #[must_use]
    pub fn alpha_at(mut self, direction: Direction, at: (f64, f64), value: f64) -> Self {
        self.pinned.push(Pin { direction, at, value });
        self
    }

    /// Lets α be what it is where it is not positive: tangents turn round there.
    #[must_use]
    pub fn any_sign(mut self) -> Self {
        self.any_sign = true;
        self
    }

    /// The same with a solver of one's own for the equations for α.
    ///
    /// # Errors
    /// As for [`solve`](Self::solve).
    pub fn solve_with(mut self, solver: impl Solver + 'static) -> Result<TunedSurface> {
        self.solver = Arc::new(solver);
        self.solve()
    }

    /// The tuned surface. `O(n)` for free ends; exact ones solve `e` equations for `m` values of α, at most `O(m e²)`; both
    /// derivatives at once factor a matrix of the tuned surface's vertices in a band of some of its rows.
    ///
    /// # Errors
    /// When the surface is rational or torn, a degree would be above 25, α is not positive (and need be), jumps across its
    /// direction or is over another domain, the region is none or its border cannot be kept that way, or the ends cannot.
    pub fn solve(&self) -> Result<TunedSurface> {
        // All of a direction across the only one that is scaled, by a function of that alone, is no part of it.
        if let Scaling::Directional { u, v } = &self.scaling {
            for (direction, scaled) in [(Direction::U, u), (Direction::V, v)] {
                let whole = Some(self.surface.space(direction).domain());
                if scaled.is_none() && self.region[index(direction)] == whole {
                    let mut same = self.clone();
                    same.region[index(direction)] = None;
                    return same.solve();
                }
            }
        }
        if self.surface.weights().is_some() {
            return Err(FineTuneError::Rational { what: "surface" });
        }
        for pin in &self.pinned {
            let exact = self.ends[index(pin.direction)] == Ends::Exact;
            if !exact
                || matches!(self.scaling, Scaling::Both { .. })
                || self.scaling.of(pin.direction)?.is_none()
            {
                return Err(FineTuneError::Contradiction(format!(
                    "α along {} can be held at a value where it is one direction's and changed for it, with ends = \"exact\"",
                    name(pin.direction)
                )));
            }
        }
        if !self.any_sign {
            self.scaling.check_positive()?;
        }
        if self.region == [None; 2] {
            self.scaling.check_domains(&self.surface)?;
            let mut tuned = self.whole(&self.surface, self.scaling.clone())?;
            let both = matches!(self.scaling, Scaling::Directional { u: Some(_), v: Some(_) });
            if both && self.ends == [Ends::Exact; 2] {
                tuned.report.notes.push(
                    "the corners stay; each edge is tuned along itself, and moves: tune one direction after the other, by an alpha of u and v, to keep edges"
                        .into(),
                );
            }
            return Ok(tuned);
        }
        self.check_region()?;
        let given = patch(&self.surface, &self.region)?;
        let scaling = self.scaling.restricted(&self.region)?;
        scaling.check_domains(&given)?;
        let tuned = self.whole(&given, scaling)?;
        let kept = [Direction::U, Direction::V].map(|direction| self.kept(direction));
        Ok(TunedSurface { surface: put_back(&self.surface, &tuned.surface, &self.region, kept)?, ..tuned })
    }

    /// How many derivatives across either end of a direction stay, and whether the end itself is the border of a part: `None` where nothing is beside it and
    /// none were asked for. Two of a part by default where the rest joins it.
    pub(crate) fn joins(&self, direction: Direction) -> [Option<u8>; 2] {
        let space = self.surface.space(direction);
        let (start, end) = space.domain();
        match self.region[index(direction)] {
            Some((a, b)) => [a > start, b < end]
                .map(|inner| self.continuity.or((inner || space.is_periodic()).then_some(2))),
            None => [None; 2],
        }
    }

    /// Which ends of a part keep their control vertices: those that the rest joins, and those that α keeps.
    fn kept(&self, direction: Direction) -> [bool; 2] {
        let scaled = match &self.scaling {
            Scaling::Directional { u, v } => [u.is_some(), v.is_some()][index(direction)],
            Scaling::Along { direction: own, .. } => *own == direction,
            Scaling::Both { .. } => true,
        };
        let part = self.region[index(direction)].is_some();
        self.joins(direction).map(|join| part && (scaled || join.is_some()))
    }

    /// Refuses regions that are none, and those that would be torn off the rest.
    fn check_region(&self) -> Result<()> {
        for direction in [Direction::U, Direction::V] {
            let Some((a, b)) = self.region[index(direction)] else { continue };
            let (start, end) = self.surface.space(direction).domain();
            if !(a < b && start <= a && b <= end) {
                return Err(FineTuneError::Range { from: a, to: b, start, end, periodic: false });
            }
            let (ends, side) = (self.ends[index(direction)], self.ends[index(across(direction))]);
            let torn = match &self.scaling {
                Scaling::Directional { u, v } => {
                    let scaled = [u.is_some(), v.is_some()];
                    if scaled[index(across(direction))] {
                        return Err(FineTuneError::Contradiction(format!(
                            "a function of {} alone moves the sides of a part from {a} to {b} along {}: scale by an α(u, v), which \
                             can be 1 on them",
                            name(across(direction)),
                            name(direction)
                        )));
                    }
                    ends == Ends::Free
                }
                // Its sides stay by α = 1 there, which a similarity would undo.
                Scaling::Along { direction: own, .. } if *own != direction => {
                    if side != Ends::Exact && side != Ends::Free {
                        return Err(FineTuneError::Contradiction(format!(
                            "a similarity that keeps the ends along {} would move the sides of the part: use ends = \"exact\"",
                            name(*own)
                        )));
                    }
                    false
                }
                _ => ends == Ends::Free,
            };
            if torn {
                return Err(FineTuneError::Contradiction(
                    "a part with free ends would be torn off the rest: keep them (\"exact\", \"position\", \"tangent\", \
                     \"curvature\")"
                        .into(),
                ));
            }
        }
        Ok(())
    }
}

impl TunedSurface {
    /// The tuned surface: degree `p + a` along a direction of degree `p` that is scaled by α of degree `a`, and so `2p - 1` with
    /// the [usual α](crate::surface_alpha_spaces); across it `q + b` for α(u, v).
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// α as it is in the end; of a region, on the region.
    pub fn scaling(&self) -> &Scaling {
        &self.scaling
    }

    /// What was done.
    pub fn report(&self) -> &SurfaceReport {
        &self.report
    }

    /// The tuned surface itself.
    pub fn into_surface(self) -> Surface {
        self.surface
    }
}

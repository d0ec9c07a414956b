//! Interpolation in place of least squares: where there are as many unknowns as points.

use loftsman_kernel::Vector;
use loftsman_kernel::spline::{Curve, Space};

use crate::constraint::Holding;
use crate::error::{FitError, Result};
use crate::foot::correct;
use crate::interpolation::{Duplicates, Interpolation};
use crate::measure::{ACCEPTED, LIMIT};
use crate::parameters::Parametrization;
use crate::search::Search;
use crate::state::State;

/// Points nearer to the one before than this share of the tolerance may be left out: a curve that passes the one is
/// near enough to the other.
const NEAR: f64 = 0.1;
/// The degrees that are tried where the degree asked for swings between the points: curves of these, raised to the
/// degree, stay near the polygon of whatever points (see [`LIMIT`]).
const CALM: [usize; 2] = [3, 2];

/// How strongly vertices are straightened that the points leave open: the first that meets the tolerance.
const RELAXED: [f64; 6] = [1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13];

/// One way of interpolating.
#[derive(Debug, Clone, Copy)]
struct Way {
    degree: usize,
    centripetal: bool,
    /// Points as near as this to the one before are left out.
    least: f64,
}

impl Search<'_> {
    /// The curve through the points (but those within a tenth of the tolerance of the one before, where that helps):
    /// the first of the following that travels as the points do, else the shortest that does so within the bounds.
    /// * with the parameters to start from, and with centripetal ones;
    /// * the same of a lower degree, raised to the one asked for: smooth of second or first order only.
    ///
    /// What differs from what was asked for is in the state's remarks. `None` where no such curve will do.
    ///
    /// # Errors
    /// [`FitError::Cancelled`].
    pub(crate) fn through(&mut self) -> Result<Option<State>> {
        let p = self.fit.degree;
        let most = self.goal.tolerance.map_or(0.0, |t| NEAR * t);
        let mut best: Option<State> = None;
        let highest = if self.fit.closed { p } else { p.min(self.places() - 1).max(1) };
        let lower = CALM.into_iter().filter(|&d| d < highest);
        for degree in std::iter::once(highest).chain(lower) {
            for least in [0.0, most] {
                for centripetal in [false, true] {
                    if self.observer.cancelled() {
                        return Err(FitError::Cancelled);
                    }
                    // Where it cannot be (too few distinct points, an unlucky even degree) another way may do.
                    let Ok(Some(state)) = self.tried(Way { degree, centripetal, least }) else { continue };
                    let counts = if self.goal.exact {
                        state.space.len() == self.goal.vertices
                    } else {
                        !self.goal.limited || state.space.len() <= self.goal.vertices
                    };
                    if !counts || self.goal.tolerance.is_some_and(|t| state.error() > t) {
                        continue;
                    }
                    if self.follows(&state, &ACCEPTED)? {
                        return Ok(Some(state));
                    }
                    if self.follows(&state, &LIMIT)? && best.as_ref().is_none_or(|b| state.length < b.length)
                    {
                        best = Some(state);
                    }
                }
            }
        }
        Ok(best)
    }

    /// One way; `None` where it is no other than one before it.
    fn tried(&mut self, way: Way) -> Result<Option<State>> {
        let m = self.points.len();
        let given = matches!(self.fit.parameters, Parametrization::Given(_));
        if way.centripetal && (given || self.fit.parameters == Parametrization::Centripetal) {
            return Ok(None);
        }
        let sites = if way.centripetal { self.centripetal()? } else { self.start.to_vec() };
        let kept = self.apart(way.least);
        if way.least > 0.0 && kept.len() == m {
            return Ok(None);
        }
        let points: Vec<Vector> = kept.iter().map(|&k| self.points[k]).collect();
        let mut apart: Vec<f64> = kept.iter().map(|&k| sites[k]).collect();
        apart.extend(&sites[m..]);
        self.iterations += 1;
        let through = Interpolation {
            closed: self.fit.closed,
            duplicates: Duplicates::Merge,
            ..Interpolation::new(way.degree)
        }
        .local(self.frame, points, apart)?;
        let vertices = through.vertices.as_chunks::<3>().0.iter().map(|&v| v.into()).collect();
        let curve = Curve::new(through.space, vertices)?.elevate(self.fit.degree - way.degree)?;
        let mut state = State {
            space: curve.space().clone(),
            vertices: curve.points().iter().flat_map(|p| <[f64; 3]>::from(p.coords)).collect(),
            distances: self.distances(&curve, &sites)?,
            sites,
            condition: through.condition,
            held: Holding::default(),
            length: crate::measure::length(&curve)?,
            sound: true,
            met: true,
            interpolated: true,
            remarks: Vec::new(),
        };
        if kept.len() < m {
            state.distances = correct(&curve, self.points, &mut state.sites, self.fit.closed)?;
            state.remarks.push(format!(
                "{} points nearer than {:e} to the one before were left out of the interpolation",
                m - kept.len(),
                self.frame.leave_length(way.least)
            ));
        }
        if way.centripetal {
            state.remarks.push("centripetal parameters, since the curve swings with the others".into());
        }
        if way.degree < self.fit.degree && self.points.len() > self.fit.degree {
            state.remarks.push(format!(
                "a curve of degree {} through the points, raised to {}: one of full smoothness swings between them",
                way.degree, self.fit.degree
            ));
        }
        Ok(Some(state))
    }

    /// The curve near the points that constraints leave: with two spans between neighbouring points, more vertices than
    /// these determine, and those straightened (see [`LeastSquares::regularization`](crate::LeastSquares)) as strongly
    /// as the tolerance allows. That is in the state's remarks. `None` where no such curve meets the tolerance.
    ///
    /// # Errors
    /// As for [`Fit::curve`](crate::Fit::curve).
    pub(crate) fn relaxed(&mut self) -> Result<Option<State>> {
        let m = self.points.len();
        let given = matches!(self.fit.parameters, Parametrization::Given(_));
        let asked = self.regularization;
        for centripetal in [false, true] {
            if centripetal && (given || self.fit.parameters == Parametrization::Centripetal) {
                continue;
            }
            let sites = if centripetal { self.centripetal()? } else { self.start.to_vec() };
            let Some(space) = self.divided(&sites)? else { continue };
            for factor in RELAXED {
                if self.observer.cancelled() {
                    return Err(FitError::Cancelled);
                }
                self.regularization = asked.max(factor);
                let solved = self.solve(&space, &sites[..m], &[]);
                self.regularization = asked;
                let fit = match solved {
                    Err(FitError::NoData { .. } | FitError::IllConditioned { .. }) => continue,
                    other => other?,
                };
                let distances = self.request(&space, &sites[..m]).distances(&fit.vertices)?;
                let mut state = self.state(&space, fit, sites.clone(), distances)?;
                if !self.goal.holds(state.error()) || !self.follows(&state, &LIMIT)? {
                    continue;
                }
                (state.sound, state.met) = (true, true);
                state.remarks.push(format!(
                    "{} control vertices for {m} points, straightened (regularization {factor:e}): no smaller number met the tolerance under the constraints",
                    space.len()
                ));
                if centripetal {
                    state
                        .remarks
                        .push("centripetal parameters, since the curve swings with the others".into());
                }
                return Ok(Some(state));
            }
        }
        Ok(None)
    }

    /// A space with a knot at every site and between every two; `None` where there are too few.
    fn divided(&self, sites: &[f64]) -> Result<Option<Space>> {
        let mut breaks = vec![sites[0]];
        let least = 1e-9 * (sites[sites.len() - 1] - sites[0]);
        let end = sites[sites.len() - 1];
        for &u in sites {
            let before = breaks[breaks.len() - 1];
            // Points close together share their knots; the domain's end stays.
            if u - before > least && (end - u > least || u == end) {
                breaks.extend([0.5 * before + 0.5 * u, u]);
            }
        }
        if let Some(last) = breaks.last_mut() {
            *last = end;
        }
        let p = self.fit.degree;
        if breaks.len() < 3 || breaks.windows(2).any(|w| w[0] >= w[1]) {
            return Ok(None);
        }
        Ok(Some(if self.fit.closed { Space::periodic(p, breaks)? } else { Space::clamped(p, &breaks)? }))
    }

    fn distances(&self, curve: &Curve, sites: &[f64]) -> Result<Vec<f64>> {
        let pairs = sites.iter().zip(self.points);
        pairs.map(|(&u, q)| Ok((curve.derivative(u, 0)? - q).norm())).collect()
    }

    /// Centripetal parameters on the domain of those to start from.
    fn centripetal(&self) -> Result<Vec<f64>> {
        let (a, b) = (self.start[0], self.start[self.start.len() - 1]);
        let mut sites = Parametrization::Centripetal.of_local(self.points, self.fit.closed)?;
        sites.iter_mut().for_each(|u| *u = a + *u * (b - a));
        if let Some(last) = sites.last_mut() {
            *last = b;
        }
        Ok(sites)
    }

    /// The points without those within `least` of the one before; the first, and the last of an open chain, stay.
    fn apart(&self, least: f64) -> Vec<usize> {
        let m = self.points.len();
        let far = |a: usize, b: usize| least == 0.0 || (self.points[a] - self.points[b]).norm() > least;
        let mut kept = vec![0];
        for k in 1..m {
            if far(kept[kept.len() - 1], k) {
                kept.push(k);
            }
        }
        let last = kept[kept.len() - 1];
        if self.fit.closed {
            while kept.len() > 1 && !far(kept[0], kept[kept.len() - 1]) {
                kept.pop();
            }
        } else if last != m - 1 {
            if kept.len() > 1 {
                kept.pop();
            }
            kept.push(m - 1);
        }
        kept
    }
}

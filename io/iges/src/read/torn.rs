//! Boundaries whose model curves are torn or missing while their parameter curves close, and parameter curves that run askew over angles.
//!
//! A spline goes round at another speed than the angle that files count by, so that a parameter curve which changes both parameters at once is no spline in
//! those of the surface. Where model curves serve they are taken; where they do not it is fitted.

use std::f64::consts::TAU;

use loftsman_kernel::spline::pieces::{self, Interpolation, Limits, Net};
use loftsman_kernel::spline::trimmed::{ParameterCurve, Region};
use loftsman_kernel::spline::{Curve, Space, Surface, Trimmed};
use loftsman_kernel::{Point, Result};

use super::curve::Run;
use super::entity::{At, Got, Reader};
use super::pace::Pace;
use super::surface::Whole;
use super::trim::{Boundary, laid};

/// How often a part between knots is halved at most, and pieces at most.
const LIMITS: Limits = Limits { depth: 10, pieces: 400 };
/// In so many parts of each knot span it is looked where a curve crosses knot lines of the surface, and halvings until a place is on one.
const STEPS: usize = 16;
const STEPS_TO_LINE: usize = 48;
/// The shortest part of a curve between two of them.
const LEAST: f64 = 1e-9;
/// How far a fitted curve may be off, as a part of the size of the surface.
const BOUND: f64 = 1e-9;

impl Reader<'_, '_> {
    /// The widest gap between model curves that follow one another, where that is more than what neighbours may be apart in a boundary.
    pub(crate) fn torn(&self, runs: &[Run], place: usize) -> Got<Option<f64>> {
        let ends = |run: &Run| -> Result<[Point; 2]> {
            let (a, b) = run.curve.domain();
            Ok([run.curve.point(a)?, run.curve.point(b)?])
        };
        let all: Vec<[Point; 2]> = runs.iter().map(ends).collect::<Result<_>>().at(place)?;
        let size = size(runs.iter().flat_map(|run| run.curve.points()));
        let widest = widest(&all);
        Ok((widest > self.near(100.0 * size)).then_some(widest))
    }

    /// The surface within its parameter curves where these close but model curves are torn or missing; `None` where model curves serve, or parameter curves do not.
    ///
    /// Told are the tear and how far parameter curves are from the model curves, or where these are missing from the file's where they had to be fitted: measured at
    /// places of each. `O(curves²)` of each boundary.
    pub(crate) fn without_model(
        &self,
        whole: &Whole,
        (outer, inner): (&[Boundary], &[Boundary]),
        place: usize,
    ) -> Got<Option<Trimmed>> {
        let (mut tear, mut missing) = (None, false);
        for boundary in outer.iter().chain(inner) {
            if boundary.parameters.is_empty() {
                return Ok(None);
            }
            missing |= boundary.model.is_empty();
            let found = self.torn(&boundary.model, boundary.place)?;
            tear = found.into_iter().chain(tear).reduce(f64::max);
        }
        if tear.is_none() && !missing {
            return Ok(None);
        }
        let bound = BOUND * size(whole.surface.points().iter());
        let (mut loops, mut fit, mut off) = (Vec::new(), 0.0_f64, 0.0_f64);
        for boundary in outer.iter().chain(inner) {
            let mut curves = Vec::new();
            for run in &boundary.parameters {
                let curve = match laid(&run.curve, whole).at(boundary.place)? {
                    Some(curve) => curve,
                    None => match Askew::new(&run.curve, whole, bound) {
                        None => return Ok(None),
                        Some(askew) => match askew.fitted().at(boundary.place)? {
                            None => return Ok(None),
                            Some((curve, away)) => {
                                fit = fit.max(away);
                                curve
                            }
                        },
                    },
                };
                curves.push(ParameterCurve::whole(curve).at(boundary.place)?);
            }
            if !self.closes(&whole.surface, &curves).at(boundary.place)? {
                return Ok(None);
            }
            off = off.max(self.off_model(&whole.surface, &curves, boundary)?.0);
            loops.push(curves);
        }
        let holes = loops.split_off(outer.len());
        let region = Region { outer: loops.pop().unwrap_or_default(), holes };
        let Ok(trimmed) = Trimmed::new(whole.surface.clone(), vec![region], vec![], vec![]) else {
            return Ok(None);
        };
        let text = match tear {
            Some(gap) => format!(
                "its boundary is torn in space, by {}, but closes in the parameters of the surface, up to {} away: there it is taken",
                self.told(gap),
                self.told(off)
            ),
            // Curves in space that other boundaries have may say something else.
            None => format!(
                "a boundary is there in the parameters of the surface only, from which all are taken: fitted within {}, up to {} off curves in space",
                self.told(fit),
                self.told(off)
            ),
        };
        self.change(place, &text);
        Ok(Some(trimmed))
    }

    /// Whether parameter curves are a closed boundary on the surface.
    fn closes(&self, surface: &Surface, curves: &[ParameterCurve]) -> Result<bool> {
        let inside = |space: &Space, t: f64| t.clamp(space.domain().0, space.domain().1);
        let on = |at: [f64; 2]| surface.point(inside(surface.u(), at[0]), inside(surface.v(), at[1]));
        let mut all = Vec::with_capacity(curves.len());
        for curve in curves {
            let [a, b] = curve.ends()?;
            all.push([on(a)?, on(b)?]);
        }
        Ok(widest(&all) <= self.near(size(all.iter().flatten())))
    }
}

/// The widest gap between ends and the starts behind them, all around.
fn widest(ends: &[[Point; 2]]) -> f64 {
    let next = ends.iter().cycle().skip(1);
    ends.iter().zip(next).map(|(a, b)| nalgebra::distance(&a[1], &b[0])).fold(0.0, f64::max)
}

fn size<'p>(points: impl Iterator<Item = &'p Point>) -> f64 {
    let mut first = None;
    points.map(|p| (p - *first.get_or_insert(*p)).amax()).fold(0.0, f64::max)
}

/// A parameter curve of a file as one of the spline, from place to place.
struct Askew<'c> {
    curve: &'c Curve,
    whole: &'c Whole,
    /// By how many turns the file counts on.
    shift: [f64; 2],
    /// How far a fitted curve may be off in space.
    bound: f64,
}

impl<'c> Askew<'c> {
    /// `None` where the curve leaves the surface.
    fn new(curve: &'c Curve, whole: &'c Whole, bound: f64) -> Option<Self> {
        let mut askew = Self { curve, whole, shift: [0.0; 2], bound };
        let (from, to) = curve.domain();
        let ends = [askew.counted(from).ok()?, askew.counted(to).ok()?];
        for d in 0..2 {
            let pace = &whole.paces[d];
            let fits = |shift: &f64| ends.iter().all(|end| pace.at(end[d] + shift).is_some());
            askew.shift[d] = [0.0, TAU, -TAU].into_iter().find(fits)?;
        }
        Some(askew)
    }

    /// What the file counts along `u` and `v` of the spline.
    fn counted(&self, t: f64) -> Result<[f64; 2]> {
        let p = self.curve.point(t)?;
        let own = if self.whole.swapped { [p.y, p.x] } else { [p.x, p.y] };
        Ok([own[0] + self.shift[0], own[1] + self.shift[1]])
    }

    /// The same in the parameters of the spline.
    fn at(&self, t: f64) -> Result<Option<[f64; 2]>> {
        let [u, v] = self.counted(t)?;
        Ok(self.whole.paces[0].at(u).zip(self.whole.paces[1].at(v)).map(<[f64; 2]>::from))
    }

    /// Where parts end within which curve and spline are smooth.
    fn smooth_parts(&self) -> Result<Vec<f64>> {
        let breaks = self.curve.space().breakpoints();
        let joints = self.whole.paces.each_ref().map(Pace::joints);
        let mut all = breaks.clone();
        for span in breaks.windows(2) {
            let step = |k: usize| span[0] + (span[1] - span[0]) * (k as f64 / STEPS as f64);
            for k in 0..STEPS {
                let (a, b) = (step(k), if k + 1 == STEPS { span[1] } else { step(k + 1) });
                let (p, q) = (self.counted(a)?, self.counted(b)?);
                for d in 0..2 {
                    for line in joints[d].iter().filter(|line| (p[d] < **line) != (q[d] < **line)) {
                        let (mut low, mut high) = (a, b);
                        for _ in 0..STEPS_TO_LINE {
                            let middle = 0.5 * (low + high);
                            let before = (self.counted(middle)?[d] < *line) == (p[d] < *line);
                            (low, high) = if before { (middle, high) } else { (low, middle) };
                        }
                        all.push(0.5 * (low + high));
                    }
                }
            }
        }
        let (from, to) = self.curve.domain();
        Ok(pieces::apart(all, LEAST * (to - from)))
    }

    /// Pieces through places of the curve, halved until each is near enough, and how far they are off at most in space, measured between those places; `None`
    /// where they do not come near enough, or the curve leaves the surface.
    fn fitted(&self) -> Result<Option<(Curve, f64)>> {
        let parts = self.smooth_parts()?;
        let mut off = 0.0_f64;
        let curve = Interpolation::new().curve(&parts, LIMITS, |by, a, b| {
            let Some((net, away)) = self.piece(by, (a, b))? else { return Ok(None) };
            let good = away <= self.bound;
            if good {
                off = off.max(away);
            }
            Ok(Some((net, good)))
        })?;
        Ok(curve.map(|curve| (curve, off)))
    }

    /// The Bézier points between two places, and how far they are off in space.
    fn piece(&self, by: &Interpolation, (a, b): (f64, f64)) -> Result<Option<(Net, f64)>> {
        let place = |x: f64| if x == 1.0 { b } else { a + (b - a) * x };
        let mut places = Net::default();
        for (to, x) in places.iter_mut().zip(by.nodes()) {
            let Some(at) = self.at(place(x))? else { return Ok(None) };
            *to = at;
        }
        let net = by.through(&places)?;
        let surface = &self.whole.surface;
        let inside = |space: &Space, t: f64| t.clamp(space.domain().0, space.domain().1);
        let on = |at: [f64; 2]| surface.point(inside(surface.u(), at[0]), inside(surface.v(), at[1]));
        let mut away = 0.0_f64;
        // Between the nodes, where it is worst.
        for x in by.between() {
            let Some(at) = self.at(place(x))? else { return Ok(None) };
            away = away.max(nalgebra::distance(&on(pieces::at(&net, x))?, &on(at)?));
        }
        Ok(Some((net, away)))
    }
}

//! Where the border of a part is nearest to a point.

use super::tree::{Bounds, Search, Tree};
use crate::Point;
use crate::error::Result;
use crate::spline::trimmed::ParameterCurve;
use crate::spline::{ParameterSide, Surface};

/// Places of each span of a loop's curve at which the nearest one is looked for.
const LOOKS: usize = 16;

/// The places of a border at which the nearest one is looked for, by where they are in space.
pub(super) struct Border {
    looks: Vec<Look>,
    tree: Tree<3>,
}

struct Look {
    curve: usize,
    parameter: f64,
    /// By how much parameters differ from one look to the next.
    step: f64,
    at: (f64, f64),
    point: Point,
    /// Whether there are looks of the same curve before and behind.
    beside: [bool; 2],
}

/// A place of the border, and how far it is from a point.
pub(super) type Near = ((f64, f64), f64);

impl Border {
    /// One evaluation of the surface a look, 16 of each span.
    ///
    /// # Errors
    /// When an evaluation overflows.
    pub(super) fn new(
        surface: &Surface,
        sides: &[ParameterSide; 2],
        curves: &[ParameterCurve],
    ) -> Result<Self> {
        let mut looks = Vec::new();
        for (number, curve) in curves.iter().enumerate() {
            let (from, to) = curve.range();
            let count = LOOKS * (curve.curve().space().breakpoints().len() - 1);
            let step = (to - from) / count as f64;
            for k in 0..=count {
                let parameter = if k == count { to } else { from + step * k as f64 };
                let (at, point) = on(surface, sides, curve, parameter)?;
                looks.push(Look { curve: number, parameter, step, at, point, beside: [k > 0, k < count] });
            }
        }
        // As far around each as it is to those beside it: between them the border is no nearer than that, or so.
        let boxes: Vec<Bounds<3>> = (0..looks.len())
            .map(|k| {
                let reach = beside(&looks, k).map(|other| (looks[other].point - looks[k].point).norm());
                let reach = reach[0].max(reach[1]);
                [0, 1, 2].map(|d: usize| [looks[k].point[d] - reach, looks[k].point[d] + reach])
            })
            .collect();
        Ok(Self { tree: Tree::new(&boxes), looks })
    }

    /// The parameters where the border is nearest to a point, and how near: downhill from each look that is nearer than those beside it. `None` where there
    /// is no border.
    ///
    /// # Errors
    /// When an evaluation overflows.
    pub(super) fn nearest(
        &self,
        surface: &Surface,
        sides: &[ParameterSide; 2],
        curves: &[ParameterCurve],
        point: Point,
    ) -> Result<Option<Near>> {
        let mut walk = Walk {
            border: self,
            surface,
            sides,
            curves,
            point,
            least: f64::INFINITY,
            best: None,
            failed: None,
        };
        self.tree.search(&mut walk);
        match walk.failed {
            Some(error) => Err(error),
            None => Ok(walk.best.map(|(_, near)| near)),
        }
    }
}

/// The looks before and behind one; itself at an end of a curve.
fn beside(looks: &[Look], k: usize) -> [usize; 2] {
    let [before, behind] = looks[k].beside;
    [k - usize::from(before), k + usize::from(behind)]
}

/// The place of the surface along a curve in its plane. Loops run on where a surface closes; elsewhere they are outside by rounding alone.
pub(super) fn on(
    surface: &Surface,
    sides: &[ParameterSide; 2],
    curve: &ParameterCurve,
    t: f64,
) -> Result<((f64, f64), Point)> {
    let c = curve.curve().point(t)?;
    let at = (sides[0].wrapped(c.x), sides[1].wrapped(c.y));
    Ok((at, surface.point(at.0, at.1)?))
}

/// A point on its way along the border.
struct Walk<'a> {
    border: &'a Border,
    surface: &'a Surface,
    sides: &'a [ParameterSide; 2],
    curves: &'a [ParameterCurve],
    point: Point,
    /// The distance of the nearest look so far: in the end nothing is farther.
    least: f64,
    best: Option<(usize, Near)>,
    failed: Option<crate::Error>,
}

impl Search<3> for Walk<'_> {
    fn bound(&self, bounds: &Bounds<3>) -> f64 {
        let away = |d: usize| (bounds[d][0] - self.point[d]).max(self.point[d] - bounds[d][1]).max(0.0);
        let size = (0..3).fold(0.0_f64, |most, d| {
            most.max(bounds[d][0].abs()).max(bounds[d][1].abs()).max(self.point[d].abs())
        });
        away(0).hypot(away(1)).hypot(away(2)) - 16.0 * f64::EPSILON * size
    }

    fn beyond(&self, bound: f64) -> bool {
        let best = self.best.map_or(f64::INFINITY, |(_, (_, best))| best);
        self.failed.is_some() || bound > best.min(self.least)
    }

    fn look(&mut self, k: usize) {
        if self.failed.is_some() {
            return;
        }
        let looks = &self.border.looks;
        let distance = |k: usize| (looks[k].point - self.point).norm();
        let own = distance(k);
        self.least = self.least.min(own);
        let beside = beside(looks, k).map(distance);
        // Between two looks it comes no nearer than by what it does from one to the next, or so.
        let gain = beside.map(|other| (other - own).abs()).into_iter().fold(0.0, f64::max);
        if beside.iter().any(|other| *other < own)
            || self.best.is_some_and(|(_, (_, best))| own - gain > best)
        {
            return;
        }
        match self.downhill(&looks[k], own) {
            Ok(near) => {
                // Of places that are as near the first one counts.
                if self.best.is_none_or(|(rank, (_, best))| near.1 < best || (near.1 == best && k < rank)) {
                    self.best = Some((k, near));
                }
            }
            Err(error) => self.failed = Some(error),
        }
    }
}

impl Walk<'_> {
    fn downhill(&self, look: &Look, distance: f64) -> Result<Near> {
        let curve = &self.curves[look.curve];
        let (from, to) = curve.range();
        let mut found = (look.parameter, (look.at, distance));
        let mut reach = look.step;
        while reach > 1e-12 * (to - from) {
            let before = found.1.1;
            for t in [found.0 - reach, found.0 + reach].map(|t| t.clamp(from, to)) {
                let (at, on) = on(self.surface, self.sides, curve, t)?;
                let next = (on - self.point).norm();
                if next < found.1.1 {
                    found = (t, (at, next));
                }
            }
            if found.1.1 >= before {
                reach *= 0.5;
            }
        }
        Ok(found.1)
    }
}

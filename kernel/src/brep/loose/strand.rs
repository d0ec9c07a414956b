//! An edge as a face has it: a curve in the parameters of its surface.

use crate::error::{MAX_DEGREE, Result};
use crate::shape::{Location, Shape};
use crate::spline::trimmed::ParameterCurve;
use crate::spline::{Space, Surface};
use crate::{Point, Vector};

/// So many pieces a first look cuts a curve into, beside its own spans.
const PIECES: usize = 64;
/// How far from its share of the whole curve a point is looked for.
const WINDOW: f64 = 0.3;
/// Steps of a search on it.
const STEPS: usize = 30;

/// A curve on a surface, and what is known of it for searching.
#[derive(Debug)]
pub(super) struct Strand<'a> {
    pub(super) surface: &'a Surface,
    pub(super) curve: &'a ParameterCurve,
    /// Parameters of the curve, ascending, and the points there.
    looks: Vec<(f64, Point)>,
}

impl<'a> Strand<'a> {
    pub(super) fn new(surface: &'a Surface, curve: &'a ParameterCurve) -> Result<Self> {
        let (from, to) = curve.range();
        let inner = curve.curve().space().breakpoints();
        let mut knots = vec![from];
        knots.extend(inner.into_iter().filter(|t| *t > from && *t < to));
        knots.push(to);
        let each = PIECES.div_ceil(knots.len() - 1).max(4);
        let mut looks = Vec::with_capacity(each * knots.len());
        for pair in knots.windows(2) {
            for k in 0..each {
                let t = pair[0] + (pair[1] - pair[0]) * (k as f64 / each as f64);
                looks.push((t, point(surface, curve, t)?));
            }
        }
        looks.push((to, point(surface, curve, to)?));
        Ok(Self { surface, curve, looks })
    }

    /// The surface's parameters at one of the curve's.
    pub(super) fn parameters(&self, t: f64) -> Result<[f64; 2]> {
        let at = self.curve.curve().point(t)?;
        Ok([at.x, at.y])
    }

    pub(super) fn point(&self, t: f64) -> Result<Point> {
        point(self.surface, self.curve, t)
    }

    /// The unit vector along `S_u × S_v`; `None` where that vanishes.
    pub(super) fn normal(&self, t: f64) -> Result<Option<Vector>> {
        let [u, v] = self.parameters(t)?;
        super::normal(self.surface, inside(self.surface, u, v))
    }

    /// The parameter at a share of the whole.
    pub(super) fn at_share(&self, share: f64) -> f64 {
        let (from, to) = self.curve.range();
        if share >= 1.0 { to } else { from + (to - from) * share }
    }

    /// The share of the whole at a parameter.
    pub(super) fn share(&self, t: f64) -> f64 {
        let (from, to) = self.curve.range();
        (t - from) / (to - from)
    }

    /// The derivative of the point by the curve's parameter.
    pub(super) fn slope(&self, t: f64) -> Result<Vector> {
        Ok(self.with_derivative(t)?.1)
    }

    /// How often the surface along the curve can be differentiated at least, by what is repeated among knots.
    pub(super) fn smoothness(&self) -> usize {
        let spaces = [self.surface.u(), self.surface.v(), self.curve.curve().space()];
        let of = |space: &Space| match space.most_repeated() {
            0 => MAX_DEGREE,
            times => space.degree().saturating_sub(times),
        };
        spaces.into_iter().map(of).min().unwrap_or(0)
    }

    /// How far it reaches.
    pub(super) fn size(&self) -> f64 {
        self.looks.iter().map(|(_, p)| (p - self.looks[0].1).norm()).fold(0.0, f64::max)
    }

    /// Where the curve passes nearest to a point, and how far from it.
    pub(super) fn closest(&self, to: Point) -> Result<(f64, f64)> {
        let (start, end) = self.curve.range();
        let away = |p: &Point| (p - to).norm();
        let look = self.looks.iter().min_by(|a, b| away(&a.1).total_cmp(&away(&b.1)));
        let Some(&(t, looked)) = look else { return Ok((start, f64::INFINITY)) };
        let found = self.nearest(to, (t - start) / (end - start))?;
        let distance = away(&self.point(found)?);
        let beside = [start, end].map(|end| (end, self.point(end)));
        let mut best = if distance <= away(&looked) { (found, distance) } else { (t, away(&looked)) };
        for (t, end) in beside {
            let distance = away(&end?);
            if distance < best.1 {
                best = (t, distance);
            }
        }
        Ok(best)
    }

    /// Where the curve passes nearest to a point, near this share of it. The ends are the ends.
    pub(super) fn nearest(&self, to: Point, share: f64) -> Result<f64> {
        if share <= 0.0 || share >= 1.0 {
            return Ok(self.at_share(share));
        }
        let (start, end) = self.curve.range();
        let inside = |t: f64| ((t - start) / (end - start) - share).abs() <= WINDOW;
        let looked = self.looks.iter().filter(|(t, _)| inside(*t));
        let away = |p: &Point| (p - to).norm_squared();
        let best = looked.min_by(|a, b| away(&a.1).total_cmp(&away(&b.1))).map(|(t, _)| *t);
        // Where the curve is run through at the same pace, that is it to rounding.
        let same = self.at_share(share);
        let mut t = match best {
            Some(best) if away(&self.point(best)?) < away(&self.point(same)?) => best,
            _ => same,
        };
        let mut distance = away(&self.point(t)?);
        for _ in 0..STEPS {
            let (point, d) = self.with_derivative(t)?;
            let squared = d.norm_squared();
            if squared == 0.0 {
                break;
            }
            let mut step = d.dot(&(to - point)) / squared;
            let mut moved = false;
            for _ in 0..8 {
                let next = (t + step).clamp(start, end);
                let nearer = away(&self.point(next)?);
                if nearer < distance {
                    moved = next != t;
                    (t, distance) = (next, nearer);
                    break;
                }
                step *= 0.5;
            }
            if !moved || step.abs() <= 1e-15 * (end - start) {
                break;
            }
        }
        Ok(t)
    }

    fn with_derivative(&self, t: f64) -> Result<(Point, Vector)> {
        let at = self.curve.curve().point(t)?;
        let by = self.curve.curve().derivative(t, 1)?;
        let mut d = [Vector::zeros(); 4];
        let (u, v) = inside(self.surface, at.x, at.y);
        self.surface.derivatives_into(u, v, [1, 1], &mut d)?;
        Ok((Point::from(d[0]), d[2] * by.x + d[1] * by.y))
    }

    /// The degree of the surface along the curve, between knots, where it is a polynomial.
    pub(super) fn degree(&self) -> Option<usize> {
        let rational = self.surface.weights().is_some() || self.curve.curve().weights().is_some();
        let degree = self.curve.curve().degree() * (self.surface.u().degree() + self.surface.v().degree());
        (!rational).then_some(degree)
    }

    /// The parameters of the curve where it crosses knot lines of the surface, or has knots itself: between them it is smooth.
    /// Ascending, its ends among them.
    pub(super) fn breaks(&self) -> Result<Vec<f64>> {
        let (from, to) = self.curve.range();
        let mut all = vec![from, to];
        all.extend(self.curve.curve().space().breakpoints().into_iter().filter(|t| *t > from && *t < to));
        let lines = |space: &Space| -> Vec<f64> {
            let points = space.breakpoints();
            if space.is_periodic() { points } else { points[1..points.len() - 1].to_vec() }
        };
        let sides = [lines(self.surface.u()), lines(self.surface.v())];
        let spaces = [self.surface.u(), self.surface.v()];
        for pair in self.looks.windows(2) {
            let (a, b) = (self.parameters(pair[0].0)?, self.parameters(pair[1].0)?);
            for k in 0..2 {
                let turn = if spaces[k].is_periodic() {
                    let (start, length) = (spaces[k].domain().0, spaces[k].length());
                    ((a[k].min(b[k]) - start) / length).floor() * length
                } else {
                    0.0
                };
                let (low, high) = (a[k].min(b[k]) - turn, a[k].max(b[k]) - turn);
                let first = sides[k].partition_point(|&x| x <= low);
                for &line in sides[k][first..].iter().take_while(|&&x| x < high) {
                    all.push(self.crossing(pair[0].0, pair[1].0, k, line + turn)?);
                }
            }
        }
        all.sort_by(f64::total_cmp);
        let least = 1e-9 * (to - from);
        let mut kept: Vec<f64> = vec![from];
        for t in all {
            if t - kept[kept.len() - 1] > least && to - t > least {
                kept.push(t);
            }
        }
        kept.push(to);
        Ok(kept)
    }

    /// Where one of the curve's coordinates has a value between two parameters at which it is on both sides of it.
    fn crossing(&self, mut low: f64, mut high: f64, axis: usize, value: f64) -> Result<f64> {
        let rises = self.parameters(low)?[axis] < value;
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if (self.parameters(middle)?[axis] < value) == rises {
                low = middle;
            } else {
                high = middle;
            }
        }
        Ok(0.5 * (low + high))
    }
}

/// Parameters brought into the domain where rounding has left them beside it.
pub(super) fn inside(surface: &Surface, u: f64, v: f64) -> (f64, f64) {
    let into = |space: &Space, t: f64| {
        let (a, b) = space.domain();
        if space.is_periodic() { t } else { t.clamp(a, b) }
    };
    (into(surface.u(), u), into(surface.v(), v))
}

fn point(surface: &Surface, curve: &ParameterCurve, t: f64) -> Result<Point> {
    let at = curve.curve().point(t)?;
    let (u, v) = inside(surface, at.x, at.y);
    surface.point(u, v)
}

/// The location on a face, inside its surface's domain.
pub(super) fn location(surface: &Surface, face: usize, [u, v]: [f64; 2]) -> Location {
    let (u, v) = inside(surface, u, v);
    Location::Face(face as u32, u, v)
}

/// Places of a spline's own at which interpolation by it has one answer: one for each of its functions.
pub(super) fn own_places(space: &Space) -> Vec<f64> {
    (0..space.len()).map(|k| space.greville(k)).collect()
}

/// The row of a curve's point over its own control vertices.
pub(super) fn row(curve: &dyn Shape, t: f64) -> Result<crate::shape::Stencil> {
    curve.stencil(Location::Curve(t), crate::shape::Derivative::POSITION)
}

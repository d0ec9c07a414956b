//! What is only followed: a constraint that asks for as many numbers as its place has parameters holds by nothing, as long as the shape does it somewhere near.
//!
//! `g(q, s) = 0` gives `s` as long as `|∂g/∂s|` (of two of them their determinant) is not zero. Where it becomes that, two such places meet and vanish, and the place
//! would run away ever faster.

use loftsman_kernel::functional::Shapes;
use loftsman_kernel::shape::{Derivative, Location};
use smallvec::SmallVec;

use super::Link;
use crate::error::Result;

/// Places a parameter at which the shape is looked at.
const LOOKS: usize = 32;
/// Below this share of what it changes by where that is steepest a place is hardly told any more.
const VANISHES: f64 = 1e-3;
/// And below this where steps do not arrive.
const NEARLY: f64 = 0.3;

impl Link {
    /// Whether it asks for as many numbers as its one place has parameters, which do not stop at corners.
    fn is_followed(&self) -> bool {
        let numbers =
            |count: usize| if count == 3 { self.axes.iter().filter(|axis| **axis).count() } else { count };
        let equations: usize = self.parts.iter().map(|part| numbers(part.value.len())).sum();
        self.places.len() == 1
            && (1..=2).contains(&equations)
            && equations == self.slides.len()
            && !self.has_corners()
    }

    /// `∂g/∂s` where its place is now, by lengths along the shape: of two numbers the determinant. None of what is more than followed.
    fn steepness(&self, shapes: &Shapes<'_>) -> Result<Option<f64>> {
        if !self.is_followed() {
            return Ok(None);
        }
        let mut columns: SmallVec<[SmallVec<[f64; 2]>; 2]> = SmallVec::new();
        for (own, slide) in self.slides.iter().enumerate() {
            let order = if own == 0 { Derivative { u: 1, v: 0 } } else { Derivative { u: 0, v: 1 } };
            let mut column: SmallVec<[f64; 2]> = SmallVec::new();
            for part in &self.parts {
                let count = part.value.len();
                let mut along: SmallVec<[f64; 6]> = SmallVec::from_elem(0.0, count);
                for term in part.terms.iter().filter(|term| term.place.is_some()) {
                    let mut all: SmallVec<[f64; 6]> = SmallVec::from_elem(0.0, count);
                    term.functional.along(shapes, order, &mut all)?;
                    along.iter_mut().zip(&all).for_each(|(sum, a)| *sum += term.sign * a);
                }
                let asked = |k: &usize| count != 3 || self.axes[*k];
                column.extend((0..count).filter(asked).map(|k| along[k] * slide.pace));
            }
            columns.push(column);
        }
        Ok(match &columns[..] {
            [a] => a.first().copied(),
            [a, b] => a.iter().zip(b.iter().rev()).map(|(a, b)| a * b).reduce(|first, second| first - second),
            _ => None,
        })
    }

    /// How much what it asks for changes along the shape where that is steepest; none of what is more than followed.
    pub(super) fn steepest(&mut self, shapes: &Shapes<'_>) -> Result<Option<f64>> {
        if self.steepness(shapes)?.is_none() {
            return Ok(None);
        }
        let kept: SmallVec<[Location; 2]> = self.locations().collect();
        let at = |own: usize, k: usize| {
            let side = self.slides[own].interval;
            side.start + (side.end - side.start) * (k as f64 + 0.5) / LOOKS as f64
        };
        let places: Vec<Location> = match kept.first() {
            Some(Location::Curve(_)) => (0..LOOKS).map(|k| Location::Curve(at(0, k))).collect(),
            Some(Location::Surface(..)) => {
                let pairs = (0..LOOKS).step_by(4).flat_map(|j| (0..LOOKS).step_by(4).map(move |k| (j, k)));
                pairs.map(|(j, k)| Location::Surface(at(0, j), at(1, k))).collect()
            }
            _ => return Ok(None),
        };
        let mut most = 0.0_f64;
        for place in places {
            self.put(&[place]);
            let found = self.steepness(shapes);
            most = most.max(found?.map_or(0.0, f64::abs));
        }
        self.put(&kept);
        Ok(Some(most).filter(|most| *most > 0.0))
    }

    /// Whether its place is about to vanish: what it asks for hardly changes along the shape any more, or the other way than just before.
    pub(crate) fn vanishes(&mut self, shapes: &Shapes<'_>) -> Result<bool> {
        let (Some(most), Some(now)) = (self.steep, self.steepness(shapes)?) else { return Ok(false) };
        let before = std::mem::replace(&mut self.last_steep, now);
        Ok(now.abs() < VANISHES * most || now * before < 0.0)
    }

    /// It may have been put elsewhere, from where it goes on as if it came.
    pub(crate) fn forget_where(&mut self) {
        self.last_steep = 0.0;
    }

    /// Whether that may be why a step did not arrive.
    pub(crate) fn is_vanishing(&self, shapes: &Shapes<'_>) -> Result<bool> {
        Ok(self.steep.zip(self.steepness(shapes)?).is_some_and(|(most, now)| now.abs() < NEARLY * most))
    }
}

//! What is told of a problem that was solved: constraints, convergence, what stayed smooth.

use std::fmt;
use std::sync::Arc;

use super::name::Name;
use crate::functional::Functional;
use crate::shape::Location;
use crate::text::figure;
use crate::unit::Unit;

/// How a nonlinear problem converged.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Convergence {
    /// Quadratic programs (or linear systems) that were solved.
    pub iterations: usize,
    /// Steps among them that had to be shortened, because the whole step did not bring the shape nearer.
    pub shortened: usize,
    /// The last change of the adjustment, relative to the adjustment.
    pub change: f64,
}

/// What became of one constraint.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct ConstraintReport {
    /// Its name: `position at 0.25`.
    pub name: Name,
    /// Largest error of its equations after the step: of an edit's position, and of what else is a vector, the distance from where it should be.
    pub residual: f64,
    /// The power of length that this error has ([`Functional::dimension`]): 2 for an area. `None` where that is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dimension: Option<u8>,
    /// Where it came to rest, if its location floated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub location: Option<Vec<f64>>,
    /// The same between the places where it was imposed, for a condition that is meant along an edge.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub between: Option<f64>,
    /// Lagrange multipliers, one an equation: how much `½ dᵀWd` would change with its value.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub multipliers: Vec<f64>,
}

impl ConstraintReport {
    /// Its error with the unit that it has where lengths are in `unit`: `0.5 m`, `0.02 m²`; a plain number where its dimension is not known.
    pub fn error_in(&self, unit: Unit) -> String {
        match self.dimension {
            Some(power @ 1..=3) => unit.quantity(self.residual, usize::from(power)),
            _ => figure(self.residual),
        }
    }

    /// The functional where its location came to rest, if that floated.
    pub fn rested(&self, functional: &Arc<dyn Functional>) -> Option<Arc<dyn Functional>> {
        let to = match self.location.as_deref()? {
            [u] => Location::Curve(*u),
            [u, v] => Location::Surface(*u, *v),
            _ => return None,
        };
        functional.moved(to)
    }
}

/// How many corners are told one by one.
const TOLD: usize = 3;

/// What became of the knots at which a shape can have corners.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct Smoothness {
    /// Knots (of surfaces: knot lines) at which the shape was smooth, or closed, and was kept so; seams count as knots.
    pub knots: usize,
    /// What else was kept together: edges of a solid between faces that move.
    #[serde(skip_serializing_if = "is_zero")]
    pub bonds: usize,
    /// Scalar equations that this took, beside those of what was asked.
    pub equations: usize,
    /// Those of them that the others imply: they were dropped, and hold.
    #[serde(skip_serializing_if = "is_zero")]
    pub redundant: usize,
    /// Corners that have appeared, or are not what they were.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub corners: Vec<Corner>,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde hands over a reference")]
fn is_zero(count: &usize) -> bool {
    *count == 0
}

impl Smoothness {
    /// Whether there is nothing to say.
    pub fn is_empty(&self) -> bool {
        self.knots == 0 && self.bonds == 0 && self.corners.is_empty()
    }

    /// The corners for people: those that have changed most, and how many more there are.
    pub fn notes(&self) -> Vec<String> {
        let mut worst: Vec<_> = self.corners.iter().collect();
        worst.sort_by(|a, b| b.change().total_cmp(&a.change()));
        let mut notes: Vec<String> = worst.iter().take(TOLD).map(ToString::to_string).collect();
        if worst.len() > TOLD {
            notes.push(format!("and {} more corners", worst.len() - TOLD));
        }
        notes
    }
}

impl fmt::Display for Smoothness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counted = |count: usize, one: &str| format!("{count} {one}{}", if count == 1 { "" } else { "s" });
        let (knots, edges) = (counted(self.knots, "knot"), counted(self.bonds, "edge"));
        match (self.knots, self.bonds) {
            (_, 0) => write!(f, "kept smooth at {knots}")?,
            (0, _) => write!(f, "kept together at {edges}")?,
            _ => write!(f, "kept smooth at {knots} and together at {edges}")?,
        }
        let equations = counted(self.equations, "equation");
        match (self.redundant, self.equations) {
            (0, _) => write!(f, " ({equations})"),
            (1, 1) => write!(f, " (1 equation, which follows from the others)"),
            (redundant, all) if redundant == all => {
                write!(f, " ({equations}, all of which follow from the others)")
            }
            (1, _) => write!(f, " ({equations}, 1 of which follows from the others)"),
            (redundant, _) => write!(f, " ({equations}, {redundant} of which follow from the others)"),
        }
    }
}

/// A corner (of a surface, a crease; it is told where it is sharpest) after an edit.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct Corner {
    /// Where: `at 2`, `along u = 2 (at v = 0.5)`.
    pub place: String,
    /// The angle between the tangents on both sides (of a surface: between the normals), 0 where smooth, 180 at a cusp.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub degrees: Option<f64>,
    /// The same before the edit; nothing where there was no tangent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub before: Option<f64>,
    /// How far the two sides are apart, where they met before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap: Option<f64>,
}

impl Corner {
    /// How much of a change it is: the angle's in degrees, above all of them a gap.
    pub fn change(&self) -> f64 {
        let turned = (self.degrees.unwrap_or(0.0) - self.before.unwrap_or(0.0)).abs();
        if self.gap.is_some() { 360.0 + turned } else { turned }
    }
}

/// An angle for people; one that nobody sees is none.
pub(crate) fn angle(degrees: f64) -> String {
    match degrees {
        d if d.to_radians() <= 1e-5 => "0°".to_owned(),
        d if d < 0.1 => format!("{}°", figure(d)),
        d => format!("{d:.1}°"),
    }
}

impl fmt::Display for Corner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(gap) = self.gap {
            return write!(f, "a gap of {} {} (was closed)", figure(gap), self.place);
        }
        write!(f, "a corner of {} {}", angle(self.degrees.unwrap_or(0.0)), self.place)?;
        match self.before {
            Some(before) => write!(f, " (was {})", angle(before)),
            None => f.write_str(" (had no tangent)"),
        }
    }
}

//! A surface or a patch of one, tuned: α with which its edges stay, and its directions one after the other.

use loftsman_kernel::Vector;
use loftsman_kernel::spline::algebra::Field;
use loftsman_kernel::spline::{Direction, Space, Surface};

use crate::curve::Ends;
use crate::edges::Edges;
use crate::error::{FineTuneError, Result};
use crate::fit::{fitted, raised};
use crate::lift::{Alpha, lifted};
use crate::lines::{across, facing, index, name};
use crate::measure::{self, change, undone};
use crate::scaling::Scaling;
use crate::similar::matched;
use crate::surface::{FineTuneSurface, SurfaceReport, TunedSurface};

impl FineTuneSurface {
    /// All of a surface by α over its domain, with so many derivatives in common at its ends.
    pub(crate) fn whole(&self, surface: &Surface, asked: Scaling, continuity: u8) -> Result<TunedSurface> {
        let given = surface.function()?;
        let mut report = SurfaceReport { scale: [1.0; 2], alpha: [[1.0; 2]; 2], ..SurfaceReport::default() };
        let mut scaling = asked.clone();
        let field = if let Scaling::Both { u, v } = &asked {
            let fields = [u.clone(), v.clone()];
            let start = raised(&given, &fields)?;
            let kept = [Direction::U, Direction::V].map(|direction| match self.ends[index(direction)] {
                _ if given.space(direction).is_periodic() => 0,
                Ends::Exact => usize::from(continuity) + 1,
                Ends::Free => 0,
                Ends::Position => 1,
                Ends::Tangent => 2,
                Ends::Curvature => 3,
            });
            let (field, residual) = fitted(&given, &fields, &start, kept)?;
            report.residual = Some(residual);
            field
        } else {
            let mut field = given.clone();
            for direction in [Direction::U, Direction::V] {
                let Some(alpha) = asked.of(direction)? else { continue };
                let own = facing(&given, direction)?;
                let alpha = self.met(&own, alpha, direction, continuity, &mut report)?;
                let turned = self.step(&facing(&field, direction)?, &alpha, direction, &mut report)?;
                field = facing(&turned, direction)?;
                scaling = scaling.with(direction, alpha)?;
            }
            field
        };
        for direction in [Direction::U, Direction::V] {
            let (Some(first), Some(found)) = (asked.of(direction)?, scaling.of(direction)?) else { continue };
            let change = change(&first, &found)?;
            report.change[index(direction)] = change;
            if change > 0.0
                && let Some(words) = undone(change, measure::asked(&first)?, !self.pinned.is_empty())
            {
                report.notes.push(format!("along {}, {words}", name(direction)));
            }
            report.alpha[index(direction)] = found.extremes()?;
        }
        Ok(TunedSurface { surface: field.into_surface()?, scaling, report })
    }

    /// α with which the edges stay where they are to stay exactly; else as it is.
    fn met(
        &self,
        given: &Field<Vector>,
        alpha: Alpha,
        direction: Direction,
        continuity: u8,
        report: &mut SurfaceReport,
    ) -> Result<Alpha> {
        let level = usize::from(continuity);
        let part = |direction: Direction| self.region[index(direction)].is_some();
        // A closed direction has no ends; a region has two, and so has a whole open surface.
        let ends = part(direction) || (self.region == [None; 2] && !given.space(Direction::U).is_periodic());
        let exact = self.ends[index(direction)] == Ends::Exact;
        let net = matches!(alpha, Alpha::Net(_));
        let (lines, sides) = (alpha.along().degree(), alpha.across().map_or(0, Space::degree));
        // Of α of a low degree there are no derivatives that could differ.
        let columns = if net && part(across(direction)) { (level + 1).min(sides + 1) } else { 0 };
        if !exact {
            // Free ends of a part that reaches from end to end: its sides stay all the same.
            return if columns > 0 { one_at_sides(alpha, columns) } else { Ok(alpha) };
        }
        let edges = Edges {
            rows: if ends { level.min(lines + 1) } else { 0 },
            columns,
            pins: self.pinned.iter().filter(|pin| pin.direction == direction).collect(),
            solver: &self.solver,
            any_sign: self.any_sign,
            names: [name(direction), name(across(direction))],
        };
        let (alpha, solved) = edges.solve(given, &alpha)?;
        report.notes.extend(solved.iter().flat_map(|solved| solved.notes.iter().cloned()));
        report.solved[index(direction)] = solved;
        Ok(alpha)
    }

    /// One direction scaled, and its ends matched where a similarity is asked for.
    fn step(
        &self,
        given: &Field<Vector>,
        alpha: &Alpha,
        direction: Direction,
        report: &mut SurfaceReport,
    ) -> Result<Field<Vector>> {
        let names = [name(direction), name(across(direction))];
        let closed = given.space(Direction::U).is_periodic();
        let fixed = match self.ends[index(direction)] {
            Ends::Exact => return lifted(given, alpha, closed, names),
            Ends::Free => return lifted(given, alpha, false, names),
            Ends::Position => 1,
            Ends::Tangent => 2,
            Ends::Curvature => 3,
        };
        if closed {
            return Err(FineTuneError::Closed { which: "ends", whose: "given" });
        }
        let tuned = lifted(given, alpha, false, names)?;
        let same = lifted(given, &alpha.one()?, false, names)?;
        let (field, scale) = matched(&tuned, &same, fixed, names[0])?;
        report.scale[index(direction)] = scale;
        Ok(field)
    }
}

/// α with its outermost columns 1.
fn one_at_sides(alpha: Alpha, columns: usize) -> Result<Alpha> {
    let alpha = alpha.clamped(false, true)?;
    let width = alpha.columns();
    let edge = |j: usize| j < columns || j + columns >= width;
    let each = alpha.values().iter().enumerate().map(|(k, c)| if edge(k % width) { 1.0 } else { *c });
    alpha.with(each.collect())
}

//! A surface or a patch of one, tuned: α with which its edges stay, and its directions one after the other.

use loftsman_kernel::Vector;
use loftsman_kernel::shape::Side;
use loftsman_kernel::spline::algebra::Field;
use loftsman_kernel::spline::{Direction, Space, Surface};
use loftsman_kernel::text::figure;

use crate::curve::{CLOSES, Ends, SEAM};
use crate::edges::Edges;
use crate::error::{FineTuneError, Result};
use crate::fit::{fitted, raised};
use crate::lift::{Alpha, lifted};
use crate::lines::{across, facing, index, name, size};
use crate::measure::{self, change, undone};
use crate::scaling::Scaling;
use crate::similar::matched;
use crate::surface::{FineTuneSurface, SurfaceReport, TunedSurface};

impl FineTuneSurface {
    /// All of a surface by α over its domain.
    pub(crate) fn whole(&self, surface: &Surface, asked: Scaling) -> Result<TunedSurface> {
        let given = surface.function()?;
        let mut report = SurfaceReport { scale: [1.0; 2], alpha: [[1.0; 2]; 2], ..SurfaceReport::default() };
        let mut scaling = asked.clone();
        let field = if let Scaling::Both { u, v } = &asked {
            let fields = [u.clone(), v.clone()];
            let start = raised(&given, &fields)?;
            let kept = [Direction::U, Direction::V].map(|direction| match self.ends[index(direction)] {
                _ if given.space(direction).is_periodic() => [0; 2],
                Ends::Exact => self.levels(direction).map(|level| level + 1),
                Ends::Free => [0; 2],
                Ends::Position => [1; 2],
                Ends::Tangent => [2; 2],
                Ends::Curvature => [3; 2],
            });
            let (field, residual) = fitted(&given, &fields, &start, kept)?;
            report.residual = Some(residual);
            field
        } else {
            let mut field = given.clone();
            for direction in [Direction::U, Direction::V] {
                let Some(alpha) = asked.of(direction)? else { continue };
                let own = facing(&given, direction)?;
                let alpha = self.met(&own, alpha, direction, &mut report)?;
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
                && let Some(words) =
                    undone(change, measure::asked(&first)?, !self.pinned.is_empty(), found.extremes()?)
            {
                report.notes.push(format!("along {}, {words}", name(direction)));
            }
            report.alpha[index(direction)] = found.extremes()?;
            if field.space(direction).is_periodic() && given.space(direction).degree() > 1 {
                report.notes.extend(seam(&found, direction)?);
            }
        }
        Ok(TunedSurface { surface: field.into_surface()?, scaling, report })
    }

    /// α with which the edges stay where they are to stay exactly; else as it is.
    fn met(
        &self,
        given: &Field<Vector>,
        alpha: Alpha,
        direction: Direction,
        report: &mut SurfaceReport,
    ) -> Result<Alpha> {
        let exact = self.ends[index(direction)] == Ends::Exact;
        let net = matches!(alpha, Alpha::Net(_));
        let (lines, sides) = (alpha.along().degree(), alpha.across().map_or(0, Space::degree));
        // Of α of a low degree there are no derivatives that could differ.
        let beside = |join: Option<u8>| join.map_or(0, |level| (usize::from(level) + 1).min(sides + 1));
        let columns = if net { self.joins(across(direction)).map(beside) } else { [0; 2] };
        if !exact {
            // Free ends of a part that reaches from end to end: its sides stay all the same.
            return if columns == [0; 2] { Ok(alpha) } else { one_at_sides(alpha, columns) };
        }
        let edges = Edges {
            rows: if given.space(Direction::U).is_periodic() {
                [0; 2]
            } else {
                self.levels(direction).map(|level| level.min(lines + 1))
            },
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

    /// How many derivatives stay at either end of a direction with exact ends.
    fn levels(&self, direction: Direction) -> [usize; 2] {
        self.joins(direction).map(|join| usize::from(join.or(self.continuity).unwrap_or(0)))
    }

    /// One direction scaled, and its lines turned and scaled where that is to keep their ends.
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
            Ends::Free => {
                let open = lifted(given, alpha, false, names)?;
                // What closes by itself stays closed.
                return if closed && gap(&open) <= CLOSES {
                    lifted(given, alpha, true, names)
                } else {
                    Ok(open)
                };
            }
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

/// What there is to say of a surface that is closed along a direction whose α ends with other values than it starts with.
fn seam(alpha: &Alpha, direction: Direction) -> Result<Option<String>> {
    let (along, (a, b)) = (alpha.along(), alpha.along().domain());
    if along.is_periodic() {
        return Ok(None);
    }
    let breaks = alpha.across().map_or_else(|| vec![0.0], Space::breakpoints);
    let middles = breaks.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect::<Vec<_>>();
    let value = |at: f64, side: Side, v: f64| alpha.at(&((at, v), [side, Side::Right]));
    let mut most = 1.0_f64;
    let lasts = breaks.len().saturating_sub(usize::from(breaks.len() > 1));
    for v in breaks.iter().take(lasts).chain(&middles) {
        let factor = value(b, Side::Left, *v)? / value(a, Side::Right, *v)?;
        most = if factor.abs().ln().abs() > most.abs().ln().abs() { factor } else { most };
    }
    let name = name(direction);
    Ok(((most - 1.0).abs() > SEAM).then(|| {
        format!(
            "along {name} alpha ends with another value than it starts with, and the surface is closed: its curvature along {name} jumps there, from the end to \
             the start by a factor of up to {}; an alpha that is periodic along {name} leaves it as it was",
            figure(most)
        )
    }))
}

/// How far apart the first and the last line of a clamped surface are, as a part of its size.
fn gap(field: &Field<Vector>) -> f64 {
    let (all, n) = (field.coefficients(), field.space(Direction::V).len());
    let pairs = all.iter().zip(&all[all.len() - n..]);
    pairs.fold(0.0_f64, |m, (a, b)| m.max((a - b).amax())) / size(field)
}

/// α with its outermost columns 1.
fn one_at_sides(alpha: Alpha, columns: [usize; 2]) -> Result<Alpha> {
    let alpha = alpha.clamped(false, true)?;
    let width = alpha.columns();
    let edge = |j: usize| j < columns[0] || j + columns[1] >= width;
    let each = alpha.values().iter().enumerate().map(|(k, c)| if edge(k % width) { 1.0 } else { *c });
    alpha.with(each.collect())
}

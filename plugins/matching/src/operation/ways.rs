//! The ways in which a surface can be made to meet an edge, and which is taken.

use loftsman_kernel::plugin::{Context, OperationError};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::spline::Surface;

use super::asked::Asked;
use super::attempt::Work;
use super::made::{Instead, Made, Way};
use super::remedy::{Refused, Why};

impl Asked {
    /// What is asked, in the metric that was said; or, where none was, by bending little, and another way where that folds, or goes much farther.
    pub(super) fn run(
        &self,
        surface: &Surface,
        other: &dyn Shape,
        context: &Context<'_>,
    ) -> Result<Made, OperationError> {
        let mut work = Work { called: "match", done: 0, most: usize::MAX };
        match self.best(surface, other, context, &mut work)? {
            Ok(made) => Ok(made),
            Err(refused) => Err(self.told(&refused, surface, other, context, &work)?),
        }
    }

    /// The same, or why there is none.
    pub(super) fn best(
        &self,
        surface: &Surface,
        other: &dyn Shape,
        context: &Context<'_>,
        work: &mut Work,
    ) -> Result<Result<Made, Refused>, OperationError> {
        let first = self.way(surface, other, context, work)?;
        // Tangent planes leave open on which side of the edge a surface lies. What moves least comes about on its own, if it does.
        let (why, mut best) = match first {
            Ok(made) if self.measured || made.changed.is_plain() => return Ok(Ok(made)),
            Ok(made) => {
                let why = match made.changed.fold {
                    _ if made.changed.is_lost() => Instead::Unmeasured,
                    Some(at) => Instead::FoldsAt(at),
                    None => Instead::Farther(made.changed.moved),
                };
                (why, Ok(made))
            }
            Err(refused) if refused.folds() => (Instead::Folds, Err(refused)),
            Err(refused) if !self.measured && refused.why == Why::NoneFound => {
                (Instead::NoneFound, Err(refused))
            }
            Err(refused) if !self.measured && matches!(refused.why, Why::Unmeasured(_)) => {
                (Instead::Unmeasured, Err(refused))
            }
            Err(refused) => return Ok(Err(refused)),
        };
        let ways: &[Way] = if self.measured { &[Way::Led] } else { &[Way::Least, Way::Led, Way::LedLeast] };
        for &way in ways {
            if why == Instead::Unmeasured && way == Way::Led {
                continue;
            }
            let mut work = work.as_much_again();
            match self.by(way).attempt(surface, other, context, &mut work) {
                Ok(Ok(made)) => {
                    let made = Made { way: Some((way, why)), ..made };
                    best = Ok(match best {
                        Ok(best) if !best.changed.is_worse_than(&made.changed) => best,
                        _ => made,
                    });
                }
                // Whoever asked may have had enough; all else says no more than what came of the first.
                _ => context.observer.proceed(work.called, 0, 0)?,
            }
            if best.as_ref().is_ok_and(|best| best.changed.is_whole()) {
                break;
            }
        }
        Ok(best)
    }

    /// The same another way.
    fn by(&self, way: Way) -> Self {
        let (least, led) = match way {
            Way::Least => (true, false),
            Way::Led => (false, true),
            Way::LedLeast => (true, true),
        };
        Self { bend: self.bend && !least, led, ..self.clone() }
    }

    /// With a closed edge that begins between the other's knots, or else at one.
    fn way(
        &self,
        surface: &Surface,
        other: &dyn Shape,
        context: &Context<'_>,
        work: &mut Work,
    ) -> Result<Result<Made, Refused>, OperationError> {
        let first = self.attempt(surface, other, context, work);
        // Both sides of a knot may miss tangent planes by the limit.
        let allowed = 2.0 * self.limits.angle.to_degrees();
        // Where a start between the other's knots asks for corners, or for too many knots, one at these may not.
        match first {
            Ok(Ok(made)) if made.corner() <= allowed => Ok(Ok(made)),
            first if !self.starts_between(surface, other)? => first,
            first => {
                let knots = Self { free: false, ..self.clone() };
                match (first, knots.attempt(surface, other, context, work)) {
                    (Err(_) | Ok(Err(_)), Ok(Ok(made))) => Ok(Ok(made)),
                    (Ok(Ok(first)), Ok(Ok(made))) if made.corner() <= first.corner() => Ok(Ok(made)),
                    (first, _) => {
                        // Whoever asked may have had enough; all else says no more than what came of the first.
                        context.observer.proceed(work.called, 0, 0)?;
                        first
                    }
                }
            }
        }
    }
}

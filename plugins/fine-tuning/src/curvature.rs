//! A curvature that is asked, as equations for α.

use std::any::Any;
use std::sync::Arc;

use loftsman_kernel::edit::{Constraint, EditError, Value, Wanted};
use loftsman_kernel::error::{Error, Figure};
use loftsman_kernel::functional::{Curvature, Functional, Linearity, Rows, Shapes, value_of};
use loftsman_kernel::shape::{Derivative, Location, Shape, Side, Stencil};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

use crate::alpha::MOST;
use crate::error::{FineTuneError, Result};
use crate::local::within;

/// A curve whose curvature is less than so many times what rounding makes of it is straight, as the kernel's functional has it.
const STRAIGHT: f64 = 1e4;
/// What two numbers may differ by that come from one place of one curve, in other knots or another degree.
const SAME: f64 = 1e-9;

/// What a curvature asks of α.
pub(crate) struct Bend {
    /// The equations (or bounds), one for each side that is another.
    pub(crate) conditions: Vec<Constraint>,
    /// Whether the place is one that may move, and is to stand still beside it.
    pub(crate) is_inside: bool,
}

/// How the curve is on a side of the place.
struct OnSide {
    at: f64,
    curvature: f64,
    /// Where it is straight, the curvature that is none.
    straight: Option<f64>,
    is_inside: bool,
}

/// The equations for α that say what a curvature of the tuned curve should be, where a constraint asks for one.
///
/// With `D' = α C'`, `D'' = α C'' + α' C'` lies in the plane of `C'` and `C''`, so that the curve turns in the plane in which it did, and its
/// curvature is `κ/α`, exactly (paper 5, §2). That it be `k` is the **linear** equation `α = κ/k`, of each side of the place where α or `κ`
/// jumps; that it be `k` or more (less) with `k > 0` is `α ≤ κ/k` (`≥`). `k` has the sign of `κ` where α is positive. Where the
/// curve is straight it stays so, whatever α is. `curve` is the given one, or all of it where α is over a part.
///
/// # Errors
/// When the curve has no curvature there, or what is asked is no `κ/α`.
pub(crate) fn bend(
    constraint: &Constraint,
    curve: &Curve,
    alpha: &Space,
    part: Option<(f64, f64)>,
    any_sign: bool,
) -> Result<Option<Bend>> {
    let functional = constraint.functional();
    let any: &dyn Any = functional.as_ref();
    let location = functional.location().filter(|_| any.is::<Curvature>() && constraint.narrowed().is_none());
    let Some((0, Location::Curve(at))) = location else { return Ok(None) };
    let shapes: [&dyn Shape; 1] = [curve];
    let shapes = Shapes::new(shapes);
    let Some(bound) = functional.bind(&shapes)? else { return Ok(None) };
    let mut values = vec![0.0; bound.equations()];
    value_of(bound.as_ref(), &shapes, &mut values)?;
    let notes = bound.notes();
    // At a corner, of which there is a note, the side behind it alone is asked.
    let sides = if notes.is_empty() { &[Side::Right, Side::Left][..] } else { &[Side::Right] };
    let mut conditions: Vec<(Stencil, f64, Constraint)> = Vec::new();
    let mut is_inside = false;
    for (k, &side) in sides.iter().enumerate() {
        let curvature = values.get(2 * k).or(values.first()).copied().unwrap_or(0.0);
        let here = OnSide::new(curve, at, side, curvature, part)?;
        is_inside |= here.is_inside;
        let Some(wanted) = alpha_of(constraint, bound.as_ref(), &here, k, any_sign)? else { continue };
        if !here.is_inside {
            if !wanted.holds(1.0) {
                return Err(refused(
                    constraint,
                    "the curve stands still there, outside of the range that is tuned: ask inside of it, or tune a longer range",
                ));
            }
            continue;
        }
        let row = crate::scale::row(alpha, here.at, 0, side)?;
        if let Some((_, value, _)) = conditions.iter().find(|(other, ..)| alike(other, &row)) {
            let other = wanted.value();
            if (other - value).abs() > SAME * value.abs() {
                let before = values.get(2).copied().unwrap_or(curvature);
                return Err(refused(
                    constraint,
                    &format!(
                        "the curvature jumps there, from {} to {}, and α does not, so that it divides both by the same: scale it, or keep it, or give \
                         α a knot there that is repeated as often as its degree and once more",
                        Figure(before),
                        Figure(values.first().copied().unwrap_or(curvature))
                    ),
                ));
            }
            continue;
        }
        let value = wanted.value();
        let name = if conditions.is_empty() {
            constraint.describe()
        } else {
            format!("{} (before it)", constraint.describe())
        };
        let notes = if conditions.is_empty() { notes.clone() } else { Vec::new() };
        let of = AlphaAt { at: here.at, side, name, notes };
        conditions.push((row, value, wanted.constraint(constraint, of)));
    }
    Ok(Some(Bend { conditions: conditions.into_iter().map(|(.., c)| c).collect(), is_inside }))
}

impl OnSide {
    fn new(curve: &Curve, at: f64, side: Side, curvature: f64, part: Option<(f64, f64)>) -> Result<Self> {
        let space = curve.space();
        let (span, at) = space.span_on(space.locate(at)?, side);
        let middle = 0.5 * (space.flat()[span] + space.flat()[span + 1]);
        // Of a part over the seam of a closed curve, α goes on beyond it.
        let inside = part.map_or(Some(middle), |part| within(space, part, middle));
        let beyond = if inside.is_some_and(|u| u > middle) { space.length() } else { 0.0 };
        let is_inside = inside.is_some();
        let stencil = |order: usize| curve.stencil_on(Location::Curve(at), order.into(), side.into());
        let (first, second) = (stencil(1)?, stencil(2)?);
        let points = curve.points();
        let (one, two) = (rounding(&first, points), rounding(&second, points));
        let (first, second) = (first.apply(points).norm(), second.apply(points).norm());
        // As in the kernel's functional: what rounding of the control vertices makes of a curvature.
        let noise = (one * second / first + two) / first / first + 3.0 * curvature * one / first;
        let straight = (curvature <= STRAIGHT * noise).then(|| 1e3 * noise.max(curvature));
        Ok(Self { at: at + beyond, curvature, straight, is_inside })
    }
}

/// `ε Σ |S_i| |P_i|`.
fn rounding(stencil: &Stencil, points: &[Point]) -> f64 {
    let sum: f64 = stencil.iter().filter_map(|(i, c)| Some(c.abs() * points.get(i)?.coords.norm())).sum();
    f64::EPSILON * sum
}

/// Whether two rows are one to rounding.
fn alike(one: &Stencil, other: &Stencil) -> bool {
    let apart: Stencil = one.iter().chain(other.iter().map(|(i, c)| (i, -c))).collect();
    apart.coefficients().iter().all(|c| c.abs() <= 1e-11)
}

/// What α should be at a place.
enum Should {
    Be(f64),
    AtLeast(f64),
    AtMost(f64),
}

impl Should {
    fn value(&self) -> f64 {
        let (Self::Be(value) | Self::AtLeast(value) | Self::AtMost(value)) = self;
        *value
    }

    fn holds(&self, alpha: f64) -> bool {
        match self {
            Self::Be(value) => (alpha - value).abs() <= SAME,
            Self::AtLeast(value) => alpha >= value - SAME,
            Self::AtMost(value) => alpha <= value + SAME,
        }
    }

    fn constraint(&self, asked: &Constraint, of: AlphaAt) -> Constraint {
        let name = of.name.clone();
        let new =
            |wanted: fn(Value) -> Wanted| Constraint::new(Arc::new(of), wanted(Value(vec![self.value()])));
        match self {
            Self::Be(_) => new(Wanted::To).called(&name),
            Self::AtLeast(_) => new(Wanted::AtLeast).called(&format!("{}: α there", asked.label())),
            Self::AtMost(_) => new(Wanted::AtMost).called(&format!("{}: α there", asked.label())),
        }
    }
}

/// What α should be on a side, and nothing where any α does.
fn alpha_of(
    constraint: &Constraint,
    bound: &dyn Functional,
    here: &OnSide,
    k: usize,
    any_sign: bool,
) -> Result<Option<Should>> {
    let refused = |why: &str| refused(constraint, why);
    let number = |Value(given): &Value| -> Result<f64> {
        if let Some(bad) = given.iter().find(|v| !v.is_finite()) {
            return Err(refused(&format!("{bad} is not a finite number")));
        }
        let all = match given[..] {
            [one] => vec![one, 0.0],
            _ => given.clone(),
        };
        let pair = if all.len() == 2 { all.get(..2) } else { all.get(2 * k..2 * k + 2) };
        match (all.len(), pair) {
            (2 | 4, Some(&[own, 0.0])) => Ok(own),
            (2 | 4, _) => Err(refused(
                "fine tuning leaves the plane in which a curve turns as it is: ask for one number, the curvature in that plane",
            )),
            (found, _) => Err(refused(&format!("{found} numbers are given where one is needed"))),
        }
    };
    let bounded = |value: &Value| {
        if any_sign {
            return Err(refused(
                "it has no bound where α may be of any sign: ask for a value, or leave any_sign out",
            ));
        }
        number(value)
    };
    let own = here.curvature;
    let (wanted, bound_of) = match constraint.wanted() {
        Wanted::Keep => return Ok(here.straight.is_none().then_some(Should::Be(1.0))),
        Wanted::Scale(factor) if !factor.is_finite() => {
            return Err(refused(&format!("{factor} is not a factor; give a finite number")));
        }
        Wanted::Scale(_) if here.straight.is_some() => return Ok(None),
        Wanted::Scale(factor) => (own * factor, None),
        Wanted::By(value) => (own + number(value)?, None),
        Wanted::To(value) => (number(value)?, None),
        Wanted::Hold => (0.0, None),
        Wanted::AtLeast(value) => (bounded(value)?, Some(true)),
        Wanted::AtMost(value) => (bounded(value)?, Some(false)),
    };
    if let Some(none) = here.straight {
        let holds = match bound_of {
            None => wanted.abs() <= none,
            Some(true) => wanted <= none,
            Some(false) => wanted >= -none,
        };
        return if holds {
            Ok(None)
        } else {
            Err(refused(
                "the curve is straight there and stays so, because its tangents keep their directions: bend it first (edit, signed-curvature)",
            ))
        };
    }
    match bound_of {
        Some(true) if wanted <= 0.0 => return Ok(None),
        Some(false) if wanted <= 0.0 => {
            return Err(refused(&turned(own, wanted)));
        }
        _ => {}
    }
    if wanted == 0.0 {
        return Err(refused(&format!(
            "it is {} there, and fine tuning divides it by α, which makes it as small as you like and never 0",
            Figure(own)
        )));
    }
    if wanted < 0.0 && !any_sign {
        return Err(refused(&turned(own, wanted)));
    }
    let value = own / wanted;
    if value.abs() > MOST {
        return Err(FineTuneError::TooLarge { value });
    }
    bound.check_target(&[own], &[wanted]).map_err(EditError::from)?;
    Ok(Some(match bound_of {
        None => Should::Be(value),
        Some(true) => Should::AtMost(value),
        Some(false) => Should::AtLeast(value),
    }))
}

fn turned(own: f64, wanted: f64) -> String {
    format!(
        "it is {} there, and {} takes an α that is not positive, by which the curve would turn to the other side: ask for a positive number, or \
         say any_sign where tangents may turn round",
        Figure(own),
        Figure(wanted)
    )
}

fn refused(constraint: &Constraint, why: &str) -> FineTuneError {
    Error::Invalid(format!("{}: {why}", constraint.describe())).into()
}

/// α's value on one side of a place, in the name of the curvature that it divides.
#[derive(Debug, Clone, PartialEq)]
struct AlphaAt {
    at: f64,
    side: Side,
    name: String,
    notes: Vec<String>,
}

impl Functional for AlphaAt {
    fn equations(&self) -> usize {
        1
    }

    fn linearity(&self) -> Linearity {
        Linearity::Linear
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> loftsman_kernel::error::Result<()> {
        let at = Location::Curve(self.at);
        let stencil = shapes.stencil_on(1, at, Derivative::POSITION, self.side.into())?;
        rows.equation();
        rows.along(1, &stencil, Vector::x());
        Ok(())
    }

    fn describe(&self) -> String {
        self.name.clone()
    }

    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    fn location(&self) -> Option<(usize, Location)> {
        Some((1, Location::Curve(self.at)))
    }

    fn dimension(&self) -> Option<u8> {
        Some(0)
    }
}

//! What is asked of the tuned curve and is so, or is not, whatever α is: that a tangent has the direction that it has.

use loftsman_kernel::edit::{Axis, Constraint, Value, Wanted};
use loftsman_kernel::functional::{Equation, Linearity, Shapes, Store, rows_of, value_of};
use loftsman_kernel::shape::{Derivative, Location};

use crate::error::{FineTuneError, Result};
use crate::operator::{FromAlpha, Influence};

/// The part of a row's size times that of the shapes up to which what it asks is so.
const MET: f64 = 1e-9;
/// The same of coordinates beside which others are asked for: a place off the plane of a curve is not one of it.
const ROUNDING: f64 = 1e-12;

/// Takes out what no α changes: its rows are nothing but rounding as rows over α's values, and would be taken for equations. What it asks is so; that is
/// said, in a sentence for each.
///
/// # Errors
/// When what it asks is not so.
pub(crate) fn take_out(
    conditions: &mut Vec<Constraint>,
    shapes: &Shapes<'_>,
    map: &dyn FromAlpha,
) -> Result<Vec<String>> {
    let mut notes = Vec::new();
    let mut kept = Vec::with_capacity(conditions.len());
    for (number, condition) in conditions.drain(..).enumerate() {
        match judged(&condition, shapes, map)? {
            Judged::Asked => kept.push(condition),
            // Of some coordinates α has nothing to say: the others are asked for.
            Judged::Along { axes, off } if off <= ROUNDING => kept.extend(axes),
            Judged::Idle { off } if off <= MET => {
                // The end, or that a loop closes, comes first, and nobody asked for it.
                if number > 0 {
                    notes.push(format!("{} holds whatever alpha is", condition.describe()));
                }
            }
            Judged::Turned => {
                return Err(FineTuneError::Contradiction(format!(
                    "{}: tangents keep their directions whatever alpha is, and this asks for another one; leave it out, or bend the curve first (edit)",
                    condition.describe()
                )));
            }
            Judged::Along { .. } | Judged::Idle { .. } => {
                return Err(FineTuneError::Contradiction(format!(
                    "{}: no alpha changes this, for tangents keep their directions; leave it out, or bend the curve first (edit)",
                    condition.describe()
                )));
            }
        }
    }
    *conditions = kept;
    Ok(notes)
}

/// What α has to say in what is asked, and how far what it cannot change is from it, as a part of the size of its rows times that of the shapes.
enum Judged {
    Asked,
    /// α would have to be 0 where it is asked: another direction.
    Turned,
    Idle {
        off: f64,
    },
    /// In some coordinates of a place or a derivative: these.
    Along {
        axes: Vec<Constraint>,
        off: f64,
    },
}

fn judged(condition: &Constraint, shapes: &Shapes<'_>, map: &dyn FromAlpha) -> Result<Judged> {
    let functional = condition.functional();
    let wanted = match condition.wanted() {
        Wanted::To(Value(wanted)) => wanted.to_vec(),
        Wanted::Hold => Vec::new(),
        _ => return Ok(Judged::Asked),
    };
    if functional.linearity() != Linearity::Linear || !matches!(functional.location(), Some((0, _))) {
        return Ok(Judged::Asked);
    }
    let mut store = Store::default();
    rows_of(functional.as_ref(), shapes, &mut store.rows(shapes))?;
    let (mut sizes, mut row, mut said) = (0.0_f64, vec![0.0; map.columns()], Vec::new());
    for equation in store.equations() {
        match equation {
            Equation::Alike { vertices, coefficients, .. } => {
                row.fill(0.0);
                for (vertex, by) in vertices.iter().zip(coefficients) {
                    for entry in row.iter_mut().skip(3 * vertex).take(3) {
                        *entry += by;
                    }
                    sizes = sizes.max(by.abs() * shapes.vertex(*vertex).coords.norm());
                }
                said.extend(map.influences(&row));
            }
            Equation::Coupled { vertices, vectors, constant } => {
                row.fill(0.0);
                for (vertex, vector) in vertices.iter().zip(vectors) {
                    for axis in 0..3 {
                        if let Some(entry) = row.get_mut(3 * vertex + axis) {
                            *entry += vector[axis];
                        }
                    }
                    sizes = sizes.max(vector.norm() * shapes.vertex(*vertex).coords.norm());
                }
                let own = map.influence(&row);
                let is_zero = constant == 0.0 && wanted.iter().all(|to| *to == 0.0);
                if own == Influence::Some && is_zero && is_of_alpha(&row, functional.location(), shapes, map)?
                {
                    return Ok(Judged::Turned);
                }
                said.push(own);
            }
        }
    }
    let count = said.len();
    let asked: Vec<usize> = match condition.narrowed() {
        Some(axis) => vec![axis as usize],
        None => (0..count).collect(),
    };
    let says = |k: &usize| said.get(*k).copied().unwrap_or(Influence::Some);
    let (some, idle): (Vec<usize>, Vec<usize>) = asked.iter().partition(|k| says(k) == Influence::Some);
    // What is asked where nothing is tuned is judged by the edit.
    let is_nothing = idle.iter().all(|k| says(k) == Influence::Nothing);
    if idle.is_empty() || is_nothing && some.is_empty() {
        return Ok(Judged::Asked);
    }
    let is_place = count == 3 && functional.equations() == 3;
    if !some.is_empty() && !is_place {
        return Ok(Judged::Asked);
    }
    let mut present = vec![0.0; functional.equations()];
    value_of(functional.as_ref(), shapes, &mut present)?;
    let is_narrowed = condition.narrowed().is_some();
    let to = |k: usize| {
        let own = if is_narrowed { wanted.first() } else { wanted.get(k).or(wanted.first()) };
        own.copied().unwrap_or(0.0)
    };
    let most = idle.iter().fold(0.0_f64, |most, k| {
        most.max((present.get(*k).copied().unwrap_or(f64::INFINITY) - to(*k)).abs())
    });
    let off = if sizes > 0.0 { most / sizes } else { most };
    if some.is_empty() {
        return Ok(Judged::Idle { off });
    }
    // Coordinates of a plane curve that are as they are to be have no rows, and are left to the edit.
    if is_nothing && most == 0.0 {
        return Ok(Judged::Asked);
    }
    let along = |k: usize| {
        let axis = [Axis::X, Axis::Y, Axis::Z][k];
        let narrowed = condition.clone().axis(axis).called(&condition.describe());
        if wanted.is_empty() {
            narrowed
        } else {
            narrowed.wanting(Wanted::To(Value([to(k)].into_iter().collect())))
        }
    };
    Ok(Judged::Along { axes: some.into_iter().map(along).collect(), off })
}

/// Whether what a row comes to as one over α's values is a multiple of α's own value at a place.
fn is_of_alpha(
    row: &[f64],
    location: Option<(usize, Location)>,
    shapes: &Shapes<'_>,
    map: &dyn FromAlpha,
) -> Result<bool> {
    let Some((_, at @ Location::Curve(_))) = location else { return Ok(false) };
    let Ok(own) = shapes.stencil(1, at, Derivative::POSITION) else { return Ok(false) };
    let (mut found, mut alone) = (vec![0.0; map.unknowns()], vec![0.0; map.unknowns()]);
    map.apply_transposed(row, &mut found);
    for (k, by) in own.iter() {
        if let Some(entry) = alone.get_mut(k) {
            *entry += by;
        }
    }
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let factor = dot(&found, &alone) / dot(&alone, &alone);
    let most = found.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    Ok(most > 0.0 && found.iter().zip(&alone).all(|(x, own)| (x - factor * own).abs() <= MET * most))
}

//! What is asked of the tuned curve and is so, or is not, whatever α is: that a tangent has the direction that it has.

use loftsman_kernel::edit::{Constraint, Value, Wanted};
use loftsman_kernel::functional::{Equation, Linearity, Shapes, Store, rows_of, value_of};

use crate::error::{FineTuneError, Result};
use crate::operator::{FromAlpha, Influence};

/// The part of a row's size times that of the shapes up to which what it asks is so.
const MET: f64 = 1e-9;

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
    for condition in conditions.drain(..) {
        match off(&condition, shapes, map)? {
            None => kept.push(condition),
            Some(off) if off <= MET => {
                notes.push(format!("{} holds whatever alpha is", condition.describe()));
            }
            Some(_) => {
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

/// How far off what is asked is, as a part of the size of its rows times that of the shapes, where no α changes it; `None` where one does.
fn off(condition: &Constraint, shapes: &Shapes<'_>, map: &dyn FromAlpha) -> Result<Option<f64>> {
    let functional = condition.functional();
    let wanted = match condition.wanted() {
        Wanted::To(Value(wanted)) => wanted.to_vec(),
        Wanted::Hold => Vec::new(),
        _ => return Ok(None),
    };
    if functional.linearity() != Linearity::Linear || !matches!(functional.location(), Some((0, _))) {
        return Ok(None);
    }
    let mut store = Store::default();
    rows_of(functional.as_ref(), shapes, &mut store.rows(shapes))?;
    let columns = map.columns();
    let (mut sizes, mut row, mut is_rounding) = (0.0_f64, vec![0.0; columns], false);
    for equation in store.equations() {
        // Three equations of one stencil are of a position or a derivative, which α changes.
        let Equation::Coupled { vertices, vectors, .. } = equation else { return Ok(None) };
        row.fill(0.0);
        for (vertex, vector) in vertices.iter().zip(vectors) {
            for axis in 0..3 {
                if let Some(entry) = row.get_mut(3 * vertex + axis) {
                    *entry += vector[axis];
                }
            }
            sizes = sizes.max(vector.norm() * shapes.vertex(*vertex).coords.norm());
        }
        match map.influence(&row) {
            Influence::Some => return Ok(None),
            Influence::Rounding => is_rounding = true,
            Influence::Nothing => {}
        }
    }
    if !is_rounding {
        return Ok(None);
    }
    let mut present = vec![0.0; functional.equations()];
    value_of(functional.as_ref(), shapes, &mut present)?;
    let each = present.iter().enumerate();
    let most = each.fold(0.0_f64, |most, (k, is)| {
        most.max((is - wanted.get(k).or(wanted.first()).copied().unwrap_or(0.0)).abs())
    });
    Ok(Some(if sizes > 0.0 { most / sizes } else { most }))
}

//! What functionals hand over, checked on arrival: a functional of another's making may name a control vertex that is not
//! there, count its equations wrong or write nothing, and must be told so by name.

use super::{Functional, Rows, Shapes, Store};
use crate::error::{Error, Result};
use crate::text::counted;

/// More equations than this are a mistake (or more than can be computed with).
const MOST: usize = 1 << 24;
/// A value that nobody computes: what is still this was not written.
const UNWRITTEN: u64 = 0x7ff8_0bad_5eed_0001;

/// A functional's rows, appended and checked: as many equations as it says, about control vertices that there are, with
/// finite coefficients and constants. `O(entries)` beside its own work.
///
/// # Errors
/// As for [`Functional::rows`]; where they are wrong, naming the functional and its type.
pub fn rows_of(functional: &dyn Functional, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
    let first = rows.begin();
    functional.rows(shapes, rows)?;
    arrived(functional, rows, first)?;
    usable(functional, rows.store(), first)
}

/// Whether a functional's rows, from block `first` on, have finite coefficients and constants.
///
/// # Errors
/// Where they have not, naming the functional and its type.
pub(crate) fn usable(functional: &dyn Functional, rows: &Store, first: usize) -> Result<()> {
    rows.unusable(first).map_or(Ok(()), |what| Err(wrong(functional, &what)))
}

/// Value and linearization at once, checked as by [`rows_of`], but for coefficients that are not finite: whoever computes on
/// with them at every event finds those.
///
/// # Errors
/// As for [`Functional::linearize`]; where they are wrong, naming the functional and its type.
pub fn linearize_of(
    functional: &dyn Functional,
    shapes: &Shapes<'_>,
    rows: &mut Rows<'_>,
    value: &mut [f64],
) -> Result<()> {
    let first = rows.begin();
    value.fill(f64::from_bits(UNWRITTEN));
    functional.linearize(shapes, rows, value)?;
    arrived(functional, rows, first)?;
    written(functional, value)
}

/// A functional's value, checked: into all of `out`, which has a place for each of its equations.
///
/// # Errors
/// As for [`Functional::value`]; where it leaves some of its numbers out, naming the functional and its type.
pub fn value_of(functional: &dyn Functional, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
    out.fill(f64::from_bits(UNWRITTEN));
    functional.value(shapes, out)?;
    written(functional, out)
}

/// How many equations it says it has.
///
/// # Errors
/// When these are more than can be.
pub(crate) fn equations_of(functional: &dyn Functional) -> Result<usize> {
    match functional.equations() {
        count if count <= MOST => Ok(count),
        count => Err(wrong(
            functional,
            &format!("says that it has {count} equations; at most {MOST} are possible"),
        )),
    }
}

fn arrived(functional: &dyn Functional, rows: &Rows<'_>, first: usize) -> Result<()> {
    if let Some(what) = rows.astray() {
        return Err(wrong(functional, what));
    }
    let (said, found) = (functional.equations(), rows.scalar_equations(first));
    if said != found {
        let what = format!("says that it has {} and appends {found}", counted(said, "equation[|s]"));
        return Err(wrong(functional, &what));
    }
    Ok(())
}

fn written(functional: &dyn Functional, out: &[f64]) -> Result<()> {
    let missing = out.iter().filter(|v| v.to_bits() == UNWRITTEN).count();
    if missing == 0 {
        return Ok(());
    }
    let found = out.len() - missing;
    let (said, found) = (counted(out.len(), "equation[|s]"), counted(found, "value[|s]"));
    Err(wrong(functional, &format!("says that it has {said} and writes {found}")))
}

fn wrong(functional: &dyn Functional, what: &str) -> Error {
    Error::Invalid(format!("\"{}\" ({}) {what}", functional.describe(), functional.type_name()))
}

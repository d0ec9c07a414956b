//! Evaluation in batches: many parameters on a curve, grids and pairs of parameters on a surface.
//!
//! Point by point, most of the time goes into finding the span and into the basis functions. In a batch both are
//! paid once a span (curves) or once a row and a column (grids), and what is left is Horner's rule on several
//! parameters at once, or a short sum of vectors. Work is cut into blocks of fixed size, with or without threads, so that
//! the result is the same to the bit whatever the number of threads.

mod bernstein;
mod cursor;
mod curve;
mod grid;
mod powers;
mod sample;
mod scattered;

use crate::error::{Error, Result};

pub(super) use sample::unit_cross;
pub use sample::{OrientedPoint, Sample};

/// Parameters in one block of work.
const BLOCK: usize = 1 << 14;
/// Parameters that Horner's rule takes at once: their sums are vectors that the compiler knows to vectorise.
const LANES: usize = 4;

fn same_length(expected: usize, found: usize) -> Result<()> {
    if expected == found {
        return Ok(());
    }
    Err(Error::Invalid(format!(
        "the batch gives {expected} results and there is room for {found}: make both equal"
    )))
}

/// `work` on blocks of parameters and the parts of `out` that belong to them (`each` entries a parameter).
fn in_blocks<U: Sync, T: Send>(
    us: &[U],
    out: &mut [T],
    each: usize,
    work: impl Fn(&[U], &mut [T]) -> Result<()> + Sync,
) -> Result<()> {
    let block = (BLOCK / each.max(1)).max(1);
    #[cfg(feature = "parallel")]
    if us.len() > 2 * block {
        use rayon::prelude::*;
        return us
            .par_chunks(block)
            .zip(out.par_chunks_mut((block * each).max(1)))
            .try_for_each(|(us, out)| work(us, out));
    }
    for (us, out) in us.chunks(block).zip(out.chunks_mut((block * each).max(1))) {
        work(us, out)?;
    }
    Ok(())
}

#[cfg(test)]
mod double;
#[cfg(test)]
mod tests;

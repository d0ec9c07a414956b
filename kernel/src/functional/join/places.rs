//! Places along edges: where functions on them are looked at.

use crate::spline::space::Space;
use crate::topology::Pair;
use crate::topology::pair::Common;

/// Places within each span, as many as asked for, denser towards its ends: where a polynomial is small at `n` of them and of
/// degree `n - 1`, it is small between them.
pub(super) fn nodes(breakpoints: &[f64], each: usize) -> impl Iterator<Item = f64> + '_ {
    breakpoints.windows(2).flat_map(move |span| {
        let (middle, half) = (0.5 * (span[0] + span[1]), 0.5 * (span[1] - span[0]));
        let angle = std::f64::consts::PI / each as f64;
        (0..each).map(move |i| middle - half * (angle * (i as f64 + 0.5)).cos())
    })
}

/// The breakpoints of both edges, where knots that nearly agree are not one.
pub(super) fn all_breakpoints(pair: &Pair<'_>, common: &Common) -> Vec<f64> {
    let mut all = common.space.breakpoints();
    all.extend(pair.first.space().breakpoints());
    all.extend(pair.second.space().breakpoints().into_iter().map(|u| pair.here(u)));
    all.sort_by(f64::total_cmp);
    let (a, b) = pair.first.space().domain();
    all.dedup_by(|t, before| *t - *before <= 1e-9 * (b - a));
    all
}

/// As many parameters as the space has vertices, at which a function of it is determined (Schoenberg and Whitney): the
/// Greville abscissae, for a floating space those of the clamped one that spans the same functions on the domain.
pub(super) fn places(space: &Space) -> Vec<f64> {
    if space.is_periodic() {
        return (0..space.len()).map(|i| space.greville(i)).collect();
    }
    let ((a, b), p, flat) = (space.domain(), space.degree(), space.flat());
    let inside = |k: f64| k.max(a).min(b);
    (0..space.len())
        .map(|i| inside(flat[i + 1..=i + p].iter().map(|&k| inside(k) / p as f64).sum()))
        .collect()
}

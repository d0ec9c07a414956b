//! How steps are taken.

/// How steps are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scheme {
    /// Paper 3's (13): a parameter that floats has a small mass `ε`.
    #[default]
    Epsilon,
    /// Paper 3's (11): it has none.
    Exact,
    /// Backward Euler: for what is stiff. It takes energy out; parameters have no mass.
    Implicit,
}

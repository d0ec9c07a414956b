//! Part of Loftsman: fitting.

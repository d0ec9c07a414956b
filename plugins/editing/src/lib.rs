//! Part of Loftsman: editing.

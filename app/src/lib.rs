//! Loftsman.

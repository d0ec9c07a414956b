//! Part of Loftsman: tessellation.

//! Part of Loftsman: points.

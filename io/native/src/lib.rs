//! Part of Loftsman: native.

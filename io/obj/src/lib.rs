//! Part of Loftsman: obj.

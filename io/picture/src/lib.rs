//! Part of Loftsman: picture.

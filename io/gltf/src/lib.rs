//! Part of Loftsman: gltf.

//! Shading normals.

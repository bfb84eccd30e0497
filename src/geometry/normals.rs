//! Shading normals.

/// Shading normals per corner.
#[derive(Clone, Debug)]
pub struct CornerNormals;

/// Stub.
pub fn corner_normals() {}

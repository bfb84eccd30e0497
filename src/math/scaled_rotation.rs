//! The linear part of a placement together with its inverse, in `f64`. Powers of two and quarter turns are undone exactly.

use super::{DMat3, DVec3};

/// A rotation times a uniform scale, mirrored where the scale is negative, together with its inverse; in `f64`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScaledRotation {
    matrix: DMat3,
    inverse: DMat3,
}

impl ScaledRotation {
    /// The map of `matrix`, whose columns are orthogonal, equally long and not zero.
    #[must_use]
    pub fn new(matrix: DMat3) -> Self {
        // No elimination: what a power of two or a quarter turn does is undone exactly.
        let inverse = matrix.transpose() * matrix.x_axis.length_squared().recip();
        Self { matrix, inverse }
    }

    /// The map itself.
    #[must_use]
    pub fn matrix(&self) -> &DMat3 {
        &self.matrix
    }

    /// `vector`, turned and scaled.
    #[must_use]
    #[inline]
    pub fn apply(&self, vector: DVec3) -> DVec3 {
        self.matrix * vector
    }

    /// The vector that [`Self::apply`] turns into `vector`.
    #[must_use]
    #[inline]
    pub fn undo(&self, vector: DVec3) -> DVec3 {
        self.inverse * vector
    }

    /// The factor of all lengths.
    #[must_use]
    pub fn scale(&self) -> f64 {
        self.matrix.x_axis.length()
    }

    /// Whether it turns left hands into right ones.
    #[must_use]
    pub fn is_mirrored(&self) -> bool {
        self.matrix.determinant() < 0.0
    }

    /// The largest coordinates, by magnitude, that [`Self::apply`] can give to a vector whose own are at most `sizes`, which are not
    /// negative.
    #[must_use]
    pub fn largest(&self, sizes: DVec3) -> DVec3 {
        let DMat3 {
            x_axis,
            y_axis,
            z_axis,
        } = self.matrix;
        x_axis.abs() * sizes.x + y_axis.abs() * sizes.y + z_axis.abs() * sizes.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::power_of_two;

    fn about_z(angle: f64, scale: f64) -> ScaledRotation {
        ScaledRotation::new(DMat3::from_rotation_z(angle) * scale)
    }

    #[test]
    fn undoing_gives_the_vector_back() {
        let vector = DVec3::new(0.3, -7.0, 1e-3);
        for scale in [1e-30, -0.7, 1.0, 1e20] {
            let map = about_z(0.4, scale);
            assert!((map.undo(map.apply(vector)) - vector).length() < 1e-14);
            assert_eq!(map.is_mirrored(), scale < 0.0);
            assert!((map.scale() / scale.abs() - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn powers_of_two_are_undone_exactly() {
        let vector = DVec3::new(0.1, -7.3, 1.0 / 3.0);
        for exponent in [-40, -1, 0, 7] {
            let factor = power_of_two(exponent);
            let map = ScaledRotation::new(DMat3::IDENTITY * factor);
            assert_eq!(map.undo(vector), vector / factor);
        }
    }

    #[test]
    fn no_vector_grows_beyond_the_largest() {
        let map = about_z(2.0, -3.0);
        let sizes = DVec3::new(1.0, 2.0, 0.5);
        for signs in 0..8 {
            let sign = |bit: u32| if signs >> bit & 1 == 0 { 1.0 } else { -1.0 };
            let vector = sizes * DVec3::new(sign(0), sign(1), sign(2));
            assert!(map.apply(vector).abs().cmple(map.largest(sizes)).all());
        }
    }
}

//! The image of a background: linear radiance over all directions, equirectangular.

/// An equirectangular image of radiance: every direction once, the first row straight up, the last straight down.
///
/// Where on it a direction is found is said by [`ImageAxes`](super::ImageAxes). Values are linear RGB in W/m²/sr, each finite
/// and at least 0.
#[derive(Clone, Debug, PartialEq)]
pub struct RadianceMap {
    width: u32,
    height: u32,
    pixels: Vec<[f32; 3]>,
    /// Whether all values are 0.
    is_black: bool,
}

impl RadianceMap {
    /// Most pixels of a side.
    pub const MAX_SIDE: u32 = 1 << 16;
    /// Most pixels in all, as many as a picture may have: a few gigabytes.
    pub const MAX_PIXELS: u64 = 1 << 28;

    /// Whether an image of this size can be held: no side is 0, and none of the limits is passed.
    #[must_use]
    pub fn can_hold(width: u64, height: u64) -> bool {
        let sides = 1..=u64::from(Self::MAX_SIDE);
        sides.contains(&width) && sides.contains(&height) && width * height <= Self::MAX_PIXELS
    }

    /// The image of these pixels, row by row from the top left, and in how many of them a value was negative, infinite or not
    /// a number; such values become 0.
    ///
    /// # Panics
    /// When the size [cannot be held](Self::can_hold) or is not that of `pixels`.
    #[must_use]
    pub fn cleaned(width: u32, height: u32, mut pixels: Vec<[f32; 3]>) -> (Self, u64) {
        assert!(
            Self::can_hold(width.into(), height.into())
                && pixels.len() as u64 == u64::from(width) * u64::from(height),
            "{} pixels for an image of {width}×{height}",
            pixels.len()
        );
        let mut count = 0;
        for pixel in &mut pixels {
            let is_radiance = |value: f32| value.is_finite() && value >= 0.0;
            if !pixel.iter().all(|&value| is_radiance(value)) {
                count += 1;
                *pixel = pixel.map(|value| if is_radiance(value) { value } else { 0.0 });
            }
        }
        let map = Self {
            width,
            height,
            is_black: pixels.iter().all(|pixel| *pixel == [0.0; 3]),
            pixels,
        };
        (map, count)
    }

    /// Pixels per row.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Whether no pixel gives light.
    #[must_use]
    pub fn is_black(&self) -> bool {
        self.is_black
    }

    /// All pixels, row by row from the top left.
    #[must_use]
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// All pixels, as a list of their own.
    #[must_use]
    pub fn into_pixels(self) -> Vec<[f32; 3]> {
        self.pixels
    }

    /// The pixels of row `y` from the top, from left to right.
    ///
    /// # Panics
    /// Outside the image.
    #[must_use]
    pub fn row(&self, y: u32) -> &[[f32; 3]] {
        let width = self.width as usize;
        &self.pixels[y as usize * width..][..width]
    }

    /// The angle from straight up to the centres of row `y`, in radians.
    #[must_use]
    pub fn polar_angle(&self, y: u32) -> f64 {
        (f64::from(y) + 0.5) / f64::from(self.height) * std::f64::consts::PI
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_that_are_no_radiance_become_zero_and_are_counted() {
        let pixels = vec![
            [1.0, 2.0, 3.0],
            [f32::NAN, 2.0, -1.0],
            [0.0, f32::INFINITY, 0.5],
            [-0.0, 0.0, 0.0],
        ];
        let (map, count) = RadianceMap::cleaned(2, 2, pixels);
        assert_eq!(count, 2);
        assert_eq!(map.row(0), [[1.0, 2.0, 3.0], [0.0, 2.0, 0.0]]);
        assert_eq!(map.row(1), [[0.0, 0.0, 0.5], [0.0, 0.0, 0.0]]);
        assert!(!map.is_black());
        let (map, _) = RadianceMap::cleaned(1, 1, vec![[f32::NAN, -1.0, -0.0]]);
        assert!(map.is_black());
    }

    #[test]
    fn absurd_sizes_cannot_be_held() {
        for (width, height) in [(1, 1), (65_536, 4096), (16_384, 8192)] {
            assert!(RadianceMap::can_hold(width, height));
        }
        for (width, height) in [(0, 1), (1, 0), (65_537, 1), (16_384, 16_385), (u64::MAX, 2)] {
            assert!(!RadianceMap::can_hold(width, height));
        }
    }
}

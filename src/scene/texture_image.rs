//! Images to be laid on surfaces, in the precision of their files: 8 or 16 bits with colours in sRGB, or linear `f32`.

use rayon::prelude::*;

use super::{RadianceMap, Rgb};
use crate::math::Vec3;
use crate::math::color::linear_from_srgb;

/// An image to be laid on surfaces, as its file holds it. What its values mean is for the material to say: colours, or normals.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureImage {
    width: u32,
    height: u32,
    texels: Texels,
    mean: Rgb,
}

/// The values of a [`TextureImage`], red, green and blue, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// Of 8 bits each; colours are sRGB.
    Bytes(Vec<[u8; 3]>),
    /// Of 16 bits each; colours are sRGB.
    Words(Vec<[u16; 3]>),
    /// Linear, each finite and at least 0.
    Floats(Vec<[f32; 3]>),
}

impl Texels {
    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Bytes(texels) => texels.len(),
            Self::Words(texels) => texels.len(),
            Self::Floats(texels) => texels.len(),
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The mean of them as colours, linear.
    fn mean(&self) -> Rgb {
        let linear = |code: f32| f64::from(linear_from_srgb(code));
        let sum = match self {
            Self::Bytes(texels) => {
                let table: [f64; 256] =
                    std::array::from_fn(|code| linear(code as f32 / f32::from(u8::MAX)));
                sum(texels, |texel| {
                    texel.map(|code| table[usize::from(code)]).into()
                })
            }
            Self::Words(texels) => {
                let decode = |code: u16| linear(f32::from(code) / f32::from(u16::MAX));
                sum(texels, |texel| texel.map(decode).into())
            }
            Self::Floats(texels) => sum(texels, |texel| Vec3::from(texel).as_dvec3()),
        };
        sum / self.len() as f64
    }

    /// Memory, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        match self {
            Self::Bytes(texels) => size_of_val(&texels[..]),
            Self::Words(texels) => size_of_val(&texels[..]),
            Self::Floats(texels) => size_of_val(&texels[..]),
        }
    }
}

/// The sum of what texels mean: of parts side by side, whose sums are added in their order, so that no bit depends on the threads.
fn sum<T: Copy + Sync>(texels: &[T], meaning: impl Fn(T) -> Rgb + Sync) -> Rgb {
    const PART: usize = 1 << 16;
    let parts = texels.par_chunks(PART);
    let sums = parts.map(|part| part.iter().map(|&texel| meaning(texel)).sum::<Rgb>());
    sums.collect::<Vec<_>>().into_iter().sum()
}

impl TextureImage {
    /// The image of these texels.
    ///
    /// # Panics
    /// When the size [cannot be held](RadianceMap::can_hold), is not that of `texels`, or a float among them is negative or not finite.
    #[must_use]
    pub fn new(width: u32, height: u32, texels: Texels) -> Self {
        assert!(
            RadianceMap::can_hold(width.into(), height.into())
                && texels.len() as u64 == u64::from(width) * u64::from(height),
            "{} texels for an image of {width}×{height}",
            texels.len()
        );
        if let Texels::Floats(floats) = &texels {
            let is_right = |value: &f32| value.is_finite() && *value >= 0.0;
            assert!(floats.iter().flatten().all(is_right), "finite, at least 0");
        }
        Self {
            width,
            height,
            mean: texels.mean(),
            texels,
        }
    }

    /// Its mean colour, where it is one of colours: linear.
    #[must_use]
    pub fn mean_color(&self) -> Rgb {
        self.mean
    }

    /// Whether no texel has a colour: what heights look like, and normals never do.
    #[must_use]
    pub fn is_grey(&self) -> bool {
        fn are_grey<T: PartialEq>(texels: &[[T; 3]]) -> bool {
            texels.iter().all(|[r, g, b]| r == g && g == b)
        }
        match &self.texels {
            Texels::Bytes(texels) => are_grey(texels),
            Texels::Words(texels) => are_grey(texels),
            Texels::Floats(texels) => are_grey(texels),
        }
    }

    /// Texels per row.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All of its values.
    #[must_use]
    pub fn texels(&self) -> &Texels {
        &self.texels
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half of the texels black, half white: half of the light, whatever they are stored in.
    #[test]
    fn the_mean_is_that_of_the_light() {
        let images = [
            Texels::Bytes(vec![[0; 3], [255; 3]]),
            Texels::Words(vec![[0; 3], [65_535; 3]]),
            Texels::Floats(vec![[0.0; 3], [1.0; 3]]),
        ];
        for texels in images {
            assert_eq!(
                TextureImage::new(1, 2, texels).mean_color(),
                Rgb::splat(0.5)
            );
        }
        let grey = TextureImage::new(1, 1, Texels::Bytes(vec![[188, 0, 0]]));
        assert!((grey.mean_color().x - 0.5).abs() < 0.005);
    }
}

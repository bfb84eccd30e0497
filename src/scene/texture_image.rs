use super::RadianceMap;

/// An image to be laid on surfaces, as its file holds it. What its values mean is for the material to say: colours, or normals.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureImage {
    width: u32,
    height: u32,
    texels: Texels,
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
            texels,
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

//! Finished pictures: a plain type that rendering, analysis and files share, with a hash that tells whether two are the same bits.

use sha2::{Digest, Sha256};

use crate::control::CancelToken;

/// A finished picture: linear RGB radiance, row by row from the top left.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Image {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width · height` values.
    pub pixels: Vec<[f32; 3]>,
}

impl Image {
    /// A black picture.
    #[must_use]
    pub fn black(width: u32, height: u32) -> Self {
        Self {
            width,
            height,
            pixels: vec![[0.0; 3]; width as usize * height as usize],
        }
    }

    /// The value at column `x`, row `y` from the top.
    ///
    /// # Panics
    /// Outside the picture.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 3] {
        assert!(
            x < self.width && y < self.height,
            "pixel ({x}, {y}) of a {}×{} picture",
            self.width,
            self.height
        );
        self.pixels[y as usize * self.width as usize + x as usize]
    }

    /// SHA-256 over width and height (`u32`) and the RGB rows from the top (`f32`), all little-endian, in hexadecimal.
    #[must_use]
    pub fn hash(&self) -> String {
        let Some(hash) = self.hash_unless(&CancelToken::new()) else {
            unreachable!("nobody cancels");
        };
        hash
    }

    /// [`Self::hash`]; `None` when cancelled.
    #[must_use]
    pub fn hash_unless(&self, cancel: &CancelToken) -> Option<String> {
        /// Pixels between two looks at the cancel token.
        const CHUNK: usize = 1 << 14;
        let mut hasher = Sha256::new();
        hasher.update(self.width.to_le_bytes());
        hasher.update(self.height.to_le_bytes());
        for pixels in self.pixels.chunks(CHUNK) {
            if cancel.is_cancelled() {
                return None;
            }
            for channel in pixels.as_flattened() {
                hasher.update(channel.to_le_bytes());
            }
        }
        let digest = hasher.finalize();
        let hex = digest.iter().fold(String::with_capacity(64), |hex, byte| {
            hex + &format!("{byte:02x}")
        });
        Some(hex)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hash_is_not_made_to_its_end_when_cancelled() {
        let (image, cancel) = (Image::black(3, 2), CancelToken::new());
        assert_eq!(image.hash_unless(&cancel), Some(image.hash()));
        cancel.cancel();
        assert_eq!(image.hash_unless(&cancel), None);
    }

    /// Expected value from `printf '\1\0\0\0\1\0\0\0\0\0\x80\x3f\0\0\0\0\0\0\0\xbf' | sha256sum`.
    #[test]
    fn hash_is_over_size_and_little_endian_rows() {
        let image = Image {
            width: 1,
            height: 1,
            pixels: vec![[1.0, 0.0, -0.5]],
        };
        assert_eq!(
            image.hash(),
            "520471bef471569cfd6758d5f4259b698e171407fab42caf77aa6a7fa9fb3d99"
        );
    }
}

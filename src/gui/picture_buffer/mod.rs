//! The pixels that a render fills in, and how they become colours for the screen.
//!
//! The render's threads put linear tiles into a [`PictureBuffer`] and encode them for the screen there, so the window's
//! thread only copies finished bytes into a texture.
//!
//! - `texels`: which pixel each texel on the screen shows
//! - `grid`: how the texels are cut into textures
//! - `encoding`: all of a picture in another look
//! - `reading`: what is read from a picture beside its tiles

mod encoding;
mod grid;
mod reading;
mod texels;

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use egui::{ColorImage, Vec2};

use super::error_colors::scale_of;
use super::look::{Channels, Look};
use super::part::Part;
use crate::render::{CoarsePicture, Image, Layer, Region, TilePixels};
use crate::scene::Display;

pub use grid::Grid;
use texels::Texels;
pub use texels::{CoarseTexels, Encoded, EncodedTile};

/// How many buffers there were.
static BUFFERS: AtomicU64 = AtomicU64::new(0);

/// Which picture of this program it is. Renders may take over the number of one that nobody wants to remember; this is never another's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PictureId(u64);

impl PictureId {
    fn next() -> Self {
        Self(BUFFERS.fetch_add(1, Ordering::Relaxed))
    }
}

/// The linear picture so far, shared by the threads that fill it and those that show or save it.
#[derive(Debug)]
pub struct PictureBuffer {
    id: PictureId,
    /// What of the picture is kept; other pixels are never there.
    part: Part,
    /// Its size in pixels.
    width: u32,
    height: u32,
    texels: Texels,
    layers: Vec<Layer>,
    /// Whether the layers were given up.
    is_bare: AtomicBool,
    state: Mutex<BufferState>,
}

#[derive(Debug)]
struct BufferState {
    /// The picture, then its layers; none of them before the first is needed, see [`Self::planes`].
    planes: Vec<Image>,
    /// How many there are, and their size.
    count: usize,
    size: [u32; 2],
    /// Which of them is on the screen.
    shown: usize,
    display: Display,
    channels: Channels,
    /// The error with the last colour, see [`super::error_colors`]; `None` while nothing is known of it.
    error_scale: Option<f32>,
    /// How often what is on the screen, or how it is shown, has changed.
    changes: u64,
}

impl BufferState {
    /// The picture, then its layers. They are made by whoever asks first, which is a thread that renders: it takes longer than the window has.
    fn planes(&mut self) -> &mut Vec<Image> {
        if self.planes.is_empty() {
            let [width, height] = self.size;
            let black = || Image::black(width, height);
            self.planes = std::iter::repeat_with(black).take(self.count).collect();
        }
        &mut self.planes
    }

    /// How values of `layer`, or of the picture, look in all channels.
    fn look(&self, layer: Option<Layer>) -> Look {
        self.look_in(layer, Channels::All)
    }

    /// How to show values of `layer`, or of the picture, on the screen.
    fn look_on_screen(&self, layer: Option<Layer>) -> Look {
        self.look_in(layer, self.channels)
    }

    fn look_in(&self, layer: Option<Layer>, channels: Channels) -> Look {
        match layer {
            Some(Layer::Error) => Look::Error(self.error_scale.unwrap_or_default()),
            _ => Look::Light(self.display, channels),
        }
    }
}

impl PictureBuffer {
    /// A black part of a picture with these layers, shown with `display`. `None` when it does not fit into memory.
    #[must_use]
    pub fn new(part: Part, layers: Vec<Layer>, display: Display) -> Option<Self> {
        let Region { width, height, .. } = part.region;
        let count = usize::try_from(u64::from(width) * u64::from(height)).ok()?;
        let planes = 1 + layers.len();
        // Ask first: allocating ends the program where there is no room.
        Vec::<[f32; 3]>::new()
            .try_reserve_exact(count.checked_mul(planes)?)
            .ok()?;
        Some(Self {
            id: PictureId::next(),
            part,
            width,
            height,
            texels: Texels::of([width, height]),
            layers,
            is_bare: AtomicBool::new(false),
            state: Mutex::new(BufferState {
                planes: Vec::new(),
                count: planes,
                size: [width, height],
                shown: 0,
                display,
                channels: Channels::default(),
                error_scale: None,
                changes: 0,
            }),
        })
    }

    /// A picture that is whole, without layers.
    #[must_use]
    pub fn of_image(image: Image, display: Display) -> Self {
        let part = Part::whole([image.width, image.height]);
        Self::of_render(image, Vec::new(), part, display)
    }

    /// This part of a picture, finished, with its layers, which are as large.
    #[must_use]
    pub fn of_render(
        image: Image,
        layers: Vec<(Layer, Image)>,
        part: Part,
        display: Display,
    ) -> Self {
        let size = [image.width, image.height];
        let errors = layers.iter().find(|(layer, _)| *layer == Layer::Error);
        let error_scale = errors.map(|(_, errors)| scale_of(errors));
        let (layers, images): (Vec<Layer>, Vec<Image>) = layers.into_iter().unzip();
        let planes: Vec<Image> = std::iter::once(image).chain(images).collect();
        Self {
            id: PictureId::next(),
            part,
            width: size[0],
            height: size[1],
            texels: Texels::of(size),
            layers,
            is_bare: AtomicBool::new(false),
            state: Mutex::new(BufferState {
                count: planes.len(),
                size,
                planes,
                shown: 0,
                display,
                channels: Channels::default(),
                error_scale,
                changes: 0,
            }),
        }
    }

    /// Which picture it is.
    #[must_use]
    pub fn id(&self) -> PictureId {
        self.id
    }

    /// What of the picture is kept.
    #[must_use]
    pub fn part(&self) -> Part {
        self.part
    }

    /// The layers that are kept beside the picture.
    #[must_use]
    pub fn layers(&self) -> &[Layer] {
        if self.is_bare.load(Ordering::Relaxed) {
            &[]
        } else {
            &self.layers
        }
    }

    /// Gives up the layers; the picture stays. Returns them, as giving back their memory may take its time.
    pub fn take_layers(&self) -> Vec<Image> {
        let mut state = self.lock();
        let shown = std::mem::take(&mut state.shown);
        state.changes += u64::from(shown != 0);
        self.is_bare.store(true, Ordering::Relaxed);
        state.count = 1;
        if state.planes.is_empty() {
            return Vec::new();
        }
        state.planes.split_off(1)
    }

    /// Bytes of the picture and of its layers.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let pixels = u64::from(self.width) * u64::from(self.height);
        pixels * size_of::<[f32; 3]>() as u64 * (1 + self.layers().len() as u64)
    }

    /// Picture pixels per texel along each axis: 1 unless the picture has too many for the memory of textures.
    #[must_use]
    pub fn step(&self) -> u32 {
        self.texels.step()
    }

    /// Width and height of what the screen shows of it, in texels.
    #[must_use]
    pub fn size_in_texels(&self) -> [usize; 2] {
        self.texels.size()
    }

    /// The picture so far. Takes its time: not for the window's thread.
    #[must_use]
    #[expect(clippy::missing_panics_doc, reason = "only layers are ever given up")]
    pub fn image(&self) -> Image {
        self.copy_of(0).expect("the picture is always kept")
    }

    /// Its layers so far, like [`Self::image`]; without those that are given up meanwhile, and without that of the error where nothing is
    /// known of it.
    #[must_use]
    pub fn layer_images(&self) -> Vec<(Layer, Image)> {
        let knows_error = self.lock().error_scale.is_some();
        let layers = self.layers().iter().enumerate();
        let layers = layers.filter(|&(_, &layer)| layer != Layer::Error || knows_error);
        let images = layers.filter_map(|(index, &layer)| Some((layer, self.copy_of(index + 1)?)));
        images.collect()
    }

    fn copy_of(&self, plane: usize) -> Option<Image> {
        let mut pixels = Vec::with_capacity(self.width as usize * self.height as usize);
        self.read(plane, |piece| pixels.extend_from_slice(piece))?;
        Some(Image {
            width: self.width,
            height: self.height,
            pixels,
        })
    }

    /// Hands on a plane piece by piece, from top to bottom; `None` where it is not kept, or not to its end.
    ///
    /// The window's thread may have the planes between any two pieces: to wait for all of a large picture would take many frames.
    fn read(&self, plane: usize, mut take: impl FnMut(&[[f32; 3]])) -> Option<()> {
        /// Pixels of a piece: copied in a part of a millisecond.
        const PIECE: usize = 1 << 15;
        let count = self.width as usize * self.height as usize;
        let mut piece = Vec::with_capacity(PIECE);
        for start in (0..count).step_by(PIECE) {
            let end = count.min(start + PIECE);
            piece.clear();
            piece.extend_from_slice(&self.lock().planes().get(plane)?.pixels[start..end]);
            take(&piece);
        }
        Some(())
    }

    /// Shows a layer, or the picture, from now on; what is already shown needs [`PictureBuffer::encode_all`]. A layer that is not
    /// kept shows the picture.
    pub fn set_shown(&self, layer: Option<Layer>) {
        let index = layer.and_then(|layer| self.layers().iter().position(|&kept| kept == layer));
        let shown = index.map_or(0, |index| index + 1);
        self.change(|state| std::mem::replace(&mut state.shown, shown) != shown);
    }

    /// Shows the picture with `display` from now on; tiles already shown need [`PictureBuffer::encode_all`].
    pub fn set_display(&self, display: Display) {
        self.change(|state| std::mem::replace(&mut state.display, display) != display);
    }

    /// Shows these channels from now on; what is already shown needs [`PictureBuffer::encode_all`].
    pub fn set_channels(&self, channels: Channels) {
        self.change(|state| std::mem::replace(&mut state.channels, channels) != channels);
    }

    /// Has `change` done, which says whether the picture looks different from now on.
    fn change(&self, change: impl FnOnce(&mut BufferState) -> bool) {
        let mut state = self.lock();
        state.changes += u64::from(change(&mut state));
    }

    /// The layer that is on the screen; `None` where that is the picture.
    #[must_use]
    pub fn shown_layer(&self) -> Option<Layer> {
        self.layer(self.lock().shown)
    }

    /// Whether the layer of the error is on the screen.
    #[must_use]
    pub fn shows_error(&self) -> bool {
        self.shown_layer() == Some(Layer::Error)
    }

    /// The error that has the last colour, where the layer of the error is on the screen and known.
    #[must_use]
    pub fn shown_error_scale(&self) -> Option<f32> {
        let state = self.lock();
        let is_shown = self.layer(state.shown) == Some(Layer::Error);
        state.error_scale.filter(|_| is_shown)
    }

    /// Takes in the error of every pixel, where it is kept. What shows it needs [`PictureBuffer::encode_all`].
    pub fn set_error(&self, errors: Image) {
        if let Some(index) = self.layers().iter().position(|&kept| kept == Layer::Error) {
            let scale = scale_of(&errors);
            let mut state = self.lock();
            let before = std::mem::replace(&mut state.planes()[index + 1], errors);
            state.error_scale = Some(scale);
            state.changes += u64::from(state.shown == index + 1);
            // To give back a large layer takes its time, for which nobody is to wait.
            drop(state);
            drop(before);
        }
    }

    /// The layer of plane `index`; `None` for the picture.
    fn layer(&self, index: usize) -> Option<Layer> {
        index.checked_sub(1).map(|layer| self.layers[layer])
    }

    /// Takes in a tile of the render and returns what to show; `None` where the reduced picture has no pixel of it, or a
    /// layer is on the screen that does not come in tiles.
    #[must_use]
    pub fn accept(&self, tile: &TilePixels<'_>) -> Option<EncodedTile> {
        let region = Region {
            x: tile.region.x - self.part.region.x,
            y: tile.region.y - self.part.region.y,
            ..tile.region
        };
        let (look, rgb) = {
            let mut state = self.lock();
            // The error, which is the last, comes in no tile.
            let planes = std::iter::once(tile.rgb).chain(tile.layers.iter().map(Vec::as_slice));
            for (image, rgb) in state.planes().iter_mut().zip(planes) {
                region.copy_into(rgb, image);
            }
            let shown = state
                .shown
                .checked_sub(1)
                .map(|index| tile.layers.get(index));
            (
                state.look_on_screen(None),
                match shown {
                    None => tile.rgb,
                    Some(layer) => layer?.as_slice(),
                },
            )
        };
        let encode = |x: u32, y: u32| {
            let index = (y - region.y) as usize * region.width as usize + (x - region.x) as usize;
            look.color(rgb[index])
        };
        self.texels.encode(
            region.x..region.x + region.width,
            region.y..region.y + region.height,
            encode,
        )
    }

    /// Takes in a coarse picture of the part that is kept and returns what to show; `None` where a layer is on the screen: it has none.
    #[must_use]
    pub fn accept_coarse(&self, coarse: &CoarsePicture) -> Option<CoarseTexels> {
        let look = {
            let mut state = self.lock();
            let rows = state.planes()[0]
                .pixels
                .chunks_exact_mut(self.width as usize);
            for (row, pixels) in (0..).zip(rows) {
                for (pixel, rgb) in pixels.iter_mut().zip(coarse.row(row)) {
                    *pixel = rgb;
                }
            }
            (state.shown == 0).then(|| state.look_on_screen(None))?
        };
        let size = coarse.size();
        let pixels = coarse.rgb.iter().map(|&rgb| look.color(rgb)).collect();
        let share =
            |pixels: u32, blocks: usize| pixels as f32 / (blocks as f32 * coarse.side as f32);
        Some(CoarseTexels {
            pixels: Arc::new(ColorImage::new(size, pixels)),
            share: Vec2::new(share(self.width, size[0]), share(self.height, size[1])),
            is_smooth: false,
        })
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, BufferState> {
        // Pixels are plain numbers: one that panicked half-way leaves nothing broken.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::CancelToken;
    use egui::Color32;

    fn buffer(width: u32, height: u32) -> Option<PictureBuffer> {
        let part = Part::whole([width, height]);
        PictureBuffer::new(part, Vec::new(), Display::default())
    }

    fn tile(region: Region, value: f32) -> (Region, Vec<[f32; 3]>) {
        (region, vec![[value; 3]; region.pixel_count()])
    }

    #[test]
    fn tiles_are_shown_where_they_belong() {
        let buffer = buffer(70, 40).unwrap();
        let region = Region {
            x: 32,
            y: 8,
            width: 38,
            height: 16,
        };
        let (region, rgb) = tile(region, 1.0);
        let encoded = buffer
            .accept(&TilePixels {
                region,
                rgb: &rgb,
                layers: &[],
            })
            .unwrap();
        assert_eq!(encoded.position, [32, 8]);
        assert_eq!(encoded.pixels.size, [38, 16]);
        assert!(encoded.pixels.pixels.iter().all(|&p| p == Color32::WHITE));
        assert_eq!(buffer.image().pixel(32, 8), [1.0; 3]);
        assert_eq!(buffer.image().pixel(31, 8), [0.0; 3]);
    }

    #[test]
    fn the_window_need_not_wait_until_a_picture_is_copied() {
        let buffer = buffer(512, 300).unwrap();
        let rows = |y: u32| (0..512).map(move |x| [x as f32, y as f32, 0.0]);
        let rgb: Vec<_> = (0..300).flat_map(rows).collect();
        let whole = TilePixels {
            region: Region::full(512, 300),
            rgb: &rgb,
            layers: &[],
        };
        assert!(buffer.accept(&whole).is_some());
        let mut pieces = 0;
        let whole = buffer.read(0, |_| {
            assert!(buffer.state.try_lock().is_ok());
            pieces += 1;
        });
        assert!(whole.is_some() && pieces > 3);
        assert_eq!(buffer.image().pixels, rgb);
        assert!(buffer.read(1, |_| {}).is_none(), "there is no layer");
    }

    #[test]
    fn a_part_of_a_picture_holds_no_more_than_its_pixels() {
        let region = Region {
            x: 40,
            y: 10,
            width: 30,
            height: 20,
        };
        let of = [100, 80];
        let part = Part { region, of };
        let buffer = PictureBuffer::new(part, Vec::new(), Display::default()).unwrap();
        assert_eq!(buffer.bytes(), 30 * 20 * 12);
        let at = Region {
            x: 64,
            y: 26,
            width: 6,
            height: 4,
        };
        let (at, rgb) = tile(at, 1.0);
        let whole = TilePixels {
            region: at,
            rgb: &rgb,
            layers: &[],
        };
        let encoded = buffer.accept(&whole).unwrap();
        assert_eq!(encoded.position, [24, 16]);
        assert_eq!(buffer.image().pixel(24, 16), [1.0; 3]);
        assert_eq!(buffer.image().pixel(23, 16), [0.0; 3]);
        // Columns and rows are those of the picture.
        let linear = |pixel| buffer.values_at(pixel).map(|values| values.linear);
        assert_eq!(linear([69, 29]), Some([1.0; 3]));
        assert_eq!(linear([63, 29]), Some([0.0; 3]));
        for outside in [[39, 20], [50, 9], [70, 20], [50, 30]] {
            assert_eq!(linear(outside), None);
        }
    }

    #[test]
    fn layers_are_shown_in_place_of_the_picture() {
        let layers = vec![Layer::Emission, Layer::Shadow];
        let buffer = PictureBuffer::new(Part::whole([16, 16]), layers, Display::default()).unwrap();
        let (region, rgb) = tile(Region::full(16, 16), 0.25);
        let layers = [tile(region, 0.0).1, tile(region, 1.0).1];
        let whole = TilePixels {
            region,
            rgb: &rgb,
            layers: &layers,
        };
        buffer.set_shown(Some(Layer::Shadow));
        let shown = buffer.accept(&whole).unwrap();
        assert_eq!(shown.pixels.pixels[0], Color32::WHITE);
        // The coarse picture has none, so the layer on the screen stays as it was.
        let coarse = CoarsePicture {
            region,
            side: 16,
            rgb: vec![[0.5; 3]],
        };
        assert!(buffer.accept_coarse(&coarse).is_none());
        assert_eq!(buffer.image().pixel(15, 15), [0.5; 3]);
        buffer.set_shown(None);
        let texels = buffer.accept_coarse(&coarse).unwrap();
        assert_eq!(texels.pixels.size, [1, 1]);
        assert_eq!(texels.share, Vec2::splat(1.0));
        buffer.set_shown(Some(Layer::Ambient));
        assert_ne!(
            buffer.accept(&whole).unwrap().pixels.pixels[0],
            Color32::WHITE
        );
        assert_eq!(buffer.layer_images()[1].1.pixel(3, 3), [1.0; 3]);
    }

    #[test]
    fn the_error_is_shown_by_a_scale_of_its_own() {
        let layers = vec![Layer::Shadow, Layer::Error];
        let buffer = PictureBuffer::new(Part::whole([16, 16]), layers, Display::default()).unwrap();
        buffer.set_shown(Some(Layer::Error));
        assert!(buffer.shows_error());
        assert_eq!(buffer.shown_error_scale(), None);
        let kept = |buffer: &PictureBuffer| buffer.layer_images().into_iter().map(|it| it.0);
        assert!(kept(&buffer).eq([Layer::Shadow]), "no error is known yet");
        let mut errors = Image {
            width: 16,
            height: 16,
            pixels: vec![[0.001; 3]; 256],
        };
        errors.pixels[0] = [0.0; 3];
        buffer.set_error(errors);
        assert!(kept(&buffer).eq([Layer::Shadow, Layer::Error]));
        assert_eq!(buffer.shown_error_scale(), Some(0.001));
        let mut shown = Vec::new();
        buffer.encode_all(&CancelToken::new(), |encoded| {
            if let Encoded::Tile(piece) = encoded {
                shown.push(piece);
            }
        });
        let colors = &shown[0].pixels.pixels;
        assert_eq!(colors[0], crate::gui::error_colors::color([0.0; 3], 1.0));
        assert_eq!(colors[1], crate::gui::error_colors::color([1.0; 3], 1.0));

        // Tiles bring no error, so what is on the screen stays.
        let (region, rgb) = tile(Region::full(16, 16), 0.25);
        let layers = [tile(region, 1.0).1];
        let whole = TilePixels {
            region,
            rgb: &rgb,
            layers: &layers,
        };
        assert!(buffer.accept(&whole).is_none());
        assert_eq!(buffer.layer_images()[1].1.pixel(1, 0), [0.001; 3]);
        buffer.set_shown(None);
        assert_eq!(buffer.shown_error_scale(), None);
    }

    #[test]
    fn layers_are_given_up_and_the_picture_stays() {
        let layers = vec![Layer::Emission, Layer::Error];
        let buffer = PictureBuffer::new(Part::whole([16, 16]), layers, Display::default()).unwrap();
        buffer.set_shown(Some(Layer::Error));
        assert_eq!(buffer.layer_images().len(), 1);
        let bytes = buffer.bytes();
        assert_eq!(buffer.take_layers().len(), 2);
        assert_eq!(buffer.bytes(), bytes / 3);
        assert!(buffer.layers().is_empty() && buffer.layer_images().is_empty());
        assert!(!buffer.shows_error());
        buffer.set_error(Image::black(16, 16));
        buffer.set_shown(Some(Layer::Emission));
        assert!(buffer.shown_error_scale().is_none());
    }

    #[test]
    fn a_picture_no_memory_holds_is_refused() {
        if usize::BITS == 64 {
            assert!(buffer(u32::MAX, u32::MAX).is_none());
        }
    }
}

use super::Choice;

/// What to compute. How to run it (threads, cancelling) is `render::RunConfig`.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// What a pixel holds.
    pub mode: Mode,
    /// Picture width in pixels, `1..=`[`RenderSettings::MAX_SIDE`].
    pub width: u32,
    /// Picture height in pixels, `1..=`[`RenderSettings::MAX_SIDE`].
    pub height: u32,
    /// Camera rays per pixel, at least 1.
    pub samples_per_pixel: u32,
    /// Start of every random sequence; the same seed gives the same picture.
    pub seed: u64,
    /// How lights cast shadows.
    pub shadows: Shadows,
    /// Whether samples spread over the pixel, or all sit at its centre.
    pub antialiasing: bool,
    /// Which Phong formula shades.
    pub phong: PhongModel,
    /// Which structure finds the hits; it never changes the picture.
    pub accelerator: AcceleratorChoice,
}

impl RenderSettings {
    /// Largest width or height of a picture.
    pub const MAX_SIDE: u32 = 65_536;
    /// Largest seed a scene file can hold.
    pub const MAX_SEED: u64 = i64::MAX as u64;
    /// Most pixels of a picture: 16,384².
    pub const MAX_PIXELS: u64 = 1 << 28;
    /// Most samples a pixel can get.
    pub const MAX_SAMPLES: u32 = 1 << 24;

    /// Pixels of the picture.
    #[must_use]
    pub fn pixel_count(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            mode: Mode::Direct,
            width: 640,
            height: 480,
            samples_per_pixel: 16,
            seed: 0,
            shadows: Shadows::Soft,
            antialiasing: true,
            phong: PhongModel::Modified,
            accelerator: AcceleratorChoice::Auto,
        }
    }
}

/// What a pixel holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Mode {
    /// Direct light of every light with its shadows, and the background's light.
    #[default]
    Direct,
    /// Shading normals: `(n + 1) / 2` of the unit normal that faces the camera's side; background black.
    Normals,
    /// Distance from the eye in scene units in every channel; 0 where nothing is hit.
    Depth,
    /// Diffuse plus specular reflectance; background black.
    Albedo,
    /// Green where the front of a triangle is seen, red where its back is; both by the cosine to the viewer.
    Facing,
    /// One colour per object.
    Object,
}

impl Choice for Mode {
    const ALL: &'static [(Self, &'static str)] = &[
        (Self::Direct, "direct"),
        (Self::Normals, "normals"),
        (Self::Depth, "depth"),
        (Self::Albedo, "albedo"),
        (Self::Facing, "facing"),
        (Self::Object, "object"),
    ];
}

/// How lights cast shadows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Shadows {
    /// No shadow: light passes through everything.
    Off,
    /// From the light's centre, with a sharp edge.
    Hard,
    /// From the light's whole surface. Point lights have none: their shadows stay hard.
    #[default]
    Soft,
}

impl Choice for Shadows {
    const ALL: &'static [(Self, &'static str)] = &[
        (Self::Off, "off"),
        (Self::Hard, "hard"),
        (Self::Soft, "soft"),
    ];
}

/// Which Phong formula shades.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum PhongModel {
    /// Physically based, energy conserving: `(kd/π + ks (s+2)/(2π) cosˢα) · cos θ`.
    #[default]
    Modified,
    /// The formula of 2011: `kd cos θ + ks cosˢα`, in place of the whole product.
    Classic,
}

impl Choice for PhongModel {
    const ALL: &'static [(Self, &'static str)] =
        &[(Self::Modified, "modified"), (Self::Classic, "classic")];
}

/// Which structure finds the hits. All give the same picture, bit for bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum AcceleratorChoice {
    /// The fastest there is for the scene.
    #[default]
    Auto,
    /// A tree of axis-aligned planes.
    KdTree,
    /// Every triangle for every ray: the reference.
    BruteForce,
}

impl Choice for AcceleratorChoice {
    const ALL: &'static [(Self, &'static str)] = &[
        (Self::Auto, "auto"),
        (Self::KdTree, "kd-tree"),
        (Self::BruteForce, "brute-force"),
    ];
}

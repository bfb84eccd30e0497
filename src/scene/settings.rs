//! What a render computes, with defaults and limits. How it is run, on how many threads and until when, is `render::RunConfig`.

use super::Choice;

/// What to compute. How to run it (threads, cancelling) is `render::RunConfig`.
#[derive(Clone, Debug, PartialEq)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "effects are independent switches"
)]
pub struct RenderSettings {
    /// What a pixel holds.
    pub mode: Mode,
    /// Picture width in pixels, `1..=`[`RenderSettings::MAX_SIDE`].
    pub width: u32,
    /// Picture height in pixels, `1..=`[`RenderSettings::MAX_SIDE`].
    pub height: u32,
    /// Camera rays per pixel, at least 1; the most a pixel gets where [`Self::stop`] says when to end.
    pub samples_per_pixel: u32,
    /// When to end before every pixel has [`Self::samples_per_pixel`].
    pub stop: Stop,
    /// Whether a render that may stop early gives more samples to pixels where the error is larger.
    pub adaptive: bool,
    /// Whether the error is estimated. It takes 40 bytes per pixel, and never changes the picture by itself.
    pub error_estimate: bool,
    /// Start of every random sequence; the same seed gives the same picture.
    pub seed: u64,
    /// How random numbers are spread.
    pub sampler: SamplerChoice,
    /// Most scattering events of a path: 0 shows emission alone, 1 direct light, each mirror or boundary of glass takes one
    /// more.
    pub max_bounces: u32,
    /// In mode `path`: whether paths that carry little may end early, at random, without bias.
    pub roulette: bool,
    /// In mode `path`: how light is found.
    pub light_sampling: LightSampling,
    /// How samples spread over and around the pixel.
    pub filter: Filter,
    /// How lights cast shadows.
    pub shadows: Shadows,
    /// Shadow rays to each light with area, per camera sample, at least 1. Of more than 32 lights, mode `direct` chooses eight times
    /// this number, points too.
    pub shadow_samples: u32,
    /// Darkening of the background's light where surfaces are near.
    pub ambient_occlusion: AmbientOcclusion,
    /// Whether mirrors reflect; grey otherwise.
    pub mirror: bool,
    /// Whether glass reflects and refracts; grey otherwise.
    pub glass: bool,
    /// Whether the lens blurs what is out of focus.
    pub depth_of_field: bool,
    /// Whether samples spread over the pixel, or all sit at its centre, where a single one always sits.
    pub antialiasing: bool,
    /// Which Phong formula shades.
    pub phong: PhongModel,
    /// The most radiance a camera sample may bring in its brightest channel, more than 0; `None` for no limit. It takes away
    /// bright specks and, with them, energy, which the render's statistics report.
    pub clamp: Option<f64>,
    /// Which structure finds the hits; it never changes the picture.
    pub accelerator: AcceleratorChoice,
    /// How carefully the wide tree is built; it never changes the picture.
    pub accelerator_build: AcceleratorBuild,
}

impl RenderSettings {
    /// Largest width or height of a picture.
    pub const MAX_SIDE: u32 = 65_536;
    /// Most scattering events of a path.
    pub const MAX_BOUNCES: u32 = 1 << 20;
    /// Most shadow or occlusion rays per camera sample.
    pub const MAX_RAYS_PER_SAMPLE: u32 = 1 << 16;
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

    /// Whether the error is measured: where it is asked for, and there are two samples to differ.
    #[must_use]
    pub fn measures_error(&self) -> bool {
        self.error_estimate && self.samples_per_pixel > 1
    }
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            mode: Mode::Direct,
            width: 640,
            height: 480,
            samples_per_pixel: 16,
            stop: Stop::default(),
            adaptive: true,
            error_estimate: true,
            seed: 0,
            sampler: SamplerChoice::Sobol,
            max_bounces: 8,
            roulette: true,
            light_sampling: LightSampling::Mis,
            filter: Filter::Box,
            shadows: Shadows::Soft,
            shadow_samples: 1,
            ambient_occlusion: AmbientOcclusion::default(),
            mirror: true,
            glass: true,
            depth_of_field: true,
            antialiasing: true,
            phong: PhongModel::Modified,
            clamp: None,
            accelerator: AcceleratorChoice::Auto,
            accelerator_build: AcceleratorBuild::Best,
        }
    }
}

/// When a render ends early: whichever comes first.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Stop {
    /// After so many seconds of rendering, more than 0.
    pub seconds: Option<f64>,
    /// When the noise, √relmse of the whole picture, is estimated to be at most this, more than 0: 0.03 is 3 %.
    pub noise: Option<f64>,
    /// After so many passes, at least 1: what reproduces a picture that the clock ended.
    pub passes: Option<u32>,
}

/// Ambient occlusion: the background's light reaches a surface where nothing is near.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AmbientOcclusion {
    /// Whether it is looked for; in mode `ao` it always is.
    pub enabled: bool,
    /// Rays per camera sample, at least 1.
    pub samples: u32,
    /// How near a surface must be to block, as a fraction of the scene's diagonal, more than 0.
    pub radius: f64,
}

impl Default for AmbientOcclusion {
    fn default() -> Self {
        Self {
            enabled: false,
            samples: 64,
            radius: 0.05,
        }
    }
}

/// How the random numbers of a pixel are spread. The picture that is approached is the same; the noise on the way is not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum SamplerChoice {
    /// Evenly, as a scrambled Sobol sequence: the error falls faster than 1/√n.
    #[default]
    Sobol,
    /// Each without regard to the others, as in a plain Monte Carlo method: the error falls as 1/√n. It is there to compare with.
    Independent,
}

impl Choice for SamplerChoice {
    const ALL: &'static [(Self, &'static str)] =
        &[(Self::Sobol, "sobol"), (Self::Independent, "independent")];
}

/// How path tracing finds light. All find the same light; they differ in noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum LightSampling {
    /// Both ways, weighted by how likely each was to find it (multiple importance sampling).
    #[default]
    Mis,
    /// By aiming at lights (next event estimation). What only mirrors or glass show is still met by chance.
    Nee,
    /// By scattering and meeting lights by chance; point lights are still aimed at.
    Bsdf,
}

impl Choice for LightSampling {
    const ALL: &'static [(Self, &'static str)] =
        &[(Self::Mis, "mis"), (Self::Nee, "nee"), (Self::Bsdf, "bsdf")];
}

/// The weight with which a pixel sees what is around it. Samples are placed by the weight, so each counts the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Filter {
    /// Even over the pixel.
    #[default]
    Box,
    /// Falling linearly to 0 one pixel from the centre.
    Tent,
    /// A normal distribution of standard deviation half a pixel, cut at two pixels.
    Gaussian,
}

impl Choice for Filter {
    const ALL: &'static [(Self, &'static str)] = &[
        (Self::Box, "box"),
        (Self::Tent, "tent"),
        (Self::Gaussian, "gaussian"),
    ];
}

/// What a pixel holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Mode {
    /// Direct light of every light with its shadows, and the background's light.
    #[default]
    Direct,
    /// All light, up to [`RenderSettings::max_bounces`].
    Path,
    /// Visible fraction of the hemisphere within the occlusion radius, weighted by the cosine: white is free.
    Ao,
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
    /// How much of the structure the ray from the eye visits, nodes and blocks of triangles together, by colours from black over red and
    /// yellow to white at 255. Unlike all others, it depends on [`RenderSettings::accelerator`].
    Steps,
}

impl Mode {
    /// Whether a pixel holds light, rather than a false colour.
    #[must_use]
    pub const fn shows_light(self) -> bool {
        matches!(self, Self::Direct | Self::Path)
    }
}

impl Choice for Mode {
    const ALL: &'static [(Self, &'static str)] = &[
        (Self::Direct, "direct"),
        (Self::Path, "path"),
        (Self::Ao, "ao"),
        (Self::Normals, "normals"),
        (Self::Depth, "depth"),
        (Self::Albedo, "albedo"),
        (Self::Facing, "facing"),
        (Self::Object, "object"),
        (Self::Steps, "steps"),
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
    /// The rule of 2011: what a light's centre would give, times the share of the light that is seen. Biased, since light
    /// that reaches a surface from the rim counts as if it came from the centre.
    Fraction,
}

impl Choice for Shadows {
    const ALL: &'static [(Self, &'static str)] = &[
        (Self::Off, "off"),
        (Self::Hard, "hard"),
        (Self::Soft, "soft"),
        (Self::Fraction, "fraction"),
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
    /// The wide tree: the fastest on meshes, and nearly so on soups of thin triangles.
    #[default]
    Auto,
    /// A tree of boxes, eight to a node.
    Wide,
    /// A tree of axis-aligned planes.
    KdTree,
    /// Every triangle for every ray: the reference.
    BruteForce,
}

impl Choice for AcceleratorChoice {
    const ALL: &'static [(Self, &'static str)] = &[
        (Self::Auto, "auto"),
        (Self::Wide, "wide"),
        (Self::KdTree, "kd-tree"),
        (Self::BruteForce, "brute-force"),
    ];
}

/// How carefully the wide tree is built. Both give the same picture, bit for bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum AcceleratorBuild {
    /// For the fastest rays.
    #[default]
    Best,
    /// In about two thirds of the time on meshes and a fifth on soups of thin triangles, where its rays take half as long again.
    Fast,
}

impl Choice for AcceleratorBuild {
    const ALL: &'static [(Self, &'static str)] = &[(Self::Best, "best"), (Self::Fast, "fast")];
}

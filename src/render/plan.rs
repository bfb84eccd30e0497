//! What a render does, and what it leaves out because the scene does not need it.

use crate::scene::{
    Background, Camera, Light, LightSampling, Material, Mode, RenderSettings, Rgb, Scene,
    SceneError, Shadows,
};

/// Work that a scene may not need. Where it does not, the picture is the same with and without.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// A point of its own in the pixel for every sample.
    PixelPoints,
    /// A point on the lens.
    Lens,
    /// Looking for light at all.
    Light,
    /// Aiming at lights and emitters, or at an image of the sky.
    Aiming,
    /// Rays that ask what is in the way to a light.
    ShadowRays,
    /// A point on each light for every ray.
    LightPoints,
    /// Shadow rays that go through glass, and so must look for what is nearest.
    GlassShadows,
    /// Looking into the hemisphere, for occlusion or the light of an image of the sky.
    Occlusion,
    /// Rays after the last surface of a path, for the light that they meet.
    LastRays,
    /// Ending paths that carry little.
    Roulette,
    /// Rays that can bring nothing: to lights behind a surface, to black lights, from black surfaces.
    DarkRays,
}

impl Feature {
    /// All, as a sample comes to them.
    pub const ALL: [Self; 11] = [
        Self::PixelPoints,
        Self::Lens,
        Self::Light,
        Self::Aiming,
        Self::ShadowRays,
        Self::LightPoints,
        Self::GlassShadows,
        Self::Occlusion,
        Self::LastRays,
        Self::Roulette,
        Self::DarkRays,
    ];

    /// What is done wherever it is.
    fn takes(self) -> &'static [Self] {
        match self {
            Self::PixelPoints | Self::Lens | Self::Light => &[],
            Self::Aiming | Self::Occlusion | Self::LastRays | Self::Roulette => &[Self::Light],
            Self::ShadowRays | Self::LightPoints => &[Self::Light, Self::Aiming],
            Self::GlassShadows => &[Self::Light, Self::Aiming, Self::ShadowRays],
            Self::DarkRays => &[
                Self::Light,
                Self::Aiming,
                Self::ShadowRays,
                Self::Occlusion,
                Self::LastRays,
            ],
        }
    }

    /// In words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::PixelPoints => "points within a pixel",
            Self::Lens => "points on a lens",
            Self::Light => "looking for light",
            Self::Aiming => "aiming at lights",
            Self::ShadowRays => "shadow rays",
            Self::LightPoints => "points on lights",
            Self::GlassShadows => "light through glass",
            Self::Occlusion => "looking into the hemisphere",
            Self::LastRays => "rays after the last surface",
            Self::Roulette => "roulette",
            Self::DarkRays => "rays that bring nothing",
        }
    }
}

/// Several features.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Features(u32);

impl Features {
    const ALL: Self = Self((1 << Feature::ALL.len()) - 1);

    const fn with(self, feature: Feature) -> Self {
        Self(self.0 | 1 << feature as u32)
    }

    const fn has(self, feature: Feature) -> bool {
        self.0 >> feature as u32 & 1 == 1
    }
}

/// What a render does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    needed: Features,
    /// What is done although it is not needed, to measure what leaving it out saves.
    forced: Features,
}

impl Plan {
    /// What `scene` needs.
    ///
    /// # Errors
    /// When an object has a material that there is not.
    pub fn of(scene: &Scene) -> Result<Self, SceneError> {
        let needed = reasons(scene)?
            .into_iter()
            .filter(|(_, reason)| reason.is_none());
        Ok(Self {
            needed: needed.fold(Features::default(), |all, (feature, _)| all.with(feature)),
            forced: Features::default(),
        })
    }

    /// Whether the picture needs it.
    #[must_use]
    pub const fn needs(self, feature: Feature) -> bool {
        self.needed.has(feature)
    }

    /// Whether it is done, needed or not.
    #[must_use]
    pub const fn does(self, feature: Feature) -> bool {
        self.needed.has(feature) || self.forced.has(feature)
    }

    /// Whether it is done where it is not needed.
    #[must_use]
    pub const fn forces(self, feature: Feature) -> bool {
        self.forced.has(feature)
    }

    /// The same, and `feature` with all that it takes, whether needed or not.
    #[must_use]
    pub fn forcing(self, feature: Feature) -> Self {
        let with = feature.takes().iter().copied().chain([feature]);
        Self {
            forced: with.fold(self.forced, Features::with),
            ..self
        }
    }

    /// The same, and everything that is not needed.
    #[must_use]
    pub const fn forcing_everything(self) -> Self {
        Self {
            forced: Features::ALL,
            ..self
        }
    }
}

/// All features, and why a render of `scene` leaves each out; `None` where it is needed.
///
/// # Errors
/// When an object has a material that there is not.
pub fn reasons(
    scene: &Scene,
) -> Result<[(Feature, Option<&'static str>); Feature::ALL.len()], SceneError> {
    let facts = Facts::of(scene)?;
    Ok(Feature::ALL.map(|feature| (feature, facts.reason_against(feature))))
}

/// What of a scene decides about its plan.
struct Facts<'a> {
    settings: &'a RenderSettings,
    camera: &'a Camera,
    background: &'a Background,
    /// Of objects that have triangles, as the settings leave them.
    has_diffuse: bool,
    has_glass: bool,
    has_emitter: bool,
    /// Of lights that shine.
    has_light: bool,
    has_light_with_area: bool,
    /// That rays can meet, and that they cannot.
    has_visible_light: bool,
    has_unmet_light: bool,
}

impl<'a> Facts<'a> {
    fn of(scene: &'a Scene) -> Result<Self, SceneError> {
        let settings = &scene.render;
        let there = scene
            .objects
            .iter()
            .filter(|object| scene.has_triangles(object));
        let materials: Vec<Material> = there
            .map(|object| scene.material_of(object))
            .collect::<Result<_, _>>()?;
        let has = |is: &dyn Fn(&Material) -> bool| materials.iter().any(is);
        let shining = || scene.lights.iter().filter(|light| light.shines());
        Ok(Self {
            settings,
            camera: &scene.camera,
            background: &scene.background,
            has_diffuse: has(&|material| match material {
                Material::Phong { diffuse, .. } => *diffuse != Rgb::ZERO,
                // Grey, where they are switched off.
                Material::Mirror { .. } => !settings.mirror,
                Material::Glass { .. } => !settings.glass,
                Material::Emitter { .. } => false,
            }),
            has_glass: settings.glass
                && has(&|material| matches!(material, Material::Glass { .. })),
            has_emitter: has(
                &|material| matches!(material, Material::Emitter { radiance } if *radiance != Rgb::ZERO),
            ),
            has_light: shining().next().is_some(),
            has_light_with_area: shining().any(Light::has_area),
            has_visible_light: shining().any(Light::is_visible),
            has_unmet_light: shining().any(|light| !light.is_visible()),
        })
    }

    /// Why the feature is not needed; `None` where it is.
    fn reason_against(&self, feature: Feature) -> Option<&'static str> {
        let settings = self.settings;
        let (is_path, is_direct) = (settings.mode == Mode::Path, settings.mode == Mode::Direct);
        let shows_light = is_path || is_direct;
        // The first that holds is the reason.
        let reasons: &[(bool, &'static str)] = match feature {
            Feature::PixelPoints => &[
                (
                    settings.samples_per_pixel == 1,
                    "one sample per pixel takes the middle",
                ),
                (!settings.antialiasing, "render.antialiasing is off"),
            ],
            Feature::Lens => &[
                (
                    self.camera.aperture_radius == 0.0,
                    "camera.aperture_radius is 0",
                ),
                (!settings.depth_of_field, "render.depth_of_field is off"),
            ],
            Feature::Light => &[
                (!shows_light, "the mode shows no light"),
                (
                    !self.has_light && !self.has_emitter && self.background.is_black(),
                    "nothing shines",
                ),
            ],
            Feature::Aiming => &[
                (!shows_light, "the mode shows no light"),
                (
                    is_path
                        && settings.light_sampling == LightSampling::Bsdf
                        && !self.has_unmet_light,
                    "render.light_sampling is bsdf",
                ),
                (
                    !self.has_light && !self.has_emitter && !(is_path && self.has_sky_image()),
                    "no light or emitter shines",
                ),
            ],
            Feature::ShadowRays => &[
                (
                    self.reason_against(Feature::Aiming).is_some(),
                    "there is nothing to aim at",
                ),
                (
                    is_direct && settings.shadows == Shadows::Off,
                    "render.shadows is off",
                ),
            ],
            Feature::LightPoints => &[
                (
                    self.reason_against(Feature::Aiming).is_some(),
                    "there is nothing to aim at",
                ),
                (
                    is_direct && settings.shadows == Shadows::Hard && !self.has_emitter,
                    "render.shadows is hard",
                ),
                (
                    !self.has_light_with_area && !self.has_emitter && !self.has_sky_image(),
                    "no light has an area",
                ),
            ],
            Feature::GlassShadows => &[
                (
                    !is_direct,
                    "only mode direct lets light straight through glass",
                ),
                (!self.has_glass, "nothing is of glass"),
                (
                    self.reason_against(Feature::ShadowRays).is_some(),
                    "there are no shadow rays",
                ),
            ],
            Feature::Occlusion => &[
                (
                    settings.mode != Mode::Ao && !is_direct,
                    "the mode has no ambient light",
                ),
                (
                    is_direct && self.background.is_black(),
                    "the background is black",
                ),
                (is_direct && !self.has_diffuse, "nothing reflects diffusely"),
                (
                    is_direct && !settings.ambient_occlusion.enabled && !self.has_sky_image(),
                    "render.ambient_occlusion is off",
                ),
            ],
            Feature::LastRays => &[
                (!is_path, "only paths have them"),
                (
                    !self.has_emitter && !self.has_visible_light && self.background.is_black(),
                    "nothing that shines can be met",
                ),
                // A background that is no image is not aimed at.
                (
                    settings.light_sampling == LightSampling::Nee
                        && (self.has_sky_image() || self.background.is_black()),
                    "render.light_sampling is nee",
                ),
            ],
            Feature::Roulette => &[
                (!is_path, "only paths end by it"),
                (
                    self.reason_against(Feature::Light).is_some(),
                    "there are no paths",
                ),
                (!settings.roulette, "render.roulette is off"),
                (
                    settings.max_bounces < super::path::ROULETTE_FROM,
                    "render.max_bounces ends paths before",
                ),
            ],
            Feature::DarkRays => &[(true, "known before they are traced")],
        };
        let first = reasons.iter().find(|(holds, _)| *holds);
        first.map(|(_, reason)| *reason)
    }

    fn has_sky_image(&self) -> bool {
        matches!(self.background, Background::Image { .. })
    }
}

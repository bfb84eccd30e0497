//! What a render does, and what it leaves out because the scene does not need it.

use super::geometry::is_nothing;
use crate::scene::{
    Camera, Light, LightSampling, Material, Mode, Object, RenderSettings, Rgb, Scene, SceneError,
    Shadows,
};

/// Work that a scene may not need. Where it does not, the picture is the same with and without.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// A point of its own in the pixel for every sample.
    PixelPoints,
    /// A point on the lens.
    Lens,
    /// A ray from the eye for every sample of a pixel.
    EyeRays,
    /// Looking for light at all.
    Light,
    /// Aiming at lights and emitters, or at an image of the sky.
    Aiming,
    /// Rays that ask what is in the way to a light.
    ShadowRays,
    /// A point on a light for every ray to it.
    LightPoints,
    /// Shadow rays that go through glass, and so must look for what is nearest.
    GlassShadows,
    /// Looking into the hemisphere, for occlusion or the light of an image of the sky.
    Occlusion,
    /// Rays after the last surface of a path, for the light that they meet.
    LastRays,
    /// Ending paths that carry little.
    Roulette,
    /// Looking up what varies over surfaces: on images, or between the colours of vertices.
    Textures,
    /// Rays that can bring nothing: to lights behind a surface, to black lights, from black surfaces.
    DarkRays,
}

impl Feature {
    /// All, as a sample comes to them.
    pub const ALL: [Self; 13] = [
        Self::PixelPoints,
        Self::Lens,
        Self::EyeRays,
        Self::Light,
        Self::Aiming,
        Self::ShadowRays,
        Self::LightPoints,
        Self::GlassShadows,
        Self::Occlusion,
        Self::LastRays,
        Self::Roulette,
        Self::Textures,
        Self::DarkRays,
    ];

    /// Whether rendering in `mode` knows it.
    #[must_use]
    pub fn is_of(self, mode: Mode) -> bool {
        let is_direct = mode == Mode::Direct;
        let is_path = mode == Mode::Path;
        match self {
            Self::PixelPoints | Self::Lens | Self::EyeRays | Self::Textures => true,
            Self::Light | Self::Aiming | Self::LightPoints | Self::DarkRays => is_direct || is_path,
            Self::ShadowRays | Self::GlassShadows => is_direct,
            Self::Occlusion => is_direct || mode == Mode::Ao,
            Self::LastRays | Self::Roulette => is_path,
        }
    }

    /// The features that are done wherever this one is.
    fn takes(self) -> &'static [Self] {
        match self {
            Self::EyeRays | Self::Light | Self::Textures => &[],
            // Of its own for every sample.
            Self::PixelPoints | Self::Lens => &[Self::EyeRays],
            Self::Aiming | Self::Occlusion | Self::LastRays | Self::Roulette => &[Self::Light],
            Self::ShadowRays | Self::LightPoints => &[Self::Light, Self::Aiming],
            Self::GlassShadows => &[Self::Light, Self::Aiming, Self::ShadowRays],
            Self::DarkRays => &[Self::Light, Self::Aiming, Self::ShadowRays, Self::LastRays],
        }
    }

    /// In words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::PixelPoints => "points within a pixel",
            Self::Lens => "points on a lens",
            Self::EyeRays => "an eye ray for every sample",
            Self::Light => "looking for light",
            Self::Aiming => "aiming at lights",
            Self::ShadowRays => "shadow rays",
            Self::LightPoints => "points on lights",
            Self::GlassShadows => "light through glass",
            Self::Occlusion => "looking into the hemisphere",
            Self::LastRays => "rays after the last surface",
            Self::Roulette => "roulette",
            Self::Textures => "coordinates of textures",
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
    /// When an object has a material that there is not, or the background an image that was not loaded.
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

    /// Whether it is done even if it is not needed.
    #[must_use]
    pub const fn forces(self, feature: Feature) -> bool {
        self.forced.has(feature)
    }

    /// The same plan, except that `feature` is done with all that it takes, whether needed or not.
    #[must_use]
    pub fn forcing(self, feature: Feature) -> Self {
        let with = feature.takes().iter().copied().chain([feature]);
        Self {
            forced: with.fold(self.forced, Features::with),
            ..self
        }
    }

    /// The same plan, except that everything is done, needed or not.
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
/// When an object has a material that there is not, or the background an image that was not loaded.
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
    is_background_black: bool,
    /// Whether the background is an image that gives light.
    has_sky_image: bool,
    /// Of objects that are there.
    materials: Vec<Material>,
    /// Whether something varies over one of these objects.
    is_textured: bool,
    /// Those that shine.
    lights: Vec<&'a Light>,
}

/// Reasons to leave something out, and whether each holds; the first that does is told.
type Reasons<'a> = &'a [(bool, &'static str)];

fn first_of(reasons: Reasons<'_>) -> Option<&'static str> {
    let first = reasons.iter().find(|(holds, _)| *holds);
    first.map(|(_, reason)| *reason)
}

impl<'a> Facts<'a> {
    fn of(scene: &'a Scene) -> Result<Self, SceneError> {
        let is_textured = |object: &Object| {
            let material = scene.material_of(object).ok();
            let mesh = scene.meshes.get(&object.mesh);
            material.zip(mesh).is_some_and(|(material, mesh)| {
                let textures = material.textures();
                textures.is_some_and(|textures| textures.vary_over(mesh))
            })
        };
        let objects = scene.objects.iter();
        let solid = objects.filter(|object| scene.has_triangles(object));
        let materials = solid.map(|object| scene.material_of(object));
        let mut materials: Vec<_> = materials.collect::<Result<_, _>>()?;
        materials.retain(|material| !is_nothing(material, &scene.render));
        let image = scene.background_image()?;
        let is_background_black =
            scene.background.is_black() || image.is_some_and(|image| image.is_black());
        Ok(Self {
            settings: &scene.render,
            camera: &scene.camera,
            is_background_black,
            is_textured: scene.objects.iter().any(is_textured),
            has_sky_image: image.is_some() && !is_background_black,
            materials,
            lights: scene.lights.iter().filter(|light| light.shines()).collect(),
        })
    }

    /// Why the feature is not needed; `None` where it is.
    fn reason_against(&self, feature: Feature) -> Option<&'static str> {
        let settings = self.settings;
        match feature {
            Feature::PixelPoints => first_of(&[
                (
                    settings.samples_per_pixel == 1,
                    "one sample per pixel takes the middle",
                ),
                (!settings.antialiasing, "render.antialiasing is off"),
            ]),
            Feature::Lens => first_of(&[
                (
                    self.camera.aperture_radius == 0.0,
                    "camera.aperture_radius is 0",
                ),
                (!settings.depth_of_field, "render.depth_of_field is off"),
            ]),
            Feature::EyeRays => first_of(&[
                (settings.samples_per_pixel == 1, "there is one sample"),
                (
                    self.reason_against(Feature::PixelPoints).is_some()
                        && self.reason_against(Feature::Lens).is_some(),
                    "all samples of a pixel look along one line",
                ),
            ]),
            Feature::Light => first_of(&[
                (!settings.mode.shows_light(), "the mode shows no light"),
                (
                    !self.has_source() && self.is_background_black,
                    "nothing shines",
                ),
            ]),
            Feature::Aiming
            | Feature::ShadowRays
            | Feature::LightPoints
            | Feature::GlassShadows => self.reason_against_aiming(feature),
            Feature::Occlusion => first_of(&[
                (
                    settings.mode != Mode::Ao && !self.is_direct(),
                    "the mode has no ambient light",
                ),
                (self.materials.is_empty(), "nothing is there"),
                (
                    self.is_direct() && settings.max_bounces == 0,
                    "render.max_bounces is 0",
                ),
                (
                    self.is_direct() && self.is_background_black,
                    "the background is black",
                ),
                (
                    self.is_direct() && !self.has_diffuse(),
                    "nothing reflects diffusely",
                ),
                (
                    self.is_direct() && !settings.ambient_occlusion.enabled && !self.has_sky_image,
                    "render.ambient_occlusion is off",
                ),
            ]),
            Feature::LastRays | Feature::Roulette => self.reason_against_in_paths(feature),
            Feature::Textures => first_of(&[
                (!self.is_textured, "no object has a texture"),
                (
                    matches!(settings.mode, Mode::Depth | Mode::Object),
                    "the mode shows none",
                ),
            ]),
            Feature::DarkRays => Some("known before they are traced"),
        }
    }

    fn reason_against_aiming(&self, feature: Feature) -> Option<&'static str> {
        let settings = self.settings;
        if !settings.mode.shows_light() {
            return Some("the mode shows no light");
        }
        if feature != Feature::Aiming && self.reason_against(Feature::Aiming).is_some() {
            return Some("nothing is aimed at");
        }
        match feature {
            Feature::Aiming => first_of(&[
                (
                    !(self.has_source() || self.is_path() && self.has_sky_image),
                    "no light or emitter shines",
                ),
                (!self.has_scatterer(), "nothing scatters light"),
                (settings.max_bounces == 0, "render.max_bounces is 0"),
                (
                    self.is_path()
                        && settings.light_sampling == LightSampling::Bsdf
                        && self.lights.iter().all(|light| light.is_visible()),
                    "render.light_sampling is bsdf",
                ),
            ]),
            Feature::ShadowRays => first_of(&[(
                self.is_direct() && settings.shadows == Shadows::Off,
                "render.shadows is off",
            )]),
            Feature::LightPoints => first_of(&[
                (
                    self.is_direct() && settings.shadows == Shadows::Hard,
                    "render.shadows is hard",
                ),
                (
                    self.is_direct() && !self.lights.iter().any(|light| light.has_area()),
                    "no light has an area",
                ),
                // The number that finds the point chooses among lights too.
                (
                    self.is_path() && self.aims_at_one_point(),
                    "there is one light, and it is a point",
                ),
            ]),
            _ => first_of(&[
                (
                    !self.is_direct(),
                    "only mode direct lets light straight through glass",
                ),
                (!self.has_glass(), "nothing is of glass"),
                (
                    self.reason_against(Feature::ShadowRays).is_some(),
                    "there are no shadow rays",
                ),
            ]),
        }
    }

    fn reason_against_in_paths(&self, feature: Feature) -> Option<&'static str> {
        let settings = self.settings;
        if !settings.mode.shows_light() {
            return Some("the mode shows no light");
        }
        if !self.is_path() {
            return Some("there are no paths but those of mirrors and glass");
        }
        if settings.max_bounces == 0 {
            return Some("render.max_bounces is 0");
        }
        match feature {
            Feature::LastRays => first_of(&[
                (
                    !self.has_emitter()
                        && !self.lights.iter().any(|light| light.is_visible())
                        && self.is_background_black,
                    "nothing that shines can be met",
                ),
                (!self.has_scatterer(), "nothing scatters light"),
                // A background that is no image is not aimed at.
                (
                    settings.light_sampling == LightSampling::Nee
                        && (self.has_sky_image || self.is_background_black),
                    "render.light_sampling is nee",
                ),
            ]),
            _ => first_of(&[
                (
                    self.reason_against(Feature::Light).is_some(),
                    "there are no paths",
                ),
                (!self.has_reflector(), "nothing reflects light"),
                (!settings.roulette, "render.roulette is off"),
                (
                    settings.max_bounces < super::path::ROULETTE_FROM,
                    "render.max_bounces ends paths before",
                ),
            ]),
        }
    }

    fn is_path(&self) -> bool {
        self.settings.mode == Mode::Path
    }

    fn is_direct(&self) -> bool {
        self.settings.mode == Mode::Direct
    }

    /// Whether a light or an object shines.
    fn has_source(&self) -> bool {
        !self.lights.is_empty() || self.has_emitter()
    }

    /// Whether all that is aimed at is one point.
    fn aims_at_one_point(&self) -> bool {
        !self.has_emitter()
            && !self.has_sky_image
            && self.lights.len() == 1
            && !self.lights.iter().any(|light| light.has_area())
    }

    /// Whether a surface scatters light in many directions.
    fn has_scatterer(&self) -> bool {
        let settings = self.settings;
        self.materials.iter().any(|material| match material {
            Material::Phong {
                diffuse, specular, ..
            } => *diffuse != Rgb::ZERO || *specular != Rgb::ZERO,
            // Grey, where they are switched off.
            Material::Mirror { .. } => !settings.mirror,
            Material::Glass { .. } => !settings.glass,
            Material::Emitter { .. } => false,
        })
    }

    /// Whether a surface sends light on in any way.
    fn has_reflector(&self) -> bool {
        self.has_scatterer()
            || self.materials.iter().any(|material| match material {
                Material::Mirror { reflectance } => *reflectance != Rgb::ZERO,
                Material::Glass { .. } => true,
                Material::Phong { .. } | Material::Emitter { .. } => false,
            })
    }

    fn has_emitter(&self) -> bool {
        let shines = |material: &Material| matches!(material, Material::Emitter { radiance } if *radiance != Rgb::ZERO);
        self.materials.iter().any(shines)
    }

    fn has_glass(&self) -> bool {
        let is_glass = |material: &Material| matches!(material, Material::Glass { .. });
        self.settings.glass && self.materials.iter().any(is_glass)
    }

    fn has_diffuse(&self) -> bool {
        let settings = self.settings;
        self.materials.iter().any(|material| match material {
            Material::Phong { diffuse, .. } => *diffuse != Rgb::ZERO,
            // Grey, where they are switched off.
            Material::Mirror { .. } => !settings.mirror,
            Material::Glass { .. } => !settings.glass,
            Material::Emitter { .. } => false,
        })
    }
}

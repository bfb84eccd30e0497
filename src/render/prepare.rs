//! A scene as rendering reads it: everything that can be computed once, in prepared units (see [`crate::math::SceneFrame`]). It is
//! immutable; a changed scene is prepared anew and shares what did not change.
//!
//! [`rays`] tells what rays in it meet, [`known_hits`] keeps what those from the eye met.

mod known_hits;
mod rays;

use std::sync::Arc;

use super::aim::AimShares;
use super::background::PreparedBackground;
use super::camera::PreparedCamera;
use super::camera_samples::CameraSample;
use super::direct;
use super::disks::VisibleDisks;
use super::emitters::Emitters;
use super::false_color::{self, FalseColor};
use super::geometry::{PreparedGeometry, SketchStore};
use super::kernel::Kernel;
use super::layers::{Gathered, Layer};
use super::light::PreparedLight;
use super::material::PreparedMaterial;
use super::media::Media;
use super::path;
use super::plan::{Feature, Plan};
use super::primary_hits::PrimaryHits;
use super::stops::Stops;
use super::texturing::PreparedTextures;
#[cfg(test)]
use super::{camera_samples::SampleId, sampler::Sampler};
use crate::accel::Assembly;
use crate::control::{CancelToken, Progress};
use crate::math::{Vec2, Vec3, three_digits};
use crate::scene::{Camera, LightSampling, Mode, RenderSettings, Scene, SceneError};
pub(super) use rays::Seen;

/// A scene as rendering reads it: immutable, shared by all threads, cheap to clone.
#[derive(Clone, Debug)]
pub struct PreparedScene {
    geometry: Arc<PreparedGeometry>,
    camera: PreparedCamera,
    background: PreparedBackground,
    /// One per object.
    materials: Vec<PreparedMaterial>,
    /// What varies over objects.
    textures: Arc<PreparedTextures>,
    lights: Vec<PreparedLight>,
    /// The disk lights that rays meet.
    disks: VisibleDisks,
    /// What one light is chosen from.
    emitters: Arc<Emitters>,
    /// How often emitters are aimed at, and how often the background.
    aim_shares: AimShares,
    plan: Plan,
    /// What is kept of the rays from the eye, where somebody keeps it.
    primary_hits: Option<Arc<PrimaryHits>>,
    /// Whether glass absorbs light.
    absorbs: bool,
    /// The glass that the eye is in.
    media_at_eye: Media,
    /// Whether there is a background or an object that shines.
    has_shining_surroundings: bool,
    /// In prepared units.
    occlusion_radius: f32,
    /// The most radiance that a camera sample may bring in its brightest channel.
    clamp: Option<f32>,
    layers: Vec<Layer>,
    settings: RenderSettings,
    /// A sample that panics.
    #[cfg(test)]
    faulty: Option<Sampler>,
}

/// That the numbers of `key` leave 32 bits once the objects are as large as they are in `geometry`.
fn too_large(key: String, geometry: &PreparedGeometry) -> SceneError {
    let bounds = geometry.accelerator().bounds();
    let extent = f64::from(bounds.diagonal()) / geometry.frame().scale();
    SceneError::BadValue {
        key,
        value: format!(
            "too large a number beside objects {} across",
            three_digits(extent)
        ),
        expected: "one that 32 bits hold, up to about 1e38, when all lengths are multiplied so that the objects are about 1 across"
            .to_owned(),
    }
}

impl PreparedScene {
    /// Prepares `scene`; keeps the geometry of `previous` where objects and meshes are the same, so that a new camera, light or
    /// material costs nothing. `None` when cancelled.
    ///
    /// # Errors
    /// What about the description cannot be rendered.
    pub fn prepare(
        scene: &Scene,
        previous: Option<&Self>,
        cancel: &CancelToken,
    ) -> Result<Option<Self>, SceneError> {
        Self::prepare_watched(scene, previous, cancel, &Progress::new())
    }

    /// [`Self::prepare`] that tells how far it is: `progress` counts the triangles that structures are built over, which takes
    /// nearly all the time.
    ///
    /// # Errors
    /// What about the description cannot be rendered.
    pub fn prepare_watched(
        scene: &Scene,
        previous: Option<&Self>,
        cancel: &CancelToken,
        progress: &Progress,
    ) -> Result<Option<Self>, SceneError> {
        let placed = previous.map(|previous| &previous.geometry);
        Self::prepare_over(scene, placed, previous, cancel, progress)
    }

    /// [`Self::prepare_watched`] of triangles that are placed already; what does not depend on them is taken from `previous`.
    ///
    /// # Errors
    /// What about the description cannot be rendered.
    pub fn prepare_placed(
        scene: &Scene,
        placed: &Arc<PreparedGeometry>,
        previous: Option<&Self>,
        cancel: &CancelToken,
        progress: &Progress,
    ) -> Result<Option<Self>, SceneError> {
        Self::prepare_over(scene, Some(placed), previous, cancel, progress)
    }

    /// Keeps what is the same of the triangles `placed`, and of all else in `previous`.
    fn prepare_over(
        scene: &Scene,
        placed: Option<&Arc<PreparedGeometry>>,
        previous: Option<&Self>,
        cancel: &CancelToken,
        progress: &Progress,
    ) -> Result<Option<Self>, SceneError> {
        scene.validate()?;
        match PreparedGeometry::prepare(scene, placed, cancel, progress)? {
            Some(geometry) => Self::with_geometry(scene, geometry, previous, cancel),
            None => Ok(None),
        }
    }

    /// Approximately what `scene` would be prepared to, for a [`Sketch`](super::Sketch) of it.
    pub(super) fn sketch(
        scene: &Scene,
        previous: &Self,
        store: &SketchStore,
        cancel: &CancelToken,
    ) -> Result<Option<Self>, SceneError> {
        scene.validate()?;
        match previous.geometry.sketch(scene, store)? {
            Some(geometry) => Self::with_geometry(scene, geometry, Some(previous), cancel),
            None => Ok(None),
        }
    }

    fn with_geometry(
        scene: &Scene,
        geometry: Arc<PreparedGeometry>,
        previous: Option<&Self>,
        cancel: &CancelToken,
    ) -> Result<Option<Self>, SceneError> {
        let plan = Plan::of(scene)?;
        let known = previous.map(|previous| &previous.background);
        let is_aimed_at = match scene.render.mode {
            // What is met by chance alone is not aimed at, even if lights are that cannot be met.
            Mode::Path => {
                plan.needs(Feature::Aiming) && scene.render.light_sampling != LightSampling::Bsdf
            }
            _ => plan.needs(Feature::Occlusion),
        };
        let Some(background) = PreparedBackground::new(scene, known, is_aimed_at, cancel)? else {
            return Ok(None);
        };
        let frame = geometry.frame();
        let materials = materials_of(scene, frame.scale())?;
        let known = previous.map(|previous| &*previous.textures);
        let Some(textures) = textures_of(scene, known, plan, cancel)? else {
            return Ok(None);
        };
        let lights: Vec<_> = scene
            .lights
            .iter()
            .map(|light| PreparedLight::new(light, frame))
            .collect();
        if let Some(index) = lights.iter().position(|light| !light.is_finite()) {
            return Err(too_large(format!("lights.{index}"), &geometry));
        }
        if let Some(index) = materials.iter().position(|material| !material.is_finite()) {
            let key = format!("the material of objects.{index}");
            return Err(too_large(key, &geometry));
        }
        let RenderSettings {
            width,
            height,
            ref ambient_occlusion,
            depth_of_field,
            ..
        } = scene.render;
        let description = if depth_of_field {
            scene.camera
        } else {
            Camera {
                aperture_radius: 0.0,
                ..scene.camera
            }
        };
        PreparedCamera::check(&description, frame)?;
        let bounds = geometry.accelerator().bounds();
        let disks = VisibleDisks::new(&lights);
        let boxes: Vec<_> = std::iter::once(bounds).chain(disks.boxes()).collect();
        let Some(camera) = PreparedCamera::new(&description, frame, &boxes, width, height) else {
            unreachable!("a validated camera has a direction");
        };
        let emitters = if plan.needs(Feature::Aiming) {
            emitters_of(scene, previous, &geometry, &lights, &materials, cancel)
        } else {
            Some(Arc::default())
        };
        let Some(emitters) = emitters else {
            return Ok(None);
        };
        let radius = bounds.diagonal() / 2.0;
        let aimed_at = background.image().filter(|_| is_aimed_at);
        let mut prepared = Self {
            camera,
            aim_shares: AimShares::new(aimed_at, radius, emitters.power()),
            has_shining_surroundings: !background.is_black()
                || materials
                    .iter()
                    .filter_map(PreparedMaterial::emission)
                    .any(|radiance| radiance != Vec3::ZERO),
            background,
            plan,
            primary_hits: None,
            absorbs: materials.iter().any(PreparedMaterial::absorbs),
            media_at_eye: Media::default(),
            #[expect(clippy::cast_possible_truncation, reason = "rendering is f32")]
            occlusion_radius: (ambient_occlusion.radius * f64::from(bounds.diagonal())) as f32,
            #[expect(clippy::cast_possible_truncation, reason = "rendering is f32")]
            clamp: scene.render.clamp.map(|most| most as f32),
            layers: Layer::all_of(scene),
            emitters,
            materials,
            textures,
            disks,
            lights,
            settings: scene.render.clone(),
            geometry,
            #[cfg(test)]
            faulty: None,
        };
        let eye = prepared.geometry.frame().narrow(scene.camera.eye);
        if prepared.absorbs && bounds.contains(eye) {
            prepared.media_at_eye = Media::at(&prepared, eye);
        }
        Ok(Some(prepared))
    }

    /// Whether glass absorbs light.
    pub(super) fn absorbs(&self) -> bool {
        self.absorbs
    }

    /// The glass that the eye is in, so far as it absorbs.
    pub(super) fn media_at_eye(&self) -> Media {
        self.media_at_eye
    }

    /// From now on that sample of that pixel panics.
    #[cfg(test)]
    pub(super) fn fail_at(&mut self, pixel: (u32, u32), index: u32) {
        self.faulty = Some(self.sampler(SampleId { pixel, index }));
    }

    /// The triangles and their structure.
    #[must_use]
    pub fn geometry(&self) -> &Arc<PreparedGeometry> {
        &self.geometry
    }

    /// Bytes of the tables by which an image of the sky is aimed at; 0 where it is not.
    #[must_use]
    pub fn sky_table_bytes(&self) -> usize {
        match &self.background {
            PreparedBackground::Image(image) => image.table_bytes(),
            _ => 0,
        }
    }

    /// Whether it shares with `other` the tables by which one light is chosen from many.
    #[must_use]
    pub fn shares_light_choice(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.emitters, &other.emitters)
    }

    /// The camera.
    #[must_use]
    pub fn camera(&self) -> &PreparedCamera {
        &self.camera
    }

    /// What to compute.
    #[must_use]
    pub fn settings(&self) -> &RenderSettings {
        &self.settings
    }

    /// The layers that the picture has.
    #[must_use]
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// The index of the object seen at the point `(x, y)` of the picture, in pixels from its top left corner.
    #[must_use]
    pub fn object_at(&self, x: f64, y: f64) -> Option<usize> {
        let hit = self
            .accelerator()
            .intersect(&self.camera.ray(x, y)?.ray, f32::INFINITY)?;
        Some(self.geometry.object_of(hit.triangle))
    }

    /// What `sample` brings: linear radiance, or a false colour. `None` when stopped: some of it may be missing then.
    pub(super) fn gathered<K: Kernel>(
        &self,
        sample: &CameraSample,
        stops: &Stops<'_>,
        tally: &mut K::Tally,
    ) -> Option<Gathered<K::Parts>> {
        let gathered = self.gathered_until::<K>(sample, stops, tally);
        // What was left out, was when somebody asked already.
        (!stops.is_asked()).then_some(gathered)
    }

    /// [`Self::gathered`], all of it as long as nobody asks to end.
    #[expect(clippy::inline_always, reason = "it is called once")]
    #[inline(always)]
    fn gathered_until<K: Kernel>(
        &self,
        sample: &CameraSample,
        stops: &Stops<'_>,
        tally: &mut K::Tally,
    ) -> Gathered<K::Parts> {
        let &CameraSample { sampler, hit, .. } = sample;
        #[cfg(test)]
        assert!(self.faulty != Some(sampler), "as the test wants");
        let Some(camera_ray) = sample.ray else {
            return Gathered::seen(match self.settings.mode {
                Mode::Direct | Mode::Path => self.background.radiance(sample.direction),
                _ => Vec3::ZERO,
            });
        };
        let mut false_color = |which| {
            Gathered::seen(false_color::color::<K>(
                self,
                which,
                &camera_ray,
                sample,
                stops,
                tally,
            ))
        };
        match self.settings.mode {
            Mode::Ao => false_color(FalseColor::AmbientOcclusion),
            Mode::Normals => false_color(FalseColor::Normals),
            Mode::Depth => false_color(FalseColor::Depth),
            Mode::Albedo => false_color(FalseColor::Albedo),
            Mode::Facing => false_color(FalseColor::Facing),
            Mode::Object => false_color(FalseColor::Object),
            Mode::Steps => false_color(FalseColor::Steps),
            Mode::Direct | Mode::Path if !self.does(Feature::Light) => Gathered::nothing(),
            Mode::Direct => direct::gather::<K>(self, camera_ray, hit, sampler, stops, tally),
            Mode::Path => path::gather::<K>(self, camera_ray, hit, sampler, stops, tally),
        }
    }

    pub(super) fn accelerator(&self) -> &Assembly {
        self.geometry.accelerator()
    }

    /// What varies over objects.
    pub(super) fn textures(&self) -> &PreparedTextures {
        &self.textures
    }

    /// Bytes of what is prepared of textures, beside those of meshes and images; 0 where nothing varies over any object.
    #[must_use]
    pub fn texture_bytes(&self) -> usize {
        self.textures.bytes()
    }

    pub(super) fn background(&self) -> &PreparedBackground {
        &self.background
    }

    pub(super) fn material(&self, object: usize) -> &PreparedMaterial {
        &self.materials[object]
    }

    /// Number of lights in the description.
    #[must_use]
    pub fn light_count(&self) -> usize {
        self.lights.len()
    }

    /// Where light number `light` is aimed at from `from`: a point uniform over its area by `u`, or the point it is.
    ///
    /// # Panics
    /// When there is no light of that number.
    #[must_use]
    pub fn point_on_light(&self, light: usize, from: Vec3, u: Vec2) -> Vec3 {
        self.lights[light].sample(from, u).position
    }

    pub(super) fn lights(&self) -> &[PreparedLight] {
        &self.lights
    }

    pub(super) fn emitters(&self) -> &Emitters {
        &self.emitters
    }

    pub(super) fn aim_shares(&self) -> AimShares {
        self.aim_shares
    }

    /// What a render of it does.
    #[must_use]
    pub fn plan(&self) -> Plan {
        self.plan
    }

    /// The same scene, rendered by `plan`.
    #[must_use]
    pub fn with_plan(self, plan: Plan) -> Self {
        Self { plan, ..self }
    }

    pub(super) fn size(&self) -> (u32, u32) {
        (self.settings.width, self.settings.height)
    }

    /// Whether the picture needs it.
    #[inline]
    pub(super) fn needs(&self, feature: Feature) -> bool {
        self.plan.needs(feature)
    }

    /// Whether it is done.
    #[inline]
    pub(super) fn does(&self, feature: Feature) -> bool {
        self.plan.does(feature)
    }

    /// Whether it is done even if it is not needed.
    #[inline]
    pub(super) fn forces(&self, feature: Feature) -> bool {
        self.plan.forces(feature)
    }

    pub(super) fn clamp(&self) -> Option<f32> {
        self.clamp
    }

    /// How near a surface must be to count as occluding, in prepared units.
    #[must_use]
    pub fn occlusion_radius(&self) -> f32 {
        self.occlusion_radius
    }
}

/// The materials of all objects; `scale`: prepared units per scene unit.
fn materials_of(scene: &Scene, scale: f64) -> Result<Vec<PreparedMaterial>, SceneError> {
    let material = |object| {
        let material = scene.material_of(object)?;
        Ok(PreparedMaterial::new(&material, &scene.render, scale))
    };
    scene.objects.iter().map(material).collect()
}

/// What varies over objects, nothing where the plan needs nothing of it; `None` when cancelled.
fn textures_of(
    scene: &Scene,
    previous: Option<&PreparedTextures>,
    plan: Plan,
    cancel: &CancelToken,
) -> Result<Option<Arc<PreparedTextures>>, SceneError> {
    if !plan.needs(Feature::Textures) {
        return Ok(Some(Arc::default()));
    }
    let textures = PreparedTextures::prepare(scene, previous, cancel)?;
    Ok(textures.map(Arc::new))
}

/// What one light is chosen from in `scene`; that of `previous`, where it is the same. `None` when cancelled.
fn emitters_of(
    scene: &Scene,
    previous: Option<&PreparedScene>,
    geometry: &Arc<PreparedGeometry>,
    lights: &[PreparedLight],
    materials: &[PreparedMaterial],
    cancel: &CancelToken,
) -> Option<Arc<Emitters>> {
    let emission = |materials: &[PreparedMaterial]| -> Vec<_> {
        materials.iter().map(PreparedMaterial::emission).collect()
    };
    let lit_alike = previous.filter(|previous| {
        previous.plan.needs(Feature::Aiming)
            && previous.settings.mode == scene.render.mode
            && Arc::ptr_eq(&previous.geometry, geometry)
            && previous.lights == lights
            && emission(&previous.materials) == emission(materials)
    });
    let emitters = match (lit_alike, scene.render.mode) {
        (Some(previous), _) => return Some(Arc::clone(&previous.emitters)),
        (None, Mode::Path) => Emitters::new(lights, geometry, materials, cancel)?,
        (None, Mode::Direct) => {
            let are_chosen = lights.len() > direct::MOST_SUMMED;
            let chosen = if are_chosen { lights } else { &[] };
            Emitters::new(chosen, geometry, materials, cancel)?
        }
        _ => Emitters::default(),
    };
    Some(Arc::new(emitters))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes;
    use crate::math::{DVec3, Degrees};
    use crate::scene::{Background, Light, LightSampling, Material, Object, RadianceMap, Rgb};

    type Edit = fn(&mut Scene);

    #[test]
    fn a_sky_is_prepared_to_be_aimed_at_only_where_it_is() {
        let mut scene = Scene::default();
        let (map, _) = RadianceMap::cleaned(2, 1, vec![[1.0; 3]; 2]);
        scene.images.insert("sky".into(), Arc::new(map));
        scene.background = Background::Image {
            image: "sky".into(),
            up: DVec3::Z,
            rotation: Degrees(0.0),
            scale: 1.0,
        };
        scene
            .meshes
            .insert("ball".into(), Arc::new(shapes::icosphere(1)));
        scene.objects.push(Object {
            mesh: "ball".into(),
            ..Object::default()
        });
        scene.render.mode = Mode::Path;
        scene.render.light_sampling = LightSampling::Bsdf;
        let prepare = |scene: &Scene, previous| {
            let prepared = PreparedScene::prepare(scene, previous, &CancelToken::new());
            prepared.expect("can be rendered").expect("nobody cancels")
        };
        let can_be_sampled = |prepared: &PreparedScene| prepared.sky_table_bytes() > 0;
        let met = prepare(&scene, None);
        assert!(!can_be_sampled(&met));
        scene.render.light_sampling = LightSampling::Mis;
        let aimed_at = prepare(&scene, Some(&met));
        assert!(can_be_sampled(&aimed_at));
        scene.render.light_sampling = LightSampling::Bsdf;
        let again = prepare(&scene, Some(&aimed_at));
        assert!(can_be_sampled(&again), "what is there is kept");
        scene.render.mode = Mode::Direct;
        assert!(can_be_sampled(&prepare(&scene, None)));
    }

    #[test]
    fn what_lights_are_chosen_from_is_kept_until_one_changes() {
        let mut scene = Scene::default();
        scene.render.mode = Mode::Path;
        scene
            .meshes
            .insert("ball".into(), Arc::new(shapes::icosphere(1)));
        let radiance = Rgb::ONE;
        scene
            .materials
            .insert("lamp".into(), Material::Emitter { radiance });
        scene.objects.push(Object {
            mesh: "ball".into(),
            material: Some("lamp".into()),
            ..Object::default()
        });
        // What they light.
        scene.objects.push(Object {
            mesh: "ball".into(),
            ..Object::default()
        });
        scene.lights.push(Light::default());
        let prepare = |scene: &Scene, previous| {
            let prepared = PreparedScene::prepare(scene, previous, &CancelToken::new());
            prepared.expect("can be rendered").expect("nobody cancels")
        };
        let before = prepare(&scene, None);
        let edits: [(Edit, bool); 4] = [
            (|s| s.camera.eye.x += 1.0, true),
            (|s| s.lights[0].move_to(DVec3::ONE), false),
            (
                |s| {
                    let radiance = Rgb::splat(2.0);
                    s.materials
                        .insert("lamp".into(), Material::Emitter { radiance });
                },
                false,
            ),
            (|s| s.render.mode = Mode::Direct, false),
        ];
        for (number, (edit, is_kept)) in edits.into_iter().enumerate() {
            let mut scene = scene.clone();
            edit(&mut scene);
            let after = prepare(&scene, Some(&before));
            assert_eq!(after.shares_light_choice(&before), is_kept, "edit {number}");
        }
    }
}

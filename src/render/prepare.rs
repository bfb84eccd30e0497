use std::sync::Arc;

use super::background::PreparedBackground;
use super::camera::{CameraRay, PreparedCamera};
use super::direct;
use super::false_color::{self, FalseColor};
use super::geometry::PreparedGeometry;
use super::light::PreparedLight;
use super::phong::Phong;
use super::run::RayCounts;
use super::sampler::{Dimension, Sampler};
use crate::accel::Accelerator;
use crate::control::CancelToken;
use crate::math::{Vec2, Vec3};
use crate::scene::{Mode, PhongModel, RenderSettings, Scene, SceneError, Shadows};

/// A scene as rendering reads it: immutable, shared by all threads, cheap to clone.
#[derive(Clone, Debug)]
pub struct PreparedScene {
    geometry: Arc<PreparedGeometry>,
    camera: PreparedCamera,
    background: PreparedBackground,
    /// One per object.
    materials: Vec<Phong>,
    lights: Vec<PreparedLight>,
    settings: RenderSettings,
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
        scene.validate()?;
        let materials = scene
            .objects
            .iter()
            .map(|object| Ok(Phong::new(&scene.material_of(object)?)));
        let materials = materials.collect::<Result<_, SceneError>>()?;
        let previous = previous.map(|previous| &previous.geometry);
        let Some(geometry) = PreparedGeometry::prepare(scene, previous, cancel)? else {
            return Ok(None);
        };
        let RenderSettings { width, height, .. } = scene.render;
        let bounds = geometry.accelerator().bounds();
        let Some(camera) =
            PreparedCamera::new(&scene.camera, geometry.frame(), &bounds, width, height)
        else {
            unreachable!("a validated camera has a direction");
        };
        Ok(Some(Self {
            camera,
            background: PreparedBackground::new(&scene.background),
            materials,
            lights: scene
                .lights
                .iter()
                .map(|light| PreparedLight::new(light, geometry.frame()))
                .collect(),
            settings: scene.render.clone(),
            geometry,
        }))
    }

    /// The triangles and their structure.
    #[must_use]
    pub fn geometry(&self) -> &Arc<PreparedGeometry> {
        &self.geometry
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

    /// The index of the object seen at the point `(x, y)` of the picture, in pixels from its top left corner.
    #[must_use]
    pub fn object_at(&self, x: f64, y: f64) -> Option<usize> {
        let hit = self
            .accelerator()
            .intersect(&self.camera.ray(x, y)?.ray, f32::INFINITY)?;
        Some(self.geometry.object_of(hit.triangle))
    }

    /// The value of sample `index` of pixel `(x, y)`: linear radiance, or a false colour.
    pub(super) fn sample(&self, x: u32, y: u32, index: u32, rays: &mut RayCounts) -> Vec3 {
        let place = if self.settings.antialiasing && self.settings.samples_per_pixel > 1 {
            Sampler::new(self.settings.seed, x, y, index).next_2d(Dimension::Pixel)
        } else {
            Vec2::splat(0.5)
        };
        let (x, y) = (
            f64::from(x) + f64::from(place.x),
            f64::from(y) + f64::from(place.y),
        );
        rays.camera += 1;
        match (self.camera.ray(x, y), self.false_color()) {
            (Some(camera_ray), Some(which)) => false_color::color(self, which, &camera_ray),
            (None, Some(_)) => Vec3::ZERO,
            (Some(CameraRay { ray, .. }), None) => direct::radiance(self, &ray, rays),
            (None, None) => self
                .background
                .radiance(self.camera.direction(x, y).as_vec3()),
        }
    }

    fn false_color(&self) -> Option<FalseColor> {
        match self.settings.mode {
            Mode::Direct => None,
            Mode::Normals => Some(FalseColor::Normals),
            Mode::Depth => Some(FalseColor::Depth),
            Mode::Albedo => Some(FalseColor::Albedo),
            Mode::Facing => Some(FalseColor::Facing),
            Mode::Object => Some(FalseColor::Object),
        }
    }

    pub(super) fn accelerator(&self) -> &Accelerator {
        self.geometry.accelerator()
    }

    pub(super) fn background(&self) -> &PreparedBackground {
        &self.background
    }

    pub(super) fn material(&self, object: usize) -> &Phong {
        &self.materials[object]
    }

    pub(super) fn lights(&self) -> &[PreparedLight] {
        &self.lights
    }

    pub(super) fn shadows(&self) -> Shadows {
        self.settings.shadows
    }

    pub(super) fn phong_model(&self) -> PhongModel {
        self.settings.phong
    }
}

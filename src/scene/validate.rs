//! What rendering relies on and no single key of a scene file can promise.

use std::fmt::Display;

use super::{
    Background, Camera, Choice, Facing, Light, Material, Mode, Object, PhongModel, RenderSettings,
    Scene, SceneError, Stop,
};
use crate::math::{DVec3, direction_of};

impl Scene {
    /// Checks what rendering relies on.
    ///
    /// # Errors
    /// The first value that cannot be rendered, and what it may be.
    pub fn validate(&self) -> Result<(), SceneError> {
        self.validate_but_objects()?;
        self.validate_objects()
    }

    /// [`Self::validate`], of all but the objects, which may be very many.
    ///
    /// # Errors
    /// Those of [`Self::validate`].
    pub fn validate_but_objects(&self) -> Result<(), SceneError> {
        check_camera(&self.camera)?;
        for (index, bookmark) in self.bookmarks.iter().enumerate() {
            check_camera(&bookmark.camera).map_err(|error| of_bookmark(error, index))?;
        }
        check_background(&self.background)?;
        for (index, light) in self.lights.iter().enumerate() {
            check_light(index, light)?;
        }
        check_settings(&self.render)
    }

    /// [`Self::validate`], of the objects alone.
    ///
    /// # Errors
    /// Those of [`Self::validate`].
    pub fn validate_objects(&self) -> Result<(), SceneError> {
        for (index, object) in self.objects.iter().enumerate() {
            check_object(index, object)?;
        }
        Ok(())
    }
}

impl Scene {
    /// What can be rendered but is hardly meant: materials that reflect more light than arrives, where light bounces, textures on meshes
    /// that do not say how they lie there, and steps between copies that there are not.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let sentence = |(name, _): (&str, f64)| {
            format!(
                "material \"{name}\" reflects more light than arrives; keep diffuse + specular, or reflectance, at 1 or less"
            )
        };
        let creators = self.energy_creators().map(sentence);
        let idle = self.idle_steps();
        creators.chain(self.lost_textures()).chain(idle).collect()
    }

    /// Grids of copies that have a step and one place.
    fn idle_steps(&self) -> impl Iterator<Item = String> {
        let is_idle =
            |object: &&Object| object.copies.total() == 1 && object.copies.step != DVec3::ZERO;
        self.objects.iter().filter(is_idle).map(|object| {
            let name = &object.name;
            format!(
                "copies.step of object \"{name}\" moves nothing, as copies.count asks for no more than one; translate moves it"
            )
        })
    }

    /// What of materials does not show on objects, as their meshes lack what it takes.
    fn lost_textures(&self) -> impl Iterator<Item = String> {
        let lost = |object: &Object| {
            let (missing, name) = (self.lost_texture(object)?, &object.name);
            Some(format!("the material of object \"{name}\" has {missing}"))
        };
        self.objects.iter().filter_map(lost)
    }

    /// What the material of `object` has that does not show on it, as its mesh lacks what that takes; nothing where the mesh is missing.
    #[must_use]
    pub fn lost_texture(&self, object: &Object) -> Option<&'static str> {
        if self.lacks_mesh(object) {
            return None;
        }
        let material = self.materials.get(object.material.as_ref()?)?;
        let (textures, mesh) = (material.textures()?, self.meshes.get(&object.mesh)?);
        let has_image = textures.images().next().is_some();
        if has_image && mesh.texture_coordinates.is_none() {
            Some("an image, but the mesh has no texture coordinates")
        } else if textures.vertex_colors && mesh.colors.is_none() {
            Some("colours of vertices, but the mesh has none")
        } else {
            None
        }
    }

    /// The materials that reflect more light than arrives, where light bounces: their names, and the largest share of the light
    /// that a channel reflects.
    pub fn energy_creators(&self) -> impl Iterator<Item = (&str, f64)> {
        let reflected = |material: &Material| match material {
            Material::Phong {
                diffuse, specular, ..
            } if self.render.mode == Mode::Path => (*diffuse + *specular).max_element(),
            Material::Mirror { reflectance } => reflectance.max_element(),
            Material::Phong { .. } | Material::Glass { .. } | Material::Emitter { .. } => 0.0,
        };
        self.materials
            .iter()
            .map(move |(name, material)| (name.as_str(), reflected(material)))
            .filter(|&(_, reflected)| reflected > Material::MAX_REFLECTANCE)
    }
}

/// Largest coordinate of a place: differences have squares that a double holds.
const MOST_COORDINATE: f64 = 1e150;

/// A number as a message shows it: hundreds of digits would hide what it says.
fn shown(number: f64) -> String {
    let has_few_digits = number == 0.0 || (1e-5..1e16).contains(&number.abs());
    if has_few_digits {
        number.to_string()
    } else {
        format!("{number:e}")
    }
}

fn shown_vector(vector: &DVec3) -> String {
    format!("[{}]", vector.to_array().map(shown).join(", "))
}

/// What is wrong with a camera, said of that of a bookmark.
fn of_bookmark(error: SceneError, index: usize) -> SceneError {
    match error {
        SceneError::BadValue {
            key,
            value,
            expected,
        } => SceneError::BadValue {
            key: key.replacen("camera.", &format!("bookmarks.{index}."), 1),
            value,
            expected,
        },
        other => other,
    }
}

fn check_camera(camera: &Camera) -> Result<(), SceneError> {
    let Camera {
        eye, target, up, ..
    } = camera;
    let expected = format!("coordinates of at most {MOST_COORDINATE:e}");
    for (key, place) in [("camera.eye", eye), ("camera.target", target)] {
        let is_near = place.abs().max_element() <= MOST_COORDINATE;
        require(is_near, key, &shown_vector(place), &expected)?;
    }
    require(
        target != eye,
        "camera.target",
        &shown_vector(target),
        "a point other than the eye",
    )?;
    let expected = "a direction that is not parallel to the view";
    let has_axes = camera.axes().is_some();
    require(has_axes, "camera.up", &shown_vector(up), expected)?;
    let fov = camera.vertical_fov.0;
    let expected = "more than 0 and less than 180 degrees";
    require(
        fov > 0.0 && fov < 180.0,
        "camera.vertical_fov",
        &fov,
        expected,
    )?;
    let aperture = camera.aperture_radius;
    let expected = "0 for a pinhole, or the lens's radius in scene units";
    require(
        aperture.is_finite() && aperture >= 0.0,
        "camera.aperture_radius",
        &shown(aperture),
        expected,
    )?;
    let focus = camera.focus();
    require(
        focus > 0.0,
        "camera.focus_distance",
        &shown(focus),
        "a distance above 0, or inf",
    )
}

fn check_background(background: &Background) -> Result<(), SceneError> {
    if let Background::Gradient { up, .. } | Background::Image { up, .. } = background {
        let has_direction = direction_of(*up).is_some();
        require(
            has_direction,
            "background.up",
            &shown_vector(up),
            "a direction",
        )?;
    }
    let radiances = match background {
        Background::Constant { radiance } => vec![("radiance", radiance)],
        Background::Gradient {
            zenith,
            horizon,
            ground,
            ..
        } => vec![("zenith", zenith), ("horizon", horizon), ("ground", ground)],
        Background::Image { .. } => Vec::new(),
    };
    for (name, radiance) in radiances {
        let expected = format!("at most {:e} in each channel", f32::MAX);
        let key = format!("background.{name}");
        let is_radiance = radiance.as_vec3().is_finite();
        require(is_radiance, &key, &shown_vector(radiance), &expected)?;
    }
    if let Background::Image {
        rotation, scale, ..
    } = background
    {
        let degrees = rotation.0;
        let key = "background.rotation";
        require(degrees.is_finite(), key, &degrees, "a finite number")?;
        let expected = "a finite number of at least 0";
        let is_factor = scale.is_finite() && *scale >= 0.0;
        require(is_factor, "background.scale", scale, expected)?;
    }
    Ok(())
}

fn check_light(index: usize, light: &Light) -> Result<(), SceneError> {
    let key = |name: &str| format!("lights.{index}.{name}");
    match light {
        Light::Point { position, .. } => require(
            position.is_finite(),
            &key("position"),
            position,
            "finite numbers",
        ),
        Light::Disk {
            center,
            facing,
            radius,
            ..
        } => {
            require(center.is_finite(), &key("center"), center, "finite numbers")?;
            require(
                *radius > 0.0 && radius.is_finite(),
                &key("radius"),
                radius,
                "a radius above 0",
            )?;
            let (name, value, expected) = match facing {
                Facing::Target(target) => ("target", target, "a point other than the center"),
                Facing::Normal(normal) => ("normal", normal, "a direction"),
            };
            require(
                facing.normal(*center).is_some(),
                &key(name),
                &shown_vector(value),
                expected,
            )
        }
    }
}

fn check_settings(settings: &RenderSettings) -> Result<(), SceneError> {
    let physical = settings.mode != Mode::Path || settings.phong == PhongModel::Modified;
    let expected =
        "modified in mode path: the classic formula makes energy from nothing when light bounces";
    require(physical, "render.phong", &settings.phong.name(), expected)?;
    let RenderSettings {
        width,
        height,
        samples_per_pixel,
        ..
    } = settings;
    let sides = 1..=RenderSettings::MAX_SIDE;
    let expected = format!("1 to {}", RenderSettings::MAX_SIDE);
    require(sides.contains(width), "render.width", width, &expected)?;
    require(sides.contains(height), "render.height", height, &expected)?;
    let expected = format!("width × height of at most {}", RenderSettings::MAX_PIXELS);
    require(
        settings.pixel_count() <= RenderSettings::MAX_PIXELS,
        "render.width",
        width,
        &expected,
    )?;
    let samples = 1..=RenderSettings::MAX_SAMPLES;
    let expected = format!("1 to {}", RenderSettings::MAX_SAMPLES);
    require(
        samples.contains(samples_per_pixel),
        "render.samples_per_pixel",
        samples_per_pixel,
        &expected,
    )?;
    check_stop(settings)?;
    let rays = 1..=RenderSettings::MAX_RAYS_PER_SAMPLE;
    let expected = format!("1 to {}", RenderSettings::MAX_RAYS_PER_SAMPLE);
    require(
        rays.contains(&settings.shadow_samples),
        "render.shadow_samples",
        &settings.shadow_samples,
        &expected,
    )?;
    require(
        settings
            .clamp
            .is_none_or(|most| most > 0.0 && most.is_finite()),
        "render.clamp",
        &settings.clamp.unwrap_or_default(),
        "a radiance above 0, or no such key",
    )?;
    let occlusion = settings.ambient_occlusion;
    let key = "render.ambient_occlusion.samples";
    require(
        rays.contains(&occlusion.samples),
        key,
        &occlusion.samples,
        &expected,
    )?;
    let key = "render.ambient_occlusion.radius";
    require(
        occlusion.radius > 0.0 && occlusion.radius.is_finite(),
        key,
        &occlusion.radius,
        "a fraction above 0",
    )
}

fn check_stop(settings: &RenderSettings) -> Result<(), SceneError> {
    let Stop {
        seconds,
        noise,
        passes,
    } = settings.stop;
    let positive = |number: Option<f64>| number.is_none_or(|n| n > 0.0 && n.is_finite());
    require(
        positive(seconds),
        "render.stop.seconds",
        &seconds.unwrap_or_default(),
        "a time above 0, or no such key",
    )?;
    require(
        positive(noise),
        "render.stop.noise",
        &noise.unwrap_or_default(),
        "a noise above 0, such as 0.03 for 3 %, or no such key",
    )?;
    require(
        passes != Some(0),
        "render.stop.passes",
        &0,
        "at least 1, or no such key",
    )?;
    require(
        noise.is_none() || settings.error_estimate,
        "render.error_estimate",
        &settings.error_estimate,
        "true where render.stop.noise asks for a noise",
    )
}

fn check_object(index: usize, object: &Object) -> Result<(), SceneError> {
    let key = |name: &str| format!("objects.{index}.{name}");
    let Object {
        scale,
        rotate,
        translate,
        copies,
        ..
    } = object;
    let expected = "a finite number other than 0";
    require(
        scale.is_finite() && *scale != 0.0,
        &key("scale"),
        scale,
        expected,
    )?;
    require(rotate.is_finite(), &key("rotate"), rotate, "finite numbers")?;
    require(
        translate.is_finite(),
        &key("translate"),
        translate,
        "finite numbers",
    )?;
    require(
        copies.total() > 0,
        &key("copies.count"),
        &0,
        "at least 1 along each axis",
    )
}

fn require(holds: bool, key: &str, value: &dyn Display, expected: &str) -> Result<(), SceneError> {
    if holds {
        return Ok(());
    }
    Err(SceneError::BadValue {
        key: key.to_owned(),
        value: value.to_string(),
        expected: expected.to_owned(),
    })
}

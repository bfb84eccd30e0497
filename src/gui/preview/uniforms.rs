//! What the shader is told besides triangles: camera, lights, background and materials, computed in `f64` and narrowed
//! last. The layouts mirror `shader.wgsl`.

use bytemuck::{Pod, Zeroable};

use super::geometry::GpuGeometry;
use super::object_color;
use crate::gui::focus::{FocusAid, blur_scale};
use crate::gui::orbit::PictureSize;
use crate::math::{Bounds, DMat3, DVec3, ScaledRotation, SceneFrame};
use crate::scene::{Background, Light, Material, Mode, Move, Object, PhongModel, Scene, ToneCurve};

/// Most lights the preview shows; a picture has no such limit.
pub const MAX_LIGHTS: usize = 256;

/// Nearest distance at which anything is drawn, in prepared units, where the eye is among the objects.
const NEAREST: f64 = 1e-4;

/// The shader's `View`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct ViewUniform {
    right: [f32; 4],
    up: [f32; 4],
    forward: [f32; 4],
    eye_high: [f32; 4],
    eye_low: [f32; 4],
    ray_right: [f32; 4],
    ray_up: [f32; 4],
    zenith: [f32; 4],
    horizon: [f32; 4],
    ground: [f32; 4],
    sky_up: [f32; 4],
    choices: [u32; 4],
    focus: [f32; 4],
    lights: [[[f32; 4]; 3]; MAX_LIGHTS],
}

impl ViewUniform {
    /// The uniform of `scene` seen by its camera, or `None` where the camera is none.
    ///
    /// `bounds`: box of the triangles in the prepared scene.
    pub(super) fn new(
        scene: &Scene,
        frame: &SceneFrame,
        bounds: &Bounds,
        aid: FocusAid,
    ) -> Option<Self> {
        let camera = &scene.camera;
        let axes = camera.axes()?;
        let half_height = (camera.vertical_fov.radians() * 0.5).tan();
        let half_width =
            half_height * f64::from(scene.render.width) / f64::from(scene.render.height);

        let eye = frame.prepared_from_world(camera.eye);
        let eye_high = eye.as_vec3();
        let eye_low = eye - eye_high.as_dvec3();
        let target_distance = camera.eye.distance(camera.target) * frame.scale();
        let near = near_distance(eye, bounds, target_distance);

        let mut lights = [[[0.0; 4]; 3]; MAX_LIGHTS];
        let shown = scene.lights.iter();
        let shown = shown.filter_map(|light| light_seen_from(light, frame, eye));
        let mut light_count = 0;
        for (slot, light) in lights.iter_mut().zip(shown) {
            *slot = light;
            light_count += 1;
        }
        let (zenith, horizon, ground, sky_up) = sky(&scene.background);

        Some(Self {
            right: vec4(axes.right / half_width, near),
            up: vec4(axes.up / half_height, 0.0),
            forward: vec4(axes.forward, 1.0 / frame.scale()),
            eye_high: vec4(eye_high.as_dvec3(), 0.0),
            eye_low: vec4(eye_low, 0.0),
            ray_right: vec4(axes.right * half_width, scene.display.exposure.exp2()),
            ray_up: vec4(axes.up * half_height, 1.0 / scene.display.gamma),
            zenith: vec4(zenith, f64::from(scene.render.mode == Mode::Path)),
            horizon: vec4(horizon, 0.0),
            ground: vec4(ground, 0.0),
            sky_up: vec4(sky_up, 0.0),
            choices: [
                mode_number(scene.render.mode),
                match scene.display.tone_curve {
                    ToneCurve::None => 0,
                    ToneCurve::Aces => 1,
                },
                match scene.render.phong {
                    PhongModel::Modified => 0,
                    PhongModel::Classic => 1,
                },
                light_count,
            ],
            focus: focus(scene, frame, aid),
            lights,
        })
    }
}

/// Numbers of lights beyond are as good as infinite, and those below as nothing: products and quotients of them stay finite in `f32`.
const MOST_OF_LIGHT: f64 = 1e15;

/// The shader's `Light`, with `eye` in prepared units; `None` where nothing of it arrives that can be told from none, or where it is too far
/// for its place to be told.
fn light_seen_from(light: &Light, frame: &SceneFrame, eye: DVec3) -> Option<[[f32; 4]; 3]> {
    let position = frame.prepared_from_world(light.position()) - eye;
    // Irradiance is intensity per squared distance, and distances shrink by the frame's scale.
    let squared_scale = frame.scale() * frame.scale();
    let (intensity, normal, is_flat) = match *light {
        Light::Point { intensity, .. } => (intensity, DVec3::ZERO, 0.0),
        // All of the disk as a point at its centre.
        Light::Disk {
            center,
            facing,
            radius,
            radiance,
            ..
        } => {
            let area = std::f64::consts::PI * radius * radius;
            let normal = facing.normal(center).unwrap_or_default();
            (radiance * area, normal, 1.0)
        }
    };
    let intensity = intensity * squared_scale;
    let is_told = position.abs().max_element() <= MOST_OF_LIGHT && normal.is_finite();
    let is_bright = intensity.max_element() >= MOST_OF_LIGHT.recip();
    let intensity = intensity.clamp(DVec3::ZERO, DVec3::splat(MOST_OF_LIGHT));
    (is_told && is_bright && !intensity.is_nan()).then(|| {
        [
            vec4(position, 0.0),
            vec4(intensity, 0.0),
            vec4(normal, is_flat),
        ]
    })
}

/// What the shader shows of the focus: 0 nothing, 1 the plane, 2 the blur too; its diameter in pixels per difference of reciprocal
/// distances; the reciprocal of the focus distance. Distances in prepared units.
fn focus(scene: &Scene, frame: &SceneFrame, aid: FocusAid) -> [f32; 4] {
    /// Numbers beyond are as good as infinite, and products of them stay finite.
    const MOST: f64 = 1e18;
    let camera = &scene.camera;
    let kind = match aid {
        FocusAid::Off => return [0.0; 4],
        FocusAid::Plane => 1.0,
        FocusAid::Blur => 2.0,
    };
    let height = f64::from(scene.render.height);
    let scale = if scene.render.depth_of_field {
        blur_scale(camera, height) * frame.scale()
    } else {
        0.0
    };
    let reciprocal = (camera.focus() * frame.scale()).recip();
    let [scale, reciprocal] = [scale, reciprocal].map(|x| x.min(MOST));
    vec4(DVec3::new(kind, scale, reciprocal), 0.0)
}

/// What there is beside one colour at one place, as the shader knows it: it was moved, an image lies on it, its vertices have colours, an
/// image says its normals.
const MOVED: u32 = 1;
const IMAGE: u32 = 2;
const COLORS: u32 = 4;
const NORMALS: u32 = 8;

/// The shader's `Object`: an object's material, how its triangles are turned, and where they have gone since.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct ObjectUniform {
    diffuse: [f32; 4],
    specular: [f32; 4],
    id_color: [f32; 4],
    about: [u32; 4],
    turn: [[f32; 4]; 3],
    moved: [[f32; 4]; 3],
    shift: [f32; 4],
}

impl ObjectUniform {
    /// The uniforms of all objects of `geometry`, with what happened to them since. An object without existing material, or not there
    /// any more, gets the default one.
    pub(super) fn of_scene(
        scene: &Scene,
        geometry: &GpuGeometry,
        moves: &[Option<Move>],
    ) -> Vec<Self> {
        let eye = scene.camera.eye;
        let uniform = |(index, turn): (usize, &ScaledRotation)| {
            let object = scene.objects.get(index);
            let material = object.and_then(|object| scene.material_of(object).ok());
            let mut material = material.unwrap_or_default();
            let [has_image, has_colors, has_normals] = geometry.shows(scene, index);
            if let Some(object) = object.filter(|_| !has_image) {
                take_mean_color(scene, object, &mut material);
            }
            let moved = moves.get(index).copied().flatten();
            let moved = moved.map(|moved| moved.seen_from(eye, &geometry.frame));
            let mut uniform = Self::new(&material, index, turn, moved);
            let bit = |bit: u32, has: bool| bit * u32::from(has);
            uniform.about[3] |=
                bit(IMAGE, has_image) | bit(COLORS, has_colors) | bit(NORMALS, has_normals);
            uniform
        };
        geometry.turns().enumerate().map(uniform).collect()
    }

    /// `moved`: a turn about the eye and what is added to it, in prepared units.
    fn new(
        material: &Material,
        object: usize,
        turn: &ScaledRotation,
        moved: Option<(ScaledRotation, DVec3)>,
    ) -> Self {
        // What the shader knows of materials: two colours, a number, and which kind it is.
        let (diffuse, specular, shininess, kind) = match *material {
            Material::Phong {
                diffuse,
                specular,
                shininess,
                ..
            } => (diffuse, specular, shininess, 0),
            Material::Mirror { reflectance } => (reflectance, DVec3::ZERO, 1.0, 1),
            // Glass takes the tint of a unit of it.
            Material::Glass { ior, attenuation } => ((-attenuation).exp(), DVec3::ZERO, ior, 2),
            Material::Emitter { radiance } => (radiance, DVec3::ZERO, 1.0, 3),
        };
        let DMat3 {
            x_axis,
            y_axis,
            z_axis,
        } = *turn.matrix();
        let still = || (ScaledRotation::new(DMat3::IDENTITY), DVec3::ZERO);
        let is_moved = moved.is_some();
        let (moved, shift) = moved.unwrap_or_else(still);
        let matrix = moved.matrix();
        Self {
            diffuse: vec4(diffuse, 0.0),
            specular: vec4(specular, shininess),
            id_color: vec4(object_color(object), turn.scale().recip()),
            about: [
                u32::try_from(object).unwrap_or(u32::MAX),
                kind,
                u32::from(turn.is_mirrored() != moved.is_mirrored()),
                MOVED * u32::from(is_moved),
            ],
            turn: [x_axis, y_axis, z_axis].map(|axis| vec4(axis, 0.0)),
            moved: [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| vec4(axis, 0.0)),
            shift: vec4(shift, 0.0),
        }
    }
}

/// Size of the picture whose frame the preview shows.
pub(crate) fn picture_size(scene: &Scene) -> PictureSize {
    PictureSize {
        width: f64::from(scene.render.width.max(1)),
        height: f64::from(scene.render.height.max(1)),
    }
}

/// A distance before which nothing is, as large as possible: it decides how finely depths are told apart.
fn near_distance(eye: DVec3, bounds: &Bounds, target_distance: f64) -> f64 {
    let closest = if bounds.is_empty() {
        DVec3::ZERO
    } else {
        eye.clamp(bounds.min.as_dvec3(), bounds.max.as_dvec3())
    };
    // Distance along the view axis is less than the straight one towards the picture's corners; this is enough for
    // fields of view of up to 178°.
    let outside = eye.distance(closest) * 0.01;
    outside
        .max(NEAREST.min(target_distance * 0.01))
        .clamp(1e-12, 1e12)
}

/// Zenith, horizon, ground and up of a background.
fn sky(background: &Background) -> (DVec3, DVec3, DVec3, DVec3) {
    match *background {
        // Drawn from its own texture; black until that is there.
        Background::Image { .. } => (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO, DVec3::Z),
        Background::Constant { radiance } => (radiance, radiance, radiance, DVec3::Z),
        Background::Gradient {
            zenith,
            horizon,
            ground,
            up,
        } => (zenith, horizon, ground, up.normalize_or(DVec3::Z)),
    }
}

/// The number of a mode in the shader.
fn mode_number(mode: Mode) -> u32 {
    match mode {
        Mode::Direct | Mode::Path => 0,
        Mode::Normals => 1,
        Mode::Depth => 2,
        Mode::Albedo => 3,
        Mode::Facing => 4,
        Mode::Object => 5,
        // The preview knows no structure either.
        Mode::Ao | Mode::Steps => 6,
    }
}

/// Three numbers and a fourth, narrowed.
#[expect(clippy::cast_possible_truncation, reason = "narrowing is the purpose")]
pub(super) fn vec4(v: DVec3, w: f64) -> [f32; 4] {
    [v.x as f32, v.y as f32, v.z as f32, w as f32]
}

/// Multiplies the diffuse colour by the mean of the image that lies on `object`, if one does: all there is to show until the image is
/// uploaded.
fn take_mean_color(scene: &Scene, object: &Object, material: &mut Material) {
    let mesh = scene.meshes.get(&object.mesh);
    let is_mapped = mesh.is_some_and(|mesh| mesh.texture_coordinates.is_some());
    if let Material::Phong {
        diffuse, textures, ..
    } = material
        && let Some(image) = textures.diffuse_image.as_ref().filter(|_| is_mapped)
        && let Some(image) = scene.textures.get(image)
    {
        *diffuse *= image.mean_color();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{DBounds, Vec3};
    use crate::scene::Rgb;

    /// Numbers that `f32` does not hold would be infinite or none in the shader, and everything black that they are added to.
    #[test]
    fn lights_out_of_all_measure_leave_the_others_their_light() {
        let frame = SceneFrame::around(&DBounds {
            min: DVec3::splat(-1.0),
            max: DVec3::splat(1.0),
        });
        let light = |place: f64, intensity: f64| Light::Point {
            position: DVec3::splat(place),
            intensity: Rgb::splat(intensity),
        };
        let eye = DVec3::new(0.0, -5.0, 0.0);
        let seen = |light: &Light| light_seen_from(light, &frame, eye);
        for (place, intensity) in [
            (2.0, 1e40),
            (2.0, f64::MAX),
            (2.0, 1e-30),
            (1e300, 1e-30),
            (1e300, 1e40),
            (1e20, 1.0),
        ] {
            let Some([position, intensity, _]) = seen(&light(place, intensity)) else {
                continue;
            };
            // What the shader does at the farthest and the nearest point.
            let squared: f32 = position[..3].iter().map(|x| x * x).sum();
            for squared in [squared, 1e-12] {
                let irradiance = intensity[0] / squared * 1e4;
                assert!(
                    irradiance.is_finite() && irradiance * squared.sqrt() > 0.0,
                    "{irradiance}"
                );
            }
        }
        assert_eq!(seen(&light(1e300, 1e-30)), None);
        let usual = seen(&light(2.0, 3.0)).unwrap();
        let scale = frame.scale();
        let expected = 3.0 * scale * scale;
        assert!((f64::from(usual[1][0]) - expected).abs() < 1e-6 * expected);
        let mut scene = Scene {
            lights: vec![light(1e300, 1e-30), light(2.0, 3.0)],
            ..Scene::default()
        };
        let bounds = Bounds {
            min: Vec3::NEG_ONE,
            max: Vec3::ONE,
        };
        scene.camera.eye = eye;
        let uniform = ViewUniform::new(&scene, &frame, &bounds, FocusAid::Off).unwrap();
        assert_eq!(uniform.choices[3], 1, "the other one is there");
        assert_eq!(uniform.lights[0], usual_from(&scene, &frame));
    }

    fn usual_from(scene: &Scene, frame: &SceneFrame) -> [[f32; 4]; 3] {
        let eye = frame.prepared_from_world(scene.camera.eye);
        light_seen_from(&scene.lights[1], frame, eye).unwrap()
    }
}

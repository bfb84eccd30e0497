//! The preview: the scene's triangles drawn by the GPU into a texture of its own, with the very frame of the picture.
//!
//! It draws the `f32` triangles of the prepared scene, so what it shows is what is rendered, and a camera built in `f64`.
//! It leaves out shadows and everything that needs more than one ray. It knows nothing of the window: tests run it
//! without one. Depth runs from 0 (infinitely far) to 1 (near plane); pixel (0, 0) is top left, as in pictures.
//!
//! - [`pack`], [`geometry`]: triangles and where copies of them are, packed and uploaded by a worker when they change
//! - [`detail`]: the same in fewer and fewer triangles, where there are many
//! - [`choice`], [`ball`]: which of them are drawn, for a frame to have no more than so many
//! - `pace`: how many that are
//! - `uniforms`: camera, lights, background, materials, compared on every frame: equal numbers are not drawn again
//! - [`paint`], `image`: colours and images that vary over objects, uploaded by a worker too
//! - [`sky`]: the background's image, uploaded by a worker too
//! - `pipeline`, `target`: programs and textures

pub mod ball;
pub mod choice;
pub mod detail;
pub mod geometry;
mod image;
mod pace;
pub mod pack;
pub mod paint;
mod pipeline;
pub mod sky;
mod sky_light;
mod target;
pub mod uniforms;

use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::wgpu;

use super::focus::FocusAid;
use crate::math::DVec3;
use crate::scene::{Move, Scene};
use choice::{Choice, Omission, Pick, Sight};
use geometry::GpuGeometry;
use pace::Pace;
pub use pace::least_triangles;
use pipeline::{ObjectUniforms, Pipelines};
use sky::{GpuSky, SkyUniform};
use target::{IdTarget, Target};
use uniforms::{ObjectUniform, ViewUniform};

/// Samples per pixel on a real GPU. Software adapters use one: they pay for each.
const SAMPLES: u32 = 4;

/// Draws scenes into a texture.
#[derive(Debug)]
pub struct Preview {
    device: wgpu::Device,
    queue: wgpu::Queue,
    samples: u32,
    pipelines: Pipelines,
    objects: Option<ObjectUniforms>,
    sky: Option<Arc<GpuSky>>,
    focus_aid: FocusAid,
    /// What happened to each object since its triangles were prepared; those beyond the end stay.
    moves: Vec<Option<Move>>,
    target: Option<Target>,
    drawn: Option<Drawn>,
    choice: Choice,
    pace: Pace,
    /// When what is drawn changed last, and whether it has been drawn at rest since.
    changed: Instant,
    is_at_rest: bool,
}

/// Everything a drawn picture depends on.
#[derive(Clone, Debug)]
struct Drawn {
    geometry: Arc<GpuGeometry>,
    view: Box<ViewUniform>,
    sky: SkyUniform,
    objects: Vec<ObjectUniform>,
}

impl PartialEq for Drawn {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.geometry, &other.geometry)
            && self.view == other.view
            && self.sky == other.sky
            && self.objects == other.objects
    }
}

impl Preview {
    /// A preview on `device`; `software`: whether the CPU plays the GPU.
    #[must_use]
    pub fn new(device: wgpu::Device, queue: wgpu::Queue, software: bool) -> Self {
        let samples = if software { 1 } else { SAMPLES };
        Self {
            pipelines: Pipelines::new(&device, &queue, samples),
            device,
            queue,
            samples,
            objects: None,
            sky: None,
            focus_aid: FocusAid::Off,
            moves: Vec::new(),
            target: None,
            drawn: None,
            choice: Choice::default(),
            pace: Pace::new(software),
            changed: Instant::now(),
            is_at_rest: false,
        }
    }

    /// Takes the image that is drawn behind scenes whose background it is.
    pub fn set_sky(&mut self, sky: Option<Arc<GpuSky>>) {
        if self.sky.as_ref().map(Arc::as_ptr) != sky.as_ref().map(Arc::as_ptr) {
            self.sky = sky;
            self.drawn = None;
        }
    }

    /// What of the focus is shown from now on.
    pub fn set_focus_aid(&mut self, aid: FocusAid) {
        self.focus_aid = aid;
    }

    /// Draws objects as moved since their triangles were prepared, by their place in the scene, from now on.
    pub fn set_moves(&mut self, moves: Vec<Option<Move>>) {
        self.moves = moves;
    }

    /// Draws `scene` with the triangles of `geometry` as a picture of `size` pixels, unless it already shows just that.
    /// The frame is the one of `scene.render`'s picture, stretched where `size` has another ratio. Where all triangles are too many for
    /// the device, they are drawn more coarsely, see [`Preview::omission`].
    ///
    /// Returns the texture, and whether it is a new one (the first, or one of another size). `None` where the camera is
    /// none (eye on target, for instance).
    pub fn draw(
        &mut self,
        scene: &Scene,
        geometry: &Arc<GpuGeometry>,
        size: [u32; 2],
    ) -> Option<(&wgpu::TextureView, bool)> {
        let size = self.clamped(size);
        let wanted = self.wanted(scene, geometry)?;
        let is_new = self
            .target
            .as_ref()
            .is_none_or(|target| target.size != size);
        if is_new {
            self.target = Some(Target::new(&self.device, size, self.samples));
        }
        if is_new || self.drawn.as_ref() != Some(&wanted) {
            (self.changed, self.is_at_rest) = (Instant::now(), false);
            self.choice = self.chosen(scene, geometry, size, true)?;
            self.upload(&wanted);
            self.submit_color(&wanted.geometry);
            self.drawn = Some(wanted);
        } else if self.rests_in() == Some(Duration::ZERO) {
            self.is_at_rest = true;
            let choice = self.chosen(scene, geometry, size, false)?;
            if choice != self.choice {
                self.choice = choice;
                self.submit_color(geometry);
            }
            self.measure_pace(geometry, size);
        }
        Some((&self.target.as_ref()?.color_view, is_new))
    }

    /// What the drawn picture leaves out of what is in sight.
    #[must_use]
    pub fn omission(&self) -> Omission {
        self.choice.omission
    }

    /// When drawing the same again will show more of it, as nothing changes any more; `None` where there is no more to show.
    #[must_use]
    pub fn rests_in(&self) -> Option<Duration> {
        let can_gain = self.choice.omission.is_any() && !self.is_at_rest;
        can_gain.then(|| pace::REST.saturating_sub(self.changed.elapsed()))
    }

    /// What to draw of `scene`, while what is seen changes or once it rests; `None` where the camera is none.
    fn chosen(
        &self,
        scene: &Scene,
        geometry: &GpuGeometry,
        [_, height]: [u32; 2],
        is_moving: bool,
    ) -> Option<Choice> {
        let frame = &geometry.frame;
        let picture = uniforms::picture_size(scene);
        let ratio = picture.width / picture.height;
        let sight = Sight::new(&scene.camera, frame, ratio, f64::from(height))?;
        let most = self.pace.triangles(is_moving);
        let eye = (scene.camera.eye, frame);
        Some(geometry.stock.choose(&sight, eye, &self.moves, most))
    }

    /// The drawn picture in sRGB, rows from the top. It waits for the GPU: for tests.
    ///
    /// # Errors
    /// What the GPU says, or that nothing has been drawn.
    pub fn read_color(&self) -> Result<Vec<[u8; 4]>, String> {
        let target = self.target.as_ref().ok_or("nothing has been drawn")?;
        target::read_back(&self.device, &self.queue, &target.color)
    }

    /// For every pixel of a picture of `size`, rows from the top, the object whose surface is nearest at the pixel's
    /// centre. It waits for the GPU: for tests.
    ///
    /// # Errors
    /// What the GPU says, or that the camera is none.
    pub fn object_ids(
        &mut self,
        scene: &Scene,
        geometry: &Arc<GpuGeometry>,
        size: [u32; 2],
    ) -> Result<Vec<Option<usize>>, String> {
        let wanted = self
            .wanted(scene, geometry)
            .ok_or("the camera has no direction")?;
        self.upload(&wanted);
        self.drawn = None;
        let target = IdTarget::new(&self.device, size);
        let commands = self.id_commands(geometry, &geometry.stock.all(), &target);
        self.queue.submit([commands]);
        let ids = target::read_back(&self.device, &self.queue, &target.ids)?;
        Ok(ids
            .into_iter()
            .map(|bytes| (u32::from_le_bytes(bytes) as usize).checked_sub(1))
            .collect())
    }

    /// Everything the picture of `scene` depends on; `None` where the camera is none.
    fn wanted(&self, scene: &Scene, geometry: &Arc<GpuGeometry>) -> Option<Drawn> {
        let frame = &geometry.frame;
        let view = ViewUniform::new(scene, frame, &geometry.bounds, self.focus_aid)?;
        Some(Drawn {
            geometry: Arc::clone(geometry),
            view: Box::new(view),
            sky: SkyUniform::new(scene, self.sky.as_deref()),
            objects: ObjectUniform::of_scene(scene, geometry, &self.moves),
        })
    }

    /// A size this GPU can draw, with the same ratio as far as possible.
    fn clamped(&self, [width, height]: [u32; 2]) -> [u32; 2] {
        let most = self.device.limits().max_texture_dimension_2d;
        [width.clamp(1, most), height.clamp(1, most)]
    }

    /// Hands the GPU everything but the triangles.
    fn upload(&mut self, wanted: &Drawn) {
        let view: &ViewUniform = &wanted.view;
        self.queue
            .write_buffer(&self.pipelines.view, 0, bytemuck::bytes_of(view));
        let sky_image = &mut self.pipelines.sky_image;
        sky_image.update(&self.device, &self.queue, &wanted.sky, self.sky.as_ref());
        let count = wanted.objects.len();
        if self.objects.as_ref().is_none_or(|room| room.count < count) {
            let room = count.max(1).next_power_of_two();
            self.objects = Some(self.pipelines.object_uniforms(&self.device, room));
        }
        if let Some(objects) = &self.objects {
            objects.write(&self.queue, &wanted.objects);
        }
    }

    /// What draws which object is where.
    fn id_commands(
        &self,
        geometry: &GpuGeometry,
        picks: &[Pick],
        target: &IdTarget,
    ) -> wgpu::CommandBuffer {
        let mut encoder = self
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = begin_pass(
                &mut encoder,
                &target.ids_view,
                None,
                &target.depth,
                wgpu::Color::TRANSPARENT,
            );
            let pipeline = &self.pipelines.object_ids;
            self.draw_objects(&mut pass, pipeline, (geometry, picks), false);
        }
        encoder.finish()
    }

    /// Finds out how long what is drawn takes the device, but for its pixels.
    fn measure_pace(&self, geometry: &GpuGeometry, size: [u32; 2]) {
        let few = size.map(|side| (side / 4).max(1));
        let target = IdTarget::new(&self.device, few);
        let Choice {
            picks, triangles, ..
        } = &self.choice;
        let commands = self.id_commands(geometry, picks, &target);
        self.pace
            .measure(&self.device, &self.queue, *triangles, commands);
    }

    /// Draws sky and objects into the target.
    fn submit_color(&self, geometry: &GpuGeometry) {
        let Some(target) = &self.target else { return };
        let mut encoder = self
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let (view, resolve) = match &target.samples {
                Some(samples) => (samples, Some(&target.color_view)),
                None => (&target.color_view, None),
            };
            let mut pass = begin_pass(
                &mut encoder,
                view,
                resolve,
                &target.depth,
                wgpu::Color::BLACK,
            );
            pass.set_pipeline(&self.pipelines.sky);
            pass.set_bind_group(0, &self.pipelines.bind_group, &[]);
            pass.set_bind_group(1, &self.pipelines.sky_image.bind_group, &[]);
            pass.draw(0..3, 0..1);
            let drawn = (geometry, &*self.choice.picks);
            self.draw_objects(&mut pass, &self.pipelines.objects, drawn, true);
            self.draw_painted_objects(&mut pass, drawn);
        }
        self.queue.submit([encoder.finish()]);
    }

    fn draw_objects(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipeline: &wgpu::RenderPipeline,
        (geometry, picks): (&GpuGeometry, &[Pick]),
        only_plain: bool,
    ) {
        let Some(objects) = &self.objects else {
            return;
        };
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &self.pipelines.bind_group, &[]);
        pass.set_bind_group(1, &self.pipelines.sky_image.bind_group, &[]);
        let choose = |pass: &mut wgpu::RenderPass<'_>, index| objects.choose(pass, index);
        geometry.draw(pass, picks, only_plain, choose);
    }

    /// Draws the objects over which images or colours vary, into the pass that has drawn the others.
    fn draw_painted_objects(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        (geometry, picks): (&GpuGeometry, &[Pick]),
    ) {
        let Some(objects) = self.objects.as_ref().filter(|_| geometry.is_painted()) else {
            return;
        };
        let draw = |pass: &mut wgpu::RenderPass<'_>, pipeline, with_normals| {
            pass.set_pipeline(pipeline);
            geometry.draw_painted(pass, picks, with_normals, |pass, index, coat| {
                objects.choose(pass, index);
                pass.set_bind_group(3, &coat.bind_group, &[]);
            });
        };
        draw(pass, &self.pipelines.painted_objects, false);
        if geometry.has_normals() {
            draw(pass, &self.pipelines.embossed_objects, true);
        }
    }
}

/// A pass that clears its target to `clear` and its depth to infinitely far.
fn begin_pass<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    view: &wgpu::TextureView,
    resolve_target: Option<&wgpu::TextureView>,
    depth: &wgpu::TextureView,
    clear: wgpu::Color,
) -> wgpu::RenderPass<'a> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("preview"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(clear),
                store: wgpu::StoreOp::Store,
            },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: depth,
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(0.0),
                store: wgpu::StoreOp::Discard,
            }),
            stencil_ops: None,
        }),
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    })
}

/// The colour that tells object `index` from the others.
#[must_use]
pub fn object_color(index: usize) -> DVec3 {
    // Golden-angle hues keep neighbours apart.
    let hue = (index as f64 * 0.618_033_988_749_895).fract() * 6.0;
    let channel = |offset: f64| {
        let x = (hue + offset).rem_euclid(6.0);
        ((x - 3.0).abs() - 1.0).clamp(0.0, 1.0) * 0.7 + 0.2
    };
    DVec3::new(channel(0.0), channel(4.0), channel(2.0))
}

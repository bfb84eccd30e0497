//! The preview's texture as egui shows it.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use eframe::{egui_wgpu, wgpu};

use super::focus::FocusAid;
use super::preview::Preview;
use super::preview::choice::Omission;
use super::preview::geometry::GpuGeometry;
use super::preview::sky::GpuSky;
use super::worker::Gpu;
use crate::scene::{Move, Scene};

/// How many devices there were.
static DEVICES: AtomicU64 = AtomicU64::new(0);

/// A preview and its place among egui's textures.
pub struct PreviewImage {
    preview: Preview,
    render_state: egui_wgpu::RenderState,
    is_software: bool,
    texture: Option<egui::TextureId>,
    /// See [`Gpu::number`].
    number: u64,
    faults: Arc<Mutex<Vec<String>>>,
    loss: Arc<Mutex<Option<String>>>,
}

impl PreviewImage {
    /// A preview on the GPU that draws the window `ctx`. From now on faults of the GPU, such as a lack of memory, do not end the
    /// program: see [`PreviewImage::take_faults`] and [`PreviewImage::loss`].
    #[must_use]
    pub fn new(render_state: &egui_wgpu::RenderState, ctx: &egui::Context) -> Self {
        let loss = Arc::new(Mutex::new(None));
        let (sink, window) = (Arc::clone(&loss), ctx.clone());
        let told = move |reason, message: String| {
            let message = message.trim().trim_end_matches('.');
            let text = match reason {
                _ if !message.is_empty() => message.to_owned(),
                wgpu::DeviceLostReason::Destroyed => "it was shut down".to_owned(),
                wgpu::DeviceLostReason::Unknown => "it does not say why".to_owned(),
            };
            *sink.lock().unwrap_or_else(PoisonError::into_inner) = Some(text);
            window.request_repaint();
        };
        render_state.device.set_device_lost_callback(told);
        let faults = Arc::new(Mutex::new(Vec::new()));
        let sink = Arc::clone(&faults);
        render_state
            .device
            .on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
                let mut faults = sink.lock().unwrap_or_else(PoisonError::into_inner);
                faults.push(error.to_string());
            }));
        let is_software = render_state.adapter.get_info().device_type == wgpu::DeviceType::Cpu;
        let (device, queue) = (render_state.device.clone(), render_state.queue.clone());
        Self {
            preview: Preview::new(device, queue, is_software),
            render_state: render_state.clone(),
            is_software,
            texture: None,
            number: DEVICES.fetch_add(1, Ordering::Relaxed),
            faults,
            loss,
        }
    }

    /// Asks the driver whether the device is still there: it tells when it is asked for something.
    pub fn ask_driver(&self) {
        // What it says comes to `loss`.
        let _ = self.device().poll(wgpu::PollType::Poll);
    }

    /// Why the device is of no use any more, as far as its driver has said; `None` as long as it is there.
    #[must_use]
    pub fn loss(&self) -> Option<String> {
        self.loss
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }

    /// The device and its queue, for workers that upload triangles and images.
    #[must_use]
    pub fn gpu(&self) -> Gpu {
        Gpu {
            device: self.render_state.device.clone(),
            queue: self.render_state.queue.clone(),
            number: self.number,
        }
    }

    /// The number of the device.
    #[must_use]
    pub fn device_number(&self) -> u64 {
        self.number
    }

    /// The device.
    #[must_use]
    pub fn device(&self) -> &wgpu::Device {
        &self.render_state.device
    }

    /// What the GPU has complained about since this was last asked.
    #[must_use]
    pub fn take_faults(&self) -> Vec<String> {
        std::mem::take(&mut self.faults.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Whether the processor draws the window.
    #[must_use]
    pub fn is_software(&self) -> bool {
        self.is_software
    }

    /// Shows objects as moved since their triangles were prepared, and what of the focus is asked for, from now on.
    pub fn set_aids(&mut self, moves: Vec<Option<Move>>, focus: FocusAid) {
        self.preview.set_moves(moves);
        self.preview.set_focus_aid(focus);
    }

    /// What the texture leaves out of what is in sight.
    #[must_use]
    pub fn omission(&self) -> Omission {
        self.preview.omission()
    }

    /// When showing the same again will show more of it; `None` where there is no more to show.
    #[must_use]
    pub fn rests_in(&self) -> Option<Duration> {
        self.preview.rests_in()
    }

    /// The texture that shows `scene` in `size` pixels, before `sky` where its background is that image; `None` where its
    /// camera is none.
    pub fn show(
        &mut self,
        scene: &Scene,
        geometry: &Arc<GpuGeometry>,
        sky: Option<&Arc<GpuSky>>,
        size: [u32; 2],
    ) -> Option<egui::TextureId> {
        self.preview.set_sky(sky.cloned());
        let (view, is_new) = self.preview.draw(scene, geometry, size)?;
        let device = &self.render_state.device;
        let filter = wgpu::FilterMode::Linear;
        match self.texture {
            Some(id) if is_new => self
                .render_state
                .renderer
                .write()
                .update_egui_texture_from_wgpu_texture(device, view, filter, id),
            Some(_) => {}
            None => {
                let mut renderer = self.render_state.renderer.write();
                self.texture = Some(renderer.register_native_texture(device, view, filter));
            }
        }
        self.texture
    }
}

impl std::fmt::Debug for PreviewImage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("PreviewImage")
            .field("preview", &self.preview)
            .field("texture", &self.texture)
            .finish_non_exhaustive()
    }
}

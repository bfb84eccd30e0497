//! Looking closely at a picture: what is under the mouse, and how bright it is.

use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{Pos2, Rect, Ui};

use super::App;
use crate::accel::Visits;
use crate::gui::compare::Seen;
use crate::gui::document::same_geometry;
use crate::gui::event::Event;
use crate::gui::histogram::Histogram;
use crate::gui::inspector::{Inspected, Surface};
use crate::gui::jobs::Lane;
use crate::gui::look::Channels;
use crate::gui::orbit::PictureSize;
use crate::gui::pick;
use crate::gui::picture::Picture;
use crate::gui::picture_buffer::PictureId;
use crate::gui::viewport;
use crate::math::DVec2;
use crate::render::{Layer, PreparedGeometry};
use crate::scene::{Display, Scene};

/// Time between two histograms of a picture that still changes.
const INTERVAL: Duration = Duration::from_secs(1);

/// The histogram, and what it was made of.
#[derive(Debug, Default)]
pub struct Brightness {
    /// As far as it is known.
    pub histogram: Option<Histogram>,
    source: Option<Source>,
}

/// What a histogram was made of.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Source {
    picture: PictureId,
    is_running: bool,
    display: Display,
    layer: Option<Layer>,
    channels: Channels,
    at: Instant,
}

impl Source {
    /// Whether the histogram of `self` still holds for `now`.
    fn holds_for(&self, now: &Self) -> bool {
        let key = |source: &Self| {
            (
                source.picture,
                source.is_running,
                source.display,
                source.layer,
                source.channels,
            )
        };
        key(self) == key(now) && !(now.is_running && now.at.duration_since(self.at) > INTERVAL)
    }
}

/// The size of the picture of `scene`, and the middle of a pixel of it.
fn middle_of(scene: &Scene, [x, y]: [u32; 2]) -> (PictureSize, DVec2) {
    let size = PictureSize {
        width: scene.render.width.into(),
        height: scene.render.height.into(),
    };
    let position = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
    (size, position)
}

/// What is seen of `scene` at a place of its picture.
fn surface_at(
    geometry: &PreparedGeometry,
    scene: &Scene,
    size: PictureSize,
    place: DVec2,
) -> Option<Surface> {
    let picked = pick::pick(geometry, &scene.camera, &scene.render, size, place)?;
    let object = scene.objects.get(picked.object)?;
    let name = if object.name.is_empty() {
        format!("object {}", picked.object + 1)
    } else {
        object.name.clone()
    };
    let material = object.material.clone();
    Some(Surface {
        object: name,
        material: material.unwrap_or_else(|| "default grey".to_owned()),
        triangle: picked.triangle,
        distance: picked.point.distance(scene.camera.eye),
        normal: picked.normal,
    })
}

impl App {
    /// Where the mouse is, unless something lies over the central area there.
    fn free_position(&self, ui: &Ui) -> Option<Pos2> {
        let position = ui.input(|input| input.pointer.hover_pos());
        let is_free = self.dialog.is_none();
        position.filter(|&position| {
            let layer = ui.ctx().layer_id_at(position);
            is_free && layer.is_none_or(|layer| layer == ui.layer_id())
        })
    }

    /// Takes note of what of the preview, which is in `frame` and `visible` there, is under the mouse.
    pub(super) fn look_ui(&mut self, ui: &Ui, visible: Rect, frame: Rect) {
        let position = self.free_position(ui);
        let position = position.filter(|&position| visible.contains(position));
        let is_busy = ui.input(|input| input.pointer.any_down());
        let state = self.prepared.as_ref().filter(|_| self.is_prepared());
        self.seen = position.filter(|_| !is_busy).and_then(|position| {
            let size = viewport::picture_size(frame);
            let offset = position - frame.min;
            let place = DVec2::new(offset.x.into(), offset.y.into());
            let geometry = &state?.placed.geometry;
            surface_at(geometry, &self.document.scene, size, place)
        });
    }

    /// Takes note of what the picture on the screen, of which `visible` is seen, holds under the mouse.
    pub(super) fn inspect_ui(&mut self, ui: &Ui, visible: Rect) {
        let position = self.free_position(ui);
        self.inspected = position.and_then(|position| self.inspect(position, visible));
    }

    fn inspect(&self, position: Pos2, visible: Rect) -> Option<Inspected> {
        let picture = self.picture_on_screen()?;
        let pixel = self.zoom.pixel_at(position)?;
        let share = self.zoom.share_at(position)?;
        let values = picture.buffer.values_at(pixel)?;
        let comparison = self.comparison.as_ref();
        let other = comparison.and_then(|comparison| comparison.light_at(share));
        let seen = comparison.map_or(Seen::Itself(values.color), |comparison| {
            comparison.seen_at(position, visible, share, (&picture.buffer, values.color))
        });
        Some(Inspected {
            pixel,
            values,
            samples: picture.samples(),
            other,
            seen,
            surface: self.surface_at(picture, pixel),
            visits: self.visits_at(picture, pixel),
        })
    }

    /// What the ray through the middle of a pixel of `picture` visits, where the structure is still that it was made with.
    fn visits_at(&self, picture: &Picture, pixel: [u32; 2]) -> Option<Visits> {
        let state = self.prepared.as_ref().filter(|_| self.is_prepared())?;
        let scene = &picture.scene;
        same_geometry(&state.scene, scene).then(|| {
            let (size, position) = middle_of(scene, pixel);
            let geometry = &state.placed.geometry;
            pick::visits(geometry, &scene.camera, &scene.render, size, position)
        })
    }

    /// The surface in the middle of a pixel of `picture`, where the triangles are still those it was made of.
    fn surface_at(&self, picture: &Picture, pixel: [u32; 2]) -> Option<Surface> {
        // Before the structure is there, every triangle is looked at.
        let state = self.prepared.as_ref().filter(|_| self.is_prepared())?;
        let scene = &picture.scene;
        if !same_geometry(&state.scene, scene) {
            return None;
        }
        let (size, position) = middle_of(scene, pixel);
        surface_at(&state.placed.geometry, scene, size, position)
    }

    /// Has the histogram of the picture on the screen made, where it is not known.
    pub(super) fn update_histogram(&mut self) {
        let Some(picture) = self.picture_on_screen() else {
            self.brightness = Brightness::default();
            return;
        };
        let now = Source {
            picture: picture.buffer.id(),
            is_running: picture.is_running(),
            display: picture.scene.display,
            layer: self.shown_layer,
            channels: self.channels,
            at: Instant::now(),
        };
        let is_known = self.brightness.source.is_some_and(|s| s.holds_for(&now));
        if is_known || self.jobs.is_busy(Lane::Histogram) {
            return;
        }
        let buffer = Arc::clone(&picture.buffer);
        self.brightness.source = Some(now);
        self.jobs.start(Lane::Histogram, move |job| {
            job.send(Event::HistogramMade(buffer.histogram()));
        });
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use egui_kittest::kittest::Queryable as _;

    use super::*;
    use crate::gui::app::testing;
    use crate::gui::opened_picture::OpenedPicture;
    use crate::gui::picture_buffer::PictureBuffer;
    use crate::render::Image;

    /// A single pixel among half a million that is not finite is counted, and shown by a click.
    #[test]
    fn a_pixel_that_is_not_finite_is_found() {
        let mut window = testing::window(None);
        let render = &mut window.state_mut().document.scene.render;
        (render.width, render.height) = (960, 540);
        let mut image = Image::black(960, 540);
        image.pixels[311 * 960 + 407] = [0.0, f32::NAN, 0.0];
        let buffer = PictureBuffer::of_image(image, Display::default());
        let opened = OpenedPicture {
            buffer: Arc::new(buffer),
            hash: None,
            hash_before: None,
            error: None,
            without_layers: None,
        };
        window
            .state_mut()
            .show_opened(Path::new("dark.exr"), opened);
        testing::until(&mut window, |app| app.brightness.histogram.is_some());
        window.run_steps(2);
        let told = "0 % of the picture is cut off at white; 1 pixel is not finite, in magenta";
        assert!(window.query_by_label(told).is_some());
        let show = "Show the first pixel that is not finite";
        window.get_by_label(show).click_accesskit();
        window.run_steps(3);
        let zoom = &window.state().zoom;
        assert!(zoom.scale() >= 16.0);
        let viewport = window.get_by_label("Viewport").rect();
        assert_eq!(zoom.pixel_at(viewport.center()), Some([407, 311]));
    }
}

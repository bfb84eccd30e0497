//! What renders are called: by what sets each apart from the one before it.

use super::App;
use crate::gui::error_plot::name_of_render;
use crate::gui::picture::Picture;
use crate::scene::Scene;

impl App {
    /// What the render that starts now is called among those of this session. One that it takes the place of was none.
    pub(super) fn name_of_next_picture(&self) -> String {
        let present = self
            .picture
            .as_ref()
            .filter(|picture| !picture.is_replaced());
        let present = present.map(|picture| (picture.scene_name.as_str(), &picture.scene));
        self.name_of_picture_after(&self.document.scene, present.or(self.last_past_scene()))
    }

    /// What a render of `scene`, which has the name of that being edited, is called after one of the scene `before`, with its name.
    pub(super) fn name_of_picture_after(
        &self,
        scene: &Scene,
        before: Option<(&str, &Scene)>,
    ) -> String {
        let name = name_of_render(self.document.name(), scene, before);
        if self.wanted_part().is_whole() {
            name
        } else {
            format!("{name}, region")
        }
    }

    /// The last render before the present one, as its scene's name and scene.
    pub(super) fn last_past_scene(&self) -> Option<(&str, &Scene)> {
        let last = self.renders.entries().last()?;
        Some((last.facts.scene_name.as_str(), &last.scene))
    }

    /// Calls the running picture by the samples it has `taken` on average, where it has more than the rules allow that it ends by: it had them
    /// before those were set.
    pub(super) fn name_by_samples(&mut self, taken: f64) {
        let file = self.document.file_number();
        let has_more = |p: &&Picture| {
            p.is_running() && p.file == file && taken > f64::from(p.scene.render.samples_per_pixel)
        };
        let Some(picture) = self.picture.as_ref().filter(has_more) else {
            return;
        };
        let mut scene = picture.scene.clone();
        scene.render.samples_per_pixel = whole_samples(taken);
        let name = self.name_of_picture_after(&scene, self.last_past_scene());
        if let Some(picture) = &mut self.picture {
            picture.name = name;
        }
    }
}

/// A mean number of samples of a pixel, to the nearest whole one.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "no pixel has more than a u32 counts"
)]
fn whole_samples(mean: f64) -> u32 {
    mean.round() as u32
}

//! What renders are called: by what sets each apart from the one before it.

use super::App;
use crate::gui::error_plot::name_of_render;
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

    /// Calls the picture, which is finished, by the samples it has, where they are more than the rules allow that it ended by: it had them
    /// before those were set.
    pub(super) fn name_by_samples(&mut self) {
        let file = self.document.file_number();
        let Some(picture) = self.picture.as_ref().filter(|p| p.file == file) else {
            return;
        };
        let render = picture.settings_to_repeat();
        if render == picture.scene.render {
            return;
        }
        let scene = picture.scene_to_repeat();
        let name = self.name_of_picture_after(&scene, self.last_past_scene());
        if let Some(picture) = &mut self.picture {
            picture.name = name;
        }
    }
}

//! By which rules a render ends: other ones while it runs, and going on by other ones after it has ended.

use super::{App, WaitingRender};
use crate::gui::document::same_picture_but_render;
use crate::gui::picture::Picture;
use crate::render::StopRules;

impl App {
    /// Takes note of rules to end a render by that were set in the window since they were those `before`.
    pub(super) fn note_asked_rules(&mut self, before: StopRules) {
        let rules = StopRules::of(&self.document.scene.render);
        if rules != before {
            self.asked_rules = Some(rules);
        }
    }

    /// Has the running render end by the rules that the scene holds now, where nothing else was edited and they were set for it. What
    /// brought others back, such as undoing, was not about it; but a picture that follows every change follows that too.
    pub(super) fn take_over_rules(&mut self) {
        let rules = StopRules::of(&self.document.scene.render);
        let is_asked = self.asked_rules.take() == Some(rules);
        if !(is_asked || self.is_live) || !self.goes_by_other_rules() {
            return;
        }
        let name = self.name_of_picture_after(&self.document.scene, self.last_past_scene());
        if let Some(picture) = &mut self.picture {
            picture.end_by(rules, name);
        }
    }

    /// Whether a render runs that differs from the scene as it is in nothing but the rules by which it ends.
    fn goes_by_other_rules(&self) -> bool {
        let rules = StopRules::of(&self.document.scene.render);
        let is_other = |p: &Picture| p.is_running() && StopRules::of(&p.scene.render) != rules;
        let picture = self.picture.as_ref().filter(|p| is_other(p));
        picture.is_some_and(|picture| self.differs_in_rules_alone(picture))
    }

    /// `news` of a scene that was brought back, and that the running render is left alone, where the two differ in when it ends.
    pub(super) fn with_note_on_rules(&self, news: String) -> String {
        if self.goes_by_other_rules() && !self.is_live {
            format!("{news}. The running render keeps its own stop rules")
        } else {
            news
        }
    }

    /// Whether `picture` is of the scene and the part of it that are edited now but for the rules by which its render ends, and could go on by
    /// those of now.
    pub(super) fn differs_in_rules_alone(&self, picture: &Picture) -> bool {
        let (scene, now) = (&picture.scene, &self.document.scene);
        let rules = StopRules::of(&now.render);
        let mut render = scene.render.clone();
        rules.put_into(&mut render);
        picture.buffer.part() == self.wanted_part()
            && render == now.render
            && rules.suit(&scene.render)
            && scene.camera == now.camera
            && same_picture_but_render(scene, now)
    }

    /// Whether the render that ended can go on with its samples, by the rules as they are now.
    pub(super) fn can_continue(&self) -> bool {
        let rules = StopRules::of(&self.document.scene.render);
        self.invalid.is_none()
            && self.waiting_render.is_none()
            && !self.report.is_running()
            && self.picture.as_ref().is_some_and(|picture| {
                picture.reached().is_there()
                    && picture.would_go_on_by(&rules)
                    && self.differs_in_rules_alone(picture)
                    && picture.scene.output.layers == self.document.scene.output.layers
            })
    }

    /// Goes on with the render that ended, as soon as its geometry is there.
    pub(super) fn continue_render(&mut self) {
        if self.can_continue() {
            self.ask_for(WaitingRender {
                continues: true,
                ..WaitingRender::new()
            });
        }
    }
}

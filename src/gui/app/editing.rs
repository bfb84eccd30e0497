//! Undoing, copying, duplicating and removing.

use egui::text::{CCursor, CCursorRange};
use egui::text_edit::TextEditState;

use super::App;
use crate::gui::commands::Command;
use crate::gui::edit;
use crate::gui::orbit;
use crate::gui::panels::NAME_FIELD;
use crate::gui::selection::Selection;
use crate::gui::top_bar::EditState;
use crate::scene::Camera;

impl App {
    /// What the menu Edit offers.
    pub(super) fn edit_state(&self) -> EditState<'_> {
        let scene = &self.document.scene;
        let is_part = edit::name_of(scene, &self.selection).is_some();
        let history = self.document.undo_history();
        EditState {
            undo: history.next_undo(),
            redo: history.next_redo(),
            can_copy: is_part,
            can_rename: is_part && self.selection.has_name(),
            can_remove: is_part && edit::is_removable(scene, &self.selection),
            can_paste: self.clipboard.is_some(),
        }
    }

    /// Carries out a command of the menu Edit; returns whether it is one.
    pub(super) fn carry_out_edit(&mut self, ctx: &egui::Context, command: Command) -> bool {
        match command {
            Command::Undo => self.undo(),
            Command::Redo => self.redo(),
            Command::Copy => self.copy(ctx),
            Command::Paste => {
                if let Some(part) = self.clipboard.clone() {
                    self.selection = edit::paste(&mut self.document.scene, part);
                    self.show_camera_view();
                }
            }
            Command::Duplicate => {
                let copy = edit::duplicate(&mut self.document.scene, &self.selection);
                self.select(copy);
            }
            Command::Rename => {
                self.panel_open = true;
                let field = egui::Id::unique(NAME_FIELD);
                ctx.memory_mut(|memory| memory.request_focus(field));
                let all = CCursorRange::two(CCursor::new(0), CCursor::new(usize::MAX));
                let mut state = TextEditState::load(ctx, field).unwrap_or_default();
                state.cursor.set_char_range(Some(all));
                state.store(ctx, field);
            }
            Command::Remove => {
                let next = edit::remove(&mut self.document.scene, &self.selection);
                self.select(next);
            }
            _ => return false,
        }
        true
    }

    fn select(&mut self, selection: Option<Selection>) {
        if let Some(selection) = selection {
            self.selection = selection;
        }
    }

    fn undo(&mut self) {
        let name = self.document.undo_history().next_undo();
        let news = format!("Undone: {}", name.unwrap_or_default());
        let before = (self.document.scene.camera, self.document.file_number());
        if let Some(selection) = self.document.undo() {
            self.show_restored(selection, before, news);
        }
    }

    fn redo(&mut self) {
        let name = self.document.undo_history().next_redo();
        let news = format!("Done again: {}", name.unwrap_or_default());
        let before = (self.document.scene.camera, self.document.file_number());
        if let Some(selection) = self.document.redo() {
            self.show_restored(selection, before, news);
        }
    }

    /// Shows what was restored; `before`: the camera, and the number of the file that the scene belonged to. Like any other move of the
    /// camera, one that is undone brings the preview back.
    fn show_restored(
        &mut self,
        selection: Selection,
        (camera_before, file_before): (Camera, usize),
        news: String,
    ) {
        if self.document.file_number() != file_before {
            self.show_other_scene();
        }
        self.selection = selection;
        if orbit::is_moved(&camera_before, &self.document.scene.camera) {
            self.show_camera_view();
        }
        self.messages.news_until_edit(self.with_note_on_rules(news));
    }

    fn copy(&mut self, ctx: &egui::Context) {
        let scene = &self.document.scene;
        let Some(name) = edit::name_of(scene, &self.selection) else {
            return;
        };
        self.clipboard = edit::copy(scene, &self.selection);
        self.messages.news(format!("Copied {name}"));
        // Pressing the keys for Paste is only heard of where the desktop's clipboard holds something.
        ctx.copy_text(name);
    }
}

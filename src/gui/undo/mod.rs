//! Undo and redo: the scene as it was after every edit.
//!
//! Scenes are plain data whose meshes and images are shared, so a step is a whole scene. One gesture is one step: what changes
//! while a button of the mouse is held, a text is typed or the wheel turns is taken together ([`Gesture`]). The oldest steps go
//! when there are too many, or when they hold too much memory that the scene itself no longer needs.

mod memory;
mod naming;

use std::collections::VecDeque;

pub use memory::bytes_beside;
pub use naming::name_of_change;

use super::document::same_scene;
use super::selection::Selection;
use crate::scene::Scene;

/// Steps that can be undone.
const MOST_STEPS: usize = 500;
/// Memory that steps may hold beside the scene, in bytes.
const MOST_BYTES: usize = 256 << 20;
/// Time after the last turn of the wheel that ends a gesture, in seconds.
const WHEEL_REST: f64 = 0.4;

/// A scene to go back to, and what was selected in it.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// The scene.
    pub scene: Scene,
    /// The selected part.
    pub selection: Selection,
    /// Number of the file, among those that were opened, that it belongs to.
    pub file: usize,
}

/// An edit: the scene on its other side.
#[derive(Clone, Debug)]
struct Step {
    snapshot: Snapshot,
    /// What the edit did, such as "moving the camera".
    name: String,
    /// What the snapshot holds that the scene beside it does not, in bytes.
    bytes: usize,
}

impl Step {
    fn new(snapshot: Snapshot, neighbour: &Scene, name: String) -> Self {
        let bytes = bytes_beside([&snapshot.scene], neighbour);
        Self {
            snapshot,
            name,
            bytes,
        }
    }
}

/// What was edited, and what was undone.
#[derive(Clone, Debug)]
pub struct UndoHistory {
    present: Snapshot,
    past: VecDeque<Step>,
    future: Vec<Step>,
}

impl UndoHistory {
    /// No edits of `scene` yet.
    #[must_use]
    pub fn new(scene: Scene) -> Self {
        let selection = Selection::default();
        Self {
            present: Snapshot {
                scene,
                selection,
                file: 0,
            },
            past: VecDeque::new(),
            future: Vec::new(),
        }
    }

    /// Takes note of the scene as it is now, once a gesture is over. What was undone before is forgotten as soon as something
    /// else is edited.
    pub fn record(&mut self, scene: &Scene, selection: &Selection) -> bool {
        self.record_as(scene, selection, None)
    }

    /// [`UndoHistory::record`], with a name for what was done where that is known better than it shows.
    pub fn record_as(
        &mut self,
        scene: &Scene,
        selection: &Selection,
        name: Option<String>,
    ) -> bool {
        if same_scene(&self.present.scene, scene) {
            if self.present.selection != *selection {
                self.present.selection = selection.clone();
            }
            return false;
        }
        let now = Snapshot {
            scene: scene.clone(),
            selection: selection.clone(),
            file: self.present.file,
        };
        let name = name.unwrap_or_else(|| name_of_change(&self.present.scene, scene));
        self.go_on(now, name);
        true
    }

    /// Takes note that `now` took the place of the scene as it was, by what is called `name`.
    pub fn go_on(&mut self, now: Snapshot, name: String) {
        let before = std::mem::replace(&mut self.present, now);
        let step = Step::new(before, &self.present.scene, name);
        self.past.push_back(step);
        self.future.clear();
        self.forget_oldest();
    }

    /// Whether undoing or doing again may lead to a scene of that file.
    #[must_use]
    pub fn leads_to(&self, file: usize) -> bool {
        let steps = self.past.iter().chain(&self.future);
        let mut snapshots = steps.map(|step| &step.snapshot).chain([&self.present]);
        snapshots.any(|snapshot| snapshot.file == file)
    }

    /// What undoing would take back, such as "moving the camera"; `None` where there is nothing.
    #[must_use]
    pub fn next_undo(&self) -> Option<&str> {
        self.past.back().map(|step| step.name.as_str())
    }

    /// What redoing would do again.
    #[must_use]
    pub fn next_redo(&self) -> Option<&str> {
        self.future.last().map(|step| step.name.as_str())
    }

    /// Goes back by one step.
    pub fn undo(&mut self) -> Option<&Snapshot> {
        let step = self.past.pop_back()?;
        let after = std::mem::replace(&mut self.present, step.snapshot);
        let redo = Step::new(after, &self.present.scene, step.name);
        self.future.push(redo);
        Some(&self.present)
    }

    /// Goes forward again by one step.
    pub fn redo(&mut self) -> Option<&Snapshot> {
        let step = self.future.pop()?;
        let before = std::mem::replace(&mut self.present, step.snapshot);
        let undo = Step::new(before, &self.present.scene, step.name);
        self.past.push_back(undo);
        Some(&self.present)
    }

    /// Changes the scene as it is and in every step.
    pub fn change_all(&mut self, change: impl Fn(&mut Scene)) {
        let steps = self.past.iter_mut().chain(&mut self.future);
        let snapshots = steps.map(|step| &mut step.snapshot);
        for snapshot in snapshots.chain([&mut self.present]) {
            change(&mut snapshot.scene);
        }
    }

    /// Forgets the oldest edits where there are too many.
    fn forget_oldest(&mut self) {
        let mut bytes: usize = self.past.iter().map(|step| step.bytes).sum();
        while self.past.len() > MOST_STEPS || bytes > MOST_BYTES {
            let Some(step) = self.past.pop_front() else {
                return;
            };
            bytes -= step.bytes;
        }
    }
}

/// Whether an edit goes on.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gesture {
    /// When the wheel last turned, in the seconds of egui's input.
    wheel_turned: Option<f64>,
}

impl Gesture {
    /// Whether the mouse, a text field or the wheel is still being used. Wakes the window when a turn of the wheel is over.
    pub fn goes_on(&mut self, ctx: &egui::Context) -> bool {
        let (time, is_turning, is_held) = ctx.input(|input| {
            let is_turning = input.is_scrolling() || input.zoom_delta() != 1.0;
            (input.time, is_turning, input.pointer.any_down())
        });
        if is_turning {
            self.wheel_turned = Some(time);
        }
        let rest = self
            .wheel_turned
            .map_or(0.0, |turned| turned + WHEEL_REST - time);
        if rest > 0.0 {
            ctx.request_repaint_after(std::time::Duration::from_secs_f64(rest));
        } else {
            self.wheel_turned = None;
        }
        is_held || rest > 0.0 || ctx.text_edit_focused()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::TriangleMesh;
    use crate::math::DVec3;
    use crate::scene::Light;
    use std::sync::Arc;

    fn moved(scene: &Scene, x: f64) -> Scene {
        let mut scene = scene.clone();
        scene.camera.eye.x = x;
        scene
    }

    #[test]
    fn edits_are_undone_and_done_again_until_another_is_made() {
        let first = Scene::default();
        let mut history = UndoHistory::new(first.clone());
        assert!(history.undo().is_none() && history.redo().is_none());
        let second = moved(&first, 1.0);
        let third = moved(&first, 2.0);
        for scene in [&second, &second, &third] {
            history.record(scene, &Selection::Camera);
        }
        assert_eq!(history.next_undo(), Some("moving the camera"));
        assert_eq!(history.undo().unwrap().scene, second);
        assert_eq!(history.undo().unwrap().scene, first);
        assert!(history.undo().is_none());
        assert_eq!(history.redo().unwrap().scene, second);
        // What is recorded now is what was restored: no new edit.
        history.record(&second, &Selection::Camera);
        assert_eq!(history.next_redo(), Some("moving the camera"));
        history.record(&moved(&first, 3.0), &Selection::Camera);
        assert!(history.redo().is_none());
        assert_eq!(history.undo().unwrap().scene, second);
    }

    #[test]
    fn undoing_selects_what_was_selected() {
        let mut scene = Scene {
            lights: vec![Light::Point {
                position: DVec3::ONE,
                intensity: DVec3::ONE,
            }],
            ..Scene::default()
        };
        let mut history = UndoHistory::new(scene.clone());
        history.record(&scene, &Selection::Light(0));
        scene.lights.clear();
        history.record(&scene, &Selection::Camera);
        assert_eq!(history.next_undo(), Some("removing light 1"));
        assert_eq!(history.undo().unwrap().selection, Selection::Light(0));
    }

    #[test]
    fn steps_are_bounded_in_number_and_in_memory() {
        let mut history = UndoHistory::new(Scene::default());
        for x in 0..MOST_STEPS + 10 {
            history.record(
                &moved(&Scene::default(), x as f64 + 1.0),
                &Selection::Camera,
            );
        }
        assert_eq!(history.past.len(), MOST_STEPS);

        let mut history = UndoHistory::new(Scene::default());
        let large = || TriangleMesh {
            positions: vec![DVec3::ZERO; MOST_BYTES / size_of::<DVec3>() / 2 + 1],
            ..TriangleMesh::default()
        };
        for index in 0..4 {
            let scene = Scene {
                meshes: [(format!("mesh {index}"), Arc::new(large()))].into(),
                ..Scene::default()
            };
            history.record(&scene, &Selection::Camera);
        }
        assert_eq!(history.past.len(), 1, "two such meshes are too many");
    }
}

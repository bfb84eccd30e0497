//! How soon an edit is seen with Live on.

use std::time::{Duration, Instant};

use egui::Key;

use super::super::figures::{RestartFigures, Spread};
use super::frames::FrameTime;
use super::hands::Hands;
use super::milliseconds;
use crate::gui::app::App;
use crate::gui::document::same_picture;
use crate::scene::{Light, Material, Mode, Rgb, Scene};

/// What the picture is left to itself before the next edit.
const REST: Duration = Duration::from_millis(300);

/// What is edited while Live is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edit {
    Camera,
    Light,
    Object,
    Material,
    Effect,
}

impl Edit {
    pub const ALL: [Self; 5] = [
        Self::Camera,
        Self::Light,
        Self::Object,
        Self::Material,
        Self::Effect,
    ];

    pub fn in_words(self) -> &'static str {
        match self {
            Self::Camera => "moving the camera",
            Self::Light => "changing a light",
            Self::Object => "moving an object",
            Self::Material => "changing a material",
            Self::Effect => "switching an effect",
        }
    }

    /// Changes `scene` a little; whether there was something to change.
    fn make(self, scene: &mut Scene) -> bool {
        let step = scene.camera.eye.distance(scene.camera.target) * 1e-3;
        match self {
            Self::Camera => scene.camera.eye.x += step,
            Self::Light => match scene.lights.first_mut() {
                Some(
                    Light::Point {
                        intensity: emission,
                        ..
                    }
                    | Light::Disk {
                        radiance: emission, ..
                    },
                ) => {
                    *emission *= 1.001;
                }
                None => return false,
            },
            Self::Object => match scene.objects.first_mut() {
                Some(object) => object.translate.x += step,
                None => return false,
            },
            Self::Material => {
                let mut materials = scene.materials.values_mut();
                let diffuse = materials.find_map(|material| match material {
                    Material::Phong { diffuse, .. } if *diffuse != Rgb::ZERO => Some(diffuse),
                    _ => None,
                });
                match diffuse {
                    Some(diffuse) => *diffuse *= 0.999,
                    None => return false,
                }
            }
            Self::Effect => {
                let settings = &mut scene.render;
                // Each mode has one of them that it uses.
                let switch = match settings.mode {
                    Mode::Direct => &mut settings.ambient_occlusion.enabled,
                    _ => &mut settings.antialiasing,
                };
                *switch = !*switch;
            }
        }
        true
    }
}

/// What edits of one kind took, in milliseconds.
#[derive(Debug, Default)]
pub struct RestartTimes {
    tiles: Vec<f64>,
    screens: Vec<f64>,
    layout_cpu: Vec<f64>,
    own_cpu: Vec<f64>,
}

impl RestartTimes {
    /// Counts a frame between the edit and what shows it.
    fn push_frame(&mut self, frame: FrameTime) {
        self.layout_cpu.extend(frame.layout_cpu.map(milliseconds));
        self.own_cpu.extend(frame.own_cpu.map(milliseconds));
    }

    /// What they took; `None` where there was nothing of the kind to edit.
    pub fn figures(self, edit: Edit) -> Option<RestartFigures> {
        (!self.tiles.is_empty()).then(|| RestartFigures {
            edit: edit.in_words(),
            tile_ms: Spread::of(self.tiles),
            screen_ms: Spread::of(self.screens),
            layout_cpu_ms: Spread::of(self.layout_cpu),
            own_cpu_ms: Spread::of(self.own_cpu),
        })
    }
}

/// An edit that the picture follows.
#[derive(Debug)]
pub struct Restart {
    pub edit: Edit,
    /// Whether Live goes off after it.
    is_last: bool,
    phase: Phase,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// Live is to be on, and the picture to have rested.
    Rest(Option<Instant>),
    Edited(Instant),
    /// The frame that shows the first tile is drawn.
    Shown(Instant),
}

impl Restart {
    pub fn new(edit: Edit, is_last: bool) -> Self {
        Self {
            edit,
            is_last,
            phase: Phase::Rest(None),
        }
    }

    /// Takes note of the last frame, where that was one between the edit and what shows it; returns whether it was.
    pub fn note(&self, last: FrameTime, times: &mut RestartTimes) -> bool {
        let is_between = matches!(self.phase, Phase::Edited(_) | Phase::Shown(_));
        if is_between {
            times.push_frame(last);
        }
        is_between
    }

    /// A frame begins; whether all is done.
    pub fn begin(&mut self, hands: &mut Hands<'_>, times: &mut RestartTimes) -> bool {
        match self.phase {
            Phase::Rest(None) => {
                if !hands.app.is_live() {
                    hands.press(Key::L);
                }
                self.phase = Phase::Rest(Some(Instant::now()));
                hands.wake_after(REST);
            }
            Phase::Rest(Some(since)) => {
                if shows_present(hands.app) && since.elapsed() >= REST {
                    self.phase = Phase::Edited(Instant::now());
                    // As every edit does, it comes with something from the mouse.
                    hands.point_at(hands.middle());
                    let is_there = self.edit.make(&mut hands.app.document_mut().scene);
                    // Where there is nothing to edit, nothing is measured.
                    if !is_there {
                        self.end_live(hands);
                        return true;
                    }
                }
                hands.wake_after(REST);
            }
            // The window is left to itself: what the render sends wakes it.
            Phase::Edited(_) => hands.wake_after(REST),
            Phase::Shown(asked) => {
                times.screens.push(milliseconds(asked.elapsed()));
                self.end_live(hands);
                return true;
            }
        }
        false
    }

    /// Switches Live off after the last edit.
    fn end_live(&self, hands: &mut Hands<'_>) {
        if self.is_last {
            hands.press(Key::L);
            hands.press(Key::Escape);
        }
    }

    /// A frame is laid out: takes note when it has the first tile.
    pub fn end(&mut self, app: &App, ctx: &egui::Context, times: &mut RestartTimes) {
        if let Phase::Edited(asked) = self.phase
            && shows_present(app)
        {
            times.tiles.push(milliseconds(asked.elapsed()));
            self.phase = Phase::Shown(asked);
            ctx.request_repaint();
        }
    }
}

/// Whether a tile of the scene as it is has come.
fn shows_present(app: &App) -> bool {
    app.picture().is_some_and(|picture| {
        picture.first_tile.is_some() && same_picture(&picture.scene, &app.document().scene)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::demo_scene;

    #[test]
    fn every_edit_makes_another_picture_and_none_an_invalid_one() {
        let mut scene = demo_scene();
        for edit in Edit::ALL.repeat(3) {
            let before = scene.clone();
            assert!(edit.make(&mut scene), "{edit:?}");
            assert!(!same_picture(&before, &scene), "{edit:?}");
            assert_eq!(scene.validate(), Ok(()), "{edit:?}");
        }
        // Where there is nothing to edit, nothing is measured.
        let mut empty = Scene::default();
        for (edit, is_there) in Edit::ALL.into_iter().zip([true, false, false, false, true]) {
            assert_eq!(edit.make(&mut empty), is_there, "{edit:?}");
        }
        assert!(RestartTimes::default().figures(Edit::Light).is_none());
    }
}

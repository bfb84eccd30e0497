//! What effects and lights bring to the picture, as small pictures beside their switches.
//!
//! A picture is asked for where it is drawn ([`Contributions::beside_ui`]); the app has what is missing rendered in the background while
//! nothing else works and the user rests, and nothing happens where nothing is missing. When the scene changes, what was known is shown
//! dimmed until what it has become is there.

mod showing;

use std::sync::{Arc, OnceLock};

use egui::{TextureHandle, TextureOptions};

use super::document::same_picture;
use super::event::Event;
use super::jobs::Job;
use super::threads::cores;
use crate::analysis::contributions::{Contribution, Contributor, LONGER_SIDE, Whole, color};
use crate::render::{PreparedScene, RunConfig};
use crate::scene::Scene;
use showing::{Opened, color_image};

/// What one job makes: others may be asked for meanwhile.
const MOST_AT_ONCE: usize = 3;

/// What effects and lights bring, as far as it is known.
#[derive(Default)]
pub struct Contributions {
    /// Whether they are not to be found out.
    is_off: bool,
    /// Of this scene is what is current.
    scene: Option<Box<Scene>>,
    /// All that brings something to its picture.
    present: Vec<Contributor>,
    known: Vec<Known>,
    /// What was asked for since the last request.
    missing: Vec<Contributor>,
    /// What a job was asked for that it has not made yet.
    requested: Vec<Contributor>,
    /// The picture with everything, once there was a job.
    whole: Arc<OnceLock<Whole>>,
    opened: Option<Opened>,
}

/// What is known of a contributor.
struct Known {
    contributor: Contributor,
    /// Whether it is of the scene as it is.
    is_current: bool,
    /// `None` where it cannot be found out.
    shown: Option<Shown>,
}

#[derive(Clone)]
struct Shown {
    contribution: Arc<Contribution>,
    /// In colours.
    change: TextureHandle,
}

impl Contributions {
    /// Whether they are found out and shown.
    #[must_use]
    pub fn is_on(&self) -> bool {
        !self.is_off
    }

    /// Has them found out, or no longer.
    pub fn set_on(&mut self, is_on: bool) {
        if self.is_on() != is_on {
            *self = Self {
                is_off: !is_on,
                ..Self::default()
            };
        }
    }

    /// All that brings something to the picture.
    #[must_use]
    pub fn present(&self) -> &[Contributor] {
        &self.present
    }

    /// What `contributor` brings to the picture of the scene as it is, where that is known.
    #[must_use]
    pub fn known(&self, contributor: &Contributor) -> Option<&Contribution> {
        let known = self.find(contributor)?;
        let shown = known.shown.as_ref().filter(|_| known.is_current)?;
        Some(&shown.contribution)
    }

    fn find(&self, contributor: &Contributor) -> Option<&Known> {
        self.known
            .iter()
            .find(|known| known.contributor == *contributor)
    }

    /// Takes `scene` for the one that contributions are of. Whether it makes another picture than before: whatever is being rendered is
    /// not wanted then.
    pub fn follow(&mut self, scene: &Scene) -> bool {
        let known = self.scene.as_ref();
        // Emitters are known by the names of their materials.
        let is_same = |known: &Scene| {
            same_picture(known, scene) && known.materials.keys().eq(scene.materials.keys())
        };
        if self.is_off || known.is_some_and(|known| is_same(known)) {
            let known = self.scene.as_mut();
            if let Some(known) = known.filter(|known| known.light_names != scene.light_names) {
                known.light_names.clone_from(&scene.light_names);
            }
            return false;
        }
        self.scene = Some(Box::new(scene.clone()));
        self.present = Contributor::all_of(scene);
        self.known
            .retain(|known| self.present.contains(&known.contributor));
        self.known
            .iter_mut()
            .for_each(|known| known.is_current = false);
        self.missing.clear();
        self.requested.clear();
        self.whole = Arc::default();
        true
    }

    /// What to call `contributor`.
    #[must_use]
    pub fn name_of(&self, contributor: &Contributor) -> String {
        let scene = self.scene.as_ref();
        scene.map_or_else(String::new, |scene| contributor.name(scene))
    }

    /// Whether something is missing of what was drawn since the last request.
    #[must_use]
    pub fn is_missing(&self) -> bool {
        !self.missing.is_empty()
    }

    /// That. `prepared`: what was prepared of the scene, if anything was.
    pub fn next_request(&mut self, prepared: Option<PreparedScene>) -> Option<ContributionRequest> {
        let mut contributors = std::mem::take(&mut self.missing);
        contributors.truncate(MOST_AT_ONCE);
        self.requested.clone_from(&contributors);
        let scene = self.scene.clone().filter(|_| !contributors.is_empty())?;
        Some(ContributionRequest {
            scene,
            prepared,
            contributors,
            whole: Arc::clone(&self.whole),
        })
    }

    /// Takes in what a job found out.
    pub fn put(
        &mut self,
        ctx: &egui::Context,
        contributor: Contributor,
        contribution: Option<Box<Contribution>>,
    ) {
        let shown = contribution.map(|contribution| {
            let scale = contribution.figures.scale;
            let image = color_image(&contribution.change, |pixel| color(pixel, scale));
            let change = ctx.load_texture("contribution", image, TextureOptions::LINEAR);
            Shown {
                contribution: Arc::new(*contribution),
                change,
            }
        });
        self.requested.retain(|requested| *requested != contributor);
        self.learn(contributor, shown);
    }

    /// The job ended by a fault: what it has not made is not asked for again, which would end the same way.
    pub fn give_up(&mut self) {
        for contributor in std::mem::take(&mut self.requested) {
            self.learn(contributor, None);
        }
    }

    fn learn(&mut self, contributor: Contributor, shown: Option<Shown>) {
        self.known.retain(|known| known.contributor != contributor);
        self.known.push(Known {
            contributor,
            is_current: true,
            shown,
        });
    }
}

impl std::fmt::Debug for Contributions {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Contributions")
            .field("present", &self.present)
            .field("known", &self.known.len())
            .field("missing", &self.missing)
            .finish_non_exhaustive()
    }
}

/// What a job works with.
#[derive(Debug)]
pub struct ContributionRequest {
    scene: Box<Scene>,
    prepared: Option<PreparedScene>,
    contributors: Vec<Contributor>,
    whole: Arc<OnceLock<Whole>>,
}

impl ContributionRequest {
    /// Finds out what each brings, and sends it. One core is left free.
    pub fn render(self, job: &Job<Event>) {
        let run = RunConfig {
            threads: cores().saturating_sub(1).max(1),
            cancel: job.cancel.clone(),
            ..RunConfig::default()
        };
        if self.whole.get().is_none() {
            let prepared = self.prepared.as_ref();
            let whole = Whole::render(&self.scene, prepared, LONGER_SIDE, &run);
            // A scene that cannot be rendered says so elsewhere.
            if let Ok(Some(whole)) = whole {
                let _ = self.whole.set(whole);
            }
        }
        for contributor in self.contributors {
            let whole = self.whole.get();
            let found = whole.map(|whole| whole.contribution(&contributor, &run));
            if job.cancel.is_cancelled() {
                return;
            }
            let contribution = found.and_then(|found| found.ok().flatten()).map(Box::new);
            job.send(Event::ContributionFound {
                contributor,
                contribution,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::contributions::Figures;
    use crate::render::Image;
    use crate::scene::{Light, Rgb};

    fn contribution() -> Box<Contribution> {
        let image = Image::black(2, 1);
        Box::new(Contribution {
            contributor: Contributor::Light(0),
            without: image.clone(),
            change: image,
            figures: Figures {
                mean: [0.0; 3],
                mean_share: 0.0,
                mean_share_error: None,
                largest: None,
                relmse: 0.0,
                scale: 0.0,
            },
        })
    }

    fn lit(count: usize) -> Scene {
        Scene {
            lights: vec![Light::default(); count],
            ..Scene::default()
        }
    }

    #[test]
    fn what_is_known_is_forgotten_when_the_picture_changes_and_not_before() {
        let ctx = egui::Context::default();
        let mut contributions = Contributions::default();
        let mut scene = lit(2);
        assert!(contributions.follow(&scene));
        assert!(contributions.present().contains(&Contributor::Light(1)));
        contributions.missing.push(Contributor::Light(0));
        let request = contributions.next_request(None).unwrap();
        assert_eq!(request.contributors, [Contributor::Light(0)]);
        contributions.put(&ctx, Contributor::Light(0), Some(contribution()));
        scene.display.exposure = 1.0;
        assert!(!contributions.follow(&scene), "the picture is the same");
        assert!(contributions.known(&Contributor::Light(0)).is_some());
        scene.background = crate::scene::Background::Constant { radiance: Rgb::ONE };
        assert!(contributions.follow(&scene));
        assert!(contributions.known(&Contributor::Light(0)).is_none());
        assert!(
            contributions.find(&Contributor::Light(0)).is_some(),
            "it is shown dimmed"
        );
        assert!(contributions.follow(&lit(0)));
        let light = Contributor::Light(0);
        assert!(!contributions.present().contains(&light) && contributions.find(&light).is_none());
    }

    #[test]
    fn what_a_job_failed_at_is_not_asked_for_again_and_off_is_off() {
        let mut contributions = Contributions::default();
        contributions.follow(&lit(1));
        contributions.missing.push(Contributor::Light(0));
        assert!(contributions.next_request(None).is_some());
        contributions.give_up();
        let known = contributions.find(&Contributor::Light(0)).unwrap();
        assert!(known.is_current && known.shown.is_none());
        contributions.set_on(false);
        assert!(!contributions.follow(&lit(1)) && contributions.present().is_empty());
    }
}

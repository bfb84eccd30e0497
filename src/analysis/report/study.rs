//! Renders of a scene, and of variants of it, over several seeds.

use serde::Serialize;

use super::picture::small;
use super::reference::Reference;
use super::trial::Trial;
use crate::render::{Image, RenderProgress, RunConfig};
use crate::scene::{RenderSettings, Scene, SceneError};

/// What is measured, and what has been so far.
#[derive(Clone, Debug)]
pub struct Study {
    /// What people call the scene.
    pub scene_name: String,
    /// When it was begun, in words.
    pub date: String,
    /// What makes the report again, as a shell takes it; `None` where no command made it.
    pub command: Option<String>,
    /// What looked wrong before anything was rendered, in sentences.
    pub warnings: Vec<String>,
    /// Of the scene as it is, copies counted.
    pub triangles: u64,
    /// What the first render of the scene as it is showed, small; `None` before.
    pub picture: Option<Image>,
    /// Where it is measured.
    pub machine: Machine,
    /// What all renders are measured against.
    pub reference: Reference,
    /// How often each variant is rendered.
    pub seeds: u32,
    /// The render settings of a scene that says nothing about them.
    pub default_settings: toml::Table,
    /// The scene as it is comes first.
    pub variants: Vec<Variant>,
}

/// A computer as far as times depend on it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Machine {
    /// Name of the processor.
    pub cpu: String,
    /// Threads that render.
    pub threads: usize,
    /// Operating system and architecture.
    pub os: String,
}

impl Machine {
    /// The one this runs on, when so many threads render.
    #[must_use]
    pub fn this(threads: usize) -> Self {
        Self {
            cpu: cpu_name(),
            threads,
            os: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        }
    }

    /// What it is, in a line.
    #[must_use]
    pub fn describe(&self) -> String {
        let threads = match self.threads {
            1 => "1 thread".to_owned(),
            threads => format!("{threads} threads"),
        };
        format!("{}, {threads}, {}", self.cpu, self.os)
    }
}

/// The processor's name where the system tells (Linux), else its kind.
fn cpu_name() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text
        .lines()
        .find_map(|line| line.strip_prefix("model name")?.split_once(':'))
        .map(|(_, name)| name.trim().to_owned());
    name.unwrap_or_else(|| std::env::consts::ARCH.to_owned())
}

/// A scene with settings of its own.
#[derive(Clone, Debug)]
pub struct Variant {
    /// What makes it different.
    pub name: String,
    /// Its seed is the first; each further trial adds 1.
    pub scene: Scene,
    /// Its render settings as a scene file says them.
    pub settings: toml::Table,
    /// Whether it is not the picture of the scene as it is that is rendered, whatever number of samples it gets.
    pub shows_another_picture: bool,
    /// In the order of seeds.
    pub trials: Vec<Trial>,
}

impl Variant {
    /// The seed of trial number `trial`. After the largest one comes 0.
    #[must_use]
    pub fn seed(&self, trial: u32) -> u64 {
        (self.scene.render.seed + u64::from(trial)) % (RenderSettings::MAX_SEED + 1)
    }
}

impl Study {
    /// The variant that is rendered next: each has its turn with one seed before any is rendered with the next, so that what
    /// else the machine does hits all alike. `None` when all is done.
    #[must_use]
    pub fn next(&self) -> Option<usize> {
        let fewest = (0..self.variants.len()).min_by_key(|&v| self.variants[v].trials.len())?;
        (self.variants[fewest].trials.len() < self.seeds as usize).then_some(fewest)
    }

    /// Renders and measures what [`Self::next`] says. `None` when cancelled.
    ///
    /// # Errors
    /// What about the variant's scene cannot be rendered.
    ///
    /// # Panics
    /// When the reference is of another size than the picture.
    pub fn render_next(
        &mut self,
        run: &RunConfig,
        progress: &RenderProgress,
    ) -> Result<Option<()>, SceneError> {
        let Some(index) = self.next() else {
            return Ok(Some(()));
        };
        let variant = &mut self.variants[index];
        let number = u32::try_from(variant.trials.len()).expect("fewer than seeds");
        let seed = variant.seed(number);
        let trial = Trial::render(&variant.scene, seed, &self.reference, run, progress)?;
        Ok(trial.map(|(trial, image)| {
            variant.trials.push(trial);
            if index == 0 && number == 0 {
                self.picture = Some(small(&image));
            }
        }))
    }

    /// The variants that have been rendered at least once.
    pub fn measured(&self) -> impl Iterator<Item = &Variant> {
        let variants = self.variants.iter();
        variants.filter(|variant| !variant.trials.is_empty())
    }
}

#[cfg(test)]
mod tests {
    use crate::analysis::report::test_data;
    use crate::scene::RenderSettings;

    #[test]
    fn variants_take_turns() {
        let mut study = test_data::study();
        for variant in &mut study.variants {
            variant.trials.clear();
        }
        let mut turns = Vec::new();
        while let Some(index) = study.next() {
            turns.push(index);
            let trial = test_data::trial(0, 1.0);
            study.variants[index].trials.push(trial);
        }
        assert_eq!(turns, [0, 1, 0, 1, 0, 1]);
    }

    #[test]
    fn seeds_begin_again_after_the_largest() {
        let mut variant = test_data::study().variants.remove(0);
        variant.scene.render.seed = RenderSettings::MAX_SEED - 1;
        let seeds = [0, 1, 2, 3].map(|trial| variant.seed(trial));
        let max = RenderSettings::MAX_SEED;
        assert_eq!(seeds, [max - 1, max, 0, 1]);
    }
}

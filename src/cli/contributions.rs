//! What effects and lights bring to a picture, as pictures and figures.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context as _, Result};
use serde::Serialize;

use super::inputs::refuse_input;
use crate::analysis::contributions::{Contribution, Contributor, Figures, Whole, color};
use crate::control::Progress;
use crate::io;
use crate::math::color::linear_from_srgb;
use crate::render::{Image, PreparedScene, RunConfig};
use crate::scene::{Display, Output, Scene};

/// The file with the figures.
const FACTS: &str = "contributions.json";
/// The file with the picture that has everything.
const WHOLE: &str = "whole.png";

/// What was found out, and the files it is in.
#[derive(Debug, Serialize)]
pub(super) struct MeasuredContributions {
    /// Of the pictures, in pixels.
    width: u32,
    height: u32,
    samples_per_pixel: u32,
    /// The picture with everything.
    whole: &'static str,
    contributions: Vec<Measured>,
}

#[derive(Debug, Serialize)]
struct Measured {
    name: String,
    /// The change in colours: black where there is none, orange to yellow where it is brighter, blue where it is darker.
    change: String,
    /// The change itself, W/m²/sr.
    radiance: String,
    /// The picture without.
    without: String,
    /// The size of a change that has the last colour, W/m²/sr.
    scale: f32,
    /// W/m²/sr per channel.
    mean_change: [f64; 3],
    /// Of the mean of the picture; none where that is black.
    mean_share: Option<f64>,
    /// How far noise puts it off at most, in 95 of 100 cases; none where that is not known.
    mean_share_error: Option<f64>,
    largest_change: Option<Largest>,
    /// Of the picture without against the whole.
    relmse: Option<f64>,
}

#[derive(Debug, Serialize)]
struct Largest {
    value: f64,
    x: u32,
    y: u32,
}

impl MeasuredContributions {
    /// Renders them with `longer_side` pixels along the longer side, and writes them into `folder`, each as soon as it is there. `None`
    /// when cancelled. Nothing that the scene is read from is written over, `own` being its file.
    pub(super) fn write(
        (scene, own): (&Scene, Option<&Path>),
        prepared: &PreparedScene,
        longer_side: u32,
        folder: &Path,
    ) -> Result<Option<Self>> {
        let contributors = Contributor::all_of(scene);
        let files = contributors.iter().enumerate();
        let files = files.flat_map(|(at, one)| Files::of(at + 1, &one.name(scene)).all());
        for file in files.chain([FACTS, WHOLE].map(str::to_owned)) {
            refuse_input(
                scene,
                own,
                &folder.join(file),
                "what --contributions writes",
            )?;
        }
        let progress = Progress::new();
        let how_far = || (progress.fraction(), "rendering contributions".to_owned());
        let measure = || Self::measure(scene, prepared, longer_side, folder, &progress);
        super::progress_bar::show(how_far, measure)
    }

    fn measure(
        scene: &Scene,
        prepared: &PreparedScene,
        longer_side: u32,
        folder: &Path,
        progress: &Progress,
    ) -> Result<Option<Self>> {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("{}: cannot make the folder", folder.display()))?;
        let contributors = Contributor::all_of(scene);
        progress.set_total(contributors.len() as u64 + 1);
        let run = RunConfig::default();
        let Some(whole) = Whole::render(scene, Some(prepared), longer_side, &run)? else {
            return Ok(None);
        };
        progress.advance(1);
        let as_shown = |image: &Image, name: &str| {
            io::write_image(
                image,
                &[],
                &scene.display,
                &scene.output,
                &folder.join(name),
            )
        };
        as_shown(whole.image(), WHOLE)?;
        let settings = &whole.scene().render;
        let mut facts = Self {
            width: settings.width,
            height: settings.height,
            samples_per_pixel: settings.samples_per_pixel,
            whole: WHOLE,
            contributions: Vec::new(),
        };
        for (number, contributor) in contributors.iter().enumerate() {
            let Some(contribution) = whole.contribution(contributor, &run)? else {
                return Ok(None);
            };
            let measured = Measured::of(number + 1, &contribution, scene);
            as_shown(&contribution.without, &measured.without)?;
            let (plain, eight_bits) = (Display::default(), Output::default());
            let colored = in_colors(&contribution);
            let path = folder.join(&measured.change);
            io::write_image(&colored, &[], &plain, &eight_bits, &path)?;
            let path = folder.join(&measured.radiance);
            io::write_image(&contribution.change, &[], &plain, &eight_bits, &path)?;
            facts.contributions.push(measured);
            progress.advance(1);
        }
        let path = folder.join(FACTS);
        std::fs::write(&path, serde_json::to_string_pretty(&facts)?)
            .with_context(|| format!("{}: cannot write the figures", path.display()))?;
        Ok(Some(facts))
    }

    /// In words, line by line.
    pub(super) fn describe(&self, folder: &Path) -> String {
        let Self {
            width,
            height,
            samples_per_pixel,
            ..
        } = self;
        let mut text = format!(
            "\nwhat each brings, in {width}×{height} pixels of {samples_per_pixel} samples, and how wrong the picture is without:\n"
        );
        text += "     mean             largest  relmse    \n";
        for measured in &self.contributions {
            let _ = writeln!(text, "{}", measured.line());
        }
        let _ = write!(
            text,
            "{}: {FACTS}, {WHOLE}, and of each the change in colours (.png) and as it is (.exr), and the picture without",
            folder.display()
        );
        text
    }
}

/// The pictures of one contribution; see [`Measured`].
struct Files {
    change: String,
    radiance: String,
    without: String,
}

impl Files {
    /// Those of the contribution of this number, from 1, and name.
    fn of(number: usize, name: &str) -> Self {
        let stem = format!("{number:02}-{}", file_stem(name));
        Self {
            change: format!("{stem}.png"),
            radiance: format!("{stem}.exr"),
            without: format!("{stem}-without.png"),
        }
    }

    fn all(self) -> [String; 3] {
        [self.change, self.radiance, self.without]
    }
}

impl Measured {
    fn of(number: usize, contribution: &Contribution, scene: &Scene) -> Self {
        let name = contribution.contributor.name(scene);
        let Files {
            change,
            radiance,
            without,
        } = Files::of(number, &name);
        let Figures {
            mean,
            mean_share,
            mean_share_error,
            largest,
            relmse,
            scale,
        } = contribution.figures;
        let finite = |value: f64| value.is_finite().then_some(value);
        Self {
            name,
            change,
            radiance,
            without,
            scale,
            mean_change: mean,
            mean_share: finite(mean_share),
            mean_share_error,
            largest_change: largest.map(|largest| Largest {
                value: largest.value,
                x: largest.x,
                y: largest.y,
            }),
            relmse: finite(relmse),
        }
    }

    fn line(&self) -> String {
        let share = self.mean_share.map_or_else(
            || "–".to_owned(),
            |share| format!("{:+.2} %", 100.0 * share),
        );
        let error = self
            .mean_share_error
            .map_or_else(String::new, |error| format!("± {:.2}", 100.0 * error));
        let largest = self.largest_change.as_ref();
        let largest = largest.map_or_else(|| "–".to_owned(), |l| format!("{:+.3e}", l.value));
        let relmse = self
            .relmse
            .map_or_else(|| "–".to_owned(), |r| format!("{r:.2e}"));
        format!(
            "{share:>9} {error:<7}  {largest:>10}  {relmse:>8}  {}",
            self.name
        )
    }
}

/// The change as its colours, linear as pictures are.
fn in_colors(contribution: &Contribution) -> Image {
    let scale = contribution.figures.scale;
    let linear = |&change: &[f32; 3]| {
        color(change, scale).map(|byte| linear_from_srgb(f32::from(byte) / 255.0))
    };
    Image {
        pixels: contribution.change.pixels.iter().map(linear).collect(),
        ..contribution.change
    }
}

/// A name that is good in any file system.
fn file_stem(name: &str) -> String {
    let mut stem: String = name
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '-' })
        .collect();
    stem.truncate(60);
    stem
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_hold_nothing_that_a_system_minds() {
        assert_eq!(
            file_stem("the emitter ../a:b\u{7}é"),
            "the-emitter----a-b--"
        );
        assert_eq!(file_stem(&"ä".repeat(100)), "-".repeat(60));
    }
}

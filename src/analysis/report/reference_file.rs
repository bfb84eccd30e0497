//! A reference from a file.

use std::path::Path;

use super::error::ReportError;
use super::reference::{Origin, Reference};
use crate::io::{self, WrittenOrigin};
use crate::scene::{Choice, Display, RenderSettings};

/// The picture at `path`, and what looks wrong with it, in sentences that do not name it. `picture`: width and height of what is measured
/// against it, `seeds` what that is rendered with.
///
/// # Errors
/// When it cannot be read, has another size, or holds no radiance.
pub(super) fn read_reference(
    path: &Path,
    picture: (u32, u32),
    seeds: &[u64],
) -> Result<(Reference, Vec<String>), ReportError> {
    let file = io::read_image(path)?;
    let image = file.image;
    if (image.width, image.height) != picture {
        return Err(ReportError::ReferenceSize {
            path: path.to_owned(),
            reference: (image.width, image.height),
            picture,
        });
    }
    let told = WrittenOrigin::of_file(path).unwrap_or_default();
    let scene: Option<toml::Table> = told.scene.and_then(|text| text.parse().ok());
    let is_rounded = file.format == "PNG";
    let display = scene.as_ref().map_or_else(Vec::new, display_of);
    if is_rounded && !display.is_empty() {
        return Err(ReportError::ReferenceDisplay {
            path: path.to_owned(),
            display: display.join(", "),
        });
    }
    let is_error = |value: f64| value.is_finite() && value >= 0.0;
    let seed = scene.as_ref().and_then(seed_of);
    let reference = Reference {
        image,
        origin: Origin::File {
            name: path.display().to_string(),
            error: (told.error).filter(|told| is_error(told.rmse) && is_error(told.relmse)),
            is_rounded,
            shared_seed: seed.filter(|seed| seeds.contains(seed)),
        },
    };
    let mut warnings = file.warnings;
    warnings.extend(reference.cautions());
    Ok((reference, warnings))
}

/// The seed that `scene`, as it stands in a picture, was rendered with.
fn seed_of(scene: &toml::Table) -> Option<u64> {
    match scene.get("render").and_then(|render| render.get("seed")) {
        Some(seed) => seed.as_integer()?.try_into().ok(),
        None => Some(RenderSettings::default().seed),
    }
}

/// The keys of `scene`, as it stands in a picture, by which a screen shows something else than its radiance, with their values.
fn display_of(scene: &toml::Table) -> Vec<String> {
    let Some(display) = scene.get("display").and_then(toml::Value::as_table) else {
        return Vec::new();
    };
    let usual = Display::default();
    let is_usual = |key: &str, value: &toml::Value| {
        let number = value.as_float().or(value.as_integer().map(|n| n as f64));
        match key {
            "exposure" => number == Some(usual.exposure),
            "gamma" => number == Some(usual.gamma),
            "tone_curve" => value.as_str() == Some(usual.tone_curve.name()),
            _ => true,
        }
    };
    let unusual = display.iter().filter(|(key, value)| !is_usual(key, value));
    unusual
        .map(|(key, value)| match value {
            toml::Value::String(text) => format!("display.{key} = {text}"),
            value => format!("display.{key} = {value}"),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::{Origin as WrittenAs, Values, write_image, write_render};
    use crate::render::Image;
    use crate::scene::{Output, Scene, ToneCurve};
    use tempfile::TempDir;

    fn read(path: &Path) -> Result<(Reference, Vec<String>), ReportError> {
        read_reference(path, (2, 1), &[3, 4])
    }

    /// Writes a picture of `scene` to `name` in a folder, and reads it as a reference.
    fn of(scene: &Scene, name: &str) -> Result<(Reference, Vec<String>), ReportError> {
        let folder = TempDir::new().expect("a folder");
        let path = folder.path().join(name);
        let origin = WrittenAs {
            scene,
            error: None,
            region: None,
            values: Values::Rendered,
        };
        write_render(&Image::black(2, 1), &[], &origin, &path).expect("is written");
        read(&path)
    }

    /// A PNG that a tone curve or an exposure has changed is no radiance, and is refused with what to give instead.
    #[test]
    fn pngs_that_show_something_else_than_radiance_are_refused() {
        let mut scene = Scene::default();
        let (plain, warnings) = of(&scene, "plain.png").expect("is as good as a PNG can be");
        assert_eq!(warnings, plain.cautions());
        assert!(warnings[0].contains("rounding are in it"), "{warnings:?}");
        scene.display.exposure = 1.5;
        scene.display.tone_curve = ToneCurve::Aces;
        let error = of(&scene, "shown.png").expect_err("is refused").to_string();
        for part in [
            "display.exposure = 1.5",
            "display.tone_curve = aces",
            "(.exr)",
        ] {
            assert!(error.contains(part), "{part}: {error}");
        }
        let (linear, warnings) = of(&scene, "linear.exr").expect("holds the radiance");
        assert!(
            warnings.is_empty() && linear.cautions().is_empty(),
            "{warnings:?}"
        );
    }

    #[test]
    fn seeds_that_are_shared_are_told_of() {
        let mut scene = Scene::default();
        for (seed, is_shared) in [(3, true), (4, true), (5, false)] {
            scene.render.seed = seed;
            let (reference, warnings) = of(&scene, "told.exr").expect("holds the radiance");
            let said = warnings.join("; ");
            assert_eq!(said.contains(&format!("seed {seed}")), is_shared, "{said}");
            assert_eq!(reference.cautions().len(), usize::from(is_shared));
        }
    }

    /// Other programs' pictures tell nothing.
    #[test]
    fn pictures_that_tell_nothing_are_taken_as_they_are() {
        let folder = TempDir::new().expect("a folder");
        let path = folder.path().join("other.png");
        let display = Display {
            exposure: 2.0,
            ..Display::default()
        };
        write_image(
            &Image::black(2, 1),
            &[],
            &display,
            &Output::default(),
            &path,
        )
        .expect("is written");
        let (_, warnings) = read(&path).expect("nobody knows");
        assert_eq!(warnings.len(), 1, "{warnings:?}");
    }
}

//! What every command about a scene takes: which one, and what is changed about it first.

use std::fmt::Debug;
use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;

use super::values;
use crate::control::CancelToken;
use crate::io::{self, LoadError, LoadedScene};

/// A scene and changes to it.
#[derive(Debug, Default, Args)]
pub struct SceneArguments {
    /// A scene file (.toml) or a mesh; the built-in demo when left out
    #[arg(value_name = "SCENE")]
    scene: Option<PathBuf>,

    /// Picture size in pixels; the scene's when left out
    #[arg(long, value_name = "WxH", allow_hyphen_values = true, value_parser = values::size)]
    pub size: Option<(u32, u32)>,

    /// Change any key of the scene, e.g. render.shadows=off; may be given several times
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub assignments: Vec<String>,
}

impl SceneArguments {
    /// The file; `None` for the demo.
    pub fn path(&self) -> Option<&Path> {
        self.scene.as_deref()
    }

    /// What people call the scene.
    pub fn name(&self) -> String {
        let path = self.path();
        path.map_or_else(|| "demo".to_owned(), |path| path.display().to_string())
    }

    /// The scene as it is changed, by `more` after all else. `None` when cancelled.
    pub fn load(
        &self,
        more: impl IntoIterator<Item = Option<Assigned>>,
        cancel: &CancelToken,
    ) -> Result<Option<LoadedScene>> {
        let Some(mut loaded) = super::load_unless(cancel, self.path())? else {
            return Ok(None);
        };
        let size = self.size.unzip();
        let sides = [("width", size.0), ("height", size.1)].map(|(key, side)| {
            let assigned = assigned("--size", key, side)?;
            let (width, height) = self.size?;
            Some(Assigned {
                option: format!("--size {width}x{height}"),
                ..assigned
            })
        });
        let of_options: Vec<Assigned> = sides.into_iter().chain(more).flatten().collect();
        let added = of_options.iter().map(|added| added.assignment.clone());
        let assignments: Vec<_> = self.assignments.iter().cloned().chain(added).collect();
        io::override_scene(&mut loaded, &assignments, cancel)
            .map_err(|error| as_given(error, &of_options))?;
        Ok((!cancel.is_cancelled()).then_some(loaded))
    }
}

/// What an option of its own asks of the scene.
pub struct Assigned {
    /// As it was given.
    option: String,
    /// As `--set` would say it.
    assignment: String,
}

/// The assignment of what `option` asks for to a key of `render`.
pub fn assigned(option: &str, key: &str, value: Option<impl Debug>) -> Option<Assigned> {
    // This way numbers have few digits and texts quotes.
    let value = format!("{:?}", value?);
    Some(Assigned {
        option: format!("{option} {}", value.trim_matches('"')),
        assignment: format!("render.{key}={value}"),
    })
}

/// The error, naming the options that were given where it names assignments that nobody wrote.
fn as_given(error: LoadError, options: &[Assigned]) -> LoadError {
    const SET: &str = "--set ";
    let LoadError::Scene(mut error) = error else {
        return error;
    };
    if let Some(assignments) = error.at.strip_prefix(SET) {
        let parts = assignments.split(" --set ").map(|assignment| {
            let own = options.iter().find(|own| own.assignment == assignment);
            own.map_or_else(|| format!("{SET}{assignment}"), |own| own.option.clone())
        });
        let mut parts: Vec<String> = parts.collect();
        // Both sides of a size are one option.
        parts.dedup();
        error.at = parts.join(" ");
    }
    LoadError::Scene(error)
}

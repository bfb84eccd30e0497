//! What every command about a scene takes: which one, and what is changed about it first.

use std::fmt::Debug;
use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;

use super::values;
use crate::control::CancelToken;
use crate::io::{self, LoadedScene};

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
        more: impl IntoIterator<Item = Option<String>>,
        cancel: &CancelToken,
    ) -> Result<Option<LoadedScene>> {
        let Some(mut loaded) = super::load_unless(cancel, self.path())? else {
            return Ok(None);
        };
        let size = self.size.unzip();
        let sides = [assigned("width", size.0), assigned("height", size.1)];
        let of_options = sides.into_iter().chain(more).flatten();
        let assignments: Vec<_> = self.assignments.iter().cloned().chain(of_options).collect();
        io::override_scene(&mut loaded, &assignments, cancel)?;
        Ok((!cancel.is_cancelled()).then_some(loaded))
    }
}

/// The assignment of what an option asks for to a key of `render`.
pub fn assigned(key: &str, value: Option<impl Debug>) -> Option<String> {
    // This way numbers have few digits and texts quotes.
    value.map(|value| format!("render.{key}={value:?}"))
}

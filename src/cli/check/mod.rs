//! `raymini check`: whether the program keeps its promises where others break, or what may spoil the picture of a scene.

mod matrix;
mod scene;

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::Args;

use crate::analysis::matrix::Effort;

/// What `raymini check` takes.
#[derive(Debug, Args)]
pub struct CheckArguments {
    /// A scene file (.toml) or a mesh to examine; the built-in extreme cases are tried when left out
    #[arg(value_name = "SCENE")]
    pub(super) scene: Option<PathBuf>,

    /// As many rays and samples as give the figures their meaning: minutes instead of seconds
    #[arg(long, conflicts_with = "scene")]
    long: bool,

    /// Only the cases whose name holds this
    #[arg(long, value_name = "TEXT", conflicts_with = "scene")]
    only: Option<String>,

    /// Print the facts as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &CheckArguments) -> Result<ExitCode> {
    if let Some(path) = &arguments.scene {
        scene::run(path, arguments.json)?;
        return Ok(ExitCode::SUCCESS);
    }
    let effort = if arguments.long {
        Effort::Long
    } else {
        Effort::Quick
    };
    matrix::run(effort, arguments.only.as_deref(), arguments.json)
}

//! `raymini check`: what may spoil the picture of a scene.

mod scene;

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

/// What `raymini check` takes.
#[derive(Debug, Args)]
pub struct CheckArguments {
    /// A scene file (.toml) or a mesh
    #[arg(value_name = "SCENE")]
    scene: PathBuf,

    /// Print what is found as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &CheckArguments) -> Result<()> {
    scene::run(&arguments.scene, arguments.json)
}

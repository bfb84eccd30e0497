//! `raymini check`: whether this program keeps its promises where others break.

mod matrix;

use std::process::ExitCode;

use anyhow::Result;
use clap::Args;

use crate::analysis::matrix::Effort;

/// What `raymini check` takes.
#[derive(Debug, Args)]
pub struct CheckArguments {
    /// As many rays and samples as give the figures their meaning: minutes instead of seconds
    #[arg(long)]
    long: bool,

    /// Only the cases whose name holds this
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,

    /// Print the facts as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &CheckArguments) -> Result<ExitCode> {
    let effort = if arguments.long {
        Effort::Long
    } else {
        Effort::Quick
    };
    matrix::run(effort, arguments.only.as_deref(), arguments.json)
}

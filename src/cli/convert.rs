//! `raymini convert`: a mesh from one format to another.

use std::path::PathBuf;

use anyhow::{Context, Result, anyhow};
use clap::Args;

use crate::control::{CancelToken, Progress};
use crate::io::{self, MeshFormat, READABLE_EXTENSIONS};

/// What `raymini convert` takes.
#[derive(Debug, Args)]
pub struct ConvertArguments {
    /// The mesh to read
    #[arg(value_name = "IN")]
    input: PathBuf,

    /// The file to write, in the format of its extension: .off, .obj, .ply, .stl, .mesh or .msh
    #[arg(value_name = "OUT")]
    output: PathBuf,
}

pub(super) fn run(arguments: &ConvertArguments) -> Result<()> {
    let ConvertArguments { input, output } = arguments;
    let name = output.display();
    let format = MeshFormat::of_extension(output).ok_or_else(|| {
        let known = READABLE_EXTENSIONS.join(", .");
        anyhow!("{name}: a mesh is written to a file with the extension .{known}")
    })?;
    let cannot_write = || format!("{name}: cannot write the mesh");
    io::check_writable(output).with_context(cannot_write)?;

    let loaded = io::load_mesh(input, &CancelToken::new(), &Progress::new())?;
    let file = loaded.ok_or_else(|| anyhow!("loading was cancelled"))?;
    for warning in io::mesh_warnings(&input.display().to_string(), &file) {
        super::warn(&warning);
    }
    let mesh = &file.mesh;
    io::write_atomically(output, |out| format.write(mesh, out)).with_context(cannot_write)?;
    for loss in format.losses(mesh) {
        super::warn(&format!("{name}: {loss}"));
    }
    super::say(&format!(
        "{name}: {}, {} vertices, {} triangles",
        format.name(),
        mesh.positions.len(),
        mesh.triangles.len()
    ))
}

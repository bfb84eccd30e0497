//! `raymini convert`: a mesh from one format to another.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail};
use clap::Args;

use crate::control::{CancelToken, Progress};
use crate::io::{self, MeshFormat, ModelFormat, READABLE_EXTENSIONS};

/// What `raymini convert` takes.
#[derive(Debug, Args)]
pub struct ConvertArguments {
    /// The mesh to read
    #[arg(value_name = "IN")]
    input: PathBuf,

    /// The file to write, in the format of its extension: .off, .obj (with .mtl), .ply, .stl, .mesh, .msh or .glb
    #[arg(value_name = "OUT")]
    output: PathBuf,
}

pub(super) fn run(arguments: &ConvertArguments) -> Result<()> {
    let ConvertArguments { input, output } = arguments;
    let name = output.display();
    let mesh_format = MeshFormat::of_extension(output);
    let model_format = ModelFormat::of_extension(output);
    if mesh_format.is_none() && model_format.is_none() {
        // The text of glTF is read only: it goes with other files.
        let known = READABLE_EXTENSIONS
            .iter()
            .filter(|extension| **extension != "gltf");
        let known: Vec<_> = known.copied().collect();
        let known = known.join(", .");
        bail!("{name}: a mesh is written to a file with the extension .{known}");
    }
    io::check_writable(output).with_context(|| format!("{name}: cannot write the mesh"))?;
    match (model_format, mesh_format) {
        (Some(format), _) => convert_model(input, format, output),
        (None, Some(format)) => convert_mesh(input, format, output),
        (None, None) => unreachable!("was refused"),
    }
}

/// Objects with their materials.
fn convert_model(input: &Path, format: ModelFormat, output: &Path) -> Result<()> {
    let loaded = io::load_model(input, &CancelToken::new(), &Progress::new())?;
    let model = loaded.ok_or_else(|| anyhow!("loading was cancelled"))?;
    for warning in &model.warnings {
        super::warn(warning);
    }
    let name = output.display();
    for loss in io::write_model(&model, format, output)? {
        super::warn(&format!("{name}: {loss}"));
    }
    let meshes = || {
        model
            .scene
            .objects
            .iter()
            .filter_map(|object| model.scene.meshes.get(&object.mesh))
    };
    let vertices: usize = meshes().map(|mesh| mesh.positions.len()).sum();
    let triangles: usize = meshes().map(|mesh| mesh.triangles.len()).sum();
    let materials = match model.scene.materials.len() {
        0 => String::new(),
        1 => ", 1 material".to_owned(),
        count => format!(", {count} materials"),
    };
    super::say(&format!(
        "{name}: {}, {vertices} vertices, {triangles} triangles{materials}",
        format.name()
    ))
}

/// One mesh.
fn convert_mesh(input: &Path, format: MeshFormat, output: &Path) -> Result<()> {
    let name = output.display();
    let cannot_write = || format!("{name}: cannot write the mesh");
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
    if !file.parts.is_empty() {
        super::warn(&format!(
            "{name}: materials are left out: {} holds none",
            format.name()
        ));
    }
    super::say(&format!(
        "{name}: {}, {} vertices, {} triangles",
        format.name(),
        mesh.positions.len(),
        mesh.triangles.len()
    ))
}

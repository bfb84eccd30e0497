//! `raymini convert`: a mesh from one format to another, perhaps with other units, axes and windings.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result, anyhow, bail};
use clap::Args;

use super::inputs::{is_same_file, refuse_input};
use crate::control::{CancelToken, Progress};
use crate::geometry::{TriangleMesh, Winding};
use crate::io::{self, MeshFormat, Model, ModelFormat, READABLE_EXTENSIONS};
use crate::math::{DMat3, DVec3, counted};
use crate::scene::Remeasure;

/// What `raymini convert` takes.
#[derive(Debug, Args)]
pub struct ConvertArguments {
    /// The mesh to read
    #[arg(value_name = "IN")]
    input: PathBuf,

    /// The file to write, in the format of its extension: .off, .obj, .ply, .stl, .mesh, .msh or .glb
    ///
    /// What is read is never written over. The materials of an .obj go to the .mtl of the same name; where there is one already that holds
    /// anything else, nothing is written.
    #[arg(value_name = "OUT")]
    output: PathBuf,

    /// Multiply all lengths: 0.001 makes metres of millimetres
    #[arg(long, value_name = "FACTOR", allow_hyphen_values = true, value_parser = super::values::positive)]
    scale: Option<f64>,

    /// Turn the axis that is up: y:z makes Z point where Y did, z:y the other way round
    #[arg(long, value_name = "FROM:TO", value_parser = quarter_turn)]
    up: Option<DMat3>,

    /// Turn triangles that turn the other way round than their neighbours, and closed surfaces that look inwards
    #[arg(long)]
    repair_winding: bool,
}

/// The rotation that takes one axis to another and keeps the third.
fn quarter_turn(text: &str) -> Result<DMat3, String> {
    let axis = |name: &str| ["x", "y", "z"].iter().position(|axis| *axis == name);
    let axes = text.split_once(':');
    let axes = axes.and_then(|(from, to)| Some((axis(from)?, axis(to)?)));
    let (from, to) = axes.ok_or("expected two of the axes x, y and z, such as y:z".to_owned())?;
    let mut turn = DMat3::IDENTITY;
    if from != to {
        *turn.col_mut(from) = DVec3::AXES[to];
        *turn.col_mut(to) = -DVec3::AXES[from];
    }
    Ok(turn)
}

pub(super) fn run(arguments: &ConvertArguments) -> Result<()> {
    let ConvertArguments { input, output, .. } = arguments;
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
    let whole = input.to_string_lossy();
    let (read, _) = io::file_and_part(&whole);
    if is_same_file(input, output) || is_same_file(Path::new(read), output) {
        bail!("{name}: the mesh is read from it; what is written needs a name of its own");
    }
    io::check_writable(output).with_context(|| format!("{name}: cannot write the mesh"))?;
    let changes = Changes {
        remeasure: Remeasure {
            turn: arguments.up.unwrap_or(DMat3::IDENTITY),
            scale: arguments.scale.unwrap_or(1.0),
        },
        repair_winding: arguments.repair_winding,
    };
    match (model_format, mesh_format) {
        (Some(format), _) => convert_model(input, &changes, format, output),
        (None, Some(format)) => convert_mesh(input, &changes, format, output),
        (None, None) => unreachable!("was refused"),
    }
}

const TOO_LARGE: &str = "--scale makes coordinates larger than numbers can be";

/// What is to be changed on the way.
struct Changes {
    remeasure: Remeasure,
    repair_winding: bool,
}

impl Changes {
    /// Changes objects with their meshes. Returns what was done, in words that follow others.
    ///
    /// # Errors
    /// When coordinates are too large then.
    fn apply_to_model(&self, model: &mut Model) -> Result<String> {
        let mut turned = 0;
        if self.repair_winding {
            for mesh in model.scene.meshes.values_mut() {
                turned += repair_winding(mesh);
            }
        }
        if self.remeasure != Remeasure::default() {
            self.remeasure.apply(&mut model.scene);
            if let Some(camera) = &mut model.camera {
                self.remeasure.camera(camera);
            }
            let bounds = model.scene.bounds();
            let is_finite = bounds.min.is_finite() && bounds.max.is_finite();
            if !bounds.is_empty() && !is_finite {
                bail!(TOO_LARGE);
            }
        }
        Ok(self.done(turned))
    }

    /// Changes a mesh.
    ///
    /// # Errors
    /// When coordinates are too large then.
    fn apply_to_mesh(&self, mesh: &mut Arc<TriangleMesh>) -> Result<String> {
        let turned = if self.repair_winding {
            repair_winding(mesh)
        } else {
            0
        };
        if self.remeasure != Remeasure::default() {
            let mesh = Arc::make_mut(mesh);
            for position in &mut mesh.positions {
                *position = self.remeasure.point(*position);
            }
            for normal in mesh.normals.iter_mut().flatten() {
                *normal = self.remeasure.direction(*normal);
            }
            if !mesh.positions.iter().all(|position| position.is_finite()) {
                bail!(TOO_LARGE);
            }
        }
        Ok(self.done(turned))
    }

    fn done(&self, turned: usize) -> String {
        match turned {
            _ if !self.repair_winding => String::new(),
            1 => ", 1 of them turned".to_owned(),
            _ => format!(", {turned} of them turned"),
        }
    }
}

/// Repairs the winding of a mesh, and returns how many triangles were turned.
fn repair_winding(mesh: &mut Arc<TriangleMesh>) -> usize {
    let winding = Winding::of(mesh);
    if !winding.is_right() {
        winding.repair(Arc::make_mut(mesh));
    }
    winding.to_turn()
}

/// Objects with their materials.
fn convert_model(
    input: &Path,
    changes: &Changes,
    format: ModelFormat,
    output: &Path,
) -> Result<()> {
    let loaded = io::load_model(input, &CancelToken::new(), &Progress::new())?;
    let mut model = loaded.ok_or_else(|| anyhow!("loading was cancelled"))?;
    for warning in &model.warnings {
        super::warn(warning);
    }
    refuse_input(&model.scene, None, output, "the mesh")?;
    let changed = changes.apply_to_model(&mut model)?;
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
        "{name}: {}, {vertices} vertices, {}{changed}{materials}",
        format.name(),
        counted(triangles as u64, "triangle", "triangles")
    ))
}

/// One mesh.
fn convert_mesh(input: &Path, changes: &Changes, format: MeshFormat, output: &Path) -> Result<()> {
    let name = output.display();
    let cannot_write = || format!("{name}: cannot write the mesh");
    let loaded = io::load_mesh(input, &CancelToken::new(), &Progress::new())?;
    let file = loaded.ok_or_else(|| anyhow!("loading was cancelled"))?;
    let shown = input.display().to_string();
    let lost_digits = io::lost_digits_warning(&shown, [&file.mesh]);
    for warning in io::mesh_warnings(&shown, &file).iter().chain(&lost_digits) {
        super::warn(warning);
    }
    let has_parts = !file.parts.is_empty();
    let mut mesh = Arc::new(file.mesh);
    let changed = changes.apply_to_mesh(&mut mesh)?;
    io::write_atomically(output, |out| format.write(&mesh, out)).with_context(cannot_write)?;
    for loss in format.losses(&mesh) {
        super::warn(&format!("{name}: {loss}"));
    }
    if has_parts {
        super::warn(&format!(
            "{name}: materials are left out: {} holds none",
            format.name()
        ));
    }
    super::say(&format!(
        "{name}: {}, {} vertices, {}{changed}",
        format.name(),
        mesh.positions.len(),
        counted(mesh.triangles.len() as u64, "triangle", "triangles")
    ))
}

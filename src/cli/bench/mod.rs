//! `raymini bench`: build and traversal speed of the structures over a scene.

mod facts;
mod table;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail};
use clap::Args;

use super::inputs::refuse_input;
use super::scene_arguments::SceneArguments;
use super::values;
use crate::analysis::bench::{self, MeasureConfig, RayKind, RaySet, Structure};
use crate::control::CancelToken;
use crate::io;
use crate::render::{PreparedScene, RunConfig};
use crate::scene::{AcceleratorChoice, Choice, Scene};
use facts::BenchFacts;

/// Up to this many triangles brute force is measured without being asked for: it takes no longer than the trees.
const FEW_TRIANGLES: u32 = 64;

/// What the triangles are written to.
const MESH_FILE: &str = "mesh.ply";

/// What `raymini bench` takes.
#[derive(Debug, Args)]
pub struct BenchArguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,

    /// Measure this structure; may be given several times. Both trees when left out, and brute force over a few triangles
    #[arg(long = "structure", value_name = "NAME", value_parser = structure_names())]
    structures: Vec<String>,

    /// Measurements of everything
    #[arg(long, value_name = "N", default_value_t = 5, allow_hyphen_values = true, value_parser = values::whole(1..=1000_u16))]
    repeats: u16,

    /// Threads where all are used; one per core when left out
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = values::threads)]
    threads: Option<u16>,

    /// Trace the rays of this .npy file (float32, n × 7: origin, direction, end) instead; may be given several times. Names
    /// that end in _shadow.npy ask for any hit, others for the nearest
    #[arg(long = "rays", value_name = "FILE", allow_hyphen_values = true, value_parser = values::input())]
    rays: Vec<PathBuf>,

    /// Write the rays as .npy files and the triangles as mesh.ply to this folder, for other programs
    #[arg(long, value_name = "DIR", conflicts_with = "rays", allow_hyphen_values = true, value_parser = values::output())]
    write: Option<PathBuf>,

    /// Measure the window in place of the structures: its frames while all cores render, how soon a cancelled render ends, and how soon
    /// an edit shows with Live on. It opens for two or three minutes; exit code 1 where a bar is missed
    #[arg(long, conflicts_with_all = ["structures", "size", "assignments", "threads", "rays", "write"])]
    window: bool,

    /// Print the numbers as JSON
    #[arg(long)]
    json: bool,
}

/// What is to be measured of the window.
#[derive(Clone, Debug)]
pub struct WindowBench {
    /// A scene or a mesh; the built-in demo when left out.
    pub scene: Option<PathBuf>,
    /// Measurements of everything.
    pub repeats: u16,
    /// Whether the numbers are printed as JSON.
    pub json: bool,
}

impl BenchArguments {
    /// What is to be measured of the window, where that is asked for.
    pub(super) fn of_window(&self) -> Option<WindowBench> {
        self.window.then(|| WindowBench {
            scene: self.scene.path().map(Path::to_owned),
            repeats: self.repeats,
            json: self.json,
        })
    }
}

fn structure_names() -> Vec<&'static str> {
    Structure::ALL.iter().map(|(_, name)| *name).collect()
}

pub(super) fn run(arguments: &BenchArguments) -> Result<()> {
    let cancel = CancelToken::new();
    let loaded = arguments.scene.load([], &cancel)?;
    let loaded = loaded.ok_or_else(|| anyhow!("loading was cancelled"))?;
    for warning in loaded.warnings.iter().chain(&loaded.scene.warnings()) {
        super::warn(warning);
    }
    let mut scene = bench::with_lamp(&loaded.scene);
    scene.render.accelerator = AcceleratorChoice::Auto;
    let prepared = PreparedScene::prepare(&scene, None, &cancel)?
        .ok_or_else(|| anyhow!("preparing was cancelled"))?;
    let assembly = prepared.geometry().accelerator();
    if assembly.triangle_count() == 0 {
        bail!("the scene has no triangles, so there is nothing to measure");
    }
    if let Some(folder) = &arguments.write {
        let (own, mesh) = (arguments.scene.path(), folder.join(MESH_FILE));
        refuse_input(&loaded.scene, own, &mesh, "the triangles of --write")?;
    }

    let sets = if arguments.rays.is_empty() {
        let sets = bench::generate(&prepared)?;
        if let Some(folder) = &arguments.write {
            write(&scene, &sets, folder)?;
        }
        sets.into()
    } else {
        read(&arguments.rays, &prepared)?
    };
    if sets.iter().all(|set| set.rays().is_empty()) {
        bail!("no ray of the picture passes the scene, so there is nothing to measure");
    }

    let structures = structures(&arguments.structures, assembly.triangle_count());
    let run = RunConfig {
        threads: arguments.threads.map_or(0, usize::from),
        ..RunConfig::default()
    };
    let config = MeasureConfig {
        repeats: arguments.repeats.into(),
        threads: run.thread_count(),
    };
    let reports = bench::measure(assembly, &structures, &sets, config)?;
    let name = arguments.scene.name();
    let facts = BenchFacts::new(name, assembly.triangle_count(), config, &sets, &reports);
    if arguments.json {
        super::say_json(&facts)
    } else {
        super::say(&table::describe(&facts))
    }
}

/// The structures of these names, each once; the trees where there are none, and brute force where that is cheap.
fn structures(names: &[String], triangles: u32) -> Vec<Structure> {
    let is_wanted = |structure: Structure| match structure {
        _ if !names.is_empty() => names.iter().any(|name| name == structure.name()),
        Structure::BruteForce => triangles <= FEW_TRIANGLES,
        Structure::Wide | Structure::WideFast | Structure::KdTree => true,
    };
    let all = Structure::ALL.iter().map(|(structure, _)| *structure);
    all.filter(|&structure| is_wanted(structure)).collect()
}

/// The rays of these files, each set under its file's name without extension.
fn read(paths: &[PathBuf], scene: &PreparedScene) -> Result<Vec<RaySet>> {
    let mut sets: Vec<RaySet> = Vec::new();
    for path in paths {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        if sets.iter().any(|set| set.name() == name) {
            bail!(
                "{}: there is another file of rays called {name}; the name is what tells them apart",
                path.display()
            );
        }
        let rows = io::load_rays(path)?;
        let frame = scene.geometry().frame();
        let any_hit = asks_for_any_hit(path);
        let set =
            RaySet::new(name, any_hit, rows, frame).with_context(|| path.display().to_string())?;
        sets.push(set);
    }
    Ok(sets)
}

fn asks_for_any_hit(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_else(|| OsStr::new(""));
    name.to_string_lossy().ends_with("_shadow.npy")
}

/// Writes rays and triangles for other programs.
fn write(scene: &Scene, sets: &[RaySet; 4], folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder)
        .with_context(|| format!("{}: the folder cannot be made", folder.display()))?;
    for (kind, set) in RayKind::ALL.into_iter().zip(sets) {
        io::save_rays(set.rows(), &folder.join(kind.file_name()))?;
    }
    let path = folder.join(MESH_FILE);
    io::write_atomically(&path, |out| bench::write_mesh(scene, out))
        .with_context(|| format!("{}: the triangles cannot be written", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brute_force_is_measured_when_asked_for_or_cheap() {
        use Structure::{BruteForce, KdTree, Wide, WideFast};
        assert_eq!(structures(&[], 1000), [Wide, WideFast, KdTree]);
        assert_eq!(structures(&[], 12), [Wide, WideFast, KdTree, BruteForce]);
        let names = ["brute-force", "wide", "wide"].map(str::to_owned);
        assert_eq!(structures(&names, 1000), [Wide, BruteForce]);
        let all = ["wide", "wide-fast", "kd-tree", "brute-force"];
        assert_eq!(structure_names(), all);
    }

    #[test]
    fn the_end_of_a_name_says_what_is_asked_for() {
        assert!(asks_for_any_hit(Path::new("rays/sun_shadow.npy")));
        assert!(!asks_for_any_hit(Path::new("a_shadow.npy/camera.npy")));
        assert!(!asks_for_any_hit(Path::new("shadow.npy")));
        assert!(!asks_for_any_hit(Path::new("..")));
    }
}

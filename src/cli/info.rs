use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow};
use clap::Args;
use serde::Serialize;
use serde_json::Value;

use crate::analysis::report::percent;
use crate::control::{CancelToken, Progress};
use crate::io::{self, MeshFile, PNG_HASH_KEYWORD, WrittenError, WrittenOrigin};
use crate::math::DBounds;
use crate::render::Image;
use crate::scene::{Choice, Scene};

/// What `raymini info` takes.
#[derive(Debug, Args)]
pub struct InfoArguments {
    /// A mesh, a scene file, or a picture (.png, .exr, .hdr)
    file: PathBuf,

    /// Print the facts as JSON
    #[arg(long)]
    json: bool,
}

/// What a file holds.
#[derive(Debug, Serialize)]
#[serde(untagged)]
enum Facts {
    Mesh(MeshFacts),
    Scene(SceneFacts),
    Picture(PictureFacts),
}

#[derive(Debug, Serialize)]
struct MeshFacts {
    format: &'static str,
    vertices: usize,
    faces: u64,
    polygons: u64,
    triangles: usize,
    bounds: Option<Box3>,
    dropped: DroppedFacts,
    warnings: Vec<String>,
}

#[derive(Debug, Serialize)]
struct DroppedFacts {
    degenerate: u64,
    too_few_corners: u64,
}

#[derive(Debug, Serialize)]
struct SceneFacts {
    format: &'static str,
    objects: Vec<ObjectFacts>,
    materials: Vec<String>,
    lights: usize,
    triangles: u64,
    bounds: Option<Box3>,
    mode: &'static str,
    width: u32,
    height: u32,
    samples_per_pixel: u32,
    warnings: Vec<String>,
}

#[derive(Debug, Serialize)]
struct ObjectFacts {
    name: String,
    mesh: String,
    triangles: usize,
    copies: u64,
}

#[derive(Debug, Serialize)]
struct PictureFacts {
    format: &'static str,
    width: usize,
    height: usize,
    /// Hash of the radiance the picture was made from, where it is known.
    image_hash: Option<String>,
    /// The text of the scene file that was rendered, where the picture tells.
    scene: Option<String>,
    /// What that says about rendering.
    settings: Option<Value>,
    /// How wrong the picture is, where it tells.
    error: Option<WrittenError>,
    warnings: Vec<String>,
}

/// Corners of a box.
#[derive(Debug, Serialize)]
struct Box3 {
    min: [f64; 3],
    max: [f64; 3],
}

impl Box3 {
    fn of(bounds: &DBounds) -> Option<Self> {
        (!bounds.is_empty()).then(|| Self {
            min: bounds.min.to_array(),
            max: bounds.max.to_array(),
        })
    }
}

pub(super) fn run(arguments: &InfoArguments) -> Result<()> {
    let facts = facts(&arguments.file)?;
    if arguments.json {
        super::say(
            &serde_json::to_string_pretty(&facts).context("the facts cannot be written as JSON")?,
        )
    } else {
        super::say(&describe(&arguments.file, &facts))
    }
}

fn facts(path: &Path) -> Result<Facts> {
    let (cancel, progress) = (CancelToken::new(), Progress::new());
    let cancelled = || anyhow!("loading was cancelled");
    let extension = path
        .extension()
        .map(|extension| extension.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("toml") => {
            let loaded = io::load_scene(path, &cancel, &progress)?.ok_or_else(cancelled)?;
            let warnings = [loaded.warnings, loaded.scene.warnings()].concat();
            Ok(Facts::Scene(scene_facts(&loaded.scene, warnings)))
        }
        Some("png") => Ok(Facts::Picture(with_origin(png_facts(path)?, path)?)),
        Some("exr" | "hdr") => Ok(Facts::Picture(with_origin(radiance_facts(path)?, path)?)),
        _ => {
            let file = io::load_mesh(path, &cancel, &progress)?.ok_or_else(cancelled)?;
            Ok(Facts::Mesh(mesh_facts(file)))
        }
    }
}

fn mesh_facts(file: MeshFile) -> MeshFacts {
    MeshFacts {
        format: file.format,
        vertices: file.mesh.positions.len(),
        faces: file.faces,
        polygons: file.polygons,
        triangles: file.mesh.triangles.len(),
        bounds: Box3::of(&file.mesh.bounds()),
        dropped: DroppedFacts {
            degenerate: file.dropped.degenerate,
            too_few_corners: file.dropped.too_few_corners,
        },
        warnings: file.warnings,
    }
}

fn scene_facts(scene: &Scene, warnings: Vec<String>) -> SceneFacts {
    let object = |object: &crate::scene::Object| ObjectFacts {
        name: object.name.clone(),
        mesh: object.mesh.clone(),
        triangles: scene
            .meshes
            .get(&object.mesh)
            .map_or(0, |mesh| mesh.triangles.len()),
        copies: object.copies.total(),
    };
    SceneFacts {
        format: "RayMini scene",
        objects: scene.objects.iter().map(object).collect(),
        materials: scene.materials.keys().cloned().collect(),
        lights: scene.lights.len(),
        triangles: scene.triangle_count(),
        bounds: Box3::of(&scene.bounds()),
        mode: scene.render.mode.name(),
        width: scene.render.width,
        height: scene.render.height,
        samples_per_pixel: scene.render.samples_per_pixel,
        warnings,
    }
}

fn png_facts(path: &Path) -> Result<PictureFacts> {
    let file = open(path)?;
    let reader = png::Decoder::new(BufReader::new(file))
        .read_info()
        .with_context(|| format!("{}: expected a PNG picture", path.display()))?;
    let info = reader.info();
    let hash = info
        .uncompressed_latin1_text
        .iter()
        .find(|chunk| chunk.keyword == PNG_HASH_KEYWORD);
    Ok(PictureFacts {
        format: "PNG",
        width: info.width as usize,
        height: info.height as usize,
        image_hash: hash.map(|chunk| chunk.text.clone()),
        scene: None,
        settings: None,
        error: None,
        warnings: Vec::new(),
    })
}

fn radiance_facts(path: &Path) -> Result<PictureFacts> {
    let loaded = io::load_image(path, &CancelToken::new(), &Progress::new())?;
    let file = loaded.ok_or_else(|| anyhow!("loading was cancelled"))?;
    let map = &file.map;
    // The hash is that of the file's own values.
    let image = (file.cleaned == 0).then(|| Image {
        width: map.width(),
        height: map.height(),
        pixels: map.pixels().to_vec(),
    });
    Ok(PictureFacts {
        format: file.format,
        width: map.width() as usize,
        height: map.height() as usize,
        image_hash: image.map(|image| image.hash()),
        scene: None,
        settings: None,
        error: None,
        warnings: file.warnings,
    })
}

/// The facts, with what the file tells of how the picture came to be.
fn with_origin(facts: PictureFacts, path: &Path) -> Result<PictureFacts> {
    let origin =
        WrittenOrigin::of_file(path).map_err(|reason| anyhow!("{}: {reason}", path.display()))?;
    let table = origin
        .scene
        .as_ref()
        .and_then(|text| text.parse::<toml::Table>().ok());
    let settings = table.and_then(|mut table| table.remove("render"));
    Ok(PictureFacts {
        settings: settings.map(serde_json::to_value).transpose()?,
        scene: origin.scene,
        error: origin.error,
        ..facts
    })
}

fn open(path: &Path) -> Result<File> {
    io::open_file(path, "a picture").map_err(|reason| anyhow!("{}: {reason}", path.display()))
}

/// The facts as lines for people: a name and a value each.
fn describe(path: &Path, facts: &Facts) -> String {
    let mut lines = vec![path.display().to_string()];
    let mut line = |name: &str, value: String| lines.push(format!("  {name:<12}{value}"));
    let warnings = match facts {
        Facts::Mesh(mesh) => {
            line("format", mesh.format.to_owned());
            line("vertices", mesh.vertices.to_string());
            line(
                "faces",
                format!(
                    "{}, {} of them with more than three corners",
                    mesh.faces, mesh.polygons
                ),
            );
            line("triangles", mesh.triangles.to_string());
            line("bounds", describe_box(mesh.bounds.as_ref()));
            let DroppedFacts {
                degenerate,
                too_few_corners,
            } = mesh.dropped;
            line(
                "left out",
                format!(
                    "{degenerate} faces without area, {too_few_corners} with fewer than three corners"
                ),
            );
            &mesh.warnings
        }
        Facts::Scene(scene) => {
            line("format", scene.format.to_owned());
            line(
                "picture",
                format!(
                    "{}, {}×{}, {} samples",
                    scene.mode, scene.width, scene.height, scene.samples_per_pixel
                ),
            );
            for object in &scene.objects {
                let copies = if object.copies == 1 {
                    String::new()
                } else {
                    format!(" × {}", object.copies)
                };
                line(
                    "object",
                    format!(
                        "{}: {} triangles{copies}, {}",
                        object.name, object.triangles, object.mesh
                    ),
                );
            }
            line(
                "materials",
                if scene.materials.is_empty() {
                    "none".to_owned()
                } else {
                    scene.materials.join(", ")
                },
            );
            line("lights", scene.lights.to_string());
            line("triangles", scene.triangles.to_string());
            line("bounds", describe_box(scene.bounds.as_ref()));
            &scene.warnings
        }
        Facts::Picture(picture) => {
            line("format", picture.format.to_owned());
            line("size", format!("{}×{}", picture.width, picture.height));
            line(
                "hash",
                picture
                    .image_hash
                    .clone()
                    .unwrap_or_else(|| "unknown: not a picture by RayMini".to_owned()),
            );
            if let Some(error) = &picture.error {
                line(
                    "error",
                    format!(
                        "noise {}, rmse {:.3e}, estimated at {:.1} samples per pixel",
                        percent(error.relmse.sqrt()),
                        error.rmse,
                        error.samples_per_pixel
                    ),
                );
            }
            if picture.scene.is_some() {
                line(
                    "scene",
                    "in the file: open or render it as a scene".to_owned(),
                );
            }
            &picture.warnings
        }
    };
    for warning in warnings {
        line("warning", warning.clone());
    }
    lines.join("\n")
}

fn describe_box(bounds: Option<&Box3>) -> String {
    match bounds {
        None => "empty".to_owned(),
        Some(Box3 { min, max }) => {
            format!(
                "({}, {}, {}) to ({}, {}, {})",
                min[0], min[1], min[2], max[0], max[1], max[2]
            )
        }
    }
}

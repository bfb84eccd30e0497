//! `raymini info`: what a mesh, a scene file or a picture holds, as lines for people or as JSON.

use std::fmt::Display;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow};
use clap::Args;
use serde::Serialize;
use serde_json::Value;

use crate::control::{CancelToken, Progress};
use crate::geometry::{TriangleMesh, Winding};
use crate::io::{self, Model, WrittenError, WrittenOrigin};
use crate::math::{DBounds, counted, percent};
use crate::render::{Image, Region};
use crate::scene::{Choice, Material, Object, Scene};

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
    vertices: u64,
    faces: u64,
    polygons: u64,
    triangles: u64,
    /// Triangles of all objects: more where they repeat meshes.
    shown_triangles: u64,
    bounds: Option<Box3>,
    /// What the vertices of any mesh carry beside their positions.
    attributes: Vec<&'static str>,
    dropped: DroppedFacts,
    /// Nodes of its scene, where the format has them.
    nodes: Option<u64>,
    /// What the file becomes in a scene.
    objects: Vec<ObjectFacts>,
    materials: Vec<MaterialFacts>,
    lights: usize,
    camera: bool,
    winding: WindingFacts,
    warnings: Vec<String>,
}

/// The way round in which triangles turn, of all meshes.
#[derive(Debug, Default, Serialize)]
struct WindingFacts {
    /// Triangles that turn the other way round than most of their surface.
    turned: u64,
    /// Closed surfaces that look inwards and bound no hollow.
    inside_out: u64,
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
    material: Option<String>,
}

#[derive(Debug, Serialize)]
struct MaterialFacts {
    name: String,
    kind: &'static str,
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
    /// Which part of what it says the picture is; `None` for all of it.
    region: Option<Region>,
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
        super::say_json(&facts)
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
            let model = io::load_model(path, &cancel, &progress)?.ok_or_else(cancelled)?;
            Ok(Facts::Mesh(mesh_facts(model)))
        }
    }
}

fn mesh_facts(model: Model) -> MeshFacts {
    let Model { scene, facts, .. } = model;
    let winding = winding_facts(&scene);
    let of_winding = describe_winding(&winding);
    let material = |(name, material): (&String, &Material)| MaterialFacts {
        name: name.clone(),
        kind: material.kind(),
    };
    MeshFacts {
        format: facts.format,
        vertices: facts.vertices,
        faces: facts.faces,
        polygons: facts.polygons,
        triangles: facts.triangles,
        shown_triangles: scene.triangle_count(),
        bounds: Box3::of(&facts.bounds),
        attributes: attributes(&scene),
        dropped: DroppedFacts {
            degenerate: facts.dropped.degenerate,
            too_few_corners: facts.dropped.too_few_corners,
        },
        nodes: facts.nodes,
        objects: scene
            .objects
            .iter()
            .map(|object| object_facts(&scene, object))
            .collect(),
        materials: scene.materials.iter().map(material).collect(),
        lights: scene.lights.len(),
        camera: model.camera.is_some(),
        winding,
        warnings: model.warnings.into_iter().chain(of_winding).collect(),
    }
}

/// What the vertices of any mesh carry beside their positions.
fn attributes(scene: &Scene) -> Vec<&'static str> {
    let any =
        |is_there: fn(&TriangleMesh) -> bool| scene.meshes.values().any(|mesh| is_there(mesh));
    [
        ("normals", any(|mesh| mesh.normals.is_some())),
        (
            "texture coordinates",
            any(|mesh| mesh.texture_coordinates.is_some()),
        ),
        ("colours", any(|mesh| mesh.colors.is_some())),
    ]
    .into_iter()
    .filter_map(|(name, is_there)| is_there.then_some(name))
    .collect()
}

fn winding_facts(scene: &Scene) -> WindingFacts {
    let mut facts = WindingFacts::default();
    for mesh in scene.meshes.values() {
        let Winding {
            turned, inside_out, ..
        } = Winding::of(mesh);
        facts.turned += turned;
        facts.inside_out += inside_out;
    }
    facts
}

/// What is to be said of windings that are not right.
fn describe_winding(winding: &WindingFacts) -> Option<String> {
    let turned = match winding.turned {
        0 => None,
        1 => Some("1 triangle turns the other way round than its neighbours".to_owned()),
        count => Some(format!(
            "{count} triangles turn the other way round than their neighbours"
        )),
    };
    let inside_out = match winding.inside_out {
        0 => None,
        1 => Some("1 closed surface is inside out".to_owned()),
        count => Some(format!("{count} closed surfaces are inside out")),
    };
    let found: Vec<_> = [turned, inside_out].into_iter().flatten().collect();
    (!found.is_empty()).then(|| {
        format!(
            "{}: an object's repair_winding = true puts that right, or raymini convert --repair-winding",
            found.join(", and ")
        )
    })
}

fn object_facts(scene: &Scene, object: &Object) -> ObjectFacts {
    let mesh = scene.meshes.get(&object.mesh);
    ObjectFacts {
        name: object.name.clone(),
        mesh: object.mesh.clone(),
        triangles: mesh.map_or(0, |mesh| mesh.triangles.len()),
        copies: object.copies.total(),
        material: object.material.clone(),
    }
}

fn scene_facts(scene: &Scene, warnings: Vec<String>) -> SceneFacts {
    SceneFacts {
        format: "RayMini scene",
        objects: scene
            .objects
            .iter()
            .map(|object| object_facts(scene, object))
            .collect(),
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
    // What the header tells holds for a file that was cut off, too.
    let warnings = match io::read_image(path) {
        Ok(picture) => picture.warnings,
        Err(error) => vec![format!(
            "the picture in it cannot be read, what is said of it is what its header tells: {}",
            error.reason
        )],
    };
    Ok(PictureFacts {
        format: "PNG",
        width: info.width as usize,
        height: info.height as usize,
        image_hash: None,
        scene: None,
        settings: None,
        region: None,
        error: None,
        warnings,
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
        region: None,
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
        region: origin.region,
        error: origin.error,
        image_hash: match origin.rendered_hash {
            Some(hash) => Some(hash).filter(|hash| !hash.is_empty()),
            None => facts.image_hash,
        },
        ..facts
    })
}

fn open(path: &Path) -> Result<File> {
    io::open_file(path, "a picture").map_err(|reason| anyhow!("{}: {reason}", path.display()))
}

/// The facts as lines for people: a name and a value each.
fn describe(path: &Path, facts: &Facts) -> String {
    let mut lines = Lines(vec![path.display().to_string()]);
    let warnings = match facts {
        Facts::Mesh(mesh) => {
            describe_mesh(mesh, &mut lines);
            &mesh.warnings
        }
        Facts::Scene(scene) => {
            describe_scene(scene, &mut lines);
            &scene.warnings
        }
        Facts::Picture(picture) => {
            describe_picture(picture, &mut lines);
            &picture.warnings
        }
    };
    lines.add_all("warning", warnings, String::clone);
    lines.0.join("\n")
}

/// Lines of a name and a value.
struct Lines(Vec<String>);

/// Most lines of one name: all that is said of a file fits on a screen.
const MOST_LINES: usize = 12;

impl Lines {
    fn add(&mut self, name: &str, value: impl Display) {
        self.0.push(format!("  {name:<12}{value}"));
    }

    /// A line for each of the first values, and how many more there are.
    fn add_all<T>(&mut self, name: &str, values: &[T], shown: impl Fn(&T) -> String) {
        for value in values.iter().take(MOST_LINES) {
            self.add(name, shown(value));
        }
        if values.len() > MOST_LINES {
            self.add(name, format!("and {} more", values.len() - MOST_LINES));
        }
    }
}

fn describe_mesh(mesh: &MeshFacts, lines: &mut Lines) {
    lines.add("format", mesh.format);
    let mut vertices = mesh.vertices.to_string();
    if !mesh.attributes.is_empty() {
        vertices = format!("{vertices}, with {}", mesh.attributes.join(", "));
    }
    lines.add("vertices", vertices);
    let MeshFacts {
        faces, polygons, ..
    } = mesh;
    lines.add(
        "faces",
        format!("{faces}, {polygons} of them with more than three corners"),
    );
    let shown = mesh.shown_triangles;
    lines.add(
        "triangles",
        if shown > mesh.triangles {
            format!(
                "{}; {shown} in all objects, which repeat meshes",
                mesh.triangles
            )
        } else {
            mesh.triangles.to_string()
        },
    );
    lines.add("bounds", describe_box(mesh.bounds.as_ref()));
    let DroppedFacts {
        degenerate,
        too_few_corners,
    } = mesh.dropped;
    lines.add(
        "left out",
        format!("{degenerate} faces without area, {too_few_corners} with fewer than three corners"),
    );
    if let Some(nodes) = mesh.nodes {
        lines.add("nodes", nodes);
    }
    // A plain mesh is one object without a material, of which there is nothing more to say.
    if mesh.objects.len() > 1 || !mesh.materials.is_empty() {
        lines.add_all("object", &mesh.objects, |object| {
            let worn = object
                .material
                .as_ref()
                .map(|name| format!(", material {name}"));
            let worn = worn.unwrap_or_default();
            let ObjectFacts {
                name, triangles, ..
            } = object;
            format!(
                "{name}: {}{worn}",
                counted(*triangles as u64, "triangle", "triangles")
            )
        });
        lines.add_all("material", &mesh.materials, |material| {
            format!("{}: {}", material.name, material.kind)
        });
    }
    if mesh.lights > 0 || mesh.camera {
        lines.add("lights", mesh.lights);
        lines.add("camera", if mesh.camera { "one" } else { "none" });
    }
}

fn describe_scene(scene: &SceneFacts, lines: &mut Lines) {
    lines.add("format", scene.format);
    let SceneFacts {
        mode,
        width,
        height,
        samples_per_pixel,
        ..
    } = scene;
    lines.add(
        "picture",
        format!(
            "{mode}, {width}×{height}, {}",
            counted((*samples_per_pixel).into(), "sample", "samples")
        ),
    );
    lines.add_all("object", &scene.objects, |object| {
        let copies = if object.copies == 1 {
            String::new()
        } else {
            format!(" × {}", object.copies)
        };
        let ObjectFacts {
            name,
            triangles,
            mesh,
            ..
        } = object;
        format!(
            "{name}: {}{copies}, {mesh}",
            counted(*triangles as u64, "triangle", "triangles")
        )
    });
    let names = match &scene.materials[..] {
        [] => "none".to_owned(),
        names if names.len() > MOST_LINES => {
            let more = names.len() - MOST_LINES;
            format!("{} and {more} more", names[..MOST_LINES].join(", "))
        }
        names => names.join(", "),
    };
    lines.add("materials", names);
    lines.add("lights", scene.lights);
    lines.add("triangles", scene.triangles);
    lines.add("bounds", describe_box(scene.bounds.as_ref()));
}

fn describe_picture(picture: &PictureFacts, lines: &mut Lines) {
    lines.add("format", picture.format);
    lines.add("size", format!("{}×{}", picture.width, picture.height));
    let hash = picture.image_hash.as_deref();
    let unknown = match picture.format {
        "PNG" => "unknown: not a picture by RayMini",
        _ => "unknown: it has values that are infinite, negative or not a number",
    };
    lines.add("hash", hash.unwrap_or(unknown));
    if let Some(error) = &picture.error {
        lines.add(
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
        lines.add("scene", "in the file: open or render it as a scene");
    }
    if let Some(region) = picture.region {
        let Region { x, y, .. } = region;
        lines.add(
            "part",
            format!("of a larger picture, from pixel {x},{y} on"),
        );
    }
}

/// All digits of a number that matter, with an exponent where there would be many zeros.
fn coordinate(value: f64) -> String {
    if value == 0.0 || (1e-5..1e16).contains(&value.abs()) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

fn describe_box(bounds: Option<&Box3>) -> String {
    match bounds {
        None => "empty".to_owned(),
        Some(Box3 { min, max }) => {
            let [min, max] = [min, max].map(|corner| corner.map(coordinate).join(", "));
            format!("({min}) to ({max})")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_have_the_digits_that_matter() {
        for (value, expected) in [
            (0.0, "0"),
            (1.0, "1"),
            (-0.25, "-0.25"),
            (0.000_01, "0.00001"),
            (0.000_001_5, "1.5e-6"),
            (123_456_789.5, "123456789.5"),
            (1e300, "1e300"),
            (-1e-300, "-1e-300"),
        ] {
            assert_eq!(coordinate(value), expected);
        }
    }
}

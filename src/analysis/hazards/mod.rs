//! Hazards: what about a scene may spoil its picture, found before it is rendered, each with its count, its places, how large it
//! is and what to do about it.
//!
//! Meshes are judged in `f64`, as their files give them; vertices at exactly the same place are one. What rounding to `f32` does
//! to them is measured, not guessed. What depends on light is measured on a small pilot picture. Every part takes time
//! proportional to N log N, and a small multiple of the memory of the largest mesh.
//!
//! Left out: faces that overlap in a plane where no ray from the eye arrives first; bodies that overlap; what no sample of the
//! pilot meets.

mod coincident;
mod dark;
mod depth;
mod disk_reach;
mod edges;
mod energy;
mod faces;
mod fireflies;
mod lights;
mod materials;
mod mesh_use;
mod normals;
mod overlaps;
mod pair;
mod pilot;
mod placed_copy;
mod resolution;
mod tally;
mod view;

use serde::Serialize;

use crate::control::CancelToken;
use crate::geometry::Welded;
use crate::render::PreparedScene;
use crate::scene::{Scene, SceneError};
pub use dark::why_black;
use mesh_use::MeshUse;

/// Something that may spoil a picture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Hazard {
    /// Of which kind.
    pub kind: HazardKind,
    /// How much it matters.
    pub severity: Severity,
    /// What of the scene it is about.
    #[serde(flatten)]
    pub subject: Subject,
    /// How many faces, edges, corners, rays or samples; those of one copy where there are copies.
    pub count: u64,
    /// The first few of them.
    #[serde(rename = "where")]
    pub places: Vec<Place>,
    /// How large it is, where that can be said in one number.
    pub figure: Option<Figure>,
    /// What was found, with counts and figures, in a sentence without its subject.
    pub message: String,
    /// What to do, or why nothing needs to be done.
    pub advice: String,
}

impl Hazard {
    /// That so many faces were not examined, as `message` says.
    fn unexamined(faces: usize, message: String) -> Self {
        Self {
            kind: HazardKind::Unexamined,
            severity: Severity::Note,
            subject: Subject::Picture {},
            count: faces as u64,
            places: Vec::new(),
            figure: None,
            message,
            advice: "Examine parts of the scene by themselves.".to_owned(),
        }
    }
}

/// How much a hazard matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// The picture is likely wrong or noisy by it.
    Warning,
    /// Worth knowing; the picture is likely as it is meant.
    Note,
}

/// What can be found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum HazardKind {
    /// Rounding to `f32` moves corners, or points on copies that share their mesh, by more than what can be neglected. The figure is
    /// the largest move over the median edge.
    CoarseResolution,
    /// The mesh's coordinates have the digits of `f32` and lie too far from its origin for these. The figure is the distance of
    /// neighbouring numbers over the median edge.
    LostDigits,
    /// Faces that have no area after rounding to `f32`.
    CollapsedFaces,
    /// Faces without area.
    ZeroArea,
    /// Faces far thinner than long. The figure is the least height over the longest edge.
    Slivers,
    /// Faces of one mesh with the same three corners.
    DuplicateFaces,
    /// Faces of different objects or copies with the same three corners.
    CoincidentFaces,
    /// Faces of different objects that overlap in a plane and are seen, as far as rays from the eye of a pilot picture tell: the count is
    /// that of rays.
    OverlappingFaces,
    /// Edges with one face.
    OpenEdges,
    /// Edges with more than two faces.
    CrowdedEdges,
    /// Faces that turn the other way round than their neighbours.
    FlippedWindings,
    /// Closed surfaces whose faces look inwards.
    InsideOut,
    /// Corners whose normal in the file points away from the side their face looks to.
    OpposedNormals,
    /// Faces whose normals in the file lean far away from them.
    LeaningNormals,
    /// Normals in the file that are zero.
    ZeroNormals,
    /// A material that reflects more light than arrives. The figure is the largest share that is reflected.
    EnergyCreating,
    /// A camera that no object is in sight of.
    NothingSeen,
    /// A picture that no light arrives in.
    BlackPicture,
    /// Lights that no ray meets, where glass or mirrors would send it to them.
    UnmetLights,
    /// A disk light that faces pass through.
    LightCut,
    /// A light that faces touch or nearly touch. The figure is the distance, over the radius where there is one.
    LightTouching,
    /// Light that is missing because paths end at `render.max_bounces`. The figure is the missing share, or the least it is; there is none
    /// where too few paths meet light to tell.
    DepthLoss,
    /// Rare samples so bright that each of them shows. The figure is the expected share of such pixels.
    Fireflies,
    /// Samples that are infinite or not a number.
    NonFinite,
    /// A part of the scene that was too large to be examined to the end.
    Unexamined,
}

/// What of a scene a hazard is about.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Subject {
    /// A mesh, wherever it is placed.
    Mesh {
        /// As the scene names it.
        mesh: String,
        /// The objects that show it, by name.
        objects: Vec<String>,
        /// How often it is placed in all.
        copies: u64,
    },
    /// An object.
    Object {
        /// Its name.
        object: String,
        /// Its mesh, as the scene names it.
        mesh: String,
        /// How often it is placed.
        copies: u64,
    },
    /// Two objects, or two copies of one.
    Pair {
        /// Their names.
        objects: [String; 2],
        /// Their meshes, as the scene names them.
        meshes: [String; 2],
    },
    /// A light, and the object it is too near to.
    Light {
        /// Its number in the scene, from 0.
        light: usize,
        /// The object's name.
        object: String,
        /// The object's mesh, as the scene names it.
        mesh: String,
    },
    /// A material.
    Material {
        /// Its name.
        material: String,
        /// The objects that have it, by name.
        objects: Vec<String>,
    },
    /// The scene as it is rendered.
    Picture {},
}

/// Where something is.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Place {
    /// Numbers of triangles of the mesh, or of one each of two objects, from 0: those of the file's faces where all of these have
    /// three corners and none was left out.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub faces: Vec<usize>,
    /// In the world; of the first copy where there are copies.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 3]>,
    /// Column and row of the picture, from its top left.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pixel: Option<[u32; 2]>,
}

/// A number that tells how large a hazard is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// The number.
    pub value: f64,
    /// What it is the number of.
    pub of: &'static str,
}

/// Looks for hazards in `scene`; warnings come first. `None` when cancelled.
///
/// # Errors
/// What about the scene cannot be rendered.
///
/// # Panics
/// When a mesh has more than 2³²/3 triangles.
pub fn examine(scene: &Scene, cancel: &CancelToken) -> Result<Option<Vec<Hazard>>, SceneError> {
    let pilot_scene = pilot::scene_of(scene);
    let Some(prepared) = PreparedScene::prepare(&pilot_scene, None, cancel)? else {
        return Ok(None);
    };
    let pilot_scene = pilot::bounded(pilot_scene, &prepared);
    let Some(mut hazards) = examine_description(scene, &prepared, cancel)? else {
        return Ok(None);
    };
    let looks = overlaps::looks(&pilot_scene, &prepared);
    let rays = pilot_scene.render.pixel_count();
    hazards.extend(view::past_everything(scene, &looks, rays)?);
    let Some(found) = overlaps::examine(scene, &looks, &prepared, cancel)? else {
        return Ok(None);
    };
    hazards.extend(found);
    let Some(found) = energy::examine(scene, (&pilot_scene, &looks), &prepared, cancel)? else {
        return Ok(None);
    };
    hazards.extend(found);
    hazards.sort_by_key(|hazard| hazard.severity);
    Ok(Some(hazards))
}

/// What needs no picture; `None` when cancelled.
fn examine_description(
    scene: &Scene,
    prepared: &PreparedScene,
    cancel: &CancelToken,
) -> Result<Option<Vec<Hazard>>, SceneError> {
    let Some(mut hazards) = resolution::examine(scene, prepared, cancel)? else {
        return Ok(None);
    };
    for mesh in MeshUse::all_of(scene)? {
        let Some(found) = examine_mesh(&mesh, cancel) else {
            return Ok(None);
        };
        hazards.extend(found);
    }
    let frame = prepared.geometry().frame();
    let Some(found) = coincident::examine(scene, frame, cancel)? else {
        return Ok(None);
    };
    hazards.extend(found);
    hazards.extend(materials::examine(scene));
    hazards.extend(dark::examine(scene)?);
    let found = lights::examine(scene, frame, cancel)?;
    Ok(found.map(|found| {
        hazards.extend(found);
        hazards
    }))
}

/// What is wrong with a mesh by itself; `None` when cancelled.
fn examine_mesh(mesh: &MeshUse<'_>, cancel: &CancelToken) -> Option<Vec<Hazard>> {
    let welded = Welded::new(&mesh.mesh);
    let (mut hazards, left_out) = faces::examine(mesh, &welded, cancel)?;
    hazards.extend(edges::examine(mesh, &welded, &left_out, cancel)?);
    hazards.extend(normals::examine(mesh, cancel)?);
    Some(hazards)
}

/// After so many steps of a loop it is asked whether to go on.
const STEPS_BETWEEN_POLLS: usize = 1 << 16;

/// Whether a loop at step number `step` is to stop.
fn stops(cancel: &CancelToken, step: usize) -> bool {
    step.is_multiple_of(STEPS_BETWEEN_POLLS) && cancel.is_cancelled()
}

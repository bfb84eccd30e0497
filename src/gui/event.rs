//! What background jobs tell the window.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::app::Stale;
use super::commands::TextureUse;
use super::compare::{Distance, FilePicture, Side};
use super::dialogs::Opened;
use super::dialogs::files::Answer;
use super::dialogs::missing::Missing;
use super::dialogs::path_field::Listing;
use super::histogram::Histogram;
use super::keeping::{Begun, Lost};
use super::picture_buffer::{CoarseTexels, Encoded, EncodedTile, PictureId};
use super::ray_view::WantedRays;
use super::recovering::Recovered;
use super::report::Findings;
use super::time_estimate::Subject;
use super::worker::Placed;
use crate::analysis::contributions::{Contribution, Contributor};
use crate::analysis::cost::Costs;
use crate::analysis::pilot::TimeEstimate;
use crate::analysis::report::ReportError;
use crate::io::{self, Found, LoadedScene, Model, Moves, RadianceFile, ReadAgain, TextureFile};
use crate::render::{PreparedScene, RenderStats, SampleTrace};
use crate::scene::{Absent, Material, RadianceMap, Scene, TextureImage, is_absent};

/// What was read again. What has the content of what was known is that itself, and no copy of it: nothing is to be done for it.
#[derive(Debug)]
pub enum Reloaded {
    /// Meshes of a file.
    Meshes(ReadAgain),
    /// An image.
    Image {
        /// Its pixels.
        image: Arc<RadianceMap>,
        /// What is to be said of it, in sentences.
        warnings: Vec<String>,
    },
    /// Images of materials.
    Textures {
        /// The images and what scenes call them.
        images: Vec<(String, Arc<TextureImage>)>,
        /// What is to be said of them, in sentences.
        warnings: Vec<String>,
    },
    /// A scene.
    Scene(Box<LoadedScene>),
}

impl Reloaded {
    /// These meshes, beside those of `known`.
    #[must_use]
    pub fn meshes(mut read: ReadAgain, known: &Scene) -> Self {
        for (name, mesh) in &mut read.meshes {
            keep_equal(mesh, &known.meshes, name);
        }
        Self::Meshes(read)
    }

    /// The image in the file at `path`, beside that of `known`.
    #[must_use]
    pub fn image(path: &Path, file: RadianceFile, known: &Scene) -> Self {
        let name = path.to_string_lossy();
        let warnings = io::image_warnings(&name, &file);
        let mut image = Arc::new(file.map);
        keep_equal(&mut image, &known.images, &name);
        Self::Image { image, warnings }
    }

    /// These images of materials, beside those of `known`.
    #[must_use]
    pub fn textures(files: Vec<(String, TextureFile)>, known: &Scene) -> Self {
        let mut warnings = Vec::new();
        let images = files.into_iter().map(|(name, file)| {
            warnings.extend(io::texture_warnings(&name, &file));
            let mut image = Arc::new(file.image);
            keep_equal(&mut image, &known.textures, &name);
            (name, image)
        });
        Self::Textures {
            images: images.collect(),
            warnings,
        }
    }
}

/// Puts what is called `name` in place of `read`, where it is equal to that. What stood for a missing file never is what was read.
fn keep_equal<T: Absent + PartialEq>(
    read: &mut Arc<T>,
    known: &BTreeMap<String, Arc<T>>,
    name: &str,
) {
    let is_it = |there: &&Arc<T>| !is_absent(there) && **there == *read;
    if let Some(there) = known.get(name).filter(is_it) {
        read.clone_from(there);
    }
}

/// What a job tells the window. Failures are sentences for the user.
#[derive(Debug)]
pub enum Event {
    /// A scene, or meshes as a scene.
    SceneLoaded {
        /// The files it came from.
        paths: Vec<PathBuf>,
        /// The scene, or why there is none.
        result: Result<Box<Opened>, String>,
    },
    /// A scene lacks files.
    FilesMissing(Missing),
    /// It was looked where missing files are, or why not.
    Located(Result<Moves, String>),
    /// What was sought for the open scene was read.
    SoughtRead {
        /// The number of the file that the scene belongs to.
        file: usize,
        /// What was found, or why it is not what was missing.
        result: Result<Box<Found>, String>,
    },
    /// Files that are watched are not there any more.
    FilesGone(Vec<PathBuf>),
    /// An image that was dropped on the window tells what was rendered, so it is to be opened.
    RenderDropped(PathBuf),
    /// Mesh files; what becomes of them is still to be decided.
    ModelsLoaded {
        /// The files.
        paths: Vec<PathBuf>,
        /// Whether they are likely to take the place of the scene.
        replaces: bool,
        /// What is in each, or why there is nothing.
        result: Result<Vec<Model>, String>,
    },
    /// An image for the background.
    ImageLoaded {
        /// Its file.
        path: PathBuf,
        /// The image, or why there is none.
        result: Result<RadianceFile, String>,
    },
    /// An image for a material.
    TextureLoaded {
        /// Its file.
        path: PathBuf,
        /// The material's name.
        material: String,
        /// What the image says.
        texture: TextureUse,
        /// The image, or why there is none.
        result: Result<TextureFile, String>,
    },
    /// The scene can be drawn.
    Placed(Box<Placed>),
    /// The scene can be rendered, or why not.
    Prepared(Result<Box<PreparedScene>, String>),
    /// A coarse picture of the running render.
    Coarse(CoarseTexels),
    /// A tile of the running render.
    Tile(EncodedTile),
    /// Some of a picture that is shown anew.
    Encoded {
        /// The number of its render.
        number: usize,
        /// What of it.
        encoded: Encoded,
    },
    /// How far the compared pictures are apart and the texels of the difference, or why that cannot be said.
    Compared(Result<(Distance, [usize; 2]), String>),
    /// Some of a picture beside the one that is looked at.
    CompareEncoded(Side, Encoded),
    /// A picture to compare with was read, or why not.
    ComparisonRead {
        /// Its file.
        path: PathBuf,
        /// The picture, or why it cannot be read.
        result: Result<FilePicture, String>,
    },
    /// How bright the picture on the screen is.
    HistogramMade(Histogram),
    /// A small picture of a render.
    Thumbnail {
        /// Of which picture.
        picture: PictureId,
        /// As it is shown.
        image: egui::ColorImage,
    },
    /// The ball of a material is rendered; `None` where that cannot be.
    BallRendered {
        /// The material.
        material: Material,
        /// What it looks like.
        image: Option<egui::ColorImage>,
    },
    /// What an effect or a light brings is known; `None` where the scene cannot be rendered without.
    ContributionFound {
        /// The effect or light.
        contributor: Contributor,
        /// What it brings.
        contribution: Option<Box<Contribution>>,
    },
    /// The rays of a camera sample, or why there are none.
    Traced {
        /// Of which sample.
        wanted: Box<WantedRays>,
        /// The rays, or why there are none.
        result: Result<SampleTrace, String>,
    },
    /// The running render is done.
    Rendered {
        /// The picture's hash.
        hash: String,
        /// What it took.
        stats: Box<RenderStats>,
    },
    /// The running render cannot go on.
    RenderFailed {
        /// Why.
        text: String,
        /// Whether it was for want of memory.
        is_short_of_memory: bool,
    },
    /// The scene was written, or why not.
    SceneSaved {
        /// Which of what was opened the scene belongs to.
        file: usize,
        /// The file.
        path: PathBuf,
        /// What was written; `None` where somebody else has written another scene to the file, which is still there.
        result: Result<Option<Box<Scene>>, String>,
    },
    /// The picture was written, or why not.
    PictureSaved {
        /// The file.
        path: PathBuf,
        /// Which picture.
        picture: PictureId,
        /// Whether the picture was finished.
        is_whole: bool,
        /// Whether nothing more came of its render.
        is_final: bool,
        /// Nothing, `None` where it was cancelled, or why not.
        result: Result<Option<()>, String>,
    },
    /// What effects cost was measured, or why not.
    CostsMeasured {
        /// Of this scene.
        scene: Box<Scene>,
        /// The costs.
        result: Result<Box<Costs>, String>,
    },
    /// How long a render will take was found out, or why not.
    TimeEstimated {
        /// What was asked about.
        subject: Box<Subject>,
        /// The time.
        result: Result<TimeEstimate, String>,
    },
    /// The desktop's file dialog is closed.
    PathsChosen(Answer),
    /// What is in the folder that the path field shows.
    Listed(Listing),
    /// The running report knows more.
    ReportGrew(Box<Findings>),
    /// The running report is whole, or why it cannot go on.
    Reported(Result<(), ReportError>),
    /// Why the desktop does not show a folder.
    FolderNotShown(String),
    /// Work is kept from now on, or why not.
    KeepingBegun {
        /// The files opened last.
        recent: Vec<PathBuf>,
        /// Where work goes, and what was lost.
        begun: Result<Box<Begun>, String>,
    },
    /// Unsaved work was written, or why not.
    WorkKept(Result<(), String>),
    /// Lost work is back, or why not.
    Restored {
        /// Where it was found.
        lost: Lost,
        /// The document and its render, or why not.
        result: Result<Box<Recovered>, String>,
    },
    /// The running render goes on from what a window before left of it.
    RenderGoesOn {
        /// The part that is done, `0..=1`.
        share_done: f64,
        /// What that took.
        seconds: f64,
    },
    /// Why what is left of an interrupted render is of no use.
    RenderLost(String),
    /// Why the running render is not kept on disk.
    RenderNotKept(String),
    /// These files have changed on disk.
    FilesChanged(Vec<PathBuf>),
    /// A file that has changed was read again, or why not.
    Reloaded {
        /// Which file.
        stale: Stale,
        /// What is in it.
        result: Result<Reloaded, String>,
    },
    /// The files opened last are these now.
    RecentChanged(Vec<PathBuf>),
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::TriangleMesh;
    use crate::math::DVec3;

    fn mesh(at: f64) -> Arc<TriangleMesh> {
        Arc::new(TriangleMesh {
            positions: vec![DVec3::splat(at)],
            ..TriangleMesh::default()
        })
    }

    #[test]
    fn of_what_is_read_again_only_what_differs_is_new() {
        let names = ["a", "b", "c"].map(str::to_owned);
        let mut known = Scene::default();
        for name in &names[..2] {
            known.meshes.insert(name.clone(), mesh(1.0));
        }
        let read = ReadAgain {
            meshes: names.into_iter().zip([1.0, 2.0, 1.0].map(mesh)).collect(),
            warnings: Vec::new(),
        };
        let Reloaded::Meshes(ReadAgain { meshes, .. }) = Reloaded::meshes(read, &known) else {
            panic!("they are meshes");
        };
        let is_known = |(name, mesh): &(String, Arc<TriangleMesh>)| {
            let there = known.meshes.get(name);
            there.is_some_and(|there| Arc::ptr_eq(there, mesh))
        };
        assert_eq!(
            meshes.iter().map(is_known).collect::<Vec<_>>(),
            [true, false, false]
        );
    }
}

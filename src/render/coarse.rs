//! A first look: pictures of few samples, each for a block of pixels, for whoever waits. None of their samples counts.
//!
//! How large the blocks are is decided by how long they take: the first picture is shown after a time that feels like none, with
//! the smallest blocks that fit into it. Pictures of smaller blocks follow, as long as they take little of what the first pass over all
//! pixels takes.

use std::panic::resume_unwind;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use super::camera_samples::SampleId;
use super::crew::{Crew, Cut};
use super::geometry::SketchStore;
use super::kernel::{Kernel, Plain};
use super::plan::Feature;
use super::prepare::PreparedScene;
use super::run::RunConfig;
use super::stops::Stops;
use super::texturing::{Textured, Untextured};
use super::tiles::Region;
use crate::control::CancelToken;
use crate::math::Vec3;
use crate::scene::{Scene, SceneError};

/// The largest blocks are just so large that there are no more of them than this.
const FEWEST_BLOCKS: u32 = 600;
/// Side of blocks, in pixels, down to which pictures are shown however long they take: a 64th of a pass.
const SMALL: u32 = 8;
/// Side of blocks, in pixels, down to which pictures are shown where none takes longer than [`QUICK`].
const SMALLEST: u32 = 4;
/// The most that a picture of blocks smaller than [`SMALL`] may be expected to take.
const QUICK: Duration = Duration::from_millis(100);
/// Within this time something is to be seen.
const FIRST_LOOK: Duration = Duration::from_millis(20);

/// A picture whose blocks of pixels each look like the pixel in their middle.
#[derive(Clone, Debug, PartialEq)]
pub struct CoarsePicture {
    /// The part of the full picture that it shows.
    pub region: Region,
    /// Columns and rows of a block; those at the right and lower edge may have fewer.
    pub side: u32,
    /// Linear radiance of each block, row by row.
    pub rgb: Vec<[f32; 3]>,
}

impl CoarsePicture {
    /// Columns and rows of blocks.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        blocks(&self.region, self.side).map(|count| count as usize)
    }

    /// What each pixel of row `row` of the region looks like.
    ///
    /// # Panics
    /// When there is no such row.
    pub fn row(&self, row: u32) -> impl Iterator<Item = [f32; 3]> {
        let [columns, _] = self.size();
        let start = (row / self.side) as usize * columns;
        let blocks = self.rgb[start..start + columns].iter();
        let pixels = blocks.flat_map(|&rgb| std::iter::repeat_n(rgb, self.side as usize));
        pixels.take(self.region.width as usize)
    }
}

/// Columns and rows of blocks of that side.
fn blocks(region: &Region, side: u32) -> [u32; 2] {
    [region.width, region.height].map(|length| length.div_ceil(side))
}

/// Who is shown coarse pictures, each finer than the one before.
pub type OnCoarse<'a> = &'a (dyn Fn(&CoarsePicture) + Sync);

/// A scene some of whose objects have moved since it was prepared, good enough for a first look: it takes next to no time to make, but is
/// not rounded as a scene that is prepared anew.
#[derive(Clone, Debug)]
pub struct Sketch(PreparedScene);

impl Sketch {
    /// The sketch of `scene`, where that differs from the scene of `previous` only by places of objects and by what is prepared quickly;
    /// `None` where it differs by more, or when cancelled. `store`: what is kept from one sketch to the next.
    ///
    /// # Errors
    /// What about the description cannot be rendered.
    pub fn new(
        scene: &Scene,
        previous: &PreparedScene,
        store: &SketchStore,
        cancel: &CancelToken,
    ) -> Result<Option<Self>, SceneError> {
        let prepared = PreparedScene::sketch(scene, previous, store, cancel)?;
        Ok(prepared.map(Self))
    }

    /// Shows coarse pictures of `region`, or of all of it; `None` when cancelled.
    ///
    /// # Panics
    /// When the region does not lie in the picture, and with a [`RenderFault`](super::RenderFault) where the program fails at a sample.
    #[must_use]
    pub fn show(
        &self,
        region: Option<Region>,
        run: &RunConfig,
        on_coarse: OnCoarse<'_>,
    ) -> Option<()> {
        let (width, height) = self.0.size();
        let region = region.unwrap_or(Region::full(width, height));
        assert!(
            region.fits(width, height),
            "{region:?} lies outside the picture"
        );
        match show(&self.0, region, &Crew::new(run), on_coarse) {
            Ok(()) => Some(()),
            Err(Cut::Failed(fault)) => resume_unwind(Box::new(fault)),
            Err(Cut::Cancelled | Cut::Interrupted) => None,
        }
    }
}

/// Shows coarse pictures of `region`.
pub fn show(
    scene: &PreparedScene,
    region: Region,
    crew: &Crew<'_>,
    on_coarse: OnCoarse<'_>,
) -> Result<(), Cut> {
    let take = if scene.does(Feature::Textures) {
        block_radiance::<Plain<Textured>>
    } else {
        block_radiance::<Plain<Untextured>>
    };
    let started = Instant::now();
    let mut is_shown = false;
    let mut side = SMALLEST;
    while blocks(&region, side).iter().product::<u32>() > FEWEST_BLOCKS {
        side *= 2;
    }
    loop {
        let begun = Instant::now();
        let rgb = radiances(scene, region, side, crew, take)?;
        // The next has four times as many blocks.
        let next_takes = begun.elapsed() * 4;
        let is_last = side <= SMALLEST || side <= SMALL && next_takes > QUICK;
        if is_shown || is_last || started.elapsed() + next_takes > FIRST_LOOK {
            on_coarse(&CoarsePicture { region, side, rgb });
            is_shown = true;
        }
        if is_last {
            return Ok(());
        }
        side /= 2;
    }
}

/// Takes a sample and returns its radiance; `None` when stopped.
type Take = fn(&PreparedScene, SampleId, &Stops<'_>) -> Option<Vec3>;

fn block_radiance<K: Kernel>(
    scene: &PreparedScene,
    id: SampleId,
    stops: &Stops<'_>,
) -> Option<Vec3> {
    let mut tally = K::Tally::default();
    let begun = scene.begin(id, &mut tally);
    let gathered = scene.gathered::<K>(&begun, stops, &mut tally)?;
    Some(gathered.radiance)
}

/// What the blocks of that side look like, row by row.
fn radiances(
    scene: &PreparedScene,
    region: Region,
    side: u32,
    crew: &Crew<'_>,
    take: Take,
) -> Result<Vec<[f32; 3]>, Cut> {
    let [columns, rows] = blocks(&region, side).map(|count| count as usize);
    let all = Mutex::new(vec![[0.0; 3]; columns * rows]);
    let middle = |start: u32, length: u32, index: u32| {
        let low = index * side;
        start + u32::midpoint(low, (low + side).min(length) - 1)
    };
    crew.for_each(rows, &|number, _, row: &mut Vec<[f32; 3]>| {
        let index = u32::try_from(number).expect("as many as there are rows");
        let y = middle(region.y, region.height, index);
        row.clear();
        crew.sample(|stops, note| {
            for column in (0..).take(columns) {
                let id = SampleId {
                    pixel: (middle(region.x, region.width, column), y),
                    index: 0,
                };
                note.set(id);
                row.push(take(scene, id, stops)?.to_array());
            }
            Some(())
        })?;
        let mut all = all.lock().expect("no thread panics with it");
        all[number * columns..][..columns].copy_from_slice(row);
        Some(())
    })?;
    Ok(all.into_inner().expect("no thread panics with it"))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::geometry::shapes;
    use crate::math::DVec3;
    use crate::render::{RenderProgress, Watch, render_watched};
    use crate::scene::{Camera, Copies, Mode, Object};

    fn shown(show: impl FnOnce(OnCoarse<'_>)) -> CoarsePicture {
        let last = Mutex::new(None);
        show(&|picture: &CoarsePicture| *last.lock().unwrap() = Some(picture.clone()));
        last.into_inner().unwrap().expect("a picture")
    }

    /// A ball and a box that are there once, balls that share one mesh, and a floor.
    fn scene() -> Scene {
        let mut scene = Scene {
            camera: Camera {
                eye: DVec3::new(0.0, -9.0, 4.0),
                ..Camera::default()
            },
            ..Scene::default()
        };
        let meshes = [
            ("ball", shapes::icosphere(4)),
            ("box", shapes::cuboid(DVec3::NEG_ONE, DVec3::ONE)),
            ("many", shapes::icosphere(3)),
            (
                "floor",
                shapes::cuboid(DVec3::new(-9.0, -9.0, -2.0), DVec3::new(9.0, 9.0, -1.5)),
            ),
        ];
        for (name, mesh) in meshes {
            scene.meshes.insert(name.into(), Arc::new(mesh));
            scene.objects.push(Object {
                mesh: name.into(),
                ..Object::default()
            });
        }
        scene.objects[1].translate.x = 2.5;
        scene.objects[2].translate.x = -3.0;
        scene.objects[2].copies = Copies {
            count: [1, 4, 3],
            step: DVec3::splat(2.2),
        };
        scene.render.mode = Mode::Facing;
        scene.render.samples_per_pixel = 1;
        scene
    }

    fn prepared(scene: &Scene) -> PreparedScene {
        let prepared = PreparedScene::prepare(scene, None, &CancelToken::new());
        prepared.unwrap().expect("nobody cancels")
    }

    #[test]
    fn a_sketch_looks_like_what_is_prepared_anew() {
        let (store, cancel, run) = (
            SketchStore::default(),
            CancelToken::new(),
            RunConfig::default(),
        );
        let before = scene();
        let known = prepared(&before);
        let mut now = before.clone();
        // One edit after the other, all from what was prepared first.
        let edits: [fn(&mut Scene); 6] = [
            |s| s.objects[0].translate = DVec3::new(0.3, -1.0, 0.7),
            |s| s.objects[0].scale = 1.4,
            |s| s.objects[1].rotate = DVec3::new(20.0, 30.0, 40.0),
            |s| s.objects[2].translate.z = 0.5,
            |s| s.objects[0].translate = DVec3::ZERO,
            |s| s.camera.eye.x += 1.0,
        ];
        for (number, edit) in edits.into_iter().enumerate() {
            edit(&mut now);
            let sketch = Sketch::new(&now, &known, &store, &cancel).unwrap();
            let sketch = sketch.expect("only places differ");
            let drawn = shown(|on_coarse| sketch.show(None, &run, on_coarse).unwrap());
            let exact = shown(|on_coarse| {
                let watch = Watch {
                    on_coarse: Some(on_coarse),
                    ..Watch::default()
                };
                let progress = RenderProgress::default();
                render_watched(&prepared(&now), None, &run, &progress, watch).unwrap();
            });
            // How far each got depends on time.
            assert_eq!((drawn.side, exact.side), (SMALLEST, SMALLEST));
            let pairs = drawn.rgb.iter().zip(&exact.rgb);
            let others = pairs.filter(|(a, b)| (0..3).any(|i| (a[i] - b[i]).abs() > 0.01));
            let share = others.count() as f64 / exact.rgb.len() as f64;
            assert!(share < 2e-3, "edit {number}: {share} of the blocks differ");
            let moved = shown(|on_coarse| {
                let still = Sketch::new(&before, &known, &store, &cancel).unwrap();
                still.unwrap().show(None, &run, on_coarse).unwrap();
            });
            assert_ne!(moved.rgb, drawn.rgb, "edit {number} shows");
        }
    }

    #[test]
    fn there_is_no_sketch_of_other_triangles() {
        let (store, cancel) = (SketchStore::default(), CancelToken::new());
        let before = scene();
        let known = prepared(&before);
        let edits: [fn(&mut Scene); 6] = [
            |s| s.objects[0].mesh = "box".into(),
            |s| s.objects[0].smooth = true,
            |s| s.objects[0].scale = -1.0,
            |s| s.objects[2].copies.count = [1, 1, 1],
            |s| drop(s.objects.pop()),
            |s| s.render.accelerator = crate::scene::AcceleratorChoice::KdTree,
        ];
        for (number, edit) in edits.into_iter().enumerate() {
            let mut now = before.clone();
            edit(&mut now);
            let sketch = Sketch::new(&now, &known, &store, &cancel).unwrap();
            assert!(sketch.is_none(), "edit {number}");
        }
        let mut wrong = before;
        wrong.camera.eye = wrong.camera.target;
        assert!(Sketch::new(&wrong, &known, &store, &cancel).is_err());
    }

    #[test]
    fn blocks_at_the_edges_are_cut_off() {
        let region = Region {
            x: 3,
            y: 5,
            width: 10,
            height: 6,
        };
        let picture = CoarsePicture {
            region,
            side: 4,
            rgb: (0..6_u8).map(|number| [f32::from(number); 3]).collect(),
        };
        assert_eq!(picture.size(), [3, 2]);
        let row = |row| picture.row(row).map(|[red, ..]| red).collect::<Vec<_>>();
        let first = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 2.0, 2.0];
        assert_eq!(row(0), first);
        assert_eq!(row(3), first);
        assert_eq!(row(5), first.map(|red| red + 3.0));
    }
}

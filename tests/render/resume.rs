//! Renders that go on from a checkpoint, against those that were never interrupted: the same bits, error and counts.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use crate::common::{add, diffuse, rectangle};
use raymini::control::CancelToken;
use raymini::geometry::shapes;
use raymini::math::{DVec3, Degrees};
use raymini::render::{
    Checkpoint, CheckpointKeeper, Ending, Image, Layer, PreparedScene, Region, RenderOutcome,
    RenderProgress, RunConfig, TilePixels, Watch, render_watched, resume,
};
use raymini::scene::{
    Background, Camera, Facing, Light, Material, Mode, RenderSettings, Rgb, SamplerChoice, Scene,
};

/// A ball of glass on a floor under a disk light: four tiles.
pub fn scene() -> Scene {
    let mut scene = Scene::default();
    let floor = rectangle(DVec3::ZERO, DVec3::X * 9.0, DVec3::Y * 9.0);
    add(&mut scene, "floor", floor, diffuse(0.6));
    let glass = Material::Glass {
        ior: 1.5,
        attenuation: Rgb::ZERO,
    };
    add(&mut scene, "ball", shapes::icosphere(2), glass);
    scene.objects[1].translate = DVec3::Z;
    scene.lights.push(Light::Disk {
        center: DVec3::new(2.0, -1.0, 4.0),
        facing: Facing::Target(DVec3::ZERO),
        radius: 0.7,
        radiance: Rgb::splat(12.0),
        visible: true,
    });
    scene.background = Background::Constant {
        radiance: Rgb::splat(0.2),
    };
    scene.camera = Camera {
        eye: DVec3::new(0.0, -7.0, 3.0),
        target: DVec3::new(0.0, 0.0, 0.8),
        vertical_fov: Degrees(30.0),
        ..Camera::default()
    };
    scene.render = RenderSettings {
        width: 40,
        height: 36,
        samples_per_pixel: 24,
        mode: Mode::Path,
        max_bounces: 3,
        ..RenderSettings::default()
    };
    scene
}

/// What is rendered, and which parts are kept.
pub struct Case {
    pub name: &'static str,
    pub scene: Scene,
    pub region: Option<Region>,
    pub layers: bool,
}

pub fn cases() -> Vec<Case> {
    let case = |name, change: &dyn Fn(&mut Scene)| {
        let mut scene = scene();
        change(&mut scene);
        Case {
            name,
            scene,
            region: None,
            layers: false,
        }
    };
    let chooses_pixels = |scene: &mut Scene| {
        scene.render.samples_per_pixel = 200;
        scene.render.stop.noise = Some(0.03);
    };
    vec![
        case("even", &|_| ()),
        case("bounded, of direct light", &|scene| {
            scene.render.mode = Mode::Direct;
            scene.render.clamp = Some(0.5);
        }),
        case("independent samples", &|scene| {
            chooses_pixels(scene);
            scene.render.sampler = SamplerChoice::Independent;
        }),
        case("without an error", &|scene| {
            scene.render.error_estimate = false;
        }),
        case("so many passes", &|scene| {
            chooses_pixels(scene);
            scene.render.stop.noise = Some(1e-9);
            scene.render.stop.passes = Some(11);
        }),
        case("adaptive", &chooses_pixels),
        Case {
            layers: true,
            region: Some(Region {
                x: 3,
                y: 1,
                width: 35,
                height: 33,
            }),
            ..case("adaptive, a part with layers", &chooses_pixels)
        },
    ]
}

impl Case {
    pub fn prepared(&self) -> PreparedScene {
        let prepared = PreparedScene::prepare(&self.scene, None, &CancelToken::new());
        prepared.expect("can be rendered").expect("nobody cancels")
    }

    /// Renders on, from `start` if there is one, on so many threads, until `tiles` tiles are done. Shows the checkpoints to `keep`.
    fn render(
        &self,
        prepared: &PreparedScene,
        start: Option<Checkpoint>,
        threads: usize,
        tiles: usize,
        every: Duration,
        keep: &(dyn Fn(Checkpoint) + Sync),
    ) -> RenderOutcome {
        let checkpoints = Some(CheckpointKeeper {
            every,
            most_share: f64::INFINITY,
            keep,
            in_background: None,
        });
        let progress = RenderProgress::default();
        let outcome = self.for_tiles(threads, tiles, |run, watch| {
            let watch = Watch {
                checkpoints,
                ..watch
            };
            match start {
                Some(start) => resume(prepared, start, run, &progress, watch),
                None => render_watched(prepared, self.region, run, &progress, watch),
            }
        });
        outcome.expect("nobody cancels")
    }

    /// Has `render` run on so many threads, and interrupts it when `tiles` tiles are done.
    pub fn for_tiles<T>(
        &self,
        threads: usize,
        tiles: usize,
        render: impl FnOnce(&RunConfig, Watch<'_>) -> T,
    ) -> T {
        let run = RunConfig {
            threads,
            layers: self.layers,
            ..RunConfig::default()
        };
        let done = AtomicUsize::new(0);
        let on_tile = |_: &TilePixels<'_>| {
            if done.fetch_add(1, Ordering::Relaxed) + 1 == tiles {
                run.interrupt.cancel();
            }
        };
        let watch = Watch {
            on_tile: Some(&on_tile),
            ..Watch::default()
        };
        render(&run, watch)
    }

    /// Renders the rest at once.
    fn render_all(&self, prepared: &PreparedScene, start: Option<Checkpoint>) -> RenderOutcome {
        self.render(prepared, start, 2, usize::MAX, Duration::MAX, &|_| ())
    }
}

/// All that must not depend on interruptions.
#[track_caller]
pub fn assert_same(found: &RenderOutcome, expected: &RenderOutcome, what: &str) {
    let bits = |outcome: &RenderOutcome| {
        let layers = outcome.layers.iter();
        let layers: Vec<(Layer, String)> = layers.map(|(l, image)| (*l, image.hash())).collect();
        (outcome.image.hash(), layers)
    };
    assert_eq!(bits(found), bits(expected), "{what}");
    let (a, b) = (&found.stats, &expected.stats);
    assert_eq!((a.rays, a.passes), (b.rays, b.passes), "{what}");
    assert_eq!((a.ending, a.error), (b.ending, b.error), "{what}");
    assert_eq!(a.sample_range, b.sample_range, "{what}");
    assert_eq!(a.samples_per_pixel, b.samples_per_pixel, "{what}");
    let counts = |stats: &raymini::render::RenderStats| {
        let clamped = stats.clamped.samples;
        (stats.depth_limited_samples, clamped)
    };
    assert_eq!(counts(a), counts(b), "{what}");
    // A sum in the order in which threads are done.
    let [share, same] = [a, b].map(|stats| stats.clamped.energy_share);
    assert!((share - same).abs() < 1e-9, "{what}: {share} {same}");
    let errors = |outcome: &RenderOutcome| -> Vec<_> {
        outcome.errors.iter().map(|point| point.error).collect()
    };
    assert_eq!(errors(found), errors(expected), "{what}");
}

/// The most checkpoints of a render that are gone on from.
const MOST_TRIED: usize = 16;

/// As if the program were ended by force after any tile.
#[test]
fn every_checkpoint_leads_to_the_same_end() {
    for case in cases() {
        let prepared = case.prepared();
        let all = Mutex::new(Vec::new());
        let keep = |checkpoint| {
            let mut all = all.lock().unwrap_or_else(PoisonError::into_inner);
            all.push(checkpoint);
        };
        let whole = case.render(&prepared, None, 1, usize::MAX, Duration::ZERO, &keep);
        let all = all.into_inner().unwrap_or_else(PoisonError::into_inner);
        assert!(all.len() > 20, "{}: {} checkpoints", case.name, all.len());
        // An odd step, so that all moments of a pass are met.
        let step = (all.len() / MOST_TRIED) | 1;
        for (number, checkpoint) in all.into_iter().enumerate().step_by(step) {
            let found = case.render_all(&prepared, Some(checkpoint));
            assert_same(&found, &whole, &format!("{}, {number}", case.name));
        }
    }
}

/// As if SIGTERM came again and again, in the middle of passes.
#[test]
fn many_interruptions_end_in_the_same_bits() {
    for case in cases() {
        let prepared = case.prepared();
        let whole = case.render_all(&prepared, None);
        let mut start = None;
        let mut interruptions = 0;
        let found = loop {
            let last = Mutex::new(None);
            let keep = |checkpoint| {
                *last.lock().unwrap_or_else(PoisonError::into_inner) = Some(checkpoint);
            };
            let (threads, tiles) = (1 + interruptions % 3, 1 + interruptions % 5);
            let outcome = case.render(&prepared, start, threads, tiles, Duration::MAX, &keep);
            if outcome.stats.ending != Ending::Interrupted {
                break outcome;
            }
            start = last.into_inner().unwrap_or_else(PoisonError::into_inner);
            assert!(start.is_some(), "{}: nothing was kept", case.name);
            interruptions += 1;
        };
        assert!(interruptions > 5, "{}: {interruptions}", case.name);
        assert_same(&found, &whole, case.name);
    }
}

#[test]
fn the_time_of_all_parts_counts() {
    let mut case = cases().swap_remove(0);
    case.scene.render.samples_per_pixel = 1 << 20;
    case.scene.render.stop.seconds = Some(0.4);
    let prepared = case.prepared();
    let kept = Mutex::new(None);
    let keep = |checkpoint: Checkpoint| {
        let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.is_none() && checkpoint.seconds() > 0.2 {
            *kept = Some(checkpoint);
        }
    };
    case.render(&prepared, None, 2, usize::MAX, Duration::ZERO, &keep);
    let kept = kept.into_inner().unwrap_or_else(PoisonError::into_inner);
    let kept = kept.expect("half of the time was reached");
    let started = std::time::Instant::now();
    let outcome = case.render_all(&prepared, Some(kept));
    let elapsed = started.elapsed().as_secs_f64();
    assert_eq!(outcome.stats.ending, Ending::Time);
    let ahead = outcome.stats.render_seconds - elapsed;
    assert!((0.1..0.4).contains(&ahead), "{ahead} s ahead of the clock");
}

#[test]
fn what_belongs_to_another_render_does_not_fit() {
    let case = cases().swap_remove(0);
    let kept = Mutex::new(None);
    let keep = |checkpoint| *kept.lock().expect("one thread") = Some(checkpoint);
    let prepared = case.prepared();
    let outcome = case.render(&prepared, None, 1, 7, Duration::MAX, &keep);
    assert_eq!(
        outcome.image.pixels.len(),
        Image::black(40, 36).pixels.len()
    );
    let kept = kept.into_inner().expect("one thread").expect("is kept");
    let full = Region::full(40, 36);
    assert!(kept.fits(&prepared, full, &[]));
    assert!(!kept.fits(&prepared, full, &[Layer::Emission]));
    assert!(!kept.fits(&prepared, Region { width: 39, ..full }, &[]));
    assert!(!kept.fits(&prepared, Region::full(36, 40), &[]));
    for change in [
        (|settings| settings.error_estimate = false) as fn(&mut RenderSettings),
        |settings| settings.samples_per_pixel = 1,
    ] {
        let mut other = cases().swap_remove(0);
        change(&mut other.scene.render);
        assert!(!kept.fits(&other.prepared(), full, &[]));
    }
}

/// What a checkpoint shows, and then the render that goes on from it, is all of the picture.
#[test]
fn a_checkpoint_and_the_tiles_after_it_show_the_whole_picture() {
    for (number, case) in cases().iter().enumerate() {
        let prepared = case.prepared();
        let kept = Mutex::new(None);
        let keep = |checkpoint| *kept.lock().expect("no panic") = Some(checkpoint);
        case.render(&prepared, None, 2, 3 + number, Duration::MAX, &keep);
        let kept = kept.into_inner().expect("no panic").expect("is kept");

        let region = kept.region();
        let shown = Mutex::new(Image::black(region.width, region.height));
        let on_tile = |tile: &TilePixels<'_>| {
            let mut shown = shown.lock().expect("no panic");
            let width = tile.region.width as usize;
            for (row, pixels) in tile.rgb.chunks(width).enumerate() {
                let y = tile.region.y - region.y;
                let first = (y as usize + row) * region.width as usize;
                let first = first + (tile.region.x - region.x) as usize;
                shown.pixels[first..first + width].copy_from_slice(pixels);
            }
        };
        kept.show(&on_tile);
        let run = RunConfig {
            layers: case.layers,
            ..RunConfig::default()
        };
        let watch = Watch {
            on_tile: Some(&on_tile),
            ..Watch::default()
        };
        let outcome = resume(&prepared, kept, &run, &RenderProgress::default(), watch);
        let image = outcome.expect("nobody cancels").image;
        let shown = shown.into_inner().expect("no panic");
        assert_eq!(shown.hash(), image.hash(), "{}", case.name);
    }
}

/// One that takes long is not followed by another before the share it may take allows it.
#[test]
fn checkpoints_wait_for_their_share_of_the_time() {
    let case = cases().swap_remove(0);
    let kept = AtomicUsize::new(0);
    let keep = |_| {
        kept.fetch_add(1, Ordering::Relaxed);
        std::thread::sleep(Duration::from_millis(5));
    };
    let watch = Watch {
        checkpoints: Some(CheckpointKeeper {
            every: Duration::ZERO,
            most_share: 1e-9,
            keep: &keep,
            in_background: None,
        }),
        ..Watch::default()
    };
    let (run, progress) = (RunConfig::default(), RenderProgress::default());
    render_watched(&case.prepared(), None, &run, &progress, watch).expect("nobody cancels");
    assert_eq!(kept.into_inner(), 1);
}

/// One that is kept in the background is not followed by another meanwhile, nor before its share of the time allows it; only the last of an
/// interrupted render waits, and has all that is there.
#[test]
fn checkpoints_wait_for_one_that_is_kept_in_the_background() {
    let case = cases().swap_remove(0);
    let prepared = case.prepared();
    for (looks, took, expected) in [
        (usize::MAX, Duration::ZERO, 1),
        (0, Duration::from_hours(1), 1),
        (20, Duration::ZERO, 2),
    ] {
        // How often it was looked since whether the last one is kept; none before the first.
        let since = Mutex::new(None);
        let kept = Mutex::new(Vec::new());
        let keep = |checkpoint: Checkpoint| {
            let before = since.lock().unwrap().replace(0);
            assert!(before.is_none_or(|before| before > looks));
            kept.lock().unwrap().push(checkpoint.samples_per_pixel());
        };
        let is_kept = || match &mut *since.lock().unwrap() {
            None => Some(Duration::ZERO),
            Some(since) => {
                *since += 1;
                (*since > looks).then_some(took)
            }
        };
        let checkpoints = Some(CheckpointKeeper {
            every: Duration::ZERO,
            most_share: 1.0,
            keep: &keep,
            in_background: Some(&is_kept),
        });
        let tiles = if looks == 20 { 3 } else { usize::MAX };
        let progress = RenderProgress::default();
        let outcome = case.for_tiles(2, tiles, |run, watch| {
            let watch = Watch {
                checkpoints,
                ..watch
            };
            render_watched(&prepared, None, run, &progress, watch)
        });
        let kept = kept.into_inner().unwrap();
        assert_eq!(kept.len(), expected);
        let outcome = outcome.expect("nobody cancels");
        if outcome.stats.ending == Ending::Interrupted {
            assert_eq!(kept[1], outcome.stats.samples_per_pixel);
        }
    }
}

//! A fault of the program while it takes a sample: told with the pixel and the sample, so that it can be looked at again.
//!
//! A panic in a thread that samples is caught where the sample is known, and [`render`](super::render) ends by panicking with a
//! [`RenderFault`] in its place, without a word: whoever catches it tells the user.

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};

use super::camera_samples::SampleId;

/// What the program failed at, as the payload of a panic.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "rendering failed at pixel {},{}, sample {sample}: {message}; replay with raymini render SCENE --pixel {},{} --sample {sample}",
    pixel.0, pixel.1, pixel.0, pixel.1
)]
pub struct RenderFault {
    /// Column and row in the full picture. Of a fault while the rays of several pixels are traced together: one of those.
    pub pixel: (u32, u32),
    /// Index of the sample.
    pub sample: u32,
    /// What the panic said, and where, if [`keep_panics_quiet`] was called.
    pub message: String,
}

/// The sample that is being worked on.
pub type SampleNote = Cell<SampleId>;

thread_local! {
    /// Where in the source this thread panicked; `None` while it takes no samples.
    static PLACE: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Does `work`, which writes in `note` the sample it is at; a panic becomes a fault.
pub fn caught<T>(note: &SampleNote, work: impl FnOnce() -> T) -> Result<T, RenderFault> {
    PLACE.set(Some(String::new()));
    // What `work` leaves unfinished goes with the render.
    let result = catch_unwind(AssertUnwindSafe(work));
    let place = PLACE.take().unwrap_or_default();
    result.map_err(|payload| {
        let SampleId { pixel, index } = note.get();
        RenderFault {
            pixel,
            sample: index,
            message: panic_message(payload.as_ref()) + &place,
        }
    })
}

/// From now on a panic that becomes a [`RenderFault`] is not printed: the fault says what and where. Others are printed as before.
pub fn keep_panics_quiet() {
    let before = take_hook();
    set_hook(Box::new(move |panic| {
        let place = panic.location().map(|place| format!(" ({place})"));
        let is_told = PLACE.try_with(|known| {
            let mut known = known.borrow_mut();
            let is_told = known.is_some();
            if is_told {
                *known = place;
            }
            is_told
        });
        if !is_told.unwrap_or(false) {
            before(panic);
        }
    }));
}

/// What the payload of a panic says.
#[must_use]
pub fn panic_message(payload: &(dyn Any + Send)) -> String {
    if let Some(fault) = payload.downcast_ref::<RenderFault>() {
        return fault.to_string();
    }
    let text = payload.downcast_ref::<&str>().copied();
    let text = text.or_else(|| payload.downcast_ref::<String>().map(String::as_str));
    text.unwrap_or("the program does not say why").to_owned()
}

#[cfg(test)]
mod tests {
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::control::CancelToken;
    use crate::geometry::shapes;
    use crate::render::{
        CheckpointKeeper, PreparedScene, RenderProgress, RunConfig, TilePixels, Watch,
        render_watched,
    };
    use crate::scene::{Object, RenderSettings, Scene};

    /// Of 20 tiles, in one of which a sample fails.
    fn faulty_scene(pixel: (u32, u32), sample: u32) -> PreparedScene {
        let mut scene = Scene::default();
        scene
            .meshes
            .insert("m".into(), Arc::new(shapes::icosphere(0)));
        scene.objects.push(Object {
            mesh: "m".into(),
            ..Object::default()
        });
        scene.render = RenderSettings {
            width: 160,
            height: 128,
            samples_per_pixel: 4,
            ..RenderSettings::default()
        };
        let prepared = PreparedScene::prepare(&scene, None, &CancelToken::new());
        let mut prepared = prepared.expect("can be rendered").expect("nobody cancels");
        prepared.fail_at(pixel, sample);
        prepared
    }

    #[test]
    fn a_panic_tells_the_pixel_and_the_sample() {
        keep_panics_quiet();
        for (pixel, sample, threads) in [((0, 0), 0, 1), ((33, 95), 3, 2), ((159, 127), 1, 4)] {
            let scene = faulty_scene(pixel, sample);
            let run = RunConfig {
                threads,
                ..RunConfig::default()
            };
            let tiles = AtomicUsize::new(0);
            let kept = AtomicUsize::new(0);
            let on_tile = |_: &TilePixels<'_>| {
                tiles.fetch_add(1, Ordering::Relaxed);
            };
            let keep = |_| {
                kept.fetch_add(1, Ordering::Relaxed);
            };
            let watch = Watch {
                on_tile: Some(&on_tile),
                checkpoints: Some(CheckpointKeeper {
                    every: std::time::Duration::MAX,
                    most_share: f64::INFINITY,
                    keep: &keep,
                    in_background: None,
                }),
                ..Watch::default()
            };
            let progress = RenderProgress::default();
            let render = || render_watched(&scene, None, &run, &progress, watch);
            let payload = catch_unwind(AssertUnwindSafe(render)).expect_err("fails");
            let fault: &RenderFault = payload.downcast_ref().expect("is told");
            assert_eq!((fault.pixel, fault.sample), (pixel, sample));
            assert!(
                fault.message.starts_with("as the test wants (") && fault.message.contains(".rs:"),
                "{fault}"
            );
            // No pass after that of the sample, and what was done before is not lost.
            let passes = sample as usize + 1;
            assert!(tiles.load(Ordering::Relaxed) < 20 * passes);
            assert_eq!(kept.load(Ordering::Relaxed), 1);
            let said = panic_message(payload.as_ref());
            let (x, y) = pixel;
            let replay =
                format!("; replay with raymini render SCENE --pixel {x},{y} --sample {sample}");
            assert!(
                said.starts_with(&format!(
                    "rendering failed at pixel {x},{y}, sample {sample}: "
                )) && said.ends_with(&replay),
                "{said}"
            );
        }
    }

    #[test]
    fn other_panics_keep_their_words() {
        let panicking = || panic!("a triangle has {} corners", 4);
        let payload = catch_unwind(panicking).expect_err("panics");
        assert_eq!(panic_message(payload.as_ref()), "a triangle has 4 corners");
        let payload = catch_unwind(|| std::panic::panic_any(7)).expect_err("panics");
        assert_eq!(
            panic_message(payload.as_ref()),
            "the program does not say why"
        );
    }
}

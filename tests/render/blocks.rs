//! Renders that take blocks of samples from a log in place of sampling anew: the same bits, error and counts as without.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::resume::{Case, assert_same, cases};
use raymini::io::{BlockLog, LoggedBlocks, block_record};
use raymini::render::{
    Block, BlockHeader, BlockStore, Checkpoint, Ending, PreparedScene, Region, RenderOutcome,
    RenderProgress, RunConfig, TilePixels, Watch, resume,
};

/// Which blocks there are to take, and what becomes of the others.
#[derive(Default)]
struct Store<'a> {
    known: LoggedBlocks,
    /// Whether a block is kept; all are, where it is not said.
    keeps: Option<&'a (dyn Fn(usize) -> bool + Sync)>,
    log: Option<Mutex<BlockLog>>,
    offered: AtomicUsize,
    recalled: AtomicUsize,
}

impl BlockStore for Store<'_> {
    fn begin_anew(&self) {}

    fn keep(&self, block: &Block<'_>) {
        let number = self.offered.fetch_add(1, Ordering::Relaxed);
        if let Some(log) = &self.log
            && self.keeps.is_none_or(|keeps| keeps(number))
        {
            let mut log = log.lock().unwrap_or_else(PoisonError::into_inner);
            log.append(&block_record(block)).expect("there is room");
        }
    }

    fn recall(&self, pass: u32, tile: u32) -> Option<Block<'static>> {
        let block = self.known.find(pass, tile)?;
        self.recalled.fetch_add(1, Ordering::Relaxed);
        Some(block)
    }
}

/// A log of a render that is called `name`.
fn log(path: &Path, name: &str) -> Mutex<BlockLog> {
    Mutex::new(BlockLog::create(path, name).expect("is written"))
}

/// Renders on two threads from the beginning, with what `store` knows, until so many tiles are done. Returns the rays that were traced too.
fn render(
    case: &Case,
    prepared: &PreparedScene,
    store: &Store<'_>,
    tiles: usize,
) -> (RenderOutcome, u64) {
    let run = RunConfig {
        threads: 2,
        layers: case.layers,
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
        blocks: Some(store),
        ..Watch::default()
    };
    let settings = prepared.settings();
    let region = case
        .region
        .unwrap_or(Region::full(settings.width, settings.height));
    let start = Checkpoint::before(prepared, region, run.layers_of(prepared));
    let progress = RenderProgress::default();
    let outcome = resume(prepared, start, &run, &progress, watch).expect("nobody cancels");
    (outcome, progress.rays())
}

/// As if the program were ended by force in the middle, with nothing but the log of its blocks.
#[test]
fn no_sample_that_was_kept_is_taken_again() {
    let folder = tempfile::tempdir().expect("a folder");
    for case in cases() {
        let path = folder.path().join("blocks");
        let prepared = case.prepared();
        let (whole, _) = render(&case, &prepared, &Store::default(), usize::MAX);
        let first = Store {
            log: Some(log(&path, case.name)),
            ..Store::default()
        };
        let (part, traced_before) = render(&case, &prepared, &first, 19);
        assert_eq!(part.stats.ending, Ending::Interrupted, "{}", case.name);
        let again = Store {
            known: LoggedBlocks::read(&[path], case.name),
            ..Store::default()
        };
        let headers = again.known.headers();
        let samples: u64 = headers.iter().map(|header| header.samples).sum();
        assert_eq!(samples, part.stats.samples, "{}", case.name);
        let (found, traced) = render(&case, &prepared, &again, usize::MAX);
        assert_same(&found, &whole, case.name);
        let recalled = again.recalled.into_inner();
        assert_eq!(recalled, first.offered.into_inner(), "{}", case.name);
        assert_eq!(
            traced_before + traced,
            whole.stats.rays.total(),
            "{}",
            case.name
        );
    }
}

#[test]
fn blocks_that_are_missing_are_sampled_again() {
    let folder = tempfile::tempdir().expect("a folder");
    for case in cases() {
        let path = folder.path().join("blocks");
        let prepared = case.prepared();
        let keeps = |number: usize| number % 5 < 2;
        let first = Store {
            log: Some(log(&path, case.name)),
            keeps: Some(&keeps),
            ..Store::default()
        };
        let (whole, _) = render(&case, &prepared, &first, usize::MAX);
        let again = Store {
            known: LoggedBlocks::read(&[path], case.name),
            ..Store::default()
        };
        let kept = again.known.headers().len();
        let (found, _) = render(&case, &prepared, &again, usize::MAX);
        assert_same(&found, &whole, case.name);
        let (recalled, taken) = (again.recalled.into_inner(), again.offered.into_inner());
        assert_eq!(recalled, kept, "{}", case.name);
        assert_eq!(recalled + taken, first.offered.into_inner());
    }
}

/// Such as of a render that was to take fewer: its last pass is shorter.
#[test]
fn blocks_of_other_samples_are_not_taken() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("blocks");
    let mut shorter = cases().swap_remove(0);
    shorter.scene.render.samples_per_pixel = 10;
    let first = Store {
        log: Some(log(&path, "shorter")),
        ..Store::default()
    };
    render(&shorter, &shorter.prepared(), &first, usize::MAX);

    let case = cases().swap_remove(0);
    let prepared = case.prepared();
    let (whole, _) = render(&case, &prepared, &Store::default(), usize::MAX);
    let again = Store {
        known: LoggedBlocks::read(&[path], "shorter"),
        ..Store::default()
    };
    let (found, traced) = render(&case, &prepared, &again, usize::MAX);
    assert_same(&found, &whole, "longer");
    assert!(traced < whole.stats.rays.total(), "most were of use");
    let passes = again.offered.into_inner() / 4;
    assert_eq!(passes, 3, "of 8, 12 and 16 samples on");
}

/// Who stops by the clock counts the time of samples that are not taken again.
#[test]
fn time_goes_on_where_it_was() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("blocks");
    let mut case = cases().swap_remove(0);
    case.scene.render.samples_per_pixel = 1 << 20;
    case.scene.render.stop.seconds = Some(0.4);
    let prepared = case.prepared();
    let first = Store {
        log: Some(log(&path, "timed")),
        ..Store::default()
    };
    render(&case, &prepared, &first, usize::MAX);
    let known = LoggedBlocks::read(&[path], "timed");
    let latest = |time: fn(&BlockHeader) -> f64| {
        let times = known.headers().iter().map(time);
        times.fold(0.0, f64::max)
    };
    let (last, last_cpu) = (
        latest(|header| header.seconds),
        latest(|header| header.cpu_seconds),
    );
    assert!(last > 0.2, "{last} s");
    let again = Store {
        known,
        ..Store::default()
    };
    let (outcome, _) = render(&case, &prepared, &again, usize::MAX);
    assert_eq!(outcome.stats.ending, Ending::Time);
    let seconds = outcome.stats.render_seconds;
    assert!(seconds >= last, "{seconds} s after {last} s");
    assert!(outcome.stats.cpu_seconds >= last_cpu && last_cpu > 0.0);
}

/// Files that were cut off, damaged, or are of another render give what is whole of theirs, and no more.
#[test]
fn damaged_logs_give_what_is_whole() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("blocks");
    let case = cases().swap_remove(0);
    let store = Store {
        log: Some(log(&path, "ball")),
        ..Store::default()
    };
    render(&case, &case.prepared(), &store, 9);
    let read = |name: &str| LoggedBlocks::read(std::slice::from_ref(&path), name);
    let all = read("ball").headers().to_vec();
    assert!(all.len() >= 9);
    assert!(read("balls").headers().is_empty());
    assert!(read("").headers().is_empty());

    let bytes = std::fs::read(&path).expect("is there");
    for share in 0..=64 {
        let end = bytes.len() * share / 64;
        std::fs::write(&path, &bytes[..end]).expect("is written");
        let found = read("ball");
        assert_eq!(*found.headers(), all[..found.headers().len()], "{end}");
        assert_eq!(found.headers().len() == all.len(), end == bytes.len());
    }
    for share in 0..64 {
        let mut changed = bytes.clone();
        changed[bytes.len() * share / 64 + 1] ^= 0x10;
        std::fs::write(&path, &changed).expect("is written");
        let found = read("ball");
        assert!(found.headers().len() < all.len(), "{share}");
        assert_eq!(*found.headers(), all[..found.headers().len()], "{share}");
    }
    // Lengths that reach beyond the end, and files that are none.
    for (start, end) in [(17, 21), (0, 4)] {
        let mut changed = bytes.clone();
        changed[start..end].fill(0xff);
        std::fs::write(&path, &changed).expect("is written");
        assert!(read("ball").headers().is_empty());
    }
    std::fs::remove_file(&path).expect("is there");
    assert!(read("ball").headers().is_empty());
}

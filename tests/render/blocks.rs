//! Renders that take blocks of samples from a log in place of sampling anew: the same bits, error and counts as without.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::resume::{Case, assert_same, cases};
use raymini::control::{CancelToken, Progress};
use raymini::io::{BlockLog, LoggedBlocks, block_record};
use raymini::render::{
    Block, BlockHeader, BlockStore, Checkpoint, Ending, PreparedScene, Region, RenderOutcome,
    RenderProgress, Watch, resume,
};

/// Which blocks there are to take, and what becomes of the others.
#[derive(Default)]
struct Store<'a> {
    known: LoggedBlocks,
    /// Whether a block is kept; all are, where it is not said.
    keeps: Option<&'a (dyn Fn(usize) -> bool + Sync)>,
    log: Option<Mutex<BlockLog>>,
    /// What each pass is said to have taken, by two threads, where that is not what it took.
    seconds_per_pass: Option<f64>,
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
        let mut block = self.known.find(pass, tile)?;
        if let Some(seconds) = self.seconds_per_pass {
            block.header.seconds = f64::from(pass + 1) * seconds;
            block.header.cpu_seconds = 2.0 * block.header.seconds;
        }
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
    let settings = prepared.settings();
    let region = case
        .region
        .unwrap_or(Region::full(settings.width, settings.height));
    let progress = RenderProgress::default();
    let outcome = case.for_tiles(2, tiles, |run, watch| {
        let start = Checkpoint::before(prepared, region, run.layers_of(prepared));
        let watch = Watch {
            blocks: Some(store),
            ..watch
        };
        resume(prepared, start, run, &progress, watch)
    });
    let outcome = outcome.expect("nobody cancels");
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

/// Who stops by the clock counts the time of samples that are not taken again: here passes that are said to have taken a thousand seconds
/// each, as nobody waits for.
#[test]
fn time_goes_on_where_it_was() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("blocks");
    let mut case = cases().swap_remove(0);
    let first = Store {
        log: Some(log(&path, "timed")),
        ..Store::default()
    };
    render(&case, &case.prepared(), &first, usize::MAX);

    case.scene.render.stop.seconds = Some(2500.0);
    let again = Store {
        known: LoggedBlocks::read(&[path], "timed"),
        seconds_per_pass: Some(1000.0),
        ..Store::default()
    };
    let (outcome, traced) = render(&case, &case.prepared(), &again, usize::MAX);
    // After two passes of one sample, the time left is not enough for another.
    let stats = outcome.stats;
    assert_eq!((stats.ending, stats.passes), (Ending::Time, 2));
    assert_eq!((stats.sample_range, traced), ([2, 2], 0));
    assert!((2000.0..2500.0).contains(&stats.render_seconds));
    assert!((4000.0..4500.0).contains(&stats.cpu_seconds));
}

/// Reading is followed to its end, and given up when nobody wants it.
#[test]
fn reading_a_log_tells_how_far_it_is_and_can_be_cancelled() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("blocks");
    let case = cases().swap_remove(0);
    let store = Store {
        log: Some(log(&path, "ball")),
        ..Store::default()
    };
    render(&case, &case.prepared(), &store, 9);
    let (cancel, progress) = (CancelToken::new(), Progress::new());
    let read = |cancel: &CancelToken, progress: &Progress| {
        LoggedBlocks::read_unless(std::slice::from_ref(&path), "ball", cancel, progress)
    };
    let blocks = read(&cancel, &progress).expect("nobody cancels");
    assert!(blocks.headers().len() >= 9);
    let bytes = std::fs::metadata(&path).expect("is there").len();
    assert_eq!(progress.done(), bytes);
    cancel.cancel();
    let progress = Progress::new();
    assert!(read(&cancel, &progress).is_none());
    assert!(progress.done() < bytes);
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
    // One that was whole when it was looked through.
    std::fs::write(&path, &bytes).expect("is written");
    let found = read("ball");
    let mut changed = bytes.clone();
    *changed.last_mut().expect("is not empty") ^= 0x10;
    std::fs::write(&path, &changed).expect("is written");
    let (last, others) = all.split_last().expect("there are some");
    let is_there = |header: &BlockHeader| found.find(header.pass, header.tile).is_some();
    assert!(!is_there(last) && others.iter().all(is_there));
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

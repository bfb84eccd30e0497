//! Timing builds and traversal.
//!
//! On one thread, time is that thread's own processor time: what other programs take does not count. On all threads it is
//! what a clock on the wall shows. Structures take turns, so that whatever slows the machine meets all of them.

use std::hint::black_box;
use std::ops::AddAssign;
use std::time::Instant;

use cpu_time::ThreadTime;
use rayon::ThreadPool;
use rayon::prelude::*;

use super::{RaySet, Spread, Structure};
use crate::accel::{Assembly, Packet, StructureQuality, Visits};
use crate::math::Ray;
use crate::scene::Choice;

/// A measurement traces its rays again and again until it took this long, so that clocks of any kind can tell.
const LEAST_SECONDS: f64 = 0.05;

/// Rays that a thread takes at once: some milliseconds of work.
const RAYS_PER_TASK: usize = 4096;

/// How to measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeasureConfig {
    /// Measurements of everything, at least 1.
    pub repeats: u32,
    /// Threads where all are used, at least 1.
    pub threads: usize,
}

/// What was measured about one structure.
#[derive(Clone, Debug)]
pub struct StructureReport {
    /// As people write it.
    pub name: &'static str,
    /// Building the trees on all threads, in seconds on the wall.
    pub build_seconds: Spread,
    /// Building them on one thread, in seconds of its own.
    pub build_seconds_one_thread: Spread,
    /// Memory of triangles, trees and places of copies.
    pub bytes: usize,
    /// What it came out like.
    pub quality: StructureQuality,
    /// One per set of rays, in their order.
    pub sets: Vec<SetReport>,
}

/// What was measured about one set of rays in one structure.
#[derive(Clone, Copy, Debug)]
pub struct SetReport {
    /// Rays that hit something.
    pub hits: u64,
    /// What a ray visits.
    pub visits: MeanVisits,
    /// Millions of rays per second of one thread's own time; `None` for a set without rays.
    pub mrays_per_second: Option<Spread>,
    /// The same on all threads, by the clock on the wall.
    pub mrays_per_second_all_threads: Option<Spread>,
    /// One thread, rays that follow each other traced as [`Packet`]s; `None` for a set without rays, and where any hit counts.
    pub mrays_per_second_packets: Option<Spread>,
}

/// Means over the rays of a set; 0 for none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeanVisits {
    /// See [`Visits::nodes`].
    pub nodes: f64,
    /// See [`Visits::blocks`].
    pub blocks: f64,
}

/// Two structures that answer differently: a bug in one of them.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{} and {} disagree about the rays of \"{set}\": {} and {} hits; please report this",
    structures[0], structures[1], hits[0], hits[1]
)]
pub struct Disagreement {
    /// Name of the set of rays.
    pub set: String,
    /// Names of the structures.
    pub structures: [&'static str; 2],
    /// What each hits. Where the numbers are equal, the triangles are not.
    pub hits: [u64; 2],
}

/// Builds each of the structures over the triangles of `scene`, and traces every set through each. One report per structure, in
/// their order.
///
/// # Errors
/// When structures answer differently.
///
/// # Panics
/// When threads cannot be started.
pub fn measure(
    scene: &Assembly,
    structures: &[Structure],
    sets: &[RaySet],
    config: MeasureConfig,
) -> Result<Vec<StructureReport>, Disagreement> {
    let [one_thread, all_threads] = [1, config.threads].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().expect("threads can be started")
    });
    let built = build_in_turns(scene, structures, config.repeats, &one_thread, &all_threads);

    let mut seconds: Vec<Vec<SetSeconds>> =
        vec![vec![SetSeconds::default(); sets.len()]; built.len()];
    for _ in 0..config.repeats {
        for (index, set) in sets
            .iter()
            .enumerate()
            .filter(|(_, set)| !set.rays().is_empty())
        {
            for (built, seconds) in built.iter().zip(&mut seconds) {
                let alone = seconds_per_pass::<ThreadClock, _>(|| answer(&built.assembly, set));
                seconds[index].one_thread.push(alone);
            }
            if !set.any_hit() {
                for (built, seconds) in built.iter().zip(&mut seconds) {
                    let packets =
                        seconds_per_pass::<ThreadClock, _>(|| answer_packets(&built.assembly, set));
                    seconds[index].packets.push(packets);
                }
            }
            for (built, seconds) in built.iter().zip(&mut seconds) {
                let together = all_threads.install(|| {
                    seconds_per_pass::<WallClock, _>(|| answer_together(&built.assembly, set))
                });
                seconds[index].all_threads.push(together);
            }
        }
    }

    let answers: Vec<Vec<Answers>> = built
        .iter()
        .map(|built| {
            let answers = |set| all_threads.install(|| answer_together(&built.assembly, set));
            sets.iter().map(answers).collect()
        })
        .collect();
    compare(&built, sets, &answers)?;
    let reports = built.into_iter().zip(seconds).zip(answers);
    Ok(reports
        .map(|((built, seconds), answers)| {
            let of_set = |((set, seconds), answers): ((&RaySet, SetSeconds), Answers)| SetReport {
                hits: answers.hits,
                visits: all_threads.install(|| mean_visits(&built.assembly, set)),
                mrays_per_second: rates(set, seconds.one_thread),
                mrays_per_second_all_threads: rates(set, seconds.all_threads),
                mrays_per_second_packets: rates(set, seconds.packets),
            };
            let sets = sets.iter().zip(seconds).zip(answers).map(of_set).collect();
            StructureReport {
                name: built.name,
                build_seconds: built.seconds,
                build_seconds_one_thread: built.seconds_one_thread,
                bytes: built.assembly.bytes(),
                quality: built.assembly.quality(),
                sets,
            }
        })
        .collect())
}

/// A structure over the scene, and what building it took.
struct Built {
    name: &'static str,
    assembly: Assembly,
    seconds: Spread,
    seconds_one_thread: Spread,
}

/// Seconds per pass over one set, one value per repeat.
#[derive(Clone, Debug, Default)]
struct SetSeconds {
    one_thread: Vec<f64>,
    all_threads: Vec<f64>,
    packets: Vec<f64>,
}

fn build_in_turns(
    scene: &Assembly,
    structures: &[Structure],
    repeats: u32,
    one_thread: &ThreadPool,
    all_threads: &ThreadPool,
) -> Vec<Built> {
    let mut seconds = vec![(Vec::new(), Vec::new()); structures.len()];
    let mut assemblies = Vec::new();
    for _ in 0..repeats {
        // Those of the turn before make room first.
        assemblies.clear();
        for (&structure, (together, alone)) in structures.iter().zip(&mut seconds) {
            let timed = one_thread.install(|| timed_build::<ThreadClock>(scene, structure));
            alone.push(timed.1);
            drop(timed);
            let timed = all_threads.install(|| timed_build::<WallClock>(scene, structure));
            together.push(timed.1);
            assemblies.push(timed.0);
        }
    }
    let built = structures.iter().zip(assemblies).zip(seconds);
    built
        .map(|((structure, assembly), (together, alone))| {
            let spread = |seconds| Spread::of(seconds).expect("there is at least one repeat");
            Built {
                name: structure.name(),
                assembly,
                seconds: spread(together),
                seconds_one_thread: spread(alone),
            }
        })
        .collect()
}

/// The scene in structures of that kind, and the seconds of building those: gathering triangles and placing copies aside.
fn timed_build<C: Clock>(scene: &Assembly, structure: Structure) -> (Assembly, f64) {
    let mut seconds = 0.0;
    let assembly = scene.rebuilt(|triangles| {
        let clock = C::now();
        let built = structure.build(triangles);
        seconds += clock.seconds();
        built
    });
    (assembly.expect("nobody cancels"), seconds)
}

/// What the rays of a set meet, as far as it is compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Answers {
    hits: u64,
    /// Sum of the hit triangles' ids, which depends on every nearest hit; 0 for any hit.
    triangles: u64,
}

impl AddAssign for Answers {
    fn add_assign(&mut self, other: Self) {
        self.hits += other.hits;
        self.triangles = self.triangles.wrapping_add(other.triangles);
    }
}

fn answer(assembly: &Assembly, set: &RaySet) -> Answers {
    answer_rays(assembly, set.rays(), set.any_hit())
}

fn answer_together(assembly: &Assembly, set: &RaySet) -> Answers {
    set.rays()
        .par_chunks(RAYS_PER_TASK)
        .map(|rays| answer_rays(assembly, rays, set.any_hit()))
        .reduce(Answers::default, added)
}

fn answer_rays(assembly: &Assembly, rays: &[(Ray, f32)], any_hit: bool) -> Answers {
    let mut answers = Answers::default();
    if any_hit {
        for (ray, t_max) in rays {
            answers.hits += u64::from(assembly.occluded(ray, *t_max));
        }
    } else {
        for (ray, t_max) in rays {
            if let Some(hit) = assembly.intersect(ray, *t_max) {
                answers += Answers {
                    hits: 1,
                    triangles: hit.triangle.into(),
                };
            }
        }
    }
    answers
}

fn answer_packets(assembly: &Assembly, set: &RaySet) -> Answers {
    let mut answers = Answers::default();
    for rays in set.rays().chunks(Packet::MOST_RAYS) {
        let hits = assembly.intersect_packet(&Packet::new(rays));
        for hit in hits.into_iter().flatten() {
            answers += Answers {
                hits: 1,
                triangles: hit.triangle.into(),
            };
        }
    }
    answers
}

fn mean_visits(assembly: &Assembly, set: &RaySet) -> MeanVisits {
    let of_chunk = |rays: &[(Ray, f32)]| {
        let mut visits = Visits::default();
        for (ray, t_max) in rays {
            visits += assembly.visits(ray, *t_max, set.any_hit());
        }
        visits
    };
    let chunks = set.rays().par_chunks(RAYS_PER_TASK);
    let sum = chunks.map(of_chunk).reduce(Visits::default, added);
    let count = set.rays().len().max(1) as f64;
    MeanVisits {
        nodes: sum.nodes as f64 / count,
        blocks: sum.blocks as f64 / count,
    }
}

fn added<T: AddAssign>(mut sum: T, more: T) -> T {
    sum += more;
    sum
}

fn compare(built: &[Built], sets: &[RaySet], answers: &[Vec<Answers>]) -> Result<(), Disagreement> {
    for (other, others) in built.iter().zip(answers).skip(1) {
        for ((set, first), other_answers) in sets.iter().zip(&answers[0]).zip(others) {
            if first != other_answers {
                return Err(Disagreement {
                    set: set.name().to_owned(),
                    structures: [built[0].name, other.name],
                    hits: [first.hits, other_answers.hits],
                });
            }
        }
    }
    Ok(())
}

fn rates(set: &RaySet, seconds: Vec<f64>) -> Option<Spread> {
    let rays = set.rays().len() as f64;
    Spread::of(seconds.into_iter().map(|s| rays / s / 1e6).collect())
}

/// Seconds of one call of `pass`, the mean of as many as it takes to be measurable.
fn seconds_per_pass<C: Clock, T>(mut pass: impl FnMut() -> T) -> f64 {
    let clock = C::now();
    let mut passes = 0;
    loop {
        black_box(pass());
        passes += 1;
        let seconds = clock.seconds();
        if seconds >= LEAST_SECONDS {
            return seconds / f64::from(passes);
        }
    }
}

/// What time is told by.
trait Clock {
    fn now() -> Self;
    /// Since [`Clock::now`].
    fn seconds(&self) -> f64;
}

/// Processor time of the thread that asks.
struct ThreadClock(ThreadTime);

impl Clock for ThreadClock {
    fn now() -> Self {
        Self(ThreadTime::now())
    }

    fn seconds(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}

/// Time on the wall.
struct WallClock(Instant);

impl Clock for WallClock {
    fn now() -> Self {
        Self(Instant::now())
    }

    fn seconds(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}

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

/// A measurement traces its rays again and again until that has taken this long, so that clocks of any kind can tell.
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

/// Two structures, or packets in a structure and its rays by themselves, that answer differently: a bug in one of them.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{} and {} disagree about the rays of \"{set}\": {} and {} hits; please report this",
    structures[0], structures[1], hits[0], hits[1]
)]
pub struct Disagreement {
    /// Name of the set of rays.
    pub set: String,
    /// Names of the structures, and which of them was given packets.
    pub structures: [String; 2],
    /// What each hits. Where the numbers are equal, the hits are not.
    pub hits: [u64; 2],
}

/// Builds each of the structures over the triangles of `scene`, and traces every set through each. One report per structure, in
/// their order.
///
/// # Errors
/// When structures answer differently, or one of them does when it is given packets.
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
                let packets = packets(set);
                for (built, seconds) in built.iter().zip(&mut seconds) {
                    let answer = || answer_packets(&built.assembly, &packets);
                    let together = seconds_per_pass::<ThreadClock, _>(answer);
                    seconds[index].packets.push(together);
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
    all_threads.install(|| compare(&built, sets))?;
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

/// What the rays of a set meet, summed up.
#[derive(Clone, Copy, Debug, Default)]
struct Answers {
    hits: u64,
    /// Sum of the hit triangles' ids, so that none of the work for nearest hits may be left out; 0 for any hit.
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

/// The rays of a set, sixteen that follow each other in a packet.
fn packets(set: &RaySet) -> Vec<Packet> {
    let chunks = set.rays().chunks(Packet::MOST_RAYS);
    chunks.map(Packet::new).collect()
}

fn answer_packets(assembly: &Assembly, packets: &[Packet]) -> Answers {
    let mut answers = Answers::default();
    for packet in packets {
        let hits = assembly.intersect_packet(packet);
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

/// Compares every structure with the first, and with itself when it is given packets.
fn compare(built: &[Built], sets: &[RaySet]) -> Result<(), Disagreement> {
    let first = &built[0];
    for set in sets {
        for other in &built[1..] {
            if !agree([&first.assembly, &other.assembly], set) {
                return Err(Disagreement {
                    set: set.name().to_owned(),
                    structures: [first.name, other.name].map(str::to_owned),
                    hits: [first, other].map(|built| answer(&built.assembly, set).hits),
                });
            }
        }
        for Built { name, assembly, .. } in built.iter().filter(|_| !set.any_hit()) {
            if !packets_agree([assembly, assembly], set) {
                return Err(Disagreement {
                    set: set.name().to_owned(),
                    structures: [(*name).to_owned(), format!("{name} with packets")],
                    hits: [
                        answer(assembly, set).hits,
                        answer_packets(assembly, &packets(set)).hits,
                    ],
                });
            }
        }
    }
    Ok(())
}

/// Whether both answer each ray alike.
fn agree([a, b]: [&Assembly; 2], set: &RaySet) -> bool {
    set.rays().par_iter().all(|(ray, t_max)| {
        if set.any_hit() {
            a.occluded(ray, *t_max) == b.occluded(ray, *t_max)
        } else {
            a.intersect(ray, *t_max) == b.intersect(ray, *t_max)
        }
    })
}

/// Whether the second one, given packets, answers as the first one does each ray by itself.
fn packets_agree([alone, together]: [&Assembly; 2], set: &RaySet) -> bool {
    let packets = set.rays().par_chunks(Packet::MOST_RAYS);
    packets.all(|rays| {
        let hits = together.intersect_packet(&Packet::new(rays));
        let mut pairs = rays.iter().zip(hits);
        pairs.all(|((ray, t_max), hit)| alone.intersect(ray, *t_max) == hit)
    })
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::Part;
    use crate::geometry::Triangle;
    use crate::math::{DBounds, DVec3, SceneFrame, Vec3};

    const COUNT: u8 = 20;

    fn frame() -> SceneFrame {
        SceneFrame::around(&DBounds {
            min: DVec3::ZERO,
            max: DVec3::splat(COUNT.into()),
        })
    }

    /// Triangles along X, each across the ray of the same number.
    fn triangles() -> Vec<Triangle> {
        let corners = [(-0.4, -0.4), (0.4, -0.4), (0.0, 0.4)];
        let triangle = |number: u8| Triangle {
            corners: corners
                .map(|(x, y)| frame().narrow(DVec3::new(f64::from(number) + x, y, 0.0))),
        };
        (0..COUNT).map(triangle).collect()
    }

    fn rays(any_hit: bool) -> RaySet {
        let row = |number: u8| [f32::from(number), 0.0, 1.0, 0.0, 0.0, -1.0, f32::INFINITY];
        let rows = (0..COUNT).map(row).collect();
        RaySet::new("down", any_hit, rows, &frame()).expect("are rays")
    }

    fn built(name: &'static str, triangles: Vec<Triangle>) -> Built {
        let count = u32::try_from(triangles.len()).expect("are few");
        let structure = Structure::Wide.build(triangles).expect("nobody cancels");
        let seconds = Spread::of(vec![1.0]).expect("has a value");
        Built {
            name,
            assembly: Assembly::new(structure, Vec::new(), vec![Part::Flat(count)]),
            seconds,
            seconds_one_thread: seconds,
        }
    }

    fn without(number: usize) -> Vec<Triangle> {
        let mut triangles = triangles();
        triangles[number].corners = [Vec3::ZERO; 3];
        triangles
    }

    #[test]
    fn structures_are_compared_ray_by_ray() {
        let mut swapped = triangles();
        swapped.swap(3, 17);
        let whole = || built("whole", triangles());
        for (any_hit, pair, hits) in [
            (
                false,
                [whole(), built("swapped", swapped.clone())],
                Some([20, 20]),
            ),
            (true, [whole(), built("swapped", swapped)], None),
            (false, [whole(), built("less", without(5))], Some([20, 19])),
            (true, [whole(), built("less", without(5))], Some([20, 19])),
            (
                true,
                [built("one", without(5)), built("other", without(6))],
                Some([19, 19]),
            ),
            (false, [whole(), whole()], None),
        ] {
            let found = compare(&pair, &[rays(any_hit)]);
            let expected = hits.map(|hits| Disagreement {
                set: "down".to_owned(),
                structures: pair.map(|built| built.name.to_owned()),
                hits,
            });
            assert_eq!(found.err(), expected);
        }
    }

    #[test]
    fn packets_are_compared_ray_by_ray() {
        let set = rays(false);
        let mut swapped = triangles();
        swapped.swap(3, 17);
        let whole = built("whole", triangles()).assembly;
        let swapped = built("swapped", swapped).assembly;
        assert!(packets_agree([&whole, &whole], &set));
        assert!(!packets_agree([&whole, &swapped], &set));
    }
}

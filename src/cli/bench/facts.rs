//! What `raymini bench --json` prints.

use serde::{Serialize, Serializer};

use crate::analysis::bench::{MeasureConfig, RaySet, SetReport, Spread, StructureReport};

/// Everything measured.
#[derive(Debug, Serialize)]
pub struct BenchFacts {
    pub version: &'static str,
    pub scene: String,
    /// Of the whole scene, copies counted.
    pub triangles: u32,
    pub threads: usize,
    pub repeats: u32,
    pub rays: Vec<RayFacts>,
    pub structures: Vec<StructureFacts>,
}

/// One set of rays.
#[derive(Debug, Serialize)]
pub struct RayFacts {
    pub name: String,
    pub any_hit: bool,
    pub rays: usize,
    pub hits: u64,
}

/// One structure. Times and rates are medians; what is called a range holds the least and the largest.
#[derive(Debug, Serialize)]
pub struct StructureFacts {
    pub name: &'static str,
    pub build_seconds: f64,
    pub build_seconds_range: Range,
    pub build_seconds_one_thread: f64,
    pub build_seconds_one_thread_range: Range,
    pub bytes: usize,
    /// What memory and references are shared by: each triangle of a mesh with copies once.
    pub triangles_stored: u64,
    pub bytes_per_triangle: f64,
    pub references_per_triangle: f64,
    pub nodes: u64,
    pub leaves: u64,
    pub empty_leaves: u64,
    pub blocks: u64,
    pub depth: u32,
    pub sah_cost: f64,
    pub nodes_per_ray: BySet<f64>,
    pub blocks_per_ray: BySet<f64>,
    /// One thread.
    pub mrays_per_second: BySet<Option<f64>>,
    pub mrays_per_second_range: BySet<Option<Range>>,
    pub mrays_per_second_all_threads: BySet<Option<f64>>,
    pub mrays_per_second_all_threads_range: BySet<Option<Range>>,
    /// One thread, sixteen rays at a time; null where any hit counts.
    pub mrays_per_second_packets: BySet<Option<f64>>,
    pub mrays_per_second_packets_range: BySet<Option<Range>>,
}

/// The ends of repeated measurements.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Range {
    pub min: f64,
    pub max: f64,
}

impl From<Spread> for Range {
    fn from(Spread { min, max, .. }: Spread) -> Self {
        Self { min, max }
    }
}

/// A value per set of rays, an object with their names as keys, in their order.
#[derive(Debug)]
pub struct BySet<T>(pub Vec<(String, T)>);

impl<T: Serialize> Serialize for BySet<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}

impl BenchFacts {
    pub fn new(
        scene: String,
        triangles: u32,
        config: MeasureConfig,
        sets: &[RaySet],
        reports: &[StructureReport],
    ) -> Self {
        let hits = |index: usize| reports.first().map_or(0, |report| report.sets[index].hits);
        let ray_facts = |(index, set): (usize, &RaySet)| RayFacts {
            name: set.name().to_owned(),
            any_hit: set.any_hit(),
            rays: set.rays().len(),
            hits: hits(index),
        };
        Self {
            version: env!("CARGO_PKG_VERSION"),
            scene,
            triangles,
            threads: config.threads,
            repeats: config.repeats,
            rays: sets.iter().enumerate().map(ray_facts).collect(),
            structures: reports
                .iter()
                .map(|report| StructureFacts::new(report, sets))
                .collect(),
        }
    }
}

impl StructureFacts {
    fn new(report: &StructureReport, sets: &[RaySet]) -> Self {
        let quality = &report.quality;
        let stored = quality.triangles as f64;
        Self {
            name: report.name,
            build_seconds: report.build_seconds.median,
            build_seconds_range: report.build_seconds.into(),
            build_seconds_one_thread: report.build_seconds_one_thread.median,
            build_seconds_one_thread_range: report.build_seconds_one_thread.into(),
            bytes: report.bytes,
            triangles_stored: quality.triangles,
            bytes_per_triangle: report.bytes as f64 / stored,
            references_per_triangle: quality.references as f64 / stored,
            nodes: quality.nodes,
            leaves: quality.leaves,
            empty_leaves: quality.empty_leaves,
            blocks: quality.blocks,
            depth: quality.depth,
            sah_cost: quality.sah_cost,
            nodes_per_ray: by_set(report, sets, |set| set.visits.nodes),
            blocks_per_ray: by_set(report, sets, |set| set.visits.blocks),
            mrays_per_second: by_set(report, sets, |set| {
                set.mrays_per_second.map(|spread| spread.median)
            }),
            mrays_per_second_range: by_set(report, sets, |set| {
                set.mrays_per_second.map(Range::from)
            }),
            mrays_per_second_all_threads: by_set(report, sets, |set| {
                set.mrays_per_second_all_threads.map(|spread| spread.median)
            }),
            mrays_per_second_all_threads_range: by_set(report, sets, |set| {
                set.mrays_per_second_all_threads.map(Range::from)
            }),
            mrays_per_second_packets: by_set(report, sets, |set| {
                set.mrays_per_second_packets.map(|spread| spread.median)
            }),
            mrays_per_second_packets_range: by_set(report, sets, |set| {
                set.mrays_per_second_packets.map(Range::from)
            }),
        }
    }
}

fn by_set<T>(
    report: &StructureReport,
    sets: &[RaySet],
    value: impl Fn(&SetReport) -> T,
) -> BySet<T> {
    let named = |(set, report): (&RaySet, &SetReport)| (set.name().to_owned(), value(report));
    BySet(sets.iter().zip(&report.sets).map(named).collect())
}

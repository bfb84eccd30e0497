//! What `raymini bench` prints for people.

use super::facts::{BenchFacts, BySet, Range, StructureFacts};

/// All numbers as small tables with a column per structure or set of rays.
pub fn describe(facts: &BenchFacts) -> String {
    let BenchFacts {
        version,
        scene,
        triangles,
        threads,
        repeats,
        ..
    } = facts;
    let repeats_of = if *repeats == 1 { "repeat" } else { "repeats" };
    let mut sections = vec![
        format!(
            "RayMini {version}, {scene}: {triangles} triangles, {} stored\n\
             {repeats} {repeats_of}: medians, and in brackets from the least to the largest",
            facts.structures[0].triangles_stored
        ),
        structures(facts),
        parts(facts),
        rays(facts),
    ];
    sections.push(rates("Mrays/s, one thread", facts, |structure| {
        (
            &structure.mrays_per_second,
            &structure.mrays_per_second_range,
        )
    }));
    sections.push(rates(
        "Mrays/s, one thread, packets of 16",
        facts,
        |structure| {
            (
                &structure.mrays_per_second_packets,
                &structure.mrays_per_second_packets_range,
            )
        },
    ));
    sections.push(rates(
        &format!("Mrays/s, {}", threads_of(*threads)),
        facts,
        |structure| {
            (
                &structure.mrays_per_second_all_threads,
                &structure.mrays_per_second_all_threads_range,
            )
        },
    ));
    sections.join("\n\n")
}

fn threads_of(count: usize) -> String {
    format!("{count} thread{}", if count == 1 { "" } else { "s" })
}

fn structures(facts: &BenchFacts) -> String {
    let build = format!("build, {}", threads_of(facts.threads));
    let heads = [
        "structure",
        "build, 1 thread",
        &build,
        "bytes/tri",
        "refs/tri",
        "SAH cost",
    ];
    let row = |structure: &StructureFacts| {
        let seconds = |median: f64, range| format!("{median:.4} s {}", ends(range, 4));
        vec![
            structure.name.to_owned(),
            seconds(
                structure.build_seconds_one_thread,
                structure.build_seconds_one_thread_range,
            ),
            seconds(structure.build_seconds, structure.build_seconds_range),
            format!("{:.1}", structure.bytes_per_triangle),
            format!("{:.3}", structure.references_per_triangle),
            format!("{:.2}", structure.sah_cost),
        ]
    };
    let heads = heads.map(str::to_owned).to_vec();
    aligned(std::iter::once(heads).chain(facts.structures.iter().map(row)))
}

/// What the structures are made of.
fn parts(facts: &BenchFacts) -> String {
    let heads = ["structure", "nodes", "leaves", "empty", "blocks", "depth"];
    let row = |structure: &StructureFacts| {
        let counts = [
            structure.nodes,
            structure.leaves,
            structure.empty_leaves,
            structure.blocks,
            structure.depth.into(),
        ];
        let mut row = vec![structure.name.to_owned()];
        row.extend(counts.iter().map(ToString::to_string));
        row
    };
    let heads = heads.map(str::to_owned).to_vec();
    aligned(std::iter::once(heads).chain(facts.structures.iter().map(row)))
}

fn rays(facts: &BenchFacts) -> String {
    let per_ray = |name: &str| format!("{name} nodes + blocks");
    let heads = ["rays", "count", "hits"].map(str::to_owned).into_iter();
    let heads = heads.chain(facts.structures.iter().map(|s| per_ray(s.name)));
    let rows = facts.rays.iter().enumerate().map(|(index, rays)| {
        let mut row = vec![
            rays.name.clone(),
            rays.rays.to_string(),
            rays.hits.to_string(),
        ];
        row.extend(facts.structures.iter().map(|structure| {
            let (nodes, blocks) = (&structure.nodes_per_ray, &structure.blocks_per_ray);
            format!("{:.1} + {:.1}", nodes.0[index].1, blocks.0[index].1)
        }));
        row
    });
    aligned(std::iter::once(heads.collect()).chain(rows))
}

fn rates<'a>(
    title: &str,
    facts: &'a BenchFacts,
    of: impl Fn(&'a StructureFacts) -> (&'a BySet<Option<f64>>, &'a BySet<Option<Range>>),
) -> String {
    let names = facts.structures.iter().map(|s| s.name.to_owned());
    let heads = std::iter::once(title.to_owned()).chain(names).collect();
    let rows = facts.rays.iter().enumerate().map(|(index, rays)| {
        let mut row = vec![rays.name.clone()];
        row.extend(facts.structures.iter().map(|structure| {
            let (medians, ranges) = of(structure);
            match (medians.0[index].1, ranges.0[index].1) {
                (Some(median), Some(range)) => format!("{median:.2} {}", ends(range, 2)),
                _ => "–".to_owned(),
            }
        }));
        row
    });
    aligned(std::iter::once(heads).chain(rows))
}

fn ends(Range { min, max }: Range, digits: usize) -> String {
    format!("({min:.digits$}–{max:.digits$})")
}

/// Rows as lines, columns at least two spaces apart: the first aligned to the left, the others to the right.
fn aligned(rows: impl Iterator<Item = Vec<String>>) -> String {
    let rows: Vec<_> = rows.collect();
    let widest = |column: usize| {
        let widths = rows.iter().map(|row| row[column].chars().count());
        widths.max().unwrap_or(0)
    };
    let widths: Vec<_> = (0..rows[0].len()).map(widest).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).enumerate();
        let cells = cells.map(|(column, (cell, width))| {
            if column == 0 {
                format!("{cell:<width$}")
            } else {
                format!("  {cell:>width$}")
            }
        });
        cells.collect::<String>()
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_stand_below_each_other() {
        let rows = [["structure", "s"], ["wide", "0.25 (0.2–0.3)"]];
        let text = aligned(rows.iter().map(|row| row.map(str::to_owned).to_vec()));
        assert_eq!(text, "structure               s\nwide       0.25 (0.2–0.3)");
    }
}

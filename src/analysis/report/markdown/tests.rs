use super::*;
use crate::analysis::report::test_data;
use crate::render::Ending;

#[test]
fn the_page_has_the_numbers_in_tables() {
    let page = to_markdown(&test_data::study());
    for line in [
        "![Noise against render time](report.svg)",
        "With 8 samples per pixel and after 8.00 s of rendering the picture has **5.00 % noise** (median of 3 seeds); \
         the renders themselves say 5.00 %, without a reference. Noise falls as render time to the power of −1.00.",
        "2 × 1 pixels, 12 triangles. Measured on A CPU, 2 threads, linux x86\\_64, begun 2026-11-28 01:05 UTC.",
        "| as the scene says | 0.500 s | −1.00 (−1.00 – −1.00) | −1.00 (−1.00 – −1.00) | −1.00 | — | — | — | 50.0 | 25.0 | 4.00 s | \
         13.3 s (predicted) | 40.0 s (predicted) |",
        "### `render.a=1, \"b\"`",
        "| 1 | 1.00 s (1.00 s – 1.00 s) | 2.00 s | 40.0 % (32.0 % – 48.0 %) | — | — | 0.200 | — | 0.625 | — |",
        "| as the scene says | 6 | 0 | 0 | 0 % | 0 |",
        "stop.noise = 0.03",
    ] {
        assert!(page.lines().any(|l| l == line), "{line}: {page}");
    }
    for row in page.lines().filter(|line| line.starts_with('|')) {
        assert!(row.ends_with('|'), "{row}");
    }
    assert!(
        !page.contains("NaN") && !page.contains("done yet"),
        "{page}"
    );
}

#[test]
fn the_page_has_the_time_to_the_noise_that_was_asked_for() {
    let mut study = test_data::study();
    assert!(!to_markdown(&study).contains("stops at noise"));
    study.variants[0].scene.render.stop.noise = Some(0.03);
    study.variants[0].trials[1].stats.ending = Ending::Noise;
    study.variants[0].trials[1].stats.render_seconds = 2.0;
    study.variants[0].trials[1].stats.samples_per_pixel = 24.0;
    study.variants[0].trials[2].stats.ending = Ending::Time;
    let page = to_markdown(&study);
    let row = "| as the scene says | 3.00 % | 1 of 3; 1 ran out of samples; 1 ran out of time | 24 \
               | 2.00 s (2.00 s – 2.00 s) | 0 s (0 s – 0 s) |";
    assert!(page.lines().any(|line| line == row), "{page}");
}

#[test]
fn the_page_warns_of_a_noisy_reference_and_of_renders_to_come() {
    let mut study = test_data::study();
    study.variants[1].trials.pop();
    study.reference = test_data::rendered_reference(0.01, 0.001);
    let page = to_markdown(&study);
    assert!(page.contains("**Not all renders are done yet.**"), "{page}");
    assert!(page.contains("**Up to 40.0 % of the measured"), "{page}");
    study.reference = test_data::rendered_reference(0.01, 0.0001);
    let page = to_markdown(&study);
    assert!(
        !page.contains("**Up to") && !page.contains("half of"),
        "{page}"
    );
    study.reference = test_data::file_reference(Some(0.0025));
    let page = to_markdown(&study);
    let expected =
        "\n- as the scene says: from 8 samples per pixel on, more than half of the mean square";
    assert!(page.contains(expected), "{page}");
    assert!(
        page.contains("before.exr; its own error, estimated: 5.00 % noise, RMSE 0.0250."),
        "{page}"
    );
}

/// What a reader must know first stands before the tables, and names what it is about.
#[test]
fn the_page_begins_with_what_spoils_it() {
    let mut study = test_data::study();
    study.scene_name = "my_room_.toml".to_owned();
    study.warnings = vec!["other.png: 3 pixels are <odd>".to_owned()];
    study.command = Some("raymini report my_room_.toml -o out".to_owned());
    study.picture = Some(study.reference.image.clone());
    study.variants[1].shows_another_picture = true;
    study.variants[1].name = "render.shadows=off".to_owned();
    for trial in &mut study.variants[0].trials {
        let mut wrong = test_data::measurement(16.0, 16.0, 1e-4, 1e-4);
        wrong.measured.relmse = 0.01;
        trial.measurements.push(wrong);
        trial.stats.threads = 4;
    }
    let page = to_markdown(&study);
    assert!(
        page.starts_with("# Error against run time: my\\_room\\_.toml\n"),
        "{page}"
    );
    let (before, after) = page.split_once("## Summary").expect("is there");
    for part in [
        "- other.png: 3 pixels are \\<odd\\>.",
        "- as the scene says: 3 of 6 intervals held the truth, which is too few for 95 %",
        "- The renders had 50 % of the processor time",
        "```sh\nraymini report my_room_.toml -o out\n```",
        "](report.png)",
    ] {
        assert!(before.contains(part), "{part}: {page}");
    }
    assert!(
        after.contains("has the difference in its true error: `render.shadows=off`."),
        "{page}"
    );
    let row = page
        .lines()
        .find(|line| line.starts_with("| `render.shadows=off` |"));
    assert!(
        row.is_some_and(|row| row.ends_with("| not by sampling | not by sampling |")),
        "{page}"
    );
    let order = [
        "## Summary",
        "## How to read it",
        "## Reference",
        "## Points",
    ];
    let places = order.map(|heading| page.find(heading));
    assert!(places.is_sorted() && places[0].is_some(), "{places:?}");
}

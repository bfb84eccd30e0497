//! The extreme cases of `raymini check`, each held to its bar, except those that measure time; and the command around them.

use std::process::Command;

use raymini::analysis::matrix::{Effort, cases};
use serde_json::Value;

/// Parts of the cases, so that they run beside each other.
const PARTS: usize = 6;

#[track_caller]
fn assert_part_passes(part: usize) {
    let untimed = cases().filter(|case| !case.is_timed);
    for (_, case) in untimed.enumerate().filter(|(n, _)| n % PARTS == part) {
        let finding = case.run(Effort::Quick);
        assert!(finding.passed, "{}: {}: {finding:?}", case.name, case.tried);
    }
}

#[test]
fn cases_of_part_1_pass() {
    assert_part_passes(0);
}

#[test]
fn cases_of_part_2_pass() {
    assert_part_passes(1);
}

#[test]
fn cases_of_part_3_pass() {
    assert_part_passes(2);
}

#[test]
fn cases_of_part_4_pass() {
    assert_part_passes(3);
}

#[test]
fn cases_of_part_5_pass() {
    assert_part_passes(4);
}

#[test]
fn cases_of_part_6_pass() {
    assert_part_passes(PARTS - 1);
}

#[test]
fn the_command_says_what_was_tried_and_what_came_out() {
    let check = |arguments: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_raymini"))
            .arg("check")
            .args(arguments)
            .output()
            .expect("starts")
    };
    let output = check(&["--only", "empty scene", "--json"]);
    assert!(output.status.success());
    let facts: Value = serde_json::from_slice(&output.stdout).expect("is JSON");
    let case = &facts["cases"][0];
    assert_eq!(case["name"], "empty scene");
    assert_eq!(
        (&case["measured"], &case["bar"]),
        (&0.0.into(), &0.0.into())
    );
    assert_eq!(case["passed"], true);
    assert!(case["seconds"].as_f64().expect("a number") > 0.0);

    let output = check(&["--only", "aperture 0"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        text.starts_with("pass") && text.contains("aperture 0"),
        "{text}"
    );
    assert!(text.contains("1 of 1 cases pass"), "{text}");

    let output = check(&["--only", "no such case"]);
    assert_eq!(output.status.code(), Some(1));
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(text.contains("no such case"), "{text}");
}

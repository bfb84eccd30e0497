//! Reports of error against time: their window, what they share with the command, and what happens beside them.

use std::path::Path;
use std::process::{Command, Stdio};

use crate::driver::{Files, Window, library_hash, set_number, set_samples};
use egui::{Key, Modifiers, accesskit::Role};
use egui_kittest::kittest::Queryable;
use raymini::gui::picture::Outcome;
use raymini::gui::report::Outcome as ReportOutcome;
use serde_json::Value;

/// Opens the window of the report by its menu entry, and has it written to `folder`.
fn ask_for_report(window: &mut Window, folder: &Path) {
    window.click("Render menu");
    window.harness.get_by_label_contains("Report…").click();
    window.harness.run_steps(3);
    assert!(window.app().report().open);
    window.enter("Folder", folder.to_str().unwrap());
}

fn wait_for_report(window: &mut Window) {
    window.until("the report is done", |app| !app.report().is_running());
}

fn json_of(folder: &Path) -> Value {
    let text = std::fs::read_to_string(folder.join("report.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// Keys without values: what a reader of a file can rely on. Whether a time is foreseen is up to the clock.
fn keys_of(value: &Value) -> Value {
    match value {
        Value::Object(fields) => {
            let keys = fields.iter().map(|(key, value)| {
                let keys = match key.as_str() {
                    "time_to" => Value::Null,
                    _ => keys_of(value),
                };
                (key.clone(), keys)
            });
            keys.collect()
        }
        Value::Array(items) => items.iter().map(keys_of).collect(),
        _ => Value::Null,
    }
}

/// The report of what the window shows, not of what is on disk, is the one the command makes once the scene is saved.
#[test]
fn a_report_is_the_commands_of_the_scene_as_it_is() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Select Light 1");
    window.click("Kind: Disk");
    assert!(window.app().document().is_modified());
    let folder = files.path("new/report");
    ask_for_report(&mut window, &folder);
    assert!(window.says("changes that are not saved included"));
    set_number(&mut window, "Seeds", "2");
    set_number(&mut window, "Picture width", "32");
    set_number(&mut window, "Picture height", "24");
    window.click("Compare with");
    window
        .harness
        .get_by_label_contains("4 shadow rays")
        .click();
    window.harness.run_steps(3);
    assert!(window.says("4 renders, after one of 256 samples"));
    window.click("Start");
    assert!(window.app().report().is_running());
    wait_for_report(&mut window);

    let run = window.app().report().run().expect("its result shows");
    assert_eq!(run.outcome, ReportOutcome::Finished);
    assert_eq!(run.folder, folder);
    let findings = run.findings().expect("there are some");
    assert_eq!(findings.variants.len(), 2);
    assert_eq!(findings.variants[0].1.points.len(), 5);
    assert!(findings.chart.curves.iter().all(|c| !c.points.is_empty()));
    assert!(window.says("noise after"));
    assert!(window.says("render.shadow_samples=4"));
    assert!(window.says(folder.to_str().unwrap()));
    // The scene keeps its size, and its changes are still not saved.
    assert_eq!(window.scene().render.width, 160);
    assert!(window.app().document().is_modified());

    let toml = files.path("saved.toml");
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    window.enter_path(&toml);
    window.until("the scene is saved", |app| !app.document().is_modified());
    let by_command = files.path("by-command");
    let status = Command::new(env!("CARGO_BIN_EXE_raymini"))
        .arg("report")
        .arg(&toml)
        .args(["--seeds", "2", "--size", "32x24", "--compare"])
        .args(["render.shadow_samples=4", "-o"])
        .arg(&by_command)
        .stdout(Stdio::null())
        .status();
    assert!(status.unwrap().success());
    let (ours, commands) = (json_of(&folder), json_of(&by_command));
    assert_eq!(keys_of(&ours), keys_of(&commands));
    assert_eq!(ours["finished"], true);
    assert_eq!(ours["settings"], commands["settings"]);
    assert_eq!(ours["reference"]["rmse"], commands["reference"]["rmse"]);
    for points in ["/points", "/variants/0/points"] {
        for (point, expected) in std::iter::zip(
            ours.pointer(points).unwrap().as_array().unwrap(),
            commands.pointer(points).unwrap().as_array().unwrap(),
        ) {
            for key in ["samples_per_pixel", "true_relmse", "estimated_relmse"] {
                assert_eq!(point[key], expected[key], "{key} in {points}");
            }
        }
    }
    let lines = |folder: &Path, name: &str| -> Vec<String> {
        let text = std::fs::read_to_string(folder.join(name)).unwrap();
        text.lines().map(str::to_owned).collect()
    };
    for name in ["report.svg", "report.csv"] {
        let [ours, commands] = [&folder, &by_command].map(|folder| lines(folder, name));
        assert_eq!(ours[0], commands[0], "{name}");
    }
    // Its title is what the scene was called, which was not saved under that name.
    let headings = |folder| {
        let lines = lines(folder, "report.md").into_iter();
        let headings = lines.filter(|line| line.starts_with('#')).skip(1);
        headings.collect::<Vec<_>>()
    };
    assert_eq!(headings(&folder), headings(&by_command));
    assert!(headings(&folder).contains(&"## Summary".to_owned()));

    // The next report starts from the same wishes.
    window.click("New report");
    assert!(window.says("4 renders, after one of 256 samples"));
}

/// A report stops a render, refuses others, lets the scene be edited, and stops at once when told to.
#[test]
fn a_report_has_the_processor_to_itself_until_it_is_cancelled() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    set_samples(&mut window, 100_000);
    window.click("Render");
    window.until("tiles arrive", |app| {
        app.picture().is_some_and(|p| p.first_tile.is_some())
    });
    let folder = files.path("report");
    ask_for_report(&mut window, &folder);
    assert!(window.says("The render that is going on is stopped first"));
    window.click("Start");
    assert_eq!(window.app().picture().unwrap().outcome, Outcome::Cancelled);
    window.until("the reference is rendered", |app| {
        let run = app.report().run();
        run.is_some_and(|run| run.progress.how_far().0 > 0.0)
    });

    window.click("Hide");
    assert!(!window.app().report().open);
    assert!(window.says("Report: reference"));
    window.press(Modifiers::NONE, Key::F5);
    assert_eq!(window.app().picture().unwrap().outcome, Outcome::Cancelled);
    window.click("Add light");
    assert_eq!(window.scene().lights.len(), 2);
    assert!(window.app().report().is_running());

    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::R);
    window.click("Cancel report");
    assert!(!window.app().report().is_running());
    window.until("threads have stopped", |app| app.render_threads() == 0);
    assert!(!folder.join("report.json").exists());
    assert_eq!(window.app().messages().last_news(), "Report cancelled");
    // What was typed is still there, and rendering is possible again.
    let field = window
        .harness
        .get_by_role_and_label(Role::TextInput, "Folder");
    assert_eq!(field.value().as_deref(), folder.to_str());
    window.press(Modifiers::NONE, Key::Escape);
    assert!(!window.app().report().open);
    set_samples(&mut window, 2);
    window.render();
    assert_eq!(window.hash(), library_hash(window.scene()));
}

/// Reports that are stopped in the middle keep what was measured, on the screen and on disk.
#[test]
fn a_cancelled_report_keeps_what_it_has_measured() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let folder = files.path("report");
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::R);
    window.click("Choose the folder");
    window.enter_path(&folder);
    set_number(&mut window, "Seeds", "1000");
    window.click("Start");
    window.until("a render is measured", |app| {
        app.report()
            .run()
            .is_some_and(|run| run.findings().is_some())
    });
    window.press(Modifiers::NONE, Key::Escape);
    let run = window.app().report().run().expect("what is known shows");
    assert_eq!(run.outcome, ReportOutcome::Cancelled);
    assert!(window.says("this is what was measured until then"));
    window.until("threads have stopped", |app| app.render_threads() == 0);
    let facts = json_of(&folder);
    assert_eq!(facts["finished"], false);
    assert_eq!(facts["points"].as_array().unwrap().len(), 5);
}

#[test]
fn mistakes_in_a_report_are_told_where_they_are_made() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let folder = files.path("report");
    ask_for_report(&mut window, &files.path("pyramid.off/report"));
    set_number(&mut window, "Seeds", "1");
    window.click("Start");
    wait_for_report(&mut window);
    assert!(window.says("the folder cannot be made"));

    window.enter("Folder", folder.to_str().unwrap());
    window.click("Compare with");
    window.click("Other settings");
    for (wrong, expected) in [
        ("", "expected KEY=VALUE"),
        ("render.filtre=tent", "filtre"),
        ("render.filter=tentt", "tentt"),
        ("render.width=25", "all pictures must be of one size"),
    ] {
        window.enter("Comparison 1", wrong);
        window.click("Start");
        wait_for_report(&mut window);
        assert!(window.says(expected), "{expected}");
        assert!(!window.says("--"), "options are the command's");
    }
    window.click("Remove comparison 1");
    assert!(!window.says("all pictures must be of one size"));

    window.click("Reference: Exact");
    window.enter("Its radiance", "1,1");
    window.click("Start");
    assert!(!window.app().report().is_running());
    assert!(window.says("expected red, green, blue"));
    window.click("Reference: File");
    window.click("Choose the reference");
    window.enter_path(&files.path("none.exr"));
    window.click("Start");
    wait_for_report(&mut window);
    assert!(window.says("none.exr: "));
    assert!(!folder.exists(), "nothing is made before all is right");

    // Nothing of it has changed the scene, and all put right it goes through.
    assert!(!window.app().document().is_modified());
    window.click("Reference: Exact");
    window.enter("Its radiance", "1, 1, 1");
    window.click("Start");
    wait_for_report(&mut window);
    assert_eq!(json_of(&folder)["reference"]["kind"], "exact");
}

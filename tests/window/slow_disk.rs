//! A disk that does not answer, while renders are kept there: a pipe waits until somebody reads from it.
#![cfg(unix)]

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use crate::driver::{DEADLINE, Files, Window, library_hash, set_samples};
use crate::keeping::open;
use raymini::gui::App;

/// Where the next render of the only window that keeps its work in `data` goes, with what is written there first already there: a pipe.
fn hang(data: &Path, number: usize) -> PathBuf {
    let sessions = fs::read_dir(data.join("sessions")).unwrap();
    let [session] = &sessions.map(Result::unwrap).collect::<Vec<_>>()[..] else {
        panic!("there is one window");
    };
    let folder = session.path().join(format!("render-{number}"));
    fs::create_dir(&folder).unwrap();
    let pipe = folder.join("about.json");
    let made = Command::new("mkfifo").arg(&pipe).status().unwrap();
    assert!(made.success());
    folder
}

fn is_hanging(folder: &Path) -> bool {
    fs::read_dir(folder).is_ok_and(|entries| entries.count() == 1)
}

/// Lets the disk go on, and waits until the render in `folder` is removed.
fn release(window: &mut Window, folder: &Path) {
    // Open both ways, it waits for nobody.
    let mut ends = File::options();
    let ends = ends.read(true).write(true);
    let reader = ends.open(folder.join("about.json")).unwrap();
    let deadline = Instant::now() + DEADLINE;
    while folder.exists() {
        assert!(Instant::now() < deadline, "it stays");
        window.harness.step();
        std::thread::sleep(Duration::from_millis(2));
    }
    drop(reader);
}

#[test]
fn neither_cancel_nor_the_end_of_a_render_waits_for_a_disk() {
    let files = Files::new();
    let data = files.path("data");
    let mut window = open(&files.path("room.toml"), &data);
    window.until("work is kept", App::is_keeping);

    set_samples(&mut window, 100_000);
    let folder = hang(&data, 0);
    window.click("Render");
    window.until("passes are done", |app| {
        let picture = app.picture().expect("was asked for");
        picture.progress.samples.done() > 10 * picture.scene.render.pixel_count()
    });
    window.click("Cancel");
    window.until("threads have stopped", |app| app.render_threads() == 0);
    assert!(is_hanging(&folder));
    release(&mut window, &folder);

    set_samples(&mut window, 40);
    let folder = hang(&data, 1);
    window.render();
    assert!(is_hanging(&folder));
    assert_eq!(window.hash(), library_hash(window.scene()));
    window.until("threads have stopped", |app| app.render_threads() == 0);
    release(&mut window, &folder);
}

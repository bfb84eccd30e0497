//! Every file that fuzzing found worth keeping, read once more: nothing panics, hangs or takes memory beyond what is stated in
//! `tests/hostile`. How the files came about is told in `fuzz/README.md`.

mod hostile;

use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Most time that one of these small files may take, far more than any does: longer is taken for a hang.
const LONGEST: Duration = Duration::from_secs(20);

/// Memory is counted for the whole program, so one test runs at a time.
static ALONE: Mutex<()> = Mutex::new(());

/// Runs `check` over the corpus of `target`.
fn replay(target: &str, check: fn(&[u8])) {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("fuzz/corpus")
        .join(target);
    let entries = std::fs::read_dir(&folder).expect("the corpus is part of the repository");
    let mut paths: Vec<_> = entries
        .map(|entry| entry.expect("an entry").path())
        .collect();
    paths.sort();
    assert!(!paths.is_empty(), "{} is empty", folder.display());
    for path in paths {
        let bytes = std::fs::read(&path).expect("can be read");
        // Shown where the check fails.
        println!("{}: {} bytes", path.display(), bytes.len());
        let start = Instant::now();
        check(&bytes);
        assert!(start.elapsed() < LONGEST, "took {:?}", start.elapsed());
    }
}

#[test]
fn meshes_from_the_corpus_are_read_or_refused() {
    replay("off", hostile::mesh::check_off);
    replay("obj", hostile::mesh::check_obj);
    replay("ply", hostile::mesh::check_ply);
    replay("stl", hostile::mesh::check_stl);
    replay("medit", hostile::mesh::check_medit);
    replay("gmsh", hostile::mesh::check_gmsh);
    replay("mtl", hostile::mtl::check);
    replay("gltf", hostile::gltf::check);
}

#[test]
fn scenes_from_the_corpus_are_read_or_refused() {
    replay("scene", hostile::scene::check);
}

#[test]
fn pictures_from_the_corpus_are_read_or_refused() {
    replay("picture", hostile::picture::check);
}

/// Textures are read from pictures too, and from JPEG.
#[test]
fn textures_from_the_corpus_are_read_or_refused() {
    replay("texture", hostile::texture::check);
    replay("picture", hostile::texture::check);
}

#[test]
fn skies_from_the_corpus_are_read_or_refused() {
    replay("radiance", hostile::radiance::check);
}

#[test]
fn rays_from_the_corpus_are_read_or_refused() {
    replay("rays", hostile::rays::check);
}

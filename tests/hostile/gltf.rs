use raymini::control::{CancelToken, Progress};
use raymini::geometry::face_normal;
use raymini::io::gltf::{ImageFile, parse, write};

use super::{assert_memory, assert_message, measured};

/// Bytes of memory per byte of the file: a node, all of it 250 bytes, is begun in three of text; the reader doubles its lists, and what
/// is read of one byte four times are numbers of eight bytes, and vertices.
const MEMORY: usize = 512;
/// Larger scenes are not written again: the text of a number is longer than its bits.
const MOST_VERTICES: usize = 10_000;

/// Reads `bytes` as a GLB or the text of a glTF; other files that it names hold `bytes`, too. Its meshes keep their invariant, and the
/// scene is the same when written and read again.
pub fn check(bytes: &[u8]) {
    let mut loaded = 0;
    let mut load = |_: &str| {
        loaded += bytes.len();
        Ok(Some(bytes.to_vec()))
    };
    let progress = Progress::new();
    let (read, peak) = measured(|| parse(bytes, &mut load, &CancelToken::new(), &progress));
    assert_memory(peak, MEMORY, bytes.len() + loaded);
    let images = ImageFile::new(bytes.to_vec());
    let _ = images.and_then(|mut images| images.image(0, &mut |_| Ok(None)));
    let gltf = match read {
        Ok(gltf) => gltf.expect("nobody cancels"),
        Err(error) => return assert_message(&error.to_string()),
    };
    assert_eq!(progress.done(), bytes.len() as u64);
    for warning in &gltf.warnings {
        assert_message(warning);
    }
    for mesh in gltf.parts.values() {
        assert_eq!(mesh.validate(), Ok(()));
        for index in 0..mesh.triangles.len() {
            assert!(face_normal(mesh.corners(index)).is_some(), "{index}");
        }
    }
    let scene = gltf.scene(str::to_owned);
    for object in &scene.objects {
        assert!(scene.meshes.contains_key(&object.mesh));
        assert!(
            object
                .material
                .as_ref()
                .is_none_or(|name| scene.materials.contains_key(name))
        );
    }
    // Copies may be many times the file.
    let vertices = scene
        .objects
        .iter()
        .filter_map(|object| scene.meshes.get(&object.mesh));
    if vertices.map(|mesh| mesh.positions.len()).sum::<usize>() > MOST_VERTICES {
        return;
    }
    let _ = gltf.whole();
    let mut written = Vec::new();
    // Numbers beyond 32 bits are refused.
    if write(&scene, gltf.camera.as_ref(), &mut written).is_err() {
        return;
    }
    let again = parse(
        &written,
        &mut |_| Ok(None),
        &CancelToken::new(),
        &Progress::new(),
    );
    let again = again.unwrap_or_else(|error| panic!("what is written: {error}"));
    let again = again.expect("nobody cancels");
    assert!(again.objects.len() <= scene.objects.len());
}

use raymini::control::{CancelToken, Progress};
use raymini::io::{Remarks, mtl};
use raymini::scene::Material;

use super::{assert_memory, assert_message, measured};

/// Bytes of memory per byte of the file: a material, all of it 250 bytes, is begun in nine.
const MEMORY: usize = 160;

/// Reads `bytes` as MTL. Each material becomes one that reflects no more than arrives, and that is the same when written and read
/// again, but for what MTL does not hold.
pub fn check(bytes: &[u8]) {
    let progress = Progress::new();
    let (read, peak) = measured(|| mtl::parse(bytes, &CancelToken::new(), &progress));
    assert_memory(peak, MEMORY, bytes.len());
    let file = match read {
        Ok(file) => file.expect("nobody cancels"),
        Err(error) => return assert_message(&error.to_string()),
    };
    assert_eq!(progress.done(), bytes.len() as u64);
    for warning in &file.warnings {
        assert_message(warning);
    }
    let mut remarks = Remarks::of("material");
    for (name, written) in &file.materials {
        let material = written.to_material(name, &mut remarks);
        let reflected = match &material {
            Material::Phong {
                diffuse, specular, ..
            } => *diffuse + *specular,
            Material::Mirror { reflectance } => *reflectance,
            Material::Glass { .. } | Material::Emitter { .. } => continue,
        };
        assert!(reflected.max_element() <= 1.0 + 1e-9 && reflected.min_element() >= 0.0);
    }
    for sentence in remarks.sentences() {
        assert_message(&sentence);
    }
}

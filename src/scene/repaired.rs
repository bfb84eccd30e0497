//! Meshes with their winding repaired, each made once: what is prepared of a mesh is kept as long as it is the same one.

use std::sync::{Arc, Mutex, PoisonError, Weak};

use crate::geometry::{TriangleMesh, Winding};

/// A mesh, and what was made of it: itself where it is right.
type Known = (Weak<TriangleMesh>, Weak<TriangleMesh>);

/// Those that may still be in use. That they are found here changes no bit, only whether work is done again.
static KNOWN: Mutex<Vec<Known>> = Mutex::new(Vec::new());

/// `mesh` with its winding repaired; itself where there is nothing to repair.
pub fn repaired(mesh: &Arc<TriangleMesh>) -> Arc<TriangleMesh> {
    // Held while a mesh is repaired: who asks for the same one meanwhile shall have the same answer.
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    known.retain(|(from, to)| from.strong_count() > 0 && to.strong_count() > 0);
    let is_it = |(from, _): &&Known| std::ptr::eq(from.as_ptr(), Arc::as_ptr(mesh));
    if let Some(repaired) = known.iter().find(is_it).and_then(|(_, to)| to.upgrade()) {
        return repaired;
    }
    let winding = Winding::of(mesh);
    let repaired = if winding.is_right() {
        Arc::clone(mesh)
    } else {
        let mut repaired = TriangleMesh::clone(mesh);
        winding.repair(&mut repaired);
        Arc::new(repaired)
    };
    known.push((Arc::downgrade(mesh), Arc::downgrade(&repaired)));
    repaired
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::icosphere;

    #[test]
    fn a_mesh_is_repaired_once_as_long_as_it_is_in_use() {
        let ball = Arc::new(icosphere(1));
        assert!(Arc::ptr_eq(&repaired(&ball), &ball));
        let mut turned = icosphere(1);
        turned.triangles[3].swap(0, 1);
        let turned = Arc::new(turned);
        let first = repaired(&turned);
        assert_ne!(first.triangles[3], turned.triangles[3]);
        assert!(Arc::ptr_eq(&first, &repaired(&turned)));
        assert!(Winding::of(&first).is_right());
    }
}

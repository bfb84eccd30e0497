//! Sculpts the creatures of the demo scene and writes them as OFF meshes.
//!
//! ```text
//! cargo run --release --example sculpt -- assets
//! ```
//!
//! Each creature is an implicit surface: ellipsoids, tapered limbs and tubes, blended and carved
//! ([`field`]). It is meshed by marching tetrahedra on a fine lattice ([`mesher`]), thinned out
//! to a budget of triangles by quadric edge collapse ([`simplify`]), relaxed, put back onto the
//! exact surface and checked ([`mesh`]). The same program always writes the same bytes.
//!
//! Conventions: z points up, the ground is z = 0, the creature stands about the origin, looks
//! along -y and is about two units long; its left side is at positive x.

mod field;
mod gargoyle;
mod mesh;
mod mesher;
mod ram;
mod rhino;
mod simplify;

use glam::DVec3;
use mesh::Mesh;
use std::error::Error;
use std::ops::RangeInclusive;
use std::path::Path;

/// What a creature must tell to be meshed.
trait Sculpture: Sync {
    /// Corners of a box around the creature; the part below z = 0 is cut off to make flat soles.
    const BOX: [DVec3; 2];
    /// Triangles to thin out to.
    const TRIANGLES: usize;
    fn field(&self, p: DVec3) -> f64;
}

const LATTICE_STEP: f64 = 0.011;
const RELAXATIONS: usize = 6;
const ALLOWED_TRIANGLES: RangeInclusive<usize> = 10_000..=50_000;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).ok_or("usage: sculpt FOLDER")?;
    let folder = Path::new(&folder);
    let (ram, (rhino, gargoyle)) = rayon::join(
        || sculpt(&ram::Ram::new()),
        || {
            rayon::join(
                || sculpt(&rhino::Rhino::new()),
                || sculpt(&gargoyle::Gargoyle::new()),
            )
        },
    );
    write("ram", &ram, folder)?;
    write("rhino", &rhino, folder)?;
    write("gargoyle", &gargoyle, folder)
}

fn write(name: &str, mesh: &Mesh, folder: &Path) -> Result<(), Box<dyn Error>> {
    let triangles = mesh.faces.len();
    mesh.verify().map_err(|fault| format!("{name}: {fault}"))?;
    if !ALLOWED_TRIANGLES.contains(&triangles) {
        return Err(format!("{name}: {triangles} triangles").into());
    }
    std::fs::write(folder.join(name).with_extension("off"), mesh.to_off())?;
    let (low, high) = mesh.bounds();
    println!("{name}: {triangles} triangles, from {low:.3} to {high:.3}");
    Ok(())
}

fn sculpt<S: Sculpture>(creature: &S) -> Mesh {
    let solid = |p: DVec3| creature.field(p).max(-p.z);
    let mut mesh = mesher::march(&solid, S::BOX, LATTICE_STEP);
    mesh.keep_largest_piece();
    let mut mesh = simplify::simplify(mesh, S::TRIANGLES);
    mesher::relax(&solid, &mut mesh, RELAXATIONS);
    mesher::project(&solid, &mut mesh, LATTICE_STEP);
    mesh.round();
    mesh
}

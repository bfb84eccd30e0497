//! Writes the plain shapes of the gallery's scenes as OFF files: a torus, a ball and a block.
//!
//! `cargo run --release --example shapes -- assets`. Z is up; shapes stand on z = 0 about the origin.

use std::f64::consts::TAU;
use std::path::PathBuf;

use raymini::geometry::{TriangleMesh, shapes};
use raymini::io::{off, write_atomically};
use raymini::math::DVec3;

fn main() -> std::io::Result<()> {
    let folder = PathBuf::from(
        std::env::args()
            .nth(1)
            .unwrap_or_else(|| "assets".to_owned()),
    );
    let shapes = [
        ("torus", torus(1.0, 0.38, 144, 64)),
        ("ball", moved_up(shapes::icosphere(5), 1.0)),
        (
            "block",
            shapes::cuboid(DVec3::new(-0.5, -0.5, 0.0), DVec3::new(0.5, 0.5, 1.0)),
        ),
    ];
    for (name, mut mesh) in shapes {
        for position in &mut mesh.positions {
            *position = rounded(*position);
        }
        write_atomically(&folder.join(name).with_extension("off"), |file| {
            off::write(&mesh, file)
        })?;
        println!("{name}: {} triangles", mesh.triangles.len());
    }
    Ok(())
}

/// A lying torus: `ring` is the distance from the middle to the tube's centre line, `tube` the tube's radius.
fn torus(ring: f64, tube: f64, around: u32, across: u32) -> TriangleMesh {
    let vertex = |i: u32, j: u32| {
        let (sin_u, cos_u) = libm::sincos(TAU * f64::from(i) / f64::from(around));
        let (sin_v, cos_v) = libm::sincos(TAU * f64::from(j) / f64::from(across));
        let radius = ring + tube * cos_v;
        DVec3::new(radius * cos_u, radius * sin_u, tube + tube * sin_v)
    };
    let mut mesh = TriangleMesh::default();
    for i in 0..around {
        for j in 0..across {
            mesh.positions.push(vertex(i, j));
            let id = |i: u32, j: u32| (i % around) * across + j % across;
            let (a, b, c, d) = (id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1));
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

fn moved_up(mut mesh: TriangleMesh, height: f64) -> TriangleMesh {
    for position in &mut mesh.positions {
        position.z += height;
    }
    mesh
}

/// To six decimals, which keeps files small and the same on every machine.
fn rounded(position: DVec3) -> DVec3 {
    (position * 1e6).round() / 1e6
}

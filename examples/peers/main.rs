//! Writes the scenes that this program is compared with others on.
//!
//! ```text
//! cargo run --release --example peers -- FOLDER
//! ```
//!
//! `docs/speed.md` says what is done with them. Where it compares what is in `scenes` already (the demo), nothing is written here. The same
//! program always writes the same bytes.

use std::error::Error;
use std::fs;
use std::io;
use std::path::Path;

use raymini::control::{CancelToken, Progress};
use raymini::geometry::shapes::Random;
use raymini::geometry::{TriangleMesh, shapes};
use raymini::io::{off, ply, write_atomically};
use raymini::math::DVec3;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).ok_or("usage: peers FOLDER")?;
    let folder = Path::new(&folder);
    fs::create_dir_all(folder)?;
    let meshes = [
        ("land", land(707)),
        ("creatures", creatures()?),
        ("soup", soup_with_slivers(1_000_000)),
        ("slivers", shapes::slivers(20_000, 1e-3, 1)),
        ("dense", shapes::soup(100_000, 0.3, 1)),
    ];
    for (name, mesh) in &meshes {
        let path = folder.join(name).with_extension("ply");
        write_atomically(&path, |file| ply::write(mesh, file))?;
        println!("{}: {} triangles", path.display(), mesh.triangles.len());
    }
    for (name, mesh) in box_parts() {
        let path = folder.join(name).with_extension("off");
        write_atomically(&path, |file| off::write(&mesh, file))?;
    }
    let path = folder.join("box.toml");
    write_atomically(&path, |file| io::Write::write_all(file, BOX.as_bytes()))?;
    println!("{}: a Cornell-like box of 36 triangles", path.display());
    Ok(())
}

/// Rolling land of `2 · side²` triangles, smooth but for small ripples.
fn land(side: u32) -> TriangleMesh {
    let mut mesh = shapes::grid(side);
    for position in &mut mesh.positions {
        let DVec3 { x, y, .. } = *position;
        position.z = 0.1 * (7.0 * x).sin() * (5.0 * y).cos() + 0.002 * (91.0 * x + 37.0 * y).sin();
    }
    mesh
}

/// Sixty of the demo's gargoyles, scattered and turned: 2.6 million triangles that all lie in one mesh.
fn creatures() -> Result<TriangleMesh, Box<dyn Error>> {
    let bytes = fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/gargoyle.off"))?;
    let creature = off::parse(&bytes, &CancelToken::new(), &Progress::new())?;
    let creature = creature.ok_or("nobody cancels")?.mesh;
    let mut random = Random::new(7);
    let mut all = TriangleMesh::default();
    for _ in 0..60 {
        let first = u32::try_from(all.positions.len())?;
        let place = random.in_cube() * DVec3::new(9.0, 9.0, 2.0);
        let (sin, cos) = (random.unit() * std::f64::consts::TAU).sin_cos();
        all.positions.extend(creature.positions.iter().map(|p| {
            let turned = DVec3::new(cos * p.x - sin * p.y, sin * p.x + cos * p.y, p.z);
            (turned + place).as_vec3().as_dvec3()
        }));
        let triangles = creature.triangles.iter();
        all.triangles
            .extend(triangles.map(|corners| corners.map(|corner| corner + first)));
    }
    Ok(all)
}

/// Unconnected triangles, every other one eight times as long and a thousandth as wide.
fn soup_with_slivers(count: u32) -> TriangleMesh {
    let mut random = Random::new(5);
    let mut mesh = TriangleMesh::default();
    for index in 0..count {
        let corner = random.in_cube();
        let [mut a, mut b] = [0, 1].map(|_| random.in_cube().normalize() * 0.02);
        if index % 2 == 0 {
            a *= 8.0;
            b *= 8e-3;
        }
        let corners = [corner, corner + a, corner + b];
        mesh.positions
            .extend(corners.map(|p| p.as_vec3().as_dvec3()));
        mesh.triangles.push([0, 1, 2].map(|i| 3 * index + i));
    }
    mesh
}

/// The box's meshes, one for each material and one for the two blocks in it.
fn box_parts() -> [(&'static str, TriangleMesh); 5] {
    let corner = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let floor = [
        corner(-1., -1., -1.),
        corner(1., -1., -1.),
        corner(1., 1., -1.),
        corner(-1., 1., -1.),
    ];
    let ceiling = [
        corner(-1., -1., 1.),
        corner(-1., 1., 1.),
        corner(1., 1., 1.),
        corner(1., -1., 1.),
    ];
    let back = [
        corner(-1., 1., -1.),
        corner(1., 1., -1.),
        corner(1., 1., 1.),
        corner(-1., 1., 1.),
    ];
    let left = [
        corner(-1., -1., -1.),
        corner(-1., 1., -1.),
        corner(-1., 1., 1.),
        corner(-1., -1., 1.),
    ];
    let right = [
        corner(1., -1., -1.),
        corner(1., -1., 1.),
        corner(1., 1., 1.),
        corner(1., 1., -1.),
    ];
    let lamp = [
        corner(-0.25, -0.2, 0.995),
        corner(-0.25, 0.2, 0.995),
        corner(0.25, 0.2, 0.995),
        corner(0.25, -0.2, 0.995),
    ];
    let mut blocks = block(DVec3::new(-0.35, 0.3, 0.3), 1.2);
    let low = block(DVec3::new(0.35, -0.35, -0.3), 0.6);
    let first = u32::try_from(blocks.positions.len()).expect("eight");
    blocks.positions.extend(low.positions);
    let low = low.triangles.iter();
    blocks
        .triangles
        .extend(low.map(|corners| corners.map(|corner| corner + first)));
    [
        ("white", quads(&[floor, ceiling, back])),
        ("left", quads(&[left])),
        ("right", quads(&[right])),
        ("lamp", quads(&[lamp])),
        ("blocks", blocks),
    ]
}

fn quads(quads: &[[DVec3; 4]]) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for quad in quads {
        let first = u32::try_from(mesh.positions.len()).expect("few");
        mesh.positions.extend(quad);
        mesh.triangles
            .extend([[0, 1, 2], [0, 2, 3]].map(|corners| corners.map(|i| first + i)));
    }
    mesh
}

/// A block on the floor, 0.6 wide and `height` high; `place`: where it stands, and by how much it is turned, in radians.
fn block(place: DVec3, height: f64) -> TriangleMesh {
    let mut block = shapes::cuboid(DVec3::new(-0.3, -0.3, 0.0), DVec3::new(0.3, 0.3, height));
    let (sin, cos) = place.z.sin_cos();
    for p in &mut block.positions {
        *p = DVec3::new(
            cos * p.x - sin * p.y + place.x,
            sin * p.x + cos * p.y + place.y,
            p.z - 1.0,
        );
    }
    block
}

const BOX: &str = r#"# A Cornell-like box: two blocks, a red and a green wall, one lamp.

[camera]
eye = [0.0, -3.9, 0.0]
target = [0.0, 0.0, 0.0]
up = [0.0, 0.0, 1.0]
vertical_fov = 39.0

[render]
mode = "path"
width = 512
height = 512
samples_per_pixel = 64
max_bounces = 7

[materials.white]
diffuse = [0.73, 0.73, 0.73]

[materials.red]
diffuse = [0.63, 0.06, 0.05]

[materials.green]
diffuse = [0.15, 0.48, 0.09]

[materials.lamp]
kind = "emitter"
radiance = [17.0, 12.0, 4.0]

[[objects]]
mesh = "white.off"
material = "white"

[[objects]]
mesh = "left.off"
material = "red"

[[objects]]
mesh = "right.off"
material = "green"

[[objects]]
mesh = "lamp.off"
material = "lamp"

[[objects]]
mesh = "blocks.off"
material = "white"
"#;

//! Writes the images and meshes of the gallery's scene of textures: boards of wood, their joints as normals, hammered metal as
//! normals, and a board, a globe and a coloured torus.
//!
//! `cargo run --release --example textures -- assets`.

mod noise;

use std::f64::consts::{PI, TAU};
use std::io;
use std::path::{Path, PathBuf};

use raymini::geometry::TriangleMesh;
use raymini::io::{obj, ply, write_atomically};
use raymini::math::color::{linear_from_srgb, srgb_from_linear};
use raymini::math::{DVec2, DVec3, Vec3};

/// Texels of a side.
const SIDE: u32 = 256;
/// Rows of boards, and boards of a row.
const ROWS: f64 = 6.0;
const BOARDS: f64 = 2.0;

fn main() -> io::Result<()> {
    let folder = std::env::args().nth(1);
    let folder = PathBuf::from(folder.unwrap_or_else(|| "assets".to_owned()));
    write_image(&folder.join("boards.png"), |at| srgb(wood(at)))?;
    write_image(&folder.join("boards-normals.png"), |at| normal(at, joint))?;
    write_image(&folder.join("hammered-normals.png"), |at| normal(at, dents))?;
    let meshes = [("board", board()), ("globe", globe(64, 32))];
    for (name, mesh) in meshes {
        write_atomically(&folder.join(name).with_extension("obj"), |file| {
            obj::write(&mesh, file)
        })?;
    }
    write_atomically(&folder.join("rainbow.ply"), |file| {
        ply::write(&rainbow(96, 32), file)
    })
}

/// Writes a PNG of `color` at the middles of its texels: right and up from 0 to 1, over which it repeats.
fn write_image(path: &Path, color: impl Fn(DVec2) -> [u8; 3]) -> io::Result<()> {
    let middle = |k: u32| (f64::from(k) + 0.5) / f64::from(SIDE);
    let places = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y)));
    let rgb: Vec<u8> = places
        .flat_map(|(x, y)| color(DVec2::new(middle(x), 1.0 - middle(y))))
        .collect();
    write_atomically(path, |file| {
        let mut encoder = png::Encoder::new(file, SIDE, SIDE);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_compression(png::Compression::High);
        encoder.write_header()?.write_image_data(&rgb)?;
        Ok(())
    })
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "between 0 and 255"
)]
fn srgb(linear: DVec3) -> [u8; 3] {
    let linear = linear.as_vec3().to_array();
    linear.map(|value| (srgb_from_linear(value) * 255.0).round() as u8)
}

/// The normal of a surface as high as `height`, in widths of the image, at a place.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "between 1 and 255"
)]
fn normal(at: DVec2, height: impl Fn(DVec2) -> f64) -> [u8; 3] {
    const STEP: f64 = 0.25 / SIDE as f64;
    let slope = |axis: DVec2| (height(at + axis * STEP) - height(at - axis * STEP)) / (2.0 * STEP);
    let normal = DVec3::new(-slope(DVec2::X), -slope(DVec2::Y), 1.0).normalize();
    // 128 is 0.
    (normal * 127.0 + 128.0)
        .round()
        .to_array()
        .map(|value| value as u8)
}

/// Which board is at a place, and where on it: along and across, from 0 to 1.
fn board_at(at: DVec2) -> (f64, DVec2) {
    let row = (at.y * ROWS).floor();
    // Rows are laid a third of a board apart, as six rows close the circle twice.
    let along = at.x * BOARDS + row / 3.0;
    let number = row.rem_euclid(ROWS) * BOARDS + along.floor().rem_euclid(BOARDS);
    (number, DVec2::new(along.fract(), (at.y * ROWS).fract()))
}

/// Wood, each board cut from another part of the tree.
fn wood(at: DVec2) -> DVec3 {
    let (number, on) = board_at(at);
    let tone = hash(number, 3.0);
    // Grain runs along: slow in x, and bent a little.
    let bend = 0.35 * libm::sin(PI * on.x) * (hash(number, 7.0) - 0.5);
    let rings = 9.0 * (on.y + bend) + 40.0 * hash(number, 11.0);
    let ring = 0.5 + 0.5 * libm::sin(TAU * (rings + 0.35 * noise(on.x * 3.0 + number, rings)));
    let pores = noise(on.x * 24.0 + 50.0 * number, on.y * 90.0);
    let light = DVec3::new(0.47, 0.27, 0.135);
    let dark = DVec3::new(0.24, 0.115, 0.05);
    let color = light.lerp(dark, 0.55 * ring + 0.25 * pores) * (0.75 + 0.5 * tone);
    color * (0.25 + 0.75 * plain(on))
}

/// 1 on a board, 0 in the joints around it.
fn plain(on: DVec2) -> f64 {
    let edge = DVec2::new(on.x.min(1.0 - on.x) / BOARDS, on.y.min(1.0 - on.y) / ROWS);
    let share = (edge.min_element() / 0.006).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

fn joint(at: DVec2) -> f64 {
    0.004 * plain(board_at(DVec2::new(at.x.rem_euclid(1.0), at.y.rem_euclid(1.0))).1)
}

/// Round dents, one in each cell of a grid that closes at the image's edges.
fn dents(at: DVec2) -> f64 {
    const CELLS: f64 = 12.0;
    let place = at * CELLS;
    let cell = place.floor();
    let mut depth = 0.0_f64;
    for y in -1..=1 {
        for x in -1..=1 {
            let cell = cell + DVec2::new(f64::from(x), f64::from(y));
            let (column, row) = (cell.x.rem_euclid(CELLS), cell.y.rem_euclid(CELLS));
            let middle = cell + DVec2::new(hash(column, row), hash(column + 40.0, row)) * 0.6 + 0.2;
            let apart = place.distance(middle) / 0.85;
            depth = depth.max(1.0 - apart * apart);
        }
    }
    -0.02 * depth
}

/// Smooth noise, 0 to 1.
fn noise(x: f64, y: f64) -> f64 {
    noise::smooth(x, y, hash)
}

/// A number of `[0, 1)` for each pair of whole ones.
fn hash(x: f64, y: f64) -> f64 {
    noise::scrambled(x.to_bits() ^ y.to_bits().rotate_left(29))
}

/// A square of side 2 on z = 0, on which the image lies once.
fn board() -> TriangleMesh {
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let corners = corners.map(|(u, v)| DVec2::new(u, v));
    let corner = |uv: DVec2| (uv * 2.0 - 1.0).extend(0.0);
    TriangleMesh {
        positions: corners.map(corner).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        texture_coordinates: Some(corners.to_vec()),
        ..TriangleMesh::default()
    }
}

/// Rows of vertices over a rectangle of `columns` × `rows` cells, each made by its place from 0 to 1; rows go up.
fn sheet(columns: u32, rows: u32, position: impl Fn(f64, f64) -> DVec3) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    let mut coordinates = Vec::new();
    for row in 0..=rows {
        for column in 0..=columns {
            let (u, v) = (
                f64::from(column) / f64::from(columns),
                f64::from(row) / f64::from(rows),
            );
            // To six decimals, which keeps files small and the same on every machine.
            mesh.positions.push((position(u, v) * 1e6).round() / 1e6);
            coordinates.push(DVec2::new(u, v));
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let a = row * (columns + 1) + column;
            let (b, c, d) = (a + 1, a + columns + 2, a + columns + 1);
            // At a pole, one of them is nothing.
            let has_area = |triangle: &[u32; 3]| {
                let [a, b, c] = triangle.map(|vertex| mesh.positions[vertex as usize]);
                a != b && b != c && c != a
            };
            let cells = [[a, b, c], [a, c, d]].into_iter().filter(has_area);
            mesh.triangles.extend(cells.collect::<Vec<_>>());
        }
    }
    mesh.texture_coordinates = Some(coordinates);
    mesh
}

/// A ball of radius 1 that stands on z = 0, the image once around it.
fn globe(columns: u32, rows: u32) -> TriangleMesh {
    sheet(columns, rows, |u, v| {
        let (sine, cosine) = libm::sincos(TAU * u);
        let (radius, height) = libm::sincos(PI * (1.0 - v));
        DVec3::new(radius * cosine, radius * sine, 1.0 + height)
    })
}

/// A torus that lies on z = 0, coloured around its ring.
fn rainbow(around: u32, across: u32) -> TriangleMesh {
    const TUBE: f64 = 0.38;
    let normal = |u: f64, v: f64| {
        let ((sine, cosine), (rise, out)) = (libm::sincos(TAU * u), libm::sincos(TAU * v));
        DVec3::new(out * cosine, out * sine, rise)
    };
    let mut mesh = sheet(around, across, |u, v| {
        let (sine, cosine) = libm::sincos(TAU * u);
        DVec3::new(cosine, sine, TUBE) + normal(u, v) * TUBE
    });
    let color = |uv: DVec2| {
        let channel = |phase: f64| 0.5 + 0.45 * libm::cos(TAU * (uv.x - phase));
        let code = |value: f64| (value * 255.0).round() / 255.0;
        let color = DVec3::new(
            code(channel(0.0)),
            code(channel(1.0 / 3.0)),
            code(channel(2.0 / 3.0)),
        );
        color.as_vec3().map(linear_from_srgb)
    };
    let coordinates = mesh.texture_coordinates.take().expect("a sheet has some");
    let of_vertex = |uv: &DVec2| normal(uv.x, uv.y).as_vec3().as_dvec3();
    mesh.normals = Some(coordinates.iter().map(of_vertex).collect());
    mesh.colors = Some(coordinates.into_iter().map(color).collect::<Vec<Vec3>>());
    mesh
}

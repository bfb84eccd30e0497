//! Writes the gallery's sky as a Radiance HDR image of all directions: a low sun among clouds over a dark plain.
//!
//! `cargo run --release --example sky -- assets/evening.hdr`. The sun stands 24° high, at the image's centre.

mod noise;

use std::f64::consts::{PI, TAU};
use std::path::PathBuf;

use image::Rgb;
use image::codecs::hdr::HdrEncoder;
use raymini::io::write_atomically;
use raymini::math::DVec3;

const WIDTH: u32 = 256;
const HEIGHT: u32 = 128;

/// Height of the sun over the horizon, in radians.
const SUN_HEIGHT: f64 = 24.0 / 180.0 * PI;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1);
    let path = PathBuf::from(path.unwrap_or_else(|| "assets/evening.hdr".to_owned()));
    let pixels = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| direction(x, y)));
    let pixels: Vec<_> = pixels
        .map(|direction| Rgb(radiance(direction).as_vec3().to_array()))
        .collect();
    let mut bytes = Vec::new();
    HdrEncoder::new(&mut bytes).encode(&pixels, WIDTH as usize, HEIGHT as usize)?;
    write_atomically(&path, |file| file.write_all(&bytes))?;
    println!("{}: {} bytes", path.display(), bytes.len());
    Ok(())
}

/// The direction of a pixel: x to the image's centre, y to its left, z up.
fn direction(x: u32, y: u32) -> DVec3 {
    let (sin_polar, z) = libm::sincos((f64::from(y) + 0.5) / f64::from(HEIGHT) * PI);
    let (sine, cosine) = libm::sincos(TAU * (0.5 - (f64::from(x) + 0.5) / f64::from(WIDTH)));
    DVec3::new(sin_polar * cosine, sin_polar * sine, z)
}

fn radiance(direction: DVec3) -> DVec3 {
    let (sine, cosine) = libm::sincos(SUN_HEIGHT);
    let sun = DVec3::new(cosine, 0.0, sine);
    let apart = libm::acos(direction.dot(sun).clamp(-1.0, 1.0)).to_degrees();
    let towards_sun = 0.5 + 0.5 * direction.dot(DVec3::X);
    if direction.z < 0.0 {
        let plain =
            DVec3::new(0.070, 0.060, 0.052).lerp(DVec3::new(0.15, 0.115, 0.08), towards_sun);
        // The haze over it ends in the sky's own colour.
        return plain.lerp(clear_sky(0.0, towards_sun), libm::exp(12.0 * direction.z));
    }
    let glow = DVec3::new(1.0, 0.62, 0.30)
        * (2.2 * libm::exp(-apart / 5.0) + 0.9 * libm::exp(-apart / 18.0));
    let clear = clear_sky(direction.z, towards_sun) + glow;
    let lit =
        DVec3::new(0.62, 0.60, 0.64) + DVec3::new(1.25, 0.78, 0.46) * towards_sun.powi(3) + glow;
    let sky = clear.lerp(lit, cloud(direction));
    // One and a half texels wide: what its light needs, not what a telescope shows.
    let disk = (1.9 - apart).clamp(0.0, 1.0);
    sky + DVec3::new(1.0, 0.76, 0.48) * (1300.0 * disk)
}

/// From the horizon's colour, warm on the sun's side, to blue overhead.
fn clear_sky(height: f64, towards_sun: f64) -> DVec3 {
    let cool = DVec3::new(0.42, 0.46, 0.56);
    let horizon = cool.lerp(DVec3::new(1.05, 0.72, 0.44), towards_sun * towards_sun);
    DVec3::new(0.10, 0.20, 0.46).lerp(horizon, libm::exp(-3.2 * height))
}

/// How much of the sky is cloud, 0 to 1: layers on a plane overhead that thin out at the horizon.
fn cloud(direction: DVec3) -> f64 {
    let (u, v) = (
        direction.x / (direction.z + 0.16),
        direction.y / (direction.z + 0.16),
    );
    let octaves = [(0.55, 0.5), (1.2, 0.27), (2.6, 0.15), (5.5, 0.08)];
    let noise: f64 = octaves
        .iter()
        .map(|(frequency, weight)| weight * value_noise(u * frequency * 0.8, v * frequency))
        .sum();
    let density = ((noise - 0.48) / 0.22).clamp(0.0, 1.0);
    let near_horizon = (direction.z / 0.12).clamp(0.0, 1.0);
    density * density * (3.0 - 2.0 * density) * near_horizon * 0.85
}

/// Smooth noise, 0 to 1, from values at whole coordinates.
fn value_noise(x: f64, y: f64) -> f64 {
    noise::smooth(x, y, hash)
}

/// A number of `[0, 1)` for each pair of whole ones.
fn hash(x: f64, y: f64) -> f64 {
    #[expect(clippy::cast_possible_truncation, reason = "small whole numbers")]
    let (x, y) = (x as i64, y as i64);
    noise::scrambled((x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b)).cast_unsigned())
}

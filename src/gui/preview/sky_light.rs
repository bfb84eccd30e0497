//! What an image sends to matt surfaces, in nine numbers per channel.
//!
//! Irradiance is so smooth in the normal that spherical harmonics of second degree hold nearly all of it; what is lost are
//! the edges of the light of a small bright sun, for which the preview has no shadows either.
//! Source: Ramamoorthi & Hanrahan, An Efficient Representation for Irradiance Environment Maps, 2001.

use std::f64::consts::{PI, TAU};

use crate::math::DVec3;
use crate::scene::RadianceMap;

/// Coefficients of a polynomial in a unit normal `(x, y, z)` along the image's axes, for 1, x, y, z, xy, yz, xz, 3z² − 1 and
/// x² − y²: irradiance over π, per channel.
pub fn irradiance(map: &RadianceMap) -> [DVec3; 9] {
    // Per degree: what the cosine keeps of it, over π.
    const KEPT: [f64; 3] = [1.0, 2.0 / 3.0, 0.25];
    let mut sums = [DVec3::ZERO; 9];
    let width = f64::from(map.width());
    let turns: Vec<[f64; 2]> = (0..map.width())
        .map(|x| {
            let (sine, cosine) = libm::sincos(TAU * (0.5 - (f64::from(x) + 0.5) / width));
            [cosine, sine]
        })
        .collect();
    for y in 0..map.height() {
        let (sine, z) = libm::sincos(map.polar_angle(y));
        // Sums over the row of 1, cos φ, sin φ, cos 2φ and sin 2φ.
        let mut row = [DVec3::ZERO; 5];
        for (pixel, &[c, s]) in map.row(y).iter().zip(&turns) {
            let radiance = DVec3::from_array(pixel.map(f64::from));
            let factors = [1.0, c, s, c * c - s * s, 2.0 * s * c];
            for (sum, factor) in row.iter_mut().zip(factors) {
                *sum += radiance * factor;
            }
        }
        let half_height = PI / f64::from(map.height()) / 2.0;
        let solid_angle = TAU / width * 2.0 * sine * libm::sin(half_height);
        let [one, cos, sin, cos_twice, sin_twice] = row.map(|sum| sum * solid_angle);
        let parts = [
            one,
            cos * sine,
            sin * sine,
            one * z,
            sin_twice * (sine * sine / 2.0),
            sin * (sine * z),
            cos * (sine * z),
            one * (3.0 * z * z - 1.0),
            cos_twice * (sine * sine),
        ];
        for (sum, part) in sums.iter_mut().zip(parts) {
            *sum += part;
        }
    }
    // Squares of the factors that make each polynomial a unit on the sphere.
    let (first, mixed) = (3.0 / (4.0 * PI), 15.0 / (4.0 * PI));
    let [zonal, tesseral] = [5.0 / (16.0 * PI), 15.0 / (16.0 * PI)];
    let norms = [
        KEPT[0] / (4.0 * PI),
        KEPT[1] * first,
        KEPT[1] * first,
        KEPT[1] * first,
        KEPT[2] * mixed,
        KEPT[2] * mixed,
        KEPT[2] * mixed,
        KEPT[2] * zonal,
        KEPT[2] * tesseral,
    ];
    std::array::from_fn(|i| sums[i] * norms[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn evaluate(light: &[DVec3; 9], n: DVec3) -> DVec3 {
        let DVec3 { x, y, z } = n;
        let polynomials = [
            1.0,
            x,
            y,
            z,
            x * y,
            y * z,
            x * z,
            3.0 * z * z - 1.0,
            x * x - y * y,
        ];
        light.iter().zip(polynomials).map(|(c, p)| *c * p).sum()
    }

    /// Radiance `1 + ω · a + (ω · b)²` gives irradiance over π of `1 + 2/3 n · a + b²/4 + (n · b)²/4`.
    #[test]
    fn images_of_second_degree_are_held_exactly() {
        let (a, b) = (DVec3::new(0.3, -0.2, 0.4), DVec3::new(0.5, 0.7, -0.6));
        let (width, height) = (128_u32, 64_u32);
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let pixels = pixels.map(|(x, y)| {
            let (sine, z) = ((f64::from(y) + 0.5) / 64.0 * PI).sin_cos();
            let (s, c) = (TAU * (0.5 - (f64::from(x) + 0.5) / 128.0)).sin_cos();
            let w = DVec3::new(sine * c, sine * s, z);
            #[expect(clippy::cast_possible_truncation, reason = "pixels are f32")]
            let radiance = (1.0 + w.dot(a) + w.dot(b).powi(2)) as f32;
            [radiance; 3]
        });
        let (map, _) = RadianceMap::cleaned(width, height, pixels.collect());
        let light = irradiance(&map);
        for n in [DVec3::X, -DVec3::Y, DVec3::Z, DVec3::new(0.6, -0.48, 0.64)] {
            let expected =
                1.0 + n.dot(a) * 2.0 / 3.0 + b.length_squared() / 4.0 + n.dot(b).powi(2) / 4.0;
            let found = evaluate(&light, n).x;
            assert!((found - expected).abs() < 1e-3, "{n}: {found}, {expected}");
        }
    }
}

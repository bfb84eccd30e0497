//! An image of all directions as rendering reads it: interpolated, and sampled in exact proportion to what it shows.
//!
//! Radiance is interpolated between the centres of four neighbouring texels, linearly in the azimuth and linearly in the
//! cosine to the image's top; beyond the first and last row it stays as it is there. The solid angle is even in these two
//! coordinates. So the luminance is linear in each of them within a cell of four centres, and directions are drawn in
//! proportion to it without any remainder: the cell by its power from tables of sums, the place in the cell by the two linear
//! densities. The density of a direction is then its luminance over the integral of the luminance, nothing else; a sample's
//! luminance over its density is the same number for every sample.
//!
//! Directions are in the image's own frame: x to its centre, y to its left, z to its top ([`crate::scene::ImageAxes`]).

use std::f32::consts::PI;
use std::f64::consts::{PI as PI_64, TAU};
use std::sync::Arc;

use super::shares::{append_shares, draw};
use crate::control::CancelToken;
use crate::math::{DVec3, Vec2, Vec3, color::luminance, warp};
use crate::scene::RadianceMap;

/// An image and its tables.
#[derive(Debug)]
pub struct RadianceImage {
    map: Arc<RadianceMap>,
    /// Cosines to the top at the edges of the rows of cells, from 1 to −1: row `r` of cells lies between the centres of the
    /// rows `r − 1` and `r` of texels.
    edges: Vec<f64>,
    /// For each row of cells the share of the luminance in it and in those above it; empty where nothing is sampled.
    rows: Vec<f32>,
    /// For each cell the share of its row's luminance in it and in those left of it. Column `c` of cells lies between the
    /// centres of the columns `c` and `c + 1` of texels. Empty where nothing is sampled.
    columns: Vec<f32>,
    /// Luminance integrated over all directions.
    integral: f64,
    /// The largest value of a channel.
    largest: f32,
}

/// Four texel centres and a place between them.
struct Cell {
    left: usize,
    right: usize,
    upper: u32,
    lower: u32,
    /// From left to right and from upper to lower, 0 to 1.
    place: Vec2,
}

impl RadianceImage {
    /// Prepares `map`, with the tables that [sampling](Self::sample) takes or without; `None` when cancelled.
    pub fn new(map: &Arc<RadianceMap>, is_sampled: bool, cancel: &CancelToken) -> Option<Self> {
        let (width, height) = (map.width() as usize, map.height());
        let centers = (0..height).map(|y| libm::cos(map.polar_angle(y)));
        let edges: Vec<f64> = std::iter::once(1.0).chain(centers).chain([-1.0]).collect();
        let luminances = |y: u32| -> Vec<f64> {
            let values = map.row(y).iter();
            values.map(|&pixel| luminance_of(pixel)).collect()
        };

        let mut powers = Vec::with_capacity(height as usize + 1);
        let rows_kept = if is_sampled { height as usize + 1 } else { 1 };
        let mut columns = Vec::with_capacity(width * rows_kept);
        let mut upper = luminances(0);
        for row in 0..=height {
            if cancel.is_cancelled() {
                return None;
            }
            let lower = luminances(row.min(height - 1));
            // Of a cell, up to factors that are the same in the whole row.
            let corners = |c: usize| {
                let next = (c + 1) % width;
                upper[c] + upper[next] + lower[c] + lower[next]
            };
            let cells: Vec<f64> = (0..width).map(corners).collect();
            if !is_sampled {
                columns.clear();
            }
            let total = append_shares(&cells, &mut columns);
            let band = edges[row as usize] - edges[row as usize + 1];
            powers.push(total / 4.0 * band * (TAU / width as f64));
            upper = lower;
        }
        let mut rows = Vec::with_capacity(powers.len());
        let integral = append_shares(&powers, &mut rows);
        if !is_sampled {
            (rows, columns) = (Vec::new(), Vec::new());
        }
        let values = map.pixels().iter().flatten();
        Some(Self {
            largest: values.fold(0.0, |a: f32, &b| a.max(b)),
            map: Arc::clone(map),
            edges,
            rows,
            columns,
            integral,
        })
    }

    /// Whether it has what [sampling](Self::sample) takes.
    pub fn can_be_sampled(&self) -> bool {
        !self.rows.is_empty()
    }

    /// Bytes of those tables.
    pub fn table_bytes(&self) -> usize {
        (self.rows.len() + self.columns.len()) * size_of::<f32>()
    }

    /// The image it was made of.
    pub fn map(&self) -> &Arc<RadianceMap> {
        &self.map
    }

    /// The largest value of a channel.
    pub fn largest(&self) -> f32 {
        self.largest
    }

    /// Luminance integrated over all directions, exactly.
    pub fn integral(&self) -> f64 {
        self.integral
    }

    /// Radiance seen along `local`, of any length.
    pub fn radiance(&self, local: DVec3) -> Vec3 {
        let Cell {
            left,
            right,
            upper,
            lower,
            place,
        } = self.cell(local);
        let at = |x: usize, y: u32| Vec3::from_array(self.map.row(y)[x]);
        let above = between(at(left, upper), at(right, upper), place.x);
        let below = between(at(left, lower), at(right, lower), place.x);
        between(above, below, place.y)
    }

    /// Density of [`Self::sample`] at a direction in which `radiance` is seen, per steradian.
    pub fn pdf_solid_angle(&self, radiance: Vec3) -> f32 {
        #[expect(clippy::cast_possible_truncation, reason = "rendering is f32")]
        let pdf = (f64::from(luminance(radiance)) / self.integral) as f32;
        pdf
    }

    /// A unit vector drawn in proportion to the luminance seen along it; `u`: uniform over the unit square. `None` for a black image, and
    /// without the tables.
    pub fn sample(&self, u: Vec2) -> Option<DVec3> {
        if self.integral <= 0.0 || !self.can_be_sampled() {
            return None;
        }
        let width = self.map.width() as usize;
        let (row, v) = draw(&self.rows, u.y);
        let (left, u) = draw(&self.columns[row * width..][..width], u.x);
        let right = (left + 1) % width;
        let [upper, lower] = texel_rows(row, self.map.height());

        // Within the cell: the height by the mean of both sides, then the azimuth at that height.
        let at = |x: usize, y: u32| luminance_of(self.map.row(y)[x]);
        let [a, b] = [at(left, upper), at(right, upper)];
        let [c, d] = [at(left, lower), at(right, lower)];
        let y = warp::linear(v, a + b, c + d);
        let mix = |from: f64, to: f64| from + (to - from) * y;
        let x = warp::linear(u, mix(a, c), mix(b, d));

        let cosine = self.edges[row] + (self.edges[row + 1] - self.edges[row]) * y;
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let azimuth = TAU * (0.5 - (left as f64 + 0.5 + x) / width as f64);
        let (sin_azimuth, cos_azimuth) = libm::sincos(azimuth);
        Some(DVec3::new(sine * cos_azimuth, sine * sin_azimuth, cosine))
    }

    /// The cell in which `local` lies, and where.
    fn cell(&self, local: DVec3) -> Cell {
        let level = local.x * local.x + local.y * local.y;
        let cosine = local.z / (level + local.z * local.z).sqrt();
        let row = self.row_of(cosine);
        let [upper, lower] = texel_rows(row, self.map.height());
        let y = (self.edges[row] - cosine) / (self.edges[row] - self.edges[row + 1]);

        #[expect(clippy::cast_possible_truncation, reason = "rendering is f32")]
        let azimuth = libm::atan2f(local.y as f32, local.x as f32);
        let width = self.map.width();
        // Counted from the centre of the first column: from −½ to width − ½, the whole turn.
        let x = (0.5 - azimuth / (2.0 * PI)) * width as f32 - 0.5;
        let column = x.floor();
        #[expect(clippy::cast_possible_truncation, reason = "at most the width")]
        let left = (column as i64).rem_euclid(width.into());
        let left = usize::try_from(left).expect("the remainder is not negative");
        #[expect(clippy::cast_possible_truncation, reason = "a share")]
        let y = y.clamp(0.0, 1.0) as f32;
        Cell {
            left,
            right: (left + 1) % width as usize,
            upper,
            lower,
            place: Vec2::new(x - column, y),
        }
    }

    /// The row of cells at a `cosine` to the top.
    fn row_of(&self, cosine: f64) -> usize {
        let last = self.edges.len() - 2;
        let angle = libm::acos(cosine.clamp(-1.0, 1.0));
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "an angle of 0 to π"
        )]
        let near = (angle / PI_64 * f64::from(self.map.height()) + 0.5) as usize;
        // The angle may be rounded across an edge; the edges themselves decide.
        let mut row = near.min(last);
        while row > 0 && cosine > self.edges[row] {
            row -= 1;
        }
        while row < last && cosine < self.edges[row + 1] {
            row += 1;
        }
        row
    }
}

/// Interpolated linearly. Between values that are not negative the result is not either, and between equal ones it is the same.
fn between(from: Vec3, to: Vec3, share: f32) -> Vec3 {
    from + (to - from) * share
}

/// The rows of texels above and below a row of cells.
fn texel_rows(row: usize, height: u32) -> [u32; 2] {
    let row = u32::try_from(row).expect("rows are counted in u32");
    [row.saturating_sub(1), row.min(height - 1)]
}

fn luminance_of(pixel: [f32; 3]) -> f64 {
    // Of values up to the largest f32, whose sum is larger.
    DVec3::from_array(pixel.map(f64::from)).dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn prepared(width: u32, height: u32, pixels: Vec<[f32; 3]>) -> RadianceImage {
        let (map, cleaned) = RadianceMap::cleaned(width, height, pixels);
        assert_eq!(cleaned, 0);
        RadianceImage::new(&Arc::new(map), true, &CancelToken::new()).expect("nobody cancels")
    }

    /// A dim sky with a sun a thousand times as bright in one texel, and a black quarter.
    fn with_sun() -> RadianceImage {
        let (width, height) = (17_u32, 9_u32);
        let pixel = |i: u32| {
            let (x, y) = (i % width, i / width);
            match (x, y) {
                (5, 2) => [1000.0, 900.0, 700.0],
                (9.., 5..) => [0.0; 3],
                _ => [0.5 + 0.02 * x as f32, 0.7, 1.0 - 0.05 * y as f32],
            }
        };
        prepared(width, height, (0..width * height).map(pixel).collect())
    }

    fn direction(cosine: f64, azimuth: f64) -> DVec3 {
        let sine = (1.0 - cosine * cosine).sqrt();
        DVec3::new(sine * azimuth.cos(), sine * azimuth.sin(), cosine)
    }

    /// Integral of the density over a part of the sphere, by midpoints.
    fn probability(
        image: &RadianceImage,
        cosines: [f64; 2],
        azimuths: [f64; 2],
        steps: u32,
    ) -> f64 {
        let mut sum = 0.0;
        for i in 0..steps {
            for j in 0..steps {
                let at = |[from, to]: [f64; 2], step: u32| {
                    from + (to - from) * (f64::from(step) + 0.5) / f64::from(steps)
                };
                let seen = image.radiance(direction(at(cosines, i), at(azimuths, j)));
                sum += f64::from(image.pdf_solid_angle(seen));
            }
        }
        let area = (cosines[1] - cosines[0]) * (azimuths[1] - azimuths[0]);
        sum * area / f64::from(steps * steps)
    }

    #[test]
    fn the_density_integrates_to_one() {
        let whole = probability(&with_sun(), [-1.0, 1.0], [-PI_64, PI_64], 2000);
        assert!((whole - 1.0).abs() < 1e-4, "{whole}");
    }

    /// χ² over 10 bands of equal solid angle and 20 sectors; cells that expect fewer than 5 samples are pooled. α = 0.001.
    #[test]
    fn directions_are_drawn_by_their_density() {
        const SAMPLES: u32 = 200_000;
        let image = with_sun();
        let mut state = 7_u64;
        let mut next = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / 16_777_216.0
        };
        let mut counts = vec![0_u32; 200];
        for _ in 0..SAMPLES {
            let w = image.sample(Vec2::new(next(), next())).expect("has light");
            assert!((w.length() - 1.0).abs() < 1e-12);
            let turn = (w.y.atan2(w.x) / TAU + 0.5).clamp(0.0, 1.0);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "cell indices"
            )]
            let (band, sector) = (
                (((w.z + 1.0) * 5.0) as usize).min(9),
                ((turn * 20.0) as usize).min(19),
            );
            counts[band * 20 + sector] += 1;
        }
        let (mut chi_squared, mut cells) = (0.0, 0_u32);
        let mut pooled = (0.0, 0.0);
        for (cell, &count) in (0_u32..).zip(&counts) {
            let (band, sector) = (f64::from(cell / 20), f64::from(cell % 20));
            let cosines = [band / 5.0 - 1.0, (band + 1.0) / 5.0 - 1.0];
            let azimuths = [sector, sector + 1.0].map(|s| (s / 20.0 - 0.5) * TAU);
            let expected = probability(&image, cosines, azimuths, 200) * f64::from(SAMPLES);
            if expected < 5.0 {
                pooled = (pooled.0 + expected, pooled.1 + f64::from(count));
            } else {
                chi_squared += (f64::from(count) - expected).powi(2) / expected;
                cells += 1;
            }
        }
        if pooled.0 > 0.0 {
            chi_squared += (pooled.1 - pooled.0).powi(2) / pooled.0;
            cells += 1;
        }
        // Wilson & Hilferty's approximation of the bound; 3.09 standard deviations are 0.001.
        let k = f64::from(cells - 1);
        let bound = k * (1.0 - 2.0 / (9.0 * k) + 3.09 * (2.0 / (9.0 * k)).sqrt()).powi(3);
        assert!(
            cells > 50 && chi_squared < bound,
            "{cells}: {chi_squared}, {bound}"
        );
    }

    #[test]
    fn nothing_black_is_ever_drawn() {
        let mut pixels = vec![[0.0; 3]; 32];
        pixels[12] = [0.0, 0.0, 1.0];
        let image = prepared(8, 4, pixels);
        for x in 0..64_u8 {
            for y in 0..64_u8 {
                let u = Vec2::new(f32::from(x), f32::from(y)) / 64.0;
                let seen = image.radiance(image.sample(u).expect("has light"));
                // On the corner where the first numbers lead, light begins.
                assert!(image.pdf_solid_angle(seen) > 0.0 || x == 0 || y == 0, "{u}");
            }
        }
        assert_eq!(
            prepared(8, 4, vec![[0.0; 3]; 32]).sample(Vec2::splat(0.5)),
            None
        );
    }

    #[test]
    fn texels_are_seen_at_their_centres() {
        let image = with_sun();
        let (width, height) = (image.map.width(), image.map.height());
        for y in 0..height {
            for x in 0..width {
                let azimuth = TAU * (0.5 - (f64::from(x) + 0.5) / f64::from(width));
                let w = direction(image.map.polar_angle(y).cos(), azimuth);
                let expected = Vec3::from_array(image.map.row(y)[x as usize]);
                let seen = image.radiance(w * 3.0);
                assert!(
                    seen.abs_diff_eq(expected, 2e-2),
                    "({x}, {y}): {seen}, {expected}"
                );
            }
        }
    }

    #[test]
    fn images_of_any_size_and_one_value_are_even_to_the_last_bit() {
        for (width, height) in [(1, 1), (1, 3), (3, 1), (2, 1), (8, 4)] {
            let image = prepared(
                width,
                height,
                vec![[0.3, 0.7, 0.1]; (width * height) as usize],
            );
            let luminance = luminance_of([0.3, 0.7, 0.1]);
            assert!((image.integral() / (4.0 * PI_64 * luminance) - 1.0).abs() < 1e-12);
            for step in 0..1000_u16 {
                let t = f64::from(step) / 999.0;
                let seen = image.radiance(direction(1.0 - 2.0 * t, 50.0 * t));
                assert_eq!(seen, Vec3::new(0.3, 0.7, 0.1), "{width}×{height}");
                let u = Vec2::new(
                    f32::from(step) / 1000.0,
                    f32::from(step * 7 % 1000) / 1000.0,
                );
                assert!(image.sample(u).is_some());
            }
        }
    }

    #[test]
    fn the_largest_values_do_not_overflow() {
        let image = prepared(4, 2, vec![[f32::MAX; 3]; 8]);
        assert!(image.integral().is_finite());
        let w = image.sample(Vec2::splat(0.4)).expect("has light");
        let pdf = image.pdf_solid_angle(image.radiance(w));
        assert!((pdf * 4.0 * PI - 1.0).abs() < 1e-5, "{pdf}");
    }
}

//! How different two pictures look when a screen shows them in turn: LDR-FLIP.
//!
//! Colours are blurred as far as the eye blurs them at a given distance, and compared in a space where equal distances look equally far
//! apart; edges and points that are in one picture alone make a difference count more.
//! Source: Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, FLIP: A Difference Evaluator for Alternating Images, 2020.
//! All filters are separable, so that each is a pass over rows and one over columns, of one band of rows after another: memory does not
//! grow with the height.

use rayon::prelude::*;

use super::metrics::{SizesDiffer, check_sizes, is_finite};
use crate::control::CancelToken;
use crate::math::{DMat3, DVec2, DVec3};
use crate::render::Image;

/// Pixels per degree of a screen 0.7 m wide with 3840 pixels, seen from 0.7 m: the paper's default.
const PIXELS_PER_DEGREE: f64 = 0.7 * 3840.0 / 0.7 * std::f64::consts::PI / 180.0;
/// Rows that are worked on at once.
const BAND: usize = 32;
/// What distances between colours are raised to.
const COLOR_EXPONENT: f64 = 0.7;
/// Up to this share of the largest distance, colours are mapped to errors up to the second number.
const KNEE: [f64; 2] = [0.4, 0.95];
/// What differences of features are raised to.
const FEATURE_EXPONENT: f64 = 0.5;
/// Width of the eye's detector of edges, in degrees.
const DETECTOR_WIDTH: f64 = 0.082;
/// Amplitudes and widths of the Gaussians that say what the eye blurs, in degrees squared: brightness, red to green, blue to yellow.
const BLURS: [&[[f64; 2]]; 3] = [
    &[[1.0, 0.0047]],
    &[[1.0, 0.0053]],
    &[[34.1, 0.04], [13.5, 0.025]],
];

/// From linear sRGB to CIE XYZ under D65 (IEC 61966-2-1).
const XYZ_FROM_RGB: DMat3 = DMat3::from_cols(
    DVec3::new(0.412_390_8, 0.212_639, 0.019_330_8),
    DVec3::new(0.357_584_3, 0.715_168_7, 0.119_194_8),
    DVec3::new(0.180_480_8, 0.072_192_3, 0.950_532_2),
);

/// The mean FLIP error of `a` against `b`, from 0 (they look alike) to 1, when a screen shows both: without exposure or tone curve, values
/// beyond 1 as 1. A pixel that is not finite in one of them is left out, and makes no difference to those around it. NaN where no pixel is
/// finite in both.
///
/// # Errors
/// When the sizes differ.
pub fn mean_flip(a: &Image, b: &Image) -> Result<f64, SizesDiffer> {
    let Some(mean) = mean_flip_unless(a, b, &CancelToken::new())? else {
        unreachable!("nobody cancels");
    };
    Ok(mean)
}

/// [`mean_flip`]; `None` when cancelled.
///
/// # Errors
/// When the sizes differ.
pub fn mean_flip_unless(
    a: &Image,
    b: &Image,
    cancel: &CancelToken,
) -> Result<Option<f64>, SizesDiffer> {
    check_sizes(a, b)?;
    let (width, height) = (a.width as usize, a.height as usize);
    let filters = Filters::new(PIXELS_PER_DEGREE);
    let bands: Option<Vec<(f64, u64)>> = (0..height.div_ceil(BAND))
        .into_par_iter()
        .map(|band| {
            if cancel.is_cancelled() {
                return None;
            }
            let rows = band * BAND..height.min((band + 1) * BAND);
            let [of_a, of_b] = [[a, b], [b, a]].map(|images| filters.look_at(images, &rows));
            let first = rows.start * width;
            let (mut sum, mut count) = (0.0, 0);
            for (index, (a_seen, b_seen)) in of_a.iter().zip(&of_b).enumerate() {
                let pixels = [a, b].map(|image| image.pixels[first + index]);
                if pixels.into_iter().all(is_finite) {
                    sum += filters.difference(a_seen, b_seen);
                    count += 1;
                }
            }
            Some((sum, count))
        })
        .collect();
    let Some(bands) = bands else {
        return Ok(None);
    };
    let sum: f64 = bands.iter().map(|(sum, _)| sum).sum();
    let count: u64 = bands.iter().map(|(_, count)| count).sum();
    Ok(Some(sum / count as f64))
}

/// What the eye sees at a pixel.
#[derive(Clone, Copy, Debug)]
struct Seen {
    /// L*a*b*, with colours less colourful where it is dark.
    color: DVec3,
    /// How much of an edge there is, and of a point.
    features: DVec2,
}

/// The filters, and what follows from them.
struct Filters {
    white: DVec3,
    rgb_from_xyz: DMat3,
    /// Rows before and after a band that have a say in it.
    halo: usize,
    /// For each channel, weights of Gaussians and the Gaussians along an axis.
    blurs: [Vec<(f64, Vec<f64>)>; 3],
    /// Along an axis: what blurs across an edge, finds an edge, and finds a point.
    detectors: [Vec<f64>; 3],
    /// The largest distance of two colours, mapped.
    largest: f64,
}

impl Filters {
    fn new(pixels_per_degree: f64) -> Self {
        use std::f64::consts::PI;
        let white = XYZ_FROM_RGB * DVec3::ONE;
        let widest = BLURS.iter().copied().flatten().map(|[_, width]| width);
        let widest = widest.fold(0.0_f64, |a, &b| a.max(b));
        let radius = whole(3.0 * (widest / (2.0 * PI * PI)).sqrt() * pixels_per_degree);
        let blurs = BLURS.map(|gaussians| {
            let parts = gaussians.iter().map(|&[amplitude, width]| {
                let bell = bell(radius, |x| {
                    let degrees = x / pixels_per_degree;
                    (-PI * PI * degrees * degrees / width).exp()
                });
                (amplitude * (PI / width).sqrt(), bell)
            });
            let parts: Vec<(f64, Vec<f64>)> = parts.collect();
            let square = |bell: &[f64]| bell.iter().sum::<f64>().powi(2);
            let total: f64 = parts
                .iter()
                .map(|(weight, bell)| weight * square(bell))
                .sum();
            let parts = parts.into_iter();
            parts.map(|(weight, bell)| (weight / total, bell)).collect()
        });

        let deviation = 0.5 * DETECTOR_WIDTH * pixels_per_degree;
        let detector_radius = whole(3.0 * deviation);
        let gauss = |x: f64| (-x * x / (2.0 * deviation * deviation)).exp();
        let across = bell(detector_radius, gauss);
        let sum: f64 = across.iter().sum();
        let across = across.into_iter().map(|x| x / sum).collect();
        let edge = balanced(&bell(detector_radius, |x| -x * gauss(x)));
        let point = balanced(&bell(detector_radius, |x| {
            (x * x / (deviation * deviation) - 1.0) * gauss(x)
        }));
        let mut filters = Self {
            white,
            rgb_from_xyz: XYZ_FROM_RGB.inverse(),
            halo: radius.max(detector_radius),
            blurs,
            detectors: [across, edge, point],
            largest: 0.0,
        };
        let [green, blue] = [DVec3::Y, DVec3::Z].map(|rgb| filters.perceived(rgb));
        filters.largest = hyab(green, blue).powf(COLOR_EXPONENT);
        filters
    }

    /// What the eye sees of the pixels of `rows`, row by row, when `image` is compared with `other`.
    fn look_at(&self, [image, other]: [&Image; 2], rows: &std::ops::Range<usize>) -> Vec<Seen> {
        let (width, height) = (image.width as usize, image.height as usize);
        // With rows above and below; beyond the picture its edge goes on.
        let halo = self.halo;
        let extended = rows.len() + 2 * halo;
        let mut channels = [(); 3].map(|()| Vec::with_capacity(extended * width));
        for row in 0..extended {
            let y = (rows.start + row).saturating_sub(halo).min(height - 1);
            let row = y * width..(y + 1) * width;
            for (&rgb, &of_other) in image.pixels[row.clone()].iter().zip(&other.pixels[row]) {
                let opponent = self.opponent(shown(rgb, of_other));
                for (channel, value) in channels.iter_mut().zip(opponent.to_array()) {
                    channel.push(value);
                }
            }
        }
        let filtered = |channel: &[f64], across: &[f64], down: &[f64]| {
            let rows = along_rows(channel, width, across);
            along_columns(&rows, width, halo, down)
        };
        let blurred = [0, 1, 2].map(|index| {
            let mut sum = vec![0.0; rows.len() * width];
            for (weight, bell) in &self.blurs[index] {
                let part = filtered(&channels[index], bell, bell);
                for (sum, part) in sum.iter_mut().zip(part) {
                    *sum += weight * part;
                }
            }
            sum
        });
        let brightness: Vec<f64> = channels[0].iter().map(|y| (y + 16.0) / 116.0).collect();
        let [across, edge, point] = &self.detectors;
        let features = [edge, point].map(|detector| {
            [
                filtered(&brightness, detector, across),
                filtered(&brightness, across, detector),
            ]
        });
        let seen = |index: usize| {
            let opponent = DVec3::from_array([0, 1, 2].map(|channel| blurred[channel][index]));
            let rgb = self.rgb_of(opponent).clamp(DVec3::ZERO, DVec3::ONE);
            let strength = |[x, y]: &[Vec<f64>; 2]| x[index].hypot(y[index]);
            Seen {
                color: self.perceived(rgb),
                features: DVec2::new(strength(&features[0]), strength(&features[1])),
            }
        };
        (0..rows.len() * width).map(seen).collect()
    }

    /// The error of a pixel.
    fn difference(&self, a: &Seen, b: &Seen) -> f64 {
        let [share, error] = KNEE;
        let knee = share * self.largest;
        let distance = hyab(a.color, b.color).powf(COLOR_EXPONENT);
        let of_color = if distance < knee {
            error / knee * distance
        } else {
            error + (distance - knee) / (self.largest - knee) * (1.0 - error)
        };
        let feature = (a.features - b.features).abs().max_element() / std::f64::consts::SQRT_2;
        of_color.powf(1.0 - feature.powf(FEATURE_EXPONENT))
    }

    /// Brightness, red against green, blue against yellow: the space `YCxCz`.
    fn opponent(&self, rgb: DVec3) -> DVec3 {
        let DVec3 { x, y, z } = XYZ_FROM_RGB * rgb / self.white;
        DVec3::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z))
    }

    /// The inverse of [`Self::opponent`].
    fn rgb_of(&self, opponent: DVec3) -> DVec3 {
        let y = (opponent.x + 16.0) / 116.0;
        let xyz = DVec3::new(y + opponent.y / 500.0, y, y - opponent.z / 200.0);
        self.rgb_from_xyz * (xyz * self.white)
    }

    /// L*a*b* with the Hunt effect: what is dark is less colourful.
    fn perceived(&self, rgb: DVec3) -> DVec3 {
        const DELTA: f64 = 6.0 / 29.0;
        let root = |t: f64| {
            if t > DELTA * DELTA * DELTA {
                t.cbrt()
            } else {
                t / (3.0 * DELTA * DELTA) + 4.0 / 29.0
            }
        };
        let DVec3 { x, y, z } = (XYZ_FROM_RGB * rgb / self.white).map(root);
        let lightness = 116.0 * y - 16.0;
        let colorful = 0.01 * lightness;
        DVec3::new(
            lightness,
            colorful * 500.0 * (x - y),
            colorful * 200.0 * (y - z),
        )
    }
}

/// The distance of colours for large differences (Abasi et al. 2020).
fn hyab(a: DVec3, b: DVec3) -> f64 {
    let difference = a - b;
    difference.x.abs() + difference.y.hypot(difference.z)
}

/// What a screen shows of a pixel, linear. One that is not finite is shown as that of the other picture, so that it does not make what the
/// eye sees around it differ.
fn shown(rgb: [f32; 3], of_other: [f32; 3]) -> DVec3 {
    let finite = [rgb, of_other].into_iter().find(|&rgb| is_finite(rgb));
    let rgb = DVec3::from_array(finite.unwrap_or_default().map(f64::from));
    rgb.clamp(DVec3::ZERO, DVec3::ONE)
}

fn whole(radius: f64) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "some ten pixels"
    )]
    let whole = radius.ceil() as usize;
    whole
}

/// The values of `f` at whole numbers from −radius to radius.
fn bell(radius: usize, f: impl Fn(f64) -> f64) -> Vec<f64> {
    let offsets = 0..=2 * radius;
    offsets.map(|i| f(i as f64 - radius as f64)).collect()
}

/// Scales positive weights to a sum of 1, and negative ones to −1.
fn balanced(weights: &[f64]) -> Vec<f64> {
    let sum = |sign: f64| {
        let of_sign = weights.iter().map(|w| (w * sign).max(0.0));
        of_sign.sum::<f64>()
    };
    let (positive, negative) = (sum(1.0), sum(-1.0));
    let scaled = |w: &f64| w / if *w > 0.0 { positive } else { negative };
    weights.iter().map(scaled).collect()
}

/// Each row, filtered; beyond its ends it goes on as it ends.
fn along_rows(values: &[f64], width: usize, weights: &[f64]) -> Vec<f64> {
    let radius = weights.len() / 2;
    let mut filtered = Vec::with_capacity(values.len());
    for row in values.chunks_exact(width) {
        filtered.extend((0..width).map(|x| {
            let terms = weights.iter().enumerate().map(|(i, weight)| {
                let place = (x + i).saturating_sub(radius).min(width - 1);
                weight * row[place]
            });
            terms.sum::<f64>()
        }));
    }
    filtered
}

/// The rows between the halos, filtered down the columns.
fn along_columns(values: &[f64], width: usize, halo: usize, weights: &[f64]) -> Vec<f64> {
    let radius = weights.len() / 2;
    let rows = values.len() / width - 2 * halo;
    let mut filtered = vec![0.0; rows * width];
    for (y, row) in filtered.chunks_exact_mut(width).enumerate() {
        for (i, weight) in weights.iter().enumerate() {
            let start = (y + halo + i - radius) * width;
            for (sum, value) in row.iter_mut().zip(&values[start..start + width]) {
                *sum += weight * value;
            }
        }
    }
    filtered
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: u32, height: u32, color: impl Fn(u32, u32) -> [f32; 3]) -> Image {
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        Image {
            width,
            height,
            pixels: places.map(|(x, y)| color(x, y)).collect(),
        }
    }

    /// The L*a*b* values of the primaries as they are tabulated, and the paper's formulas by hand: nothing is blurred, nothing has edges.
    #[test]
    fn even_pictures_differ_as_their_colors_do() {
        let lab = |l: f64, a: f64, b: f64| [l, 0.01 * l * a, 0.01 * l * b];
        let white = lab(100.0, 0.0, 0.0);
        let black = lab(0.0, 0.0, 0.0);
        let red = lab(53.24, 80.09, 67.20);
        let green = lab(87.73, -86.18, 83.18);
        let blue = lab(32.30, 79.19, -107.86);
        let distance = |p: [f64; 3], q: [f64; 3]| {
            let [l, a, b] = [0, 1, 2].map(|i| p[i] - q[i]);
            (l.abs() + (a * a + b * b).sqrt()).powf(0.7)
        };
        let largest = distance(green, blue);
        let expected = |p: [f64; 3], q: [f64; 3]| {
            let (d, knee) = (distance(p, q), 0.4 * largest);
            if d < knee {
                0.95 * d / knee
            } else {
                0.95 + 0.05 * (d - knee) / (largest - knee)
            }
        };
        let colors = [
            ([1.0, 1.0, 1.0], white),
            ([0.0, 0.0, 0.0], black),
            ([1.0, 0.0, 0.0], red),
            ([0.0, 1.0, 0.0], green),
            ([0.0, 0.0, 1.0], blue),
        ];
        for (a, lab_a) in colors {
            for (b, lab_b) in colors {
                let [a, b] = [a, b].map(|color| image(5, 40, |_, _| color));
                let found = mean_flip(&a, &b).unwrap();
                let expected = expected(lab_a, lab_b);
                // The tables give four digits.
                assert!((found - expected).abs() < 1e-3, "{found} {expected}");
            }
        }
        let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|c| image(3, 3, |_, _| c));
        assert!((mean_flip(&green, &blue).unwrap() - 1.0).abs() < 1e-9);
    }

    /// Twin: filters in two dimensions, as the paper has them, around every pixel of two noisy pictures.
    #[test]
    fn filters_along_axes_are_those_of_the_plane() {
        use std::f64::consts::PI;
        let noise = |seed: u32| {
            image(37, 41, move |x, y| {
                let hash = |c: u32| {
                    let mixed =
                        (x * 7919 + y * 104_729 + c * 31 + seed).wrapping_mul(2_654_435_761);
                    (mixed >> 8) as f32 / 16_777_216.0
                };
                [hash(0), hash(1), hash(2) * 1.2]
            })
        };
        let (a, b) = (noise(1), noise(77));
        let ppd = 67.020_643_276_582_25;
        let filters = Filters::new(ppd);
        let sample = |image: &Image, x: i64, y: i64| {
            let x = usize::try_from(x.clamp(0, 36)).unwrap();
            let y = usize::try_from(y.clamp(0, 40)).unwrap();
            let rgb = image.pixels[y * 37 + x];
            filters.opponent(shown(rgb, rgb))
        };
        let look = |image: &Image, x: i64, y: i64| {
            let offsets = || (-10..=10_i64).flat_map(|v| (-10..=10_i64).map(move |u| (u, v)));
            let channel = |index: usize| {
                let weight = |(u, v): (i64, i64)| {
                    let z = ((u * u + v * v) as f64) / (ppd * ppd);
                    let bells = BLURS[index].iter();
                    let bells = bells.map(|[a, b]| a * (PI / b).sqrt() * (-PI * PI * z / b).exp());
                    bells.sum::<f64>()
                };
                let total: f64 = offsets().map(weight).sum();
                let sum =
                    offsets().map(|(u, v)| weight((u, v)) * sample(image, x + u, y + v)[index]);
                sum.sum::<f64>() / total
            };
            let sd = 0.5 * 0.082 * ppd;
            let detect = |kind: &dyn Fn(f64) -> f64, turned: bool| {
                let weight = |(u, v): (i64, i64)| {
                    if u.abs() > 9 || v.abs() > 9 {
                        return 0.0;
                    }
                    let along = if turned { v } else { u } as f64;
                    let squared = (u * u + v * v) as f64;
                    kind(along) * (-squared / (2.0 * sd * sd)).exp()
                };
                let plus: f64 = offsets().map(weight).map(|w| w.max(0.0)).sum();
                let minus: f64 = offsets().map(weight).map(|w| (-w).max(0.0)).sum();
                let terms = offsets().map(|(u, v)| {
                    let w = weight((u, v));
                    let w = w / if w > 0.0 { plus } else { minus };
                    w * (sample(image, x + u, y + v).x + 16.0) / 116.0
                });
                terms.sum::<f64>()
            };
            let strength =
                |kind: &dyn Fn(f64) -> f64| detect(kind, false).hypot(detect(kind, true));
            let opponent = DVec3::from_array([0, 1, 2].map(channel));
            let rgb = filters.rgb_of(opponent).clamp(DVec3::ZERO, DVec3::ONE);
            Seen {
                color: filters.perceived(rgb),
                features: DVec2::new(strength(&|t| -t), strength(&|t| t * t / (sd * sd) - 1.0)),
            }
        };
        let mut sum = 0.0;
        for y in 0..41 {
            for x in 0..37 {
                sum += filters.difference(&look(&a, x, y), &look(&b, x, y));
            }
        }
        let expected = sum / (37.0 * 41.0);
        let found = mean_flip(&a, &b).unwrap();
        let cancelled = CancelToken::new();
        cancelled.cancel();
        assert_eq!(mean_flip_unless(&a, &b, &cancelled), Ok(None));
        assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        assert!(found > 0.05 && found < 0.95);
        assert_eq!(mean_flip(&b, &a).unwrap(), found, "neither is preferred");
    }

    #[test]
    fn pictures_that_look_alike_have_no_error() {
        let ramp = image(50, 3, |x, _| [x as f32 / 10.0, 0.2, 0.0]);
        let mut brighter = ramp.clone();
        for rgb in &mut brighter.pixels {
            // A screen shows nothing beyond 1.
            rgb[0] = if rgb[0] >= 1.0 { 50.0 } else { rgb[0] };
        }
        assert_eq!(mean_flip(&ramp, &brighter), Ok(0.0));
        let nothing = image(2, 2, |_, _| [f32::INFINITY; 3]);
        assert!(mean_flip(&nothing, &nothing).unwrap().is_nan());
        assert!(mean_flip(&ramp, &nothing).is_err());
    }

    /// The pictures differ farther from the bad pixels than any filter reaches: these only make one part of the mean fewer.
    #[test]
    fn pixels_that_are_not_finite_make_no_difference_around_them() {
        let halo = u32::try_from(Filters::new(PIXELS_PER_DEGREE).halo).unwrap();
        let width = 20 + 2 * halo;
        let even = image(width, 40, |_, _| [0.5, 0.2, 0.1]);
        let other = image(width, 40, |x, y| {
            [0.5, 0.2, if x == 0 && y < 9 { 0.8 } else { 0.1 }]
        });
        let whole = mean_flip(&even, &other).unwrap();
        assert!(whole > 0.0);
        let count = even.pixels.len();
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let [mut a, mut b] = [even.clone(), other.clone()];
            a.pixels[35 * width as usize - 3][1] = bad;
            b.pixels[10 * width as usize - 1][2] = bad;
            let expected = whole * count as f64 / (count - 2) as f64;
            for found in [mean_flip(&a, &b), mean_flip(&b, &a)].map(Result::unwrap) {
                assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
            }
            assert_eq!(mean_flip(&a, &even), Ok(0.0));
        }
    }
}

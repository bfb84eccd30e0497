//! Sets of rays to measure structures with: in world units as files hold them, and in prepared units as they are traced.

use crate::io::npy::RayRow;
use crate::math::{DVec3, Ray, SceneFrame, Vec3};

/// Rays that are measured together, in the world's units as files hold them and as the prepared scene meets them.
#[derive(Clone, Debug)]
pub struct RaySet {
    name: String,
    any_hit: bool,
    rows: Vec<RayRow>,
    /// Each with its largest parameter.
    rays: Vec<(Ray, f32)>,
}

/// Why a row is no ray that the scene could be asked about.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("ray {index} of \"{set}\": expected {expected}, found {found}")]
pub struct RayError {
    /// Name of the set.
    pub set: String,
    /// Number of the ray, from 0.
    pub index: usize,
    /// What would have been right.
    pub expected: &'static str,
    /// What is there instead.
    pub found: String,
}

impl RaySet {
    /// The set of `rows` (origin, direction, largest parameter, in world units), asked for any hit or for the nearest. Rays
    /// in the prepared scene keep the meaning of their parameter: their direction is scaled with the scene.
    ///
    /// # Errors
    /// The first row that is no ray, or none that `f32` can hold at the scene's scale.
    pub fn new(
        name: impl Into<String>,
        any_hit: bool,
        rows: Vec<RayRow>,
        frame: &SceneFrame,
    ) -> Result<Self, RayError> {
        let name = name.into();
        let ray = |(index, row): (usize, &RayRow)| {
            prepared(row, frame).map_err(|expected| RayError {
                set: name.clone(),
                index,
                expected,
                found: format!("{row:?}"),
            })
        };
        let rays = rows.iter().enumerate().map(ray).collect::<Result<_, _>>()?;
        Ok(Self {
            name,
            any_hit,
            rows,
            rays,
        })
    }

    /// What the set is called in reports.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether its rays ask for any hit; for the nearest otherwise.
    #[must_use]
    pub fn any_hit(&self) -> bool {
        self.any_hit
    }

    /// The rays as a file holds them.
    #[must_use]
    pub fn rows(&self) -> &[RayRow] {
        &self.rows
    }

    /// The rays in the prepared scene, each with its largest parameter.
    #[must_use]
    pub fn rays(&self) -> &[(Ray, f32)] {
        &self.rays
    }
}

/// The ray of a row in the prepared scene; what was expected where it is none.
pub(super) fn prepared(row: &RayRow, frame: &SceneFrame) -> Result<(Ray, f32), &'static str> {
    let &[ox, oy, oz, dx, dy, dz, t_max] = row;
    let (origin, direction) = (Vec3::new(ox, oy, oz), Vec3::new(dx, dy, dz));
    if !origin.is_finite() {
        return Err("a finite origin");
    }
    if !direction.is_finite() || direction == Vec3::ZERO {
        return Err("a finite direction other than zero");
    }
    if t_max.is_nan() {
        return Err("an end that is a number or infinite");
    }
    let ray = Ray::new(
        frame.narrow(origin.as_dvec3()),
        (direction.as_dvec3() * frame.scale()).as_vec3(),
    );
    if !ray.origin.is_finite() || !ray.direction.is_finite() || ray.direction == Vec3::ZERO {
        return Err("numbers that 32 bits can hold at the scene's scale");
    }
    Ok((ray, t_max))
}

/// The row of a ray that starts at a point of the world, rounded to the side of `normal` along every axis; to the nearest
/// where that is zero.
///
/// Rounding to `f32` is monotonic, there and back: a ray that starts off a surface, on the side of its normal, is not
/// moved to the other side, nor nearer along any axis.
pub(super) fn row(origin: DVec3, normal: Vec3, direction: Vec3, t_max: f32) -> RayRow {
    let nearest = origin.as_vec3();
    let rounded = |axis: usize| {
        let (exact, near) = (origin[axis], nearest[axis]);
        if normal[axis] > 0.0 && f64::from(near) < exact {
            near.next_up()
        } else if normal[axis] < 0.0 && f64::from(near) > exact {
            near.next_down()
        } else {
            near
        }
    };
    let [dx, dy, dz] = direction.to_array();
    [rounded(0), rounded(1), rounded(2), dx, dy, dz, t_max]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::DBounds;

    fn frame() -> SceneFrame {
        SceneFrame::around(&DBounds {
            min: DVec3::new(100.0, 200.0, -7.0),
            max: DVec3::new(110.0, 203.0, -1.0),
        })
    }

    #[test]
    fn a_point_of_a_ray_keeps_its_parameter() {
        let frame = frame();
        let row = [101.0, 199.0, -3.0, 0.6, 0.0, -0.8, 12.5];
        let (ray, t_max) = prepared(&row, &frame).expect("is a ray");
        assert_eq!(t_max, 12.5);
        let world = DVec3::new(101.0 + 0.6 * 4.0, 199.0, -3.0 - 0.8 * 4.0);
        assert!(ray.at(4.0).abs_diff_eq(frame.narrow(world), 1e-6));
    }

    #[test]
    fn rows_that_are_no_rays_are_named() {
        let good = [101.0, 199.0, -3.0, 0.6, 0.0, -0.8, f32::INFINITY];
        let with = |column: usize, value| {
            let mut row = good;
            row[column] = value;
            row
        };
        let mut still = good;
        still[3..6].fill(0.0);
        for (row, expected) in [
            (with(1, f32::NAN), "finite origin"),
            (with(4, f32::INFINITY), "finite direction"),
            (still, "finite direction"),
            (with(6, f32::NAN), "an end"),
        ] {
            let error = RaySet::new("mine", true, vec![good, row], &frame());
            let error = error.expect_err(expected);
            assert_eq!((error.index, &*error.set), (1, "mine"));
            assert!(error.to_string().contains(expected), "{error}");
        }
        let tiny = SceneFrame::around(&DBounds {
            min: DVec3::ZERO,
            max: DVec3::splat(1e-42),
        });
        let error = RaySet::new("mine", false, vec![good], &tiny).expect_err("too large");
        assert!(error.expected.contains("32 bits"), "{error}");
    }

    #[test]
    fn starts_are_rounded_away_from_the_surface() {
        let frame = frame();
        let normal = Vec3::new(0.6, -0.8, 0.0);
        for step in 0..1000_u16 {
            let start = Vec3::new(-0.3, 0.1, 0.2) + f32::from(step) * 1.234_567e-5;
            let world = frame.world_from_prepared(start.as_dvec3());
            let row = row(world, normal, Vec3::X, f32::INFINITY);
            let (ray, _) = prepared(&row, &frame).expect("is a ray");
            let moved = ray.origin - start;
            assert!(moved.x >= 0.0 && moved.y <= 0.0, "{step}: {moved}");
            assert!(moved.abs().max_element() < 1e-5, "{step}: {moved}");
        }
    }
}

//! What one camera sample did, ray by ray: for whoever wants to know why a pixel looks as it does.

use super::camera_samples::SampleId;
use super::kernel::Watched;
use super::prepare::{PreparedScene, Seen};
use super::stops::Stops;
use super::surface::SurfacePoint;
use super::tally::{NotedEnd, NotedRay, RayPurpose, WorkTally};
use crate::control::{CancelToken, Throttle};
use crate::math::{DVec3, Vec3};

/// A camera sample taken again, in the units of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleTrace {
    /// What it adds to its pixel: linear radiance, or a false colour.
    pub radiance: [f32; 3],
    /// Whether `render.max_bounces` ended the path where it might have brought more.
    pub is_depth_limited: bool,
    /// Every ray, in the order in which they were traced: first that from the eye.
    pub rays: Vec<TracedRay>,
}

/// A ray of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TracedRay {
    /// What it was traced for.
    pub purpose: RayPurpose,
    /// Where it starts. Camera rays start at the eye, or on the lens.
    pub origin: DVec3,
    /// Unit.
    pub direction: DVec3,
    /// How far from its origin it was traced; infinity where there is no end.
    pub reach: f64,
    /// The share of light that comes through, for rays that only ask what is in the way: to lights, and for ambient occlusion.
    pub passed: Option<[f32; 3]>,
    /// What it meets first; of rays that only ask what is in the way, the first surface.
    pub met: Met,
}

/// What a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Met {
    /// Neither surface nor visible light.
    Nothing,
    /// A visible light.
    Light {
        /// Its index in the description.
        light: usize,
        /// From the ray's origin.
        distance: f64,
        /// Where.
        position: DVec3,
    },
    /// A surface.
    Surface(MetSurface),
}

/// A point of a surface that a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetSurface {
    /// From the ray's origin.
    pub distance: f64,
    /// Index of the object in the description.
    pub object: usize,
    /// Which of its copies, from 0.
    pub copy: u32,
    /// Index of the triangle in the object's mesh.
    pub triangle: u32,
    /// Where.
    pub position: DVec3,
    /// Of the triangle, on the side that is met; unit.
    pub geometric_normal: DVec3,
    /// What shading takes for the normal; unit.
    pub shading_normal: DVec3,
    /// Whether it is met on the side from which its corners are seen counter-clockwise.
    pub front: bool,
}

/// Why a sample cannot be traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TraceError {
    /// The pixel lies outside.
    #[error("pixel {x},{y} does not lie in the {width}×{height} picture, whose last pixel is {},{}", width - 1, height - 1)]
    NoSuchPixel {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
        /// Of the picture.
        width: u32,
        /// Of the picture.
        height: u32,
    },
    /// The pixel does not get so many samples.
    #[error("sample {sample} is not taken: the last of a pixel is {}", count - 1)]
    NoSuchSample {
        /// Its index.
        sample: u32,
        /// How many a pixel gets at most.
        count: u32,
    },
}

/// Takes sample `sample`, counted from 0, of the pixel at column `x` and row `y` again, and tells all about it. It is the very
/// sample that a render takes, bit for bit. `None` when cancelled.
///
/// # Errors
/// When there is no such pixel or sample.
///
/// # Panics
/// Where the sample makes a render panic.
pub fn trace_sample(
    scene: &PreparedScene,
    (x, y): (u32, u32),
    sample: u32,
    cancel: &CancelToken,
) -> Result<Option<SampleTrace>, TraceError> {
    let settings = scene.settings();
    let (width, height) = (settings.width, settings.height);
    if x >= width || y >= height {
        return Err(TraceError::NoSuchPixel {
            x,
            y,
            width,
            height,
        });
    }
    let count = settings.samples_per_pixel;
    if sample >= count {
        return Err(TraceError::NoSuchSample { sample, count });
    }
    let scene = &scene.without_primary_hits();
    let mut tally = WorkTally::default();
    let id = SampleId {
        pixel: (x, y),
        index: sample,
    };
    let begun = scene.begin(id, &mut tally);
    let stops = Stops {
        cancel,
        halt: cancel,
        throttle: &Throttle::default(),
    };
    let Some(mut gathered) = scene.gathered::<Watched>(&begun, &stops, &mut tally) else {
        return Ok(None);
    };
    if let Some(most) = scene.clamp() {
        gathered.limit(most);
    }
    let traced = |(purpose, ray): &(RayPurpose, NotedRay)| {
        (!cancel.is_cancelled()).then(|| traced(scene, *purpose, ray))
    };
    let rays: Option<Vec<TracedRay>> = tally.kept.iter().map(traced).collect();
    let Some(mut rays) = rays else {
        return Ok(None);
    };
    // With all its digits, and from where the ray starts that is traced from near the scene on.
    let (eye, direction) = scene.line_of_sight((x, y), &begun.sampler, &mut tally);
    rays[0].origin = scene.geometry().frame().world_from_prepared(eye);
    rays[0].direction = direction;
    Ok(Some(SampleTrace {
        radiance: gathered.radiance.to_array(),
        is_depth_limited: gathered.is_depth_limited,
        rays,
    }))
}

/// A noted ray in the units of the scene.
fn traced(scene: &PreparedScene, purpose: RayPurpose, noted: &NotedRay) -> TracedRay {
    let &NotedRay {
        ray,
        start,
        reach,
        end,
    } = noted;
    let frame = scene.geometry().frame();
    let to_world = |point: Vec3| frame.world_from_prepared(point.as_dvec3());
    let length = f64::from(ray.direction.length());
    let direction = ray.direction.as_dvec3().normalize();
    let distance = |t: f32| (start + f64::from(t) * length) / frame.scale();
    let surface = |point: &SurfacePoint| {
        let object = &scene.geometry().objects()[point.object];
        let number = point.triangle - object.triangles.start;
        MetSurface {
            distance: (start + f64::from(point.distance)) / frame.scale(),
            object: point.object,
            copy: number / object.triangles_per_copy,
            triangle: number % object.triangles_per_copy,
            position: to_world(point.position),
            geometric_normal: point.geometric_normal().as_dvec3(),
            shading_normal: point.shading_normal.as_dvec3(),
            front: point.front,
        }
    };
    let (passed, met) = match end {
        // False colours look through lights.
        NotedEnd::Nearest(hit) if !scene.settings().mode.shows_light() => {
            let point = hit.map(|hit| scene.surface(&ray, &hit));
            let met = point.map_or(Met::Nothing, |point| Met::Surface(surface(&point)));
            (None, met)
        }
        NotedEnd::Nearest(hit) => {
            let met = match scene.seen(&ray, hit) {
                Seen::Background => Met::Nothing,
                Seen::Disk(disk) => Met::Light {
                    light: disk.light,
                    distance: distance(disk.t),
                    position: to_world(ray.at(disk.t)),
                },
                Seen::Surface(point) => Met::Surface(surface(&point)),
            };
            (None, met)
        }
        NotedEnd::PassesBy => (None, Met::Nothing),
        NotedEnd::Passed(share) => {
            let first = scene.surface_along(&ray, reach);
            let met = first.map_or(Met::Nothing, |point| Met::Surface(surface(&point)));
            (Some(share.to_array()), met)
        }
    };
    TracedRay {
        purpose,
        origin: to_world(ray.origin),
        direction,
        reach: distance(reach),
        passed,
        met,
    }
}

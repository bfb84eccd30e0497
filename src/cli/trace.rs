//! `raymini render --pixel`: one camera sample taken again, and everything that it did, as lines to read.

use std::fmt::{self, Display, Write};

use anyhow::Result;
use clap::Args;

use crate::control::CancelToken;
use crate::math::DVec3;
use crate::render::{
    Met, MetSurface, PreparedScene, RayPurpose, SampleTrace, TracedRay, trace_sample,
};
use crate::scene::{RenderSettings, Scene};

/// What `raymini render` takes to look at one sample.
#[derive(Debug, Default, Args)]
pub struct TraceArguments {
    /// Print every ray of one camera sample of this pixel, from 0,0 at the top left, and render nothing
    #[arg(
        long,
        value_name = "X,Y",
        allow_hyphen_values = true,
        value_parser = super::values::pixel,
        conflicts_with_all = ["output", "stats", "region", "checkpoint", "costs"]
    )]
    pub pixel: Option<(u32, u32)>,

    /// Which sample, from 0
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0,
        allow_hyphen_values = true,
        value_parser = super::values::whole(0..=RenderSettings::MAX_SAMPLES - 1),
        requires = "pixel",
        conflicts_with = "output"
    )]
    sample: u32,
}

impl TraceArguments {
    /// Prints the sample of `pixel`.
    pub fn print(&self, scene: &Scene, prepared: &PreparedScene, pixel: (u32, u32)) -> Result<()> {
        let trace = trace_sample(prepared, pixel, self.sample, &CancelToken::new())?;
        let trace = trace.expect("nobody cancels");
        let (x, y) = pixel;
        let (trace, sample) = (
            InWords {
                scene,
                trace: &trace,
            },
            self.sample,
        );
        super::say(&format!("pixel {x},{y}, sample {sample}\n{trace}"))
    }
}

/// A sample as lines.
struct InWords<'a> {
    scene: &'a Scene,
    trace: &'a SampleTrace,
}

impl Display for InWords<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rays = &self.trace.rays;
        for (number, ray) in (1..).zip(rays) {
            self.write_ray(f, number, ray)?;
        }
        let count = |purpose| rays.iter().filter(|ray| ray.purpose == purpose).count();
        write!(f, "rays")?;
        for purpose in RayPurpose::ALL {
            write!(f, " {} {},", count(purpose), purpose.name())?;
        }
        writeln!(f, " {} in all", rays.len())?;
        if self.trace.is_depth_limited {
            writeln!(f, "render.max_bounces ended the path")?;
        }
        let [r, g, b] = self.trace.radiance;
        write!(f, "radiance {r:?} {g:?} {b:?}")
    }
}

impl InWords<'_> {
    fn write_ray(&self, f: &mut impl Write, number: u32, ray: &TracedRay) -> fmt::Result {
        writeln!(f, "{number} {} ray", ray.purpose.name())?;
        writeln!(f, "  origin {}", vector(ray.origin))?;
        writeln!(f, "  direction {}", vector(ray.direction))?;
        if ray.reach.is_finite() {
            writeln!(f, "  reach {:?}", ray.reach)?;
        }
        if let Some([r, g, b]) = ray.passed {
            writeln!(f, "  passed {r:?} {g:?} {b:?}")?;
        }
        match ray.met {
            Met::Nothing => writeln!(f, "  meets nothing"),
            Met::Light {
                light,
                distance,
                position,
            } => {
                writeln!(f, "  meets lights.{light}")?;
                writeln!(f, "  distance {distance:?}")?;
                writeln!(f, "  position {}", vector(position))
            }
            Met::Surface(surface) => self.write_surface(f, &surface),
        }
    }

    fn write_surface(&self, f: &mut impl Write, surface: &MetSurface) -> fmt::Result {
        let object = &self.scene.objects[surface.object];
        let side = if surface.front { "front" } else { "back" };
        let material = object.material.as_deref().unwrap_or("the default");
        writeln!(
            f,
            "  meets objects.{} {:?}, copy {}, triangle {}, on its {side}; material {material:?}",
            surface.object, object.name, surface.copy, surface.triangle
        )?;
        writeln!(f, "  distance {:?}", surface.distance)?;
        writeln!(f, "  position {}", vector(surface.position))?;
        writeln!(f, "  geometric normal {}", vector(surface.geometric_normal))?;
        writeln!(f, "  shading normal {}", vector(surface.shading_normal))
    }
}

/// With all the digits that tell it from its neighbours.
fn vector(v: DVec3) -> String {
    format!("{:?} {:?} {:?}", v.x, v.y, v.z)
}

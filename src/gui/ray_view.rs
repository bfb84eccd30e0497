//! The rays of one camera sample as lines in the preview, which may look at them from anywhere.

use egui::{Color32, Pos2, Rect, Shape, Stroke, Ui, Vec2};

use super::event::Event;
use super::jobs::Job;
use super::orbit;
use super::viewport::picture_size;
use super::widgets::{counted, format_number};
use crate::math::{DVec2, DVec3};
use crate::render::{Met, PreparedScene, RayPurpose, SampleTrace, TracedRay, trace_sample};
use crate::scene::{Camera, Scene};

/// Most rays that are drawn; all are counted.
const MOST: usize = 2000;
/// What is drawn of a ray that meets nothing, as a share of the scene's diagonal.
const FREE_LENGTH: f64 = 0.4;

/// A sample whose rays are wanted.
#[derive(Clone, Debug)]
pub struct WantedRays {
    /// Column and row from the top left, from 0.
    pub pixel: [u32; 2],
    /// Which of its samples, from 0.
    pub sample: u32,
    /// What is rendered.
    pub scene: Scene,
    /// The scene as it was being edited then: the rays are shown as long as it stays so.
    pub edited: Scene,
}

impl WantedRays {
    /// The first sample of the pixel of `scene` at `place`, a share of the picture's width and height.
    #[must_use]
    pub fn at(place: DVec2, scene: Scene, edited: Scene) -> Self {
        let pixel = |share: f64, side: u32| {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a share of the side; what lies outside is the edge"
            )]
            let pixel = (share * f64::from(side)) as u32;
            pixel.min(side.saturating_sub(1))
        };
        let settings = &scene.render;
        Self {
            pixel: [
                pixel(place.x, settings.width),
                pixel(place.y, settings.height),
            ],
            sample: 0,
            scene,
            edited,
        }
    }

    /// The sample of the same pixel `step` after this one; `None` where there is none.
    #[must_use]
    pub fn of_other_sample(&self, step: i64) -> Option<Self> {
        let sample = u32::try_from(i64::from(self.sample) + step).ok()?;
        (sample < self.scene.render.samples_per_pixel).then(|| Self {
            sample,
            ..self.clone()
        })
    }

    /// Traces and sends the rays, with what is `known` of the same geometry.
    pub fn trace(self, known: Option<&PreparedScene>, job: &Job<Event>) {
        let prepared = PreparedScene::prepare(&self.scene, known, &job.cancel);
        let [x, y] = self.pixel;
        let result = match prepared {
            Ok(None) => return,
            Ok(Some(prepared)) => match trace_sample(&prepared, (x, y), self.sample, &job.cancel) {
                Ok(None) => return,
                Ok(Some(trace)) => Ok(trace),
                Err(error) => Err(error.to_string()),
            },
            Err(error) => Err(error.to_string()),
        };
        let wanted = Box::new(self);
        job.send(Event::Traced { wanted, result });
    }
}

/// The rays of a sample.
#[derive(Debug)]
pub struct RayView {
    /// Of which one.
    pub wanted: WantedRays,
    trace: SampleTrace,
    lines: Vec<Line>,
}

/// A ray in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Line {
    ends: [DVec3; 2],
    kind: Kind,
}

/// How a ray is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Camera,
    Bounce,
    /// To a light, which is seen.
    Lit,
    /// To the sky: off a surface and on to nothing, or into the hemisphere where nothing is near.
    Free,
    /// To a light or into the hemisphere, with something in the way.
    Blocked,
}

impl Kind {
    fn of(ray: &TracedRay) -> Self {
        let passes = ray.passed.is_none_or(|passed| passed != [0.0; 3]);
        match ray.purpose {
            RayPurpose::Camera => Self::Camera,
            RayPurpose::Bounce => match ray.met {
                Met::Nothing => Self::Free,
                Met::Light { .. } => Self::Lit,
                Met::Surface(_) => Self::Bounce,
            },
            _ if !passes => Self::Blocked,
            RayPurpose::Shadow => Self::Lit,
            RayPurpose::AmbientOcclusion => Self::Free,
        }
    }

    /// What sets it off from what is behind it: white from a pale ground most.
    fn outline(self) -> Stroke {
        let alpha = if self == Self::Camera { 230 } else { 110 };
        Stroke::new(3.6, Color32::from_black_alpha(alpha))
    }

    fn color(self) -> Color32 {
        match self {
            Self::Camera => Color32::from_rgb(0xff, 0xff, 0xff),
            Self::Bounce => Color32::from_rgb(0x5c, 0xb8, 0xff),
            Self::Lit => Color32::from_rgb(0xff, 0xd0, 0x40),
            Self::Free => Color32::from_rgb(0x7c, 0xe0, 0x90),
            Self::Blocked => Color32::from_rgb(0xe0, 0x48, 0x40),
        }
    }
}

impl RayView {
    /// The rays of `trace`, as they are drawn.
    #[must_use]
    pub fn new(wanted: WantedRays, trace: SampleTrace) -> Self {
        let diagonal = wanted.scene.bounds().diagonal();
        let lines = trace.rays.iter().take(MOST).map(|ray| Line {
            ends: [ray.origin, end_of(ray, diagonal * FREE_LENGTH)],
            kind: Kind::of(ray),
        });
        let lines = lines.collect();
        Self {
            wanted,
            trace,
            lines,
        }
    }

    /// What there is to say of them, in lines.
    #[must_use]
    pub fn in_words(&self) -> Vec<String> {
        let WantedRays {
            pixel: [x, y],
            sample,
            scene,
            ..
        } = &self.wanted;
        let rays = &self.trace.rays;
        let count = |purpose| rays.iter().filter(|ray| ray.purpose == purpose).count();
        let counts = RayPurpose::ALL.iter().filter_map(|&purpose| {
            let count = count(purpose);
            (count > 0).then(|| format!("{count} {}", purpose.name()))
        });
        let counts: Vec<String> = counts.collect();
        let radiance = self.trace.radiance;
        let radiance = radiance.map(|channel| format_number(channel.into(), 4));
        let mut lines = vec![
            format!(
                "Pixel {x}, {y}  ·  sample {sample} of {}  ·  linear {}",
                scene.render.samples_per_pixel,
                radiance.join(" ")
            ),
            format!(
                "{}: {}",
                counted(rays.len(), "ray", "rays"),
                counts.join(", ")
            ),
            "White from the eye, blue bounces, yellow reaches a light, green the sky, red is blocked".to_owned(),
            "Drag to look from elsewhere  ·  , and . change the sample".to_owned(),
        ];
        if self.trace.is_depth_limited {
            lines.insert(2, "The path ended at the most bounces".to_owned());
        }
        if rays.len() > MOST {
            lines.insert(2, format!("The first {MOST} are drawn"));
        }
        lines
    }

    /// Draws them into `frame`, which `camera` sees.
    pub fn rays_ui(&self, ui: &Ui, frame: Rect, camera: &Camera) {
        let painter = ui.painter().with_clip_rect(frame);
        let size = picture_size(frame);
        for line in &self.lines {
            let [from, to] = line.ends;
            let Some(ends) = orbit::project_line(camera, size, from, to) else {
                continue;
            };
            let ends = ends.map(|end| on_screen(frame, end));
            let color = line.kind.color();
            painter.line_segment(ends, line.kind.outline());
            if line.kind == Kind::Blocked {
                let stroke = Stroke::new(1.4, color);
                painter.extend(Shape::dashed_line(&ends, stroke, 5.0, 4.0));
            } else {
                painter.line_segment(ends, Stroke::new(1.6, color));
            }
        }
        // Where rays begin: the eye, and the points of surfaces.
        let mut places: Vec<DVec3> = self.lines.iter().map(|line| line.ends[0]).collect();
        places.dedup();
        for place in places {
            if let Some((position, _)) = orbit::project(camera, size, place) {
                let center = on_screen(frame, position);
                painter.circle(
                    center,
                    3.2,
                    Color32::WHITE,
                    Stroke::new(1.2, Color32::BLACK),
                );
            }
        }
    }
}

/// Where what is drawn of a ray ends: at what it meets, or where it no longer looks, or after `free` where there is neither.
fn end_of(ray: &TracedRay, free: f64) -> DVec3 {
    match ray.met {
        Met::Surface(surface) => surface.position,
        Met::Light { position, .. } => position,
        Met::Nothing if ray.reach.is_finite() => ray.origin + ray.direction * ray.reach,
        Met::Nothing => ray.origin + ray.direction * free,
    }
}

#[expect(clippy::cast_possible_truncation, reason = "screen positions are f32")]
fn on_screen(frame: Rect, point: DVec2) -> Pos2 {
    // Far outside, as numbers that are drawn without surprise.
    let point = point.clamp(DVec2::splat(-1e5), DVec2::splat(1e5));
    frame.min + Vec2::new(point.x as f32, point.y as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::CancelToken;
    use crate::io;
    use crate::scene::Light;

    fn view(sample: u32) -> RayView {
        let mut scene = io::demo_scene();
        (scene.render.width, scene.render.height) = (96, 54);
        let mut wanted = WantedRays::at(DVec2::new(0.5, 0.55), scene.clone(), scene.clone());
        assert_eq!(wanted.pixel, [48, 29]);
        wanted.sample = sample;
        let prepared = PreparedScene::prepare(&scene, None, &CancelToken::new());
        let prepared = prepared.unwrap().unwrap();
        let trace = trace_sample(&prepared, (48, 29), sample, &CancelToken::new());
        RayView::new(wanted, trace.unwrap().expect("nobody cancels"))
    }

    /// The rays hang together: each begins where the one from the eye ends, and those that reach a light end there.
    #[test]
    fn lines_go_from_the_eye_over_the_surface_to_the_lights() {
        let view = view(3);
        let scene = &view.wanted.scene;
        let [first, others @ ..] = view.lines.as_slice() else {
            panic!("there are rays");
        };
        assert_eq!(first.kind, Kind::Camera);
        assert!(first.ends[0].distance(scene.camera.eye) < 1e-5);
        // Lights behind the surface get none.
        assert!(!others.is_empty() && others.len() <= scene.lights.len());
        let mut lit = 0;
        for line in others {
            assert!(line.ends[0].distance(first.ends[1]) < 1e-3);
            if line.kind == Kind::Lit {
                lit += 1;
                let near = scene.lights.iter().map(Light::position);
                let nearest = near.map(|light| light.distance(line.ends[1]));
                assert!(nearest.fold(f64::INFINITY, f64::min) < 1e-3);
            } else {
                assert_eq!(line.kind, Kind::Blocked);
            }
        }
        assert!(lit > 0);
        let words = view.in_words().join(" ");
        assert!(words.contains("Pixel 48, 29  ·  sample 3 of 16"), "{words}");
        let counts = format!(
            "{} rays: 1 camera, {} shadow",
            others.len() + 1,
            others.len()
        );
        assert!(words.contains(&counts), "{words}");
    }

    /// As the legend says.
    #[test]
    fn rays_to_the_sky_are_green_wherever_they_come_from() {
        let ray = |purpose, met| TracedRay {
            origin: DVec3::ZERO,
            direction: DVec3::Z,
            reach: f64::INFINITY,
            purpose,
            passed: None,
            met,
        };
        let color = |purpose, met| Kind::of(&ray(purpose, met)).color();
        let green = color(RayPurpose::AmbientOcclusion, Met::Nothing);
        assert!(green.g() > green.r() && green.g() > green.b());
        assert_eq!(color(RayPurpose::Bounce, Met::Nothing), green);
        let light = Met::Light {
            light: 0,
            distance: 1.0,
            position: DVec3::Z,
        };
        let yellow = color(RayPurpose::Bounce, light);
        assert!(yellow.r() > yellow.b() && yellow.g() > yellow.b());
        assert_eq!(color(RayPurpose::Camera, Met::Nothing), Color32::WHITE);
    }

    #[test]
    fn samples_end_at_the_first_and_the_last() {
        let wanted = view(0).wanted;
        assert!(wanted.of_other_sample(-1).is_none());
        assert!(wanted.of_other_sample(16).is_none());
        assert_eq!(wanted.of_other_sample(15).unwrap().sample, 15);
    }
}

//! The settings of the picture that a render follows: size, samples and structure, and effects.

use egui::Ui;

use super::PanelState;
use crate::analysis::contributions::Contributor;
use crate::analysis::cost::Effect;
use crate::gui::contributions::Contributions;
use crate::gui::costs::{self, EffectCosts};
use crate::gui::threads::{Threads, cores};
use crate::gui::widgets::{
    Number, choice_row_ui, combo_row_ui, counted, integer_row_ui, number_row_ui,
    optional_number_row_ui, row_ui, switch_row_ui,
};
use crate::scene::{
    AcceleratorBuild, AcceleratorChoice, Choice, Filter, LightSampling, Mode, PhongModel,
    RenderSettings, SamplerChoice, Shadows,
};

/// Picture sizes on offer.
const SIZES: [(u32, u32, &str); 7] = [
    (320, 240, "Draft"),
    (640, 480, "VGA"),
    (960, 540, "Quarter HD"),
    (1280, 720, "HD"),
    (1920, 1080, "Full HD"),
    (3840, 2160, "4K"),
    (1024, 1024, "Square"),
];

/// The structure that rays look for triangles in.
#[derive(Clone, Copy, Debug)]
pub struct StructureInUse {
    /// As people write it.
    pub name: &'static str,
    /// Its memory.
    pub bytes: usize,
}

/// Size, samples, and how to run.
pub fn image_ui(ui: &mut Ui, state: &mut PanelState<'_>) {
    let costs = state.costs.of_effects(state.scene);
    let settings = &mut state.scene.render;
    combo_row_ui(
        ui,
        "Mode",
        "What a pixel of the picture holds",
        &mut settings.mode,
        &Mode::ALL
            .iter()
            .map(|(mode, _)| (*mode, mode_name(*mode).to_owned()))
            .collect::<Vec<_>>(),
    );
    size_ui(ui, settings);
    integer_row_ui(
        ui,
        "Samples",
        "Camera rays per pixel: more give smoother edges and take longer. Where the render is to stop at a noise or after a time, it is \
         the most a pixel gets",
        &mut settings.samples_per_pixel,
        1..=RenderSettings::MAX_SAMPLES,
        0.2,
    );
    stop_ui(ui, settings, costs);
    integer_row_ui(
        ui,
        "Seed",
        "Start of the random numbers: the same seed gives the same picture, bit for bit",
        &mut settings.seed,
        0..=RenderSettings::MAX_SEED,
        0.1,
    );
    state.region.panel_ui(ui, [settings.width, settings.height]);
    threads_ui(ui, state.threads);
    structure_ui(ui, settings, state.structure);
}

fn threads_ui(ui: &mut Ui, threads: &mut Threads) {
    let cores = cores();
    let mut choices = vec![(Threads::All, format!("All cores ({cores})"))];
    if cores > 1 {
        let text = "All, one left to you".to_owned();
        choices.insert(0, (Threads::Courteous, text));
    } else if *threads == Threads::Courteous {
        *threads = Threads::All;
    }
    choices.extend((1..=cores).map(|count| (Threads::Fixed(count), count.to_string())));
    combo_row_ui(
        ui,
        "Threads",
        "Processor cores that render; the picture does not depend on it. One is left free while you use mouse or keys in the window, and half a second longer, where that is chosen",
        threads,
        &choices,
    );
}

/// Fewer samples than this may well not be enough for a noise that is asked for.
const FEW_SAMPLES: u32 = 256;

/// When a render ends before every pixel has its samples, and what that takes.
fn stop_ui(ui: &mut Ui, settings: &mut RenderSettings, costs: EffectCosts<'_>) {
    let stop = &mut settings.stop;
    optional_number_row_ui(
        ui,
        ["Stop at noise", "Noise to stop at"],
        "End the render as soon as the noise is down to this, in percent of the picture's brightness: 10 % is grainy, 3 % fair, 1 % \
         clean. It is estimated while rendering",
        &mut stop.noise,
        [0.03, 100.0],
        &Number::within(0.01..=1000.0, 0.02).with_suffix(" %"),
    );
    // A stop at a noise needs to know the noise.
    settings.error_estimate |= stop.noise.is_some();
    if stop.noise.is_some() && settings.samples_per_pixel < FEW_SAMPLES {
        let samples = counted(settings.samples_per_pixel as usize, "sample", "samples");
        let text = format!("A pixel gets {samples} at most: if they do not reach it, allow more");
        ui.label(egui::RichText::new(text).weak().small());
    }
    optional_number_row_ui(
        ui,
        ["Stop after", "Time to stop after"],
        "End the render after this time of rendering, in seconds",
        &mut stop.seconds,
        [10.0, 1.0],
        &Number::within(0.01..=1e7, 0.1).with_suffix(" s"),
    );
    if let Some(passes) = stop.passes {
        let mut is_on = true;
        let label = "Stop at pass";
        let tooltip = "The scene file ends the render after so many passes, to give a picture again that the clock ended";
        ui.horizontal(|ui| {
            switch_row_ui(ui, label, tooltip, &mut is_on);
            ui.weak(passes.to_string());
        });
        stop.passes = stop.passes.filter(|_| is_on);
    }
    let may_stop = stop.noise.is_some() || stop.seconds.is_some();
    if may_stop && settings.error_estimate {
        ui.horizontal(|ui| {
            switch_row_ui(
                ui,
                "Adaptive",
                "Give more samples to the pixels that are still noisy, and none to those that are done; off gives all pixels the \
                 same number",
                &mut settings.adaptive,
            );
            let text = egui::RichText::new("samples where the error is");
            let text = text.weak().small();
            ui.add(egui::Label::new(text).truncate());
        });
    }
    ui.add_enabled_ui(settings.stop.noise.is_none(), |ui| {
        costs::beside_ui(ui, costs.of(Effect::ErrorEstimate), |ui| {
            let meaning = "Estimate while rendering how far the picture is from the truth: for the noise in the status bar, the error \
                           plot and the error layer. It takes 40 bytes per pixel and changes no pixel of a render that does not stop early";
            let tooltip = costs.tooltip(ui.ctx(), meaning);
            switch_row_ui(
                ui,
                "Estimate error",
                &tooltip,
                &mut settings.error_estimate,
            )
            .on_disabled_hover_text("Stop at noise needs it: switch that off first");
        });
    });
}

fn structure_ui(ui: &mut Ui, settings: &mut RenderSettings, structure: Option<StructureInUse>) {
    combo_row_ui(
        ui,
        "Structure",
        "What rays look for triangles in; the picture does not depend on it. Auto takes the wide tree: on meshes about twice as fast as the \
         kd-tree, in less memory, and sooner built. On soups, where very many triangles overlap, the kd-tree may be up to three times as fast",
        &mut settings.accelerator,
        &AcceleratorChoice::ALL
            .iter()
            .map(|(choice, _)| (*choice, structure_name(*choice).to_owned()))
            .collect::<Vec<_>>(),
    );
    if matches!(
        settings.accelerator,
        AcceleratorChoice::Auto | AcceleratorChoice::Wide
    ) {
        choice_row_ui(
            ui,
            "Tree",
            "How carefully the tree is built; the picture does not depend on it",
            &mut settings.accelerator_build,
            |build| match build {
                AcceleratorBuild::Best => ("Best", "The fastest rays"),
                AcceleratorBuild::Fast => ("Fast", "The fastest edits: the tree is there sooner"),
            },
        );
    }
    // There all the time, so that what is below keeps its place.
    row_ui(
        ui,
        "In use",
        "The structure that was built, and its memory",
        |ui| {
            ui.weak(match structure {
                Some(StructureInUse { name, bytes }) => format!("{name}, {}", memory(bytes)),
                None => "none is built yet".to_owned(),
            })
        },
    );
}

fn structure_name(choice: AcceleratorChoice) -> &'static str {
    match choice {
        AcceleratorChoice::Auto => "Auto",
        AcceleratorChoice::Wide => "Wide tree",
        AcceleratorChoice::KdTree => "kd-tree",
        AcceleratorChoice::BruteForce => "Every triangle",
    }
}

/// So many bytes in a unit that fits.
fn memory(bytes: usize) -> String {
    let bytes = bytes as f64;
    if bytes < 1e6 {
        format!("{:.0} kB", bytes / 1e3)
    } else {
        format!("{:.1} MB", bytes / 1e6)
    }
}

fn size_ui(ui: &mut Ui, settings: &mut RenderSettings) {
    let size = (settings.width, settings.height);
    let name = SIZES
        .iter()
        .find(|(width, height, _)| (*width, *height) == size)
        .map_or("Custom", |(_, _, name)| name);
    row_ui(ui, "Preset", "Usual picture sizes, in pixels", |ui| {
        egui::ComboBox::from_id_salt("picture size")
            .selected_text(name)
            .width(ui.available_width())
            .show_ui(ui, |ui| {
                for (width, height, name) in SIZES {
                    let text = format!("{name}  {width} × {height}");
                    if ui.selectable_label((width, height) == size, text).clicked() {
                        (settings.width, settings.height) = (width, height);
                    }
                }
            })
            .response
    });
    let before = (settings.width, settings.height);
    let sides = 1..=RenderSettings::MAX_SIDE;
    let pixels = |ui: &mut Ui, label, tooltip, side: &mut u32| {
        integer_row_ui(ui, label, tooltip, side, sides.clone(), 1.0);
    };
    pixels(ui, "Width", "Picture width, in pixels", &mut settings.width);
    pixels(
        ui,
        "Height",
        "Picture height, in pixels",
        &mut settings.height,
    );
    if settings.pixel_count() > RenderSettings::MAX_PIXELS {
        (settings.width, settings.height) = before;
    }
}

/// What is known of effects, for what is drawn beside their switches.
struct Known<'a> {
    contributions: &'a mut Contributions,
    costs: EffectCosts<'a>,
}

impl Known<'_> {
    /// A row of the panel with what `effect` brings and takes at its right. The row gets its tooltip, which means `meaning`.
    fn beside_ui(
        &mut self,
        ui: &mut Ui,
        effect: Effect,
        meaning: &str,
        row: impl FnOnce(&mut Ui, &str),
    ) {
        let tooltip = self.costs.tooltip(ui.ctx(), meaning);
        let (contributor, cost) = (Contributor::Effect(effect), self.costs.of(effect));
        self.contributions
            .beside_ui(ui, &contributor, cost, |ui| row(ui, &tooltip));
    }

    /// A row that says what `effect` brings and takes, where it does.
    fn row_ui(&mut self, ui: &mut Ui, effect: Effect, text: &str) {
        let (contributor, cost) = (Contributor::Effect(effect), self.costs.of(effect));
        self.contributions.row_ui(ui, &contributor, cost, text);
    }
}

/// What the picture leaves out or adds, each a switch of its own, with what it brings and what it takes of the time beside it.
pub fn effects_ui(ui: &mut Ui, state: &mut PanelState<'_>) {
    let known = &mut Known {
        contributions: &mut *state.contributions,
        costs: state.costs.of_effects(state.scene),
    };
    let settings = &mut state.scene.render;
    match settings.mode {
        Mode::Direct => {
            shadows_ui(ui, settings, known);
            occlusion_ui(ui, settings, known);
            phong_ui(ui, settings);
        }
        Mode::Path => path_ui(ui, settings, known),
        Mode::Ao => occlusion_rays_ui(ui, settings),
        _ => {}
    }
    sampler_ui(ui, settings);
    if settings.mode.shows_light() {
        scattering_ui(ui, settings, known);
        clamp_ui(ui, settings);
    }
    let meaning =
        "Whether the lens blurs what is out of focus; it needs a lens radius above 0 at the camera";
    known.beside_ui(ui, Effect::DepthOfField, meaning, |ui, tooltip| {
        switch_row_ui(ui, "Depth of field", tooltip, &mut settings.depth_of_field);
    });
    let meaning = "Spread the samples over each pixel for smooth edges; off puts all at its centre";
    known.beside_ui(ui, Effect::Antialiasing, meaning, |ui, tooltip| {
        switch_row_ui(ui, "Anti-aliasing", tooltip, &mut settings.antialiasing);
    });
    antialiasing_ui(ui, settings);
    if settings.mode.shows_light() {
        contributions_switch_ui(ui, known.contributions);
    }
}

/// Where light goes on from surfaces.
fn scattering_ui(ui: &mut Ui, settings: &mut RenderSettings, known: &mut Known<'_>) {
    let meaning = "Whether mirrors reflect; grey otherwise";
    known.beside_ui(ui, Effect::Mirrors, meaning, |ui, tooltip| {
        switch_row_ui(ui, "Mirror", tooltip, &mut settings.mirror);
    });
    let meaning = "Whether glass reflects and refracts; grey otherwise";
    known.beside_ui(ui, Effect::Glass, meaning, |ui, tooltip| {
        switch_row_ui(ui, "Glass", tooltip, &mut settings.glass);
    });
    let meaning = "Most times light is scattered on its way: 1 is direct light, each mirror or side of glass takes one more";
    known.beside_ui(ui, Effect::IndirectLight, meaning, |ui, tooltip| {
        integer_row_ui(
            ui,
            "Bounces",
            tooltip,
            &mut settings.max_bounces,
            0..=RenderSettings::MAX_BOUNCES,
            0.1,
        );
    });
}

fn contributions_switch_ui(ui: &mut Ui, contributions: &mut Contributions) {
    let mut is_on = contributions.is_on();
    switch_row_ui(
        ui,
        "Contributions",
        "Show beside each effect and light what it brings: the picture with it minus the picture without, rendered small when nothing \
         else is rendered and you rest. It changes no picture",
        &mut is_on,
    );
    contributions.set_on(is_on);
}

fn antialiasing_ui(ui: &mut Ui, settings: &mut RenderSettings) {
    if settings.antialiasing {
        choice_row_ui(
            ui,
            "Pixel filter",
            "How samples spread over and around the pixel",
            &mut settings.filter,
            |filter| match filter {
                Filter::Box => ("Box", "Even over the pixel"),
                Filter::Tent => ("Tent", "Falling off to the middle of the neighbours"),
                Filter::Gaussian => ("Gauss", "A soft bell, the smoothest"),
            },
        );
    }
}

fn shadows_ui(ui: &mut Ui, settings: &mut RenderSettings, known: &mut Known<'_>) {
    let meaning = "How lights cast shadows; those of point lights are hard either way";
    choice_row_ui(
        ui,
        "Shadows",
        &known.costs.tooltip(ui.ctx(), meaning),
        &mut settings.shadows,
        |shadows| match shadows {
            Shadows::Off => ("Off", "Light passes through everything"),
            Shadows::Hard => ("Hard", "As if each light shone from its centre"),
            Shadows::Soft => ("Soft", "From the whole of each light"),
            Shadows::Fraction => (
                "2011",
                "The rule of 2011: what each light's centre would give, times the share of the light that is seen; darker \
                 or brighter than the truth where that share changes",
            ),
        },
    );
    if matches!(settings.shadows, Shadows::Soft | Shadows::Fraction) {
        integer_row_ui(
            ui,
            "Shadow rays",
            "Rays to each light with a size, per sample",
            &mut settings.shadow_samples,
            1..=RenderSettings::MAX_RAYS_PER_SAMPLE,
            0.1,
        );
    }
    known.row_ui(ui, Effect::Shadows, "With shadows");
    known.row_ui(ui, Effect::SoftShadows, "Soft in place of hard");
}

fn occlusion_ui(ui: &mut Ui, settings: &mut RenderSettings, known: &mut Known<'_>) {
    let meaning = "Ambient occlusion: the background's light is kept off where surfaces are near";
    known.beside_ui(ui, Effect::AmbientOcclusion, meaning, |ui, tooltip| {
        let is_on = &mut settings.ambient_occlusion.enabled;
        switch_row_ui(ui, "Occlusion", tooltip, is_on);
    });
    if settings.ambient_occlusion.enabled {
        occlusion_rays_ui(ui, settings);
    }
}

fn occlusion_rays_ui(ui: &mut Ui, settings: &mut RenderSettings) {
    let occlusion = &mut settings.ambient_occlusion;
    integer_row_ui(
        ui,
        "Occlusion rays",
        "Rays into the hemisphere, per sample",
        &mut occlusion.samples,
        1..=RenderSettings::MAX_RAYS_PER_SAMPLE,
        0.2,
    );
    let mut percent = occlusion.radius * 100.0;
    let number = Number::within(1e-3..=1e4, 0.1).with_suffix(" %");
    let response = number_row_ui(
        ui,
        "Occlusion reach",
        "How near a surface must be, in percent of the scene's diagonal",
        &mut percent,
        &number,
    );
    // There and back, some numbers change by rounding.
    if response.changed() {
        occlusion.radius = percent / 100.0;
    }
}

fn phong_ui(ui: &mut Ui, settings: &mut RenderSettings) {
    choice_row_ui(
        ui,
        "Phong model",
        "Which formula shades highlights",
        &mut settings.phong,
        |model| match model {
            PhongModel::Modified => (
                "Modified",
                "Physically based: reflects no more light than arrives",
            ),
            PhongModel::Classic => (
                "Classic",
                "The formula of 2011, brighter by a factor of about 3",
            ),
        },
    );
}

fn path_ui(ui: &mut Ui, settings: &mut RenderSettings, known: &mut Known<'_>) {
    // Only this formula keeps energy when light bounces.
    settings.phong = PhongModel::Modified;
    choice_row_ui(
        ui,
        "Light search",
        "How paths find light: all ways find the same, with different noise",
        &mut settings.light_sampling,
        |way| match way {
            LightSampling::Mis => (
                "Both",
                "Aiming and meeting, weighted by how likely each was (MIS)",
            ),
            LightSampling::Nee => ("Aim", "Aiming at lights (NEE)"),
            LightSampling::Bsdf => ("Meet", "Scattering, and meeting lights by chance"),
        },
    );
    let meaning = "Let paths that carry little end at random, without bias; off follows each to the last bounce";
    known.beside_ui(ui, Effect::Roulette, meaning, |ui, tooltip| {
        switch_row_ui(ui, "Roulette", tooltip, &mut settings.roulette);
    });
}

fn sampler_ui(ui: &mut Ui, settings: &mut RenderSettings) {
    choice_row_ui(
        ui,
        "Sampler",
        "How the random numbers of a pixel are spread: both ways lead to the same picture, with different noise",
        &mut settings.sampler,
        |sampler| match sampler {
            SamplerChoice::Sobol => (
                "Sobol",
                "Evenly, as a scrambled Sobol sequence: noise falls fastest",
            ),
            SamplerChoice::Independent => (
                "Independent",
                "Each without regard to the others, the plainest way: more noise in the same time. To compare with",
            ),
        },
    );
}

/// A limit on what one sample may bring, off by default.
fn clamp_ui(ui: &mut Ui, settings: &mut RenderSettings) {
    const UNIT: &str = " W/m²/sr";
    let mut is_on = settings.clamp.is_some();
    switch_row_ui(
        ui,
        "Clamp",
        "Limit what one sample may bring: bright specks go, and some of the light with them; how much is reported",
        &mut is_on,
    );
    if !is_on {
        settings.clamp = None;
        return;
    }
    let mut most = settings.clamp.unwrap_or(10.0);
    number_row_ui(
        ui,
        "Clamp at",
        "The most radiance of a sample in its brightest channel, in watts per square metre and steradian",
        &mut most,
        &Number::within(f64::MIN_POSITIVE..=f64::MAX, 0.1).with_suffix(UNIT),
    );
    settings.clamp = Some(most);
}

/// What a mode is called on screen.
fn mode_name(mode: Mode) -> &'static str {
    match mode {
        Mode::Direct => "Direct light",
        Mode::Path => "All light (path tracing)",
        Mode::Ao => "Ambient occlusion",
        Mode::Normals => "Surface normals",
        Mode::Depth => "Distance from the eye",
        Mode::Albedo => "Reflectance",
        Mode::Facing => "Front and back sides",
        Mode::Object => "Objects by colour",
        Mode::Steps => "Steps through the structure",
    }
}

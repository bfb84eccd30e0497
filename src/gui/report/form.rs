//! What the user wants measured. Fields that were not touched follow the scene.

use std::path::{Path, PathBuf};

use egui::{Align, Button, Layout, Response, RichText, TextEdit, Ui};

use super::Subject;
use crate::analysis::report::{
    ComparisonError, REPORT_FILES, ReferenceOptions, ReportError, ReportOptions, parse_radiance,
};
use crate::gui::dialogs::{files::FilePurpose, path_field::with_home};
use crate::gui::widgets::{choice_row_ui, counted, integer_row_ui, row_ui};
use crate::scene::{Choice, Mode, RenderSettings, Scene};

/// What buttons say that let a path be chosen.
const CHOOSE: &str = "Choose…";

/// The fields.
#[derive(Debug, Default)]
pub(super) struct Form {
    /// What is wrong, and where.
    pub problem: Option<Problem>,
    folder: String,
    /// Whether the folder is one the user typed.
    is_own_folder: bool,
    /// All but the reference, which has fields of its own.
    options: ReportOptions,
    reference: ReferenceKind,
    reference_samples: Option<u32>,
    reference_file: String,
    radiance: String,
}

/// The ways to get a reference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum ReferenceKind {
    #[default]
    Rendered,
    File,
    Exact,
}

impl Choice for ReferenceKind {
    const ALL: &'static [(Self, &'static str)] = &[
        (Self::Rendered, "rendered"),
        (Self::File, "file"),
        (Self::Exact, "exact"),
    ];
}

/// What is wrong with the fields.
#[derive(Debug)]
pub(super) struct Problem {
    place: Place,
    text: String,
}

/// Where a problem is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Folder,
    Comparison(usize),
    Reference,
    Scene,
}

impl Problem {
    /// In the words of the error, where the field does not say them already.
    pub fn of(error: &ReportError) -> Self {
        let (place, text) = match error {
            ReportError::Folder { .. }
            | ReportError::File { .. }
            | ReportError::Elsewhere { .. } => (Place::Folder, error.to_string()),
            ReportError::Comparison { index, reason, .. } => {
                (Place::Comparison(*index), in_the_window(reason))
            }
            ReportError::Reference(_)
            | ReportError::ReferenceSize { .. }
            | ReportError::ReferenceDisplay { .. } => (Place::Reference, error.to_string()),
            ReportError::Scene(_) | ReportError::Render(_) | ReportError::Memory(_) => {
                (Place::Scene, error.to_string())
            }
        };
        Self { place, text }
    }
}

fn in_the_window(reason: &ComparisonError) -> String {
    match reason {
        ComparisonError::Size => format!("{reason}: set it above"),
        reason => reason.to_string(),
    }
}

/// Comparisons that are of use in a mode, and what they are called. All lead to the same picture, by another way.
fn ready_made(mode: Mode) -> Vec<(&'static str, &'static str)> {
    let mut all = vec![
        (
            "Stop at 3 % noise, samples where the error is",
            "render.stop.noise=0.03",
        ),
        ("4 shadow rays per light", "render.shadow_samples=4"),
        ("The kd-tree", "render.accelerator=kd-tree"),
        ("Plain random numbers", "render.sampler=independent"),
    ];
    if mode == Mode::Path {
        all.extend([
            (
                "Find light by sampling lights alone",
                "render.light_sampling=nee",
            ),
            (
                "Find light by scattering alone",
                "render.light_sampling=bsdf",
            ),
            ("No roulette", "render.roulette=false"),
        ]);
    }
    all
}

impl Form {
    /// Offers a folder, unless the user has typed one.
    pub fn suggest(&mut self, folder: &Path) {
        if !self.is_own_folder {
            self.folder = folder.display().to_string();
        }
    }

    pub fn has_folder(&self) -> bool {
        !self.folder.trim().is_empty()
    }

    /// Where the report is to be written to.
    pub fn folder(&self) -> PathBuf {
        let folder = with_home(self.folder.trim());
        // A path that says where it is, wherever it is read.
        std::path::absolute(&folder).unwrap_or(folder)
    }

    /// Takes the path that was chosen for `purpose`.
    pub fn set_path(&mut self, purpose: FilePurpose, path: &Path) {
        let text = path.display().to_string();
        if purpose.is_folder() {
            self.folder = text;
            self.is_own_folder = true;
        } else {
            self.reference_file = text;
        }
    }

    /// What the fields ask for.
    pub fn options(&self) -> Result<ReportOptions, Problem> {
        let problem = |text| Problem {
            place: Place::Reference,
            text,
        };
        let reference = match self.reference {
            ReferenceKind::Rendered => ReferenceOptions::Rendered {
                samples: self.reference_samples,
            },
            ReferenceKind::File => match self.reference_file.trim() {
                "" => return Err(problem("Name the picture".to_owned())),
                path => ReferenceOptions::File(with_home(path)),
            },
            ReferenceKind::Exact => {
                ReferenceOptions::Exact(parse_radiance(&self.radiance).map_err(problem)?)
            }
        };
        Ok(ReportOptions {
            reference,
            ..self.options.clone()
        })
    }

    /// Draws the fields; returns what a path is to be chosen for.
    pub fn form_ui(&mut self, ui: &mut Ui, subject: Subject<'_>) -> Option<FilePurpose> {
        ui.label(format!(
            "Renders {} with several seeds, measures each render whenever its samples have doubled, and shows how noise falls with time.",
            in_words(subject)
        ));
        self.problem_ui(ui, Place::Scene);
        ui.add_space(6.0);
        let chooses_folder = self.folder_ui(ui);
        ui.add_space(8.0);
        self.numbers_ui(ui, subject.scene);
        ui.add_space(8.0);
        self.comparisons_ui(ui, subject.scene.render.mode);
        ui.add_space(8.0);
        let chooses_reference = self.reference_ui(ui, subject.scene);
        ui.add_space(8.0);
        ui.label(RichText::new(self.work(subject.scene)).weak());
        let stops = if subject.is_rendering {
            "The render that is going on is stopped first, and no other"
        } else {
            "No render"
        };
        ui.label(
            RichText::new(format!(
                "{stops} can start until the report is done: it would spoil the times. The rest of the window stays usable."
            ))
            .weak(),
        );
        let folder = chooses_folder.then_some(FilePurpose::ReportFolder);
        folder.or(chooses_reference.then_some(FilePurpose::ReportReference))
    }

    fn problem_ui(&self, ui: &mut Ui, place: Place) {
        let problem = self.problem.as_ref().filter(|p| p.place == place);
        if let Some(problem) = problem {
            let text = RichText::new(&problem.text).color(ui.visuals().error_fg_color);
            ui.add(egui::Label::new(text).wrap());
        }
    }

    /// Returns whether the folder is to be chosen.
    fn folder_ui(&mut self, ui: &mut Ui) -> bool {
        let mut chooses = false;
        let tooltip = "Where the report is written to; the folder is made where it is missing";
        let field = row_ui(ui, "Folder", tooltip, |ui| {
            let choose = (CHOOSE, "Choose the folder");
            let field = TextEdit::singleline(&mut self.folder);
            field_and_button_ui(ui, field, choose, &mut chooses)
        });
        self.is_own_folder |= field.changed();
        let text = format!(
            "For {}. Those of a report before are replaced.",
            REPORT_FILES.join(", ")
        );
        ui.label(RichText::new(text).weak().small());
        self.problem_ui(ui, Place::Folder);
        chooses
    }

    fn numbers_ui(&mut self, ui: &mut Ui, scene: &Scene) {
        let render = &scene.render;
        let own = (render.width, render.height);
        let (mut width, mut height) = self.options.size.unwrap_or(own);
        let sides = 1..=RenderSettings::MAX_SIDE;
        let tooltip = "Of the pictures that are rendered, in pixels; the scene keeps its own. Small ones tell nearly the same, and sooner";
        integer_row_ui(ui, "Picture width", tooltip, &mut width, sides.clone(), 1.0);
        integer_row_ui(ui, "Picture height", tooltip, &mut height, sides, 1.0);
        let pixels = u64::from(width) * u64::from(height);
        if pixels <= RenderSettings::MAX_PIXELS {
            self.options.size = Some((width, height)).filter(|&size| size != own);
        }
        let usual = ReportOptions::default_samples(render);
        let mut samples = self.options.samples.unwrap_or(usual);
        integer_row_ui(
            ui,
            "Most samples",
            "Samples per pixel at the last point; the points before have 1, 2, 4, … of them",
            &mut samples,
            ReportOptions::SAMPLES,
            0.5,
        );
        self.options.samples = Some(samples).filter(|&samples| samples != usual);
        integer_row_ui(
            ui,
            "Seeds",
            "How often each is rendered, every time with other random numbers: the chart shows the median and the range",
            &mut self.options.seeds,
            ReportOptions::SEEDS,
            0.1,
        );
    }

    fn comparisons_ui(&mut self, ui: &mut Ui, mode: Mode) {
        let mut removed = None;
        for index in 0..self.options.comparisons.len() {
            let label = format!("Comparison {}", index + 1);
            let tooltip = "What the scene says is changed in this: KEY=VALUE, several divided by semicolons, in the words of \
                           scene files";
            row_ui(ui, &label, tooltip, |ui| {
                let field = TextEdit::singleline(&mut self.options.comparisons[index])
                    .hint_text("render.filter=tent; render.max_bounces=4");
                let name = format!("Remove comparison {}", index + 1);
                let mut is_removed = false;
                let field = field_and_button_ui(ui, field, ("✖", &name), &mut is_removed);
                removed = removed.or(is_removed.then_some(index));
                field
            });
            self.problem_ui(ui, Place::Comparison(index));
        }
        if let Some(index) = removed {
            self.options.comparisons.remove(index);
            // Its number means another one now.
            self.problem = None;
        }
        row_ui(
            ui,
            "Compare with",
            "Renders the scene in another way too, seed by seed in turns, and lays its curve over the scene's",
            |ui| {
                let menu = ui.menu_button("Add comparison", |ui| {
                    for (name, assignments) in ready_made(mode) {
                        let button = Button::new(name).shortcut_text(assignments);
                        if ui.add(button).clicked() {
                            self.options.comparisons.push(assignments.to_owned());
                        }
                    }
                    ui.separator();
                    if ui.button("Other settings").clicked() {
                        self.options.comparisons.push(String::new());
                    }
                });
                menu.response
            },
        );
    }

    /// Returns whether the picture is to be chosen.
    fn reference_ui(&mut self, ui: &mut Ui, scene: &Scene) -> bool {
        let mut chooses = false;
        choice_row_ui(
            ui,
            "Reference",
            "What is taken for the truth",
            &mut self.reference,
            |kind| match kind {
                ReferenceKind::Rendered => (
                    "Rendered",
                    "A render with many samples, another seed and, in mode path, another way of finding light. Its own error is \
                     estimated and taken away from what is measured",
                ),
                ReferenceKind::File => {
                    ("File", "A picture made before, by this program or another")
                }
                ReferenceKind::Exact => (
                    "Exact",
                    "The same radiance in every pixel, where the answer is known",
                ),
            },
        );
        match self.reference {
            ReferenceKind::Rendered => {
                let usual = self.usual_reference_samples(&scene.render);
                let mut samples = self.reference_samples.unwrap_or(usual);
                integer_row_ui(
                    ui,
                    "Its samples",
                    "Samples per pixel of the reference. Where nothing else is set here, 16 times the most of all that is compared: that makes \
                     its own error small",
                    &mut samples,
                    1..=RenderSettings::MAX_SAMPLES,
                    4.0,
                );
                self.reference_samples = Some(samples).filter(|&samples| samples != usual);
            }
            ReferenceKind::File => {
                row_ui(
                    ui,
                    "Its file",
                    "OpenEXR, HDR or PNG, of the report's size",
                    |ui| {
                        let field = TextEdit::singleline(&mut self.reference_file)
                            .hint_text("reference.exr");
                        let choose = (CHOOSE, "Choose the reference");
                        field_and_button_ui(ui, field, choose, &mut chooses)
                    },
                );
            }
            ReferenceKind::Exact => {
                row_ui(ui, "Its radiance", "Red, green, blue", |ui| {
                    let field = TextEdit::singleline(&mut self.radiance);
                    ui.add(field.hint_text("1,1,1").desired_width(f32::INFINITY))
                });
            }
        }
        self.problem_ui(ui, Place::Reference);
        chooses
    }

    fn usual_reference_samples(&self, render: &RenderSettings) -> u32 {
        let most = self
            .options
            .samples
            .unwrap_or(ReportOptions::default_samples(render));
        ReportOptions::default_reference_samples(most)
    }

    /// What will be rendered.
    fn work(&self, scene: &Scene) -> String {
        let renders = self.options.seeds as usize * (1 + self.options.comparisons.len());
        let renders = counted(renders, "render", "renders");
        match self.reference {
            ReferenceKind::Rendered => {
                let usual = self.usual_reference_samples(&scene.render);
                let samples = self.reference_samples.unwrap_or(usual) as usize;
                let samples = counted(samples, "sample", "samples");
                format!("{renders}, after one of {samples} per pixel for the reference.")
            }
            _ => format!("{renders}."),
        }
    }
}

/// A text field and a button at its right, which has a text and a name. Sets `clicked` where the button was.
fn field_and_button_ui(
    ui: &mut Ui,
    field: TextEdit<'_>,
    (text, name): (&str, &str),
    clicked: &mut bool,
) -> Response {
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        let button = ui.button(text).on_hover_text(name).accessible_name(name);
        *clicked = button.clicked();
        ui.add(field.desired_width(f32::INFINITY))
    })
    .inner
}

/// The scene as the user knows it.
fn in_words(subject: Subject<'_>) -> String {
    let unsaved = if subject.is_modified {
        ", changes that are not saved included,"
    } else {
        ""
    };
    format!("{} as the window shows it{unsaved}", subject.name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::scene_file::apply_overrides;

    #[test]
    fn an_untouched_form_asks_for_what_the_command_does() {
        let form = Form::default();
        assert_eq!(form.options().expect("is right"), ReportOptions::default());
    }

    #[test]
    fn ready_made_comparisons_say_something_else_than_the_scene() {
        for mode in [Mode::Direct, Mode::Path] {
            let mut scene = Scene::default();
            scene.render.mode = mode;
            for (name, assignments) in ready_made(mode) {
                let changed = apply_overrides(&scene, &[assignments.to_owned()]);
                assert_ne!(changed.expect("can be read"), scene, "{name}");
            }
        }
    }

    #[test]
    fn a_suggested_folder_gives_way_to_a_typed_one() {
        let mut form = Form::default();
        assert!(!form.has_folder());
        form.suggest(Path::new("/a"));
        form.suggest(Path::new("/b"));
        assert_eq!(form.folder(), Path::new("/b"));
        form.is_own_folder = true;
        form.suggest(Path::new("/c"));
        assert_eq!(form.folder(), Path::new("/b"));
    }
}

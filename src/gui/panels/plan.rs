//! What a render needs, what it leaves out and why, and what each part brings and costs.

use egui::{Grid, Label, RichText, Ui};

use super::PanelState;
use crate::analysis::cost::{Costs, Share};
use crate::gui::commands::Command;
use crate::gui::contributions::Contributions;
use crate::gui::costs::CostState;
use crate::gui::document::same_picture;
use crate::gui::status_bar::progress_ui;
use crate::gui::widgets::grouped;
use crate::render::{Used, reasons};
use crate::scene::Scene;

/// What the keys of scene files in the plan's reasons are called in the window; the longer first, where one begins like another.
const NAMES: [(&str, &str); 12] = [
    ("camera.aperture_radius", "Lens radius"),
    ("render.antialiasing", "Anti-aliasing"),
    ("render.depth_of_field", "Depth of field"),
    ("render.max_bounces ends", "the limit of Bounces ends"),
    ("render.max_bounces", "Bounces"),
    ("render.ambient_occlusion", "Occlusion"),
    ("render.light_sampling is bsdf", "Light search is Meet"),
    ("render.light_sampling is nee", "Light search is Aim"),
    ("render.shadows is off", "Shadows is Off"),
    ("render.shadows is hard", "Shadows is Hard"),
    ("render.roulette", "Roulette"),
    ("mode direct", "the mode Direct light"),
];

/// A reason of the plan in the words of the window.
fn in_window_words(reason: &str) -> String {
    let text = reason.to_owned();
    NAMES
        .iter()
        .fold(text, |text, (key, name)| text.replace(key, name))
}

/// What a render of the scene does, what it leaves out and why, and what that costs and saves.
pub fn plan_ui(ui: &mut Ui, state: &mut PanelState<'_>) {
    features_ui(ui, state.scene);
    ui.add_space(6.0);
    used_ui(ui, &Used::of(state.scene));
    ui.add_space(6.0);
    contributions_ui(ui, state.contributions);
    match state.costs {
        CostState::Measuring(progress) => {
            ui.horizontal(|ui| {
                progress_ui(ui, progress.fraction());
                ui.label("Measuring costs");
            });
            if ui.button("Cancel measuring").clicked() {
                state.commands.push(Command::Cancel);
            }
            return;
        }
        CostState::Unknown => {}
        CostState::Failed(problem) => {
            ui.add(Label::new(RichText::new(problem).color(ui.visuals().error_fg_color)).wrap());
        }
        CostState::Known { scene, costs } => {
            costs_ui(ui, costs);
            if !same_picture(scene, state.scene) {
                ui.add(Label::new(
                    RichText::new("Of the scene before the last changes").weak(),
                ));
            }
        }
    }
    let command = Command::MeasureCosts;
    let button = ui.add_enabled(state.can_measure_costs, egui::Button::new(command.label()));
    let button = button
        .on_hover_text(command.tooltip(ui.ctx()))
        .on_disabled_hover_text(
            "Not while anything is rendered or loaded, as times would spoil each other",
        );
    if button.clicked() {
        state.commands.push(command);
    }
}

fn features_ui(ui: &mut Ui, scene: &Scene) {
    // A scene that cannot be rendered says so elsewhere.
    let Ok(reasons) = reasons(scene) else {
        return;
    };
    for (feature, reason) in reasons {
        let name = feature.name();
        let text = match reason {
            None => RichText::new(format!("{name}: needed")),
            Some(reason) => {
                let reason = in_window_words(reason);
                RichText::new(format!("{name}: left out, as {reason}")).weak()
            }
        };
        // Wrapped, as the longest reason must not make the panel wider.
        ui.add(Label::new(text).wrap());
    }
}

fn used_ui(ui: &mut Ui, used: &Used) {
    let [facts, tooltips] = facts_of(used);
    for (fact, tooltip) in facts.into_iter().zip(tooltips) {
        ui.add(Label::new(fact).wrap()).on_hover_text(tooltip);
    }
}

/// What of the scene is used, and what that means.
fn facts_of(used: &Used) -> [[String; 3]; 2] {
    let [shining, lights] = used.lights;
    let [worn, materials] = used.materials;
    let names = used.lobes.iter().map(|lobe| match *lobe {
        "diffuse" => "matt",
        "specular" => "highlights",
        "mirror" => "mirrors",
        "glass" => "glass",
        _ => "shining by themselves",
    });
    let names: Vec<_> = names.collect();
    let kinds = if names.is_empty() {
        String::new()
    } else {
        format!(" ({})", names.join(", "))
    };
    let structure = match used.structure {
        "wide" => "the wide tree",
        "kd-tree" => "the kd-tree",
        _ => "a list of all",
    };
    let triangles = grouped(used.triangles);
    [
        [
            format!("Lights: {shining} of {lights} shine"),
            format!("Materials: {worn} of {materials} on objects{kinds}"),
            format!("Rays look for {triangles} triangles in {structure}"),
        ],
        [
            "Black lights cost nothing".to_owned(),
            "Materials of no object cost nothing, nor does what none of the others do".to_owned(),
            "Copies counted. What the structure is, the row Structure says".to_owned(),
        ],
    ]
}

/// What each effect and each light brings.
fn contributions_ui(ui: &mut Ui, contributions: &mut Contributions) {
    let all = contributions.present().to_vec();
    if all.is_empty() {
        return;
    }
    ui.label(RichText::new("What each brings").strong())
        .on_hover_text(
            "The picture with it minus the picture without, small and of the same samples",
        );
    for contributor in all {
        let name = contributions.name_of(&contributor);
        contributions.row_ui(ui, &contributor, None, &name);
    }
    ui.add_space(6.0);
}

fn costs_ui(ui: &mut Ui, costs: &Costs) {
    let hover = format!(
        "Medians of {} pairs of small renders, by processor time, and where they lie with 95 % confidence",
        costs.pairs
    );
    let effects = costs.effects.iter();
    let effects = effects.map(|(effect, share)| (effect.name(), *share));
    shares_ui(ui, "Part of the time", &hover, effects);
    ui.add_space(6.0);
    shares_ui(ui, "What is left out would add", &hover, costs.left_out());
}

fn shares_ui(
    ui: &mut Ui,
    title: &str,
    hover: &str,
    shares: impl Iterator<Item = (&'static str, Share)>,
) {
    ui.label(RichText::new(title).strong()).on_hover_text(hover);
    Grid::new(title).num_columns(2).show(ui, |ui| {
        for (name, share) in shares {
            let [text, meaning] = share_in_words(share);
            ui.label(text).on_hover_text(meaning);
            ui.add(Label::new(name).wrap());
            ui.end_row();
        }
    });
}

/// A share of the time, and where it lies; a share that may as well be nothing is called that.
fn share_in_words(share: Share) -> [String; 2] {
    let percent = |share: f64| format!("{:+.0} %", 100.0 * share);
    let [low, high] = share.interval;
    let text = if low <= 0.0 && high >= 0.0 {
        "no difference".to_owned()
    } else {
        percent(share.value)
    };
    let meaning = format!(
        "Measured {} of the time, and with 95 % confidence between {} and {}",
        percent(share.value),
        percent(low),
        percent(high)
    );
    [text, meaning]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every key that the plan names has a name of the window.
    #[test]
    fn reasons_are_in_the_words_of_the_window() {
        let source = include_str!("../../render/plan.rs");
        let quoted = source.split('"').skip(1).step_by(2);
        let keys = quoted.filter(|text| text.contains("render.") || text.contains("camera."));
        let keys: Vec<_> = keys.collect();
        assert!(keys.len() > 8, "{keys:?}");
        for reason in keys {
            let words = in_window_words(reason);
            let is_plain =
                !words.contains('_') && !words.contains("render.") && !words.contains("camera.");
            assert!(is_plain, "{reason}: {words}");
        }
        assert_eq!(
            in_window_words("camera.aperture_radius is 0"),
            "Lens radius is 0"
        );
    }

    #[test]
    fn shares_that_may_be_nothing_are_called_so() {
        let share = |value, interval| share_in_words(Share { value, interval });
        let [text, meaning] = share(-0.01, [-0.07, 0.06]);
        assert_eq!(text, "no difference");
        assert!(meaning.contains("between -7 % and +6 %"), "{meaning}");
        assert_eq!(share(0.12, [0.1, 0.14])[0], "+12 %");
    }

    #[test]
    fn what_is_used_is_told_without_keys() {
        let used = Used {
            lights: [1, 2],
            materials: [2, 3],
            lobes: ["diffuse", "specular"].into(),
            structure: "wide",
            triangles: 12_345,
        };
        let [facts, _] = facts_of(&used);
        assert_eq!(
            facts,
            [
                "Lights: 1 of 2 shine",
                "Materials: 2 of 3 on objects (matt, highlights)",
                "Rays look for 12,345 triangles in the wide tree",
            ]
        );
    }
}

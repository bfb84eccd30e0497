//! What a render needs, what it leaves out and why, and what each part brings and costs.

use egui::{Grid, Label, RichText, Ui};

use super::PanelState;
use crate::analysis::cost::{Costs, Share};
use crate::gui::commands::Command;
use crate::gui::contributions::Contributions;
use crate::gui::costs::CostState;
use crate::gui::document::same_picture;
use crate::gui::status_bar::progress_ui;
use crate::render::{Used, reasons};
use crate::scene::Scene;

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
            Some(reason) => RichText::new(format!("{name}: left out: {reason}")).weak(),
        };
        // Wrapped, as the longest reason must not make the panel wider.
        ui.add(Label::new(text).wrap());
    }
}

fn used_ui(ui: &mut Ui, used: &Used) {
    for fact in used.facts() {
        ui.add(Label::new(fact).wrap());
    }
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
    let percent = |share: f64| format!("{:+.0}", 100.0 * share);
    Grid::new(title).num_columns(2).show(ui, |ui| {
        for (name, share) in shares {
            let [low, high] = share.interval.map(percent);
            ui.label(format!("{} %  ({low} to {high})", percent(share.value)));
            ui.add(Label::new(name).wrap());
            ui.end_row();
        }
    });
}

//! What the window knows about what effects cost: measured in the background when somebody asks, and shown in the panel Plan and beside
//! the switches of effects.

use egui::{Align, Layout, RichText, Ui, Vec2};

use super::commands::Command;
use super::document::same_picture;
use crate::analysis::cost::{Costs, Effect, Share};
use crate::control::Progress;
use crate::scene::Scene;

/// Pairs of renders for each effect: enough for an interval, and few enough to wait for.
pub const PAIRS: usize = 8;

/// What is known.
#[derive(Debug, Default)]
pub enum CostState {
    /// Nothing.
    #[default]
    Unknown,
    /// They are being measured.
    Measuring(Progress),
    /// They were measured.
    Known {
        /// Of this scene.
        scene: Box<Scene>,
        /// What they are.
        costs: Box<Costs>,
    },
    /// They cannot be measured, for this reason.
    Failed(String),
}

impl CostState {
    /// How far measuring is, `0..=1`, where it goes on.
    #[must_use]
    pub fn share_measured(&self) -> Option<f64> {
        match self {
            Self::Measuring(progress) => Some(progress.fraction()),
            _ => None,
        }
    }

    /// What is known of the effects of `scene`.
    #[must_use]
    pub fn of_effects(&self, scene: &Scene) -> EffectCosts<'_> {
        match self {
            Self::Known { scene: of, costs } => EffectCosts {
                costs: Some(costs),
                is_current: same_picture(of, scene),
            },
            _ => EffectCosts {
                costs: None,
                is_current: false,
            },
        }
    }
}

/// What effects take of the time of a render, as far as it is known.
#[derive(Clone, Copy, Debug)]
pub struct EffectCosts<'a> {
    costs: Option<&'a Costs>,
    /// Whether they are of the scene as it is.
    is_current: bool,
}

impl EffectCosts<'_> {
    /// What `effect` takes.
    #[must_use]
    pub fn of(&self, effect: Effect) -> Option<EffectCost> {
        let costs = self.costs?;
        let (_, share) = costs.effects.iter().find(|(known, _)| *known == effect)?;
        Some(EffectCost {
            share: *share,
            pairs: costs.pairs,
            is_current: self.is_current,
        })
    }

    /// The tooltip of a switch that means `meaning`: where nothing was measured of the scene as it is, it says how that is done.
    #[must_use]
    pub fn tooltip(&self, ctx: &egui::Context, meaning: &str) -> String {
        if self.is_current {
            return meaning.to_owned();
        }
        let keys = Command::MeasureCosts.shortcut_text(ctx);
        format!("{meaning}\n{keys} measures what effects take of the time")
    }
}

/// What an effect takes of the time of a render.
#[derive(Clone, Copy, Debug)]
pub struct EffectCost {
    share: Share,
    pairs: usize,
    is_current: bool,
}

impl EffectCost {
    /// In a few words, fainter where it is of a scene before.
    #[must_use]
    pub fn text(&self, ui: &Ui) -> RichText {
        let weak = ui.visuals().weak_text_color();
        let strength = if self.is_current { 1.0 } else { 0.6 };
        RichText::new(format!("{} time", whole_percent(self.share.value)))
            .small()
            .color(weak.gamma_multiply(strength))
    }

    /// What that means, and how it was found.
    #[must_use]
    pub fn explanation(&self) -> String {
        let [low, high] = self.share.interval.map(whole_percent);
        let value = whole_percent(self.share.value);
        let saving = if self.share.value < 0.0 {
            ", less than nothing: with it a render is done sooner"
        } else {
            ""
        };
        let before = if self.is_current {
            ""
        } else {
            "\nOf the scene before the last changes"
        };
        format!(
            "Its part of the time of a render: {value}{saving}. Between {low} and {high} with 95 % confidence: the median of {} pairs of small \
             renders with and without it, in processor time{before}",
            self.pairs
        )
    }
}

/// A row of the panel with what an effect takes at its right, where that is known.
pub fn beside_ui(ui: &mut Ui, cost: Option<EffectCost>, row: impl FnOnce(&mut Ui)) {
    let Some(cost) = cost else {
        return row(ui);
    };
    let size = Vec2::new(ui.available_width(), ui.spacing().interact_size.y);
    ui.allocate_ui_with_layout(size, Layout::right_to_left(Align::Center), |ui| {
        ui.label(cost.text(ui)).on_hover_text(cost.explanation());
        ui.with_layout(Layout::left_to_right(Align::Center), row);
    });
}

/// A share in whole per cent: what is measured tells no more.
fn whole_percent(share: f64) -> String {
    // Minus nothing is nothing.
    let percent = (100.0 * share).round() + 0.0;
    format!("{percent:.0} %")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn known(value: f64) -> CostState {
        let share = Share {
            value,
            interval: [value - 0.04, value + 0.03],
        };
        CostState::Known {
            scene: Box::default(),
            costs: Box::new(Costs {
                effects: vec![(Effect::Shadows, share)],
                savings: Vec::new(),
                layers: None,
                primary_rays: None,
                pairs: PAIRS,
            }),
        }
    }

    #[test]
    fn a_cost_is_told_with_its_interval_and_whether_it_is_of_the_scene_before() {
        let state = known(0.12);
        let mut scene = Scene::default();
        let explain = |state: &CostState, scene: &Scene| {
            let cost = state.of_effects(scene).of(Effect::Shadows);
            cost.expect("was measured").explanation()
        };
        assert!(state.of_effects(&scene).of(Effect::Glass).is_none());
        let text = explain(&state, &scene);
        assert!(
            text.contains("render: 12 %. Between 8 % and 15 %"),
            "{text}"
        );
        assert!(text.contains("8 pairs") && !text.contains("before the last changes"));
        // The display makes no other picture.
        scene.display.exposure = 1.0;
        assert_eq!(explain(&state, &scene), text);
        scene.render.antialiasing = !scene.render.antialiasing;
        assert!(explain(&state, &scene).ends_with("before the last changes"));
        let text = explain(&known(-0.2), &Scene::default());
        assert!(text.contains("-20 %, less than nothing"), "{text}");
        assert_eq!(whole_percent(-0.001), "0 %");
    }

    #[test]
    fn where_nothing_is_known_a_tooltip_says_how_to_measure() {
        let ctx = egui::Context::default();
        let scene = Scene::default();
        let tooltip = |state: &CostState| state.of_effects(&scene).tooltip(&ctx, "Glass");
        assert!(
            CostState::Unknown
                .of_effects(&scene)
                .of(Effect::Shadows)
                .is_none()
        );
        assert!(tooltip(&CostState::Unknown).starts_with("Glass\nF7 measures"));
        assert_eq!(tooltip(&known(0.1)), "Glass");
    }
}

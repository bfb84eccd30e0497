//! What of the picture shows, and how: layers, channels and display.

use egui::Ui;

use super::PanelState;
use crate::gui::look::Channels;
use crate::gui::widgets::{Number, choice_row_ui, combo_row_ui, number_row_ui, switch_row_ui};
use crate::render::Layer;
use crate::scene::{PngBits, Scene, ToneCurve};

/// Which part of the picture shows, and whether parts are kept.
pub fn layers_ui(ui: &mut Ui, state: &mut PanelState<'_>) {
    if !state.layers.is_empty() {
        let mut choices = vec![(None, "Whole picture".to_owned())];
        let layers = state.layers.iter().copied();
        choices.extend(layers.map(|layer| (Some(layer), layer_name(layer).to_owned())));
        if !choices.iter().any(|(layer, _)| layer == state.shown_layer) {
            *state.shown_layer = None;
        }
        combo_row_ui(
            ui,
            "Layer",
            "Which part of the picture to look at; the parts add up to the whole, shadow and occlusion are factors beside them, and \
             the error is how far each pixel still is from the truth",
            state.shown_layer,
            &choices,
        );
    }
    switch_row_ui(
        ui,
        "Keep layers",
        "Keep the parts of the next picture, to look at them and to save them in .exr files; they take memory",
        &mut state.scene.output.layers,
    );
}

/// Which channels of the picture show.
pub fn channels_ui(ui: &mut Ui, channels: &mut Channels) {
    let choices = Channels::ALL.map(|channels| (channels, channels.label().to_owned()));
    combo_row_ui(
        ui,
        "Channels",
        "Which channels of the picture to look at; false colours tell how bright each place is, in stops. Files are saved with all",
        channels,
        &choices,
    );
}

/// From radiance to the screen. It changes no radiance and needs no new render.
pub fn display_ui(ui: &mut Ui, scene: &mut Scene) {
    number_row_ui(
        ui,
        "Exposure",
        "Brightness on the screen and in PNG files, in stops: each doubles it",
        &mut scene.display.exposure,
        &Number {
            decimals: 2,
            ..Number::within(-20.0..=20.0, 0.02).with_suffix(" stops")
        },
    );
    choice_row_ui(
        ui,
        "Tone curve",
        "What becomes of values brighter than the screen, before they are encoded as sRGB, which they always are",
        &mut scene.display.tone_curve,
        |curve| match curve {
            ToneCurve::None => (
                "None",
                "No curve: values are shown as they are, as sRGB; what is brighter than the screen is cut off at its white",
            ),
            ToneCurve::Aces => (
                "ACES",
                "A curve like that of the Academy Color Encoding System: bright values roll off as in film, dark ones get more contrast",
            ),
        },
    );
    number_row_ui(
        ui,
        "Gamma",
        "Above 1, what is between black and white is shown brighter, below 1 darker; after the tone curve, in PNG files too",
        &mut scene.display.gamma,
        &Number {
            decimals: 2,
            ..Number::within(0.1..=10.0, 0.01)
        },
    );
    combo_row_ui(
        ui,
        "PNG depth",
        "Bits per channel of saved PNG files",
        &mut scene.output.png_bits,
        &[
            (PngBits::Eight, "8 bits".to_owned()),
            (PngBits::Sixteen, "16 bits".to_owned()),
        ],
    );
}

/// What a layer is called on screen.
fn layer_name(layer: Layer) -> &'static str {
    match layer {
        Layer::Emission => "Lights and background",
        Layer::DirectDiffuse => "Direct light, diffuse",
        Layer::DirectSpecular => "Direct light, highlights",
        Layer::Ambient => "Ambient light",
        Layer::Reflection => "Reflections",
        Layer::Refraction => "Seen through glass",
        Layer::Indirect => "Indirect light",
        Layer::Shadow => "Shadow factor",
        Layer::Occlusion => "Occlusion factor",
        Layer::Error => "Error of each pixel",
    }
}

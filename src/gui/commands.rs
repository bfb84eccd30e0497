//! Everything the user can ask for that has a name: one table feeds the menus, the shortcuts and the shortcut sheet.

use egui::{Key, KeyboardShortcut, Modifiers};

/// Something the user asks for by menu, button or key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Open a scene or mesh in place of the present one.
    Open,
    /// Add a mesh to the scene.
    AddMesh,
    /// Make an image the background.
    SetBackground,
    /// Lay an image on the selected material.
    SetTexture(TextureUse),
    /// Write the scene to its file.
    SaveScene,
    /// Write the scene to another file.
    SaveSceneAs,
    /// Write the picture.
    SavePicture,
    /// Close the window.
    Quit,
    /// Take back the last edit.
    Undo,
    /// Do again what was undone.
    Redo,
    /// Take a copy of the selected part.
    Copy,
    /// Add what was copied.
    Paste,
    /// Add a copy of the selected part.
    Duplicate,
    /// Change the name of the selected part.
    Rename,
    /// Take the selected part out of the scene.
    Remove,
    /// Let clicks select.
    SelectTool,
    /// Show handles that move the selected object or light.
    MoveTool,
    /// Show handles that turn it.
    RotateTool,
    /// Show a handle that changes its size.
    ScaleTool,
    /// Have handles go along the axes of the part itself, or of the world again.
    ToggleOwnAxes,
    /// Let clicks choose what is sharp.
    FocusTool,
    /// Let clicks show the rays of a pixel.
    RayTool,
    /// Move the camera to where it sees everything.
    FrameAll,
    /// Move the camera to where it sees the selected object.
    FrameSelected,
    /// Go back to the file's camera.
    ResetCamera,
    /// Remember the camera.
    AddBookmark,
    /// Go to the next camera that was remembered.
    NextBookmark,
    /// Go to the one before.
    PreviousBookmark,
    /// Turn everything around the objects so that another axis is up.
    TurnUp,
    /// Show the live preview.
    ShowPreview,
    /// Show the rendered picture.
    ShowPicture,
    /// Show or hide the side panel.
    TogglePanel,
    /// Show or hide the error plot.
    ToggleErrorPlot,
    /// Show or hide the renders of this session.
    ToggleRenders,
    /// Outline the tiles that are being rendered, or no longer.
    ToggleTiles,
    /// Show the picture of the render before the shown one.
    ShowOlderRender,
    /// Show the picture of the render after the shown one.
    ShowNewerRender,
    /// Compare the shown picture with another render, or stop comparing.
    Compare,
    /// Compare the shown picture with an image file.
    CompareFile,
    /// Show the other of two compared pictures.
    Flip,
    /// Show all of the picture.
    ShowWhole,
    /// Show each pixel of the picture as one of the screen.
    ShowFullSize,
    /// Show the picture larger.
    Enlarge,
    /// Show the picture smaller.
    Reduce,
    /// Start rendering, in place of a running render.
    Render,
    /// Render anew whenever the scene or the camera changes, or no longer.
    ToggleLive,
    /// Have the running render rest, or go on.
    TogglePause,
    /// Draw the part of the picture to render, or put the tool away.
    DrawRegion,
    /// Render all of the picture again.
    ClearRegion,
    /// Stop what goes on: see [`Stoppable`].
    Cancel,
    /// Find out how long a render will take.
    EstimateTime,
    /// Describe, watch or look at a report of error against run time.
    Report,
    /// Measure what effects cost and what leaving out saves.
    MeasureCosts,
    /// Show the sheet of shortcuts.
    ShowShortcuts,
}

/// What [`Command::Cancel`] stops.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stoppable {
    /// Drawing the region to render.
    Region,
    /// The running render.
    Render,
    /// The report that is being made.
    Report,
    /// Measuring what effects cost.
    Measuring,
    /// Reading files.
    Loading,
    /// Writing pictures.
    Saving,
    /// Preparing the scene that is waited for, and the render that waits.
    Preparing,
}

impl Stoppable {
    /// What is stopped, after "Cancel" or "Give up".
    #[must_use]
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Region => "drawing the region",
            Self::Render => "the render",
            Self::Report => "the report",
            Self::Measuring => "measuring",
            Self::Loading => "loading",
            Self::Saving => "saving the picture",
            Self::Preparing => "preparing",
        }
    }
}

/// What an image on a material says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextureUse {
    /// Colours.
    Diffuse,
    /// Normals.
    Normals,
}

impl Command {
    /// All of them, by menu, but for those of buttons alone.
    pub const ALL: [Self; 53] = [
        Self::Open,
        Self::AddMesh,
        Self::SetBackground,
        Self::SaveScene,
        Self::SaveSceneAs,
        Self::SavePicture,
        Self::Quit,
        Self::Undo,
        Self::Redo,
        Self::Copy,
        Self::Paste,
        Self::Duplicate,
        Self::Rename,
        Self::Remove,
        Self::SelectTool,
        Self::MoveTool,
        Self::RotateTool,
        Self::ScaleTool,
        Self::ToggleOwnAxes,
        Self::FocusTool,
        Self::RayTool,
        Self::Render,
        Self::ToggleLive,
        Self::TogglePause,
        Self::Cancel,
        Self::DrawRegion,
        Self::ClearRegion,
        Self::EstimateTime,
        Self::Report,
        Self::MeasureCosts,
        Self::FrameAll,
        Self::FrameSelected,
        Self::ResetCamera,
        Self::AddBookmark,
        Self::NextBookmark,
        Self::PreviousBookmark,
        Self::TurnUp,
        Self::ShowPreview,
        Self::ShowPicture,
        Self::TogglePanel,
        Self::ToggleErrorPlot,
        Self::ToggleRenders,
        Self::ToggleTiles,
        Self::ShowOlderRender,
        Self::ShowNewerRender,
        Self::Compare,
        Self::CompareFile,
        Self::Flip,
        Self::ShowWhole,
        Self::ShowFullSize,
        Self::Enlarge,
        Self::Reduce,
        Self::ShowShortcuts,
    ];

    /// Its name in menus; an ellipsis says that a question follows.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::Open => "Open scene or mesh…",
            Self::AddMesh => "Add mesh…",
            Self::SetBackground => "Background image…",
            Self::SetTexture(TextureUse::Diffuse) => "Image…",
            Self::SetTexture(TextureUse::Normals) => "Normals…",
            Self::SaveScene => "Save scene",
            Self::SaveSceneAs => "Save scene as…",
            Self::SavePicture => "Save picture…",
            Self::Quit => "Quit",
            Self::Undo => "Undo",
            Self::Redo => "Redo",
            Self::Copy => "Copy",
            Self::Paste => "Paste",
            Self::Duplicate => "Duplicate",
            Self::Rename => "Rename",
            Self::Remove => "Remove",
            Self::SelectTool => "Select tool",
            Self::MoveTool => "Move tool",
            Self::RotateTool => "Rotate tool",
            Self::ScaleTool => "Scale tool",
            Self::ToggleOwnAxes => "Own axes",
            Self::FocusTool => "Focus tool",
            Self::RayTool => "Ray tool",
            Self::FrameAll => "Frame all",
            Self::FrameSelected => "Frame selected object",
            Self::ResetCamera => "Reset camera",
            Self::AddBookmark => "Add bookmark",
            Self::NextBookmark => "Next bookmark",
            Self::PreviousBookmark => "Previous bookmark",
            Self::TurnUp => "Other axis up",
            Self::ShowPreview => "Preview",
            Self::ShowPicture => "Picture",
            Self::TogglePanel => "Side panel",
            Self::ToggleErrorPlot => "Error plot",
            Self::ToggleRenders => "Renders",
            Self::ToggleTiles => "Outline tiles at work",
            Self::ShowOlderRender => "Older render",
            Self::ShowNewerRender => "Newer render",
            Self::Compare => "Compare with another render",
            Self::CompareFile => "Compare with image…",
            Self::Flip => "Flip",
            Self::ShowWhole => "Whole picture",
            Self::ShowFullSize => "100 %",
            Self::Enlarge => "Enlarge",
            Self::Reduce => "Reduce",
            Self::Render => "Render",
            Self::ToggleLive => "Live",
            Self::TogglePause => "Pause",
            Self::DrawRegion => "Draw region to render",
            Self::ClearRegion => "Render whole picture",
            Self::Cancel => "Cancel",
            Self::EstimateTime => "How long will it take?",
            Self::Report => "Report…",
            Self::MeasureCosts => "Measure costs",
            Self::ShowShortcuts => "Keyboard and mouse",
        }
    }

    /// What it does, for tooltips and the sheet.
    #[must_use]
    pub fn description(self) -> &'static str {
        match self {
            Self::Open => {
                "Open a scene file in place of the present scene, or meshes to add to it or to replace it"
            }
            Self::AddMesh => "Add a mesh to the present scene as a new object",
            Self::SetBackground => "Light the scene with an image of all directions",
            Self::SetTexture(TextureUse::Diffuse) => "Lay an image on the material",
            Self::SetTexture(TextureUse::Normals) => {
                "Make the material bumpy by an image of normals"
            }
            Self::SaveScene => "Write the scene to its file",
            Self::SaveSceneAs => "Write the scene to another file",
            Self::SavePicture => "Write the rendered picture as PNG or EXR",
            Self::Quit => "Close the window",
            Self::Undo => "Take back the last edit of the scene",
            Self::Redo => "Do again what was undone",
            Self::Copy => "Copy the selected object, light or material",
            Self::Paste => "Add what was copied to the scene",
            Self::Duplicate => "Add a copy of the selected object, light or material",
            Self::Rename => "Change the name of the selected object, light or material",
            Self::Remove => "Take the selected object, light or material out of the scene",
            Self::SelectTool => "Select what is clicked, and show no handles",
            Self::MoveTool => {
                "Show handles that move the selected object or light; again to hide them"
            }
            Self::RotateTool => {
                "Show handles that turn the selected object or disk; again to hide them"
            }
            Self::ScaleTool => {
                "Show a handle that changes the size of the selected object or disk; again to hide it"
            }
            Self::ToggleOwnAxes => {
                "Have handles go along the axes of the object or disk itself, as it is turned; again for those of the world"
            }
            Self::FocusTool => {
                "Click what is to be sharp, in the preview or the picture; again to stop"
            }
            Self::RayTool => {
                "Click a pixel, in the preview or the picture, to see its rays in the preview; again to stop"
            }
            Self::FrameAll => "Move the camera to where it sees all objects",
            Self::FrameSelected => "Move the camera to where it sees the selected object",
            Self::ResetCamera => "Go back to the camera of the file",
            Self::AddBookmark => "Remember the camera; the scene file keeps it",
            Self::NextBookmark => "Go to the next camera that was remembered",
            Self::PreviousBookmark => "Go to the one before",
            Self::TurnUp => {
                "Turn camera, lights and background about the objects, between Z up and Y up: for a mesh that lies on its face"
            }
            Self::ShowPreview => "Show the live preview",
            Self::ShowPicture => "Show the rendered picture",
            Self::TogglePanel => "Show or hide the side panel",
            Self::ToggleErrorPlot => "Plot the noise of renders against time",
            Self::ToggleRenders => "Show the renders of this session, to look at them again",
            Self::ToggleTiles => "Outline the parts of the picture that are being rendered now",
            Self::ShowOlderRender => "Show the picture of the render before this one",
            Self::ShowNewerRender => "Show the picture of the render after this one",
            Self::Compare => "Compare the shown picture with the render before it; again to stop",
            Self::CompareFile => "Compare the shown picture with one from a file (PNG, EXR, HDR)",
            Self::Flip => "Show the other one of two compared pictures",
            Self::ShowWhole => "Show all of the picture",
            Self::ShowFullSize => "Show each pixel of the picture as one pixel of the screen",
            Self::Enlarge => "Show the picture larger",
            Self::Reduce => "Show the picture smaller",
            Self::Render => "Render the picture; restarts a running render",
            Self::ToggleLive => {
                "Render anew whenever the scene or the camera changes: coarse at once, then ever finer"
            }
            Self::TogglePause => {
                "Have the render rest without using the processor, or go on where it was; the picture is the same"
            }
            Self::DrawRegion => {
                "Draw with the mouse which part of the picture is rendered; a click takes all of it"
            }
            Self::ClearRegion => "Render all of the picture again in place of a part",
            Self::Cancel => {
                "Stop what goes on: a render, a report, measuring, loading, preparing, saving; else give up the tool, then the selection"
            }
            Self::MeasureCosts => {
                "Measure what each effect costs and what leaving out saves, for the panel Plan"
            }
            Self::EstimateTime => {
                "Render a few tiles to tell how long the whole will take; pointing at Render for a moment does so too"
            }
            Self::Report => "Measure how the error falls with time, over several renders",
            Self::ShowShortcuts => "Show this sheet",
        }
    }

    /// Its keys; the first is the one menus name.
    #[must_use]
    pub fn shortcuts(self) -> &'static [KeyboardShortcut] {
        const fn plain(key: Key) -> KeyboardShortcut {
            KeyboardShortcut::new(Modifiers::NONE, key)
        }
        const fn command(key: Key) -> KeyboardShortcut {
            KeyboardShortcut::new(Modifiers::COMMAND, key)
        }
        const fn command_shift(key: Key) -> KeyboardShortcut {
            KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), key)
        }
        match self {
            Self::Open => const { &[command(Key::O)] },
            Self::AddMesh => const { &[command_shift(Key::O)] },
            Self::SetBackground => const { &[command(Key::B)] },
            Self::SetTexture(_) => &[],
            Self::SaveScene => const { &[command(Key::S)] },
            Self::SaveSceneAs => const { &[command_shift(Key::S)] },
            Self::SavePicture => const { &[command(Key::E)] },
            Self::Quit => const { &[command(Key::Q)] },
            Self::Undo => const { &[command(Key::Z)] },
            Self::Redo => const { &[command_shift(Key::Z), command(Key::Y)] },
            Self::Copy => const { &[command(Key::C)] },
            Self::Paste => const { &[command(Key::V)] },
            Self::Duplicate => const { &[command(Key::D)] },
            Self::Rename => const { &[plain(Key::F2)] },
            Self::Remove => const { &[plain(Key::Delete)] },
            Self::SelectTool => const { &[plain(Key::Q)] },
            Self::MoveTool => const { &[plain(Key::G)] },
            Self::RotateTool => const { &[plain(Key::R)] },
            Self::ScaleTool => const { &[plain(Key::S)] },
            Self::ToggleOwnAxes => const { &[plain(Key::W)] },
            Self::FocusTool => const { &[plain(Key::D)] },
            Self::RayTool => const { &[plain(Key::T)] },
            Self::FrameAll => const { &[plain(Key::F)] },
            Self::FrameSelected => const { &[KeyboardShortcut::new(Modifiers::SHIFT, Key::F)] },
            Self::ResetCamera => const { &[plain(Key::Home)] },
            Self::AddBookmark => const { &[plain(Key::M)] },
            Self::NextBookmark => const { &[plain(Key::N)] },
            Self::PreviousBookmark => const { &[KeyboardShortcut::new(Modifiers::SHIFT, Key::N)] },
            Self::TurnUp => const { &[plain(Key::U)] },
            Self::ShowPreview => const { &[plain(Key::Num1)] },
            Self::ShowPicture => const { &[plain(Key::Num2)] },
            Self::TogglePanel => const { &[plain(Key::F9)] },
            Self::ToggleErrorPlot => const { &[plain(Key::F8)] },
            Self::ToggleRenders => const { &[plain(Key::F6)] },
            Self::ToggleTiles => const { &[plain(Key::O)] },
            Self::ShowOlderRender => const { &[plain(Key::PageUp)] },
            Self::ShowNewerRender => const { &[plain(Key::PageDown)] },
            Self::Compare => const { &[plain(Key::C)] },
            Self::CompareFile => const { &[KeyboardShortcut::new(Modifiers::SHIFT, Key::C)] },
            Self::Flip => const { &[plain(Key::X)] },
            Self::ShowWhole => const { &[plain(Key::Num3)] },
            Self::ShowFullSize => const { &[plain(Key::Num4)] },
            Self::Enlarge => const { &[plain(Key::Plus), plain(Key::Equals)] },
            Self::Reduce => const { &[plain(Key::Minus)] },
            Self::Render => const { &[plain(Key::F5), command(Key::R)] },
            Self::ToggleLive => const { &[plain(Key::L)] },
            Self::TogglePause => const { &[plain(Key::P)] },
            Self::DrawRegion => const { &[plain(Key::B)] },
            Self::ClearRegion => const { &[KeyboardShortcut::new(Modifiers::SHIFT, Key::B)] },
            Self::Cancel => const { &[plain(Key::Escape)] },
            Self::EstimateTime => const { &[plain(Key::E)] },
            Self::Report => const { &[command_shift(Key::R)] },
            Self::MeasureCosts => const { &[plain(Key::F7)] },
            Self::ShowShortcuts => const { &[plain(Key::F1), plain(Key::Questionmark)] },
        }
    }

    /// Its first key in words, such as "Ctrl+O".
    #[must_use]
    pub fn shortcut_text(self, ctx: &egui::Context) -> String {
        self.shortcut_texts(ctx).next().unwrap_or_default()
    }

    /// Its keys in words.
    pub fn shortcut_texts(self, ctx: &egui::Context) -> impl Iterator<Item = String> {
        self.shortcuts().iter().map(|keys| match keys.logical_key {
            Key::Questionmark => "?".to_owned(),
            Key::Escape => "Esc".to_owned(),
            Key::Plus => "+".to_owned(),
            Key::Minus => "-".to_owned(),
            Key::Equals => "=".to_owned(),
            _ => ctx.format_shortcut(keys),
        })
    }

    /// Its description and keys, for a tooltip.
    #[must_use]
    pub fn tooltip(self, ctx: &egui::Context) -> String {
        format!("{}  ({})", self.description(), self.shortcut_text(ctx))
    }

    /// Whether its keys mean something to a text field that is being typed into.
    fn is_of_text_fields(self) -> bool {
        matches!(self, Self::Undo | Self::Redo | Self::Copy | Self::Paste)
    }

    /// The commands whose keys were pressed. Keys without Ctrl, and those of texts, belong to a text field that is being typed into.
    #[must_use]
    pub fn pressed(ctx: &egui::Context) -> Vec<Self> {
        let typing = ctx.egui_wants_keyboard_input();
        let in_text_field = ctx.text_edit_focused();
        let in_menu = egui::Popup::is_any_open(ctx);
        let mut candidates: Vec<(KeyboardShortcut, Self)> = Self::ALL
            .into_iter()
            .flat_map(|command| command.shortcuts().iter().map(move |&keys| (keys, command)))
            .filter(|(keys, command)| {
                let is_function_key = matches!(
                    keys.logical_key,
                    Key::F1 | Key::F2 | Key::F5 | Key::F6 | Key::F7 | Key::F8 | Key::F9
                );
                (!typing || keys.modifiers.command || is_function_key)
                    && !(in_text_field && command.is_of_text_fields())
                    // It closes the menu.
                    && !(in_menu && keys.logical_key == Key::Escape)
            })
            .collect();
        // Ctrl+Shift+S also matches a pressed Ctrl+S pattern: ask for the longer one first.
        candidates.sort_by_key(|(keys, _)| !keys.modifiers.shift);
        ctx.input_mut(|input| {
            // A slow frame may bring a key several times.
            let pressed = candidates.into_iter().flat_map(|(keys, command)| {
                let count = input.count_and_consume_key(keys.modifiers, keys.logical_key);
                std::iter::repeat_n(command, count)
            });
            let mut pressed: Vec<Self> = pressed.collect();
            // Desktops say what the keys of the clipboard mean, in place of the keys.
            if !in_text_field {
                pressed.extend(input.events.iter().filter_map(|event| match event {
                    egui::Event::Copy => Some(Self::Copy),
                    egui::Event::Paste(_) => Some(Self::Paste),
                    _ => None,
                }));
            }
            pressed
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_commands_share_a_key_or_a_name() {
        for (index, a) in Command::ALL.iter().enumerate() {
            assert!(!a.label().is_empty() && !a.description().is_empty());
            for b in &Command::ALL[..index] {
                assert_ne!(a.label(), b.label());
                for keys in a.shortcuts() {
                    assert!(!b.shortcuts().contains(keys), "{a:?} and {b:?}");
                }
            }
        }
    }
}

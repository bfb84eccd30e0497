//! What the program has to say where no terminal shows it: somebody started it from an icon of the desktop.

use std::io::IsTerminal as _;

use rfd::{AsyncMessageDialog, MessageLevel};

/// Title of the boxes.
const TITLE: &str = "RayMini";

/// Shows `text` in a box on the desktop, and waits until that is closed. Does nothing where a terminal shows what is told on the standard
/// error, and where there is nothing to show a box with.
pub fn show_on_desktop(text: &str) {
    if is_told_on_a_terminal() {
        return;
    }
    if !LACKS_BOXES || has_program("zenity") {
        // Of all ways this is the one that any thread may go.
        let dialog = AsyncMessageDialog::new().set_level(MessageLevel::Error);
        let dialog = dialog.set_title(TITLE).set_description(text);
        pollster::block_on(dialog.show());
    } else {
        show_by_others(text);
    }
}

/// Whether somebody reads the standard error in a terminal that stays. On Windows a program that is started from an icon gets one that goes
/// with it.
fn is_told_on_a_terminal() -> bool {
    !cfg!(windows) && std::io::stderr().is_terminal()
}

/// Whether boxes are shown by another program, as the system has none of its own. The library knows `zenity` alone.
const LACKS_BOXES: bool = cfg!(all(unix, not(target_os = "macos")));

/// Shows a box by what other desktops have in place of `zenity`.
fn show_by_others(text: &str) {
    let ways: [(&str, &[&str]); 2] = [
        ("kdialog", &["--title", TITLE, "--error", text]),
        ("xmessage", &["-center", text]),
    ];
    let way = ways.iter().find(|(program, _)| has_program(program));
    if let Some((program, arguments)) = way {
        // What cannot be shown is on the standard error.
        let _ = std::process::Command::new(program)
            .args(*arguments)
            .output();
    }
}

/// Whether there is a program of that name where programs are looked for.
fn has_program(name: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).any(|folder| folder.join(name).is_file())
}

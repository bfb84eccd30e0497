//! The desktop's own file dialog, asked for on a thread of its own.
//!
//! The desktop answers through a portal. Where there is none, the path must be typed.

use std::path::{Path, PathBuf};

use super::desktop;
use crate::gui::commands::TextureUse;
use crate::gui::event::Event;
use crate::gui::jobs::Job;
use crate::io::{
    MissingKind, RADIANCE_EXTENSIONS, READABLE_EXTENSIONS, RENDER_EXTENSIONS, TEXTURE_EXTENSIONS,
};

/// What a path is wanted for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilePurpose {
    /// A scene or meshes to open.
    Open,
    /// A mesh to add.
    AddMesh,
    /// An image to make the background.
    SetBackground,
    /// An image to lay on the selected material.
    SetTexture(TextureUse),
    /// A scene file to write.
    SaveScene,
    /// A picture to write.
    SavePicture,
    /// A folder to write a report to.
    ReportFolder,
    /// A picture that a report measures against.
    ReportReference,
    /// A picture to compare with.
    Compare,
    /// A file in place of one that is missing.
    Locate(MissingKind),
}

impl FilePurpose {
    /// What the dialog is called.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Open => "Open scene or mesh",
            Self::AddMesh => "Add mesh",
            Self::SetBackground => "Background image",
            Self::SetTexture(TextureUse::Diffuse) => "Image on the material",
            Self::SetTexture(TextureUse::Normals) => "Image of normals",
            Self::SaveScene => "Save scene",
            Self::SavePicture => "Save picture",
            Self::ReportFolder => "Folder of the report",
            Self::ReportReference => "Reference of the report",
            Self::Compare => "Compare with image",
            Self::Locate(MissingKind::Mesh) => "Locate the mesh",
            Self::Locate(_) => "Locate the image",
        }
    }

    /// What its button does.
    #[must_use]
    pub fn verb(self) -> &'static str {
        match self {
            Self::Open => "Open",
            Self::AddMesh => "Add",
            Self::SetBackground
            | Self::SetTexture(_)
            | Self::ReportFolder
            | Self::ReportReference
            | Self::Locate(_) => "Use",
            Self::SaveScene | Self::SavePicture => "Save",
            Self::Compare => "Compare",
        }
    }

    /// Whether a file is going to be written.
    #[must_use]
    pub fn is_save(self) -> bool {
        matches!(self, Self::SaveScene | Self::SavePicture)
    }

    /// Whether a folder is wanted, not a file.
    #[must_use]
    pub fn is_folder(self) -> bool {
        self == Self::ReportFolder
    }

    /// Extensions of files that fit, without dot.
    #[must_use]
    pub fn extensions(self) -> Vec<&'static str> {
        match self {
            Self::Open => [&["toml"], READABLE_EXTENSIONS, RENDER_EXTENSIONS].concat(),
            Self::AddMesh | Self::Locate(MissingKind::Mesh) => READABLE_EXTENSIONS.to_vec(),
            Self::SetBackground | Self::Locate(MissingKind::Background) => {
                RADIANCE_EXTENSIONS.to_vec()
            }
            Self::SetTexture(_) => TEXTURE_EXTENSIONS.to_vec(),
            // Also those within files of meshes.
            Self::Locate(MissingKind::Texture) => [TEXTURE_EXTENSIONS, &["gltf", "glb"]].concat(),
            Self::SaveScene => vec!["toml"],
            Self::SavePicture => vec!["png", "exr"],
            Self::ReportFolder => Vec::new(),
            Self::ReportReference | Self::Compare => [RADIANCE_EXTENSIONS, &["png"]].concat(),
        }
    }

    /// `path` with the extension that belongs to it, where it names a file to write without one.
    #[must_use]
    pub fn with_extension(self, path: PathBuf) -> PathBuf {
        if self.is_save() && path.extension().is_none() && path.file_name().is_some() {
            path.with_extension(self.extensions()[0])
        } else {
            path
        }
    }
}

/// What the desktop's dialog said.
#[derive(Clone, Debug)]
pub struct Answer {
    /// What it was for.
    pub purpose: FilePurpose,
    /// The chosen files; empty when cancelled.
    pub paths: Vec<PathBuf>,
    /// Whether nobody can have seen the dialog.
    pub nobody_saw_it: bool,
}

/// Shows the desktop's dialog and sends its answer. `suggestion`: the folder to start in and the file name to offer.
pub fn ask(job: &Job<Event>, purpose: FilePurpose, suggestion: &Path) {
    job.send(Event::PathsChosen(answer(purpose, suggestion)));
}

fn answer(purpose: FilePurpose, suggestion: &Path) -> Answer {
    let (paths, was_shown) = desktop::was_shown(|| choose(purpose, suggestion));
    Answer {
        purpose,
        nobody_saw_it: !was_shown,
        paths: paths.unwrap_or_default(),
    }
}

/// The files chosen in the desktop's dialog.
fn choose(purpose: FilePurpose, suggestion: &Path) -> Option<Vec<PathBuf>> {
    let mut dialog = rfd::FileDialog::new().set_title(purpose.title());
    if let Some(folder) = suggestion.parent().filter(|folder| folder.is_dir()) {
        dialog = dialog.set_directory(folder);
    }
    let extensions = purpose.extensions();
    match purpose {
        FilePurpose::Open => dialog
            .add_filter("Scenes and meshes", &extensions)
            .pick_files(),
        FilePurpose::AddMesh => dialog.add_filter("Meshes", &extensions).pick_files(),
        FilePurpose::SetBackground => dialog
            .add_filter("Images of radiance", &extensions)
            .pick_file()
            .map(|path| vec![path]),
        FilePurpose::Locate(MissingKind::Mesh) => dialog
            .add_filter("Meshes", &extensions)
            .pick_file()
            .map(|path| vec![path]),
        FilePurpose::SetTexture(_) | FilePurpose::Locate(_) => dialog
            .add_filter("Images", &extensions)
            .pick_file()
            .map(|path| vec![path]),
        FilePurpose::ReportFolder => dialog.pick_folder().map(|path| vec![path]),
        FilePurpose::ReportReference | FilePurpose::Compare => dialog
            .add_filter("Pictures", &extensions)
            .pick_file()
            .map(|path| vec![path]),
        FilePurpose::SaveScene | FilePurpose::SavePicture => {
            if let Some(name) = suggestion.file_name() {
                dialog = dialog.set_file_name(name.to_string_lossy());
            }
            for extension in extensions {
                dialog = dialog.add_filter(extension.to_uppercase(), &[extension]);
            }
            dialog.save_file().map(|path| vec![path])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_to_write_get_an_extension() {
        let picture = |name: &str| FilePurpose::SavePicture.with_extension(name.into());
        assert_eq!(picture("ram"), Path::new("ram.png"));
        assert_eq!(picture("ram.exr"), Path::new("ram.exr"));
        assert_eq!(
            FilePurpose::Open.with_extension("ram".into()),
            Path::new("ram")
        );
    }

    /// The environment of [`asks_the_desktop`] says what it is to ask for.
    #[cfg(target_os = "linux")]
    const ASKED_FOR: &str = "RAYMINI_TEST_DIALOG";

    /// Not a test by itself: [`the_desktop`] runs it in a process of its own, whose desktop is what that makes it.
    #[cfg(target_os = "linux")]
    #[test]
    fn asks_the_desktop() {
        let purpose = match std::env::var(ASKED_FOR).as_deref() {
            Ok("open") => FilePurpose::Open,
            Ok("save") => FilePurpose::SaveScene,
            Ok("folder") => FilePurpose::ReportFolder,
            _ => return,
        };
        println!("{:?}", answer(purpose, Path::new("/")));
    }

    /// What is answered where the session bus is at `bus` and programs are looked for in `programs`.
    #[cfg(target_os = "linux")]
    fn the_desktop(asked_for: &str, bus: &str, programs: &Path) -> String {
        let test = "gui::dialogs::files::tests::asks_the_desktop";
        let output = std::process::Command::new(std::env::current_exe().unwrap())
            .args(["--exact", test, "--nocapture"])
            .env(ASKED_FOR, asked_for)
            .env("DBUS_SESSION_BUS_ADDRESS", bus)
            .env("PATH", programs)
            .output()
            .unwrap();
        String::from_utf8(output.stdout).unwrap()
    }

    /// Also where it takes its time to fail, as on a busy machine.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_desktop_without_dialog_is_no_user_who_cancels() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let fails_at_once = "unix:path=/nowhere/bus";
        let fails_late = "unixexec:path=/bin/sleep,argv1=0.5";
        for bus in [fails_at_once, fails_late] {
            for asked_for in ["open", "save", "folder"] {
                let answer = the_desktop(asked_for, bus, folder.path());
                assert!(answer.contains("paths: []"), "{answer}");
                assert!(answer.contains("nobody_saw_it: true"), "{bus}: {answer}");
            }
        }
        // Without a portal there may be zenity, in which a user cancels at once, or chooses.
        let zenity = folder.path().join("zenity");
        let make_zenity = |script: &str| {
            std::fs::write(&zenity, format!("#!/bin/sh\n{script}\n")).unwrap();
            std::fs::set_permissions(&zenity, PermissionsExt::from_mode(0o755)).unwrap();
        };
        for asked_for in ["open", "save", "folder"] {
            make_zenity("exit 1");
            let answer = the_desktop(asked_for, fails_at_once, folder.path());
            assert!(
                answer.contains("paths: [], nobody_saw_it: false"),
                "{answer}"
            );
            make_zenity("echo /a/b.toml");
            let answer = the_desktop(asked_for, fails_at_once, folder.path());
            assert!(answer.contains("paths: [\"/a/b.toml\"]"), "{answer}");
        }
    }
}

//! `raymini check SCENE`: what may spoil the picture of a scene, where it is, and what to do about it.

use std::path::Path;
use std::time::Instant;

use anyhow::{Result, anyhow};
use serde::Serialize;

use crate::analysis::hazards::{self, Hazard, HazardKind, Place, Severity, Subject};
use crate::control::CancelToken;
use crate::io::{READ_FROM_OUTSIDE, STRETCHED};

/// What is printed.
#[derive(Debug, Serialize)]
struct Facts {
    scene: String,
    hazards: Vec<Hazard>,
    /// What was found while the files were read.
    warnings: Vec<String>,
    seconds: f64,
}

/// Examines the scene of a file and prints what is found.
pub(super) fn run(path: &Path, json: bool) -> Result<()> {
    let started = Instant::now();
    let loaded = crate::cli::load(Some(path))?;
    let hazards = hazards::examine(&loaded.scene, &CancelToken::new())?
        .ok_or_else(|| anyhow!("examining was cancelled"))?;
    let facts = Facts {
        scene: path.display().to_string(),
        warnings: told_once(loaded.warnings, &hazards),
        hazards,
        seconds: started.elapsed().as_secs_f64(),
    };
    if json {
        crate::cli::say_json(&facts)
    } else {
        crate::cli::say(&describe(&facts))
    }
}

/// The `warnings` of reading files without those that `hazards` tell with more about them.
fn told_once(mut warnings: Vec<String>, hazards: &[Hazard]) -> Vec<String> {
    let told: Vec<_> = hazards
        .iter()
        .filter(|hazard| hazard.kind == HazardKind::LostDigits)
        .map(|hazard| hazard.message.as_str())
        .collect();
    warnings.retain(|warning| !told.iter().any(|told| warning.contains(told)));
    warnings
}

/// The facts as lines for people: each hazard in one line, with where it is and what to do below.
fn describe(facts: &Facts) -> String {
    let of = |severity| facts.hazards.iter().filter(move |h| h.severity == severity);
    let warnings = of(Severity::Warning).count() + facts.warnings.len();
    let notes = of(Severity::Note).count();
    let counts = [(warnings, "warning"), (notes, "note")]
        .into_iter()
        .filter(|&(count, _)| count > 0)
        .map(|(count, name)| format!("{count} {name}{}", if count == 1 { "" } else { "s" }));
    let found = counts.collect::<Vec<_>>().join(", ");
    let mut lines = vec![format!(
        "{}: {}, in {:.1} s",
        facts.scene,
        if found.is_empty() {
            "nothing found"
        } else {
            &found
        },
        facts.seconds
    )];
    for warning in &facts.warnings {
        lines.push(format!("warning: {}", shortened(warning)));
        lines.extend(advice_on(warning).map(|advice| format!("    {advice}")));
    }
    for hazard in &facts.hazards {
        let severity = match hazard.severity {
            Severity::Warning => "warning",
            Severity::Note => "note",
        };
        let subject = describe_subject(&hazard.subject);
        lines.push(format!("{severity}: {subject}{}", hazard.message));
        if !hazard.places.is_empty() {
            let left = hazard.count.saturating_sub(hazard.places.len() as u64);
            lines.push(format!("    at {}", describe_places(&hazard.places, left)));
        }
        lines.push(format!("    {}", hazard.advice));
    }
    lines.join("\n")
}

/// What to do about a warning of reading files; `None` where it says that itself.
fn advice_on(warning: &str) -> Option<&'static str> {
    let says = |words: &[&str]| words.iter().any(|words| warning.contains(words));
    if says(&[READ_FROM_OUTSIDE]) {
        Some(
            "See whether you want this file read. A copy in the folder of the scene file is found on other machines too.",
        )
    } else if says(&["write it again"]) {
        None
    } else if says(&[STRETCHED]) {
        Some(
            "Take an image of all directions, twice as wide as high, unless the stretched one is what you want.",
        )
    } else if says(&["left out", "dropped", "no triangles"]) {
        Some("Repair the file, unless what is left out is not missed.")
    } else {
        Some("Look at the picture there; where it is not what you want, repair the file.")
    }
}

/// What a hazard is about, with a colon; nothing for the whole picture.
fn describe_subject(subject: &Subject) -> String {
    match subject {
        Subject::Mesh {
            mesh,
            objects,
            copies,
        } => format!(
            "{} ({}): ",
            shortened(mesh),
            places_of_mesh(objects, *copies)
        ),
        Subject::Object {
            object,
            mesh,
            copies,
        } => {
            let objects = std::slice::from_ref(object);
            format!(
                "{} ({}): ",
                shortened(mesh),
                places_of_mesh(objects, *copies)
            )
        }
        Subject::Pair { objects, meshes } => {
            let [a, b] = [0, 1].map(|i| named(&objects[i], &meshes[i]));
            format!("{a} and {b}: ")
        }
        Subject::Light {
            light,
            object,
            mesh,
        } => format!("light {light} at {}: ", named(object, mesh)),
        Subject::Material { material, objects } if objects.is_empty() => {
            format!("material \"{material}\", which no object has: ")
        }
        Subject::Material { material, objects } => {
            format!("material \"{material}\" ({}): ", objects_of(objects))
        }
        Subject::Picture {} => String::new(),
    }
}

/// The most objects that are named in a line.
const MOST_NAMED: usize = 3;

fn objects_of(objects: &[String]) -> String {
    let names = objects.iter().filter(|name| !name.is_empty());
    let quoted: Vec<_> = names
        .take(MOST_NAMED)
        .map(|name| format!("\"{name}\""))
        .collect();
    let left = objects.len() - quoted.len();
    match (quoted.is_empty(), left) {
        (true, 1) => "one object".to_owned(),
        (true, _) => format!("{left} objects"),
        (false, 0) if quoted.len() == 1 => format!("object {}", quoted[0]),
        (false, 0) => format!("objects {}", quoted.join(", ")),
        (false, _) => format!("objects {} and {left} more", quoted.join(", ")),
    }
}

fn places_of_mesh(objects: &[String], copies: u64) -> String {
    let objects_of = objects_of(objects);
    if copies == objects.len() as u64 {
        objects_of
    } else {
        format!("{objects_of}; in each of {copies} copies")
    }
}

/// An object by its name, or by its mesh where it has none.
fn named(object: &str, mesh: &str) -> String {
    if object.is_empty() {
        shortened(mesh).to_owned()
    } else {
        format!("object \"{object}\"")
    }
}

/// A path without the folder the program runs in.
fn shortened(path: &str) -> &str {
    let here = std::env::current_dir().ok();
    let here = here.as_deref().and_then(Path::to_str).unwrap_or_default();
    match path.strip_prefix(here) {
        Some(rest) if !here.is_empty() => rest.strip_prefix(['/', '\\']).unwrap_or(path),
        _ => path,
    }
}

fn describe_places(places: &[Place], left: u64) -> String {
    let mut places: Vec<_> = places.iter().map(describe_place).collect();
    // Samples of one pixel are in one place.
    places.dedup();
    if left > 0 {
        places.push(format!("and {left} more"));
    }
    places.join("; ")
}

fn describe_place(place: &Place) -> String {
    let faces: Vec<_> = place.faces.iter().map(usize::to_string).collect();
    let faces = match faces.len() {
        0 => String::new(),
        1 => format!("face {} ", faces[0]),
        _ => format!("faces {} ", faces.join(", ")),
    };
    let position = place
        .position
        .map(|position| format!("({})", position.map(coordinate).join(", ")));
    let pixel = place.pixel.map(|[x, y]| format!("pixel ({x}, {y})"));
    format!("{faces}{}", position.or(pixel).unwrap_or_default())
}

/// A coordinate with six digits, enough to find the place; no zeros at the end.
fn coordinate(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    if rounded == 0.0 || (1e-4..1e9).contains(&rounded.abs()) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_have_six_digits_at_most() {
        for (value, expected) in [
            (0.0, "0"),
            (1.0, "1"),
            (-0.333_333_333, "-0.333333"),
            (333_333.333, "333333"),
            (1_234_567.8, "1234570"),
            (0.000_012_345_67, "1.23457e-5"),
            (1.5e20, "1.5e20"),
        ] {
            assert_eq!(coordinate(value), expected);
        }
    }

    /// A file that is read from elsewhere is not broken, and need not be repaired.
    #[test]
    fn advice_is_about_what_the_warning_is_about() {
        let folder = tempfile::TempDir::new().expect("a folder");
        let write = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().expect("has one")).expect("a folder");
            std::fs::write(&path, text).expect("is written");
            path
        };
        // The second face has no area.
        let mesh = "OFF 3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 1\n";
        write("elsewhere/mesh.off", mesh);
        let scene = "[[objects]]\nmesh = \"../../elsewhere/mesh.off\"\n";
        let scene = write("project/scenes/scene.toml", scene);
        let loaded = crate::cli::load(Some(&scene)).expect("is right");
        let of = |words: &str| {
            let mut all = loaded.warnings.iter();
            let warning = all.find(|warning| warning.contains(words));
            let warning = warning.unwrap_or_else(|| panic!("{words}: {:?}", loaded.warnings));
            advice_on(warning).expect("there is something to do")
        };
        let outside = of("outside of");
        assert!(
            outside.contains("copy") && !outside.contains("Repair"),
            "{outside}"
        );
        assert!(of("dropped").starts_with("Repair the file"));
    }
}

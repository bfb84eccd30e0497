//! Scene files: TOML, strict. A key nobody knows, a value of the wrong kind or out of range, a material that is not defined: each
//! is an error that names file, line, column, and what was expected.

mod keys;
mod records;
mod spelling;
mod tree;

use std::fmt;

use super::part_name;
use super::shorten::shortened;
use crate::scene::Scene;
use keys::Keys;
use spelling::nearest;
use tree::{Node, Place};

/// Something a scene file says that cannot be understood.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneFileError {
    /// File, line and column, or the `--set` that said it.
    pub at: String,
    /// What is wrong and what was expected.
    pub message: String,
    /// Where `at` is, in a text or among assignments.
    place: Option<Place>,
}

impl SceneFileError {
    fn at(name: &str, place: Place, message: String) -> Self {
        Self {
            at: format!("{name}:{}:{}", place.line, place.column),
            message,
            place: Some(place),
        }
    }

    fn of_assignments(assignments: &[String], message: String) -> Self {
        Self {
            at: format!("--set {}", assignments.join(" --set ")),
            message,
            place: None,
        }
    }
}

impl fmt::Display for SceneFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.at, self.message)
    }
}

impl std::error::Error for SceneFileError {}

/// A parsed scene file: the description, and where its values stand.
#[derive(Clone, Debug)]
pub struct SceneFile {
    /// What the file describes; its meshes are not loaded.
    pub scene: Scene,
    name: String,
    tree: Node,
}

impl SceneFile {
    /// Reads the scene in `text`; `name` stands for the file in messages.
    ///
    /// # Errors
    /// The first mistake in the order of the file.
    pub fn parse(text: &str, name: &str) -> Result<Self, SceneFileError> {
        let tree = Node::parse(text, name)?;
        let scene = read(&tree, name)?;
        Ok(Self {
            scene,
            name: name.to_owned(),
            tree,
        })
    }

    /// An error about the value of a dotted `key`, such as `objects.0.mesh`, at its place in the file.
    #[must_use]
    pub fn error_at(&self, key: &str, message: String) -> SceneFileError {
        SceneFileError::at(&self.name, self.tree.place_of(key), message)
    }
}

/// The description as the text of a scene file. Reading it gives the same description.
#[must_use]
pub fn write(scene: &Scene) -> String {
    let mut text = String::new();
    // Keys are visited by one function for reading and writing, which takes its scene mutably.
    records::scene(&mut Keys::writing(&mut text), &mut scene.clone());
    text.trim_start().to_owned()
}

/// Changes values: each assignment is `KEY=VALUE` with a dotted key, list items by number (`objects.0.scale=2`), and a TOML
/// value; quotes around a single word may be left out. All are applied before any is judged, but for those that say a key which another
/// one says again. Keys that another one excludes go:
/// those of the former kind with a new `kind` or another kind of background, `normal` with `target`. Meshes and images stay as
/// they are.
///
/// # Errors
/// What about a key or value cannot be understood.
///
/// # Panics
/// When `scene` holds a value that no scene file can say, such as a number that is not finite.
pub fn apply_overrides(scene: &Scene, assignments: &[String]) -> Result<Scene, SceneFileError> {
    let mut tree = Node::parse(&write(scene), "scene").expect("a written scene can be read");
    for (number, assignment) in assignments.iter().enumerate() {
        let place = Place {
            line: ASSIGNED,
            column: number,
        };
        if let Some((number, message)) = replaced(&mut tree, assignment) {
            let blamed = &assignments[number..=number];
            return Err(SceneFileError::of_assignments(blamed, message));
        }
        if let Err(message) = assign(&mut tree, assignment, place) {
            let (number, message) = spoiled(&tree, assignment).unwrap_or((number, message));
            let blamed = &assignments[number..=number];
            return Err(SceneFileError::of_assignments(blamed, message));
        }
    }
    let mut changed = read(&tree, "scene").map_err(|problem| {
        // Where it is what the scene had that does not go with the new values, any of them may be to blame.
        let blamed = match problem.place {
            Some(Place { line, column }) if line == ASSIGNED => &assignments[column..=column],
            _ => assignments,
        };
        SceneFileError::of_assignments(blamed, problem.message)
    })?;
    changed.meshes.clone_from(&scene.meshes);
    changed.images.clone_from(&scene.images);
    changed.textures.clone_from(&scene.textures);
    Ok(changed)
}

/// What is wrong with an assignment before this one, and its number, where this one says the same key again: nobody would judge it after.
fn replaced(tree: &mut Node, assignment: &str) -> Option<(usize, String)> {
    let (path, _) = assignment.split_once('=')?;
    let place = tree.place_at(path.trim())?;
    wrong_at(tree, place)
}

/// What is wrong with an assignment before this one, and its number, where it has put a value in the place of what this one is to change
/// a part of.
fn spoiled(tree: &Node, assignment: &str) -> Option<(usize, String)> {
    let (path, _) = assignment.split_once('=')?;
    wrong_at(tree, tree.place_of(path.trim()))
}

/// What is wrong with the assignment that stands at `place`, and its number.
fn wrong_at(tree: &Node, place: Place) -> Option<(usize, String)> {
    if place.line != ASSIGNED {
        return None;
    }
    let problem = read(tree, "scene").err()?;
    (problem.place == Some(place)).then_some((place.column, problem.message))
}

/// The line, which no text has, of what assignments say; their number is the column.
const ASSIGNED: usize = 0;

/// Puts one assignment into the tree of a scene, as what stands at `place`.
fn assign(tree: &mut Node, assignment: &str, place: Place) -> Result<(), String> {
    let parts = assignment.split_once('=');
    let parts = parts.map(|(path, value)| (path.trim(), value.trim()));
    let Some((path, value)) = parts.filter(|(path, _)| !path.is_empty()) else {
        return Err("expected KEY=VALUE, such as render.width=800".to_owned());
    };
    let mut node = parse_value(value).ok_or_else(|| {
        let value = shortened(value);
        format!("\"{value}\" is no value; expected one such as 2.5, true, soft, \"two words\" or [1, 2, 3]")
    })?;
    node.put_at(place);
    if tree.get(path).is_none()
        && let Some(longer) = tree.path_to(path)
    {
        return Err(format!("unknown key `{path}`; there is `{longer}`"));
    }
    let (table, key) = path.rsplit_once('.').unwrap_or(("", path));
    match (table, key) {
        ("background", _) => records::excluded_by(key)
            .iter()
            .for_each(|other| tree.remove(&format!("background.{other}"))),
        (_, "target") if table != "camera" => tree.remove(&format!("{table}.normal")),
        (_, "normal") => tree.remove(&format!("{table}.target")),
        (_, "kind") if tree.text_at(path) != node.text() => tree.clear(table),
        _ => {}
    }
    tree.set(path, node)
}

/// A TOML value, or a bare word as a text.
fn parse_value(text: &str) -> Option<Node> {
    let parse = |value: &str| {
        let tree = Node::parse(&format!("value = {value}"), "").ok()?;
        Some(tree.get("value")?.node.clone())
    };
    let is_word = |c: char| c.is_ascii_alphanumeric() || "-_./:".contains(c);
    parse(text).or_else(|| {
        if text.chars().all(is_word) {
            parse(&format!("\"{text}\""))
        } else {
            None
        }
    })
}

fn read(tree: &Node, name: &str) -> Result<Scene, SceneFileError> {
    let mut scene = Scene::default();
    let mut problems = Vec::new();
    records::scene(&mut Keys::reading(tree, name, &mut problems), &mut scene);
    if let Some(first) = problems.into_iter().next() {
        return Err(first);
    }
    check_materials(tree, name, &scene)?;
    scene.validate().map_err(|problem| {
        let place = tree.place_of(problem.key().unwrap_or_default());
        SceneFileError::at(name, place, problem.to_string())
    })?;
    name_objects(&mut scene);
    Ok(scene)
}

/// Every material that an object names must be there.
fn check_materials(tree: &Node, name: &str, scene: &Scene) -> Result<(), SceneFileError> {
    for (index, object) in scene.objects.iter().enumerate() {
        let Some(material) = &object.material else {
            continue;
        };
        if !scene.materials.contains_key(material) {
            let known = match nearest(material, scene.materials.keys().map(String::as_str)) {
                Some(nearest) => format!("the nearest defined one is \"{}\"", shortened(nearest)),
                None => "none is defined".to_owned(),
            };
            let place = tree.place_of(&format!("objects.{index}.material"));
            let material = shortened(material);
            let message = format!("material \"{material}\" is not defined; {known}");
            return Err(SceneFileError::at(name, place, message));
        }
    }
    Ok(())
}

/// Objects without a name get that of their mesh file, or of their part of it.
fn name_objects(scene: &mut Scene) {
    let objects = scene.objects.iter_mut();
    for object in objects.filter(|object| object.name.is_empty()) {
        object.name = part_name::short_name(&object.mesh).to_owned();
    }
}

#[cfg(test)]
mod tests;

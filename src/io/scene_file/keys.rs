//! One description of every key serves reading and writing: a record's function names its keys in order, and [`Keys`] either
//! fills the values from a file or prints them. What is written can therefore always be read back.

mod values;

use std::collections::BTreeMap;
use std::fmt::Write;

use super::SceneFileError;
use super::spelling::{counterpart, distance, is_near, nearest};
use super::tree::{Entry, Node, Value};
use crate::io::shorten::shortened;

pub use values::Allowed;

/// The most keys that a message names all of.
const MOST_LISTED: usize = 10;
/// How many of more it names.
const NEAREST: usize = 3;

/// The keys of one table, being read or written.
pub struct Keys<'a> {
    /// Dotted path of the table, empty for the root.
    path: String,
    direction: Direction<'a>,
}

enum Direction<'a> {
    Reading {
        table: &'a Node,
        known: Vec<&'static str>,
        problems: &'a mut Vec<SceneFileError>,
        name: &'a str,
    },
    Writing {
        text: &'a mut String,
    },
}

impl<'a> Keys<'a> {
    /// Reads the root table `table` of the file called `name`; collects what is wrong in `problems`.
    pub fn reading(table: &'a Node, name: &'a str, problems: &'a mut Vec<SceneFileError>) -> Self {
        Self {
            path: String::new(),
            direction: Direction::Reading {
                table,
                known: Vec::new(),
                problems,
                name,
            },
        }
    }

    /// Appends the root table to `text`.
    pub fn writing(text: &'a mut String) -> Self {
        Self {
            path: String::new(),
            direction: Direction::Writing { text },
        }
    }

    /// Whether this fills values from a file.
    pub fn is_reading(&self) -> bool {
        matches!(self.direction, Direction::Reading { .. })
    }

    /// Whether a table being read has `key`; false while writing.
    pub fn has(&self, key: &str) -> bool {
        matches!(&self.direction, Direction::Reading { table, .. } if table.get(key).is_some())
    }

    /// Says that `key` does not go with the table's other keys.
    pub fn refuse(&mut self, key: &'static str, reason: &str) {
        if let Direction::Reading {
            table,
            known,
            problems,
            name,
        } = &mut self.direction
        {
            known.push(key);
            if let Some(entry) = table.get(key) {
                problems.push(SceneFileError::at(
                    name,
                    entry.place,
                    format!("`{key}` {reason}"),
                ));
            }
        }
    }

    /// A table of its own.
    pub fn record(&mut self, key: &'static str, fields: impl FnOnce(&mut Keys<'_>)) {
        self.know(key);
        let path = self.child_path(key);
        match &mut self.direction {
            Direction::Reading {
                table,
                problems,
                name,
                ..
            } => {
                if let Some(entry) = table.get(key) {
                    read_table(&entry.node, path, name, problems, fields);
                }
            }
            Direction::Writing { text } => {
                write_table(text, &format!("[{path}]"), path, fields);
            }
        }
    }

    /// Tables by name, as in `[materials.clay]`.
    pub fn map<T: Default>(
        &mut self,
        key: &'static str,
        map: &mut BTreeMap<String, T>,
        fields: impl Fn(&mut Keys<'_>, &mut T),
    ) {
        self.know(key);
        let path = self.child_path(key);
        match &mut self.direction {
            Direction::Reading {
                table,
                problems,
                name,
                ..
            } => {
                let Some(entry) = table.get(key) else { return };
                let Value::Table(entries) = &entry.node.value else {
                    problems.push(wrong_kind(name, &entry.node, &path, "tables by name"));
                    return;
                };
                for entry in entries {
                    let path = format!("{path}.{}", entry.key);
                    let Some(item) = read_item(&entry.node, path, name, problems, &fields) else {
                        return;
                    };
                    map.insert(entry.key.clone(), item);
                }
            }
            Direction::Writing { text } => {
                for (item_name, item) in map {
                    let path = format!("{path}.{}", key_text(item_name));
                    write_table(text, &format!("[{path}]"), path, |keys| fields(keys, item));
                }
            }
        }
    }

    /// A list of tables, as in `[[objects]]`.
    pub fn list<T: Default>(
        &mut self,
        key: &'static str,
        list: &mut Vec<T>,
        fields: impl Fn(&mut Keys<'_>, &mut T),
    ) {
        self.know(key);
        let path = self.child_path(key);
        match &mut self.direction {
            Direction::Reading {
                table,
                problems,
                name,
                ..
            } => {
                let Some(entry) = table.get(key) else { return };
                let Value::Array(items) = &entry.node.value else {
                    problems.push(wrong_kind(
                        name,
                        &entry.node,
                        &path,
                        &format!("a list: write [[{path}]]"),
                    ));
                    return;
                };
                for (index, node) in items.iter().enumerate() {
                    let path = format!("{path}.{index}");
                    let Some(item) = read_item(node, path, name, problems, &fields) else {
                        return;
                    };
                    list.push(item);
                }
            }
            Direction::Writing { text } => {
                let header = format!("[[{path}]]");
                for item in list {
                    write_table(text, &header, path.clone(), |keys| fields(keys, item));
                }
            }
        }
    }

    /// Reads or writes one key with a value of its own.
    fn field<T>(
        &mut self,
        key: &'static str,
        value: &mut T,
        parse: impl FnOnce(&Node) -> Result<T, String>,
        print: impl FnOnce(&T) -> String,
    ) {
        self.know(key);
        let path = self.child_path(key);
        match &mut self.direction {
            Direction::Reading {
                table,
                problems,
                name,
                ..
            } => {
                let Some(entry) = table.get(key) else { return };
                match parse(&entry.node) {
                    Ok(parsed) => *value = parsed,
                    Err(expected) => problems.push(wrong_kind(name, &entry.node, &path, &expected)),
                }
            }
            Direction::Writing { text } => {
                let _ = writeln!(text, "{key} = {}", print(value));
            }
        }
    }

    /// Makes `key` one that may be written here.
    pub fn know(&mut self, key: &'static str) {
        if let Direction::Reading { known, .. } = &mut self.direction
            && !known.contains(&key)
        {
            known.push(key);
        }
    }

    fn child_path(&self, key: &str) -> String {
        if self.path.is_empty() {
            key.to_owned()
        } else {
            format!("{}.{key}", self.path)
        }
    }

    /// Reports the first key of the table that nobody asked for.
    pub fn finish(&mut self) {
        let Direction::Reading {
            table,
            known,
            problems,
            name,
        } = &mut self.direction
        else {
            return;
        };
        let Value::Table(entries) = &table.value else {
            return;
        };
        let is_unknown = |entry: &&Entry| !known.contains(&entry.key.as_str());
        if let Some(entry) = entries.iter().find(is_unknown) {
            let key = shortened(&entry.key);
            let counterpart = counterpart(&entry.key).filter(|name| known.contains(name));
            let nearest = nearest(&entry.key, known.iter().copied());
            let instead = match (counterpart, nearest) {
                (Some(name), _) => format!("here it is called `{name}`"),
                (_, Some(nearest)) if is_near(&entry.key, nearest) => {
                    format!("the nearest known one is `{nearest}`")
                }
                (_, Some(_)) if known.len() > MOST_LISTED => {
                    known.sort_by_key(|known| distance(&entry.key, known));
                    let (nearest, all) = (known[..NEAREST].join(", "), known.len());
                    format!("the nearest of the {all} known here are {nearest}")
                }
                (_, Some(_)) => format!("known here: {}", known.join(", ")),
                (_, None) => "no key is known here".to_owned(),
            };
            let message = format!("unknown key `{key}`; {instead}");
            problems.push(SceneFileError::at(name, entry.place, message));
        }
    }
}

/// Reads the table `node` with `fields`.
fn read_table(
    node: &Node,
    path: String,
    name: &str,
    problems: &mut Vec<SceneFileError>,
    fields: impl FnOnce(&mut Keys<'_>),
) {
    if !matches!(node.value, Value::Table(_)) {
        problems.push(wrong_kind(name, node, &path, "a table"));
        return;
    }
    let mut keys = Keys {
        path,
        direction: Direction::Reading {
            table: node,
            known: Vec::new(),
            problems,
            name,
        },
    };
    fields(&mut keys);
    keys.finish();
}

/// Reads the table `node` as one of several; `None` where something was wrong before.
fn read_item<T: Default>(
    node: &Node,
    path: String,
    name: &str,
    problems: &mut Vec<SceneFileError>,
    fields: impl Fn(&mut Keys<'_>, &mut T),
) -> Option<T> {
    if !problems.is_empty() {
        return None;
    }
    let mut item = T::default();
    read_table(node, path, name, problems, |keys| fields(keys, &mut item));
    Some(item)
}

/// Writes a table with `fields`, below its `header`.
fn write_table(text: &mut String, header: &str, path: String, fields: impl FnOnce(&mut Keys<'_>)) {
    let _ = write!(text, "\n{header}\n");
    fields(&mut Keys {
        path,
        direction: Direction::Writing { text },
    });
}

fn wrong_kind(name: &str, node: &Node, path: &str, expected: &str) -> SceneFileError {
    SceneFileError::at(
        name,
        node.place,
        format!("`{path}` is {}; expected {expected}", node.describe()),
    )
}

/// A key as TOML writes it: bare where it can be, else in quotes on one line, which a text with line breaks is not.
fn key_text(key: &str) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !key.is_empty() && key.chars().all(bare) {
        return key.to_owned();
    }
    let mut text = "\"".to_owned();
    for c in key.chars() {
        let _ = match c {
            '"' | '\\' => write!(text, "\\{c}"),
            c if c.is_control() => write!(text, "\\u{:04x}", u32::from(c)),
            c => write!(text, "{c}"),
        };
    }
    text + "\""
}

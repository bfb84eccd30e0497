//! One description of every key serves reading and writing: a record's function names its keys in order, and [`Keys`] either
//! fills the values from a file or prints them. What is written can therefore always be read back.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::SceneFileError;
use super::tree::{Entry, Node, Value};
use crate::io::shorten::shortened;
use crate::math::DVec3;
use crate::scene::Choice;

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

/// Which numbers a key takes.
#[derive(Clone, Copy, Debug)]
pub enum Allowed {
    /// Every finite number.
    Any,
    /// Every finite number but 0.
    NonZero,
    /// Every finite number above 0.
    Positive,
    /// Every number above 0, infinity too.
    PositiveOrInfinite,
    /// 0 and above.
    NotNegative,
    /// Between the two, both excluded.
    Between(f64, f64),
    /// From the first to the second, both included.
    Within(f64, f64),
}

impl Allowed {
    fn contains(self, number: f64) -> bool {
        (number.is_finite() || matches!(self, Self::PositiveOrInfinite))
            && match self {
                Self::Any => true,
                Self::NonZero => number != 0.0,
                Self::Positive | Self::PositiveOrInfinite => number > 0.0,
                Self::NotNegative => number >= 0.0,
                Self::Between(low, high) => low < number && number < high,
                Self::Within(low, high) => low <= number && number <= high,
            }
    }

    fn describe(self) -> String {
        match self {
            Self::Any => "a finite number".to_owned(),
            Self::NonZero => "a finite number other than 0".to_owned(),
            Self::Positive => "a finite number above 0".to_owned(),
            Self::PositiveOrInfinite => "a number above 0, or inf".to_owned(),
            Self::NotNegative => "a finite number of at least 0".to_owned(),
            Self::Between(low, high) => format!("a number above {low} and below {high}"),
            Self::Within(low, high) => format!("a number from {low} to {high}"),
        }
    }
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

    /// A number.
    pub fn number(&mut self, key: &'static str, value: &mut f64, allowed: Allowed) {
        let parse = |node: &Node| {
            number_of(node)
                .filter(|&n| allowed.contains(n))
                .ok_or_else(|| allowed.describe())
        };
        self.field(key, value, parse, |number| format_number(*number));
    }

    /// A number that need not be there.
    pub fn optional_number(
        &mut self,
        key: &'static str,
        value: &mut Option<f64>,
        allowed: Allowed,
    ) {
        match value {
            None if !self.has(key) => self.know(key),
            _ => {
                let mut number = value.unwrap_or_default();
                self.number(key, &mut number, allowed);
                *value = Some(number);
            }
        }
    }

    /// A whole number from `range`.
    pub fn integer<T>(
        &mut self,
        key: &'static str,
        value: &mut T,
        range: std::ops::RangeInclusive<T>,
    ) where
        T: Copy + PartialOrd + std::fmt::Display + TryFrom<i64>,
    {
        let parse = |node: &Node| {
            let integer = if let Value::Integer(number) = node.value {
                T::try_from(number).ok()
            } else {
                None
            };
            let expected = || format!("a whole number from {} to {}", range.start(), range.end());
            integer
                .filter(|number| range.contains(number))
                .ok_or_else(expected)
        };
        self.field(key, value, parse, T::to_string);
    }

    /// A whole number from `range` that need not be there.
    pub fn optional_integer(
        &mut self,
        key: &'static str,
        value: &mut Option<u32>,
        range: std::ops::RangeInclusive<u32>,
    ) {
        match value {
            None if !self.has(key) => self.know(key),
            _ => {
                let mut number = value.unwrap_or(*range.start());
                self.integer(key, &mut number, range);
                *value = Some(number);
            }
        }
    }

    /// `true` or `false`.
    pub fn flag(&mut self, key: &'static str, value: &mut bool) {
        let parse = |node: &Node| match node.value {
            Value::Flag(flag) => Ok(flag),
            _ => Err("true or false".to_owned()),
        };
        self.field(key, value, parse, bool::to_string);
    }

    /// A text.
    pub fn text(&mut self, key: &'static str, value: &mut String) {
        self.field(key, value, text_of, |text| quoted(text));
    }

    /// A text that a file must give.
    pub fn required_text(&mut self, key: &'static str, value: &mut String) {
        self.text(key, value);
        let missing = !self.has(key);
        if let Direction::Reading {
            table,
            problems,
            name,
            ..
        } = &mut self.direction
            && missing
        {
            problems.push(SceneFileError::at(
                name,
                table.place,
                format!("the key `{key}` is missing here"),
            ));
        }
    }

    /// A text that need not be there.
    pub fn optional_text(&mut self, key: &'static str, value: &mut Option<String>) {
        match value {
            None if !self.has(key) => self.know(key),
            _ => {
                let mut text = value.take().unwrap_or_default();
                self.text(key, &mut text);
                *value = Some(text);
            }
        }
    }

    /// One of the named values of `T`.
    pub fn choice<T: Choice>(&mut self, key: &'static str, value: &mut T) {
        let parse = |node: &Node| {
            let found = match &node.value {
                Value::Text(text) => T::ALL.iter().find(|(_, name)| name == text),
                _ => None,
            };
            let names = || {
                T::ALL
                    .iter()
                    .map(|(_, name)| quoted(name))
                    .collect::<Vec<_>>()
                    .join(", ")
            };
            found
                .map(|(choice, _)| *choice)
                .ok_or_else(|| match T::ALL.len() {
                    1 => names(),
                    _ => format!("one of {}", names()),
                })
        };
        self.field(key, value, parse, |choice| quoted(choice.name()));
    }

    /// One of a few whole numbers, each with a meaning of its own.
    pub fn numbered_choice<T: Copy + PartialEq>(
        &mut self,
        key: &'static str,
        value: &mut T,
        all: &[(T, i64)],
    ) {
        let parse = |node: &Node| {
            let found = all
                .iter()
                .find(|(_, number)| matches!(node.value, Value::Integer(n) if n == *number));
            let numbers = || {
                all.iter()
                    .map(|(_, number)| number.to_string())
                    .collect::<Vec<_>>()
                    .join(" or ")
            };
            found.map(|(choice, _)| *choice).ok_or_else(numbers)
        };
        let print = |value: &T| {
            all.iter()
                .find(|(choice, _)| choice == value)
                .map_or(0, |(_, number)| *number)
                .to_string()
        };
        self.field(key, value, parse, print);
    }

    /// Three numbers.
    pub fn vector(&mut self, key: &'static str, value: &mut DVec3) {
        self.triple(key, value, Allowed::Any, "[x, y, z]");
    }

    /// Red, green, blue: three numbers of at least 0.
    pub fn color(&mut self, key: &'static str, value: &mut DVec3) {
        self.triple(key, value, Allowed::NotNegative, "[red, green, blue]");
    }

    fn triple(&mut self, key: &'static str, value: &mut DVec3, allowed: Allowed, form: &str) {
        let parse = |node: &Node| {
            let numbers = triple_of(node, |item| {
                number_of(item).filter(|&n| allowed.contains(n))
            });
            numbers
                .map(DVec3::from_array)
                .ok_or_else(|| format!("{form}, each {}", allowed.describe()))
        };
        let print = |v: &DVec3| {
            format!(
                "[{}, {}, {}]",
                format_number(v.x),
                format_number(v.y),
                format_number(v.z)
            )
        };
        self.field(key, value, parse, print);
    }

    /// Three counts, each at least 1.
    pub fn counts(&mut self, key: &'static str, value: &mut [u32; 3]) {
        let parse = |node: &Node| {
            let count = |item: &Node| match item.value {
                Value::Integer(number) => u32::try_from(number).ok().filter(|&n| n > 0),
                _ => None,
            };
            triple_of(node, count).ok_or_else(|| "three whole numbers, each at least 1".to_owned())
        };
        self.field(key, value, parse, |[x, y, z]| format!("[{x}, {y}, {z}]"));
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
                let _ = write!(text, "\n[{path}]\n");
                fields(&mut Keys {
                    path,
                    direction: Direction::Writing { text },
                });
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
                    if !problems.is_empty() {
                        return;
                    }
                    let mut item = T::default();
                    let path = format!("{path}.{}", entry.key);
                    read_table(&entry.node, path, name, problems, |keys| {
                        fields(keys, &mut item);
                    });
                    map.insert(entry.key.clone(), item);
                }
            }
            Direction::Writing { text } => {
                for (item_name, item) in map {
                    let path = format!("{path}.{}", key_text(item_name));
                    let _ = write!(text, "\n[{path}]\n");
                    fields(
                        &mut Keys {
                            path,
                            direction: Direction::Writing { text },
                        },
                        item,
                    );
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
                    if !problems.is_empty() {
                        return;
                    }
                    let mut item = T::default();
                    read_table(node, format!("{path}.{index}"), name, problems, |keys| {
                        fields(keys, &mut item);
                    });
                    list.push(item);
                }
            }
            Direction::Writing { text } => {
                for item in list {
                    let _ = write!(text, "\n[[{path}]]\n");
                    fields(
                        &mut Keys {
                            path: path.clone(),
                            direction: Direction::Writing { text },
                        },
                        item,
                    );
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
            let message = match (counterpart, nearest) {
                (Some(name), _) => format!("unknown key `{key}`; here it is called `{name}`"),
                (_, Some(nearest)) if is_near(&entry.key, nearest) => {
                    format!("unknown key `{key}`; the nearest known one is `{nearest}`")
                }
                (_, Some(_)) => format!("unknown key `{key}`; known here: {}", known.join(", ")),
                (_, None) => format!("unknown key `{key}`; no key is known here"),
            };
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

fn wrong_kind(name: &str, node: &Node, path: &str, expected: &str) -> SceneFileError {
    SceneFileError::at(
        name,
        node.place,
        format!("`{path}` is {}; expected {expected}", node.describe()),
    )
}

/// What a key of other renderers is called here.
fn counterpart(key: &str) -> Option<&'static str> {
    Some(match key {
        "fov" | "angle" => "vertical_fov",
        "origin" | "look_from" | "lookfrom" => "eye",
        "look_at" | "lookat" => "target",
        "lens_radius" | "aperture" => "aperture_radius",
        "spp" | "samples" => "samples_per_pixel",
        "max_depth" | "depth" => "max_bounces",
        "color" | "colour" | "albedo" | "base_color" => "diffuse",
        "exponent" => "shininess",
        "absorption" | "transmittance" => "attenuation",
        "emission" => "radiance",
        "file" | "filename" | "shape" => "mesh",
        "translation" => "translate",
        "rotation" => "rotate",
        _ => return None,
    })
}

/// Whether one word may be a misspelling of the other: at most half of its letters differ.
fn is_near(word: &str, other: &str) -> bool {
    2 * edits(word, other) <= word.chars().count().max(2)
}

/// The candidate that takes the fewest edits to reach.
pub fn nearest<'n>(word: &str, candidates: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    candidates.min_by_key(|candidate| edits(word, candidate))
}

/// Edits from one word to the other, as far as people make words: time and memory are the product of the lengths.
fn edits(word: &str, other: &str) -> usize {
    const LONGEST: usize = 32;
    let beginning = |text: &str| text.chars().take(LONGEST).collect::<String>();
    strsim::damerau_levenshtein(&beginning(word), &beginning(other))
}

fn number_of(node: &Node) -> Option<f64> {
    match node.value {
        Value::Integer(number) => Some(number as f64),
        Value::Number(number) => Some(number),
        _ => None,
    }
}

fn text_of(node: &Node) -> Result<String, String> {
    match &node.value {
        Value::Text(text) => Ok(text.clone()),
        _ => Err("a text in quotes".to_owned()),
    }
}

fn triple_of<T>(node: &Node, item: impl Fn(&Node) -> Option<T>) -> Option<[T; 3]> {
    match &node.value {
        Value::Array(items) => items
            .iter()
            .map(item)
            .collect::<Option<Vec<T>>>()?
            .try_into()
            .ok(),
        _ => None,
    }
}

/// The shortest form that reads back to the same number, with a point or exponent so that TOML sees a float.
fn format_number(number: f64) -> String {
    format!("{number:?}")
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
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

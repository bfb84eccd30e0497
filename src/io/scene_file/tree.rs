//! A parsed TOML document whose every key and value knows its line and column.

use toml::de::{DeTable, DeValue};

use super::SceneFileError;
use crate::io::shorten::shortened;

/// Where something stands in a text, both from 1; columns count characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    pub line: usize,
    pub column: usize,
}

/// A value and where it stands.
#[derive(Clone, Debug)]
pub struct Node {
    pub place: Place,
    pub value: Value,
}

/// A TOML value without the kinds no scene key has.
#[derive(Clone, Debug)]
pub enum Value {
    Table(Vec<Entry>),
    Array(Vec<Node>),
    Text(String),
    Integer(i64),
    Number(f64),
    Flag(bool),
}

/// Most items of a list that a message shows.
const MOST_SHOWN: usize = 8;

/// A key with its value.
#[derive(Clone, Debug)]
pub struct Entry {
    pub key: String,
    pub place: Place,
    pub node: Node,
}

impl Node {
    /// The root table of `text`; `name` stands for the file in messages.
    pub fn parse(text: &str, name: &str) -> Result<Self, SceneFileError> {
        let lines = Lines::of(text);
        let error = |place: Place, message: String| SceneFileError::at(name, place, message);
        match DeTable::parse(text) {
            Ok(table) => {
                let (place, table) = (lines.place(table.span().start), table.into_inner());
                let value = table_value(&table, &lines)
                    .map_err(|(place, message)| error(place, message))?;
                Ok(Self { place, value })
            }
            Err(problem) => {
                let place = lines.place(problem.span().map_or(text.len(), |span| span.start));
                Err(error(place, problem.message().to_owned()))
            }
        }
    }

    /// What a message calls this value.
    pub fn describe(&self) -> String {
        match &self.value {
            Value::Table(_) => "a table".to_owned(),
            Value::Array(items) => {
                let describe = |item: &Self| match item.value {
                    Value::Array(_) => "a list".to_owned(),
                    _ => item.describe(),
                };
                let mut shown: Vec<_> = items.iter().take(MOST_SHOWN).map(describe).collect();
                if shown.len() < items.len() {
                    shown.push("…".to_owned());
                }
                format!("[{}]", shown.join(", "))
            }
            Value::Text(text) => format!("{:?}", shortened(text)),
            Value::Integer(number) => number.to_string(),
            // The largest have hundreds of digits.
            Value::Number(number) => format!("{number:?}"),
            Value::Flag(flag) => flag.to_string(),
        }
    }

    /// The entry of a table.
    pub fn get(&self, key: &str) -> Option<&Entry> {
        match &self.value {
            Value::Table(entries) => entries.iter().find(|entry| entry.key == key),
            _ => None,
        }
    }

    /// Where the value of a dotted `path` stands (array items by number), or else its nearest existing ancestor.
    pub fn place_of(&self, path: &str) -> Place {
        let mut node = self;
        for step in path.split('.') {
            let next = match &node.value {
                Value::Array(items) => step.parse().ok().and_then(|index: usize| items.get(index)),
                _ => node.get(step).map(|entry| &entry.node),
            };
            match next {
                Some(next) => node = next,
                None => break,
            }
        }
        node.place
    }

    /// Where the value of a dotted `path` stands, if one is there.
    pub fn place_at(&mut self, path: &str) -> Option<Place> {
        self.at_mut(path).map(|node| node.place)
    }

    /// Says that this value, and all in it, stands at `place`.
    pub fn put_at(&mut self, place: Place) {
        self.place = place;
        match &mut self.value {
            Value::Table(entries) => {
                for entry in entries {
                    entry.place = place;
                    entry.node.put_at(place);
                }
            }
            Value::Array(items) => items.iter_mut().for_each(|item| item.put_at(place)),
            _ => {}
        }
    }

    /// The dotted path of the first entry called `key` in a table of a table, at any depth.
    pub fn path_to(&self, key: &str) -> Option<String> {
        let within = |step: &str, node: &Self| {
            let rest = match node.get(key) {
                Some(_) => key.to_owned(),
                None => node.path_to(key)?,
            };
            Some(format!("{step}.{rest}"))
        };
        match &self.value {
            Value::Table(entries) => entries.iter().find_map(|e| within(&e.key, &e.node)),
            Value::Array(items) => {
                let mut items = items.iter().enumerate();
                items.find_map(|(index, item)| within(&index.to_string(), item))
            }
            _ => None,
        }
    }

    /// The value at a dotted `path`.
    fn at_mut(&mut self, path: &str) -> Option<&mut Self> {
        path.split('.')
            .filter(|step| !step.is_empty())
            .try_fold(self, |node, step| match &mut node.value {
                Value::Table(entries) => entries
                    .iter_mut()
                    .find(|entry| entry.key == step)
                    .map(|entry| &mut entry.node),
                Value::Array(items) => step
                    .parse()
                    .ok()
                    .and_then(|index: usize| items.get_mut(index)),
                _ => None,
            })
    }

    /// The text that this value is.
    pub fn text(&self) -> Option<String> {
        match &self.value {
            Value::Text(text) => Some(text.clone()),
            _ => None,
        }
    }

    /// The text at a dotted `path`, if one is there.
    pub fn text_at(&mut self, path: &str) -> Option<String> {
        self.at_mut(path)?.text()
    }

    /// Takes away what stands at a dotted `path`, if anything does.
    pub fn remove(&mut self, path: &str) {
        let (table, key) = path.rsplit_once('.').unwrap_or(("", path));
        if let Some(Self {
            value: Value::Table(entries),
            ..
        }) = self.at_mut(table)
        {
            entries.retain(|entry| entry.key != key);
        }
    }

    /// Empties the table at a dotted `path`, if one is there.
    pub fn clear(&mut self, path: &str) {
        if let Some(Self {
            value: Value::Table(entries),
            ..
        }) = self.at_mut(path)
        {
            entries.clear();
        }
    }

    /// Puts `node` at a dotted `path`, making tables on the way.
    ///
    /// # Errors
    /// A sentence where the path goes through something that is neither table nor array, or past an array's end.
    pub fn set(&mut self, path: &str, node: Self) -> Result<(), String> {
        let (step, rest) = path
            .split_once('.')
            .map_or((path, None), |(step, rest)| (step, Some(rest)));
        let place = node.place;
        let child = match &mut self.value {
            Value::Table(entries) => {
                let index = entries
                    .iter()
                    .position(|entry| entry.key == step)
                    .unwrap_or_else(|| {
                        let empty = Self {
                            place,
                            value: Value::Table(Vec::new()),
                        };
                        entries.push(Entry {
                            key: step.to_owned(),
                            place,
                            node: empty,
                        });
                        entries.len() - 1
                    });
                &mut entries[index].node
            }
            Value::Array(items) => {
                let count = items.len();
                let item = step
                    .parse()
                    .ok()
                    .and_then(|index: usize| items.get_mut(index));
                item.ok_or_else(|| {
                    format!("\"{step}\" is not one of the {count} items, numbered from 0")
                })?
            }
            _ => {
                return Err(format!(
                    "\"{step}\" asks for a part of {}, which has none",
                    self.describe()
                ));
            }
        };
        if let Some(rest) = rest {
            return child.set(rest, node);
        }
        *child = node;
        Ok(())
    }
}

/// A place and what is wrong there.
type Problem = (Place, String);

fn table_value(table: &DeTable<'_>, lines: &Lines<'_>) -> Result<Value, Problem> {
    let mut entries = Vec::with_capacity(table.len());
    for (key, value) in table {
        let node = node(value.get_ref(), lines.place(value.span().start), lines)?;
        entries.push(Entry {
            key: key.get_ref().to_string(),
            place: lines.place(key.span().start),
            node,
        });
    }
    // In the order of the file, so that the first mistake is reported first.
    entries.sort_by_key(|entry| entry.place);
    Ok(Value::Table(entries))
}

fn node(value: &DeValue<'_>, place: Place, lines: &Lines<'_>) -> Result<Node, Problem> {
    let value = match value {
        DeValue::String(text) => Value::Text(text.to_string()),
        DeValue::Boolean(flag) => Value::Flag(*flag),
        DeValue::Integer(number) => i64::from_str_radix(number.as_str(), number.radix())
            .map(Value::Integer)
            .map_err(|_| {
                let number = number.to_string();
                let shown = shortened(&number);
                (place, format!("{shown} does not fit a 64-bit integer"))
            })?,
        DeValue::Float(number) => number.as_str().parse().map(Value::Number).map_err(|_| {
            let shown = shortened(number.as_str());
            (place, format!("{shown} is not a number"))
        })?,
        DeValue::Array(items) => {
            let item_node = |item: &toml::Spanned<DeValue<'_>>| {
                node(item.get_ref(), lines.place(item.span().start), lines)
            };
            Value::Array(items.iter().map(item_node).collect::<Result<_, _>>()?)
        }
        DeValue::Table(table) => table_value(table, lines)?,
        DeValue::Datetime(_) => return Err((place, "a date has no meaning in a scene".to_owned())),
    };
    Ok(Node { place, value })
}

/// Turns byte offsets into places. A line may hold everything: to count from its start each time would take the square of its
/// length.
struct Lines<'a> {
    text: &'a str,
    starts: Vec<usize>,
    /// Characters before every [`STRIDE`]th byte.
    characters: Vec<usize>,
}

/// Bytes that are counted for one place at most.
const STRIDE: usize = 128;

impl<'a> Lines<'a> {
    fn of(text: &'a str) -> Self {
        let after_newlines = text.match_indices('\n').map(|(at, _)| at + 1);
        let mut before = 0;
        let pieces = text.as_bytes().chunks(STRIDE).map(|piece| {
            let here = before;
            before += characters_in(piece);
            here
        });
        let mut characters: Vec<usize> = pieces.collect();
        characters.push(before);
        Self {
            text,
            starts: std::iter::once(0).chain(after_newlines).collect(),
            characters,
        }
    }

    fn place(&self, offset: usize) -> Place {
        let line = self.starts.partition_point(|&start| start <= offset).max(1);
        let start = self.starts[line - 1];
        Place {
            line,
            column: 1 + self.characters_before(offset) - self.characters_before(start),
        }
    }

    fn characters_before(&self, offset: usize) -> usize {
        let offset = offset.min(self.text.len());
        let piece = offset / STRIDE;
        self.characters[piece] + characters_in(&self.text.as_bytes()[piece * STRIDE..offset])
    }
}

/// Characters of UTF-8 that begin in these bytes.
fn characters_in(bytes: &[u8]) -> usize {
    let begins = |&&byte: &&u8| byte & 0b1100_0000 != 0b1000_0000;
    bytes.iter().filter(begins).count()
}

//! The kinds of values that a key can have: what of a file is one, how it is written, and what is expected where it is none.

use super::{Direction, Keys};
use crate::io::scene_file::SceneFileError;
use crate::io::scene_file::tree::{Node, Value};
use crate::math::DVec3;
use crate::scene::Choice;

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

impl Keys<'_> {
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

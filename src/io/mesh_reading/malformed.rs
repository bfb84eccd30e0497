use super::cursor::quoted;
use std::fmt::{self, Display, Formatter};
use thiserror::Error;

/// Where in a file something stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// In text: the line, counted from 1.
    Line(u64),
    /// In binary data: the byte, counted from 0.
    Byte(u64),
}

impl Display for Place {
    fn fmt(&self, out: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(out, "line {line}"),
            Self::Byte(byte) => write!(out, "byte {byte}"),
        }
    }
}

/// Why a file is not a mesh of its format: the first thing that is wrong with it.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{place}: expected {expected}, found {found}")]
pub struct Malformed {
    /// Where it stands.
    pub place: Place,
    /// What would have been right there.
    pub expected: String,
    /// What is there instead; text from the file is quoted and cut short.
    pub found: String,
}

impl Malformed {
    /// `expected`, but something else, described by `found`, is there.
    pub fn at(place: Place, expected: impl Into<String>, found: impl Into<String>) -> Self {
        Self {
            place,
            expected: expected.into(),
            found: found.into(),
        }
    }

    /// [`Malformed::at`] a line.
    pub fn in_line(line: u64, expected: impl Into<String>, found: impl Into<String>) -> Self {
        Self::at(Place::Line(line), expected, found)
    }

    /// `expected`, but the text of the file says `token` in this line.
    pub fn at_token(line: u64, expected: impl Into<String>, token: &[u8]) -> Self {
        Self::in_line(line, expected, quoted(token))
    }

    /// The sentence without the place, for whoever writes `path:line: ` before it.
    #[must_use]
    pub fn sentence(&self) -> String {
        format!("expected {}, found {}", self.expected, self.found)
    }
}

//! The error that all mesh formats share: a place in the file, what was expected there, and what was found.

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
    /// In a document of lists: the list, and the number in it, counted from 0.
    Item(List, u32),
}

/// A list of a document of glTF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum List {
    /// Of numbers in buffer views.
    Accessors,
    /// Of parts of buffers.
    BufferViews,
    /// Of bytes.
    Buffers,
    /// Of cameras.
    Cameras,
    /// Of images.
    Images,
    /// Of lights, in an extension.
    Lights,
    /// Of materials.
    Materials,
    /// Of meshes.
    Meshes,
    /// Of what a scene is made of.
    Nodes,
    /// Of scenes.
    Scenes,
}

impl Display for List {
    fn fmt(&self, out: &mut Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Self::Accessors => "accessors",
            Self::BufferViews => "bufferViews",
            Self::Buffers => "buffers",
            Self::Cameras => "cameras",
            Self::Images => "images",
            Self::Lights => "lights",
            Self::Materials => "materials",
            Self::Meshes => "meshes",
            Self::Nodes => "nodes",
            Self::Scenes => "scenes",
        })
    }
}

impl Display for Place {
    fn fmt(&self, out: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(out, "line {line}"),
            Self::Byte(byte) => write!(out, "byte {byte}"),
            Self::Item(list, number) => write!(out, "{list}[{number}]"),
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

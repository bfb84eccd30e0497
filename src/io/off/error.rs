use super::cursor::quoted;
use thiserror::Error;

/// Why a file is not an OFF mesh: the first thing that is wrong with it.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("line {line}: expected {expected}, found {found}")]
pub struct OffError {
    /// The line it stands on, counted from 1.
    pub line: u64,
    /// What would have been right there.
    pub expected: String,
    /// What is there instead; text from the file is quoted and cut short.
    pub found: String,
}

impl OffError {
    /// `expected`, but the text of the file says `token`.
    pub(super) fn at_token(line: u64, expected: impl Into<String>, token: &[u8]) -> Self {
        Self {
            line,
            expected: expected.into(),
            found: quoted(token),
        }
    }

    /// `expected`, but something else, described by `found`, is there.
    pub(super) fn new(line: u64, expected: impl Into<String>, found: impl Into<String>) -> Self {
        Self {
            line,
            expected: expected.into(),
            found: found.into(),
        }
    }

    /// The sentence without the line, for whoever writes `path:line: ` before it.
    #[must_use]
    pub fn sentence(&self) -> String {
        format!("expected {}, found {}", self.expected, self.found)
    }
}

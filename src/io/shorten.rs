//! Text from files, cut short for messages.

use std::borrow::Cow;

/// A text from a file as a message shows it: the beginning of a long one.
pub fn shortened(text: &str) -> Cow<'_, str> {
    const MOST: usize = 60;
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}…", &text[..end]).into(),
        None => text.into(),
    }
}

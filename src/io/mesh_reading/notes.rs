//! Warnings about a file that count what they warn of and name its first place, in place of a line for each.

use super::malformed::Place;

/// What a warning counts, and where it was seen first.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seen {
    /// How often it was seen.
    pub count: u64,
    first: Option<Place>,
}

impl Seen {
    /// Counts one more.
    pub fn at(&mut self, place: Place) {
        self.first.get_or_insert(place);
        self.count += 1;
    }

    /// How many, of which `one` and `many` say what they are: `2 faces were dropped (the first on line 7)`.
    pub fn counted(&self, one: &str, many: &str) -> Option<String> {
        let first = self.first?;
        Some(match self.count {
            1 => format!("1 {one} ({first})"),
            count => format!("{count} {many} (the first {})", on(first)),
        })
    }

    /// What was found, and where it begins: `colours are ignored (the first on line 7)`.
    pub fn found(&self, what: &str) -> Option<String> {
        Some(format!("{what} (the first {})", on(self.first?)))
    }
}

fn on(place: Place) -> String {
    match place {
        Place::Line(line) => format!("on line {line}"),
        Place::Byte(byte) => format!("at byte {byte}"),
        Place::Item(list, number) => format!("in {list}[{number}]"),
    }
}

/// A number of things in words: `numbers(1, "number")` is `1 number`.
pub fn numbers(count: usize, what: &str) -> String {
    match count {
        1 => format!("1 {what}"),
        _ => format!("{count} {what}s"),
    }
}

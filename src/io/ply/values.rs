//! The numbers of the data, one after the other, however they are written.

use super::header::Scalar;
use crate::io::mesh_reading::{Cursor, Malformed, Place, number, numbers};

/// A place in the data. Every type of number in a PLY file is exact as `f64`.
pub trait Values {
    /// The place where an item begins.
    fn begin_item(&mut self) -> Place;

    /// The next number; `None` where the data ends or, in a text, says something else.
    fn next(&mut self, scalar: Scalar) -> Option<f64>;

    /// Passes over numbers of a list; `None` where the data ends before them.
    fn skip(&mut self, count: u64, scalar: Scalar) -> Option<()>;

    /// Says why there is not the number asked for last, of the item `item`.
    fn missing(&self, item: String) -> Malformed;

    /// Says that the number asked for last should have been something else.
    fn unexpected(&self, expected: String) -> Malformed;

    /// Looks at what follows the last number of an item; `item`: which one it is.
    fn end_item(&mut self, item: &dyn Fn() -> String) -> Result<(), Malformed>;

    /// What is left after the last item, to warn of.
    fn end(&mut self) -> Result<Option<String>, Malformed>;

    /// The bytes of the file passed so far.
    fn position(&self) -> usize;

    /// The bytes of the file still ahead.
    fn remaining(&self) -> usize;
}

/// Binary data, little endian or `BIG`.
pub struct BinaryValues<'a, const BIG: bool> {
    bytes: &'a [u8],
    at: usize,
    /// The last number, and where it stands.
    last: (usize, f64),
}

impl<'a, const BIG: bool> BinaryValues<'a, BIG> {
    /// The data that begins at byte `start` of the file.
    pub fn new(bytes: &'a [u8], start: usize) -> Self {
        let at = start.min(bytes.len());
        Self {
            bytes,
            at,
            last: (at, 0.0),
        }
    }

    /// The next bytes, in little endian order.
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let mut bytes = *self.bytes[self.at..].first_chunk()?;
        self.at += N;
        if BIG {
            bytes.reverse();
        }
        Some(bytes)
    }
}

impl<const BIG: bool> Values for BinaryValues<'_, BIG> {
    fn begin_item(&mut self) -> Place {
        Place::Byte(self.at as u64)
    }

    fn next(&mut self, scalar: Scalar) -> Option<f64> {
        let at = self.at;
        let value = match scalar {
            Scalar::I8 => i8::from_le_bytes(self.take()?).into(),
            Scalar::U8 => u8::from_le_bytes(self.take()?).into(),
            Scalar::I16 => i16::from_le_bytes(self.take()?).into(),
            Scalar::U16 => u16::from_le_bytes(self.take()?).into(),
            Scalar::I32 => i32::from_le_bytes(self.take()?).into(),
            Scalar::U32 => u32::from_le_bytes(self.take()?).into(),
            Scalar::F32 => f32::from_le_bytes(self.take()?).into(),
            Scalar::F64 => f64::from_le_bytes(self.take()?),
        };
        self.last = (at, value);
        Some(value)
    }

    fn skip(&mut self, count: u64, scalar: Scalar) -> Option<()> {
        let bytes = usize::try_from(count).ok()?.checked_mul(scalar.size())?;
        let after = self.at.checked_add(bytes)?;
        (after <= self.bytes.len()).then(|| self.at = after)
    }

    fn missing(&self, item: String) -> Malformed {
        let end = self.bytes.len() as u64;
        Malformed::at(Place::Byte(end), item, "the end of the file")
    }

    fn unexpected(&self, expected: String) -> Malformed {
        let (at, value) = self.last;
        Malformed::at(Place::Byte(at as u64), expected, value.to_string())
    }

    fn end_item(&mut self, _: &dyn Fn() -> String) -> Result<(), Malformed> {
        Ok(())
    }

    fn end(&mut self) -> Result<Option<String>, Malformed> {
        let left = numbers(self.remaining(), "byte");
        Ok((self.remaining() > 0).then(|| format!("{left} after the last element are ignored")))
    }

    fn position(&self) -> usize {
        self.at
    }

    fn remaining(&self) -> usize {
        self.bytes.len() - self.at
    }
}

/// Data as text.
pub struct TextValues<'a> {
    cursor: Cursor<'a>,
    last_word: &'a [u8],
    last_line: u64,
    /// The line on which the item began.
    first_line: u64,
    /// Numbers of the item read so far.
    read: usize,
    /// How many of them stood on its first line, once another has begun.
    on_first_line: Option<usize>,
}

impl<'a> TextValues<'a> {
    /// The text from the cursor on.
    pub fn new(cursor: Cursor<'a>) -> Self {
        Self {
            last_word: &[],
            last_line: cursor.line(),
            first_line: cursor.line(),
            cursor,
            read: 0,
            on_first_line: None,
        }
    }
}

impl Values for TextValues<'_> {
    fn begin_item(&mut self) -> Place {
        self.cursor.find_word();
        self.first_line = self.cursor.line();
        self.read = 0;
        self.on_first_line = None;
        Place::Line(self.first_line)
    }

    fn next(&mut self, _: Scalar) -> Option<f64> {
        if !self.cursor.line_has_word() {
            self.on_first_line.get_or_insert(self.read);
            self.cursor.find_word();
        }
        self.last_line = self.cursor.line();
        self.last_word = self.cursor.word().unwrap_or_default();
        self.read += 1;
        number(self.last_word)
    }

    fn skip(&mut self, count: u64, scalar: Scalar) -> Option<()> {
        (0..count).try_for_each(|_| self.next(scalar).map(drop))
    }

    fn missing(&self, item: String) -> Malformed {
        if self.last_word.is_empty() {
            Malformed::in_line(self.last_line, item, "the end of the file")
        } else {
            self.unexpected("a number".to_owned())
        }
    }

    fn unexpected(&self, expected: String) -> Malformed {
        Malformed::at_token(self.last_line, expected, self.last_word)
    }

    fn end_item(&mut self, item: &dyn Fn() -> String) -> Result<(), Malformed> {
        if !self.cursor.line_has_word() {
            return Ok(());
        }
        if let Some(count) = self.on_first_line {
            let expected = format!("all values of {}", item());
            let found = numbers(count, "value");
            return Err(Malformed::in_line(self.first_line, expected, found));
        }
        let expected = format!("the end of the line after {}", item());
        let line = self.cursor.line();
        let word = self.cursor.word().unwrap_or_default();
        Err(Malformed::at_token(line, expected, word))
    }

    fn end(&mut self) -> Result<Option<String>, Malformed> {
        if !self.cursor.find_word() {
            return Ok(None);
        }
        let line = self.cursor.line();
        let word = self.cursor.word().unwrap_or_default();
        if number(word).is_some() {
            let expected = "the end of the file after the last element";
            return Err(Malformed::at_token(line, expected, word));
        }
        let warning = format!("text after the last element is ignored (line {line})");
        Ok(Some(warning))
    }

    fn position(&self) -> usize {
        self.cursor.position()
    }

    fn remaining(&self) -> usize {
        self.cursor.remaining()
    }
}

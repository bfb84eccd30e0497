//! A place in the text, and the words and numbers found there.

use super::Malformed;

/// Walks over bytes word by word and line by line.
///
/// Words are separated by blanks. A line ends with LF, CR or CR LF; `#` hides the rest of its line. The text need not be
/// UTF-8, as comments in old files often are not.
#[derive(Clone, Debug)]
pub struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u64,
    last_line_with_words: u64,
}

impl<'a> Cursor<'a> {
    /// The start of `bytes`, after the byte order mark if there is one.
    pub fn new(bytes: &'a [u8]) -> Self {
        let at = if bytes.starts_with(b"\xEF\xBB\xBF") {
            3
        } else {
            0
        };
        Self {
            bytes,
            at,
            line: 1,
            last_line_with_words: 1,
        }
    }

    /// Bytes passed so far.
    pub fn position(&self) -> usize {
        self.at
    }

    /// Bytes still ahead.
    pub fn remaining(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// The line of the next word, or at the end of the text the last line that held one.
    pub fn line(&self) -> u64 {
        if self.remaining() == 0 {
            self.last_line_with_words
        } else {
            self.line
        }
    }

    /// The next word of this line; `None` where the line has no more.
    pub fn word(&mut self) -> Option<&'a [u8]> {
        if !self.line_has_word() {
            return None;
        }
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|&byte| ends_word(byte));
        let word = &rest[..length.unwrap_or(rest.len())];
        self.at += word.len();
        Some(word)
    }

    /// Moves over blanks and says whether this line goes on with a word.
    pub fn line_has_word(&mut self) -> bool {
        while let Some(&byte) = self.bytes.get(self.at) {
            if is_blank(byte) {
                self.at += 1;
            } else if ends_word(byte) {
                return false;
            } else {
                self.last_line_with_words = self.line;
                return true;
            }
        }
        false
    }

    /// Moves to the next word, on this line or a later one, and says whether there is one.
    pub fn find_word(&mut self) -> bool {
        loop {
            if self.line_has_word() {
                return true;
            }
            if !self.leave_line() {
                return false;
            }
        }
    }

    /// The number of words left on this line. The cursor stays.
    pub fn words_on_line(&self) -> usize {
        let mut ahead = self.clone();
        let mut count = 0;
        while ahead.word().is_some() {
            count += 1;
        }
        count
    }

    /// What is left of this line, comments included, without blanks around it. The cursor stays on the line.
    pub fn rest_of_line(&mut self) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|&byte| is_line_end(byte));
        let rest = &rest[..length.unwrap_or(rest.len())];
        self.at += rest.len();
        rest.trim_ascii()
    }

    /// The characters that end this line, where the cursor is at its end.
    pub fn line_end(&self) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        let length = match rest {
            [b'\r', b'\n', ..] => 2,
            [b'\r' | b'\n', ..] => 1,
            _ => 0,
        };
        &rest[..length]
    }

    /// Moves behind the end of this line; `false` when the text ends with it.
    pub fn leave_line(&mut self) -> bool {
        self.rest_of_line();
        let line_end = self.line_end();
        self.at += line_end.len();
        self.line += u64::from(!line_end.is_empty());
        !line_end.is_empty()
    }
}

/// Words that have to be there, and what is wrong where something else is.
impl<'a> Cursor<'a> {
    /// The next word, on this line or a later one.
    ///
    /// # Errors
    /// That `expected` is not there, where the text ends.
    pub fn next_word(&mut self, expected: &str) -> Result<&'a [u8], Malformed> {
        if !self.find_word() {
            return Err(self.at_end(expected));
        }
        Ok(self.word().unwrap_or_default())
    }

    /// The next word as an unsigned whole number.
    ///
    /// # Errors
    /// That `expected` is not there, where the text ends or says something else.
    pub fn next_count(&mut self, expected: &str) -> Result<u64, Malformed> {
        let word = self.next_word(expected)?;
        self.count(word, expected)
    }

    /// The next word as a coordinate.
    ///
    /// # Errors
    /// That it is not there, where the text ends or says something else.
    pub fn next_coordinate(&mut self) -> Result<f64, Malformed> {
        let word = self.next_word(COORDINATE)?;
        self.coordinate(word)
    }

    /// The value of `word`, which was the last one, as an unsigned whole number.
    ///
    /// # Errors
    /// That `expected` is not there, where it is no such number.
    pub fn count(&self, word: &[u8], expected: &str) -> Result<u64, Malformed> {
        whole(word).ok_or_else(|| Malformed::at_token(self.line(), expected, word))
    }

    /// The value of `word`, which was the last one, as a coordinate.
    ///
    /// # Errors
    /// That it is no finite number.
    pub fn coordinate(&self, word: &[u8]) -> Result<f64, Malformed> {
        let value = number(word).filter(|value| value.is_finite());
        value.ok_or_else(|| Malformed::at_token(self.line(), COORDINATE, word))
    }

    /// Says that the text ends where `expected` was to stand.
    pub fn at_end(&self, expected: impl Into<String>) -> Malformed {
        Malformed::in_line(self.line(), expected, "the end of the file")
    }
}

/// What messages call a coordinate.
const COORDINATE: &str = "a finite coordinate";

/// What a byte is, looked up: this is asked of every byte of a text.
const KINDS: [Kind; 256] = {
    let mut kinds = [Kind::InWord; 256];
    let mut byte = 0_u8;
    loop {
        kinds[byte as usize] = match byte {
            b'\n' | b'\r' => Kind::LineEnd,
            b' ' | b'\t' | 0x0B | 0x0C => Kind::Blank,
            b'#' => Kind::Comment,
            _ => Kind::InWord,
        };
        if byte == u8::MAX {
            break kinds;
        }
        byte += 1;
    }
};

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    InWord,
    Blank,
    LineEnd,
    Comment,
}

fn kind_of(byte: u8) -> Kind {
    KINDS[usize::from(byte)]
}

fn is_line_end(byte: u8) -> bool {
    kind_of(byte) == Kind::LineEnd
}

fn is_blank(byte: u8) -> bool {
    kind_of(byte) == Kind::Blank
}

fn ends_word(byte: u8) -> bool {
    kind_of(byte) != Kind::InWord
}

/// The value of a decimal number; infinite where it is too large, NaN where it says so. Its exponent may begin with a `d`, as Fortran
/// writes it.
pub fn number(word: &[u8]) -> Option<f64> {
    plain_number(word).or_else(|| any_number(word))
}

/// The value of digits with a point or without, as most numbers are; `None` for others, and for those of many digits.
///
/// Both the digits as a whole number and the power of ten fit into a `f64`, so that their quotient is rounded once, as it has to be.
/// Source: Clinger, How to Read Floating Point Numbers Accurately, 1990.
#[inline]
fn plain_number(word: &[u8]) -> Option<f64> {
    const MOST_DIGITS: usize = 19;
    const WHOLE: u64 = 1 << f64::MANTISSA_DIGITS;
    const POWERS_OF_TEN: [f64; MOST_DIGITS + 1] = [
        1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
        1e17, 1e18, 1e19,
    ];
    let is_negative = word.first() == Some(&b'-');
    let digits = match word {
        [b'-' | b'+', digits @ ..] | digits => digits,
    };
    if digits.len() > MOST_DIGITS {
        return None;
    }
    let mut whole = 0_u64;
    let mut point = None;
    for (at, &byte) in digits.iter().enumerate() {
        let digit = byte.wrapping_sub(b'0');
        if digit <= 9 {
            whole = whole * 10 + u64::from(digit);
        } else if byte == b'.' && point.is_none() {
            point = Some(at);
        } else {
            return None;
        }
    }
    let has_digits = digits.len() > usize::from(point.is_some());
    if !has_digits || whole >= WHOLE {
        return None;
    }
    let decimals = point.map_or(0, |at| digits.len() - at - 1);
    let value = whole as f64 / POWERS_OF_TEN[decimals];
    Some(if is_negative { -value } else { value })
}

fn any_number(word: &[u8]) -> Option<f64> {
    let text = str::from_utf8(word).ok()?;
    text.parse().ok().or_else(|| of_fortran(text))
}

#[cold]
fn of_fortran(text: &str) -> Option<f64> {
    let (mantissa, exponent) = text.split_once(['d', 'D'])?;
    format!("{mantissa}e{exponent}").parse().ok()
}

/// The value of an unsigned decimal integer that fits.
pub fn whole(word: &[u8]) -> Option<u64> {
    if word.is_empty() {
        return None;
    }
    word.iter().try_fold(0_u64, |value, byte| {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            return None;
        }
        value.checked_mul(10)?.checked_add(u64::from(digit))
    })
}

/// A word for a message: in quotes, what cannot be shown escaped, a long one cut.
pub fn quoted(word: &[u8]) -> String {
    const LONGEST: usize = 32;
    let shown = &word[..word.len().min(LONGEST)];
    let dots = if word.len() > LONGEST { "…" } else { "" };
    let text = String::from_utf8_lossy(shown);
    format!("\"{}{dots}\"", text.escape_debug())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::Random;

    fn words(text: &str) -> Vec<(u64, String)> {
        let mut cursor = Cursor::new(text.as_bytes());
        let mut found = Vec::new();
        while cursor.find_word() {
            let line = cursor.line();
            let word = cursor.word().expect("a word was found");
            found.push((line, String::from_utf8_lossy(word).into_owned()));
        }
        found
    }

    #[test]
    fn every_kind_of_line_end_counts_once() {
        let expected = [(1, "a"), (2, "b"), (4, "c"), (5, "d")].map(|(l, w)| (l, w.to_owned()));
        assert_eq!(words("a\nb\n\nc\nd"), expected);
        assert_eq!(words("a\r\nb\r\n\r\nc\r\nd\r\n"), expected);
        assert_eq!(words("a\rb\r\rc\rd\r"), expected);
    }

    #[test]
    fn comments_end_words_and_lines() {
        assert_eq!(
            words("a#b c\n # d\n\u{FEFF}"),
            [(1, "a".to_owned()), (3, "\u{FEFF}".to_owned())]
        );
        assert_eq!(words("\u{FEFF}a"), [(1, "a".to_owned())]);
    }

    /// Against the standard library, bit for bit.
    #[test]
    fn numbers_are_rounded_as_they_have_to_be() {
        let mut random = Random::new(11);
        let mut below = |bound: u64| random.bits() % bound;
        let signs = ["", "-", "+"];
        for _ in 0..100_000 {
            let length = u32::try_from(below(20)).expect("is small");
            let digits = below(10_u64.pow(length));
            let mut text = format!("{digits}");
            let point = usize::try_from(below(25)).expect("is small");
            if point <= text.len() {
                text.insert(point, '.');
            }
            let sign = signs[usize::try_from(below(3)).expect("is small")];
            let text = format!("{sign}{text}");
            let expected: f64 = text.parse().expect("is a number");
            let found = number(text.as_bytes()).expect("is a number");
            assert_eq!(found.to_bits(), expected.to_bits(), "{text}");
        }
        for text in [
            "-0",
            "0.",
            ".5",
            "9007199254740993",
            "0.1",
            "123456789012345678901",
        ] {
            let expected: f64 = text.parse().expect("is a number");
            assert_eq!(
                number(text.as_bytes()).map(f64::to_bits),
                Some(expected.to_bits())
            );
        }
        for text in [
            "", ".", "-", "+.", "1.2.3", "1-", "--1", "0x1", "1_0", "1,5",
        ] {
            assert_eq!(number(text.as_bytes()), None, "{text}");
        }
    }

    #[test]
    fn exponents_may_be_those_of_fortran() {
        for (word, value) in [
            ("1.d+3", Some(1000.0)),
            ("-2.5D-1", Some(-0.25)),
            (".5d0", Some(0.5)),
            ("1e3", Some(1000.0)),
            ("d3", None),
            ("1d", None),
            ("1d1d1", None),
            ("infd1", None),
        ] {
            assert_eq!(number(word.as_bytes()), value, "{word}");
        }
    }

    #[test]
    fn whole_numbers_are_digits_that_fit() {
        assert_eq!(whole(b"18446744073709551615"), Some(u64::MAX));
        for word in [
            "",
            "18446744073709551616",
            "-1",
            "+1",
            "1.0",
            "1e3",
            "0x1",
            "１",
        ] {
            assert_eq!(whole(word.as_bytes()), None, "{word}");
        }
    }

    #[test]
    fn words_in_messages_are_short_and_printable() {
        assert_eq!(quoted(b"9"), "\"9\"");
        assert_eq!(quoted(b"\x00\xFF\""), "\"\\0\u{FFFD}\\\"\"");
        assert!(quoted(&[b'x'; 1000]).len() < 50);
    }
}

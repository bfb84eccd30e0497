//! What a document refers to: data within it, or other files.

use std::borrow::Cow;

/// What a URI means.
#[derive(Debug, PartialEq, Eq)]
pub enum Uri<'a> {
    /// The bytes that it holds.
    Data(Vec<u8>),
    /// A file, by its name relative to the document's.
    File(Cow<'a, str>),
}

/// Reads a URI.
///
/// # Errors
/// What of data it holds cannot be read, in words.
pub fn read(uri: &str) -> Result<Uri<'_>, &'static str> {
    let Some(data) = strip_scheme(uri, "data:") else {
        return Ok(Uri::File(without_percents(uri)));
    };
    let (kind, data) = data.split_once(',').ok_or("data without a comma")?;
    if !kind.to_ascii_lowercase().ends_with(";base64") {
        return Err("data that is not in base64");
    }
    decode(data.as_bytes())
        .map(Uri::Data)
        .ok_or("data that is not base64")
}

/// The name of the file that a URI means; `None` where it holds data.
#[must_use]
pub fn without_data(uri: &str) -> Option<Cow<'_, str>> {
    strip_scheme(uri, "data:")
        .is_none()
        .then(|| without_percents(uri))
}

fn strip_scheme<'a>(uri: &'a str, scheme: &str) -> Option<&'a str> {
    let start = uri.get(..scheme.len())?;
    start
        .eq_ignore_ascii_case(scheme)
        .then(|| &uri[scheme.len()..])
}

/// The text with `%20` and the like replaced by what they stand for, where that is UTF-8.
fn without_percents(text: &str) -> Cow<'_, str> {
    if !text.contains('%') {
        return Cow::Borrowed(text);
    }
    let bytes = text.as_bytes();
    let mut plain = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        let digits = bytes.get(at + 1..at + 3).filter(|_| bytes[at] == b'%');
        let byte =
            digits.and_then(|digits| u8::from_str_radix(str::from_utf8(digits).ok()?, 16).ok());
        plain.push(byte.unwrap_or(bytes[at]));
        at += if byte.is_some() { 3 } else { 1 };
    }
    String::from_utf8(plain).map_or(Cow::Borrowed(text), Cow::Owned)
}

/// The bytes that base64 stands for, with or without `=` at its end. Source: RFC 4648, section 4.
fn decode(text: &[u8]) -> Option<Vec<u8>> {
    let end = text
        .iter()
        .rposition(|&byte| byte != b'=')
        .map_or(0, |last| last + 1);
    let (text, padding) = text.split_at(end);
    if padding.len() > 2 || text.len() % 4 == 1 {
        return None;
    }
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 2);
    for four in text.chunks(4) {
        let mut bits = 0_u32;
        for &letter in four {
            bits = bits << 6 | u32::from(six_bits(letter)?);
        }
        bits <<= 6 * (4 - four.len());
        let [_, a, b, c] = bits.to_be_bytes();
        bytes.extend_from_slice(&[a, b, c][..four.len() - 1]);
    }
    Some(bytes)
}

fn six_bits(letter: u8) -> Option<u8> {
    Some(match letter {
        b'A'..=b'Z' => letter - b'A',
        b'a'..=b'z' => letter - b'a' + 26,
        b'0'..=b'9' => letter - b'0' + 52,
        b'+' => 62,
        b'/' => 63,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The test vectors of RFC 4648, section 10.
    #[test]
    fn base64_is_decoded() {
        for (text, bytes) in [
            ("", ""),
            ("Zg==", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9vYg==", "foob"),
            ("Zm9vYmE=", "fooba"),
            ("Zm9vYmFy", "foobar"),
            ("Zm9vYg", "foob"),
        ] {
            let data = format!("data:application/octet-stream;base64,{text}");
            assert_eq!(read(&data), Ok(Uri::Data(bytes.into())), "{text}");
        }
        assert_eq!(read("DATA:;BASE64,+/8="), Ok(Uri::Data(vec![0xFB, 0xFF])));
        for wrong in [
            "data:;base64,Z",
            "data:;base64,Zm9\n",
            "data:;base64,Zg===",
            "data:;base64,Zg=A",
            "data:,abc",
            "data:;base64",
        ] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn files_may_have_percents() {
        for (uri, name) in [
            ("a.bin", "a.bin"),
            ("my%20data%2fa.bin", "my data/a.bin"),
            ("100%.bin", "100%.bin"),
            ("%c3%bc%4", "ü%4"),
            ("%ff", "%ff"),
        ] {
            assert_eq!(read(uri), Ok(Uri::File(name.into())), "{uri}");
        }
    }
}

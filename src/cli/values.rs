//! Values of options: each is understood, or refused in words that say what was expected.

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::str::FromStr;

use clap::builder::{PathBufValueParser, TypedValueParser};

use crate::render::Region;
use crate::scene::RenderSettings;

/// Reads a whole number from `range`.
pub fn whole<T>(range: RangeInclusive<T>) -> impl Fn(&str) -> Result<T, String> + Clone
where
    T: Clone + Display + FromStr + PartialOrd,
{
    move |text| {
        let number = text.trim().parse().ok();
        let expected = || {
            format!(
                "expected a whole number from {} to {}",
                range.start(),
                range.end()
            )
        };
        number
            .filter(|number| range.contains(number))
            .ok_or_else(expected)
    }
}

/// Reads how many threads are to work.
pub fn threads(text: &str) -> Result<u16, String> {
    whole(1..=1024)(text)
}

/// Reads how many samples a pixel is to have.
pub fn samples(text: &str) -> Result<u32, String> {
    whole(1..=RenderSettings::MAX_SAMPLES)(text)
}

/// Reads a finite number above 0.
pub fn positive(text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok();
    number
        .filter(|number: &f64| number.is_finite() && *number > 0.0)
        .ok_or_else(|| "expected a number above 0".to_owned())
}

/// Reads the size of a picture in pixels.
pub fn size(text: &str) -> Result<(u32, u32), String> {
    let side = whole(1..=RenderSettings::MAX_SIDE);
    let sides = text.split_once(['x', 'X', '×']);
    let sides = sides.and_then(|(width, height)| Some((side(width).ok()?, side(height).ok()?)));
    let pixels = |&(width, height): &(u32, u32)| u64::from(width) * u64::from(height);
    let sides = sides.filter(|sides| pixels(sides) <= RenderSettings::MAX_PIXELS);
    let (most, most_pixels) = (RenderSettings::MAX_SIDE, RenderSettings::MAX_PIXELS);
    sides.ok_or_else(|| {
        format!(
            "expected width and height, each up to {most} and {most_pixels} pixels together, such as 640x480"
        )
    })
}

/// Reads a part of a picture.
pub fn region(text: &str) -> Result<Region, String> {
    let numbers: Option<Vec<u32>> = text
        .split(',')
        .map(|number| number.trim().parse().ok())
        .collect();
    match numbers.as_deref() {
        Some(&[x, y, width, height]) if width > 0 && height > 0 => Ok(Region {
            x,
            y,
            width,
            height,
        }),
        _ => Err("expected left, top, width, height in pixels, such as 0,0,320,240".to_owned()),
    }
}

/// Reads the place of a pixel.
pub fn pixel(text: &str) -> Result<(u32, u32), String> {
    let sides = text.split_once(',').and_then(|(x, y)| {
        let number = |text: &str| text.trim().parse().ok();
        Some((number(x)?, number(y)?))
    });
    sides.ok_or_else(|| "expected column and row of a pixel, such as 320,240".to_owned())
}

/// Takes the name of something to write.
pub fn output() -> impl TypedValueParser<Value = PathBuf> {
    path("something to write")
}

/// Takes the name of a file to read.
pub fn input() -> impl TypedValueParser<Value = PathBuf> {
    path("a file to read")
}

/// Takes the name of `what`. One that begins with a dash is more likely the next option, where the name was forgotten.
fn path(what: &'static str) -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(move |path| {
        if path.as_os_str().as_encoded_bytes().starts_with(b"-") {
            let name = path.display();
            return Err(format!(
                "expected the name of {what}; one that begins with a dash is given as ./{name}"
            ));
        }
        Ok(path)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_are_understood_or_refused() {
        let few = whole(2..=7_u16);
        assert_eq!((few("2"), few(" 7 ")), (Ok(2), Ok(7)));
        for wrong in ["", "1", "8", "-3", "2.5", "x", "99999999999999999999"] {
            let expected = "expected a whole number from 2 to 7".to_owned();
            assert_eq!(few(wrong), Err(expected), "{wrong}");
        }
        assert!(threads("0").is_err() && threads("1024").is_ok());
        assert!(samples("0").is_err() && samples("16777216").is_ok());
    }

    #[test]
    fn numbers_above_0_are_understood_or_refused() {
        assert_eq!(positive(" 0.5"), Ok(0.5));
        for wrong in ["", "0", "-1", "nan", "inf", "1,5"] {
            assert!(positive(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn sizes_regions_and_pixels_are_understood_or_refused() {
        assert_eq!(size("640x480"), Ok((640, 480)));
        assert_eq!(size("1X2"), Ok((1, 2)));
        for wrong in ["640", "0x3", "-1x3", "ax3", "3x", "", "65536x65536"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
        assert_eq!(
            region("1, 2,3,4"),
            Ok(Region {
                x: 1,
                y: 2,
                width: 3,
                height: 4
            })
        );
        for wrong in ["1,2,3", "1,2,0,4", "1,2,3,4,5", "a,2,3,4"] {
            assert!(region(wrong).is_err(), "{wrong}");
        }
        assert_eq!(pixel("0, 12"), Ok((0, 12)));
        for wrong in ["", "1", "1x2", "-1,0", "1,2,3"] {
            assert!(pixel(wrong).is_err(), "{wrong}");
        }
    }
}

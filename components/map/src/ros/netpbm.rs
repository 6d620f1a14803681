//! The Netpbm formats PBM, PGM and PPM (<https://netpbm.sourceforge.net/doc/pnm.html>), in text and binary form: P1 to
//! P6.

use super::picture::{Channels, MapPicture, narrow};
use crate::error::MapFault;

/// Reads an image of type `P1` to `P6`; fails if it has more pixels than `limit`.
pub fn read(bytes: &[u8], limit: u64) -> Result<MapPicture, MapFault> {
    let (is_text, channels, is_bitmap) = match bytes.get(1) {
        Some(b'1') => (true, Channels::Grey, true),
        Some(b'2') => (true, Channels::Grey, false),
        Some(b'3') => (true, Channels::Rgb, false),
        Some(b'4') => (false, Channels::Grey, true),
        Some(b'5') => (false, Channels::Grey, false),
        Some(b'6') => (false, Channels::Rgb, false),
        _ => return Err(syntax("is none of P1 to P6")),
    };
    let mut text = NetpbmText(bytes.get(2..).unwrap_or_default());
    let width = text.header("width")?;
    let height = text.header("height")?;
    let white = if is_bitmap {
        1
    } else {
        text.header("largest value")?
    };
    let Ok(white @ 1..) = u16::try_from(white) else {
        return Err(syntax("its largest value is not from 1 to 65535"));
    };
    let pixels = u64::from(width) * u64::from(height);
    if pixels > limit {
        return Err(MapFault::TooManyBytes { limit });
    }
    let count = pixels as usize * channels.count();
    let samples = match (is_bitmap, is_text) {
        (true, true) => text.bits(count)?,
        (true, false) => packed_bits(text.0, width, height)?,
        (false, true) => text.samples(count, white)?,
        (false, false) => samples(text.0, count, white)?,
    };
    MapPicture::new(width, height, channels, samples).ok_or_else(too_short)
}

fn syntax(what: &str) -> MapFault {
    MapFault::Syntax {
        what: what.to_owned(),
    }
}

fn too_short() -> MapFault {
    syntax("has fewer pixels than its header says")
}

/// Reads numbers separated by white space; in the header, `#` begins a comment.
struct NetpbmText<'a>(&'a [u8]);

impl NetpbmText<'_> {
    fn next(&mut self) -> Option<u8> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }

    /// Reads a number of the header and the one white-space character after it.
    fn header(&mut self, what: &str) -> Result<u32, MapFault> {
        let mut number = None;
        loop {
            match self.next() {
                Some(b'#') => while !matches!(self.next(), None | Some(b'\n' | b'\r')) {},
                Some(digit @ b'0'..=b'9') => {
                    let digit = u32::from(digit - b'0');
                    let before = number.unwrap_or(0_u32).checked_mul(10);
                    number = before.and_then(|before| before.checked_add(digit));
                    if number.is_none() {
                        return Err(syntax(&format!("its {what} is too large")));
                    }
                }
                Some(byte) if is_blank(byte) && number.is_none() => {}
                Some(byte) if is_blank(byte) => break,
                None if number.is_some() => break,
                Some(_) | None => return Err(syntax(&format!("its header has no {what}"))),
            }
        }
        number.ok_or_else(too_short)
    }

    /// Reads `count` samples from 0 to `white`.
    fn samples(&mut self, count: usize, white: u16) -> Result<Vec<u8>, MapFault> {
        let words = self.0.split(|byte| is_blank(*byte));
        let words = words.filter(|word| !word.is_empty()).take(count);
        let mut samples = Vec::new();
        for word in words {
            let sample = str::from_utf8(word).ok().and_then(|word| word.parse().ok());
            let sample: u16 = sample.ok_or_else(|| syntax("a pixel is not a number"))?;
            samples.push(shade(sample, white));
        }
        Ok(samples)
    }

    /// Reads `count` bits, which need no separators; 1 is black.
    fn bits(&mut self, count: usize) -> Result<Vec<u8>, MapFault> {
        let digits = self.0.iter().filter(|byte| !is_blank(**byte)).take(count);
        let shade = |digit: &u8| match digit {
            b'0' => Ok(255),
            b'1' => Ok(0),
            _ => Err(syntax("a pixel is neither 0 nor 1")),
        };
        digits.map(shade).collect()
    }
}

fn is_blank(byte: u8) -> bool {
    matches!(byte, b'\t' | b'\n' | b'\x0b' | b'\x0c' | b'\r' | b' ')
}

/// Reads packed bits: a row occupies whole bytes, the leftmost pixel is the highest bit, and 1 is black.
fn packed_bits(bytes: &[u8], width: u32, height: u32) -> Result<Vec<u8>, MapFault> {
    let row = width.div_ceil(8) as usize;
    let rows = row.checked_mul(height as usize);
    let bytes = rows
        .and_then(|rows| bytes.get(..rows))
        .ok_or_else(too_short)?;
    let shade = |row: &[u8], column: u32| {
        let byte = row.get(column as usize / 8).copied().unwrap_or_default();
        match byte >> (7 - column % 8) & 1 {
            0 => 255,
            _ => 0,
        }
    };
    let rows = bytes.chunks_exact(row.max(1));
    Ok(rows
        .flat_map(|row| (0..width).map(move |column| shade(row, column)))
        .collect())
}

/// Reads samples of one byte or, if `white` exceeds 255, of two bytes in big-endian order.
fn samples(bytes: &[u8], count: usize, white: u16) -> Result<Vec<u8>, MapFault> {
    if white < 256 {
        let bytes = bytes.get(..count).ok_or_else(too_short)?;
        return Ok(match white {
            255 => bytes.to_vec(),
            _ => bytes
                .iter()
                .map(|it| shade(u16::from(*it), white))
                .collect(),
        });
    }
    let bytes = bytes.get(..2 * count).ok_or_else(too_short)?;
    let pairs = bytes.chunks_exact(2);
    Ok(pairs
        .map(|it| shade(u16::from_be_bytes([it[0], it[1]]), white))
        .collect())
}

/// Scales a sample from `0..=white` to 8 bits.
fn shade(sample: u16, white: u16) -> u8 {
    let scaled = |most: u16| (f32::from(sample) * (f32::from(most) / f32::from(white))).round();
    match white {
        0..=255 => scaled(255) as u8,
        _ => narrow(scaled(u16::MAX) as u16),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Width, height, and the first channel of each pixel.
    fn grey(bytes: &[u8]) -> Result<(u32, u32, Vec<u8>), String> {
        let picture = read(bytes, 100).map_err(|fault| fault.to_string())?;
        let mut shades: Vec<u8> = picture.upwards().map(|it| it.colour[0]).collect();
        // back to the order of the file
        let width = picture.width as usize;
        shades = shades.chunks(width).rev().flatten().copied().collect();
        Ok((picture.width, picture.height, shades))
    }

    #[test]
    fn it_reads_all_six() {
        let bits = vec![255, 0, 0, 255, 255, 0];
        assert_eq!(grey(b"P1\n3 2\n011\n0 0 1"), Ok((3, 2, bits.clone())));
        assert_eq!(grey(b"P4 3 2\n\x60\x20"), Ok((3, 2, bits)));
        assert_eq!(grey(b"P2\n2 1\n10\n5\t10 "), Ok((2, 1, vec![128, 255])));
        assert_eq!(grey(b"P5 2 1 10\n\x05\x0a"), Ok((2, 1, vec![128, 255])));
        let colours = read(b"P6 1 1 255\n\x01\x02\x03", 100).unwrap();
        let colours: Vec<_> = colours.upwards().map(|it| (it.colour, it.alpha)).collect();
        assert_eq!(colours, [([1, 2, 3], None)]);
        assert_eq!(grey(b"P3 2 1 255 9 8 7 6 5 4"), Ok((2, 1, vec![9, 6])));
    }

    #[test]
    fn it_reads_wide_samples_and_comments() {
        let wide = b"P5 # from a camera\n# 16 bits\n2 1\n65535\n\x00\x80\xff\xff";
        assert_eq!(grey(wide), Ok((2, 1, vec![0, 255])));
        assert_eq!(grey(b"P2 2 1 1000 500 1000"), Ok((2, 1, vec![128, 255])));
    }

    #[test]
    fn it_says_what_is_wrong() {
        let error = |bytes: &[u8]| grey(bytes).unwrap_err();
        assert_eq!(error(b"P5 2 1 255\n\x01"), too_short().to_string());
        assert_eq!(error(b"P2 2 1 255\n1"), too_short().to_string());
        assert_eq!(error(b"P4 9 1\n\x01"), too_short().to_string());
        assert_eq!(error(b"P5 x"), "its header has no width");
        assert_eq!(error(b"P5 2"), "its header has no height");
        assert_eq!(error(b"P5 99999999999 1 255"), "its width is too large");
        assert_eq!(
            error(b"P5 2 1 0\n"),
            "its largest value is not from 1 to 65535"
        );
        assert_eq!(error(b"P2 1 1 255 x"), "a pixel is not a number");
        assert_eq!(error(b"P1 1 1 2"), "a pixel is neither 0 nor 1");
        assert!(error(b"P5 101 1 255\n").contains("more than 100 bytes"));
    }
}

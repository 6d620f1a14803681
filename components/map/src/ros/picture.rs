//! Reads the image of a ROS map: PNG or a Netpbm format (PBM, PGM, PPM).

use std::io::Cursor;

use png::{ColorType, Decoder, DecodingError, Encoder, Limits, Transformations};

use super::netpbm;
use crate::error::{MapError, MapFault};
use crate::format::{MapSettings, MapSource};

/// The signature of a PNG file.
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Pixels in rows from the top, 8 bits per channel.
#[derive(Debug)]
pub struct MapPicture {
    /// Number of pixels in a row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    channels: Channels,
    /// One byte per channel of each pixel.
    samples: Vec<u8>,
}

/// The channels of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Channels {
    /// Brightness.
    Grey,
    /// Brightness and opacity.
    GreyAlpha,
    /// Red, green and blue.
    Rgb,
    /// Red, green, blue and opacity.
    Rgba,
}

/// One pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// Red, green and blue; equal for a grey pixel.
    pub colour: [u8; 3],
    /// Opacity, 255 for opaque; `None` if the image has no such channel.
    pub alpha: Option<u8>,
}

impl Channels {
    /// Number of bytes per pixel.
    pub fn count(self) -> usize {
        match self {
            Self::Grey => 1,
            Self::GreyAlpha => 2,
            Self::Rgb => 3,
            Self::Rgba => 4,
        }
    }
}

impl MapPicture {
    /// Creates a picture; `None` if the number of samples does not fit.
    pub fn new(width: u32, height: u32, channels: Channels, samples: Vec<u8>) -> Option<Self> {
        let pixels = (width as usize).checked_mul(height as usize)?;
        let expected = pixels.checked_mul(channels.count())?;
        (samples.len() == expected).then_some(Self {
            width,
            height,
            channels,
            samples,
        })
    }

    /// The pixels from the lower left to the upper right, which is the order of a grid's cells.
    pub fn upwards(&self) -> impl Iterator<Item = Pixel> {
        let size = self.channels.count();
        let row = (self.width as usize * size).max(1);
        let rows = self.samples.chunks_exact(row).rev();
        let pixel = |bytes: &[u8]| Pixel::of(self.channels, bytes);
        rows.flat_map(move |row| row.chunks_exact(size).map(pixel))
    }
}

impl Pixel {
    fn of(channels: Channels, bytes: &[u8]) -> Self {
        let sample = |index: usize| bytes.get(index).copied().unwrap_or_default();
        let (colour, alpha) = match channels {
            Channels::Grey => ([sample(0); 3], None),
            Channels::GreyAlpha => ([sample(0); 3], Some(sample(1))),
            Channels::Rgb => ([sample(0), sample(1), sample(2)], None),
            Channels::Rgba => ([sample(0), sample(1), sample(2)], Some(sample(3))),
        };
        Self { colour, alpha }
    }
}

/// Reads an image; fails if decompression would need more bytes than the settings allow.
///
/// # Errors
/// An error if the file cannot be read, has another format, is damaged, or is too large.
pub fn read(source: &MapSource<'_>, settings: &MapSettings) -> Result<MapPicture, MapError> {
    let bytes = source.bytes()?;
    let picture = match &*bytes {
        [b'P', b'1'..=b'6', ..] => netpbm::read(&bytes, settings.max_bytes),
        png if png.starts_with(PNG) => read_png(png, settings.max_bytes),
        _ => Err(syntax("is neither PNG nor PBM, PGM or PPM")),
    };
    picture.map_err(|fault| source.error(fault))
}

fn syntax(what: impl ToString) -> MapFault {
    MapFault::Syntax {
        what: what.to_string(),
    }
}

fn read_png(bytes: &[u8], limit: u64) -> Result<MapPicture, MapFault> {
    let wrong = |error: DecodingError| {
        if let DecodingError::LimitsExceeded = error {
            MapFault::TooManyBytes { limit }
        } else {
            syntax(error)
        }
    };
    // a pixel may need several bytes
    let most = usize::try_from(limit.saturating_mul(2)).unwrap_or(usize::MAX);
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: most });
    // converts palettes to colours, and fewer than eight bits to eight
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(wrong)?;
    let pixels = u64::from(reader.info().width) * u64::from(reader.info().height);
    let size = reader.output_buffer_size().filter(|size| *size <= most);
    let (Some(size), true) = (size, pixels <= limit) else {
        return Err(MapFault::TooManyBytes { limit });
    };
    let mut samples = vec![0; size];
    let frame = reader.next_frame(&mut samples).map_err(wrong)?;
    samples.truncate(frame.buffer_size());
    let samples = match frame.bit_depth {
        png::BitDepth::Sixteen => {
            let pairs = samples.chunks_exact(2);
            pairs
                .map(|it| narrow(u16::from_be_bytes([it[0], it[1]])))
                .collect()
        }
        png::BitDepth::One | png::BitDepth::Two | png::BitDepth::Four | png::BitDepth::Eight => {
            samples
        }
    };
    let channels = match frame.color_type {
        ColorType::Grayscale => Channels::Grey,
        ColorType::GrayscaleAlpha => Channels::GreyAlpha,
        ColorType::Rgb => Channels::Rgb,
        ColorType::Rgba => Channels::Rgba,
        ColorType::Indexed => return Err(syntax("its palette cannot be read")),
    };
    let picture = MapPicture::new(frame.width, frame.height, channels, samples);
    picture.ok_or_else(|| syntax("ends too early"))
}

/// Converts a sample from 16 to 8 bits, rounded to nearest: 65535 becomes 255.
pub fn narrow(sample: u16) -> u8 {
    ((u32::from(sample) + 128) / 257) as u8
}

/// Writes a grey PNG with one byte per pixel, in rows from the top.
///
/// # Errors
/// An error if there are no pixels, or if their number does not match the size.
pub fn write_png(width: u32, height: u32, shades: &[u8]) -> Result<Vec<u8>, MapFault> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width, height);
    encoder.set_color(ColorType::Grayscale);
    let mut writer = encoder.write_header().map_err(syntax)?;
    writer.write_image_data(shades).map_err(syntax)?;
    writer.finish().map_err(syntax)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use png::BitDepth;

    /// A PNG with a single row.
    fn png(colour: ColorType, depth: BitDepth, width: u32, data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, width, 1);
        encoder.set_color(colour);
        encoder.set_depth(depth);
        if colour == ColorType::Indexed {
            encoder.set_palette(vec![10, 20, 30, 40, 50, 60]);
            encoder.set_trns(vec![255, 7]);
        }
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(data).unwrap();
        writer.finish().unwrap();
        bytes
    }

    fn pixels(png: &[u8]) -> Vec<([u8; 3], Option<u8>)> {
        let picture = read_png(png, 1000).unwrap();
        picture.upwards().map(|it| (it.colour, it.alpha)).collect()
    }

    #[test]
    fn it_reads_every_kind_of_png() {
        let grey = |shade| ([shade; 3], None);
        let one = png(ColorType::Grayscale, BitDepth::One, 3, &[0b0100_0000]);
        assert_eq!(pixels(&one), [grey(0), grey(255), grey(0)]);
        let four = png(ColorType::Grayscale, BitDepth::Four, 2, &[0x1f]);
        assert_eq!(pixels(&four), [grey(17), grey(255)]);
        let eight = png(ColorType::Grayscale, BitDepth::Eight, 2, &[3, 205]);
        assert_eq!(pixels(&eight), [grey(3), grey(205)]);
        // 128 of 65535 is nearer to 0 than to 1 of 255; 129 is not
        let wide = [0, 128, 0, 129, 0xff, 0xff];
        let sixteen = png(ColorType::Grayscale, BitDepth::Sixteen, 3, &wide);
        assert_eq!(pixels(&sixteen), [grey(0), grey(1), grey(255)]);
        let alpha = png(ColorType::GrayscaleAlpha, BitDepth::Eight, 1, &[9, 8]);
        assert_eq!(pixels(&alpha), [([9; 3], Some(8))]);
        let rgb = png(ColorType::Rgb, BitDepth::Eight, 1, &[1, 2, 3]);
        assert_eq!(pixels(&rgb), [([1, 2, 3], None)]);
        let rgba = png(ColorType::Rgba, BitDepth::Eight, 1, &[1, 2, 3, 4]);
        assert_eq!(pixels(&rgba), [([1, 2, 3], Some(4))]);
        let palette = png(ColorType::Indexed, BitDepth::Two, 2, &[0b0001_0000]);
        let colours = [([10, 20, 30], Some(255)), ([40, 50, 60], Some(7))];
        assert_eq!(pixels(&palette), colours);
    }

    #[test]
    fn it_unpacks_no_more_than_it_may() {
        let wide = png(ColorType::Grayscale, BitDepth::Eight, 2000, &[7; 2000]);
        let limit = |limit| read_png(&wide, limit).map(|it| it.width);
        assert_eq!(limit(1999), Err(MapFault::TooManyBytes { limit: 1999 }));
        assert_eq!(limit(100), Err(MapFault::TooManyBytes { limit: 100 }));
        assert_eq!(limit(50_000), Ok(2000));
    }
}

//! The trait of map formats, their settings and their source.

use asmotion_geometry::Occupancy;

use crate::error::{MapError, MapFault, Where};
use crate::files::{FileFault, FileSource, read_at_most};
use crate::map::Map;
use crate::rules::Rules;

/// Reads a map file of one format. Never panics, whatever the content, and uses no more memory than the settings allow.
pub trait MapFormat: Send + Sync {
    /// The endings of its files, with the dot; each may be followed by `.gz`.
    fn endings(&self) -> &'static [&'static str];

    /// Reads the map. Equal content gives equal maps.
    ///
    /// # Errors
    /// The file cannot be read, is malformed, exceeds a limit of the settings, or contains nothing to draw: see
    /// [`MapFault`].
    fn load(&self, source: &MapSource<'_>, settings: &MapSettings) -> Result<Map, MapError>;
}

/// Settings of loading, common to all formats.
#[derive(Clone, Debug, PartialEq)]
pub struct MapSettings {
    /// Side length of a cell, m; `None` uses the file's value or the format's default. The resolution of a ROS map can
    /// only be reduced.
    pub resolution: Option<f64>,
    /// Limit on the number of cells of a grid; each uses one byte.
    pub max_cells: u64,
    /// Limit on the size of a file in bytes, after decompression.
    pub max_bytes: u64,
    /// Occupancy of places that no feature covers; `None` uses the file's value or free.
    pub ground: Option<Occupancy>,
    /// The rules that determine the occupancy of features (GeoJSON and OSM).
    pub rules: Rules,
    /// Frame of the grid, which its header names.
    pub frame: String,
}

impl Default for MapSettings {
    fn default() -> Self {
        Self {
            resolution: None,
            max_cells: 25_000_000,
            max_bytes: 64 << 20,
            ground: None,
            rules: Rules::default(),
            frame: "map".to_owned(),
        }
    }
}

/// A map file, and the source to read it from.
pub struct MapSource<'a> {
    files: &'a dyn FileSource,
    name: String,
    limit: u64,
}

impl<'a> MapSource<'a> {
    /// The file with this name.
    pub fn new(files: &'a dyn FileSource, name: &str, settings: &MapSettings) -> Self {
        Self {
            files,
            name: name.to_owned(),
            limit: settings.max_bytes,
        }
    }

    /// Name of the file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Reads the file, and decompresses it if its name ends in `.gz`.
    ///
    /// # Errors
    /// The file cannot be read, its content is longer than the limit, or its compression is damaged.
    pub fn bytes(&self) -> Result<Vec<u8>, MapError> {
        let bytes = self.files.read(&self.name, self.limit);
        let bytes = bytes.map_err(|fault| self.unread(fault))?;
        if !self.name.ends_with(".gz") {
            return Ok(bytes);
        }
        let unpacked = flate2::read::MultiGzDecoder::new(&bytes[..]);
        read_at_most(unpacked, self.limit).map_err(|fault| match fault {
            FileFault::Other(reason) => self.error(MapFault::Syntax {
                what: format!("is not gzip, or damaged: {reason}"),
            }),
            fault @ (FileFault::Missing | FileFault::TooLong) => self.unread(fault),
        })
    }

    /// Reads the file as UTF-8 text.
    ///
    /// # Errors
    /// As [`bytes`](Self::bytes), and [`MapFault::Syntax`] with the position of the first byte that is not UTF-8.
    pub fn text(&self) -> Result<String, MapError> {
        String::from_utf8(self.bytes()?).map_err(|error| {
            let byte = error.utf8_error().valid_up_to() as u64;
            let what = "is not UTF-8 text".to_owned();
            self.error_at(Where::Byte(byte), MapFault::Syntax { what })
        })
    }

    /// A file with a name relative to the folder of this one.
    pub fn beside(&self, name: &str) -> MapSource<'_> {
        let folder = self.name.rfind('/').map_or("", |at| &self.name[..=at]);
        let absolute = name.starts_with('/');
        MapSource {
            files: self.files,
            name: if absolute {
                name.to_owned()
            } else {
                format!("{folder}{name}")
            },
            limit: self.limit,
        }
    }

    /// An error concerning this file as a whole.
    pub fn error(&self, fault: MapFault) -> MapError {
        self.error_at(Where::File, fault)
    }

    /// An error at a place of this file.
    pub fn error_at(&self, at: Where, fault: MapFault) -> MapError {
        MapError {
            file: self.name.clone(),
            at,
            fault,
        }
    }

    fn unread(&self, fault: FileFault) -> MapError {
        self.error(match fault {
            FileFault::Missing => MapFault::Missing,
            FileFault::TooLong => MapFault::TooManyBytes { limit: self.limit },
            FileFault::Other(reason) => MapFault::Unreadable { reason },
        })
    }
}

//! The seam: the trait of map formats (bytes in, a map out), their settings, and the table of formats.

use asmotion_geometry::Occupancy;

use crate::error::{MapError, MapFault, Where};
use crate::files::{FileFault, FileSource, read_at_most};
use crate::geo_json::GeoJson;
use crate::map::Map;
use crate::osm::OsmPbf;
#[cfg(feature = "maps")]
use crate::osm::OsmXml;
#[cfg(feature = "maps")]
use crate::ros::RosMap;
use crate::rules::Rules;

/// Reads one kind of map file. Never panics, whatever the bytes are, and holds no more memory than the settings allow.
pub trait MapFormat: Sync {
    /// The endings of its files, with the dot; `.gz` may follow any of them.
    fn endings(&self) -> &'static [&'static str];

    /// The map in the file. The same bytes give the same map.
    ///
    /// # Errors
    /// The file cannot be read, is malformed, exceeds a limit of the settings, or contains nothing to draw: see
    /// [`MapFault`].
    fn load(&self, source: &MapSource<'_>, settings: &MapSettings) -> Result<Map, MapError>;
}

/// Every format by its name. Where a place has files of several formats, the first row wins.
pub const FORMATS: &[(&str, &dyn MapFormat)] = &[
    ("geojson", &GeoJson),
    #[cfg(feature = "maps")]
    ("ros", &RosMap),
    #[cfg(feature = "maps")]
    ("osm", &OsmXml),
    ("osm.pbf", &OsmPbf),
];

/// The endings of formats that a build without the feature `maps` leaves out.
const LEFT_OUT: &[&str] = if cfg!(feature = "maps") {
    &[]
} else {
    &[".yaml", ".yml", ".osm", ".osm.xml"]
};

/// Settings of loading, common to all formats.
#[derive(Clone, Debug, PartialEq)]
pub struct MapSettings {
    /// Side of a cell, m; none takes what the file says, or what suits its kind. A ROS map is made coarser if need be,
    /// never finer.
    pub resolution: Option<f64>,
    /// No grid has more cells; a byte each.
    pub max_cells: u64,
    /// No file has more bytes, unpacked.
    pub max_bytes: u64,
    /// Occupancy of places no feature covers; none takes the file's, or free.
    pub ground: Option<Occupancy>,
    /// Which features block and which are free (GeoJSON and OSM).
    pub rules: Rules,
}

impl Default for MapSettings {
    fn default() -> Self {
        Self {
            resolution: None,
            max_cells: 25_000_000,
            max_bytes: 64 << 20,
            ground: None,
            rules: Rules::default(),
        }
    }
}

/// Loads the map in file `name`, whose ending decides the format.
///
/// # Errors
/// [`MapFault::UnknownFormat`] for another ending, [`MapFault::LeftOut`] if the build lacks the format, and the errors
/// of [`MapFormat::load`].
pub fn load(files: &dyn FileSource, name: &str, settings: &MapSettings) -> Result<Map, MapError> {
    let source = MapSource::new(files, name, settings);
    match format_of(name) {
        Some(format) => format.load(&source, settings),
        None if LEFT_OUT.iter().any(|ending| stem(name, ending).is_some()) => {
            Err(source.error(MapFault::LeftOut { feature: "maps" }))
        }
        None => Err(source.error(MapFault::UnknownFormat {
            known: endings().collect::<Vec<_>>().join(" "),
        })),
    }
}

/// The format whose ending the file has.
pub fn format_of(name: &str) -> Option<&'static dyn MapFormat> {
    FORMATS.iter().map(|(_, format)| *format).find(|format| {
        format
            .endings()
            .iter()
            .any(|ending| stem(name, ending).is_some())
    })
}

/// Every ending in the order of the table.
pub fn endings() -> impl Iterator<Item = &'static str> {
    FORMATS
        .iter()
        .flat_map(|(_, format)| format.endings().iter().copied())
}

/// The name without the ending, packed or not; none if it ends otherwise.
pub fn stem<'a>(name: &'a str, ending: &str) -> Option<&'a str> {
    name.strip_suffix(".gz")
        .unwrap_or(name)
        .strip_suffix(ending)
}

/// A file and how to get it.
pub struct MapSource<'a> {
    files: &'a dyn FileSource,
    name: String,
    limit: u64,
}

impl<'a> MapSource<'a> {
    /// The file called `name`.
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

    /// The file's bytes, unpacked if its name ends in `.gz`.
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

    /// The file's text.
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

    /// Another file, named as this one names it: relative to this one's folder.
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

    /// An error of this file.
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

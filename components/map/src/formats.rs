//! The table of map formats.

use std::fmt;

use crate::error::{MapError, MapFault};
use crate::files::FileSource;
use crate::format::{MapFormat, MapSettings, MapSource};
use crate::geo_json::GeoJson;
use crate::map::Map;
use crate::osm::OsmPbf;
#[cfg(feature = "maps")]
use crate::osm::OsmXml;
#[cfg(feature = "maps")]
use crate::ros::RosMap;

/// The formats of this crate by name.
pub const FORMATS: &[(&str, &dyn MapFormat)] = &[
    ("geojson", &GeoJson),
    #[cfg(feature = "maps")]
    ("ros", &RosMap),
    #[cfg(feature = "maps")]
    ("osm", &OsmXml),
    ("osm.pbf", &OsmPbf),
];

/// Endings of the formats that a build without the feature `maps` does not include.
const LEFT_OUT: &[&str] = if cfg!(feature = "maps") {
    &[]
} else {
    &[".yaml", ".yml", ".osm", ".osm.xml"]
};

/// A selection of map formats, by name. If a place has files of several formats, the first one wins.
#[derive(Clone)]
pub struct MapFormats(Vec<(&'static str, &'static dyn MapFormat)>);

impl MapFormats {
    /// All formats of [`FORMATS`].
    pub fn standard() -> Self {
        Self(FORMATS.to_vec())
    }

    /// No format.
    pub fn none() -> Self {
        Self(Vec::new())
    }

    /// Adds a format, which wins over the others: its endings are compared first.
    pub fn with(mut self, name: &'static str, format: &'static dyn MapFormat) -> Self {
        self.0.insert(0, (name, format));
        self
    }

    /// The formats, in the order in which their endings are compared.
    pub fn iter(&self) -> impl Iterator<Item = &'static dyn MapFormat> {
        self.0.iter().map(|(_, format)| *format)
    }

    /// The format that matches the file's ending.
    pub fn of_file(&self, name: &str) -> Option<&'static dyn MapFormat> {
        self.iter().find(|format| {
            let mut endings = format.endings().iter();
            endings.any(|ending| stem(name, ending).is_some())
        })
    }

    /// All endings, in order.
    pub fn endings(&self) -> impl Iterator<Item = &'static str> {
        self.iter()
            .flat_map(|format| format.endings().iter().copied())
    }

    /// Loads the map in file `name`, whose ending determines the format.
    ///
    /// # Errors
    /// [`MapFault::UnknownFormat`](crate::MapFault::UnknownFormat) for another ending,
    /// [`MapFault::LeftOut`](crate::MapFault::LeftOut) if the build lacks the format, and the errors of the format.
    pub fn load(
        &self,
        files: &dyn FileSource,
        name: &str,
        settings: &MapSettings,
    ) -> Result<Map, MapError> {
        let source = MapSource::new(files, name, settings);
        match self.of_file(name) {
            Some(format) => format.load(&source, settings),
            None if LEFT_OUT.iter().any(|ending| stem(name, ending).is_some()) => {
                Err(source.error(MapFault::LeftOut { feature: "maps" }))
            }
            None => Err(source.error(MapFault::UnknownFormat {
                known: self.endings().collect::<Vec<_>>().join(" "),
            })),
        }
    }
}

impl fmt::Debug for MapFormats {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list()
            .entries(self.0.iter().map(|(name, _)| name))
            .finish()
    }
}

/// Loads the map in file `name` in one of the formats of this crate; see [`MapFormats::load`].
///
/// # Errors
/// As [`MapFormats::load`].
pub fn load(files: &dyn FileSource, name: &str, settings: &MapSettings) -> Result<Map, MapError> {
    MapFormats::standard().load(files, name, settings)
}

/// The name without the ending and an optional `.gz`; `None` if it has another ending.
pub fn stem<'a>(name: &'a str, ending: &str) -> Option<&'a str> {
    name.strip_suffix(".gz")
        .unwrap_or(name)
        .strip_suffix(ending)
}

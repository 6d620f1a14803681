//! The table of map formats.

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

/// All formats by name. If a place has files of several formats, the first row wins.
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

/// Loads the map in file `name`, whose ending determines the format.
///
/// # Errors
/// [`MapFault::UnknownFormat`](crate::MapFault::UnknownFormat) for another ending,
/// [`MapFault::LeftOut`](crate::MapFault::LeftOut) if the build lacks the format, and the errors of the format.
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

/// The format that matches the file's ending.
pub fn format_of(name: &str) -> Option<&'static dyn MapFormat> {
    FORMATS.iter().map(|(_, format)| *format).find(|format| {
        format
            .endings()
            .iter()
            .any(|ending| stem(name, ending).is_some())
    })
}

/// All endings, in the order of the table.
pub fn endings() -> impl Iterator<Item = &'static str> {
    FORMATS
        .iter()
        .flat_map(|(_, format)| format.endings().iter().copied())
}

/// The name without the ending and an optional `.gz`; `None` if it has another ending.
pub fn stem<'a>(name: &'a str, ending: &str) -> Option<&'a str> {
    name.strip_suffix(".gz")
        .unwrap_or(name)
        .strip_suffix(ending)
}

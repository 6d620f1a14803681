//! Maps: converts floor plans, OpenStreetMap extracts and ROS maps to occupancy grids, which a server provides by name.
//!
//! Metres in the map frame, x forward (east), y left (north), angles counter-clockwise (REP-103, REP-105).

pub mod contract;
mod drawing;
mod error;
mod files;
mod format;
mod formats;
mod geo_json;
mod library;
mod map;
mod osm;
mod projection;
#[cfg(feature = "maps")]
pub mod ros;
mod rules;
mod server;

pub use error::{MapError, MapFault, Where};
pub use files::{DiskFiles, FileFault, FileSource, FilesInMemory};
pub use format::{MapFormat, MapSettings, MapSource};
pub use formats::{FORMATS, MapFormats, load};
pub use library::{
    Load, LoadedPlace, Lookup, MapLibrary, PlaceEntry, Places, Refresh, ServeError, ServedMap,
};
pub use map::{LonLat, Map, NamedPoint};
pub use rules::{DEFAULT_RULES, FeatureRule, RuleError, Rules, Tags};
pub use server::MapServer;

/// Protocol of the map server: what it sends, depending on what it receives.
pub const PROTOCOL: &str = include_str!("../protocol.asm");

//! Maps: floor plans, city extracts and ROS maps become occupancy grids, and a server hands them out by name.
//!
//! Metres in the map frame, x forward (east), y left (north), angles counter-clockwise (REP-103, REP-105).

mod drawing;
mod error;
mod files;
mod format;
mod geo_json;
mod library;
mod map;
mod osm;
mod projection;
#[cfg(feature = "maps")]
pub mod ros;
mod rules;
mod server;

pub use error::{Fault, MapError, Where};
pub use files::{Disk, FileFault, Files, Memory};
pub use format::{FORMATS, Format, Settings, Source, load};
pub use library::{Entry, Library, Load, Loaded, Lookup, Places, Refresh, ServeError, Served};
pub use map::{LonLat, Map, NamedPoint};
pub use rules::{DEFAULT_RULES, Rule, RuleError, Rules, Tags};
pub use server::MapServer;

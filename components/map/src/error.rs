//! Errors of maps: the file, the place in it, the cause, and a remedy.

use std::fmt;

use asmotion_geometry::GridLayoutError;

/// A map that could not be loaded.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{file}{at}: {fault}")]
pub struct MapError {
    /// Name of the faulty file: the image, for example, and not the YAML file that refers to it.
    pub file: String,
    /// Place in the file.
    pub at: Where,
    /// Cause, with a remedy.
    pub fault: MapFault,
}

/// A place in a file, counted as usual for its format.
#[derive(Clone, Debug, PartialEq)]
pub enum Where {
    /// The file as a whole.
    File,
    /// A character in a text file.
    Line {
        /// Line, from 1.
        line: u64,
        /// Column, from 1.
        column: u64,
    },
    /// Offset of a byte, from 0.
    Byte(u64),
    /// Index of a GeoJSON feature, from 0.
    Feature(usize),
    /// An OSM element.
    Element {
        /// Kind of the element: `node`, `way` or `relation`.
        kind: &'static str,
        /// Id of the element.
        id: i64,
    },
}

impl Where {
    /// The line and column of a byte in a text.
    pub fn in_text(text: &str, byte: usize) -> Self {
        let before = text.as_bytes().get(..byte).unwrap_or(text.as_bytes());
        let start = before
            .iter()
            .rposition(|byte| *byte == b'\n')
            .map_or(0, |at| at + 1);
        Self::Line {
            line: before.iter().filter(|byte| **byte == b'\n').count() as u64 + 1,
            column: (before.len() - start) as u64 + 1,
        }
    }
}

impl fmt::Display for Where {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Line { line, column } => write!(f, ":{line}:{column}"),
            Self::Byte(byte) => write!(f, ", byte {byte}"),
            Self::Feature(index) => write!(f, ", features[{index}]"),
            Self::Element { kind, id } => write!(f, ", {kind} {id}"),
        }
    }
}

/// Cause of an error.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MapFault {
    /// The file does not exist.
    #[error("file not found")]
    Missing,
    /// The operating system cannot read the file.
    #[error("cannot be read: {reason}")]
    Unreadable {
        /// The operating system's message.
        reason: String,
    },
    /// The file exceeds the limit on its size.
    #[error("has more than {limit} bytes; cut a smaller extract, or raise `max_bytes`")]
    TooManyBytes {
        /// Limit in bytes, after decompression.
        limit: u64,
    },
    /// No format has the file's ending.
    #[error("unknown map format; the known endings are {known}")]
    UnknownFormat {
        /// All known endings.
        known: String,
    },
    /// This build does not include the reader of the format.
    #[error(
        "maps of this format need the feature `{feature}`, which is not in this build: build it with `--features {feature}`"
    )]
    LeftOut {
        /// Cargo feature that includes it.
        feature: &'static str,
    },
    /// The content does not have the format that the ending implies.
    #[error("{what}")]
    Syntax {
        /// The parser's message.
        what: String,
    },
    /// A value that is not allowed.
    #[error("`{key}` is {found}; it must be {expected}")]
    Value {
        /// Name of the value.
        key: String,
        /// The value found.
        found: String,
        /// The values allowed.
        expected: &'static str,
    },
    /// Coordinates that are not degrees.
    #[error(
        "({x}, {y}) is not a longitude and latitude; for coordinates in metres, add \"map\": {{\"units\": \"metres\"}}"
    )]
    NotDegrees {
        /// First coordinate.
        x: f64,
        /// Second coordinate.
        y: f64,
    },
    /// A place too far from the map's centre for the projection.
    #[error(
        "({longitude}, {latitude}) is too far from the middle of the map; cut a smaller extract"
    )]
    TooFar {
        /// Degrees east.
        longitude: f64,
        /// Degrees north.
        latitude: f64,
    },
    /// A coordinate reference system other than WGS 84.
    #[error(
        "the coordinate reference system {name} is not supported; convert the file to WGS 84 (EPSG:4326)"
    )]
    ReferenceSystem {
        /// Name of the system, as in the file.
        name: String,
    },
    /// The file contains nothing that can be drawn.
    #[error("no element can be drawn, so the map has no extent; check that a rule names its tags")]
    Nothing,
    /// The grid would be too large.
    #[error(
        "{width} × {height} cells of {resolution} m are more than `max_cells` = {limit}; set `resolution_m` to {fits} or more"
    )]
    TooLarge {
        /// Number of cells along x.
        width: f64,
        /// Number of cells along y.
        height: f64,
        /// Side length of a cell, m.
        resolution: f64,
        /// Limit on the number of cells.
        limit: u64,
        /// The finest resolution at which the map fits, m.
        fits: f64,
    },
    /// The file contains more elements than the limit.
    #[error("has more than {limit} elements; cut a smaller extract")]
    TooManyElements {
        /// Limit on the number of elements.
        limit: usize,
    },
    /// Invalid size or resolution of the grid.
    #[error(transparent)]
    Layout(#[from] GridLayoutError),
}

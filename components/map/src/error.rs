//! Errors of maps: the file, the place in it, the cause, and the way out.

use std::fmt;

use asmotion_geometry::GridLayoutError;

/// A map that could not be loaded.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{file}{at}: {fault}")]
pub struct MapError {
    /// The file that is wrong: the image, for instance, not the YAML file that names it.
    pub file: String,
    /// Place in the file.
    pub at: Where,
    /// Cause, with the way out.
    pub fault: MapFault,
}

/// A place in a file, as its readers count.
#[derive(Clone, Debug, PartialEq)]
pub enum Where {
    /// The file as a whole.
    File,
    /// A character; both from 1.
    Line {
        /// From 1.
        line: u64,
        /// From 1.
        column: u64,
    },
    /// A byte, from 0.
    Byte(u64),
    /// A GeoJSON feature, from 0.
    Feature(usize),
    /// An OSM element.
    Element {
        /// `node`, `way`, `relation`.
        kind: &'static str,
        /// Its id.
        id: i64,
    },
}

impl Where {
    /// The line and column of a byte of a text.
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
    /// No such file.
    #[error("there is no such file")]
    Missing,
    /// The system would not give it.
    #[error("cannot be read: {reason}")]
    Unreadable {
        /// The system's words.
        reason: String,
    },
    /// More bytes than may be read.
    #[error("has more than {limit} bytes; cut a smaller extract, or raise `max_bytes`")]
    TooManyBytes {
        /// Bytes, unpacked.
        limit: u64,
    },
    /// No row of the table of formats claims the file.
    #[error("no map format has this ending; known are {known}")]
    UnknownFormat {
        /// Their endings.
        known: String,
    },
    /// This build leaves the reader of the format out.
    #[error(
        "maps of this format need the feature `{feature}`, which is not in this build: build it with `--features {feature}`"
    )]
    LeftOut {
        /// The Cargo feature that adds it.
        feature: &'static str,
    },
    /// The file is not what its ending says.
    #[error("{what}")]
    Syntax {
        /// The parser's words.
        what: String,
    },
    /// A value that cannot be.
    #[error("`{key}` is {found}; it must be {expected}")]
    Value {
        /// Its name.
        key: String,
        /// The value found.
        found: String,
        /// The values allowed.
        expected: &'static str,
    },
    /// The coordinates are no degrees.
    #[error(
        "({x}, {y}) is no longitude and latitude; if the coordinates are metres, say so: \"map\": {{\"units\": \"metres\"}}"
    )]
    NotDegrees {
        /// The first number.
        x: f64,
        /// The second.
        y: f64,
    },
    /// A place on the other side of the Earth.
    #[error(
        "({longitude}, {latitude}) lies too far from the middle of the map; cut a smaller extract"
    )]
    TooFar {
        /// Degrees east.
        longitude: f64,
        /// Degrees north.
        latitude: f64,
    },
    /// Another coordinate reference system.
    #[error(
        "the coordinate reference system {name} is not supported; convert the file to WGS 84 (EPSG:4326)"
    )]
    ReferenceSystem {
        /// As the file says it.
        name: String,
    },
    /// There is nothing on the map.
    #[error("nothing in it can be drawn, so the map has no extent; does a rule name its tags?")]
    Nothing,
    /// The grid would be too large.
    #[error(
        "{width} × {height} cells of {resolution} m are more than `max_cells` = {limit}; set `resolution_m` to {fits} or more"
    )]
    TooLarge {
        /// Cells along x.
        width: f64,
        /// Cells along y.
        height: f64,
        /// Side of a cell, m.
        resolution: f64,
        /// The largest number of cells.
        limit: u64,
        /// A resolution at which the map fits, m.
        fits: f64,
    },
    /// More things than may be held in memory.
    #[error("has more than {limit} elements; cut a smaller extract")]
    TooManyElements {
        /// The largest number.
        limit: usize,
    },
    /// The grid's numbers are none.
    #[error(transparent)]
    Layout(#[from] GridLayoutError),
}

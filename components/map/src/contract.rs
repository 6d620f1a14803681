//! The guarantees of a map format, as a test suite that every format passes.
//!
//! The suite loads the map of a yard with a building, whole, packed, coarser and damaged. A case returns a description of
//! the failure, if any.

use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};

use asmotion_geometry::{Occupancy, Point};
use flate2::Compression;
use flate2::write::GzEncoder;

use crate::error::{MapError, MapFault};
use crate::files::FilesInMemory;
use crate::format::{MapFormat, MapSettings};
use crate::formats::MapFormats;
use crate::map::Map;

/// A map in the format under test: a free yard with a building.
///
/// At the default resolution it has at least 500 cells, and its files at least 100 bytes together with their references.
#[derive(Clone, Debug)]
pub struct Yard {
    /// The file to load, followed by the files it refers to: names and contents.
    pub files: Vec<(&'static str, Vec<u8>)>,
    /// A point in the building, map frame, m.
    pub occupied: (f64, f64),
    /// A point in the yard, map frame, m.
    pub free: (f64, f64),
}

type Case = fn(&Yard, &MapFormats) -> Result<(), String>;

const CASES: &[(&str, Case)] = &[
    ("the building is occupied and the yard is free", reads),
    ("equal files give equal maps", is_deterministic),
    ("a file packed by gzip is read", reads_packed),
    ("a coarser resolution is obeyed", reads_coarsely),
    (
        "a grid that is too large is refused with a resolution that fits",
        refuses_large_grid,
    ),
    ("a file that is too long is refused", refuses_long_file),
    ("a missing file is named", names_missing_file),
    ("no truncation is a panic", survives_truncation),
    ("no changed byte is a panic", survives_changed_bytes),
];

/// Runs the suite; a format keeps the contract if this is empty. A violation is the case, and the observed behaviour.
pub fn violations(format: &'static dyn MapFormat, yard: &Yard) -> Vec<String> {
    let formats = MapFormats::none().with("tested", format);
    let run = |(case, check): &(&str, Case)| {
        let checked = catch_unwind(AssertUnwindSafe(|| check(yard, &formats)));
        let observed = checked
            .unwrap_or_else(|_| Err("panicked".to_owned()))
            .err()?;
        Some(format!("{case}: {observed}"))
    };
    CASES.iter().filter_map(run).collect()
}

fn reads(yard: &Yard, formats: &MapFormats) -> Result<(), String> {
    check_content(&load_yard(yard, formats, &MapSettings::default())?, yard)
}

fn is_deterministic(yard: &Yard, formats: &MapFormats) -> Result<(), String> {
    let same = load_yard(yard, formats, &MapSettings::default())?.grid
        == load_yard(yard, formats, &MapSettings::default())?.grid;
    require(same, || "the second map differs from the first".to_owned())
}

fn reads_packed(yard: &Yard, formats: &MapFormats) -> Result<(), String> {
    let (name, files) = packed(yard)?;
    let map = formats.load(&FilesInMemory::new(files), &name, &MapSettings::default());
    check_content(&map.map_err(|error| error.to_string())?, yard)
}

fn reads_coarsely(yard: &Yard, formats: &MapFormats) -> Result<(), String> {
    let fine = load_yard(yard, formats, &MapSettings::default())?;
    let resolution = 2.0 * fine.grid.layout().resolution();
    let coarse = MapSettings {
        resolution: Some(resolution),
        ..MapSettings::default()
    };
    let coarse = load_yard(yard, formats, &coarse)?;
    check_content(&coarse, yard)?;
    let observed = coarse.grid.layout().resolution();
    require((observed - resolution).abs() < 1e-9, || {
        format!("cells of {observed} m instead of {resolution} m")
    })?;
    let (cells, fine) = (coarse.grid.cells().len(), fine.grid.cells().len());
    require(cells * 3 < fine, || {
        format!("{cells} cells, {fine} at half the resolution")
    })
}

fn refuses_large_grid(yard: &Yard, formats: &MapFormats) -> Result<(), String> {
    let small = MapSettings {
        max_cells: 400,
        ..MapSettings::default()
    };
    let error = refused(read(yard, formats, &small))?;
    let MapFault::TooLarge { fits, .. } = error.fault else {
        return Err(error.to_string());
    };
    let fitting = MapSettings {
        resolution: Some(fits),
        ..small
    };
    load_yard(yard, formats, &fitting).map(drop)
}

fn refuses_long_file(yard: &Yard, formats: &MapFormats) -> Result<(), String> {
    let too_long = |error: MapError, limit| {
        let expected = MapFault::TooManyBytes { limit };
        require(error.fault == expected, || error.to_string())
    };
    let (Some((_, first)), limit) = (yard.files.first(), 20) else {
        return Err("the yard has no file".to_owned());
    };
    let short = MapSettings {
        max_bytes: limit,
        ..MapSettings::default()
    };
    too_long(refused(read(yard, formats, &short))?, limit)?;
    // decompressed it is too long, compressed it is not
    let (name, files) = packed(yard)?;
    let limit = files.first().map_or(0, |(_, bytes)| bytes.len() as u64);
    if limit >= first.len() as u64 {
        return Ok(());
    }
    let short = MapSettings {
        max_bytes: limit,
        ..MapSettings::default()
    };
    let result = formats.load(&FilesInMemory::new(files), &name, &short);
    too_long(refused(result)?, limit)
}

fn names_missing_file(yard: &Yard, formats: &MapFormats) -> Result<(), String> {
    for missing in 0..yard.files.len() {
        let mut rest = yard.clone();
        let (name, _) = rest.files.remove(missing);
        let first = yard.files.first().map_or("", |(name, _)| name);
        let result = formats.load(
            &FilesInMemory::new(rest.files),
            first,
            &MapSettings::default(),
        );
        let error = refused(result)?;
        require(
            error.file == name && error.fault == MapFault::Missing,
            || format!("without `{name}`: {error}"),
        )?;
    }
    Ok(())
}

fn survives_truncation(yard: &Yard, formats: &MapFormats) -> Result<(), String> {
    for (which, (_, bytes)) in yard.files.iter().enumerate() {
        for length in 0..bytes.len() {
            read_damaged(yard, formats, which, bytes.get(..length).unwrap_or(bytes))?;
        }
    }
    Ok(())
}

fn survives_changed_bytes(yard: &Yard, formats: &MapFormats) -> Result<(), String> {
    for (which, (_, bytes)) in yard.files.iter().enumerate() {
        let mut damaged = bytes.clone();
        for at in 0..bytes.len().min(1500) {
            for change in [0x00, 0x01, 0x30, 0x7f, 0x80, 0xff] {
                damaged[at] = change;
                read_damaged(yard, formats, which, &damaged)?;
            }
            damaged[at] = bytes[at];
        }
    }
    Ok(())
}

/// Loads the yard with another content of one file. An error must name a file.
fn read_damaged(
    yard: &Yard,
    formats: &MapFormats,
    which: usize,
    bytes: &[u8],
) -> Result<(), String> {
    let mut damaged = yard.clone();
    if let Some((_, content)) = damaged.files.get_mut(which) {
        *content = bytes.to_vec();
    }
    let settings = MapSettings {
        max_cells: 1_000_000,
        max_bytes: 1 << 20,
        ..MapSettings::default()
    };
    match read(&damaged, formats, &settings) {
        Err(error) if error.file.is_empty() => Err(format!("an error without a file: {error}")),
        Ok(_) | Err(_) => Ok(()),
    }
}

fn read(yard: &Yard, formats: &MapFormats, settings: &MapSettings) -> Result<Map, MapError> {
    let name = yard.files.first().map_or("", |(name, _)| name);
    formats.load(&FilesInMemory::new(yard.files.clone()), name, settings)
}

fn load_yard(yard: &Yard, formats: &MapFormats, settings: &MapSettings) -> Result<Map, String> {
    read(yard, formats, settings).map_err(|error| error.to_string())
}

fn refused(result: Result<Map, MapError>) -> Result<MapError, String> {
    match result {
        Ok(_) => Err("the file is accepted".to_owned()),
        Err(error) => Ok(error),
    }
}

fn check_content(map: &Map, yard: &Yard) -> Result<(), String> {
    for ((x, y), expected) in [
        (yard.occupied, Occupancy::Occupied),
        (yard.free, Occupancy::Free),
    ] {
        let observed = map.grid.occupancy(Point::new(x, y));
        require(observed == expected, || {
            format!("({x}, {y}) is {observed:?} instead of {expected:?}")
        })?;
    }
    Ok(())
}

/// Names and contents of files.
type Files = Vec<(String, Vec<u8>)>;

/// The name of the first file, which ends in `.gz`, and the files with the first one compressed.
fn packed(yard: &Yard) -> Result<(String, Files), String> {
    let mut files = Vec::new();
    for (at, (name, bytes)) in yard.files.iter().enumerate() {
        if at > 0 {
            files.push(((*name).to_owned(), bytes.clone()));
            continue;
        }
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        let written = encoder.write_all(bytes).and_then(|()| encoder.finish());
        files.push((
            format!("{name}.gz"),
            written.map_err(|error| error.to_string())?,
        ));
    }
    let name = files
        .first()
        .map_or_else(String::new, |(name, _)| name.clone());
    Ok((name, files))
}

fn require(condition: bool, otherwise: impl FnOnce() -> String) -> Result<(), String> {
    if condition { Ok(()) } else { Err(otherwise()) }
}

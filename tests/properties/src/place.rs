//! Extracts of OpenStreetMap.

use asmotion_map::{FilesInMemory, MapSettings, load};

/// A small limit, so that a hostile size is refused instead of allocated.
const MAX_CELLS: u64 = 1_000_000;

/// An extract in XML is a map of at most that many cells, or an error that names the file.
pub fn osm(bytes: &[u8]) {
    map("fuzz.osm", bytes);
}

/// The same property for an extract in PBF.
pub fn osm_pbf(bytes: &[u8]) {
    map("fuzz.osm.pbf", bytes);
}

fn map(name: &str, bytes: &[u8]) {
    let settings = MapSettings {
        max_cells: MAX_CELLS,
        max_bytes: 4 << 20,
        ..MapSettings::default()
    };
    match load(&FilesInMemory::new([(name, bytes)]), name, &settings) {
        Ok(map) => {
            let cells = map.grid.cells().len();
            assert!(cells as u64 <= MAX_CELLS, "{cells} cells");
        }
        Err(error) => assert!(error.to_string().contains(name), "{error}"),
    }
}

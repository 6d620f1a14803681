//! The guarantees of map formats, tested for every row of `FORMATS`.

use asmotion_map::contract::{Yard, violations};
use asmotion_map::{FORMATS, FilesInMemory, Map, MapError, MapSettings, load};
use proptest::prelude::*;

#[test]
fn every_format_keeps_the_contract() {
    let yards = crate::fixture::all();
    assert_eq!(yards.len(), FORMATS.len());
    for ((name, format), (of, yard)) in FORMATS.iter().zip(yards) {
        assert_eq!(*name, of);
        assert_eq!(violations(*format, &yard), [""; 0], "{name}");
    }
}

/// A format that forgets the building, another that panics, and one that accepts everything do not pass.
#[test]
fn the_contract_can_be_broken() {
    let (_, yard) = crate::fixture::all().swap_remove(0);
    let elsewhere = Yard {
        occupied: yard.free,
        ..yard.clone()
    };
    let observed = violations(FORMATS[0].1, &elsewhere);
    assert!(
        observed[0].contains("is Free instead of Occupied"),
        "{observed:?}"
    );
    let (_, other) = crate::fixture::all().pop().unwrap();
    let observed = violations(FORMATS[0].1, &other);
    assert!(observed.len() >= 7, "{observed:?}");
}

#[test]
fn it_knows_no_other_ending() {
    let files = FilesInMemory::new([("yard.dwg", "")]);
    let error = load(&files, "yard.dwg", &MapSettings::default()).unwrap_err();
    let known = if cfg!(feature = "maps") {
        ".geojson .yaml .yml .osm .osm.xml .osm.pbf .pbf"
    } else {
        ".geojson .osm.pbf .pbf"
    };
    let expected = format!("yard.dwg: unknown map format; the known endings are {known}");
    assert_eq!(error.to_string(), expected);
}

#[cfg(not(feature = "maps"))]
#[test]
fn a_format_that_was_left_out_says_how_to_get_it() {
    let files = FilesInMemory::new([("yard.yaml", ""), ("yard.osm.gz", "")]);
    for name in ["yard.yaml", "yard.osm.gz"] {
        let error = load(&files, name, &MapSettings::default()).unwrap_err();
        assert!(error.to_string().contains("`--features maps`"), "{error}");
    }
}

/// Loads damaged files without panicking; an error must name a file.
fn read_damaged(fixture: &Yard, which: usize, bytes: Vec<u8>) -> Result<Map, MapError> {
    let mut files = fixture.files.clone();
    files[which].1 = bytes;
    let settings = MapSettings {
        max_cells: 1_000_000,
        max_bytes: 1 << 20,
        ..MapSettings::default()
    };
    let map = load(&FilesInMemory::new(files), fixture.files[0].0, &settings);
    if let Err(error) = &map {
        assert!(!error.file.is_empty(), "{error}");
    }
    map
}

#[test]
fn a_truncated_file_is_no_map() {
    for (format, fixture) in crate::fixture::all() {
        for which in 0..fixture.files.len() {
            let bytes = &fixture.files[which].1;
            let whole = bytes.trim_ascii_end().len();
            for length in 0..whole {
                let map = read_damaged(&fixture, which, bytes[..length].to_vec());
                // a cut YAML or PBF file may be valid, and then contains another map
                let cut_between = map.is_ok() && format != "ros" && format != "osm.pbf";
                assert!(!cut_between, "{format} cut at {length} of {whole}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn it_survives_damage(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..20),
        cut in any::<prop::sample::Index>(),
        insert in prop::collection::vec(any::<u8>(), 0..20),
        format in 0..FORMATS.len(),
    ) {
        let (_, fixture) = crate::fixture::all().swap_remove(format);
        for which in 0..fixture.files.len() {
            let mut bytes = fixture.files[which].1.clone();
            for (at, value) in &changes {
                let at = at.index(bytes.len());
                bytes[at] = *value;
            }
            let at = cut.index(bytes.len());
            bytes.splice(at..at, insert.iter().copied());
            let _ = read_damaged(&fixture, which, bytes);
        }
    }

    #[test]
    fn it_survives_noise(bytes in prop::collection::vec(any::<u8>(), 0..300), format in 0..FORMATS.len()) {
        let (_, fixture) = crate::fixture::all().swap_remove(format);
        for which in 0..fixture.files.len() {
            let _ = read_damaged(&fixture, which, bytes.clone());
        }
    }
}

/// The yard as written by libosmium 2.20, with a named bench, and a relation that is no area.
#[test]
fn it_reads_what_another_program_wrote() {
    let (_, fixture) = crate::fixture::all().pop().unwrap();
    let files = FilesInMemory::new(fixture.files.clone());
    let expected = load(&files, fixture.files[0].0, &MapSettings::default()).unwrap();
    for bytes in [
        &include_bytes!("data/yard-plain.osm.pbf")[..],
        &include_bytes!("data/yard-dense.osm.pbf")[..],
    ] {
        let files = FilesInMemory::new([("yard.osm.pbf", bytes)]);
        let map = load(&files, "yard.osm.pbf", &MapSettings::default()).unwrap();
        assert_eq!(map.grid.layout(), expected.grid.layout());
        assert_eq!(map.grid, expected.grid);
        let names: Vec<_> = map.points.iter().map(|it| it.name.as_str()).collect();
        assert_eq!(names, ["Tor Süd"]);
    }
}

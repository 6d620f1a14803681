//! The guarantees of map formats, tested for every row of `FORMATS`.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

mod fixture;

use asmotion_geometry::{Occupancy, Point};
use asmotion_map::{FORMATS, FilesInMemory, Map, MapError, MapFault, MapSettings, load};
use fixture::Fixture;
use proptest::prelude::*;

fn read(fixture: &Fixture, settings: &MapSettings) -> Result<Map, MapError> {
    load(
        &FilesInMemory::new(fixture.files.clone()),
        fixture.files[0].0,
        settings,
    )
}

fn check_content(map: &Map, fixture: &Fixture) {
    let at = |(x, y): (f64, f64)| map.grid.occupancy(Point::new(x, y));
    assert_eq!(
        at(fixture.occupied),
        Occupancy::Occupied,
        "{}",
        fixture.format
    );
    assert_eq!(at(fixture.free), Occupancy::Free, "{}", fixture.format);
}

#[test]
fn every_format_has_a_fixture() {
    let fixtures: Vec<_> = fixture::all()
        .iter()
        .map(|fixture| fixture.format)
        .collect();
    let formats: Vec<_> = FORMATS.iter().map(|(name, _)| *name).collect();
    assert_eq!(fixtures, formats);
}

#[test]
fn it_reads_the_yard() {
    for fixture in fixture::all() {
        let map = read(&fixture, &MapSettings::default()).unwrap();
        check_content(&map, &fixture);
        assert_eq!(
            map.grid,
            read(&fixture, &MapSettings::default()).unwrap().grid
        );
    }
}

#[test]
fn it_reads_packed_files() {
    for fixture in fixture::all() {
        let files = fixture::packed(&fixture);
        let name = files[0].0.clone();
        let map = load(&FilesInMemory::new(files), &name, &MapSettings::default()).unwrap();
        check_content(&map, &fixture);
    }
}

#[test]
fn it_draws_as_coarsely_as_it_is_told() {
    for fixture in fixture::all() {
        let fine = read(&fixture, &MapSettings::default()).unwrap();
        let settings = MapSettings {
            resolution: Some(1.0),
            ..MapSettings::default()
        };
        let coarse = read(&fixture, &settings).unwrap();
        check_content(&coarse, &fixture);
        assert!((coarse.grid.layout().resolution() - 1.0).abs() < 1e-9);
        assert!(coarse.grid.cells().len() < fine.grid.cells().len() / 3);
    }
}

#[test]
fn it_refuses_a_grid_that_is_too_large_and_says_what_would_fit() {
    for fixture in fixture::all() {
        let small = MapSettings {
            max_cells: 500,
            ..MapSettings::default()
        };
        let error = read(&fixture, &small).unwrap_err();
        assert!(error.to_string().contains("`resolution_m`"), "{error}");
        let MapFault::TooLarge { fits, .. } = error.fault else {
            panic!("{error}");
        };
        let fitting = MapSettings {
            resolution: Some(fits),
            ..small
        };
        assert!(
            read(&fixture, &fitting).is_ok(),
            "{} does not fit",
            fixture.format
        );
    }
}

#[test]
fn it_refuses_a_file_that_is_too_long() {
    for fixture in fixture::all() {
        let settings = MapSettings {
            max_bytes: 100,
            ..MapSettings::default()
        };
        let plain = read(&fixture, &settings).unwrap_err();
        assert_eq!(plain.fault, MapFault::TooManyBytes { limit: 100 });
        // decompressed it is too long, compressed it is not
        let files = fixture::packed(&fixture);
        let limit = files[0].1.len() as u64;
        if limit >= fixture.files[0].1.len() as u64 {
            continue;
        }
        let settings = MapSettings {
            max_bytes: limit,
            ..settings
        };
        let name = files[0].0.clone();
        let packed = load(&FilesInMemory::new(files), &name, &settings).unwrap_err();
        assert_eq!(packed.fault, MapFault::TooManyBytes { limit });
    }
}

#[test]
fn it_names_the_file_that_is_missing() {
    for fixture in fixture::all() {
        for missing in 0..fixture.files.len() {
            let mut files = fixture.files.clone();
            let (name, _) = files.remove(missing);
            let error = load(
                &FilesInMemory::new(files),
                fixture.files[0].0,
                &MapSettings::default(),
            );
            let error = error.unwrap_err();
            assert_eq!(
                (error.file.as_str(), &error.fault),
                (name, &MapFault::Missing)
            );
        }
    }
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
fn read_damaged(fixture: &Fixture, which: usize, bytes: Vec<u8>) -> Result<Map, MapError> {
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
fn it_survives_every_truncation() {
    for fixture in fixture::all() {
        for which in 0..fixture.files.len() {
            let bytes = &fixture.files[which].1;
            let whole = bytes.trim_ascii_end().len();
            for length in 0..whole {
                let map = read_damaged(&fixture, which, bytes[..length].to_vec());
                // a cut YAML or PBF file may be valid, and then contains another map
                let cut_between =
                    map.is_ok() && fixture.format != "ros" && fixture.format != "osm.pbf";
                assert!(
                    !cut_between,
                    "{} cut at {length} of {whole}",
                    fixture.format
                );
            }
        }
    }
}

#[test]
fn it_survives_every_changed_byte() {
    for fixture in fixture::all() {
        for which in 0..fixture.files.len() {
            let bytes = &fixture.files[which].1;
            for at in 0..bytes.len().min(1500) {
                for change in [0x00, 0x01, 0x30, 0x7f, 0x80, 0xff] {
                    let mut damaged = bytes.clone();
                    damaged[at] = change;
                    let _ = read_damaged(&fixture, which, damaged);
                }
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
        let fixture = fixture::all().swap_remove(format);
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
        let fixture = fixture::all().swap_remove(format);
        for which in 0..fixture.files.len() {
            let _ = read_damaged(&fixture, which, bytes.clone());
        }
    }
}

/// The yard as written by libosmium 2.20, with a named bench, and a relation that is no area.
#[test]
fn it_reads_what_another_program_wrote() {
    let fixture = fixture::all().pop().unwrap();
    let expected = read(&fixture, &MapSettings::default()).unwrap();
    for bytes in [
        &include_bytes!("data/yard-plain.osm.pbf")[..],
        &include_bytes!("data/yard-dense.osm.pbf")[..],
    ] {
        let files = FilesInMemory::new([("yard.osm.pbf", bytes)]);
        let map = load(&files, "yard.osm.pbf", &MapSettings::default()).unwrap();
        assert_eq!(map.grid.layout(), expected.grid.layout());
        check_content(&map, &fixture);
        let names: Vec<_> = map.points.iter().map(|it| it.name.as_str()).collect();
        assert_eq!(names, ["Tor Süd"]);
    }
}

//! Maps by the name of their place: which file it is, loaded once, the same revision for everybody.

use std::collections::BTreeMap;

use asmotion_geometry::message::occupancy_grid;
use asmotion_messages::OccupancyGrid;
use serde::Deserialize;

use crate::format::{FORMATS, Source, load, stem};
use crate::{Fault, Files, MapError, Settings, Where};

/// The name of the file that lists places.
const LIST: &str = "places.toml";

/// The frame of every map (REP-105).
const FRAME: &str = "map";

/// Which file each place has.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Places(BTreeMap<String, Entry>);

/// The map of a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Its file.
    pub file: String,
    /// Side of a cell, m; none leaves it to the settings.
    pub resolution: Option<f64>,
}

/// What `places.toml` says.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    places: BTreeMap<String, Listed>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Listed {
    File(String),
    More(More),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct More {
    file: String,
    resolution_m: Option<f64>,
}

impl Places {
    /// The places of a source: a list (`places.toml`), a folder (its own list, else every map in it, called as its
    /// file without the ending), or a single map.
    pub fn find(files: &dyn Files, source: &str, settings: &Settings) -> Result<Self, MapError> {
        if files.is_folder(source) {
            return Self::in_folder(files, source.trim_end_matches('/'), settings);
        }
        if source.ends_with(".toml") {
            return Self::listed(files, source, settings);
        }
        let name = source.rsplit('/').next().unwrap_or(source);
        let entry = Entry {
            file: source.to_owned(),
            resolution: None,
        };
        let place = named(name).unwrap_or(name);
        Ok(Self(BTreeMap::from([(place.to_owned(), entry)])))
    }

    fn in_folder(files: &dyn Files, folder: &str, settings: &Settings) -> Result<Self, MapError> {
        let source = Source::new(files, folder, settings);
        let names = files.list(folder).map_err(|fault| {
            let reason = fault.to_string();
            source.error(Fault::Unreadable { reason })
        })?;
        if names.iter().any(|name| name == LIST) {
            return Self::listed(files, &format!("{folder}/{LIST}"), settings);
        }
        let mut places = BTreeMap::new();
        for (_, format) in FORMATS {
            for name in &names {
                let mut stems = format
                    .endings()
                    .iter()
                    .filter_map(|ending| stem(name, ending));
                if let Some(place) = stems.next() {
                    let entry = Entry {
                        file: format!("{folder}/{name}"),
                        resolution: None,
                    };
                    places.entry(place.to_owned()).or_insert(entry);
                }
            }
        }
        Ok(Self(places))
    }

    fn listed(files: &dyn Files, name: &str, settings: &Settings) -> Result<Self, MapError> {
        let source = Source::new(files, name, settings);
        let text = source.text()?;
        let list: List = toml::from_str(&text).map_err(|error| {
            let at = error
                .span()
                .map_or(Where::File, |span| Where::in_text(&text, span.start));
            let what = error.message().to_owned();
            source.error_at(at, Fault::Syntax { what })
        })?;
        let entry = |listed| {
            let (file, resolution) = match listed {
                Listed::File(file) => (file, None),
                Listed::More(more) => (more.file, more.resolution_m),
            };
            Entry {
                file: source.beside(&file).name().to_owned(),
                resolution,
            }
        };
        let places = list.places.into_iter();
        Ok(Self(
            places
                .map(|(place, listed)| (place, entry(listed)))
                .collect(),
        ))
    }

    /// The place called `name`; without a name, the only one there is.
    pub fn get(&self, name: &str) -> Option<(&str, &Entry)> {
        let (place, entry) = match (name, self.0.len()) {
            ("", 1) => self.0.first_key_value()?,
            _ => self.0.get_key_value(name)?,
        };
        Some((place, entry))
    }

    /// Every name, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }
}

/// A map's name without its ending.
fn named(file: &str) -> Option<&str> {
    let endings = FORMATS.iter().flat_map(|(_, format)| format.endings());
    endings
        .filter_map(|ending| stem(file, ending))
        .min_by_key(|stem| stem.len())
}

/// The maps of some places, each loaded when first asked for and kept.
pub struct Library {
    files: Box<dyn Files>,
    places: Places,
    settings: Settings,
    maps: BTreeMap<String, Kept>,
    loads: u64,
}

struct Kept {
    grid: OccupancyGrid,
    /// Of the file, to see whether it changed.
    version: Option<u128>,
    notes: Vec<String>,
}

/// A map that was asked for.
pub struct Served<'a> {
    /// The name of its place.
    pub place: &'a str,
    /// The map; its `map_load_time` is its revision.
    pub grid: &'a OccupancyGrid,
    /// What was left out of it, for people.
    pub notes: &'a [String],
    /// Whether it was loaded just now.
    pub fresh: bool,
}

/// Why there is no map.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ServeError {
    /// No such place.
    #[error("no place is called `{place}`; known are {known}")]
    UnknownPlace {
        /// What was asked for.
        place: String,
        /// Every name.
        known: String,
    },
    /// Its map cannot be loaded.
    #[error(transparent)]
    Map(#[from] MapError),
}

impl ServeError {
    /// The fault code of the map service.
    pub fn code(&self) -> &'static str {
        match self {
            Self::UnknownPlace { .. } => "UNKNOWN_PLACE",
            Self::Map(_) => "BAD_MAP",
        }
    }
}

impl Library {
    /// The maps of a source, as [`Places::find`] understands it. Only names are read now.
    pub fn open(files: Box<dyn Files>, source: &str, settings: Settings) -> Result<Self, MapError> {
        Ok(Self {
            places: Places::find(files.as_ref(), source, &settings)?,
            files,
            settings,
            maps: BTreeMap::new(),
            loads: 0,
        })
    }

    /// The files, to open another library on them.
    pub fn into_files(self) -> Box<dyn Files> {
        self.files
    }

    /// The places.
    pub fn places(&self) -> &Places {
        &self.places
    }

    /// How many files were loaded so far.
    pub fn loads(&self) -> u64 {
        self.loads
    }

    /// The map of a place, loaded now (`nanos` nanoseconds after the clock's zero) if nobody asked before.
    pub fn get(&mut self, name: &str, nanos: i64) -> Result<Served<'_>, ServeError> {
        let Some((place, entry)) = self.places.get(name) else {
            return Err(ServeError::UnknownPlace {
                place: name.to_owned(),
                known: self.places.names().collect::<Vec<_>>().join(", "),
            });
        };
        let fresh = !self.maps.contains_key(place);
        if fresh {
            let kept = shelve(self.files.as_ref(), entry, &self.settings, nanos)?;
            self.loads += 1;
            self.maps.insert(place.to_owned(), kept);
        }
        match self.maps.get(place) {
            Some(kept) => Ok(kept.served(place, fresh)),
            None => Err(ServeError::UnknownPlace {
                place: place.to_owned(),
                known: String::new(),
            }),
        }
    }

    /// Loads again what changed since; a map that cannot be loaded any more stays as it was. Says, for each place
    /// whose file changed, what became of it.
    pub fn refresh(&mut self, nanos: i64) -> Vec<(String, Result<(), MapError>)> {
        let mut changed = Vec::new();
        for (place, kept) in &mut self.maps {
            let Some((_, entry)) = self.places.get(place) else {
                continue;
            };
            let version = self.files.version(&entry.file);
            if version == kept.version {
                continue;
            }
            let fresh = shelve(self.files.as_ref(), entry, &self.settings, nanos);
            changed.push((place.clone(), fresh.map(|fresh| *kept = fresh)));
            kept.version = version;
            self.loads += 1;
        }
        changed
    }
}

impl Kept {
    fn served<'a>(&'a self, place: &'a str, fresh: bool) -> Served<'a> {
        Served {
            place,
            grid: &self.grid,
            notes: &self.notes,
            fresh,
        }
    }
}

fn shelve(
    files: &dyn Files,
    entry: &Entry,
    settings: &Settings,
    nanos: i64,
) -> Result<Kept, MapError> {
    let version = files.version(&entry.file);
    let map = if entry.resolution.is_some() {
        let settings = Settings {
            resolution: entry.resolution,
            ..settings.clone()
        };
        load(files, &entry.file, &settings)?
    } else {
        load(files, &entry.file, settings)?
    };
    Ok(Kept {
        grid: occupancy_grid(&map.grid, nanos, FRAME),
        version,
        notes: map.notes,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Memory;

    const WALL: &str = r#"{"type":"FeatureCollection","map":{"units":"metres"},"features":[{"type":"Feature","properties":{"indoor":"wall"},"geometry":{"type":"LineString","coordinates":[[0,0],[4,3]]}}]}"#;

    fn library(source: &str, files: &[(&str, &str)]) -> Result<Library, MapError> {
        let files = Memory::new(files.iter().map(|(name, text)| (*name, *text)));
        Library::open(Box::new(files), source, Settings::default())
    }

    #[test]
    fn it_loads_a_place_once_and_gives_everybody_the_same_revision() {
        let mut library = library("maps", &[("maps/hall.geojson", WALL)]).unwrap();
        let first = library.get("hall", 1_000).unwrap();
        assert!(first.fresh);
        let revision = first.grid.info.map_load_time;
        let second = library.get("hall", 9_000_000_000).unwrap();
        assert!(!second.fresh);
        assert_eq!(second.grid.info.map_load_time, revision);
        assert_eq!(library.loads(), 1);
    }

    #[test]
    fn it_knows_the_maps_of_a_folder() {
        let files = [
            ("maps/hall.geojson", WALL),
            ("maps/hall.yaml", ""),
            ("maps/hall.png", ""),
            ("maps/town.osm.gz", ""),
            ("maps/README.md", ""),
        ];
        let library = library("maps/", &files).unwrap();
        assert_eq!(
            library.places().names().collect::<Vec<_>>(),
            ["hall", "town"]
        );
        assert_eq!(
            library.places().get("hall").unwrap().1.file,
            "maps/hall.geojson"
        );
        assert!(library.places().get("").is_none());
    }

    #[test]
    fn it_reads_a_list_of_places() {
        let list = "[places]\nlobby = \"plans/hall.geojson\"\n[places.coarse]\nfile = \"plans/hall.geojson\"\nresolution_m = 0.5\n";
        let files = [
            ("maps/places.toml", list),
            ("maps/plans/hall.geojson", WALL),
        ];
        let mut library = library("maps", &files).unwrap();
        let width =
            |library: &mut Library, place: &str| library.get(place, 0).unwrap().grid.info.width;
        assert_eq!(
            (width(&mut library, "lobby"), width(&mut library, "coarse")),
            (80, 8)
        );
    }

    #[test]
    fn a_single_map_needs_no_name() {
        let mut library = library("maps/hall.geojson", &[("maps/hall.geojson", WALL)]).unwrap();
        assert_eq!(library.get("", 0).unwrap().place, "hall");
        assert_eq!(library.get("hall", 0).unwrap().place, "hall");
        let error = library.get("moon", 0).err().unwrap();
        assert_eq!(error.code(), "UNKNOWN_PLACE");
        assert_eq!(
            error.to_string(),
            "no place is called `moon`; known are hall"
        );
    }

    #[test]
    fn it_says_what_is_wrong_with_a_list() {
        let error = library(
            "places.toml",
            &[("places.toml", "[places]\nx = { fil = 3 }\n")],
        );
        assert!(
            error
                .err()
                .unwrap()
                .to_string()
                .starts_with("places.toml:2:")
        );
    }

    #[test]
    fn it_loads_again_what_changed_on_disk() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("hall.geojson");
        std::fs::write(&file, WALL).unwrap();
        let source = folder.path().to_str().unwrap();
        let mut library =
            Library::open(Box::new(crate::Disk), source, Settings::default()).unwrap();
        library.get("hall", 1).unwrap();
        assert!(library.refresh(2).is_empty());
        std::fs::write(&file, WALL.replace("[4,3]", "[8,3.5]")).unwrap();
        let changed = library.refresh(3);
        assert!(matches!(&changed[..], [(place, Ok(()))] if place == "hall"));
        let served = library.get("hall", 4).unwrap();
        assert_eq!(
            (
                served.grid.info.width,
                served.grid.info.map_load_time.nanosec
            ),
            (160, 3)
        );
        std::fs::write(&file, "{").unwrap();
        assert!(matches!(&library.refresh(5)[..], [(_, Err(_))]));
        assert_eq!(library.get("hall", 6).unwrap().grid.info.width, 160);
        assert!(library.refresh(7).is_empty());
    }
}

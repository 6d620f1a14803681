//! Maps by the name of their place: which file it is, loaded once, the same revision for everybody.

use std::collections::{BTreeMap, btree_map};
use std::sync::Arc;

use asmotion_geometry::message::occupancy_grid;
use asmotion_messages::OccupancyGrid;
use serde::Deserialize;

use crate::error::{MapError, MapFault, Where};
use crate::files::FileSource;
use crate::format::{FORMATS, MapSettings, MapSource, load, stem};
use crate::map::Map;

/// The name of the file that lists places.
const LIST: &str = "places.toml";

/// The frame of every map (REP-105).
const FRAME: &str = "map";

/// Which file each place has.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Places(BTreeMap<String, PlaceEntry>);

/// The map of a place.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaceEntry {
    /// Its file.
    pub file: String,
    /// Side of a cell, m; none leaves it to the settings.
    pub resolution: Option<f64>,
}

/// Contents of `places.toml`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PlaceList {
    places: BTreeMap<String, PlaceValue>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum PlaceValue {
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
    ///
    /// # Errors
    /// The list or the folder cannot be read, or the list is malformed. A single map is not opened here.
    pub fn find(
        files: &dyn FileSource,
        source: &str,
        settings: &MapSettings,
    ) -> Result<Self, MapError> {
        if files.is_folder(source) {
            return Self::in_folder(files, source.trim_end_matches('/'), settings);
        }
        if source.ends_with(".toml") {
            return Self::listed(files, source, settings);
        }
        let name = source.rsplit('/').next().unwrap_or(source);
        let entry = PlaceEntry {
            file: source.to_owned(),
            resolution: None,
        };
        let place = named(name).unwrap_or(name);
        Ok(Self(BTreeMap::from([(place.to_owned(), entry)])))
    }

    fn in_folder(
        files: &dyn FileSource,
        folder: &str,
        settings: &MapSettings,
    ) -> Result<Self, MapError> {
        let source = MapSource::new(files, folder, settings);
        let names = files.list(folder).map_err(|fault| {
            let reason = fault.to_string();
            source.error(MapFault::Unreadable { reason })
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
                    let entry = PlaceEntry {
                        file: format!("{folder}/{name}"),
                        resolution: None,
                    };
                    places.entry(place.to_owned()).or_insert(entry);
                }
            }
        }
        Ok(Self(places))
    }

    fn listed(
        files: &dyn FileSource,
        name: &str,
        settings: &MapSettings,
    ) -> Result<Self, MapError> {
        let source = MapSource::new(files, name, settings);
        let text = source.text()?;
        let list: PlaceList = toml::from_str(&text).map_err(|error| {
            let at = error
                .span()
                .map_or(Where::File, |span| Where::in_text(&text, span.start));
            let what = error.message().to_owned();
            source.error_at(at, MapFault::Syntax { what })
        })?;
        let entry = |listed| {
            let (file, resolution) = match listed {
                PlaceValue::File(file) => (file, None),
                PlaceValue::More(more) => (more.file, more.resolution_m),
            };
            PlaceEntry {
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
    pub fn get(&self, name: &str) -> Option<(&str, &PlaceEntry)> {
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

/// The maps of some places, each loaded when first requested and kept.
///
/// Looking up and keeping maps takes no time; reading and parsing files is in [`Load::run`] and [`Refresh::run`], which
/// need no library and may run elsewhere.
pub struct MapLibrary {
    files: Arc<dyn FileSource>,
    places: Places,
    settings: MapSettings,
    maps: BTreeMap<String, LoadedMap>,
    loads: u64,
}

struct LoadedMap {
    place: String,
    grid: OccupancyGrid,
    /// Version of the file the grid was made of.
    version: Option<u128>,
    notes: Vec<String>,
}

/// A map of the library.
pub struct ServedMap<'a> {
    /// The name of its place.
    pub place: &'a str,
    /// The map; its `map_load_time` is its revision.
    pub grid: &'a OccupancyGrid,
    /// Features that were left out, for people.
    pub notes: &'a [String],
}

/// Result of looking up a name.
pub enum Lookup<'a> {
    /// The map of the place.
    Kept(ServedMap<'a>),
    /// The work that makes it.
    Missing(Load),
}

/// The loading of one place: slow, and independent of the library.
pub struct Load {
    /// The name of the place.
    pub place: String,
    files: Arc<dyn FileSource>,
    entry: PlaceEntry,
    settings: MapSettings,
}

/// The outcome of a [`Load`].
pub struct LoadedPlace {
    /// The name of the place.
    pub place: String,
    /// Version of the file before it was read.
    version: Option<u128>,
    result: Result<Map, MapError>,
}

/// The search for files that have changed since they were loaded: slow, and independent of the library.
pub struct Refresh {
    /// Each place with the version of its file at the time of loading.
    kept: Vec<(Load, Option<u128>)>,
}

/// Reason why a map cannot be served.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ServeError {
    /// No such place.
    #[error("no place is called `{place}`; known are {known}")]
    UnknownPlace {
        /// The name in the request.
        place: String,
        /// Every name, separated by commas.
        known: String,
    },
    /// The map of the place cannot be loaded.
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

impl MapLibrary {
    /// The maps of a source, as [`Places::find`] understands it. Only names are read now.
    ///
    /// # Errors
    /// If the source is a folder or a list that cannot be read.
    pub fn open(
        files: Arc<dyn FileSource>,
        source: &str,
        settings: MapSettings,
    ) -> Result<Self, MapError> {
        Ok(Self {
            places: Places::find(files.as_ref(), source, &settings)?,
            files,
            settings,
            maps: BTreeMap::new(),
            loads: 0,
        })
    }

    /// The places.
    pub fn places(&self) -> &Places {
        &self.places
    }

    /// Files loaded so far, those included that could not be parsed.
    pub fn loads(&self) -> u64 {
        self.loads
    }

    /// The map of a place, or the work that loads it.
    ///
    /// # Errors
    /// If there is no such place.
    pub fn find(&self, name: &str) -> Result<Lookup<'_>, ServeError> {
        let Some((place, entry)) = self.places.get(name) else {
            return Err(ServeError::UnknownPlace {
                place: name.to_owned(),
                known: self.places.names().collect::<Vec<_>>().join(", "),
            });
        };
        Ok(match self.maps.get(place) {
            Some(kept) => Lookup::Kept(kept.served()),
            None => Lookup::Missing(self.load(place, entry)),
        })
    }

    fn load(&self, place: &str, entry: &PlaceEntry) -> Load {
        Load {
            place: place.to_owned(),
            files: Arc::clone(&self.files),
            entry: entry.clone(),
            settings: MapSettings {
                resolution: entry.resolution.or(self.settings.resolution),
                ..self.settings.clone()
            },
        }
    }

    /// Keeps a map that was loaded, `nanos` nanoseconds after the clock's zero. Where it could not be loaded, the map
    /// that was kept before, if any, stays.
    ///
    /// # Errors
    /// The error of the loading.
    pub fn keep(&mut self, loaded: LoadedPlace, nanos: i64) -> Result<ServedMap<'_>, MapError> {
        let LoadedPlace {
            place,
            version,
            result,
        } = loaded;
        self.loads += 1;
        let map = match result {
            Ok(map) => map,
            Err(error) => {
                // not tried again until the file changes once more
                if let Some(kept) = self.maps.get_mut(&place) {
                    kept.version = version;
                }
                return Err(error);
            }
        };
        let kept = LoadedMap {
            place: place.clone(),
            grid: occupancy_grid(&map.grid, nanos, FRAME),
            version,
            notes: map.notes,
        };
        Ok(match self.maps.entry(place) {
            btree_map::Entry::Vacant(vacant) => vacant.insert(kept),
            btree_map::Entry::Occupied(mut occupied) => {
                occupied.insert(kept);
                occupied.into_mut()
            }
        }
        .served())
    }

    /// The work that looks for changed files, and loads them again.
    pub fn refresh(&self) -> Refresh {
        let kept = self.maps.iter().filter_map(|(place, kept)| {
            let (_, entry) = self.places.get(place)?;
            Some((self.load(place, entry), kept.version))
        });
        Refresh {
            kept: kept.collect(),
        }
    }
}

impl Load {
    /// Reads and parses the file.
    pub fn run(self) -> LoadedPlace {
        let version = self.files.version(&self.entry.file);
        LoadedPlace {
            result: load(self.files.as_ref(), &self.entry.file, &self.settings),
            place: self.place,
            version,
        }
    }
}

impl Refresh {
    /// Loads the files that have changed, in the order of their places.
    pub fn run(self) -> Vec<LoadedPlace> {
        let changed = self
            .kept
            .into_iter()
            .filter(|(load, version)| load.files.version(&load.entry.file) != *version);
        changed.map(|(load, _)| load.run()).collect()
    }
}

impl LoadedMap {
    fn served(&self) -> ServedMap<'_> {
        ServedMap {
            place: &self.place,
            grid: &self.grid,
            notes: &self.notes,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::FilesInMemory;

    const WALL: &str = r#"{"type":"FeatureCollection","map":{"units":"metres"},"features":[{"type":"Feature","properties":{"indoor":"wall"},"geometry":{"type":"LineString","coordinates":[[0,0],[4,3]]}}]}"#;

    fn library(source: &str, files: &[(&str, &str)]) -> Result<MapLibrary, MapError> {
        let files = FilesInMemory::new(files.iter().map(|(name, text)| (*name, *text)));
        MapLibrary::open(Arc::new(files), source, MapSettings::default())
    }

    /// The map of a place, loaded here if need be, and whether it was.
    fn get<'a>(library: &'a mut MapLibrary, name: &str, nanos: i64) -> (&'a OccupancyGrid, bool) {
        let load = match library.find(name).unwrap() {
            Lookup::Kept(_) => None,
            Lookup::Missing(load) => Some(load),
        };
        let fresh = load.is_some();
        if let Some(load) = load {
            library.keep(load.run(), nanos).unwrap();
        }
        match library.find(name).unwrap() {
            Lookup::Kept(served) => (served.grid, fresh),
            Lookup::Missing(_) => panic!("{name} was not kept"),
        }
    }

    /// Loads again what has changed; the places, and whether each could be loaded.
    fn refresh(library: &mut MapLibrary, nanos: i64) -> Vec<(String, bool)> {
        let changed = library.refresh().run().into_iter();
        changed
            .map(|loaded| (loaded.place.clone(), library.keep(loaded, nanos).is_ok()))
            .collect()
    }

    #[test]
    fn it_loads_a_place_once_and_gives_everybody_the_same_revision() {
        let mut library = library("maps", &[("maps/hall.geojson", WALL)]).unwrap();
        let (first, loaded) = get(&mut library, "hall", 1_000);
        assert!(loaded);
        let revision = first.info.map_load_time;
        let (second, loaded) = get(&mut library, "hall", 9_000_000_000);
        assert!(!loaded);
        assert_eq!(second.info.map_load_time, revision);
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
        let width = |library: &mut MapLibrary, place: &str| get(library, place, 0).0.info.width;
        assert_eq!(
            (width(&mut library, "lobby"), width(&mut library, "coarse")),
            (80, 8)
        );
    }

    #[test]
    fn a_single_map_needs_no_name() {
        let mut library = library("maps/hall.geojson", &[("maps/hall.geojson", WALL)]).unwrap();
        let unnamed = get(&mut library, "", 0).0.clone();
        assert_eq!(get(&mut library, "hall", 1), (&unnamed, false));
        let error = library.find("moon").err().unwrap();
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
        let mut library = MapLibrary::open(
            Arc::new(crate::files::DiskFiles),
            source,
            MapSettings::default(),
        )
        .unwrap();
        get(&mut library, "hall", 1);
        assert_eq!(refresh(&mut library, 2), []);
        std::fs::write(&file, WALL.replace("[4,3]", "[8,3.5]")).unwrap();
        assert_eq!(refresh(&mut library, 3), [("hall".to_owned(), true)]);
        let info = &get(&mut library, "hall", 4).0.info;
        assert_eq!((info.width, info.map_load_time.nanosec), (160, 3));
        std::fs::write(&file, "{").unwrap();
        assert_eq!(refresh(&mut library, 5), [("hall".to_owned(), false)]);
        assert_eq!(get(&mut library, "hall", 6).0.info.width, 160);
        assert_eq!(refresh(&mut library, 7), []);
    }
}

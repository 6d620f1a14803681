//! Maps by the names of their places; each is loaded once, and all clients get the same revision.

use std::collections::{BTreeMap, btree_map};
use std::sync::Arc;

use asmotion_geometry::message::occupancy_grid;
use asmotion_messages::OccupancyGrid;
use serde::{Deserialize, Serialize};

use crate::error::{MapError, MapFault, Where};
use crate::files::{FileFault, FileSource};
use crate::format::{MapSettings, MapSource};
use crate::formats::{MapFormats, stem};
use crate::map::Map;

/// The name of the file that lists places.
const LIST: &str = "places.toml";

/// The map file of each place.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Places(BTreeMap<String, PlaceEntry>);

/// The map of a place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlaceEntry {
    /// Name of the map file.
    pub file: String,
    /// Side length of a cell, m; `None` uses the settings.
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
    /// Finds the places of a source: a list (`places.toml`), a folder (with its own list, or else every map in it under
    /// its name without the ending), or a single map.
    ///
    /// # Errors
    /// The list or the folder cannot be read, or the list is malformed. A single map is not opened here.
    pub fn find(
        files: &dyn FileSource,
        source: &str,
        formats: &MapFormats,
        settings: &MapSettings,
    ) -> Result<Self, MapError> {
        if files.is_folder(source) {
            return Self::in_folder(files, source.trim_end_matches('/'), formats, settings);
        }
        if source.ends_with(".toml") {
            return Self::listed(files, source, settings);
        }
        if files.version(source).is_none() {
            let reason = FileFault::Missing.to_string();
            return Err(
                MapSource::new(files, source, settings).error(MapFault::Unreadable { reason })
            );
        }
        let name = source.rsplit('/').next().unwrap_or(source);
        let entry = PlaceEntry {
            file: source.to_owned(),
            resolution: None,
        };
        let place = named(name, formats).unwrap_or(name);
        Ok(Self(BTreeMap::from([(place.to_owned(), entry)])))
    }

    fn in_folder(
        files: &dyn FileSource,
        folder: &str,
        formats: &MapFormats,
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
        for format in formats.iter() {
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

    /// The place with this name; for an empty name, the only place.
    pub fn get(&self, name: &str) -> Option<(&str, &PlaceEntry)> {
        let (place, entry) = match (name, self.0.len()) {
            ("", 1) => self.0.first_key_value()?,
            _ => self.0.get_key_value(name)?,
        };
        Some((place, entry))
    }

    /// All names, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }
}

/// The name of a map file without its ending.
fn named<'n>(file: &'n str, formats: &MapFormats) -> Option<&'n str> {
    formats
        .endings()
        .filter_map(|ending| stem(file, ending))
        .min_by_key(|stem| stem.len())
}

/// The maps of places, each loaded at its first request and then kept.
///
/// Looking up and storing maps is fast. Reading and parsing files happens in [`Load::run`] and [`Refresh::run`], which
/// do not need the library and can run on another thread.
pub struct MapLibrary {
    files: Arc<dyn FileSource>,
    formats: MapFormats,
    places: Places,
    settings: MapSettings,
    maps: BTreeMap<String, LoadedMap>,
    loads: u64,
}

/// Frozen content of a library: places and maps found and loaded so far. The rest is derived from the properties of the
/// server.
#[derive(Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LibraryContents {
    places: Places,
    maps: BTreeMap<String, LoadedMap>,
    loads: u64,
}

#[derive(Clone, Serialize, Deserialize)]
struct LoadedMap {
    place: String,
    grid: OccupancyGrid,
    /// Version of the file from which the grid was made.
    #[serde(with = "version_text")]
    version: Option<u128>,
    notes: Vec<String>,
}

/// Versions of files as text: they have 128 bits, and integers of frozen states 64.
mod version_text {
    use serde::de::{Deserialize, Deserializer, Error};
    use serde::ser::{Serialize, Serializer};

    pub fn serialize<S: Serializer>(version: &Option<u128>, to: S) -> Result<S::Ok, S::Error> {
        version.map(|version| version.to_string()).serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<u128>, D::Error> {
        let text = Option::<String>::deserialize(from)?;
        let version = text.map(|text| text.parse().map_err(D::Error::custom));
        version.transpose()
    }
}

/// A map of the library.
pub struct ServedMap<'a> {
    /// Name of the place.
    pub place: &'a str,
    /// The map; its `map_load_time` is its revision.
    pub grid: &'a OccupancyGrid,
    /// Notes for the user about features that were left out.
    pub notes: &'a [String],
}

/// The result of looking up a place.
pub enum Lookup<'a> {
    /// The map, which was loaded before.
    Kept(ServedMap<'a>),
    /// The work that loads the map.
    Missing(Load),
}

/// Loads the map of one place; slow, and independent of the library.
pub struct Load {
    /// Name of the place.
    pub place: String,
    files: Arc<dyn FileSource>,
    formats: MapFormats,
    entry: PlaceEntry,
    settings: MapSettings,
}

/// The result of a [`Load`].
pub struct LoadedPlace {
    /// Name of the place.
    pub place: String,
    /// Version of the file before it was read, so that a change in between is noticed.
    version: Option<u128>,
    result: Result<Map, MapError>,
}

/// Checks for files that have changed since they were loaded; slow, and independent of the library.
pub struct Refresh {
    /// Each place with the version of its file when it was loaded.
    kept: Vec<(Load, Option<u128>)>,
}

/// The reason that a map cannot be provided.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ServeError {
    /// A name that no place has.
    #[error("unknown place `{place}`; known are {known}")]
    UnknownPlace {
        /// The name in the request.
        place: String,
        /// All known names, separated by commas.
        known: String,
    },
    /// The map of the place cannot be loaded.
    #[error(transparent)]
    Map(#[from] MapError),
}

impl ServeError {
    /// The fault code in the map service.
    pub fn code(&self) -> &'static str {
        match self {
            Self::UnknownPlace { .. } => "UNKNOWN_PLACE",
            Self::Map(_) => "BAD_MAP",
        }
    }
}

impl MapLibrary {
    /// Opens a source as described at [`Places::find`]. No map is loaded yet.
    ///
    /// # Errors
    /// An error if a folder or a list cannot be read.
    pub fn open(
        files: Arc<dyn FileSource>,
        source: &str,
        formats: MapFormats,
        settings: MapSettings,
    ) -> Result<Self, MapError> {
        Ok(Self {
            places: Places::find(files.as_ref(), source, &formats, &settings)?,
            files,
            formats,
            settings,
            maps: BTreeMap::new(),
            loads: 0,
        })
    }

    /// Returns the places and maps found and loaded so far.
    pub(crate) fn contents(&self) -> LibraryContents {
        LibraryContents {
            places: self.places.clone(),
            maps: self.maps.clone(),
            loads: self.loads,
        }
    }

    /// Creates a library with previously loaded content, without reading any file.
    pub(crate) fn with_contents(
        files: Arc<dyn FileSource>,
        formats: MapFormats,
        settings: MapSettings,
        contents: LibraryContents,
    ) -> Self {
        let LibraryContents {
            places,
            maps,
            loads,
        } = contents;
        Self {
            files,
            formats,
            places,
            settings,
            maps,
            loads,
        }
    }

    /// All places.
    pub fn places(&self) -> &Places {
        &self.places
    }

    /// Number of files loaded so far, including those that could not be parsed.
    pub fn loads(&self) -> u64 {
        self.loads
    }

    /// Looks up the map of a place. Returns the work that loads it if it has not been loaded yet.
    ///
    /// # Errors
    /// [`ServeError::UnknownPlace`] if there is no such place.
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
            formats: self.formats.clone(),
            entry: entry.clone(),
            settings: MapSettings {
                resolution: entry.resolution.or(self.settings.resolution),
                ..self.settings.clone()
            },
        }
    }

    /// Stores a loaded map. `nanos`, the time in nanoseconds since the clock's zero, becomes its revision. If loading
    /// failed, the previous map of the place is kept.
    ///
    /// # Errors
    /// The error that occurred in loading.
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
            grid: occupancy_grid(&map.grid, nanos, &self.settings.frame),
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

    /// The work that finds changed files and loads them again.
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
            result: self
                .formats
                .load(self.files.as_ref(), &self.entry.file, &self.settings),
            place: self.place,
            version,
        }
    }
}

impl Refresh {
    /// Loads the changed files, in the order of their places.
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
        MapLibrary::open(
            Arc::new(files),
            source,
            MapFormats::standard(),
            MapSettings::default(),
        )
    }

    /// The map of a place, and whether it was loaded by this call.
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

    /// Loads changed maps again. Returns their places, and whether each could be loaded.
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
    #[cfg(feature = "maps")]
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
        assert_eq!(error.to_string(), "unknown place `moon`; known are hall");
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
            MapFormats::standard(),
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

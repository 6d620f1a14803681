//! The component: provides maps by the names of their places.
//!
//! A map takes milliseconds to seconds to load, and a cycle neither blocks nor waits: files are read and parsed by
//! background work ([`Cycle::spawn`]), one for each place, and the waiting requests get their replies in the cycle that
//! finds the work done. Only `configure`, which may block, reads a folder or a list itself. In simulated time the work
//! is done at once, so the reply is sent in the cycle of the request.

use std::sync::Arc;

use asmotion_component::frozen::{
    Datum, DatumError, FieldName, StateField, entry, field, refuse_unknown,
};
use asmotion_component::{
    BackgroundWork, Component, Cycle, Fault, Freeze, FreezeProblem, Interface, Out, Ports,
    Properties, PropertySet, Provided, RequestId, ServiceFault, Setup, freeze_by_fields,
};
use asmotion_geometry::GridLayout;
use asmotion_messages::{GetMap, OccupancyGrid};
use serde::de::Error;

use crate::files::{DiskFiles, FileSource};
use crate::format::MapSettings;
use crate::formats::MapFormats;
use crate::library::{
    LibraryContents, Load, LoadedPlace, Lookup, MapLibrary, ServeError, ServedMap,
};
use crate::rules::Rules;

/// `nav::MapServer`: provides `getMap`, loads each place once, and publishes maps when they have been loaded or have
/// changed.
pub struct MapServer {
    ports: MapServerPorts,
    /// Read when configured.
    properties: PropertySet<MapServerProperties>,

    files: Arc<dyn FileSource>,
    formats: MapFormats,
    /// `None` until configured.
    library: Option<MapLibrary>,
    /// Places whose maps were loaded while the server was stopped and have not been published.
    unpublished: Vec<String>,
    /// `true` until the place to publish at the start has been looked up.
    is_first: bool,
    /// Places being loaded.
    loading: Vec<MapLoading>,
    /// The search for changed files in progress, if any.
    refreshing: Option<BackgroundWork<Vec<LoadedPlace>>>,
}

/// A place whose map is being loaded.
struct MapLoading {
    place: String,
    work: BackgroundWork<LoadedPlace>,
    /// Requests that wait for the map.
    requests: Vec<RequestId>,
    /// `true` for the place to publish at the start, without which the server fails.
    is_first: bool,
}

#[derive(Ports)]
struct MapServerPorts {
    /// `getMap`: the map of a place, map frame; without a name, of `place`, or of the only place there is. Faults
    /// `UNKNOWN_PLACE`, `BAD_MAP`.
    maps: Provided<GetMap>,
    /// Every map when it is loaded or reloaded; map frame, `map_load_time` is the revision.
    map: Out<OccupancyGrid>,
}

#[derive(Properties)]
struct MapServerProperties {
    /// Map file, folder of maps (each place is named after its file), or `places.toml`. Read when configured, as are
    /// all properties here.
    source: String,
    /// Place whose map is loaded and published at the start, and the one meant by a request without a name.
    place: String,
    /// Side of a cell; 0 for that of the file (ROS maps can only become coarser).
    #[property(unit = "m", range = 0.0..=100.0)]
    resolution_m: f64,
    /// Largest number of cells of a grid; a cell takes a byte.
    #[property(range = 1..=GridLayout::MAX_CELLS, default = MapSettings::default().max_cells)]
    max_cells: u64,
    /// Largest size of a file, uncompressed.
    #[property(unit = "B", range = 1..=1 << 36, default = MapSettings::default().max_bytes)]
    max_bytes: u64,
    /// Rules for map elements, applied before the built-in ones: `key=value|value occupied|free|ignore width=…; …`.
    rules: String,
    /// Frame of all maps (REP 105). A planner refuses a start or goal in another frame.
    #[property(default = MapSettings::default().frame)]
    frame: String,
    /// Whether each cycle checks for changed files and loads them again.
    watch: bool,
}

impl MapServerProperties {
    fn settings(&self) -> Result<MapSettings, Fault> {
        Ok(MapSettings {
            resolution: (self.resolution_m > 0.0).then_some(self.resolution_m),
            max_cells: self.max_cells,
            max_bytes: self.max_bytes,
            ground: None,
            rules: Rules::parse(&self.rules)?.followed_by(Rules::default()),
            frame: self.frame.clone(),
        })
    }
}

impl MapServer {
    /// Declares ports and properties; reads maps from disk.
    pub fn new(interface: &mut Interface) -> Self {
        Self::with_files(interface, DiskFiles)
    }

    /// Declares ports and properties; reads maps from another source.
    pub fn with_files(interface: &mut Interface, files: impl FileSource + 'static) -> Self {
        let ports: MapServerPorts = interface.ports();
        interface.while_stopped(ports.maps);
        Self {
            ports,
            properties: interface.properties(),
            files: Arc::new(files),
            formats: MapFormats::standard(),
            library: None,
            unpublished: Vec::new(),
            is_first: false,
            loading: Vec::new(),
            refreshing: None,
        }
    }

    /// Reads these formats instead of the standard ones.
    pub fn formats(self, formats: MapFormats) -> Self {
        Self { formats, ..self }
    }

    /// Replies to a request, at once or when the map has been loaded.
    fn reply_to(&mut self, cycle: &mut Cycle<'_>, request: RequestId, name: &str) {
        let place = match name {
            "" => &self.properties.place,
            name => name,
        };
        match self.library.as_ref().map(|library| library.find(place)) {
            Some(Ok(Lookup::Kept(served))) => {
                cycle.reply(self.ports.maps, request, Ok(served.grid.clone()));
            }
            Some(Ok(Lookup::Missing(load))) => self.load(cycle, load).requests.push(request),
            Some(Err(error)) => cycle.reply(self.ports.maps, request, Err(fault(&error))),
            None => {
                let fault = ServiceFault::new("BAD_MAP", "not configured");
                cycle.reply(self.ports.maps, request, Err(fault));
            }
        }
    }

    /// Starts to load a place, unless it is being loaded.
    fn load(&mut self, cycle: &mut Cycle<'_>, load: Load) -> &mut MapLoading {
        let known = self.loading.iter().position(|it| it.place == load.place);
        let index = known.unwrap_or(self.loading.len());
        if known.is_none() {
            self.loading.push(MapLoading {
                place: load.place.clone(),
                work: cycle.spawn(|| load.run()),
                requests: Vec::new(),
                is_first: false,
            });
        }
        &mut self.loading[index]
    }

    /// Starts to load the place to publish at the start.
    fn load_first(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let place = &self.properties.place;
        let found = self.library.as_ref().map(|library| library.find(place));
        match found
            .transpose()
            .map_err(|error| Fault::new(fault(&error)))?
        {
            Some(Lookup::Missing(load)) => self.load(cycle, load).is_first = true,
            Some(Lookup::Kept(_)) | None => {}
        }
        Ok(())
    }

    /// Publishes the maps that have been loaded, and replies to the requests that wait for them.
    fn finish(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let mut index = 0;
        while let Some(loading) = self.loading.get_mut(index) {
            let Some(loaded) = loading.work.take() else {
                index += 1;
                continue;
            };
            let MapLoading {
                requests, is_first, ..
            } = self.loading.remove(index);
            let answer = self.store(cycle, loaded?);
            if let (true, Err(error)) = (is_first, &answer) {
                return Err(Fault::new(error));
            }
            for request in requests {
                cycle.reply(self.ports.maps, request, answer.clone());
            }
        }
        Ok(())
    }

    /// Stores a map and publishes it.
    fn store(
        &mut self,
        cycle: &mut Cycle<'_>,
        loaded: LoadedPlace,
    ) -> Result<OccupancyGrid, ServiceFault> {
        let not_configured = || ServiceFault::new("BAD_MAP", "not configured");
        let library = self.library.as_mut().ok_or_else(not_configured)?;
        let served = library.keep(loaded, cycle.now().nanos());
        let served = served.map_err(|error| fault(&error.into()))?;
        cycle.report("map", summary(&served).into());
        if cycle.is_running() {
            cycle.write(self.ports.map, served.grid.clone());
        } else {
            self.unpublished.push(served.place.to_owned());
        }
        Ok(served.grid.clone())
    }

    /// Publishes the maps that were loaded while the server was stopped.
    fn publish_waiting(&mut self, cycle: &mut Cycle<'_>) {
        for place in std::mem::take(&mut self.unpublished) {
            let library = self.library.as_ref();
            if let Some(Ok(Lookup::Kept(served))) = library.map(|library| library.find(&place)) {
                cycle.write(self.ports.map, served.grid.clone());
            }
        }
    }

    /// Replies to the waiting requests, at once or when their maps have been loaded.
    fn answer(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let cancelled = cycle.cancelled(self.ports.maps);
        for loading in &mut self.loading {
            loading
                .requests
                .retain(|request| !cancelled.contains(request));
        }
        self.finish(cycle)?;
        for request in cycle.requests(self.ports.maps) {
            self.reply_to(cycle, request.id, &request.argument.name);
            self.finish(cycle)?;
        }
        Ok(())
    }

    /// Watches for changed files: a cycle starts the search, and the first cycle that finds it done publishes the
    /// changed maps. A cycle triggered by the end of a search does not start the next one.
    fn watch(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let Some(library) = &self.library else {
            return Ok(());
        };
        let mut refreshing = match self.refreshing.take() {
            Some(refreshing) => refreshing,
            None => {
                let refresh = library.refresh();
                cycle.spawn(|| refresh.run())
            }
        };
        let Some(changed) = refreshing.take() else {
            self.refreshing = Some(refreshing);
            return Ok(());
        };
        for loaded in changed? {
            let place = loaded.place.clone();
            if let Err(error) = self.store(cycle, loaded) {
                let what = format!("{place} stays as it was: {}", error.detail);
                cycle.report("map", what.into());
            }
        }
        Ok(())
    }
}

fn fault(error: &ServeError) -> ServiceFault {
    ServiceFault::new(error.code(), error.to_string())
}

/// Place, size and notes of a map, for the log.
fn summary(served: &ServedMap<'_>) -> String {
    let info = &served.grid.info;
    let size = format!(
        "{} × {} cells of {} m",
        info.width, info.height, info.resolution
    );
    let notes = served.notes.iter().map(|note| format!("; {note}"));
    format!("{}: {size}{}", served.place, notes.collect::<String>())
}

/// The maps themselves are part of the state, since their files may change after freezing.
impl Freeze for MapServer {
    const COMPONENT: &'static str = "nav::MapServer";
    const VERSION: u32 = 2;

    fn fields(&self) -> Result<Vec<(FieldName, Datum)>, FreezeProblem> {
        if let Some(loading) = self.loading.first() {
            let what = format!("it loads the map of `{}`", loading.place);
            return Err(FreezeProblem::Busy(what));
        }
        if self.refreshing.is_some() {
            return Err(FreezeProblem::Busy(
                "it checks for changed files".to_owned(),
            ));
        }
        let contents = self.library.as_ref().map(MapLibrary::contents);
        Ok(vec![
            entry("properties", &self.properties)?,
            entry("library", &contents)?,
            entry("unpublished", &self.unpublished)?,
            entry("is_first", &self.is_first)?,
        ])
    }

    fn set_fields(&mut self, fields: &[(FieldName, Datum)]) -> Result<(), DatumError> {
        refuse_unknown(
            fields,
            &["properties", "library", "unpublished", "is_first"],
        )?;
        let properties = field::<PropertySet<MapServerProperties>>(fields, "properties")?;
        let contents = field::<Option<LibraryContents>>(fields, "library")?;
        let unpublished = field::<Vec<String>>(fields, "unpublished")?;
        let is_first = field::<bool>(fields, "is_first")?;
        let library = contents.map(|contents| {
            let settings = properties.settings().map_err(DatumError::custom)?;
            let files = Arc::clone(&self.files);
            Ok::<_, DatumError>(MapLibrary::with_contents(
                files,
                self.formats.clone(),
                settings,
                contents,
            ))
        });
        self.library = library.transpose()?;
        self.properties.set(properties);
        self.unpublished = unpublished;
        self.is_first = is_first;
        self.loading.clear();
        self.refreshing = None;
        Ok(())
    }
}

impl Component for MapServer {
    freeze_by_fields!();

    fn configure(&mut self, setup: &mut Setup<'_>) -> Result<(), Fault> {
        let properties = self.properties.refresh(setup);
        let source = &properties.source;
        let source = source.strip_prefix("file:").unwrap_or(source);
        if source.is_empty() {
            return Err(Fault::new(
                "`source` is not a map, a folder of maps or a `places.toml`",
            ));
        }
        let files = Arc::clone(&self.files);
        self.library = Some(MapLibrary::open(
            files,
            source,
            self.formats.clone(),
            properties.settings()?,
        )?);
        self.is_first = !properties.place.is_empty();
        self.unpublished.clear();
        self.loading.clear();
        self.refreshing = None;
        Ok(())
    }

    /// Forgets waiting requests; the runtime ends their calls as stopped.
    fn stop(&mut self, _: &mut Cycle<'_>) {
        for loading in &mut self.loading {
            loading.requests.clear();
        }
    }

    fn serve(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.answer(cycle)
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.publish_waiting(cycle);
        if std::mem::take(&mut self.is_first) {
            self.load_first(cycle)?;
        }
        self.answer(cycle)?;
        if self.properties.watch {
            self.watch(cycle)?;
        }
        Ok(())
    }
}

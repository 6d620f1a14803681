//! The component: maps by name for everybody who asks.

use asmotion_component::{
    Component, Cycle, Fault, Interface, Out, Property, Provided, ServiceFault, Setup,
};
use asmotion_messages::{GetMap, OccupancyGrid, Place};

use crate::library::Served;
use crate::{Disk, Files, Library, Rules, Settings};

/// `nav::MapServer`: serves `getMap`, each place loaded once; publishes a map when it was loaded and when it changed.
///
/// Reading a map takes milliseconds to seconds and happens in the server's own cycle, so it wants an activity of its
/// own; callers never wait for it, their reply comes later.
pub struct MapServer {
    maps: Provided<GetMap>,
    map: Out<OccupancyGrid>,
    properties: Properties,

    files: Option<Box<dyn Files>>,
    library: Option<Library>,
    /// The place to load without being asked; none once it is.
    first: Option<String>,
    /// What a request without a name means.
    usual: String,
    watch: bool,
}

struct Properties {
    source: Property<String>,
    place: Property<String>,
    resolution: Property<f64>,
    max_cells: Property<u64>,
    max_bytes: Property<u64>,
    rules: Property<String>,
    watch: Property<bool>,
}

impl MapServer {
    /// Declares ports and properties; serves maps from disk.
    pub fn new(interface: &mut Interface) -> Self {
        Self::with_files(interface, Box::new(Disk))
    }

    /// Declares ports and properties; serves maps from other files.
    pub fn with_files(interface: &mut Interface, files: Box<dyn Files>) -> Self {
        Self {
            maps: interface.serve("maps", "the map of a place; faults UNKNOWN_PLACE, BAD_MAP"),
            map: interface.output(
                "map",
                "a map that was just loaded, or loaded again, map frame",
            ),
            properties: Properties::declare(interface),
            files: Some(files),
            library: None,
            first: None,
            usual: String::new(),
            watch: false,
        }
    }

    fn answer(
        &mut self,
        cycle: &mut Cycle<'_>,
        place: &str,
    ) -> Result<OccupancyGrid, ServiceFault> {
        let library = self.library.as_mut();
        let library = library.ok_or_else(|| ServiceFault::new("BAD_MAP", "not configured"))?;
        let place = if place.is_empty() { &self.usual } else { place };
        let served = library.get(place, cycle.now().nanos());
        let served = served.map_err(|error| ServiceFault::new(error.code(), error.to_string()))?;
        let grid = served.grid.clone();
        if served.fresh {
            let news = news(&served);
            cycle.report("map", news.into());
            cycle.write(self.map, grid.clone());
        }
        Ok(grid)
    }

    fn look_for_changes(&mut self, cycle: &mut Cycle<'_>) {
        let now = cycle.now().nanos();
        let Some(library) = &mut self.library else {
            return;
        };
        for (place, result) in library.refresh(now) {
            match (result, library.get(&place, now)) {
                (Ok(()), Ok(served)) => {
                    cycle.report("map", news(&served).into());
                    cycle.write(self.map, served.grid.clone());
                }
                (Err(error), _) => {
                    let what = format!("{place} stays as it was: {error}");
                    cycle.report("map", what.into());
                }
                (Ok(()), Err(_)) => {}
            }
        }
    }
}

/// What there is to say of a map that was just loaded.
fn news(served: &Served<'_>) -> String {
    let info = &served.grid.info;
    let size = format!(
        "{} × {} cells of {} m",
        info.width, info.height, info.resolution
    );
    let notes = served.notes.iter().map(|note| format!("; {note}"));
    format!("{}: {size}{}", served.place, notes.collect::<String>())
}

impl Component for MapServer {
    fn configure(&mut self, setup: &mut Setup<'_>) -> Result<(), Fault> {
        let settings = self.properties.settings(setup)?;
        let source = setup.property(self.properties.source);
        let source = source.strip_prefix("file:").unwrap_or(&source);
        if source.is_empty() {
            return Err(Fault::new(
                "`source` names no map, folder of maps or `places.toml`",
            ));
        }
        if let Some(library) = self.library.take() {
            self.files = Some(library.into_files());
        }
        if let Some(files) = self.files.take() {
            self.library = Some(Library::open(files, source, settings)?);
        }
        self.usual = setup.property(self.properties.place);
        self.first = (!self.usual.is_empty()).then(|| self.usual.clone());
        self.watch = setup.property(self.properties.watch);
        Ok(())
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        if let Some(place) = self.first.take() {
            self.answer(cycle, &place).map_err(Fault::new)?;
        }
        for request in cycle.requests(self.maps) {
            let Place { name } = &request.argument;
            let answer = self.answer(cycle, name);
            cycle.reply(self.maps, request.id, answer);
        }
        if self.watch {
            self.look_for_changes(cycle);
        }
        Ok(())
    }
}

impl Properties {
    fn declare(interface: &mut Interface) -> Self {
        let source = "a map file, a folder of maps, or a `places.toml`; read when configured, as all properties here";
        let place =
            "the place to load and publish at once, and the one meant by a request without a name";
        let resolution =
            "side of a cell; 0 leaves it to the file (ROS maps get coarser, never finer)";
        let max_cells = "no larger grid is made; a cell takes a byte";
        let max_bytes = "no larger file is read, unpacked";
        let rules = "rules before the usual ones, which say what blocks: `key=value|value occupied|free|ignore width=…; …`";
        let watch = "whether to look for changed files each cycle and load them again";
        Self {
            source: interface.property("source", String::new(), source),
            place: interface.property("place", String::new(), place),
            resolution: interface
                .setting("resolution_m", 0.0, resolution)
                .range(0.0..=100.0)
                .unit("m")
                .declare(),
            max_cells: interface
                .setting("max_cells", Settings::default().max_cells, max_cells)
                .range(1..=asmotion_geometry::Layout::MAX_CELLS)
                .declare(),
            max_bytes: interface
                .setting("max_bytes", Settings::default().max_bytes, max_bytes)
                .range(1..=1 << 36)
                .unit("B")
                .declare(),
            rules: interface.property("rules", String::new(), rules),
            watch: interface.property("watch", false, watch),
        }
    }

    fn settings(&self, setup: &Setup<'_>) -> Result<Settings, Fault> {
        let resolution = setup.property(self.resolution);
        Ok(Settings {
            resolution: (resolution > 0.0).then_some(resolution),
            max_cells: setup.property(self.max_cells),
            max_bytes: setup.property(self.max_bytes),
            ground: None,
            rules: Rules::parse(&setup.property(self.rules))?.before(Rules::default()),
        })
    }
}

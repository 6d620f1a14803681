//! The map server in a running system.

use std::sync::{Arc, Mutex};

use asmotion_component::{
    Activity, CallError, Component, Cycle, Fault, Interface, Required, Span, State, Time,
    Transition, Wire,
};
use asmotion_map::{FileFault, FileSource, FilesInMemory, MapServer};
use asmotion_messages::{GetMap, OccupancyGrid, Place};
use asmotion_runtime::{Log, Run, System};

const WALL: &str = r#"{"type":"FeatureCollection","map":{"units":"metres"},"features":[{"type":"Feature","properties":{"indoor":"wall"},"geometry":{"type":"LineString","coordinates":[[0,0],[4,3]]}}]}"#;

type Answers = Arc<Mutex<Vec<Result<OccupancyGrid, CallError>>>>;

/// Requests one map once.
struct Client {
    maps: Required<GetMap>,
    place: Option<&'static str>,
    answers: Answers,
}

impl Component for Client {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        if let Some(place) = self.place.take() {
            let name = place.to_owned();
            cycle.call(self.maps, Place { name });
        }
        let answers = cycle
            .replies(self.maps)
            .into_iter()
            .map(|reply| reply.result);
        self.answers.lock().unwrap().extend(answers);
        Ok(())
    }
}

/// A server with two maps, and a client for each place.
fn system(source: &str, places: &[&'static str]) -> (System, Answers, Log) {
    let files = FilesInMemory::new([("maps/hall.geojson", WALL), ("maps/bad.geojson", "{")]);
    system_on(files, source, places)
}

fn system_on(
    files: impl FileSource + 'static,
    source: &str,
    places: &[&'static str],
) -> (System, Answers, Log) {
    system_as(Activity::event(), files, source, places)
}

fn system_as(
    activity: Activity,
    files: impl FileSource + 'static,
    source: &str,
    places: &[&'static str],
) -> (System, Answers, Log) {
    let (mut system, log, answers) = (System::new(), Log::new(), Answers::default());
    system.observe(log.clone());
    let server = move |interface: &mut Interface| -> Box<dyn Component> {
        Box::new(MapServer::with_files(interface, files))
    };
    let id = system.add("Maps", activity, server).unwrap();
    system.set_property(id, "source", &source.into()).unwrap();
    for (index, place) in places.iter().enumerate() {
        let (name, answers) = (format!("Client{index}"), Arc::clone(&answers));
        let client = move |interface: &mut Interface| -> Box<dyn Component> {
            Box::new(Client {
                maps: interface.require("maps", "a map"),
                place: Some(place),
                answers,
            })
        };
        system
            .add(&name, Activity::periodic(10.ms()), client)
            .unwrap();
        system
            .wire(&format!("{name}.maps"), "Maps.maps", Wire::default())
            .unwrap();
    }
    (system, answers, log)
}

#[test]
fn n7_n12_two_clients_get_the_same_revision_of_a_map_that_was_loaded_once() {
    let (system, answers, log) = system("maps", &["hall", "hall"]);
    system.simulate().run_for(1.s());
    let answers = answers.lock().unwrap();
    let [Ok(one), Ok(other)] = &answers[..] else {
        panic!("{answers:?}");
    };
    assert_eq!(one, other);
    assert_eq!(one.header.frame_id, "map");
    assert_eq!(log.samples::<OccupancyGrid>("Maps.map").len(), 1);
}

#[test]
fn it_says_why_there_is_no_map() {
    let (system, answers, _) = system("maps", &["moon", "bad"]);
    let mut run = system.simulate();
    run.run_for(1.s());
    let answers = answers.lock().unwrap();
    let faults: Vec<_> = answers
        .iter()
        .map(|answer| answer.clone().unwrap_err().to_string())
        .collect();
    assert_eq!(
        faults[0],
        "UNKNOWN_PLACE: unknown place `moon`; known are bad, hall"
    );
    assert!(
        faults[1].starts_with("BAD_MAP: maps/bad.geojson:1:1: "),
        "{}",
        faults[1]
    );
    assert!(run.is_running("Maps"));
}

#[test]
fn it_publishes_its_first_place_unasked() {
    let (mut system, _, log) = system("maps", &[]);
    let maps = system.id("Maps").unwrap();
    system.set_property(maps, "place", &"hall".into()).unwrap();
    system
        .set_property(maps, "resolution_m", &0.5.into())
        .unwrap();
    system.set_property(maps, "frame", &"site".into()).unwrap();
    let mut run = system.simulate();
    run.trigger("Maps").unwrap();
    run.run_for(1.s());
    let published = log.samples::<OccupancyGrid>("Maps.map");
    assert_eq!(published.len(), 1);
    assert_eq!(
        (published[0].1.info.width, published[0].1.info.height),
        (8, 6)
    );
    assert_eq!(published[0].1.header.frame_id, "site");
}

#[test]
fn it_is_not_configured_without_a_source() {
    let (system, ..) = system("", &[]);
    let run = system.simulate();
    assert_eq!(run.state("Maps"), Some(State::PreOperational));
    assert!(
        run.fault("Maps")
            .unwrap()
            .to_string()
            .contains("`source` is not a map")
    );
}

/// A source of which one file takes as long to read as the test wants.
struct Slow {
    files: FilesInMemory,
    /// Reading blocks while this is locked.
    gate: Arc<Mutex<()>>,
}

impl FileSource for Slow {
    fn read(&self, name: &str, limit: u64) -> Result<Vec<u8>, FileFault> {
        if name.contains("slow") {
            drop(self.gate.lock().unwrap());
        }
        self.files.read(name, limit)
    }

    fn list(&self, folder: &str) -> Result<Vec<String>, FileFault> {
        self.files.list(folder)
    }

    fn is_folder(&self, name: &str) -> bool {
        self.files.is_folder(name)
    }

    fn version(&self, name: &str) -> Option<u128> {
        self.files.version(name)
    }
}

/// Runs until the clients have `count` answers: they take a reply in a cycle of theirs, later than it is reported.
fn wait_for(count: usize, answers: &Answers, run: &mut impl Run) {
    let limit = run.now() + 20.s();
    while answers.lock().unwrap().len() < count {
        assert!(run.now() < limit, "{count} answers");
        run.run_for(5.ms());
    }
}

#[test]
fn live_no_cycle_waits_for_a_file_and_other_places_are_served_meanwhile() {
    let gate = Arc::new(Mutex::new(()));
    let closed = gate.lock().unwrap();
    let files = Slow {
        files: FilesInMemory::new([("maps/hall.geojson", WALL), ("maps/slow.geojson", WALL)]),
        gate: Arc::clone(&gate),
    };
    let (system, answers, _) = system_on(files, "maps", &["slow", "hall"]);
    let mut run = system.live();
    wait_for(1, &answers, &mut run);
    let cycles = run.cycles("Maps");
    run.trigger("Maps").unwrap();
    run.run_for(50.ms());
    assert!(run.cycles("Maps") > cycles, "the cycle does not wait");
    assert_eq!(answers.lock().unwrap().len(), 1);
    drop(closed);
    wait_for(2, &answers, &mut run);
    let answers = answers.lock().unwrap();
    let [Ok(hall), Ok(slow)] = &answers[..] else {
        panic!("{answers:?}");
    };
    assert_eq!(hall.data, slow.data);
}

#[test]
fn simulated_the_answer_comes_in_the_cycle_of_the_request() {
    let (system, answers, log) = system("maps", &["hall"]);
    let mut run = system.simulate();
    run.run_for(1.s());
    assert_eq!(answers.lock().unwrap().len(), 1);
    let published = log.samples::<OccupancyGrid>("Maps.map");
    assert_eq!(
        published[0].0,
        Time::ZERO,
        "at the time of the first cycles"
    );
    assert_eq!(run.cycles("Maps"), 2, "of the start, and of the request");
}

#[test]
fn it_fails_without_the_place_it_shall_publish() {
    for (place, why) in [("moon", "UNKNOWN_PLACE"), ("bad", "BAD_MAP")] {
        let (mut system, ..) = system("maps", &[]);
        let maps = system.id("Maps").unwrap();
        system.set_property(maps, "place", &place.into()).unwrap();
        let mut run = system.simulate();
        run.run_for(1.s());
        assert_eq!(run.state("Maps"), Some(State::Exception));
        assert!(run.fault("Maps").unwrap().to_string().starts_with(why));
    }
}

#[test]
fn it_publishes_a_file_again_when_it_has_changed() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("hall.geojson");
    std::fs::write(&file, WALL).unwrap();
    let source = folder.path().to_str().unwrap();
    let (mut system, _, log) = system_on(asmotion_map::DiskFiles, source, &["hall"]);
    let maps = system.id("Maps").unwrap();
    system.set_property(maps, "watch", &true.into()).unwrap();
    let mut run = system.simulate();
    run.run_for(1.s());
    std::fs::write(&file, WALL.replace("[4,3]", "[8,3.5]")).unwrap();
    run.trigger("Maps").unwrap();
    run.run_for(1.s());
    run.trigger("Maps").unwrap();
    run.run_for(1.s());
    let widths = log.samples::<OccupancyGrid>("Maps.map").into_iter();
    let widths: Vec<_> = widths.map(|(_, map)| map.info.width).collect();
    assert_eq!(widths, [80, 160]);
}

#[test]
fn t18_a_stopped_server_gives_maps_and_publishes_them_when_it_starts() {
    let (system, answers, log) = system("maps", &["hall"]);
    let mut run = system.simulate();
    run.transition("Maps", Transition::Stop).unwrap();
    let cycles = run.cycles("Maps");
    run.run_for(1.s());
    assert!(matches!(&answers.lock().unwrap()[..], [Ok(_)]));
    assert_eq!(run.cycles("Maps"), cycles);
    assert!(log.samples::<OccupancyGrid>("Maps.map").is_empty());
    run.transition("Maps", Transition::Start).unwrap();
    run.run_for(1.s());
    assert_eq!(log.samples::<OccupancyGrid>("Maps.map").len(), 1);
}

#[test]
fn t18_live_a_stopped_server_answers_when_the_file_has_been_read() {
    let gate = Arc::new(Mutex::new(()));
    let closed = gate.lock().unwrap();
    let files = Slow {
        files: FilesInMemory::new([("maps/slow.geojson", WALL)]),
        gate: Arc::clone(&gate),
    };
    let stopped = Activity::periodic(1.s()).run_on_startup(false);
    let (system, answers, _) = system_as(stopped, files, "maps", &["slow"]);
    let mut run = system.live();
    run.run_for(50.ms());
    assert_eq!(answers.lock().unwrap().len(), 0);
    drop(closed);
    wait_for(1, &answers, &mut run);
    assert!(answers.lock().unwrap()[0].is_ok());
    assert_eq!(run.state("Maps"), Some(State::Stopped));
}

//! The map server in a running system.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests"
)]

use std::sync::{Arc, Mutex};

use asmotion_component::{
    Activity, CallError, Component, Cycle, Fault, Interface, Log, Required, Run, Span, State,
    System, Wire,
};
use asmotion_map::{MapServer, Memory};
use asmotion_messages::{GetMap, OccupancyGrid, Place};

const WALL: &str = r#"{"type":"FeatureCollection","map":{"units":"metres"},"features":[{"type":"Feature","properties":{"indoor":"wall"},"geometry":{"type":"LineString","coordinates":[[0,0],[4,3]]}}]}"#;

type Answers = Arc<Mutex<Vec<Result<OccupancyGrid, CallError>>>>;

/// Asks for one place, once.
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

/// A server on two maps, and a client for each place.
fn system(source: &str, places: &[&'static str]) -> (System, Answers, Log) {
    let (mut system, log, answers) = (System::new(), Log::new(), Answers::default());
    system.observe(log.clone());
    let server = |interface: &mut Interface| -> Box<dyn Component> {
        let files = Memory::new([("maps/hall.geojson", WALL), ("maps/bad.geojson", "{")]);
        Box::new(MapServer::with_files(interface, Box::new(files)))
    };
    let id = system.add("Maps", Activity::event(), server).unwrap();
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
fn two_clients_get_the_same_revision_of_a_map_that_was_loaded_once() {
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
        "UNKNOWN_PLACE: no place is called `moon`; known are bad, hall"
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
    let mut run = system.simulate();
    run.trigger("Maps").unwrap();
    run.run_for(1.s());
    let published = log.samples::<OccupancyGrid>("Maps.map");
    assert_eq!(published.len(), 1);
    assert_eq!(
        (published[0].1.info.width, published[0].1.info.height),
        (8, 6)
    );
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
            .contains("`source` names no map")
    );
}

//! Round trips between two components of a system.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use asmotion_component::{Activity, Component, Cycle, Fault, In, Interface, Out, Policy};
use asmotion_datum::Datum;
use asmotion_program::{ProgramCommand, ProgramComponent, ask};
use asmotion_runtime::{Live, Run, Simulation, System};

use crate::Trips;
use crate::echo::{sample, sample_schema};

/// Implementation of the component that returns samples.
pub(crate) enum Kind {
    Component,
    Program(ProgramCommand),
}

/// Adds a component that returns samples.
pub(crate) fn add_echo(system: &mut System, name: &str, kind: &Kind, activity: Activity) {
    match kind {
        Kind::Component => {
            let make = |interface: &mut Interface| Box::new(Echo::new(interface)) as Box<_>;
            system.add(name, activity, make).unwrap();
        }
        Kind::Program(command) => {
            let declaration = ask(command, name).unwrap().complete(&|_| None).unwrap();
            let make = |interface: &mut Interface| {
                let component = ProgramComponent::new(command.clone(), declaration, interface);
                Box::new(component) as Box<dyn Component>
            };
            system.add(name, activity, make).unwrap();
        }
    }
}

struct Echo {
    input: In<Datum>,
    output: Out<Datum>,
}

impl Echo {
    fn new(interface: &mut Interface) -> Self {
        Self {
            input: interface.input_of("in", sample_schema(), ""),
            output: interface.output_of("out", sample_schema(), ""),
        }
    }
}

impl Component for Echo {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let newest = cycle.all(self.input).last().cloned();
        if let Some(newest) = newest {
            cycle.write(self.output, newest);
        }
        Ok(())
    }
}

/// The measurement of a round.
#[derive(Default)]
struct Round {
    left: usize,
    times: Vec<Duration>,
}

/// Sends the next sample when the last one has returned.
struct Pinger {
    ends: Echo,
    number: i64,
    sent_at: Instant,
    round: Arc<Mutex<Round>>,
    end_of_round: Sender<()>,
}

impl Component for Pinger {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let newest = cycle.all(self.ends.input).last();
        let returned = newest.and_then(|it| it.get("number")?.as_int());
        let mut round = self.round.lock().unwrap();
        if returned == Some(self.number) && round.left > 0 {
            round.times.push(self.sent_at.elapsed());
            round.left -= 1;
            if round.left == 0 {
                self.end_of_round.send(()).unwrap();
            }
        }
        if round.left > 0 {
            self.number += 1;
            self.sent_at = Instant::now();
            cycle.write(self.ends.output, sample(self.number));
        }
        Ok(())
    }
}

/// A component and its echo in real time, both event-driven.
pub(crate) struct LiveTrips {
    run: Live,
    round: Arc<Mutex<Round>>,
    ends_of_rounds: Receiver<()>,
}

impl LiveTrips {
    pub(crate) fn new(kind: Kind) -> Self {
        let mut system = System::new();
        let round = Arc::<Mutex<Round>>::default();
        let (end_of_round, ends_of_rounds) = channel();
        let make = |interface: &mut Interface| {
            Box::new(Pinger {
                ends: Echo::new(interface),
                number: 0,
                sent_at: Instant::now(),
                round: Arc::clone(&round),
                end_of_round,
            }) as Box<dyn Component>
        };
        system.add("Sender", Activity::event(), make).unwrap();
        add_echo(&mut system, "Echo", &kind, Activity::event());
        let data = Policy::data();
        system
            .connect("Sender.out", "Echo.in", data.clone())
            .unwrap();
        system.connect("Echo.out", "Sender.in", data).unwrap();
        Self {
            run: system.live(),
            round,
            ends_of_rounds,
        }
    }
}

impl Trips for LiveTrips {
    fn measure(&mut self, count: usize) -> Vec<Duration> {
        self.round.lock().unwrap().left = count;
        self.run.trigger("Sender").unwrap();
        let end = self.ends_of_rounds.recv_timeout(Duration::from_secs(60));
        end.unwrap();
        std::mem::take(&mut self.round.lock().unwrap().times)
    }
}

/// A component and its echo in virtual time, which both have a cycle in each trip.
pub(crate) struct VirtualTrips(Simulation);

impl VirtualTrips {
    pub(crate) fn new(command: &ProgramCommand) -> Self {
        let mut system = System::new();
        let activity = Activity::periodic(PERIOD);
        let make = |interface: &mut Interface| {
            let output = interface.output_of("out", sample_schema(), "");
            Box::new(Source { output, number: 0 }) as Box<dyn Component>
        };
        system.add("Source", activity.clone(), make).unwrap();
        let kind = Kind::Program(command.clone());
        add_echo(&mut system, "Echo", &kind, activity);
        let data = Policy::data();
        system.connect("Source.out", "Echo.in", data).unwrap();
        Self(system.simulate())
    }
}

impl Trips for VirtualTrips {
    fn measure(&mut self, count: usize) -> Vec<Duration> {
        let times = (0..count).map(|_| {
            let begin = Instant::now();
            self.0.run_for(PERIOD);
            begin.elapsed()
        });
        times.collect()
    }
}

const PERIOD: Duration = Duration::from_millis(1);

/// Writes a sample in each cycle.
pub(crate) struct Source {
    pub(crate) output: Out<Datum>,
    pub(crate) number: i64,
}

impl Component for Source {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.number += 1;
        cycle.write(self.output, sample(self.number));
        Ok(())
    }
}

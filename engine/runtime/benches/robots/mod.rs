//! Systems of any number of robots, to measure cost against size.

use std::time::Duration;

use asmotion_component::{Activity, Component, Cycle, Fault, In, Interface, Out, Policy};
use asmotion_runtime::{Run, Simulation, System};

asmotion_datum::message! {
    /// A reading of a robot.
    pub struct Reading = "bench/Reading" {
        /// Number of readings before it.
        pub number: i64,
    }
}

/// Period of each robot's sensor.
pub const PERIOD: Duration = Duration::from_millis(100);

/// Publishes a reading in each period.
struct Sensor {
    reading: Out<Reading>,
    number: i64,
}

impl Component for Sensor {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.number += 1;
        let number = self.number;
        cycle.write(self.reading, Reading { number });
        Ok(())
    }
}

/// Reads the readings of its robot, as a coordinator does.
struct Reader {
    reading: In<Reading>,
    sum: i64,
}

impl Component for Reader {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        if let Some(reading) = cycle.read(self.reading).new() {
            self.sum += reading.number;
        }
        Ok(())
    }
}

/// A system of so many robots, whose sensors are out of phase.
pub fn system(robots: usize) -> System {
    let mut system = System::new();
    for robot in 0..robots {
        let delay = PERIOD * u32::try_from(robot).unwrap() / u32::try_from(robots).unwrap();
        let activity = Activity::periodic(PERIOD).delay(delay);
        let sensor = |interface: &mut Interface| -> Box<dyn Component> {
            let reading = interface.output("reading", "its readings");
            Box::new(Sensor { reading, number: 0 })
        };
        let reader = |interface: &mut Interface| -> Box<dyn Component> {
            let reading = interface.input("reading", "those of its robot");
            Box::new(Reader { reading, sum: 0 })
        };
        let [sensor_name, reader_name] = ["Sensor", "Reader"].map(|kind| format!("{kind}{robot}"));
        system.add(&sensor_name, activity, sensor).unwrap();
        system.add(&reader_name, Activity::event(), reader).unwrap();
        let topic = format!("robot{robot}/reading");
        system
            .publish(&format!("{sensor_name}.reading"), &topic)
            .unwrap();
        system
            .subscribe(&topic, &format!("{reader_name}.reading"), Policy::data())
            .unwrap();
    }
    system
}

/// Such a system in virtual time, after its first seconds.
pub fn started(robots: usize) -> Simulation {
    let mut run = system(robots).simulate();
    run.run_for(PERIOD * 20);
    run
}

//! Wires of a running system to another robot and to another system (C18).

use std::sync::Arc;

use asmotion_assembly::reconfigure::Version;
use asmotion_assembly::{Assembled, CoordinatorOptions, Standard};
use asmotion_bus::{
    Bus, BusError, LocalBus, Notifier, Payload, PendingCall, Request, ServedAddress, ServiceClient,
};
use asmotion_component::{Activity, Span};
use asmotion_network::{Network, RunningNetwork};
use asmotion_plan::Part;
use asmotion_runtime::{Log, Run, System};

use crate::additions::deployed;
use crate::replacement::{BRAIN, BUILD, COMPOSITE, Number, apply, replaced, status, version};

/// Asks for the half of a number again and again.
const ASKING: &[(&str, &str)] = &[
    ("{NOACT | ASK}", "{NOACT | HALVE}"),
    ("{NOEV | ANSWER | FAILED}", "{NOEV | HALVED | FAILED}"),
    (
        "\tcontrolled mode",
        "\tcontrolled last: Ev\n\tcontrolled mode",
    ),
    (
        "\t\t\tif ev = ANSWER then answered := true endif",
        "\t\t\tif ev = HALVED or ev = FAILED then par last := ev command := NOACT endpar else\n\
         \t\t\tif command = NOACT then command := HALVE endif endif",
    ),
    ("\t\t\t\t\tif number = 1 then command := ASK endif\n", ""),
    ("\tfunction mode", "\tfunction last = NOEV\n\tfunction mode"),
];

const ROBOT: &str = "binding = \"amqp\"\nurl = \"robot://depot/Slow.sums\"";
const SYSTEM: &str = "binding = \"http\"\nurl = \"http://plant.example/sums\"";

/// The version in which the specification calls this service.
fn asking(service: &str) -> Version {
    let composite = replaced(
        COMPOSITE,
        &[
            (
                "[components.Counter]",
                "[brokers.main]\nurl = \"amqp://rover@desk:5672/cell\"\n[components.Counter]",
            ),
            (
                "ASK = { call = \"sums.double\", with = { n = 4 }, ok = \"ANSWER\"",
                "HALVE = { call = \"sums.halve\", with = { n = 4 }, ok = \"HALVED\"",
            ),
            ("service = \"Slow.sums\"", service),
        ],
    );
    let (_, version) = version(&composite, &replaced(BRAIN, ASKING));
    deployed(&version, |_| Part::WholeOverBus)
}

/// Calls a system outside, whose requests a bus stands for.
struct Outside(LocalBus);

impl ServiceClient for Outside {
    fn call(
        &self,
        address: &str,
        request: Request,
        _: bool,
        notifier: Arc<Notifier>,
    ) -> Result<PendingCall, BusError> {
        let address = address.strip_prefix("http://").expect("an address");
        self.0.call(&address.replace('/', "."), request, notifier)
    }
}

/// A system, another robot with a service of the same name, and a system outside.
struct Site {
    here: Box<dyn Run>,
    robot: Box<dyn Run>,
    robot_log: Log,
    outside: ServedAddress,
    /// Number of requests that the system outside has answered.
    answered: usize,
    network: RunningNetwork,
    plant: LocalBus,
}

impl Site {
    fn start(first: &Version, is_live: bool) -> Self {
        let (bus, plant) = (LocalBus::new(), LocalBus::new());
        let run = |system: System| -> Box<dyn Run> {
            if is_live {
                Box::new(system.live())
            } else {
                Box::new(system.simulate())
            }
        };
        let (robot_log, mut robot) = (Log::new(), System::new());
        robot.observe(robot_log.clone());
        let (_, slow) = BUILD.components[1];
        let slow = robot.add("Slow", Activity::periodic(10.ms()), slow);
        slow.expect("a component");
        let mut network = Network::new();
        let address = "robot://depot/Slow.sums";
        let offered = network.offer_as(&robot, "Slow.sums", address, None);
        offered.expect("a service");
        let attached = network.attach(&mut robot, Arc::new(bus.clone()), 2);
        attached.expect("a bus");
        let loader = first.loader();
        let mut workshop = Standard::new(&BUILD, loader, CoordinatorOptions::seeded(1));
        let assembled = asmotion_assembly::start_part(&first.plan, &first.part, &mut workshop);
        let Assembled {
            mut system,
            mut network,
        } = assembled.expect("a system");
        let attached = network.attach(&mut system, Arc::new(bus), 1);
        attached.expect("a bus");
        let served = plant.serve("plant.example.sums.halve", 8, Arc::new(Notifier::new()));
        Self {
            here: run(system),
            robot: run(robot),
            robot_log,
            outside: served.expect("an address"),
            answered: 0,
            network: network.running(),
            plant,
        }
    }

    /// Returns a version with what it needs to reach the others.
    fn reaching(&self, version: &Version) -> Version {
        let plant = self.plant.clone();
        let version = version.clone().on_buses(self.network.clone());
        version.with_clients(Arc::new(move |_, _| Ok(Arc::new(Outside(plant.clone())))))
    }

    fn changes(&mut self, from: &Version, to: &Version) {
        let (from, to) = (self.reaching(from), self.reaching(to));
        apply(&mut *self.here, &from, &to).expect("another wire");
    }

    /// Runs all for two seconds. Returns the numbers of requests that the robot and the system outside have received.
    fn asked(&mut self) -> [usize; 2] {
        let robot = || self.robot_log.lines_with("halve").len();
        let before = [robot(), self.answered];
        for _ in 0..100 {
            self.here.run_for(20.ms());
            self.robot.run_for(20.ms());
            while let Some(call) = self.outside.try_next() {
                self.answered += 1;
                let number = asmotion_datum::Datum::of(&Number { n: 2 });
                call.reply(Ok(Payload::of(number.expect("a datum"))));
            }
        }
        let robot = self.robot_log.lines_with("halve").len();
        [robot - before[0], self.answered - before[1]]
    }

    fn last(&mut self) -> String {
        status(&mut *self.here, "Brain").state["last"].clone()
    }
}

fn is_wired_abroad(is_live: bool) {
    let [own, robot, system] = ["service = \"Slow.sums\"", ROBOT, SYSTEM].map(asking);
    let mut site = Site::start(&own, is_live);
    assert_eq!(site.asked(), [0, 0]);
    assert_eq!(site.last(), "HALVED");
    site.changes(&own, &robot);
    let expected = site.network.new_robot_services(None);
    assert_eq!(expected.len(), 1);
    assert_eq!(expected[0].robot(), "depot");
    let [of_robot, of_system] = site.asked();
    assert!(of_robot > 3 && of_system == 0, "{of_robot} {of_system}");
    assert_eq!(site.last(), "HALVED");
    // it is compared with what the robot announces
    expected[0].set_missing(&[]);
    assert_eq!(site.asked()[0], 0);
    assert_eq!(site.last(), "FAILED");
    drop(expected);
    site.changes(&robot, &system);
    let [of_robot, of_system] = site.asked();
    assert!(of_robot == 0 && of_system > 3, "{of_robot} {of_system}");
    assert_eq!(site.last(), "HALVED");
    // what was found wrong before does not concern a new wire
    site.changes(&system, &robot);
    let [of_robot, of_system] = site.asked();
    assert!(of_robot > 3 && of_system == 0, "{of_robot} {of_system}");
    site.changes(&robot, &own);
    assert_eq!(site.asked(), [0, 0]);
    assert_eq!(site.last(), "HALVED");
    site.here.stop();
    site.robot.stop();
}

#[test]
fn c18_a_simulated_system_is_wired_to_another_robot_and_to_another_system() {
    is_wired_abroad(false);
}

#[test]
fn c18_a_live_system_is_wired_to_another_robot_and_to_another_system() {
    is_wired_abroad(true);
}

#[test]
fn c18_a_system_without_a_client_of_other_systems_stays_as_it_is() {
    let [own, system] = ["service = \"Slow.sums\"", SYSTEM].map(asking);
    let mut site = Site::start(&own, false);
    let [from, to] = [&own, &system].map(|it| it.clone().on_buses(site.network.clone()));
    let planned = asmotion_assembly::reconfigure::changes(&from, &to, &*site.here);
    let refused = site.here.change(&planned.expect("no new start is needed"));
    assert_eq!(
        refused.expect_err("no client").to_string(),
        "`Brain.sums` cannot be joined to http://plant.example/sums: there is no client of other systems"
    );
    assert_eq!(site.asked(), [0, 0]);
    assert_eq!(site.last(), "HALVED");
}

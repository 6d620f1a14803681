//! Every input of every component × values that cannot be meant: nothing fails, nothing that is not finite comes out, and a
//! refused message changes nothing.

use std::sync::{Arc, Mutex};

use asmotion_component::{Activity, Interface, Policy, Span, State, Time};
use asmotion_components::COMPONENTS;
use asmotion_datum::{Datum, Message};
use asmotion_messages::{
    Bool, Disc, Encoders, Event, Float64, Header, JointCommand, JointStatus, LaserScan,
    MapMetaData, Obstacles, OccupancyGrid, Odometry, Path, Polygon, Pose, PoseStamped, RoverDisc,
    RoverDiscs, Scene, Segment, Twist, Vertex, WheelSpeeds,
};
use asmotion_runtime::{Event as RunEvent, PortWriter, Run, Simulation, System};

/// Numbers that no quantity has.
const HOSTILE: [f64; 5] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308, -1e308];

/// Number of good messages before, and after, the hostile ones.
const STEPS: usize = 4;

/// Another rover of the world, far away.
fn other_rover() -> RoverDisc {
    RoverDisc {
        rover: "other".to_owned(),
        disc: Disc {
            x: 9.0,
            y: 9.0,
            radius: 0.3,
        },
    }
}

/// The n-th good message of a type; `None` for a type that this table lacks.
fn good(name: &str, n: usize) -> Option<Datum> {
    let nanos = n as i64 * 50_000_000;
    let x = 0.05 * n as f64;
    let header = Header::new(nanos, "map");
    let datum = match name {
        Twist::NAME => Datum::of(&Twist::planar(0.3, 0.1)),
        Bool::NAME => Datum::of(&Bool { data: true }),
        WheelSpeeds::NAME => Datum::of(&WheelSpeeds {
            left: 1.0,
            right: 2.0,
        }),
        Encoders::NAME => Datum::of(&Encoders {
            stamp: header.stamp,
            left: x * 20.0,
            right: x * 21.0,
        }),
        Odometry::NAME => {
            let mut odometry = Odometry {
                header,
                ..Odometry::default()
            };
            odometry.pose.pose = Pose::planar(x, 0.0, 0.1);
            odometry.twist.twist = Twist::planar(0.3, 0.0);
            Datum::of(&odometry)
        }
        Path::NAME => {
            let poses = (0..5).map(|at| Pose::planar(f64::from(at), 0.0, 0.0));
            Datum::of(&Path::from_poses(nanos, "map", poses))
        }
        LaserScan::NAME => Datum::of(&LaserScan {
            header,
            angle_min: -1.0,
            angle_max: 1.0,
            angle_increment: 0.25,
            scan_time: 0.05,
            range_min: 0.05,
            range_max: 10.0,
            ranges: vec![2.0; 9],
            ..LaserScan::default()
        }),
        OccupancyGrid::NAME => Datum::of(&OccupancyGrid {
            header,
            info: MapMetaData {
                resolution: 0.5,
                width: 8,
                height: 4,
                origin: Pose::planar(-1.0, -1.0, 0.0),
                ..MapMetaData::default()
            },
            data: vec![0; 32],
        }),
        Obstacles::NAME => Datum::of(&Obstacles {
            stamp: header.stamp,
            points: vec![Vertex { x: 3.0, y: 0.5 }],
        }),
        Event::NAME => Datum::of(&Event::new(nanos, Event::REACHED, "")),
        JointStatus::NAME => Datum::of(&JointStatus {
            stamp: header.stamp,
            position: vec![0.1; 5],
            velocity: vec![0.0; 5],
            current: vec![0.0; 5],
            temperature: vec![30.0; 5],
            error_flags: vec![0; 5],
        }),
        JointCommand::NAME => Datum::of(&JointCommand {
            stamp: header.stamp,
            position: vec![0.2; 5],
        }),
        Float64::NAME => Datum::of(&Float64 { data: 0.05 }),
        PoseStamped::NAME => Datum::of(&PoseStamped {
            header,
            pose: Pose::planar(x, 0.0, 0.1),
        }),
        RoverDisc::NAME => Datum::of(&other_rover()),
        RoverDiscs::NAME => Datum::of(&RoverDiscs {
            rovers: vec![other_rover()],
        }),
        Scene::NAME => {
            let corners = [(3.0, -1.0), (4.0, -1.0), (4.0, 1.0)];
            let [a, b, c] = corners.map(|(x, y)| Vertex { x, y });
            Datum::of(&Scene {
                revision: n as u64,
                segments: vec![Segment { a, b }],
                discs: vec![Disc {
                    x: 2.0,
                    y: 1.0,
                    radius: 0.3,
                }],
                polygons: vec![Polygon {
                    vertices: vec![a, b, c],
                }],
            })
        }
        _ => return None,
    };
    Some(datum.unwrap())
}

/// Variants of a message in each of which one number is hostile, and grids whose layout is.
fn hostile(good: &Datum) -> Vec<Datum> {
    let mut variants = Vec::new();
    for value in HOSTILE {
        for at in 0..floats(good) {
            let mut changed = good.clone();
            let mut left = at;
            set_float(&mut changed, &mut left, value);
            variants.push(changed);
        }
    }
    for (path, value) in [
        ("info.resolution", Datum::Float(0.0)),
        ("info.resolution", Datum::Float(-0.05)),
        ("info.width", Datum::Int(0)),
        ("info.width", Datum::Int(4_294_967_295)),
        ("info.height", Datum::Int(4_294_967_295)),
        ("scan_time", Datum::Float(-1.0)),
        ("range_min", Datum::Float(-1.0)),
        ("header.stamp.nanosec", Datum::Int(4_294_967_295)),
        ("stamp.nanosec", Datum::Int(4_294_967_295)),
        ("pose.pose.orientation.w", Datum::Float(2.0)),
        ("poses.0.pose.orientation.w", Datum::Float(2.0)),
        ("discs.0.radius", Datum::Float(-1.0)),
    ] {
        let mut changed = good.clone();
        if set(&mut changed, path, value) {
            variants.push(changed);
        }
    }
    variants.push(Datum::Record(Vec::new()));
    variants
}

/// Number of floats in a datum; of a long list, the first three count.
fn floats(datum: &Datum) -> usize {
    let mut count = 0;
    visit(&mut datum.clone(), &mut |_| count += 1);
    count
}

fn set_float(datum: &mut Datum, at: &mut usize, value: f64) {
    let mut index = 0;
    visit(datum, &mut |float| {
        if index == *at {
            *float = value;
        }
        index += 1;
    });
}

/// Visits all floats. Packed lists of them become lists.
fn visit(datum: &mut Datum, f: &mut dyn FnMut(&mut f64)) {
    if let Datum::Numbers(numbers) = datum {
        *datum = Datum::List(numbers.iter().collect());
    }
    if let Datum::Float(float) = datum {
        f(float);
    } else if let Datum::List(list) = datum {
        list.iter_mut().take(3).for_each(|one| visit(one, f));
    } else if let Datum::Record(fields) = datum {
        fields.iter_mut().for_each(|(_, one)| visit(one, f));
    }
}

/// Sets the value at a path; returns `false` if there is none.
fn set(datum: &mut Datum, path: &str, value: Datum) -> bool {
    let (first, rest) = path.split_once('.').unwrap_or((path, ""));
    let found = if let Datum::Record(fields) = datum {
        let mut fields = fields.iter_mut();
        fields.find(|(name, _)| name == first).map(|(_, one)| one)
    } else if let Datum::List(list) = datum {
        first
            .parse()
            .ok()
            .and_then(|index: usize| list.get_mut(index))
    } else {
        None
    };
    match found {
        Some(found) if rest.is_empty() => {
            *found = value;
            true
        }
        Some(found) => set(found, rest, value),
        None => false,
    }
}

/// A component with a writer for each of its inputs, and what it has published.
struct InputBench {
    run: Simulation,
    inputs: Vec<(String, String, PortWriter<Datum>)>,
    published: Arc<Mutex<Vec<(Time, String, Datum)>>>,
    faults: Arc<Mutex<Vec<String>>>,
}

impl InputBench {
    fn new(name: &str) -> Self {
        let make = asmotion_components::component(name).unwrap();
        let mut system = System::new();
        let activity = Activity::periodic(50.ms());
        system
            .add("It", activity, move |interface| make(interface))
            .unwrap();
        let published = Arc::new(Mutex::new(Vec::new()));
        let faults = Arc::new(Mutex::new(Vec::new()));
        let (outputs, failures) = (Arc::clone(&published), Arc::clone(&faults));
        system.observe(move |now: Time, event: &RunEvent<'_>| {
            if let RunEvent::Published { port, sample, .. } = event {
                let output = (now, (*port).to_owned(), sample.to_datum().unwrap());
                outputs.lock().unwrap().push(output);
            } else if let RunEvent::Fault { fault, .. } = event {
                failures.lock().unwrap().push(fault.to_string());
            }
        });
        let mut run = system.simulate();
        let mut scratch = Interface::new();
        make(&mut scratch);
        let declared = scratch.declaration().inputs.clone();
        let inputs = declared.iter().map(|input| {
            let port = format!("It.{}", input.name);
            let writer = run.writer(&port, Policy::default()).unwrap();
            (input.name.clone(), input.schema.name.to_string(), writer)
        });
        let inputs = inputs.collect();
        Self {
            run,
            inputs,
            published,
            faults,
        }
    }

    /// Writes the n-th good message to every input, and runs the cycle that reads them.
    fn step(&mut self, n: usize) {
        for (name, kind, writer) in &mut self.inputs {
            let message = good(kind, n).unwrap_or_else(|| panic!("no good `{kind}` for {name}"));
            writer.write(message).unwrap();
        }
        self.run.run_for(50.ms());
    }

    /// Writes a message to one input in front of the next good ones.
    fn disturb(&mut self, input: usize, message: &Datum) {
        let (_, _, writer) = &mut self.inputs[input];
        writer.write(message.clone()).unwrap();
    }

    fn outputs(&self) -> Vec<(Time, String, Datum)> {
        self.published.lock().unwrap().clone()
    }
}

/// Runs a component on good messages, with a hostile one in the middle.
fn run(name: &str, disturbance: Option<(usize, &Datum)>) -> InputBench {
    let mut bench = InputBench::new(name);
    for n in 0..STEPS {
        bench.step(n);
    }
    if let Some((input, message)) = disturbance {
        bench.disturb(input, message);
    }
    bench.run.run_for(50.ms());
    for n in STEPS..3 * STEPS {
        bench.step(n);
    }
    bench
}

/// Returns whether all numbers of an output are finite.
fn is_finite(output: &Datum) -> bool {
    let mut finite = true;
    visit(&mut output.clone(), &mut |float| {
        finite &= float.is_finite()
    });
    finite
}

#[test]
fn no_message_makes_a_component_fail_or_write_nonsense() {
    let mut refused = 0;
    for (name, _) in COMPONENTS {
        let undisturbed = run(name, None);
        if undisturbed.inputs.is_empty() {
            continue;
        }
        assert_eq!(undisturbed.run.state("It"), Some(State::Running), "{name}");
        let expected = undisturbed.outputs();
        for (index, (input, kind, _)) in undisturbed.inputs.iter().enumerate() {
            for message in hostile(&good(kind, STEPS).unwrap()) {
                let bench = run(name, Some((index, &message)));
                let of = format!("{name}.{input} = {message:?}");
                let faults = bench.faults.lock().unwrap().clone();
                assert!(faults.is_empty(), "{of}: {faults:?}");
                assert_eq!(bench.run.state("It"), Some(State::Running), "{of}");
                let outputs = bench.outputs();
                // a range of a scan is infinite where nothing is in sight
                for (_, port, output) in outputs.iter().filter(|(_, port, _)| port != "scan") {
                    assert!(is_finite(output), "{of}: {port} = {output:?}");
                }
                if bench.run.losses("It").misfits > 0 {
                    refused += 1;
                    assert_eq!(outputs, expected, "{of} was refused, but changes something");
                }
            }
        }
    }
    assert!(refused > 200, "only {refused} messages were refused");
}

#[test]
fn a_refusal_is_counted_each_time_and_reported_once_for_each_cause() {
    let reports = Arc::new(Mutex::new(Vec::new()));
    let seen = Arc::clone(&reports);
    let mut bench = InputBench::new("nav::sim::RoverDriver");
    bench.run.observe(move |_: Time, event: &RunEvent<'_>| {
        if let RunEvent::Report { data, .. } = event {
            seen.lock()
                .unwrap()
                .push(data.as_text().unwrap().to_owned());
        }
    });
    let encoders = |left: f64| Datum::record([("left", Datum::Float(left))]);
    let input = bench
        .inputs
        .iter()
        .position(|(name, ..)| name == "encoders")
        .unwrap();
    for value in [f64::NAN, 1e308, f64::INFINITY] {
        bench.disturb(input, &encoders(value));
        bench.run.run_for(50.ms());
    }
    assert_eq!(bench.run.losses("It").misfits, 3);
    let expected = "`encoders` refuses a message: `left`: not finite, or too large";
    assert_eq!(*reports.lock().unwrap(), [expected]);
}

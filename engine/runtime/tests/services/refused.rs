//! Requests that a provider refuses because its queue is full: counted, reported, and part of a frozen system.

use crate::common::{Double, number};
use asmotion_component::{
    Activity, CallError, Component, Cycle, Fault, Freeze, Interface, Losses, Provided, Required,
    Span, Wire, freeze_by_fields,
};
use asmotion_runtime::{Log, Run, Simulation, System};

/// Makes 80 calls in its first cycle.
#[derive(Freeze)]
#[freeze(component = "test::Hasty", version = 1)]
struct Hasty {
    has_called: bool,
    #[freeze(skip)]
    one_way: bool,
    #[freeze(skip)]
    double: Required<Double>,
}

impl Component for Hasty {
    freeze_by_fields!();

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        for n in 0..80 * i64::from(!self.has_called) {
            if self.one_way {
                cycle.call_one_way(self.double, number(n));
            } else {
                cycle.call(self.double, number(n));
            }
        }
        self.has_called = true;
        for reply in cycle.replies(self.double) {
            assert_eq!(reply.result.err(), Some(CallError::Unavailable));
        }
        Ok(())
    }
}

/// Never replies.
#[derive(Freeze)]
#[freeze(component = "test::Silent", version = 1)]
struct Silent {
    #[freeze(skip)]
    double: Provided<Double>,
}

impl Component for Silent {
    freeze_by_fields!();

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        drop(cycle.requests(self.double));
        Ok(())
    }
}

/// Two callers, and a provider that begins after 500 ms.
fn system(log: &Log, one_way: bool) -> Simulation {
    let mut system = System::new();
    system.observe(log.clone());
    for caller in ["One", "Two"] {
        let activity = Activity::periodic(100.ms());
        let hasty = |interface: &mut Interface| -> Box<dyn Component> {
            let double = interface.require::<Double>("sums", "asks");
            Box::new(Hasty {
                has_called: false,
                one_way,
                double,
            })
        };
        system.add(caller, activity, hasty).unwrap();
    }
    let serving = |interface: &mut Interface| -> Box<dyn Component> {
        let double = interface.serve::<Double>("sums", "is silent");
        Box::new(Silent { double })
    };
    let activity = Activity::periodic(1.s()).delay(500.ms());
    system.add("Provider", activity, serving).unwrap();
    for caller in ["One", "Two"] {
        let (from, wire) = (format!("{caller}.sums"), Wire::timeout(10.s()));
        system.wire(&from, "Provider.sums", wire).unwrap();
    }
    system.simulate()
}

#[test]
fn f14_requests_refused_by_a_full_queue_are_counted_and_reported() {
    for one_way in [false, true] {
        let log = Log::new();
        let mut run = system(&log, one_way);
        run.run_for(400.ms());
        // the queue holds 128 of 160
        assert_eq!(run.refused_requests("Provider"), [32]);
        assert_eq!(run.refused_requests("One"), [0; 0]);
        let losses = Losses {
            dropped: 32,
            misfits: 0,
        };
        assert_eq!(run.losses("Provider"), losses);
        let dropped = log.lines_with("dropped");
        assert_eq!(dropped.len(), 32, "{dropped:?}");
        assert_eq!(dropped[31], "0 s Two.sums -> Provider.sums: 32 dropped");
    }
}

#[test]
fn f14_a_frozen_system_keeps_the_count_of_refused_requests() {
    let mut run = system(&Log::new(), false);
    run.run_for(400.ms());
    let state = run.freeze().unwrap();
    let mut other = system(&Log::new(), false);
    other.thaw(&state).unwrap();
    assert_eq!(other.refused_requests("Provider"), [32]);
}

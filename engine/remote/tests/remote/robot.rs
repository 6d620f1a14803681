//! A system on an in-process bus, run by a thread of its own.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

use asmotion_assembly::{Assembled, CoordinatorOptions, Standard};
use asmotion_bus::LocalBus;
use asmotion_component::Span;
use asmotion_plan::Part;
use asmotion_remote::{LastSamples, ProcessContact, Remote};
use asmotion_runtime::Run;

use crate::driver::{BUILD, files, open};

/// A running system. Dropping this ends it.
pub struct Robot {
    pub bus: LocalBus,
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Robot {
    /// Starts a driver on its own bus.
    pub fn start() -> Self {
        let (bus, ends) = (LocalBus::new(), Arc::new(AtomicBool::new(false)));
        let (on, until) = (bus.clone(), Arc::clone(&ends));
        let thread = std::thread::spawn(move || live(&on, &until));
        Self {
            bus,
            ends,
            thread: Some(thread),
        }
    }

    /// A connection to the system from outside.
    pub fn remote(&self) -> Remote {
        Remote::over_bus(Arc::new(self.bus.clone()), None).expect("a bus")
    }
}

impl Drop for Robot {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            thread.join().expect("a system that ends in order");
        }
    }
}

fn live(bus: &LocalBus, until: &AtomicBool) {
    let opened = open(&[]);
    let plan = opened.plan(None).expect("a plan");
    let files = files();
    let mut workshop = Standard::new(&BUILD, &files, CoordinatorOptions::seeded(1));
    let part = Part::with_brokers(plan);
    let assembled = asmotion_assembly::start_part(plan, &part, &mut workshop);
    let Assembled {
        mut system,
        mut network,
    } = assembled.expect("a system");
    let attached = network.attach(&mut system, Arc::new(bus.clone()), 1);
    attached.expect("a bus");
    let newest = LastSamples::default();
    system.observe(newest.clone());
    let mut contact = ProcessContact::new(plan, part, "arm", bus, 1, newest).expect("a bus");
    let mut run = system.live();
    while !until.load(Ordering::Acquire) {
        contact.process_orders(&mut run);
        run.run_for(5.ms());
    }
    run.stop();
    contact.leave();
}

//! Components that read and write as directed by a test.

use std::sync::{Arc, Mutex};

use asmotion_component::{Activity, Component, Flow, Interface, Policy, Span};
use asmotion_runtime::{Run, Simulation, System};

use crate::common::{Number, behaviour, number};

/// Values recorded by a component, shared with the test.
pub type Seen<T> = Arc<Mutex<Vec<T>>>;

pub fn taken<T>(seen: &Seen<T>) -> Vec<T> {
    std::mem::take(&mut seen.lock().unwrap())
}

/// Writes all prepared values in its next cycle.
pub fn writer(ready: &Seen<i64>) -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    let ready = Arc::clone(ready);
    behaviour(move |interface| {
        let out = interface.output::<Number>("n", "what lies ready");
        move |cycle| {
            for n in taken(&ready) {
                cycle.write(out, number(n));
            }
            Ok(())
        }
    })
}

/// Records all samples that it reads.
pub fn reader(seen: &Seen<i64>) -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    let seen = Arc::clone(seen);
    behaviour(move |interface| {
        let input = interface.input::<Number>("n", "numbers");
        move |cycle| {
            let all = cycle.all(input).iter().map(|sample| sample.n);
            seen.lock().unwrap().extend(all);
            Ok(())
        }
    })
}

/// Records the flow of its port: `no data`, `old 1`, `new 2`.
pub fn looker(seen: &Seen<String>) -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    let seen = Arc::clone(seen);
    behaviour(move |interface| {
        let input = interface.input::<Number>("n", "numbers");
        move |cycle| {
            let shown = shown(cycle.read(input));
            seen.lock().unwrap().push(shown);
            Ok(())
        }
    })
}

pub fn shown(flow: Flow<&Number>) -> String {
    match flow {
        Flow::NoData => "no data".to_owned(),
        Flow::OldData(sample) => format!("old {}", sample.n),
        Flow::NewData(sample) => format!("new {}", sample.n),
    }
}

/// Writers `A` and `B`, readers `X` and `Y`, all driven by hand.
pub struct Bench {
    pub system: System,
    pub ready: [Seen<i64>; 2],
    pub seen: [Seen<i64>; 2],
}

impl Bench {
    pub fn new() -> Self {
        let mut bench = Self {
            system: System::new(),
            ready: Default::default(),
            seen: Default::default(),
        };
        for (name, ready) in ["A", "B"].iter().zip(&bench.ready) {
            let add = bench.system.add(name, Activity::manual(), writer(ready));
            add.unwrap();
        }
        for (name, seen) in ["X", "Y"].iter().zip(&bench.seen) {
            let add = bench.system.add(name, Activity::manual(), reader(seen));
            add.unwrap();
        }
        bench
    }

    /// Connects the given ends, each written as `A X`.
    pub fn connected(ends: &[&str], policy: &Policy) -> Self {
        let mut bench = Self::new();
        for ends in ends {
            let (from, to) = ends.split_once(' ').unwrap();
            let (from, to) = (format!("{from}.n"), format!("{to}.n"));
            bench.system.connect(&from, &to, policy.clone()).unwrap();
        }
        bench
    }

    pub fn simulate(self) -> Hands {
        Hands {
            run: self.system.simulate(),
            ready: self.ready,
            seen: self.seen,
        }
    }
}

/// A running bench, driven by hand.
pub struct Hands {
    pub run: Simulation,
    ready: [Seen<i64>; 2],
    seen: [Seen<i64>; 2],
}

impl Hands {
    pub fn write(&mut self, who: &str, what: impl IntoIterator<Item = i64>) {
        let place = usize::from(who == "B");
        self.ready[place].lock().unwrap().extend(what);
        self.cycle(who);
    }

    pub fn read(&mut self, who: &str) -> Vec<i64> {
        self.cycle(who);
        taken(&self.seen[usize::from(who == "Y")])
    }

    pub fn cycle(&mut self, who: &str) {
        self.run.trigger(who).unwrap();
        self.run.run_for(1.ms());
    }
}

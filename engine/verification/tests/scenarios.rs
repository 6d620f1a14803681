//! Simulated runs of the repository's composites, with seeds, while every component with a protocol is followed.

use crate::support::{CATALOGUE, Files, NoVariables};
use asmotion_assembly::{CoordinatorOptions, Standard};
use asmotion_component::{Span, Time, Transition};
use asmotion_composite::{AsmFiles, Context, NoPrograms};
use asmotion_datum::Datum;
use asmotion_plan::{Implementation, Part, Plan};
use asmotion_runtime::Run;
use asmotion_verification::conformance::{ComponentConformance, ProtocolObserver};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A simulated run.
#[derive(Clone, Default)]
pub struct Scenario {
    pub composite: &'static str,
    /// Properties of the composite.
    pub settings: Vec<(String, String)>,
    /// Properties of components: component, name and value as JSON.
    pub properties: Vec<(&'static str, &'static str, String)>,
    /// Messages from outside: time in ms, topic or input port, and content as JSON.
    pub messages: Vec<(u64, String, String)>,
    /// Components that stop: time in ms, and name.
    pub stops: Vec<(u64, &'static str)>,
    pub seconds: u64,
    pub seed: u64,
}

/// The observations of each implementation, by its name in the catalogue, or of the component if its file names the protocol.
pub type Conformance = BTreeMap<String, ComponentConformance>;

impl Scenario {
    /// Runs it with these files, and follows the components with a protocol.
    pub fn observed(&self, files: &Files) -> Conformance {
        let specifications = AsmFiles::new(files);
        let context = Context {
            loader: files,
            environment: &NoVariables,
            catalogue: &*CATALOGUE,
            specifications: &specifications,
            programs: &NoPrograms,
            settings: &self.settings,
        };
        let opened = asmotion_plan::open(self.composite, &context);
        let style = asmotion_lang::Style::Plain;
        assert!(
            !opened.report.has_errors(),
            "{}",
            asmotion_lang::render_all(&opened.report, &opened.sources, style)
        );
        let plan = opened.plan(None).expect("a plan");
        let protocols = |name: &str| files.protocol(name);
        let observer =
            ProtocolObserver::new(plan, &Part::Whole, files, &protocols).expect("protocols");
        let mut workshop = Standard::new(&*CATALOGUE, files, CoordinatorOptions::seeded(self.seed));
        let mut system = asmotion_assembly::start(plan, &mut workshop).expect("a system");
        for (component, property, value) in &self.properties {
            let id = system.id(component).expect("a component");
            let value: Datum = asmotion_datum::json::decode(value).expect("JSON");
            let set = system.set_property(id, property, &value);
            set.unwrap_or_else(|error| panic!("{component}.{property}: {error}"));
        }
        system.observe(observer.clone());
        let mut run = system.simulate();
        for (at, target, content) in &self.messages {
            let content: Datum = asmotion_datum::json::decode(content).expect("JSON");
            let (at, content) = (Time::ZERO + at.ms(), Arc::new(content));
            let sent = if target.contains('.') {
                run.inject_sample(at, target, content)
            } else {
                run.publish_sample(at, target, content)
            };
            sent.unwrap_or_else(|error| panic!("{target}: {error}"));
        }
        for (at, component) in &self.stops {
            run.run_until(Time::ZERO + at.ms());
            run.transition(component, Transition::Stop).expect("a stop");
        }
        run.run_until(Time::ZERO + self.seconds.s());
        by_implementation(plan, observer.found())
    }
}

fn by_implementation(plan: &Plan, found: BTreeMap<String, ComponentConformance>) -> Conformance {
    let mut all = Conformance::new();
    for (component, found) in found {
        let planned = plan.component(&component).expect("a component");
        let name = match &planned.implementation {
            Implementation::Rust(name) => name.clone(),
            Implementation::Asm { .. }
            | Implementation::Builtin { .. }
            | Implementation::Process { .. }
            | Implementation::Ros { .. }
            | Implementation::Orocos { .. } => component,
        };
        merge(&mut all, name, found);
    }
    all
}

fn merge(all: &mut Conformance, name: String, found: ComponentConformance) {
    let known = all.entry(name).or_default();
    known.cycles += found.cycles;
    known.sent.extend(found.sent);
    known.followed.extend(found.followed);
    known.possible = known.possible.take().or(found.possible);
    known.deviation = known.deviation.take().or(found.deviation);
}

/// Runs all scenarios, and puts together what was observed.
#[expect(clippy::print_stderr, reason = "names the scenario if a test fails")]
pub fn observed(scenarios: &[Scenario], files: &Files) -> Conformance {
    let mut all = Conformance::new();
    for scenario in scenarios {
        for (name, found) in scenario.observed(files) {
            if let Some((at, deviation)) = &found.deviation {
                let seconds = at.nanos() as f64 * 1e-9;
                eprintln!(
                    "{} {} at {seconds} s: {name}: {deviation}",
                    scenario.composite, scenario.seed
                );
            }
            merge(&mut all, name, found);
        }
    }
    all
}

/// Numbers that look random: the generator of Steele, Lea and Flood (`SplitMix64`).
pub struct Dice(pub u64);

impl Dice {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// A number below a limit.
    pub fn below(&mut self, limit: u64) -> u64 {
        self.next() % limit
    }

    pub fn one_of<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        &all[self.below(all.len() as u64) as usize]
    }
}

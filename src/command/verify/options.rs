//! The options of a verification, from those of the command.

use super::Verify;
use super::input_values::{GivenValues, ValuesError, given_values, machine_of};
use crate::exit::Exit;
use crate::terminal::TerminalOutput;
use asmotion_verify::{FairName, Limits, Options, VerifiedMachine};

impl Verify {
    pub(super) fn options(
        &self,
        machines: &mut [VerifiedMachine],
        terminal: &mut TerminalOutput,
    ) -> Result<Options, Exit> {
        let is_declared = |text: &str| {
            machines.iter().any(|machine| {
                let model = &machine.specification.model;
                let mut invariants = model.invariants.iter().map(|it| &*it.name);
                let mut properties = model.properties.iter().filter_map(|it| it.name.as_deref());
                invariants.any(|name| name == text) || properties.any(|name| name == text)
            })
        };
        let engine = match self.engine.engine() {
            Ok(engine) => engine,
            Err(error) => {
                terminal.error(error);
                return Err(Exit::Usage);
            }
        };
        let storage = match self.storage() {
            Ok(storage) => storage,
            Err(text) => {
                terminal.error(text);
                return Err(Exit::Usage);
            }
        };
        let terms = self.property.iter().filter(|text| !is_declared(text));
        let mut options = Options {
            limits: Limits {
                states: self.states,
                depth: self.bound,
                memory: Some(self.memory_limit().bytes()),
                reserve: Some(self.reserve),
            },
            properties: terms.cloned().collect(),
            possible: self.possible.clone(),
            only: self
                .property
                .iter()
                .chain(&self.possible)
                .cloned()
                .collect(),
            assumptions: self.assume.clone(),
            ends: self.end.clone(),
            fairness: self.fairness(),
            advice: self.advice,
            keeps_states: self.itf.is_some(),
            inputs: Vec::new(),
            engine,
            threads: self.threads(),
            storage,
            symmetry: self.symmetry(),
            cone: self.cone(),
            independent: self.independent(),
            messages: self.system.message_model(),
            ..Options::default()
        };
        for values in &self.values {
            let (machine, name) = machine_of(machines, values);
            let Some(known) = machines.get_mut(machine) else {
                continue;
            };
            let specification = &mut known.specification;
            match given_values(machine, specification, &name) {
                Ok(GivenValues::Input(values)) => options.inputs.push(values),
                Ok(GivenValues::Content(values)) => options.contents.push(values),
                Err(ValuesError::Text(text)) => {
                    terminal.error(format_args!("`--values {values}`: {text}"));
                    return Err(Exit::Usage);
                }
                Err(ValuesError::Term(report)) => {
                    terminal.report(&report, &specification.sources);
                    return Err(Exit::Usage);
                }
            }
        }
        Ok(options)
    }

    fn fairness(&self) -> Vec<FairName> {
        let weak = self.fair.iter().map(|name| (name, false));
        let strong = self.strongly_fair.iter().map(|name| (name, true));
        let all = weak.chain(strong).map(|(name, is_strong)| FairName {
            name: name.clone(),
            is_strong,
        });
        all.collect()
    }
}

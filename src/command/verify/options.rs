//! The options of a verification, from those of the command.

use super::Verify;
use super::input_values::{ValuesError, input_values};
use crate::exit::Exit;
use crate::terminal::TerminalOutput;
use asmotion_lang::Specification;
use asmotion_verify::{Limits, Options};

impl Verify {
    pub(super) fn options(
        &self,
        specification: &mut Specification,
        terminal: &mut TerminalOutput,
    ) -> Result<Options, Exit> {
        let is_declared = |text: &str| {
            let model = &specification.model;
            let mut invariants = model.invariants.iter().map(|it| &*it.name);
            let mut properties = model.properties.iter().filter_map(|it| it.name.as_deref());
            invariants.any(|name| name == text) || properties.any(|name| name == text)
        };
        let terms = self.property.iter().filter(|text| !is_declared(text));
        let mut options = Options {
            limits: Limits {
                states: self.states,
                depth: self.bound,
                memory: Some(self.memory << 20),
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
            inputs: Vec::new(),
            ..Options::default()
        };
        for values in &self.values {
            match input_values(specification, values) {
                Ok(values) => options.inputs.push(values),
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
}

//! Writes the session as a scenario that sets the inputs and checks the updates.

use crate::paths::relative_specification;
use asmotion_lang::{History, HistoryEvent, Machine, Session, Value, simulate};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// Returns the scenario of all events so far, to be stored at `path`.
pub fn scenario(history: &mut History, path: &Path, spec: &Path, seed: u64) -> String {
    let mut scenario = ScenarioWriter::default();
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let is_letter = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
    let name: String = name
        .chars()
        .map(|letter| if is_letter(letter) { letter } else { '_' })
        .collect();
    scenario.line(&format!("// choices were made with seed {seed}"));
    scenario.line(&format!("scenario {name}"));
    scenario.line(&format!("load {}", relative_specification(path, spec)));
    history.replay(|event, session| scenario.event(event, session));
    scenario.text
}

#[derive(Default)]
struct ScenarioWriter {
    text: String,
    /// Inputs as set by the scenario so far.
    inputs: BTreeMap<String, String>,
}

impl ScenarioWriter {
    fn event(&mut self, event: &HistoryEvent, session: &Session) {
        let machine = &session.machine;
        match event {
            HistoryEvent::Step => {
                self.set_inputs(machine);
                self.line("step");
                self.check_updates(machine);
            }
            HistoryEvent::Fire(rule) => self.line(&format!("exec {};", rule.trim_end_matches(';'))),
            // a monitored location is set in the scenario when a step reads it
            HistoryEvent::Set(function, arguments, value) => {
                let kind = machine.program().functions[function.0 as usize].kind;
                if kind != asmotion_lang::ir::FunctionKind::Monitored {
                    let location = simulate::applied(machine, *function, arguments);
                    self.fact("exec", &location, ":=", &value_text(machine, value));
                }
            }
            HistoryEvent::Release(..) => {}
        }
    }

    fn set_inputs(&mut self, machine: &Machine) {
        for input in machine.last_step().inputs() {
            let location = simulate::location(machine, input.slot);
            let value = value_text(machine, &input.value);
            let known = self.inputs.insert(location.clone(), value.clone());
            if known.unwrap_or_else(|| "undef".to_owned()) != value {
                self.fact("set", &location, ":=", &value);
            }
        }
    }

    fn check_updates(&mut self, machine: &Machine) {
        for (location, _, after) in simulate::updates(machine, &machine.last_step()) {
            self.fact("check", &location, "=", &after);
        }
    }

    fn fact(&mut self, verb: &str, location: &str, sign: &str, value: &str) {
        self.line(&format!("{verb} {location} {sign} {value};"));
    }

    fn line(&mut self, line: &str) {
        // writing to a string cannot fail
        let _ = writeln!(self.text, "{line}");
    }
}

fn value_text(machine: &Machine, value: &Value) -> String {
    value.show(&machine.naming()).to_string()
}

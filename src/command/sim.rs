//! `asmotion sim`: a specification alone.

use crate::exit::Exit;
use crate::files::Disk;
use crate::terminal::{FAINT, NAME, Terminal, count};
use asm_lang::machine::Machine;
use asm_lang::simulate::{self, Random, Script, Seeded};
use asm_lang::{Environment, Loader, Report, Severity, Specification, Step};
use clap::Args;
use serde_json::{Map, Value, json};

/// Runs a specification alone, with scripted or random inputs.
#[derive(Args)]
pub struct Sim {
    /// The specification.
    spec: String,

    /// How many steps; as many as the script has, or 20 without one.
    #[arg(long)]
    steps: Option<u64>,

    /// Inputs by name, step by step (TOML: `[default]` and `[[step]]` tables); random ones without.
    #[arg(long, value_name = "FILE")]
    env: Option<String>,

    /// Decides random inputs and `choose`.
    #[arg(long, default_value_t = 1)]
    seed: u64,

    /// One JSON object a line: each step, then the final state.
    #[arg(long)]
    json: bool,

    /// The final state alone.
    #[arg(long, short)]
    quiet: bool,
}

/// Where inputs come from.
enum Inputs {
    Script(Script),
    Random(Box<Random>),
}

impl Inputs {
    fn environment(&mut self) -> &mut dyn Environment {
        match self {
            Self::Script(script) => script,
            Self::Random(random) => &mut **random,
        }
    }

    fn advance(&mut self) {
        if let Self::Script(script) = self {
            script.advance();
        }
    }
}

impl Sim {
    /// Runs it.
    pub fn run(self, terminal: &mut Terminal) -> Exit {
        if self.spec.ends_with(".toml") {
            terminal.error(format_args!(
                "`{0}` is a composite: `asmotion run {0}` runs it",
                self.spec
            ));
            return Exit::Usage;
        }
        let mut specification = match asm_lang::open(&self.spec, &Disk) {
            Ok(specification) => specification,
            Err(failure) => {
                terminal.report(&failure.report, &failure.sources);
                terminal.error(count(&failure.report).unwrap_or_default());
                return Exit::Findings;
            }
        };
        if specification.report.count(Severity::Warning) > 0 {
            terminal.report(&specification.report, &specification.sources);
        }
        let mut machine = match specification.machine() {
            Ok(machine) => machine,
            Err(fault) => return self.fault(&fault, &specification, None, terminal),
        };
        let mut inputs = match self.inputs(&mut specification, &machine) {
            Ok(inputs) => inputs,
            Err(report) => {
                terminal.report(&report, &specification.sources);
                return Exit::Usage;
            }
        };
        let steps = self.steps.unwrap_or(match &inputs {
            Inputs::Script(script) => script.len() as u64,
            Inputs::Random(_) => 20,
        });
        let mut chooser = Seeded::new(self.seed);
        for _ in 0..steps {
            if let Err(fault) = machine.step(inputs.environment(), &mut chooser, 0) {
                if !self.json {
                    self.state(&machine, terminal);
                }
                return self.fault(&fault, &specification, Some(&machine), terminal);
            }
            inputs.advance();
            if !self.quiet {
                self.step(&machine, terminal);
            }
        }
        self.state(&machine, terminal);
        Exit::Ok
    }

    fn inputs(
        &self,
        specification: &mut Specification,
        machine: &Machine,
    ) -> Result<Inputs, Report> {
        let Some(path) = &self.env else {
            let program = specification.program.clone();
            return Ok(Inputs::Random(Box::new(Random::new(
                program, machine, self.seed,
            ))));
        };
        let text = Disk.read(path).map_err(|error| {
            let mut report = Report::new();
            report.push(
                asm_lang::Diagnostic::error("S000", error)
                    .help("check the path given with `--env`"),
            );
            report
        })?;
        let file = specification.sources.add(path, text.clone());
        Script::read(file, &text, &specification.program).map(Inputs::Script)
    }

    fn step(&self, machine: &Machine, terminal: &mut Terminal) {
        let step = machine.last_step();
        if self.json {
            return terminal.result(step_json(machine, &step));
        }
        terminal.result(format_args!("{NAME}step {}{NAME:#}", step.number));
        let naming = machine.naming();
        for input in step.inputs {
            let location = simulate::location(machine, input.slot);
            terminal.result(format_args!(
                "  {FAINT}{location} = {}{FAINT:#}",
                input.value.show(&naming)
            ));
        }
        for (location, before, after) in simulate::updates(machine, &step) {
            terminal.result(format_args!(
                "  {location} := {after}  {FAINT}(was {before}){FAINT:#}"
            ));
        }
        for line in step.printed {
            terminal.result(format_args!("  print: {line}"));
        }
        if step.updates.is_empty() {
            terminal.result(format_args!("  {FAINT}no updates{FAINT:#}"));
        }
    }

    fn state(&self, machine: &Machine, terminal: &mut Terminal) {
        let state = state(machine);
        if self.json {
            let state: Map<String, Value> = state
                .into_iter()
                .map(|(location, value)| (location, Value::String(value)))
                .collect();
            return terminal.result(
                json!({ "type": "state", "v": 1, "steps": machine.steps(), "state": state }),
            );
        }
        terminal.result(format_args!(
            "{NAME}state after step {}{NAME:#}",
            machine.steps()
        ));
        for (location, value) in state {
            terminal.result(format_args!("  {location} = {value}"));
        }
    }

    fn fault(
        &self,
        fault: &asm_lang::Fault,
        specification: &Specification,
        machine: Option<&Machine>,
        terminal: &mut Terminal,
    ) -> Exit {
        let finding = match machine {
            Some(machine) => specification.explain_in(fault, machine),
            None => specification.explain(fault),
        };
        if self.json {
            terminal.result(json!({
                "type": "fault", "v": 1, "step": fault.step, "code": finding.code, "message": finding.message,
            }));
        }
        let mut report = Report::new();
        report.push(finding);
        terminal.report(&report, &specification.sources);
        Exit::Fault
    }
}

/// What every location of the specification that has a value holds.
fn state(machine: &Machine) -> Vec<(String, String)> {
    let naming = machine.naming();
    let mut shown: Vec<(String, String)> = machine
        .state()
        .locations(machine.program())
        .into_iter()
        .filter(|(_, _, slot)| !machine.state().get(*slot).is_undef())
        .map(|(function, arguments, slot)| {
            let location = simulate::applied(machine, function, &arguments);
            (
                location,
                machine.state().get(slot).show(&naming).to_string(),
            )
        })
        .collect();
    shown.sort();
    shown
}

fn step_json(machine: &Machine, step: &Step<'_>) -> Value {
    let naming = machine.naming();
    let inputs: Map<String, Value> = step
        .inputs
        .iter()
        .map(|input| {
            let value = input.value.show(&naming).to_string();
            (
                simulate::location(machine, input.slot),
                Value::String(value),
            )
        })
        .collect();
    let updates: Vec<Value> = simulate::updates(machine, step)
        .into_iter()
        .map(|(location, before, after)| json!({ "location": location, "before": before, "after": after }))
        .collect();
    let choices: Vec<Value> = step
        .choices
        .iter()
        .map(|choice| json!({ "index": choice.index, "of": choice.count }))
        .collect();
    json!({
        "type": "step", "v": 1, "step": step.number,
        "inputs": inputs, "choices": choices, "updates": updates, "printed": step.printed,
    })
}

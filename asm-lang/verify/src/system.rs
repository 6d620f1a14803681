//! Systems: machines that are verified together, and what they read from each other.

use crate::codes::m007::AmbiguousConnection;
use crate::codes::m008::ConnectionMismatch;
use crate::codes::m009::UnusedProvision;
use crate::codes::m010::NothingProvided;
use crate::environment::EnvironmentModel;
use crate::translation::{corresponds, described, element};
use asmotion_diagnostics::{Finding, Span};
use asmotion_lang::ir::{Function, FunctionId, FunctionKind, Program};
use asmotion_lang::{Report, Specification, Value};
use std::collections::BTreeMap;

/// A machine of a system.
#[derive(Debug)]
pub struct VerifiedMachine {
    /// Name of the machine in the system; that of the specification if there is only one.
    pub name: String,
    /// Its specification. That of a verification has no properties any more, but additions.
    pub specification: Specification,
}

/// Machines that are verified together.
#[derive(Debug, Default)]
pub struct SystemSpecification {
    /// The machines, with different names.
    pub machines: Vec<VerifiedMachine>,
    /// Inputs that machines read from others, in addition to those that follow from names.
    pub connections: Vec<InputConnection>,
    /// Partners that machines of the system are, in addition to those found by name.
    pub message_links: Vec<MessageLink>,
    /// `true` if nothing follows from names: inputs without a connection have any value, a partner without a link is not part of the
    /// system, and requests from outside come only to `open`.
    pub ignores_names: bool,
    /// Indices of the machines to which requests also come from outside, if names are ignored.
    pub open: Vec<usize>,
    /// Which machines make a step at a time.
    pub schedule: MachineSchedule,
    /// The source of inputs that no machine provides.
    pub environment: EnvironmentModel,
}

/// Which machines make a step at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MachineSchedule {
    /// One machine after the other, in every order.
    #[default]
    Interleaved,
    /// All machines at the same time; each reads what the others had before.
    Synchronous,
}

/// An input that is read from another machine.
#[derive(Clone, Debug)]
pub struct InputConnection {
    /// Monitored or shared function that is read.
    pub input: ConnectedLocation,
    /// Controlled, out or shared function that provides the value.
    pub source: ConnectedLocation,
}

/// A location of a machine, or all locations of a function.
#[derive(Clone, Debug, PartialEq)]
pub struct ConnectedLocation {
    /// Index of the machine.
    pub machine: usize,
    /// The function.
    pub function: FunctionId,
    /// Its arguments. `None` for all locations: those of the input are read from those of the source with the same arguments.
    pub arguments: Option<Vec<Value>>,
}

/// The partner of a machine that another machine is.
#[derive(Clone, Debug, PartialEq)]
pub struct MessageLink {
    /// Index of the machine that sends requests.
    pub client: usize,
    /// The agent that stands for the partner in its specification.
    pub partner: Value,
    /// Index of the machine that receives them.
    pub provider: usize,
}

/// The source of an input location.
#[derive(Clone, Debug)]
pub(crate) struct InputSource {
    /// Arguments of the input; `None` for all.
    pub arguments: Option<Vec<Value>>,
    pub machine: usize,
    pub function: FunctionId,
    /// Arguments of the source; `None` for those of the input.
    pub source_arguments: Option<Vec<Value>>,
}

/// The sources of the inputs of each machine.
pub(crate) type InputSources = Vec<BTreeMap<FunctionId, Vec<InputSource>>>;

impl VerifiedMachine {
    /// A machine with the name of its specification.
    pub fn of(specification: Specification) -> Self {
        Self {
            name: specification.model.name.to_string(),
            specification,
        }
    }
}

impl SystemSpecification {
    /// A system of one machine.
    pub fn of(specification: Specification) -> Self {
        Self {
            machines: vec![VerifiedMachine::of(specification)],
            ..Self::default()
        }
    }

    /// Sets the environment.
    #[must_use]
    pub fn with_environment(mut self, environment: EnvironmentModel) -> Self {
        self.environment = environment;
        self
    }

    /// Adds the connections that follow from names: an input reads the function with its name and number of parameters of the only
    /// other machine that has one; `f(NAME)` reads `f` of the machine called `NAME`; and `f` of the machine called `NAME` reads
    /// `f(NAME)` of another machine. Inputs that are connected already are left as they are.
    ///
    /// # Errors
    /// Several machines have the function: the machine that reads it, and a report.
    pub(crate) fn connect_by_name(&mut self) -> Result<(), (usize, Report)> {
        if self.ignores_names {
            return Ok(());
        }
        let mut found = Vec::new();
        for (machine, input) in self.inputs() {
            if self.is_connected(machine, input) {
                continue;
            }
            match self.sources_by_name(machine, input) {
                Ok(sources) => found.extend(sources),
                Err(problem) => {
                    let mut report = Report::new();
                    report.push(problem.diagnostic());
                    return Err((machine, report));
                }
            }
        }
        self.connections.extend(found);
        Ok(())
    }

    /// Lists the own inputs of all machines.
    fn inputs(&self) -> Vec<(usize, FunctionId)> {
        let mut all = Vec::new();
        for (index, machine) in self.machines.iter().enumerate() {
            let functions = own_functions(&machine.specification.program);
            let inputs = functions.filter(|(_, it)| it.kind == FunctionKind::Monitored);
            all.extend(inputs.map(|(id, _)| (index, id)));
        }
        all
    }

    fn is_connected(&self, machine: usize, function: FunctionId) -> bool {
        let mut inputs = self.connections.iter().map(|it| &it.input);
        inputs.any(|input| input.machine == machine && input.function == function)
    }

    fn program(&self, machine: usize) -> Option<&Program> {
        let machine = self.machines.get(machine)?;
        Some(&machine.specification.program)
    }

    fn sources_by_name(
        &self,
        machine: usize,
        input: FunctionId,
    ) -> Result<Vec<InputConnection>, AmbiguousConnection> {
        let Some(program) = self.program(machine) else {
            return Ok(Vec::new());
        };
        let (Some(name), Some(declared)) = (
            program.symbols.functions.get(input.0 as usize),
            program.functions.get(input.0 as usize),
        ) else {
            return Ok(Vec::new());
        };
        let arity = declared.parameters.len();
        let all = |machine, function| ConnectedLocation {
            machine,
            function,
            arguments: None,
        };
        let mut candidates = Vec::new();
        let mut of_elements = Vec::new();
        for (other, known) in self.machines.iter().enumerate() {
            if other == machine {
                continue;
            }
            let program = &known.specification.program;
            if let Some(function) = provided(program, name, arity) {
                candidates.push(all(other, function));
            }
            // `f(NAME)` reads `f` of the machine called `NAME`
            let own_program = self.program(machine);
            if let ([shape], Some(own), Some(function)) = (
                declared.parameters.as_slice(),
                own_program,
                provided(program, name, 0),
            ) && let Some(argument) = element(&known.name, own, shape)
            {
                of_elements.push(InputConnection {
                    input: ConnectedLocation {
                        machine,
                        function: input,
                        arguments: Some(vec![argument]),
                    },
                    source: all(other, function),
                });
            }
            // `f` of the machine called `NAME` reads `f(NAME)`
            let own_name = self.machines.get(machine).map(|it| it.name.as_str());
            if let (0, Some(own_name), Some(function)) =
                (arity, own_name, provided(program, name, 1))
                && let Some(shape) = program
                    .functions
                    .get(function.0 as usize)
                    .and_then(|it| it.parameters.first())
                && let Some(argument) = element(own_name, program, shape)
            {
                candidates.push(ConnectedLocation {
                    machine: other,
                    function,
                    arguments: Some(vec![argument]),
                });
            }
        }
        match candidates.as_slice() {
            [] => Ok(of_elements),
            [source] => Ok(vec![InputConnection {
                input: all(machine, input),
                source: source.clone(),
            }]),
            several => Err(AmbiguousConnection {
                function: name.to_string(),
                machines: several
                    .iter()
                    .filter_map(|it| self.machines.get(it.machine))
                    .map(|it| it.name.clone())
                    .collect(),
                has_parameters: arity > 0,
                at: self.declared_at(machine, input),
            }),
        }
    }

    fn declared_at(&self, machine: usize, function: FunctionId) -> Span {
        let machine = self.machines.get(machine);
        machine.map_or_else(Span::default, |it| declared_at(&it.specification, function))
    }

    /// Returns the sources of all inputs.
    ///
    /// # Errors
    /// The functions of a connection have different types: the machine whose input it is, and a report.
    pub(crate) fn input_sources(&self) -> Result<InputSources, (usize, Report)> {
        let mut sources: InputSources = vec![BTreeMap::new(); self.machines.len()];
        for connection in &self.connections {
            let input = &connection.input;
            if let Some(mismatch) = self.mismatch(connection) {
                let mut report = Report::new();
                report.push(mismatch.diagnostic());
                return Err((input.machine, report.finish()));
            }
            if let Some(of_machine) = sources.get_mut(input.machine) {
                let of_input = of_machine.entry(input.function).or_default();
                of_input.push(InputSource {
                    arguments: input.arguments.clone(),
                    machine: connection.source.machine,
                    function: connection.source.function,
                    source_arguments: match &input.arguments {
                        Some(_) => Some(connection.source.arguments.clone().unwrap_or_default()),
                        None => connection.source.arguments.clone(),
                    },
                });
            }
        }
        Ok(sources)
    }

    fn mismatch(&self, connection: &InputConnection) -> Option<ConnectionMismatch> {
        let InputConnection { input, source } = connection;
        let (own, other) = (self.program(input.machine)?, self.program(source.machine)?);
        let read = own.functions.get(input.function.0 as usize)?;
        let given = other.functions.get(source.function.0 as usize)?;
        let corresponds_in_value = corresponds((other, &given.codomain), (own, &read.codomain));
        let has_parameters = input.arguments.is_some() || source.arguments.is_some();
        let corresponds_in_parameters = has_parameters
            || read.parameters.len() == given.parameters.len()
                && read
                    .parameters
                    .iter()
                    .zip(&given.parameters)
                    .all(|(read, given)| corresponds((own, read), (other, given)));
        if corresponds_in_value && corresponds_in_parameters {
            return None;
        }
        let signature = |program: &Program, function: &Function| {
            let parameters: Vec<String> = function
                .parameters
                .iter()
                .map(|shape| described(program, shape))
                .collect();
            let codomain = described(program, &function.codomain);
            if parameters.is_empty() {
                codomain
            } else {
                format!("{} -> {codomain}", parameters.join(", "))
            }
        };
        Some(ConnectionMismatch {
            input: own
                .symbols
                .functions
                .get(input.function.0 as usize)?
                .to_string(),
            source_machine: self.machines.get(source.machine)?.name.clone(),
            expected: signature(own, read),
            found: signature(other, given),
            at: self.declared_at(input.machine, input.function),
        })
    }

    /// Checks the connections of an environment: each of its out functions is read, and each of its inputs is provided.
    ///
    /// # Errors
    /// One is not.
    pub(crate) fn check_environment(&self, environment: usize) -> Result<(), Report> {
        let Some(machine) = self.machines.get(environment) else {
            return Ok(());
        };
        let program = &machine.specification.program;
        let mut report = Report::new();
        for (id, function) in own_functions(program) {
            let name = program.symbols.functions.get(id.0 as usize);
            let function_name = name.map(ToString::to_string).unwrap_or_default();
            let at = self.declared_at(environment, id);
            if function.kind == FunctionKind::Out {
                let mut sources = self.connections.iter().map(|it| &it.source);
                let is_read = sources.any(|it| it.machine == environment && it.function == id);
                if !is_read {
                    let inputs = self.input_names(environment);
                    report.push(UnusedProvision::of(function_name, at, &inputs).diagnostic());
                }
            } else if function.kind == FunctionKind::Monitored
                && !self.is_connected(environment, id)
            {
                let provided = self.provided_names(environment);
                report.push(NothingProvided::of(function_name, at, &provided).diagnostic());
            }
        }
        if report.has_errors() {
            Err(report.finish())
        } else {
            Ok(())
        }
    }

    /// Names of the inputs without a source, of the machines other than the environment.
    fn input_names(&self, environment: usize) -> Vec<String> {
        let inputs = self.inputs().into_iter();
        let names = inputs.filter(|(machine, function)| {
            *machine != environment && !self.is_connected(*machine, *function)
        });
        let names = names.filter_map(|(machine, function)| {
            let program = self.program(machine)?;
            Some(
                program
                    .symbols
                    .functions
                    .get(function.0 as usize)?
                    .to_string(),
            )
        });
        names.collect()
    }

    /// Names of the functions that the machines other than the environment provide.
    fn provided_names(&self, environment: usize) -> Vec<String> {
        let machines = self.machines.iter().enumerate();
        let machines = machines.filter(|(machine, _)| *machine != environment);
        let names = machines.flat_map(|(_, machine)| {
            let program = &machine.specification.program;
            let provided = own_functions(program).filter(|(_, it)| is_updated(it));
            provided.filter_map(|(id, _)| {
                let name = program.symbols.functions.get(id.0 as usize)?;
                Some(name.to_string())
            })
        });
        names.collect()
    }

    /// Lists the inputs that no machine provides, as `machine.function`.
    pub(crate) fn free_inputs(&self) -> Vec<String> {
        let inputs = self.inputs().into_iter();
        let free = inputs.filter(|(machine, function)| !self.is_connected(*machine, *function));
        let names = free.filter_map(|(machine, function)| {
            let known = self.machines.get(machine)?;
            let names = &known.specification.program.symbols.functions;
            Some(format!(
                "{}.{}",
                known.name,
                names.get(function.0 as usize)?
            ))
        });
        names.collect()
    }
}

/// The functions that a specification declares itself.
pub(crate) fn own_functions(program: &Program) -> impl Iterator<Item = (FunctionId, &Function)> {
    let functions = program.functions.iter().enumerate();
    let functions = functions.filter(|(_, it)| it.own && it.mail.is_none() && it.clock.is_none());
    functions.map(|(index, function)| (FunctionId(index as u32), function))
}

/// Returns `true` if a function provides values for other machines.
fn is_updated(function: &Function) -> bool {
    match function.kind {
        FunctionKind::Controlled | FunctionKind::Out | FunctionKind::Shared => true,
        FunctionKind::Monitored | FunctionKind::Local | FunctionKind::Fixed => false,
    }
}

/// Returns the function of a program that provides values, with this name and number of parameters.
fn provided(program: &Program, name: &str, arity: usize) -> Option<FunctionId> {
    let mut functions = own_functions(program);
    let found = functions.find(|(id, function)| {
        let known = program.symbols.functions.get(id.0 as usize);
        is_updated(function)
            && function.parameters.len() == arity
            && known.is_some_and(|known| **known == *name)
    });
    found.map(|(id, _)| id)
}

/// Place of the declaration of a function.
pub(crate) fn declared_at(specification: &Specification, function: FunctionId) -> Span {
    let functions = &specification.model.functions;
    let declared = functions.get(function.0 as usize);
    declared.map_or_else(Span::default, |it| it.span)
}

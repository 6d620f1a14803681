//! The observer: a machine that never makes a step, in whose specification terms about several machines are resolved.
//!
//! A term such as `courier.jobs <= dispatcher.finished` has no place in the specification of either machine. The observer declares a
//! monitored function for each function that such a term names, and reads the function of the machine. It adds neither states nor
//! transitions.

use crate::codes::m012::SeveralMachines;
use crate::inputs::InputRanges;
use crate::options::Options;
use crate::qualifier::{places_of, qualifiers};
use crate::system::{
    ConnectedLocation, InputConnection, SystemSpecification, VerifiedMachine, own_functions,
};
use crate::translation::atoms_of;
use asmotion_diagnostics::{Finding, Sources, Span};
use asmotion_lang::ir::{
    DomainElements, DomainId, Function, FunctionId, FunctionKind, Program, ValueShape,
};
use asmotion_lang::{MemoryFiles, Report};
use std::collections::{BTreeMap, BTreeSet};

/// Name of the observer, which no specification can have.
pub(crate) const OBSERVER: &str = "(observer)";

/// The observer of a system, if terms need one.
#[derive(Debug, Default)]
pub(crate) struct ObserverMachine {
    /// Index of the machine.
    pub machine: Option<usize>,
    /// The terms about several machines, with their texts in the observer's specification.
    pub terms: BTreeMap<String, String>,
}

impl ObserverMachine {
    /// Adds an observer to a system if a term of the options is about several machines.
    ///
    /// # Errors
    /// A term names something that cannot be observed: the index of a machine, and a report.
    pub fn of(
        system: &mut SystemSpecification,
        options: &Options,
    ) -> Result<Self, (usize, Report)> {
        let names: Vec<String> = system.machines.iter().map(|it| it.name.clone()).collect();
        let mut observer = Self::default();
        let mut draft = Draft::new(&names);
        let terms = options.properties.iter().chain(&options.possible);
        let terms = terms.chain(&options.assumptions).chain(&options.ends);
        for text in terms {
            if qualifiers(text, &names).len() < 2 || observer.terms.contains_key(text) {
                continue;
            }
            match draft.translate(system, text) {
                Ok(own) => {
                    observer.terms.insert(text.clone(), own);
                }
                Err(problem) => return Err(refuse(system, &names, text, problem)),
            }
        }
        let Some(text) = observer.terms.keys().next() else {
            return Ok(observer);
        };
        let machine = system.machines.len();
        let mut files = MemoryFiles::new();
        files.add("observer", draft.text());
        let opened = asmotion_lang::open("observer", &files);
        let specification = opened.map_err(|failure| {
            let problem = Problem::new(failure.to_string(), None);
            refuse(system, &names, text, problem)
        })?;
        system.machines.push(VerifiedMachine {
            name: OBSERVER.to_owned(),
            specification,
        });
        let observed = draft.observed.into_iter();
        let connections = observed.filter_map(|((of, source), declared)| {
            let own = system.machines.get(machine)?;
            let input = declared_as(&own.specification.program, &declared.name, declared.arity)?;
            let all = |machine, function| ConnectedLocation {
                machine,
                function,
                arguments: None,
            };
            Some(InputConnection {
                input: all(machine, input),
                source: all(of, source),
            })
        });
        let connections: Vec<InputConnection> = connections.collect();
        system.connections.extend(connections);
        observer.machine = Some(machine);
        Ok(observer)
    }

    /// Checks that the observed inputs have finite domains: representatives of an input are chosen without regard to other machines.
    ///
    /// # Errors
    /// One has no finite domain.
    pub fn check_inputs(
        &self,
        system: &mut SystemSpecification,
        ranges: &[InputRanges],
    ) -> Result<(), (usize, Report)> {
        let Some(observer) = self.machine else {
            return Ok(());
        };
        let mut unlisted = None;
        for connection in &system.connections {
            let source = &connection.source;
            let Some(known) = system.machines.get(source.machine) else {
                continue;
            };
            let program = &known.specification.program;
            let function = program.functions.get(source.function.0 as usize);
            let is_input = function.is_some_and(|it| it.kind == FunctionKind::Monitored);
            let is_provided = system.connections.iter().any(|it| {
                it.input.machine == source.machine && it.input.function == source.function
            });
            let has_values = ranges
                .get(source.machine)
                .is_some_and(|it| it.of(source.function).is_ok());
            if connection.input.machine == observer && is_input && !is_provided && !has_values {
                let name = program.symbols.functions.get(source.function.0 as usize);
                unlisted = Some((known.name.clone(), name.map(ToString::to_string)));
                break;
            }
        }
        let Some((machine, function)) = unlisted else {
            return Ok(());
        };
        let names: Vec<String> = system.machines.iter().map(|it| it.name.clone()).collect();
        let qualified = format!("{machine}.{}", function.unwrap_or_default());
        let text = self.terms.keys().find(|it| it.contains(&qualified));
        let text = text.cloned().unwrap_or_default();
        let problem = Problem::new(
            format!(
                "`{qualified}` is an input without a finite domain: select its values with `--values`"
            ),
            text.find(&qualified),
        );
        Err(refuse(system, &names, &text, problem))
    }
}

/// The reason for which a term cannot be observed, and its place in the text.
struct Problem {
    reason: String,
    at: Option<usize>,
}

impl Problem {
    fn new(reason: String, at: Option<usize>) -> Self {
        Self { reason, at }
    }
}

/// Describes a term that cannot be observed; its text becomes a source of the first machine that it names.
fn refuse(
    system: &mut SystemSpecification,
    names: &[String],
    text: &str,
    problem: Problem,
) -> (usize, Report) {
    let first = qualifiers(text, names).first().copied().unwrap_or_default();
    let sources = system.machines.get_mut(first);
    let sources = sources.map(|it| &mut it.specification.sources);
    let file = sources.map(|it: &mut Sources| it.add("<property>", text));
    let file = file.unwrap_or_default();
    let at = match problem.at {
        Some(at) => {
            let rest = text.get(at..).unwrap_or_default();
            let is_word = |sign: char| sign.is_alphanumeric() || sign == '_' || sign == '.';
            let length = rest.find(|sign| !is_word(sign)).unwrap_or(rest.len());
            Span::new(file, at, at + length)
        }
        None => Span::new(file, 0, text.len()),
    };
    let finding = SeveralMachines {
        text: text.to_owned(),
        reason: problem.reason,
        at,
    };
    let mut report = Report::new();
    report.push(finding.diagnostic());
    (first, report.finish())
}

/// A function of the observer.
struct ObservedFunction {
    name: String,
    arity: usize,
}

/// The specification of an observer, in the making.
struct Draft<'a> {
    names: &'a [String],
    /// For each machine, the prefix of its functions in the observer: its name as an identifier, with the same length.
    prefixes: Vec<String>,
    observed: BTreeMap<(usize, FunctionId), ObservedFunction>,
    functions: Vec<String>,
    domains: Vec<ObservedDomain>,
}

/// A domain of the observer: that of a machine, or several of the same name.
struct ObservedDomain {
    name: String,
    content: DomainContent,
}

#[derive(PartialEq)]
enum DomainContent {
    Integers(i64, i64),
    Elements(Vec<String>),
}

impl<'a> Draft<'a> {
    fn new(names: &'a [String]) -> Self {
        let mut prefixes: Vec<String> = Vec::new();
        for name in names {
            let word = |sign: char| {
                if sign.is_ascii_alphanumeric() {
                    sign
                } else {
                    '_'
                }
            };
            let mut word: String = name.chars().map(word).collect();
            let rest = word.split_off(word.chars().next().map_or(0, char::len_utf8));
            // function names begin with a small letter
            let own = word.to_ascii_lowercase();
            let letters = ('a'..='z').map(String::from);
            let starts = std::iter::once(own).chain(letters);
            let mut free = starts
                .filter(|start| start.starts_with(|sign: char| sign.is_ascii_lowercase()))
                .map(|start| format!("{start}{rest}"))
                .filter(|it| !prefixes.contains(it));
            prefixes.push(
                free.next()
                    .unwrap_or_else(|| format!("m{}", prefixes.len())),
            );
        }
        Self {
            names,
            prefixes,
            observed: BTreeMap::new(),
            functions: Vec::new(),
            domains: Vec::new(),
        }
    }

    /// Declares the functions that a term names, and returns its text in the observer's specification.
    fn translate(&mut self, system: &SystemSpecification, text: &str) -> Result<String, Problem> {
        let mut places = Vec::new();
        for (machine, name) in self.names.iter().enumerate() {
            places.extend(places_of(text, name).map(|place| (place, machine, name.len())));
        }
        places.sort_unstable();
        let mut own = String::new();
        let mut end = 0;
        for (place, machine, length) in places {
            let rest = text.get(place + length + 1..).unwrap_or_default();
            let is_word = |sign: char| sign.is_alphanumeric() || sign == '_';
            let word = rest.get(..rest.find(|sign| !is_word(sign)).unwrap_or(rest.len()));
            let word = word.unwrap_or_default();
            self.observe(system, machine, word)
                .map_err(|reason| Problem::new(reason, Some(place)))?;
            own.push_str(text.get(end..place).unwrap_or_default());
            own.push_str(self.prefixes.get(machine).map_or("", |it| it.as_str()));
            own.push('_');
            end = place + length + 1;
        }
        own.push_str(text.get(end..).unwrap_or_default());
        Ok(own)
    }

    /// Declares the functions of a machine with this name.
    fn observe(
        &mut self,
        system: &SystemSpecification,
        machine: usize,
        word: &str,
    ) -> Result<(), String> {
        let Some(known) = system.machines.get(machine) else {
            return Ok(());
        };
        let program = &known.specification.program;
        let mut is_declared = false;
        let mut is_fixed = false;
        for (id, function) in own_functions(program) {
            let name = program.symbols.functions.get(id.0 as usize);
            if name.is_none_or(|it| **it != *word) {
                continue;
            }
            match function.kind {
                FunctionKind::Controlled
                | FunctionKind::Out
                | FunctionKind::Monitored
                | FunctionKind::Shared => {
                    is_declared = true;
                    self.declare(machine, program, id, function, word)?;
                }
                FunctionKind::Fixed => is_fixed = true,
                FunctionKind::Local => {}
            }
        }
        if is_declared {
            return Ok(());
        }
        Err(if is_fixed {
            format!(
                "`{word}` of `{}` is static or derived: write its definition in place of it",
                known.name
            )
        } else {
            format!("`{}` declares no function `{word}`", known.name)
        })
    }

    fn declare(
        &mut self,
        machine: usize,
        program: &Program,
        id: FunctionId,
        function: &Function,
        word: &str,
    ) -> Result<(), String> {
        if self.observed.contains_key(&(machine, id)) {
            return Ok(());
        }
        let parameters = function.parameters.iter();
        let parameters = parameters.map(|shape| self.domain(program, shape));
        let parameters = parameters.collect::<Result<Vec<String>, String>>()?;
        let codomain = self.domain(program, &function.codomain)?;
        let name = format!(
            "{}_{word}",
            self.prefixes.get(machine).map_or("", |it| it.as_str())
        );
        let domain = match parameters.as_slice() {
            [] => String::new(),
            [only] => format!("{only} -> "),
            several => format!("Prod({}) -> ", several.join(", ")),
        };
        self.functions
            .push(format!("monitored {name}: {domain}{codomain}"));
        let arity = parameters.len();
        self.observed
            .insert((machine, id), ObservedFunction { name, arity });
        Ok(())
    }

    /// The text of a domain.
    fn domain(&mut self, program: &Program, shape: &ValueShape) -> Result<String, String> {
        Ok(match shape {
            ValueShape::Bool => "Boolean".to_owned(),
            ValueShape::Int => "Integer".to_owned(),
            ValueShape::Natural => "Natural".to_owned(),
            ValueShape::Real => "Real".to_owned(),
            ValueShape::Char => "Char".to_owned(),
            ValueShape::Text => "String".to_owned(),
            ValueShape::Complex => "Complex".to_owned(),
            ValueShape::Rule | ValueShape::Any => {
                return Err("its values are rules, or of any domain".to_owned());
            }
            ValueShape::Domain(domain) => self.declared(program, *domain)?,
            ValueShape::Tuple(items) => {
                let items = items.iter().map(|it| self.domain(program, it));
                let items = items.collect::<Result<Vec<String>, String>>()?;
                format!("Prod({})", items.join(", "))
            }
            ValueShape::Seq(item) => format!("Seq({})", self.domain(program, item)?),
            ValueShape::Set(item) => format!("Powerset({})", self.domain(program, item)?),
            ValueShape::Bag(item) => format!("Bag({})", self.domain(program, item)?),
            ValueShape::Map(key, content) => format!(
                "Map({}, {})",
                self.domain(program, key)?,
                self.domain(program, content)?
            ),
        })
    }

    /// The name of a declared domain. Equal domains of several machines are one.
    fn declared(&mut self, program: &Program, domain: DomainId) -> Result<String, String> {
        let name = program.symbols.domains.get(domain.0 as usize);
        let name = name.map_or_else(String::new, ToString::to_string);
        let Some(known) = program.domains.get(domain.0 as usize) else {
            return Err(format!("the elements of `{name}` are not declared"));
        };
        if known.grows {
            return Err(format!(
                "`{name}` grows, and its new elements have no names"
            ));
        }
        let content = match known.elements {
            DomainElements::Ints { low, high } => DomainContent::Integers(low, high),
            DomainElements::Atoms { .. }
            | DomainElements::Computed(_)
            | DomainElements::Undefined
            | DomainElements::Open => {
                let atoms = atoms_of(program, domain);
                let atoms = atoms.and_then(|atoms| program.symbols.atoms.get(atoms));
                match atoms {
                    Some([]) => return Ok("Integer".to_owned()),
                    Some(atoms) => {
                        DomainContent::Elements(atoms.iter().map(ToString::to_string).collect())
                    }
                    None => return Err(format!("the elements of `{name}` are not declared")),
                }
            }
        };
        for known in &self.domains {
            if known.content == content && known.name == name {
                return Ok(name);
            }
            if let (DomainContent::Elements(own), DomainContent::Elements(other)) =
                (&content, &known.content)
            {
                if own == other {
                    return Ok(known.name.clone());
                }
                let own: BTreeSet<&String> = own.iter().collect();
                if let Some(shared) = other.iter().find(|it| own.contains(it)) {
                    return Err(format!(
                        "`{shared}` is an element of two different domains, `{}` and `{name}`",
                        known.name
                    ));
                }
            }
            if known.name == name {
                return Err(format!(
                    "the machines have different domains called `{name}`"
                ));
            }
        }
        self.domains.push(ObservedDomain {
            name: name.clone(),
            content,
        });
        Ok(name)
    }

    /// The text of the specification.
    fn text(&self) -> String {
        let mut signature = Vec::new();
        let mut definitions = Vec::new();
        for ObservedDomain { name, content } in &self.domains {
            match content {
                DomainContent::Integers(low, high) => {
                    signature.push(format!("domain {name} subsetof Integer"));
                    definitions.push(format!("domain {name} = {{{low}:{high}}}"));
                }
                DomainContent::Elements(elements)
                    if elements
                        .iter()
                        .all(|it| it.starts_with(|sign: char| sign.is_uppercase())) =>
                {
                    signature.push(format!("enum domain {name} = {{{}}}", elements.join(" | ")));
                }
                DomainContent::Elements(elements) => {
                    signature.push(format!("abstract domain {name}"));
                    let constants = elements.iter();
                    signature.extend(constants.map(|it| format!("static {it}: {name}")));
                }
            }
        }
        signature.extend(self.functions.iter().cloned());
        format!(
            "asm observer\nimport StandardLibrary\nimport CTLLibrary\nimport LTLLibrary\nsignature:\n{}\ndefinitions:\n{}\nmain rule r_Main = skip\n",
            signature.join("\n"),
            definitions.join("\n"),
        )
    }
}

fn declared_as(program: &Program, name: &str, arity: usize) -> Option<FunctionId> {
    let mut functions = own_functions(program);
    let found = functions.find(|(id, function)| {
        let known = program.symbols.functions.get(id.0 as usize);
        function.parameters.len() == arity && known.is_some_and(|known| **known == *name)
    });
    found.map(|(id, _)| id)
}

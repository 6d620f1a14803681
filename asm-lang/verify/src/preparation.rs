//! Properties as formulas: the terms of a specification, and those from outside, become conditions and formulas.

use crate::codes::m003::NoTemporalFormula;
use crate::explore::Conditions;
use crate::final_states;
use crate::formula::{Formula, FormulaProblem, Formulas, NoFormula};
use crate::hints::{self, KnownNames};
use crate::inputs::MAX_VALUES;
use crate::logic::FairnessFormula;
use crate::observer::ObserverMachine;
use crate::operator::{Logic, TemporalFunctions};
use crate::options::Options;
use crate::property::PropertyKind;
use crate::qualifier::{qualifiers, unqualified};
use crate::reads::{InputFunctions, Reads};
use crate::system::{InputSources, VerifiedMachine};
use crate::transition::ConditionTerm;
use asmotion_diagnostics::{Finding, Sources, Span};
use asmotion_lang::hir::{
    Expression, FunctionId, Invariant, Model, PropertyLogic, TemporalProperty, Term, TermKind,
};
use asmotion_lang::{Diagnostic, Machine, Report, Specification};
use std::collections::{BTreeMap, BTreeSet};

/// A property that is to be checked.
pub(crate) struct Property {
    pub kind: PropertyKind,
    /// Index of the machine in whose specification the property is.
    pub machine: usize,
    pub name: Option<String>,
    pub text: String,
    pub place: Option<Span>,
    pub formula: Formula,
    /// Conditions that are antecedents of implications.
    pub antecedents: Vec<usize>,
    /// The inputs that it mentions.
    pub inputs: InputFunctions,
    /// Conditions that read these inputs, and those that all properties share, where its own conditions may not need them.
    pub mentions: Vec<usize>,
}

/// Everything that the properties of a specification consist of.
#[derive(Default)]
pub(crate) struct Prepared {
    /// See [`Options::checked_constraints`].
    pub checked_constraints: Vec<String>,
    pub properties: Vec<Property>,
    pub fairness: Vec<FairnessFormula>,
    /// `true` if only some paths are considered.
    pub has_fairness: bool,
    /// `true` if there can be several initial states.
    pub has_several_starts: bool,
    /// The inputs that fairness constraints and assumptions mention.
    pub common_inputs: InputFunctions,
    /// The inputs that conditions of accepted ends mention.
    pub end_inputs: InputFunctions,
    pub conditions: Conditions,
    /// Texts of the conditions.
    pub texts: Vec<String>,
    pub assumptions: Vec<String>,
    /// Conditions of the states in which nothing needs to change any more.
    pub ends: Vec<Formula>,
}

/// Turns the properties of all machines into conditions and formulas, and removes them from the specifications.
///
/// # Errors
/// A property is no formula: the index of the machine, and a report.
pub(crate) fn prepare(
    machines: &mut [VerifiedMachine],
    options: &Options,
    sources: &InputSources,
    observer: &ObserverMachine,
) -> Result<Prepared, (usize, Report)> {
    let mut declared = Vec::new();
    for machine in machines.iter_mut() {
        let model = &mut machine.specification.model;
        let invariants = std::mem::take(&mut model.invariants);
        declared.push((invariants, std::mem::take(&mut model.properties)));
    }
    for (index, machine) in machines.iter_mut().enumerate() {
        machine.specification.lower().map_err(|it| (index, it))?;
    }
    let invariants = declared.iter().flat_map(|(invariants, _)| invariants);
    let properties = declared.iter().flat_map(|(_, properties)| properties);
    let named = invariants.map(|it| it.name.to_string());
    let named = named.chain(properties.filter_map(|it| it.name.as_ref().map(ToString::to_string)));
    let mut given = given(machines, options, observer, &named.collect::<Vec<String>>())?;
    let mut prepared = Prepared {
        checked_constraints: options.checked_constraints.clone(),
        ..Prepared::default()
    };
    for (index, (invariants, properties)) in declared.into_iter().enumerate() {
        let Some(machine) = machines.get_mut(index) else {
            continue;
        };
        let of_machine = given.extract_if(.., |term| term.machine == index);
        let terms: Vec<GivenTerm> = of_machine.collect();
        let inputs = sources.get(index).into_iter().flat_map(|it| it.keys());
        let provided = inputs.map(|id| FunctionId(id.0)).collect();
        let specification = &mut machine.specification;
        prepared = prepared
            .with(
                index,
                specification,
                invariants,
                &properties,
                terms,
                &provided,
            )
            .map_err(|report| (index, report))?;
    }
    Ok(prepared)
}

impl Prepared {
    /// Adds the properties of a machine.
    fn with(
        self,
        index: usize,
        specification: &mut Specification,
        invariants: Vec<Invariant>,
        declared: &[TemporalProperty],
        given: Vec<GivenTerm>,
        provided: &BTreeSet<FunctionId>,
    ) -> Result<Self, Report> {
        let machine = specification
            .machine()
            .map_err(|fault| report_of(specification.explain(&fault)))?;
        let first_condition = self.conditions.terms.len();
        let mut preparation = Preparation {
            index,
            provided,
            prepared: self,
            formulas: Formulas {
                temporal: TemporalFunctions::of(&specification.model),
                model: &mut specification.model,
                machine: &machine,
                first_condition,
                conditions: Vec::new(),
                places: Vec::new(),
            },
            sources: &specification.sources,
            report: Report::new(),
        };
        for invariant in invariants {
            preparation.invariant(invariant);
        }
        for property in declared {
            preparation.declared(property);
        }
        for term in given {
            preparation.given(term);
        }
        preparation.mentions(&machine);
        let Preparation {
            mut prepared,
            formulas,
            report,
            ..
        } = preparation;
        let terms = formulas.conditions.into_iter();
        prepared
            .conditions
            .terms
            .extend(terms.map(|term| ConditionTerm {
                machine: index,
                term,
            }));
        let places = formulas.places.iter();
        prepared
            .texts
            .extend(places.map(|place| text_of(&specification.sources, *place)));
        if report.has_errors() {
            return Err(report.finish());
        }
        specification.lower_covered()?;
        Ok(prepared)
    }
}

/// Returns the text of a place on one line.
pub(crate) fn text_of(sources: &Sources, place: Span) -> String {
    let words: Vec<&str> = sources.snippet(place).split_whitespace().collect();
    words.join(" ")
}

/// Returns the texts of the constraints (`INVAR`) of a specification that read functions updated by rules and no inputs. A run
/// does not keep to them, so a property that holds under them alone says nothing about it.
pub fn state_constraints(model: &Model, sources: &Sources) -> Vec<String> {
    let constraints = model.properties.iter();
    let constraints = constraints.filter(|it| it.logic == PropertyLogic::Constraint);
    let terms = constraints.flat_map(|constraint| &constraint.formulas);
    let of_state = terms.filter(|term| {
        let reads = Reads::of(model, &term.root, &BTreeSet::new());
        reads.state && !reads.inputs
    });
    of_state
        .map(|term| text_of(sources, term.root.span))
        .collect()
}

/// The use of a term from outside.
#[derive(Clone, Copy)]
enum GivenUse {
    Property,
    Possible,
    Assumption,
    Ends,
}

/// A term from outside, resolved.
struct GivenTerm {
    /// Index of the machine in whose specification it is resolved.
    machine: usize,
    usage: GivenUse,
    text: String,
    term: Expression,
}

/// Resolves the terms from outside. In a system of several machines, a term belongs to the machine that it names, as in
/// `courier.mode = ASKING`, to the observer if it names several, or else to the first one in which it can be resolved.
fn given(
    machines: &mut [VerifiedMachine],
    options: &Options,
    observer: &ObserverMachine,
    properties: &[String],
) -> Result<Vec<GivenTerm>, (usize, Report)> {
    let with = |usage: GivenUse, texts: &[String]| -> Vec<(GivenUse, String)> {
        texts.iter().map(|text| (usage, text.clone())).collect()
    };
    let mut all = with(GivenUse::Property, &options.properties);
    all.extend(with(GivenUse::Possible, &options.possible));
    all.extend(with(GivenUse::Assumption, &options.assumptions));
    let ends: Vec<String> = options.ends.iter().cloned().collect();
    all.extend(with(GivenUse::Ends, &ends));
    let names: Vec<String> = machines.iter().map(|it| it.name.clone()).collect();
    let known = KnownNames {
        machines: &names,
        properties,
    };
    let mut resolved = Vec::new();
    for (usage, text) in all {
        let term = resolve(machines, &names, observer, usage, text.clone());
        resolved.push(
            term.map_err(|(index, report)| (index, known.hinted(report, &text, index, machines)))?,
        );
    }
    for (index, machine) in machines.iter_mut().enumerate() {
        if let Some(text) = final_states::condition(&machine.specification) {
            let term = add(&mut machine.specification, &text).map_err(|it| (index, it))?;
            resolved.push(GivenTerm {
                machine: index,
                usage: GivenUse::Ends,
                text,
                term,
            });
        }
    }
    Ok(resolved)
}

/// Resolves a term in the machine that it belongs to.
fn resolve(
    machines: &mut [VerifiedMachine],
    names: &[String],
    observer: &ObserverMachine,
    usage: GivenUse,
    text: String,
) -> Result<GivenTerm, (usize, Report)> {
    let named = if names.len() > 1 {
        qualifiers(&text, names)
    } else {
        Vec::new()
    };
    let observed = observer.machine.zip(observer.terms.get(&text));
    let candidates: Vec<usize> = match (observed, named.as_slice()) {
        (Some((machine, _)), _) => vec![machine],
        (None, []) => (0..machines.len()).collect(),
        (None, named) => named.to_vec(),
    };
    let mut problem = None;
    for index in candidates {
        let Some(machine) = machines.get_mut(index) else {
            continue;
        };
        let own = match (observed, names.get(index)) {
            (Some((_, own)), _) => own.clone(),
            (None, Some(name)) if !named.is_empty() => unqualified(&text, name),
            (None, Some(_) | None) => text.clone(),
        };
        match add(&mut machine.specification, &own) {
            Ok(term) => {
                return Ok(GivenTerm {
                    machine: index,
                    usage,
                    text,
                    term,
                });
            }
            Err(report) => problem = problem.or(Some((index, report))),
        }
    }
    Err(problem.unwrap_or_default())
}

/// Adds a term to a specification and resolves it.
pub(crate) fn add(specification: &mut Specification, text: &str) -> Result<Expression, Report> {
    // texts with the same path are one source
    let sources = &mut specification.sources;
    let numbered = (2..).map(|number: usize| format!("<property {number}>"));
    let mut paths = std::iter::once("<property>".to_owned()).chain(numbered);
    let path = paths.find(|path| sources.find(path).is_none());
    let file = sources.add(&path.unwrap_or_default(), text);
    let term = asmotion_lang::syntax::parse_term(file, text)?;
    while let Err(report) = specification.model.add_condition(&term, "a property") {
        // operators are available in properties from outside, whatever the specification imports
        let library = hints::missing_library(&report, &specification.sources);
        if !library.is_some_and(|it| specification.offer_library(it)) {
            return Err(report);
        }
    }
    let added = specification.model.added.terms.pop();
    added.ok_or_else(Report::new)
}

/// The translation of all properties.
struct Preparation<'a> {
    /// Index of the machine.
    index: usize,
    /// Monitored functions that another machine updates.
    provided: &'a BTreeSet<FunctionId>,
    prepared: Prepared,
    formulas: Formulas<'a>,
    sources: &'a Sources,
    report: Report,
}

impl Preparation<'_> {
    fn text(&self, place: Span) -> String {
        text_of(self.sources, place)
    }

    /// An invariant that depends on inputs alone is an assumption about them.
    fn invariant(&mut self, invariant: Invariant) {
        let root = invariant.condition.root;
        let text = self.text(root.span);
        if let Some(logic) = self.formulas.logic(&root) {
            let problem = NoFormula {
                at: root.span,
                problem: FormulaProblem::Invariant(logic),
            };
            self.report.push(NoTemporalFormula { problem }.diagnostic());
            return;
        }
        let reads = Reads::of(self.formulas.model, &root, self.provided);
        let place = invariant.span;
        let antecedents = self.formulas.antecedents(&root);
        let formula = self.formulas.condition(root, invariant.condition.variables);
        let inputs = reads.input_functions.iter();
        let inputs = inputs.map(|function| (self.index, *function)).collect();
        if reads.inputs && !reads.state {
            self.prepared.common_inputs.extend(inputs);
            self.assume(formula, text);
            return;
        }
        let name = (*invariant.name != *text).then(|| invariant.name.to_string());
        self.prepared.properties.push(Property {
            kind: PropertyKind::Invariant,
            machine: self.index,
            name,
            text,
            place: Some(place),
            formula,
            antecedents,
            inputs,
            mentions: Vec::new(),
        });
    }

    /// A constraint is an assumption, unless it is to be checked.
    fn constraint(&mut self, term: &Expression) {
        let text = self.text(term.root.span);
        if !self.prepared.checked_constraints.contains(&text) {
            let formula = self.fair(term);
            return self.assume(formula, text);
        }
        let inputs = self.inputs(&term.root);
        let antecedents = self.formulas.antecedents(&term.root);
        let formula = self.plain(term);
        self.prepared.properties.push(Property {
            kind: PropertyKind::Constraint,
            machine: self.index,
            name: None,
            text,
            place: Some(term.root.span),
            formula,
            antecedents,
            inputs,
            mentions: Vec::new(),
        });
    }

    /// Lets conditions read the inputs of this machine that properties mention, where that matters: an operand or a part of a term is not
    /// evaluated if another one decides.
    fn mentions(&mut self, machine: &Machine) {
        let mut known = BTreeMap::new();
        let common = self.prepared.common_inputs.iter();
        let common = common.filter(|(machine, _)| *machine == self.index);
        let common: InputFunctions = common.copied().collect();
        let mut properties = std::mem::take(&mut self.prepared.properties);
        let own = self.index;
        let may_see = |it: &&mut Property| it.machine == own && it.may_see_inputs();
        for property in properties.iter_mut().filter(may_see) {
            for (_, function) in property.inputs.union(&common) {
                let index = known.entry(*function);
                let index = *index.or_insert_with(|| self.reading(*function, machine));
                property.mentions.extend(index);
            }
        }
        self.prepared.properties = properties;
    }

    /// Adds a condition that reads an input without parameters and with finitely many values; returns its index.
    fn reading(&mut self, function: FunctionId, machine: &Machine) -> Option<usize> {
        let compiled = machine.program().functions.get(function.0 as usize)?;
        machine.elements(&compiled.codomain, MAX_VALUES)?;
        let declared = self.formulas.model.functions.get(function.0 as usize)?;
        if !declared.parameters.is_empty() {
            return None;
        }
        let term = Term {
            kind: Box::new(TermKind::Apply(function, Vec::new())),
            ty: declared.codomain,
            span: declared.span,
        };
        match self.formulas.condition(term, Vec::new()) {
            Formula::Condition(index) => Some(index),
            Formula::Constant(_) | Formula::Apply(..) | Formula::Repeat(..) => None,
        }
    }

    /// Returns the inputs that a term mentions.
    fn inputs(&self, root: &Term) -> InputFunctions {
        let reads = Reads::of(self.formulas.model, root, self.provided);
        let inputs = reads.input_functions.into_iter();
        inputs.map(|function| (self.index, function)).collect()
    }

    /// Translates the condition of a fairness constraint or an assumption.
    fn fair(&mut self, term: &Expression) -> Formula {
        let inputs = self.inputs(&term.root);
        self.prepared.common_inputs.extend(inputs);
        self.plain(term)
    }

    fn assume(&mut self, formula: Formula, text: String) {
        self.prepared.assumptions.push(text);
        match formula {
            Formula::Condition(index) => self.prepared.conditions.assumed.push(index),
            Formula::Constant(_) | Formula::Apply(..) | Formula::Repeat(..) => {}
        }
    }

    fn formula(&mut self, term: &Expression, logic: Logic) -> Option<Formula> {
        match self.formulas.formula(&term.root, &term.variables, logic) {
            Ok(formula) => Some(formula),
            Err(problem) => {
                self.report.push(NoTemporalFormula { problem }.diagnostic());
                None
            }
        }
    }

    /// Translates a formula without temporal operators.
    fn plain(&mut self, term: &Expression) -> Formula {
        if self.formulas.logic(&term.root).is_some() {
            let problem = NoFormula {
                at: term.root.span,
                problem: FormulaProblem::Condition,
            };
            self.report.push(NoTemporalFormula { problem }.diagnostic());
        }
        self.formulas
            .condition(term.root.clone(), term.variables.clone())
    }

    fn declared(&mut self, property: &TemporalProperty) {
        let kind = match (property.logic, property.formulas.as_slice()) {
            (PropertyLogic::Ctl, [_]) => PropertyKind::Ctl,
            (PropertyLogic::Ltl, [_]) => PropertyKind::Ltl,
            (PropertyLogic::Constraint, [term]) => {
                return self.constraint(term);
            }
            (PropertyLogic::Justice, [term]) => {
                let formula = self.fair(term);
                self.prepared
                    .fairness
                    .push(FairnessFormula::Justice(formula));
                return;
            }
            (PropertyLogic::Compassion, [p, q]) => {
                let (p, q) = (self.fair(p), self.fair(q));
                self.prepared
                    .fairness
                    .push(FairnessFormula::Compassion(p, q));
                return;
            }
            _ => return,
        };
        let Some(term) = property.formulas.first() else {
            return;
        };
        let text = self.text(term.root.span);
        let name = property.name.as_ref().map(ToString::to_string);
        self.property(kind, name, text, Some(property.span), term);
    }

    fn given(&mut self, given: GivenTerm) {
        match given.usage {
            // the property of the file with this text is selected instead
            GivenUse::Property if self.has_property(&given.text) => {}
            GivenUse::Property => {
                let kind = match self.formulas.logic(&given.term.root) {
                    Some(Logic::Ctl) => PropertyKind::Ctl,
                    Some(Logic::Ltl) => PropertyKind::Ltl,
                    None => PropertyKind::Invariant,
                };
                self.property(kind, None, given.text, None, &given.term);
            }
            GivenUse::Possible => {
                self.property(PropertyKind::Possible, None, given.text, None, &given.term);
            }
            GivenUse::Assumption => {
                let formula = self.fair(&given.term);
                self.assume(formula, given.text);
            }
            GivenUse::Ends => {
                let inputs = self.inputs(&given.term.root);
                self.prepared.end_inputs.extend(inputs);
                let formula = self.plain(&given.term);
                self.prepared.ends.push(formula);
            }
        }
    }

    fn has_property(&self, text: &str) -> bool {
        self.prepared.properties.iter().any(|it| it.text == text)
    }

    fn property(
        &mut self,
        kind: PropertyKind,
        name: Option<String>,
        text: String,
        place: Option<Span>,
        term: &Expression,
    ) {
        let formula = match kind {
            PropertyKind::Ltl => self.formula(term, Logic::Ltl),
            PropertyKind::Ctl => self.formula(term, Logic::Ctl),
            PropertyKind::Invariant
            | PropertyKind::Constraint
            | PropertyKind::Possible
            | PropertyKind::NoFault
            | PropertyKind::NotStuck
            | PropertyKind::RulesRun => Some(self.plain(term)),
        };
        if let Some(formula) = formula {
            let inputs = self.inputs(&term.root);
            let antecedents = self.formulas.antecedents(&term.root);
            self.prepared.properties.push(Property {
                kind,
                machine: self.index,
                name,
                text,
                place,
                formula,
                antecedents,
                inputs,
                mentions: Vec::new(),
            });
        }
    }
}

/// Returns a report with one finding.
pub(crate) fn report_of(diagnostic: Diagnostic) -> Report {
    let mut report = Report::new();
    report.push(diagnostic);
    report
}

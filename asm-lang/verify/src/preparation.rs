//! Properties as formulas: the terms of a specification, and those from outside, become conditions and formulas.

use crate::codes::m003::NoTemporalFormula;
use crate::codes::m005::ExchangesMessages;
use crate::explore::Conditions;
use crate::final_states;
use crate::formula::{Formula, Formulas, Logic};
use crate::logic::FairnessFormula;
use crate::options::Options;
use crate::property::PropertyKind;
use crate::reads::Reads;
use crate::transition::ConditionTerm;
use asmotion_diagnostics::{Finding, Sources, Span};
use asmotion_lang::hir::{Expression, Invariant, PropertyLogic, TemporalProperty};
use asmotion_lang::{Diagnostic, Report, Specification};

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
}

/// Everything that the properties of a specification consist of.
#[derive(Default)]
pub(crate) struct Prepared {
    pub properties: Vec<Property>,
    pub fairness: Vec<FairnessFormula>,
    pub conditions: Conditions,
    /// Texts of the conditions.
    pub texts: Vec<String>,
    pub assumptions: Vec<String>,
    /// Conditions of the states in which nothing needs to change any more.
    pub ends: Vec<Formula>,
}

/// Turns the properties of a specification into conditions and formulas, and removes them from it.
pub(crate) fn prepare(
    specification: &mut Specification,
    options: &Options,
) -> Result<Prepared, Report> {
    if let Some(message) = asmotion_lang::ir::message_uses(&specification.model).first() {
        return Err(report_of(ExchangesMessages { at: message.at }.diagnostic()));
    }
    let invariants = std::mem::take(&mut specification.model.invariants);
    let declared = std::mem::take(&mut specification.model.properties);
    specification.lower()?;
    let machine = specification
        .machine()
        .map_err(|fault| report_of(specification.explain(&fault)))?;
    let given = given(specification, options)?;
    let mut preparation = Preparation {
        prepared: Prepared::default(),
        formulas: Formulas {
            model: &mut specification.model,
            machine: &machine,
            conditions: Vec::new(),
            places: Vec::new(),
        },
        sources: &specification.sources,
        report: Report::new(),
    };
    for invariant in invariants {
        preparation.invariant(invariant);
    }
    for property in &declared {
        preparation.declared(property);
    }
    for term in given {
        preparation.given(term);
    }
    let Preparation {
        mut prepared,
        formulas,
        report,
        ..
    } = preparation;
    let terms = formulas.conditions.into_iter();
    prepared.conditions.terms = terms
        .map(|term| ConditionTerm { machine: 0, term })
        .collect();
    prepared.texts = formulas
        .places
        .iter()
        .map(|place| text_of(&specification.sources, *place))
        .collect();
    if report.has_errors() {
        return Err(report.finish());
    }
    specification.lower_covered()?;
    Ok(prepared)
}

/// Returns the text of a place on one line.
fn text_of(sources: &Sources, place: Span) -> String {
    let words: Vec<&str> = sources.snippet(place).split_whitespace().collect();
    words.join(" ")
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
    usage: GivenUse,
    text: String,
    term: Expression,
}

/// Resolves the terms from outside.
fn given(specification: &mut Specification, options: &Options) -> Result<Vec<GivenTerm>, Report> {
    let properties = options.properties.iter();
    let properties = properties.map(|text| (GivenUse::Property, text));
    let possible = options
        .possible
        .iter()
        .map(|text| (GivenUse::Possible, text));
    let properties = properties.chain(possible);
    let assumptions = options.assumptions.iter();
    let assumptions = assumptions.map(|text| (GivenUse::Assumption, text));
    let declared = final_states::condition(specification);
    let ends = options.ends.iter().chain(&declared);
    let ends = ends.map(|text| (GivenUse::Ends, text));
    let mut report = Report::new();
    let mut resolved = Vec::new();
    for (usage, text) in properties.chain(assumptions).chain(ends) {
        let file = specification.sources.add("<property>", text.as_str());
        let added = asmotion_lang::syntax::parse_term(file, text)
            .and_then(|term| specification.model.add_condition(&term, "a property"));
        match added {
            Ok(_) => {
                if let Some(term) = specification.model.added.terms.pop() {
                    let text = text.clone();
                    resolved.push(GivenTerm { usage, text, term });
                }
            }
            Err(problems) => report.extend(problems),
        }
    }
    if report.has_errors() {
        Err(report.finish())
    } else {
        Ok(resolved)
    }
}

/// The translation of all properties.
struct Preparation<'a> {
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
        let reads = Reads::of(self.formulas.model, &root);
        let place = invariant.span;
        let antecedents = self.formulas.antecedents(&root);
        let formula = self.formulas.condition(root, invariant.condition.variables);
        if reads.inputs && !reads.state {
            self.assume(formula, text);
            return;
        }
        let name = (*invariant.name != *text).then(|| invariant.name.to_string());
        self.prepared.properties.push(Property {
            kind: PropertyKind::Invariant,
            machine: 0,
            name,
            text,
            place: Some(place),
            formula,
            antecedents,
        });
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
        self.formulas
            .condition(term.root.clone(), term.variables.clone())
    }

    fn declared(&mut self, property: &TemporalProperty) {
        let kind = match (property.logic, property.formulas.as_slice()) {
            (PropertyLogic::Ctl, [_]) => PropertyKind::Ctl,
            (PropertyLogic::Ltl, [_]) => PropertyKind::Ltl,
            (PropertyLogic::Constraint, [term]) => {
                let formula = self.plain(term);
                let text = self.text(term.root.span);
                return self.assume(formula, text);
            }
            (PropertyLogic::Justice, [term]) => {
                let formula = self.plain(term);
                self.prepared
                    .fairness
                    .push(FairnessFormula::Justice(formula));
                return;
            }
            (PropertyLogic::Compassion, [p, q]) => {
                let (p, q) = (self.plain(p), self.plain(q));
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
                let formula = self.plain(&given.term);
                self.assume(formula, given.text);
            }
            GivenUse::Ends => {
                let formula = self.plain(&given.term);
                self.prepared.ends.push(formula);
            }
        }
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
            | PropertyKind::Possible
            | PropertyKind::NoFault
            | PropertyKind::NotStuck
            | PropertyKind::RulesRun => Some(self.plain(term)),
        };
        if let Some(formula) = formula {
            let antecedents = self.formulas.antecedents(&term.root);
            self.prepared.properties.push(Property {
                kind,
                machine: 0,
                name,
                text,
                place,
                formula,
                antecedents,
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

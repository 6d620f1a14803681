//! The syntax of rules.

use super::{Binder, NameText, Term};
use asmotion_diagnostics::Span;

/// A rule with its span.
#[derive(Clone, Debug)]
pub struct Rule {
    /// Form of the rule, with its parts.
    pub kind: Box<RuleKind>,
    /// Span of the rule.
    pub span: Span,
    /// Nesting depth, including terms; 1 for `skip`. Limited by the parser to `MAX_DEPTH`.
    pub depth: u32,
}

/// The forms of a rule.
#[derive(Clone, Debug)]
pub enum RuleKind {
    /// `skip`
    Skip,
    /// An update: `f(t…) := t`, `$v := t`.
    Update {
        /// Left-hand side.
        target: Assignee,
        /// Term for the new value.
        value: Term,
    },
    /// An update to the result of a turbo rule: `f(t…) <- r_x(t…)`.
    Assign {
        /// Left-hand side.
        target: Assignee,
        /// Name of the turbo rule.
        rule: NameText,
        /// Arguments of the turbo rule.
        arguments: Vec<Term>,
    },
    /// A macro call: `r_x[t…]`.
    Macro {
        /// Name of the rule.
        name: NameText,
        /// Arguments, passed by name.
        arguments: Vec<Term>,
    },
    /// A turbo rule call: `r_x(t…)`.
    Turbo {
        /// Name of the rule.
        name: NameText,
        /// Arguments, passed by value.
        arguments: Vec<Term>,
    },
    /// A term whose value is a rule: `program($a)`, `$r[t…]`.
    Term {
        /// Term for the rule: a location, variable or function application.
        term: Term,
        /// Arguments in brackets; empty without brackets.
        arguments: Vec<Term>,
    },
    /// `par … endpar`
    Par(Vec<Rule>),
    /// `seq … endseq`
    Seq(Vec<Rule>),
    /// `if g then R else S endif`
    If {
        /// Guard, a Boolean term.
        guard: Term,
        /// Rule for a true guard.
        then: Rule,
        /// Rule for a false guard; `None` stands for `skip`.
        otherwise: Option<Rule>,
    },
    /// `switch t case c: R … otherwise R endswitch`
    Switch(SwitchRule),
    /// `choose $x in D with g do R ifnone S`
    Choose {
        /// Variables with their ranges.
        binders: Vec<Binder>,
        /// Condition on the candidates; `None` stands for `true`.
        guard: Option<Term>,
        /// Rule for the chosen candidate.
        body: Rule,
        /// Rule for the case that there is no candidate; `None` stands for `skip`.
        ifnone: Option<Rule>,
    },
    /// `forall $x in D with g do R`
    Forall {
        /// Variables with their ranges.
        binders: Vec<Binder>,
        /// Condition on the elements; `None` stands for `true`.
        guard: Option<Term>,
        /// Rule for each element.
        body: Rule,
    },
    /// `let ($x = t, …) in R endlet`
    Let {
        /// Variables with their values, in order; later ones may use earlier ones.
        bindings: Vec<(NameText, Term)>,
        /// Rule in which the variables are visible.
        body: Rule,
    },
    /// `extend D with $x, … do R`
    Extend {
        /// Name of the domain.
        domain: NameText,
        /// One variable for each new element.
        variables: Vec<NameText>,
        /// Rule in which the variables are visible.
        body: Rule,
    },
    /// `while g do R`
    While {
        /// Condition for another iteration.
        guard: Term,
        /// Rule executed in each iteration.
        body: Rule,
    },
    /// `whilerec g do R`
    WhileRec {
        /// Condition for another iteration.
        guard: Term,
        /// Rule executed in each iteration.
        body: Rule,
    },
    /// `iterate R enditerate`
    Iterate(Rule),
    /// `local f: D [R] S`
    Local {
        /// Functions, each with the rule that initialises it.
        functions: Vec<(super::Function, Rule)>,
        /// Rule in which the functions are visible.
        body: Rule,
    },
    /// A rule that could not be parsed; the error was reported.
    Invalid,
}

/// The left-hand side of an update.
#[derive(Clone, Debug)]
pub enum Assignee {
    /// A location: `f(t…)`, `a.f(t…)`.
    Location {
        /// Agent before the dot.
        agent: Option<NameText>,
        /// Name of the function.
        function: NameText,
        /// Arguments; empty without parentheses.
        arguments: Vec<Term>,
        /// Span of the location.
        span: Span,
    },
    /// A parameter or variable: `$v`.
    Variable(NameText),
}

/// The parts of a `switch` rule.
#[derive(Clone, Debug)]
pub struct SwitchRule {
    /// Term that the cases are compared with.
    pub subject: Term,
    /// Cases with their rules, in order.
    pub cases: Vec<(Term, Rule)>,
    /// Rule for the case that no case matches; `None` stands for `skip`.
    pub otherwise: Option<Rule>,
}

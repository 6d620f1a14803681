//! Rules as written.

use super::{Binder, NameText, Term};
use asmotion_diagnostics::Span;

/// A rule and where it stands.
#[derive(Clone, Debug)]
pub struct Rule {
    /// What it is.
    pub kind: Box<RuleKind>,
    /// Where it stands.
    pub span: Span,
    /// How deep it nests, its terms included: 1 for `skip`. The parser bounds it (`MAX_DEPTH`).
    pub depth: u32,
}

/// The forms of a rule.
#[derive(Clone, Debug)]
pub enum RuleKind {
    /// `skip`
    Skip,
    /// `f(t…) := t`, `$v := t`.
    Update {
        /// What is written.
        target: Assignee,
        /// The new value.
        value: Term,
    },
    /// `f(t…) <- r_x(t…)`.
    Assign {
        /// What takes the result.
        target: Assignee,
        /// The turbo rule.
        rule: NameText,
        /// Its arguments.
        arguments: Vec<Term>,
    },
    /// `r_x[t…]`.
    Macro {
        /// The rule.
        name: NameText,
        /// Its arguments.
        arguments: Vec<Term>,
    },
    /// `r_x(t…)`.
    Turbo {
        /// The rule.
        name: NameText,
        /// Its arguments.
        arguments: Vec<Term>,
    },
    /// A term whose value is a rule: `program($a)`, `$r[t…]`.
    Term {
        /// The term.
        term: Term,
        /// The arguments after it.
        arguments: Vec<Term>,
    },
    /// `par … endpar`
    Par(Vec<Rule>),
    /// `seq … endseq`
    Seq(Vec<Rule>),
    /// `if g then R else S endif`
    If {
        /// The guard.
        guard: Term,
        /// What is done where it holds.
        then: Rule,
        /// What is done otherwise.
        otherwise: Option<Rule>,
    },
    /// `switch t case c: R … otherwise R endswitch`
    Switch(SwitchRule),
    /// `choose $x in D with g do R ifnone S`
    Choose {
        /// The variables.
        binders: Vec<Binder>,
        /// The guard; `true` without.
        guard: Option<Term>,
        /// What is done with the choice.
        body: Rule,
        /// What is done where there is none.
        ifnone: Option<Rule>,
    },
    /// `forall $x in D with g do R`
    Forall {
        /// The variables.
        binders: Vec<Binder>,
        /// The guard; `true` without.
        guard: Option<Term>,
        /// What is done for each.
        body: Rule,
    },
    /// `let ($x = t, …) in R endlet`
    Let {
        /// The bindings, in order.
        bindings: Vec<(NameText, Term)>,
        /// What is done with them.
        body: Rule,
    },
    /// `extend D with $x, … do R`
    Extend {
        /// The domain.
        domain: NameText,
        /// One variable a new element.
        variables: Vec<NameText>,
        /// What is done with them.
        body: Rule,
    },
    /// `while g do R`
    While {
        /// The guard.
        guard: Term,
        /// What is repeated.
        body: Rule,
    },
    /// `whilerec g do R`
    WhileRec {
        /// The guard.
        guard: Term,
        /// What is repeated.
        body: Rule,
    },
    /// `iterate R enditerate`
    Iterate(Rule),
    /// `local f: D [R] S`
    Local {
        /// The functions, each with the rule that initialises it.
        functions: Vec<(super::Function, Rule)>,
        /// What is done with them.
        body: Rule,
    },
    /// What could not be parsed; an error was reported.
    Invalid,
}

/// What an update writes.
#[derive(Clone, Debug)]
pub enum Assignee {
    /// `f(t…)`, `a.f(t…)`.
    Location {
        /// The agent before the point.
        agent: Option<NameText>,
        /// The function.
        function: NameText,
        /// The arguments.
        arguments: Vec<Term>,
        /// All of it.
        span: Span,
    },
    /// `$v`: a parameter that stands for a location.
    Variable(NameText),
}

/// The parts of `switch`.
#[derive(Clone, Debug)]
pub struct SwitchRule {
    /// What is compared.
    pub subject: Term,
    /// The cases, in order.
    pub cases: Vec<(Term, Rule)>,
    /// What is done where no case matches.
    pub otherwise: Option<Rule>,
}

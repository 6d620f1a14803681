//! The syntax of scenarios (Avalla): commands for a specification, and checks of its states.

use super::{Assignee, NameText, Rule, Term};
use asmotion_diagnostics::Span;

/// The contents of a scenario file.
#[derive(Clone, Debug, Default)]
pub struct Scenario {
    /// Name after `scenario`; `None` if the heading is missing.
    pub name: Option<NameText>,
    /// Path of the specification, after `load`; `None` if the command is missing.
    pub load: Option<NameText>,
    /// Conditions that must hold in the initial state and after every step.
    pub invariants: Vec<ScenarioInvariant>,
    /// Commands, in order.
    pub commands: Vec<ScenarioCommand>,
}

/// `invariant NAME : term;`
#[derive(Clone, Debug)]
pub struct ScenarioInvariant {
    /// Name of the invariant.
    pub name: NameText,
    /// Boolean term, resolved in the scope of the specification.
    pub condition: Term,
}

/// A command of a scenario.
#[derive(Clone, Debug)]
pub struct ScenarioCommand {
    /// Form of the command, with its parts.
    pub kind: ScenarioCommandKind,
    /// Span of the command.
    pub span: Span,
}

/// The forms of a command.
#[derive(Clone, Debug)]
pub enum ScenarioCommandKind {
    /// `set location := term;`
    Set(Assignee, Term),
    /// `check term;`
    Check(Term),
    /// `step`
    Step,
    /// `step until term;`
    StepUntil(Term),
    /// `exec rule;`
    Exec(Rule),
    /// `pick $x in r_rule := term;`
    Pick(Pick),
    /// `begin NAME … end`
    Block(ScenarioBlock),
    /// `execblock scenario:block;`
    ExecBlock {
        /// Scenario that contains the block; `None` for this one.
        scenario: Option<NameText>,
        /// Name of the block.
        block: NameText,
    },
}

/// `pick`: determines the value that a `choose` takes in the next step.
#[derive(Clone, Debug)]
pub struct Pick {
    /// Variable of the `choose`, including its `$`.
    pub variable: NameText,
    /// Rule that contains the `choose`; `None` for a `choose` in any rule.
    pub rule: Option<PickedRule>,
    /// Term for the value.
    pub value: Term,
}

/// A rule, with the domains of its parameters to distinguish overloads.
#[derive(Clone, Debug)]
pub struct PickedRule {
    /// Name of the rule.
    pub name: NameText,
    /// Domains of the parameters; `None` if not given.
    pub parameters: Option<Vec<NameText>>,
}

/// A named block of commands: `begin NAME … end`.
#[derive(Clone, Debug)]
pub struct ScenarioBlock {
    /// Name of the block.
    pub name: NameText,
    /// Commands, in order.
    pub commands: Vec<ScenarioCommand>,
}

impl Scenario {
    /// Returns the block with a name, nested blocks included.
    pub fn block(&self, name: &str) -> Option<&ScenarioBlock> {
        self.blocks()
            .into_iter()
            .find(|block| &*block.name.text == name)
    }

    /// Returns all blocks, outer ones before those nested in them.
    pub fn blocks(&self) -> Vec<&ScenarioBlock> {
        fn add<'a>(commands: &'a [ScenarioCommand], to: &mut Vec<&'a ScenarioBlock>) {
            for command in commands {
                if let ScenarioCommandKind::Block(block) = &command.kind {
                    to.push(block);
                    add(&block.commands, to);
                }
            }
        }
        let mut blocks = Vec::new();
        add(&self.commands, &mut blocks);
        blocks
    }
}

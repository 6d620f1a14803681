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
    /// The condition.
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
    /// The rule its `choose` stands in, where it is said.
    pub rule: Option<PickedRule>,
    /// The value.
    pub value: Term,
}

/// A rule, told from others of its name by its parameters' domains.
#[derive(Clone, Debug)]
pub struct PickedRule {
    /// Its name.
    pub name: NameText,
    /// The domains of its parameters, where they are said.
    pub parameters: Option<Vec<NameText>>,
}

/// Commands with a name.
#[derive(Clone, Debug)]
pub struct ScenarioBlock {
    /// The name.
    pub name: NameText,
    /// The commands.
    pub commands: Vec<ScenarioCommand>,
}

impl Scenario {
    /// The block of a name, wherever it stands.
    pub fn block(&self, name: &str) -> Option<&ScenarioBlock> {
        self.blocks()
            .into_iter()
            .find(|block| &*block.name.text == name)
    }

    /// All blocks, outer ones before those in them.
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

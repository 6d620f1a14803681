//! Scenarios (Avalla): what is done to a specification, and what is expected of it.

use super::{Assignee, Name, Rule, Term};
use asmotion_diagnostics::Span;

/// A scenario file.
#[derive(Clone, Debug, Default)]
pub struct Scenario {
    /// The name after `scenario`.
    pub name: Option<Name>,
    /// The path after `load`.
    pub load: Option<Name>,
    /// What must hold after every step.
    pub invariants: Vec<ScenarioInvariant>,
    /// The commands, in order.
    pub commands: Vec<Command>,
}

/// `invariant NAME : term;`
#[derive(Clone, Debug)]
pub struct ScenarioInvariant {
    /// Its name.
    pub name: Name,
    /// The condition.
    pub condition: Term,
}

/// A command of a scenario.
#[derive(Clone, Debug)]
pub struct Command {
    /// What it is.
    pub kind: CommandKind,
    /// Where it stands.
    pub span: Span,
}

/// The forms of a command.
#[derive(Clone, Debug)]
pub enum CommandKind {
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
    Block(Block),
    /// `execblock scenario:block;`
    ExecBlock {
        /// The scenario the block stands in; this one where it is left out.
        scenario: Option<Name>,
        /// The block.
        block: Name,
    },
}

/// Which value a `choose` takes in the next step.
#[derive(Clone, Debug)]
pub struct Pick {
    /// The variable.
    pub variable: Name,
    /// The rule its `choose` stands in, where it is said.
    pub rule: Option<PickedRule>,
    /// The value.
    pub value: Term,
}

/// A rule, told from others of its name by its parameters' domains.
#[derive(Clone, Debug)]
pub struct PickedRule {
    /// Its name.
    pub name: Name,
    /// The domains of its parameters, where they are said.
    pub parameters: Option<Vec<Name>>,
}

/// Commands with a name.
#[derive(Clone, Debug)]
pub struct Block {
    /// The name.
    pub name: Name,
    /// The commands.
    pub commands: Vec<Command>,
}

impl Scenario {
    /// The block of a name, wherever it stands.
    pub fn block(&self, name: &str) -> Option<&Block> {
        self.blocks()
            .into_iter()
            .find(|block| &*block.name.text == name)
    }

    /// All blocks, outer ones before those in them.
    pub fn blocks(&self) -> Vec<&Block> {
        fn add<'a>(commands: &'a [Command], to: &mut Vec<&'a Block>) {
            for command in commands {
                if let CommandKind::Block(block) = &command.kind {
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

//! Scenarios (Avalla): what is done to a specification, and what is expected of it.

use super::{Assignee, NameText, Rule, Term};
use asmotion_diagnostics::Span;

/// A scenario file.
#[derive(Clone, Debug, Default)]
pub struct Scenario {
    /// The name after `scenario`.
    pub name: Option<NameText>,
    /// The path after `load`.
    pub load: Option<NameText>,
    /// What must hold after every step.
    pub invariants: Vec<ScenarioInvariant>,
    /// The commands, in order.
    pub commands: Vec<ScenarioCommand>,
}

/// `invariant NAME : term;`
#[derive(Clone, Debug)]
pub struct ScenarioInvariant {
    /// Its name.
    pub name: NameText,
    /// The condition.
    pub condition: Term,
}

/// A command of a scenario.
#[derive(Clone, Debug)]
pub struct ScenarioCommand {
    /// What it is.
    pub kind: ScenarioCommandKind,
    /// Where it stands.
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
        /// The scenario the block stands in; this one where it is left out.
        scenario: Option<NameText>,
        /// The block.
        block: NameText,
    },
}

/// Which value a `choose` takes in the next step.
#[derive(Clone, Debug)]
pub struct Pick {
    /// The variable.
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

//! The syntax of scenarios (Avalla): commands for a specification, and checks of its states.

use super::{Assignee, NameText, Rule, Term};
use asmotion_diagnostics::Span;
use std::collections::BTreeSet;
use std::sync::Arc;

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
    /// Divides `execblock scenario.block`, the old notation of `scenario:block`, at its last point,
    /// except where a block of this scenario has the whole name.
    pub(crate) fn split_qualified_blocks(&mut self) {
        fn split(commands: &mut [ScenarioCommand], own: &BTreeSet<Arc<str>>) {
            for command in commands {
                match &mut command.kind {
                    ScenarioCommandKind::Block(block) => split(&mut block.commands, own),
                    ScenarioCommandKind::ExecBlock {
                        scenario: scenario @ None,
                        block,
                    } if !own.contains(&block.text) => {
                        if let Some((first, second)) = divided(block) {
                            (*scenario, *block) = (Some(first), second);
                        }
                    }
                    ScenarioCommandKind::ExecBlock { .. }
                    | ScenarioCommandKind::Set(..)
                    | ScenarioCommandKind::Check(_)
                    | ScenarioCommandKind::Step
                    | ScenarioCommandKind::StepUntil(_)
                    | ScenarioCommandKind::Exec(_)
                    | ScenarioCommandKind::Pick(_) => {}
                }
            }
        }
        let own: BTreeSet<Arc<str>> = self
            .blocks()
            .into_iter()
            .map(|block| block.name.text.clone())
            .collect();
        split(&mut self.commands, &own);
    }
}

/// Divides a name at its last point into two names, neither of them empty.
fn divided(name: &NameText) -> Option<(NameText, NameText)> {
    let (first, second) = name.text.rsplit_once('.')?;
    let part = |text: &str, span: Span| {
        (!text.is_empty()).then(|| NameText {
            text: Arc::from(text),
            span,
        })
    };
    let point = name.span.range().start + first.len();
    Some((
        part(
            first,
            Span::new(name.span.file, name.span.range().start, point),
        )?,
        part(
            second,
            Span::new(name.span.file, point + 1, name.span.range().end),
        )?,
    ))
}

//! Runs through states that stand for others: the bytes of a node's state are not kept, or are those of one of several states that
//! permutations of elements make of each other.
//!
//! Such a run is found by executing it from the initial state. Each step is the first one that leads to a state for which the next node
//! stands. It exists, since a node's successors stand for those of all states that it stands for. A path that returns to a node may
//! have reached another state than before; the cycle is then repeated until a state recurs.

use crate::counterexample::{NodePath, Replay};
use crate::decisions::{Decision, Decisions};
use crate::fair_moves::{CountsBefore, MovedSet};
use crate::transition::TransitionSystem;

/// Limit for the repetitions of a cycle.
const MAX_ROUNDS: usize = 1 << 12;

/// Limit for the executions of a step.
const MAX_EXECUTIONS: u32 = 1 << 20;

/// A run in progress.
struct ConcreteRun<'r, 'a, S> {
    replay: &'r Replay<'a, S>,
    system: S,
    /// The bytes of its state.
    state: Vec<u8>,
    path: NodePath,
}

impl<S: TransitionSystem> Replay<'_, S> {
    /// Returns a path through the same nodes, of which each step is known; the cycle may be longer. `None` if there is none, because
    /// a state was taken for another one.
    pub fn concrete(&self, path: &NodePath) -> Option<NodePath> {
        let mut system = self.system.clone();
        system.keep_candidates();
        let mut run = ConcreteRun {
            replay: self,
            system,
            state: Vec::new(),
            path: NodePath::default(),
        };
        let (first, rest) = path.nodes.split_first()?;
        run.begin(*first)?;
        let until = path.cycle.unwrap_or(rest.len());
        for (index, node) in rest.iter().enumerate().take(until) {
            run.go_to(*node, path.moved.get(index).copied())?;
        }
        if let Some(cycle) = path.cycle {
            run.repeat(path, cycle)?;
        }
        if let Some(failing) = &path.failing {
            run.path.failing = Some(run.failing(path, failing)?);
        }
        Some(run.path)
    }
}

impl<S: TransitionSystem> ConcreteRun<'_, '_, S> {
    /// Returns `true` if a node stands for the state in which the system is.
    fn is_at(&mut self, node: u32, packed: &mut Vec<u8>) -> bool {
        packed.clear();
        self.system.pack(packed);
        let exploration = self.replay.exploration;
        let number = exploration.number_of(&self.system, packed);
        number.is_some() && number == exploration.state_number(node)
    }

    /// Enters the initial state for which a node stands.
    fn begin(&mut self, node: u32) -> Option<()> {
        let mut before = Vec::new();
        self.system.pack(&mut before);
        let decisions = Decisions::default();
        let mut packed = Vec::new();
        loop {
            if self.system.begin(&decisions).is_ok() && self.is_at(node, &mut packed) {
                self.state = packed;
                self.path.nodes.push(node);
                return Some(());
            }
            if !decisions.advance() {
                return None;
            }
            self.system.restore(&before);
        }
    }

    /// Takes the first step to a state for which a node stands.
    fn go_to(&mut self, node: u32, wanted: Option<MovedSet>) -> Option<()> {
        let from = *self.path.nodes.last()?;
        let (exploration, fair) = (self.replay.exploration, self.replay.fair);
        let decisions = Decisions::default();
        let mut counts = CountsBefore::default();
        let mut packed = Vec::new();
        for _ in 0..MAX_EXECUTIONS {
            self.system.restore(&self.state);
            fair.before(&self.system, &mut counts);
            let done = self.system.step(&decisions, exploration.inputs(from));
            if done.is_ok() && self.is_at(node, &mut packed) {
                let moved = fair.moved(&self.system, &counts, packed != self.state);
                if wanted.is_none_or(|wanted| wanted == moved) {
                    self.state = packed;
                    self.path.nodes.push(node);
                    self.path.decisions.push(decisions.taken());
                    self.path.moved.push(moved);
                    return Some(());
                }
            }
            if !decisions.advance() {
                return None;
            }
        }
        None
    }

    /// Repeats the cycle of a path until a state recurs.
    fn repeat(&mut self, path: &NodePath, cycle: usize) -> Option<()> {
        let first = *path.nodes.get(cycle)?;
        let mut starts = vec![self.state.clone()];
        for _ in 0..MAX_ROUNDS {
            for (index, node) in path.nodes.iter().enumerate().skip(cycle + 1) {
                self.go_to(*node, path.moved.get(index - 1).copied())?;
            }
            self.go_to(first, path.moved.get(path.nodes.len() - 1).copied())?;
            if let Some(known) = starts.iter().position(|it| *it == self.state) {
                // the last node is the one to which it returns
                self.path.nodes.pop();
                let length = path.nodes.len() - cycle;
                self.path.cycle = Some(cycle + known * length);
                return Some(());
            }
            starts.push(self.state.clone());
        }
        None
    }

    /// Returns the decisions of a step that fails as that of the last node of a path does.
    fn failing(&mut self, path: &NodePath, taken: &[Decision]) -> Option<Vec<Decision>> {
        let exploration = self.replay.exploration;
        let node = *path.nodes.last()?;
        let is_it =
            |found: &&crate::explore::FoundFault| found.node == node && found.decisions == taken;
        let wanted = exploration.faults.iter().find(is_it)?;
        let decisions = Decisions::default();
        for _ in 0..MAX_EXECUTIONS {
            self.system.restore(&self.state);
            let done = self.system.step(&decisions, exploration.inputs(node));
            if done.is_err_and(|fault| fault.is_like(&wanted.fault)) {
                return Some(decisions.taken());
            }
            if !decisions.advance() {
                return None;
            }
        }
        None
    }
}

//! Among the runs through layers of nodes, the one that is easiest to read: with the fewest switches between machines or chosen
//! agents, then with the fewest changes of inputs, then with the smallest values.
//!
//! A run through layers takes one move for each pair of consecutive layers. The costs of a move depend on the move before it only,
//! so the best run is found backwards, with the cheapest continuation of each move (dynamic programming).

use crate::decisions::{Decision, Decisions, InputValue};
use crate::explore::Exploration;
use crate::fair_moves::{CountsBefore, FairMoves, MovedSet};
use crate::transition::TransitionSystem;
use asmotion_lang::Value;
use rustc_hash::FxHashMap;

/// Limit for the executions of steps while the moves between layers are sought.
pub(crate) const MAX_LAYER_EXECUTIONS: u32 = 1 << 16;

/// Limit for the pairs of moves that are compared.
const MAX_MOVE_PAIRS: usize = 1 << 22;

/// A run through layers: one node of each layer, and the decisions of the steps between them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct LayeredPath {
    pub nodes: Vec<u32>,
    pub decisions: Vec<Vec<Decision>>,
    /// Agents and rules with fairness that the steps move.
    pub moved: Vec<MovedSet>,
}

/// The decisions of a step that fails in the last node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FailingStep<'a>(pub &'a [Decision]);

/// Costs of a run, in the order in which they are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct MoveCosts {
    /// Steps whose machine or agent is another one than in the step before.
    switches: u32,
    /// Inputs that a step reads with another value than the step before.
    changes: u32,
}

impl MoveCosts {
    const NONE: Self = Self {
        switches: 0,
        changes: 0,
    };

    fn plus(self, other: Self) -> Self {
        Self {
            switches: self.switches.saturating_add(other.switches),
            changes: self.changes.saturating_add(other.changes),
        }
    }
}

/// A step between nodes of consecutive layers.
struct LayerMove {
    from: u32,
    /// `None` for a step that fails.
    to: Option<u32>,
    /// The machines that move, each with the candidate of its first choice.
    movers: Vec<(usize, Option<Vec<Value>>)>,
    inputs: Vec<InputValue>,
    decisions: Vec<Decision>,
    moved: MovedSet,
}

impl LayerMove {
    /// Returns the costs of this move after another one.
    fn costs_after(&self, before: &Self) -> MoveCosts {
        let changes = self.inputs.iter().filter(|input| {
            let same_place = |other: &&InputValue| {
                other.machine == input.machine
                    && other.function == input.function
                    && other.arguments == input.arguments
            };
            let known = before.inputs.iter().find(same_place);
            known.is_some_and(|known| known.value != input.value)
        });
        MoveCosts {
            switches: u32::from(self.movers != before.movers),
            changes: changes.count() as u32,
        }
    }
}

/// Returns the best run that takes one node of each layer; `None` if there is none, or if too many would have to be compared.
///
/// `system` must keep candidates. If `wanted` is not empty, it gives what each step has to move.
pub(crate) fn best_path<S: TransitionSystem>(
    system: &S,
    exploration: &Exploration,
    layers: &[Vec<u32>],
    failing: Option<FailingStep<'_>>,
    fair: &FairMoves,
    wanted: &[MovedSet],
) -> Option<LayeredPath> {
    let mut search = LayerSearch {
        system: system.clone(),
        exploration,
        fair,
        counts: CountsBefore::default(),
        executions: 0,
    };
    let mut moves: Vec<Vec<LayerMove>> = Vec::new();
    for (index, pair) in layers.windows(2).enumerate() {
        let [from, to] = pair else { continue };
        moves.push(search.moves(from, to, wanted.get(index).copied())?);
    }
    if let Some(FailingStep(decisions)) = failing {
        let last = layers.last()?.first()?;
        moves.push(vec![search.failing(*last, decisions)]);
    }
    if moves.is_empty() {
        let first = layers.first()?.first()?;
        return Some(LayeredPath {
            nodes: vec![*first],
            ..LayeredPath::default()
        });
    }
    let rests = continuations(&moves)?;
    choose(&moves, &rests)
}

/// The costs of the cheapest continuation of each move, for each pair of layers; `None` for a move that leads nowhere.
type Continuations = Vec<Vec<Option<MoveCosts>>>;

fn continuations(moves: &[Vec<LayerMove>]) -> Option<Continuations> {
    let mut pairs = 0;
    let mut all: Continuations = vec![vec![
        Some(MoveCosts::NONE);
        moves.last().map_or(0, Vec::len)
    ]];
    for pair in moves.windows(2).rev() {
        let [here, next] = pair else { continue };
        let rests = all.last()?;
        let mut costs = Vec::with_capacity(here.len());
        for before in here {
            let (start, followers) = starting_at(next, before.to);
            pairs += followers.len();
            if pairs > MAX_MOVE_PAIRS {
                return None;
            }
            let followed = followers.iter().zip(rests.iter().skip(start));
            let each = followed
                .filter_map(|(follower, rest)| Some(follower.costs_after(before).plus((*rest)?)));
            costs.push(each.min());
        }
        all.push(costs);
    }
    all.reverse();
    Some(all)
}

/// Returns the moves that start at a node, and the index of the first one.
fn starting_at(moves: &[LayerMove], node: Option<u32>) -> (usize, &[LayerMove]) {
    let Some(node) = node else {
        return (0, &[]);
    };
    let start = moves.partition_point(|it| it.from < node);
    let end = moves.partition_point(|it| it.from <= node);
    (start, moves.get(start..end).unwrap_or_default())
}

/// Follows the cheapest moves; of equal ones, the first, which has the smallest values.
fn choose(moves: &[Vec<LayerMove>], rests: &Continuations) -> Option<LayeredPath> {
    let mut path = LayeredPath::default();
    let mut before: Option<&LayerMove> = None;
    for (moves, rests) in moves.iter().zip(rests) {
        let (start, followers) = match before {
            Some(before) => starting_at(moves, before.to),
            None => (0, moves.as_slice()),
        };
        let followed = followers.iter().zip(rests.iter().skip(start));
        let costed = followed.filter_map(|(follower, rest)| {
            let costs = before.map_or(MoveCosts::NONE, |before| follower.costs_after(before));
            Some((costs.plus((*rest)?), follower))
        });
        // the first of equal elements
        let (_, taken) = costed.min_by_key(|(costs, _)| *costs)?;
        if before.is_none() {
            path.nodes.push(taken.from);
        }
        path.nodes.extend(taken.to);
        path.decisions.push(taken.decisions.clone());
        path.moved.push(taken.moved);
        before = Some(taken);
    }
    Some(path)
}

/// The search for moves.
struct LayerSearch<'a, S> {
    system: S,
    exploration: &'a Exploration,
    fair: &'a FairMoves,
    counts: CountsBefore,
    executions: u32,
}

impl<S: TransitionSystem> LayerSearch<'_, S> {
    /// Returns the moves from a layer to the next one, in order of their start and of their decisions. `None` at the limit.
    fn moves(
        &mut self,
        from: &[u32],
        to: &[u32],
        wanted: Option<MovedSet>,
    ) -> Option<Vec<LayerMove>> {
        let mut targets: FxHashMap<Vec<u8>, Vec<u32>> = FxHashMap::default();
        for node in to {
            let state = self.exploration.state(*node).into_owned();
            targets.entry(state).or_default().push(*node);
        }
        let mut moves = Vec::new();
        let decisions = Decisions::default();
        let mut packed = Vec::new();
        for &node in from {
            let first = moves.len();
            let state = self.exploration.state(node);
            decisions.restart();
            loop {
                self.executions += 1;
                if self.executions > MAX_LAYER_EXECUTIONS {
                    return None;
                }
                self.system.restore(&state);
                self.fair.before(&self.system, &mut self.counts);
                let known = self.exploration.inputs(node);
                let done = self.system.step(&decisions, known);
                packed.clear();
                self.system.pack(&mut packed);
                let is_changed = *packed != *state;
                let moved = self.fair.moved(&self.system, &self.counts, is_changed);
                let is_wanted = done.is_ok() && wanted.is_none_or(|wanted| wanted == moved);
                let reached = targets.get(packed.as_slice()).filter(|_| is_wanted);
                for &target in reached.into_iter().flatten() {
                    let mut found = self.taken(node, Some(target), &decisions);
                    found.moved = moved;
                    let is_same = |known: &LayerMove| {
                        known.to == found.to
                            && known.movers == found.movers
                            && known.inputs == found.inputs
                            && known.moved == found.moved
                    };
                    let known = moves.get(first..).unwrap_or_default();
                    if !known.iter().any(is_same) {
                        moves.push(found);
                    }
                }
                if !decisions.advance() {
                    break;
                }
            }
        }
        Some(moves)
    }

    /// Returns the move of the step that was executed last.
    fn taken(&self, from: u32, to: Option<u32>, decisions: &Decisions) -> LayerMove {
        let machines = self.system.machines();
        let movers = self.system.moved().iter().map(|&index| {
            let machine = machines.get(index);
            let candidates = machine.map(|it| it.last_step().candidates());
            let first = candidates.and_then(<[_]>::first);
            (index, first.map(|it| it.values.clone()))
        });
        let mut inputs = self.exploration.inputs(from).to_vec();
        inputs.extend(decisions.read());
        LayerMove {
            from,
            to,
            movers: movers.collect(),
            inputs,
            decisions: decisions.taken(),
            moved: 0,
        }
    }

    /// Returns the move of a step that fails.
    fn failing(&mut self, node: u32, taken: &[Decision]) -> LayerMove {
        let decisions = Decisions::default();
        decisions.repeat(taken);
        self.system.restore(&self.exploration.state(node));
        // the step fails, as is known
        let _ = self.system.step(&decisions, self.exploration.inputs(node));
        let mut failing = self.taken(node, None, &decisions);
        failing.decisions = taken.to_vec();
        failing
    }
}

//! Formulas over the graph of an exploration.

use crate::codes::m004::FormulaTooLarge;
use crate::counterexample::NodePath;
use crate::explore::{Exploration, Truths};
use crate::fair_moves::{self, FairMoves, MovedSet};
use crate::formula::Formula;
use crate::operator::Operator;
use crate::property::PropertyKind;
use crate::transition::FairLabels;
use asmotion_diagnostics::{Diagnostic, Finding};
use asmotion_temporal::{
    Bits, Ctl, FairPaths, Fairness, Graph, GraphBuilder, Lasso, Ltl, Recurrent, TemporalError,
    Vacuity, check_ctl, check_ctl_while, check_ltl, check_ltl_with_vacuity_while,
    vacuity_ctl_while, witness_ctl,
};

/// A fairness constraint: only paths on which it holds are considered.
#[derive(Clone, Debug)]
pub(crate) enum FairnessFormula {
    /// Infinitely often.
    Justice(Formula),
    /// If the first condition holds infinitely often, so does the second.
    Compassion(Formula, Formula),
}

impl FairnessFormula {
    /// Returns the formulas that it consists of.
    pub fn formulas(&self) -> Vec<&Formula> {
        match self {
            Self::Justice(often) => vec![often],
            Self::Compassion(cause, effect) => vec![cause, effect],
        }
    }
}

/// The reason for which a formula is not checked.
#[derive(Debug)]
pub(crate) enum LogicError {
    /// A limit was reached.
    Interrupted,
    /// It cannot be.
    Formula(String),
}

impl LogicError {
    pub fn diagnostic(self) -> Diagnostic {
        let reason = self.reason();
        FormulaTooLarge { reason }.diagnostic()
    }

    pub fn reason(self) -> String {
        match self {
            Self::Interrupted => TemporalError::Interrupted.to_string(),
            Self::Formula(reason) => reason,
        }
    }
}

impl From<TemporalError> for LogicError {
    fn from(error: TemporalError) -> Self {
        if error == TemporalError::Interrupted {
            return Self::Interrupted;
        }
        Self::Formula(error.to_string())
    }
}

/// Number of nodes after which the construction of a graph asks whether to go on.
const NODES_AT_ONCE: u32 = 4096;

/// Returns the value of a formula without temporal operators at a node.
pub(crate) fn is_true(formula: &Formula, truths: &[Truths], node: u32) -> bool {
    match formula {
        Formula::Constant(truth) => *truth,
        Formula::Condition(index) => truths.get(*index).is_some_and(|it| it.get(node)),
        Formula::Apply(operator, operands) => {
            let mut values = operands.iter().map(|it| is_true(it, truths, node));
            match operator {
                Operator::Not => !values.next().unwrap_or_default(),
                Operator::And => values.all(|it| it),
                Operator::Or => values.any(|it| it),
                Operator::Implies => {
                    !values.next().unwrap_or_default() || values.next().unwrap_or_default()
                }
                Operator::Iff => values.next() == values.next(),
                Operator::Ex
                | Operator::Ax
                | Operator::Ef
                | Operator::Af
                | Operator::Eg
                | Operator::Ag
                | Operator::Eu
                | Operator::Au
                | Operator::Next
                | Operator::Globally
                | Operator::Finally
                | Operator::Until
                | Operator::Release
                | Operator::Yesterday
                | Operator::WeakYesterday
                | Operator::Historically
                | Operator::Once
                | Operator::Since
                | Operator::Triggered => false,
            }
        }
        Formula::Repeat(..) => false,
    }
}

/// Calls `see` for each condition of a formula.
pub(crate) fn visit_conditions(formula: &Formula, see: &mut dyn FnMut(usize)) {
    match formula {
        Formula::Constant(_) => {}
        Formula::Condition(index) => see(*index),
        Formula::Apply(_, operands) => {
            operands.iter().for_each(|it| visit_conditions(it, see));
        }
        Formula::Repeat(_, _, operand) => visit_conditions(operand, see),
    }
}

/// Fairness that refers to what steps move.
#[derive(Clone, Copy)]
pub(crate) struct FairnessOfSteps<'a> {
    /// The machines of a system, which the schedule selects again and again.
    pub scheduled: &'a [FairLabels],
    /// Agents and rules.
    pub due: &'a FairMoves,
}

/// Some labels of edges.
struct LabelSet(Vec<bool>);

impl LabelSet {
    #[inline]
    fn contains(&self, label: u32) -> bool {
        self.0.get(label as usize).copied().unwrap_or_default()
    }
}

/// The graph of an exploration, or of a path in it, with fairness constraints.
pub(crate) struct Checker {
    graph: Graph,
    atoms: Vec<Bits>,
    fairness: Vec<Fairness>,
    /// Agents and rules that the edges with each label move.
    moved_sets: Vec<MovedSet>,
}

impl Checker {
    /// Builds the graph of a complete exploration, as long as `goes_on` returns true for the memory that it takes.
    pub fn new(
        exploration: &Exploration,
        fairness: &[FairnessFormula],
        fair: FairnessOfSteps<'_>,
        goes_on: &dyn Fn(usize) -> bool,
    ) -> Result<Self, LogicError> {
        let mut builder = GraphBuilder::new();
        let mut edges = 0;
        for node in 0..exploration.nodes() {
            if node.is_multiple_of(NODES_AT_ONCE) && !goes_on(graph_memory(node as usize, edges)) {
                return Err(LogicError::Interrupted);
            }
            for (target, label) in exploration.labelled_successors(node) {
                builder.edge(target, label);
                edges += 1;
            }
            builder.end_node();
        }
        let graph = builder.finish((0..exploration.initial).collect())?;
        let sets = exploration.moved_sets.clone();
        Ok(Self::of(
            graph,
            exploration,
            fairness,
            fair,
            &|node| node,
            sets,
        ))
    }

    /// Builds the graph of a path that ends in a cycle.
    pub fn of_path(
        exploration: &Exploration,
        fairness: &[FairnessFormula],
        fair: FairnessOfSteps<'_>,
        path: &NodePath,
    ) -> Result<Self, LogicError> {
        let mut builder = GraphBuilder::new();
        let count = path.nodes.len();
        for index in 0..count {
            let next = if index + 1 < count {
                index + 1
            } else {
                path.cycle.unwrap_or(index)
            };
            builder.edge(next as u32, index as u32);
            builder.end_node();
        }
        let graph = builder.finish(vec![0])?;
        let node = |index: u32| path.nodes.get(index as usize).copied().unwrap_or_default();
        let sets = path.moved.clone();
        Ok(Self::of(graph, exploration, fairness, fair, &node, sets))
    }

    /// `node` returns the node of the exploration that a node of the graph stands for.
    fn of(
        graph: Graph,
        exploration: &Exploration,
        fairness: &[FairnessFormula],
        fair: FairnessOfSteps<'_>,
        node: &dyn Fn(u32) -> u32,
        moved_sets: Vec<MovedSet>,
    ) -> Self {
        let count = graph.node_count();
        let truths = exploration.truths.iter();
        let atoms = truths.map(|it| Bits::from_fn(count, |index| it.get(node(index as u32))));
        let nodes = |formula: &Formula| {
            let holds = |index| is_true(formula, &exploration.truths, node(index as u32));
            Recurrent::nodes(Bits::from_fn(count, holds))
        };
        let fairness = fairness.iter().map(|constraint| match constraint {
            FairnessFormula::Justice(often) => Fairness::Justice(nodes(often)),
            FairnessFormula::Compassion(cause, effect) => {
                Fairness::Compassion(nodes(cause), nodes(effect))
            }
        });
        let scheduled = fair.scheduled.iter().map(|fair| {
            let taken = graph.edges_with(|label| {
                let set = moved_sets.get(label as usize).copied().unwrap_or_default();
                label == Graph::STUTTER || fair.contains(fair_moves::label_of(set))
            });
            Fairness::Justice(Recurrent::edges(taken))
        });
        let due = fair.due.moves.iter().enumerate().map(|(index, due)| {
            let moved_by = |sets: &[MovedSet]| {
                let moves = sets.iter().map(|set| fair_moves::contains(*set, index));
                LabelSet(moves.collect())
            };
            let moving = moved_by(&moved_sets);
            let taken = graph.edges_with(|label| moving.contains(label));
            // enabled in the whole exploration, of which a path has some edges only
            let moving = moved_by(&exploration.moved_sets);
            let is_enabled = |place: usize| {
                let mut labels = exploration.labels(node(place as u32));
                labels.any(|label| moving.contains(label))
            };
            if due.is_strong {
                let enabled = Bits::from_fn(count, is_enabled);
                Fairness::Compassion(Recurrent::nodes(enabled), Recurrent::edges(taken))
            } else {
                let disabled = Bits::from_fn(count, |place| !is_enabled(place));
                Fairness::Justice(Recurrent::nodes_or_edges(disabled, taken))
            }
        });
        let fairness = fairness.chain(scheduled).chain(due).collect();
        Self {
            atoms: atoms.collect(),
            fairness,
            graph,
            moved_sets,
        }
    }

    /// Returns `true` if the formula is violated.
    pub fn violates(&self, kind: PropertyKind, formula: &Formula) -> Result<bool, LogicError> {
        let verdict = if kind == PropertyKind::Ltl {
            check_ltl(&self.graph, &self.atoms, &ltl(formula)?, &self.fairness)?
        } else {
            check_ctl(&self.graph, &self.atoms, &ctl(formula)?, &self.fairness)?
        };
        Ok(verdict.violation.is_some())
    }

    /// Returns the bytes that the graph takes.
    fn memory(&self) -> usize {
        graph_memory(self.graph.node_count(), self.graph.edge_count())
    }

    /// Checks a temporal formula, as long as `goes_on` returns true for the memory that this takes.
    pub fn check(
        &self,
        kind: PropertyKind,
        formula: &Formula,
        goes_on: &dyn Fn(usize) -> bool,
    ) -> Result<Checked, LogicError> {
        let (graph, atoms, fairness) = (&self.graph, &*self.atoms, &*self.fairness);
        let goes_on: &dyn Fn(usize) -> bool = &|bytes| goes_on(self.memory() + bytes);
        let (verdict, of_ltl) = if kind == PropertyKind::Ltl {
            check_ltl_with_vacuity_while(graph, atoms, &ltl(formula)?, fairness, goes_on)?
        } else {
            let formula = ctl(formula)?;
            let verdict = check_ctl_while(graph, atoms, &formula, fairness, goes_on)?;
            (verdict, Some(Vacuity::default()))
        };
        let path = verdict.violation.as_ref().map(|it| self.path(it));
        // a formula that holds because some path exists is shown by such a path
        let witness = match (kind, path.is_none() && is_existential(formula)) {
            (PropertyKind::Ctl, true) => {
                let found = witness_ctl(&self.graph, &self.atoms, &ctl(formula)?, &self.fairness)?;
                found.map(|it| self.path(&it))
            }
            _ => None,
        };
        let vacuity = if path.is_some() || kind == PropertyKind::Ltl {
            of_ltl
        } else {
            match vacuity_ctl_while(graph, atoms, &ctl(formula)?, fairness, goes_on) {
                Ok(vacuity) => Some(vacuity),
                Err(TemporalError::Interrupted) => None,
                Err(error) => return Err(error.into()),
            }
        };
        let irrelevant = vacuity.map(|vacuity| {
            let irrelevant: Vec<usize> = vacuity.irrelevant.iter().map(|it| it.atom).collect();
            formula.with_all_occurrences(&irrelevant)
        });
        Ok(Checked {
            path,
            irrelevant,
            witness,
            fair: verdict.fair,
        })
    }

    fn path(&self, lasso: &Lasso) -> NodePath {
        let mut nodes: Vec<u32> = vec![lasso.start];
        nodes.extend(lasso.stem.iter().map(|step| step.node));
        let start = nodes.len() - 1;
        nodes.extend(lasso.cycle.iter().map(|step| step.node));
        let cycle = (!lasso.cycle.is_empty()).then(|| {
            // the last node of the cycle is its first
            nodes.pop();
            start
        });
        let steps = lasso.stem.iter().chain(&lasso.cycle);
        let moved = steps.map(|step| {
            let label = self.graph.label(step.edge).unwrap_or_default();
            self.moved_sets
                .get(label as usize)
                .copied()
                .unwrap_or_default()
        });
        let is_labelled = !self.moved_sets.is_empty();
        NodePath {
            nodes,
            cycle,
            moved: moved.filter(|_| is_labelled).collect(),
            ..NodePath::default()
        }
    }
}

/// Returns the bytes that a graph takes, with the edges backwards.
fn graph_memory(nodes: usize, edges: usize) -> usize {
    nodes * 8 + edges * 12
}

/// The result of checking a temporal formula.
pub(crate) struct Checked {
    /// A path that violates it.
    pub path: Option<NodePath>,
    /// A path that shows that it holds.
    pub witness: Option<NodePath>,
    /// Conditions whose values do not matter for a formula that holds; `None` if a limit was reached before they were found.
    pub irrelevant: Option<Vec<usize>>,
    pub fair: FairPaths,
}

/// Returns `true` if one path shows that a formula holds.
fn is_existential(formula: &Formula) -> bool {
    matches!(
        formula,
        Formula::Apply(Operator::Ex | Operator::Ef | Operator::Eg | Operator::Eu, _)
            | Formula::Repeat(Operator::Ex, ..)
    )
}

/// Returns `true` if one path shows that a formula is violated: it says something about all paths only.
pub(crate) fn is_universal(formula: &Formula, is_positive: bool) -> bool {
    let all = |operands: &[Formula]| operands.iter().all(|it| is_universal(it, is_positive));
    match formula {
        Formula::Constant(_) | Formula::Condition(_) => true,
        Formula::Repeat(operator, _, operand) => {
            (*operator == Operator::Ax) == is_positive && is_universal(operand, is_positive)
        }
        Formula::Apply(operator, operands) => match (operator, operands.as_slice()) {
            (Operator::Not, [operand]) => is_universal(operand, !is_positive),
            (Operator::Implies, [cause, effect]) => {
                is_universal(cause, !is_positive) && is_universal(effect, is_positive)
            }
            (Operator::Iff, _) => formula.is_condition(),
            (Operator::Ex | Operator::Ef | Operator::Eg | Operator::Eu, _) => {
                !is_positive && all(operands)
            }
            (Operator::Ax | Operator::Af | Operator::Ag | Operator::Au, _) => {
                is_positive && all(operands)
            }
            (
                Operator::Not
                | Operator::And
                | Operator::Or
                | Operator::Implies
                | Operator::Next
                | Operator::Globally
                | Operator::Finally
                | Operator::Until
                | Operator::Release
                | Operator::Yesterday
                | Operator::WeakYesterday
                | Operator::Historically
                | Operator::Once
                | Operator::Since
                | Operator::Triggered,
                _,
            ) => all(operands),
        },
    }
}

/// The operands of an operator, of which it has one or two.
struct Operands<'f>(&'f [Formula]);

impl Operands<'_> {
    fn one<T>(&self, translate: fn(&Formula) -> Result<T, LogicError>) -> Result<T, LogicError> {
        self.0.first().map_or_else(|| Err(missing()), translate)
    }

    fn two<T>(
        &self,
        translate: fn(&Formula) -> Result<T, LogicError>,
    ) -> Result<(T, T), LogicError> {
        let [left, right] = self.0 else {
            return Err(missing());
        };
        Ok((translate(left)?, translate(right)?))
    }
}

fn missing() -> LogicError {
    LogicError::Formula("an operator lacks an operand".to_owned())
}

pub(crate) fn ctl(formula: &Formula) -> Result<Ctl, LogicError> {
    let (operator, operands) = match formula {
        Formula::Constant(true) => return Ok(Ctl::True),
        Formula::Constant(false) => return Ok(Ctl::False),
        Formula::Condition(index) => return Ok(Ctl::Atom(*index)),
        Formula::Repeat(operator, count, operand) => {
            let count = u32::try_from(*count).unwrap_or(u32::MAX);
            let operand = ctl(operand)?;
            let is_existential = *operator == Operator::Ex;
            return Ok(if is_existential {
                Ctl::ex(count, operand)
            } else {
                Ctl::ax(count, operand)
            });
        }
        Formula::Apply(operator, operands) => (operator, operands),
    };
    let all = || operands.iter().map(ctl).collect::<Result<Vec<Ctl>, _>>();
    let operands = Operands(operands);
    let pair = |make: fn(Ctl, Ctl) -> Ctl| operands.two(ctl).map(|(left, right)| make(left, right));
    match operator {
        Operator::Not => operands.one(ctl).map(Ctl::negation),
        Operator::And => all().map(Ctl::And),
        Operator::Or => all().map(Ctl::Or),
        Operator::Implies => pair(Ctl::implies),
        Operator::Iff => pair(Ctl::iff),
        Operator::Ex => operands.one(ctl).map(|it| Ctl::ex(1, it)),
        Operator::Ax => operands.one(ctl).map(|it| Ctl::ax(1, it)),
        Operator::Ef => operands.one(ctl).map(Ctl::ef),
        Operator::Af => operands.one(ctl).map(Ctl::af),
        Operator::Eg => operands.one(ctl).map(Ctl::eg),
        Operator::Ag => operands.one(ctl).map(Ctl::ag),
        Operator::Eu => pair(Ctl::eu),
        Operator::Au => pair(Ctl::au),
        Operator::Next
        | Operator::Globally
        | Operator::Finally
        | Operator::Until
        | Operator::Release
        | Operator::Yesterday
        | Operator::WeakYesterday
        | Operator::Historically
        | Operator::Once
        | Operator::Since
        | Operator::Triggered => Err(LogicError::Formula("an operator of LTL in CTL".to_owned())),
    }
}

pub(crate) fn ltl(formula: &Formula) -> Result<Ltl, LogicError> {
    let (operator, operands) = match formula {
        Formula::Constant(true) => return Ok(Ltl::True),
        Formula::Constant(false) => return Ok(Ltl::False),
        Formula::Condition(index) => return Ok(Ltl::Atom(*index)),
        Formula::Repeat(..) => {
            return Err(LogicError::Formula("an operator of CTL in LTL".to_owned()));
        }
        Formula::Apply(operator, operands) => (operator, operands),
    };
    let all = || operands.iter().map(ltl).collect::<Result<Vec<Ltl>, _>>();
    let operands = Operands(operands);
    let pair = |make: fn(Ltl, Ltl) -> Ltl| operands.two(ltl).map(|(left, right)| make(left, right));
    match operator {
        Operator::Not => operands.one(ltl).map(Ltl::negation),
        Operator::And => all().map(Ltl::And),
        Operator::Or => all().map(Ltl::Or),
        Operator::Implies => pair(Ltl::implies),
        Operator::Iff => pair(Ltl::iff),
        Operator::Next => operands.one(ltl).map(Ltl::next),
        Operator::Globally => operands.one(ltl).map(Ltl::globally),
        Operator::Finally => operands.one(ltl).map(Ltl::finally),
        Operator::Until => pair(Ltl::until),
        Operator::Release => pair(Ltl::release),
        Operator::Yesterday => operands.one(ltl).map(Ltl::yesterday),
        Operator::WeakYesterday => operands.one(ltl).map(Ltl::weak_yesterday),
        Operator::Historically => operands.one(ltl).map(Ltl::historically),
        Operator::Once => operands.one(ltl).map(Ltl::once),
        Operator::Since => pair(Ltl::since),
        Operator::Triggered => pair(Ltl::triggered),
        Operator::Ex
        | Operator::Ax
        | Operator::Ef
        | Operator::Af
        | Operator::Eg
        | Operator::Ag
        | Operator::Eu
        | Operator::Au => Err(LogicError::Formula("an operator of CTL in LTL".to_owned())),
    }
}

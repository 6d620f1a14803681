//! Checks CTL formulas: the nodes that satisfy each sub-formula, and paths that show why.

use crate::bits::Bits;
use crate::constraint::Constraint;
use crate::ctl::Ctl;
use crate::ctl_terms::{CtlId, CtlTerm, CtlTerms};
use crate::cycle::LassoSearch;
use crate::error::TemporalError;
use crate::fairness::Fairness;
use crate::fixpoints::Fixpoints;
use crate::graph::Graph;
use crate::lasso::{Lasso, PathStep};
use crate::search::ShortestPaths;
use crate::validate::validate;
use crate::verdict::TemporalVerdict;

/// Checks whether a CTL formula holds in all initial nodes from which fair paths start.
///
/// The counterexample is a path for the violated universal part: to a node that violates `p` for `AG p`, a lasso that avoids `p` for
/// `AF p`, and from there on for a violated sub-formula. It is empty where no path shows the violation, as for `EF p`.
///
/// # Errors
/// A set has the wrong size, an atom does not exist, or `EX` or `AX` are repeated more than 65 536 times.
pub fn check_ctl(
    graph: &Graph,
    atoms: &[Bits],
    formula: &Ctl,
    fairness: &[Fairness],
) -> Result<TemporalVerdict, TemporalError> {
    check_ctl_while(graph, atoms, formula, fairness, &|_| true)
}

/// Checks a CTL formula like [`check_ctl`], as long as `goes_on` returns true. It is asked before each sub-formula, with the bytes of
/// memory that the sets of nodes take so far.
///
/// # Errors
/// The same as of [`check_ctl`], and [`TemporalError::Interrupted`].
pub fn check_ctl_while(
    graph: &Graph,
    atoms: &[Bits],
    formula: &Ctl,
    fairness: &[Fairness],
    goes_on: &dyn Fn(usize) -> bool,
) -> Result<TemporalVerdict, TemporalError> {
    let negation = Satisfaction::while_allowed(graph, atoms, (formula, false), fairness, goes_on)?;
    Ok(TemporalVerdict {
        violation: negation.witness(),
        fair: negation.on.fair.paths(graph),
    })
}

/// Returns a path that shows why a CTL formula holds in one of the initial nodes: to a node that satisfies `p` for `EF p`. `None` if
/// it holds in no initial node from which a fair path starts.
///
/// # Errors
/// The same as of [`check_ctl`].
pub fn witness_ctl(
    graph: &Graph,
    atoms: &[Bits],
    formula: &Ctl,
    fairness: &[Fairness],
) -> Result<Option<Lasso>, TemporalError> {
    Ok(Satisfaction::of(graph, atoms, formula, true, fairness)?.witness())
}

/// Returns whether [`check_ctl`] finds no violation.
pub(crate) fn holds_ctl(
    graph: &Graph,
    atoms: &[Bits],
    formula: &Ctl,
    fairness: &[Fairness],
    goes_on: &dyn Fn(usize) -> bool,
) -> Result<bool, TemporalError> {
    let negation = Satisfaction::while_allowed(graph, atoms, (formula, false), fairness, goes_on)?;
    Ok(negation.initial().is_empty())
}

/// The nodes that satisfy each sub-formula.
struct Satisfaction<'a> {
    on: Fixpoints<'a>,
    terms: Vec<CtlTerm>,
    root: CtlId,
    /// By term.
    sets: Vec<Bits>,
    /// Whether some path shows why a term holds.
    has_path: Vec<bool>,
}

impl<'a> Satisfaction<'a> {
    fn of(
        graph: &'a Graph,
        atoms: &[Bits],
        formula: &Ctl,
        is_positive: bool,
        fairness: &'a [Fairness],
    ) -> Result<Self, TemporalError> {
        Self::while_allowed(graph, atoms, (formula, is_positive), fairness, &|_| true)
    }

    /// Evaluates a formula, or its negation.
    fn while_allowed(
        graph: &'a Graph,
        atoms: &[Bits],
        (formula, is_positive): (&Ctl, bool),
        fairness: &'a [Fairness],
        goes_on: &dyn Fn(usize) -> bool,
    ) -> Result<Self, TemporalError> {
        validate(graph, atoms, fairness)?;
        let (terms, root) = CtlTerms::of(formula, is_positive, atoms.len())?;
        let mut found = Self {
            on: Fixpoints::new(graph, fairness),
            terms: terms.terms,
            root,
            sets: Vec::new(),
            has_path: Vec::new(),
        };
        for id in 0..found.terms.len() {
            if !goes_on(id * graph.node_count().div_ceil(8)) {
                return Err(TemporalError::Interrupted);
            }
            let set = found.evaluate(&found.terms[id], atoms);
            found.sets.push(set);
            let has_path = found.starts_path(&found.terms[id]);
            found.has_path.push(has_path);
        }
        Ok(found)
    }

    fn evaluate(&self, term: &CtlTerm, atoms: &[Bits]) -> Bits {
        let size = self.on.graph.node_count();
        match term {
            CtlTerm::Constant(true) => Bits::full(size),
            CtlTerm::Constant(false) => Bits::new(size),
            CtlTerm::Atom { atom, is_positive } => {
                let set = atoms[*atom].clone();
                if *is_positive {
                    set
                } else {
                    set.complemented()
                }
            }
            CtlTerm::And(parts) => {
                let mut set = Bits::full(size);
                parts
                    .iter()
                    .for_each(|it| set.intersect_with(&self.sets[*it]));
                set
            }
            CtlTerm::Or(parts) => {
                let mut set = Bits::new(size);
                parts.iter().for_each(|it| set.union_with(&self.sets[*it]));
                set
            }
            CtlTerm::ExistsNext(steps, of) => self.on.after(*steps, &self.sets[*of]),
            CtlTerm::ExistsUntil(left, right) => {
                self.on.until(&self.sets[*left], &self.sets[*right])
            }
            CtlTerm::ExistsGlobally(of) => self.on.globally(&self.sets[*of]),
            CtlTerm::ForallNext(steps, of) => {
                let violating = self.sets[*of].clone().complemented();
                self.on.after(*steps, &violating).complemented()
            }
            CtlTerm::ForallUntil(left, right) => {
                let never = self.sets[*right].clone().complemented();
                let mut violating = self.on.globally(&never);
                violating.union_with(&self.broken(*left, *right));
                violating.complemented()
            }
            CtlTerm::ForallWeakUntil(left, right) => self.broken(*left, *right).complemented(),
        }
    }

    fn starts_path(&self, term: &CtlTerm) -> bool {
        match term {
            CtlTerm::ExistsNext(_, _) | CtlTerm::ExistsUntil(_, _) | CtlTerm::ExistsGlobally(_) => {
                true
            }
            CtlTerm::And(parts) | CtlTerm::Or(parts) => parts.iter().any(|it| self.has_path[*it]),
            CtlTerm::Constant(_)
            | CtlTerm::Atom { .. }
            | CtlTerm::ForallNext(_, _)
            | CtlTerm::ForallUntil(_, _)
            | CtlTerm::ForallWeakUntil(_, _) => false,
        }
    }

    /// The nodes with a path on which `left` stops before `right` holds.
    fn broken(&self, left: CtlId, right: CtlId) -> Bits {
        let not_yet = self.sets[right].clone().complemented();
        let mut neither = self.sets[left].clone().complemented();
        neither.intersect_with(&not_yet);
        self.on.until(&not_yet, &neither)
    }

    /// Returns the fair initial nodes in which the formula holds.
    fn initial(&self) -> Vec<u32> {
        let set = &self.sets[self.root];
        let mut initial = self.on.fair.initial(self.on.graph);
        initial.retain(|node| set.contains(*node as usize));
        initial
    }

    /// Returns a path that shows why the formula holds in a fair initial node.
    fn witness(&self) -> Option<Lasso> {
        let from = self.initial();
        let lasso = Lasso {
            start: *from.first()?,
            stem: Vec::new(),
            cycle: Vec::new(),
        };
        Some(self.continued(lasso, from))
    }

    /// Continues a path that ends in one of the nodes `from`, all of which satisfy the formula.
    fn continued(&self, mut lasso: Lasso, mut from: Vec<u32>) -> Lasso {
        let mut id = self.root;
        loop {
            let (start, path) = match &self.terms[id] {
                CtlTerm::And(parts) => {
                    let Some(part) = parts.iter().find(|part| self.has_path[**part]) else {
                        break;
                    };
                    id = *part;
                    continue;
                }
                CtlTerm::Or(parts) => {
                    let Some(part) = self.alternative(parts, &from) else {
                        break;
                    };
                    id = part;
                    from.retain(|node| self.sets[id].contains(*node as usize));
                    continue;
                }
                CtlTerm::ExistsNext(steps, of) => {
                    let path = self.path_after(*steps, *of, from.first().copied());
                    id = *of;
                    (from.first().copied(), path)
                }
                CtlTerm::ExistsUntil(left, right) => {
                    let goal = self.on.fair_of(&self.sets[*right]);
                    let through = |node| self.sets[*left].contains(node as usize);
                    let rows = self.on.graph.rows();
                    let (paths, arrivals) = ShortestPaths::to_nearest(rows, &from, &goal, through);
                    let found = arrivals.first().map(|it| paths.to_arrival(*it));
                    let (start, path) = found.unwrap_or_default();
                    id = *right;
                    (Some(start), path)
                }
                CtlTerm::ExistsGlobally(of) => return self.for_ever(lasso, &from, *of),
                CtlTerm::Constant(_)
                | CtlTerm::Atom { .. }
                | CtlTerm::ForallNext(_, _)
                | CtlTerm::ForallUntil(_, _)
                | CtlTerm::ForallWeakUntil(_, _) => break,
            };
            let start = start.unwrap_or(lasso.start);
            if lasso.stem.is_empty() {
                lasso.start = start;
            }
            from = vec![path.last().map_or(start, |step| step.node)];
            lasso.continued(path);
        }
        if lasso.stem.is_empty()
            && let Some(first) = from.first()
        {
            lasso.start = *first;
        }
        lasso
    }

    /// Returns a part that holds in one of the nodes, if possible one that needs no path.
    fn alternative(&self, parts: &[CtlId], from: &[u32]) -> Option<CtlId> {
        let holds = |part: &&CtlId| {
            let mut from = from.iter();
            from.any(|node| self.sets[**part].contains(*node as usize))
        };
        let holding: Vec<CtlId> = parts.iter().filter(holds).copied().collect();
        let without_path = holding.iter().find(|part| !self.has_path[**part]);
        without_path.or(holding.first()).copied()
    }

    /// Appends the shortest stem, and its shortest cycle, on which a formula always holds.
    fn for_ever(&self, mut lasso: Lasso, from: &[u32], of: CtlId) -> Lasso {
        let search = LassoSearch {
            rows: self.on.graph.rows(),
            from,
            within: &self.sets[of],
            origins: None,
            components: &self.on.components(&self.sets[of]),
            constraints: &Constraint::all(self.on.fairness),
        };
        let found = search.shortest();
        if let Some(found) = found {
            if lasso.stem.is_empty() {
                lasso.start = found.start;
            }
            lasso.continued(found.stem);
            lasso.cycle = found.cycle;
        }
        lasso
    }

    /// Returns a path of exactly this length to a node that satisfies a formula.
    ///
    /// The sets of nodes at each distance are kept at every √n-th distance only, and computed again in between.
    fn path_after(&self, steps: u32, of: CtlId, from: Option<u32>) -> Vec<PathStep> {
        let block = (steps as usize).isqrt().max(1);
        let mut marks = vec![self.sets[of].clone()];
        let mut set = self.sets[of].clone();
        for distance in 1..steps as usize {
            set = self.on.next(&set);
            if distance % block == 0 {
                marks.push(set.clone());
            }
        }
        let mut path = Vec::new();
        let mut node = from;
        while let (Some(from), Some(mark)) = (node, marks.pop()) {
            let done = marks.len() * block;
            let mut sets = vec![mark];
            for _ in done + 1..steps as usize - path.len() {
                sets.extend(sets.last().map(|set| self.on.next(set)));
            }
            let mut at = from;
            for set in sets.iter().rev() {
                let fair = self.on.fair_of(set);
                let rows = self.on.graph.rows();
                let mut edges = rows.edges(at).zip(rows.targets(at));
                let Some((edge, target)) = edges.find(|(_, it)| fair.contains(**it as usize))
                else {
                    return path;
                };
                at = *target;
                path.push(PathStep {
                    edge: edge as u32,
                    node: at,
                });
            }
            node = Some(at);
        }
        path
    }
}

//! Infinite paths that repeat, and finite paths.

/// A step of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathStep {
    /// The edge taken.
    pub edge: u32,
    /// The node reached.
    pub node: u32,
}

/// A path that shows why a formula is violated, or holds.
///
/// With a cycle it is infinite, and fair. Without one, the finite path suffices: every fair path that continues it agrees, and there
/// is one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lasso {
    /// The initial node at which the path starts.
    pub start: u32,
    /// Steps from the start to the cycle, or to the end.
    pub stem: Vec<PathStep>,
    /// Steps from the end of the stem back to it.
    pub cycle: Vec<PathStep>,
}

impl Lasso {
    /// Returns the shortest description of the same path: repetitions of the cycle become one, and the end of the stem moves into the
    /// cycle as far as it repeats the cycle.
    pub(crate) fn folded(mut self) -> Self {
        let length = self.cycle.len();
        let repeats = |period: &usize| {
            let shifted = self.cycle.iter().skip(*period);
            length.is_multiple_of(*period)
                && shifted.zip(&self.cycle).all(|(later, step)| later == step)
        };
        if let Some(period) = (1..length).find(repeats) {
            self.cycle.truncate(period);
        }
        let mut moved = 0;
        let backwards = self.cycle.iter().rev().cycle();
        for (step, repeated) in self.stem.iter().rev().zip(backwards) {
            if step != repeated {
                break;
            }
            moved += 1;
        }
        self.stem.truncate(self.stem.len() - moved);
        if !self.cycle.is_empty() {
            let turn = moved % self.cycle.len();
            self.cycle.rotate_right(turn);
        }
        self
    }

    /// Returns the path of the graph to which nodes and edges correspond.
    pub(crate) fn projected(self, (nodes, edges): (&[u32], &[u32])) -> Self {
        let step = |step: PathStep| PathStep {
            edge: edges[step.edge as usize],
            node: nodes[step.node as usize],
        };
        Self {
            start: nodes[self.start as usize],
            stem: self.stem.into_iter().map(step).collect(),
            cycle: self.cycle.into_iter().map(step).collect(),
        }
    }

    /// Appends a path that starts where the stem ends.
    pub(crate) fn continued(&mut self, path: Vec<PathStep>) {
        self.stem.extend(path);
    }
}

//! The states that can be reached, by the number of steps.

use crate::bdd::Bdd;
use crate::error::SymbolicError;
use crate::model::{NodeSet, SymbolicModel};

/// The progress of a search.
#[derive(Clone, Copy, Debug)]
pub struct SearchProgress {
    /// Number of states found; 2^64 - 1 if there are more.
    pub states: u64,
    /// Number of steps so far.
    pub depth: u32,
    /// Memory in use for diagrams, in bytes.
    pub memory: u64,
}

/// The reason for which a search ended before all states were found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SearchLimit {
    /// The limit for states.
    States,
    /// The limit for steps.
    Depth,
    /// The memory.
    Memory,
    /// The caller.
    Stopped,
}

/// The states that were found.
pub struct Reached {
    /// The nodes that are first reached after each number of steps; none of them is empty.
    pub rings: Vec<NodeSet>,
    pub(crate) states: Bdd,
    pub(crate) nodes: Bdd,
    /// The reason for which not all were found.
    pub limit: Option<SearchLimit>,
}

impl SymbolicModel<'_> {
    /// Finds the states that can be reached, within limits for their number and the number of steps. `proceed` ends the search by
    /// returning `false`.
    ///
    /// # Errors
    /// There is not enough memory even for the initial states.
    pub fn reach(
        &self,
        limits: (Option<u64>, Option<u32>),
        proceed: &mut dyn FnMut(SearchProgress) -> bool,
    ) -> Result<Reached, SymbolicError> {
        let nodes = self.store.and(&self.initial, &self.valid)?;
        let mut reached = Reached {
            rings: Vec::new(),
            states: self.initial.clone(),
            nodes: nodes.clone(),
            limit: None,
        };
        if nodes.is_never() {
            return Ok(reached);
        }
        reached.rings.push(NodeSet(nodes));
        match self.search(&mut reached, limits, proceed) {
            Ok(()) => {}
            Err(SymbolicError::Memory) => reached.limit = Some(SearchLimit::Memory),
            Err(SymbolicError::Stopped) => reached.limit = Some(SearchLimit::Stopped),
            Err(error) => return Err(error),
        }
        Ok(reached)
    }

    fn search(
        &self,
        reached: &mut Reached,
        (most_states, most_steps): (Option<u64>, Option<u32>),
        proceed: &mut dyn FnMut(SearchProgress) -> bool,
    ) -> Result<(), SymbolicError> {
        while let Some(frontier) = reached.rings.last().cloned() {
            let depth = (reached.rings.len() - 1) as u32;
            let states = self.state_count(&reached.states);
            let states = states.and_then(|count| u64::try_from(count).ok());
            let states = states.unwrap_or(u64::MAX);
            if most_steps.is_some_and(|limit| depth >= limit) {
                reached.limit = Some(SearchLimit::Depth);
                return Ok(());
            }
            if most_states.is_some_and(|limit| states > limit) {
                reached.limit = Some(SearchLimit::States);
                return Ok(());
            }
            let mut fresh = self.store.never();
            for moves in &self.moves {
                let memory = self.store.memory();
                if !proceed(SearchProgress {
                    states,
                    depth,
                    memory,
                }) {
                    return Err(SymbolicError::Stopped);
                }
                let after = moves.successors(&self.store, &frontier.0)?;
                let after = self.store.without(&after, &reached.states)?;
                fresh = self.store.or(&fresh, &after)?;
            }
            let nodes = self.store.and(&fresh, &self.valid)?;
            let all_states = self.store.or(&reached.states, &fresh)?;
            let all_nodes = self.store.or(&reached.nodes, &nodes)?;
            (reached.states, reached.nodes) = (all_states, all_nodes);
            if nodes.is_never() {
                return Ok(());
            }
            reached.rings.push(NodeSet(nodes));
            self.store.tidy();
        }
        Ok(())
    }
}

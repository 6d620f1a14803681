//! The exploration of the same system for properties that mention no inputs, without executing its steps again.

use crate::explore::Exploration;
use crate::parents::Parents;
use crate::spill::Table;

impl Exploration {
    /// Returns an exploration in which each state is one node: its successors are those of all nodes that the state had. Conditions have
    /// no values in it. `None` if it has to be explored: states or transitions are missing, or a step fails, which decisions describe
    /// that differ if no inputs are known.
    ///
    /// The states have other numbers than if they were explored, but the same distances from the initial ones.
    pub fn without_inputs(self) -> Option<Self> {
        let has_all = self.incomplete.is_none()
            && self.keeps_edges
            && self.excluded == 0
            && self.faults.is_empty()
            && !self.stands_for_others()
            && self.left_out.is_empty()
            && !self.has_left_out_steps;
        if !has_all {
            return None;
        }
        let state_of = |node: &u32| self.state_number(*node);
        let count = self.state_count() as u32;
        let spill = self.spill.as_ref();
        let mut found = Self {
            first_nodes: Table::new(spill),
            state_of: Table::new(spill),
            edge_ends: Table::new(spill),
            targets: Table::new(spill),
            labels: Table::new(spill),
            parents: Parents::default(),
            levels: self.levels.iter().filter_map(state_of).collect(),
            initial: self.initial.checked_sub(1).as_ref().and_then(state_of)? + 1,
            explored: count,
            keeps_edges: true,
            transitions: self.transitions,
            ..Self::default()
        };
        let mut edges: Vec<(u32, u32)> = Vec::new();
        for state in 0..count {
            let nodes = self.nodes_of(state);
            let parent = self.parents.get(nodes.start);
            found.parents.push(parent.as_ref().and_then(state_of));
            let mut beside = nodes.clone();
            found.moving.push(beside.any(|node| self.moving.get(node)));
            let successors = nodes.flat_map(|node| self.labelled_successors(node));
            edges.extend(successors.filter_map(|(next, label)| Some((state_of(&next)?, label))));
            edges.sort_unstable();
            edges.dedup();
            found.targets.extend(edges.iter().map(|(next, _)| *next));
            if self.labels.len() > 0 {
                found.labels.extend(edges.iter().map(|(_, label)| *label));
            }
            found.edge_ends.push(found.targets.len() as u64);
            edges.clear();
            if self.words.is_none() {
                found.first_nodes.push(state);
                found.state_of.push(state);
            }
        }
        Some(Self {
            states: self.states,
            words: self.words,
            spill: self.spill,
            stuck: self.stuck,
            moved_sets: self.moved_sets,
            symmetric: self.symmetric,
            counts: self.counts,
            ..found
        })
    }
}

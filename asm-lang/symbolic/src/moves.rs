//! Transition relations: one for each alternative of a step, over the variables of the locations that it changes.

use crate::bdd::{Bdd, BddStore, BitIndex, Renaming};
use crate::encoding::{Inputs, Slots};
use crate::error::SymbolicError;
use crate::step::Alternative;

/// Number of nodes up to which the relations of several locations are combined.
const CLUSTER: usize = 4000;

/// The transitions of an alternative. Locations that it does not change have no part in the relation.
pub(crate) struct Moves {
    /// Parts of the relation, whose conjunction it is, each with the variables that are quantified after it: for successors, and for
    /// predecessors.
    parts: Vec<(Bdd, Bdd, Bdd)>,
    to_now: Renaming,
    to_then: Renaming,
    /// The step updates a location.
    pub updates: Bdd,
    /// The step gives a location another value.
    pub changes: Bdd,
    /// Each input that is not read, and each choice that is not made, has its first code.
    canonical: Bdd,
    /// Variables of inputs and choices.
    pub decided: Vec<BitIndex>,
}

impl Moves {
    pub fn of(
        store: &BddStore,
        slots: &Slots,
        inputs: &Inputs,
        alternative: &Alternative,
    ) -> Result<Self, SymbolicError> {
        let (mut updates, mut changes) = (store.never(), store.never());
        let mut relations = vec![alternative.path.clone()];
        let (mut now, mut then) = (Vec::new(), Vec::new());
        for (slot, value) in &alternative.updates {
            let written = value.defined(store)?;
            updates = store.or(&updates, &written)?;
            let Some(code) = slots.get(slot) else {
                // an update to the only value that the location ever has
                continue;
            };
            let unwritten = store.without(&store.always(), &written)?;
            let mut relation = store.and(&unwritten, &code.same)?;
            let mut kept = store.never();
            for (value, guard) in value.iter() {
                let becomes = code
                    .becomes(value)
                    .cloned()
                    .unwrap_or_else(|| store.never());
                relation = store.or(&relation, &store.and(guard, &becomes)?)?;
                if let Some(is) = code.is(value) {
                    kept = store.or(&kept, &store.and(guard, is)?)?;
                }
            }
            let changed = store.without(&written, &kept)?;
            if changed.is_never() {
                continue;
            }
            changes = store.or(&changes, &changed)?;
            now.extend_from_slice(&code.now.bits);
            then.extend_from_slice(&code.then.bits);
            relations.push(relation);
        }
        let mut decided: Vec<BitIndex> = Vec::new();
        let mut canonical = store.always();
        for (number, read) in &alternative.reads {
            let free = inputs
                .all
                .get(*number)
                .and_then(|input| input.free.as_ref());
            if let Some(free) = free {
                decided.extend_from_slice(&free.bits);
                let first = store.or(read, &free.first(store))?;
                canonical = store.and(&canonical, &first)?;
            }
        }
        for choice in &alternative.choices {
            decided.extend_from_slice(&choice.code.bits);
            let first = store.or(&choice.made, &choice.code.first(store))?;
            canonical = store.and(&canonical, &first)?;
        }
        let known = inputs.all.iter().filter_map(|input| input.known.as_ref());
        let known = known.flat_map(|known| known.bits.iter().copied());
        let forward: Vec<BitIndex> = now
            .iter()
            .copied()
            .chain(known)
            .chain(decided.iter().copied())
            .collect();
        let backward: Vec<BitIndex> = then.iter().chain(&decided).copied().collect();
        let clusters = clustered(store, relations)?;
        let supports: Vec<Vec<BitIndex>> = clusters.iter().map(|it| store.support(it)).collect();
        let forward = schedule(&supports, &forward);
        let backward = schedule(&supports, &backward);
        let mut parts = Vec::new();
        for ((cluster, forward), backward) in clusters.into_iter().zip(forward).zip(backward) {
            parts.push((cluster, store.bits(&forward)?, store.bits(&backward)?));
        }
        let pairs: Vec<(BitIndex, BitIndex)> = then.into_iter().zip(now).collect();
        let reversed: Vec<(BitIndex, BitIndex)> =
            pairs.iter().map(|(to, from)| (*from, *to)).collect();
        decided.sort_unstable();
        decided.dedup();
        Ok(Self {
            parts,
            to_now: store.renaming(&pairs),
            to_then: store.renaming(&reversed),
            updates: store.and(&updates, &alternative.path)?,
            changes: store.and(&changes, &alternative.path)?,
            canonical,
            decided,
        })
    }

    /// Returns the states after a step from one of these nodes.
    pub fn successors(&self, store: &BddStore, nodes: &Bdd) -> Result<Bdd, SymbolicError> {
        let mut found = nodes.clone();
        for (part, bits, _) in &self.parts {
            found = store.and_exists(&found, part, bits)?;
            if found.is_never() {
                return Ok(found);
            }
        }
        store.rename(&found, &self.to_now)
    }

    /// Returns the nodes before a step to one of these states.
    pub fn predecessors(&self, store: &BddStore, states: &Bdd) -> Result<Bdd, SymbolicError> {
        let mut found = store.rename(states, &self.to_then)?;
        for (part, _, bits) in &self.parts {
            found = store.and_exists(&found, part, bits)?;
            if found.is_never() {
                return Ok(found);
            }
        }
        Ok(found)
    }

    /// Returns the steps from these nodes to these states, with their inputs and choices.
    pub fn between(
        &self,
        store: &BddStore,
        nodes: &Bdd,
        states: &Bdd,
    ) -> Result<Bdd, SymbolicError> {
        let mut found = nodes.clone();
        for (part, ..) in &self.parts {
            found = store.and(&found, part)?;
        }
        store.and(&found, &store.rename(states, &self.to_then)?)
    }

    /// Returns the executions that update a location, from one of these nodes, with their inputs and choices.
    pub fn executions(&self, store: &BddStore, nodes: &Bdd) -> Result<Bdd, SymbolicError> {
        store.and(&store.and(nodes, &self.updates)?, &self.canonical)
    }
}

/// Combines consecutive relations while they are small.
fn clustered(store: &BddStore, relations: Vec<Bdd>) -> Result<Vec<Bdd>, SymbolicError> {
    let mut clusters: Vec<Bdd> = Vec::new();
    for relation in relations {
        if let Some(last) = clusters.last_mut()
            && store.size(last).saturating_add(store.size(&relation)) < CLUSTER
        {
            let both = store.and(last, &relation)?;
            if store.size(&both) < CLUSTER {
                *last = both;
                continue;
            }
        }
        clusters.push(relation);
    }
    Ok(clusters)
}

/// Returns the variables to quantify after each cluster: those that no later cluster depends on.
fn schedule(supports: &[Vec<BitIndex>], bits: &[BitIndex]) -> Vec<Vec<BitIndex>> {
    let mut after = vec![Vec::new(); supports.len()];
    for bit in bits {
        let last = supports
            .iter()
            .rposition(|it| it.binary_search(bit).is_ok());
        if let Some(place) = after.get_mut(last.unwrap_or(0)) {
            place.push(*bit);
        }
    }
    after
}

//! Sizes of the sets that a check is given.

use crate::bits::Bits;
use crate::error::TemporalError;
use crate::fairness::Fairness;
use crate::graph::Graph;

pub(crate) fn validate(
    graph: &Graph,
    atoms: &[Bits],
    fairness: &[Fairness],
) -> Result<(), TemporalError> {
    let expected = graph.node_count();
    for atom in atoms {
        let found = atom.size();
        if found != expected {
            return Err(TemporalError::SetSize {
                what: "nodes",
                expected,
                found,
            });
        }
    }
    fairness
        .iter()
        .try_for_each(|constraint| constraint.validate(graph.rows()))
}

//! Sets of atoms, and the programs of agents.

use asmotion_ir::{DomainId, Program, RoutineId};

/// A set of atoms.
#[derive(Clone, Copy, Debug)]
pub(crate) enum AtomRange {
    /// Consecutive atoms: number of the first, and count.
    Atoms(u32, u32),
    /// The elements of a domain.
    Domain(DomainId),
}

impl AtomRange {
    /// Returns `true` if all atoms are among these consecutive ones.
    pub fn is_within(self, first: u32, count: u32) -> bool {
        match self {
            Self::Atoms(from, so_many) => first <= from && from + so_many <= first + count,
            Self::Domain(_) => false,
        }
    }
}

/// Returns the only routine that can be the program of any of these agents.
pub(crate) fn routine_of(program: &Program, agents: AtomRange) -> Option<RoutineId> {
    let mut domains: Vec<DomainId> = match agents {
        AtomRange::Atoms(first, count) => {
            let end = first.checked_add(count)?;
            program
                .atom_domains
                .get(first as usize..end as usize)?
                .to_vec()
        }
        AtomRange::Domain(domain) => {
            let all = (0..program.domains.len() as u32).map(DomainId);
            all.filter(|&subset| is_subset(program, subset, domain))
                .collect()
        }
    };
    domains.dedup();
    let programs = domains.iter().map(|domain| {
        let mut programs = program.programs.iter();
        programs.find(|(of, _)| of == domain).map(|(_, rule)| *rule)
    });
    let mut programs: Vec<_> = programs.collect::<Option<_>>()?;
    programs.dedup();
    let [rule] = programs.as_slice() else {
        return None;
    };
    let rule = program.rules.get(rule.0 as usize)?;
    rule.routine.filter(|_| rule.arguments.is_empty())
}

/// Returns `true` if a domain is, or is declared to be a subset of, another one.
pub(crate) fn is_subset(program: &Program, subset: DomainId, of: DomainId) -> bool {
    let mut next = Some(subset);
    for _ in 0..=program.domains.len() {
        match next {
            Some(domain) if domain == of => return true,
            Some(domain) => next = program.domains[domain.0 as usize].base,
            None => return false,
        }
    }
    false
}

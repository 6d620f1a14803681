//! CTL formulas in negation normal form, with equal sub-formulas shared.

use crate::ctl::Ctl;
use crate::error::TemporalError;
use rustc_hash::FxHashMap;

/// Index of a term; operands have smaller indices.
pub(crate) type CtlId = usize;

/// A formula without negations except of atoms. `p W q` and `F p` of the sources become the operators here: `EF p` is `E[true U p]`,
/// `AG p` is `A[p W false]`.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum CtlTerm {
    Constant(bool),
    Atom { atom: usize, is_positive: bool },
    And(Vec<CtlId>),
    Or(Vec<CtlId>),
    ExistsNext(u32, CtlId),
    ExistsUntil(CtlId, CtlId),
    ExistsGlobally(CtlId),
    ForallNext(u32, CtlId),
    ForallUntil(CtlId, CtlId),
    ForallWeakUntil(CtlId, CtlId),
}

/// Largest number of steps of `EX` and `AX`.
const STEPS: u32 = 1 << 16;

/// The terms of one formula.
pub(crate) struct CtlTerms {
    pub(crate) terms: Vec<CtlTerm>,
    ids: FxHashMap<CtlTerm, CtlId>,
    /// Terms of formulas by address, so that `iff` does not double the work at each level.
    converted: FxHashMap<(*const Ctl, bool), CtlId>,
    atom_count: usize,
}

impl CtlTerms {
    /// Returns the terms of the formula, or of its negation, and the term of the whole.
    pub(crate) fn of(
        formula: &Ctl,
        is_positive: bool,
        atom_count: usize,
    ) -> Result<(Self, CtlId), TemporalError> {
        let mut terms = Self {
            terms: Vec::new(),
            ids: FxHashMap::default(),
            converted: FxHashMap::default(),
            atom_count,
        };
        let root = terms.convert(formula, is_positive)?;
        Ok((terms, root))
    }

    fn add(&mut self, term: CtlTerm) -> CtlId {
        let terms = &mut self.terms;
        *self.ids.entry(term.clone()).or_insert_with(|| {
            terms.push(term);
            terms.len() - 1
        })
    }

    fn convert(&mut self, formula: &Ctl, is_positive: bool) -> Result<CtlId, TemporalError> {
        let key = (std::ptr::from_ref(formula), is_positive);
        if let Some(id) = self.converted.get(&key) {
            return Ok(*id);
        }
        let id = self.convert_new(formula, is_positive)?;
        self.converted.insert(key, id);
        Ok(id)
    }

    fn convert_new(&mut self, formula: &Ctl, is_positive: bool) -> Result<CtlId, TemporalError> {
        Ok(match formula {
            Ctl::True => self.add(CtlTerm::Constant(is_positive)),
            Ctl::False => self.add(CtlTerm::Constant(!is_positive)),
            Ctl::Atom(atom) => self.atom(*atom, is_positive)?,
            Ctl::Not(of) => self.convert(of, !is_positive)?,
            Ctl::And(parts) => self.join(parts, is_positive, is_positive)?,
            Ctl::Or(parts) => self.join(parts, is_positive, !is_positive)?,
            Ctl::Implies(left, right) => {
                let parts = vec![
                    self.convert(left, !is_positive)?,
                    self.convert(right, is_positive)?,
                ];
                self.joined(parts, !is_positive)
            }
            Ctl::Iff(left, right) => self.equivalence(left, right, is_positive)?,
            Ctl::Ex(steps, of) => self.next(*steps, of, is_positive, is_positive)?,
            Ctl::Ax(steps, of) => self.next(*steps, of, is_positive, !is_positive)?,
            Ctl::Ef(of) => self.until(&Ctl::True, of, is_positive, true)?,
            Ctl::Af(of) => self.until(&Ctl::True, of, is_positive, false)?,
            Ctl::Eg(of) => self.weak_until(of, &Ctl::False, is_positive, true)?,
            Ctl::Ag(of) => self.weak_until(of, &Ctl::False, is_positive, false)?,
            Ctl::Eu(left, right) => self.until(left, right, is_positive, true)?,
            Ctl::Au(left, right) => self.until(left, right, is_positive, false)?,
            Ctl::Ew(left, right) => self.weak_until(left, right, is_positive, true)?,
            Ctl::Aw(left, right) => self.weak_until(left, right, is_positive, false)?,
        })
    }

    fn atom(&mut self, atom: usize, is_positive: bool) -> Result<CtlId, TemporalError> {
        let count = self.atom_count;
        if atom >= count {
            return Err(TemporalError::UnknownAtom { atom, count });
        }
        Ok(self.add(CtlTerm::Atom { atom, is_positive }))
    }

    fn join(
        &mut self,
        parts: &[Ctl],
        is_positive: bool,
        is_and: bool,
    ) -> Result<CtlId, TemporalError> {
        let parts = parts.iter().map(|part| self.convert(part, is_positive));
        let parts = parts.collect::<Result<_, _>>()?;
        Ok(self.joined(parts, is_and))
    }

    fn joined(&mut self, parts: Vec<CtlId>, is_and: bool) -> CtlId {
        self.add(if is_and {
            CtlTerm::And(parts)
        } else {
            CtlTerm::Or(parts)
        })
    }

    fn equivalence(
        &mut self,
        left: &Ctl,
        right: &Ctl,
        is_positive: bool,
    ) -> Result<CtlId, TemporalError> {
        let both = vec![self.convert(left, true)?, self.convert(right, is_positive)?];
        let neither = vec![
            self.convert(left, false)?,
            self.convert(right, !is_positive)?,
        ];
        let ways = vec![self.joined(both, true), self.joined(neither, true)];
        Ok(self.joined(ways, false))
    }

    fn next(
        &mut self,
        steps: u32,
        of: &Ctl,
        is_positive: bool,
        is_existential: bool,
    ) -> Result<CtlId, TemporalError> {
        if steps > STEPS {
            let limit = STEPS;
            return Err(TemporalError::TooManySteps { steps, limit });
        }
        let of = self.convert(of, is_positive)?;
        if steps == 0 {
            return Ok(of);
        }
        Ok(self.add(if is_existential {
            CtlTerm::ExistsNext(steps, of)
        } else {
            CtlTerm::ForallNext(steps, of)
        }))
    }

    /// Converts `E[left U right]` or `A[left U right]`.
    fn until(
        &mut self,
        left: &Ctl,
        right: &Ctl,
        is_positive: bool,
        is_existential: bool,
    ) -> Result<CtlId, TemporalError> {
        let right_id = self.convert(right, is_positive)?;
        let left_id = self.convert(left, is_positive)?;
        if is_positive {
            return Ok(self.strong(left_id, right_id, is_existential));
        }
        let neither = self.joined(vec![left_id, right_id], true);
        Ok(self.weak(right_id, neither, !is_existential))
    }

    /// Converts `E[left W right]` or `A[left W right]`.
    fn weak_until(
        &mut self,
        left: &Ctl,
        right: &Ctl,
        is_positive: bool,
        is_existential: bool,
    ) -> Result<CtlId, TemporalError> {
        let left_id = self.convert(left, is_positive)?;
        let right_id = self.convert(right, is_positive)?;
        if is_positive {
            return Ok(self.weak(left_id, right_id, is_existential));
        }
        let neither = self.joined(vec![left_id, right_id], true);
        Ok(self.strong(right_id, neither, !is_existential))
    }

    fn strong(&mut self, left: CtlId, right: CtlId, is_existential: bool) -> CtlId {
        self.add(if is_existential {
            CtlTerm::ExistsUntil(left, right)
        } else {
            CtlTerm::ForallUntil(left, right)
        })
    }

    fn weak(&mut self, left: CtlId, right: CtlId, is_existential: bool) -> CtlId {
        if !is_existential {
            return self.add(CtlTerm::ForallWeakUntil(left, right));
        }
        let until = self.add(CtlTerm::ExistsUntil(left, right));
        let globally = self.add(CtlTerm::ExistsGlobally(left));
        self.joined(vec![until, globally], false)
    }
}

//! LTL formulas in positive normal form, with equal sub-formulas shared and past operators as history.

use crate::error::TemporalError;
use crate::ltl::Ltl;
use rustc_hash::FxHashMap;

/// Index of a term; operands have smaller indices.
pub(crate) type LtlId = usize;

/// A formula without negations except of literals, and without past operators.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum LtlTerm {
    Constant(bool),
    Literal { letter: Letter, is_positive: bool },
    And(Vec<LtlId>),
    Or(Vec<LtlId>),
    Next(LtlId),
    Until(LtlId, LtlId),
    Release(LtlId, LtlId),
}

/// The knowledge at a position of a path when an automaton reads it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Letter {
    /// An atom.
    Atom(usize),
    /// A formula with a past operator, by index in [`Closure::past`].
    Past(usize),
    /// A formula about the future below a past operator, by index in [`Closure::guesses`]. The automaton guesses whether it holds,
    /// and then has to keep the guess.
    Guess(usize),
}

/// A formula with a past operator. Its operands are formulas about the present: literals, conjunctions and disjunctions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Past {
    /// The operand held at the previous position; the value at the first position.
    Previous(LtlId, bool),
    Since(LtlId, LtlId),
    Triggered(LtlId, LtlId),
}

impl Past {
    /// Returns whether the formula, or the operand of `Previous`, counts as having held before the first position.
    pub(crate) fn before_start(self) -> bool {
        match self {
            Self::Previous(_, is_weak) => is_weak,
            Self::Since(_, _) => false,
            Self::Triggered(_, _) => true,
        }
    }
}

/// A formula about the future, and its negation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Guess {
    pub(crate) holds: LtlId,
    pub(crate) fails: LtlId,
}

/// Largest number of guesses, which double the successors of a state.
const GUESSES: usize = 12;

/// The terms of one formula.
pub(crate) struct Closure {
    pub(crate) terms: Vec<LtlTerm>,
    /// Formulas with past operators; operands refer to earlier ones only.
    pub(crate) past: Vec<Past>,
    pub(crate) guesses: Vec<Guess>,
    ids: FxHashMap<LtlTerm, LtlId>,
    past_ids: FxHashMap<Past, usize>,
    guess_ids: FxHashMap<Guess, usize>,
    /// Terms of formulas by address, so that `iff` does not double the work at each level.
    converted: FxHashMap<(*const Ltl, bool, Place), LtlId>,
    atom_count: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Place {
    /// Below operators about the future only.
    Future,
    /// Below a past operator, where formulas about the future are guessed.
    Past,
}

impl Closure {
    /// Returns the terms of the negated formula, and the term of the whole.
    pub(crate) fn of_negation(
        formula: &Ltl,
        atom_count: usize,
    ) -> Result<(Self, LtlId), TemporalError> {
        let mut closure = Self {
            terms: Vec::new(),
            past: Vec::new(),
            guesses: Vec::new(),
            ids: FxHashMap::default(),
            past_ids: FxHashMap::default(),
            guess_ids: FxHashMap::default(),
            converted: FxHashMap::default(),
            atom_count,
        };
        let root = closure.convert(formula, false, Place::Future)?;
        Ok((closure, root))
    }

    /// Returns the atoms that occur in the formula, in ascending order.
    pub(crate) fn atoms(&self) -> Vec<usize> {
        let atom = |term: &LtlTerm| match term {
            LtlTerm::Literal {
                letter: Letter::Atom(atom),
                ..
            } => Some(*atom),
            LtlTerm::Literal { .. }
            | LtlTerm::Constant(_)
            | LtlTerm::And(_)
            | LtlTerm::Or(_)
            | LtlTerm::Next(_)
            | LtlTerm::Until(_, _)
            | LtlTerm::Release(_, _) => None,
        };
        let mut atoms: Vec<usize> = self.terms.iter().filter_map(atom).collect();
        atoms.sort_unstable();
        atoms.dedup();
        atoms
    }

    fn add(&mut self, term: LtlTerm) -> LtlId {
        let terms = &mut self.terms;
        *self.ids.entry(term.clone()).or_insert_with(|| {
            terms.push(term);
            terms.len() - 1
        })
    }

    fn constant(&mut self, value: bool) -> LtlId {
        self.add(LtlTerm::Constant(value))
    }

    fn literal(&mut self, letter: Letter, is_positive: bool) -> LtlId {
        self.add(LtlTerm::Literal {
            letter,
            is_positive,
        })
    }

    fn convert(
        &mut self,
        formula: &Ltl,
        is_positive: bool,
        place: Place,
    ) -> Result<LtlId, TemporalError> {
        let key = (std::ptr::from_ref(formula), is_positive, place);
        if let Some(id) = self.converted.get(&key) {
            return Ok(*id);
        }
        let id = self.convert_new(formula, is_positive, place)?;
        self.converted.insert(key, id);
        Ok(id)
    }

    fn convert_new(
        &mut self,
        formula: &Ltl,
        is_positive: bool,
        place: Place,
    ) -> Result<LtlId, TemporalError> {
        match formula {
            Ltl::True => Ok(self.constant(is_positive)),
            Ltl::False => Ok(self.constant(!is_positive)),
            Ltl::Atom(atom) => self.atom(*atom, is_positive),
            Ltl::Not(of) => self.convert(of, !is_positive, place),
            Ltl::And(parts) => self.join(parts, is_positive, place, is_positive),
            Ltl::Or(parts) => self.join(parts, is_positive, place, !is_positive),
            Ltl::Implies(left, right) => {
                let left = self.convert(left, !is_positive, place)?;
                let right = self.convert(right, is_positive, place)?;
                Ok(self.joined(vec![left, right], !is_positive))
            }
            Ltl::Iff(left, right) => self.equivalence(left, right, is_positive, place),
            Ltl::Next(_)
            | Ltl::Finally(_)
            | Ltl::Globally(_)
            | Ltl::Until(_, _)
            | Ltl::Release(_, _)
            | Ltl::WeakUntil(_, _) => match place {
                Place::Future => self.future(formula, is_positive),
                Place::Past => self.guess(formula, is_positive),
            },
            Ltl::Yesterday(of) => {
                let of = self.convert(of, true, Place::Past)?;
                Ok(self.past(Past::Previous(of, false), is_positive))
            }
            Ltl::WeakYesterday(of) => {
                let of = self.convert(of, true, Place::Past)?;
                Ok(self.past(Past::Previous(of, true), is_positive))
            }
            Ltl::Once(of) => {
                let (left, right) = (self.constant(true), self.convert(of, true, Place::Past)?);
                Ok(self.past(Past::Since(left, right), is_positive))
            }
            Ltl::Historically(of) => {
                let (left, right) = (self.constant(false), self.convert(of, true, Place::Past)?);
                Ok(self.past(Past::Triggered(left, right), is_positive))
            }
            Ltl::Since(left, right) => {
                let left = self.convert(left, true, Place::Past)?;
                let right = self.convert(right, true, Place::Past)?;
                Ok(self.past(Past::Since(left, right), is_positive))
            }
            Ltl::Triggered(left, right) => {
                let left = self.convert(left, true, Place::Past)?;
                let right = self.convert(right, true, Place::Past)?;
                Ok(self.past(Past::Triggered(left, right), is_positive))
            }
        }
    }

    fn atom(&mut self, atom: usize, is_positive: bool) -> Result<LtlId, TemporalError> {
        let count = self.atom_count;
        if atom >= count {
            return Err(TemporalError::UnknownAtom { atom, count });
        }
        Ok(self.literal(Letter::Atom(atom), is_positive))
    }

    fn join(
        &mut self,
        parts: &[Ltl],
        is_positive: bool,
        place: Place,
        is_and: bool,
    ) -> Result<LtlId, TemporalError> {
        let parts = parts
            .iter()
            .map(|part| self.convert(part, is_positive, place));
        let parts = parts.collect::<Result<_, _>>()?;
        Ok(self.joined(parts, is_and))
    }

    /// Returns a conjunction or disjunction without constants, nested ones of the same kind, and repetitions.
    fn joined(&mut self, parts: Vec<LtlId>, is_and: bool) -> LtlId {
        let mut flat = Vec::new();
        for part in parts {
            match &self.terms[part] {
                LtlTerm::Constant(value) if *value == is_and => {}
                LtlTerm::Constant(_) => return part,
                LtlTerm::And(inner) if is_and => flat.extend(inner),
                LtlTerm::Or(inner) if !is_and => flat.extend(inner),
                LtlTerm::Literal { .. }
                | LtlTerm::And(_)
                | LtlTerm::Or(_)
                | LtlTerm::Next(_)
                | LtlTerm::Until(_, _)
                | LtlTerm::Release(_, _) => flat.push(part),
            }
        }
        flat.sort_unstable();
        flat.dedup();
        match flat.as_slice() {
            [] => self.constant(is_and),
            [only] => *only,
            [_, _, ..] if is_and => self.add(LtlTerm::And(flat)),
            [_, _, ..] => self.add(LtlTerm::Or(flat)),
        }
    }

    fn equivalence(
        &mut self,
        left: &Ltl,
        right: &Ltl,
        is_positive: bool,
        place: Place,
    ) -> Result<LtlId, TemporalError> {
        let both = vec![
            self.convert(left, true, place)?,
            self.convert(right, is_positive, place)?,
        ];
        let neither = vec![
            self.convert(left, false, place)?,
            self.convert(right, !is_positive, place)?,
        ];
        let ways = vec![self.joined(both, true), self.joined(neither, true)];
        Ok(self.joined(ways, false))
    }

    /// Converts a formula with a future operator outside of past operators.
    fn future(&mut self, formula: &Ltl, is_positive: bool) -> Result<LtlId, TemporalError> {
        let mut operand = |of| self.convert(of, is_positive, Place::Future);
        let (left, right, is_until) = match formula {
            Ltl::Next(of) => {
                let of = operand(of)?;
                return Ok(self.add(LtlTerm::Next(of)));
            }
            Ltl::Finally(of) => (None, operand(of)?, true),
            Ltl::Globally(of) => (None, operand(of)?, false),
            Ltl::Until(left, right) => (Some(operand(left)?), operand(right)?, true),
            Ltl::Release(left, right) => (Some(operand(left)?), operand(right)?, false),
            Ltl::WeakUntil(left, right) => return self.weak_until(left, right, is_positive),
            Ltl::True
            | Ltl::False
            | Ltl::Atom(_)
            | Ltl::Not(_)
            | Ltl::And(_)
            | Ltl::Or(_)
            | Ltl::Implies(_, _)
            | Ltl::Iff(_, _)
            | Ltl::Yesterday(_)
            | Ltl::WeakYesterday(_)
            | Ltl::Once(_)
            | Ltl::Historically(_)
            | Ltl::Since(_, _)
            | Ltl::Triggered(_, _) => {
                return self.convert(formula, is_positive, Place::Future);
            }
        };
        let is_until = is_until == is_positive;
        let left = left.unwrap_or_else(|| self.constant(is_until));
        Ok(self.eventuality(left, right, is_until))
    }

    /// `p W q` is `q V (p or q)`, and its negation is `not q U (not p and not q)`.
    fn weak_until(
        &mut self,
        left: &Ltl,
        right: &Ltl,
        is_positive: bool,
    ) -> Result<LtlId, TemporalError> {
        let left = self.convert(left, is_positive, Place::Future)?;
        let right = self.convert(right, is_positive, Place::Future)?;
        let either = self.joined(vec![left, right], !is_positive);
        Ok(self.eventuality(right, either, !is_positive))
    }

    fn eventuality(&mut self, left: LtlId, right: LtlId, is_until: bool) -> LtlId {
        if matches!(self.terms[right], LtlTerm::Constant(_)) {
            return right;
        }
        self.add(if is_until {
            LtlTerm::Until(left, right)
        } else {
            LtlTerm::Release(left, right)
        })
    }

    fn past(&mut self, past: Past, is_positive: bool) -> LtlId {
        let all = &mut self.past;
        let index = *self.past_ids.entry(past).or_insert_with(|| {
            all.push(past);
            all.len() - 1
        });
        self.literal(Letter::Past(index), is_positive)
    }

    fn guess(&mut self, formula: &Ltl, is_positive: bool) -> Result<LtlId, TemporalError> {
        let guess = Guess {
            holds: self.convert(formula, true, Place::Future)?,
            fails: self.convert(formula, false, Place::Future)?,
        };
        let all = &mut self.guesses;
        let index = *self.guess_ids.entry(guess).or_insert_with(|| {
            all.push(guess);
            all.len() - 1
        });
        if self.guesses.len() > GUESSES {
            let limit = 1 << GUESSES;
            return Err(TemporalError::FormulaTooLarge { limit });
        }
        Ok(self.literal(Letter::Guess(index), is_positive))
    }
}

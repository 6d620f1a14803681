//! Variables that range over elements: quantifiers, comprehensions, `forall` and `choose`.

use crate::bdd::Bdd;
use crate::error::SymbolicError;
use crate::evaluator::{Evaluator, MAX_COMBINATIONS};
use crate::fault::FaultClass;
use crate::guarded::Guarded;
use crate::term::{collected, many};
use asmotion_lang::Value;
use asmotion_lang::ir::{Binder, BinderRange, Collection, Origin, Term, ValueShape};
use asmotion_lang::value::Atom;
use std::collections::BTreeMap;

/// Called for an assignment of the variables; returns the part of the path on which the next assignment follows.
pub(crate) type Visit<'v, 'a> =
    &'v mut dyn FnMut(&mut Evaluator<'a>, &Bdd) -> Result<Bdd, SymbolicError>;

impl<'a> Evaluator<'a> {
    /// Calls `visit` for each assignment of the variables, in ascending order. Returns the part of the path on which no call broke.
    pub fn each(
        &mut self,
        binders: &[Binder],
        path: &Bdd,
        visit: Visit<'_, 'a>,
    ) -> Result<Bdd, SymbolicError> {
        let path = self.alive(path)?;
        if path.is_never() {
            return Ok(path);
        }
        let Some((binder, others)) = binders.split_first() else {
            let rest = visit(self, &path)?;
            return self.alive(&rest);
        };
        let elements = self.range(&binder.range, binder.origin, &path)?;
        let mut rest = self.alive(&path)?;
        for (element, guard) in elements {
            let here = self.store.and(&rest, &guard)?;
            if here.is_never() {
                continue;
            }
            self.set_local(binder.local, Guarded::of(element, &self.store.always()));
            let done = self.each(others, &here, visit)?;
            let elsewhere = self.store.without(&rest, &guard)?;
            rest = self.store.or(&elsewhere, &done)?;
            rest = self.alive(&rest)?;
        }
        Ok(rest)
    }

    /// Returns the elements of a range, each with the condition under which it belongs to the range.
    fn range(
        &mut self,
        range: &BinderRange,
        origin: Origin,
        path: &Bdd,
    ) -> Result<Vec<(Value, Bdd)>, SymbolicError> {
        let always = self.store.always();
        let constant = |values: Vec<Value>| {
            let values = values.into_iter();
            Ok(values.map(|value| (value, always.clone())).collect())
        };
        match range {
            BinderRange::Ints(low, high) => {
                let count = high.saturating_sub(*low);
                if count > MAX_COMBINATIONS as i64 {
                    return Err(many(origin));
                }
                constant((*low..=*high).map(Value::Int).collect())
            }
            BinderRange::Atoms(first, count) => {
                let atoms = *first..first.saturating_add(*count);
                constant(atoms.map(|atom| Value::Atom(Atom(atom))).collect())
            }
            BinderRange::Bools => constant(vec![Value::Bool(false), Value::Bool(true)]),
            BinderRange::Domain(domain) => {
                constant(self.elements(&ValueShape::Domain(*domain), origin)?)
            }
            BinderRange::Elements(term) => {
                let collection = self.term(term, path)?;
                self.members(&collection, origin)
            }
        }
    }

    /// Returns the members of a collection; several copies of one in a sequence or bag follow each other.
    fn members(
        &mut self,
        collection: &Guarded,
        origin: Origin,
    ) -> Result<Vec<(Value, Bdd)>, SymbolicError> {
        let store = self.store;
        let mut members: BTreeMap<(Value, usize), Bdd> = BTreeMap::new();
        for (collection, guard) in collection.iter() {
            let items: Vec<(Value, usize)> = match collection {
                Value::Set(items) => items.iter().map(|it| (it.clone(), 1)).collect(),
                Value::Bag(items) => items
                    .iter()
                    .map(|(it, count)| (it.clone(), *count))
                    .collect(),
                Value::Seq(items) => {
                    let mut counts: BTreeMap<Value, usize> = BTreeMap::new();
                    for item in items.iter() {
                        *counts.entry(item.clone()).or_default() += 1;
                    }
                    counts.into_iter().collect()
                }
                Value::Undef
                | Value::Bool(_)
                | Value::Int(_)
                | Value::Real(_)
                | Value::Char(_)
                | Value::Atom(_)
                | Value::Rule(_)
                | Value::Text(_)
                | Value::Complex(_)
                | Value::Tuple(_)
                | Value::Map(_) => {
                    self.fail(FaultClass::NotACollection, origin, guard)?;
                    continue;
                }
            };
            for (item, count) in items {
                for copy in 0..count {
                    let key = (item.clone(), copy);
                    let known = members.entry(key).or_insert_with(|| store.never());
                    *known = store.or(known, guard)?;
                }
            }
            if members.len() > MAX_COMBINATIONS {
                return Err(many(origin));
            }
        }
        Ok(members
            .into_iter()
            .map(|((it, _), guard)| (it, guard))
            .collect())
    }

    /// Evaluates a comprehension: all collections that it can yield.
    pub fn comprehension(
        &mut self,
        collection: Collection,
        (binders, guard): (&[Binder], Option<&Term>),
        item: &Term,
        origin: Origin,
        path: &Bdd,
    ) -> Result<Guarded, SymbolicError> {
        let mut partial: BTreeMap<Vec<Value>, Bdd> = BTreeMap::new();
        partial.insert(Vec::new(), path.clone());
        self.each(binders, path, &mut |it, path| {
            let truth = it.satisfied(guard, path)?;
            let value = it.term(item, &truth.yes)?;
            let store = it.store;
            let mut longer: BTreeMap<Vec<Value>, Bdd> = BTreeMap::new();
            let mut add = |items: Vec<Value>, guard: Bdd| {
                if guard.is_never() {
                    return Ok(());
                }
                let known = longer.entry(items).or_insert_with(|| store.never());
                *known = store.or(known, &guard)?;
                Ok::<(), SymbolicError>(())
            };
            for (items, guard) in &partial {
                add(items.clone(), store.without(guard, &truth.yes)?)?;
                for (value, condition) in value.iter() {
                    let mut items = items.clone();
                    items.push(value.clone());
                    match collection {
                        Collection::Seq => {}
                        Collection::Bag => items.sort(),
                        Collection::Set => {
                            items.sort();
                            items.dedup();
                        }
                    }
                    add(items, store.and(guard, condition)?)?;
                }
            }
            if longer.len() > MAX_COMBINATIONS {
                return Err(many(origin));
            }
            partial = longer;
            it.alive(path)
        })?;
        let mut value = Guarded::default();
        for (items, guard) in partial {
            let guard = self.alive(&guard)?;
            value.add(self.store, collected(collection, items), &guard)?;
        }
        Ok(value)
    }
}

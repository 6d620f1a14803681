//! What the reader asks of a file, written down while it reads: the dialect, as the reader knows it.

use std::collections::{BTreeMap, BTreeSet};

/// The ways in which a value may be written. None where nobody asks: then it may be anything.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Asked {
    pub ways: Vec<Way>,
}

/// A way in which a value may be written.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Way {
    /// However one likes.
    Any,
    /// A text.
    Text,
    /// A text in which something is substituted.
    Substituted,
    /// `true` or `false`.
    Flag,
    /// A whole number within a range.
    Whole(i64, i64),
    /// A number within a range.
    Real(f64, f64),
    /// One of these words.
    Word(Vec<String>),
    /// A list.
    List(Asked),
    /// A table of names.
    Names(Asked),
    /// A table with these keys.
    Table(Fields),
}

/// The keys of a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Fields {
    /// What the table describes, as in "a wire".
    pub of: &'static str,
    pub keys: BTreeMap<&'static str, Field>,
    /// Of these keys there is exactly one.
    pub one_of: &'static [&'static str],
    /// Those of them that were there when the tables were read.
    chosen: BTreeSet<&'static str>,
}

/// A key.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Field {
    pub asked: Asked,
    /// Whether it must be there.
    pub needed: bool,
    /// A value, as TOML writes it.
    pub example: Option<String>,
    /// With which of the `one_of` keys it was asked for.
    with: BTreeSet<&'static str>,
}

impl Way {
    pub(crate) fn word<'w>(words: impl Iterator<Item = &'w str>) -> Self {
        Self::Word(words.map(str::to_owned).collect())
    }
}

impl Asked {
    /// One more way.
    pub(crate) fn add(&mut self, way: Way) {
        for known in &mut self.ways {
            match (known, &way) {
                (Way::List(known), Way::List(more)) | (Way::Names(known), Way::Names(more)) => {
                    return known.merge(more.clone());
                }
                (Way::Table(known), Way::Table(more)) if known.of == more.of => {
                    return known.merge(more.clone());
                }
                (known, way) if *known == *way => return,
                _ => {}
            }
        }
        self.ways.push(way);
    }

    pub(crate) fn merge(&mut self, more: Self) {
        for way in more.ways {
            self.add(way);
        }
    }
}

impl Fields {
    pub(crate) fn new(of: &'static str) -> Self {
        Self {
            of,
            ..Self::default()
        }
    }

    /// Of these keys `chosen` is there, if any is.
    pub(crate) fn choose(&mut self, one_of: &'static [&'static str], chosen: Option<&'static str>) {
        self.one_of = one_of;
        self.chosen.extend(chosen);
    }

    /// The key of `one_of` without which this key is unknown.
    pub(crate) fn depends(&self, field: &Field) -> Option<&'static str> {
        let mut with = field.with.iter();
        match (with.next(), with.next()) {
            (Some(only), None) if self.chosen.len() > 1 => Some(only),
            _ => None,
        }
    }

    /// The table has been read.
    pub(crate) fn close(&mut self) {
        for field in self.keys.values_mut() {
            field.with.extend(self.chosen.iter().copied());
        }
    }

    /// What another table of this kind was asked for: only what all of them need is needed.
    fn merge(&mut self, more: Self) {
        for (key, field) in &mut self.keys {
            field.needed &= more.keys.get(key).is_some_and(|more| more.needed);
        }
        for (key, more) in more.keys {
            match self.keys.get_mut(key) {
                Some(field) => {
                    field.asked.merge(more.asked);
                    field.with.extend(more.with);
                    field.example = field.example.take().or(more.example);
                }
                None => {
                    let needed = false;
                    self.keys.insert(key, Field { needed, ..more });
                }
            }
        }
        self.chosen.extend(more.chosen);
        if self.one_of.is_empty() {
            self.one_of = more.one_of;
        }
    }
}

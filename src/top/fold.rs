//! Folds components that differ only in a number, as the instances of one element of a composite do, into one row.

use std::borrow::Cow;
use std::collections::BTreeMap;

use asmotion_plan::{MANY_NUMBERED, NumberedName};
use asmotion_remote::PresentComponent;

use super::board::BoardComponent;

/// Replaces components whose names differ only in their first number, and which are in the same process and state, by one row for all
/// of them, in the place of the first one.
pub(super) fn folded(components: Vec<BoardComponent<'_>>) -> Vec<BoardComponent<'_>> {
    let mut families: BTreeMap<_, Vec<usize>> = BTreeMap::new();
    for (position, it) in components.iter().enumerate() {
        if let Some(NumberedName { before, after, .. }) = NumberedName::of(&it.present.name) {
            let state = (it.present.state.as_str(), it.silence.is_some());
            let family = (it.robot, it.process, before, after, state);
            families.entry(family).or_default().push(position);
        }
    }
    let families: Vec<Vec<usize>> = families.into_values().collect();
    let families = families.into_iter().filter(|it| it.len() >= MANY_NUMBERED);
    let mut rows: Vec<Option<BoardComponent<'_>>> = components.into_iter().map(Some).collect();
    for family in families.collect::<Vec<_>>() {
        let mut members = family.iter().filter_map(|it| rows.get_mut(*it)?.take());
        let Some(first) = members.next() else {
            continue;
        };
        let row = members.fold(Folded::new(first), Folded::with).row();
        if let Some(place) = family.first().and_then(|it| rows.get_mut(*it)) {
            *place = Some(row);
        }
    }
    rows.into_iter().flatten().collect()
}

/// Returns whether a row stands for several components.
pub(super) fn is_fold(component: &BoardComponent<'_>) -> bool {
    matches!(component.present, Cow::Owned(_))
}

/// A row of several components.
struct Folded<'b> {
    first: BoardComponent<'b>,
    /// Sums, extremes, and means times `count`.
    present: PresentComponent,
    count: u32,
    /// The names, of which the first and the last number are shown.
    least: u64,
    greatest: u64,
}

impl<'b> Folded<'b> {
    fn new(first: BoardComponent<'b>) -> Self {
        let present = PresentComponent::clone(&first.present);
        let number = number(&present.name);
        Self {
            first,
            present,
            count: 1,
            least: number,
            greatest: number,
        }
    }

    fn with(mut self, other: BoardComponent<'b>) -> Self {
        let (sum, other) = (&mut self.present, &*other.present);
        sum.cycles += other.cycles;
        sum.rate_hz += other.rate_hz;
        sum.overruns += other.overruns;
        sum.late += other.late;
        sum.cycle_mean_ms += other.cycle_mean_ms;
        sum.cycle_max_ms = sum.cycle_max_ms.max(other.cycle_max_ms);
        sum.dropped += other.dropped;
        sum.misfits += other.misfits;
        sum.properties.retain(|it| other.properties.contains(it));
        // a control state that not all have
        if sum.inspection != other.inspection {
            sum.inspection.clear();
        }
        let number = number(&other.name);
        self.least = self.least.min(number);
        self.greatest = self.greatest.max(number);
        self.count += 1;
        self
    }

    fn row(self) -> BoardComponent<'b> {
        let mut present = self.present;
        present.rate_hz /= f64::from(self.count);
        present.cycle_mean_ms /= f64::from(self.count);
        if let Some(name) = NumberedName::of(&present.name) {
            let range = name.of_range((self.least, self.greatest));
            present.name = format!("{range} ×{}", self.count);
        }
        BoardComponent {
            present: Cow::Owned(present),
            ..self.first
        }
    }
}

fn number(name: &str) -> u64 {
    let number = NumberedName::of(name).and_then(NumberedName::number);
    number.unwrap_or_default()
}

//! The components of a recorded run at any time: the composite that ran then, and what events say until then.

use std::collections::BTreeMap;

use asmotion_component::Time;
use asmotion_datum::Datum;
use asmotion_remote::{Presence, PresentComponent};

use super::RecordedSteps;
use super::composition::Composition;
use super::moment::{PATIENCE_S, REGULAR_FACTOR, seconds_until};
use crate::rendering;

/// Number of steps over which a rate is measured.
const RATE_STEPS: usize = 32;

/// Values by time, oldest first.
type TimedValues<T> = Vec<(Time, T)>;

/// The newest value up to a time.
fn at<T>(history: &TimedValues<T>, t: f64) -> Option<&T> {
    let known = history.partition_point(|(at, _)| seconds_until(*at, t));
    Some(&history.get(known.checked_sub(1)?)?.1)
}

/// The components of a recorded run.
#[derive(Default)]
pub(super) struct RecordedComponents {
    /// Versions of the composite with the times from which they run, oldest first.
    versions: TimedValues<Composition>,
    lives: BTreeMap<String, ComponentLife>,
    /// Losses on the way to an input, `Component.port`.
    lost: BTreeMap<String, TimedValues<u64>>,
    /// Messages that wait at an input or a service, `Component.port`.
    waiting: BTreeMap<String, TimedValues<u64>>,
}

/// What events say about a component.
#[derive(Default)]
struct ComponentLife {
    states: TimedValues<String>,
    /// Missed periods so far.
    overruns: TimedValues<u64>,
    /// Cycles that exceeded their deadline so far.
    late: TimedValues<u64>,
    properties: TimedValues<(String, Datum)>,
}

impl RecordedComponents {
    /// Takes a version of the composite that runs from this time on.
    pub(super) fn follow(&mut self, from: Time, composition: Composition) {
        self.versions.push((from, composition));
        self.versions.sort_by_key(|(from, _)| *from);
    }

    /// Names of all components, in the order of the composites, with their implementations.
    pub(super) fn names(&self) -> impl Iterator<Item = (&str, &str)> {
        self.versions.iter().flat_map(|(_, version)| {
            version.presence.components.iter().map(|component| {
                let implementation = version.implementations.get(&component.name);
                (&*component.name, implementation.map_or("", |it| &**it))
            })
        })
    }

    /// Takes the record of an event.
    pub(super) fn event(&mut self, time: Time, record: &Datum) {
        let text = |member: &str| {
            let value = record.get(member);
            value
                .and_then(|it| it.as_text().map(str::to_owned))
                .unwrap_or_default()
        };
        let count = |member: &str| {
            let count = record.get(member).and_then(|it| it.as_int()).unwrap_or(0);
            u64::try_from(count).unwrap_or(0)
        };
        let kind = text("kind");
        if kind == "dropped" {
            // the count is that of the connection so far
            let history = self.lost.entry(text("to")).or_default();
            history.push((time, count("count")));
            return;
        }
        let life = self.lives.entry(text("component")).or_default();
        let more = |history: &mut TimedValues<u64>, by: u64| {
            let so_far = history.last().map_or(0, |(_, count)| *count);
            history.push((time, so_far + by));
        };
        match &*kind {
            "life_cycle" => life.states.push((time, text("to"))),
            "overrun" => more(&mut life.overruns, count("count")),
            "late" => more(&mut life.late, 1),
            "property" => {
                let value = record
                    .get("value")
                    .map_or(Datum::Null, |it| it.into_owned());
                life.properties.push((time, (text("property"), value)));
            }
            _ => {}
        }
    }

    /// Takes a record of the numbers of messages that wait. What it does not name has none.
    pub(super) fn queues(&mut self, time: Time, record: &Datum) {
        let waiting = record.get("waiting");
        let waiting = waiting.and_then(|it| it.to::<BTreeMap<String, u64>>().ok());
        let waiting = waiting.unwrap_or_default();
        for (name, history) in &mut self.waiting {
            if !waiting.contains_key(name) && history.last().is_some_and(|(_, last)| *last > 0) {
                history.push((time, 0));
            }
        }
        for (name, count) in waiting {
            self.waiting.entry(name).or_default().push((time, count));
        }
    }

    /// The components at a time as JSON, in the form of a running system; `null` if the composite is not attached.
    pub(super) fn json(&self, t: f64, steps: &BTreeMap<String, RecordedSteps>) -> String {
        let version = at(&self.versions, t).or_else(|| Some(&self.versions.first()?.1));
        let Some(version) = version else {
            return "null".to_owned();
        };
        let mut presence: Presence = version.presence.clone();
        for component in &mut presence.components {
            self.complete(component, t, steps.get(&component.name));
        }
        let datum = Datum::of(&presence);
        datum.map_or_else(|_| "null".to_owned(), |it| rendering::json(&it))
    }

    fn complete(&self, component: &mut PresentComponent, t: f64, steps: Option<&RecordedSteps>) {
        if let Some(life) = self.lives.get(&component.name) {
            component.state = at(&life.states, t).cloned().unwrap_or_default();
            component.overruns = at(&life.overruns, t).copied().unwrap_or(0);
            component.late = at(&life.late, t).copied().unwrap_or(0);
            let set = life.properties.iter();
            for (_, (name, value)) in set.take_while(|(time, _)| seconds_until(*time, t)) {
                match component.properties.iter_mut().find(|it| it.0 == *name) {
                    Some(known) => known.1 = value.clone(),
                    None => component.properties.push((name.clone(), value.clone())),
                }
            }
        }
        let lost = |end: &str| {
            let lost = self.lost.get(&format!("{}.{end}", component.name));
            lost.and_then(|it| at(it, t)).copied().unwrap_or(0)
        };
        let waiting = |end: &str| {
            let waiting = self.waiting.get(&format!("{}.{end}", component.name));
            waiting.and_then(|it| at(it, t)).copied().unwrap_or(0)
        };
        for input in &mut component.inputs {
            input.waiting = waiting(&input.name);
            input.lost = lost(&input.name);
            component.dropped += input.lost;
        }
        let inside = self.waiting.get(&component.name);
        component.waiting = inside.and_then(|it| at(it, t)).copied().unwrap_or(0);
        for service in &mut component.services {
            service.waiting = waiting(&service.name);
            service.refused = lost(&service.name);
            component.dropped += service.refused;
        }
        if let Some(steps) = steps {
            (component.cycles, component.rate_hz) = steps.pace(t);
        }
    }
}

impl RecordedSteps {
    /// Number of steps up to a time, and steps per second of the last ones; 0 if they have ended.
    fn pace(&self, t: f64) -> (u64, f64) {
        let made = self.steps.partition_point(|(at, _)| seconds_until(*at, t));
        let recent = self.steps.get(made.saturating_sub(RATE_STEPS)..made);
        let [(first, _), .., (last, _)] = recent.unwrap_or_default() else {
            return (made as u64, 0.0);
        };
        let gap = last.since(*first).as_secs_f64() / (recent.map_or(1, <[_]>::len) - 1) as f64;
        let is_over = t - last.seconds() > (gap * REGULAR_FACTOR).max(PATIENCE_S);
        let rate = if gap > 0.0 && !is_over {
            gap.recip()
        } else {
            0.0
        };
        (made as u64, rate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asmotion_component::Span;
    use asmotion_coordinator::StepRecord;
    use serde_json::Value;

    fn component(all: &RecordedComponents, t: f64) -> Value {
        let json: Value = serde_json::from_str(&all.json(t, &BTreeMap::new())).expect("JSON");
        json["components"][0].clone()
    }

    #[test]
    fn a_component_has_the_state_and_the_counts_of_its_time() {
        let mut all = RecordedComponents::default();
        assert_eq!(all.json(0.0, &BTreeMap::new()), "null");
        let text = "[components.A]\nports.in = { scan = \"S\" }\nproperties = { n = 1 }\n";
        all.follow(Time::ZERO, Composition::read(text, ""));
        let event = |members: &[(&'static str, Datum)]| {
            let about = [("component", Datum::text("A"))];
            Datum::record(
                about
                    .into_iter()
                    .chain(members.iter().cloned())
                    .collect::<Vec<_>>(),
            )
        };
        let second = |t: u64| Time::ZERO + (t * 1000).ms();
        let life = |to| event(&[("kind", Datum::text("life_cycle")), ("to", Datum::text(to))]);
        let overrun = event(&[("kind", Datum::text("overrun")), ("count", Datum::Int(2))]);
        let dropped = event(&[
            ("kind", Datum::text("dropped")),
            ("to", Datum::text("A.scan")),
            ("count", Datum::Int(7)),
        ]);
        let property = event(&[
            ("kind", Datum::text("property")),
            ("property", Datum::text("n")),
            ("value", Datum::Int(5)),
        ]);
        all.event(second(1), &life("Running"));
        all.event(second(2), &overrun);
        all.event(second(3), &overrun);
        all.event(second(4), &dropped);
        all.event(second(5), &property);
        all.event(second(6), &life("Exception"));
        let state = |t| component(&all, t)["state"].clone();
        assert_eq!(
            [state(0.5), state(1.0), state(6.0)],
            ["", "Running", "Exception"]
        );
        let overruns = |t| component(&all, t)["overruns"].clone();
        assert_eq!([overruns(1.0), overruns(2.0), overruns(9.0)], [0, 2, 4]);
        let lost = |t| component(&all, t)["dropped"].clone();
        assert_eq!([lost(3.9), lost(4.0)], [0, 7]);
        let n = |t| component(&all, t)["properties"][0][1].clone();
        assert_eq!([n(4.0), n(5.0)], [1, 5]);
    }

    #[test]
    fn each_time_has_the_composite_that_ran_then() {
        let mut all = RecordedComponents::default();
        all.follow(Time::ZERO, Composition::read("[components.A]\n", ""));
        let later = Time::ZERO + 5000_u64.ms();
        all.follow(later, Composition::read("[components.B]\n", ""));
        let name = |t| component(&all, t)["name"].clone();
        assert_eq!([name(0.0), name(4.9), name(5.0)], ["A", "A", "B"]);
    }

    #[test]
    fn the_rate_of_steps_falls_to_zero_when_they_end() {
        let mut steps = RecordedSteps::new(&[]);
        for tick in 0..100_u64 {
            steps.push(Time::ZERO + (tick * 50).ms(), StepRecord::default(), None);
        }
        let (made, rate) = steps.pace(2.0);
        assert_eq!((made, rate.round()), (41, 20.0));
        assert_eq!(steps.pace(4.96), (100, 20.0));
        assert_eq!(steps.pace(9.0), (100, 0.0));
    }
}

//! The guards on the way to the updates of a step, with the values that they had.
//!
//! A step reports what it has read and written, and not how it came to that. So it is repeated when somebody asks, by a machine of its
//! own in the state before the step, with the same inputs and choices. What comes out has to be the reported update set: otherwise
//! nothing is claimed.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use asmotion_component::Time;
use asmotion_coordinator::StepRecord;
use asmotion_lang::guards::PassedGuard;
use asmotion_lang::machine::Machine;
use asmotion_lang::simulate::{self, RecordedStep};
use asmotion_lang::{
    FirstChoice, FunctionKind, MemoryFiles, NoInputs, Session, Specification, open,
};
use serde_json::{Value, json};

/// Limit on the number of specifications that are kept open.
const MOST: usize = 16;
/// Number of steps after which a specification is opened anew: it keeps every text that was evaluated in it.
const USES: u32 = 256;

/// A step with all that determines it.
pub(crate) struct KnownStep {
    /// Values of locations before the step, as text.
    pub before: Vec<(String, String)>,
    pub record: StepRecord,
    pub at: Time,
}

/// Texts of a specification by path, the main one first.
pub(crate) type SpecificationTexts = Vec<(String, Arc<str>)>;

/// Repeats steps.
#[derive(Default)]
pub(crate) struct StepRepeater(Mutex<BTreeMap<SpecificationTexts, OpenSpecification>>);

/// A specification whose steps are repeated.
struct OpenSpecification {
    session: Session,
    /// The machine in its initial state.
    initial: Machine,
    uses: u32,
}

impl StepRepeater {
    /// The updates of a step with the guards on the way to each, outermost first, as JSON.
    ///
    /// # Errors
    /// The reason that the step cannot be repeated, in words.
    pub(crate) fn guards(
        &self,
        texts: SpecificationTexts,
        step: &KnownStep,
    ) -> Result<Value, String> {
        if let Some(rule) = &step.record.safe_rule {
            return Err(format!("the safe rule `{rule}` made this step"));
        }
        let mut open = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if open.get(&texts).is_none_or(|known| known.uses >= USES) {
            let opened = OpenSpecification::of(&texts)?;
            if open.len() == MOST {
                open.clear();
            }
            open.insert(texts.clone(), opened);
        }
        let known = open.get_mut(&texts).ok_or_else(String::new)?;
        known.guards(step)
    }
}

impl OpenSpecification {
    fn of(texts: &SpecificationTexts) -> Result<Self, String> {
        let unknown = || "the text of the specification is not known".to_owned();
        let (main, _) = texts.first().ok_or_else(unknown)?;
        let mut files = MemoryFiles::new();
        for (path, text) in texts {
            files.add(path, Arc::clone(text));
        }
        let specification = open(main, &files).map_err(|_| unknown())?;
        let session = Session::new(specification).map_err(|_| unknown())?;
        Ok(Self {
            initial: session.machine.clone(),
            session,
            uses: 0,
        })
    }

    fn guards(&mut self, step: &KnownStep) -> Result<Value, String> {
        self.uses += 1;
        self.go_to(&step.before)?;
        let before = self.session.machine.clone();
        let machine = &mut before.clone();
        let record = &step.record;
        let choices = record.choices.iter();
        let choices = choices.map(|(index, _)| usize::try_from(*index).unwrap_or(usize::MAX));
        let (inputs, choices) = (Arc::new(record.inputs.clone()), choices.collect());
        let recorded = RecordedStep::with_frame(step.at.nanos(), inputs, choices, Vec::new());
        let (mut inputs, _) = recorded.readable_inputs(machine);
        // a step that breaks an invariant has made its updates
        let _ = machine.step(&mut inputs, &mut recorded.choices(), recorded.now_ns);
        let made = simulate::updates(machine, &machine.last_step());
        let made = made.iter().map(|(location, _, after)| (location, after));
        let reported = record.updates.iter();
        if !made.eq(reported.map(|it| (&it.location, &it.after))) {
            let reason = "a repetition of the step makes other updates: it depends on more than is known of it";
            return Err(reason.to_owned());
        }
        Ok(updates(&self.session.specification, machine, &before))
    }

    /// Brings the machine into a state.
    fn go_to(&mut self, state: &[(String, String)]) -> Result<(), String> {
        let Session {
            specification,
            machine,
            ..
        } = &mut self.session;
        *machine = self.initial.clone();
        // its program may have been lowered again since then
        let _ = machine.replace_program(specification.program.clone());
        let known: BTreeMap<_, _> = simulate::state(machine).into_iter().collect();
        let is_set = |location: &str| {
            let name = location.split('(').next().unwrap_or(location);
            let mut own = specification.model.own_functions();
            own.any(|(_, it)| &*it.name == name && it.kind != FunctionKind::Monitored)
        };
        let is_new = |location: &str, value: &str| match known.get(location) {
            Some(known) => known != value,
            None => value != "undef",
        };
        let new = state.iter();
        let new = new.filter(|(location, value)| is_new(location, value) && is_set(location));
        let updates: Vec<String> = new.map(|(at, value)| format!("{at} := {value}")).collect();
        if updates.is_empty() {
            return Ok(());
        }
        let rule = format!("par\n{}\nendpar", updates.join("\n"));
        let fired = self
            .session
            .fire(&rule, &mut NoInputs, &mut FirstChoice, 0)
            .map(|_| ());
        fired.map_err(|_| "the state before the step has values without a notation".to_owned())
    }
}

/// The updates of a machine's last step with their guards.
fn updates(specification: &Specification, machine: &Machine, before: &Machine) -> Value {
    let last = machine.last_step();
    let update = |update: &asmotion_lang::machine::Update| {
        let at = machine.state().location(machine.program(), update.slot);
        let guards = at.map(|(function, arguments)| {
            specification.guards_of_update(machine, before, function, &arguments)
        });
        let guards = guards.unwrap_or_default();
        let rule = specification.rule_at(specification.span(update.origin));
        json!({
            "location": simulate::location(machine, update.slot),
            "place": specification.place(update.origin),
            "rule": rule.map(|rule| rule.name.to_string()),
            "guards": guards.iter().map(|it| guard(specification, it)).collect::<Vec<_>>(),
        })
    };
    last.updates().iter().map(update).collect()
}

fn guard(specification: &Specification, guard: &PassedGuard) -> Value {
    let PassedGuard {
        text,
        holds,
        values,
        place,
    } = guard;
    let sources = &specification.sources;
    let (line, _) = sources.position(place.file, place.start);
    let path = sources.path(place.file);
    let file = path.rsplit('/').next().unwrap_or(path);
    json!({ "text": text, "holds": holds, "values": values, "place": format!("{file}:{line}") })
}

#[cfg(test)]
mod tests {
    use super::*;
    use asmotion_coordinator::UpdateRecord;

    const TEXT: &str = "asm drive
import StandardLibrary
signature:
  enum domain Mode = {IDLE | DRIVING}
  monitored distance: Real
  controlled mode: Mode
  controlled tries: Integer
  controlled said: String
definitions:
  main rule r_Main =
    if mode = DRIVING then
      if distance < 0.25 then
        par
          mode := IDLE
          tries := tries + 1
        endpar
      endif
    else
      said := \"waiting\"
    endif
default init s0:
  function mode = IDLE
  function tries = 0
  function said = \"\"
";

    fn texts() -> SpecificationTexts {
        vec![("a/drive.asm".to_owned(), TEXT.into())]
    }

    fn pairs(pairs: &[(&str, &str)]) -> Vec<(String, String)> {
        let owned = pairs.iter();
        owned
            .map(|(one, other)| ((*one).to_owned(), (*other).to_owned()))
            .collect()
    }

    fn step(before: &[(&str, &str)], distance: &str, updates: &[(&str, &str)]) -> KnownStep {
        let updates = pairs(updates).into_iter();
        let updates = updates.map(|(location, after)| UpdateRecord {
            location,
            after,
            ..UpdateRecord::default()
        });
        KnownStep {
            before: pairs(before),
            record: StepRecord {
                number: 7,
                inputs: pairs(&[("distance", distance)]),
                updates: updates.collect(),
                ..StepRecord::default()
            },
            at: Time::ZERO,
        }
    }

    #[test]
    fn the_guards_of_a_step_have_the_values_of_that_step() {
        let repeater = StepRepeater::default();
        let before = [
            ("mode", "DRIVING"),
            ("tries", "4"),
            ("said", "\"a \\\" b\""),
            ("distance", "9.0"),
        ];
        let arrived = step(&before[..2], "0.21", &[("mode", "IDLE"), ("tries", "5")]);
        let found = repeater.guards(texts(), &arrived).unwrap();
        let of = |found: &Value, index: usize| {
            let guards = found[index]["guards"].as_array().unwrap().clone();
            let shown = guards.iter().map(|it| {
                let place = it["place"].as_str().unwrap();
                let (text, values) = (it["text"].as_str().unwrap(), &it["values"]);
                format!("{place} {text} {} {values}", it["holds"])
            });
            shown.collect::<Vec<_>>()
        };
        let expected = [
            "drive.asm:11 mode = DRIVING true [[\"mode\",\"DRIVING\"]]",
            "drive.asm:12 distance < 0.25 true [[\"distance\",\"0.21\"]]",
        ];
        assert_eq!([of(&found, 0), of(&found, 1)], [expected, expected]);
        assert_eq!(
            (&found[0]["location"], &found[0]["rule"]),
            (&json!("mode"), &json!("r_Main"))
        );
        // the other branch, from another state, with the same machine
        let waited = step(&[("mode", "IDLE")], "9.0", &[("said", "\"waiting\"")]);
        let found = repeater.guards(texts(), &waited).unwrap();
        assert_eq!(
            of(&found, 0),
            ["drive.asm:11 mode = DRIVING false [[\"mode\",\"IDLE\"]]"]
        );
        assert!(repeater.guards(texts(), &arrived).is_ok());
    }

    #[test]
    fn nothing_is_claimed_of_a_step_that_cannot_be_repeated() {
        let repeater = StepRepeater::default();
        // nearer than it was
        let other = step(&[("mode", "DRIVING")], "0.31", &[("mode", "IDLE")]);
        let refused = repeater.guards(texts(), &other).unwrap_err();
        assert!(refused.contains("other updates"), "{refused}");
        let unknown = step(&[("tries", "<unknown>")], "0.1", &[]);
        assert!(repeater.guards(texts(), &unknown).is_err());
        assert!(repeater.guards(Vec::new(), &other).is_err());
        let mut safe = step(&[("mode", "DRIVING")], "0.1", &[("mode", "IDLE")]);
        safe.record.safe_rule = Some("r_Stop".to_owned());
        assert!(
            repeater
                .guards(texts(), &safe)
                .unwrap_err()
                .contains("r_Stop")
        );
    }
}

//! Every component of the catalogue can be frozen and thawed and rejects states of other components.

use asmotion_component::{Component, FrozenState, Interface, ThawProblem};
use asmotion_components::COMPONENTS;
use asmotion_datum::{Datum, cbor};
use proptest::prelude::*;

/// Creates a component with its registered constructor.
fn made(name: &str) -> Box<dyn Component> {
    asmotion_components::component(name).unwrap()(&mut Interface::new())
}

/// Returns a state with modified fields.
fn tampered(frozen: &FrozenState, change: impl Fn(&mut Vec<(String, Datum)>)) -> FrozenState {
    let Datum::Record(entries) = Datum::of(frozen).unwrap() else {
        panic!("a frozen state is a record");
    };
    let mut entries = entries
        .into_iter()
        .map(|(name, value)| (name.into_owned(), value))
        .collect();
    change(&mut entries);
    Datum::record(entries).to().unwrap()
}

fn with(frozen: &FrozenState, field: &str, value: &Datum) -> FrozenState {
    tampered(frozen, |entries| {
        let entry = entries.iter_mut().find(|(name, _)| name == field);
        entry.unwrap().1 = value.clone();
    })
}

#[test]
fn every_component_is_the_type_that_its_state_names() {
    for (name, _) in COMPONENTS {
        let frozen = made(name).freeze().unwrap();
        assert_eq!(frozen.component(), *name);
        assert!(frozen.version() >= 1);
    }
}

#[test]
fn a_thawed_component_freezes_to_the_same_state_any_number_of_times() {
    for (name, _) in COMPONENTS {
        let frozen = made(name).freeze().unwrap();
        let (mut one, mut other) = (made(name), made(name));
        for component in [&mut one, &mut other] {
            for _ in 0..2 {
                component.thaw(&frozen).unwrap();
                assert_eq!(component.freeze().unwrap(), frozen, "{name}");
            }
        }
    }
}

#[test]
fn no_component_takes_the_state_of_another_type_or_layout() {
    for (name, _) in COMPONENTS {
        let mut component = made(name);
        let own = component.freeze().unwrap();
        for (other, _) in COMPONENTS.iter().filter(|(other, _)| other != name) {
            let refused = component.thaw(&made(other).freeze().unwrap()).unwrap_err();
            assert_eq!(
                refused.problem,
                ThawProblem::ComponentMismatch((*other).to_owned())
            );
        }
        let (layout, next) = (own.version(), own.version() + 1);
        let newer = with(&own, "version", &Datum::Int(next.into()));
        assert_eq!(
            component.thaw(&newer).unwrap_err().to_string(),
            format!(
                "`{name}` rejects the frozen state: it has layout {next}, and this build has layout {layout}"
            )
        );
        assert_eq!(component.freeze().unwrap(), own);
    }
}

#[test]
fn a_state_that_ends_too_early_is_refused_wherever_it_ends() {
    for (name, _) in COMPONENTS {
        let mut component = made(name);
        let own = component.freeze().unwrap();
        for end in 0..own.as_bytes().len() {
            let bytes = Datum::Bytes(own.as_bytes()[..end].into());
            let refused = component.thaw(&with(&own, "fields", &bytes)).unwrap_err();
            assert!(
                matches!(refused.problem, ThawProblem::Malformed(_)),
                "{name} at {end}: {refused}"
            );
        }
        assert_eq!(component.freeze().unwrap(), own);
    }
}

#[test]
fn a_missing_an_unknown_and_a_repeated_field_are_refused_by_name() {
    let mut operator = made("youbot::Operator");
    let own = operator.freeze().unwrap();
    let Datum::Record(fields) = own.to_datum().unwrap() else {
        panic!("fields are a record");
    };
    let mut refusal = |fields: Vec<_>| {
        let bytes = cbor::encode(&Datum::Record(fields)).unwrap();
        let state = with(&own, "fields", &Datum::Bytes(bytes.into()));
        operator.thaw(&state).unwrap_err().to_string()
    };
    let with = |name: &str, added: Vec<_>| {
        let kept = fields.iter().filter(|(known, _)| known != name);
        kept.cloned().chain(added).collect::<Vec<_>>()
    };
    let of = "`youbot::Operator` rejects the frozen state:";
    for (wrong, problem) in [
        (with("next", vec![]), "expected the field `next` once"),
        (
            with("", vec![("next".into(), Datum::Int(1))]),
            "the field `next` occurs twice",
        ),
        (
            with("", vec![("nest".into(), Datum::Null)]),
            "unknown field `nest`",
        ),
        (
            with("next", vec![("next".into(), Datum::text("first"))]),
            "`next`: invalid type: string \"first\", expected usize",
        ),
    ] {
        assert_eq!(refusal(wrong), format!("{of} {problem}"));
    }
}

#[test]
fn a_component_that_does_not_freeze_says_so_by_name() {
    struct Stranger;

    impl Component for Stranger {
        fn update(
            &mut self,
            _: &mut asmotion_component::Cycle<'_>,
        ) -> Result<(), asmotion_component::Fault> {
            Ok(())
        }
    }

    let refused = Stranger.freeze().unwrap_err().to_string();
    assert!(
        refused.contains("Stranger` cannot be frozen: it does not implement `Component::freeze`"),
        "{refused}"
    );
    let own = made("youbot::Operator").freeze().unwrap();
    let refused = Stranger.thaw(&own).unwrap_err().to_string();
    assert!(
        refused.contains("does not implement `Component::thaw`"),
        "{refused}"
    );
}

/// Lengths of 2⁴⁷ − 1 elements without content must not cause an allocation.
#[test]
fn a_length_that_is_not_there_allocates_nothing() {
    let own = made("nav::Operator").freeze().unwrap();
    for head in [0x5b_u8, 0x7b, 0x9b, 0xbb] {
        let bytes = [&[head][..], &0x7fff_ffff_ffff_u64.to_be_bytes()].concat();
        let state = with(&own, "fields", &Datum::Bytes(bytes.into()));
        assert!(made("nav::Operator").thaw(&state).is_err());
    }
}

proptest! {
    #[test]
    fn bytes_from_a_stranger_are_refused_and_never_panic(
        which in 0..COMPONENTS.len(),
        bytes in prop::collection::vec(any::<u8>(), 0..200),
    ) {
        let mut component = made(COMPONENTS[which].0);
        let own = component.freeze().unwrap();
        let state = with(&own, "fields", &Datum::Bytes(bytes.as_slice().into()));
        if component.thaw(&state).is_err() {
            prop_assert_eq!(component.freeze().unwrap(), own);
        }
        let _ = cbor::decode::<FrozenState>(&bytes);
    }

    /// Modified bytes are either rejected or accepted as a state that can be frozen and thawed again.
    #[test]
    fn changed_bytes_are_refused_or_are_a_state(
        which in 0..COMPONENTS.len(),
        at: prop::sample::Index,
        byte: u8,
    ) {
        let mut component = made(COMPONENTS[which].0);
        let own = component.freeze().unwrap();
        let mut bytes = own.as_bytes().to_vec();
        let at = at.index(bytes.len());
        bytes[at] = byte;
        match component.thaw(&with(&own, "fields", &Datum::Bytes(bytes.into()))) {
            Err(_) => prop_assert_eq!(component.freeze().unwrap(), own),
            Ok(()) => {
                let thawed = component.freeze().unwrap();
                component.thaw(&thawed).unwrap();
                prop_assert_eq!(component.freeze().unwrap(), thawed);
            }
        }
    }
}

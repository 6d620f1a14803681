//! The life cycle of a component as that of a managed node of ROS 2.
//!
//! | component | managed node |
//! |---|---|
//! | `Init`, `PreOperational`, `Exception` | unconfigured |
//! | `Stopped` | inactive |
//! | `Running`, `RunTimeError` | active |
//! | `FatalError`, or shut down from ROS | finalized |
//!
//! A failure goes through the state `errorprocessing`, as in ROS 2. Source of names and numbers: `lifecycle_msgs` and rcl's
//! `default_state_machine.c`.

use asmotion_component::{State, Transition};
use asmotion_datum::Datum;

/// A state of a managed node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum NodeState {
    Unconfigured = 1,
    Inactive = 2,
    Active = 3,
    Finalized = 4,
    Configuring = 10,
    CleaningUp = 11,
    ShuttingDown = 12,
    Activating = 13,
    Deactivating = 14,
    ErrorProcessing = 15,
}

impl NodeState {
    const ALL: [Self; 10] = [
        Self::Unconfigured,
        Self::Inactive,
        Self::Active,
        Self::Finalized,
        Self::Configuring,
        Self::CleaningUp,
        Self::ShuttingDown,
        Self::Activating,
        Self::Deactivating,
        Self::ErrorProcessing,
    ];

    /// The state of a component's node, which nobody has shut down.
    pub(crate) fn of(state: State) -> Self {
        match state {
            State::Init | State::PreOperational | State::Exception => Self::Unconfigured,
            State::Stopped => Self::Inactive,
            State::Running | State::RunTimeError => Self::Active,
            State::FatalError => Self::Finalized,
        }
    }

    fn label(self) -> &'static str {
        match self {
            Self::Unconfigured => "unconfigured",
            Self::Inactive => "inactive",
            Self::Active => "active",
            Self::Finalized => "finalized",
            Self::Configuring => "configuring",
            Self::CleaningUp => "cleaningup",
            Self::ShuttingDown => "shuttingdown",
            Self::Activating => "activating",
            Self::Deactivating => "deactivating",
            Self::ErrorProcessing => "errorprocessing",
        }
    }

    /// `lifecycle_msgs/msg/State`.
    pub(crate) fn message(self) -> Datum {
        named(self as u8, self.label())
    }

    /// The response of `get_available_states`.
    pub(crate) fn all() -> Datum {
        let unknown = named(0, "unknown");
        let known = Self::ALL.into_iter().map(Self::message);
        let all = std::iter::once(unknown).chain(known);
        Datum::record([("available_states", Datum::List(all.collect()))])
    }
}

fn named(id: u8, label: &str) -> Datum {
    Datum::record([("id", Datum::Int(id.into())), ("label", Datum::text(label))])
}

/// A transition that a client of ROS can ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NodeTransition {
    id: u8,
    pub(crate) label: &'static str,
    from: NodeState,
    through: NodeState,
    pub(crate) to: NodeState,
    /// Number of the transition `transition_success` that ends it.
    success: u8,
}

const fn transition(
    (id, label): (u8, &'static str),
    from: NodeState,
    through: NodeState,
    to: NodeState,
    success: u8,
) -> NodeTransition {
    NodeTransition {
        id,
        label,
        from,
        through,
        to,
        success,
    }
}

const TRANSITIONS: [NodeTransition; 7] = {
    use NodeState::{
        Activating, Active, CleaningUp, Configuring, Deactivating, Finalized, Inactive,
        ShuttingDown, Unconfigured,
    };
    [
        transition((1, "configure"), Unconfigured, Configuring, Inactive, 10),
        transition((2, "cleanup"), Inactive, CleaningUp, Unconfigured, 20),
        transition((3, "activate"), Inactive, Activating, Active, 30),
        transition((4, "deactivate"), Active, Deactivating, Inactive, 40),
        transition((5, "shutdown"), Unconfigured, ShuttingDown, Finalized, 50),
        transition((6, "shutdown"), Inactive, ShuttingDown, Finalized, 50),
        transition((7, "shutdown"), Active, ShuttingDown, Finalized, 50),
    ]
};

impl NodeTransition {
    /// The transition that `change_state` names, by its label or else by its number.
    pub(crate) fn requested(from: NodeState, request: &Datum) -> Option<Self> {
        let id = request.get("transition.id").and_then(|it| it.as_int());
        let label = request.get("transition.label");
        let label = label.as_deref().and_then(Datum::as_text).unwrap_or("");
        let mut possible = TRANSITIONS.into_iter().filter(|it| it.from == from);
        possible.find(|it| {
            let is_named = it.label == label;
            is_named || (label.is_empty() && id == Some(i64::from(it.id)))
        })
    }

    /// The response of `get_transition_graph`: the transitions of all states.
    pub(crate) fn graph() -> Datum {
        Self::listed(TRANSITIONS.into_iter())
    }

    /// The response of `get_available_transitions`. A description ends in the state that the transition goes through, as those of
    /// rcl do.
    pub(crate) fn available(from: NodeState) -> Datum {
        Self::listed(TRANSITIONS.into_iter().filter(|it| it.from == from))
    }

    fn listed(some: impl Iterator<Item = Self>) -> Datum {
        let described = some.map(|it| step(named(it.id, it.label), it.from, it.through));
        Datum::record([("available_transitions", Datum::List(described.collect()))])
    }

    /// The transitions of the component, in their order.
    pub(crate) fn of_component(&self, state: State) -> Vec<Transition> {
        let is_failed = state == State::Exception;
        let reset = is_failed.then_some(Transition::ResetException);
        match self.id {
            1 => reset.into_iter().chain([Transition::Configure]).collect(),
            2 => vec![Transition::Cleanup],
            3 => vec![Transition::Start],
            4 => vec![Transition::Stop],
            6 => vec![Transition::Cleanup],
            7 => vec![Transition::Stop, Transition::Cleanup],
            // shut down without a change of the component
            _ => Vec::new(),
        }
    }

    /// The messages of `transition_event`, without their time.
    pub(crate) fn events(&self) -> Vec<Datum> {
        let begun = step(named(self.id, self.label), self.from, self.through);
        let success = named(self.success, "transition_success");
        vec![begun, step(success, self.through, self.to)]
    }
}

/// The messages of `transition_event` for a change that nobody in ROS has asked for, without their time.
pub(crate) fn events_of(from: State, to: State) -> Vec<Datum> {
    let (before, after) = (NodeState::of(from), NodeState::of(to));
    let has_failed = matches!(to, State::Exception | State::FatalError);
    if has_failed {
        let end = if after == NodeState::Finalized {
            named(61, "transition_failure")
        } else {
            named(60, "transition_success")
        };
        return vec![
            step(
                named(99, "transition_error"),
                before,
                NodeState::ErrorProcessing,
            ),
            step(end, NodeState::ErrorProcessing, after),
        ];
    }
    let mut known = TRANSITIONS.into_iter();
    let found = known.find(|it| it.from == before && it.to == after);
    found.map_or(Vec::new(), |it| it.events())
}

/// A transition with its states, in the form of `TransitionDescription` and `TransitionEvent`.
fn step(transition: Datum, from: NodeState, to: NodeState) -> Datum {
    Datum::record([
        ("transition", transition),
        ("start_state", from.message()),
        ("goal_state", to.message()),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(id: u8, label: &str) -> Datum {
        Datum::record([("transition", named(id, label))])
    }

    #[test]
    fn transitions_are_named_by_label_or_number() {
        let found = |from, id, label| {
            let found = NodeTransition::requested(from, &request(id, label));
            found.map(|it| it.id)
        };
        assert_eq!(found(NodeState::Unconfigured, 1, ""), Some(1));
        assert_eq!(found(NodeState::Active, 0, "shutdown"), Some(7));
        assert_eq!(found(NodeState::Inactive, 1, "activate"), Some(3));
        assert_eq!(found(NodeState::Active, 1, ""), None);
        assert_eq!(found(NodeState::Finalized, 1, ""), None);
        assert_eq!(found(NodeState::Inactive, 3, "fly"), None);
        assert_eq!(
            NodeTransition::requested(NodeState::Active, &Datum::Null),
            None
        );
    }

    #[test]
    fn a_failed_component_is_reset_before_it_is_configured() {
        let configure =
            NodeTransition::requested(NodeState::Unconfigured, &request(1, "")).unwrap();
        assert_eq!(
            configure.of_component(State::PreOperational),
            [Transition::Configure]
        );
        assert_eq!(
            configure.of_component(State::Exception),
            [Transition::ResetException, Transition::Configure]
        );
    }

    #[test]
    fn each_change_of_the_component_is_one_of_ros() {
        for from in State::ALL {
            for transition in Transition::ALL {
                let Some(to) = transition.target(from) else {
                    continue;
                };
                let events = events_of(from, to);
                let is_visible = NodeState::of(from) != NodeState::of(to);
                assert_eq!(events.len(), if is_visible { 2 } else { 0 }, "{from} {to}");
            }
        }
        let failure = events_of(State::Running, State::Exception);
        let goals: Vec<_> = failure
            .iter()
            .map(|it| it.get("goal_state.label").unwrap().to_string())
            .collect();
        assert_eq!(goals, ["\"errorprocessing\"", "\"unconfigured\""]);
    }
}

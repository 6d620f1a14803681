//! The services of a managed node of ROS 2.

use asmotion_component::State;
use asmotion_datum::Datum;
use asmotion_ros2::{Node, Publisher, ReplyTo, Server};

use crate::desk::{ComponentWatch, DeskChange, PendingOrder};
use crate::ros2_endpoint::{publisher, reply, since_1970};
use crate::ros2_life_cycle::{NodeState, NodeTransition, events_of};

/// The services of a managed node.
pub(crate) struct LifeCycleServers {
    change: Server,
    state: Server,
    states: Server,
    transitions: Server,
    graph: Server,
    events: Publisher,
    /// Set by a shutdown from ROS; cleared when the component changes its state for another reason.
    is_shut_down: bool,
    pending: Option<PendingTransition>,
    waiting: Vec<(ReplyTo, Datum)>,
}

struct PendingTransition {
    reply_to: ReplyTo,
    transition: NodeTransition,
    order: PendingOrder,
}

impl LifeCycleServers {
    pub(crate) fn new(
        node: &Node,
        service: impl Fn(&str, &str) -> Result<Server, String>,
    ) -> Result<Self, String> {
        let of = |name: &str, kind: &str| service(name, &format!("lifecycle_msgs/srv/{kind}"));
        let event = "lifecycle_msgs/msg/TransitionEvent";
        Ok(Self {
            change: of("change_state", "ChangeState")?,
            state: of("get_state", "GetState")?,
            states: of("get_available_states", "GetAvailableStates")?,
            transitions: of("get_available_transitions", "GetAvailableTransitions")?,
            graph: of("get_transition_graph", "GetAvailableTransitions")?,
            events: publisher(node, "~/transition_event", event, 10)?,
            is_shut_down: false,
            pending: None,
            waiting: Vec::new(),
        })
    }

    fn node_state(&self, state: Option<State>) -> NodeState {
        match state {
            _ if self.is_shut_down => NodeState::Finalized,
            // the system has just begun
            None => NodeState::Unconfigured,
            Some(state) => NodeState::of(state),
        }
    }

    /// Publishes a change of the component's state.
    pub(crate) fn changed(&mut self, from: State, to: State) {
        let shuts_down = self.pending.as_ref();
        if shuts_down.is_some_and(|it| it.transition.to == NodeState::Finalized) {
            // published as one transition, when it has ended
            return;
        }
        self.is_shut_down = false;
        self.publish(events_of(from, to));
    }

    fn publish(&self, events: Vec<Datum>) {
        let now = i64::try_from(since_1970().as_nanos()).unwrap_or(i64::MAX);
        for event in events {
            if let Datum::Record(mut fields) = event {
                fields.push(("timestamp".into(), Datum::Int(now)));
                // a full queue keeps the newest
                let _ = self.events.send(&Datum::Record(fields));
            }
        }
    }

    /// Answers requests. Returns notices with the reasons of transitions that fail.
    pub(crate) fn update(
        &mut self,
        state: Option<State>,
        (component, node): (&str, &str),
        watch: &ComponentWatch,
    ) -> Vec<String> {
        let mut notices = self.take_result(node);
        while let Some(request) = self.change.take() {
            self.waiting.push((request.reply_to, request.request));
        }
        while self.pending.is_none() && !self.waiting.is_empty() {
            let (reply_to, request) = self.waiting.remove(0);
            let from = self.node_state(state);
            let (Some(state), Some(transition)) =
                (state, NodeTransition::requested(from, &request))
            else {
                let wanted = request.get("transition").unwrap_or_default();
                notices.push(format!(
                    "`{node}` cannot make the transition {wanted}: it is {}",
                    from.message()
                ));
                self.succeed(&reply_to, false);
                continue;
            };
            let change = DeskChange::Transitions(transition.of_component(state));
            self.pending = Some(PendingTransition {
                reply_to,
                transition,
                order: watch.order(component, change),
            });
        }
        let now = self.node_state(state);
        let answer = |server: &Server, response: &dyn Fn() -> Datum| {
            while let Some(request) = server.take() {
                reply(server, &request.reply_to, &response());
            }
        };
        answer(&self.state, &|| {
            Datum::record([("current_state", now.message())])
        });
        answer(&self.states, &NodeState::all);
        answer(&self.transitions, &|| NodeTransition::available(now));
        answer(&self.graph, &NodeTransition::graph);
        notices
    }

    fn take_result(&mut self, node: &str) -> Vec<String> {
        let Some(pending) = self.pending.take() else {
            return Vec::new();
        };
        let Some(result) = pending.order.try_take() else {
            self.pending = Some(pending);
            return Vec::new();
        };
        self.succeed(&pending.reply_to, result.is_ok());
        match result {
            Err(reason) => {
                let label = pending.transition.label;
                vec![format!("`{node}`: the transition {label} failed: {reason}")]
            }
            Ok(()) => {
                if pending.transition.to == NodeState::Finalized {
                    self.is_shut_down = true;
                    self.publish(pending.transition.events());
                }
                Vec::new()
            }
        }
    }

    fn succeed(&self, to: &ReplyTo, success: bool) {
        let response = Datum::record([("success", Datum::Bool(success))]);
        reply(&self.change, to, &response);
    }
}

//! Messages on their way are part of a snapshot: a restored machine receives, answers and cancels them like the original.

use crate::support::opened;
use asmotion_lang::ir::FunctionId;
use asmotion_lang::machine::{CallFault, MessageId, Snapshot};
use asmotion_lang::simulate::{agent, sent, state};
use asmotion_lang::{Environment, FirstChoice, Machine, Specification, Value};

const POST: &str = "asm post
import StandardLibrary
import CommonBehavior
signature:
  domain Peer subsetof Agent
  static client: Peer
  static server: Peer
  controlled path: Integer
  controlled told: Integer
  controlled fault: String
  controlled failed: Boolean
  controlled down: Boolean
  controlled asked: Integer
  controlled asker: Agent
  //@Backref
  shared backref: Agent -> Agent
  monitored broken: Boolean
definitions:
  main rule r_Main = par
    r_wcall[server, \"plan\", 7, 200, path]
    r_wreceive[client, \"tell\", told]
    r_wreceive[client, \"ask(Integer,Integer)\", asked]
    if isDef(asked) then r_wreply[client, \"ask(Integer,Integer)\", asked * 2] endif
    asker := backref(self)
    if broken then par failed := true failed := false endpar endif
    if callFault(self, \"plan\") = CALL_TIMEOUT then fault := \"timeout\" endif
    if callFault(self, \"plan\") = CALL_FAILED then fault := \"failed\" endif
    if isDef(callFault(self, \"plan\")) then r_wcancel[server, \"plan\"] endif
  endpar
";

/// Answers `broken`.
struct Broken(bool);

impl Environment for Broken {
    fn read(&mut self, _: FunctionId, arguments: &[Value]) -> Result<Option<Value>, String> {
        Ok(arguments.is_empty().then_some(Value::Bool(self.0)))
    }
}

/// A machine with the values of its agents.
struct Post {
    machine: Machine,
    client: Value,
    server: Value,
}

impl Post {
    /// Creates a machine whose first step, at time 0, makes a call that fails after 200 ms.
    fn new(specification: &Specification) -> Self {
        let machine = specification.machine().unwrap();
        let [client, server] = ["client", "server"].map(|name| agent(name, &machine).unwrap());
        let mut post = Self {
            machine,
            client,
            server,
        };
        let partners = vec![post.client.clone(), post.server.clone()];
        post.machine.set_partners(partners);
        assert_eq!(
            post.step(0).1,
            ["undef -> server: call plan(7) until 200000000 ns"]
        );
        post
    }

    fn deliver(&mut self, operation: &str, number: i64) -> MessageId {
        let (from, to) = (self.client.clone(), Value::Undef);
        self.machine
            .deliver(from, to, operation, Value::Int(number))
    }

    /// Ends the call of the first step.
    fn end(&mut self, outcome: Result<Value, CallFault>) {
        let calls = self.machine.pending_calls();
        self.machine.end_call(calls[0].id, outcome);
    }

    /// Executes a step at a time in milliseconds. Returns the new state and the messages sent, all of which leave.
    fn step(&mut self, now_ms: i64) -> (Vec<(String, String)>, Vec<String>) {
        let now_ns = now_ms * 1_000_000;
        let step = self
            .machine
            .step(&mut Broken(false), &mut FirstChoice, now_ns);
        assert!(step.unwrap().sent().iter().all(|it| it.leaves));
        let messages = self.machine.last_step().sent().iter();
        let messages = messages.map(|it| sent(&self.machine, it)).collect();
        (state(&self.machine), messages)
    }
}

/// An event of a message or a call, by name.
type PostEvent = (&'static str, fn(&mut Post));

/// Events after the first step, all of which lead to different states.
const EVENTS: [PostEvent; 14] = [
    ("nothing", |_| {}),
    ("a message", |post| {
        post.deliver("tell", 1);
    }),
    ("other data", |post| {
        post.deliver("tell", 2);
    }),
    ("two messages", |post| {
        post.deliver("tell", 1);
        post.deliver("tell", 2);
    }),
    ("two messages in the other order", |post| {
        post.deliver("tell", 2);
        post.deliver("tell", 1);
    }),
    ("a request", |post| {
        post.deliver("ask(Integer,Integer)", 1);
    }),
    ("a request that was received", |post| {
        post.deliver("ask(Integer,Integer)", 1);
        post.step(1);
    }),
    ("a call that ended in a failed step", |post| {
        let (now_ns, inputs) = (250_000_000, &mut Broken(true));
        let step = post.machine.step(inputs, &mut FirstChoice, now_ns);
        assert!(step.is_err());
    }),
    ("a reply", |post| post.end(Ok(Value::Int(3)))),
    ("another reply", |post| post.end(Ok(Value::Int(4)))),
    ("a failure", |post| post.end(Err(CallFault::Failed))),
    ("no provider", |post| post.end(Err(CallFault::Unavailable))),
    ("a message that was not sent", |post| {
        post.machine.set_unsent(Value::Undef, "plan");
    }),
    ("a channel that is down", |post| {
        post.machine.set_channel_down(true);
    }),
];

#[test]
fn are_restored_with_the_state() {
    let specification = opened("post", POST);
    let mut states = Vec::new();
    for (name, event) in EVENTS {
        let mut original = Post::new(&specification);
        event(&mut original);
        let snapshot = original.machine.snapshot();
        assert_eq!(snapshot.steps(), original.machine.steps());
        assert!(!states.contains(snapshot.state()), "{name}");
        states.push(snapshot.state().clone());
        let bytes = snapshot.to_bytes();
        let mut restored = Post::new(&specification);
        restored.deliver("tell", 99);
        let read = Snapshot::from_bytes(&bytes).unwrap();
        restored.machine.restore(&read).unwrap();
        assert_eq!(restored.machine.snapshot(), snapshot, "{name}");
        // the packed state alone continues in the same way, apart from the ids of messages
        let mut packed = Post::new(&specification);
        let state = snapshot.state().as_bytes();
        packed.machine.restore_state(state).unwrap();
        assert_eq!(
            packed.machine.snapshot().state(),
            snapshot.state(),
            "{name}"
        );
        for now in [100, 199, 200, 300] {
            let expected = original.step(now);
            assert_eq!(restored.step(now), expected, "{name}, {now} ms");
            assert_eq!(packed.step(now), expected, "{name}, {now} ms");
            let (left, right) = (&restored.machine, &original.machine);
            assert_eq!(left.last_step().sent(), right.last_step().sent(), "{name}");
            assert_eq!(left.last_message(), right.last_message(), "{name}");
            assert_eq!(left.snapshot(), right.snapshot(), "{name}, {now} ms");
        }
    }
}

#[test]
fn the_sender_of_a_request_is_known_until_it_is_answered() {
    let mut post = Post::new(&opened("post", POST));
    let asker = |state: Vec<(String, String)>| {
        let mut all = state.into_iter();
        let found = all.find(|(location, _)| location == "asker");
        found.map(|(_, value)| value)
    };
    assert_eq!(asker(post.step(1).0), None);
    // it waits, is received, and is answered
    post.deliver("ask(Integer,Integer)", 4);
    for now in [2, 3] {
        assert_eq!(asker(post.step(now).0).as_deref(), Some("client"));
    }
    assert_eq!(asker(post.step(4).0), None);
}

#[test]
fn a_snapshot_that_is_cut_off_or_too_long_is_refused() {
    let specification = opened("post", POST);
    for (name, event) in EVENTS {
        let mut post = Post::new(&specification);
        event(&mut post);
        let bytes = post.machine.snapshot().to_bytes();
        let longer = [&bytes[..], &[0]].concat();
        for bytes in (0..bytes.len()).map(|end| &bytes[..end]).chain([&*longer]) {
            assert!(Snapshot::from_bytes(bytes).is_err(), "{name}: {bytes:?}");
        }
        let before = post.machine.snapshot();
        let state = before.state().as_bytes().to_vec();
        let longer = [&state[..], &[0]].concat();
        for state in (0..state.len()).map(|end| &state[..end]).chain([&*longer]) {
            assert!(post.machine.restore_state(state).is_err(), "{name}");
            assert_eq!(post.machine.snapshot(), before, "{name}");
        }
    }
}

#[test]
fn the_oldest_message_is_dropped_from_a_full_queue() {
    const CAPACITY: i64 = 1024;
    for (sent, dropped, first) in [(CAPACITY, 0, 1), (CAPACITY + 1, 1, 2)] {
        let mut post = Post::new(&opened("post", POST));
        for number in 1..=sent {
            post.deliver("tell", number);
        }
        assert_eq!(post.machine.dropped_messages(), dropped);
        assert_eq!(post.machine.undelivered_messages(), CAPACITY as usize);
        let (state, _) = post.step(1);
        assert!(state.contains(&("told".to_owned(), first.to_string())));
        assert_eq!(post.machine.undelivered_messages(), CAPACITY as usize - 1);
    }
}

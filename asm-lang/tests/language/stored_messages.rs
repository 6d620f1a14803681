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

const TWO_SERVERS: &str = "asm two_servers
import StandardLibrary
import CommonBehavior
signature:
  domain Client subsetof Agent
  domain Server subsetof Agent
  static c1: Client
  static c2: Client
  static s1: Server
  static s2: Server
  monitored doing: Integer
  controlled plan: Prod(Client, Server) -> Integer
  controlled stop: Prod(Client, Server) -> Integer
definitions:
  rule r_client = par
    if doing = 0 then
      forall $s in Server with true do par
        r_wcall[$s, \"plan\", 1, 0, plan(self, $s)]
        r_wcall[$s, \"stop\", 2, 0, stop(self, $s)]
      endpar
    endif
    if doing = 1 and self = c1 then r_wcancel[s1, \"plan\"] endif
  endpar
  main rule r_Main = forall $c in Client with true do program($c)
default init s0:
  agent Client: r_client[]
";

/// Answers `doing`.
struct Doing(i64);

impl Environment for Doing {
    fn read(&mut self, _: FunctionId, arguments: &[Value]) -> Result<Option<Value>, String> {
        Ok(arguments.is_empty().then_some(Value::Int(self.0)))
    }
}

/// Two clients that have called two operations of two servers each.
fn two_servers(specification: &Specification) -> Machine {
    let mut machine = specification.machine().unwrap();
    let partners = ["s1", "s2"].map(|name| agent(name, &machine).unwrap());
    machine.set_partners(partners.to_vec());
    machine.step(&mut Doing(0), &mut FirstChoice, 0).unwrap();
    assert_eq!(machine.pending_calls().len(), 8);
    machine
}

#[test]
fn a_call_is_cancelled_alone() {
    let specification = opened("two_servers", TWO_SERVERS);
    let mut machine = two_servers(&specification);
    let calls = |machine: &Machine| {
        let naming = machine.naming();
        let calls = machine.pending_calls().into_iter();
        let calls = calls.map(|call| {
            let (from, to) = (call.from.show(&naming), call.to.show(&naming));
            format!("{from} {to} {}", call.operation.show(&naming))
        });
        calls.collect::<Vec<_>>()
    };
    let mut expected = calls(&machine);
    let cancelled = expected.remove(0);
    assert_eq!(cancelled, "c1 s1 \"plan\"");
    machine.step(&mut Doing(1), &mut FirstChoice, 0).unwrap();
    let messages = machine.last_step().sent().iter();
    let messages: Vec<String> = messages.map(|it| sent(&machine, it)).collect();
    assert_eq!(messages.len(), 1, "{messages:?}");
    assert_eq!(calls(&machine), expected);
}

#[test]
fn the_reply_to_a_cancelled_call_is_dropped_alone() {
    let specification = opened("two_servers", TWO_SERVERS);
    let mut machine = two_servers(&specification);
    // reply 1 answers the first call, and so on
    for (call, number) in machine.pending_calls().into_iter().zip(1..) {
        machine.end_call(call.id, Ok(Value::Int(number)));
    }
    assert_eq!(machine.undelivered_messages(), 8);
    machine.step(&mut Doing(1), &mut FirstChoice, 0).unwrap();
    assert_eq!(machine.undelivered_messages(), 7);
    machine.step(&mut Doing(0), &mut FirstChoice, 0).unwrap();
    let replies: Vec<String> = state(&machine)
        .into_iter()
        .filter(|(location, _)| location.starts_with("plan") || location.starts_with("stop"))
        .map(|(location, value)| format!("{location} {value}"))
        .collect();
    let mut numbers: Vec<&str> = replies
        .iter()
        .filter_map(|it| it.split(' ').next_back())
        .collect();
    numbers.sort_unstable();
    assert_eq!(numbers, ["2", "3", "4", "5", "6", "7", "8"], "{replies:?}");
    // the client calls again
    assert_eq!(machine.pending_calls().len(), 1);
}

#[test]
fn a_call_that_the_environment_answers_has_ended_alone() {
    /// Answers one call itself, as a replay does.
    struct Replayed(FunctionId, Vec<Value>);
    impl Environment for Replayed {
        fn read(
            &mut self,
            function: FunctionId,
            arguments: &[Value],
        ) -> Result<Option<Value>, String> {
            if arguments.is_empty() {
                return Ok(Some(Value::Int(0)));
            }
            let is_it = function == self.0 && arguments[..2] == self.1[..2];
            let is_plan = matches!(arguments.get(2), Some(Value::Text(it)) if **it == "plan");
            Ok((is_it && is_plan).then_some(Value::Int(9)))
        }
    }
    let specification = opened("two_servers", TWO_SERVERS);
    let mut machine = two_servers(&specification);
    let names = &machine.program().symbols.functions;
    let answered = names.iter().position(|name| &**name == "answered").unwrap();
    let route = ["c2", "s1"].map(|name| agent(name, &machine).unwrap());
    let mut inputs = Replayed(FunctionId(answered as u32), route.to_vec());
    machine.step(&mut inputs, &mut FirstChoice, 0).unwrap();
    let pending = machine.pending_calls();
    assert_eq!(pending.len(), 7);
    let is_left = pending.iter().any(|call| {
        call.from == route[0] && call.to == route[1] && call.operation == Value::text("plan")
    });
    assert!(!is_left, "{pending:?}");
}

const TWO_RECEIVERS: &str = "asm two_receivers
import StandardLibrary
import CommonBehavior
signature:
  domain Peer subsetof Agent
  static a: Peer
  static b: Peer
  static boss: Peer
  monitored replies: Boolean
  controlled told: Peer -> Integer
  controlled asked: Peer -> Integer
definitions:
  rule r_peer = par
    r_wreceive[boss, \"tell\", told(self)]
    r_wreceive[boss, \"ask(Integer,Integer)\", asked(self)]
    if replies then r_wreply[boss, \"ask(Integer,Integer)\", 1] endif
  endpar
  main rule r_Main = par program(a) program(b) endpar
default init s0:
  agent Peer: r_peer[]
";

/// Answers `replies` with false.
struct Silent;

impl Environment for Silent {
    fn read(&mut self, _: FunctionId, arguments: &[Value]) -> Result<Option<Value>, String> {
        Ok(arguments.is_empty().then_some(Value::Bool(false)))
    }
}

/// Delivers messages from the boss, one a step, each of which is received in the next step.
fn received(specification: &Specification, messages: &[(&str, &str)]) -> Machine {
    let mut machine = specification.machine().unwrap();
    let [boss, a, b] = ["boss", "a", "b"].map(|name| agent(name, &machine).unwrap());
    machine.set_partners(vec![boss.clone()]);
    for (to, operation) in messages {
        let to = if *to == "a" { &a } else { &b };
        machine.deliver(boss.clone(), to.clone(), operation, Value::Int(1));
        machine.step(&mut Silent, &mut FirstChoice, 0).unwrap();
    }
    assert_eq!(machine.undelivered_messages(), 0);
    machine
}

const ASK: &str = "ask(Integer,Integer)";

#[test]
fn numbers_of_messages_do_not_depend_on_those_before() {
    let specification = opened("two_receivers", TWO_RECEIVERS);
    let is_answered = |operation: &str| operation == "ask";
    // received messages, and those that are left
    type Case<'a> = (&'a [(&'a str, &'a str)], &'a [u64]);
    let cases: [Case<'_>; 7] = [
        (&[], &[]),
        (&[("a", "tell")], &[1]),
        // the sender of the first one can be observed, those of others cannot
        (&[("a", "tell"), ("a", "tell"), ("a", "tell")], &[1]),
        (&[("a", "tell"), ("b", "tell")], &[1, 2]),
        (
            &[("a", "tell"), ("b", "tell"), ("a", "tell"), ("a", ASK)],
            &[1, 2, 4],
        ),
        (&[("a", ASK), ("a", ASK), ("b", ASK)], &[1, 2, 3]),
        // the first one is answered, so that the next can be observed then
        (&[("a", ASK), ("a", "tell"), ("a", "tell")], &[1, 2]),
    ];
    for (messages, left) in cases {
        let mut machine = received(&specification, messages);
        let known = machine.renumber_messages(&is_answered);
        let expected: Vec<(MessageId, MessageId)> = left
            .iter()
            .zip(1..)
            .map(|(old, new)| (MessageId(*old), MessageId(new)))
            .collect();
        assert_eq!(known, expected, "{messages:?}");
        assert_eq!(machine.last_message(), MessageId(left.len() as u64));
        // numbered again, nothing changes
        let again = machine.renumber_messages(&is_answered);
        assert!(again.iter().all(|(old, new)| old == new), "{messages:?}");
        assert_eq!(again.len(), left.len(), "{messages:?}");
        // where every request is answered, none can be forgotten
        let mut machine = received(&specification, messages);
        let known = machine.renumber_messages(&|_| true);
        assert_eq!(known.len(), messages.len(), "{messages:?}");
    }
    // states with different histories become equal
    let packed = |messages: &[(&str, &str)]| {
        let mut machine = received(&specification, messages);
        machine.renumber_messages(&is_answered);
        machine.snapshot().into_state()
    };
    let short = packed(&[("a", "tell"), ("b", "tell")]);
    let long = packed(&[("a", "tell"), ("b", "tell"), ("a", "tell"), ("b", "tell")]);
    assert_eq!(short, long);
}

#[test]
fn messages_find_their_way_after_they_are_numbered_again() {
    let folder = crate::folder().join("semantics");
    let mut count = 0;
    for (name, text) in crate::programs(&folder) {
        if !name.starts_with("messages") {
            continue;
        }
        count += 1;
        let specification = opened(&name, &text);
        let run = |is_renumbered: bool| {
            let mut machine = specification.machine().unwrap();
            let mut states = Vec::new();
            for now in 0..6 {
                let step = machine.step(&mut asmotion_lang::NoInputs, &mut FirstChoice, now);
                let is_done = step.map(|_| ()).map_err(|fault| fault.kind);
                let messages = machine.last_step().sent().iter();
                let messages: Vec<String> = messages.map(|it| sent(&machine, it)).collect();
                states.push((is_done, messages, state(&machine)));
                if is_renumbered {
                    machine.renumber_messages(&|_| true);
                    let pending = machine.pending_calls();
                    assert!(pending.iter().all(|call| call.id <= machine.last_message()));
                }
            }
            states
        };
        assert_eq!(run(true), run(false), "{name}");
    }
    assert!(count > 5);
}

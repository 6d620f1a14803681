//! Comparison of random systems with a naive exploration that knows nothing of packed states, decisions or deliveries: the machines
//! are cloned, messages are kept in lists of texts and numbers, and every combination is executed from scratch.

use crate::naive::{Digits, Random};
use crate::naive_logic::{Condition, Fair, Formula, Graph};
use crate::storage::{ENOUGH, Limited};
use crate::{machine, verified_system};
use asmotion_lang::ir::FunctionKind;
use asmotion_lang::machine::{MessageId, SentKind, SentMessage};
use asmotion_lang::{Chooser, Environment, Machine, Value};
use asmotion_verify::{
    EnvironmentModel, MachineSchedule, MessageModel, Options, Storage, SystemSpecification,
};
use std::cell::RefCell;
use std::collections::BTreeMap;

/// The inputs of a machine: its own are Booleans, and `seen` is the number of the other machine.
struct Inputs<'a> {
    digits: &'a RefCell<Digits>,
    own: String,
    /// The value of its own input, once it is read.
    read: Option<bool>,
    seen: Value,
    names: Vec<std::sync::Arc<str>>,
}

impl Environment for Inputs<'_> {
    fn read(
        &mut self,
        function: asmotion_lang::ir::FunctionId,
        _: &[Value],
    ) -> Result<Option<Value>, String> {
        let name = &*self.names[function.0 as usize];
        Ok(match name {
            name if name == self.own => {
                let value = self.digits.borrow_mut().draw(2) == 1;
                self.read = Some(value);
                Some(Value::Bool(value))
            }
            "numberLeft" | "numberRight" => Some(self.seen.clone()),
            _ => None,
        })
    }
}

struct Choices<'a>(&'a RefCell<Digits>);

impl Chooser for Choices<'_> {
    fn choose(&mut self, count: usize) -> usize {
        self.0.borrow_mut().draw(count)
    }
}

/// A message: its content, and for a request the call that waits for it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Naive {
    Request(i64, MessageId),
    Reply(i64, MessageId),
}

/// The machines, the messages that wait for each, oldest first, and the requests that the right machine has received.
#[derive(Clone)]
struct Whole {
    machines: [Machine; 2],
    letters: [Vec<Naive>; 2],
    /// Messages on their way to each, if they are delayed.
    under_way: [Vec<Naive>; 2],
    /// Id of the request in the provider, and id of the call in the client.
    requests: Vec<(MessageId, MessageId)>,
    /// The input of each machine, if its last step read it and inputs keep their values.
    held: [Option<bool>; 2],
}

/// How machines move.
#[derive(Clone, Copy, Debug)]
struct Movement {
    messages: MessageModel,
    is_synchronous: bool,
    /// `true` if inputs keep their values for ever.
    is_held: bool,
}

/// Labels of edges: the machine that moves, and the machines at which a message is not made to wait.
const RIGHT_MOVES: u32 = 1;
const PROMPT: [u32; 2] = [2, 4];
const STUTTER: u32 = u32::MAX;

fn number(machine: &Machine) -> Value {
    let program = machine.program();
    let names = program.symbols.functions.iter();
    let mut named = names
        .enumerate()
        .filter(|(_, name)| name.starts_with("number"));
    let own = named.find(|(index, _)| program.functions[*index].kind == FunctionKind::Controlled);
    let function = asmotion_lang::ir::FunctionId(own.unwrap().0 as u32);
    let slot = machine.state().slot(program, function, &[]).unwrap();
    machine.state().get(slot).clone()
}

impl Whole {
    /// The distinction of states: the locations, and the messages in order, without their ids.
    fn key(&self) -> String {
        let locations = self.machines.iter().map(|machine| {
            let (state, program) = (machine.state(), machine.program());
            let slots = state.slots().filter(|slot| {
                let function = state.function(program, *slot).unwrap();
                program.functions[function.0 as usize].kind == FunctionKind::Controlled
            });
            let mut all: Vec<String> = slots
                .map(|slot| format!("{:?}={:?}", state.location(program, slot), state.get(slot)))
                .filter(|it| !it.ends_with("=Undef"))
                .collect();
            all.sort();
            all
        });
        let locations: Vec<Vec<String>> = locations.collect();
        // a call waits exactly while there is a request without reply for it
        let [left, right] = &self.machines;
        let waits = left.pending_calls().len();
        let calls = left.pending_calls();
        let age = |id: &MessageId| calls.iter().position(|call| call.id == *id);
        let letters = |letters: &Vec<Naive>| {
            let letters = letters.iter().map(|letter| match letter {
                Naive::Request(data, call) => ("request", *data, age(call)),
                Naive::Reply(data, call) => ("reply", *data, age(call)),
            });
            format!("{:?}", letters.collect::<Vec<_>>())
        };
        let requests = self.requests.iter().map(|(_, call)| age(call));
        format!(
            "{locations:?} {waits} {} {} {} {} {} {} {:?} {:?}",
            left.undelivered_messages(),
            right.undelivered_messages(),
            letters(&self.letters[0]),
            letters(&self.letters[1]),
            letters(&self.under_way[0]),
            letters(&self.under_way[1]),
            requests.collect::<Vec<_>>(),
            self.held,
        )
    }

    /// Puts a message into the machine that receives it.
    fn deliver(&mut self, to: usize, letter: Naive) {
        let waiting = self.machines[to].undelivered_messages();
        match letter.clone() {
            Naive::Request(data, call) => {
                let id =
                    self.machines[1].deliver(Value::Undef, Value::Undef, "add", Value::Int(data));
                let calls = self.machines[0].pending_calls();
                if calls.iter().any(|it| it.id == call) {
                    self.requests.push((id, call));
                }
            }
            Naive::Reply(data, call) => self.machines[0].end_call(call, Ok(Value::Int(data))),
        }
        if self.machines[to].undelivered_messages() > waiting {
            self.letters[to].push(letter);
        }
    }

    /// Lets machines make a step at the same time; returns the label. `Err` if a mailbox is full or a step fails, and `None` if an input
    /// changes that is held.
    fn step(
        &mut self,
        movers: &[usize],
        digits: &RefCell<Digits>,
        movement: Movement,
    ) -> Result<Option<u32>, ()> {
        let mut label = if movers == [1] { RIGHT_MOVES } else { 0 };
        for &mover in movers {
            if self.arrive(mover, digits) {
                label |= PROMPT[mover];
            }
        }
        let seen = [1, 0].map(|other| number(&self.machines[other]));
        let mut has_changed = false;
        let mut sent = Vec::new();
        for (&mover, seen) in movers
            .iter()
            .zip(movers.iter().map(|mover| seen[*mover].clone()))
        {
            let machine = &mut self.machines[mover];
            let mut inputs = Inputs {
                digits,
                own: ["goLeft", "goRight"][mover].to_owned(),
                read: None,
                seen,
                names: machine.program().symbols.functions.clone(),
            };
            let step = machine.step(&mut inputs, &mut Choices(digits), 0);
            let read = inputs.read;
            if movement.is_held {
                let held = std::mem::replace(&mut self.held[mover], read);
                has_changed |= held.is_some() && read.is_some() && held != read;
            }
            let of_step = step.map(|it| it.sent().to_vec());
            if has_changed {
                return Ok(None);
            }
            sent.push((mover, of_step.map_err(|_| ())?));
            // what the machine has received
            let left = self.machines[mover].undelivered_messages();
            let received = self.letters[mover].len() - left;
            self.letters[mover].drain(..received);
        }
        for (_, sent) in sent {
            self.send(sent, digits, movement.messages)?;
        }
        Ok(Some(label))
    }

    /// Delivers some messages to a machine; returns `true` if none is made to wait, or one arrives.
    fn arrive(&mut self, mover: usize, digits: &RefCell<Digits>) -> bool {
        if self.under_way[mover].is_empty() {
            return true;
        }
        let count = digits.borrow_mut().draw(self.under_way[mover].len() + 1);
        let arriving: Vec<Naive> = self.under_way[mover].drain(..count).collect();
        for letter in arriving {
            self.deliver(mover, letter);
        }
        count > 0
    }

    /// Sends the messages of a step.
    fn send(
        &mut self,
        sent: Vec<SentMessage>,
        digits: &RefCell<Digits>,
        model: MessageModel,
    ) -> Result<(), ()> {
        for message in sent {
            let (to, letter) = match &message.kind {
                SentKind::Call {
                    data: Value::Int(data),
                    ..
                } => (1, Naive::Request(*data, message.id)),
                SentKind::Reply {
                    data: Value::Int(data),
                    to: Some(request),
                } => {
                    let Some(at) = self.requests.iter().position(|(id, _)| id == request) else {
                        continue;
                    };
                    let (_, call) = self.requests.remove(at);
                    (0, Naive::Reply(*data, call))
                }
                SentKind::Cancel { call } => {
                    self.requests.retain(|(_, known)| known != call);
                    self.under_way[0].retain(|it| !matches!(it, Naive::Reply(_, to) if to == call));
                    continue;
                }
                SentKind::Message { .. } | SentKind::Call { .. } | SentKind::Reply { .. } => {
                    panic!("{message:?}")
                }
            };
            if model.is_lossy && digits.borrow_mut().draw(2) == 1 {
                continue;
            }
            let waiting = self.machines[to].undelivered_messages() + self.under_way[to].len();
            if waiting >= model.mailbox {
                return Err(());
            }
            if model.is_delayed {
                self.under_way[to].push(letter);
            } else {
                self.deliver(to, letter);
            }
        }
        Ok(())
    }
}

/// States and transitions of a naive exploration, and whether a step fails.
struct Explored {
    states: Vec<Whole>,
    graph: Graph,
    fails: bool,
}

fn explored(texts: &[String; 2], movement: Movement) -> Explored {
    let [mut left, mut right] = texts
        .each_ref()
        .map(|text| crate::open(text).machine().unwrap());
    let names = &left.program().symbols.atoms;
    let adder = names.iter().position(|name| &**name == "adder").unwrap();
    left.set_partners(vec![Value::Atom(asmotion_lang::value::Atom(adder as u32))]);
    right.set_partners(vec![Value::Undef]);
    let first = Whole {
        machines: [left, right],
        letters: [Vec::new(), Vec::new()],
        under_way: [Vec::new(), Vec::new()],
        requests: Vec::new(),
        held: [None; 2],
    };
    let mut known = BTreeMap::from([(first.key(), 0)]);
    let mut found = Explored {
        states: vec![first],
        graph: Graph {
            initial: vec![0],
            ..Graph::default()
        },
        fails: false,
    };
    let moves: &[&[usize]] = if movement.is_synchronous {
        &[&[0, 1]]
    } else {
        &[&[0], &[1]]
    };
    while found.graph.edges.len() < found.states.len() {
        let at = found.graph.edges.len();
        let mut edges = Vec::new();
        for movers in moves {
            let digits = RefCell::new(Digits::default());
            loop {
                let mut next = found.states[at].clone();
                match next.step(movers, &digits, movement) {
                    Ok(Some(label)) => {
                        let count = found.states.len();
                        let target = *known.entry(next.key()).or_insert(count);
                        if target == count {
                            found.states.push(next);
                        }
                        edges.push((target, label));
                    }
                    Ok(None) => {}
                    Err(()) => found.fails = true,
                }
                if !digits.borrow_mut().increment() {
                    break;
                }
            }
        }
        found.graph.edges.push(edges);
    }
    found.graph.close(STUTTER);
    found.graph.fairness = fairness(found.states.len(), movement);
    found
}

/// Each machine moves again and again, and each message arrives.
fn fairness(states: usize, movement: Movement) -> Vec<Fair> {
    let mut fair = Vec::new();
    for (mover, arrival) in PROMPT.iter().enumerate() {
        let prompt = if movement.messages.is_delayed {
            *arrival
        } else {
            0
        };
        let is_it: fn(u32, u32) -> bool = if movement.is_synchronous {
            |label, mask| label == STUTTER || label & mask == mask
        } else if mover == 1 {
            |label, mask| label == STUTTER || label & RIGHT_MOVES != 0 && label & mask == mask
        } else {
            |label, mask| label == STUTTER || label & RIGHT_MOVES == 0 && label & mask == mask
        };
        fair.push(Fair::Often(vec![false; states], is_it, prompt));
    }
    fair
}

/// Conditions on both machines.
const ATOMS: &[&str] = &[
    "left.numberLeft = 0",
    "left.numberLeft = 1",
    "right.numberRight = 2",
    "right.numberRight = 0",
    "isDef(left.reply)",
    "left.numberLeft = right.numberRight",
];

fn is_true(whole: &Whole, atom: &str) -> bool {
    let [left, right] = whole.machines.each_ref().map(number);
    match atom {
        "left.numberLeft = 0" => left == Value::Int(0),
        "left.numberLeft = 1" => left == Value::Int(1),
        "right.numberRight = 2" => right == Value::Int(2),
        "right.numberRight = 0" => right == Value::Int(0),
        "isDef(left.reply)" => {
            let machine = &whole.machines[0];
            let program = machine.program();
            let mut names = program.symbols.functions.iter();
            let reply = names.position(|name| &**name == "reply").unwrap();
            let reply = asmotion_lang::ir::FunctionId(reply as u32);
            let slot = machine.state().slot(program, reply, &[]).unwrap();
            !machine.state().get(slot).is_undef()
        }
        _ => left == right,
    }
}

fn client(random: &mut Random) -> String {
    let conditions = [
        "goLeft",
        "not goLeft",
        "numberRight = 1",
        "numberLeft != numberRight",
        "true",
    ];
    let sent = ["numberLeft", "(numberLeft + 1) mod 3", "2", "numberRight"];
    let (condition, cancels) = (random.one_of(&conditions), random.one_of(&conditions));
    let (sent, received) = (
        random.one_of(&sent),
        random.one_of(&["reply", "(reply + 1) mod 3"]),
    );
    let other = random.one_of(&[
        "skip",
        "numberLeft := (numberLeft + 1) mod 3",
        "if goLeft then numberLeft := 0 endif",
        "choose $n in Number with $n != numberLeft do numberLeft := $n",
    ]);
    let cancel = random.one_of(&["skip", "r_wcancel[adder, \"add\"]"]);
    format!(
        "asm model
import StandardLibrary
import CommonBehavior
signature:
  domain Number subsetof Integer
  domain Adder subsetof Agent
  static adder: Adder
  out add: Prod(Adder, Number) -> Number
  monitored goLeft: Boolean
  monitored numberRight: Number
  controlled numberLeft: Number
  controlled reply: Number
definitions:
  domain Number = {{0:2}}
  main rule r_Main =
    if isDef(reply) then par numberLeft := {received} reply := undef endpar
    else if {condition} then r_wcall[adder, \"add\", {sent}, 0, reply]
    else if {cancels} then {cancel}
    else {other}
    endif endif endif
default init s0:
  function numberLeft = 0
"
    )
}

fn provider(random: &mut Random) -> String {
    let conditions = [
        "goRight",
        "numberLeft = 1",
        "true",
        "true",
        "numberRight != numberLeft",
    ];
    let condition = random.one_of(&conditions);
    let answer = random.one_of(&["numberRight", "(numberRight + 1) mod 3", "1"]);
    let other = random.one_of(&[
        "skip",
        "numberRight := (numberRight + 2) mod 3",
        "choose $n in Number with true do numberRight := $n",
    ]);
    format!(
        "asm model
import StandardLibrary
import CommonBehavior
signature:
  domain Number subsetof Integer
  domain Adder subsetof Agent
  out add: Prod(Adder, Number) -> Number
  //@Backref
  shared client: Agent -> Agent
  monitored goRight: Boolean
  monitored numberLeft: Number
  controlled numberRight: Number
definitions:
  domain Number = {{0:2}}
  main rule r_Main =
    if nextRequest(self) = \"add\" and {condition} then seq
      r_wreceive[client(self), \"add\", numberRight]
      r_wreply[client(self), \"add\", {answer}]
    endseq
    else {other}
    endif
default init s0:
  function numberRight = 0
"
    )
}

/// Ways to explore, which make no difference.
fn explored_somehow(random: &mut Random, plain: Options) -> Options {
    let mut flag = || random.below(2) == 0;
    let (symmetry, cone, independent, without_grounding) = (flag(), flag(), flag(), flag());
    Options {
        symmetry,
        cone,
        independent,
        without_grounding,
        storage: match random.below(3) {
            0 => Storage::Exact,
            1 => Storage::Compact,
            _ => Limited::of(ENOUGH),
        },
        threads: 1 + random.below(3) as usize,
        ..plain
    }
}

#[test]
fn random_systems_have_the_states_and_verdicts_that_a_naive_exploration_finds() {
    let seed = std::env::var("ASMOTION_NAIVE_SEED").ok();
    let seed = seed.and_then(|it| it.parse().ok());
    let mut random = Random(seed.unwrap_or(0x2545_f491_4f6c_dd1d));
    let (mut large, mut failing, mut held, mut violated) = (0, 0, 0, 0);
    for round in 0..120 {
        let texts = [client(&mut random), provider(&mut random)];
        let movement = Movement {
            messages: MessageModel {
                is_lossy: round % 3 == 0,
                is_delayed: round % 5 < 2,
                mailbox: 1 + round % 2,
            },
            is_synchronous: round % 7 < 2,
            is_held: round % 4 == 3,
        };
        let expected = explored(&texts, movement);
        let mut system = SystemSpecification {
            machines: vec![machine("left", &texts[0]), machine("right", &texts[1])],
            ..SystemSpecification::default()
        };
        if movement.is_synchronous {
            system.schedule = MachineSchedule::Synchronous;
        }
        if movement.is_held {
            system.environment = EnvironmentModel::Hold { changes: 0 };
        }
        let formulas: Vec<Formula> = (0..4)
            .map(|at| Formula::temporal(&mut random, ATOMS, at % 3))
            .collect();
        let plain = Options {
            messages: movement.messages,
            properties: formulas.iter().map(ToString::to_string).collect(),
            ..Options::default()
        };
        let options = explored_somehow(&mut random, plain);
        let verification = verified_system(system, &options);
        let shown = format!("{}\n{}\n{movement:?}\n{options:?}", texts[0], texts[1]);
        assert_eq!(verification.states, expected.states.len() as u64, "{shown}");
        let no_fault = verification.properties.iter();
        let no_fault = no_fault.filter(|it| it.text == "no step fails");
        let failed = no_fault
            .map(|it| it.verdict.is_violated())
            .collect::<Vec<_>>();
        assert_eq!(failed, [expected.fails], "{shown}");
        large += u32::from(expected.states.len() > 20);
        failing += u32::from(expected.fails);
        // the naive decision takes too long
        for formula in formulas.iter().filter(|_| expected.states.len() < 300) {
            let holds = expected
                .graph
                .satisfies(formula, &|node, condition: &Condition| {
                    condition.is_true(&|atom| is_true(&expected.states[node], atom))
                });
            let property = formula.to_string();
            let mut checked = verification.properties.iter();
            let checked = checked.find(|it| it.text == property).unwrap();
            assert_eq!(checked.verdict.holds(), holds, "{property}\n{shown}");
            held += u32::from(holds);
            violated += u32::from(!holds);
        }
    }
    assert!(
        large > 20 && failing > 2 && held > 50 && violated > 50,
        "{large} {failing} {held} {violated}"
    );
}

/// A message arrives at last, also if its receiver makes steps together with its sender.
#[test]
fn delayed_messages_arrive_in_every_schedule() {
    let client = "asm model
import StandardLibrary
import CommonBehavior
signature:
  domain Number subsetof Integer
  domain Adder subsetof Agent
  static adder: Adder
  out add: Prod(Adder, Number) -> Number
  controlled reply: Number
  controlled calls: Boolean
definitions:
  domain Number = {0:2}
  main rule r_Main =
    if isUndef(reply) then par r_wcall[adder, \"add\", 1, 0, reply] calls := not calls endpar endif
default init s0:
  function calls = false
";
    let provider = "asm model
import StandardLibrary
import CommonBehavior
signature:
  domain Number subsetof Integer
  domain Adder subsetof Agent
  out add: Prod(Adder, Number) -> Number
  //@Backref
  shared client: Agent -> Agent
  controlled number: Number
definitions:
  domain Number = {0:2}
  main rule r_Main =
    if nextRequest(self) = \"add\" then seq
      r_wreceive[client(self), \"add\", number]
      r_wreply[client(self), \"add\", 2]
    endseq endif
default init s0:
  function number = 0
";
    for schedule in [MachineSchedule::Interleaved, MachineSchedule::Synchronous] {
        for (is_lossy, expected) in [(false, "holds"), (true, "violated")] {
            let system = SystemSpecification {
                machines: vec![machine("left", client), machine("right", provider)],
                schedule,
                ..SystemSpecification::default()
            };
            let options = Options {
                properties: vec!["af(left.reply = 2)".to_owned()],
                messages: MessageModel {
                    is_lossy,
                    is_delayed: true,
                    mailbox: 2,
                },
                ends: Some("isDef(left.reply)".to_owned()),
                ..Options::default()
            };
            let found = verified_system(system, &options);
            let verdict = crate::verdict_of(&found, "af(left.reply = 2)");
            assert_eq!(verdict, expected, "{schedule:?} {is_lossy}");
        }
    }
}

//! Comparison of random systems with a naive exploration that knows nothing of packed states, decisions or deliveries: the machines
//! are cloned, messages are kept in lists of texts and numbers, and every combination is executed from scratch.

use crate::naive::{Digits, Random};
use crate::{machine, verified_system};
use asmotion_lang::ir::FunctionKind;
use asmotion_lang::machine::{MessageId, SentKind};
use asmotion_lang::{Chooser, Environment, Machine, Value};
use asmotion_verify::{MessageModel, Options, SystemSpecification};
use std::cell::RefCell;
use std::collections::BTreeSet;

/// The inputs of a machine: its own are Booleans, and `seen` is the number of the other machine.
struct Inputs<'a> {
    digits: &'a RefCell<Digits>,
    own: String,
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
            name if name == self.own => Some(Value::Bool(self.digits.borrow_mut().draw(2) == 1)),
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
}

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
            "{locations:?} {waits} {} {} {} {} {} {} {:?}",
            left.undelivered_messages(),
            right.undelivered_messages(),
            letters(&self.letters[0]),
            letters(&self.letters[1]),
            letters(&self.under_way[0]),
            letters(&self.under_way[1]),
            requests.collect::<Vec<_>>(),
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

    /// Lets one machine make a step. `Err` if a mailbox is full or the step fails.
    fn step(
        &mut self,
        mover: usize,
        digits: &RefCell<Digits>,
        model: MessageModel,
    ) -> Result<(), ()> {
        if !self.under_way[mover].is_empty() {
            let count = digits.borrow_mut().draw(self.under_way[mover].len() + 1);
            let arriving: Vec<Naive> = self.under_way[mover].drain(..count).collect();
            for letter in arriving {
                self.deliver(mover, letter);
            }
        }
        let seen = number(&self.machines[1 - mover]);
        let machine = &mut self.machines[mover];
        let mut inputs = Inputs {
            digits,
            own: ["goLeft", "goRight"][mover].to_owned(),
            seen,
            names: machine.program().symbols.functions.clone(),
        };
        let step = machine.step(&mut inputs, &mut Choices(digits), 0);
        let sent = step.map_err(|_| ())?.sent().to_vec();
        // what the machine has received
        let left = self.machines[mover].undelivered_messages();
        let received = self.letters[mover].len() - left;
        self.letters[mover].drain(..received);
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

/// Number of states, and whether a step fails.
fn explored(texts: &[String; 2], model: MessageModel) -> (usize, bool) {
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
    };
    let mut seen = BTreeSet::from([first.key()]);
    let mut waiting = vec![first];
    let mut fails = false;
    while let Some(whole) = waiting.pop() {
        for mover in 0..2 {
            let digits = RefCell::new(Digits::default());
            loop {
                let mut next = whole.clone();
                match next.step(mover, &digits, model) {
                    Ok(()) => {
                        if seen.insert(next.key()) {
                            waiting.push(next);
                        }
                    }
                    Err(()) => fails = true,
                }
                if !digits.borrow_mut().increment() {
                    break;
                }
            }
        }
    }
    (seen.len(), fails)
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

#[test]
fn random_systems_have_the_states_that_a_naive_exploration_finds() {
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    let (mut large, mut failing) = (0, 0);
    for round in 0..90 {
        let texts = [client(&mut random), provider(&mut random)];
        let model = MessageModel {
            is_lossy: round % 3 == 0,
            is_delayed: round % 5 < 2,
            mailbox: 1 + round % 2,
        };
        let (states, fails) = explored(&texts, model);
        let system = SystemSpecification {
            machines: vec![machine("left", &texts[0]), machine("right", &texts[1])],
            ..SystemSpecification::default()
        };
        let options = Options {
            messages: model,
            ..Options::default()
        };
        let verification = verified_system(system, &options);
        let shown = format!("{}\n{}\n{model:?}", texts[0], texts[1]);
        assert_eq!(verification.states, states as u64, "{shown}");
        let no_fault = verification.properties.iter();
        let no_fault = no_fault.filter(|it| it.text == "no step fails");
        let violated = no_fault
            .map(|it| it.verdict.is_violated())
            .collect::<Vec<_>>();
        assert_eq!(violated, [fails], "{shown}");
        large += u32::from(states > 20);
        failing += u32::from(fails);
    }
    assert!(large > 20 && failing > 2, "{large} {failing}");
}

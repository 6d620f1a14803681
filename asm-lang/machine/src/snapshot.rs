//! Snapshots: a machine put back into a state it, or another one of its program, was in.

use crate::machine::Machine;
use crate::messages::MessagesInTransit;
use crate::packed::{PackedState, Reader, Unpacked, Writer};
use std::error::Error;
use std::fmt;

/// What a machine needs to go on and to show what it would have shown: its state, how far it had come,
/// and which locations it knew. Take [`Snapshot::into_state`] to keep many.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Snapshot {
    state: PackedState,
    steps: u64,
    /// The number of the last message.
    messages: u64,
    /// Which other locations were met: listings show them.
    history: Box<[u8]>,
}

/// A snapshot is one of another program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ForeignSnapshot;

impl fmt::Display for ForeignSnapshot {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str("the snapshot was taken of a machine with another program")
    }
}

impl Error for ForeignSnapshot {}

impl Snapshot {
    /// The state: equal for all machines of a program that go on in the same way.
    pub fn state(&self) -> &PackedState {
        &self.state
    }

    /// The state alone, to be kept in a set of states.
    pub fn into_state(self) -> PackedState {
        self.state
    }

    /// How many steps the machine had done.
    pub fn steps(&self) -> u64 {
        self.steps
    }
}

/// The initial state holds the values that depend on inputs.
const COMPLETE: u64 = 1;
/// The first step was done, or does nothing that others do not.
const BEGUN: u64 = 2;

impl Machine {
    /// The state the machine is in, packed. Takes time linear in the number of locations.
    ///
    /// Which agents are outside ([`Machine::set_partners`]) and what was counted are no part of it.
    pub fn snapshot(&self) -> Snapshot {
        let layout = &self.code.layout;
        let mut to = Writer::default();
        let has_begun = self.steps > 0 || !layout.first_differs;
        let complete = if self.is_complete { COMPLETE } else { 0 };
        to.number(complete | if has_begun { BEGUN } else { 0 });
        self.state.pack(&self.program, layout, &mut to);
        if self.program.messages.is_some() {
            self.post.pack(&mut to);
        }
        let mut history = Writer::default();
        self.state.pack_history(&self.program, layout, &mut history);
        Snapshot {
            state: PackedState::new(to.bytes),
            steps: self.steps,
            messages: self.post.last(),
            history: history.bytes.into_boxed_slice(),
        }
    }

    /// Puts the machine into the state of a snapshot: given the same inputs, choices and times, it goes on
    /// as the machine did that the snapshot was taken of. There is no last step then.
    ///
    /// Slots of locations that are not fixed by the program may have other numbers afterwards.
    ///
    /// # Errors
    /// The snapshot was taken of a machine with another program; this one is as before.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), ForeignSnapshot> {
        let (program, code) = (&*self.program, &*self.code);
        let mut from = Reader::new(snapshot.state.as_bytes(), program.rules.len());
        let phase = from.number().ok_or(ForeignSnapshot)?;
        let mut unpacked =
            Unpacked::read(program, &code.layout, &mut from).ok_or(ForeignSnapshot)?;
        let post = match program.messages.is_some() {
            true => {
                MessagesInTransit::unpack(&mut from, snapshot.messages).ok_or(ForeignSnapshot)?
            }
            false => MessagesInTransit::default(),
        };
        let mut history = Reader::new(&snapshot.history, program.rules.len());
        let known = unpacked.read_history(program, &mut history);
        if known.is_none() || !from.is_done() || !history.is_done() {
            return Err(ForeignSnapshot);
        }
        self.state
            .restore(program, &code.layout, &code.supers, unpacked);
        self.post.replace_messages(post);
        self.is_complete = phase & COMPLETE != 0;
        self.steps = snapshot.steps;
        self.forget_last_step();
        Ok(())
    }
}

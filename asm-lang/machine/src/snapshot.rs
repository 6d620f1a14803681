//! Snapshots: return a machine to a state that it, or another machine of its program, was in.

use crate::machine::Machine;
use crate::messages::MessagesInTransit;
use crate::packed::{PackedState, Reader, Unpacked, Writer};
use asmotion_value::Value;
use std::error::Error;
use std::fmt;

/// A state of a machine, with the number of steps and the accessed locations, so that a restored
/// machine continues and displays its state in the same way. Use [`Snapshot::into_state`] to store
/// many states.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Snapshot {
    state: PackedState,
    steps: u64,
    /// Id of the last message.
    messages: u64,
    /// Packed locations that were accessed but hold their initial value; shown by listings.
    history: Box<[u8]>,
}

/// The snapshot belongs to another program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ForeignSnapshot;

impl fmt::Display for ForeignSnapshot {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str("the snapshot was taken of a machine with another program")
    }
}

impl Error for ForeignSnapshot {}

impl Snapshot {
    /// Returns the state; equal for all machines of the program that continue in the same way.
    pub fn state(&self) -> &PackedState {
        &self.state
    }

    /// Returns the state, without the rest of the snapshot.
    pub fn into_state(self) -> PackedState {
        self.state
    }

    /// Returns the number of steps that the machine had completed.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Encodes the snapshot. Equal snapshots have equal bytes, whose format depends on the program
    /// and on the version of this crate.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut to = Writer::default();
        to.number(self.steps);
        to.number(self.messages);
        to.block(self.state.as_bytes());
        to.block(&self.history);
        to.bytes
    }

    /// Decodes the output of [`Snapshot::to_bytes`]. [`Machine::restore`] checks that the snapshot
    /// belongs to the program.
    ///
    /// # Errors
    /// The bytes are malformed.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ForeignSnapshot> {
        Self::read(&mut Reader::new(bytes, 0)).ok_or(ForeignSnapshot)
    }

    fn read(from: &mut Reader<'_>) -> Option<Self> {
        let (steps, messages) = (from.number()?, from.number()?);
        let state = PackedState::new(from.block()?.to_vec());
        let history = from.block()?.into();
        from.is_done().then_some(Self {
            state,
            steps,
            messages,
            history,
        })
    }
}

/// Flag: the initial state contains the values that depend on inputs.
const COMPLETE: u64 = 1;
/// Flag: the first step is done, or does not differ from others.
const BEGUN: u64 = 2;

/// Id of the last message in a machine of which only the packed state is known; packed states contain ids relative to it.
const MESSAGES: u64 = 1 << 40;

/// Encodes a value like those in packed states, for data that is stored together with a snapshot.
/// [`Machine::unpack_value`] decodes it.
///
/// ```
/// use asmotion_machine::pack_value;
/// use asmotion_value::Value;
///
/// assert_eq!(pack_value(&Value::Int(3)), pack_value(&Value::Int(3)));
/// assert_ne!(pack_value(&Value::real(0.0)), pack_value(&Value::real(-0.0)));
/// ```
pub fn pack_value(value: &Value) -> Vec<u8> {
    let mut to = Writer::default();
    to.value(value);
    to.bytes
}

impl Machine {
    /// Decodes the output of [`pack_value`]. The value may contain all elements that exist in the
    /// current state, including those created by `extend`.
    ///
    /// # Errors
    /// The bytes are malformed, or the value contains an unknown element or rule.
    pub fn unpack_value(&self, bytes: &[u8]) -> Result<Value, ForeignSnapshot> {
        let mut from = Reader::new(bytes, self.program.rules.len());
        from.set_atoms(self.program.atom_domains.len() + self.state.store.reserve.len());
        let value = from.value().ok_or(ForeignSnapshot)?;
        from.is_done().then_some(value).ok_or(ForeignSnapshot)
    }

    /// Returns a snapshot of the current state. Takes time linear in the number of locations.
    ///
    /// Partners ([`Machine::set_partners`]) and coverage counts are not part of it.
    pub fn snapshot(&self) -> Snapshot {
        let mut to = Writer::default();
        self.pack(&mut to);
        let mut history = Writer::default();
        self.state
            .pack_history(&self.program, &self.code.layout, &mut history);
        Snapshot {
            state: PackedState::new(to.bytes),
            steps: self.steps,
            messages: self.messages.last(),
            history: history.bytes.into_boxed_slice(),
        }
    }

    /// Appends the bytes of the current [`PackedState`] to a buffer.
    pub fn pack_state(&self, to: &mut Vec<u8>) {
        let mut writer = Writer {
            bytes: std::mem::take(to),
        };
        self.pack(&mut writer);
        *to = writer.bytes;
    }

    fn pack(&self, to: &mut Writer) {
        let layout = &self.code.layout;
        let has_begun = self.steps > 0 || !layout.first_differs;
        let complete = if self.is_complete { COMPLETE } else { 0 };
        to.number(complete | if has_begun { BEGUN } else { 0 });
        self.state.pack(&self.program, layout, to);
        if self.program.messages.is_some() {
            self.messages.pack(to);
        }
    }

    /// Returns the machine to the state of a snapshot. Given the same inputs, choices and times, it
    /// then continues like the machine from which the snapshot was taken. The record of the last
    /// step is empty afterwards.
    ///
    /// The slots of interned locations may have changed.
    ///
    /// # Errors
    /// The snapshot belongs to another program; the machine is unchanged.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), ForeignSnapshot> {
        let history = Some(&*snapshot.history);
        self.restore_packed(snapshot.state.as_bytes(), snapshot.messages, history)?;
        self.steps = snapshot.steps;
        Ok(())
    }

    /// Returns the machine to a packed state, given by its bytes. The machine then continues like every other one in that state.
    /// It counts one step, or none before the first step, and lists no location that has its initial value.
    ///
    /// # Errors
    /// The bytes belong to another program; the machine is unchanged.
    pub fn restore_state(&mut self, state: &[u8]) -> Result<(), ForeignSnapshot> {
        let phase = self.restore_packed(state, MESSAGES, None)?;
        self.steps = u64::from(phase & BEGUN != 0);
        Ok(())
    }

    /// Replaces the state, and returns the flags of the packed one.
    fn restore_packed(
        &mut self,
        state: &[u8],
        messages: u64,
        history: Option<&[u8]>,
    ) -> Result<u64, ForeignSnapshot> {
        let (program, code) = (&*self.program, &*self.code);
        let mut from = Reader::new(state, program.rules.len());
        let phase = from.number().ok_or(ForeignSnapshot)?;
        let mut unpacked =
            Unpacked::read(program, &code.layout, &mut from).ok_or(ForeignSnapshot)?;
        let post = if program.messages.is_some() {
            MessagesInTransit::unpack(&mut from, messages).ok_or(ForeignSnapshot)?
        } else {
            MessagesInTransit::default()
        };
        if let Some(history) = history {
            let mut history = Reader::new(history, program.rules.len());
            let known = unpacked.read_history(program, &mut history);
            if known.is_none() || !history.is_done() {
                return Err(ForeignSnapshot);
            }
        }
        if !from.is_done() {
            return Err(ForeignSnapshot);
        }
        self.state
            .restore(program, &code.layout, &code.supers, unpacked);
        self.messages.replace_messages(post);
        self.changed_outside();
        self.is_complete = phase & COMPLETE != 0;
        self.forget_last_step();
        Ok(phase)
    }
}

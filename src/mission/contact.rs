//! A process' contact with others on the bus: it says what it is, and does what they want.

use std::sync::Arc;

use assembly::order::{Order, control_address};
use assembly::{Part, Plan};
use bus::{Bell, Bus, BusError, Call, Payload, Refusal, Serving};
use component::Run;
use datum::Datum;

use super::herald::Herald;

/// How many orders may wait.
const WAITING: usize = 16;

/// The contact.
pub(super) struct Contact<'p> {
    herald: Herald<'p>,
    orders: Serving,
}

impl<'p> Contact<'p> {
    pub(super) fn new(
        plan: &'p Plan,
        part: Part,
        process: &str,
        bus: &dyn Bus,
        incarnation: u64,
    ) -> Result<Self, BusError> {
        let bell = Arc::new(Bell::new());
        Ok(Self {
            herald: Herald::new(plan, part, process, bus, incarnation)?,
            orders: bus.serve(&control_address(process), WAITING, bell)?,
        })
    }

    /// Does what is due: carries out orders, and speaks.
    pub(super) fn attend(&mut self, run: &mut dyn Run) {
        while let Some(call) = self.orders.try_next() {
            let done = carry_out(&call, run);
            call.reply(done.map(|()| Payload::of(Datum::Null)));
            self.herald.hurry();
        }
        self.herald.speak(run);
    }

    /// Says the last word.
    pub(super) fn leave(&mut self) {
        self.herald.leave();
    }
}

fn carry_out(call: &Call, run: &mut dyn Run) -> Result<(), Refusal> {
    let refusal = |code: &str, detail| Refusal {
        code: code.to_owned(),
        detail,
    };
    let order = call.argument.to_datum();
    let order: Order = order
        .and_then(|order| order.to())
        .map_err(|error| refusal("BAD_REQUEST", error.to_string()))?;
    order
        .carry_out(run)
        .map_err(|reason| refusal("REFUSED", reason))
}

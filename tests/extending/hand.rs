//! A hand that other components and specifications close by a service.

use asmotion_component::{
    Component, Cycle, Fault, Interface, Operation, Ports, Provided, ServiceFault,
};

asmotion_datum::message! {
    /// How to close.
    pub struct GripRequest = "acme/GripRequest" {
        /// force of the fingers, N
        pub force_n: f64,
    }

    /// The end of closing.
    pub struct GripResult = "acme/GripResult" {
        /// whether the fingers hold something
        pub held: bool,
    }
}

/// `grip` of the interface `acme/Hand`: closes the fingers.
pub struct Grip;

impl Operation for Grip {
    type Request = GripRequest;
    type Response = GripResult;
    const INTERFACE: &'static str = "acme/Hand";
    const NAME: &'static str = "grip";
}

#[derive(Ports)]
struct HandPorts {
    /// Closes the fingers.
    hand: Provided<Grip>,
}

/// `acme::Hand`: holds whatever it grips with 2 N or more.
pub struct Hand {
    ports: HandPorts,
}

impl Hand {
    /// Declares the service.
    pub fn new(interface: &mut Interface) -> Self {
        Self {
            ports: interface.ports(),
        }
    }
}

impl Component for Hand {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        for request in cycle.requests(self.ports.hand) {
            let force = request.argument.force_n;
            let result = if force > 10.0 {
                Err(ServiceFault::new("TOO_STRONG", "at most 10 N"))
            } else {
                Ok(GripResult { held: force >= 2.0 })
            };
            // or in a later cycle: keep `request.id`
            cycle.reply(self.ports.hand, request.id, result);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use asmotion_bench::{Bench, BenchError};
    use asmotion_component::{CallError, SendStatus};

    use super::*;

    #[test]
    fn it_grips() -> Result<(), BenchError> {
        let mut bench = Bench::new(Hand::new);
        let mut firm = bench.call::<Grip>("hand", GripRequest { force_n: 5.0 })?;
        let mut brutal = bench.call::<Grip>("hand", GripRequest { force_n: 50.0 })?;
        bench.cycle()?;
        let held = SendStatus::Success(GripResult { held: true });
        assert_eq!(firm.collect_if_done(), held);
        let refused = ServiceFault::new("TOO_STRONG", "at most 10 N");
        let refused = SendStatus::Failure(CallError::Fault(refused));
        assert_eq!(brutal.collect_if_done(), refused);
        Ok(())
    }
}

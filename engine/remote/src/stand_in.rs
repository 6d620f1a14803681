//! A component that stands for a component of another robot: it has the ports and services that the robot announces, and
//! passes on samples and requests.
//!
//! A thread of its own, the *link*, follows the presence of the robot. It has the robot publish the outputs that are used here,
//! for as long as it renews the lease, and writes the commands of this system to the robot's inputs.

mod announced;
mod link;

use std::sync::Arc;

use asmotion_bus::{Notifier, PendingCall};
use asmotion_component::declaration::{Declaration, OperationDeclaration};
use asmotion_component::{
    AwaitedWriters, CallError, Component, Cycle, Dynamic, Fault, In, Interface, NOTICE_REPORT, Out,
    Provided, RequestId, ServiceFault, Setup,
};
use asmotion_datum::{Datum, Schema};
use asmotion_network::call_error;

pub use self::announced::RobotComponent;
use self::link::Link;
use crate::presence::key;
use crate::remote::{Remote, request};

/// A component that stands for a component of another robot.
pub struct StandIn {
    remote: Remote,
    robot_component: RobotComponent,
    inputs: Vec<(String, In<Datum>)>,
    outputs: Vec<RelayedOutput>,
    operations: Vec<RelayedOperation>,
    /// The link to the robot; `None` before the component is configured.
    link: Option<Link>,
    calls: Vec<RelayedCall>,
    /// Wakes the component when a reply arrives.
    notifier: Arc<Notifier>,
}

/// An output of the robot's component.
struct RelayedOutput {
    name: String,
    port: Out<Datum>,
    schema: Schema,
}

/// An operation of the robot's component.
struct RelayedOperation {
    handle: Provided<Dynamic>,
    /// Address on the broker.
    address: String,
}

/// A request that the robot has not answered.
struct RelayedCall {
    handle: Provided<Dynamic>,
    request: RequestId,
    pending: PendingCall,
}

impl StandIn {
    /// Declares the ports and services of the robot's component on an interface. Connects nothing.
    pub fn new(remote: Remote, robot_component: RobotComponent, interface: &mut Interface) -> Self {
        let RobotComponent {
            robot,
            component,
            declaration,
            ..
        } = &robot_component;
        let inputs = declaration.inputs.iter().map(|port| {
            let handle = interface.input_of(&port.name, port.schema.clone(), &port.doc);
            // what the robot has not received in time, it must not receive late
            (port.name.clone(), interface.command(handle))
        });
        let inputs = inputs.collect();
        let outputs = declaration.outputs.iter().map(|port| RelayedOutput {
            name: port.name.clone(),
            port: interface.output_of(&port.name, port.schema.clone(), &port.doc),
            schema: port.schema.clone(),
        });
        let outputs = outputs.collect();
        let mut operations = Vec::new();
        for service in &declaration.services {
            for operation in &service.operations {
                let name = format!("{component}.{}.{}", service.name, operation.name);
                let declared = OperationDeclaration {
                    while_stopped: false,
                    ..operation.clone()
                };
                let (of, doc) = (&service.interface, &service.doc);
                operations.push(RelayedOperation {
                    handle: interface.serve_declared(&service.name, of, declared, doc),
                    address: key(robot, &name),
                });
            }
        }
        Self {
            remote,
            robot_component,
            inputs,
            outputs,
            operations,
            link: None,
            calls: Vec::new(),
            notifier: Arc::default(),
        }
    }

    /// Passes samples of the robot on to this system.
    fn write_samples(&self, link: &Link, cycle: &mut Cycle<'_>) {
        for (name, sample) in link.samples() {
            let mut outputs = self.outputs.iter();
            let Some(output) = outputs.find(|output| *output.name == *name) else {
                continue;
            };
            match output.schema.complete(sample) {
                Ok(sample) => cycle.write(output.port, sample),
                Err(_) => link.count_misfit(),
            }
        }
    }

    /// Passes requests on to the robot, and its replies to the callers.
    fn relay_requests(&mut self, cycle: &mut Cycle<'_>) {
        for operation in &self.operations {
            let gone = cycle.cancelled(operation.handle);
            self.calls.retain(|call| !gone.contains(&call.request));
            for arrived in cycle.requests(operation.handle) {
                let Some(deadline) = arrived.deadline else {
                    let timeout = link::LISTEN;
                    let request = request(arrived.argument, timeout);
                    // nobody waits for the outcome of a one-way call
                    let _ = self.remote.bus().call_one_way(
                        &operation.address,
                        request,
                        Arc::clone(&self.notifier),
                    );
                    continue;
                };
                let request = request(arrived.argument, deadline.since(cycle.now()));
                let notifier = Arc::clone(&self.notifier);
                match self
                    .remote
                    .bus()
                    .call(&operation.address, request, notifier)
                {
                    Ok(pending) => self.calls.push(RelayedCall {
                        handle: operation.handle,
                        request: arrived.id,
                        pending,
                    }),
                    Err(error) => {
                        let fault = ServiceFault::new("UNAVAILABLE", error.to_string());
                        cycle.reply(operation.handle, arrived.id, Err(fault));
                    }
                }
            }
        }
        let robot = &self.robot_component.robot;
        self.calls.retain(|call| {
            let Some(end) = call.pending.try_take() else {
                return true;
            };
            let result = end.map_err(call_error).and_then(|reply| {
                let unreadable = |error: asmotion_datum::DatumError| {
                    ServiceFault::new("BAD_REPLY", error.to_string()).into()
                };
                reply.to_datum().map_err(unreadable)
            });
            let result = result.map_err(|error| match error {
                CallError::Fault(fault) => fault,
                CallError::Timeout
                | CallError::Unavailable
                | CallError::Stopped
                | CallError::Cancelled => {
                    ServiceFault::new("UNAVAILABLE", format!("robot `{robot}`: {error}"))
                }
            });
            cycle.reply(call.handle, call.request, result);
            false
        });
    }
}

impl Component for StandIn {
    fn configure(&mut self, setup: &mut Setup<'_>) -> Result<(), Fault> {
        self.link = None;
        self.calls.clear();
        let Some(waker) = setup.waker() else {
            return Err(Fault::new(
                "a component of another robot needs the wall clock",
            ));
        };
        let wake = Arc::clone(&waker);
        self.notifier = Arc::new(Notifier::calling(move || wake()));
        let link = Link::start(self.remote.clone(), self.robot_component.clone(), waker);
        self.link = Some(link.map_err(Fault::new)?);
        Ok(())
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let Some(link) = self.link.take() else {
            return Ok(());
        };
        for notice in link.notices() {
            cycle.report(NOTICE_REPORT, Datum::text(notice));
        }
        for (name, port) in &self.inputs {
            for sample in cycle.all(*port).to_vec() {
                link.command(name, sample);
            }
        }
        self.write_samples(&link, cycle);
        cycle.set_losses(link.losses());
        cycle.set_reachable(link.absence().is_none());
        let fault = link.fault();
        self.link = Some(link);
        self.relay_requests(cycle);
        fault.map_or(Ok(()), |fault| Err(Fault::new(fault)))
    }

    fn inspect(&self) -> Vec<(String, Datum)> {
        let RobotComponent {
            robot, component, ..
        } = &self.robot_component;
        let absence = self.link.as_ref().and_then(Link::absence);
        let state = match absence {
            Some(absence) => format!("robot `{robot}` {absence}"),
            None => "present".to_owned(),
        };
        vec![
            ("robot".to_owned(), Datum::text(robot.as_str())),
            ("component".to_owned(), Datum::text(component.as_str())),
            ("presence".to_owned(), Datum::Text(state)),
        ]
    }

    fn awaited_writers(&self) -> AwaitedWriters {
        AwaitedWriters::All
    }

    fn cleanup(&mut self) {
        self.link = None;
    }

    fn exception(&mut self) {
        self.link = None;
    }
}

impl RobotComponent {
    /// The ports and services of a declaration that a stand-in has. References and properties belong to the robot.
    pub fn interface(declaration: Declaration) -> Declaration {
        Declaration {
            references: Vec::new(),
            properties: Vec::new(),
            outputs: declaration
                .outputs
                .into_iter()
                .map(|mut output| {
                    // the robot itself writes its safe samples
                    output.safe = None;
                    output
                })
                .collect(),
            ..declaration
        }
    }
}

//! Services of other robots: what a reference expects of the service is compared with what its provider announces.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use asmotion_bus::{Notifier, Payload};
use asmotion_component::ServiceFault;
use asmotion_component::declaration::{OperationDeclaration, ReferenceDeclaration};

/// A service of another robot that a reference of the system calls. Calls that do not fit the announcement of its provider end
/// with a fault, those under way included. At the start, calls [wait](Self::expect_announcement) for the announcement; without
/// one they are sent as they are.
///
/// The bus thread reads the comparison with each call; the thread that receives announcements writes it.
pub struct RobotService {
    /// The reference, for example `Coordinator.maps`.
    from: String,
    robot: String,
    name: String,
    expected: ReferenceDeclaration,
    /// The system's notifier, which wakes the bus thread.
    notifier: Arc<Notifier>,
    /// Timeout of the calls.
    timeout: Duration,
    comparison: Mutex<Comparison>,
}

/// The comparison of a reference with the announcement of its service.
enum Comparison {
    /// The announcement has not arrived, and calls are sent without it.
    Absent,
    /// Calls wait for the announcement until this instant.
    Awaited(Instant),
    /// The fault of each operation of the reference, by position.
    Done(Vec<Option<ServiceFault>>),
}

/// The decision about a call.
pub(crate) enum Admission {
    /// The call is sent.
    Sent,
    /// The call waits for the announcement.
    Held,
    /// The call ends with a fault.
    Refused(ServiceFault),
}

/// Time within which a running process has announced its services, once a second.
const ANNOUNCED: Duration = Duration::from_millis(1500);

/// Announcement of a service by a process.
#[derive(Debug, Clone, Copy)]
pub struct AnnouncedService<'a> {
    /// Name of the interface.
    pub interface: &'a str,
    /// Operations of the service.
    pub operations: &'a [AnnouncedOperation<'a>],
}

/// An operation of an announced service, with the names of its types.
#[derive(Debug, Clone, Copy)]
pub struct AnnouncedOperation<'a> {
    /// Name of the operation.
    pub name: &'a str,
    /// Type of the request; empty if it has no name.
    pub request: &'a str,
    /// Type of the response; empty if it has no name.
    pub response: &'a str,
}

impl RobotService {
    pub(crate) fn new(
        from: &str,
        (robot, name): (&str, &str),
        expected: ReferenceDeclaration,
        timeout: Duration,
        notifier: Arc<Notifier>,
    ) -> Self {
        Self {
            from: from.to_owned(),
            robot: robot.to_owned(),
            name: name.to_owned(),
            expected,
            notifier,
            timeout,
            comparison: Mutex::new(Comparison::Absent),
        }
    }

    /// The reference that calls the service, for example `Coordinator.maps`.
    pub fn reference(&self) -> &str {
        &self.from
    }

    /// Name of the robot that provides the service.
    pub fn robot(&self) -> &str {
        &self.robot
    }

    /// `Component.service`, or the name under which the service is promoted.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Lets calls wait for the announcement for 1.5 s, or for half of their timeout if that is less. The caller must
    /// [end the wait](Self::end_wait) then.
    pub fn expect_announcement(&self) {
        let wait = ANNOUNCED.min(self.timeout / 2);
        self.set(Comparison::Awaited(Instant::now() + wait));
    }

    /// Lets calls be sent without an announcement if the time for it is over.
    pub fn end_wait(&self) {
        let is_over = match &*self.lock() {
            Comparison::Awaited(until) => Instant::now() >= *until,
            Comparison::Absent | Comparison::Done(_) => false,
        };
        if is_over {
            self.set(Comparison::Absent);
        }
    }

    /// Compares the reference with the service that the robot announces under this name.
    pub fn compare(&self, announced: &AnnouncedService<'_>) {
        let operations = self.expected.operations.iter();
        let faults = operations.map(|expected| self.misfit(expected, announced));
        self.set(Comparison::Done(faults.collect()));
    }

    /// Takes note that the robot announces no service with this name, but those with the names in `known`.
    pub fn set_missing(&self, known: &[String]) {
        let others = match known {
            [] => "none".to_owned(),
            known => known.join(", "),
        };
        let detail = format!(
            "robot `{}` has no service `{}`, which `{}` calls; its component provides {others}",
            self.robot, self.name, self.from
        );
        self.refuse(detail);
    }

    /// Takes note that the name begins with the `id` of a component of the robot, whose service has the address `address`.
    pub fn set_named_by_id(&self, address: &str) {
        let Self {
            from, robot, name, ..
        } = self;
        self.refuse(format!(
            "`{name}` of robot `{robot}`, which `{from}` calls, begins with the `task.id` of a component: its address is \
             `robot://{robot}/{address}`"
        ));
    }

    /// Lets all calls end with the fault that there is no such service.
    fn refuse(&self, detail: String) {
        let fault = ServiceFault::new("NO_SERVICE", detail);
        let operations = self.expected.operations.len();
        self.set(Comparison::Done(vec![Some(fault); operations]));
    }

    /// Forgets the announcement, because the process that provides the service has left.
    pub fn forget(&self) {
        self.set(Comparison::Absent);
    }

    /// Decides about a call of an operation of the reference.
    pub(crate) fn admit(&self, operation: usize) -> Admission {
        match &*self.lock() {
            Comparison::Absent => Admission::Sent,
            Comparison::Awaited(_) => Admission::Held,
            Comparison::Done(faults) => match faults.get(operation) {
                Some(Some(fault)) => Admission::Refused(fault.clone()),
                Some(None) | None => Admission::Sent,
            },
        }
    }

    /// Reads the reply to a call of an operation, which may come from anyone who uses the robot's name.
    pub(crate) fn read(&self, operation: usize, reply: &Payload) -> Result<Payload, ServiceFault> {
        let Some(expected) = self.expected.operations.get(operation) else {
            return Ok(reply.clone());
        };
        let datum = reply.to_datum();
        let datum = datum.and_then(|datum| expected.response.complete(datum));
        datum.map(Payload::of).map_err(|error| {
            let Self { robot, name, .. } = self;
            let operation = &expected.name;
            let detail = format!("reply of `{name}.{operation}` of robot `{robot}`: {error}");
            ServiceFault::new("BAD_REPLY", detail)
        })
    }

    fn set(&self, comparison: Comparison) {
        *self.lock() = comparison;
        self.notifier.notify();
    }

    fn lock(&self) -> MutexGuard<'_, Comparison> {
        let locked = self.comparison.lock();
        locked.unwrap_or_else(PoisonError::into_inner)
    }

    fn misfit(
        &self,
        expected: &OperationDeclaration,
        announced: &AnnouncedService<'_>,
    ) -> Option<ServiceFault> {
        let Self {
            from, robot, name, ..
        } = self;
        let interface = &self.expected.interface;
        if interface != announced.interface {
            let detail = format!(
                "`{name}` of robot `{robot}` has the interface `{}`, but `{from}` expects `{interface}`",
                announced.interface
            );
            return Some(ServiceFault::new("OTHER_INTERFACE", detail));
        }
        let mut operations = announced.operations.iter();
        let Some(operation) = operations.find(|it| it.name == expected.name) else {
            let detail = format!(
                "`{name}` of robot `{robot}` has no operation `{}`, which `{from}` calls",
                expected.name
            );
            return Some(ServiceFault::new("NO_OPERATION", detail));
        };
        let types = [
            ("takes", &*expected.request.name, operation.request),
            ("returns", &*expected.response.name, operation.response),
        ];
        let differs = |(_, wanted, found): &(_, &str, &str)| {
            !wanted.is_empty() && !found.is_empty() && wanted != found
        };
        let (verb, wanted, found) = types.into_iter().find(differs)?;
        let detail = format!(
            "`{name}.{}` of robot `{robot}` {verb} `{found}`, but `{from}` expects `{wanted}`",
            expected.name
        );
        Some(ServiceFault::new("OTHER_TYPE", detail))
    }
}

//! Ends outside the system, such as topics of a bus, to which ends of components are joined while the system runs.

use std::fmt;
use std::sync::Arc;

use asmotion_component::Wire;
use asmotion_component::declaration::{ReferenceDeclaration, ServiceDeclaration};
use asmotion_datum::Schema;
use asmotion_port::{AnySender, Policy};

use crate::cause::CycleCause;
use crate::injection::InjectionPort;
use crate::opened_end::OpenedEnd;
use crate::service::RequestQueue;

/// An output that is joined to the outside.
pub struct OuterOutput<'a> {
    /// The message type.
    pub schema: &'a Schema,
    /// The cause of the component's cycles.
    pub cause: Arc<CycleCause>,
}

/// An input that is joined to the outside.
pub struct OuterInput<'a> {
    /// The connection into the input.
    pub port: InjectionPort,
    /// The message type.
    pub schema: &'a Schema,
    /// The cause of the component's cycles.
    pub cause: Arc<CycleCause>,
}

/// A service that is offered outside.
pub struct OuterService<'a> {
    /// Position of the provider in the system.
    pub provider: usize,
    /// The operations of the service.
    pub declaration: &'a ServiceDeclaration,
    /// The requests that wait for the provider.
    pub queue: Arc<RequestQueue>,
}

type OpenOutput = dyn Fn(OuterOutput<'_>) -> Result<Box<dyn AnySender>, String> + Send + Sync;
type OpenInput = dyn Fn(OuterInput<'_>) -> Result<Box<dyn OpenedEnd>, String> + Send + Sync;
type OpenService = dyn Fn(OuterService<'_>) -> Result<Box<dyn OpenedEnd>, String> + Send + Sync;
type OpenReference =
    dyn Fn(&ReferenceDeclaration) -> Result<Arc<RequestQueue>, String> + Send + Sync;

/// An end outside, the end of a component that is joined to it, and how an adapter opens it. The adapter is called by the thread
/// that owns the run, and may wait for the transport.
#[derive(Clone)]
pub struct OuterEnd {
    /// The end in the system, as `component.port`.
    pub(crate) end: String,
    /// Name of the end outside, for example `topic scan`.
    pub(crate) outside: String,
    pub(crate) opener: OuterOpener,
}

/// How an adapter opens an end outside, by the kind of the component's end.
#[derive(Clone)]
pub(crate) enum OuterOpener {
    Output {
        /// The newest sample leaves at once.
        init: bool,
        open: Arc<OpenOutput>,
    },
    Input {
        policy: Policy,
        open: Arc<OpenInput>,
    },
    Service(Arc<OpenService>),
    Reference {
        wire: Wire,
        open: Arc<OpenReference>,
    },
}

impl OuterEnd {
    /// Lets the samples of an output leave; with `init`, its newest one at once. `outside` is shown in events.
    pub fn output(
        output: &str,
        outside: String,
        init: bool,
        open: impl Fn(OuterOutput<'_>) -> Result<Box<dyn AnySender>, String> + Send + Sync + 'static,
    ) -> Self {
        let open = Arc::new(open);
        Self::new(output, outside, OuterOpener::Output { init, open })
    }

    /// Feeds samples from outside into an input, under this policy.
    pub fn input(
        input: &str,
        outside: String,
        policy: Policy,
        open: impl Fn(OuterInput<'_>) -> Result<Box<dyn OpenedEnd>, String> + Send + Sync + 'static,
    ) -> Self {
        let open = Arc::new(open);
        Self::new(input, outside, OuterOpener::Input { policy, open })
    }

    /// Offers a service outside.
    pub fn service(
        service: &str,
        outside: String,
        open: impl Fn(OuterService<'_>) -> Result<Box<dyn OpenedEnd>, String> + Send + Sync + 'static,
    ) -> Self {
        Self::new(service, outside, OuterOpener::Service(Arc::new(open)))
    }

    /// Wires a reference to a service outside, whose requests go into the queue that `open` returns.
    pub fn reference(
        reference: &str,
        service: String,
        wire: Wire,
        open: impl Fn(&ReferenceDeclaration) -> Result<Arc<RequestQueue>, String>
        + Send
        + Sync
        + 'static,
    ) -> Self {
        let open = Arc::new(open);
        Self::new(reference, service, OuterOpener::Reference { wire, open })
    }

    fn new(end: &str, outside: String, opener: OuterOpener) -> Self {
        Self {
            end: end.to_owned(),
            outside,
            opener,
        }
    }
}

impl fmt::Debug for OuterEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut shown = f.debug_struct("OuterEnd");
        shown.field("end", &self.end);
        shown.field("outside", &self.outside);
        shown.finish_non_exhaustive()
    }
}

/// Two are equal if they join the same ends.
impl PartialEq for OuterEnd {
    fn eq(&self, other: &Self) -> bool {
        (&self.end, &self.outside) == (&other.end, &other.outside)
    }
}

/// Says that the ends are joined.
impl fmt::Display for OuterEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { end, outside, .. } = self;
        match &self.opener {
            OuterOpener::Output { .. } => write!(f, "`{end}` is sent to {outside}"),
            OuterOpener::Input { .. } => write!(f, "`{end}` receives {outside}"),
            OuterOpener::Service(_) => write!(f, "`{end}` is offered as {outside}"),
            OuterOpener::Reference { .. } => write!(f, "`{end}` is wired to `{outside}`"),
        }
    }
}

impl OuterEnd {
    /// Says that the ends are parted.
    pub(crate) fn write_parted(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { end, outside, .. } = self;
        match &self.opener {
            OuterOpener::Output { .. } => write!(f, "`{end}` is no longer sent to {outside}"),
            OuterOpener::Input { .. } => write!(f, "`{end}` no longer receives {outside}"),
            OuterOpener::Service(_) => write!(f, "`{end}` is no longer offered as {outside}"),
            OuterOpener::Reference { .. } => write!(f, "`{end}` is unwired from `{outside}`"),
        }
    }
}

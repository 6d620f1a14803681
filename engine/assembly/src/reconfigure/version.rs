//! Versions of a part of a system.

use std::collections::BTreeMap;
use std::sync::Arc;

use asmotion_bus::ServiceClient;
use asmotion_component::Interface;
use asmotion_composite::Catalogue;
use asmotion_diagnostics::Loader;
use asmotion_network::{KnownOperations, RunningNetwork};
use asmotion_plan::{Component, Endpoint, Implementation, Part, Plan};

use crate::start::{self, CoordinatorOptions, Standard, Workshop};

/// A version of a part of a system: its plan, and what its components are created from.
#[derive(Clone)]
pub struct Version {
    /// The plan of the version.
    pub plan: Arc<Plan>,
    /// The part of the plan that runs in this process.
    pub part: Part,
    catalogue: Arc<dyn Catalogue + Send + Sync>,
    loader: Arc<dyn Loader + Send + Sync>,
    coordinators: CoordinatorOptions,
    /// The texts of each component's specification and its imports, in the order in which they are loaded.
    pub(super) texts: BTreeMap<String, Vec<Arc<str>>>,
    /// The buses of the running system.
    pub(super) network: RunningNetwork,
    clients: Option<Clients>,
}

/// Returns the client that calls a service of another system with a token, and with the certificate authorities in a file.
pub type Clients = Arc<
    dyn Fn(Option<&Endpoint>, Option<&str>) -> Result<Arc<dyn ServiceClient>, String> + Send + Sync,
>;

impl Version {
    /// Reads the specifications of a part of a plan. Catalogue, loader and options are those of [`Standard`].
    pub fn new(
        plan: impl Into<Arc<Plan>>,
        part: Part,
        catalogue: Arc<dyn Catalogue + Send + Sync>,
        loader: Arc<dyn Loader + Send + Sync>,
        coordinators: CoordinatorOptions,
    ) -> Self {
        let plan = plan.into();
        let here = plan.components.iter().filter(|it| part.has(&it.name));
        // many components have the same specification
        let mut known: BTreeMap<&str, Vec<Arc<str>>> = BTreeMap::new();
        let texts = here.filter_map(|component| {
            let file = specification(component)?;
            let read = || start::specification_texts(file, &*loader);
            let texts = known.entry(file).or_insert_with(read).clone();
            Some((component.name.clone(), texts))
        });
        let texts = texts.collect();
        Self {
            texts,
            network: RunningNetwork::default(),
            clients: None,
            plan,
            part,
            catalogue,
            loader,
            coordinators,
        }
    }

    /// The files of the version, which need not be those on the disk of this machine.
    pub fn loader(&self) -> &dyn Loader {
        &*self.loader
    }

    /// Sets the buses of the running system, which new ends use.
    #[must_use]
    pub fn on_buses(mut self, network: RunningNetwork) -> Self {
        self.network = network;
        self
    }

    /// Sets the clients that call services of other systems; without them, such services cannot be wired.
    #[must_use]
    pub fn with_clients(mut self, clients: Clients) -> Self {
        self.clients = Some(clients);
        self
    }

    /// Returns how the client of a service of another system is made.
    pub(super) fn client(
        &self,
        token: Option<Endpoint>,
        authorities: Option<String>,
    ) -> impl Fn() -> Result<Arc<dyn ServiceClient>, String> + Send + Sync + 'static {
        let clients = self.clients.clone();
        move || {
            let clients = clients
                .as_ref()
                .ok_or("there is no client of other systems")?;
            clients(token.as_ref(), authorities.as_deref())
        }
    }

    /// Returns the operations of service interfaces: those of the catalogue, and those that only the plan has.
    pub(super) fn operations(&self) -> KnownOperations {
        let (catalogue, interfaces) = (Arc::clone(&self.catalogue), self.plan.interfaces.clone());
        Arc::new(move |interface| {
            let of_plan = || interfaces.get(interface).cloned();
            catalogue.operations(interface).or_else(of_plan)
        })
    }

    /// Returns the constructor of a component. It loads its specification at each call.
    pub(super) fn constructor(
        &self,
        component: &Component,
    ) -> impl Fn(&mut Interface) -> Result<Box<dyn asmotion_component::Component>, String>
    + Send
    + Sync
    + 'static {
        let (version, component) = (self.clone(), component.clone());
        move |interface| {
            let mut workshop =
                Standard::new(&*version.catalogue, &*version.loader, version.coordinators);
            workshop.make(&component, &version.plan)?(interface)
        }
    }
}

/// Returns the file of the specification that a component runs.
pub(super) fn specification(component: &Component) -> Option<&str> {
    match &component.implementation {
        Implementation::Asm { file, .. } => Some(file),
        Implementation::Rust(_)
        | Implementation::Builtin { .. }
        | Implementation::Process { .. }
        | Implementation::Ros { .. }
        | Implementation::Orocos { .. } => None,
    }
}

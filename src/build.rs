//! Contents of a program beside the engine: components, messages, interfaces, map formats, planners, transports.

mod catalogue;
mod environment;
#[cfg(feature = "ros")]
pub(crate) mod ros_messages;

use std::sync::Arc;

use asmotion_component::declaration::OperationDeclaration;
use asmotion_component::{Component, Interface, Operation};
use asmotion_composite::{AsmFiles, Catalogue, ComponentFactory, Context, Programs};
use asmotion_datum::Message;
use asmotion_lang::Loader;
use asmotion_map::{MapFormat, MapFormats, MapServer};
use asmotion_plan::Opened;
use asmotion_planner::{MakePlanner, Planners, TrajectoryPlanner};

use crate::programs::{AskedPrograms, ProcessChoice, ProgramsHere};
use crate::transport::{ConnectTransport, Transports};
use catalogue::BuildCatalogue;
use environment::ProcessEnvironment;

/// The contents of a program: what composites can name. [`App`](crate::App) adds to them.
#[derive(Clone, Debug)]
pub struct Build {
    catalogue: Arc<BuildCatalogue>,
    map_formats: MapFormats,
    planners: Planners,
    transports: Transports,
    /// The programs that have been asked for their declarations; clones share them.
    programs: Arc<AskedPrograms>,
}

impl Build {
    /// The contents of `asmotion`.
    pub fn standard() -> Self {
        Self {
            catalogue: Arc::new(BuildCatalogue::standard()),
            map_formats: MapFormats::standard(),
            planners: Planners::standard(),
            transports: Transports::default(),
            programs: Arc::default(),
        }
    }

    /// The components, messages and service interfaces.
    pub fn catalogue(&self) -> &(dyn Catalogue + Send + Sync) {
        &*self.catalogue
    }

    /// The components, messages and service interfaces, shared.
    pub(crate) fn shared_catalogue(&self) -> Arc<dyn Catalogue + Send + Sync> {
        self.catalogue.clone()
    }

    /// The transports that were added.
    pub(crate) fn transports(&self) -> &Transports {
        &self.transports
    }

    /// Contradictions between additions, in order.
    pub(crate) fn problems(&self) -> &[String] {
        self.catalogue.problems()
    }

    /// The programs that implement components, as far as they have been asked for their declarations.
    pub(crate) fn programs(&self) -> &AskedPrograms {
        &self.programs
    }

    /// Opens a composite with properties set on the command line, as pairs of name and text. Starts the programs that
    /// implement components, to ask them for their declarations; those of processes with another `host` than this machine
    /// may be absent.
    pub fn open(&self, path: &str, settings: &[(String, String)], loader: &dyn Loader) -> Opened {
        self.open_for(ProcessChoice::on_this_machine(), path, settings, loader)
    }

    /// Like [`open`](Self::open), for these processes. The programs of others may be absent.
    pub(crate) fn open_for(
        &self,
        choice: ProcessChoice,
        path: &str,
        settings: &[(String, String)],
        loader: &dyn Loader,
    ) -> Opened {
        let programs = ProgramsHere {
            programs: &*self.programs,
            choice,
        };
        self.open_with(path, settings, loader, &programs)
    }

    /// Like [`open`](Self::open), with other declarations of programs.
    pub(crate) fn open_with(
        &self,
        path: &str,
        settings: &[(String, String)],
        loader: &dyn Loader,
        programs: &dyn Programs,
    ) -> Opened {
        let context = Context {
            loader,
            environment: &ProcessEnvironment,
            catalogue: &*self.catalogue,
            specifications: &AsmFiles::new(loader),
            programs,
            settings,
        };
        asmotion_plan::open(path, &context)
    }

    /// See [`App::component`](crate::App::component).
    pub(crate) fn add_component<C: Component>(
        &mut self,
        name: &str,
        new: impl Fn(&mut Interface) -> C + Send + Sync + 'static,
    ) {
        Arc::make_mut(&mut self.catalogue).add_component(name, factory(new));
    }

    /// See [`App::protocol`](crate::App::protocol).
    pub(crate) fn add_protocol(&mut self, component: &str, protocol: &str) {
        Arc::make_mut(&mut self.catalogue).add_protocol(component, protocol);
    }

    /// See [`App::message`](crate::App::message).
    pub(crate) fn add_message<M: Message>(&mut self) {
        Arc::make_mut(&mut self.catalogue).add_message(M::schema());
    }

    /// See [`App::operation`](crate::App::operation).
    pub(crate) fn add_operation<O: Operation>(&mut self) {
        let operation = OperationDeclaration::of::<O>();
        Arc::make_mut(&mut self.catalogue).add_operation(O::INTERFACE, &operation);
    }

    /// See [`App::map_format`](crate::App::map_format).
    pub(crate) fn add_map_format(&mut self, name: &'static str, format: &'static dyn MapFormat) {
        self.map_formats = self.map_formats.clone().with(name, format);
        let formats = self.map_formats.clone();
        self.replace("nav::MapServer", move |interface| {
            MapServer::new(interface).formats(formats.clone())
        });
    }

    /// See [`App::planner`](crate::App::planner).
    pub(crate) fn add_planner(&mut self, name: &'static str, make: MakePlanner) {
        self.planners = self.planners.clone().with(name, make);
        let planners = self.planners.clone();
        self.replace("nav::TrajectoryPlanner", move |interface| {
            TrajectoryPlanner::with_planners(interface, planners.clone())
        });
    }

    /// See [`App::transport`](crate::App::transport).
    pub(crate) fn add_transport(&mut self, scheme: &'static str, connect: ConnectTransport) {
        self.transports.add(scheme, connect);
    }

    /// Replaces a standard component with a variant of it.
    fn replace<C: Component>(
        &mut self,
        name: &str,
        new: impl Fn(&mut Interface) -> C + Send + Sync + 'static,
    ) {
        Arc::make_mut(&mut self.catalogue).replace_component(name, factory(new));
    }
}

fn factory<C: Component>(
    new: impl Fn(&mut Interface) -> C + Send + Sync + 'static,
) -> ComponentFactory {
    Arc::new(move |interface| Box::new(new(interface)))
}

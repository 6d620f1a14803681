//! Creation of component instances.

use asmotion_bridge::PortProxy;
use asmotion_component::declaration::OperationDeclaration;
use asmotion_component::{Component, Interface};
use asmotion_diagnostics::Loader;

use super::specifications::PreparedSpecifications;
use super::{coordinator, of_build, program};
use asmotion_composite::Catalogue;
use asmotion_plan::{Implementation, Plan};

/// Creates a component and declares it on the interface; `Err` contains a human-readable reason.
pub type Make = Box<dyn FnOnce(&mut Interface) -> Result<Box<dyn Component>, String>>;

/// A factory of components.
pub trait Workshop {
    /// Returns the constructor of a component.
    ///
    /// # Errors
    ///
    /// A human-readable reason if the component cannot be created.
    fn make(&mut self, component: &asmotion_plan::Component, plan: &Plan) -> Result<Make, String>;

    /// Returns the operations of a service interface, with which replies of other robots are compared; `None` if it is
    /// unknown.
    fn operations(&self, _interface: &str) -> Option<Vec<OperationDeclaration>> {
        None
    }
}

/// Options of the coordinators of a system.
#[derive(Debug, Clone, Copy, Default)]
pub struct CoordinatorOptions {
    /// Seed of random choices; the position of each coordinator is added, so that they choose differently.
    pub seed: u64,
    /// Reports every cycle, for a recording of the run.
    pub records_cycles: bool,
}

impl CoordinatorOptions {
    /// Returns the default options with this seed.
    pub fn seeded(seed: u64) -> Self {
        Self {
            seed,
            ..Self::default()
        }
    }
}

/// The default factory: components from the catalogue, specifications run by coordinators, port-proxies, and other
/// built-ins through a callback.
///
/// It loads and prepares each specification once, however many components it implements.
pub struct Standard<'a> {
    catalogue: &'a dyn Catalogue,
    coordinators: CoordinatorOptions,
    specifications: PreparedSpecifications<'a>,
    builtins: Option<&'a mut Builtins<'a>>,
}

/// Creates the built-in components that this crate does not know; returns `None` for one that does not exist.
pub type Builtins<'a> = dyn FnMut(&asmotion_plan::Component, &Plan) -> Option<Make> + 'a;

impl<'a> Standard<'a> {
    /// Creates a factory with a catalogue of the components in the executable, a loader of specifications and the options of
    /// coordinators.
    pub fn new(
        catalogue: &'a dyn Catalogue,
        loader: &'a dyn Loader,
        coordinators: CoordinatorOptions,
    ) -> Self {
        Self {
            catalogue,
            coordinators,
            specifications: PreparedSpecifications::new(loader),
            builtins: None,
        }
    }

    /// Adds a factory of the built-in components that this crate does not know.
    pub fn with_builtins(self, builtins: &'a mut Builtins<'a>) -> Self {
        Self {
            builtins: Some(builtins),
            ..self
        }
    }
}

impl Workshop for Standard<'_> {
    fn make(&mut self, component: &asmotion_plan::Component, plan: &Plan) -> Result<Make, String> {
        match &component.implementation {
            Implementation::Rust(name) => {
                let factory = self.catalogue.factory(name);
                factory
                    .map(of_build)
                    .ok_or(format!("`{name}` is not in this build"))
            }
            Implementation::Asm { file, .. } => {
                let options = coordinator::options(self.coordinators, component, plan);
                let prepared = self.specifications.prepared(component, file)?;
                Ok(coordinator::make(component, prepared, &plan.types, options))
            }
            Implementation::Builtin { .. } if let Some(settings) = &component.bridge => {
                let settings = settings.clone();
                Ok(Box::new(move |interface: &mut Interface| {
                    Ok(Box::new(PortProxy::new(&settings, interface)) as Box<dyn Component>)
                }))
            }
            Implementation::Builtin { name, .. } => {
                let builtins = self.builtins.as_mut();
                let made = builtins.and_then(|make| make(component, plan));
                made.ok_or(format!("the built-in `{name}` is not in this build"))
            }
            Implementation::Process { .. } => program::make(component),
            Implementation::Ros { .. } => Err("ROS nodes cannot be started yet".to_owned()),
            Implementation::Orocos { .. } => {
                Err("Orocos components cannot be connected yet".to_owned())
            }
        }
    }

    fn operations(&self, interface: &str) -> Option<Vec<OperationDeclaration>> {
        self.catalogue.operations(interface)
    }
}

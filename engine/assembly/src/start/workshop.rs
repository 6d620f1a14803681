//! Where components come from.

use asmotion_bridge::PortProxy;
use asmotion_component::{Component, Interface};
use asmotion_diagnostics::Loader;

use super::{coordinator, of_build};
use asmotion_composite::Catalogue;
use asmotion_plan::{Implementation, Plan};

/// Makes a component: declares it on the interface, or says why that cannot be.
pub type Make = Box<dyn FnOnce(&mut Interface) -> Result<Box<dyn Component>, String>>;

/// Makes the components of a plan.
pub trait Workshop {
    /// What makes a component.
    ///
    /// # Errors
    /// Why it cannot be made here.
    fn make(&mut self, component: &asmotion_plan::Component, plan: &Plan) -> Result<Make, String>;
}

/// The usual workshop: components of the build from the catalogue, specifications run by the
/// coordinator, the port-proxy by the bridge, other built-ins by whoever knows them.
pub struct Standard<'a> {
    /// The components of the build.
    pub catalogue: &'a dyn Catalogue,
    /// Where specifications come from.
    pub loader: &'a dyn Loader,
    /// The seed of all choices; two coordinators choose differently all the same.
    pub seed: u64,
    /// Makes the built-ins that this crate does not know.
    pub builtins: &'a mut dyn FnMut(&asmotion_plan::Component, &Plan) -> Option<Make>,
}

impl Workshop for Standard<'_> {
    fn make(&mut self, component: &asmotion_plan::Component, plan: &Plan) -> Result<Make, String> {
        match &component.implementation {
            Implementation::Rust(name) => {
                let constructor = self.catalogue.constructor(name);
                constructor
                    .map(of_build)
                    .ok_or(format!("`{name}` is not in this build"))
            }
            Implementation::Asm(asm) => {
                let position = plan
                    .components
                    .iter()
                    .position(|it| it.name == component.name);
                let seed = self.seed.wrapping_add(position.unwrap_or(0) as u64);
                coordinator::make(component, asm, &plan.types, self.loader, seed)
            }
            Implementation::Builtin(_) if let Some(settings) = &component.bridge => {
                let settings = settings.clone();
                Ok(Box::new(move |interface: &mut Interface| {
                    Ok(Box::new(PortProxy::new(&settings, interface)) as Box<dyn Component>)
                }))
            }
            Implementation::Builtin(settings) => (self.builtins)(component, plan).ok_or(format!(
                "the built-in `{}` is not in this build",
                settings.kind
            )),
            Implementation::Process(_) => Err("other programs cannot be started yet".to_owned()),
            Implementation::Ros(_) => Err("ROS nodes cannot be started yet".to_owned()),
            Implementation::Orocos(_) => {
                Err("components of Orocos cannot be joined yet".to_owned())
            }
        }
    }
}

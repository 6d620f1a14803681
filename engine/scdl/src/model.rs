//! A composite as SCDL has it; every part knows its place in the file it was read from.

use asmotion_assembly::At;

/// A `<composite>`.
#[derive(Clone, Debug)]
pub(crate) struct Composite {
    /// Its name.
    pub name: At<String>,
    /// `targetNamespace`.
    pub namespace: Option<At<String>>,
    /// `<documentation>`.
    pub doc: Option<String>,
    /// Whether references find their services by themselves.
    pub autowire: bool,
    /// `<include name>`.
    pub includes: Vec<At<String>>,
    /// `<property>`.
    pub properties: Vec<Property>,
    /// `<component>`.
    pub components: Vec<Component>,
    /// `<service promote>`.
    pub services: Vec<Contract>,
    /// `<reference promote>`.
    pub references: Vec<Contract>,
    /// `<wire>`, and the targets of references.
    pub wires: Vec<Wire>,
    /// What has no counterpart, as it is written.
    pub notes: Vec<String>,
}

/// A `<component>`.
#[derive(Clone, Debug)]
pub(crate) struct Component {
    /// Its name.
    pub name: At<String>,
    /// `<documentation>`.
    pub doc: Option<String>,
    /// Whether its references find their services by themselves, where it says so.
    pub autowire: Option<bool>,
    /// What it is made of.
    pub implementation: Option<Implementation>,
    /// `<service>`.
    pub services: Vec<Contract>,
    /// `<reference>`.
    pub references: Vec<Contract>,
    /// `<property>`.
    pub properties: Vec<Property>,
    /// What has no counterpart, as it is written.
    pub notes: Vec<String>,
}

/// What a component is made of.
#[derive(Clone, Debug)]
pub(crate) enum Implementation {
    /// `<implementation.java class>`.
    Java(At<String>),
    /// `<implementation.composite name>`, without the prefix.
    Composite(At<String>),
    /// `<implementation.asm location>`.
    Asm(At<String>),
    /// `<implementation.python script>`.
    Python(At<String>),
}

/// A `<service>` or `<reference>`, of a component or of the composite.
#[derive(Clone, Debug)]
pub(crate) struct Contract {
    /// Its name.
    pub name: At<String>,
    /// Its interface, where it is said.
    pub interface: Option<Interface>,
    /// How others reach it, or it reaches others.
    pub bindings: Vec<Bound>,
    /// `promote`: what of the components it is.
    pub promote: Vec<Target>,
    /// `target`: who answers.
    pub targets: Vec<Target>,
    /// `multiplicity`.
    pub multiplicity: Multiplicity,
    /// Whether it finds its service by itself, where it says so.
    pub autowire: Option<bool>,
    /// What has no counterpart, as it is written.
    pub notes: Vec<String>,
}

/// An interface and the one that is called back.
#[derive(Clone, Debug)]
pub(crate) struct Interface {
    /// Its name as composites have it: `nav/MapService`.
    pub name: At<String>,
    /// The interface that is called back.
    pub callback: Option<At<String>>,
}

/// A way to a service.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Bound {
    /// What it goes over.
    pub over: Binding,
    /// `uri`: where it is called over HTTP, where it says.
    pub uri: Option<At<String>>,
}

/// What messages of a service go over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Binding {
    /// `binding.sca`: whatever the runtime has.
    Sca,
    /// `binding.ws`, and others over HTTP.
    Http,
    /// `binding.jms`.
    Jms,
    /// `binding.rmi`.
    Rmi,
}

/// How many services a reference takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Multiplicity {
    /// It can do without.
    pub optional: bool,
    /// It takes several.
    pub many: bool,
}

impl Multiplicity {
    /// As SCDL writes it.
    pub(crate) fn word(self) -> &'static str {
        match (self.optional, self.many) {
            (false, false) => "1..1",
            (false, true) => "1..n",
            (true, false) => "0..1",
            (true, true) => "0..n",
        }
    }
}

/// A `<property>`: declared by a composite, or set for a component.
#[derive(Clone, Debug)]
pub(crate) struct Property {
    /// Its name.
    pub name: At<String>,
    /// Its type, without the prefix.
    pub kind: Option<At<String>>,
    /// Its values.
    pub values: Vec<At<String>>,
    /// Whether it has several values.
    pub many: bool,
    /// `source`: the property of the composite it takes its value from.
    pub source: Option<At<String>>,
    /// Whether somebody outside must set it.
    pub must_supply: bool,
    /// What has no counterpart, as it is written.
    pub notes: Vec<String>,
}

/// A wire from a reference to a service.
#[derive(Clone, Debug)]
pub(crate) struct Wire {
    /// The reference.
    pub source: Target,
    /// The service.
    pub target: Target,
}

/// `Component/name`, or a component alone.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Target {
    /// The component.
    pub component: At<String>,
    /// Its service or reference, where it is said.
    pub name: Option<At<String>>,
}

impl std::fmt::Display for Target {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.name {
            Some(name) => write!(f, "{}/{}", self.component.value, name.value),
            None => f.write_str(&self.component),
        }
    }
}

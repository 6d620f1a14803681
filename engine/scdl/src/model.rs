//! A composite as SCDL has it; every part knows its place in the file it was read from.

use asmotion_assembly::At;

/// A `<composite>`.
#[derive(Clone, Debug)]
pub(crate) struct ScdlComposite {
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
    pub properties: Vec<ScdlProperty>,
    /// `<component>`.
    pub components: Vec<ScdlComponent>,
    /// `<service promote>`.
    pub services: Vec<ScdlContract>,
    /// `<reference promote>`.
    pub references: Vec<ScdlContract>,
    /// `<wire>`, and the targets of references.
    pub wires: Vec<ScdlWire>,
    /// What has no counterpart, as it is written.
    pub notes: Vec<String>,
}

/// A `<component>`.
#[derive(Clone, Debug)]
pub(crate) struct ScdlComponent {
    /// Its name.
    pub name: At<String>,
    /// `<documentation>`.
    pub doc: Option<String>,
    /// Whether its references find their services by themselves, where it says so.
    pub autowire: Option<bool>,
    /// What it is made of.
    pub implementation: Option<ScdlImplementation>,
    /// `<service>`.
    pub services: Vec<ScdlContract>,
    /// `<reference>`.
    pub references: Vec<ScdlContract>,
    /// `<property>`.
    pub properties: Vec<ScdlProperty>,
    /// What has no counterpart, as it is written.
    pub notes: Vec<String>,
}

/// What a component is made of.
#[derive(Clone, Debug)]
pub(crate) enum ScdlImplementation {
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
pub(crate) struct ScdlContract {
    /// Its name.
    pub name: At<String>,
    /// Its interface, where it is said.
    pub interface: Option<ScdlInterface>,
    /// How others reach it, or it reaches others.
    pub bindings: Vec<ScdlBinding>,
    /// `promote`: what of the components it is.
    pub promote: Vec<ScdlTarget>,
    /// `target`: who answers.
    pub targets: Vec<ScdlTarget>,
    /// `multiplicity`.
    pub multiplicity: ScdlMultiplicity,
    /// Whether it finds its service by itself, where it says so.
    pub autowire: Option<bool>,
    /// What has no counterpart, as it is written.
    pub notes: Vec<String>,
}

/// An interface and the one that is called back.
#[derive(Clone, Debug)]
pub(crate) struct ScdlInterface {
    /// Its name as composites have it: `nav/MapService`.
    pub name: At<String>,
    /// The interface that is called back.
    pub callback: Option<At<String>>,
}

/// A way to a service.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ScdlBinding {
    /// What it goes over.
    pub over: ScdlTransport,
    /// `uri`: where it is called over HTTP, where it says.
    pub uri: Option<At<String>>,
}

/// What messages of a service go over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ScdlTransport {
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
pub(crate) struct ScdlMultiplicity {
    /// It can do without.
    pub optional: bool,
    /// It takes several.
    pub many: bool,
}

impl ScdlMultiplicity {
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
pub(crate) struct ScdlProperty {
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
pub(crate) struct ScdlWire {
    /// The reference.
    pub source: ScdlTarget,
    /// The service.
    pub target: ScdlTarget,
}

/// `Component/name`, or a component alone.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ScdlTarget {
    /// The component.
    pub component: At<String>,
    /// Its service or reference, where it is said.
    pub name: Option<At<String>>,
}

impl std::fmt::Display for ScdlTarget {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.name {
            Some(name) => write!(f, "{}/{}", self.component.value, name.value),
            None => f.write_str(&self.component),
        }
    }
}

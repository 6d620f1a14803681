//! The SCDL model of a composite; every part has its place in the file it was read from.

use asmotion_composite::At;

#[derive(Clone, Debug)]
pub(crate) struct ScdlComposite {
    pub name: At<String>,
    /// `targetNamespace`.
    pub namespace: Option<At<String>>,
    /// `<documentation>`.
    pub doc: Option<String>,
    /// `autowire`: references find their services by interface.
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
    /// Elements and attributes without a counterpart, as written.
    pub notes: Vec<String>,
}

#[derive(Clone, Debug)]
pub(crate) struct ScdlComponent {
    pub name: At<String>,
    /// `<documentation>`.
    pub doc: Option<String>,
    /// `autowire`: its references find their services by interface; `None` if not specified.
    pub autowire: Option<bool>,
    /// `<implementation.…>`; `None` if it is missing.
    pub implementation: Option<ScdlImplementation>,
    /// `<service>`.
    pub services: Vec<ScdlContract>,
    /// `<reference>`.
    pub references: Vec<ScdlContract>,
    /// `<property>`.
    pub properties: Vec<ScdlProperty>,
    /// Elements and attributes without a counterpart, as written.
    pub notes: Vec<String>,
}

/// The implementation of a component.
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
    pub name: At<String>,
    /// `<interface.…>`; `None` until it is known.
    pub interface: Option<ScdlInterface>,
    /// `<binding.…>`: transports over which it is provided or called.
    pub bindings: Vec<ScdlBinding>,
    /// `promote`: the services or references of components that it promotes.
    pub promote: Vec<ScdlTarget>,
    /// `target`: the services that it calls.
    pub targets: Vec<ScdlTarget>,
    /// `multiplicity`.
    pub multiplicity: ScdlMultiplicity,
    /// `autowire`: finds its service by interface; `None` if not specified.
    pub autowire: Option<bool>,
    /// Elements and attributes without a counterpart, as written.
    pub notes: Vec<String>,
}

impl ScdlContract {
    /// The URL that a reference of a component calls, and the transport of the calls; `None` if it calls a service of its
    /// composite.
    pub(crate) fn url(&self) -> Option<(ScdlTransport, &str)> {
        let mut bindings = self.bindings.iter();
        bindings.find_map(|bound| Some((bound.over, bound.uri.as_ref()?.value.as_str())))
    }
}

/// An interface, and optionally the interface for calls in the other direction.
#[derive(Clone, Debug)]
pub(crate) struct ScdlInterface {
    /// Name as in composite files, for example `nav/MapService`.
    pub name: At<String>,
    /// `callbackInterface`.
    pub callback: Option<At<String>>,
}

/// A `<binding.…>` of a service or reference.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ScdlBinding {
    pub over: ScdlTransport,
    /// `uri`: HTTP address of the service, or `robot://…` for a service of another robot; `None` if not specified.
    pub uri: Option<At<String>>,
}

/// The transport of a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ScdlTransport {
    /// `binding.sca`: left to the runtime.
    Sca,
    /// `binding.ws`, `binding.rest` and `binding.jsonrpc`.
    Http,
    /// `binding.jms`.
    Jms,
    /// `binding.rmi`.
    Rmi,
}

/// Number of services of a reference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct ScdlMultiplicity {
    /// The lower bound is 0.
    pub optional: bool,
    /// The upper bound is `n`.
    pub many: bool,
}

impl ScdlMultiplicity {
    /// The multiplicity as written in SCDL.
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
    pub name: At<String>,
    /// `type`, without the prefix.
    pub kind: Option<At<String>>,
    /// The values as written.
    pub values: Vec<At<String>>,
    /// `many`: the property is a list.
    pub many: bool,
    /// `source`: the property of the composite that supplies the value.
    pub source: Option<At<String>>,
    /// `mustSupply`: the property has no default.
    pub must_supply: bool,
    /// Elements and attributes without a counterpart, as written.
    pub notes: Vec<String>,
}

#[derive(Clone, Debug)]
pub(crate) struct ScdlWire {
    pub source: ScdlTarget,
    pub target: ScdlTarget,
}

/// An end of a wire: `Component/name`, or a component alone.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ScdlTarget {
    pub component: At<String>,
    /// The service or reference; `None` until it is known.
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

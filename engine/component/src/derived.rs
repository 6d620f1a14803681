//! Declarations as plain structs: each field declares one port or property, and its doc comment describes it.

use std::ops::Deref;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use asmotion_datum::{Datum, DatumError};

use crate::cycle::Cycle;
use crate::handle::Property;
use crate::interface::Interface;
use crate::property::PropertyValue;
use crate::setup::Setup;

/// The properties of a component as a plain struct, with one field for each property.
///
/// The derive takes everything from the field: the name, the description (the doc comment), and, from `#[property(…)]`,
/// the unit, the range, the default and the allowed choices. Algorithms use the same struct, so a property has one name
/// in composites, in the declaration and in the code.
///
/// A field may have any type that implements [`PropertyValue`]: numbers, truth values, text, lists, arrays, messages.
/// Beyond that it may be
/// - a [`Duration`](std::time::Duration), written as text in the attribute and as a number of its unit (`s` unless
///   given; `ms`, `us`) in composites; a range is mandatory,
/// - an enum that is a [`Word`](asmotion_datum::Word), marked `words`,
/// - another struct of properties, marked `flatten`, whose fields are declared in its place.
///
/// ```
/// use std::time::Duration;
/// use asmotion_component::{Interface, Properties, PropertySet};
///
/// /// Limits of a base.
/// #[derive(Properties)]
/// struct BaseProperties {
///     /// Forward speed limit.
///     #[property(unit = "m/s", range = 0.01..=20.0, default = 0.5)]
///     max_speed: f64,
///     /// Age from which odometry no longer counts.
///     #[property(range = "0s"..="10s", default = "200ms")]
///     odom_timeout_s: Duration,
/// }
///
/// let mut interface = Interface::new();
/// let properties: PropertySet<BaseProperties> = interface.properties();
/// assert_eq!(properties.odom_timeout_s, Duration::from_millis(200));
/// let declared = interface.declaration().property("odom_timeout_s").ok_or("declared")?;
/// assert_eq!((declared.unit.as_str(), declared.default.as_float()), ("s", Some(0.2)));
/// # Ok::<(), &str>(())
/// ```
pub trait Properties: Default {
    /// The struct of handles, one for each field.
    type Handles;

    /// Declares every field on an interface.
    fn declare(interface: &mut Interface) -> Self::Handles;

    /// Reads the current value of every field.
    fn read(handles: &Self::Handles, from: &impl PropertySource) -> Self;

    /// Returns the values as a record, for a frozen state.
    ///
    /// # Errors
    ///
    /// An error if a value cannot be represented as a datum.
    fn to_datum(&self) -> Result<Datum, DatumError>;

    /// Reads the record written by [`to_datum`](Self::to_datum).
    ///
    /// # Errors
    ///
    /// An error if a field is missing, unknown or of another type.
    fn of_datum(datum: &Datum) -> Result<Self, DatumError>;
}

/// Ports, services and references of a component as a plain struct of handles.
///
/// ```
/// use asmotion_component::{In, Interface, Out, Ports};
/// # asmotion_datum::message! {
/// #     /// A speed.
/// #     pub struct Speed = "test/Speed" {
/// #         /// m/s.
/// #         pub data: f64,
/// #     }
/// # }
///
/// #[derive(Ports)]
/// struct LimiterPorts {
///     /// Requested forward speed.
///     requested: In<Speed>,
///     /// The speed after limiting.
///     limited: Out<Speed>,
/// }
///
/// let mut interface = Interface::new();
/// let ports: LimiterPorts = interface.ports();
/// assert!(interface.declaration().input("requested").is_some());
/// ```
pub trait Ports: Sized {
    /// Declares every field on an interface.
    fn declare(interface: &mut Interface) -> Self;
}

/// A source of property values: a cycle, or the setup of a component being configured.
pub trait PropertySource {
    /// The current value of a property.
    fn property<T: PropertyValue>(&self, property: Property<T>) -> T;
}

impl PropertySource for Cycle<'_> {
    fn property<T: PropertyValue>(&self, property: Property<T>) -> T {
        Cycle::property(self, property)
    }
}

impl PropertySource for Setup<'_> {
    fn property<T: PropertyValue>(&self, property: Property<T>) -> T {
        Setup::property(self, property)
    }
}

/// Declared properties and a snapshot of their values. Dereferences to the snapshot.
///
/// Properties change between cycles only, so a component calls [`refresh`](Self::refresh) at the beginning of
/// [`Component::update`](crate::Component::update) (or once in `configure`, if later changes should have no effect) and
/// reads the fields afterwards. A refresh without a change copies nothing.
#[derive(Debug)]
pub struct PropertySet<P: Properties> {
    handles: P::Handles,
    /// Number of changes of the component's properties. Written by the component's own thread between cycles.
    revision: Arc<AtomicU64>,
    /// The value of `revision` at the last refresh; `None` before the first.
    seen: Option<u64>,
    values: P,
}

impl<P: Properties> PropertySet<P> {
    /// Reads the values again if a property has changed since the last refresh.
    pub fn refresh(&mut self, from: &impl PropertySource) -> &P {
        let revision = Some(self.revision.load(Ordering::Relaxed));
        if self.seen != revision {
            self.values = P::read(&self.handles, from);
            self.seen = revision;
        }
        &self.values
    }

    /// Sets the values; the next refresh reads all properties again.
    pub(crate) fn set_values(&mut self, values: P) {
        self.values = values;
        self.seen = None;
    }
}

/// The values as of the last refresh; the defaults before the first one.
impl<P: Properties> Deref for PropertySet<P> {
    type Target = P;

    fn deref(&self) -> &P {
        &self.values
    }
}

impl Interface {
    /// Declares the properties of a struct, in the order of its fields.
    pub fn properties<P: Properties>(&mut self) -> PropertySet<P> {
        PropertySet {
            handles: P::declare(self),
            revision: Arc::clone(self.revision()),
            seen: None,
            values: P::default(),
        }
    }

    /// Declares the ports, services and references of a struct, in the order of its fields.
    pub fn ports<P: Ports>(&mut self) -> P {
        P::declare(self)
    }
}

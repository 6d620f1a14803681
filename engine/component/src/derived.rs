//! Declarations as plain structs: each field is declared where it is documented, and read by its name.

use std::ops::Deref;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use asmotion_datum::{Datum, DatumError};

use crate::cycle::Cycle;
use crate::handle::Property;
use crate::interface::Interface;
use crate::property::PropertyValue;
use crate::setup::Setup;

/// The properties of a component as a plain struct, one field a property.
///
/// The derive takes everything from the field: the name, the description (the doc comment), and in `#[property(…)]`
/// the unit, the range, the default and the lawful choices. Algorithms use the same struct, so a property has one name
/// in composites, in the declaration and in the code.
///
/// A field may be whatever is a [`PropertyValue`]: numbers, truth values, text, lists, arrays, messages. Beyond that
/// it may be
/// - a [`Duration`](std::time::Duration), written as text in the attribute and as a number of its unit (`s` unless
///   given; `ms`, `us`) in composites; a range is mandatory,
/// - an enum that is a [`Word`](asmotion_datum::Word), marked `words`,
/// - another struct of properties, marked `flatten`, declared as if its fields stood here.
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
    /// One handle for each field.
    type Handles;

    /// Declares every field on an interface.
    fn declare(interface: &mut Interface) -> Self::Handles;

    /// Reads every field: a snapshot of one cycle.
    fn read(handles: &Self::Handles, from: &impl PropertySource) -> Self;

    /// The values as a record, for a frozen state.
    ///
    /// # Errors
    /// A value has no form as data.
    fn to_datum(&self) -> Result<Datum, DatumError>;

    /// Reads what [`to_datum`](Self::to_datum) wrote.
    ///
    /// # Errors
    /// A field is missing, unknown, or of another type.
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

/// Where properties can be read: in a cycle, and while a component is configured.
pub trait PropertySource {
    /// The present value of a property.
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

/// Declared properties together with the last snapshot of their values, which it dereferences to.
///
/// Properties change between cycles only, so a component calls [`refresh`](Self::refresh) first thing in
/// [`Component::update`](crate::Component::update) (or once in `configure`, where properties are to count only then) and
/// reads fields from there on. A refresh without a change in between copies nothing.
#[derive(Debug)]
pub struct PropertySet<P: Properties> {
    handles: P::Handles,
    /// Counts the changes of the component's properties; written by the component's own thread between cycles.
    revision: Arc<AtomicU64>,
    /// The revision the values were read at; none before the first refresh.
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

    /// Replaces the values until the next refresh, which reads them all again.
    pub(crate) fn set_values(&mut self, values: P) {
        self.values = values;
        self.seen = None;
    }
}

/// The values of the last refresh; before the first one, the defaults.
impl<P: Properties> Deref for PropertySet<P> {
    type Target = P;

    fn deref(&self) -> &P {
        &self.values
    }
}

impl Interface {
    /// Declares the properties of a struct.
    pub fn properties<P: Properties>(&mut self) -> PropertySet<P> {
        PropertySet {
            handles: P::declare(self),
            revision: Arc::clone(self.revision()),
            seen: None,
            values: P::default(),
        }
    }

    /// Declares the ports, services and references of a struct.
    pub fn ports<P: Ports>(&mut self) -> P {
        P::declare(self)
    }
}

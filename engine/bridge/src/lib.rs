//! Joins two styles of interaction: services, which are called, and periodic components, which read and write ports. A
//! [`PortProxy`] translates between them according to a map, without code. (The JOrocos paper names this as future
//! work.)

mod condition;
mod conversion;
mod converter;
mod fit;
mod proxy;
mod units;

pub use condition::{ConditionError, MessageCondition};
pub use conversion::{Conversion, Use};
pub use converter::{ConverterError, FieldConverter};
pub use fit::{SchemaMisfit, check_fit};
pub use proxy::{
    IdleCriterion, ListLength, Mapped, PortProxy, ProxyNotification, ProxyPort, ProxySettings,
    ReplyMode,
};

//! Two worlds that do not fit: services that are called, and periodic components that read and write ports. A
//! [`PortProxy`] joins them by a map, without code (the wish that the JOrocos paper ends with).

mod condition;
mod conversion;
mod fit;
mod proxy;

pub use condition::{ConditionError, MessageCondition};
pub use conversion::{Conversion, Use, inside};
pub use fit::{SchemaMisfit, fit};
pub use proxy::{
    IdleCriterion, Mapped, PortProxy, ProxyNotification, ProxyPort, ProxySettings, ReplyMode,
};

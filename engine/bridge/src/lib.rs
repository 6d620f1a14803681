//! Two worlds that do not fit: services that are called, and periodic components that read and write ports. A
//! [`PortProxy`] joins them by a map, without code (the wish that the JOrocos paper ends with).

mod condition;
mod conversion;
mod fit;
mod proxy;

pub use condition::{Condition, ConditionError};
pub use conversion::{Conversion, Use, inside};
pub use fit::{Misfit, fit};
pub use proxy::{Idle, Mapped, Mode, Notify, PortProxy, ProxyPort, Settings};

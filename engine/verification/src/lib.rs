//! Verification of composites: puts the specification of a component together with its environment.
//!
//! The possible values of an input of the specification follow from its binding and from the components that send to it: from their
//! specifications, or from their *protocols*. A protocol is a specification of what a component sends, depending on what it
//! receives ([`protocol`](mod@protocol)). A component without one may send anything at any time.

mod actor;
mod bound;
mod canonical;
pub mod conformance;
mod context;
mod currency;
mod environment;
mod error;
mod glue;
mod instrument;
mod merge;
mod message;
mod model;
mod network;
mod origin;
mod own_messages;
pub mod protocol;
mod protocol_text;
mod rename;
mod search;

pub use context::ModelContext;
pub use error::ModelError;
pub use model::{
    ComponentModel, ModelledEnvironment, canonical_model, component_model, specified_components,
};
pub use origin::ValueOrigin;

//! Converts between SCDL, the XML of the Service Component Architecture, and composite files; and reads CPF, the XML in
//! which Orocos RTT stores properties.

mod codes;
mod cpf;
mod export;
mod finish;
mod gateway;
mod import;
mod model;
mod name;
mod read;
mod resolve;
mod tca;
mod toml;
mod value;
mod write;
mod xml;

pub use codes::CODES;
pub use cpf::{Cpf, cpf};
pub use export::{Exported, export};
pub use import::{Imported, import};

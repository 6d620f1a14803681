//! SCDL, the XML in which the Service Component Architecture writes composites: read into composites
//! of this engine, and written from them. And CPF, that in which Orocos RTT keeps properties.

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

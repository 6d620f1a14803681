//! The XML formats: SCDL and CPF.

use crate::composite::shown;
use asmotion_composite::Tables;

/// A composite in SCDL is converted to composite files, which are TOML, and a report that can be rendered.
pub fn scdl(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes).into_owned();
    let imported = asmotion_scdl::import(&[("fuzz.composite".to_owned(), text)], &Tables::EMPTY);
    shown(&imported.report, &imported.sources);
    for (name, text) in &imported.files {
        let table = toml::from_str::<toml::Table>(text);
        assert!(table.is_ok(), "{name}: {table:?}\n{text}");
    }
}

/// A property file in CPF is converted to a table and a report that can be rendered.
pub fn cpf(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let read = asmotion_scdl::cpf("fuzz.cpf", &text);
    shown(&read.report, &read.sources);
}

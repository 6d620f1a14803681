//! Certificates for tests.

use std::io;
use std::path::Path;

use rcgen::{
    BasicConstraints, CertificateParams, DistinguishedName, DnType, Error, IsCa, Issuer, KeyPair,
};

/// Writes `authority.pem`, the certificate of a new authority, and those of two identities that it has signed: `server.pem` of
/// `localhost` and `client.pem`, with their keys `server.key` and `client.key`.
///
/// # Errors
/// A file cannot be written.
pub fn write_certificates(folder: &Path) -> io::Result<()> {
    for (name, text) in certificates().map_err(io::Error::other)? {
        std::fs::write(folder.join(name), text)?;
    }
    Ok(())
}

/// The files, by their names.
fn certificates() -> Result<Vec<(String, String)>, Error> {
    let key = KeyPair::generate()?;
    let mut parameters = CertificateParams::new(Vec::new())?;
    parameters.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
    parameters.distinguished_name = named("authority");
    let authority = parameters.self_signed(&key)?.pem();
    let mut files = vec![("authority.pem".to_owned(), authority)];
    let authority = Issuer::new(parameters, key);
    // signs itself and claims to be an authority, as tools make them by default
    let key = KeyPair::generate()?;
    let mut parameters = CertificateParams::new(["localhost".to_owned()])?;
    parameters.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
    let alone = parameters.self_signed(&key)?.pem();
    files.push(("alone.pem".to_owned(), alone));
    files.push(("alone.key".to_owned(), key.serialize_pem()));
    for (name, host) in [("server", "localhost"), ("client", "tester")] {
        let key = KeyPair::generate()?;
        let mut parameters = CertificateParams::new([host.to_owned()])?;
        parameters.distinguished_name = named(name);
        let certificate = parameters.signed_by(&key, &authority)?;
        files.push((format!("{name}.pem"), certificate.pem()));
        files.push((format!("{name}.key"), key.serialize_pem()));
    }
    Ok(files)
}

/// Creates a distinguished name. It must differ from the issuer's, or the certificate counts as self-signed.
fn named(name: &str) -> DistinguishedName {
    let mut names = DistinguishedName::new();
    names.push(DnType::CommonName, name);
    names
}

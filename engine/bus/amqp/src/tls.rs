//! TLS: certificate authority and client certificate.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::rustls::{ClientConfig, RootCertStore};

/// TLS settings of a link. Files are in PEM format.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TlsSettings {
    /// File with the certificate authority of the broker; the web's root certificates if `None`.
    pub authority: Option<PathBuf>,
    /// Client certificate and key, if the broker requires them.
    pub identity: Option<ClientIdentity>,
}

/// A client certificate and its key.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClientIdentity {
    /// File with the certificate, followed by any intermediate certificates.
    pub certificate: PathBuf,
    /// File with the private key.
    pub key: PathBuf,
}

impl TlsSettings {
    /// Creates the TLS connector. Reads the files each time, so that certificates can be renewed while the bus runs.
    ///
    /// # Errors
    /// A description of the file that cannot be read or is not PEM.
    pub(crate) fn connector(&self) -> Result<TlsConnector, String> {
        let provider = Arc::new(ring::default_provider());
        let config = ClientConfig::builder_with_provider(provider)
            .with_safe_default_protocol_versions()
            .map_err(|error| error.to_string())?
            .with_root_certificates(self.authorities()?);
        let config = match &self.identity {
            None => config.with_no_client_auth(),
            Some(identity) => {
                let unread = |error| unread(&identity.key, &error);
                let key = PrivateKeyDer::from_pem_file(&identity.key).map_err(unread)?;
                config
                    .with_client_auth_cert(certificates(&identity.certificate)?, key)
                    .map_err(|error| error.to_string())?
            }
        };
        Ok(TlsConnector::from(Arc::new(config)))
    }

    fn authorities(&self) -> Result<RootCertStore, String> {
        let mut authorities = RootCertStore::empty();
        let Some(file) = &self.authority else {
            let public = webpki_roots::TLS_SERVER_ROOTS.iter().cloned();
            authorities.extend(public);
            return Ok(authorities);
        };
        for certificate in certificates(file)? {
            let added = authorities.add(certificate);
            added.map_err(|error| format!("`{}`: {error}", file.display()))?;
        }
        Ok(authorities)
    }
}

fn certificates(file: &Path) -> Result<Vec<CertificateDer<'static>>, String> {
    let all = CertificateDer::pem_file_iter(file).and_then(Iterator::collect);
    all.map_err(|error| unread(file, &error))
}

fn unread(file: &Path, error: &dyn std::fmt::Display) -> String {
    format!("`{}`: {error}", file.display())
}

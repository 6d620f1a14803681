//! What goes out.

use asmotion_datum::Codec;
use http_body_util::Full;
use hyper::body::Bytes;
use hyper::{Response, StatusCode, header};

/// An answer, whole.
pub(crate) type HttpResponse = Response<Full<Bytes>>;

/// An answer in JSON.
pub(crate) fn json(status: StatusCode, json: String) -> HttpResponse {
    let mut response = Response::new(Full::new(Bytes::from(json + "\n")));
    *response.status_mut() = status;
    let kind = header::HeaderValue::from_static(Codec::Json.content_type());
    response.headers_mut().insert(header::CONTENT_TYPE, kind);
    response
}

/// The request is with its component, and nobody will be answered.
pub(crate) fn accepted() -> HttpResponse {
    let mut response = Response::new(Full::default());
    *response.status_mut() = StatusCode::ACCEPTED;
    response
}

//! Builds HTTP responses.

use asmotion_datum::Codec;
use asmotion_http::HttpResponse;
use http_body_util::Full;
use hyper::body::Bytes;
use hyper::{Response, StatusCode, header};

/// A response with a JSON body.
pub(crate) fn json(status: StatusCode, json: String) -> HttpResponse {
    let mut response = Response::new(Full::new(Bytes::from(json + "\n")));
    *response.status_mut() = status;
    let kind = header::HeaderValue::from_static(Codec::Json.content_type());
    response.headers_mut().insert(header::CONTENT_TYPE, kind);
    response
}

/// The response to a one-way call: the provider has the request.
pub(crate) fn accepted() -> HttpResponse {
    let mut response = Response::new(Full::default());
    *response.status_mut() = StatusCode::ACCEPTED;
    response
}

//! Handles HTTP requests.

use std::net::SocketAddr;
use std::sync::Arc;

use asmotion_bus::{Bus, CallFailure, LinkState, Payload, Request, SenderId};
use asmotion_datum::{Codec, Datum, DatumError, Schema, Shape, json as written};
use asmotion_http::{ConnectionPlace, HttpHandler, HttpRequest, HttpResponse, call};
use http_body_util::{BodyExt, LengthLimitError, Limited};
use hyper::{Method, StatusCode, header};
use serde_json::json;
use tokio::time::timeout;

use crate::access;
use crate::components::ComponentListing;
use crate::listing;
use crate::parameters::CallParameters;
use crate::problem::Problem;
use crate::response;
use crate::service::{GatewayOperation, GatewayService};
use crate::settings::GatewaySettings;

/// Handles the requests of all connections.
pub(crate) struct RequestHandler {
    pub services: Vec<GatewayService>,
    pub components: ComponentListing,
    pub bus: Arc<dyn Bus>,
    pub settings: GatewaySettings,
}

impl HttpHandler for RequestHandler {
    async fn respond(
        &self,
        request: HttpRequest,
        from: SocketAddr,
        place: &Arc<ConnectionPlace>,
    ) -> HttpResponse {
        let answer = self.route(request, from, place).await;
        answer.unwrap_or_else(|problem| problem.response())
    }

    fn busy(&self) -> HttpResponse {
        Problem::Busy.response()
    }
}

impl RequestHandler {
    async fn route(
        &self,
        request: HttpRequest,
        from: SocketAddr,
        place: &ConnectionPlace,
    ) -> Result<HttpResponse, Problem> {
        access::check(&self.settings, request.uri(), request.headers())?;
        // only browsers send this header; web pages of other origins must not control a robot
        if request.headers().contains_key(header::ORIGIN) {
            return Err(Problem::WebPage);
        }
        let path = request.uri().path().to_owned();
        let parts: Vec<&str> = path.trim_matches('/').split('/').collect();
        match (parts.as_slice(), request.method()) {
            (["health"], &Method::GET) => Ok(self.health()),
            (["services"], &Method::GET) => Ok(listing::all(&self.services)),
            (["services", name], &Method::GET) => Ok(listing::one(self.service(name)?)),
            (["components"], &Method::GET) => self.components.all(),
            (["components", name], &Method::GET) => self.components.one(name),
            (["services", name, operation], &Method::POST) => {
                let service = self.service(name)?;
                let operation = self::operation(service, operation)?;
                let called = (service, operation);
                self.call(called, request, from, place).await
            }
            (["health"] | ["services" | "components"] | ["services" | "components", _], _) => {
                Err(Problem::Method { allowed: "GET" })
            }
            (["services", _, _], _) => Err(Problem::Method { allowed: "POST" }),
            _ => Err(Problem::UnknownPath { path }),
        }
    }

    /// Reports the state of the bus.
    fn health(&self) -> HttpResponse {
        let (status, state, reason) = match self.bus.health().link {
            LinkState::Up => (StatusCode::OK, "UP", None),
            LinkState::Blocked { reason } => {
                (StatusCode::SERVICE_UNAVAILABLE, "BLOCKED", Some(reason))
            }
            LinkState::Down { reason } => (StatusCode::SERVICE_UNAVAILABLE, "DOWN", Some(reason)),
        };
        let mut health = json!({ "state": state });
        if let Some(reason) = reason {
            health["reason"] = reason.to_string().into();
        }
        response::json(status, health.to_string())
    }

    fn service(&self, name: &str) -> Result<&GatewayService, Problem> {
        let found = self.services.iter().find(|service| service.name == name);
        found.ok_or_else(|| Problem::UnknownService {
            name: name.to_owned(),
            available: self.services.iter().map(|it| it.name.clone()).collect(),
        })
    }

    async fn call(
        &self,
        (service, operation): (&GatewayService, &GatewayOperation),
        request: HttpRequest,
        from: SocketAddr,
        place: &ConnectionPlace,
    ) -> Result<HttpResponse, Problem> {
        let question = CallParameters::of(request.uri().query())?;
        let one_way = question.one_way || operation.one_way;
        let time = question.timeout.unwrap_or(service.timeout);
        let trace = request.headers().get("traceparent");
        let trace = trace.and_then(|trace| trace.to_str().ok()?.parse().ok());
        let argument = self.argument(service, operation, request).await?;
        // the sender is no process of the system, so the incarnation is 0
        let origin = SenderId::new(format!("http {from}"), 0);
        let mut request = Request::new(origin, Payload::of(argument), time);
        request.trace = trace;
        let address = format!("{}.{}", service.name, operation.name);
        let _under_way = place.begin_call();
        match call(&*self.bus, &address, request, one_way).await {
            Ok(_) if one_way => Ok(response::accepted()),
            Ok(payload) => result(&payload, operation).map_err(Problem::Answer),
            Err(CallFailure::Timeout) => Err(Problem::Timeout { after: time }),
            Err(CallFailure::Unavailable | CallFailure::Cancelled) => Err(Problem::Unavailable {
                service: service.name.clone(),
            }),
            Err(CallFailure::Stopped) => Err(Problem::Stopped {
                service: service.name.clone(),
            }),
            Err(CallFailure::Refused(refusal)) => Err(Problem::Fault {
                refusal,
                path: schema_at(service),
            }),
        }
    }

    /// Reads and checks the request of an operation.
    async fn argument(
        &self,
        service: &GatewayService,
        operation: &GatewayOperation,
        request: HttpRequest,
    ) -> Result<Datum, Problem> {
        let kind = request.headers().get(header::CONTENT_TYPE).cloned();
        let limit = self.settings.max_body;
        let body = Limited::new(request.into_body(), limit).collect();
        let within = self.settings.request_timeout;
        let body = timeout(within, body).await;
        let body = body.map_err(|_| Problem::RequestTimeout { within })?;
        let body = body.map_err(|error| {
            if error.is::<LengthLimitError>() {
                Problem::TooLarge { limit }
            } else {
                Problem::IncompleteBody
            }
        })?;
        let bytes = body.to_bytes();
        let path = schema_at(service);
        if bytes.is_empty() {
            let argument = operation.request.complete(empty_argument(operation));
            return argument.map_err(|error| Problem::Argument { error, path });
        }
        let kind = kind.as_ref().map_or("", |kind| kind.to_str().unwrap_or(""));
        let essence = kind.split(';').next().unwrap_or(kind).trim();
        if Codec::of_content_type(essence) != Some(Codec::Json) {
            let content_type = kind.to_owned();
            return Err(Problem::ContentType {
                found: content_type,
            });
        }
        let argument = read(&bytes, &operation.request);
        argument.map_err(|error| Problem::Argument { error, path })
    }
}

/// Decodes JSON and converts it to the form that a typed writer would give it.
fn read(json: &[u8], schema: &Schema) -> Result<Datum, DatumError> {
    let argument = Codec::Json.decode(json, schema)?;
    schema.complete(argument)
}

/// Path at which the schemas of a service are available.
fn schema_at(service: &GatewayService) -> String {
    format!("/services/{}", service.name)
}

fn operation<'s>(service: &'s GatewayService, name: &str) -> Result<&'s GatewayOperation, Problem> {
    let found = service.operations.iter().find(|it| it.name == name);
    found.ok_or_else(|| Problem::UnknownOperation {
        service: service.name.clone(),
        name: name.to_owned(),
        available: service
            .operations
            .iter()
            .map(|it| it.name.clone())
            .collect(),
    })
}

/// The value of an empty body: a record without fields, which all have their initial values, or null for any other
/// type.
fn empty_argument(operation: &GatewayOperation) -> Datum {
    if matches!(operation.request.shape, Shape::Record(_)) {
        Datum::Record(Vec::new())
    } else {
        Datum::Null
    }
}

fn result(payload: &Payload, operation: &GatewayOperation) -> Result<HttpResponse, DatumError> {
    let datum = payload.to_datum_of(&operation.response)?;
    Ok(response::json(StatusCode::OK, written::encode(&datum)?))
}

//! Lists services and operations as JSON, with JSON Schemas of all types.

use asmotion_datum::json_schema::SchemaDefinitions;
use hyper::StatusCode;
use serde_json::{Value, json};

use asmotion_http::HttpResponse;

use crate::response;
use crate::service::{GatewayOperation, GatewayService};

/// JSON pointer to the schemas of named types.
const SCHEMAS: &str = "#/$defs";

/// The listing of all services.
pub(crate) fn all(services: &[GatewayService]) -> HttpResponse {
    let mut definitions = SchemaDefinitions::at(SCHEMAS);
    let services: Vec<Value> = services
        .iter()
        .map(|it| service(it, &mut definitions))
        .collect();
    let listing = json!({ "services": services, "$defs": definitions.into_value() });
    response::json(StatusCode::OK, listing.to_string())
}

/// The listing of one service.
pub(crate) fn one(of: &GatewayService) -> HttpResponse {
    let mut definitions = SchemaDefinitions::at(SCHEMAS);
    let mut listing = service(of, &mut definitions);
    listing["$defs"] = definitions.into_value();
    response::json(StatusCode::OK, listing.to_string())
}

fn service(service: &GatewayService, definitions: &mut SchemaDefinitions) -> Value {
    let operations = service.operations.iter();
    let operations = operations.map(|it| operation(service, it, definitions));
    json!({
        "name": service.name,
        "interface": service.interface,
        "timeout_ms": u64::try_from(service.timeout.as_millis()).unwrap_or(u64::MAX),
        "operations": operations.collect::<Vec<_>>(),
    })
}

fn operation(
    service: &GatewayService,
    operation: &GatewayOperation,
    definitions: &mut SchemaDefinitions,
) -> Value {
    let mut description = json!({
        "name": operation.name,
        "call": format!("POST /services/{}/{}", service.name, operation.name),
        "oneway": operation.one_way,
        "argument": definitions.schema(&operation.request),
    });
    if !operation.one_way {
        description["result"] = definitions.schema(&operation.response);
    }
    description
}

//! The types of a component's ports and operations, for display.

use asmotion_component::Declaration;
use asmotion_datum::{Schema, Shape};
use asmotion_remote::{PresentComponent, PresentEndpoint, PresentOperation, RemoteComponent};

/// The types that a component declares. Its presence has the names of types only.
#[derive(Default)]
pub(super) struct DeclaredTypes(Declaration);

impl DeclaredTypes {
    /// The types of a component, which is asked for them if one has no name; none if it does not answer.
    pub(super) fn of(remote: &RemoteComponent, component: &PresentComponent) -> Self {
        let ports = component.inputs.iter().chain(&component.outputs);
        let operations = component.services.iter().flat_map(|it| &it.operations);
        let is_named = ports.clone().all(|port| !port.kind.is_empty())
            && operations
                .clone()
                .all(|it| !it.request.is_empty() && !it.response.is_empty());
        if is_named {
            return Self::default();
        }
        Self(remote.declaration().unwrap_or_default())
    }

    /// The type of a port: its name, or its fields if it has none.
    pub(super) fn port(&self, port: &PresentEndpoint) -> String {
        let mut ports = self.0.inputs.iter().chain(&self.0.outputs);
        let schema = ports.find(|it| it.name == port.name).map(|it| &it.schema);
        type_text(&port.kind, schema)
    }

    /// The types of an operation.
    pub(super) fn operation(&self, service: &str, operation: &PresentOperation) -> String {
        let service = self.0.service(service);
        let mut operations = service.iter().flat_map(|it| &it.operations);
        let declared = operations.find(|it| it.name == operation.name);
        operation_types(
            &type_text(&operation.request, declared.map(|it| &it.request)),
            &type_text(&operation.response, declared.map(|it| &it.response)),
        )
    }
}

/// Types of an operation, after its name; empty if neither is known, as for most services of specifications.
fn operation_types(request: &str, response: &str) -> String {
    let shown = |name: &str| if name.is_empty() { "-" } else { name }.to_owned();
    match (request, response) {
        ("", "") => String::new(),
        (request, response) => format!(": {} -> {}", shown(request), shown(response)),
    }
}

/// The name of a type, or its fields; empty if it is not known.
fn type_text(name: &str, schema: Option<&Schema>) -> String {
    let schema = schema.filter(|it| name.is_empty() && it.shape != Shape::Any);
    schema.map_or_else(|| name.to_owned(), Schema::to_string)
}

#[cfg(test)]
mod tests {
    use asmotion_component::declaration::{
        OperationDeclaration, PortDeclaration, ServiceDeclaration,
    };
    use asmotion_datum::OutlineKey;

    use super::*;

    fn width() -> Schema {
        let field = OutlineKey::new("width", "", Schema::plain(Shape::F64));
        Schema::plain(Shape::Record(vec![field]))
    }

    fn declared() -> DeclaredTypes {
        DeclaredTypes(Declaration {
            inputs: vec![PortDeclaration {
                name: "goal".to_owned(),
                schema: width(),
                doc: String::new(),
                safe: None,
                command: false,
                optional: false,
            }],
            services: vec![ServiceDeclaration {
                name: "grip".to_owned(),
                interface: "acme/Grip".to_owned(),
                doc: String::new(),
                operations: vec![OperationDeclaration {
                    name: "close".to_owned(),
                    request: width(),
                    response: Schema::plain(Shape::Any),
                    while_stopped: false,
                }],
            }],
            ..Declaration::default()
        })
    }

    #[test]
    fn a_type_without_a_name_is_shown_by_its_fields() {
        let port = |name: &str, kind: &str| {
            declared().port(&PresentEndpoint {
                name: name.to_owned(),
                kind: kind.to_owned(),
                lost: 0,
                waiting: 0,
            })
        };
        assert_eq!(port("goal", ""), "{width: float64}");
        assert_eq!(port("goal", "acme/Opening"), "acme/Opening");
        assert_eq!(port("other", ""), "");
    }

    #[test]
    fn an_operation_shows_the_types_that_are_known() {
        let operation = |name: &str, response: &str| {
            let operation = PresentOperation {
                name: name.to_owned(),
                response: response.to_owned(),
                ..PresentOperation::default()
            };
            declared().operation("grip", &operation)
        };
        assert_eq!(operation("close", ""), ": {width: float64} -> -");
        assert_eq!(
            operation("close", "std_msgs/Bool"),
            ": {width: float64} -> std_msgs/Bool"
        );
        assert_eq!(operation("open", ""), "");
    }
}

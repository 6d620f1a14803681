//! Type descriptions of ROS 2 (REP 2011, REP 2016): the structures of a type, and of all types in it.

use crate::catalogue::Catalogue;
use crate::definition::{Count, Element, Field, FieldType, Interface, Primitive, Structure};
use crate::error::DefinitionError;
use crate::name::InterfaceName;

/// The field of a structure without fields, since IDL has no empty structures.
const PLACEHOLDER: &str = "structure_needs_at_least_one_member";

/// A type and the types that it refers to, sorted by name.
pub(crate) struct TypeDescription {
    /// The type.
    pub of: IndividualType,
    /// The types of its fields, and of theirs.
    pub referenced: Vec<IndividualType>,
}

/// A structure with its name.
#[derive(Clone)]
pub(crate) struct IndividualType {
    /// Name, with package and kind.
    pub name: String,
    /// Fields.
    pub fields: Vec<DescribedField>,
}

/// A field of a structure.
#[derive(Clone)]
pub(crate) struct DescribedField {
    /// Name.
    pub name: String,
    /// Number of the type (`type_description_interfaces/msg/FieldType`).
    pub type_id: u8,
    /// Length of an array, or bound of a sequence; else 0.
    pub capacity: usize,
    /// Bound of a string; else 0.
    pub string_capacity: usize,
    /// Name of the type of a structure; else empty.
    pub nested: String,
}

/// Number of the type of a nested structure.
const NESTED: u8 = 1;
/// Added to the number of the type of an element for an array, a bounded sequence, and a sequence.
const ARRAY: u8 = 48;
/// See [`ARRAY`].
const BOUNDED_SEQUENCE: u8 = 96;
/// See [`ARRAY`].
const SEQUENCE: u8 = 144;

impl Catalogue {
    /// The type description of an interface. Services and actions have structures that their definitions do not
    /// mention: the event of a service, and the services and messages of an action.
    pub(crate) fn type_description(
        &self,
        name: &InterfaceName,
    ) -> Result<TypeDescription, DefinitionError> {
        let mut referenced = Vec::new();
        for inner in self.contained(name)? {
            referenced.push(individual(inner, &self.message(inner)?.fields));
        }
        let of = match self.interface(name)? {
            Interface::Message(structure) => individual(name, &structure.fields),
            Interface::Service { request, response } => {
                self.service(name, request, response, &mut referenced)?
            }
            Interface::Action {
                goal,
                result,
                feedback,
            } => self.action(name, [goal, result, feedback], &mut referenced)?,
        };
        referenced.sort_by(|a, b| a.name.cmp(&b.name));
        referenced.dedup_by(|a, b| a.name == b.name);
        Ok(TypeDescription { of, referenced })
    }

    /// Adds a message that a service or action refers to, with its own messages.
    fn refer(
        &self,
        package: &str,
        name: &str,
        referenced: &mut Vec<IndividualType>,
    ) -> Result<FieldType, DefinitionError> {
        let name = InterfaceName::message(package, name);
        for inner in self.contained(&name)? {
            referenced.push(individual(inner, &self.message(inner)?.fields));
        }
        referenced.push(individual(&name, &self.message(&name)?.fields));
        Ok(one(Element::Message(name)))
    }

    fn service(
        &self,
        name: &InterfaceName,
        request: &Structure,
        response: &Structure,
        referenced: &mut Vec<IndividualType>,
    ) -> Result<IndividualType, DefinitionError> {
        let requests = name.part("Request");
        let responses = name.part("Response");
        let events = name.part("Event");
        referenced.push(individual(&requests, &request.fields));
        referenced.push(individual(&responses, &response.fields));
        let info = self.refer("service_msgs", "ServiceEventInfo", referenced)?;
        let at_most_one = |name: &InterfaceName| FieldType {
            element: Element::Message(name.clone()),
            count: Count::AtMost(1),
        };
        let event = [
            field("info", info),
            field("request", at_most_one(&requests)),
            field("response", at_most_one(&responses)),
        ];
        referenced.push(individual(&events, &event));
        let parts = [
            field("request_message", one(Element::Message(requests))),
            field("response_message", one(Element::Message(responses))),
            field("event_message", one(Element::Message(events))),
        ];
        Ok(individual(name, &parts))
    }

    fn action(
        &self,
        name: &InterfaceName,
        [goal, result, feedback]: [&Structure; 3],
        referenced: &mut Vec<IndividualType>,
    ) -> Result<IndividualType, DefinitionError> {
        let of_part = |suffix: &str| one(Element::Message(name.part(suffix)));
        for (suffix, structure) in [("Goal", goal), ("Result", result), ("Feedback", feedback)] {
            referenced.push(individual(&name.part(suffix), &structure.fields));
        }
        let id = self.refer("unique_identifier_msgs", "UUID", referenced)?;
        let stamp = self.refer("builtin_interfaces", "Time", referenced)?;
        let structure = |fields: Vec<Field>| Structure {
            constants: Vec::new(),
            fields,
        };
        let int8 = one(Element::Primitive(Primitive::Int8));
        let accepted = one(Element::Primitive(Primitive::Bool));
        let send_goal = self.service(
            &name.part("SendGoal"),
            &structure(vec![
                field("goal_id", id.clone()),
                field("goal", of_part("Goal")),
            ]),
            &structure(vec![field("accepted", accepted), field("stamp", stamp)]),
            referenced,
        )?;
        let get_result = self.service(
            &name.part("GetResult"),
            &structure(vec![field("goal_id", id.clone())]),
            &structure(vec![
                field("status", int8),
                field("result", of_part("Result")),
            ]),
            referenced,
        )?;
        let message = [field("goal_id", id), field("feedback", of_part("Feedback"))];
        referenced.push(individual(&name.part("FeedbackMessage"), &message));
        referenced.extend([send_goal, get_result]);
        let parts = [
            field("goal", of_part("Goal")),
            field("result", of_part("Result")),
            field("feedback", of_part("Feedback")),
            field("send_goal_service", of_part("SendGoal")),
            field("get_result_service", of_part("GetResult")),
            field("feedback_message", of_part("FeedbackMessage")),
        ];
        Ok(individual(name, &parts))
    }
}

fn one(element: Element) -> FieldType {
    FieldType {
        element,
        count: Count::One,
    }
}

fn field(name: &str, of: FieldType) -> Field {
    Field {
        of,
        name: name.to_owned(),
        default: None,
    }
}

fn individual(name: &InterfaceName, fields: &[Field]) -> IndividualType {
    let mut described: Vec<DescribedField> = fields.iter().map(described).collect();
    if described.is_empty() {
        let byte = one(Element::Primitive(Primitive::Uint8));
        described.push(self::described(&field(PLACEHOLDER, byte)));
    }
    IndividualType {
        name: name.to_string(),
        fields: described,
    }
}

fn described(field: &Field) -> DescribedField {
    let FieldType { element, count } = &field.of;
    let (type_id, string_capacity) = match element {
        Element::Primitive(primitive) => (number(*primitive), 0),
        Element::String(None) => (17, 0),
        Element::WideString(None) => (18, 0),
        Element::String(Some(bound)) => (21, *bound),
        Element::WideString(Some(bound)) => (22, *bound),
        Element::Message(_) => (NESTED, 0),
    };
    let (added, capacity) = match count {
        Count::One => (0, 0),
        Count::Exactly(length) => (ARRAY, *length),
        Count::AtMost(bound) => (BOUNDED_SEQUENCE, *bound),
        Count::Any => (SEQUENCE, 0),
    };
    let nested = match element {
        Element::Message(name) => name.to_string(),
        Element::Primitive(_) | Element::String(_) | Element::WideString(_) => String::new(),
    };
    DescribedField {
        name: field.name.clone(),
        type_id: type_id + added,
        capacity,
        string_capacity,
        nested,
    }
}

/// The number of a primitive type. `char` of a definition is an unsigned integer of eight bits in IDL. Times are messages in
/// ROS 2, so theirs occur in no definition.
fn number(primitive: Primitive) -> u8 {
    match primitive {
        Primitive::Time | Primitive::Duration => 0,
        Primitive::Int8 => 2,
        Primitive::Uint8 | Primitive::Char => 3,
        Primitive::Int16 => 4,
        Primitive::Uint16 => 5,
        Primitive::Int32 => 6,
        Primitive::Uint32 => 7,
        Primitive::Int64 => 8,
        Primitive::Uint64 => 9,
        Primitive::Float32 => 10,
        Primitive::Float64 => 11,
        Primitive::Bool => 15,
        Primitive::Byte => 16,
    }
}

impl TypeDescription {
    /// The description as JSON, with the order and the blanks of which the hash is taken.
    pub fn to_json(&self) -> String {
        let mut text = String::from("{\"type_description\": ");
        self.of.write(&mut text);
        text.push_str(", \"referenced_type_descriptions\": [");
        for (index, one) in self.referenced.iter().enumerate() {
            if index > 0 {
                text.push_str(", ");
            }
            one.write(&mut text);
        }
        text.push_str("]}");
        text
    }
}

impl IndividualType {
    fn write(&self, text: &mut String) {
        use std::fmt::Write as _;
        // writing to a string cannot fail
        let _ = write!(text, "{{\"type_name\": \"{}\", \"fields\": [", self.name);
        for (index, field) in self.fields.iter().enumerate() {
            if index > 0 {
                text.push_str(", ");
            }
            let _ = write!(
                text,
                "{{\"name\": \"{}\", \"type\": {{\"type_id\": {}, \"capacity\": {}, \"string_capacity\": {}, \
                 \"nested_type_name\": \"{}\"}}}}",
                field.name, field.type_id, field.capacity, field.string_capacity, field.nested
            );
        }
        text.push_str("]}");
    }
}

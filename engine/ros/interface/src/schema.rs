//! Schemas of messages.

use asmotion_datum::{OutlineKey, Schema, Shape, shared_name};

use crate::catalogue::Catalogue;
use crate::definition::{Count, Element, Field, Interface, Primitive, Structure};
use crate::distribution::Distribution;
use crate::error::DefinitionError;
use crate::name::InterfaceName;

/// The type of times, in ROS 2 a message, and here also the type of `time` in ROS 1.
const TIME: &str = "builtin_interfaces/Time";
/// The type of durations.
const DURATION: &str = "builtin_interfaces/Duration";
/// The type of headers, which in ROS 1 have a sequence number.
const HEADER: &str = "std_msgs/Header";

impl Catalogue {
    /// The schema of a message, whose name is the short one: `geometry_msgs/Twist`. It is that of the wire, for the codecs
    /// `cdr` (ROS 2) and `ros1`.
    ///
    /// `time` and `duration` of ROS 1 are `builtin_interfaces/Time` and `Duration`, which have the same fields. Bounds of
    /// strings and sequences are not part of a schema.
    ///
    /// # Errors
    /// A definition is missing, or a message contains itself.
    pub fn schema(&self, name: &InterfaceName) -> Result<Schema, DefinitionError> {
        self.contained(name)?;
        let structure = self.message(name)?;
        self.record(name.short(), structure)
    }

    /// The schema of a message without the differences between the generations of ROS, as components use it: headers have no
    /// sequence number, and times have signed seconds and unsigned nanoseconds, as in ROS 2.
    ///
    /// # Errors
    /// As [`schema`](Self::schema).
    pub fn common_schema(&self, name: &InterfaceName) -> Result<Schema, DefinitionError> {
        self.schema(name).map(common)
    }

    /// The schemas of the structures of an interface, in their order: of a message, of request and response, or of goal,
    /// result and feedback. Those of services and actions have the names `nav_msgs/GetMap_Request` and so on.
    ///
    /// # Errors
    /// A definition is missing, or a message contains itself.
    pub fn schemas(&self, name: &InterfaceName) -> Result<Vec<Schema>, DefinitionError> {
        self.contained(name)?;
        let suffixes: &[&str] = match self.interface(name)? {
            Interface::Message(_) => return Ok(vec![self.schema(name)?]),
            Interface::Service { .. } => &["Request", "Response"],
            Interface::Action { .. } => &["Goal", "Result", "Feedback"],
        };
        let structures = self.interface(name)?.structures();
        let named = structures.into_iter().zip(suffixes);
        named
            .map(|(structure, suffix)| self.record(name.part(suffix).short(), structure))
            .collect()
    }

    fn record(&self, name: String, structure: &Structure) -> Result<Schema, DefinitionError> {
        let mut fields = Vec::new();
        for field in &structure.fields {
            let schema = self.field(field)?;
            fields.push(OutlineKey::new(shared_name(&field.name), "", schema));
        }
        Ok(Schema {
            name: name.into(),
            shape: Shape::Record(fields),
        })
    }

    fn field(&self, field: &Field) -> Result<Schema, DefinitionError> {
        let element = match &field.of.element {
            Element::Primitive(primitive) => self.primitive(*primitive),
            Element::String(_) | Element::WideString(_) => Schema::plain(Shape::Text),
            Element::Message(name) => {
                let inner = self.message(name)?;
                self.record(name.short(), inner)?
            }
        };
        Ok(match field.of.count {
            Count::One => element,
            Count::Exactly(count) => Schema::many(element, Some(count)),
            Count::AtMost(_) | Count::Any => Schema::many(element, None),
        })
    }

    fn primitive(&self, primitive: Primitive) -> Schema {
        Schema::plain(match primitive {
            Primitive::Bool => Shape::Bool,
            Primitive::Byte => match self.distribution() {
                Distribution::Ros1 => Shape::I8,
                Distribution::Ros2 => Shape::U8,
            },
            Primitive::Int8 => Shape::I8,
            Primitive::Char | Primitive::Uint8 => Shape::U8,
            Primitive::Int16 => Shape::I16,
            Primitive::Uint16 => Shape::U16,
            Primitive::Int32 => Shape::I32,
            Primitive::Uint32 => Shape::U32,
            Primitive::Int64 => Shape::I64,
            Primitive::Uint64 => Shape::U64,
            Primitive::Float32 => Shape::F32,
            Primitive::Float64 => Shape::F64,
            Primitive::Time => return of_two(TIME, Shape::U32, Shape::U32),
            Primitive::Duration => return of_two(DURATION, Shape::I32, Shape::I32),
        })
    }
}

/// A schema without the differences between the generations of ROS: see [`Catalogue::common_schema`].
pub fn common(schema: Schema) -> Schema {
    let shape = match schema.shape {
        Shape::Record(_) if *schema.name == *TIME => return of_two(TIME, Shape::I32, Shape::U32),
        Shape::Record(_) if *schema.name == *DURATION => {
            return of_two(DURATION, Shape::I32, Shape::U32);
        }
        Shape::Record(mut fields) => {
            if *schema.name == *HEADER {
                fields.retain(|field| *field.name != *"seq");
            }
            for field in &mut fields {
                let inner = std::mem::replace(&mut field.schema, Schema::plain(Shape::Any));
                field.schema = common(inner);
            }
            Shape::Record(fields)
        }
        Shape::List(element) => Shape::List(Box::new(common(*element))),
        Shape::Array(element, count) => Shape::Array(Box::new(common(*element)), count),
        shape @ (Shape::Any
        | Shape::Bool
        | Shape::Text
        | Shape::F32
        | Shape::F64
        | Shape::I8
        | Shape::I16
        | Shape::I32
        | Shape::I64
        | Shape::U8
        | Shape::U16
        | Shape::U32
        | Shape::U64
        | Shape::Option(_)) => shape,
    };
    Schema { shape, ..schema }
}

/// A record of seconds and nanoseconds.
fn of_two(name: &'static str, seconds: Shape, nanoseconds: Shape) -> Schema {
    let field = |name, doc, shape| OutlineKey::new(name, doc, Schema::plain(shape));
    let fields = vec![
        field("sec", "s", seconds),
        field("nanosec", "ns", nanoseconds),
    ];
    Schema::record(name, fields)
}

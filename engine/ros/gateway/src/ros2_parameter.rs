//! Values of properties as parameters of ROS 2, and back.
//!
//! A record becomes a parameter for each field, such as `pid.p`. A list of records and other values that ROS has no type for are
//! texts in JSON.

use asmotion_component::declaration::PropertyDeclaration;
use asmotion_datum::{Codec, Datum, Schema, Shape, json};

use crate::desk::DeskComponent;

/// Deepest field of a property that is a parameter of its own.
const DEEPEST: usize = 8;

/// Types of `rcl_interfaces/msg/ParameterType`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum ParameterType {
    NotSet = 0,
    Bool = 1,
    Integer = 2,
    Double = 3,
    Text = 4,
    Bytes = 5,
    Bools = 6,
    Integers = 7,
    Doubles = 8,
    Texts = 9,
}

impl ParameterType {
    const ALL: [Self; 10] = [
        Self::NotSet,
        Self::Bool,
        Self::Integer,
        Self::Double,
        Self::Text,
        Self::Bytes,
        Self::Bools,
        Self::Integers,
        Self::Doubles,
        Self::Texts,
    ];

    fn of_number(number: i64) -> Option<Self> {
        let mut all = Self::ALL.into_iter();
        all.find(|it| i64::from(*it as u8) == number)
    }

    /// The name that tools of ROS show.
    fn name(self) -> &'static str {
        match self {
            Self::NotSet => "not set",
            Self::Bool => "bool",
            Self::Integer => "integer",
            Self::Double => "double",
            Self::Text => "string",
            Self::Bytes => "byte_array",
            Self::Bools => "bool_array",
            Self::Integers => "integer_array",
            Self::Doubles => "double_array",
            Self::Texts => "string_array",
        }
    }

    /// The field of `rcl_interfaces/msg/ParameterValue` with the content; `None` for a parameter that is not set.
    fn field(self) -> Option<&'static str> {
        Some(match self {
            Self::NotSet => return None,
            Self::Bool => "bool_value",
            Self::Integer => "integer_value",
            Self::Double => "double_value",
            Self::Text => "string_value",
            Self::Bytes => "byte_array_value",
            Self::Bools => "bool_array_value",
            Self::Integers => "integer_array_value",
            Self::Doubles => "double_array_value",
            Self::Texts => "string_array_value",
        })
    }

    /// The type of a value without fields, and whether it is written as JSON.
    fn of(schema: &Schema) -> (Self, bool) {
        let plain = match &schema.without_option().shape {
            Shape::Bool => Self::Bool,
            Shape::I8
            | Shape::I16
            | Shape::I32
            | Shape::I64
            | Shape::U8
            | Shape::U16
            | Shape::U32
            | Shape::U64 => Self::Integer,
            Shape::F32 | Shape::F64 => Self::Double,
            Shape::Text => Self::Text,
            Shape::List(element) | Shape::Array(element, _) => match Self::of(element) {
                _ if matches!(element.shape, Shape::Option(_)) => return (Self::Text, true),
                (Self::Bool, false) => Self::Bools,
                (Self::Integer, false) if element.shape == Shape::U8 => Self::Bytes,
                (Self::Integer, false) => Self::Integers,
                (Self::Double, false) => Self::Doubles,
                (Self::Text, false) => Self::Texts,
                _ => return (Self::Text, true),
            },
            Shape::Option(_) | Shape::Any | Shape::Record(_) => return (Self::Text, true),
        };
        (plain, false)
    }
}

/// A property, or a field of one, as a parameter.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Parameter {
    /// Name in ROS, such as `pid.p`.
    pub(crate) name: String,
    pub(crate) kind: ParameterType,
    /// `rcl_interfaces/msg/ParameterValue`.
    pub(crate) value: Datum,
    /// `rcl_interfaces/msg/ParameterDescriptor`.
    pub(crate) descriptor: Datum,
    property: String,
    /// Path of the field in the property; empty for the whole property.
    path: Vec<String>,
    schema: Schema,
    is_json: bool,
}

/// The parameters of a component, in the order of its properties.
pub(crate) fn parameters(component: &DeskComponent) -> Vec<Parameter> {
    let mut all = Vec::new();
    for (of, value) in &component.properties {
        add(of, &of.schema, Some(value), &mut Vec::new(), &mut all);
    }
    all
}

fn add(
    of: &PropertyDeclaration,
    schema: &Schema,
    value: Option<&Datum>,
    path: &mut Vec<String>,
    all: &mut Vec<Parameter>,
) {
    if let Shape::Record(fields) = &schema.shape
        && path.len() < DEEPEST
        && !fields.is_empty()
    {
        for field in fields {
            let part = value.and_then(|value| part(value, &field.name));
            path.push(field.name.to_string());
            add(of, &field.schema, part, path, all);
            path.pop();
        }
        return;
    }
    let (kind, is_json) = ParameterType::of(schema);
    let name = std::iter::once(&of.name).chain(&*path);
    let name: Vec<&str> = name.map(String::as_str).collect();
    let name = name.join(".");
    all.push(Parameter {
        value: value_of(value, kind, is_json),
        descriptor: descriptor(of, &name, kind, path.is_empty()),
        name,
        kind,
        property: of.name.clone(),
        path: path.clone(),
        schema: schema.clone(),
        is_json,
    });
}

fn part<'d>(value: &'d Datum, name: &str) -> Option<&'d Datum> {
    let Datum::Record(entries) = value else {
        return None;
    };
    let found = entries.iter().find(|(entry, _)| **entry == *name);
    found.map(|(_, value)| value)
}

fn part_mut<'d>(value: &'d mut Datum, name: &str) -> Option<&'d mut Datum> {
    let Datum::Record(entries) = value else {
        return None;
    };
    let found = entries.iter_mut().find(|(entry, _)| **entry == *name);
    found.map(|(_, value)| value)
}

fn number(kind: ParameterType) -> Datum {
    Datum::Int(i64::from(kind as u8))
}

/// `rcl_interfaces/msg/ParameterValue` of a parameter that does not exist.
pub(crate) fn not_set() -> Datum {
    Datum::record([("type", number(ParameterType::NotSet))])
}

fn value_of(value: Option<&Datum>, kind: ParameterType, is_json: bool) -> Datum {
    let (Some(value), Some(field)) = (value, kind.field()) else {
        return not_set();
    };
    if value.is_null() {
        return not_set();
    }
    let content = if is_json {
        Datum::text(json::encode(value).unwrap_or_default())
    } else {
        value.clone()
    };
    Datum::record([("type", number(kind)), (field, content)])
}

fn descriptor(of: &PropertyDeclaration, name: &str, kind: ParameterType, is_whole: bool) -> Datum {
    let mut constraints = Vec::new();
    if !of.unit.is_empty() {
        constraints.push(format!("unit: {}", of.unit));
    }
    if is_whole && !of.choices.is_empty() {
        let choices: Vec<_> = of.choices.iter().map(ToString::to_string).collect();
        constraints.push(format!("one of {}", choices.join(", ")));
    }
    let range = of.range.clone().filter(|_| is_whole);
    let ranges = [
        (ParameterType::Integer, "integer_range"),
        (ParameterType::Double, "floating_point_range"),
    ];
    let field = ranges.into_iter().find(|(of, _)| *of == kind);
    let range = range.zip(field).map(|((least, greatest), (_, field))| {
        // a range without a step
        let range = Datum::record([("from_value", least), ("to_value", greatest)]);
        (field, Datum::List(vec![range]))
    });
    let mut fields = vec![
        ("name", Datum::text(name)),
        ("type", number(kind)),
        ("description", Datum::text(of.doc.clone())),
        (
            "additional_constraints",
            Datum::text(constraints.join("; ")),
        ),
    ];
    fields.extend(range);
    Datum::record(fields)
}

impl Parameter {
    /// The property that a value of ROS gives, together with earlier ones of the same request.
    ///
    /// # Errors
    /// The value has another type than the parameter.
    pub(crate) fn set(
        &self,
        value: &Datum,
        component: &DeskComponent,
        values: &mut Vec<(String, Datum)>,
    ) -> Result<(), String> {
        let content = self.content(value)?;
        let at = match values.iter().position(|(of, _)| *of == self.property) {
            Some(at) => at,
            None => {
                let known = component.property(&self.property);
                let known = known.map(|(_, value)| value.clone());
                values.push((self.property.clone(), known.unwrap_or_default()));
                values.len() - 1
            }
        };
        let whole = values.get_mut(at).map(|(_, value)| value);
        let place = whole.and_then(|whole| {
            let mut path = self.path.iter();
            path.try_fold(whole, |record, step| part_mut(record, step))
        });
        let Some(place) = place else {
            return Err(format!("`{}` is not set as a whole", self.property));
        };
        *place = content;
        Ok(())
    }

    /// The property of the parameter.
    pub(crate) fn property(&self) -> &str {
        &self.property
    }

    fn content(&self, value: &Datum) -> Result<Datum, String> {
        let number = value.get("type").and_then(|it| it.as_int());
        let kind = number.and_then(ParameterType::of_number);
        let kind = kind.ok_or_else(|| "the type of the value is not one of ROS".to_owned())?;
        let is_optional = matches!(self.schema.shape, Shape::Option(_));
        match (kind, self.kind) {
            (ParameterType::NotSet, _) if is_optional => return Ok(Datum::Null),
            // as the reader of properties does
            (ParameterType::Integer, ParameterType::Double) => {}
            (kind, expected) if kind == expected => {}
            (kind, expected) => {
                let (kind, expected) = (kind.name(), expected.name());
                return Err(format!(
                    "`{}` has the type {expected}, and the value {kind}",
                    self.name
                ));
            }
        }
        let content = kind.field().and_then(|field| value.get(field));
        let content = content
            .map(std::borrow::Cow::into_owned)
            .unwrap_or_default();
        if !self.is_json {
            return Ok(content);
        }
        let text = content.as_text().unwrap_or_default().as_bytes();
        let read = Codec::Json.decode(text, &self.schema);
        read.map_err(|error| format!("`{}` is no JSON of `{}`: {error}", self.name, self.schema))
    }
}

/// The names and prefixes that `list_parameters` returns, as rclcpp has them. A depth of 0 is without limit.
pub(crate) fn list(
    parameters: &[Parameter],
    prefixes: &[&str],
    depth: i64,
) -> (Vec<String>, Vec<String>) {
    let levels = |rest: &str| i64::try_from(rest.matches('.').count()).unwrap_or(i64::MAX);
    let is_within = |rest: &str| depth == 0 || levels(rest) < depth;
    let (mut names, mut found_prefixes) = (Vec::new(), Vec::new());
    for Parameter { name, .. } in parameters {
        let is_listed = match prefixes {
            [] => is_within(name),
            some => some.iter().any(|prefix| {
                let rest = name.strip_prefix(prefix);
                let inner = rest.and_then(|rest| rest.strip_prefix('.'));
                name == prefix || inner.is_some_and(is_within)
            }),
        };
        if !is_listed {
            continue;
        }
        if let Some((prefix, _)) = name.rsplit_once('.')
            && !found_prefixes.iter().any(|it| it == prefix)
        {
            found_prefixes.push(prefix.to_owned());
        }
        names.push(name.clone());
    }
    (names, found_prefixes)
}

#[cfg(test)]
mod tests {
    use asmotion_component::State;
    use asmotion_datum::OutlineKey;

    use super::*;

    fn declaration(name: &str, schema: Schema) -> PropertyDeclaration {
        PropertyDeclaration {
            name: name.to_owned(),
            doc: "doc".to_owned(),
            schema,
            unit: "m/s".to_owned(),
            default: Datum::Null,
            range: Some((Datum::Float(0.0), Datum::Float(2.0))),
            choices: Vec::new(),
            conversion: Default::default(),
        }
    }

    fn component() -> DeskComponent {
        let float = || Schema::plain(Shape::F64);
        let pid = Schema::record(
            "test/Pid",
            vec![
                OutlineKey::new("p", "", float()),
                OutlineKey::new("i", "", float()),
            ],
        );
        let gains = Datum::record([("p", Datum::Float(1.0)), ("i", Datum::Float(0.5))]);
        let optional = Schema::plain(Shape::Option(Box::new(Schema::plain(Shape::Text))));
        let points = Schema::many(pid.clone(), None);
        DeskComponent {
            state: State::Running,
            properties: vec![
                (declaration("speed", float()), Datum::Float(0.5)),
                (declaration("pid", pid), gains.clone()),
                (declaration("frame", optional), Datum::Null),
                (declaration("points", points), Datum::List(vec![gains])),
            ],
        }
    }

    fn named(name: &str) -> Parameter {
        let all = parameters(&component());
        all.into_iter().find(|it| it.name == name).unwrap()
    }

    fn value(kind: u8, field: &'static str, content: Datum) -> Datum {
        Datum::record([("type", Datum::Int(kind.into())), (field, content)])
    }

    #[test]
    fn records_are_parameters_for_each_field_and_other_values_are_json() {
        let all = parameters(&component());
        let names: Vec<_> = all.iter().map(|it| (&*it.name, it.kind)).collect();
        let expected = [
            ("speed", ParameterType::Double),
            ("pid.p", ParameterType::Double),
            ("pid.i", ParameterType::Double),
            ("frame", ParameterType::Text),
            ("points", ParameterType::Text),
        ];
        assert_eq!(names, expected);
        assert_eq!(named("frame").value, not_set());
        let json = r#"[{"p":1.0,"i":0.5}]"#;
        assert_eq!(
            named("points").value,
            value(4, "string_value", Datum::text(json))
        );
    }

    #[test]
    fn fields_of_one_request_are_set_together() {
        let (component, mut values) = (component(), Vec::new());
        named("pid.i")
            .set(
                &value(3, "double_value", Datum::Float(7.0)),
                &component,
                &mut values,
            )
            .unwrap();
        named("pid.p")
            .set(
                &value(2, "integer_value", Datum::Int(3)),
                &component,
                &mut values,
            )
            .unwrap();
        let gains = Datum::record([("p", Datum::Int(3)), ("i", Datum::Float(7.0))]);
        assert_eq!(values, [("pid".to_owned(), gains)]);
        let points = Datum::text(r#"[{"p": 2, "i": 4}]"#);
        named("points")
            .set(&value(4, "string_value", points), &component, &mut values)
            .unwrap();
        assert_eq!(values.len(), 2);
    }

    #[test]
    fn values_of_another_type_are_refused() {
        let (component, mut values) = (component(), Vec::new());
        let wrong = [
            ("speed", value(4, "string_value", Datum::text("fast"))),
            ("speed", not_set()),
            ("speed", Datum::record([("type", Datum::Int(77))])),
            ("points", value(4, "string_value", Datum::text("[{"))),
        ];
        for (name, value) in wrong {
            assert!(
                named(name).set(&value, &component, &mut values).is_err(),
                "{name} {value}"
            );
        }
        assert!(values.is_empty());
        named("frame")
            .set(&not_set(), &component, &mut values)
            .unwrap();
        assert_eq!(values, [("frame".to_owned(), Datum::Null)]);
    }

    #[test]
    fn lists_have_prefixes_and_a_depth() {
        let all = parameters(&component());
        let names = |prefixes: &[&str], depth| list(&all, prefixes, depth).0.join(" ");
        assert_eq!(names(&[], 0), "speed pid.p pid.i frame points");
        assert_eq!(names(&[], 1), "speed frame points");
        assert_eq!(names(&["pid"], 1), "pid.p pid.i");
        assert_eq!(names(&["pi", "frame"], 0), "frame");
        assert_eq!(list(&all, &[], 0).1, ["pid"]);
    }
}

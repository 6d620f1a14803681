//! Types of topics and services: what both ends compare, and the schemas of the data.

use std::sync::Arc;

use asmotion_datum::Schema;
use asmotion_ros_interface::{
    Catalogue, DefinitionError, DefinitionProblem, Distribution, InterfaceName,
};

/// Stands for every type and sum.
pub(crate) const ANY: &str = "*";

/// The type of a topic.
#[derive(Debug, Clone, PartialEq)]
pub struct TopicType {
    /// Name, such as `geometry_msgs/Twist`.
    pub name: Arc<str>,
    /// MD5 sum, in hexadecimal digits.
    pub md5: Arc<str>,
    /// Definition, with those of all messages in it.
    pub definition: Arc<str>,
    /// Schema of the messages.
    pub schema: Arc<Schema>,
}

/// The type of a service.
#[derive(Debug, Clone, PartialEq)]
pub struct ServiceType {
    /// Name, such as `std_srvs/SetBool`.
    pub name: Arc<str>,
    /// MD5 sum, in hexadecimal digits.
    pub md5: Arc<str>,
    /// Definition of request and response.
    pub definition: Arc<str>,
    /// Schema of the requests.
    pub request: Arc<Schema>,
    /// Schema of the responses.
    pub response: Arc<Schema>,
}

impl TopicType {
    /// The type of a message.
    ///
    /// # Errors
    /// A definition is missing, or a message contains itself.
    pub fn of(catalogue: &Catalogue, name: &InterfaceName) -> Result<Self, DefinitionError> {
        Ok(Self {
            name: name.short().into(),
            md5: catalogue.md5(name)?.to_string().into(),
            definition: catalogue.full_text(name)?.into(),
            schema: Arc::new(catalogue.schema(name)?),
        })
    }

    /// The type with a definition as a publisher sends it: that of the message, and those of the messages in it, separated by
    /// lines of `=` and named by `MSG: NAME`.
    ///
    /// # Errors
    /// The text is not a definition, or does not have the MD5 sum.
    pub fn of_definition(name: &str, md5: &str, definition: &str) -> Result<Self, String> {
        let parsed: InterfaceName = name.parse().map_err(|error| format!("{error}"))?;
        let mut catalogue = Catalogue::empty(Distribution::Ros1);
        let mut parts = Vec::new();
        let (mut part, mut current) = (parsed.clone(), String::new());
        let mut lines = definition.lines();
        while let Some(line) = lines.next() {
            if line.len() < 20 || line.bytes().any(|byte| byte != b'=') {
                current.push_str(line);
                current.push('\n');
                continue;
            }
            let named = lines.next().and_then(|line| line.strip_prefix("MSG: "));
            let named = named.ok_or("a part of the definition has no name")?;
            let next = named.trim().parse().map_err(|error| format!("{error}"))?;
            parts.push((
                std::mem::replace(&mut part, next),
                std::mem::take(&mut current),
            ));
        }
        parts.push((part, current));
        for (part, text) in parts {
            let defined = catalogue.define(part, &text);
            defined.map_err(|error| error.to_string())?;
        }
        let found = Self::of(&catalogue, &parsed).map_err(|error| error.to_string())?;
        if *found.md5 != *md5 {
            let computed = &found.md5;
            return Err(format!(
                "the definition of `{name}` has the MD5 sum {computed}, and the publisher says {md5}"
            ));
        }
        Ok(found)
    }
}

impl ServiceType {
    /// The type of a service.
    ///
    /// # Errors
    /// A definition is missing, or a message contains itself.
    pub fn of(catalogue: &Catalogue, name: &InterfaceName) -> Result<Self, DefinitionError> {
        let undefined = || DefinitionError {
            interface: name.clone(),
            line: None,
            problem: DefinitionProblem::Undefined,
        };
        let mut schemas = catalogue.schemas(name)?.into_iter();
        let (Some(request), Some(response), None) =
            (schemas.next(), schemas.next(), schemas.next())
        else {
            return Err(undefined());
        };
        Ok(Self {
            name: name.short().into(),
            md5: catalogue.md5(name)?.to_string().into(),
            definition: catalogue.interface(name)?.to_string().into(),
            request: Arc::new(request),
            response: Arc::new(response),
        })
    }
}

//! Message types of ROS for composites.

use std::sync::{Arc, LazyLock};

use asmotion_component::declaration::OperationDeclaration;
use asmotion_composite::model::BridgeKind;
use asmotion_composite::{RosMessage, RosMessages, RosOperation, RosOperations};
use asmotion_datum::Schema;
use asmotion_ros_gateway::OperationType;
use asmotion_ros_interface::{Catalogue, Distribution, InterfaceKind};

/// The definitions of ROS 1, read once.
static NOETIC: LazyLock<Arc<Catalogue>> =
    LazyLock::new(|| Arc::new(Catalogue::included(Distribution::Ros1)));

/// The definitions of ROS 2, read once.
static JAZZY: LazyLock<Arc<Catalogue>> =
    LazyLock::new(|| Arc::new(Catalogue::included(Distribution::Ros2)));

/// The definitions of ROS 1.
pub(crate) fn noetic() -> Arc<Catalogue> {
    Arc::clone(&NOETIC)
}

/// The definitions of ROS 2.
#[cfg(feature = "ros2")]
pub(crate) fn jazzy() -> Arc<Catalogue> {
    Arc::clone(&JAZZY)
}

/// The message types for bridges of a kind; `None` if this build does not connect them.
pub(super) fn of(kind: BridgeKind) -> Option<&'static dyn RosMessages> {
    match kind {
        BridgeKind::Ros1 => Some(&ROS_1),
        BridgeKind::Ros2 if cfg!(feature = "ros2") => Some(&ROS_2),
        BridgeKind::Ros2 | BridgeKind::Rosbridge => None,
    }
}

/// The message types of a generation of ROS.
struct Definitions(&'static LazyLock<Arc<Catalogue>>);

static ROS_1: Definitions = Definitions(&NOETIC);
static ROS_2: Definitions = Definitions(&JAZZY);

impl RosMessages for Definitions {
    fn names(&self) -> Vec<String> {
        let all = self.0.interfaces();
        let messages = all.filter(|(name, _)| name.kind() == InterfaceKind::Message);
        messages.map(|(name, _)| name.short()).collect()
    }

    fn find(&self, name: &str) -> Option<RosMessage> {
        let name = name.parse().ok()?;
        Some(RosMessage {
            schema: self.0.common_schema(&name).ok()?,
            definition: self.0.interface(&name).ok()?.to_string(),
        })
    }

    fn operations(&self) -> Option<&dyn RosOperations> {
        Some(self)
    }
}

impl RosOperations for Definitions {
    fn names(&self) -> Vec<String> {
        OperationType::names(self.0)
    }

    fn find(&self, name: &str) -> Option<RosOperation> {
        let found = OperationType::find(self.0, name)?;
        let schemas = found.common_schemas(self.0).ok()?;
        Some(RosOperation {
            request: schemas.request,
            response: schemas.response,
            feedback: schemas.feedback,
            definition: found.definition(self.0).ok()?,
        })
    }
}

/// The operations of an interface that is a service or an action of ROS: as in ROS 2, or else as in ROS 1.
pub(super) fn operations(interface: &str) -> Option<Vec<OperationDeclaration>> {
    let in_both = [&JAZZY, &NOETIC].into_iter();
    in_both
        .filter_map(|catalogue| {
            let found = OperationType::find(catalogue, interface)?;
            found.operations(catalogue).ok()
        })
        .next()
}

/// The schema of a message type that only ROS defines, for topics of composites: as in ROS 2, or else as in ROS 1.
pub(super) fn schema(name: &str) -> Option<Schema> {
    let name = name.parse().ok()?;
    let in_both = [&JAZZY, &NOETIC].into_iter();
    in_both
        .filter_map(|catalogue| catalogue.common_schema(&name).ok())
        .next()
}

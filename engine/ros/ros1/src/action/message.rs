//! The messages of an action.

use std::borrow::Cow;
use std::fmt;
use std::sync::Arc;

use asmotion_datum::Datum;
use asmotion_ros_interface::{Catalogue, DefinitionError, InterfaceKind, InterfaceName, NameError};

use crate::interface::TopicType;
use crate::time::time;

/// The types of the topics of an action.
#[derive(Debug, Clone, PartialEq)]
pub struct ActionType {
    /// Name, such as `move_base_msgs/MoveBase`.
    pub name: Arc<str>,
    /// `NAMEActionGoal`, with the goal in its field `goal`.
    pub goal: TopicType,
    /// `NAMEActionFeedback`, with the feedback in its field `feedback`.
    pub feedback: TopicType,
    /// `NAMEActionResult`, with the result in its field `result`.
    pub result: TopicType,
    /// `actionlib_msgs/GoalID`.
    pub cancel: TopicType,
    /// `actionlib_msgs/GoalStatusArray`.
    pub status: TopicType,
}

/// An action has no type.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ActionTypeError {
    /// A definition is missing.
    #[error(transparent)]
    Definition(#[from] DefinitionError),
    /// A name is wrong.
    #[error(transparent)]
    Name(#[from] NameError),
}

impl ActionType {
    /// The types of an action such as `move_base_msgs/MoveBase`. The catalogue has the messages that ROS makes of an `.action`
    /// file: `MoveBaseActionGoal` and so on.
    ///
    /// # Errors
    /// A definition is missing, or the text is not a name.
    pub fn of(catalogue: &Catalogue, name: &str) -> Result<Self, ActionTypeError> {
        let name: InterfaceName = name.parse()?;
        let own = |suffix: &str| {
            let whole = format!("{}{suffix}", name.name());
            let message = InterfaceName::new(name.package(), InterfaceKind::Message, &whole)?;
            Ok::<_, ActionTypeError>(TopicType::of(catalogue, &message)?)
        };
        let common = |whole: &str| {
            let message = InterfaceName::new("actionlib_msgs", InterfaceKind::Message, whole)?;
            Ok::<_, ActionTypeError>(TopicType::of(catalogue, &message)?)
        };
        Ok(Self {
            name: name.short().into(),
            goal: own("ActionGoal")?,
            feedback: own("ActionFeedback")?,
            result: own("ActionResult")?,
            cancel: common("GoalID")?,
            status: common("GoalStatusArray")?,
        })
    }
}

/// Identity of a goal, unique among all clients of a server.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct GoalId(pub(super) Arc<str>);

impl fmt::Display for GoalId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// `actionlib_msgs/GoalID`.
pub(super) fn goal_id(id: &GoalId, stamp: i64) -> Datum {
    Datum::record([("stamp", time(stamp)), ("id", Datum::text(&*id.0))])
}

/// `std_msgs/Header` without a frame.
fn header(stamp: i64) -> Datum {
    Datum::record([
        ("seq", Datum::Int(0)),
        ("stamp", time(stamp)),
        ("frame_id", Datum::text("")),
    ])
}

/// `actionlib_msgs/GoalStatus`.
pub(super) fn goal_status(id: &GoalId, stamp: i64, status: i64, text: &str) -> Datum {
    Datum::record([
        ("goal_id", goal_id(id, stamp)),
        ("status", Datum::Int(status)),
        ("text", Datum::text(text)),
    ])
}

/// `actionlib_msgs/GoalStatusArray`.
pub(super) fn status_array(statuses: Vec<Datum>, now: i64) -> Datum {
    Datum::record([
        ("header", header(now)),
        ("status_list", Datum::List(statuses)),
    ])
}

/// `NAMEActionFeedback` or `NAMEActionResult`: a status and one more field.
pub(super) fn told(status: Datum, field: &'static str, content: Datum, now: i64) -> Datum {
    Datum::record([
        ("header", header(now)),
        ("status", status),
        (field, content),
    ])
}

/// `NAMEActionGoal`.
pub(super) fn action_goal(id: &GoalId, goal: &Datum, stamp: i64) -> Datum {
    Datum::record([
        ("header", header(stamp)),
        ("goal_id", goal_id(id, stamp)),
        ("goal", goal.clone()),
    ])
}

/// A status of a goal, as servers tell it.
pub(super) struct StatedStatus {
    pub(super) id: GoalId,
    pub(super) status: i64,
    pub(super) text: String,
}

/// The status in a datum of `actionlib_msgs/GoalStatus`.
pub(super) fn status(of: &Datum) -> Option<StatedStatus> {
    let text = |path| of.get(path)?.as_text().map(str::to_owned);
    Some(StatedStatus {
        id: GoalId(text("goal_id.id")?.into()),
        status: of.get("status")?.as_int()?,
        text: text("text")?,
    })
}

/// The statuses in `actionlib_msgs/GoalStatusArray`.
pub(super) fn statuses(of: &Datum) -> Option<Vec<StatedStatus>> {
    let list = of.get("status_list")?;
    let count = list.count()?;
    let elements = (0..count).filter_map(|index| list.element(index).map(Cow::into_owned));
    Some(elements.filter_map(|it| status(&it)).collect())
}

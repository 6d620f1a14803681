//! Reasons that a transform is refused, or is not found.

use std::time::Duration;

/// The reason that a message has no transform into a frame.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TransformFailure {
    /// The message does not say what its frame is.
    #[error("its `header.frame_id` is empty")]
    NoFrame,
    /// No transform has the frame.
    #[error("no transform has the frame `{frame}`")]
    UnknownFrame {
        /// Name of the frame.
        frame: String,
    },
    /// Both frames are known, and belong to different trees.
    #[error("no transforms connect the frames `{from}` and `{to}`")]
    Disconnected {
        /// Frame of the message.
        from: String,
        /// Frame into which it was to be transformed.
        to: String,
    },
    /// The message is older than the transforms.
    #[error("it is older than all transforms from `{child}` to `{parent}`")]
    Past {
        /// Frame whose transforms are younger.
        child: String,
        /// Parent frame of `child`.
        parent: String,
        /// Time between the message and the oldest transform.
        by: Duration,
    },
    /// The message is younger than the transforms.
    #[error("it is younger than all transforms from `{child}` to `{parent}`")]
    Future {
        /// Frame whose transforms are older.
        child: String,
        /// Parent frame of `child`.
        parent: String,
        /// Time between the last transform and the message.
        by: Duration,
    },
    /// A frame that is above itself.
    #[error("the frame `{frame}` is above itself in the tree of transforms")]
    Circle {
        /// A frame of the circle.
        frame: String,
    },
    /// A cloud without points that could be transformed.
    #[error("its points are not fields `x`, `y` and `z` of floating-point numbers within its data")]
    Cloud,
}

impl TransformFailure {
    /// Returns whether transforms that arrive later can end the failure. A message that is too old stays so.
    pub fn may_pass(&self) -> bool {
        match self {
            Self::UnknownFrame { .. }
            | Self::Disconnected { .. }
            | Self::Future { .. }
            | Self::Circle { .. } => true,
            Self::NoFrame | Self::Past { .. } | Self::Cloud => false,
        }
    }

    /// The time between message and transforms, where that is the failure.
    pub fn distance(&self) -> Option<Duration> {
        if let Self::Past { by, .. } | Self::Future { by, .. } = self {
            Some(*by)
        } else {
            None
        }
    }
}

/// The reason that a transform is not kept.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InvalidTransform {
    /// A frame without a name.
    #[error("a transform has no frame")]
    NoFrame,
    /// A frame that would be its own parent.
    #[error("the transform of `{frame}` has itself as the parent")]
    OwnParent {
        /// Name of the frame.
        frame: String,
    },
    /// Numbers that are no motion.
    #[error(
        "the transform from `{child}` to `{parent}` is not finite, or its quaternion has not the length 1"
    )]
    NoMotion {
        /// Name of the frame.
        child: String,
        /// Parent frame of `child`.
        parent: String,
    },
    /// Too many frames.
    #[error("the transform of `{frame}` was one too many: there are {most} frames already")]
    TooMany {
        /// Name of the frame.
        frame: String,
        /// Most frames.
        most: usize,
    },
    /// The message is not one of `tf2_msgs/TFMessage`.
    #[error("it has no list of transforms")]
    NoMessage,
}

/// The reason that no message of a mapping could be transformed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotTransformable {
    /// Messages without data in a frame, or with a meaning that a transform would change.
    #[error("messages of `{kind}` cannot be transformed into another frame")]
    Type {
        /// Type in ROS.
        kind: String,
    },
    /// A text that is no name of a frame.
    #[error("`{frame}` is not the name of a frame")]
    Frame {
        /// The text.
        frame: String,
    },
}

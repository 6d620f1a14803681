//! `youbot`: an arm of several joints, in order from the first one, and the services around it (the interfaces of the
//! JOrocos paper).

use asmotion_component::Operation;

use crate::builtin_interfaces::Time;
use crate::geometry_msgs::Pose;
use crate::std_msgs::{Bool, Empty, Text};
use asmotion_datum::DatumError;

use crate::plausible::{LARGEST_DURATION, LARGEST_MEASUREMENT, all_bounded, positive};

asmotion_datum::message! {
    /// Measurements of the driver (`youbot/JointStatus`).
    pub struct JointStatus = "youbot/JointStatus", check = check_status {
        /// Time of the measurement.
        pub stamp: Time,
        /// Angle of each joint, rad.
        pub position: Vec<f64>,
        /// Angular velocity of each joint, rad/s.
        pub velocity: Vec<f64>,
        /// Motor current of each joint, A.
        pub current: Vec<f64>,
        /// Motor temperature of each joint, °C.
        pub temperature: Vec<f64>,
        /// Error flags of each joint, ten bits.
        pub error_flags: Vec<u16>,
    }

    /// A command to the driver (`youbot/JointCommand`).
    pub struct JointCommand = "youbot/JointCommand", check = check_command {
        /// Time of the command.
        pub stamp: Time,
        /// Commanded angle of each joint, rad.
        pub position: Vec<f64>,
    }

    /// A posture of the arm (`youbot/JointPositions`).
    pub struct JointPositions = "youbot/JointPositions", check = check_positions {
        /// Angle of each joint, rad.
        pub position: Vec<f64>,
    }

    /// A goal for the hand (`youbot/Goal`).
    pub struct Goal = "youbot/Goal", check = check_goal {
        /// Pose of the hand in the frame of the arm's base; z points out of the hand.
        pub pose: Pose,
        /// Posture to which the solution should be nearest, rad; upright if empty.
        pub near: Vec<f64>,
    }

    /// An event of the arm (`youbot/Notice`).
    pub struct Notice = "youbot/Notice" {
        /// Kind of event: `busy`, `idle`, `refresh`, `fault` or `stale`.
        pub event: String,
        /// Explanation for a human reader.
        pub detail: String,
    }

    /// The period of a component (`youbot/Period`).
    #[derive(Copy)]
    pub struct Period = "youbot/Period", check = check_period {
        /// Time between two cycles, s.
        pub period: f64,
    }
}

macro_rules! operations {
    ($($(#[doc = $doc:literal])* $name:ident = $interface:literal . $operation:literal ($request:ty) -> $response:ty;)*) => {
        $(
            $(#[doc = $doc])*
            #[derive(Debug, Clone, Copy)]
            pub struct $name;

            impl Operation for $name {
                type Request = $request;
                type Response = $response;
                const INTERFACE: &'static str = $interface;
                const NAME: &'static str = $operation;
            }
        )*
    };
}

operations! {
    /// Moves the joints to these angles.
    SetJointsPositions = "youbot/SendingCommands"."setJointsPositions"(JointPositions) -> Empty;
    /// Returns the angles of the joints.
    GetJointsPositions = "youbot/RetrievingStatus"."getJointsPositions"(Empty) -> JointPositions;
    /// Sets the period of the driver.
    SetPeriod = "youbot/SettingPeriod"."setPeriod"(Period) -> Empty;
    /// Reports an event of the arm: a callback.
    Notify = "youbot/Notifying"."notify"(Notice) -> Empty;
    /// Returns a posture in which the hand reaches the goal.
    Solve = "youbot/Kinematics"."solve"(Goal) -> JointPositions;
    /// Moves the hand to a pose.
    MoveTo = "youbot/Locomotion"."moveTo"(Pose) -> Empty;
    /// The driver's own operation: sets the period and returns whether it is accepted.
    DriverSetPeriod = "youbot/Driver"."setPeriod"(Period) -> Bool;
    /// The driver's own operation: returns its state.
    DriverState = "youbot/Driver"."state"(Empty) -> Text;
}

fn check_status(status: &JointStatus) -> Result<(), DatumError> {
    all_bounded("position", &status.position, LARGEST_MEASUREMENT)?;
    all_bounded("velocity", &status.velocity, LARGEST_MEASUREMENT)?;
    all_bounded("current", &status.current, LARGEST_MEASUREMENT)?;
    all_bounded("temperature", &status.temperature, LARGEST_MEASUREMENT)
}

fn check_command(command: &JointCommand) -> Result<(), DatumError> {
    all_bounded("position", &command.position, LARGEST_MEASUREMENT)
}

fn check_positions(positions: &JointPositions) -> Result<(), DatumError> {
    all_bounded("position", &positions.position, LARGEST_MEASUREMENT)
}

fn check_goal(goal: &Goal) -> Result<(), DatumError> {
    all_bounded("near", &goal.near, LARGEST_MEASUREMENT)
}

fn check_period(period: &Period) -> Result<(), DatumError> {
    positive("period", period.period, LARGEST_DURATION)
}

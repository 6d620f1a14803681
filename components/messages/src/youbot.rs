//! `youbot`: an arm of some joints, first joint first; and the services around it (the interfaces of the JOrocos paper).

use asmotion_component::Operation;

use crate::builtin_interfaces::Time;
use crate::geometry_msgs::Pose;
use crate::std_msgs::{Bool, Empty, Text};

asmotion_datum::message! {
    /// What the driver measures (`youbot/JointStatus`).
    pub struct JointStatus = "youbot/JointStatus" {
        /// When.
        pub stamp: Time,
        /// How far each joint is turned, rad.
        pub position: Vec<f64>,
        /// How fast it turns, rad/s.
        pub velocity: Vec<f64>,
        /// What its motor draws, A.
        pub current: Vec<f64>,
        /// How warm its motor is, °C.
        pub temperature: Vec<f64>,
        /// Ten error bits of each joint.
        pub error_flags: Vec<u16>,
    }

    /// What the driver is told (`youbot/JointCommand`).
    pub struct JointCommand = "youbot/JointCommand" {
        /// When.
        pub stamp: Time,
        /// How far each joint shall turn, rad.
        pub position: Vec<f64>,
    }

    /// A posture of the arm (`youbot/JointPositions`).
    pub struct JointPositions = "youbot/JointPositions" {
        /// How far each joint is turned, rad.
        pub position: Vec<f64>,
    }

    /// Where the hand shall be (`youbot/Goal`).
    pub struct Goal = "youbot/Goal" {
        /// The hand in the frame of the arm's foot: z points out of the hand.
        pub pose: Pose,
        /// Of several postures the one nearest to this one; upright where empty, rad.
        pub near: Vec<f64>,
    }

    /// What happens to the arm (`youbot/Notice`).
    pub struct Notice = "youbot/Notice" {
        /// `busy`, `idle`, `refresh`, `fault` or `stale`.
        pub event: String,
        /// For people.
        pub detail: String,
    }

    /// How often something happens (`youbot/Period`).
    #[derive(Copy)]
    pub struct Period = "youbot/Period" {
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
    /// The joints shall go there.
    SetJointsPositions = "youbot/SendingCommands"."setJointsPositions"(JointPositions) -> Empty;
    /// Where the joints are.
    GetJointsPositions = "youbot/RetrievingStatus"."getJointsPositions"(Empty) -> JointPositions;
    /// The driver shall cycle so often.
    SetPeriod = "youbot/SettingPeriod"."setPeriod"(Period) -> Empty;
    /// Something has happened to the arm: a callback.
    Notify = "youbot/Notifying"."notify"(Notice) -> Empty;
    /// The posture in which the hand is there.
    Solve = "youbot/Kinematics"."solve"(Goal) -> JointPositions;
    /// The hand shall go there.
    MoveTo = "youbot/Locomotion"."moveTo"(Pose) -> Empty;
    /// The driver's own: whether it takes the period.
    DriverSetPeriod = "youbot/Driver"."setPeriod"(Period) -> Bool;
    /// The driver's own: what it does.
    DriverState = "youbot/Driver"."state"(Empty) -> Text;
}

//! The KUKA youBot's arm: a driver that has no arm ([`DummyDriver`]), the inverse kinematics ([`Arm`],
//! served by [`Kinematics`]), and a client that sends goals ([`YoubotOperator`]).

mod arm;
mod driver;
mod inverse;
mod joints;
mod kinematics;
mod operator;
mod unreachable;

pub use arm::{Arm, ArmJoints};
pub use driver::DummyDriver;
pub use kinematics::Kinematics;
pub use operator::YoubotOperator;
pub use unreachable::Unreachable;

//! The KUKA youBot's arm: a simulated driver ([`DummyDriver`]), inverse kinematics ([`Arm`], provided by
//! [`Kinematics`]), and a client that sends goals ([`YoubotOperator`]).

mod arm;
mod driver;
mod inverse;
mod joints;
mod kinematics;
mod limits;
mod operator;
mod period;
mod unreachable;

pub use arm::{Arm, ArmJoints};
pub use driver::DummyDriver;
pub use kinematics::Kinematics;
pub use operator::YoubotOperator;
pub use unreachable::Unreachable;

//! The KUKA youBot's arm: a driver that has no arm ([`DummyDriver`]), and the way from a pose of the hand to the
//! positions of the joints ([`Arm`], served by [`Kinematics`]); and somebody who wants the hand elsewhere ([`Operator`]).

mod arm;
mod driver;
mod inverse;
mod joints;
mod kinematics;
mod operator;
mod unreachable;

pub use arm::{Arm, Joints};
pub use driver::DummyDriver;
pub use kinematics::Kinematics;
pub use operator::Operator;
pub use unreachable::Unreachable;

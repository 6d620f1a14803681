//! The KUKA youBot's arm: a driver that has no arm ([`DummyDriver`]), and the way from a pose of the hand to the
//! positions of the joints ([`Arm`], served by [`Kinematics`]).

mod arm;
mod driver;
mod joints;
mod kinematics;

pub use arm::{Arm, Joints, Unreachable};
pub use driver::DummyDriver;
pub use kinematics::Kinematics;

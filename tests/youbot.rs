//! The case study of the JOrocos paper: the youBot's driver, its proxy without code, and the locomotor. Tests are named
//! after the rows of the inventory.

mod another_robot;
mod bench;
mod discovery;
mod facade;
mod lengths;
mod locomotor;
mod processes;
mod proxy;
mod record;
mod robot_crossings;

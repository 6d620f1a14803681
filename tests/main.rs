//! Tests of the whole program: the language, missions, the command line, and the architecture. One module per subject.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr,
    reason = "a test fails by panicking, and says why it is skipped"
)]

mod access;
mod ages;
mod app;
mod assembly;
mod ball_tracker;
mod cli;
mod commands;
mod composites;
mod control;
mod dashboards;
mod describe;
mod documents;
mod extending;
mod faults;
mod fleet;
mod gateway;
mod health;
mod hostile;
mod house;
mod identity;
mod inspection;
mod keys;
mod language;
mod losses;
mod message_types;
mod mission_files;
mod missions;
mod nav2;
mod new;
mod omitted_fields;
mod person;
mod pictures;
mod processes;
mod programs;
mod programs_cpp;
mod quiet;
mod reconfigure;
mod recording;
mod repl;
mod replay;
mod returns;
mod robots;
mod ros;
mod ros1;
mod ros2;
mod ros2_bridge;
mod ros_bridge;
mod ros_calls;
mod ros_case;
mod ros_folders;
mod ros_frames;
mod ros_kills;
mod ros_lent;
mod ros_parameters;
mod ros_versions;
mod routes;
mod rovers;
mod safe;
mod scenario;
mod shell;
mod standstills;
mod stops;
mod stranger;
mod supply;
mod terminal;
mod tour;
mod up;
mod watch;
mod ways;
mod youbot;
mod youbot_python;

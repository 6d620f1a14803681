//! The files in `specs` are right, and their scenarios and missions pass.

use asmotion::Exit;

#[test]
fn specifications_and_composites_have_no_errors() {
    assert_eq!(gripper::app().run(["gripper", "check", "specs"]), Exit::Ok);
}

#[test]
fn scenarios_and_missions_pass() {
    assert_eq!(gripper::app().run(["gripper", "test", "specs"]), Exit::Ok);
}

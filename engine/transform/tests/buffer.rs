//! Look-ups in a buffer.

use std::time::Duration;

use asmotion_datum::Datum;
use asmotion_transform::{
    InvalidTransform, RigidMotion, StampedMotion, TransformBuffer, TransformFailure,
    UnitQuaternion, Vector3,
};

const SECOND: i64 = 1_000_000_000;

fn shift(x: f64) -> RigidMotion {
    RigidMotion::translation(x, 0.0, 0.0)
}

/// `child` in `parent` at a time in milliseconds.
fn moving(buffer: &mut TransformBuffer, (parent, child): (&str, &str), at_ms: i64, x: f64) {
    let new = StampedMotion::new(parent, child, at_ms * 1_000_000, shift(x));
    buffer.insert(new, false).unwrap();
}

fn fixed(buffer: &mut TransformBuffer, (parent, child): (&str, &str), x: f64) {
    let new = StampedMotion::new(parent, child, 0, shift(x));
    buffer.insert(new, true).unwrap();
}

/// map → odom → base → laser, with a moving robot.
fn robot() -> TransformBuffer {
    let mut buffer = TransformBuffer::default();
    fixed(&mut buffer, ("base", "laser"), 0.25);
    for step in 0..=20 {
        moving(&mut buffer, ("odom", "base"), 1000 + step * 50, step as f64);
    }
    for step in 0..=10 {
        moving(&mut buffer, ("map", "odom"), 1000 + step * 100, 100.0);
    }
    buffer
}

fn x(buffer: &TransformBuffer, target: &str, source: &str, at_ms: i64) -> f64 {
    let found = buffer.look_up(target, source, at_ms * 1_000_000).unwrap();
    found.motion.offset.x
}

#[test]
fn it_interpolates_along_the_chain() {
    let buffer = robot();
    assert_eq!(x(&buffer, "map", "laser", 1000), 100.25);
    assert_eq!(x(&buffer, "map", "laser", 1075), 101.75);
    assert_eq!(x(&buffer, "laser", "map", 1075), -101.75);
    assert_eq!(x(&buffer, "odom", "laser", 2000), 20.25);
    assert_eq!(x(&buffer, "/odom", "/laser", 2000), 20.25);
    // the transform from map to odom is not needed
    let mut buffer = buffer;
    moving(&mut buffer, ("odom", "base"), 2050, 21.0);
    assert_eq!(x(&buffer, "odom", "laser", 2050), 21.25);
    assert_eq!(x(&buffer, "laser", "laser", 9999), 0.0);
    assert_eq!(buffer.frames(), 3);
}

#[test]
fn rotations_take_the_shorter_way() {
    let (mut buffer, cosine) = (TransformBuffer::default(), 0.75_f64.sqrt());
    let turned = |z: f64, w: f64| RigidMotion {
        rotation: UnitQuaternion::normalized([0.0, 0.0, z, w]).unwrap(),
        offset: Vector3::default(),
    };
    // -60° to 60° by quaternions of different signs
    for (stamp, motion) in [
        (SECOND, turned(-0.5, cosine)),
        (2 * SECOND, turned(-0.5, -cosine)),
    ] {
        buffer
            .insert(StampedMotion::new("a", "b", stamp, motion), false)
            .unwrap();
    }
    let found = buffer.look_up("a", "b", 3 * SECOND / 2).unwrap().motion;
    let tip = found.apply(Vector3::new(1.0, 0.0, 0.0));
    assert!(
        (tip.x - 1.0).abs() < 1e-12 && tip.y.abs() < 1e-12,
        "{tip:?}"
    );
}

#[test]
fn at_time_0_it_takes_the_latest_common_time() {
    let mut buffer = robot();
    moving(&mut buffer, ("odom", "base"), 2050, 21.0);
    let found = buffer.look_up("map", "laser", 0).unwrap();
    assert_eq!((found.stamp, found.motion.offset.x), (2 * SECOND, 120.25));
    // transforms above the common frame do not count
    let found = buffer.look_up("odom", "laser", 0).unwrap();
    assert_eq!(found.stamp, 2_050_000_000);
    assert_eq!(buffer.look_up("base", "laser", 0).unwrap().stamp, 0);
}

#[test]
fn failures_say_which_transform_is_missing() {
    let mut buffer = robot();
    fixed(&mut buffer, ("arm", "hand"), 1.0);
    let failure = |target: &str, source: &str, at_ms: i64| {
        buffer
            .look_up(target, source, at_ms * 1_000_000)
            .unwrap_err()
    };
    let unknown = failure("map", "camera", 1500);
    assert_eq!(unknown.to_string(), "no transform has the frame `camera`");
    let apart = failure("map", "hand", 1500);
    assert_eq!(
        apart.to_string(),
        "no transforms connect the frames `hand` and `map`"
    );
    let late = failure("map", "laser", 2500);
    assert_eq!(
        late.to_string(),
        "it is younger than all transforms from `base` to `odom`"
    );
    assert_eq!(late.distance(), Some(Duration::from_millis(500)));
    let early = failure("laser", "map", 400);
    assert_eq!(
        early.to_string(),
        "it is older than all transforms from `base` to `odom`"
    );
    assert_eq!(early.distance(), Some(Duration::from_millis(600)));
    let passing = [&unknown, &apart, &late, &early].map(TransformFailure::may_pass);
    assert_eq!(passing, [true, true, true, false]);
}

#[test]
fn a_circle_is_a_failure() {
    let mut buffer = TransformBuffer::default();
    fixed(&mut buffer, ("a", "b"), 1.0);
    fixed(&mut buffer, ("b", "a"), 1.0);
    fixed(&mut buffer, ("c", "d"), 1.0);
    let found = buffer.look_up("d", "a", SECOND).unwrap_err();
    assert!(matches!(found, TransformFailure::Circle { .. }), "{found}");
    let found = buffer.look_up("d", "a", 0).unwrap_err();
    assert!(
        matches!(found, TransformFailure::Disconnected { .. }),
        "{found}"
    );
}

#[test]
fn transforms_are_forgotten_after_10_seconds() {
    let mut buffer = TransformBuffer::default();
    for step in 0..=300 {
        moving(&mut buffer, ("a", "b"), 1000 + step * 100, 0.0);
    }
    let found = buffer.look_up("a", "b", 20 * SECOND).unwrap_err();
    assert!(matches!(found, TransformFailure::Past { .. }), "{found}");
    buffer.look_up("a", "b", 21 * SECOND).unwrap();
}

#[test]
fn a_frame_gets_another_parent() {
    let mut buffer = TransformBuffer::default();
    fixed(&mut buffer, ("world", "table"), 5.0);
    fixed(&mut buffer, ("world", "gripper"), 7.0);
    moving(&mut buffer, ("table", "cup"), 1000, 1.0);
    moving(&mut buffer, ("table", "cup"), 2000, 2.0);
    moving(&mut buffer, ("gripper", "cup"), 3000, 0.5);
    assert_eq!(x(&buffer, "world", "cup", 1500), 6.5);
    assert_eq!(x(&buffer, "world", "cup", 2500), 7.0);
    assert_eq!(x(&buffer, "world", "cup", 3000), 7.5);
}

#[test]
fn a_publisher_that_starts_again_with_an_earlier_time_is_heard() {
    let mut buffer = TransformBuffer::default();
    for at_ms in [100_000, 100_100] {
        moving(&mut buffer, ("a", "b"), at_ms, 1.0);
    }
    // a late one is no new start
    moving(&mut buffer, ("a", "b"), 99_000, 5.0);
    assert_eq!(x(&buffer, "a", "b", 100_050), 1.0);
    for at_ms in [1000, 1100] {
        moving(&mut buffer, ("a", "b"), at_ms, 2.0);
    }
    assert_eq!(x(&buffer, "a", "b", 1050), 2.0);
    assert_eq!(x(&buffer, "a", "b", 0), 2.0);
}

#[test]
fn what_is_no_transform_is_refused() {
    let mut buffer = TransformBuffer::default();
    let message = |parent: &str, child: &str, w: f64, x: f64| {
        let number = |number| Datum::Float(number);
        let zero = || number(0.0);
        let rotation = [
            ("x", zero()),
            ("y", zero()),
            ("z", zero()),
            ("w", number(w)),
        ];
        let translation = [("x", number(x)), ("y", zero()), ("z", zero())];
        let stamp = [("sec", Datum::Int(1)), ("nanosec", Datum::Int(0))];
        let header = [
            ("stamp", Datum::record(stamp)),
            ("frame_id", Datum::text(parent)),
        ];
        let transform = [
            ("translation", Datum::record(translation)),
            ("rotation", Datum::record(rotation)),
        ];
        Datum::record([
            ("header", Datum::record(header)),
            ("child_frame_id", Datum::text(child)),
            ("transform", Datum::record(transform)),
        ])
    };
    let transforms = vec![
        message("a", "b", 1.0, 3.0),
        message("", "b", 1.0, 0.0),
        message("/b", "b", 1.0, 0.0),
        message("a", "c", 0.5, 0.0),
        message("a", "c", 1.0, f64::NAN),
        message("a", "d", 1.001, 2.0),
    ];
    let message = Datum::record([("transforms", Datum::List(transforms))]);
    let refused = buffer.insert_message(&message, false);
    let no_motion = InvalidTransform::NoMotion {
        child: "c".to_owned(),
        parent: "a".to_owned(),
    };
    let frame = "b".to_owned();
    let own = InvalidTransform::OwnParent { frame };
    let expected = [InvalidTransform::NoFrame, own, no_motion.clone(), no_motion];
    assert_eq!(refused, expected);
    assert_eq!(x(&buffer, "d", "b", 1000), 1.0);
    let refused = buffer.insert_message(&Datum::Null, false);
    assert_eq!(refused, [InvalidTransform::NoMessage]);
}

#[test]
fn names_without_end_do_not_fill_the_memory() {
    let mut buffer = TransformBuffer::default();
    let results = (0..5000).map(|number| {
        let new = StampedMotion::new("a", &format!("b{number}"), 0, shift(0.0));
        buffer.insert(new, true)
    });
    let refused = results.filter(Result::is_err).count();
    assert_eq!((refused, buffer.frames()), (5000 - 4096, 4096));
}

//! Cargo features of this build: the only list of all features, of their contents, and of the way to enable them.

use asmotion_composite::model::BridgeKind;

/// Part of asmotion that a build may leave out, to compile faster.
pub trait Feature {
    /// Name in `Cargo.toml`.
    const NAME: &'static str;
    /// The subject of the sentence "… is not in this build".
    const BRINGS: &'static str;
}

/// Systems on RabbitMQ: `run --bus`, and the commands that inspect and control a running system.
pub struct Amqp;

/// The dashboard: `run --dashboard`, `demo --open` and, with recordings, `dash`.
pub struct Dashboard;

/// Services over HTTP: gateways of composites, and wires to other systems.
pub struct Http;

/// Recordings in MCAP: `run --record FILE.mcap`, `[deploy] record` and `replay`.
pub struct Mcap;

/// ROS: the built-in `ros-bridge`, `ros types`, `ros list` and `ros echo`.
pub struct Ros;

/// ROS 2: bridges of kind `ros2`, `ros list --ros 2` and `ros echo --ros 2`.
pub struct Ros2;

/// Composites of the Service Component Architecture, and RTT's property files.
pub struct Scdl;

/// Decision diagrams: `verify --engine symbolic`.
pub struct Symbolic;

/// Terminal user interface: `top` and `run --top`.
pub struct Tui;

impl Feature for Amqp {
    const NAME: &'static str = "amqp";
    const BRINGS: &'static str = "the bus over RabbitMQ";
}

impl Feature for Dashboard {
    const NAME: &'static str = "dashboard";
    const BRINGS: &'static str = "the dashboard";
}

impl Feature for Http {
    const NAME: &'static str = "http";
    const BRINGS: &'static str = "the gateway and client for services over HTTP";
}

impl Feature for Mcap {
    const NAME: &'static str = "mcap";
    const BRINGS: &'static str = "the recorder of runs in MCAP";
}

impl Feature for Ros {
    const NAME: &'static str = "ros";
    const BRINGS: &'static str = "the bridge to ROS";
}

impl Feature for Ros2 {
    const NAME: &'static str = "ros2";
    const BRINGS: &'static str = "the bridge to ROS 2";
}

impl Feature for Scdl {
    const NAME: &'static str = "scdl";
    const BRINGS: &'static str = "the reader and writer of SCDL";
}

impl Feature for Symbolic {
    const NAME: &'static str = "symbolic";
    const BRINGS: &'static str = "the symbolic engine of `verify`";
}

impl Feature for Tui {
    const NAME: &'static str = "tui";
    const BRINGS: &'static str = "the terminal monitor";
}

/// The error for a request that needs a feature this build does not have. Its text explains how to get it.
#[derive(Debug, thiserror::Error)]
#[error(
    "{brings} is not in this build: it needs the feature `{feature}`\n  \
     asmotion itself: `cargo install --path . --features {feature}` adds it, `--features full,ros2` adds everything\n  \
     a program of your own: `cargo run --features {feature} -- …`, with `{feature} = [\"asmotion/{feature}\"]` in the \
     `[features]` of its Cargo.toml"
)]
pub struct LeftOut {
    brings: &'static str,
    feature: &'static str,
}

impl LeftOut {
    /// The error for the missing feature `F`.
    pub fn new<F: Feature>() -> Self {
        let (brings, feature) = (F::BRINGS, F::NAME);
        Self { brings, feature }
    }

    /// The way to the feature, on one line.
    pub fn way(&self) -> String {
        let feature = self.feature;
        format!("install a build that connects it: `cargo install --path . --features {feature}`")
    }
}

/// The missing feature that connects bridges of a kind; `None` if this build connects them, or none can.
pub fn without_bridges(kind: BridgeKind) -> Option<LeftOut> {
    match kind {
        BridgeKind::Ros1 => (!cfg!(feature = "ros")).then(LeftOut::new::<Ros>),
        BridgeKind::Ros2 => (!cfg!(feature = "ros2")).then(LeftOut::new::<Ros2>),
        BridgeKind::Rosbridge => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_says_how_to_get_it() {
        let said = LeftOut::new::<Scdl>().to_string();
        assert!(said.starts_with("the reader and writer of SCDL is not in this build"));
        for way in [
            "cargo install --path . --features scdl`",
            "cargo run --features scdl -- …`",
            "`scdl = [\"asmotion/scdl\"]` in the `[features]` of its Cargo.toml",
        ] {
            assert!(said.contains(way), "{said}");
        }
        let said = LeftOut::new::<Symbolic>().to_string();
        assert!(said.starts_with("the symbolic engine of `verify` is not in this build"));
        let way = LeftOut::new::<Ros2>().way();
        assert!(
            way.ends_with("`cargo install --path . --features ros2`"),
            "{way}"
        );
        assert!(
            said.contains("cargo install --path . --features symbolic`"),
            "{said}"
        );
        let said = LeftOut::new::<Mcap>().to_string();
        assert!(
            said.starts_with("the recorder of runs in MCAP is not in this build: it needs")
                && said.contains("cargo install --path . --features mcap`"),
            "{said}"
        );
    }
}

//! asmotion with the components of this project: it has every command of `asmotion`.

fn main() -> std::process::ExitCode {
    gripper::app().main()
}

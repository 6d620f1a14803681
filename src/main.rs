//! The `asmotion` binary.

fn main() -> std::process::ExitCode {
    asmotion::main()
}

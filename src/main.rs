//! The `asmotion` binary.

fn main() -> std::process::ExitCode {
    asmotion::App::standard().main()
}

#!/bin/sh
# Runs the tests of the crates with unsafe code under the address and leak sanitizers. Needs a nightly compiler.
set -eu
cd "$(dirname "$0")/.."
target=$(rustc +nightly -vV | sed -n 's/^host: //p')
export RUSTFLAGS="-Zsanitizer=address" CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-target/sanitizer}"
# doctests would be compiled without the sanitizer's runtime
exec cargo +nightly test --target "$target" --locked --lib --tests \
    -p asmotion-value -p asmotion-connection -p asmotion-machine "$@"

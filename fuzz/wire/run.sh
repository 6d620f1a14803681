#!/bin/sh
# Fuzzes a property of the decoders of ROS for some seconds: run.sh TARGET [SECONDS]; the targets are the files of fuzz_targets.
# Needs no nightly compiler and no cargo-fuzz: the flags are those of `cargo fuzz run -s none`.
set -eu
cd "$(dirname "$0")"
target=$1
seconds=${2:-300}
host=$(rustc -vV | sed -n 's/^host: //p')
export RUSTFLAGS="-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
-Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
-Cllvm-args=-sanitizer-coverage-trace-compares --cfg fuzzing -Cdebug-assertions -Ccodegen-units=1 \
-Cllvm-args=-simplifycfg-branch-fold-threshold=0"
# with `--target`, build scripts and procedural macros are built without these flags
cargo build --release --target "$host" --bin "$target"
mkdir -p "corpus/$target" "artifacts/$target"
exec "${CARGO_TARGET_DIR:-target}/$host/release/$target" "corpus/$target" "seeds/$target" -max_total_time="$seconds" -timeout=10 \
    -rss_limit_mb=2048 -malloc_limit_mb=1024 -max_len=16384 -artifact_prefix="artifacts/$target/"

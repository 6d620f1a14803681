#!/bin/sh
# Fuzzes a property for some seconds: run.sh parse|check|fmt [seconds]
# Instrumented code takes about five times the time and twice the memory.
set -eu
cd "$(dirname "$0")/.."
property=$1
seconds=${2:-600}
mkdir -p "fuzz/corpus/$property"
exec cargo +nightly fuzz run "$property" "fuzz/corpus/$property" \
    tests/language/semantics tests/language/messages \
    asm-lang/syntax/tests/errors asm-lang/syntax/tests/layout asm-lang/syntax/tests/scenarios specs \
    -- -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -malloc_limit_mb=1024 \
    -dict=fuzz/words.dict -max_len=16384

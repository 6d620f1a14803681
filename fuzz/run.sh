#!/bin/sh
# Fuzzes a property for some seconds: run.sh TARGET [SECONDS]; the targets are the files of fuzz_targets.
# Instrumented code takes about five times the time and twice the memory.
set -eu
cd "$(dirname "$0")/.."
target=$1
seconds=${2:-600}
words=
case $target in
parse | check | fmt)
    seeds="tests/language/semantics tests/language/messages asm-lang/syntax/tests/errors \
        asm-lang/syntax/tests/layout asm-lang/syntax/tests/scenarios specs"
    words="-dict=fuzz/words.dict"
    ;;
composite) seeds="engine/plan/tests/composites" ;;
scdl) seeds="engine/scdl/tests/scdl" ;;
*) seeds= ;;
esac
mkdir -p "fuzz/corpus/$target"
# the lists of seeds and words are split on purpose
# shellcheck disable=SC2086
exec cargo +nightly fuzz run "$target" "fuzz/corpus/$target" $seeds \
    -- -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -malloc_limit_mb=1024 $words -max_len=16384

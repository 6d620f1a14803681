"""Reads the text format of Prometheus on the standard input with Prometheus' own parser, and prints its metrics as JSON."""

import json
import sys

from prometheus_client.parser import text_string_to_metric_families

families = {}
for family in text_string_to_metric_families(sys.stdin.read()):
    assert family.name not in families, f"{family.name} appears twice"
    families[family.name] = {
        "type": family.type,
        "help": family.documentation,
        "samples": [[it.name, it.labels, it.value] for it in family.samples],
    }
print(json.dumps(families))

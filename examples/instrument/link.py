#!/usr/bin/env python3
"""A link with nothing but a latency, 25 ms each way, as the link `fixed` has. docs/INSTRUMENT.md tells the questions.

    foreland bench latency SCENE --round-trips 50 --link-command examples/instrument/link.py
"""
import json
import sys

LATENCY_US = 25_000


def answer(question):
    if "foreland" in question:
        return {"foreland": 1}
    return {"leaves_us": question["time_us"], "arrives_us": question["time_us"] + LATENCY_US}


for line in sys.stdin:
    print(json.dumps(answer(json.loads(line))), flush=True)

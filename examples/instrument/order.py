#!/usr/bin/env python3
"""An order of jobs: first the one with the least time to spare, as `--policies least-laxity`. docs/INSTRUMENT.md tells the questions.

    foreland bench load SCENE --policies least-laxity --order-command examples/instrument/order.py
"""
import json
import sys


def answer(question):
    if "foreland" in question:
        return {"foreland": 1}
    return {"key": question["deadline_us"] - question["work_us"]}


for line in sys.stdin:
    print(json.dumps(answer(json.loads(line))), flush=True)

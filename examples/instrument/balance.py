#!/usr/bin/env python3
"""A balancer: the server whose viewers use least, as `--balance least-loaded` places them. docs/INSTRUMENT.md tells the questions.

    foreland bench load SCENE --servers 3 --balance least-loaded --balance-command examples/instrument/balance.py
"""
import json
import sys


def answer(question):
    if "foreland" in question:
        return {"foreland": 1}
    servers = question["servers"]
    open_ones = [number for number, server in enumerate(servers) if server["open"]]
    return {"server": min(open_ones, key=lambda number: servers[number]["used"], default=None)}


for line in sys.stdin:
    print(json.dumps(answer(json.loads(line))), flush=True)

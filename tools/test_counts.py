#!/usr/bin/env python3
"""Counts the test cases of a ctest run: prints `PASSED FAILED SKIPPED`, then a line for each skipped and each failed case.

    tools/test_counts.py LABEL CTEST.xml RESULTS

CTEST.xml is what ctest wrote (--output-junit). RESULTS is the folder into which GoogleTest executables write their cases, each in the
file that is named as ctest's test (NAME.xml). A test without such a file counts as one case; if it is an executable that was to write
one, it ended early, and that is a failure.

  skip LABEL: NAME: REASON
  fail LABEL: NAME
"""

import os
import re
import sys
import xml.etree.ElementTree as ET

WRITES_CASES = re.compile(r"_test\.\d+$")  # cmake/Tests.cmake names the processes of test executables so


def failed(case):
    return case.find("failure") is not None or case.find("error") is not None or case.get("status") == "fail"


def cases_in(path):
    """(name, 'passed' | 'failed' | 'skipped', reason) of each case that ran."""
    for case in ET.parse(path).getroot().iter("testcase"):
        if case.get("status") == "notrun":
            continue  # another process's, or filtered out
        name = f"{case.get('classname')}.{case.get('name')}"
        skip = case.find("skipped")
        if failed(case):
            yield name, "failed", ""
        elif skip is not None or case.get("result") == "skipped":
            yield name, "skipped", " ".join((skip.get("message") or "no reason given").split()) if skip is not None else "no reason given"
        else:
            yield name, "passed", ""


def judged(test, results):
    """The cases of one of ctest's tests."""
    name, path = test.get("name"), os.path.join(results, test.get("name") + ".xml")
    if os.path.exists(path):
        cases = list(cases_in(path))
        yield from cases
        if failed(test) and not any(outcome == "failed" for _, outcome, _ in cases):
            yield f"{name} (ended with an error)", "failed", ""
    elif failed(test):
        yield name, "failed", ""
    elif WRITES_CASES.search(name):
        yield f"{name} (was not built, or ended early)", "failed", ""
    elif test.get("status") in ("notrun", "disabled"):
        yield f"{name} (was not run)", "failed", ""
    else:
        yield name, "passed", ""


def main():
    if len(sys.argv) != 4:
        print(__doc__, file=sys.stderr)
        return 2
    label, counts, lines = sys.argv[1], {"passed": 0, "failed": 0, "skipped": 0}, []
    for test in ET.parse(sys.argv[2]).getroot().iter("testcase"):
        for name, outcome, reason in judged(test, sys.argv[3]):
            counts[outcome] += 1
            if outcome == "failed":
                lines.append(f"fail {label}: {name}")
            elif outcome == "skipped":
                lines.append(f"skip {label}: {name}: {reason}")
    print(counts["passed"], counts["failed"], counts["skipped"])
    print("\n".join(lines))
    return 0


if __name__ == "__main__":
    sys.exit(main())

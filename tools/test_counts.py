#!/usr/bin/env python3
"""Reads a JUnit file that ctest wrote: prints `PASSED FAILED SKIPPED`, then a line for each skipped and each failed test.

    tools/test_counts.py LABEL FILE.xml

  skip LABEL: NAME: REASON
  fail LABEL: NAME
"""

import re
import sys
import xml.etree.ElementTree as ET


def reason(output):
    """What GTEST_SKIP() said, or the last line that is not GoogleTest's own."""
    said = re.search(r": Skipped\n(.*?)\n*\[  SKIPPED \]", output, re.DOTALL)
    if said and said[1].strip():
        return " ".join(said[1].split())
    lines = [l.strip() for l in output.splitlines() if l.strip() and not l.startswith(("[", "Note:", "Running"))]
    return lines[-1] if lines else "no reason given"


def main():
    if len(sys.argv) != 3:
        print(__doc__, file=sys.stderr)
        return 2
    passed, lines, failed, skipped = 0, [], 0, 0
    for case in ET.parse(sys.argv[2]).getroot().iter("testcase"):
        output = case.findtext("system-out") or ""
        if case.find("failure") is not None or case.find("error") is not None or case.get("status") == "fail":
            failed += 1
            lines.append(f"fail {sys.argv[1]}: {case.get('name')}")
        elif case.find("skipped") is not None or case.get("status") in ("notrun", "disabled"):
            # A test whose executable is missing has not been skipped by choice.
            if "NOT_BUILT" in case.get("name", "") or "Unable to find executable" in output:
                failed += 1
                lines.append(f"fail {sys.argv[1]}: {case.get('name')} (not built)")
            else:
                skipped += 1
                lines.append(f"skip {sys.argv[1]}: {case.get('name')}: {reason(output)}")
        else:
            passed += 1
    print(passed, failed, skipped)
    print("\n".join(lines))
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Which files are ours: tracked ones and new ones that git does not ignore; without git, all outside build folders."""

import os
import subprocess

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
CPP = (".h", ".cpp")


def ours(root=ROOT, suffixes=None):
    """Sorted paths relative to `root`, existing files only, optionally by suffix."""
    found = [p for p in (_from_git(root) or _from_walk(root)) if os.path.isfile(os.path.join(root, p))]
    return sorted(p for p in found if suffixes is None or p.endswith(tuple(suffixes)))


def _from_git(root):
    if not os.path.exists(os.path.join(root, ".git")):
        return None
    command = ["git", "-c", "safe.directory=*", "-C", root, "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(command, capture_output=True, check=False)
    return [p.decode() for p in listed.stdout.split(b"\0") if p] if listed.returncode == 0 else None


def _from_walk(root):
    skipped = {"node_modules", "dist", ".git", "__pycache__"}
    for folder, folders, files in os.walk(root):
        folders[:] = [f for f in folders if f not in skipped and not (folder == root and f == "build")]
        for name in files:
            yield os.path.relpath(os.path.join(folder, name), root)

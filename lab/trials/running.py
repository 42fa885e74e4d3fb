"""Programs that a trial runs, and what they say. All of them end with the trial, however it ends."""

import contextlib
import json
import math
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BIN = Path(os.environ.get("FORELAND_BIN", ROOT / "build/release/bin"))
PATIENCE_S = 60


def say(text):
    print(f"{Path(sys.argv[0]).stem}: {text}", file=sys.stderr, flush=True)


def foreland(name):
    """The path of a subcommand's program."""
    path = BIN / f"foreland-{name}"
    if not path.exists():
        sys.exit(f"{path} is not there; build it, or set FORELAND_BIN")
    return str(path)


def free_port():
    """One that was free a moment ago."""
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


class Program(contextlib.AbstractContextManager):
    """A program in a process group of its own, which is killed at the end of a `with`. What it prints goes to `log`, or is kept."""

    def __init__(self, *words, env=None, log=None, **more):
        self.name = Path(words[0]).name
        self._log = open(log, "ab") if log else None
        self._process = subprocess.Popen(
            [str(word) for word in words], stdin=subprocess.DEVNULL, stdout=self._log or subprocess.PIPE, stderr=self._log or subprocess.DEVNULL,
            env={**os.environ, **(env or {})}, start_new_session=True, **more)

    def line(self):
        """The next line of its output."""
        return self._process.stdout.readline().decode()

    def result(self):
        """Exit code and the rest of the output, when it has ended."""
        output = self._process.communicate()[0]
        return self._process.returncode, output.decode() if output else ""

    @property
    def id(self):
        return self._process.pid

    def is_running(self):
        return self._process.poll() is None

    def kill(self, number=signal.SIGKILL):
        """Sends a signal to the program and its children."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.id, number)

    def __exit__(self, *_):
        self.kill()
        self._process.wait()
        for file in (self._log, self._process.stdout):
            if file:
                file.close()


class Share(contextlib.AbstractContextManager):
    """A part of one processor for programs, by a control group of Linux's (cpu, version 1 or 2), which is theirs until they end. Needs root."""

    PERIOD_US = 8000  # short, so that a small part of a processor is a slow one, and not one that comes and goes
    LEAST_US = 1000  # of a period, that Linux allows

    def __init__(self, name):
        self._is_first = Path("/sys/fs/cgroup/cpu").is_dir()
        self._folder = Path("/sys/fs/cgroup/cpu" if self._is_first else "/sys/fs/cgroup") / f"foreland-{os.getpid()}-{name}"
        self._folder.mkdir()

    def add(self, program):
        (self._folder / "cgroup.procs").write_text(str(program.id))

    def set(self, part):
        period = max(self.PERIOD_US, math.ceil(self.LEAST_US / part))
        quota = round(part * period)
        if self._is_first:
            (self._folder / "cpu.cfs_period_us").write_text(str(period))
            (self._folder / "cpu.cfs_quota_us").write_text(str(quota))
        else:
            (self._folder / "cpu.max").write_text(f"{quota} {period}")

    def __exit__(self, *_):
        until(self._is_gone, f"the end of {self._folder}")

    def _is_gone(self):
        with contextlib.suppress(OSError):
            self._folder.rmdir()
        return not self._folder.exists()


def until(condition, what, patience_s=PATIENCE_S):
    """Waits until a condition holds, and returns its value."""
    end = time.monotonic() + patience_s
    while not (value := condition()):
        if time.monotonic() > end:
            raise TimeoutError(f"waited {patience_s} s in vain for {what}")
        time.sleep(0.05)
    return value


def answers(port):
    with socket.socket() as s:
        return s.connect_ex(("127.0.0.1", port)) == 0


NGINX = """daemon off; master_process off; pid {folder}/nginx.pid; error_log /dev/null;
events {{ worker_connections 256; }}
http {{ log_format sent "$body_bytes_sent"; access_log {folder}/sent.log sent;
  client_body_temp_path {folder}/body; proxy_temp_path {folder}/proxy; fastcgi_temp_path {folder}/fastcgi; uwsgi_temp_path {folder}/uwsgi; scgi_temp_path {folder}/scgi;
  server {{ listen 127.0.0.1:{port}; root {folder}; autoindex on; }} }}
"""


def nginx(folder, port):
    """A web server for a folder, which keeps the number of bytes of each answer in sent.log there."""
    config = folder / "nginx.conf"
    config.write_text(NGINX.format(folder=folder, port=port))
    server = Program("/usr/sbin/nginx", "-c", config, "-p", folder)
    until(lambda: answers(port), "nginx")
    return server


def port_of(line):
    """Of the address with which a server's, or a link's, first line ends."""
    return int(line.rsplit(":", 1)[1].strip().strip("/"))


def metrics(port):
    """What a server counts, by name with labels; its own names without their prefix."""
    with urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics", timeout=10) as answer:
        lines = answer.read().decode().splitlines()
    pairs = (line.rsplit(" ", 1) for line in lines if line and not line.startswith("#"))
    return {name.removeprefix("foreland_"): float(value) for name, value in pairs}


@contextlib.contextmanager
def scratch(keep=None):
    """A folder for what is made meanwhile: `keep`, or one that goes at the end."""
    if keep:
        Path(keep).mkdir(parents=True, exist_ok=True)
        yield Path(keep)
        return
    with tempfile.TemporaryDirectory(prefix="foreland-trial-") as folder:
        yield Path(folder)


def finish(report, out):
    """Prints a report, and keeps it where `out` says. Exits 1 if one of its laws does not hold."""
    text = json.dumps(report, indent=1)
    print(text)
    if out:
        Path(out).write_text(text + "\n")
    broken = report.get("broken", [])
    for law in broken:
        say(f"broken: {law}")
    sys.exit(1 if broken else 0)

"""A store that answers every request for a part of a scene, and never with that part.

    liar.py FOLDER PORT [SEED]
"""

import http.server
import random
import re
import sys
from pathlib import Path

# The first three look as they should, and come most.
KINDS = 3 * ("noise", "zeros", "elsewhere") + ("html", "error", "cut short", "too long", "whole")


class Liar(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    chance = random.Random(1)

    def do_GET(self):
        scene = Path(sys.argv[1]) / self.path.lstrip("/")
        asked = re.fullmatch(r"bytes=(\d+)-(\d+)", self.headers.get("Range", ""))
        begin, end = (int(number) for number in asked.groups()) if asked else (0, 4095)
        count, kind = end - begin + 1, self.chance.choice(KINDS)
        if kind == "error":
            self.answer(500, b"out of order\n")
        elif kind == "html":
            self.answer(200, b"<!doctype html><p>Please log in.")
        elif kind == "whole":
            self.answer(200, bytes(1 << 20))
        elif kind == "cut short":
            self.answer(206, self.noise(count), sent=count // 2)
        elif kind == "too long":
            self.answer(206, self.noise(count + 4096))
        elif kind == "zeros":
            self.answer(206, bytes(count))
        elif kind == "elsewhere" and scene.is_file():
            with open(scene, "rb") as file:
                file.seek((begin + (1 << 20)) % max(1, scene.stat().st_size - count))
                self.answer(206, file.read(count))
        else:
            self.answer(206, self.noise(count))

    def noise(self, count):
        return self.chance.randbytes(count)

    def answer(self, status, body, sent=None):
        self.send_response(status)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body[:sent])
        self.close_connection = sent is not None

    def log_message(self, *_):
        pass


class Server(http.server.ThreadingHTTPServer):
    def handle_error(self, *_):
        pass  # whoever was lied to has hung up


if __name__ == "__main__":
    Liar.chance = random.Random(int(sys.argv[3]) if len(sys.argv) > 3 else 1)
    Server(("127.0.0.1", int(sys.argv[2])), Liar).serve_forever()

"""A strake studio that is started for a test, and asked over sockets."""
import http.client
import json
import re
import signal
import socket
import subprocess
import time


class Studio:
    """A studio at work in a folder."""

    def __init__(self, strake, folder, *arguments, environment=None, command=None):
        self.process = subprocess.Popen(command or [strake, "studio", *arguments, "--no-browser"], cwd=folder, text=True,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment)
        self.url = self.process.stdout.readline()
        found = re.fullmatch(r"http://127\.0\.0\.1:(\d+)/([0-9a-f]{32})/\n", self.url)
        if not found:
            self.process.kill()
            raise RuntimeError(f"no address: {self.url!r} {self.process.stderr.read()}")
        self.port, self.token = int(found[1]), found[2]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.end(signal.SIGTERM)

    def end(self, with_signal):
        """(status, stdout, stderr)"""
        self.process.send_signal(with_signal)
        out, err = self.process.communicate(timeout=20)
        return self.process.returncode, out, err

    def request(self, path, method="GET", body=None, headers=None, token=None):
        """(status, body)"""
        asked = http.client.HTTPConnection("127.0.0.1", self.port, timeout=30)
        asked.request(method, f"/{self.token if token is None else token}/{path}", body, headers or {})
        answer = asked.getresponse()
        self.headers = answer.headers
        found = answer.status, answer.read()
        asked.close()
        return found

    def post(self, what, **more):
        status, body = self.request("api", "POST", json.dumps({"do": what, **more}), {"Content-Type": "application/json"})
        return status, json.loads(body)

    def state(self):
        return json.loads(self.request("api/state?from=0")[1])

    def until(self, holds, seconds=60):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            state = self.state()
            if holds(state):
                return state
            time.sleep(0.05)
        raise RuntimeError(f"never came true; last: {state}")

    def raw(self, words):
        with socket.create_connection(("127.0.0.1", self.port), timeout=10) as link:
            link.sendall(words)
            answer = b""
            while True:
                try:
                    piece = link.recv(65536)
                except (ConnectionResetError, TimeoutError):
                    break
                if not piece:
                    break
                answer += piece
            return answer

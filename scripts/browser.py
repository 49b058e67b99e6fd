"""A headless Chromium that is told what to do through DevTools' pipe (standard library only).

    with Browser(1200, 900) as browser:
        browser.open(path)
        browser.until("document.documentElement.dataset.ready")
        browser.click("#design")
        browser.screenshot("page.png")

Errors of the page's console and requests beside its own file, or outside of its own address, are collected in `errors` and `requests`.
"""
import base64
import json
import os
import pathlib
import select
import shutil
import subprocess
import tempfile
import time

KEYS = {"Tab": 9, "Enter": 13, " ": 32, "ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39, "ArrowDown": 40, "Home": 36}


def find_chromium():
    for name in ("chromium", "chromium-browser", "google-chrome"):
        if shutil.which(name):
            return shutil.which(name)
    return None


class Browser:
    def __init__(self, width=1200, height=900, arguments=()):
        self.home = tempfile.mkdtemp(prefix="strake-browser-")
        self.width, self.height = width, height
        read_commands, self.commands = os.pipe()
        self.answers, write_answers = os.pipe()

        def in_child():  # DevTools reads descriptor 3 and writes 4
            os.dup2(read_commands, 100), os.dup2(write_answers, 101)
            os.dup2(100, 3), os.dup2(101, 4)

        self.process = subprocess.Popen(
            [find_chromium(), "--headless=new", "--remote-debugging-pipe", "--no-sandbox", "--disable-dev-shm-usage",
             "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-first-run", "--disable-extensions",
             "--disable-background-networking", "--disable-component-update", "--disable-sync", "--hide-scrollbars",
             "--force-color-profile=srgb", f"--user-data-dir={self.home}", f"--window-size={width},{height}",
             *arguments, "about:blank"],
            preexec_fn=in_child, close_fds=False, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL, start_new_session=True)
        os.close(read_commands), os.close(write_answers)
        self.buffer, self.number, self.session, self.page = b"", 0, None, ""
        self.errors, self.requests, self.is_loaded = [], [], False
        target = next(t for t in self.call("Target.getTargets")["targetInfos"] if t["type"] == "page")
        self.session = self.call("Target.attachToTarget", targetId=target["targetId"], flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        self.resize(width, height)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        try:
            self.session = None
            self.call("Browser.close", seconds=5)
        except (OSError, RuntimeError):
            pass
        try:
            self.process.wait(5)
        except subprocess.TimeoutExpired:
            os.killpg(self.process.pid, 9)
            self.process.wait()
        os.close(self.commands), os.close(self.answers)
        shutil.rmtree(self.home, ignore_errors=True)

    def receive(self, end):
        while b"\0" not in self.buffer:
            ready, _, _ = select.select([self.answers], [], [], max(0, end - time.monotonic()))
            if not ready:
                raise RuntimeError("the browser does not answer")
            piece = os.read(self.answers, 1 << 20)
            if not piece:
                raise RuntimeError("the browser has gone")
            self.buffer += piece
        message, self.buffer = self.buffer.split(b"\0", 1)
        message = json.loads(message)
        self.note(message.get("method"), message.get("params", {}))
        return message

    def note(self, method, what):
        if method == "Page.loadEventFired":
            self.is_loaded = True
        if method == "Runtime.exceptionThrown":
            details = what["exceptionDetails"]
            self.errors.append(details.get("exception", {}).get("description", details["text"]))
        if method == "Runtime.consoleAPICalled" and what["type"] in ("error", "warning", "assert"):
            self.errors.append(" ".join(str(a.get("value", a.get("description", ""))) for a in what["args"]))
        if method == "Log.entryAdded" and what["entry"]["level"] in ("error", "warning"):
            self.errors.append(f'{what["entry"]["text"]} {what["entry"].get("url", "")}'.strip())
        if method == "Network.requestWillBeSent":
            url = what["request"]["url"]
            if not url.startswith((self.page, "data:", "blob:")):
                self.requests.append(url)

    def call(self, method, seconds=200, **parameters):
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.commands, json.dumps(message).encode() + b"\0")
        end = time.monotonic() + seconds
        while True:
            answer = self.receive(end)
            if answer.get("id") != message["id"]:
                continue
            if "error" in answer:
                raise RuntimeError(f"{method}: {answer['error']['message']}")
            return answer["result"]

    def resize(self, width, height, scale=1):
        self.width, self.height = width, height
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=scale, mobile=False)

    def open(self, path):
        is_address = str(path).startswith("http://")
        self.page = str(path) if is_address else pathlib.Path(path).resolve().as_uri()
        self.is_loaded = False
        self.call("Page.navigate", url=self.page)
        end = time.monotonic() + 120
        while not self.is_loaded:
            self.receive(end)

    def run(self, script):
        """The value of an expression in the page; promises are waited for."""
        result = self.call("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in result:
            details = result["exceptionDetails"]
            raise RuntimeError(details.get("exception", {}).get("description", details["text"]))
        return result["result"].get("value")

    def until(self, script, seconds=200):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            value = self.run(script)
            if value:
                return value
            time.sleep(0.05)
        raise RuntimeError(f"never came true: {script}")

    def settle(self):
        """Two pictures later."""
        self.run("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 60))))")

    def place_of(self, selector):
        found = self.run(f"""(() => {{ const e = document.querySelector({json.dumps(selector)});
            if (!e) return null; e.scrollIntoView({{block: 'center'}});
            const b = e.getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; }})()""")
        if not found:
            raise RuntimeError(f"nothing on the page is {selector}")
        return found

    def click(self, selector, across=0.5, down=0.5):
        left, top, width, height = self.place_of(selector)
        at = {"x": left + across * width, "y": top + down * height, "button": "left", "clickCount": 1}
        self.call("Input.dispatchMouseEvent", type="mousePressed", **at)
        self.call("Input.dispatchMouseEvent", type="mouseReleased", **at)
        self.settle()

    def key(self, name):
        what = {"key": name, "code": name, "windowsVirtualKeyCode": KEYS.get(name, ord(name[0]))}
        if len(name) == 1:
            what["text"] = name
        if name == "Enter":
            what["text"] = "\r"
        self.call("Input.dispatchKeyEvent", type="keyDown", **what)
        what.pop("text", None)
        self.call("Input.dispatchKeyEvent", type="keyUp", **what)
        self.settle()

    def choose(self, label, value):
        """In the drop-down list with that label, as a user's choice."""
        self.run(f"""(() => {{ const l = [...document.querySelectorAll('label')].find((l) => l.textContent.startsWith({json.dumps(label)}));
            const s = l.querySelector('select'); s.value = {json.dumps(value)};
            if (s.value !== {json.dumps(value)}) throw new Error('no such choice');
            s.dispatchEvent(new Event('change', {{bubbles: true}})); }})()""")
        self.settle()

    def screenshot(self, path, selector=None, whole=False):
        options = {"format": "png"}
        if selector:
            left, top, width, height = self.place_of(selector)
            x, y = self.run("[scrollX, scrollY]")
            options.update(clip={"x": left + x, "y": top + y, "width": width, "height": height, "scale": 1},
                           captureBeyondViewport=True)
        elif whole:
            height = self.run("document.documentElement.scrollHeight")
            options.update(clip={"x": 0, "y": 0, "width": self.width, "height": height, "scale": 1},
                           captureBeyondViewport=True)
        data = base64.b64decode(self.call("Page.captureScreenshot", **options)["data"])
        if path:
            pathlib.Path(path).write_bytes(data)
        return data

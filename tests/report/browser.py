"""Headless Chromium, told what to do over a pipe: the DevTools protocol without a library."""

import base64
import contextlib
import itertools
import json
import os
import re
import shutil
import signal
import subprocess
import tempfile
import zlib
from pathlib import Path

CHROMIUM = (
    shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
)


class Browser:
    """One page in a browser without a window; a context manager."""

    def __init__(self, width, height=900):
        self._folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        theirs_in, self._out = os.pipe()
        self._in, theirs_out = os.pipe()

        def pipes():  # Chromium reads from 3 and writes to 4
            first, second = os.dup(theirs_in), os.dup(theirs_out)
            os.dup2(first, 3)
            os.dup2(second, 4)

        flags = ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                 "--remote-debugging-pipe", f"--user-data-dir={self._folder.name}",
                 "--hide-scrollbars", "--no-first-run", "about:blank")  # fmt: skip
        self._process = subprocess.Popen(
            [CHROMIUM, *flags], preexec_fn=pipes, close_fds=False, start_new_session=True,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        os.close(theirs_in)
        os.close(theirs_out)
        self._numbers, self._rest, self.events = itertools.count(1), b"", []
        target = self._say("Target.createTarget", url="about:blank")["targetId"]
        session = self._say("Target.attachToTarget", targetId=target, flatten=True)
        self._session = session["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.say(f"{domain}.enable")
        self.resize(width, height)

    def __enter__(self):
        return self

    def __exit__(self, *error):
        # first by itself, with the processes it has started; they write into its folder to the end
        with contextlib.suppress(OSError, RuntimeError):
            self._say("Browser.close")
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(timeout=20)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        os.close(self._in)
        os.close(self._out)
        self._folder.cleanup()

    def _read(self):
        while b"\0" not in self._rest:
            part = os.read(self._in, 1 << 20)
            if not part:
                raise RuntimeError("Chromium ended")
            self._rest += part
        message, _, self._rest = self._rest.partition(b"\0")
        return json.loads(message)

    def _say(self, method, session=None, **values):
        number = next(self._numbers)
        message = {"id": number, "method": method, "params": values}
        if session:
            message["sessionId"] = session
        os.write(self._out, json.dumps(message).encode() + b"\0")
        while True:
            heard = self._read()
            if heard.get("id") != number:
                self.events.append(heard)
            elif "error" in heard:
                raise RuntimeError(f"{method}: {heard['error']}")
            else:
                return heard["result"]

    def say(self, method, **values):
        return self._say(method, self._session, **values)

    def resize(self, width, height=900):
        self.say("Emulation.setDeviceMetricsOverride", width=width, height=height,
                 deviceScaleFactor=1, mobile=width < 600)  # fmt: skip

    def open(self, page, wait_ms=300):
        self.events.clear()
        self.say("Page.navigate", url=Path(page).resolve().as_uri())
        while not any(event.get("method") == "Page.loadEventFired" for event in self.events):
            self.events.append(self._read())
        self.run(f"new Promise(done => setTimeout(done, {wait_ms}))")

    def run(self, script):
        found = self.say(
            "Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True
        )
        if "exceptionDetails" in found:
            raise RuntimeError(found["exceptionDetails"])
        return found["result"].get("value")

    def unfold(self):
        self.run("document.querySelectorAll('details').forEach(d => { d.open = true })")
        self.run("new Promise(done => setTimeout(done, 800))")

    def complaints(self):
        """What the page wrote to the console as an error or a warning, and what it threw."""
        found = []
        for event in self.events:
            method, values = event.get("method"), event.get("params", {})
            if method == "Runtime.exceptionThrown":
                found.append(values["exceptionDetails"])
            if method == "Runtime.consoleAPICalled" and values["type"] in ("error", "warning"):
                found.append(values["args"])
            if method == "Log.entryAdded" and values["entry"]["level"] in ("error", "warning"):
                found.append(values["entry"])
        return found

    def requests(self):
        """Addresses that the page asked for, itself and what it holds left out."""
        asked = [
            event["params"]["request"]["url"]
            for event in self.events
            if event.get("method") == "Network.requestWillBeSent"
        ]
        return [url for url in asked if not url.startswith(("data:", "file:", "about:"))]

    def overflowing(self, within="body"):
        """Elements that reach beyond the page's width and lie in nothing that scrolls."""
        return self.run(
            """(() => {
          const found = [], width = document.documentElement.clientWidth;
          for (const e of document.querySelectorAll("WITHIN *")) {
            const box = e.getBoundingClientRect();
            if (!box.width || box.right <= width + 1) continue;
            let scrolls = false;
            for (let at = e.parentElement; at && at !== document.body; at = at.parentElement)
              if (/auto|scroll|hidden/.test(getComputedStyle(at).overflowX)) scrolls = true;
            if (!scrolls) found.push(`${e.tagName}.${e.className} ${Math.round(box.right)}`);
          }
          return found;
        })()""".replace("WITHIN", within)
        )

    def screenshot(self, file, *, whole=True):
        png = self.say("Page.captureScreenshot", format="png", captureBeyondViewport=whole,
                       **({"clip": self._clip()} if whole else {}))["data"]  # fmt: skip
        Path(file).write_bytes(base64.b64decode(png))

    def _clip(self):
        size = self.say("Page.getLayoutMetrics")["cssContentSize"]
        return {"x": 0, "y": 0, "width": size["width"], "height": size["height"], "scale": 1}

    def pdf(self, file):
        told = self.say("Page.printToPDF", preferCSSPageSize=True, printBackground=True)
        Path(file).write_bytes(base64.b64decode(told["data"]))


def marks_by_page(pdf):
    """How many texts and images each page of a PDF of Chromium shows."""
    data = Path(pdf).read_bytes()
    objects = {
        int(number): body
        for number, body in re.findall(rb"(?:^|\n)(\d+) 0 obj\n?(.*?)endobj", data, re.DOTALL)
    }
    counts = []
    for body in objects.values():
        if not re.search(rb"/Type\s*/Page\b(?!s)", body):
            continue
        stream = objects[int(re.search(rb"/Contents\s+(\d+)", body)[1])]
        packed = stream.split(b"stream", 1)[1].lstrip(b"\r\n").rsplit(b"endstream", 1)[0]
        text = zlib.decompressobj().decompress(packed)
        counts.append(len(re.findall(rb"\bT[jJ]\b|\bDo\b", text)))
    return counts

#!/usr/bin/env python3
"""Watches runs and an experiment through `--view`, with Python's own HTTP client and in headless Chromium.

live_view.py STONESTACK FOLDER: exit code 0 if every check holds.
"""
import http.client
import json
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

from browse_report import Browser, check, failures

STONESTACK = pathlib.Path(sys.argv[1]).resolve()
FOLDER = pathlib.Path(sys.argv[2]).resolve()


class Work:
    """A command with --view."""

    def __init__(self, *arguments):
        self.process = subprocess.Popen([STONESTACK, *arguments, "--view"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=FOLDER)
        self.port, self.token, self.log = None, None, []
        for line in self.process.stderr:
            if found := re.match(r"live view: http://127\.0\.0\.1:(\d+)/$", line):
                self.port = int(found.group(1))
            if found := re.match(r"stop token: ([0-9a-f]{32})$", line):
                self.token = found.group(1)
                break
        for stream, lines in ((self.process.stderr, self.log), (self.process.stdout, [])):
            threading.Thread(target=lambda s, l: l.extend(s), args=(stream, lines), daemon=True).start()

    def ask(self, method, path, headers=()):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        connection.putrequest(method, path, skip_host=any(name == "Host" for name, _ in headers))
        for name, value in headers:
            connection.putheader(name, value)
        if method == "POST":
            connection.putheader("Content-Length", "0")
        connection.endheaders()
        answer = connection.getresponse()
        return answer.status, answer.read().decode()

    def open_events(self):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=300)
        connection.request("GET", "/events")
        return connection.getresponse()

    def end(self):
        return self.process.wait(timeout=300)


class Listener(threading.Thread):
    """Collects the messages of /events."""

    def __init__(self, work):
        super().__init__(daemon=True)
        self.answer, self.messages = work.open_events(), []
        self.start()

    def run(self):
        kind = None
        try:
            for line in self.answer:
                text = line.decode().rstrip("\n")
                if text.startswith("event: "):
                    kind = text[7:]
                if text.startswith("data: "):
                    self.messages.append((kind, json.loads(text[6:])))
        except (http.client.IncompleteRead, ConnectionError):
            self.messages.append(("cut off", None))

    def wait_for(self, count, seconds=120):
        deadline = time.monotonic() + seconds
        while len(self.messages) < count and self.is_alive() and time.monotonic() < deadline:
            time.sleep(0.05)
        return len(self.messages) >= count


def data_of(html, name):
    """The data that stands in a page."""
    return json.loads(re.search(r"^const %s = (\{.*\});$" % name, html, re.M).group(1).replace("<\\/", "</"))


def wait_until(browser, script, seconds=180):
    deadline = time.monotonic() + seconds
    while not browser.run("return " + script) and time.monotonic() < deadline:
        time.sleep(0.2)
    return bool(browser.run("return " + script))


def text_of(browser):
    """What a reader sees, and what the scene shows."""
    return browser.run("return [document.title, document.body.innerText, scene.stones.map(s => [s.visible, s.position.toArray()]), "
                       "scene.arm.tool.getWorldPosition(new THREE.Vector3()).toArray(), duration]")


def refuses(work):
    check(work.ask("GET", "/", [("Host", "evil.example")])[0] == 403, "a foreign Host is refused")
    check(work.ask("GET", "/", [("Host", "localhost:8080")])[0] == 200, "the port of an SSH tunnel is not")
    wrong = ("0" if work.token[0] != "0" else "1") + work.token[1:]
    for headers in ([], [("X-Stop-Token", wrong)], [("X-Stop-Token", work.token), ("Host", "evil.example")],
                    [("X-Stop-Token", work.token), ("Origin", "http://evil.example")]):
        check(work.ask("POST", "/stop", headers)[0] == 403, f"a stop with {[name for name, _ in headers]} is refused")


def a_run(browser):
    work = Work("run", "--robot", "ur10", "--seed", "1", "--per-run", "2", "--out", "run")
    check(work.port and work.token, "address and token are printed")
    page = work.ask("GET", "/")[1]
    check(data_of(page, "run")["live"] and not data_of(page, "run")["events"], "the page begins empty")
    first, slow = Listener(work), work.open_events()  # `slow` is never read
    browser.open(f"http://127.0.0.1:{work.port}/")
    refuses(work)
    check(first.wait_for(5), "messages come")
    second = Listener(work)
    check(wait_until(browser, "run.events.length > 3 && run.views.length > 0"), "the page grows in the browser")
    check(browser.run("return run.live && !document.querySelector('#live').hidden"), "it shows that the run goes on")
    check(browser.run("return document.querySelectorAll('#log tbody tr').length") > 3, "its log grows")
    check(wait_until(browser, "samples.length > 50 && duration > 1"), "motion comes in")
    check(work.process.poll() is None, "the run goes on meanwhile")
    check(wait_until(browser, "run.live === false"), "the end reaches the browser")
    time.sleep(0.5)
    live = text_of(browser)
    check(browser.errors() == [], "the console shows no error")
    check(work.end() == 0, "the run succeeds")
    slow.close()
    first.join(20)
    second.join(20)
    check(first.messages == second.messages and first.messages[-1][0] == "end", f"two clients have the same {len(first.messages)} messages")
    report = (FOLDER / "run/report.html")
    written = data_of(report.read_text(), "run")
    check(first.messages[-1][1] == written, "the last message is the data of the report")
    grown = {name: sum((data[name] for kind, data in first.messages if kind == "add"), []) for name in ("views", "decisions")}
    check(all(len(grown[name]) == len(written[name]) > 0 for name in grown), "observations and decisions came one after the other")
    browser.open(report.as_uri())
    wait_until(browser, "document.documentElement.dataset.ready === 'true'")
    check(text_of(browser) == live, "the page at the end is the report")
    try:
        work.ask("GET", "/")
        check(False, "the server ends with the run")
    except ConnectionError:
        check(True, "the server ends with the run")


def ends_early(how, end, *more):
    work = Work("run", "--robot", "ur10", "--seed", "1", "--per-run", "3", "--out", how, *more)
    listener = Listener(work)
    check(listener.wait_for(3), f"{how}: messages come")
    end(work)
    check(work.end() == 130, f"{how}: exit code 130, as after Ctrl-C")
    listener.join(20)
    check(not listener.is_alive() and listener.messages[-1][0] == "end", f"{how}: clients are told the end")
    result = json.loads((FOLDER / how / "result.json").read_text())
    check(result["ended"] == "interrupted", f"{how}: the record says so")


def press_stop(browser):
    def press(work):
        browser.open(f"http://localhost:{work.port}/")
        wait_until(browser, "document.documentElement.dataset.ready === 'true'")
        browser.run("document.getElementById('live-token').value = 'a wrong one'")
        browser.click("#live button")
        check(wait_until(browser, "document.getElementById('live-note').textContent.includes('stop token')", 20), "the button needs the token")
        check(all("403" in error for error in browser.errors()), "nothing else is wrong")
        browser.run("document.getElementById('live-token').value = arguments[0]", work.token)
        browser.click("#live button")
    return press


def an_experiment(browser):
    work = Work("experiment", "--runs", "2", "--stones", "2", "--per-run", "1", "--survival", "false", "--out", "experiment")
    listener = Listener(work)
    browser.open(f"http://127.0.0.1:{work.port}/")
    check(wait_until(browser, "document.querySelectorAll('#runs tbody tr').length === 1"), "a run that is done is listed")
    check(work.process.poll() is None, "while the next one goes on")
    first = browser.run("return document.querySelectorAll('#costs svg circle, #costs svg path').length")
    check(wait_until(browser, "document.querySelectorAll('#runs tbody tr').length === 2"), "so is the next")
    check(browser.run("return document.querySelectorAll('#costs svg circle, #costs svg path').length") > first, "figure 5 grows")
    check(wait_until(browser, "document.getElementById('live').hidden", 20), "the end reaches the browser")
    live = browser.run("return [document.title, document.body.innerText, document.getElementById('costs').innerHTML]")
    check(work.end() == 0, "the experiment succeeds")
    listener.join(20)
    runs = [len(data["runs"]) for _, data in listener.messages]
    check(runs == sorted(runs) and {0, 1, 2} <= set(runs), f"heights come run by run: {runs}")
    browser.open((FOLDER / "experiment/report.html").as_uri())
    check(browser.run("return [document.title, document.body.innerText, document.getElementById('costs').innerHTML]") == live,
          "the page at the end is the experiment's report")
    check(browser.errors() == [], "the console shows no error")


def main():
    shutil.rmtree(FOLDER, ignore_errors=True)
    FOLDER.mkdir(parents=True)
    with tempfile.TemporaryDirectory() as profile:
        browser = Browser(profile)
        try:
            a_run(browser)
            ends_early("stop", press_stop(browser))
            ends_early("sockets", lambda work: work.process.send_signal(signal.SIGINT), "--cell", "loopback-ur10")
            an_experiment(browser)
        finally:
            browser.close()
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())

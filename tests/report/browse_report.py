#!/usr/bin/env python3
"""Opens the report of a run in headless Chromium and clicks through it.

browse_report.py REPORT.html [PICTURE.png]: exit code 0 if every check holds. Chromium is driven by chromedriver's
WebDriver protocol (JSON over HTTP), with nothing but Python's standard library. PICTURE: a screenshot is kept there.
"""
import base64
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import urllib.request

CHROMIUM_FLAGS = ["--headless=new", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
                  "--disable-component-update", "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader",
                  "--enable-unsafe-swiftshader", "--window-size=1440,1000"]


class Browser:
    """A session of chromedriver."""

    def __init__(self, profile, flags=()):
        self.driver = subprocess.Popen(["chromedriver", "--port=0"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        for line in self.driver.stdout:
            if port := re.search(r"successfully on port (\d+)", line):
                self.address = f"http://127.0.0.1:{port.group(1)}"
                break
        options = {"binary": "/usr/bin/chromium", "args": CHROMIUM_FLAGS + [*flags, f"--user-data-dir={profile}"]}
        self.session = ""
        wanted = {"capabilities": {"alwaysMatch": {"goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"}}}}
        self.session = "/session/" + self.call("POST", "/session", wanted)["sessionId"]

    def call(self, method, path, body=None):
        request = urllib.request.Request(self.address + self.session + path, method=method,
                                         data=None if body is None else json.dumps(body).encode(),
                                         headers={"Content-Type": "application/json"})
        with urllib.request.urlopen(request, timeout=120) as answer:
            return json.load(answer)["value"]

    def open(self, url):
        self.call("POST", "/url", {"url": url})

    def run(self, script, *arguments):
        return self.call("POST", "/execute/sync", {"script": script, "args": list(arguments)})

    def click(self, selector):
        found = self.call("POST", "/element", {"using": "css selector", "value": selector})
        self.call("POST", f"/element/{next(iter(found.values()))}/click", {})

    def errors(self):
        return [entry["message"] for entry in self.call("POST", "/se/log", {"type": "browser"}) if entry["level"] == "SEVERE"]

    def close(self):
        try:
            self.call("DELETE", "")
        finally:
            self.driver.terminate()


failures = []


def check(holds, what):
    print(("ok    " if holds else "FAIL  ") + what)
    if not holds:
        failures.append(what)


def start(browser, report):
    browser.open(report.as_uri())
    deadline = time.monotonic() + 60
    while browser.run("return document.documentElement.dataset.ready") != "true" and time.monotonic() < deadline:
        time.sleep(0.2)
    check(browser.run("return document.documentElement.dataset.ready") == "true", "the page starts")


def browse_without_webgl(browser, report):
    start(browser, report)
    check(browser.run("return document.querySelector('#view canvas') === null && document.querySelector('#view img').naturalWidth > 300"),
          "a picture stands where WebGL is missing")
    check(browser.run("return document.querySelectorAll('#decisions table tr.chosen').length > 0"), "decisions are listed there too")
    browser.click("#decisions > li:first-child button.jump")
    check(browser.run("return now < duration"), "a decision leads to its time there too")


def browse(browser, report, picture):
    start(browser, report)
    check(browser.run("return document.querySelectorAll('#view canvas').length") == 1, "the cell is drawn with WebGL")
    colours = browser.run("""
        const source = document.querySelector('#view canvas'), copy = document.createElement('canvas');
        copy.width = 160; copy.height = 100;
        const context = copy.getContext('2d');
        context.drawImage(source, 0, 0, 160, 100);
        const pixels = context.getImageData(0, 0, 160, 100).data, colours = new Set();
        for (let i = 0; i < pixels.length; i += 4) colours.add((pixels[i] >> 4) << 8 | (pixels[i + 1] >> 4) << 4 | pixels[i + 2] >> 4);
        return colours.size""")
    check(colours > 20, f"the drawing shows something ({colours} colours)")
    placements = browser.run("return document.querySelectorAll('#placements tbody tr').length")
    check(placements == browser.run("return run.placements.length") and placements > 0, f"{placements} placements are listed")
    decisions = browser.run("return document.querySelectorAll('#decisions > li').length")
    check(decisions == browser.run("return run.decisions.length") and decisions > 0, f"{decisions} decisions are listed")
    check(browser.run("return document.querySelectorAll('#stages .bar').length") == 5, "five stages have their times")
    check(browser.run("return document.querySelector('#costs svg circle') !== null"), "the paper's figure 5 is drawn")
    check(browser.run("return run.samples.length > 1000 && duration > 5"), "the motion of the arm was recorded")
    check(browser.run("return run.carries.length > 0"), "stones are carried")

    end = browser.run("return document.getElementById('clock').textContent")
    browser.click("#decisions > li:first-child button.jump")
    begin = browser.run("return document.getElementById('clock').textContent")
    check(begin != end, f"a decision leads to its time ({begin})")
    arm = browser.run("return scene.arm.tool.getWorldPosition(new THREE.Vector3()).toArray()")
    browser.run("show(duration / 2)")
    moved = browser.run("return scene.arm.tool.getWorldPosition(new THREE.Vector3()).toArray()")
    check(max(abs(a - b) for a, b in zip(arm, moved)) > 0.01, "the arm moves with time")
    placed = browser.run("return Math.max(...run.placements.map(p => p.level))")
    browser.run("show(duration)")
    heights = browser.run("return scene.stones.filter(s => s.visible).map(s => s.position.z)")
    check(len(heights) > 0 and (placed < 2 or max(heights) > 0.06), "stones stand upon each other at the end")
    browser.click("#layer-contacts")
    check(browser.run("return scene.layers.contacts.visible && scene.layers.contacts.children.length > 2"), "contacts are a layer")
    browser.click("#layer-candidates")
    browser.click("#decisions > li:first-child button.jump")
    check(browser.run("return scene.layers.candidates.visible && scene.layers.candidates.children.length > 0"),
          "candidate poses are a layer")
    browser.run("show(duration)")
    browser.click("#layer-mass")
    check(browser.run("return scene.layers.mass.visible && scene.layers.mass.children.length > 1"),
          "centres of mass and thrust line are a layer")
    browser.click("#layer-detections")
    check(browser.run("""
        const balls = scene.layers.detections.children.filter((part) => part.userData.sigma);
        return scene.layers.detections.visible && balls.length > 0 &&
            balls.every((ball) => ball.userData.sigma.every((mm) => mm > 0.005 && mm < 20) && ball.userData.turn > 0)"""),
          "detections are a layer, with their uncertainty")
    browser.click("#layer-cloud")
    check(browser.run("""
        const [points] = scene.layers.cloud.children;
        const p = points ? points.geometry.attributes.position : {count: 0};
        return scene.layers.cloud.visible && p.count > 500 && Array.from(p.array).every((x) => Math.abs(x) < 3)"""),
          "the points of the camera are a layer")
    compared = browser.run("""
        const places = run.decisions.filter((d) => d.candidates.some((c) => c.chosen));
        return places.map((d) => d.candidates.length)""")
    loose = browser.run("return run.present")
    check(len(compared) >= placed and all(count == 6 for count in compared[:max(1, loose - 2)]),
          f"the chosen placement stands beside the next five ({compared})")
    check(browser.run("""
        const tables = [...document.querySelectorAll('#decisions table')];
        return tables.length > 0 && tables.every((table) => table.querySelectorAll('tr.chosen').length === 1 &&
            [...table.querySelectorAll('tbody tr:not(.chosen)')].every((row) => row.children[1].textContent.length > 5))"""),
          "each that was not chosen says why")
    if browser.run("return run.decisions.some((d) => d.terms.includes('joint_cover'))"):
        check(browser.run("""
            const heads = [...document.querySelectorAll('#decisions th')].map((head) => head.textContent);
            return ['course', 'joint cover mm', 'fill', 'margin g', 'worth'].every((name) => heads.includes(name))"""),
              "a wall has the terms of its own")
        check(browser.run("return run.towers.some((t) => t.centres.length > 2 && t.thrust.length >= 2 * t.centres.length)"),
              "the thrust lines of a wall branch")
    browser.click("#layer-support")
    browser.run("show(run.decisions.find((d) => d.candidates.some((c) => c.chosen && c.support.length)).t)")
    check(browser.run("return scene.layers.support.visible && scene.layers.support.children.length > 0"),
          "the support polygon is a layer")
    check(browser.run("return run.decisions.some((d) => d.candidates.length > 1 && d.why.some((w) => w.includes('expected to stand')))"),
          "a decision says why it was preferred")
    for layer in ("mass", "detections", "cloud", "support"):
        browser.click("#layer-" + layer)
    browser.click("#play")
    time.sleep(1.0)
    check(browser.run("return playing && now") > 0, "the run plays")
    browser.click("#play")
    check(browser.run("""
        const page = document.documentElement;
        return page.scrollWidth <= page.clientWidth"""), "nothing is cut off at the right")
    if picture:
        browser.run("""
            show(duration);
            document.querySelector('#layer-candidates').click();
            document.querySelector('#layer-mass').click();
            document.querySelectorAll('#decisions details')[1].open = true;""")
        pathlib.Path(picture).write_bytes(base64.b64decode(browser.call("GET", "/screenshot")))
    check(browser.errors() == [], "the console shows no error")


def main():
    report = pathlib.Path(sys.argv[1]).resolve()
    size = report.stat().st_size / 1e6
    check(size <= 6.0, f"{size:.2f} MB")
    check(not re.search(r"(src|href)\s*=\s*[\"']https?:", report.read_text()), "nothing is loaded from a network")
    for flags, look in (((), lambda browser: browse(browser, report, sys.argv[2] if len(sys.argv) > 2 else None)),
                        (("--disable-3d-apis",), lambda browser: browse_without_webgl(browser, report))):
        with tempfile.TemporaryDirectory() as profile:
            browser = Browser(profile, flags)
            try:
                look(browser)
            finally:
                browser.close()
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())

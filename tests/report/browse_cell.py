#!/usr/bin/env python3
"""Opens the page of a cell in headless Chromium and clicks through it, with and without WebGL.

browse_cell.py STONESTACK FOLDER [CELL]: exit code 0 if every check holds. Screenshots are kept in FOLDER.
"""
import base64
import pathlib
import re
import subprocess
import sys
import tempfile
import time

import browse_report
from browse_report import Browser, check, failures

STONESTACK = pathlib.Path(sys.argv[1]).resolve()
FOLDER = pathlib.Path(sys.argv[2]).resolve()
CELL = sys.argv[3] if len(sys.argv) > 3 else "practice-ur10"


def open_page(browser, page):
    browser.open(page.as_uri())
    deadline = time.monotonic() + 60
    while browser.run("return document.documentElement.dataset.ready") != "true" and time.monotonic() < deadline:
        time.sleep(0.2)
    check(browser.run("return document.documentElement.dataset.ready") == "true", "the page starts")


def keep(browser, name):
    (FOLDER / name).write_bytes(base64.b64decode(browser.call("GET", "/screenshot")))


def browse(browser, page):
    open_page(browser, page)
    check(browser.run("return document.querySelectorAll('#view canvas').length") == 1, "the cell is drawn with WebGL")
    check(browser.run("return document.querySelectorAll('#findings > li').length === run.findings.length"), "findings are listed")
    check(browser.run("return document.querySelectorAll('#numbers tbody tr').length === run.numbers.length"), "numbers are listed")
    keep(browser, "start.png")
    tip = "return cell.arm.tool.getWorldPosition(new THREE.Vector3()).toArray()"
    start = browser.run(tip)
    browser.click("#pose-1")
    check(max(abs(a - b) for a, b in zip(start, browser.run(tip))) > 0.01, "the arm moves to the view of the field")
    check(browser.run("return document.getElementById('caption').textContent").startswith("view of the field"), "the pose is named")
    keep(browser, "view.png")
    for layer in ("arm", "reach", "camera", "names", "workspace", "fence"):
        group = "cell.arm.base" if layer == "arm" else f"cell.layers.{layer}"
        check(browser.run(f"return {group}.visible"), f"{layer} is shown")
        browser.click(f"#layer-{layer}")
        check(not browser.run(f"return {group}.visible"), f"{layer} can be hidden")
    check(browser.run("return document.getElementById('layer-obstacles') === null"), "there is no layer of what there is none of")
    check(browser.run("const page = document.documentElement; return page.scrollWidth <= page.clientWidth"), "nothing is cut off at the right")
    check(browser.errors() == [], "the console shows no error")


def browse_without_webgl(browser, page):
    open_page(browser, page)
    check(browser.run("return document.querySelectorAll('#view img').length") == 1, "without WebGL there is a picture")
    check(browser.run("return document.querySelector('#view img').naturalWidth") == 1200, "the picture can be read")
    keep(browser, "without_webgl.png")


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    page = FOLDER / "cell.html"
    subprocess.run([STONESTACK, "view", CELL, "--out", page], check=True, stdout=subprocess.DEVNULL)
    check(not re.search(r"(src|href)\s*=\s*[\"']https?:", page.read_text()), "nothing is loaded from a network")
    for visit, flags in ((browse, []), (browse_without_webgl, ["--disable-3d-apis"])):
        usual = browse_report.CHROMIUM_FLAGS
        browse_report.CHROMIUM_FLAGS = usual + flags
        with tempfile.TemporaryDirectory() as profile:
            browser = Browser(profile)
            try:
                visit(browser, page)
            finally:
                browser.close()
        browse_report.CHROMIUM_FLAGS = usual
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())

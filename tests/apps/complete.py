#!/usr/bin/env python3
"""Completes commands in real shells and renders the manual pages.

complete.py STONESTACK SHARE: SHARE is the folder of `stonestack pages`. Exit code 0 if every check holds. Shells and
renderers that are not installed are left out, but for bash.
"""
import os
import pathlib
import pty
import re
import select
import shutil
import subprocess
import sys
import time

STONESTACK = pathlib.Path(sys.argv[1]).resolve()
SHARE = pathlib.Path(sys.argv[2]).resolve()
# what is typed, and what stands there after TAB
CASES = [("stonestack sea", "stonestack search"),
         ("stonestack run --exe", "stonestack run --execute"),
         ("stonestack search --method pa", "stonestack search --method paper"),
         ("stonestack search --method=pa", "stonestack search --method=paper"),
         ("stonestack run --seed 3 -q --cat", "stonestack run --seed 3 -q --catalogue"),
         ("stonestack config sh", "stonestack config show"),
         ("stonestack config show --ori", "stonestack config show --origin"),
         ("stonestack run --set search.frict", "stonestack run --set search.friction="),
         ("stonestack detect here/only_fi", "stonestack detect here/only_file"),
         ("stonestack completion f", "stonestack completion fish")]
failures = []


def check(holds, what):
    print(("ok    " if holds else "FAIL  ") + what)
    if not holds:
        failures.append(what)


class Terminal:
    """A shell on a terminal."""

    def __init__(self, command, folder):
        environment = {"PATH": f"{STONESTACK.parent}:/usr/bin:/bin", "HOME": str(folder), "TERM": "vt100", "PS1": "$ ", "LC_ALL": "C.UTF-8"}
        pid, self.terminal = pty.fork()
        if pid == 0:
            os.chdir(folder)
            os.execvpe(command[0], command, environment)
        self.pid = pid

    def read(self, until, seconds=20):
        """Everything shown until that appears, without control sequences; shells redraw what they complete."""
        shown, deadline = b"", time.monotonic() + seconds
        while time.monotonic() < deadline:
            if select.select([self.terminal], [], [], 0.1)[0]:
                try:
                    shown += os.read(self.terminal, 65536)
                except OSError:
                    break
            text = re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]|\x1b[=>]|\x07", "", shown.decode(errors="replace"))
            if until in text:
                return text
        return text

    def send(self, text):
        os.write(self.terminal, text.encode())

    def close(self):
        self.send("\x15exit\n")
        os.close(self.terminal)
        os.waitpid(self.pid, 0)


def in_terminal(shell, command, set_up, folder):
    terminal = Terminal(command, folder)
    terminal.send(set_up + "; echo rea''dy\n")
    check("ready" in terminal.read("ready\r\n"), f"{shell} takes the script")
    for typed, completed in CASES:
        terminal.send(typed + "\t")
        shown = terminal.read(completed)
        check(completed in shown, f"{shell}: {typed}<TAB> -> {completed}" + ("" if completed in shown else f", not {shown!r}"))
        terminal.send("\x15echo cle''ar\n")
        terminal.read("clear\r\n")
    terminal.close()


def in_fish(folder):
    script = SHARE / "fish/vendor_completions.d/stonestack.fish"
    for typed, completed in CASES:
        answer = subprocess.run(["fish", "--no-config", "-c", f"source {script}; complete -C '{typed}'"], cwd=folder, capture_output=True,
                                text=True, env={**os.environ, "HOME": str(folder), "PATH": f"{STONESTACK.parent}:{os.environ['PATH']}"})
        offers = [line.split("\t")[0] for line in answer.stdout.splitlines()]
        word = completed.split(" ")[-1]
        check(word in offers and not answer.stderr, f"fish: {typed}<TAB> -> {completed}" + ("" if word in offers else f", not {offers} {answer.stderr}"))


def help_of(*words):
    return subprocess.run([STONESTACK, *words, "--help"], capture_output=True, text=True, check=True).stdout


def subcommands(text):
    return re.findall(r"^  (\w+)  ", text.split("Subcommands:")[1].split("\n\n")[0], re.M) if "Subcommands:" in text else []


def check_page(words):
    page = SHARE / "man/man1" / ("-".join(["stonestack", *words]) + ".1")
    check(page.is_file(), f"{page.name} is there")
    if not page.is_file():
        return
    renderers = {"groff": ["groff", "-man", "-Tutf8", "-ww", str(page)], "man": ["man", "--warnings", "-l", str(page)],
                 "mandoc": ["mandoc", "-Tutf8", "-Wwarning", str(page)]}
    for name, command in renderers.items():
        if not shutil.which(name):
            continue
        rendered = subprocess.run(command, capture_output=True, text=True, env={**os.environ, "LC_ALL": "C.UTF-8", "MANWIDTH": "100"})
        check(rendered.returncode == 0 and rendered.stderr == "", f"{name} renders {page.name}" + ("" if not rendered.stderr else f": {rendered.stderr[:300]}"))
        text = re.sub(r"\x1b\[[0-9;]*m|.\x08", "", rendered.stdout).replace("‐", "-").replace("−", "-")
        text = re.sub(r"\s+", " ", text)
        lines = re.findall(r"^  (-\S+)", help_of(*words), re.M)
        missing = [option for line in lines for option in line.split(",") if not re.search(re.escape(option) + r"(?![\w-])", text)]
        check(lines and not missing, f"{name}: {page.name} has all {len(lines)} options{missing if missing else ''}")


def main():
    folder = SHARE.parent / "completion_test"
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "here").mkdir(parents=True)
    (folder / "here/only_file").write_text("")
    in_terminal("bash", ["bash", "--norc", "--noprofile", "-i"], f"source {SHARE}/bash-completion/completions/stonestack", folder)
    if shutil.which("zsh"):
        in_terminal("zsh", ["zsh", "-f", "-i"], f"PS1='$ '; fpath=({SHARE}/zsh/vendor-completions $fpath); autoload -Uz compinit; compinit -u -D", folder)
    if shutil.which("fish"):
        in_fish(folder)
    check_page([])
    for command in subcommands(help_of()):
        check_page([command])
        for below in subcommands(help_of(command)):
            check_page([command, below])
    for shell, file in (("bash", "bash-completion/completions/stonestack"), ("zsh", "zsh/vendor-completions/_stonestack"),
                        ("fish", "fish/vendor_completions.d/stonestack.fish")):
        printed = subprocess.run([STONESTACK, "completion", shell], capture_output=True, text=True, check=True).stdout
        check(printed == (SHARE / file).read_text(), f"`completion {shell}` prints what is installed")
    shutil.rmtree(folder, ignore_errors=True)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())

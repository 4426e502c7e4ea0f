"""What libstonestack exports is what its public headers declare: python3 exports.py ROOT LIBRARY

Everything else has hidden visibility. A private symbol that is exported is one that another binary may replace.
"""

import pathlib
import re
import subprocess
import sys


def main(root, library):
    declared = set()
    for header in (root / "include").rglob("*.hpp"):
        declared |= set(re.findall(r"[A-Za-z_]\w*", header.read_text(encoding="utf-8")))
    lines = subprocess.run(["nm", "-DC", "--defined-only", library], capture_output=True, text=True, check=True).stdout
    own, foreign = set(), set()
    for line in lines.splitlines():
        symbol = line.split(" ", 2)[-1]
        symbol = re.sub(r"^(vtable|typeinfo|typeinfo name|VTT|guard variable|non-virtual thunk|.*thunk) (for|to) ", "", symbol)
        name = re.match(r"(?:[\w:<>,*& ]+ )?(stonestack::[\w:~]+)", symbol)
        if name and not re.match(r"[^(]*\bstd::", symbol):
            own.add(name.group(1))
            room, first = (name.group(1).split("::")[1:] + [""])[:2]  # what a class holds is as visible as the class
            if room not in declared or (first not in declared and not first.startswith("operator")):
                foreign.add(symbol)
    if len(own) < 100:
        sys.exit(f"only {len(own)} names of stonestack are exported: do public headers make theirs visible?")
    if foreign:
        sys.exit("exported, but in no public header:\n" + "\n".join(sorted(foreign)[:50]))
    print(f"{len(own)} names are exported, each of a public header")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]), sys.argv[2])

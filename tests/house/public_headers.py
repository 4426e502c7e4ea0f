"""The public headers are few, and each has a user: python3 public_headers.py ROOT

A header in include/stonestack is one that a program outside the library needs: the command and the examples include it,
the umbrella brings it, or another public header needs it. What only the library uses lies in src. The command includes
nothing of src: it is a user like any other.
"""

import pathlib
import re
import sys

MOST = 45


def included(path):
    return set(re.findall(r'^\s*#\s*include\s+["<]([^">]+)[">]', path.read_text(encoding="utf-8"), re.M))


def sources(folder):
    return [path for path in sorted(folder.rglob("*")) if path.suffix in (".hpp", ".cpp")]


def problems_of(root):
    public = {str(path.relative_to(root / "include")): included(path) for path in sources(root / "include")}
    problems = []
    if len(public) > MOST:
        problems.append(f"{len(public)} public headers, at most {MOST}")
    reached, ahead = set(), ["stonestack/stonestack.hpp"]
    for path in sources(root / "apps") + sources(root / "examples"):
        ahead += included(path)
        problems += [
            f"{path.relative_to(root)} includes {name}, which is not public"
            for name in included(path)
            if (root / "src" / name).exists() and not (path.parent / name).exists()
        ]
    while ahead:
        name = ahead.pop()
        if name in public and name not in reached:
            reached.add(name)
            ahead += public[name]
    problems += [f"include/{name} is used by no program" for name in sorted(set(public) - reached)]
    for name, names in public.items():
        problems += [f"include/{name} includes {other}, which is not public" for other in sorted(names) if (root / "src" / other).exists()]
    return len(public), problems


def main(root):
    count, problems = problems_of(root)
    if count < 20:
        sys.exit(f"only {count} public headers below {root}: is ROOT right?")
    if problems:
        sys.exit("\n".join(problems))
    print(f"{count} public headers, each with a user")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))

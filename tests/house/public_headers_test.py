"""Tests public_headers.py on trees that break each of its rules: python3 public_headers_test.py"""

import pathlib
import sys
import tempfile

import public_headers


def problems_of(files):
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for name, text in files.items():
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_text(text, encoding="utf-8")
        return public_headers.problems_of(root)[1]


def main():
    good = {
        "include/stonestack/stonestack.hpp": '#include "stonestack/a/a.hpp"\n',
        "include/stonestack/a/a.hpp": "",
        "include/stonestack/a/b.hpp": "",
        "apps/main.cpp": '#include "stonestack/a/b.hpp"\n#include "main.hpp"\n',
        "apps/main.hpp": "",
        "src/a/inner.hpp": "",
    }
    bad = {
        "is used by no program": {"include/stonestack/a/c.hpp": '#include "stonestack/a/a.hpp"\n'},
        "apps/main.cpp includes a/inner.hpp": {"apps/main.cpp": good["apps/main.cpp"] + '#include "a/inner.hpp"\n'},
        "include/stonestack/a/a.hpp includes a/inner.hpp": {"include/stonestack/a/a.hpp": '#include "a/inner.hpp"\n'},
        "48 public headers": {
            "include/stonestack/stonestack.hpp": "".join(f'#include "stonestack/a/{k}.hpp"\n' for k in ["a", *range(45)]),
            **{f"include/stonestack/a/{k}.hpp": "" for k in range(45)},
        },
    }
    if found := problems_of(good):
        sys.exit(f"complains of a tree in order: {found}")
    for expected, files in bad.items():
        found = problems_of({**good, **files})
        if len(found) != 1 or expected not in found[0]:
            sys.exit(f"expected '{expected}', got {found}")


if __name__ == "__main__":
    main()

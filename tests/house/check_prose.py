"""check_prose.py ROOT: plain English in docstrings and documents (CONTRIBUTING.md, "Plain English").

Fails on docstrings that begin with That, What, Who, Those, The same or a unit, and on names of tests that begin so; on words for which the field has a
standard term (WORDS, but ALLOWED) in names, comments, messages and documents; on references to files that are not in
the repository; on words of a lab notebook in documents; on documents wider than they should be.
"""
import pathlib
import re
import sys

BAD_START = re.compile(r"^(That|What|Who|Whom|Whose|Those|The same)\b")
UNITS = r"(?:m|mm|s|ms|us|rad|deg|kg|N|Nm|Hz|px|J|N s|m/s|rad/s|m\^2|m\^3|kg/m\^3|N/m|kg m)"
BARE_UNIT = re.compile(r"^" + UNITS + r"(?:[\s,;:.]|$)")
# word as a pattern: the standard term. Words in English and in names: `hand` is found in grip_hand and HandPose, not in handle.
NAME = r"(?<![A-Za-z])(?:%s)(?![a-z])"
WORDS = {
    NAME % "[Hh]ands?": "gripper",
    NAME % "[Bb]elie(?:fs?|ve[sd]?)": "estimate, assumed",
    NAME % "[Oo]urs": "design choice",
    NAME % "[Dd]oubt(?:s|ed)?": "uncertainty",
    NAME % "[Mm]end(?:s|ed|ing)?": "repair, correct",
    NAME % "[Ss]teadied|[Ss]eated|[Oo]utlook": "settled, expected height",
    NAME % "[Ww]ay[ _-]points?": "waypoint",
    r"\bposes? of rest\b": "resting pose",
    r"\bto the letter\b": "exactly",
    r"\b(?:the|each|every|a) look\b(?!-)": "view, observation",
    r"\b(?:turn(?:s|ed|ing)? over the|turned over)\b": "reorient",
    r"\b(?:least|most|largest|smallest)_(?!squares\b|likely\b|violated\b)\w+|\bk(?:Least|Most|Largest|Smallest)[A-Z]\w*": "min_x, max_x",
    r"\b(?:outside|tool|no|has)_room\b|\bToolRoom\b": "workspace, clearance",
}
# standard terms, keys of files and schemas that keep their name, and names of random streams
ALLOWED = re.compile(r"[Hh]and[-_ /]?[Ee]ye|[Ee]ye[-_ ]in[-_ ][Hh]and|kOnHand|OnHand|on_hand|[Bb]y[ _]?[Hh]and|HandBy|right[- _][Hh]and|other hand|first hand"
                     r"|Random::stream\(.*|\"(?:hand|doubt)\"|\b[ab]: '?hands?|'hands'|arm, `?hand`?, `?held|`?hand `?(?:none|robotiq_3f|claw)"
                     r"|hand '|[Rr]obotiq[-_][Hh]and[-_][Ee]|Hand-E|gripper\.hand|\bhand: ?(?:NAME|FILE|robotiq|\\?\"|`)|`hand`|hand: FILE|^hand none|\"believed pose\"|\"steadied\"|\"paths of ten way points\"")
TEST_NAME = re.compile(r"^TEST(?:_[FP])?\(\w+,\s*((?:What|Who|Whom|Whose|Those|That|Nobody)[A-Z]\w*)")
REFERENCE = re.compile(r"((?<![/\w])(?:docs|facts|cmake|tests|src|include|apps|benchmarks|examples)/[\w./-]*\.(?:md|cpp|hpp|cmake|txt|yaml|png|py))\b")
NOTEBOOK = re.compile(r"(the day before|machine (?:was )?shared|a load of \d|beside (?:builds|tests|other work)|scratch (?:program|build|library)"
                      r"|looked at before|never looked at|\bhelpers?'? (?:build|work))", re.IGNORECASE)


def docstrings(path):
    """(line number, text) of each block of /// lines, and of each ///< comment."""
    block = None
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        after = re.search(r"///<\s*(.*)", line)
        if after:
            yield number, after.group(1)
            block = None
            continue
        start = re.match(r"\s*///\s?(.*)", line)
        if start and block is None and start.group(1).strip():
            yield number, start.group(1).strip()
        block = True if start else None


TERMS = [(re.compile(word), term) for word, term in WORDS.items()]


def bad_start(text):
    """True for a docstring that does not begin with a noun or a verb."""
    return bool(BAD_START.match(text) or BARE_UNIT.match(text))


def bad_test_name(line):
    """Name of a test whose name does not begin with its subject; None: there is none."""
    found = TEST_NAME.match(line)
    return found.group(1) if found else None


def bad_words(line):
    """(word, standard term) of each word of a line that has a standard term."""
    line = ALLOWED.sub(" ", line)
    return [(found.group(0), term) for word, term in TERMS if (found := word.search(line))]


def main(root):
    faults = []
    sources = [p for top in ("include", "src", "apps", "benchmarks", "mpi", "examples", "tests") for p in sorted((root / top).rglob("*"))
               if p.suffix in (".hpp", ".cpp")]
    documents = sorted(root.glob("*.md")) + sorted((root / "docs").glob("*.md"))
    if len(sources) < 100 or not documents:
        sys.exit(f"only {len(sources)} sources and {len(documents)} documents below {root}: is ROOT right?")
    for path in sources:
        for number, text in docstrings(path):
            if bad_start(text):
                faults.append(f"{path.relative_to(root)}:{number}: a docstring begins with '{text[:40]}': begin with a noun or a verb")
    for path in sources:
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            if name := bad_test_name(line):
                faults.append(f"{path.relative_to(root)}:{number}: a test is called {name}: begin with its subject")
    for path in sources + documents:
        if path.name == "CHANGELOG.md":
            continue
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            faults += [f"{path.relative_to(root)}:{number}: '{word}': the standard term is: {term}" for word, term in bad_words(line)]
    for path in sources + documents:
        base = path.parent
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            for name in REFERENCE.findall(line):
                if not any((top / name).exists() for top in (root, root / "include/stonestack", root / "src", base)):
                    faults.append(f"{path.relative_to(root)}:{number}: there is no {name}")
            if path.suffix == ".md" and path.name != "CHANGELOG.md" and NOTEBOOK.search(line):
                faults.append(f"{path.relative_to(root)}:{number}: sounds like a lab notebook: {NOTEBOOK.search(line).group(0)}")
    readme = (root / "README.md").read_text(encoding="utf-8").splitlines()
    if len(readme) > 150:
        faults.append(f"README.md has {len(readme)} lines: 150 at most")
    faults += [f"README.md:{n}: {len(line)} columns: 120 at most" for n, line in enumerate(readme, 1) if len(line) > 120]
    for example in sorted((root / "examples").glob("*.cpp")):
        length = len(example.read_text(encoding="utf-8").splitlines())
        if length > 60:
            faults.append(f"{example.relative_to(root)} has {length} lines: 60 at most")
    if faults:
        sys.exit("\n".join(faults) + f"\n{len(faults)} faults of prose")
    print(f"{len(sources)} sources and {len(documents)} documents read")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))

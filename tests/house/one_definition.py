"""One definition of every name: python3 one_definition.py ROOT

Collects what the sources of each program define with external linkage at namespace scope (types, aliases, inline
variables, functions with their parameter types), namespace by namespace, and fails when two files define the same.
A compiler and a linker need not notice: of two classes with one name, one destructor is linked for both.

Beside these, functions of anonymous namespaces: files of one room may be compiled together, and then a call of one
takes the function of the other where its argument fits that better (a literal for `const char*`, not for a string).

The library and the command are one program; each folder of tests is one with the library, each fuzz target, too.
"""

import pathlib
import re
import sys

TOKEN = re.compile(
    r"""
    //[^\n]* | /\*.*?\*/ | ^[ \t]*\#(?:[^\n\\]|\\\n|\\.)*   # comments, preprocessor
  | (?P<raw>R"(?P<mark>[^()\s]*)\(.*?\)(?P=mark)")
  | (?P<text>"(?:[^"\\\n]|\\.)*" | '(?:[^'\\\n]|\\.)')
  | (?P<word>[A-Za-z_]\w*) | (?P<number>\.?\d(?:[\w.']|[eEpP][+-])*)
  | (?P<sign>::|->|&&|[^\s])
""",
    re.X | re.S | re.M,
)
OPEN, CLOSE = {"(", "[", "{"}, {")", "]", "}"}
ALTERNATIVE = "realsense_library.cpp"  # in place of realsense_absent.cpp, where the build has the library
IMPORTER = "import_program.cpp"  # a program of its own
TEXTS = {"const char *", "std :: string", "const std :: string &", "std :: string &&", "std :: string_view"}
NUMBERS = {"int", "long", "unsigned", "double", "float", "bool", "char", "std :: size_t"}
TYPE_WORDS = {"const", "unsigned", "signed", "int", "long", "short", "double", "float", "bool", "char", "auto", "void"}


def tokens_of(text):
    return [m.group() for m in TOKEN.finditer(text) if m.lastgroup and m.group().strip()]


def closing(tokens, i):
    """Index of the bracket that closes the one at i."""
    depth = 0
    for k in range(i, len(tokens)):
        if tokens[k] in OPEN:
            depth += 1
        elif tokens[k] in CLOSE:
            depth -= 1
            if depth == 0:
                return k
    return len(tokens) - 1


def after_angle(tokens, i):
    """Index after the template argument or parameter list that starts at i."""
    depth = 0
    while i < len(tokens):
        if tokens[i] == "<":
            depth += 1
        elif tokens[i] == ">":
            depth -= 1
            if depth == 0:
                return i + 1
        elif tokens[i] in OPEN:
            i = closing(tokens, i)
        i += 1
    return i


def without_prefix(tokens):
    """Without template<...>, requires (...) and attributes in front; and whether it is a template."""
    i, template = 0, False
    while i < len(tokens):
        if tokens[i] == "template":
            template, i = True, after_angle(tokens, i + 1)
            if tokens[i - 1 : i] != [">"]:
                i += 1
        elif tokens[i] == "requires" and tokens[i + 1 : i + 2] == ["("]:
            i = closing(tokens, i + 1) + 1
        elif tokens[i] == "[":
            i = closing(tokens, i) + 1
        elif tokens[i] in ("__attribute__", "alignas"):
            i = closing(tokens, i + 1) + 1
        else:
            break
    return tokens[i:], template


def parameter_types(tokens):
    """Types of a parameter list, without names and default values."""
    parts, part, i = [], [], 0
    depth = 0
    while i < len(tokens):
        token = tokens[i]
        depth += (token == "<" or token in OPEN) - (token == ">" or token in CLOSE)
        if token == "," and depth == 0:
            parts.append(part)
            part = []
        else:
            part.append(token)
        i += 1
    types = []
    for part in parts + [part]:
        part = part[: part.index("=")] if "=" in part else part
        named = len(part) > 1 and re.match(r"[A-Za-z_]\w*$", part[-1]) and part[-1] not in TYPE_WORDS
        if named and part[-2] != "::" and part[-2] != "const":
            part = part[:-1]
        types.append(" ".join(part))
    return ", ".join(types)


def definition_of(head, has_body):
    """(kind, name, detail) of a declaration at namespace scope, or None: what it defines with external linkage."""
    head, template = without_prefix(head)
    if not head or head[0] in ("friend", "static_assert", "namespace", "extern"):
        return None
    if head[0] == "using":
        head, _ = [head[0]] + without_prefix(head[1:])[0], None
        if len(head) > 3 and head[2] == "=":
            return ("alias", head[1], " ".join(head[3:]))
        return None
    if head[0] in ("struct", "class", "union", "enum"):
        i = 1
        if head[0] == "enum" and head[i : i + 1] in (["class"], ["struct"]):
            i += 1
        rest, _ = without_prefix(head[i:])
        while len(rest) > 1 and re.match(r"[A-Z_]+$", rest[0]) and re.match(r"[A-Za-z_]", rest[1]) and rest[1] != "final":
            rest = rest[1:]  # an export macro
        name = rest[0] if rest else ""
        plain = len(rest) < 2 or rest[1] in (":", "final")
        if has_body and plain and re.match(r"[A-Za-z_]\w*$", name):
            return ("type", name, "")
        if has_body and rest[1:2] in (["<"], ["::"]):
            return ("type", " ".join(rest[: rest.index(":")] if ":" in rest else rest), "")
        if not (len(rest) > 1 and "(" in rest):
            return None
    if "static" in head:
        return None
    k = head.index("(") if "(" in head else -1
    equals = head.index("=") if "=" in head else len(head)
    if "operator" in head:
        k = head.index("(", head.index("operator") + (3 if head[head.index("operator") + 1] == "(" else 1))
        equals = len(head)
    if 0 < k < equals and has_body:
        name = head[k - 1]
        first = k - 1
        if "operator" in head[:k]:
            first = head.index("operator")
            name = " ".join(head[first:k])
        while first >= 2 and head[first - 1] == "::":
            first -= 2
            if head[first] == ">":
                return None  # member of a template's specialisation
        name = " ".join(head[first:k]).replace(" ", "")
        end = closing(head, k)
        const = " const" if head[end + 1 : end + 2] == ["const"] else ""
        return ("function", name, "(" + parameter_types(head[k + 1 : end]) + ")" + const + (" template" if template else ""))
    if "inline" in head and (equals < len(head) or has_body):
        return ("variable", head[equals - 1] if equals < len(head) else head[-1], "")
    return None


def definitions(text, hidden=False):
    """All of a file: [(namespace, kind, name, detail)]; `hidden`: those of its anonymous namespaces instead."""
    tokens = tokens_of(text)
    found, scope, head, i = [], [], [], 0
    while i < len(tokens):
        token = tokens[i]
        if not head and token == "namespace" or (head == ["inline"] and token == "namespace"):
            k, name = i + 1, []
            while tokens[k] not in ("{", ";", "="):
                name.append(tokens[k])
                k += 1
            head = []
            if tokens[k] == "{":
                scope.append("".join(name) or None)
            else:
                while tokens[k] != ";":
                    k += 1
            i = k + 1
        elif token == "}" and not head:
            if scope:
                scope.pop()
            i += 1
        elif token == "{" and head[:1] == ["extern"] and len(head) == 2:
            scope.append("")
            head, i = [], i + 1
        elif token == ";" or token == "{":
            assigned = token == "{" and "=" in head and "operator" not in head and not ("(" in head and head.index("(") < head.index("="))
            entry = definition_of(head, token == "{" and not assigned)
            if assigned and "inline" in head:
                entry = definition_of(head + ["x"], False)
            if entry and (None in scope) == hidden:
                found.append(("::".join(s for s in scope if s),) + entry)
            if token == ";":
                head, i = [], i + 1
                continue
            end = closing(tokens, i)
            i = end + 1
            kind = entry[0] if entry else ""
            if kind == "function" or (not assigned and "(" in head and kind != "type"):
                if tokens[i : i + 1] == ["{"] or (tokens[i : i + 1] == [","] and ":" in head):
                    head.append("(")  # a braced member initialiser: the body follows
                    continue
                head = []
            elif tokens[i : i + 1] == [";"]:
                head, i = [], i + 1
            # else: the rest of the declaration, up to its semicolon
        elif token in OPEN:
            end = closing(tokens, i)
            head += tokens[i : end + 1]
            i = end + 1
        else:
            head.append(token)
            i += 1
    return found


def check(program, files, cache):
    """Problems among the files of one program."""
    places, problems = {}, []
    for path in files:
        if path not in cache:
            cache[path] = definitions(path.read_text(encoding="utf-8"))
        for namespace, kind, name, detail in cache[path]:
            if kind == "alias":
                key, text = (namespace, kind, name), detail
            else:
                key, text = (namespace, kind, name, detail if kind == "function" else ""), ""
            places.setdefault(key, {}).setdefault(path, text)
            if kind in ("type", "alias"):
                places.setdefault((namespace, "name", name), {}).setdefault(path, text or kind)
    for key, by_file in sorted(places.items(), key=lambda item: [str(k) for k in item[0]]):
        if len(by_file) < 2 or (key[1] in ("alias", "name") and len(set(by_file.values())) == 1):
            continue
        if key[1] == "name" and set(by_file.values()) == {"type"}:
            continue
        where = ", ".join(sorted(str(path) for path in by_file))
        problems.append(f"{program}: {key[1]} {key[0]}::{key[2]}{''.join(key[3:])} is defined in {where}")
    return problems


def convertible(one, other):
    """Whether a call may fit both parameter lists, though they differ."""
    if one == other or "template" in one + other:
        return False
    pairs = list(zip(one.strip("()").split(", "), other.strip("()").split(", ")))
    if one.count(",") != other.count(","):
        return False
    return all(a == b or {a, b} <= TEXTS or {a, b} <= NUMBERS for a, b in pairs)


def check_hidden(room, files):
    """Problems among the functions in the anonymous namespaces of one room."""
    places, problems = {}, []
    for path in files:
        for namespace, kind, name, detail in definitions(path.read_text(encoding="utf-8"), hidden=True):
            if kind == "function" and "::" not in name:
                places.setdefault((namespace, name), []).append((path, detail))
    for (namespace, name), found in sorted(places.items()):
        for k, (path, detail) in enumerate(found):
            for other, other_detail in found[:k]:
                if path != other and convertible(detail, other_detail):
                    problems.append(f"{room}: function {namespace}::{name} takes {other_detail} in {other} and {detail} in {path}")
    return problems


def sources(folder):
    return sorted(p for p in folder.rglob("*") if p.suffix in (".hpp", ".cpp") and p.name not in (ALTERNATIVE, IMPORTER))


def main(root):
    library = sources(root / "include") + sources(root / "src")
    if len(library) < 20:
        sys.exit(f"only {len(library)} files found below {root}: is ROOT right?")
    cache = {}
    problems = check("library", library, cache)
    programs = {"command": sources(root / "apps")}
    if (root / "benchmarks").exists():
        programs["benchmarks"] = sources(root / "benchmarks")
    if (root / "mpi").exists():
        programs["mpi"] = sources(root / "mpi")
    for folder in sorted(p for p in (root / "tests").iterdir() if p.is_dir() and p.name not in ("house", "fuzz")):
        programs[f"test_{folder.name}"] = [p for p in sources(folder) if "stub" not in str(p)]
    for target in sorted((root / "tests" / "fuzz").glob("fuzz_*.cpp")):
        programs[target.stem] = [target]
    for name, files in programs.items():
        problems += [p for p in check(name, library + files, cache) if not any(p.split(": ", 1)[1] == q.split(": ", 1)[1] for q in problems)]
    for folder in sorted(p for p in (root / "src").iterdir() if p.is_dir()):
        problems += check_hidden(folder.name, [p for p in sources(folder) if p.suffix == ".cpp"])
    if problems:
        sys.exit("\n".join(["More than one definition (rename one, or give it an anonymous namespace):"] + problems))
    print(f"{sum(len(found) for found in cache.values())} definitions in {len(cache)} files, each made once")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))

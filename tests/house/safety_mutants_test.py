"""The check of the safety functions' mutants finds what is wrong with a list."""
import copy
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import safety_mutants  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]


def main():
    whole = safety_mutants.read_mutants(ROOT)
    assert not list(safety_mutants.faults(ROOT, whole))

    def found(change):
        mutants = copy.deepcopy(whole)
        change(mutants)
        return "\n".join(safety_mutants.faults(ROOT, mutants))

    function = whole[0]["function"]
    assert f"{function} has no mutant" in found(
        lambda list_: list_.__setitem__(slice(None), [m for m in list_ if m["function"] != function]))
    assert "occurs 0 times" in found(lambda list_: list_[0].update({"from": "no such text"}))
    assert "occurs 0 times" in found(lambda list_: list_[0].update(file="src/nowhere.cpp"))
    assert "nothing is replaced" in found(lambda list_: list_[0].update(to=list_[0]["from"]))
    assert "there is no test No.Such" in found(lambda list_: list_[0].update(tests=["No.Such"]))
    assert "missing or unknown" in found(lambda list_: list_[0].pop("side"))
    assert "another table" in found(lambda list_: list_[0].update(statement="Something else"))


if __name__ == "__main__":
    main()

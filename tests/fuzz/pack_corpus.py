"""pack_corpus.py [--bin FOLDER [--found FOLDER]] [NAME...]: packs what libFuzzer found into corpus/NAME.tar.

A corpus has two parts: seeds with names, which people wrote (corpus/NAME/), and inputs that libFuzzer found, named by
hashes (corpus/NAME.tar). With --bin (build/fuzz/bin) the second part is minimised first: named seeds, then only what
adds a feature (libFuzzer's -merge=1); the features before and after are printed. --found (build/fuzz/found) adds what
`./dev test` found since. Files of hash names that lie in corpus/NAME/ are moved into the archive.
"""
import argparse
import io
import pathlib
import re
import shutil
import subprocess
import tarfile
import tempfile

CORPUS = pathlib.Path(__file__).resolve().parent / "corpus"
HASH = re.compile(r"[0-9a-f]{16}|[0-9a-f]{40}")


def features(program, folder):
    done = subprocess.run([program, "-runs=0", "-max_len=16384", folder], stderr=subprocess.PIPE, text=True, check=True)
    return re.search(r"cov: \d+ ft: \d+", done.stderr).group(0)


def minimised(program, named, folder, work):
    """The smallest files of `folder` that keep its features beside the named seeds."""
    kept = work / "kept"
    kept.mkdir()
    for seed in named:
        shutil.copy(seed, kept)
    log = subprocess.run([program, "-merge=1", "-max_len=16384", kept, folder], stderr=subprocess.PIPE, text=True)
    if log.returncode:
        raise SystemExit(f"{program} -merge=1 failed:\n{log.stderr[-2000:]}")
    before, after = features(program, folder), features(program, kept)
    if [int(n) for n in re.findall(r"\d+", after)] < [int(n) for n in re.findall(r"\d+", before)]:
        raise SystemExit(f"{program}: {before} would become {after}")
    print(f"  {before} -> {after}")
    return kept


def pack(name, options):
    named = sorted(p for p in (CORPUS / name).iterdir() if not HASH.fullmatch(p.name))
    loose = sorted(p for p in (CORPUS / name).iterdir() if HASH.fullmatch(p.name))
    archive = CORPUS / f"{name}.tar"
    with tempfile.TemporaryDirectory() as work:
        work = pathlib.Path(work)
        whole = work / "whole"
        whole.mkdir()
        if archive.exists():
            with tarfile.open(archive) as old:
                old.extractall(whole)
        found = pathlib.Path(options.found) / name if options.found else None
        for file in named + loose + (sorted(found.iterdir()) if found and found.is_dir() else []):
            shutil.copy(file, whole)
        count = len(list(whole.iterdir()))
        program = pathlib.Path(options.bin) / f"fuzz_{name}" if options.bin else None
        kept = minimised(program, named, whole, work) if program else whole
        inputs = sorted(p for p in kept.iterdir() if p.name not in {seed.name for seed in named})
        print(f"{name}: {count} inputs -> {len(named)} named, {len(inputs)} packed")
        if inputs:
            with tarfile.open(archive, "w", format=tarfile.USTAR_FORMAT) as new:
                for file in inputs:  # no times, no owners: the same inputs give the same archive
                    entry = tarfile.TarInfo(file.name)
                    content = file.read_bytes()
                    entry.size = len(content)
                    new.addfile(entry, io.BytesIO(content))
        elif archive.exists():
            archive.unlink()
    for file in loose:
        file.unlink()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", help="folder of the fuzz targets: minimise with them")
    parser.add_argument("--found", help="folder of newly found inputs")
    parser.add_argument("names", nargs="*", help="targets; all without")
    options = parser.parse_args()
    for name in options.names or sorted(p.name for p in CORPUS.iterdir() if p.is_dir()):
        pack(name, options)


if __name__ == "__main__":
    main()

"""Copies version and address of the repository from the Cargo.toml at the root to all other files with them.

    stamp.py                            write
    stamp.py --check                    write nothing, fail if a file is stale
    stamp.py --release TAG              the same, and fail if the checkout is not ready for the release TAG
    stamp.py --sums SHA256SUMS --out DIR
                                        the recipes of package managers with the hashes of a release

In the repository the hashes in recipes are zeros, because they are known only after the archives are built.
"""

import argparse
import pathlib
import re
import sys

import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent


def read(path: str) -> str:
    return (ROOT / path).read_text(encoding="utf-8")


PACKAGE = tomllib.loads(read("Cargo.toml"))["workspace"]["package"]
VERSION, REPOSITORY = PACKAGE["version"], PACKAGE["repository"]
ZEROS = "0" * 64
WINGET = [f"winget/{path.name}" for path in sorted((ROOT / "packaging/winget").iterdir())]
RECIPES = ["conda/recipe.yaml", "homebrew/arcmin.rb", *WINGET]

V = r"\d+\.\d+\.\d+[-+.0-9A-Za-z]*?"
# (file, pattern with one group for the value, the value)
PLACES = [
    ("crates/arcmin-py/Cargo.toml", rf'^version = "({V})"$', VERSION),
    ("crates/arcmin-py/Cargo.toml", r'^repository = "(.*)"$', REPOSITORY),
    ("crates/arcmin/Cargo.toml", rf'^arcmin-mechanics = .*version = "({V})"', VERSION),
    ("crates/arcmin-cli/Cargo.toml", rf'^arcmin = .*version = "({V})"', VERSION),
    ("crates/arcmin-fmu/Cargo.toml", rf'^arcmin = .*version = "({V})"', VERSION),
    ("CITATION.cff", rf"^version: ({V})$", VERSION),
    ("CITATION.cff", r'^repository-code: "(.*)"$', REPOSITORY),
    ("packaging/conda/recipe.yaml", rf'^  version: "({V})"$', VERSION),
    ("packaging/conda/recipe.yaml", r"^  repository: (.*)$", REPOSITORY),
    ("packaging/homebrew/arcmin.rb", rf'^  version "({V})"$', VERSION),
    ("packaging/homebrew/arcmin.rb", r'^  homepage "(.*)"$', REPOSITORY),
]
for name in WINGET:
    PLACES.append((f"packaging/{name}", rf"^PackageVersion: ({V})$", VERSION))
    if name.endswith("locale.en-US.yaml"):
        PLACES.append((f"packaging/{name}", r"^PackageUrl: (.*)$", REPOSITORY))


def stamped(path: str, text: str) -> str:
    """The text with the present values; a missing pattern is an error."""
    for file, pattern, value in PLACES:
        if file == path:
            match = re.search(pattern, text, re.M)
            if match is None:
                sys.exit(f"{path}: no line is like {pattern}")
            text = text[: match.start(1)] + value + text[match.end(1) :]
    # Archives of a release: the version in the address, in the name and in the top folder.
    address = f"{REPOSITORY}/releases/download/v{VERSION}/"
    text = re.sub(rf"https://[^\s\"']+?/releases/download/v{V}/", address, text)
    return re.sub(rf"\barcmin-{V}(?=-[a-z0-9_]+-(?:unknown|apple|pc)-|\.tar\.gz)", f"arcmin-{VERSION}", text)


def with_sums(text: str, sums: dict[str, str]) -> str:
    """Every hash is in the line below the address of its file."""
    lines = text.splitlines(keepends=True)
    for at in range(1, len(lines)):
        if ZEROS in lines[at].lower():
            name = re.search(r"[^/\"'\s]+\.(?:tar\.gz|zip)", lines[at - 1])
            if name is None or name.group() not in sums:
                sys.exit(f"no hash is known for: {lines[at - 1].strip()}")
            lines[at] = lines[at].replace(ZEROS, sums[name.group()])
    return "".join(lines)


def unready(tag: str) -> list[str]:
    """Reasons why this checkout cannot be the release with that tag."""
    reasons = []
    if tag != f"v{VERSION}":
        reasons.append(f"the tag is {tag}, the version in Cargo.toml {VERSION}")
    if ".invalid" in REPOSITORY:
        reasons.append("`repository` in Cargo.toml still stands in for the address of the project")
    head = rf"^## {re.escape(VERSION)} \(\d{{4}}-\d\d-\d\d\)$"
    if re.search(head, read("CHANGELOG.md"), re.M) is None:
        reasons.append(f"CHANGELOG.md has no section `## {VERSION} (date)`")
    return reasons


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--release", metavar="TAG")
    parser.add_argument("--sums", type=pathlib.Path)
    parser.add_argument("--out", type=pathlib.Path)
    given = parser.parse_args()

    if given.sums:
        pairs = (line.split() for line in given.sums.read_text().splitlines())
        sums = {name.removeprefix("*"): digest for digest, name in pairs}
        for name in RECIPES:
            path = given.out / name
            path.parent.mkdir(parents=True, exist_ok=True)
            text = with_sums(read(f"packaging/{name}"), sums)
            path.write_text(text, newline="\n", encoding="utf-8")
        return
    stale = []
    for path in sorted({file for file, _, _ in PLACES}):
        text = read(path)
        new = stamped(path, text)
        if new != text:
            stale.append(path)
            if not (given.check or given.release):
                (ROOT / path).write_text(new, newline="\n", encoding="utf-8")
    if given.check or given.release:
        reasons = [f"{path} is stale: `python3 packaging/stamp.py` writes it" for path in stale]
        reasons += unready(given.release) if given.release else []
        if reasons:
            sys.exit("\n".join(reasons))
    elif stale:
        print("written:", *stale)


main()

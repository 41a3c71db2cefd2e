"""Packs the archive of the command for one platform, and writes its hash into a separate file.

    python3 packaging/archive.py --target x86_64-unknown-linux-gnu --binaries target/release \\
        --licences THIRD-PARTY.html --out dist

Runs the command for its completions and manual pages, so that the platform must be that of the host. The same
binaries give the same bytes: times are SOURCE_DATE_EPOCH (or 1980), names are sorted, owners are omitted.
"""

import argparse
import gzip
import hashlib
import io
import os
import pathlib
import subprocess
import tarfile
import tempfile
import time
import zipfile

import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent
# The earliest time that a zip file can store.
FIRST = 315532800


def contents(target: str, binaries: pathlib.Path, licences: pathlib.Path) -> dict[str, tuple[bytes, int]]:
    """Names in the archive with contents and modes."""
    windows, mac = "windows" in target, "apple" in target
    command = "arcmin.exe" if windows else "arcmin"
    # The library for `arcmin export fmu`, which is searched in the directory of the command.
    library = "arcmin_fmu.dll" if windows else "libarcmin_fmu.dylib" if mac else "libarcmin_fmu.so"
    files = {name: ((binaries / name).read_bytes(), 0o755) for name in (command, library)}
    for name in ("README.md", "CHANGELOG.md", "CITATION.cff", "LICENSE-MIT", "LICENSE-APACHE"):
        files[name] = ((ROOT / name).read_bytes(), 0o644)
    files["THIRD-PARTY.html"] = (licences.read_bytes(), 0o644)

    def printed(*arguments: str) -> tuple[bytes, int]:
        done = subprocess.run([binaries / command, *arguments], check=True, stdout=subprocess.PIPE)
        return done.stdout, 0o644

    # With the file names expected by the shells.
    names = {"bash": "arcmin", "zsh": "_arcmin", "fish": "arcmin.fish", "powershell": "arcmin.ps1"}
    for shell, name in names.items():
        files[f"completions/{shell}/{name}"] = printed("completions", shell)
    with tempfile.TemporaryDirectory() as pages:
        printed("man", "--out", pages)
        files |= {f"man/{page.name}": (page.read_bytes(), 0o644) for page in pathlib.Path(pages).iterdir()}
    return files


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--target", required=True)
    parser.add_argument("--binaries", type=pathlib.Path, required=True)
    parser.add_argument("--licences", type=pathlib.Path, required=True)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    given = parser.parse_args()

    version = tomllib.loads((ROOT / "Cargo.toml").read_text(encoding="utf-8"))["workspace"]["package"][
        "version"
    ]
    name = f"arcmin-{version}-{given.target}"
    files = sorted(contents(given.target, given.binaries, given.licences).items())
    moment = max(int(os.environ.get("SOURCE_DATE_EPOCH", FIRST)), FIRST)
    packed = io.BytesIO()
    if "windows" in given.target:
        ending = ".zip"
        with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
            for path, (data, mode) in files:
                entry = zipfile.ZipInfo(f"{name}/{path}", time.gmtime(moment)[:6])
                entry.external_attr = mode << 16
                entry.compress_type = zipfile.ZIP_DEFLATED
                archive.writestr(entry, data)
    else:
        ending = ".tar.gz"
        with gzip.GzipFile(fileobj=packed, mode="wb", mtime=moment) as stream:
            with tarfile.open(fileobj=stream, mode="w", format=tarfile.PAX_FORMAT) as tar:
                for path, (data, mode) in files:
                    member = tarfile.TarInfo(f"{name}/{path}")
                    member.size, member.mode, member.mtime = len(data), mode, moment
                    tar.addfile(member, io.BytesIO(data))
    given.out.mkdir(parents=True, exist_ok=True)
    data = packed.getvalue()
    (given.out / (name + ending)).write_bytes(data)
    line = f"{hashlib.sha256(data).hexdigest()}  {name}{ending}\n"
    (given.out / (name + ending + ".sha256")).write_text(line, newline="\n")
    print(f"{name}{ending}: {len(data) / 1e6:.1f} MB")


main()

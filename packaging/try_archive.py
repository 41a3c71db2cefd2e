"""Unpacks the archive written by archive.py into a folder, checks its contents and runs the command.

python3 packaging/try_archive.py dist
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

paths = pathlib.Path(sys.argv[1]).resolve().iterdir()
(archive,) = (path for path in paths if path.suffix in (".gz", ".zip"))
with tempfile.TemporaryDirectory() as work:
    shutil.unpack_archive(archive, work)
    (folder,) = pathlib.Path(work).iterdir()
    if archive.name not in (f"{folder.name}.zip", f"{folder.name}.tar.gz"):
        sys.exit(f"{archive.name} unpacks to {folder.name}")
    command = folder / ("arcmin.exe" if archive.suffix == ".zip" else "arcmin")
    # zipfile does not restore modes.
    command.chmod(0o755)

    def run(*arguments: str) -> str:
        # With a separate cache, so that no earlier results of this machine are used.
        environment = os.environ | {"XDG_CACHE_HOME": f"{work}/cache"}
        done = subprocess.run(
            [command, *arguments], cwd=work, env=environment, check=True, stdout=subprocess.PIPE
        )
        return done.stdout.decode()

    version = run("--version").split()
    if version[0] != "arcmin" or not folder.name.startswith(f"arcmin-{version[1]}-"):
        sys.exit(f"{folder.name} holds {' '.join(version)}")
    for name in (
        "completions/bash/arcmin",
        "completions/zsh/_arcmin",
        "man/arcmin-life.1",
        "THIRD-PARTY.html",
    ):
        if not (folder / name).read_bytes():
            sys.exit(f"{name} is empty")
    run("new", "design.toml")
    run("contact", "design.toml", "--quiet")
    # Packs the library in the directory of the command.
    run("export", "fmu", "design.toml", "--model", "multibody", "--joints", "ideal")
    units = list(pathlib.Path(work).glob("out/**/*.fmu"))
    if len(units) != 1:
        sys.exit(f"no unit was exported: {units}")
    print(f"{archive.name}: unpacked, {len(list(folder.rglob('*')))} entries, runs")

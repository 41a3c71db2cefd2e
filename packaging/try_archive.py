"""Unpacks the archive of the command that archive.py has put into a folder, looks at what is there and runs it.

    python3 packaging/try_archive.py dist
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

(archive,) = [path.resolve() for path in pathlib.Path(sys.argv[1]).iterdir() if path.suffix in (".gz", ".zip")]
with tempfile.TemporaryDirectory() as work:
    shutil.unpack_archive(archive, work, **({} if archive.suffix == ".zip" else {"filter": "data"}))
    (folder,) = pathlib.Path(work).iterdir()
    if archive.name not in (f"{folder.name}.zip", f"{folder.name}.tar.gz"):
        sys.exit(f"{archive.name} unpacks to {folder.name}")
    command = folder / ("arcmin.exe" if archive.suffix == ".zip" else "arcmin")
    # zipfile keeps no modes.
    command.chmod(0o755)

    def run(*arguments: str) -> str:
        # With a cache of its own: nothing may come from what this machine has computed before.
        environment = os.environ | {"XDG_CACHE_HOME": f"{work}/cache"}
        done = subprocess.run(
            [command, *arguments], cwd=work, env=environment, check=True, stdout=subprocess.PIPE, text=True, encoding="utf-8"
        )
        return done.stdout

    version = run("--version").split()
    if version[0] != "arcmin" or not folder.name.startswith(f"arcmin-{version[1]}-"):
        sys.exit(f"{folder.name} holds {' '.join(version)}")
    for name in ("completions/bash/arcmin", "completions/zsh/_arcmin", "completions/fish/arcmin.fish", "man/arcmin-life.1"):
        if "arcmin" not in (folder / name).read_text(encoding="utf-8"):
            sys.exit(f"{name} does not speak of arcmin")
    run("new", "design.toml")
    run("contact", "design.toml", "--quiet")
    # Packs the library that lies beside the command; ideal joints and two positions, since only packing is tried here.
    run("export", "fmu", "design.toml", "--model", "multibody", "--joints", "ideal")
    units = list(pathlib.Path(work).glob("out/**/*.fmu"))
    if len(units) != 1:
        sys.exit(f"no unit was exported: {units}")
    print(f"{archive.name}: unpacked, {len(list(folder.rglob('*')))} entries, runs")

#!/bin/sh
# Computes shards of a study with kills under local processes, HyperQueue and Dask, and compares the tables
# byte for byte: `validation/study/check.sh [VENV]`. Sets up its own Python environment (default:
# target/study-venv) and runs check.py; needs python3 with venv, access to PyPI, and a few minutes.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
venv=${1:-"$root/target/study-venv"}
if [ ! -x "$venv/bin/python" ]; then
    python3 -m venv "$venv"
fi
"$venv/bin/python" -m pip install --quiet --disable-pip-version-check -r "$root/validation/study/requirements.txt"
cd "$root"
cargo build --release --quiet
"$venv/bin/python" "$root/validation/study/check.py" "$root/target/release/arcmin" "$root/target/study-check"

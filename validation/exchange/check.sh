#!/bin/sh
# Checks the exports with the programs that read them: `validation/exchange/check.sh [VENV]`.
# Builds the files with the example `exchange_files`, sets up its own Python environment (default:
# target/exchange-venv), and runs check.py. Needs python3 with venv and access to PyPI.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
venv=${1:-"$root/target/exchange-venv"}
files="$root/target/exchange-files"
if [ ! -x "$venv/bin/python" ]; then
    python3 -m venv "$venv"
fi
"$venv/bin/python" -c "import OCP, ezdxf, numpy" 2>/dev/null || "$venv/bin/python" -m pip install --quiet \
    --disable-pip-version-check -r "$root/validation/exchange/requirements.txt"
rm -rf "$files" "$files-again"
cd "$root"
cargo run --release --quiet -p arcmin --example exchange_files -- "$files"
cargo run --release --quiet -p arcmin --example exchange_files -- "$files-again"
diff -r "$files" "$files-again"
"$venv/bin/python" "$root/validation/exchange/check.py" "$files"

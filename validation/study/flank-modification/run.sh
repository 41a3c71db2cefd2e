#!/bin/sh
# The worked case: unmodified machines, the handbook's modification, free form. `run.sh [DIR]`; about an hour on two
# quiet cores.
# The limit of the pressure in both searches is the 95 % quantile of the unmodified machines.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../../.." && pwd)
out=${1:-"$root/target/flank-modification"}
arcmin="$root/target/release/arcmin"
mkdir -p "$out"
cp "$here"/*.toml "$out"
cp "$root/designs/tao2024.toml" "$out/handbook-design.toml"
"$arcmin" study "$out/unmodified.toml" --out "$out/unmodified"
pressure=$(python3 -c 'import json, sys
for quantile in json.load(open(sys.argv[1]))["results"]["max_pressure_mpa"]["quantiles"]:
    if quantile["share"] == 0.95:
        print(quantile["value"])' "$out/unmodified/summary.json")
# The free form starts from the offsets with the longest life among those of the handbook's search that fulfil its limits
# on the machines of the search.
points="[[-150, 0], [-75, 0], [-25, 0], [25, 0], [75, 0], [150, 0]]"
sed -e "s/^equidistant_offset_um = 0$/equidistant_offset_um = 9.070131683972974/" \
    -e "s/^radial_offset_um = 0$/radial_offset_um = 13.907407702406957/" \
    -e "s/^rotation_arcmin = 0$/&\nfree_form_deg_um = $points/" \
    "$out/handbook-design.toml" >"$out/free-form-design.toml"
for search in handbook free-form; do
    sed -i "s/^high = 2600$/high = $pressure/" "$out/$search.toml"
    "$arcmin" study "$out/$search.toml" --out "$out/$search"
done

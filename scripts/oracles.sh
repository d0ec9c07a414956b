#!/usr/bin/env bash
# Installs the foreign programs that the tests ask for a second opinion: about 3 GB, some minutes, once a machine.
#
#   blender/   Blender 5.0 as the Python module bpy (it needs CPython 3.11 and an older numpy: its own environment)
#   python/    OpenCASCADE 8, MeshLab and scipy
#   node/      the Khronos glTF validator
#
# They go where every clone finds them again: $LOFTSMAN_ORACLES, by default ~/.cache/loftsman-oracles (XDG_CACHE_HOME
# is minded). Needs Python 3.11 and Node with npm; where apt-get is there, missing system libraries are installed
# through it (as root, or with sudo that does not ask). What is there already is left alone, so running it again is cheap.
#
#   scripts/oracles.sh            installs what is missing
#   scripts/oracles.sh --where    prints the folder and does nothing
set -euo pipefail

folder=${LOFTSMAN_ORACLES:-${XDG_CACHE_HOME:-$HOME/.cache}/loftsman-oracles}
if [ "${1:-}" = --where ]; then echo "$folder"; exit 0; fi
[ $# -eq 0 ] || { echo "usage: scripts/oracles.sh [--where]" >&2; exit 2; }

blender=(bpy==5.0.1)
python=(numpy==2.4.6 scipy==1.17.1 pymeshlab==2025.7.post1 cadquery-ocp==8.0.1.1.0)
node=gltf-validator@2.0.0-dev.3.10

mkdir -p "$folder"
exec 9>"$folder/.lock"
if command -v flock >/dev/null; then flock 9; fi # two runs at once do the work once

say() { echo "oracles: $*"; }
quiet() { # Runs a command; shows what it printed only if it fails, after a second try (networks hiccup).
  local log; log=$(mktemp)
  if "$@" >"$log" 2>&1 </dev/null || { sleep 5; "$@" >"$log" 2>&1 </dev/null; }; then rm -f "$log"; return 0; fi
  tail -n 40 "$log" >&2; rm -f "$log"; return 1
}
apt() { # Installs Debian packages where that is possible; says what is missing where it is not.
  local root=()
  [ "$(id -u)" = 0 ] || root=(sudo -n)
  command -v apt-get >/dev/null || { say "please install: $*"; return 0; }
  dpkg -s "$@" >/dev/null 2>&1 && return 0
  say "apt-get install $*"
  quiet "${root[@]}" apt-get update -qq || true
  quiet "${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" ||
    say "that failed; please install: $*" # not the end: they may be there under another name
}
has() { # has ENVIRONMENT "IMPORTS" REQUIREMENT...: whether these versions are there and load
  local where=$1 imports=$2; shift 2
  [ -x "$where/bin/python" ] && "$where/bin/python" - "$imports" "$@" >/dev/null 2>&1 <<'PY'
import importlib, importlib.metadata, sys
for requirement in sys.argv[2:]:
    name, version = requirement.split("==")
    assert importlib.metadata.version(name) == version
for name in sys.argv[1].split():
    importlib.import_module(name)
PY
}
environment() { # environment NAME PYTHON "IMPORTS" REQUIREMENT...: a virtual environment with exactly these packages
  local where=$folder/$1 interpreter=$2 imports=$3; shift 3
  if has "$where" "$imports" "$@"; then say "$where is complete"; return; fi
  say "installing $* into $where"
  rm -rf "$where"
  "$interpreter" -m venv "$where" 2>/dev/null || {
    rm -rf "$where"; apt "$(basename "$interpreter")-venv"; "$interpreter" -m venv "$where"; }
  quiet "$where/bin/python" -m pip install --quiet --no-cache-dir --disable-pip-version-check "$@"
  has "$where" "$imports" "$@" || { "$where/bin/python" -c "import ${imports// /, }" >&2 || true; say "$where does not work"; exit 1; }
}

python311=$(command -v python3.11 || command -v python3 || true)
[ -n "$python311" ] && "$python311" -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' ||
  { say "Blender needs Python 3.11 (python3.11, or a python3 that is one); found ${python311:-none}"; exit 1; }
command -v npm >/dev/null || { say "the glTF validator needs Node with npm"; exit 1; }

# What Blender and MeshLab load even without a window.
apt libsm6 libxi6 libxkbcommon0 libxfixes3 libxrender1 libgl1 libegl1 libgomp1
environment blender "$python311" "bpy" "${blender[@]}"
environment python "$python311" "OCP pymeshlab scipy" "${python[@]}"
validator() { node -p 'require(process.argv[1]).version' "$folder/node/node_modules/gltf-validator/package.json" 2>/dev/null; }
if [ "gltf-validator@$(validator)" = "$node" ]; then say "$folder/node is complete"; else
  say "installing $node into $folder/node"
  rm -rf "$folder/node"
  quiet npm install --silent --no-audit --no-fund --prefix "$folder/node" "$node"
  [ "gltf-validator@$(validator)" = "$node" ] || { say "$folder/node does not work"; exit 1; }
fi
say "all are in $folder"

#!/usr/bin/env bash
# Makes this folder ready to run: the Debian packages that dpkg lacks, then .venv from
# requirements.lock. Safe to call again; a call that finds all in place takes 0.1 s.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

packages=(
  liggghts make python3-venv graphviz
  # gmsh and vtk are wheels that bring all but these; vtk draws off screen through EGL
  libglu1-mesa libgl1 libegl1 libxrender1 libxcursor1 libxft2 libxinerama1 libgomp1
)

say() { printf 'bootstrap: %s\n' "$*" >&2; }
die() { say "$*"; exit 2; }

install_packages() {
  local installed missing=() package as_root=()
  installed=$(dpkg-query -W -f='${Package} ${db:Status-Status}\n' "${packages[@]}" 2>/dev/null || true)
  for package in "${packages[@]}"; do
    grep -qxF "$package installed" <<<"$installed" || missing+=("$package")
  done
  ((${#missing[@]})) || return 0

  command -v apt-get >/dev/null || die "no apt-get here; install what corresponds to: ${missing[*]}; then call again with SYSTEM_READY=1"
  if ((EUID != 0)); then
    command -v sudo >/dev/null || die "neither root nor sudo; ask for: apt-get install ${missing[*]}"
    as_root=(sudo)
  fi
  as_root+=(env DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=300)
  say "installing ${missing[*]}"
  { "${as_root[@]}" update && "${as_root[@]}" install -y --no-install-recommends "${missing[@]}"; } >&2 ||
    die "apt-get failed (see above); wanted: ${missing[*]}"
}

# The first Python of the right age, outside of any virtual environment: .venv may be the
# active one, and cannot be made again by itself.
find_python() {
  local name found=none
  for name in python3 python3.13 python3.12 python3.11; do
    command -v "$name" >/dev/null || continue
    "$name" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 14))' &&
      exec "$name" -c 'import sys; print(sys._base_executable)'
    [ "$found" != none ] || found=$("$name" -V)
  done
  die "Python 3.11, 3.12 or 3.13 is needed; found: $found"
}

# What .venv was made from. Its scripts hold this folder's path, so a moved folder is a new one.
wanted_environment() { .venv/bin/python -V && pwd && sha256sum <requirements.lock; }
wanted_package() { sha256sum <pyproject.toml; }
is_stamped() { [ -f ".venv/$1.stamp" ] && [ "$("wanted_$1" 2>/dev/null)" = "$(<".venv/$1.stamp")" ]; }

make_environment() {
  local python
  python=$(find_python)
  say "making .venv with $("$python" -V) from requirements.lock: half a gigabyte to fetch the first time"
  rm -rf .venv
  "$python" -m venv .venv
  # Packages without a wheel are built with the locked setuptools, never with one fetched for it.
  local locked=(--no-deps --no-build-isolation --no-compile --require-hashes -r)
  sed -nE '/^(setuptools|uv)==/,/# via/p' requirements.lock >.venv/tools.lock
  .venv/bin/python -m pip install --quiet "${locked[@]}" .venv/tools.lock >&2
  # uv takes a fifth of the time of Debian's pip; pip knows the mirrors and certificates of pip.conf.
  .venv/bin/uv pip install --python .venv/bin/python "${locked[@]}" requirements.lock >&2 || {
    say "uv could not (see above); pip tries"
    .venv/bin/python -m pip install --use-pep517 "${locked[@]}" requirements.lock >&2
  }
  wanted_environment >.venv/environment.stamp
}

install_package() {
  .venv/bin/python -m pip install --quiet --no-deps --no-build-isolation --editable . >&2
  wanted_package >.venv/package.stamp
}

[ -n "${SYSTEM_READY:-}" ] || install_packages
exec 9<requirements.lock
flock 9 # of two calls at once, the second waits and finds all done
is_stamped environment || make_environment
# without the sources of the package: a layer of a container that their changes leave as it is
[ -n "${ENVIRONMENT_ONLY:-}" ] || is_stamped package || install_package

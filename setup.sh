#!/usr/bin/env bash
# Debian packages that are missing; quick and silent when nothing is.
set -euo pipefail

packages=(yade liggghts libliggghts-dev libopenmpi-dev openmpi-bin g++ make python3-venv)
if ! command -v dpkg-query > /dev/null; then
    echo "setup: not a Debian system; install by hand: ${packages[*]}" >&2
    exit 1
fi

missing=()
for package in "${packages[@]}"; do
    [[ $(dpkg-query -W -f '${db:Status-Status}' "$package" 2> /dev/null || true) == installed ]] || missing+=("$package")
done
[[ ${#missing[@]} -eq 0 ]] && exit 0

root=()
if [[ $EUID -ne 0 ]]; then
    if ! command -v sudo > /dev/null; then
        echo "setup: as root, run: apt-get update && apt-get install ${missing[*]}" >&2
        exit 1
    fi
    root=(sudo)
fi

# Package lists that are missing or too old to know a package are fetched, others are left alone.
simulated=$(apt-get install --simulate --no-install-recommends "${missing[@]}" 2>&1) || "${root[@]}" apt-get update
echo "setup: installing ${missing[*]}"
"${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "${missing[@]}"

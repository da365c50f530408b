#!/usr/bin/env bash
# What the study needs of this machine; `make setup` calls it.
#   bash setup.sh packages      install the Debian packages that are missing; quick and silent when none is
#   bash setup.sh works         a line where .venv cannot be used, silence where it can
#   bash setup.sh environment   make or mend .venv; results are never touched
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

packages=(yade liggghts libliggghts-dev libopenmpi-dev openmpi-bin g++ make python3-venv libjemalloc2)
python=.venv/bin/python

# numpy is loaded, not looked for: it needs the very Python that it was installed for.
works() {
    if ! $python -c 'import importlib.metadata, importlib.util, numpy
importlib.metadata.version("ballast-analysis")
assert all(map(importlib.util.find_spec, ("jinja2", "jsonschema", "matplotlib", "pandas", "pytest", "scipy")))' > /dev/null 2>&1; then
        echo "setup: .venv cannot be used"
    fi
}

environment() {
    if ! $python -c 'import pip' > /dev/null 2>&1 || [[ -f .venv/installed && -n $(works) ]]; then
        "${PYTHON:-python3}" -c 'import sys; sys.version_info >= (3, 11) or sys.exit("setup: Python 3.11 or newer is needed; give PYTHON=path")'
        [[ ! -e .venv ]] || echo "setup: .venv cannot be used any more (was its Python upgraded?) and is made anew"
        "${PYTHON:-python3}" -m venv --clear .venv
    fi
    echo "setup: installing the Python packages of pyproject.toml into .venv"
    if ! $python -m pip install --quiet --disable-pip-version-check --editable '.[test]'; then
        echo "setup: pip could not install the packages of pyproject.toml; its lines above say why, then run make setup again" >&2
        exit 1
    fi
    [[ -z $(works) ]] || { echo "setup: .venv cannot be used though it was made anew; try another Python with PYTHON=path" >&2; exit 1; }
    # pip's own script takes a dollar in the path of the checkout for a variable
    cat > .venv/bin/ballast << 'END'
#!/bin/sh
exec "$(dirname -- "$(readlink -f -- "$0")")/python" -m analysis "$@"
END
    touch .venv/installed
}

install_packages() {
    if [[ $PWD == *:* ]]; then
        echo "setup: $PWD has a colon, at which PYTHONPATH would be cut; move the checkout to a folder without one" >&2
        exit 1
    fi
    if ! command -v dpkg-query > /dev/null; then
        if command -v yade > /dev/null && command -v mpicxx > /dev/null; then return; fi
        echo "setup: not a Debian system; install by hand: ${packages[*]}" >&2
        exit 1
    fi
    local missing=() root=() package
    for package in "${packages[@]}"; do
        [[ $(dpkg-query -W -f '${db:Status-Status}' "$package" 2> /dev/null || true) == installed ]] || missing+=("$package")
    done
    [[ ${#missing[@]} -eq 0 ]] && return
    if [[ $EUID -ne 0 ]]; then
        if ! command -v sudo > /dev/null; then
            echo "setup: as root, run: apt-get update && apt-get install ${missing[*]}" >&2
            exit 1
        fi
        root=(sudo)
    fi
    # Package lists that are missing or too old to know a package are fetched, others are left alone.
    apt-get install --simulate --no-install-recommends "${missing[@]}" > /dev/null 2>&1 || "${root[@]}" apt-get update || true
    echo "setup: installing ${missing[*]}"
    if ! "${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "${missing[@]}"; then
        echo "setup: apt-get could not install ${missing[*]}; the packages yade and liggghts are in Debian 12 and 13" >&2
        exit 1
    fi
}

case ${1:-} in
    packages) install_packages ;;
    works) works ;;
    environment) environment ;;
    *) echo "usage: bash setup.sh packages | works | environment" >&2; exit 2 ;;
esac

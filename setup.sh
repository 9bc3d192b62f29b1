#!/bin/sh
# Creates the virtual environment for the Makefile; installs the system packages it needs if it has the rights,
# otherwise prints the exact command.
set -eu
venv=${1:-.venv}

for candidate in ${PYTHON:-} python3.13 python3.12 python3.11 python3 python; do
    if command -v "$candidate" >/dev/null 2>&1 &&
        "$candidate" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' 2>/dev/null; then
        python=$candidate
        break
    fi
done
if [ -z "${python:-}" ]; then
    echo "nmaptool needs Python 3.11, 3.12 or 3.13; install one, or choose one: make PYTHON=/path/to/python3.12" >&2
    exit 1
fi

if ! "$python" -c 'import ensurepip, venv' 2>/dev/null; then
    version=$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
    install="apt-get install -y python$version-venv"
    if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1; then
        { apt-get update -q && $install; } || { echo "This failed: $install" >&2; exit 1; }
    else
        echo "Python's venv module is missing. Run this, then run make again:  sudo $install" >&2
        exit 1
    fi
fi

[ -x "$venv/bin/python" ] || [ -x "$venv/Scripts/python" ] || "$python" -m venv "$venv"
if [ -d "$venv/Scripts" ]; then bin=$venv/Scripts; else bin=$venv/bin; fi # Windows has Scripts

# the inner loops are compiled; without a C compiler, or Python's headers, slower NumPy code takes their place
missing=$("$python" -c 'import os, shutil, sys, sysconfig
compiler = os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc"
header = os.path.join(sysconfig.get_path("include"), "Python.h")
packages = [] if shutil.which(compiler.split()[0]) else ["gcc", "libc6-dev"]
print(*packages, *([] if os.path.exists(header) else ["python%d.%d-dev" % sys.version_info[:2]]))')
compiler="apt-get install -y $missing"
if [ -n "$missing" ] && [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1; then
    { apt-get update -q && $compiler; } || echo "This failed, so the inner loops are not compiled: $compiler" >&2
fi
echo "installing nmaptool into $venv"
# PIP_FLAGS may say more, such as --only-binary :all: --no-binary pyopengl
# shellcheck disable=SC2086
"$bin/python" -m pip install --quiet --disable-pip-version-check ${PIP_FLAGS:-} --editable '.[dev]'
# the type checker knows packages by their folders: cli is the package nmaptool_cli
mkdir -p "$venv/typing"
ln -sfn "$PWD/cli" "$venv/typing/nmaptool_cli"

if ! "$bin/python" -c 'import nmaptool._compiled' 2>/dev/null; then
    echo "The inner loops were not compiled; slower NumPy code takes their place. Install a C compiler with" >&2
    echo "Python's headers${missing:+ (on Debian and Ubuntu: sudo $compiler)}, then run: make setup" >&2
fi

# tests of the studio drive a browser; without one, they are skipped
browser=
for candidate in chromium chromium-browser google-chrome google-chrome-stable; do
    command -v $candidate >/dev/null 2>&1 && browser=$candidate
done
if [ -z "$browser" ] && [ "$(uname -s)" = Linux ]; then
    install="apt-get install -y --no-install-recommends chromium fonts-liberation"
    if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1; then
        { apt-get update -q && $install; } || echo "This failed, so tests in a browser are skipped: $install" >&2
    else
        echo "Tests in a browser are skipped without Chromium. On Debian and Ubuntu:  sudo $install" >&2
    fi
fi

# rendering meshes needs the OpenGL libraries (and pyglet one of X), but no graphics card or display
draws='from nmaptool.render import gl
with gl.drawing():
    pass'
if ! "$bin/python" -c "$draws" 2>/dev/null; then
    install="apt-get install -y libegl1 libgl1 libgl1-mesa-dri libxrender1"
    if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1; then
        { apt-get update -q && $install; } || { echo "This failed: $install" >&2; exit 1; }
    fi
    if ! "$bin/python" -c "$draws" 2>/dev/null; then
        "$bin/python" -c "$draws" 2>&1 | tail -1 >&2
        if [ "$(uname -s)" != Linux ]; then
            echo "OpenGL cannot render meshes here. Everything else works, and so does nmap bake --renderer numpy." >&2
            exit 0
        fi
        echo "OpenGL does not work yet. On Debian and Ubuntu run this, then run make again:  sudo $install" >&2
        exit 1
    fi
fi

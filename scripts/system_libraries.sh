#!/bin/sh
# Installs the system libraries that CadQuery and VTK load, if we may; else asks. With the word "tests" also those of
# gmsh, a C compiler and the browser for the pages.
# libgl1 and libexpat1: OCCT; libegl1, libgl1-mesa-dri: VTK without a display; the rest: gmsh, the second STEP reader.
set -eu

has_library() { ldconfig -p 2>/dev/null | grep -q "$1" || ls /usr/lib/*/"$1"* /usr/lib/"$1"* >/dev/null 2>&1; }

missing=""
need() { has_library "$1" || missing="$missing $2"; }
[ "$(uname -s)" = Linux ] || exit 0
need libGL.so.1 libgl1
need libexpat.so.1 libexpat1
need libEGL.so.1 libegl1
need libGLX_mesa.so.0 libgl1-mesa-dri
[ "${1:-}" != tests ] || {
need libGLU.so.1 libglu1-mesa
need libXcursor.so.1 libxcursor1
need libXft.so.2 libxft2
need libXinerama.so.1 libxinerama1
need libXrender.so.1 libxrender1
need libXfixes.so.3 libxfixes3
need libfontconfig.so.1 libfontconfig1
need libgomp.so.1 libgomp1
command -v cc >/dev/null 2>&1 || missing="$missing gcc libc6-dev" # the C controller is compiled in the tests
command -v chromium >/dev/null 2>&1 || command -v chromium-browser >/dev/null 2>&1 || command -v google-chrome >/dev/null 2>&1 ||
    missing="$missing chromium"
}

[ -n "$missing" ] || exit 0
if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1; then
    export DEBIAN_FRONTEND=noninteractive
    apt-get update -qq && apt-get install -y -qq --no-install-recommends $missing >/dev/null && exit 0
fi
echo "Please install these system packages first:$missing (on Debian: sudo apt-get install$missing)" >&2
[ "$missing" = " chromium" ] # the browser alone is not needed to build; the tests of the pages need it

#!/bin/sh
# Installs the system libraries that CadQuery and VTK load, if we may; else asks. With the word "tests" also what the
# tests need: libraries of gmsh, C compilers with their sanitizers, the cross compiler and the emulator of bare Cortex-M
# cores, the browser for the pages.
# libgl1 and libexpat1: OCCT; libegl1, libgl1-mesa-dri: VTK without a display; the rest: gmsh, the second STEP reader.
set -eu

has_library() { ldconfig -p 2>/dev/null | grep -q "$1" || ls /usr/lib/*/"$1"* /usr/lib/"$1"* >/dev/null 2>&1; }
has_command() { command -v "$1" >/dev/null 2>&1; }

missing=""
needed() { missing="$missing $*"; }
library() { has_library "$1" || needed "$2"; }
tool() { has_command "$1" || needed "$2"; }

[ "$(uname -s)" = Linux ] || exit 0
library libGL.so.1 libgl1
library libexpat.so.1 libexpat1
library libEGL.so.1 libegl1
library libGLX_mesa.so.0 libgl1-mesa-dri
if [ "${1:-}" = tests ]; then
    library libGLU.so.1 libglu1-mesa
    library libXcursor.so.1 libxcursor1
    library libXft.so.2 libxft2
    library libXinerama.so.1 libxinerama1
    library libXrender.so.1 libxrender1
    library libXfixes.so.3 libxfixes3
    library libfontconfig.so.1 libfontconfig1
    library libgomp.so.1 libgomp1
    has_command cc || needed gcc libc6-dev
    tool clang clang
    clang -print-file-name="libclang_rt.asan-$(uname -m).a" 2>/dev/null | grep -q / || needed libclang-rt-dev
    tool arm-none-eabi-gcc gcc-arm-none-eabi
    [ -e /usr/lib/arm-none-eabi/newlib/libm.a ] || needed libnewlib-arm-none-eabi
    tool qemu-system-arm qemu-system-arm
    has_command chromium || has_command chromium-browser || has_command google-chrome || needed chromium
fi

[ -n "$missing" ] || exit 0
if [ "$(id -u)" = 0 ] && has_command apt-get; then
    export DEBIAN_FRONTEND=noninteractive
    apt-get update -qq && apt-get install -y -qq --no-install-recommends $missing >/dev/null && exit 0
fi
echo "Please install these system packages first:$missing (on Debian: sudo apt-get install$missing)" >&2
exit 1

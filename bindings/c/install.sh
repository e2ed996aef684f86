#!/bin/sh
# Builds the library and installs header, libraries, CMake package and pkg-config file: ./install.sh PREFIX [PROFILE]
# CULLET_FEATURES chooses its parts: scenes,files,queries as it is unset; with tiles and bake added, what asset pipelines need; boxes for
# the least. CULLET_NO_BACKTRACE=1 compiles Rust's standard library along, without what lists the calls that led to a panic; it
# needs `rustup component add rust-src`.
# CULLET_TARGET builds for another system, by Rust's name for it, such as x86_64-pc-windows-gnu; STRIP names its strip.
set -eu
if [ $# -lt 1 ] || [ $# -gt 2 ]; then
    echo "usage: [CULLET_FEATURES=boxes] [CULLET_NO_BACKTRACE=1] $0 PREFIX [PROFILE]    for example: $0 /usr/local" >&2
    exit 2
fi
here=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
mkdir -p "$1"
prefix=$(CDPATH='' cd -- "$1" && pwd)
profile=${2:-library}
features=${CULLET_FEATURES:-scenes,files,queries}
cargo=${CARGO:-cargo}
folder=$profile
if [ "$profile" = dev ]; then folder=debug; fi
set -- build --quiet --package cullet-c --lib --profile "$profile" --no-default-features --features "$features"
triple=${CULLET_TARGET:-}
if [ "${CULLET_NO_BACKTRACE:-}" = 1 ]; then
    triple=${triple:-$("${RUSTC:-rustc}" -vV | sed -n 's/^host: //p')}
    export RUSTC_BOOTSTRAP=1 # These options are not stable.
    set -- "$@" -Zbuild-std=std,panic_unwind -Zbuild-std-features=panic-unwind
fi
if [ -n "$triple" ]; then
    folder=$triple/$folder
    set -- "$@" --target "$triple"
fi
( cd "$here" && "$cargo" "$@" )
target=$(cd "$here" && "$cargo" metadata --format-version 1 --no-deps | sed 's/.*"target_directory":"\([^"]*\)".*/\1/')
version=$(sed -n 's/^version = "\(.*\)"/\1/p' "$here/Cargo.toml" "$here/../../Cargo.toml" 2>/dev/null | head -n 1)
mkdir -p "$prefix/include" "$prefix/lib/pkgconfig" "$prefix/lib/cmake/cullet" "$prefix/share/licenses/cullet"
for header in cullet.h cullet.hpp cullet_queries.hpp cullet_pvs.hpp cullet_moc.h; do
    cp "$here/include/$header" "$prefix/include/"
done
built=$target/$folder
cp "$built/libcullet.a" "$prefix/lib/"
# strip stops at members without sections, which the standard library for MinGW has.
strip=${STRIP:-strip}
empty=$("${strip%strip}ar" t "$prefix/lib/libcullet.a" 2>/dev/null | grep '\.dwo$' || true)
# shellcheck disable=SC2086
[ -z "$empty" ] || "${strip%strip}ar" d "$prefix/lib/libcullet.a" $empty >/dev/null 2>&1
# Half of it says where lines of the standard library are.
"$strip" -S "$prefix/lib/libcullet.a" >/dev/null 2>&1 || echo "libcullet.a keeps its debugging information: strip failed, or is not there" >&2
private="-Wl,--gc-sections -lgcc_s -lutil -lrt -lpthread -lm -ldl"
if [ -f "$built/cullet.dll" ]; then
    mkdir -p "$prefix/bin"
    cp "$built/cullet.dll" "$prefix/bin/"
    cp "$built/libcullet.dll.a" "$prefix/lib/" # The import library: what programs are linked with.
    # The same for MSVC: the names, and where there is a tool for it the library that `lib /def:cullet.def` would make of them.
    def=$prefix/lib/cullet.def
    printf 'LIBRARY cullet.dll\nEXPORTS\n' > "$def"
    "${strip%strip}nm" "$prefix/lib/libcullet.dll.a" | sed -n 's/.* T \(cullet_[a-z0-9_]*\)$/    \1/p' | sort -u >> "$def"
    case $triple in i686*) machine=i386 ;; aarch64*) machine=arm64 ;; *) machine=i386:x86-64 ;; esac
    if command -v llvm-dlltool >/dev/null; then
        llvm-dlltool -m "$machine" -d "$def" -D cullet.dll -l "$prefix/lib/cullet.lib"
    fi
    private="-Wl,--gc-sections -lkernel32 -lntdll -luserenv -lws2_32 -ldbghelp"
elif [ -f "$built/libcullet.dylib" ]; then
    cp "$built/libcullet.dylib" "$prefix/lib/"
else
    # A program that runs keeps the file that it opened.
    rm -f "$prefix/lib/libcullet.so.0"
    cp "$built/libcullet.so" "$prefix/lib/libcullet.so.0"
    ln -sf libcullet.so.0 "$prefix/lib/libcullet.so"
fi
cp "$here/cmake/culletConfig.cmake" "$prefix/lib/cmake/cullet/"
sed "s|@VERSION@|$version|g" "$here/cmake/culletConfigVersion.cmake.in" > "$prefix/lib/cmake/cullet/culletConfigVersion.cmake"
sed "s|@VERSION@|$version|g; s|@PRIVATE@|$private|" "$here/cullet.pc.in" > "$prefix/lib/pkgconfig/cullet.pc"
cp "$here/LICENSE-MIT" "$here/LICENSE-APACHE" "$prefix/share/licenses/cullet/"
echo "cullet $version is in $prefix"

#!/usr/bin/env bash
# Builds the library for C, and installs it as libraries for C are.
#
#   src/capi/install.sh [--levels "LEVEL..."] PREFIX [CARGO_OPTION...]
#
# PREFIX gets include/, lib/libphalanx.so.0 and libphalanx_files.so.0, the first as a static library too, and what CMake and pkg-config
# look for. Without --levels there is one build, with the flags of `cargo build`. With it there is one for each level of x86-64: that
# for the first lies in lib/, the others in lib/glibc-hwcaps/, of which the loader (glibc 2.33) takes the best that the CPU can run.
set -euo pipefail

levels=()
if [ "${1-}" = --levels ] && [ $# -gt 1 ]; then
    read -ra levels <<<"$2"
    shift 2
fi
[[ $# -gt 0 && $1 != -* && " $* " != *" --target"* ]] || { sed -n 's/^#  *\(src\/capi\/install.*\)/usage: \1/p' "$0" >&2; exit 2; }
prefix=$(realpath -m "$1")
shift
cd "$(dirname "$0")/../.."
target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
sources=src/capi

version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -n 1)

# build OPTION...: both libraries, from $folder to $shared; into lib/ itself with all that is there once.
build() {
    local library features
    for library in phalanx phalanx_files; do
        features=()
        [ "$library" = phalanx ] || features=(--features render)
        cargo build --release --locked -p phalanx-capi "${features[@]}" "$@"
        install -D "$folder/libphalanx_c.so" "$shared/lib$library.so.0"
        strip --strip-unneeded "$shared/lib$library.so.0"
        [ "$shared" = "$prefix/lib" ] || continue
        ln -sf "lib$library.so.0" "$shared/lib$library.so"
        # The readers of files would make a static library of seventy megabytes.
        if [ "$library" = phalanx ]; then
            install -m 644 "$folder/libphalanx_c.a" "$shared/libphalanx.a"
            strip --strip-debug "$shared/libphalanx.a"
        fi
        install -d "$shared/pkgconfig"
        install -m 644 "$sources/package/phalanx.pc" "$shared/pkgconfig/$library.pc"
        sed -i "s/@library@/$library/; s/@version@/$version/" "$shared/pkgconfig/$library.pc"
    done
}

# Those of another time, which the loader would prefer.
rm -f "$prefix"/lib/glibc-hwcaps/*/libphalanx{,_files}.so.0
if [ ${#levels[@]} = 0 ]; then
    shared=$prefix/lib folder=$target/release
    build "$@"
fi
for level in "${levels[@]}"; do
    shared=$prefix/lib/glibc-hwcaps/$level folder=$target/release-$level/x86_64-unknown-linux-gnu/release
    [ "$level" != "${levels[0]}" ] || shared=$prefix/lib
    CARGO_TARGET_DIR=$target/release-$level RUSTFLAGS="-C target-cpu=$level" build --target x86_64-unknown-linux-gnu "$@"
done

install -D -m 644 -t "$prefix/include" "$sources"/include/*.h
install -D -m 644 -t "$prefix/lib/cmake/phalanx" "$sources"/package/*.cmake
sed -i "s/@version@/$version/" "$prefix/lib/cmake/phalanx/phalanx-config-version.cmake"

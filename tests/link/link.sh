#!/usr/bin/env bash
# Links programs with an installed library as models do, in C, C++ and Fortran, shared and static, with pkg-config, make and
# CMake, and runs them:
#
#   link.sh SOURCES PREFIX SONAME
#
# SOURCES is the source tree, PREFIX where the library is, SONAME the name by which programs find it at run time. Writes to
# the current directory, which is to be empty. The command lines are those of the book.
set -euo pipefail
sources=$1 prefix=$2 soname=$3
# The library search path that cargo sets would have other builds of the library.
unset LD_LIBRARY_PATH MAKEFLAGS DESTDIR
export PKG_CONFIG_PATH=$prefix/lib/pkgconfig CMAKE_PREFIX_PATH=$prefix
found='LD_LIBRARY_PATH=$(pkg-config --variable=libdir icoray)'
strict='-std=c99 -Wall -Wextra -Werror -pedantic'
title='' directory='' programs=()
trap 'echo "$title: line $LINENO of $0 failed" >&2' ERR

fail() {
    echo "$title: $*" >&2
    exit 1
}

# way TITLE BUILD SOURCE...: runs the commands BUILD in a directory with copies of the sources.
way() {
    title=$1 directory=${1//[, +]/_}
    local build=$2
    shift 2
    mkdir "$directory"
    for source in "${@/#/$sources/}"; do
        [ -d "$source" ] || cp "$source" "$directory"
    done
    (cd "$directory" && sh -e -c "$build") || fail 'cannot be built'
}

# draws shared|static COMMAND...: runs the programs of the way, which must draw.
draws() {
    local linkage=$1
    shift
    for command in "$@"; do
        programs+=("$title" "$directory" "$linkage" "$command")
        draw "$directory" "$command" || fail "$command failed"
    done
}

# draw DIRECTORY COMMAND: fails unless the command leaves pictures, all of them PNG files that end with their last chunk.
draw() (
    cd "$1"
    rm -f ./*.png pictures/*.png
    sh -e -c "$2" || exit
    shopt -s nullglob
    pictures=(*.png pictures/*.png)
    [ ${#pictures[@]} -gt 0 ] || { echo "$2 left no picture" >&2; exit 1; }
    for picture in "${pictures[@]}"; do
        [ "$(head -c 8 "$picture" | od -An -tx1)$(tail -c 8 "$picture" | od -An -tx1)" = \
            ' 89 50 4e 47 0d 0a 1a 0a 49 45 4e 44 ae 42 60 82' ] || { echo "$picture is not a complete PNG" >&2; exit 1; }
    done
)

way 'C, shared, found by LD_LIBRARY_PATH' 'cc minimal.c -o minimal $(pkg-config --cflags --libs icoray) -lm' examples/c/minimal.c
draws shared "$found ./minimal"

way 'C, shared, found by rpath, as strict C99' "cc $strict minimal.c -o minimal "'$(pkg-config --cflags --libs icoray) -lm \
    -Wl,-rpath,$(pkg-config --variable=libdir icoray)' examples/c/minimal.c
draws shared ./minimal

way 'C, static' 'cc minimal.c -o minimal $(pkg-config --cflags --libs icoray-static)' examples/c/minimal.c
draws static ./minimal

way 'C, wholly static' 'cc -static minimal.c -o minimal $(pkg-config --static --cflags --libs icoray)' examples/c/minimal.c
draws static ./minimal

way 'C, static, beside all of another Rust static library' '
    ${RUSTC:-rustc} --edition 2024 --crate-type staticlib other.rs
    cc -Dmain=draw -c minimal.c $(pkg-config --cflags icoray-static)
    cc two_rusts.c minimal.o -o two_rusts -Wl,--whole-archive libother.a -Wl,--no-whole-archive \
        $(pkg-config --libs icoray-static)' examples/c/minimal.c tests/link/two_rusts.c tests/link/other.rs
draws static ./two_rusts

options='--level 3 --layers 8 --days 1 --scene tracer.toml --out pictures'
way 'C, the tracer model, shared and static' "
    rm minimal.c
    cc -O2 $strict *.c -o shared "'$(pkg-config --cflags --libs icoray)'" -lm
    cc -O2 $strict *.c -o static "'$(pkg-config --cflags --libs icoray-static)' \
    $(cd "$sources" && echo examples/c/*) examples/scenes/tracer.toml
draws shared "$found ./shared $options"
draws static "./static $options"

way 'C++' "c++ ${strict/c99/c++11} minimal.cpp -o minimal "'$(pkg-config --cflags --libs icoray) \
    -Wl,-rpath,$(pkg-config --variable=libdir icoray)' tests/link/minimal.cpp
draws shared ./minimal

way 'Fortran, make' make tests/link/Makefile examples/fortran/minimal.f90
draws shared "$found ./minimal"

way 'Fortran, the shallow-water model' "make -j2 && $found build/shallow_water --self-test --level 3" \
    $(cd "$sources" && echo examples/fortran/shallow_water/*) examples/scenes/shallow_water.toml
draws shared "$found build/shallow_water --level 3 --layers 4 --days 0.5 --scene shallow_water.toml --out pictures"

way 'C and Fortran, CMake' 'cmake -B build && cmake --build build' \
    tests/link/CMakeLists.txt examples/c/minimal.c examples/fortran/minimal.f90
draws shared build/c_shared build/fortran_shared
draws static build/c_static build/fortran_static

# A project finds the library if and only if it requests a compatible version.
title='CMake, versions'
mkdir version
for request in '=found' 0.1=found 0.1.99= 0.2= 1.0= 0.0.9=; do
    version=${request%=*} expected=${request#*=} outcome=
    printed=$(cmake -S "$sources/tests/link/version" -B "version/$version" -DWANTED="$version" 2>&1) && outcome=found
    [ "$outcome" = "$expected" ] || fail "icoray '$version', expected '$expected', got '$outcome': $printed"
done

# Without the shared library the programs that were linked with it do not run, and the others do: otherwise the former use
# another library, or the latter are not static.
rm "$prefix/lib/$soname"
for ((i = 0; i < ${#programs[@]}; i += 4)); do
    title=${programs[i]} directory=${programs[i + 1]} linkage=${programs[i + 2]} command=${programs[i + 3]}
    if printed=$(draw "$directory" "$command" 2>&1); then
        [ "$linkage" = static ] || fail "$command runs without $soname"
    else
        [ "$linkage" = shared ] || fail "$command does not run without $soname: $printed"
        [[ $printed == *"$soname"* ]] || fail "$command does not miss $soname, which is gone: $printed"
    fi
done

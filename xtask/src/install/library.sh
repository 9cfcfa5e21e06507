#!/usr/bin/env bash
# Checks libraries that are to be installed, and reduces the static one, with the binutils. Runs in the workspace's root.
#
#   library.sh names LIBRARY [NAME]...
#   library.sh shared LIBRARY SONAME mpi|plain [NAME]...
#   library.sh reduce ARCHIVE DIRECTORY
#
# `names` fails unless the global names that a library defines are these, or else the functions of include/icoray.h. `shared`
# also checks the dynamic section and the stack of a shared library that is to be installed under the name SONAME, with MPI or
# without, and prints the libraries that it needs. `reduce` writes libicoray.a to the directory, so that it can be linked with
# any other: rustc writes a hundred objects whose symbols clash with those of any other Rust static library (those of the
# standard library, of the personality routine, and of dependencies that export unmangled names) and their debug information.
# The code that the header's functions need is linked into one object, in which only these functions stay visible: a third of
# the size, without clashes.
set -euo pipefail
# Without translations.
export LC_ALL=C
task=$1 library=$2 has_faults=
shift 2

fault() {
    echo "$library: $*" >&2
    has_faults=1
}

# The functions that the header declares: outside of comments, whose lines start with a star, only the name of a prototype is
# followed by a bracket.
declared() {
    sed -nE '/^ *[*\/]/!s/^[^(]*[ *](icoray_[a-z0-9_]+)\(.*/\1/p' include/icoray.h
}

names() {
    local expected found options=(-D)
    expected=$(if [ $# -gt 0 ]; then printf '%s\n' "$@"; else declared; fi | sort -u)
    # A comparison of nothing with nothing would always hold.
    [ -n "$expected" ] || fault 'no name is expected'
    [[ $library != *.a ]] || options=()
    found=$(nm -g --defined-only "${options[@]}" "$library" | sed -nE 's/^[0-9a-f]+ . //p' | sort -u)
    diff -U0 --label declared --label defined <(echo "$expected") <(echo "$found") >&2 ||
        fault 'its names are not those declared'
}

shared() {
    local soname=$1 mpi=$2 dynamic needed allowed='^(lib(c|m|gcc_s|pthread|dl)\.so\.|ld-linux)' of_mpi='^lib(mpi|mpich)\.so\.'
    shift 2
    names "$@"
    dynamic=$(readelf -dlW "$library")
    # The values of the entries of a kind in the dynamic section.
    entries() { sed -nE "s/.*\($1\).*\[(.*)\].*/\1/p" <<<"$dynamic"; }
    [ "$(entries SONAME)" = "$soname" ] || fault "its SONAME is [$(entries SONAME)], expected [$soname]"
    # Those of any C program, and the unwinder.
    needed=$(entries NEEDED)
    if [ "$mpi" = mpi ]; then
        allowed="$allowed|$of_mpi"
        grep -qE "$of_mpi" <<<"$needed" || fault 'it needs no MPI'
    fi
    for other in $(grep -vE "$allowed" <<<"$needed"); do fault "it needs $other"; done
    for path in $(entries RPATH; entries RUNPATH); do fault "it searches $path"; done
    ! grep -q TEXTREL <<<"$dynamic" || fault 'it has text relocations'
    # The stack is executable unless the library has a header that says otherwise.
    grep -q 'GNU_STACK .* RW ' <<<"$dynamic" || fault 'it makes the stack executable'
    echo "${needed//$'\n'/, }"
}

reduce() {
    local directory=$1 functions
    mapfile -t functions < <(declared)
    mkdir -p "$directory"
    # GNU's linker by its own name: other linkers cannot drop unused sections of a relocatable object.
    ld.bfd -r --gc-sections --force-group-allocation -o "$directory/joined.o" "${functions[@]/#/--undefined=}" "$library"
    # The bitcode of the standard library is unusable once joined, and plugins of the binutils fail on it.
    objcopy --strip-debug --remove-section=.llvmbc --remove-section=.llvmcmd "${functions[@]/#/--keep-global-symbol=}" \
        "$directory/joined.o" "$directory/icoray.o"
    library=$directory/libicoray.a
    # `ar` would add to an archive that exists; `D` leaves out dates and users, so that builds are reproducible.
    rm -f "$library"
    ar rcsD "$library" "$directory/icoray.o"
    names
}

"$task" "$@"
[ -z "$has_faults" ]

# The start of the script of each page, in the page's folder. ROOT is the workspace, DATA the folder of the data files, FILE
# the one that FILE.nc stands for, PROGRAMS the folder of the programs that the tests have built.
set -euo pipefail
trap 'echo "the command that failed is in the block at $block" >&2' ERR
export CARGO_HOME=${CARGO_HOME:-$HOME/.cargo} RUSTUP_HOME=${RUSTUP_HOME:-$HOME/.rustup}
# Hidden, since commands of the pages list and watch the folder.
export HOME=$PWD/.home
mkdir "$HOME"
# Programs must find libraries by themselves; cargo adds its own directories to this variable.
unset LD_LIBRARY_PATH
# Pages put target/release first, where a test has left a program with fewer features.
PATH=$PROGRAMS:$PATH
cp -R "$ROOT/examples" .
ln -s "${PROGRAMS%/*}" target
for file in "$DATA"/*; do
    [ ! -e "$file" ] || ln -s "$(realpath "$file")" .
done
[ ! -e "$FILE" ] || ln -s "$FILE" FILE.nc
# `cargo xtask test` does not run itself; its options are still checked. The programs that a page builds are there, and the demo
# is short and built in their profile: the release profile would compile everything again. The library for MPI is built
# without GPUs, which takes half the time; tests have it with both.
cargo() {
    case "$*" in
    "xtask test"*) command cargo "$@" --help >/dev/null ;;
    "xtask demo"*) command cargo "$@" --profile dev --days 2 ;;
    "xtask install"*"--mpi"*) command cargo "$@" --no-gpu ;;
    "build --release -p icoray-cli") "$PROGRAMS/icoray" --version >/dev/null ;;
    "run --release -p icoray-study -- "*) shift 5; "$PROGRAMS/icoray-study" "$@" ;;
    *) command cargo "$@" ;;
    esac
}

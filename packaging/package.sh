#!/usr/bin/env bash
# Writes the source archive of the commit HEAD, whatever the working tree is, and the recipes of Spack and conda with its
# checksum: package.sh DIRECTORY. Two archives of one commit are equal byte by byte. `.gitattributes` leaves this directory
# out of them: a recipe in the archive could not hold the archive's checksum.
set -euo pipefail
mkdir -p "$1"
directory=$(cd "$1" && pwd)
cd "$(dirname "${BASH_SOURCE[0]}")/.."
# member KEY: the value of a key of the workspace's packages.
member() {
    sed -n "s/^$1 = \"\(.*\)\"\$/\1/p" Cargo.toml | head -n 1
}
version=$(member version)
name=icoray-$version
archive=$directory/$name.tar.gz
if [ -n "$(git status --porcelain --untracked-files=no)" ]; then
    echo 'the working tree has changes; the archive holds HEAD without them'
fi
# Neither the user's settings nor the time go into the archive.
git -c tar.umask=0022 -c tar.tar.gz.command='gzip -n' archive --format=tar.gz --prefix="$name/" --output="$archive" HEAD

# It is a workspace of this version that cargo can read.
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
tar -xzf "$archive" -C "$scratch"
metadata=$("${CARGO:-cargo}" metadata --format-version=1 --no-deps --offline --manifest-path "$scratch/$name/Cargo.toml")
if [[ $metadata != *"\"name\":\"icoray\",\"version\":\"$version\""* ]]; then
    echo "the crate icoray of HEAD is not of version $version: commit Cargo.toml" >&2
    exit 1
fi

checksum=$(sha256sum "$archive" | cut -d ' ' -f 1)
echo "$checksum  $archive"
for recipe in spack/package.py conda/recipe.yaml; do
    mkdir -p "$directory/${recipe%/*}"
    sed "s/@VERSION@/$version/g; s/@SHA256@/$checksum/g; s/@RUST_VERSION@/$(member rust-version)/g" "packaging/$recipe.in" \
        >"$directory/$recipe"
    echo "$directory/$recipe"
done

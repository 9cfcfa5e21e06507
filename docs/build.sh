#!/usr/bin/env bash
# Builds the book into docs/book with mdBook, and fails if a link of a page leads to no file.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
mdbook build .
# mdBook also replaces the ending of Markdown files outside the book; its own pages never lead two folders up.
find book -name '*.html' -exec sed -Ei 's,href="((\.\./){2}[^":#]*)\.html,href="\1.md,g' {} +
# The page for printing has the links of all pages.
links=$(grep -rEHo --include='*.html' --exclude=print.html 'href="[^":#]+["#]' book)
faults=0
while IFS=: read -r page link; do
    file=${link#href=\"}
    file=${file%[\"#]}
    [ -e "$(dirname "$page")/$file" ] || { echo "$page: $file: there is no such file" >&2; faults=1; }
done <<<"$links"
exit "$faults"

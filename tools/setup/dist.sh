#!/usr/bin/env bash
# Writes build/dist/nutate-VERSION.tar.gz, the sources of the last commit, and its checksum beside it.
set -u
. "$(dirname "$0")/../environment.sh"

[ -e .git ] || die "make dist needs a clone with git; this folder is an archive already"
version=$(sed -n 's/^version = "\(.*\)"/\1/p' fpm.toml)
folder=$top/build/dist
archive=nutate-$version.tar.gz
[ -z "$(git status --porcelain --untracked-files=no)" ] || say "Changes that are not committed stay out of the archive"
rm -rf "$folder" && mkdir -p "$folder" || exit 1
git archive --format=tar --prefix="nutate-$version/" HEAD | gzip -n -9 >"$folder/$archive" || exit 1
(cd "$folder" && sha256sum "$archive" >"$archive.sha256") || exit 1
say "Archive: ${folder#"$top/"}/$archive ($(wc -c <"$folder/$archive") bytes), checksum: $archive.sha256"

#!/usr/bin/env bash
# Builds the Debian packages from the source archive, in build/deb/, and checks them with lintian.
# In an unpacked archive: dpkg-buildpackage -us -uc -b.
set -u
. "$(dirname "$0")/../environment.sh"

bash tools/setup/dist.sh || exit 1
version=$(sed -n 's/^version = "\(.*\)"/\1/p' fpm.toml)
folder=$top/build/deb
rm -rf "$folder" && mkdir -p "$folder" && cp "build/dist/nutate-$version.tar.gz" "$folder/nutate_$version.orig.tar.gz" &&
   tar -xf "build/dist/nutate-$version.tar.gz" -C "$folder" && cd "$folder/nutate-$version" || exit 1
export DEB_BUILD_OPTIONS="${DEB_BUILD_OPTIONS-noautodbgsym} parallel=$jobs"
# Its tools and flags are those of Debian.
PATH=$(printf '%s' "$PATH" | tr : '\n' | grep -v -e "^$venv/" | paste -sd :)
quietly deb-build env -u FFLAGS dpkg-buildpackage -us -uc || exit 1
cd "$folder" || exit 1
# Left out: what is said of a first upload to Debian, and of a folder debian/ that comes with the sources.
lintian --fail-on error,warning --suppress-tags initial-upload-closes-no-bugs,no-debian-changes ./*.changes || exit 1
say "Packages: $(ls ./*.deb | tr '\n' ' ')"

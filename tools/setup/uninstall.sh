#!/usr/bin/env bash
# Removes what `make install` put into a folder, and the folders of it that are empty then.
#    tools/setup/uninstall.sh PREFIX
set -u
. "$(dirname "$0")/../environment.sh"

[ $# -eq 1 ] && [ -n "$1" ] || die "say where nutate is installed: make uninstall PREFIX=FOLDER"
prefix=$(home_expanded "$1")
list=$prefix/share/nutate/installed.txt
[ -f "$list" ] || die "nothing was installed in $prefix (there is no $list)"
prefix=$(cd -- "$prefix" && pwd) || exit 1

# pip leaves these beside the Python package that it is given.
rm -rf "$prefix/share/nutate/python/build" "$prefix/share/nutate/python/"*.egg-info
find "$prefix/share/nutate" -name __pycache__ -prune -exec rm -rf {} +
folders=$(
   while IFS= read -r file; do
      rm -f "$prefix/$file"
      folder=$file
      while folder=$(dirname "$folder") && [ "$folder" != . ]; do say "$folder"; done
   done <"$prefix/share/nutate/installed.txt" | sort -ur
)
rm -f "$prefix/share/nutate/installed.txt"
while IFS= read -r folder; do
   rmdir "$prefix/$folder" 2>/dev/null
done <<<"$folders"
rmdir "$prefix" 2>/dev/null
for folder in share/nutate include/nutate lib/cmake/nutate; do
   [ ! -e "$prefix/$folder" ] || say "Left, since it holds what was not installed: $prefix/$folder"
done
say "Removed from $prefix"

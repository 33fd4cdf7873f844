#!/usr/bin/env bash
# Fetches test-drive, once: by git, or with the argument `fpm` by fpm, which afterwards works without a network. Where GitHub
# does not answer, they get the stand-in of tools/setup/testdrive/ under test-drive's address.
#    tools/setup/fetch-testdrive.sh [fpm]
set -u
. "$(dirname "$0")/../environment.sh"

by=${1:-git}
[ -f build/dependencies/test-drive/fpm.toml ] && { [ "$by" = git ] || [ -f build/cache.toml ]; } && exit 0

address=$(sed -n 's/^test-drive.*git *= *"\([^"]*\)".*/\1/p' fpm.toml)
tag=$(sed -n 's/^test-drive.*tag *= *"\([^"]*\)".*/\1/p' fpm.toml)
[ -n "$address" ] && [ -n "$tag" ] || die "fpm.toml does not name test-drive's address and tag"

export GIT_TERMINAL_PROMPT=0

fetch() {
   rm -rf build/dependencies/test-drive build/cache.toml
   case $by in
      fpm) fpm update ;;
      *) git -c advice.detachedHead=false clone --quiet --depth 1 --branch "$tag" "$address" build/dependencies/test-drive ;;
   esac
}

github_answers() {
   GIT_HTTP_LOW_SPEED_LIMIT=100 GIT_HTTP_LOW_SPEED_TIME=10 timeout 10 git ls-remote --exit-code "$address" \
      "refs/tags/$tag" >/dev/null 2>&1 </dev/null
}

# A git repository with that tag, made of tools/setup/testdrive/.
make_repository() {
   local identity=(-c user.name=nutate -c user.email=nutate@localhost -c commit.gpgsign=false -c tag.gpgsign=false)
   cp -r tools/setup/testdrive/. "$1" && git -C "$1" init -q && git -C "$1" add -A &&
      git -C "$1" "${identity[@]}" commit -q -m "Stand-in for test-drive" && git -C "$1" tag "$tag"
}

# Added to the settings that GIT_CONFIG_COUNT may hold already.
redirect() {
   local n=${GIT_CONFIG_COUNT:-0}
   export "GIT_CONFIG_KEY_$n=url.file://$1.insteadOf" "GIT_CONFIG_VALUE_$n=$address" GIT_CONFIG_COUNT=$((n + 1))
}

if github_answers && quietly test-drive fetch; then
   say "Fetched test-drive $tag from $address"
   exit 0
fi
repository=$(mktemp -d) || exit 1
trap 'rm -rf "$repository"' EXIT
quietly stand-in make_repository "$repository" || exit 1
redirect "$repository"
quietly test-drive fetch || exit 1
say "GitHub does not answer: the tests use the stand-in for test-drive in tools/setup/testdrive"

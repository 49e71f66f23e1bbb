#!/usr/bin/env bash
# Usage: package.sh FOLDER [ROOT]
# Installs the packages in FOLDER and uses what they bring: the command builds, asks and fits, and a program in C is made
# with pkg-config. ROOT is a Debian system of which nothing is known but that it is one, as debootstrap makes them: there
# apt installs the packages with what they need. Without it they are unpacked beside the system that runs this.
set -euo pipefail
folder=$(cd "$1" && pwd)
root=${2:-}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

use() {  # use COMMAND ARGUMENT ..: in the root, or in the unpacked tree
  if [ -n "$root" ]; then
    chroot "$root" "$@"
  else
    LD_LIBRARY_PATH=$libraries "$work/tree/usr/bin/$1" "${@:2}"
  fi
}

if [ -n "$root" ]; then
  mkdir -p "$root/packages" "$root/trial"
  cp "$folder"/*.deb "$root/packages"
  chroot "$root" apt-get update -qq
  chroot "$root" sh -c 'DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends /packages/*.deb gcc libc6-dev pkg-config' \
    >"$work/apt.log" 2>&1 || { tail -20 "$work/apt.log"; exit 1; }
  place=/trial
else
  for package in "$folder"/*.deb; do dpkg-deb -x "$package" "$work/tree"; done
  libraries=$(dirname "$(find "$work/tree/usr/lib" -name "libsamara_base.so.*.*.*")")
  # Everything that is linked is there, and nothing is looked for where it was built.
  for file in "$work/tree/usr/bin/samara" "$libraries"/*.so; do
    if LD_LIBRARY_PATH=$libraries ldd "$file" | grep "not found"; then echo "of $file" >&2; exit 1; fi
    if readelf -d "$file" | grep -E 'R(UN)?PATH'; then echo "of $file" >&2; exit 1; fi
  done
  place=$work
fi

examples=/usr/share/doc/samara/examples
[ -n "$root" ] || examples=$work/tree$examples
use samara --version
# A page for man of every command, and completion for three shells.
brought=${root:-$work/tree}/usr/share
for name in samara $(use samara help --json | grep -o '"name":"[a-z]*","summary"' | cut -d'"' -f4 | sed 's/^/samara-/'); do
  gzip -dc "$brought/man/man1/$name.1.gz" | grep '^\.SH SYNOPSIS' >/dev/null || { echo "no page for man of $name" >&2; exit 1; }
done
for file in bash-completion/completions/samara zsh/vendor-completions/_samara fish/vendor_completions.d/samara.fish; do
  grep -q gradient "$brought/$file" || { echo "$file completes nothing" >&2; exit 1; }
done
use samara build "$examples/coin/plan.toml" -o "$place/coin.h5" | head -1
use samara query "$place/coin.h5" --set C_D=1.15 --set "v(0)=10 cm/s" --at 0.3
use samara fit "$place/coin.h5" "$examples/coin/coin.toml" --config "$examples/coin/fit.toml" --span "0.4 s" | grep "^C_D *1\.169 "

if [ -n "$root" ]; then
  chroot "$root" sh -c "cd / && gcc $examples/c_interface/ask.c \$(pkg-config --cflags --libs samara) -o trial/ask && trial/ask trial/coin.h5 0.3 1.15 0.1"
else
  export PKG_CONFIG_PATH=$libraries/pkgconfig
  # shellcheck disable=SC2046
  cc "$examples/c_interface/ask.c" $(pkg-config --cflags --libs samara) -o "$work/ask" -Wl,-rpath-link,"$libraries"
  LD_LIBRARY_PATH=$libraries "$work/ask" "$work/coin.h5" 0.3 1.15 0.1
fi
# A flat file is read by one header, which needs none of the libraries.
use samara export "$place/coin.h5" --to flat -o "$place/coin.flat"
if [ -n "$root" ]; then
  chroot "$root" sh -c "cd / && gcc $examples/flat_codebook/fall.c -lm -o trial/fall && trial/fall trial/coin.flat 0.3 1.15 0.1"
else
  cc -I"$work/tree/usr/include" "$examples/flat_codebook/fall.c" -lm -o "$work/fall"
  "$work/fall" "$work/coin.flat" 0.3 1.15 0.1
fi
echo "the packages work${root:+ in $root}"

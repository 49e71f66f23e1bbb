#!/usr/bin/env bash
# Usage: consumer.sh BUILD_DIR
# Installs BUILD_DIR into a temporary prefix and uses it from a project of its own, compiled for several machines.
set -euo pipefail
build=$(cd "$1" && pwd)
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cmake --install "$build" --prefix "$work/prefix" >"$work/install.log"
cmake -G Ninja -S "$here/consumer" -B "$work/consumer" -DCMAKE_PREFIX_PATH="$work/prefix" >"$work/configure.log" 2>&1 ||
  { cat "$work/configure.log"; exit 1; }
cmake --build "$work/consumer"
"$work/consumer/consumer" "$work/book.h5"
"$work/consumer/ask" "$work/book.h5"
# The same program in C by pkg-config, where there is one and libraries are shared.
pc=$(find "$work/prefix" -name samara.pc)
if [ -n "$pc" ] && command -v pkg-config >/dev/null; then
  export PKG_CONFIG_PATH=${pc%/*}
  libraries=${pc%/pkgconfig/*}
  # shellcheck disable=SC2046
  cc "$here/consumer/ask.c" $(pkg-config --cflags --libs samara) -lm -o "$work/asked_by_pkg_config" \
    -Wl,-rpath,"$libraries" -Wl,-rpath-link,"$libraries"
  "$work/asked_by_pkg_config" "$work/book.h5"
  # Falling bodies have a library and a file of their own.
  # shellcheck disable=SC2046
  cc "$here/consumer/bodies.c" $(pkg-config --cflags --libs samara-motion) -o "$work/bodies_by_pkg_config" \
    -Wl,-rpath,"$libraries" -Wl,-rpath-link,"$libraries"
  "$work/bodies_by_pkg_config"
fi
for program in "$work"/consumer/objects_*; do
  if [[ $program == *avx2* ]] && ! grep -qw avx2 /proc/cpuinfo; then
    echo "skipped: this machine has no AVX2"
  else
    "$program" "$work"
  fi
done
"$work/prefix/bin/samara" --version
# The codebook of the program is validated by its law, which the command takes from a library; the same law as text
# becomes one, too.
"$work/prefix/bin/samara" --model-library "$work/consumer/libgrowth.so" validate "$work/book.h5" --points 200
cat >"$work/plan.toml" <<'EOF'
[equations]
states.x = { initial = 1 }
parameters.rate = { unit = "1/s" }
rates.x = "rate*x"
[box]
rate = [0.2, 0.8]
[time]
end = 2
EOF
"$work/prefix/bin/samara" build "$work/plan.toml" -o "$work/text.h5"
# exp(0.5 * 2), to a thousandth of what x goes through
"$work/prefix/bin/samara" query "$work/text.h5" --set rate=0.5 --at 2 | tail -1 |
  awk -F, '{ print; exit !($3 > 2.713 && $3 < 2.724) }'

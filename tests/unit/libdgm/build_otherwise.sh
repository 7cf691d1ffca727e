#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# build_otherwise.sh SOURCE WORK SAMPLE XXHASH C CXX [FLAG]...: builds the runtime and the C consumer with another
# compiler or for another word size, and runs the consumer on SAMPLE's file. Exit code 77 if that compiler or the C++
# library for those flags is not there.
set -eu
source=$1 work=$2 sample=$3 xxhash=$4 c=$5 cxx=$6
shift 6

rm -rf "$work" && mkdir -p "$work"
# A cross compiler brings its own C library: programs start through its loader.
loader=$("$cxx" -print-file-name=ld-linux.so.2)
run() {
  case $loader in
    */i686-linux-gnu/*) "$loader" --library-path "$work:$(dirname "$loader")" "$@" ;;
    *) LD_LIBRARY_PATH=$work "$@" ;;
  esac
}
# Debian: g++-i686-linux-gnu, or g++-multilib for -m32.
printf '#include <vector>\n#include <errno.h>\nint main() { return errno + int(std::vector<int>().size()); }\n' >"$work/try.cpp"
if ! "$cxx" "$@" "$work/try.cpp" -o "$work/try" 2>/dev/null || ! run "$work/try"; then
  echo "skipped: $cxx $* builds no programs here"
  exit 77
fi
set -- "$@" -O1 -fPIC -Wall -Wextra -Wshadow -Wconversion -Werror
for file in "$source"/libdgm/src/*/*.cpp; do
  object=$(basename "$(dirname "$file")")_$(basename "$file" .cpp).o  # two folders have files of one name
  "$cxx" "$@" -std=c++20 -fno-exceptions -fno-rtti -fvisibility=hidden -idirafter "$xxhash" -I "$source/libdgm/include" -I "$source/libdgm/src" \
    -c "$file" -o "$work/$object"
done
"$cxx" "$@" -shared -Wl,--no-undefined -Wl,--version-script="$source/libdgm/libdgm.map" "$work"/*.o -o "$work/libdgm.so"
"$c" "$@" -std=c99 -I "$source/libdgm/include" "$source/tests/e2e/consumer/consumer.c" -L "$work" -ldgm -lm -o "$work/consumer"
"$sample" "$work/sample.dgm"
run "$work/consumer" "$work/sample.dgm"

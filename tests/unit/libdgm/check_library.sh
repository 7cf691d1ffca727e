#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# check_library.sh LIBRARY NM BYTES COUNT: needs the C and C++ standard libraries and libdgm alone, throws nothing,
# shows only dgm symbols, at least COUNT C functions, and has at most BYTES of text.
set -u
library=$1 nm=$2 limit=$3 least=$4 bad=0

extra=$(LC_ALL=C ldd "$library" | awk '{print $1}' |
    grep -vE '(^|/)(linux-vdso|linux-gate|libdgm|libc|libm|libstdc\+\+|libgcc_s|ld-linux[^/]*)\.so(\.[0-9]+)?$')
[ -z "$extra" ] || { echo "depends on: $extra"; bad=1; }

thrown=$("$nm" -D "$library" | grep -E '__cxa_(throw|allocate_exception|begin_catch|rethrow)|_Unwind_|__gxx_personality')
[ -z "$thrown" ] || { echo "uses exceptions: $thrown"; bad=1; }

foreign=$("$nm" -DC --defined-only "$library" | cut -d' ' -f3- | grep -vE '^(dgm_|dgm::|DGM_[0-9.]+$)')
[ -z "$foreign" ] || { echo "shows foreign symbols: $foreign"; bad=1; }

shown=$("$nm" -D --defined-only "$library" | grep -c ' T dgm_')
[ "$shown" -ge "$least" ] || { echo "shows only $shown C functions"; bad=1; }

unversioned=$("$nm" -D --defined-only "$library" | grep ' T dgm_' | grep -v '@@DGM_')
[ -z "$unversioned" ] || { echo "has symbols without a version: $unversioned"; bad=1; }

text=$(size -A "$library" | awk '$1 == ".text" || $1 == ".rodata" {sum += $2} END {print sum}')
[ "$text" -le "$limit" ] || { echo "text is $text bytes, the limit is $limit"; bad=1; }
exit $bad
